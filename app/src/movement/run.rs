//! A solver taken through a course in frames of one length.

use lorelei_core::motion::HeadPose;
use lorelei_sim::Measure;

use super::solver::{On, Piece, Solver, SolverError};
use super::{Course, Shot, Subject};

/// Longest piece of a frame between two of the head's poses, seconds: in between the pose is interpolated, and a
/// film's 24 frames a second would cut the corners off a shake.
const LONGEST_PIECE_SECS: f64 = 1.0 / 60.0;
/// Steps that a piece may take: fewer than the solver's clock drops time beyond.
const STEPS_PER_PIECE: f64 = 48.0;

/// A simulation at a frame.
pub struct Run {
    solver: Solver,
    course: Course,
    fps: f32,
    frame_idx: u32,
    /// The course stands still from this frame on.
    ends_at: Option<u32>,
    n_steps: usize,
    ms: f64,
}

impl Run {
    /// At frame 0, at rest; `warm_up_secs` have passed in the pose and the air of time 0.
    pub fn start(on: On, subject: &Subject, course: Course, fps: f32, warm_up_secs: f32) -> Result<Self, SolverError> {
        let solver = Solver::new(on, subject, &course.settings_at(0.0), &course.pose(0.0))?;
        let mut run = Self { solver, course, fps, frame_idx: 0, ends_at: None, n_steps: 0, ms: 0.0 };
        let n_frames = (warm_up_secs * fps).round() as u32;
        for _ in 0..n_frames {
            run.pass(0.0, 0.0)?;
        }
        Ok(run)
    }

    /// Simulate up to the next frame.
    pub fn next_frame(&mut self) -> Result<(), SolverError> {
        let of_course = |frame_idx: u32| secs_of(self.ends_at.map_or(frame_idx, |end| end.min(frame_idx)), self.fps);
        self.pass(of_course(self.frame_idx), of_course(self.frame_idx + 1))?;
        self.frame_idx += 1;
        Ok(())
    }

    /// Let a frame's time pass while the course goes from one time to another.
    fn pass(&mut self, before: f64, after: f64) -> Result<(), SolverError> {
        let pieces = pieces(&self.course, self.fps, before, after, HeadPose::default());
        let (n_steps, ms) = self.solver.advance(&pieces)?;
        self.n_steps += n_steps;
        self.ms += ms;
        Ok(())
    }

    /// Let head and air stand still from a frame on, as they are then.
    pub fn end_course_at(&mut self, frame_idx: u32) {
        self.ends_at = Some(frame_idx);
    }

    pub fn frame_idx(&self) -> u32 {
        self.frame_idx
    }

    /// Time of the present frame.
    pub fn secs(&self) -> f64 {
        secs_of(self.frame_idx, self.fps)
    }

    /// Steps so far, and what one took.
    pub fn cost(&self) -> (usize, f64) {
        (self.n_steps, self.ms / self.n_steps.max(1) as f64)
    }

    pub fn measure(&self) -> Result<Measure, SolverError> {
        self.solver.measure()
    }

    /// The present frame.
    pub fn shot(&self) -> Result<Shot, SolverError> {
        let world_from_head = self.course.pose(self.secs() as f32);
        Ok(Shot { world_from_head, positions: self.solver.positions()? })
    }
}

/// Time of a frame.
pub fn secs_of(frame_idx: u32, fps: f32) -> f64 {
    f64::from(frame_idx) / f64::from(fps)
}

/// A frame's time cut into pieces, while the course goes from one time to another.
pub fn pieces(course: &Course, fps: f32, before: f64, after: f64, dragged: HeadPose) -> Vec<Piece> {
    let frame_secs = 1.0 / f64::from(fps);
    let n_steps = frame_secs * f64::from(course.settings.steps_per_second);
    // A thousandth is given, so that sixty frames a second are one piece each.
    let n = (frame_secs / LONGEST_PIECE_SECS - 1e-3).ceil().max((n_steps / STEPS_PER_PIECE).ceil()).clamp(1.0, 256.0);
    let piece = |piece_idx: u32| {
        let secs = (before + (after - before) * f64::from(piece_idx) / n) as f32;
        Piece {
            world_from_head: course.pose_with(secs, dragged),
            settings: course.settings_at(secs),
            secs: (frame_secs / n) as f32,
        }
    };
    (1..=n as u32).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;
    use lorelei_core::binding::LayerBinding;
    use lorelei_core::guides::GuideSet;
    use lorelei_core::motion::Motion;
    use lorelei_core::simulation::SimulationSettings;

    use super::*;

    /// Two strands that hang beside a head.
    pub fn two_strands() -> Subject {
        let strand = |x: f32| (0..8).map(move |k| Vec3::new(x, -2.0 * k as f32, 1.0));
        let guides = GuideSet { n_vertices: 8, positions: strand(-8.0).chain(strand(8.0)).collect() };
        let mut binding = LayerBinding::default();
        binding.guides = guides;
        Subject { bindings: vec![Arc::new(binding)], field: None }
    }

    fn shake() -> Course {
        Course { motion: Motion::Shake, neck: Vec3::NEG_Y * 8.0, settings: SimulationSettings::default() }
    }

    #[test]
    fn the_same_inputs_give_the_same_frames() {
        let frames = || {
            let mut run = Run::start(On::Cpu, &two_strands(), shake(), 24.0, 0.5).unwrap();
            let shots: Vec<Shot> = (0..24)
                .map(|_| {
                    run.next_frame().unwrap();
                    run.shot().unwrap()
                })
                .collect();
            assert_eq!(run.cost().0, 240 + 120, "steps of a second and of the warm-up");
            shots
        };
        let shots = frames();
        assert_ne!(shots[22], shots[23]);
        assert_eq!(frames(), shots);
    }

    #[test]
    fn no_frame_is_so_long_that_the_solver_drops_time() {
        let mut course = shake();
        course.settings.steps_per_second = 960.0;
        for fps in [1.0, 5.0, 24.0, 60.0, 120.0] {
            let pieces = pieces(&course, fps, 0.0, 1.0 / f64::from(fps), HeadPose::default());
            let secs: f32 = pieces.iter().map(|piece| piece.secs).sum();
            assert!((secs * fps - 1.0).abs() < 1e-4 && pieces.iter().all(|piece| piece.secs * 960.0 <= 64.0), "{fps}");
        }
        assert_eq!(pieces(&shake(), 60.0, 0.0, 1.0 / 60.0, HeadPose::default()).len(), 1);
    }
}
