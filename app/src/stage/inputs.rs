//! What frames of a movement follow from, and the kept frames of states that were left: undo comes back to them.

use std::collections::VecDeque;
use std::sync::Arc;

use lorelei_core::distance_field::DistanceField;
use lorelei_core::motion::HeadPose;
use lorelei_core::moved::{g_per_cm, moved_vertices};
use lorelei_core::simulation::{Moved, Wind};

use super::maker::LayerHair;
use super::player::Score;
use crate::movement::frames::Frames;

/// States besides the present one whose frames are kept.
const MOST_STATES: usize = 6;

/// Everything that decides how frames are. Where two are alike, the frames are the same bit for bit.
#[derive(Clone)]
pub struct Inputs {
    pub score: Score,
    pub layers: Vec<LayerHair>,
    /// What is moved of them.
    pub moved: Moved,
    /// Of the head.
    pub field: Option<Arc<DistanceField>>,
    /// Where the head was dragged to.
    pub dragged: HeadPose,
}

impl Inputs {
    /// What is moved is the same, among the same obstacles.
    pub fn has_curves_of(&self, other: &Self) -> bool {
        let has_same_head = match (&self.field, &other.field) {
            (Some(field), Some(other)) => Arc::ptr_eq(field, other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        has_same_head && self.moved == other.moved && self.all(other, |a, b| moves_alike(self.moved, a, b))
    }

    /// It is held to the style in the same way.
    pub fn has_ties_of(&self, other: &Self) -> bool {
        self.all(other, |(_, a), (_, b)| Arc::ptr_eq(a, b) || a.guide_ties() == b.guide_ties())
    }

    /// It is as much hair.
    pub fn has_masses_of(&self, other: &Self) -> bool {
        let mass_of = |(layer, binding): &LayerHair| g_per_cm(layer, binding);
        self.all(other, |a, b| mass_of(a) == mass_of(b))
    }

    pub fn has_frames_of(&self, other: &Self) -> bool {
        self.score.course == other.score.course
            && self.score.movement.moves_like(&other.score.movement)
            && self.dragged == other.dragged
            && (self.score.course.settings.wind != Wind::Grid || self.has_masses_of(other))
            && self.has_ties_of(other)
            && self.has_curves_of(other)
    }

    fn all(&self, other: &Self, is_alike: impl Fn(&LayerHair, &LayerHair) -> bool) -> bool {
        self.layers.len() == other.layers.len() && self.layers.iter().zip(&other.layers).all(|(a, b)| is_alike(a, b))
    }
}

/// Whether what is moved of a layer is the same.
fn moves_alike(moved: Moved, (layer, binding): &LayerHair, (other_layer, other): &LayerHair) -> bool {
    match moved {
        Moved::Guides | Moved::Mesh | Moved::Rope => Arc::ptr_eq(binding, other) || binding.guides == other.guides,
        Moved::Strands => {
            layer.style == other_layer.style
                && layer.has_same_sculpt(other_layer)
                && moved_vertices(layer) == moved_vertices(other_layer)
                && (Arc::ptr_eq(binding, other) || binding == other)
        }
    }
}

/// Frames of states that were left, the newest last.
#[derive(Default)]
pub struct Left {
    states: VecDeque<(Inputs, Frames)>,
}

impl Left {
    /// Keep the frames of a state that is left; of too many the oldest go.
    pub fn keep(&mut self, inputs: Inputs, frames: Frames) {
        if frames.n_bytes() == 0 {
            return;
        }
        if self.states.len() == MOST_STATES {
            self.states.pop_front();
        }
        self.states.push_back((inputs, frames));
    }

    /// The frames of a state that is come back to.
    pub fn take(&mut self, inputs: &Inputs) -> Option<Frames> {
        let at = self.states.iter().position(|(known, _)| known.has_frames_of(inputs))?;
        self.states.remove(at).map(|(_, frames)| frames)
    }

    /// Let the oldest go until the rest takes no more than so many bytes.
    pub fn make_room(&mut self, n_bytes: usize) {
        while self.states.iter().map(|(_, frames)| frames.n_bytes()).sum::<usize>() > n_bytes {
            self.states.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};
    use lorelei_core::motion::Movement;
    use lorelei_core::simulation::SimulationSettings;

    use super::*;
    use crate::movement::{Course, Shot};

    fn inputs(gravity: f32) -> Inputs {
        let settings = SimulationSettings { gravity, ..SimulationSettings::default() };
        let score = Score { course: Course::still(Vec3::ZERO, settings), movement: Movement::default() };
        Inputs { score, layers: Vec::new(), moved: Moved::Guides, field: None, dragged: HeadPose::default() }
    }

    fn frames() -> Frames {
        let shot = Shot { world_from_head: Affine3A::IDENTITY, positions: vec![vec![Vec3::ZERO; 10]] };
        let mut frames = Frames::new(0);
        frames.keep(0, Arc::new(shot), usize::MAX);
        frames
    }

    #[test]
    fn frames_of_the_last_states_come_back_once_and_the_oldest_go_first() {
        let mut left = Left::default();
        left.keep(inputs(0.0), Frames::new(0));
        assert!(left.take(&inputs(0.0)).is_none(), "there were none");
        for i in 0..=MOST_STATES {
            left.keep(inputs(i as f32), frames());
        }
        assert!(left.take(&inputs(0.0)).is_none(), "one too many");
        assert!(left.take(&inputs(3.0)).is_some() && left.take(&inputs(3.0)).is_none());
        left.make_room(2 * frames().n_bytes());
        let has = |left: &mut Left, i: usize| left.take(&inputs(i as f32)).is_some();
        assert!(!has(&mut left, MOST_STATES - 2) && has(&mut left, MOST_STATES - 1) && has(&mut left, MOST_STATES));
    }

    #[test]
    fn another_head_gives_other_frames() {
        let field = || Some(Arc::new(DistanceField { min: Vec3::ZERO, cell: 1.0, n: [1; 3], values: vec![0.0] }));
        let with = Inputs { field: field(), ..inputs(1.0) };
        assert!(with.has_frames_of(&with.clone()) && inputs(1.0).has_frames_of(&inputs(1.0)));
        assert!(!with.has_frames_of(&inputs(1.0)) && !inputs(1.0).has_frames_of(&with));
        assert!(!with.has_frames_of(&Inputs { field: field(), ..inputs(1.0) }));
    }
}
