//! Work on files on threads, with progress and cancel; what comes of it is picked up by the window.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, mpsc};

use lorelei_core::camera::Camera;
use lorelei_core::document;
use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::hair_mesh::HairMesh;
use lorelei_core::io::{self, Contents, ImportOptions, Watch, WriteOptions};
use lorelei_core::maps::picture::{self, PictureError, PictureKind};
use lorelei_core::maps::{MapKind, ScalpMap};
use lorelei_core::motion::PoseTrack;
use lorelei_core::panorama::Panorama;
use lorelei_core::panorama::read::read_panorama;
use lorelei_core::script::{self, Step};
use lorelei_shaders::Gpu;

use crate::lod_strip::{LevelPicture, LevelStage};
use crate::movement::range::Ranged;
use crate::sheet::{self, SheetInput};
use crate::stage::shown::Shown;
use crate::window::recovery::Restored;
use crate::{open, turntable};

/// What came of a job.
pub enum Done {
    /// A document; `path` is its `.lorelei` file.
    Opened {
        groom: Box<Groom>,
        path: Option<PathBuf>,
        source: PathBuf,
        /// It is this embedded style.
        style: Option<&'static str>,
        notes: Vec<String>,
    },
    Hair {
        layers: Vec<Layer>,
        source: PathBuf,
        notes: Vec<String>,
    },
    Head {
        head: Head,
        source: PathBuf,
        notes: Vec<String>,
    },
    Saved {
        state: (u64, u64),
        path: PathBuf,
    },
    PictureSaved {
        path: PathBuf,
    },
    /// Levels of detail, drawn.
    Levels {
        levels: Vec<LevelPicture>,
    },
    /// The level whose frames take a target's time, and what they take, milliseconds.
    Level {
        level: f32,
        ms: f32,
    },
    /// A contact sheet, to be saved where the artist says.
    Sheet {
        picture: image::RgbaImage,
    },
    TurntableSaved {
        n_pictures: usize,
        folder: PathBuf,
    },
    /// A picture of what is all around.
    EnvironmentLoaded {
        panorama: Panorama,
    },
    MapLoaded {
        kind: MapKind,
        map: ScalpMap,
    },
    /// What a crashed run had left.
    Recovered {
        restored: Box<Restored>,
        /// Files that are not needed once the document is kept anew.
        replaces: Vec<PathBuf>,
    },
    /// What moves in a file.
    Animation {
        tracks: Vec<PoseTrack>,
    },
    /// Frames of a movement; what was cancelled is as far as it came.
    Ranged {
        ranged: Ranged,
        path: Option<PathBuf>,
    },
    MacroSaved {
        path: PathBuf,
    },
    /// A macro's edits, as they were applied to a copy of the groom.
    Played {
        name: String,
        edits: Vec<Edit>,
    },
    Exported {
        path: PathBuf,
        notes: Vec<String>,
    },
    Failed {
        title: String,
        why: String,
    },
    Cancelled,
}

impl Done {
    /// Whether it is for the window to take over, so that a cancel counts however late it comes. What is written
    /// is written.
    fn can_be_left(&self) -> bool {
        match self {
            Self::Opened { .. }
            | Self::Hair { .. }
            | Self::Head { .. }
            | Self::Levels { .. }
            | Self::Level { .. }
            | Self::Sheet { .. }
            | Self::EnvironmentLoaded { .. }
            | Self::MapLoaded { .. }
            | Self::Played { .. }
            | Self::Animation { .. }
            | Self::Recovered { .. } => true,
            Self::Saved { .. }
            | Self::PictureSaved { .. }
            | Self::TurntableSaved { .. }
            | Self::MacroSaved { .. }
            | Self::Ranged { .. }
            | Self::Exported { .. }
            | Self::Failed { .. }
            | Self::Cancelled => false,
        }
    }
}

/// A job that runs.
pub struct Job {
    pub label: String,
    /// Another document will take the place of this one.
    is_opening: bool,
    progress: Arc<AtomicU32>,
    cancel: Arc<AtomicBool>,
    receiver: mpsc::Receiver<Done>,
}

/// All jobs that run.
#[derive(Default)]
pub struct Jobs {
    pub running: Vec<Job>,
}

impl Jobs {
    /// As [`Jobs::start`], where another document comes of it: the viewport says so.
    pub fn start_opening(
        &mut self,
        ctx: &egui::Context,
        label: impl Into<String>,
        work: impl FnOnce(Watch<'_>) -> Done + Send + 'static,
    ) {
        self.start(ctx, label, work);
        if let Some(job) = self.running.last_mut() {
            job.is_opening = true;
        }
    }

    /// What is being opened, in words.
    pub fn opening(&self) -> Option<String> {
        let job = self.running.iter().find(|job| job.is_opening)?;
        let share = f32::from_bits(job.progress.load(Ordering::Relaxed));
        let done = if share > 0.0 { format!(" {:.0} %", 100.0 * share) } else { String::new() };
        Some(format!("{}\u{2026}{done}", job.label))
    }

    /// Run `work` on a thread.
    pub fn start(
        &mut self,
        ctx: &egui::Context,
        label: impl Into<String>,
        work: impl FnOnce(Watch<'_>) -> Done + Send + 'static,
    ) {
        let progress = Arc::new(AtomicU32::new(0));
        let cancel = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = mpsc::channel();
        let (their_progress, their_cancel, ctx) = (Arc::clone(&progress), Arc::clone(&cancel), ctx.clone());
        std::thread::spawn(move || {
            let on_progress = |share: f32| {
                their_progress.store(share.to_bits(), Ordering::Relaxed);
                ctx.request_repaint();
            };
            let mut done = work(Watch::new(&on_progress, &their_cancel));
            if their_cancel.load(Ordering::Relaxed) && done.can_be_left() {
                done = Done::Cancelled;
            }
            // The window may have been closed meanwhile: then nobody listens.
            let _ = sender.send(done);
            ctx.request_repaint();
        });
        self.running.push(Job { label: label.into(), is_opening: false, progress, cancel, receiver });
    }

    /// What has come of jobs since the last call.
    pub fn finished(&mut self) -> Vec<Done> {
        let mut finished = Vec::new();
        self.running.retain(|job| match job.receiver.try_recv() {
            Ok(done) => {
                finished.push(done);
                false
            }
            Err(mpsc::TryRecvError::Empty) => true,
            Err(mpsc::TryRecvError::Disconnected) => {
                let why = "the work ended without an answer: a bug; the groom is as it was".to_owned();
                finished.push(Done::Failed { title: job.label.clone(), why });
                false
            }
        });
        finished
    }

    /// A line with a bar and a way to stop, for the status bar.
    pub fn ui(&self, ui: &mut egui::Ui) {
        for job in &self.running {
            let share = f32::from_bits(job.progress.load(Ordering::Relaxed));
            if ui.small_button("Cancel").on_hover_text("Stop; everything stays as it was").clicked() {
                job.cancel.store(true, Ordering::Relaxed);
            }
            ui.add(egui::ProgressBar::new(share).desired_width(120.0).desired_height(8.0));
            ui.label(&job.label);
        }
    }
}

/// Open whatever a file holds: a document, or hair of another program as a new document.
pub fn open(path: &Path, head_path: Option<&Path>, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: format!("Could not open {}", name_of(path)), why };
    if open::hairstyle_named(path).is_none() && io::detect(path).is_ok_and(|format| format.contents() == Contents::Mesh)
    {
        return import_head(path, watch);
    }
    match open::open(path, head_path, ImportOptions::default(), watch) {
        Ok(opened) => {
            let mut notes = opened.notes;
            if !opened.space_reason.is_empty() {
                notes.insert(0, format!("Read as {}", opened.space_reason));
            }
            let style = open::hairstyle_named(path);
            Done::Opened {
                groom: Box::new(opened.groom),
                path: opened.is_document.then(|| path.to_owned()),
                source: if style.is_some() { PathBuf::new() } else { path.to_owned() },
                // With another head it is no longer the style.
                style: style.filter(|_| head_path.is_none()),
                notes,
            }
        }
        Err(why) if why.is_cancelled() => Done::Cancelled,
        Err(why) => failed(why.to_string()),
    }
}

/// Read a picture of what is all around.
pub fn load_environment(path: &Path) -> Done {
    match read_panorama(path) {
        Ok(panorama) => Done::EnvironmentLoaded { panorama },
        Err(why) => Done::Failed { title: format!("Could not read {}", name_of(path)), why: why.to_string() },
    }
}

/// Read strands as layers to add.
pub fn import_hair(path: &Path, watch: Watch<'_>) -> Done {
    match open(path, None, watch) {
        Done::Opened { groom, source, notes, .. } => Done::Hair { layers: groom.layers, source, notes },
        done => done,
    }
}

/// Read a mesh as the head.
pub fn import_head(path: &Path, watch: Watch<'_>) -> Done {
    match open::read_head(path, watch) {
        Ok((head, notes)) => Done::Head { head, source: path.to_owned(), notes },
        Err(why) if why.is_cancelled() => Done::Cancelled,
        Err(why) => Done::Failed { title: format!("Could not read {}", name_of(path)), why: why.to_string() },
    }
}

/// Read polygons as a layer with a hair mesh, on `head` or else on the mannequin.
pub fn import_hair_mesh(path: &Path, head: Option<Head>, watch: Watch<'_>) -> Done {
    let head = head.unwrap_or_else(lorelei_assets::mannequin);
    match open::hair_mesh_layer(path, &head, ImportOptions::default(), watch) {
        Ok((layer, notes)) => Done::Hair { layers: vec![layer], source: path.to_owned(), notes },
        Err(why) if why.is_cancelled() => Done::Cancelled,
        Err(why) => Done::Failed { title: format!("Could not read {}", name_of(path)), why: why.to_string() },
    }
}

/// Write the selected layer's hair mesh as polygons, or the first that there is.
pub fn export_hair_mesh(groom: &Groom, selected: Option<usize>, path: &Path) -> Done {
    let failed = |why: String| Done::Failed { title: format!("Could not export {}", name_of(path)), why };
    let Some(mesh) = open::hair_mesh_of(groom, selected) else {
        return failed("no layer is made of a hair mesh: make or import one first".to_owned());
    };
    match io::write_hair_mesh(path, mesh) {
        Ok(()) => Done::Exported { path: path.to_owned(), notes: Vec::new() },
        Err(why) => failed(why.to_string()),
    }
}

/// Root faces of a fitted hair mesh, and its layers: enough to follow a hairstyle, few enough to model with.
const FITTED_CELL_CM: f32 = 2.0;
const N_FITTED_LAYERS: usize = 8;

/// A layer with a hair mesh around the selected layer's guides or strands, or the first that has some.
pub fn fit_hair_mesh(groom: &Groom, selected: Option<usize>) -> Done {
    let failed = |why: String| Done::Failed { title: "Could not fit a hair mesh".to_owned(), why };
    let guides_of = |layer: &Layer| match &layer.source {
        Source::Guides(strands) | Source::Strands(strands) => Some(Arc::clone(strands)),
        Source::HairMesh(_) => None,
    };
    let selected = selected.and_then(|layer_idx| groom.layers.get(layer_idx)).filter(|l| guides_of(l).is_some());
    let Some(layer) = selected.or_else(|| groom.layers.iter().find(|layer| guides_of(layer).is_some())) else {
        return failed("no layer has guides or strands: import some, or draw guides first".to_owned());
    };
    let Some(guides) = guides_of(layer) else { return Done::Cancelled };
    let head = groom.head.clone().unwrap_or_else(lorelei_assets::mannequin);
    match HairMesh::around_guides(&guides, &head.mesh, FITTED_CELL_CM, N_FITTED_LAYERS) {
        Ok(mesh) => {
            let notes = vec![format!(
                "{} bundles of {N_FITTED_LAYERS} layers around {} curves",
                mesh.n_bundles(),
                guides.n_strands()
            )];
            let fitted = Layer {
                name: format!("{} as a hair mesh", layer.name),
                source: Source::HairMesh(Arc::new(mesh)),
                n_strands: layer.n_strands.max(20_000),
                read_as: None,
                ..layer.clone()
            };
            Done::Hair { layers: vec![fitted], source: PathBuf::new(), notes }
        }
        Err(why) => failed(why.to_string()),
    }
}

/// Write the document.
pub fn save(groom: &Groom, state: (u64, u64), path: &Path, watch: Watch<'_>) -> Done {
    match document::save_watched(groom, path, watch) {
        Ok(()) => Done::Saved { state, path: path.to_owned() },
        Err(why) if why.is_cancelled() => Done::Cancelled,
        Err(why) => Done::Failed { title: format!("Could not save {}", name_of(path)), why: why.to_string() },
    }
}

/// Write a picture of the viewport.
pub fn save_picture(picture: &image::RgbaImage, path: &Path) -> Done {
    let written = io::write_atomically(path, |file| {
        picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other)
    });
    match written {
        Ok(()) => Done::PictureSaved { path: path.to_owned() },
        Err(why) => Done::Failed { title: format!("Could not save {}", name_of(path)), why: why.to_string() },
    }
}

/// Write a macro.
pub fn save_macro(steps: &[Step], path: &Path) -> Done {
    let failed = |why: String| Done::Failed { title: format!("Could not save {}", name_of(path)), why };
    let text = match script::to_text(steps) {
        Ok(text) => text,
        Err(why) => return failed(why.to_string()),
    };
    match io::write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes())) {
        Ok(()) => Done::MacroSaved { path: path.to_owned() },
        Err(why) => failed(why.to_string()),
    }
}

/// Replay a macro on a copy of the groom; what it did is then one step of the groom itself.
pub fn play_macro(mut groom: Groom, path: &Path, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: format!("Could not play {}", name_of(path)), why };
    let steps = match crate::script::read(path) {
        Ok(steps) => steps,
        Err(why) => return failed(why),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    match crate::script::run(&mut groom, &steps, folder, watch) {
        Ok(edits) => {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            Done::Played { name, edits }
        }
        Err(_) if watch.cancelled() => Done::Cancelled,
        Err(refusal) => {
            failed(format!("{refusal}\nNothing was changed. It was made for another groom, or has a fault"))
        }
    }
}

/// Pixels of a tile of a contact sheet.
const TILE_SIZE: [u32; 2] = [420, 420];
/// Pictures of a turntable: a second and a half at 24 a second.
const N_TURNTABLE: u32 = 36;

/// Draw every choice of a slot, seen as the viewport sees the groom.
pub fn draw_sheet(groom: &Groom, shown: &Shown, camera: &Camera, slot: &str, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: "The contact sheet could not be drawn".to_owned(), why };
    let Some(name) = sheet::slots().into_iter().find(|(key, ..)| *key == slot) else {
        return failed(format!("there is no slot {slot}"));
    };
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(why) => return failed(why.to_string()),
    };
    let groom = Groom { look: shown.look(&groom.look), lights: shown.lights(&groom.lights), ..groom.clone() };
    let input = SheetInput { groom: &groom, camera, size: TILE_SIZE, n_frames: 1 };
    match sheet::draw(&gpu, name, &input, watch) {
        Ok(Some(sheet)) => Done::Sheet { picture: sheet.picture() },
        Ok(None) => Done::Cancelled,
        Err(why) => failed(why.to_string()),
    }
}

/// Draw and write pictures from all around.
pub fn turntable(groom: &Groom, shown: &Shown, camera: &Camera, size: [u32; 2], path: &Path, watch: Watch<'_>) -> Done {
    match turntable::write_beside(groom, shown, camera, size, N_TURNTABLE, path, watch) {
        Ok(_) if watch.cancelled() => Done::Cancelled,
        Ok(written) => Done::TurntableSaved {
            n_pictures: written.len(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        },
        Err(why) => Done::Failed { title: "The turntable was not finished".to_owned(), why: why.to_string() },
    }
}

/// Pixels of a level's picture in the strip.
const STRIP_SIZE: [u32; 2] = [220, 220];

/// Draw every level of detail.
pub fn draw_levels(groom: &Groom, camera: Camera, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: "The levels could not be drawn".to_owned(), why };
    let mut stage = match LevelStage::new(groom, camera, STRIP_SIZE) {
        Ok(stage) => stage,
        Err(why) => return failed(why.to_string()),
    };
    let n = groom.lod.levels.len();
    let mut levels = Vec::with_capacity(n);
    for level in 0..n {
        if watch.cancelled() {
            return Done::Cancelled;
        }
        match stage.draw(level as f32) {
            Ok(drawn) => levels.push(drawn),
            Err(why) => return failed(why.to_string()),
        }
        watch.progress((level + 1) as f32 / n as f32);
    }
    Done::Levels { levels }
}

/// Find the level whose frames, of a picture's size, take so many milliseconds.
pub fn solve_level(groom: &Groom, camera: Camera, size: [u32; 2], target_ms: f32, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: "No level could be found".to_owned(), why };
    let mut stage = match LevelStage::new(groom, camera, size) {
        Ok(stage) => stage,
        Err(why) => return failed(why.to_string()),
    };
    let mut failure = None;
    let (level, ms) = groom.lod.solve(target_ms, |level| {
        if watch.cancelled() || failure.is_some() {
            return 0.0;
        }
        stage.draw(level).map_or_else(
            |why| {
                failure = Some(why);
                0.0
            },
            |drawn| drawn.ms,
        )
    });
    match failure {
        Some(why) => failed(why.to_string()),
        None if watch.cancelled() => Done::Cancelled,
        None => Done::Level { level, ms },
    }
}

/// Read a picture as a painted map.
pub fn load_map(path: &Path, kind: MapKind) -> Done {
    match picture::read_map(path, &kind) {
        Ok(map) => Done::MapLoaded { kind, map },
        Err(why) => Done::Failed { title: format!("Could not read {}", name_of(path)), why: why.to_string() },
    }
}

/// Write a painted map as a picture.
pub fn save_map(path: &Path, map: &ScalpMap, kind: &MapKind, picture_kind: Option<PictureKind>) -> Done {
    let written = picture_kind
        .ok_or_else(|| PictureError::Extension { path: path.to_owned() })
        .and_then(|picture_kind| picture::write_map(path, map, kind, picture_kind));
    match written {
        Ok(()) => Done::PictureSaved { path: path.to_owned() },
        Err(why) => Done::Failed { title: format!("Could not save {}", name_of(path)), why: why.to_string() },
    }
}

/// Generate all visible strands and write them for another program.
pub fn export(groom: &Groom, path: &Path, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: format!("Could not export {}", name_of(path)), why };
    // Making the strands is the first half of the bar, writing them the second.
    let half = |offset: f32| move |share: f32| watch.progress(offset + 0.5 * share);
    let (first, second) = (half(0.0), half(0.5));
    let watch_of = |on_progress| Watch { on_progress: Some(on_progress), cancel: watch.cancel };
    let Some(strands) = io::strands_of_watched(groom, io::What::Strands, watch_of(&first)) else {
        return Done::Cancelled;
    };
    match io::write_strands(path, &strands, WriteOptions::default(), watch_of(&second)) {
        Ok(notes) => Done::Exported { path: path.to_owned(), notes },
        Err(_) if watch.cancelled() => Done::Cancelled,
        Err(why) => failed(why.to_string()),
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
