//! A solver taken through a course in frames of one length.

use lorelei_core::motion::{HeadPose, Movement};
use lorelei_sim::{Measure, SolverState};

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
    movement: Movement,
    frame_idx: u32,
    /// The course stands still from this frame on.
    ends_at: Option<u32>,
    n_steps: usize,
    ms: f64,
}

impl Run {
    /// At the first frame, at rest; the warm-up has passed in the pose and the air of that frame.
    pub fn start(on: On, subject: &Subject, course: Course, movement: &Movement) -> Result<Self, SolverError> {
        let movement = movement.bounded();
        let first_secs = movement.secs_of(movement.start);
        let settings = course.settings_at(first_secs as f32);
        let solver = Solver::new(on, subject, &settings, &course.pose(first_secs as f32))?;
        let frame_idx = movement.start;
        let mut run = Self { solver, course, movement, frame_idx, ends_at: None, n_steps: 0, ms: 0.0 };
        let n_frames = (run.movement.warm_up_secs * run.movement.fps).round() as u32;
        for _ in 0..n_frames {
            run.pass(first_secs, first_secs)?;
        }
        Ok(run)
    }

    /// Simulate up to the next frame.
    pub fn next_frame(&mut self) -> Result<(), SolverError> {
        self.pass(self.course_secs(self.frame_idx), self.course_secs(self.frame_idx + 1))?;
        self.frame_idx += 1;
        Ok(())
    }

    /// Where in its course a frame is, seconds.
    fn course_secs(&self, frame_idx: u32) -> f64 {
        self.movement.secs_of(self.ends_at.map_or(frame_idx, |end| end.min(frame_idx)))
    }

    /// Let a frame's time pass while the course goes from one time to another.
    fn pass(&mut self, before: f64, after: f64) -> Result<(), SolverError> {
        let pieces = pieces(&self.course, self.movement.fps, before, after, HeadPose::default());
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
        self.movement.secs_of(self.frame_idx)
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
        let world_from_head = self.course.pose(self.course_secs(self.frame_idx) as f32);
        Ok(Shot { world_from_head, positions: self.solver.positions()? })
    }

    /// Everything that the next frame follows from, beside its number.
    pub fn read_state(&self) -> Result<SolverState, SolverError> {
        self.solver.read_state()
    }

    /// Go on from a frame; false where the state is of other guides.
    pub fn go_on_from(&mut self, frame_idx: u32, state: &SolverState) -> bool {
        let fits = self.solver.write_state(state);
        if fits {
            self.frame_idx = frame_idx;
        }
        fits
    }
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
pub mod tests {
    use glam::Vec3;
    use lorelei_core::guides::GuideSet;
    use lorelei_core::motion::Motion;
    use lorelei_core::moved::MovedHair;
    use lorelei_core::simulation::SimulationSettings;

    use super::*;

    /// Two strands that hang beside a head.
    pub fn two_strands() -> Subject {
        let strand = |x: f32| (0..8).map(move |k| Vec3::new(x, -2.0 * k as f32, 1.0));
        let guides = GuideSet { n_vertices: 8, positions: strand(-8.0).chain(strand(8.0)).collect() };
        Subject { hair: vec![MovedHair { curves: guides, ..MovedHair::default() }], field: None }
    }

    pub fn shake() -> Course {
        Course { motion: Motion::Shake, ..Course::still(Vec3::NEG_Y * 8.0, SimulationSettings::default()) }
    }

    fn film(warm_up_secs: f32) -> Movement {
        Movement { fps: 24.0, warm_up_secs, ..Movement::default() }
    }

    #[test]
    fn the_same_inputs_give_the_same_frames_and_a_kept_state_goes_on_with_them() {
        let subject = two_strands();
        let mut run = Run::start(On::Cpu, &subject, shake(), &film(0.5)).unwrap();
        let mut shots = Vec::new();
        let mut state = None;
        for _ in 0..24 {
            run.next_frame().unwrap();
            shots.push(run.shot().unwrap());
            if run.frame_idx() == 12 {
                state = Some(run.read_state().unwrap());
            }
        }
        assert_eq!(run.cost().0, 240 + 120, "steps of a second and of the warm-up");
        assert_ne!(shots[22], shots[23]);
        let mut again = Run::start(On::Cpu, &subject, shake(), &film(0.0)).unwrap();
        assert!(again.go_on_from(12, &state.unwrap()));
        for shot in &shots[12..] {
            again.next_frame().unwrap();
            assert_eq!(again.shot().unwrap(), *shot);
        }
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
