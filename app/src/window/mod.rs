//! The studio's window: one frame of it from top to bottom.

mod collider_handles;
mod commands;
mod desk;
mod document;
mod files;
mod handles;
mod layout;
mod macros;
mod navigation;
mod notices;
mod outcomes;
mod palette;
mod panels;
mod pin_handles;
mod projection;
mod questions;
mod recovery;
mod room;
mod run_command;
mod settings;
mod start;
mod state_report;
mod status_bar;
mod takes;
mod theme;
mod timeline;
mod tools;
mod top_bar;
mod viewport;
mod wind_handles;
mod wind_view;

use lorelei_core::camera::Camera;
use lorelei_core::script::Step;
use lorelei_shaders::Gpu;

pub use start::{StartOptions, open};

use crate::stage::report::Cancelled;
use crate::stage::shown::Shown;
use crate::stage::thread::{FrameRequest, StageGpu, StageThread};
use desk::{Desk, FrameTimes};
use document::Document;
use files::choose::Chooser;
use files::jobs::{self, Jobs};
use notices::{Notices, Severity};
use palette::{Palette, PaletteAnswer};
use questions::{Next, Question};
use recovery::{Left, Recovery};
use settings::{SETTINGS_KEY, Settings};
use start::Handover;
use state_report::{StateReport, UiClock};
use viewport::Viewport;

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
    /// A contact sheet that waits for its file's name.
    sheet: Option<image::RgbaImage>,
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
            sheet: None,
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
        let shot = report.shot.take();
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
        match report.cancelled.take() {
            Some(Cancelled::Strands(state)) => self.take_back(state),
            Some(Cancelled::EveryStrand(before)) => self.move_again(before),
            Some(Cancelled::CatchUp) => self.desk.playback.is_playing = false,
            None => {}
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
            // Frames of less detail cost less, and what is shown beside the document is not the document's look.
            let is_full = report.lod >= 1.0 && report.coarseness == 1 && report.shown == Shown::default();
            if is_full && report.state == self.desk.document.state() {
                self.desk.room.costs.keep(&report, &self.desk.document.groom.look);
            }
        }
        self.is_lost |= report.is_lost;
        if report.timeline.has_ended && report.frame_idx != self.desk.report.frame_idx {
            self.desk.playback.is_playing = false;
        }
        self.desk.report = report;
        if let Some((_, shot)) = shot {
            self.took_over(shot);
        }
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
            shown: self.desk.room.shown(),
            inspect: self.desk.room.pixel,
            wants_air: self.desk.wind_view.is_on(),
            is_interacting: self.viewport.is_interacting,
            moving_budget_ms: self.desk.settings.moving_budget_ms,
            frames_budget: self.frames_budget(),
            offered: self.desk.takes.offered.clone(),
            n_shots: self.desk.takes.n_shots,
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
            && report.shown == self.desk.room.shown()
            && self.jobs.running.is_empty()
    }

    /// For the state report: where the head's handle is.
    fn head_handle(&self) -> Option<[f32; 2]> {
        let projection = projection::Projection::new(&self.desk.camera, self.viewport.rect?);
        let at = projection.point(self.desk.neck + self.desk.playback.head_pose.shift)?;
        Some([at.x, at.y])
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
        // It comes first, so that what is pressed while it waits for an answer is for it alone.
        let is_asked = self.question.is_some();
        self.questions(&ctx);
        if is_asked {
            questions::take_keys(&ctx);
        }
        let is_typing = ctx.text_edit_focused()
            || self.chooser.is_some()
            || self.desk.renaming.is_some()
            || self.palette.is_some()
            || self.desk.tools.takes_keys();
        let mut pressed = Vec::new();
        while let Some(command) = commands::pressed(&ctx, is_typing, self.desk.tools.active) {
            pressed.push(command);
        }
        if pressed.contains(&commands::Command::Palette) {
            // Letters that came with its key in one slow frame are for it.
            pressed.retain(|&command| command == commands::Command::Palette);
        }
        self.desk.asked.append(&mut pressed);
        self.viewport.opening = self.jobs.opening();
        top_bar::ui(ui, self);
        status_bar::ui(ui, self);
        timeline::ui(ui, &mut self.desk);
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
}
