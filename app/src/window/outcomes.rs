//! What opening, importing, saving and all other jobs come to: each takes its place in the window when it is done.

use std::path::Path;

use lorelei_core::edit::Edit;
use lorelei_core::groom::Groom;
use lorelei_core::history::Merge;
use lorelei_core::lod::LodChoice;
use lorelei_core::look::Choice;
use lorelei_core::motion::HeadPose;
use lorelei_core::simulation::{Moved, SimulationSettings};

use super::desk::Selection;
use super::document::Document;
use super::files::choose::Purpose;
use super::files::jobs::{self, Done};
use super::notices::Severity;
use super::recovery::Base;
use super::{Studio, tools};

impl Studio {
    /// Take over what jobs have done.
    pub(super) fn finish_jobs(&mut self, ctx: &egui::Context) {
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
                Done::EnvironmentLoaded { panorama } => {
                    let edit = self.desk.document.groom.lit_by(panorama);
                    self.desk.document.edit("Load environment", edit, Merge::New);
                }
                Done::MapLoaded { kind, map } => tools::paint::take_map(&mut self.desk, kind, map),
                Done::Sheet { picture } => {
                    self.sheet = Some(picture);
                    self.choose(ctx, Purpose::SaveSheet);
                }
                Done::TurntableSaved { n_pictures, folder } => {
                    let text = format!("{n_pictures} pictures in {}", folder.display());
                    self.desk.notices.push(Severity::Info, "Turntable saved", text);
                }
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
                Done::Animation { tracks } => self.take_animation(tracks),
                Done::Ranged { ranged, path } => self.take_frames(ranged, path.as_deref()),
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

    pub(super) fn note(&mut self, source: &Path, notes: &[String]) {
        if !notes.is_empty() {
            let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
            self.desk.notices.push(Severity::Info, name, notes.join("\n"));
        }
    }

    pub(super) fn add_layers(&mut self, layers: Vec<lorelei_core::groom::Layer>) {
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

    /// Open the default groom on a thread: its strands are made when it opens.
    pub(super) fn start_default(&mut self, ctx: &egui::Context) {
        self.jobs.start_opening(ctx, "Opening the default groom", |_| Done::Opened {
            groom: Box::new(lorelei_assets::default_groom()),
            path: None,
            source: std::path::PathBuf::new(),
            style: lorelei_assets::hairstyle_names().first().copied(),
            notes: Vec::new(),
        });
    }

    pub(super) fn start_hairstyle(&mut self, ctx: &egui::Context, key: &'static str) {
        self.jobs.start_opening(ctx, format!("Opening {key}"), move |_| match lorelei_assets::hairstyle(key) {
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

    pub(super) fn start_opening(&mut self, ctx: &egui::Context, path: &Path, head: Option<std::path::PathBuf>) {
        let path = path.to_owned();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.jobs.start_opening(ctx, format!("Opening {name}"), move |watch| jobs::open(&path, head.as_deref(), watch));
    }

    /// Show another document.
    pub(super) fn show_document(&mut self, groom: Groom, path: Option<std::path::PathBuf>, is_unsaved: bool) {
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

    /// A person gave up preparing every strand to move: what moved `before` does so again.
    pub(super) fn move_again(&mut self, before: Moved) {
        let simulation = &self.desk.document.groom.simulation;
        if simulation.moved != Moved::Strands {
            return;
        }
        let label = before.info().label;
        let settings = SimulationSettings { moved: before, ..simulation.clone() };
        let step = format!("What moves: {} again", label.to_lowercase());
        self.desk.document.edit(&step, Edit::SetSimulation(Box::new(settings)), Merge::New);
        let text = format!(
            "Preparing every strand was cancelled. What moves is `{label}` again; choose `{}` in the panel Movement to prepare them anew.",
            Moved::Strands.info().label
        );
        self.desk.notices.push(Severity::Info, "Not every strand moves", text);
    }

    /// A person gave up preparing `state`: back to what is on screen.
    pub(super) fn take_back(&mut self, state: (u64, u64)) {
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
}
