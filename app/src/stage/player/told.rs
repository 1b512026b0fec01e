//! What the player tells: what is shown and where, how it came there, what is still to come.

use glam::{Affine3A, Vec4Swizzles};
use lorelei_core::moved::moved_vertices;
use lorelei_core::simulation::{Moved, Wind};
use lorelei_render::MovedLayer;
use lorelei_shaders::GpuError;
use lorelei_sim::wind::{AirGrid, FreeAir};

use super::Player;
use crate::movement::frames::Frames;
use crate::movement::key::key_of;
use crate::movement::{Shot, Subject};
use crate::stage::hold::Held;

impl Player {
    /// What of the hair is moved.
    pub fn moved(&self) -> Moved {
        self.inputs.moved
    }

    /// What the frames are made from.
    pub fn key(&self, subject: &Subject) -> u128 {
        key_of(subject, &self.inputs.score.course, &self.inputs.score.movement)
    }

    /// What of each layer is shown elsewhere than at rest on the head.
    pub fn moved_layers(&self) -> Vec<MovedLayer<'_>> {
        let shot = self.shot.as_ref();
        let solver = self.moving.as_ref().map(|moving| &moving.solver);
        let of_layer = |(layer_idx, n_shown): (usize, usize)| {
            let positions = match (shot, solver) {
                (Some(shot), _) => {
                    shot.layers.get(layer_idx).filter(|buffer| buffer.size() == (16 * n_shown as u64).max(16))
                }
                (None, Some(solver)) => (layer_idx < solver.n_layers()).then(|| solver.positions(layer_idx)),
                (None, None) => None,
            };
            match (positions, self.inputs.moved) {
                (None, _) => MovedLayer::Nothing,
                (Some(positions), Moved::Guides | Moved::Mesh | Moved::Rope) => MovedLayer::Guides(positions),
                (Some(positions), Moved::Strands) => {
                    MovedLayer::Strands { positions, n_vertices: moved_vertices(&self.inputs.layers[layer_idx].0) }
                }
            }
        };
        self.n_shown().enumerate().map(of_layer).collect()
    }

    /// Share of what moves that is prepared, while it is being prepared.
    pub fn made(&self) -> Option<f32> {
        self.maker.share()
    }

    /// What was being prepared is there to be taken.
    pub fn has_made(&self) -> bool {
        self.maker.has_made()
    }

    /// Frames until the one that was asked for, the warm-up's included.
    pub fn n_left(&self) -> u32 {
        let Some(wanted) = self.wanted else { return 0 };
        let (front, warm_up_left) = self
            .moving
            .as_ref()
            .map_or((self.inputs.score.movement.start, 0), |moving| (moving.front, moving.warm_up_left));
        warm_up_left + wanted.saturating_sub(front)
    }

    /// The air as it is drawn: the grid's of the last frame that was simulated, or free air where there is no grid; `None`
    /// where it is still. Waits for the GPU.
    pub fn air(&self) -> Result<Option<AirGrid>, GpuError> {
        let settings = &self.inputs.score.course.settings;
        let grid = self.moving.as_ref().and_then(|moving| moving.solver.air_grid());
        Ok(match (settings.wind, grid) {
            (Wind::Off, _) => None,
            (Wind::Grid, Some(grid)) => Some(grid.read_air()?),
            (Wind::Uniform | Wind::Grid, _) => Some(AirGrid::of_free(FreeAir::new(settings, self.now().1))),
        })
    }

    pub fn world_from_head(&self) -> Affine3A {
        self.shot.as_ref().map_or(self.world_from_head, |shot| shot.world_from_head)
    }

    /// What is shown, on the CPU: for whatever takes it over into the groom. `None` where hair is at rest.
    pub fn shot(&self) -> Result<Option<Shot>, GpuError> {
        if let Some(shot) = self.frames.get(self.at).filter(|_| self.shot.is_some()) {
            return Ok(Some(Shot::clone(shot)));
        }
        let Some(moving) = &self.moving else { return Ok(None) };
        let read = |layer_idx| {
            let positions = moving.solver.read_positions(layer_idx)?;
            Ok(positions.iter().map(|p| p.xyz()).collect())
        };
        let positions = (0..moving.solver.n_layers()).map(read).collect::<Result<_, GpuError>>()?;
        Ok(Some(Shot { world_from_head: self.world_from_head, positions }))
    }

    /// The frame that is shown, and its time.
    pub fn now(&self) -> (u32, f64) {
        (self.at, self.inputs.score.movement.secs_of(self.at))
    }

    pub fn frames(&self) -> &Frames {
        &self.frames
    }

    /// A frame was asked for and is still to be simulated.
    pub fn wanted(&self) -> Option<u32> {
        self.wanted
    }

    /// Playing has come to the end of the range and stays there.
    pub fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// What is shown now was made by hand and is not kept.
    pub fn is_by_hand(&self) -> bool {
        self.is_by_hand
    }

    /// Hair that a hand holds.
    pub fn held(&self) -> Option<Held> {
        self.hold.held()
    }
}
