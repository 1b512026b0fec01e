//! What is done with a movement as a whole: simulating its range in the background, its frames in files, and taking the hair
//! over into the groom as it is now.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::guides::GuideSet;
use lorelei_core::history::Merge;
use lorelei_core::io::Watch;
use lorelei_core::io::gltf_motion::{read_motions, track_of};
use lorelei_core::motion::PoseTrack;
use lorelei_core::moved::moved_vertices;
use lorelei_core::simulation::Moved;
use lorelei_render::Bound;
use lorelei_shaders::Gpu;

use super::Studio;
use super::desk::Selection;
use super::files::jobs::Done;
use super::notices::Severity;
use crate::movement::range::{Ranged, open, simulate_range};
use crate::movement::solver::On;
use crate::movement::{Course, Shot, Subject};

/// What becomes of the hair as it is now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeOver {
    /// It is where every layer rests.
    Rest,
    /// It is a layer of guides beside the selected one.
    Bake,
}

/// Between window and stage.
#[derive(Debug, Default)]
pub struct Takes {
    /// Frames for the stage to take over.
    pub offered: Option<Arc<Ranged>>,
    /// Times that the stage was asked where the hair is.
    pub n_shots: u64,
    wanted: Option<TakeOver>,
    /// Every moving node of the file that was loaded last.
    pub tracks: Vec<PoseTrack>,
}

impl Studio {
    /// Simulate the range in the background; where a path is given, into a file too.
    pub(super) fn simulate_range(&mut self, ctx: &egui::Context, path: Option<PathBuf>) {
        self.desk.playback.is_playing = false;
        let (groom, budget) = (self.desk.document.groom.clone(), self.frames_budget());
        let label = format!("Simulating frames {} to {}", groom.movement.start, groom.movement.end);
        let work = move |watch: Watch<'_>| simulate(&groom, budget, path.as_deref(), watch);
        self.jobs.start(ctx, label, work);
    }

    pub(super) fn open_frames(&mut self, ctx: &egui::Context, path: PathBuf) {
        let budget = self.frames_budget();
        self.jobs.start(ctx, "Reading frames", move |_| match open(&path, budget) {
            Ok(ranged) => Done::Ranged { ranged, path: Some(path) },
            Err(why) => Done::Failed { title: "The frames were not opened".to_owned(), why: why.to_string() },
        });
    }

    /// Read what moves in a file.
    pub(super) fn load_animation(&mut self, ctx: &egui::Context, path: PathBuf) {
        self.jobs.start(ctx, "Reading an animation", move |watch| match read_motions(&path, watch) {
            Ok(tracks) => Done::Animation { tracks },
            Err(why) => Done::Failed { title: "The animation was not loaded".to_owned(), why: why.to_string() },
        });
    }

    /// A file's animation has come: its head moves this one.
    pub(super) fn take_animation(&mut self, tracks: Vec<PoseTrack>) {
        match track_of(&tracks, None) {
            Ok(track) => self.desk.set_track(track),
            Err(why) => self.desk.notices.error("The animation was not loaded", why),
        }
        self.desk.takes.tracks = tracks;
    }

    pub(super) fn frames_budget(&self) -> usize {
        self.desk.settings.frames_mib as usize * (1 << 20)
    }

    /// Frames have come: the stage takes them over where they are of this groom.
    pub(super) fn take_frames(&mut self, ranged: Ranged, path: Option<&Path>) {
        // How many are kept is told by the strip and the panel, once the stage has them.
        let (title, text) = if ranged.is_whole {
            ("The range is simulated", "Play and scrub cost nothing now")
        } else {
            ("Part of the range is simulated", "The bright line at the strip's lower edge shows which frames are kept")
        };
        let mut text = text.to_owned();
        if let Some(path) = path {
            text = format!("{text}\n{}", path.display());
        }
        self.desk.notices.push(Severity::Info, title, text);
        self.desk.takes.offered = Some(Arc::new(ranged));
    }

    /// Ask where the hair is; [`Studio::took_over`] follows.
    pub(super) fn take_over(&mut self, how: TakeOver) {
        self.desk.playback.is_playing = false;
        self.desk.takes.n_shots += 1;
        self.desk.takes.wanted = Some(how);
    }

    /// The stage has said where the hair is.
    pub(super) fn took_over(&mut self, shot: Option<Arc<Shot>>) {
        let Some(how) = self.desk.takes.wanted.take() else { return };
        let Some(shot) = shot else {
            let text = "The hair is at rest already. Let it move first: Space plays, the strip below the viewport goes through time.";
            self.desk.notices.push(Severity::Info, "Nothing to take over", text);
            return;
        };
        let groom = &self.desk.document.groom;
        let selected = match self.desk.selection {
            Selection::Layer(layer_idx) => layer_idx,
            Selection::Head | Selection::Light(_) | Selection::Collider(_) | Selection::Pin(_) | Selection::Wind(_) => {
                0
            }
        };
        let edit = match how {
            TakeOver::Rest => rest_edit(groom, &shot),
            TakeOver::Bake => {
                let guides = guides_of(groom, &shot, selected).and_then(|guides| groom.baked(selected, &guides));
                let strands = || groom.baked_strands(selected, &strands_of(groom, &shot, selected)?);
                guides.or_else(strands)
            }
        };
        let Some(edit) = edit else {
            let text = if groom.simulation.moved == Moved::Strands {
                "Every strand has moved by itself, and guides do not know where that brings them. Bake it to a layer of strands, or let guides or the hair mesh move and play again."
            } else {
                "The groom has changed since the hair was simulated: play it again, then take it over."
            };
            self.desk.notices.push(Severity::Warning, "Nothing was taken over", text);
            return;
        };
        let label = match how {
            TakeOver::Rest => "Set current as rest",
            TakeOver::Bake => "Bake to guides",
        };
        self.desk.document.edit(label, edit, Merge::New);
        if how == TakeOver::Bake {
            self.desk.selection = Selection::Layer(self.desk.document.groom.layers.len() - 1);
        }
        // From here on it rests so.
        self.desk.playback.n_resets += 1;
        self.desk.measure();
    }
}

/// Strands of a layer in head space as a shot has them, where they were moved themselves.
fn strands_of(groom: &Groom, shot: &Shot, layer_idx: usize) -> Option<GuideSet> {
    let n_vertices = moved_vertices(groom.layers.get(layer_idx)?);
    let moved = shot.positions.get(layer_idx).filter(|moved| moved.len() % n_vertices as usize == 0)?;
    let head_from_world = shot.world_from_head.inverse();
    let positions = moved.iter().map(|p| head_from_world.transform_point3(*p)).collect();
    (groom.simulation.moved == Moved::Strands).then_some(GuideSet { n_vertices, positions })
}

/// Guides of a layer in head space as a shot has them.
fn guides_of(groom: &Groom, shot: &Shot, layer_idx: usize) -> Option<GuideSet> {
    let at_rest = match &groom.layers.get(layer_idx)?.source {
        Source::HairMesh(mesh) => GuideSet::of_chains(mesh, &mesh.chains()).0,
        Source::Guides(strands) | Source::Strands(strands) => GuideSet::of_strands(strands),
    };
    let moved = shot.positions.get(layer_idx).filter(|moved| moved.len() == at_rest.positions.len())?;
    let head_from_world = shot.world_from_head.inverse();
    let positions = moved.iter().map(|p| head_from_world.transform_point3(*p)).collect();
    Some(GuideSet { positions, ..at_rest })
}

/// Every layer rests where the shot has it. Layers that share a hair mesh move once.
fn rest_edit(groom: &Groom, shot: &Shot) -> Option<Edit> {
    let mut edits = Vec::new();
    let mut moved: Vec<usize> = Vec::new();
    for layer_idx in 0..groom.layers.len() {
        if groom.layers_sharing(layer_idx).iter().any(|other| moved.contains(other)) {
            continue;
        }
        edits.push(groom.rest_at(layer_idx, &guides_of(groom, shot, layer_idx)?)?);
        moved.push(layer_idx);
    }
    Some(Edit::Batch(edits))
}

fn simulate(groom: &Groom, budget: usize, path: Option<&Path>, watch: Watch<'_>) -> Done {
    let failed = |why: String| Done::Failed { title: "The range was not simulated".to_owned(), why };
    let Some(bound) = Bound::default().update(groom, Watch { on_progress: None, ..watch }) else {
        return Done::Cancelled;
    };
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(why) => return failed(why.to_string()),
    };
    let (subject, course) = (Subject::of(&bound, groom.simulation.moved), Course::of(groom));
    match simulate_range(On::Gpu(Box::new(gpu)), &subject, &course, &groom.movement, budget, path, watch) {
        Ok(ranged) => Done::Ranged { ranged, path: path.map(Path::to_owned) },
        Err(why) => failed(why.to_string()),
    }
}
