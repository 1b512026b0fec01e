//! From a command that needs a file to the job that reads or writes it.

use std::path::{Path, PathBuf};

use super::choose::{Choice, Chooser, Purpose};
use super::{jobs, listing};
use crate::window::desk::Selection;
use crate::window::{Studio, panels, room, tools};

impl Studio {
    pub(in crate::window) fn choose(&mut self, ctx: &egui::Context, purpose: Purpose) {
        let settings = &self.desk.settings;
        let document = &self.desk.document;
        let stem = document
            .path
            .as_deref()
            .and_then(Path::file_stem)
            .map_or_else(|| document.groom.name.clone(), |stem| stem.to_string_lossy().into_owned());
        let stem = match purpose {
            Purpose::SaveMacro => "macro".to_owned(),
            Purpose::SaveLook => "look".to_owned(),
            Purpose::SaveSheet => self.desk.room.slot.to_owned(),
            Purpose::SaveTurntable => "turntable".to_owned(),
            _ => stem,
        };
        let name = if purpose.is_save() {
            purpose.with_extension(stem.replace(std::path::is_separator, "-").into()).display().to_string()
        } else {
            String::new()
        };
        let folder = settings.folder.as_deref();
        self.chooser = Some(Chooser::new(ctx, purpose, settings.use_system_dialogs, folder, name));
    }

    pub(in crate::window) fn choosers(&mut self, ctx: &egui::Context) {
        let Some((purpose, choice)) = self.chooser.as_mut().and_then(|chooser| chooser.ui(ctx)) else { return };
        self.chooser = None;
        match choice {
            Choice::Cancelled => {
                self.after_save = None;
                self.sheet = None;
            }
            Choice::Path(path) => self.chosen(ctx, purpose, path),
        }
    }

    pub(in crate::window) fn chosen(&mut self, ctx: &egui::Context, purpose: Purpose, path: PathBuf) {
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
            Purpose::LoadLook | Purpose::SaveLook => {
                let done = room::commands::file(&mut self.desk, purpose == Purpose::SaveLook, &path);
                if let Err(why) = done {
                    self.desk.notices.error(format!("{name} was not used as a look"), why.to_string());
                }
            }
            Purpose::LoadEnvironment => self.load_environment(ctx, path),
            Purpose::SaveSheet => {
                let Some(picture) = self.sheet.take() else { return };
                self.jobs.start(ctx, format!("Saving {name}"), move |_| jobs::save_picture(&picture, &path));
            }
            Purpose::SaveTurntable => {
                let (camera, size, shown) = (self.desk.camera, self.viewport.size, self.desk.room.shown());
                let work = move |watch: lorelei_core::io::Watch<'_>| {
                    jobs::turntable(&groom, &shown, &camera, size, &path, watch)
                };
                self.jobs.start(ctx, "Drawing the turntable", work);
            }
            Purpose::SaveFrames => self.simulate_range(ctx, Some(path)),
            Purpose::OpenFrames => self.open_frames(ctx, path),
            Purpose::LoadAnimation => self.load_animation(ctx, path),
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

    /// Read a picture of what is all around, on a thread.
    fn load_environment(&mut self, ctx: &egui::Context, path: PathBuf) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.jobs.start(ctx, format!("Reading {name}"), move |_| jobs::load_environment(&path));
    }

    pub(in crate::window) fn selected_layer(&self) -> Option<usize> {
        match self.desk.selection {
            Selection::Layer(layer_idx) => Some(layer_idx),
            Selection::Head | Selection::Light(_) | Selection::Collider(_) | Selection::Pin(_) | Selection::Wind(_) => {
                None
            }
        }
    }

    pub(in crate::window) fn fit_hair_mesh(&mut self, ctx: &egui::Context) {
        let groom = self.desk.document.groom.clone();
        let selected = self.selected_layer();
        self.jobs.start(ctx, "Fitting a hair mesh", move |_| jobs::fit_hair_mesh(&groom, selected));
    }

    pub(in crate::window) fn dropped_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<_> = ctx.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            let path = file.path();
            let is_environment =
                listing::has_extension(path, &Purpose::LoadEnvironment.extensions()) && !self.desk.document.is_none();
            if is_environment {
                self.load_environment(ctx, path.to_owned());
            } else {
                self.open_or_ask(ctx, path);
            }
        }
    }
}
