//! What the stage says about the picture that is seen, and what it cost.

use std::sync::Arc;
use std::time::Duration;

use lorelei_core::camera::Camera;
use lorelei_core::simulation::Moved;
use lorelei_render::inspect::Inspection;
use lorelei_sim::wind::AirGrid;

use super::binder::State;
use super::hold::Held;
use super::player::Player;
use super::shown::Shown;
use crate::movement::Shot;

/// What takes long right now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Busy {
    pub task: Task,
    /// Share that is done, where it is known.
    pub share: Option<f32>,
}

/// What the stage does that can take longer than a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    CompileShaders,
    /// What strands hang on.
    BindStrands,
    /// What a solver of every strand needs.
    PrepareEveryStrand,
    /// Frames on the way to one that was asked for.
    CatchUp,
}

impl Task {
    pub fn label(self) -> &'static str {
        match self {
            Self::CompileShaders => "Compiling shaders",
            Self::BindStrands => "Preparing strands",
            Self::PrepareEveryStrand => "Preparing every strand to move",
            Self::CatchUp => "Simulating up to the frame",
        }
    }

    /// What a cancel leads to, where there is one.
    pub fn after_cancel(self) -> Option<&'static str> {
        match self {
            Self::CompileShaders => None,
            Self::BindStrands => Some("Back to what is on screen"),
            Self::PrepareEveryStrand => Some("What moved before moves again"),
            Self::CatchUp => Some("Pause at the frame that it has come to"),
        }
    }
}

/// What will not come, because a person did not want to wait for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cancelled {
    /// The strands of this state.
    Strands(State),
    /// Every strand is not moved; this was, before.
    EveryStrand(Moved),
    /// A frame that was asked for.
    CatchUp,
}

/// How long the parts of the first picture took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StartTimes {
    /// Linking and compiling, beside the other parts.
    pub shaders: Duration,
    pub bind: Duration,
    /// What the driver still compiles when a shader is first used is in here.
    pub first_frame: Duration,
    /// From the start of the program to the first picture.
    pub picture: Duration,
    /// Of that, what was spent waiting for nothing but shaders.
    pub waited_for_shaders: Duration,
}

/// What is seen, and what it cost.
#[derive(Debug, Clone, Default)]
pub struct FrameReport {
    /// Frames drawn since the start.
    pub frame_idx: u64,
    /// The groom's state that was drawn.
    pub state: State,
    pub camera: Option<Camera>,
    pub size: [u32; 2],
    pub shown: Shown,
    /// What is under the pixel that was asked for last.
    pub inspection: Option<Inspection>,
    /// Share of the strands that was drawn.
    pub lod: f32,
    /// Each side of the picture was this many times smaller than asked for.
    pub coarseness: u32,
    pub texture: Option<wgpu::Texture>,
    /// GPU milliseconds by pass, of the newest frame that was timed.
    pub pass_times: Vec<(String, f32)>,
    /// Recording, and waiting until the GPU was done.
    pub frame_ms: f32,
    pub n_strands: u64,
    pub n_vertices: u64,
    pub n_bytes: u64,
    /// Of these, what turns strands into pixels, and what shadows are looked up in.
    pub n_drawing_bytes: u64,
    pub n_shadow_bytes: u64,
    /// Where on the timeline it is.
    pub timeline: Timeline,
    /// Hair that a hand holds.
    pub held: Option<Held>,
    /// The air of the last frame that was simulated, where it was asked for.
    pub air: Option<AirGrid>,
    /// Where the head was in the last picture.
    pub world_from_head: glam::Affine3A,
    pub adapter: String,
    /// What takes long right now, for the status bar.
    pub busy: Option<Busy>,
    /// A frame of full detail is being drawn, for longer than a moment.
    pub is_refining: bool,
    /// Nothing is left to do until another request.
    pub is_still: bool,
    /// What a person cancelled; handed out once.
    pub cancelled: Option<Cancelled>,
    pub start: StartTimes,
    /// What a person should know about the groom that was prepared since the last pick-up.
    pub warnings: Vec<String>,
    /// What went wrong since the last pick-up.
    pub errors: Vec<String>,
    /// The window's own GPU is gone; nothing more will be drawn.
    pub is_lost: bool,
    /// The stage's GPU was lost and another one taken, this many times.
    pub n_replaced: u32,
    /// Where the guides are, as it was asked for; `None` inside: at rest.
    pub shot: Option<(u64, Option<Arc<Shot>>)>,
    /// Pixels that were asked for: number of the request, size, straight RGBA.
    pub picture: Option<(u64, image::RgbaImage)>,
}

/// The timeline's present.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Timeline {
    /// The frame that is shown.
    pub at: u32,
    /// Its time.
    pub secs: f64,
    /// A frame that was asked for and is still being simulated.
    pub wanted: Option<u32>,
    /// Share of what moves that is prepared, while it is being prepared.
    pub made: Option<f32>,
    /// Frames until the one that was asked for, the warm-up's included.
    pub n_left: u32,
    /// Playing has come to the end and stays there.
    pub has_ended: bool,
    /// What is shown was made by hand, so that it is not kept.
    pub is_by_hand: bool,
    /// First and last of each run of kept frames.
    pub kept: Vec<[u32; 2]>,
    pub n_kept_bytes: usize,
    /// Simulated time over real time while it plays; 1 where the device keeps up.
    pub speed: f32,
}

impl Timeline {
    pub(super) fn of(player: &Player) -> Self {
        let (at, secs) = player.now();
        Self {
            at,
            secs,
            wanted: player.wanted(),
            made: player.made(),
            n_left: player.n_left(),
            has_ended: player.has_ended(),
            is_by_hand: player.is_by_hand(),
            kept: player.frames().runs().iter().map(|run| [*run.start(), *run.end()]).collect(),
            n_kept_bytes: player.frames().n_bytes(),
            speed: 1.0,
        }
    }
}
