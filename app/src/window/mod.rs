//! The studio's window: one frame of it from top to bottom, and what every command does.

mod commands;
mod desk;
mod document;
mod files;
mod handles;
mod layout;
mod macros;
mod navigation;
mod notices;
mod palette;
mod panels;
mod projection;
mod recovery;
mod run_command;
mod settings;
mod start;
mod state_report;
mod status_bar;
mod theme;
mod tools;
mod top_bar;
mod viewport;

use std::path::Path;

use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::history::Merge;
use lorelei_core::lod::LodChoice;
use lorelei_core::motion::HeadPose;
use lorelei_core::script::Step;
use lorelei_shaders::Gpu;

pub use start::{StartOptions, open};

use crate::stage::thread::{FrameRequest, StageGpu, StageThread};
use commands::Command;
use desk::{Desk, FrameTimes, Selection};
use document::Document;
use files::choose::{Choice, Chooser, Purpose};
use files::jobs::{self, Done, Jobs};
use lorelei_core::edit::Edit;
use notices::{Notices, Severity};
use palette::{Palette, PaletteAnswer};
use recovery::{Base, Left, Recovery};
use settings::{SETTINGS_KEY, Settings};
use start::Handover;
use state_report::{StateReport, UiClock};
use viewport::Viewport;

/// A question that must be answered before something is lost. Nothing else waits for the answer.
#[derive(Debug, Clone, PartialEq)]
enum Question {
    /// Save before what comes next?
    Unsaved(Next),
    /// Take what a crashed run left?
    Recover,
}

/// What goes on once unsaved changes were saved or given up.
#[derive(Debug, Clone, PartialEq)]
enum Next {
    Close,
    New,
    /// An embedded hairstyle as a new document.
    Hairstyle(&'static str),
    AskForFile,
    Open(std::path::PathBuf),
}

/// With `--report-state`: lose the GPU, to test that it is survived.
const LOSE_GPU: egui::KeyboardShortcut =
    egui::KeyboardShortcut::new(egui::Modifiers::COMMAND.plus(egui::Modifiers::SHIFT), egui::Key::F9);

/// The window's state.
pub struct Studio {
    desk: Desk,
    viewport: Viewport,
    stage: Option<StageThread>,
    render_state: eframe::egui_wgpu::RenderState,
    shown_texture: Option<wgpu::Texture>,
    jobs: Jobs,
    chooser: Option<Chooser>,
    palette: Option<Palette>,
    shows_shortcuts: bool,
    question: Option<Question>,
    /// After the running save.
    after_save: Option<Next>,
    may_close: bool,
    recovery: Option<Recovery>,
    /// A macro that waits for its file's name.
    recorded: Vec<Step>,
    state_report: Option<StateReport>,
    handover: Handover,
    n_pictures: u64,
    /// Where the next picture of the viewport goes.
    picture_path: Option<std::path::PathBuf>,
    last_shadowing: lorelei_core::look::Shadowing,
    title: String,
    last_time_frame: u64,
    is_lost: bool,
    /// What was open before, until the stage shows what is open now: a cancel goes back to it.
    before: Option<(Document, Camera)>,
    n_losses: u64,
    n_replaced: u32,
    kept_state: Option<(u64, u64)>,
    /// The file that a recovered document belongs to.
    recovered_path: Option<std::path::PathBuf>,
    clock: UiClock,
}

impl Studio {
    fn new(context: &eframe::CreationContext<'_>, options: StartOptions, handover: Handover) -> Result<Self, String> {
        theme::install(&context.egui_ctx);
        let mut notices = Notices::default();
        let mut settings: Settings =
            context.storage.and_then(|storage| eframe::get_value(storage, SETTINGS_KEY)).unwrap_or_default();
        if !layout::is_complete(&settings.layout) {
            settings.layout = layout::default_layout();
        }
        let render_state = context.wgpu_render_state.clone().ok_or("eframe was built without wgpu")?;
        let info = render_state.adapter.get_info();
        let gpu = Gpu::from_parts(render_state.device.clone(), render_state.queue.clone(), info);
        let ctx = context.egui_ctx.clone();
        let is_software = gpu.adapter_info.device_type == wgpu::DeviceType::Cpu;
        let gpu = StageGpu { window: gpu, has_own: is_software && !options.share_gpu, started: options.started };
        let stage = match StageThread::start(gpu, move || ctx.request_repaint()) {
            Ok(stage) => Some(stage),
            Err(why) => {
                notices.error("The hair cannot be drawn", why);
                None
            }
        };
        let data_folder = options
            .data_folder
            .clone()
            .or_else(|| directories::ProjectDirs::from("", "", "lorelei").map(|dirs| dirs.data_local_dir().to_owned()));
        let recovery = data_folder.and_then(|folder| match Recovery::new(folder.join("recovery"), options.autosave) {
            Ok(recovery) => Some(recovery),
            Err(why) => {
                notices.push(Severity::Warning, "No autosave", format!("The recovery folder cannot be used: {why}"));
                None
            }
        });
        let is_after_loss = options.recovered.is_some();
        let question = recovery.as_ref().filter(|recovery| !recovery.left.is_empty() && !is_after_loss);
        let question = question.map(|_| Question::Recover);
        if is_after_loss {
            notices.push(
                Severity::Error,
                "The GPU was lost",
                "A new window was opened and your groom is here. Save it. If this happens again, use fewer strands or a smaller shadow map.",
            );
        }
        let desk = Desk { notices, settings, ..Desk::default() };
        let mut studio = Self {
            desk,
            viewport: Viewport::default(),
            stage,
            render_state,
            shown_texture: None,
            jobs: Jobs::default(),
            chooser: None,
            palette: None,
            shows_shortcuts: false,
            question,
            after_save: None,
            may_close: false,
            recovery,
            recorded: Vec::new(),
            state_report: options.report_state.map(StateReport::new),
            handover,
            n_pictures: 0,
            picture_path: None,
            last_shadowing: lorelei_core::look::Shadowing::DeepOpacity,
            title: String::new(),
            last_time_frame: 0,
            is_lost: false,
            before: None,
            n_losses: 0,
            n_replaced: 0,
            kept_state: None,
            recovered_path: None,
            clock: UiClock::default(),
        };
        if let Some(recovery) = &studio.recovery {
            lock(&studio.handover).file = Some(recovery.file_for_loss());
        }
        if let Some(kept) = &options.recovered {
            studio.recovered_path = options.recovered_path;
            studio.recover(&context.egui_ctx, Left { files: vec![kept.clone()] });
            return Ok(studio);
        }
        match options.file {
            Some(path) => studio.start_opening(&context.egui_ctx, &path, options.head),
            None => studio.start_default(&context.egui_ctx),
        }
        Ok(studio)
    }

    /// Open the default groom on a thread: its strands are made when it opens.
    fn start_default(&mut self, ctx: &egui::Context) {
        self.jobs.start(ctx, "Opening the default groom", |_| Done::Opened {
            groom: Box::new(lorelei_assets::default_groom()),
            path: None,
            source: std::path::PathBuf::new(),
            style: lorelei_assets::hairstyle_names().first().copied(),
            notes: Vec::new(),
        });
    }

    fn start_hairstyle(&mut self, ctx: &egui::Context, key: &'static str) {
        self.jobs.start(ctx, format!("Opening {key}"), move |_| match lorelei_assets::hairstyle(key) {
            Some(groom) => Done::Opened {
                groom: Box::new(groom),
                path: None,
                source: std::path::PathBuf::new(),
                style: Some(key),
                notes: Vec::new(),
            },
            None => Done::Failed { title: format!("Could not open {key}"), why: "it is not embedded".to_owned() },
        });
    }

    fn start_opening(&mut self, ctx: &egui::Context, path: &Path, head: Option<std::path::PathBuf>) {
        let path = path.to_owned();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.jobs.start(ctx, format!("Opening {name}"), move |watch| jobs::open(&path, head.as_deref(), watch));
    }

    /// Show another document.
    fn show_document(&mut self, groom: Groom, path: Option<std::path::PathBuf>, is_unsaved: bool) {
        let document = Document::new(groom, path, is_unsaved);
        let before = std::mem::replace(&mut self.desk.document, document);
        // Two openings in a row: the first never was on screen.
        if !before.is_none() && self.before.is_none() {
            self.before = Some((before, self.desk.camera));
        }
        self.desk.measure();
        self.desk.clamp_selection();
        self.desk.selection =
            if self.desk.document.groom.layers.is_empty() { Selection::Head } else { Selection::Layer(0) };
        self.desk.playback.is_playing = false;
        self.desk.playback.head_pose = HeadPose::default();
        self.desk.playback.n_resets += 1;
        self.desk.wants_frame = true;
    }

    /// A person gave up preparing `state`: back to what is on screen.
    fn take_back(&mut self, state: (u64, u64)) {
        if self.desk.document.state() != state {
            return;
        }
        match self.before.take() {
            Some((before, camera)) => {
                self.desk.document = before;
                self.desk.camera = camera;
            }
            None if !self.desk.document.history.can_undo() => {
                self.desk.document = Document::default();
                self.viewport.texture = None;
                self.shown_texture = None;
                let what_next = "File > New, Open or Open recent go on from here.";
                self.desk.notices.push(Severity::Info, "Nothing was opened", what_next);
            }
            None => {
                self.desk.document.undo();
            }
        }
        self.desk.measure();
        self.desk.clamp_selection();
    }

    /// Take over what jobs have done.
    fn finish_jobs(&mut self, ctx: &egui::Context) {
        for done in self.jobs.finished() {
            match done {
                Done::Opened { groom, path, source, style, notes } => {
                    let is_default = source.as_os_str().is_empty();
                    if !is_default {
                        self.desk.settings.remember(&source);
                    }
                    self.note(&source, &notes);
                    // An import is not in a document yet; the default groom is no work of anybody's.
                    let is_unsaved = path.is_none() && !is_default;
                    self.show_document(*groom, path, is_unsaved);
                    if let Some(style) = style {
                        self.desk.document.base = Some(Base::Style(style.to_owned()));
                    }
                }
                Done::Hair { layers, source, notes } => {
                    // What was made here comes from no file.
                    if !source.as_os_str().is_empty() {
                        self.desk.settings.remember(&source);
                    }
                    self.note(&source, &notes);
                    self.add_layers(layers);
                }
                Done::Head { head, source, notes } => {
                    self.desk.settings.remember(&source);
                    self.note(&source, &notes);
                    self.desk.document.edit("Import head", Edit::SetHead(Some(head)), Merge::New);
                    self.desk.measure();
                }
                Done::Saved { state, path } => {
                    self.desk.settings.remember(&path);
                    self.desk.document.mark_saved(state, &path);
                    if let Some(recovery) = &mut self.recovery {
                        recovery.saved(&self.desk.document);
                    }
                    if let Some(next) = self.after_save.take() {
                        self.go_on(ctx, next);
                    }
                }
                Done::Levels { levels } => self.desk.levels.show(ctx, levels),
                Done::Level { level, ms } => {
                    let mut lod = self.desk.document.groom.lod.clone();
                    lod.choice = LodChoice::Level(level);
                    self.desk.document.edit("Level for a time", Edit::SetLod(Box::new(lod)), Merge::New);
                    let text = format!("Level {level:.2} takes {ms:.1} ms");
                    self.desk.notices.push(Severity::Info, "Level of detail", text);
                }
                Done::MapLoaded { kind, map } => tools::paint::take_map(&mut self.desk, kind, map),
                Done::PictureSaved { path } => {
                    self.desk.notices.push(Severity::Info, "Picture saved", path.display().to_string());
                }
                Done::Recovered { restored, replaces } => {
                    let path = self.recovered_path.take().or(restored.path);
                    self.show_document(restored.groom, path, true);
                    self.desk.document.history = restored.history;
                    self.desk.document.history.record();
                    self.note(Path::new("Recovered"), &restored.notes);
                    if let Some(recovery) = &mut self.recovery {
                        recovery.take_over(&self.desk.document, replaces);
                        recovery.left.clear();
                    }
                }
                Done::MacroSaved { path } => {
                    self.desk.notices.push(Severity::Info, "Macro saved", path.display().to_string());
                }
                Done::Played { name, edits } => self.played(&name, edits),
                Done::Exported { path, notes } => {
                    let name = path.display().to_string();
                    self.desk.notices.push(Severity::Info, "Exported", name);
                    self.note(&path, &notes);
                }
                Done::Failed { title, why } => {
                    self.after_save = None;
                    self.desk.notices.error(title, why);
                }
                Done::Cancelled => self.after_save = None,
            }
        }
    }

    fn note(&mut self, source: &Path, notes: &[String]) {
        if !notes.is_empty() {
            let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
            self.desk.notices.push(Severity::Info, name, notes.join("\n"));
        }
    }

    fn add_layers(&mut self, layers: Vec<lorelei_core::groom::Layer>) {
        let n = self.desk.document.groom.layers.len();
        let names: Vec<String> = layers.iter().map(|layer| layer.name.clone()).collect();
        let edits = layers
            .into_iter()
            .enumerate()
            .map(|(i, layer)| Edit::AddLayer { layer_idx: n + i, layer: Box::new(layer) })
            .collect();
        self.desk.document.edit(&format!("Add {}", names.join(", ")), Edit::Batch(edits), Merge::New);
        self.desk.selection = Selection::Layer(n);
        self.desk.measure();
    }

    /// Show what the stage has drawn since the last frame.
    fn pick_up(&mut self, ctx: &egui::Context) {
        let Some(stage) = &self.stage else { return };
        let mut report = stage.pick_up();
        for warning in std::mem::take(&mut report.warnings) {
            self.desk.notices.push(Severity::Warning, "About this groom", warning);
        }
        for why in std::mem::take(&mut report.errors) {
            self.desk.notices.error("The picture may be old or incomplete", why);
        }
        if let Some((_, picture)) = report.picture.take()
            && let Some(path) = self.picture_path.take()
        {
            self.jobs.start(ctx, "Saving the picture", move |_| jobs::save_picture(&picture, &path));
        }
        if report.n_replaced != self.n_replaced {
            self.n_replaced = report.n_replaced;
            self.keep_now();
            self.desk.notices.push(
                Severity::Warning,
                "The GPU was lost",
                "Another one was taken, and your groom is untouched. If this happens again, save it, and use fewer strands or a smaller shadow map.",
            );
        }
        if report.state == self.desk.document.state() {
            self.before = None;
        }
        if let Some(state) = report.cancelled.take() {
            self.take_back(state);
        }
        if report.texture != self.shown_texture
            && let Some(texture) = &report.texture
        {
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let mut renderer = self.render_state.renderer.write();
            let device = &self.render_state.device;
            if let Some(id) = self.viewport.texture {
                renderer.update_egui_texture_from_wgpu_texture(device, &view, wgpu::FilterMode::Linear, id);
            } else {
                let id = renderer.register_native_texture(device, &view, wgpu::FilterMode::Linear);
                self.viewport.texture = Some(id);
            }
            self.shown_texture = Some(texture.clone());
        }
        if report.frame_idx != self.last_time_frame && !report.pass_times.is_empty() {
            self.last_time_frame = report.frame_idx;
            self.desk.keep_times(FrameTimes { passes: report.pass_times.clone() });
        }
        self.is_lost |= report.is_lost;
        self.desk.report = report;
    }

    /// Tell the stage what should be seen now.
    fn post(&self) {
        let Some(stage) = &self.stage else { return };
        if self.viewport.size[0] <= 1 || self.is_lost || self.desk.document.is_none() {
            return;
        }
        stage.post(&FrameRequest {
            groom: self.desk.document.groom.clone(),
            state: self.desk.document.state(),
            camera: self.desk.camera,
            size: self.viewport.size,
            playback: self.desk.playback,
            overlay: self.desk.tools.overlay(&self.desk.document.groom, self.desk.selection),
            is_interacting: self.viewport.is_interacting,
            moving_budget_ms: self.desk.settings.moving_budget_ms,
            n_pictures: self.n_pictures,
            n_losses: self.n_losses,
        });
    }

    /// Whether the picture on screen is of the document, camera and size as they are now.
    fn is_shown(&self) -> bool {
        let report = &self.desk.report;
        report.state == self.desk.document.state()
            && report.camera == Some(self.desk.camera)
            && report.size == self.viewport.size
            && self.jobs.running.is_empty()
    }

    /// For the state report: where the head's handle is.
    fn head_handle(&self) -> Option<[f32; 2]> {
        let projection = projection::Projection::new(&self.desk.camera, self.viewport.rect?);
        let at = projection.point(self.desk.neck + self.desk.playback.head_pose.shift)?;
        Some([at.x, at.y])
    }

    fn open_question(&self) -> Option<&'static str> {
        match self.question {
            Some(Question::Unsaved(_)) => Some("unsaved"),
            Some(Question::Recover) => Some("recover"),
            None => None,
        }
    }

    /// The GPU is gone: end this window; [`start::open`] keeps the groom and opens another.
    fn hand_over(&mut self, ctx: &egui::Context) {
        lock(&self.handover).is_lost = true;
        self.may_close = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Leave the document where it is found if the window ends badly.
    fn keep_for_loss(&mut self) {
        let state = self.desk.document.state();
        if self.kept_state != Some(state) && !self.desk.document.is_none() {
            self.kept_state = Some(state);
            let document = &self.desk.document;
            lock(&self.handover).latest = Some((document.groom.clone(), document.path.clone()));
        }
    }

    /// Write the recovery file at once, where there is something to recover.
    fn keep_now(&mut self) {
        if let Some(recovery) = &mut self.recovery {
            recovery.keep_now(&self.desk.document);
        }
    }

    /// Keep what was done since the last frame, should the studio end badly; a macro records the same.
    fn keep_records(&mut self, is_dragging: bool) {
        if self.recovery.as_ref().is_some_and(|recovery| !recovery.wants_records(is_dragging)) {
            return;
        }
        let max_bytes = (self.desk.settings.history_mib as usize) << 20;
        self.desk.document.history.set_max_bytes(max_bytes);
        let records = self.desk.document.history.take_records();
        if let Some(recorder) = &mut self.desk.recorder {
            records.iter().cloned().for_each(|record| recorder.add(record));
        }
        if let Some(recovery) = &mut self.recovery {
            recovery.keep(&self.desk.document, &records);
            if let Some(why) = recovery.problem() {
                self.desk.notices.push(Severity::Warning, "No recovery after a crash", why);
            }
        }
    }

    fn questions(&mut self, ctx: &egui::Context) {
        let Some(question) = self.question.clone() else { return };
        let (title, text, buttons): (_, String, [&str; 3]) = match &question {
            Question::Unsaved(_) => (
                "Save the changes?",
                format!("{} has changes that are in no file.", self.desk.document.title()),
                ["Save", "Do not save", "Cancel"],
            ),
            Question::Recover => (
                "Recover unsaved work?",
                "The studio ended without saving the last time. What was changed up to the last moments is here."
                    .to_owned(),
                ["Recover", "Throw away", "Later"],
            ),
        };
        let mut pressed = None;
        egui::Window::new(title)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, -60.0])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                ui.set_width(360.0);
                ui.add(egui::Label::new(text).wrap());
                ui.add_space(10.0);
                ui.horizontal(|ui| {
                    for (i, label) in buttons.into_iter().enumerate() {
                        let fill = if i == 0 { theme::ACCENT_DIM } else { theme::CONTROL };
                        let text = egui::RichText::new(label).color(theme::TEXT_STRONG);
                        let button = egui::Button::new(text).fill(fill).min_size(egui::vec2(90.0, 28.0));
                        let button = ui.add(button);
                        state_report::mark(ctx, || format!("answer {i}"), button.rect);
                        if button.clicked() {
                            pressed = Some(i);
                        }
                    }
                });
            });
        if ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
            pressed = Some(2);
        }
        let Some(pressed) = pressed else { return };
        self.question = None;
        match (question, pressed) {
            (Question::Unsaved(next), 0) => {
                self.after_save = Some(next);
                self.save(ctx);
            }
            (Question::Unsaved(next), 1) => self.go_on(ctx, next),
            (Question::Recover, 0) => {
                if let Some(left) = self.recovery.as_ref().and_then(|recovery| recovery.left.first()).cloned() {
                    self.recover(ctx, left);
                }
            }
            (Question::Recover, 1) => {
                if let Some(recovery) = &mut self.recovery {
                    recovery.forget_left();
                }
            }
            (Question::Unsaved(_) | Question::Recover, _) => {}
        }
    }

    fn recover(&mut self, ctx: &egui::Context, left: Left) {
        self.jobs.start(ctx, "Recovering", move |watch| match recovery::restore(&left, watch) {
            Ok(restored) => Done::Recovered { restored: Box::new(restored), replaces: left.files },
            Err(_) if watch.cancelled() => Done::Cancelled,
            Err(why) => Done::Failed { title: "The unsaved work could not be read".to_owned(), why },
        });
    }

    fn dropped_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<_> = ctx.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            self.open_or_ask(ctx, file.path());
        }
    }

    fn choosers(&mut self, ctx: &egui::Context) {
        let Some((purpose, choice)) = self.chooser.as_mut().and_then(|chooser| chooser.ui(ctx)) else { return };
        self.chooser = None;
        match choice {
            Choice::Cancelled => self.after_save = None,
            Choice::Path(path) => self.chosen(ctx, purpose, path),
        }
    }

    fn chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: std::path::PathBuf) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.desk.settings.folder = path.parent().map(Path::to_owned);
        let groom = self.desk.document.groom.clone();
        match purpose {
            Purpose::Open => self.open_or_ask(ctx, &path),
            Purpose::SaveAs => self.save_to(ctx, path),
            Purpose::ImportHair => {
                self.jobs.start(ctx, format!("Importing {name}"), move |watch| jobs::import_hair(&path, watch));
            }
            Purpose::ImportHead => {
                self.jobs.start(ctx, format!("Importing {name}"), move |watch| jobs::import_head(&path, watch));
            }
            Purpose::ImportHairMesh => {
                let head = groom.head;
                self.jobs
                    .start(ctx, format!("Importing {name}"), move |watch| jobs::import_hair_mesh(&path, head, watch));
            }
            Purpose::ExportHairMesh => {
                let selected = self.selected_layer();
                self.jobs
                    .start(ctx, format!("Exporting {name}"), move |_| jobs::export_hair_mesh(&groom, selected, &path));
            }
            Purpose::Export => {
                self.jobs.start(ctx, format!("Exporting {name}"), move |watch| jobs::export(&groom, &path, watch));
            }
            Purpose::LoadStyle | Purpose::SaveStyle => {
                let done = panels::style::file(&mut self.desk, purpose == Purpose::SaveStyle, &path);
                if let Err(why) = done {
                    self.desk.notices.error(format!("{name} was not used as a style"), why.to_string());
                }
            }
            Purpose::SavePicture => {
                self.picture_path = Some(path);
                self.n_pictures += 1;
            }
            Purpose::SaveMacro => {
                let steps = std::mem::take(&mut self.recorded);
                self.jobs.start(ctx, format!("Saving {name}"), move |_| jobs::save_macro(&steps, &path));
            }
            Purpose::PlayMacro => {
                self.jobs.start(ctx, format!("Playing {name}"), move |watch| jobs::play_macro(groom, &path, watch));
            }
            Purpose::LoadMap => {
                let kind = self.desk.tools.paint.kind.clone();
                self.jobs.start(ctx, format!("Reading {name}"), move |_| jobs::load_map(&path, kind));
            }
            Purpose::SaveMap => {
                let Some((kind, map)) = tools::paint::map_to_save(&self.desk) else { return };
                let picture_kind = self.desk.tools.paint.picture_kind(&path);
                self.jobs
                    .start(ctx, format!("Writing {name}"), move |_| jobs::save_map(&path, &map, &kind, picture_kind));
            }
        }
    }

    fn selected_layer(&self) -> Option<usize> {
        match self.desk.selection {
            Selection::Layer(layer_idx) => Some(layer_idx),
            Selection::Head | Selection::Light(_) => None,
        }
    }

    fn fit_hair_mesh(&mut self, ctx: &egui::Context) {
        let groom = self.desk.document.groom.clone();
        let selected = self.selected_layer();
        self.jobs.start(ctx, "Fitting a hair mesh", move |_| jobs::fit_hair_mesh(&groom, selected));
    }

    fn palettes(&mut self, ctx: &egui::Context) {
        if let Some(palette) = &mut self.palette {
            match palette.ui(ctx) {
                PaletteAnswer::StaysOpen => {}
                PaletteAnswer::Closed => self.palette = None,
                PaletteAnswer::Run(command) => {
                    self.palette = None;
                    self.desk.asked.push(command);
                }
            }
        }
        if self.shows_shortcuts {
            self.shows_shortcuts = palette::shortcut_sheet(ctx);
        }
    }
}

fn lock(handover: &Handover) -> std::sync::MutexGuard<'_, start::Kept> {
    handover.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.finish_jobs(&ctx);
        self.clock.tick();
        self.pick_up(&ctx);
        if self.is_lost {
            self.hand_over(&ctx);
        }
        let is_typing = ctx.text_edit_focused()
            || self.desk.renaming.is_some()
            || self.palette.is_some()
            || self.desk.tools.takes_keys();
        while let Some(command) = commands::pressed(&ctx, is_typing, self.desk.tools.active) {
            self.desk.asked.push(command);
        }
        top_bar::ui(ui, self);
        status_bar::ui(ui, self);
        let background = egui::Frame::new().fill(theme::GAP);
        egui::CentralPanel::no_frame().frame(background).show(ui, |ui| {
            let mut layout = std::mem::replace(
                &mut self.desk.settings.layout,
                egui_tiles::Tree::empty(egui::Id::unique("moved out")),
            );
            let mut behavior = layout::Behavior { desk: &mut self.desk, viewport: &mut self.viewport };
            layout.ui(&mut behavior, ui);
            self.desk.settings.layout = layout;
        });
        self.palettes(&ctx);
        self.choosers(&ctx);
        self.questions(&ctx);
        self.desk.notices.ui(&ctx, self.viewport.rect);
        self.dropped_files(&ctx);
        if ctx.input(|input| input.viewport().close_requested()) && !self.may_close {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.ask_or_go_on(&ctx, Next::Close);
        }
        for command in std::mem::take(&mut self.desk.asked) {
            self.run(&ctx, command);
        }
        if !ctx.input(|input| input.pointer.any_down()) && !self.desk.tools.takes_keys() {
            self.desk.document.history.end_drag();
        }
        self.desk.clamp_selection();
        let is_dragging = ctx.input(|input| input.pointer.any_down());
        self.keep_records(is_dragging);
        self.keep_for_loss();
        self.post();
        self.show_title(&ctx);
        if self.viewport.is_interacting {
            self.clock.expect_next();
            ctx.request_repaint();
        } else {
            // Autosave looks at the clock.
            ctx.request_repaint_after_secs(10.0);
        }
        if self.state_report.is_some() && ctx.input_mut(|input| input.consume_shortcut(&LOSE_GPU)) {
            self.n_losses += 1;
        }
        if let Some(mut report) = self.state_report.take() {
            match report.write(self, &ctx) {
                Ok(()) => self.state_report = Some(report),
                Err(why) => log::error!("--report-state: {why}"),
            }
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, SETTINGS_KEY, &self.desk.settings);
    }

    fn on_exit(&mut self) {
        let was_lost = lock(&self.handover).is_lost;
        if let Some(recovery) = &mut self.recovery {
            recovery.end(!was_lost);
        }
        self.stage = None;
    }
}

impl Studio {
    fn show_title(&mut self, ctx: &egui::Context) {
        let mark = if self.desk.document.is_unsaved() { " *" } else { "" };
        let title = format!("{}{mark} - Lorelei", self.desk.document.title());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn grab(&mut self, is_turning: bool) {
        self.viewport.start_grab(&self.desk, is_turning);
    }

    fn choose(&mut self, ctx: &egui::Context, purpose: Purpose) {
        let settings = &self.desk.settings;
        let document = &self.desk.document;
        let stem = document
            .path
            .as_deref()
            .and_then(Path::file_stem)
            .map_or_else(|| document.groom.name.clone(), |stem| stem.to_string_lossy().into_owned());
        let stem = if purpose == Purpose::SaveMacro { "macro".to_owned() } else { stem };
        let name = if purpose.is_save() {
            purpose.with_extension(stem.replace(std::path::is_separator, "-").into()).display().to_string()
        } else {
            String::new()
        };
        let folder = settings.folder.as_deref();
        self.chooser = Some(Chooser::new(ctx, purpose, settings.use_system_dialogs, folder, name));
    }

    fn is_enabled(&self, command: Command) -> bool {
        let document = &self.desk.document;
        match command {
            Command::Undo => document.history.can_undo(),
            Command::Redo => document.history.can_redo(),
            Command::ToggleLayer | Command::DuplicateLayer | Command::RemoveLayer => {
                matches!(self.desk.selection, Selection::Layer(_))
            }
            Command::ClearHistory => document.history.labels().len() > 0,
            Command::RecordMacro | Command::PlayMacro => !document.is_none(),
            Command::LoadStyle | Command::SaveStyle => self.desk.selected_layer().is_some(),
            Command::DetachLayer => match self.desk.selection {
                Selection::Layer(layer_idx) => document.groom.layers_sharing(layer_idx).len() > 1,
                Selection::Head | Selection::Light(_) => false,
            },
            // Imported strands are as many as they are.
            Command::AddFlyAways | Command::AddFrizz => {
                let layer = self.desk.selected_layer();
                layer.is_some_and(|layer| !matches!(layer.source, Source::Strands(_)))
            }
            Command::Mesh(command) => self.desk.tools.mesh.is_enabled(&self.desk, command),
            Command::Paint(command) => tools::paint::commands::is_enabled(&self.desk, command),
            Command::Sculpt(command) => tools::sculpt::commands::is_enabled(&self.desk, command),
            _ => true,
        }
    }
}
