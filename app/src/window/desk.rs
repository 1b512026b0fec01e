//! What every panel works on: the document, what is selected, where the camera is, what the stage reported.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::Vec3;
use lorelei_core::camera::Camera;
use lorelei_core::edit::Edit;
use lorelei_core::groom::Layer;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;
use lorelei_core::motion::{Motion, Movement, PoseTrack};
use lorelei_core::record::Macro;
use lorelei_core::simulation::Wind;

use super::commands::Command;
use super::document::Document;
use super::notices::Notices;
use super::panels::lod::LodPanel;
use super::room::Room;
use super::settings::Settings;
use super::takes::Takes;
use super::tools::Tools;
use super::wind_view::WindView;
use crate::stage::Playback;
use crate::stage::report::FrameReport;

/// What the properties panel shows and the layer commands act on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    Head,
    Layer(usize),
    Light(usize),
    /// Of the settings of movement.
    Collider(usize),
    /// Of the settings of movement.
    Pin(usize),
    /// A source of wind.
    Wind(usize),
}

/// GPU time of one frame by pass, for the plot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameTimes {
    pub passes: Vec<(String, f32)>,
}

/// How many frames the plot shows.
pub const N_FRAMES_KEPT: usize = 240;

/// The state that panels share.
pub struct Desk {
    pub document: Document,
    pub selection: Selection,
    pub camera: Camera,
    /// The camera is to show all as soon as the viewport's shape is known.
    pub wants_frame: bool,
    pub playback: Playback,
    /// What the head turns about, in head space.
    pub neck: Vec3,
    /// The box around head and hair at rest.
    pub bounds: (Vec3, Vec3),
    pub report: FrameReport,
    pub times: VecDeque<FrameTimes>,
    pub notices: Notices,
    pub settings: Settings,
    pub show_handles: bool,
    /// What of the wind is drawn over the picture.
    pub wind_view: WindView,
    pub tools: Tools,
    pub levels: LodPanel,
    /// Movements as a whole.
    pub takes: Takes,
    /// Looks beside each other, one term alone, the inspector.
    pub room: Room,
    /// Commands that panels ask for; run at the end of the frame.
    pub asked: Vec<Command>,
    /// What is being renamed in the outliner, and the text so far.
    pub renaming: Option<(Selection, String)>,
    /// The macro that is being recorded.
    pub recorder: Option<Macro>,
}

impl Default for Desk {
    /// Nothing is open, and the camera looks at a head's place.
    fn default() -> Self {
        Self {
            document: Document::default(),
            selection: Selection::Layer(0),
            camera: Camera::default(),
            wants_frame: false,
            playback: Playback::default(),
            neck: Vec3::ZERO,
            bounds: (Vec3::splat(-10.0), Vec3::splat(10.0)),
            report: FrameReport::default(),
            times: VecDeque::new(),
            notices: Notices::default(),
            settings: Settings::default(),
            show_handles: true,
            wind_view: WindView::new(),
            tools: Tools::default(),
            levels: LodPanel::default(),
            takes: Takes::default(),
            room: Room::default(),
            asked: Vec::new(),
            renaming: None,
            recorder: None,
        }
    }
}

impl Desk {
    /// The middle of head and hair: what lights turn about.
    pub fn centre(&self) -> Vec3 {
        0.5 * (self.bounds.0 + self.bounds.1)
    }

    /// Distance of light handles from the middle: around head and hair, and within what the camera sees.
    pub fn light_radius(&self, aspect: f32) -> f32 {
        let around = 0.62 * (self.bounds.1 - self.bounds.0).length();
        let half_height = self.camera.eye().distance(self.centre()) * (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        // Seen from the side, the sphere's outline is a little larger than its radius.
        around.min(0.86 * half_height * aspect.min(1.0)).max(1.0)
    }

    pub fn frame_all(&mut self, aspect: f32) {
        let bounds = self.bounds;
        self.camera.frame(bounds, aspect);
    }

    /// Bounds and neck of a document that was just opened or got another head.
    pub fn measure(&mut self) {
        self.bounds = crate::stage::bounds_of(&self.document.groom);
        self.neck = crate::stage::neck_of(&self.document.groom);
    }

    /// Another movement, from its beginning, and playing.
    pub fn set_motion(&mut self, motion: Motion) {
        self.playback.is_playing |= motion != Motion::None;
        if self.document.groom.movement.motion != motion {
            let movement = Movement { motion, ..self.document.groom.movement.clone() };
            self.set_movement(&format!("Movement: {}", motion.info().label), movement, Merge::New);
        }
    }

    /// Let keyed poses move the body; the range reaches to their end.
    pub fn set_track(&mut self, track: PoseTrack) {
        let before = self.document.groom.movement.bounded();
        let end = before.end.max(before.start + (track.secs() * before.fps).ceil() as u32);
        let label = format!("Animation: {}", track.name);
        let movement = Movement { track: Some(Arc::new(track)), end, ..before };
        self.set_movement(&label, movement, Merge::New);
        self.playback.is_playing = true;
    }

    /// Another timeline, as one step.
    pub fn set_movement(&mut self, label: &str, movement: Movement, merge: Merge) {
        self.document.edit(label, Edit::SetMovement(Box::new(movement)), merge);
    }

    /// Show a frame of the timeline.
    pub fn seek(&mut self, frame_idx: u32) {
        self.playback.is_playing = false;
        self.playback.seek(frame_idx);
    }

    /// The layer that is selected.
    pub fn selected_layer(&self) -> Option<&Layer> {
        match self.selection {
            Selection::Layer(layer_idx) => self.document.groom.layers.get(layer_idx),
            Selection::Head | Selection::Light(_) | Selection::Collider(_) | Selection::Pin(_) | Selection::Wind(_) => {
                None
            }
        }
    }

    /// There are sources of wind, and none blows: the air is chosen to be still.
    pub fn has_idle_sources(&self) -> bool {
        let simulation = &self.document.groom.simulation;
        simulation.wind == Wind::Off && !simulation.sources.is_empty()
    }

    pub fn clamp_selection(&mut self) {
        let groom = &self.document.groom;
        self.selection = match self.selection {
            Selection::Layer(i) if i >= groom.layers.len() => {
                // Where there is one that is seen, that: brushes and edits act on it.
                let seen = groom.layers.iter().rposition(|layer| layer.visible);
                seen.or(groom.layers.len().checked_sub(1)).map_or(Selection::Head, Selection::Layer)
            }
            Selection::Light(i) if i >= groom.lights.len() => {
                groom.lights.len().checked_sub(1).map_or(Selection::Head, Selection::Light)
            }
            Selection::Collider(i) if i >= groom.simulation.colliders.len() => {
                groom.simulation.colliders.len().checked_sub(1).map_or(Selection::Head, Selection::Collider)
            }
            Selection::Pin(i) if i >= groom.simulation.pins.len() => {
                groom.simulation.pins.len().checked_sub(1).map_or(Selection::Head, Selection::Pin)
            }
            Selection::Wind(i) if i >= groom.simulation.sources.len() => {
                groom.simulation.sources.len().checked_sub(1).map_or(Selection::Head, Selection::Wind)
            }
            kept => kept,
        };
    }

    /// Remember the GPU times of a frame for the plot.
    pub fn keep_times(&mut self, times: FrameTimes) {
        if self.times.len() == N_FRAMES_KEPT {
            self.times.pop_front();
        }
        self.times.push_back(times);
    }
}

/// How a change of a control goes into the history.
pub fn merge_of(drag: Option<u64>) -> Merge {
    drag.map_or(Merge::New, Merge::Drag)
}
