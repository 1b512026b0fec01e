//! What every command does, and whether it can be done now: one match over all of them each.

use std::path::Path;

use lorelei_core::edit::Edit;
use lorelei_core::groom::Source;
use lorelei_core::history::Merge;
use lorelei_core::io::Watch;
use lorelei_core::look::Shadowing;
use lorelei_core::motion::{AtEnd, HeadPose, Motion};

use super::commands::Command;
use super::desk::Selection;
use super::files::choose::Purpose;
use super::files::jobs;
use super::room::commands::RoomCommand;
use super::takes::TakeOver;
use super::tools::Tool;
use super::tools::paint::commands::PaintCommand;
use super::{Next, Palette, Question, Studio, layout, panels, room, tools};

impl Studio {
    pub(super) fn is_enabled(&self, command: Command) -> bool {
        let document = &self.desk.document;
        match command {
            Command::Undo => document.history.can_undo(),
            Command::Redo => document.history.can_redo(),
            Command::ToggleLayer | Command::DuplicateLayer | Command::RemoveLayer => {
                matches!(self.desk.selection, Selection::Layer(_))
            }
            Command::ClearHistory => document.history.labels().len() > 0,
            Command::RecordMacro
            | Command::PlayMacro
            | Command::SimulateRange
            | Command::SimulateToFile
            | Command::OpenFrames
            | Command::LoadAnimation
            | Command::SetRest
            | Command::BakeGuides => !document.is_none(),
            Command::LoadStyle | Command::SaveStyle => self.desk.selected_layer().is_some(),
            Command::DetachLayer => match self.desk.selection {
                Selection::Layer(layer_idx) => document.groom.layers_sharing(layer_idx).len() > 1,
                Selection::Head
                | Selection::Light(_)
                | Selection::Collider(_)
                | Selection::Pin(_)
                | Selection::Wind(_) => false,
            },
            // Imported strands are as many as they are.
            Command::AddFlyAways | Command::AddFrizz => {
                let layer = self.desk.selected_layer();
                layer.is_some_and(|layer| !matches!(layer.source, Source::Strands(_)))
            }
            Command::Mesh(command) => self.desk.tools.mesh.is_enabled(&self.desk, command),
            Command::Paint(command) => tools::paint::commands::is_enabled(&self.desk, command),
            Command::Sculpt(command) => tools::sculpt::commands::is_enabled(&self.desk, command),
            Command::Room(command) => room::commands::is_enabled(&self.desk, command),
            _ => true,
        }
    }

    pub(super) fn run(&mut self, ctx: &egui::Context, command: Command) {
        if !self.is_enabled(command) {
            return;
        }
        match command {
            Command::New => self.ask_or_go_on(ctx, Next::New),
            Command::Open => self.ask_or_go_on(ctx, Next::AskForFile),
            Command::Save => self.save(ctx),
            Command::SaveAs => self.choose(ctx, Purpose::SaveAs),
            Command::ImportHair => self.choose(ctx, Purpose::ImportHair),
            Command::ImportHead => self.choose(ctx, Purpose::ImportHead),
            Command::ImportHairMesh => self.choose(ctx, Purpose::ImportHairMesh),
            Command::ExportHairMesh => self.choose(ctx, Purpose::ExportHairMesh),
            Command::FitHairMesh => self.fit_hair_mesh(ctx),
            Command::Export => self.choose(ctx, Purpose::Export),
            Command::SavePicture => self.choose(ctx, Purpose::SavePicture),
            Command::LoadStyle => self.choose(ctx, Purpose::LoadStyle),
            Command::SaveStyle => self.choose(ctx, Purpose::SaveStyle),
            Command::Quit => self.ask_or_go_on(ctx, Next::Close),
            Command::Undo => {
                self.desk.document.undo();
                self.desk.measure();
            }
            Command::Redo => {
                self.desk.document.redo();
                self.desk.measure();
            }
            Command::Frame => self.desk.frame_all(self.viewport.aspect()),
            Command::Front => self.view(0.0, 5.0),
            Command::Back => self.view(180.0, 5.0),
            Command::Right => self.view(90.0, 5.0),
            Command::Left => self.view(-90.0, 5.0),
            Command::Top => self.view(0.0, 89.0),
            Command::ThreeQuarter => self.view(35.0, 5.0),
            Command::ToggleGizmos => self.desk.show_handles = !self.desk.show_handles,
            Command::ResetLayout => self.desk.settings.layout = layout::default_layout(),
            Command::Fullscreen => {
                let is_full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!is_full));
            }
            Command::Play => self.play(),
            Command::Step => self.step(1),
            Command::StepBack => self.step(-1),
            Command::ToStart => self.desk.seek(self.desk.document.groom.movement.bounded().start),
            Command::ToEnd => self.desk.seek(self.desk.document.groom.movement.bounded().end),
            Command::Reset => {
                let playback = &mut self.desk.playback;
                playback.is_playing = false;
                playback.head_pose = HeadPose::default();
                playback.n_resets += 1;
            }
            Command::MoveHead => self.grab(false),
            Command::TurnHead => self.grab(true),
            Command::SimulateRange => self.simulate_range(ctx, None),
            Command::SimulateToFile => self.choose(ctx, Purpose::SaveFrames),
            Command::OpenFrames => self.choose(ctx, Purpose::OpenFrames),
            Command::LoadAnimation => self.choose(ctx, Purpose::LoadAnimation),
            Command::SetRest => self.take_over(TakeOver::Rest),
            Command::BakeGuides => self.take_over(TakeOver::Bake),
            Command::MotionNone => self.motion(Motion::None),
            Command::MotionTurn => self.motion(Motion::Turn),
            Command::MotionNod => self.motion(Motion::Nod),
            Command::MotionShake => self.motion(Motion::Shake),
            Command::MotionWalk => self.motion(Motion::Walk),
            Command::MotionJump => self.motion(Motion::Jump),
            Command::MotionGust => self.motion(Motion::Gust),
            Command::ToggleShadows => self.toggle_shadows(),
            Command::ToggleLayer
            | Command::DuplicateLayer
            | Command::RemoveLayer
            | Command::AddFlyAways
            | Command::AddFrizz
            | Command::DetachLayer => {
                panels::properties::layer_command(&mut self.desk, command);
                self.desk.measure();
            }
            Command::RecordMacro => self.record_macro(ctx),
            Command::PlayMacro => self.choose(ctx, Purpose::PlayMacro),
            Command::ClearHistory => self.desk.document.history.clear(),
            Command::Palette => {
                self.palette = if self.palette.is_some() { None } else { Some(Palette::new(ctx)) };
            }
            Command::Tool(tool) => self.take_tool(ctx, tool),
            Command::Mesh(command) => tools::mesh::run(&mut self.desk, command),
            Command::DrawLevels => {
                let (groom, camera) = (self.desk.document.groom.clone(), self.desk.camera);
                self.jobs.start(ctx, "Drawing the levels", move |watch| jobs::draw_levels(&groom, camera, watch));
            }
            Command::SolveLevel => {
                let (groom, camera, size) = (self.desk.document.groom.clone(), self.desk.camera, self.viewport.size);
                let target = self.desk.levels.target_ms;
                let work = move |watch: Watch<'_>| jobs::solve_level(&groom, camera, size, target, watch);
                self.jobs.start(ctx, "Looking for a level of detail", work);
            }
            Command::Paint(PaintCommand::Load) => self.choose(ctx, Purpose::LoadMap),
            Command::Paint(PaintCommand::Save) => self.choose(ctx, Purpose::SaveMap),
            Command::Paint(command) => tools::paint::commands::run(&mut self.desk, command),
            Command::Sculpt(command) => tools::sculpt::commands::run(&mut self.desk, command),
            Command::Room(RoomCommand::ContactSheet) => self.draw_sheet(ctx, self.desk.room.slot),
            Command::Room(RoomCommand::Turntable) => self.choose(ctx, Purpose::SaveTurntable),
            Command::Room(RoomCommand::LoadEnvironment) => self.choose(ctx, Purpose::LoadEnvironment),
            Command::Room(RoomCommand::LoadLook) => self.choose(ctx, Purpose::LoadLook),
            Command::Room(RoomCommand::SaveLook) => self.choose(ctx, Purpose::SaveLook),
            Command::Room(command) => room::commands::run(&mut self.desk, command),
            Command::Shortcuts => self.shows_shortcuts = !self.shows_shortcuts,
        }
    }

    /// Draw every choice of a slot as the viewport is now, in the background.
    pub(super) fn draw_sheet(&mut self, ctx: &egui::Context, slot: &'static str) {
        self.desk.room.slot = slot;
        let (groom, camera, shown) = (self.desk.document.groom.clone(), self.desk.camera, self.desk.room.shown());
        let work = move |watch: Watch<'_>| jobs::draw_sheet(&groom, &shown, &camera, slot, watch);
        self.jobs.start(ctx, format!("Drawing the contact sheet of {slot}"), work);
    }

    fn take_tool(&mut self, ctx: &egui::Context, tool: Tool) {
        let active = &mut self.desk.tools.active;
        *active = if *active == tool { Tool::Select } else { tool };
        let panel = if *active == Tool::Select { layout::Panel::Properties } else { layout::Panel::Tool };
        layout::show(&mut self.desk.settings.layout, panel);
        // Tab also went to the next control.
        ctx.memory_mut(|memory| {
            if let Some(focused) = memory.focused() {
                memory.surrender_focus(focused);
            }
        });
    }

    fn view(&mut self, azimuth_deg: f32, elevation_deg: f32) {
        self.desk.camera.azimuth_deg = azimuth_deg;
        self.desk.camera.elevation_deg = elevation_deg;
    }

    fn play(&mut self) {
        let movement = self.desk.document.groom.movement.bounded();
        let playback = &mut self.desk.playback;
        playback.is_playing = !playback.is_playing;
        if playback.is_playing && movement.at_end == AtEnd::Stop && self.desk.report.timeline.at >= movement.end {
            playback.seek(movement.start);
        }
    }

    fn step(&mut self, n_frames: i64) {
        self.desk.playback.is_playing = false;
        self.desk.playback.n_steps += n_frames;
    }

    fn motion(&mut self, motion: Motion) {
        self.desk.set_motion(motion);
    }

    fn toggle_shadows(&mut self) {
        let mut look = self.desk.document.groom.look.clone();
        let label = if look.shadowing == Shadowing::Off {
            look.shadowing = self.last_shadowing;
            "Shadows on"
        } else {
            self.last_shadowing = look.shadowing;
            look.shadowing = Shadowing::Off;
            "Shadows off"
        };
        self.desk.document.edit(label, Edit::SetLook(Box::new(look)), Merge::New);
    }

    /// Save to the document's file, or ask for one.
    pub(super) fn save(&mut self, ctx: &egui::Context) {
        match self.desk.document.path.clone() {
            Some(path) => self.save_to(ctx, path),
            None => self.choose(ctx, Purpose::SaveAs),
        }
    }

    pub(super) fn save_to(&mut self, ctx: &egui::Context, path: std::path::PathBuf) {
        let groom = self.desk.document.groom.clone();
        let state = self.desk.document.state();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.jobs.start(ctx, format!("Saving {name}"), move |watch| jobs::save(&groom, state, &path, watch));
    }

    /// Go on at once where nothing would be lost, else ask first.
    pub(super) fn ask_or_go_on(&mut self, ctx: &egui::Context, next: Next) {
        if self.desk.document.is_unsaved() {
            self.question = Some(Question::Unsaved(next));
        } else {
            self.go_on(ctx, next);
        }
    }

    pub(super) fn go_on(&mut self, ctx: &egui::Context, next: Next) {
        match next {
            Next::Close => {
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Next::New => self.start_default(ctx),
            Next::Hairstyle(key) => self.start_hairstyle(ctx, key),
            Next::AskForFile => self.choose(ctx, Purpose::Open),
            Next::Open(path) => self.start_opening(ctx, &path, None),
        }
    }

    /// A file that was dropped, chosen, or is a recent one. A head is added; anything else replaces the
    /// document, so unsaved changes are asked about.
    pub(super) fn open_or_ask(&mut self, ctx: &egui::Context, path: &Path) {
        let is_mesh =
            lorelei_core::io::detect(path).is_ok_and(|format| format.contents() == lorelei_core::io::Contents::Mesh);
        if is_mesh {
            self.start_opening(ctx, path, None);
        } else {
            self.ask_or_go_on(ctx, Next::Open(path.to_owned()));
        }
    }
}
