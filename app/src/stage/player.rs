//! Playing: which frame of the timeline is shown, and the solver that makes frames that were not there yet.
//!
//! Time goes in frames of the timeline. Frames that were simulated once from the first frame on are kept on the CPU
//! ([`Frames`]); going back to one shows it again, bit for bit. The solver stands at the newest frame. What a person changes
//! while it plays moves on from where the hair is: such frames are shown and not kept, until the movement begins again.

mod told;

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::motion::{AtEnd, HeadPose, Movement};
use lorelei_core::moved::{g_per_cm, n_moved};
use lorelei_core::simulation::{Moved, SimulationSettings};
use lorelei_shaders::{Gpu, GpuError, ShaderError};
use lorelei_sim::GpuSolver;
use lorelei_sim::gpu::TooMuchHair;

use super::hold::{Hold, Sight};
use super::inputs::{Inputs, Left};
use super::maker::{Gear, LayerHair, Maker, moved_on};
use super::{Playback, StageError};
use crate::movement::frames::Frames;
use crate::movement::run::pieces;
use crate::movement::{Course, Shot};

/// Frames that one call simulates at most on its way to a frame that was asked for: a picture in between keeps the window
/// answering.
const FRAMES_AT_ONCE: u32 = 12;
/// And at least, however long that takes: pictures in between take their time too.
const LEAST_AT_ONCE: u32 = 2;

/// Kept frames that there must be room for, for any to be kept: a second of film. Frames of every strand are large, and to
/// bring them to the CPU takes its time.
const FEWEST_FRAMES: usize = 24;

/// What a groom says about its movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    pub course: Course,
    pub movement: Movement,
}

/// The solver, and where on the timeline it stands.
struct Moving {
    solver: GpuSolver,
    settings: SimulationSettings,
    /// The frame that it has reached, once no warm-up is left.
    front: u32,
    warm_up_left: u32,
}

/// A [`Shot`] on the GPU.
struct ShotBuffers {
    world_from_head: Affine3A,
    layers: Vec<wgpu::Buffer>,
}

/// A frame on its way to the CPU.
struct Recorded {
    frame_idx: u32,
    world_from_head: Affine3A,
    layers: Vec<(usize, wgpu::Buffer)>,
}

/// The timeline's present.
pub struct Player {
    /// What the frames are made from.
    inputs: Inputs,
    /// What was, before every strand.
    moved_before: Moved,
    maker: Maker,
    moving: Option<Moving>,
    frames: Frames,
    /// And those of states that were left.
    left_frames: Left,
    /// Bytes that all of them may take.
    budget: usize,
    /// The frame that is shown.
    at: u32,
    /// Share of a frame that has passed since.
    left: f64,
    /// A frame that was asked for and is not simulated yet.
    wanted: Option<u32>,
    /// Frames that a call simulates on its way there.
    n_at_once: u32,
    /// Frames now are no function of time: they are not kept.
    is_by_hand: bool,
    has_ended: bool,
    /// A kept frame, where that is shown.
    shot: Option<ShotBuffers>,
    recorded: Vec<Recorded>,
    hold: Hold,
    /// Frames are made because time passes, and not to reach one that was asked for.
    plays: bool,
    world_from_head: Affine3A,
    n_steps: i64,
    n_resets: u64,
    n_seeks: u64,
}

impl Player {
    pub fn new() -> Self {
        let score =
            Score { course: Course::still(Vec3::ZERO, SimulationSettings::default()), movement: Movement::default() };
        Self {
            inputs: Inputs {
                score,
                layers: Vec::new(),
                moved: Moved::Guides,
                field: None,
                dragged: HeadPose::default(),
            },
            moved_before: Moved::Guides,
            maker: Maker::default(),
            moving: None,
            frames: Frames::default(),
            left_frames: Left::default(),
            budget: 0,
            at: 0,
            left: 0.0,
            wanted: None,
            n_at_once: FRAMES_AT_ONCE,
            is_by_hand: false,
            has_ended: false,
            shot: None,
            recorded: Vec::new(),
            hold: Hold::default(),
            plays: false,
            world_from_head: Affine3A::IDENTITY,
            n_steps: 0,
            n_resets: 0,
            n_seeks: 0,
        }
    }

    /// Keep frames up to so many bytes; 0: none.
    pub fn set_budget(&mut self, n_bytes: usize) {
        self.budget = n_bytes;
        self.make_room();
    }

    /// Take over what changed in the groom. What moves goes on where its guides are as many as before. Returns why something
    /// else is moved than was asked for.
    pub fn set_score(
        &mut self,
        gear: &Gear<'_>,
        layers: Vec<LayerHair>,
        score: Score,
    ) -> Result<Option<TooMuchHair>, StageError> {
        let (moved, too_much) = moved_on(gear.gpu, score.course.settings.moved, &layers);
        let inputs = Inputs { score, layers, moved, field: gear.field.cloned(), dragged: self.inputs.dragged };
        let before = std::mem::replace(&mut self.inputs, inputs);
        if before.moved != moved {
            self.moved_before = before.moved;
        }
        let has_same_curves = self.inputs.has_curves_of(&before);
        let has_same_ties = self.inputs.has_ties_of(&before);
        let has_same_masses = self.inputs.has_masses_of(&before);
        if has_same_curves && !has_same_masses {
            self.maker.set_masses(&self.inputs.layers);
            if let Some(moving) = &mut self.moving {
                for (layer_idx, layer) in self.inputs.layers.iter().enumerate() {
                    moving.solver.set_g_per_cm(layer_idx, g_per_cm(&layer.0, &layer.1));
                }
            }
        }
        if self.inputs.has_frames_of(&before) {
            return Ok(too_much);
        }
        let is_restarted = !self.inputs.score.movement.moves_like(&before.score.movement);
        let is_at_front = self.moving.as_ref().is_some_and(|moving| moving.front == self.at);
        let shown = self.shown_shots().filter(|_| self.shot.is_some() && !is_restarted && !is_at_front);
        self.leave(before);
        if !has_same_curves {
            self.hold.drop_hair();
        }
        if is_restarted {
            // Another motion, another time: begin again rather than go on in the middle of it.
            self.stop();
            self.wanted = Some(self.at).filter(|at| *at > self.inputs.score.movement.start);
        } else if self.moving.as_ref().is_some_and(|moving| moving.front != self.at) {
            self.stop();
        }
        if !has_same_curves || (!has_same_ties && self.inputs.moved == Moved::Strands) {
            self.maker.forget();
            if let Some(before) = self.moving.take() {
                let state = before.solver.read_state()?;
                // Hair that is as much as before takes over where that was; other hair begins at rest.
                self.moving = self.make_solver(gear, &self.world_from_head.clone())?.map(|mut next| {
                    next.solver.write_state(&state);
                    Moving { front: before.front, warm_up_left: before.warm_up_left, ..next }
                });
                self.wanted = self.maker.is_making().then_some(self.at);
            }
        } else if !has_same_ties {
            self.maker.set_ties(&self.inputs.layers);
            if let Some(moving) = &mut self.moving {
                for (layer_idx, hair) in self.maker.hair().iter().enumerate() {
                    moving.solver.set_ties(layer_idx, &hair.ties);
                }
            }
        }
        if let Some([shot, last]) = shown
            && self.moving.is_none()
        {
            // A kept frame is seen: the hair moves on from there.
            self.stand_at(gear, &shot, &last)?;
        }
        self.is_by_hand = self.moving.is_some();
        let is_shown = self.is_by_hand || self.shot.is_some();
        if is_shown && self.frames.get(self.at).is_some() {
            // Undo came back to frames that are kept: this one too is as it was.
            self.wanted = Some(self.at);
        }
        Ok(too_much)
    }

    /// Nothing moves any more.
    fn stop(&mut self) {
        if let Some(moving) = self.moving.take() {
            self.maker.put_back(moving.solver);
        }
    }

    /// Frames that were simulated elsewhere, with the same inputs.
    pub fn set_frames(&mut self, frames: Frames) {
        self.frames = frames;
        self.make_room();
        // A solver that stands at a frame of the same run goes on being of use.
        if self.is_by_hand {
            self.stop();
        }
        self.is_by_hand = false;
    }

    /// Other inputs than `before` have other frames: those that they had when they were left, if any.
    fn leave(&mut self, before: Inputs) {
        self.recorded.clear();
        let frames = self.left_frames.take(&self.inputs);
        let frames = frames.unwrap_or_else(|| Frames::new(self.inputs.score.movement.start));
        self.left_frames.keep(before, std::mem::replace(&mut self.frames, frames));
        self.make_room();
    }

    /// What is kept now has room before what was left.
    fn make_room(&mut self) {
        self.left_frames.make_room(self.budget.saturating_sub(self.frames.n_bytes()));
    }

    /// Let time pass as the playback says, recording what the solver has to do; true where the guides moved.
    pub fn pass(
        &mut self,
        gear: &Gear<'_>,
        playback: &Playback,
        sight: &Sight,
        dt_secs: f32,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<bool, StageError> {
        let Movement { start, end, fps, at_end, .. } = self.inputs.score.movement;
        let mut has_moved = false;
        if self.n_resets != playback.n_resets {
            self.n_resets = playback.n_resets;
            self.stop();
            (self.shot, self.wanted) = (None, None);
            (self.at, self.left, self.is_by_hand) = (start, 0.0, false);
            self.hold.drop_hair();
            has_moved = true;
        }
        let n_steps = playback.n_steps - std::mem::replace(&mut self.n_steps, playback.n_steps);
        if self.inputs.dragged != playback.head_pose {
            has_moved = true;
            self.drag(gear, playback)?;
        }
        if self.n_seeks != playback.n_seeks {
            self.n_seeks = playback.n_seeks;
            self.wanted = Some(playback.seek.max(start));
            self.left = 0.0;
        }
        if n_steps != 0 {
            let to = i64::from(self.wanted.unwrap_or(self.at)) + n_steps;
            self.wanted = Some(to.clamp(i64::from(start), i64::from(end.max(self.at))) as u32);
        }
        self.plays = playback.is_playing && self.wanted.is_none();
        self.hold(gear, playback, sight)?;
        if let Some(wanted) = self.wanted {
            self.go_to(gear, wanted, self.n_at_once, encoder)?;
            return Ok(true);
        }
        self.has_ended = false;
        if playback.is_playing {
            self.left += f64::from(dt_secs.max(0.0)) * f64::from(fps);
            // A thousandth is given, so that sixty pictures a second show sixty frames.
            let n = (self.left + 1e-3).floor().min(1e4);
            self.left = (self.left - n).max(0.0);
            let is_new = self.moving.is_none() && self.frames.get(self.at).is_none();
            if is_new {
                // Nothing is there to go on from: hair begins at the first frame.
                self.go_to(gear, start, 0, encoder)?;
                return Ok(true);
            }
            if n > 0.0 {
                let to = self.at + n as u32;
                let to = match at_end {
                    AtEnd::Stop => to.min(end.max(self.at)),
                    AtEnd::Loop if self.at >= end => start,
                    // However few pictures a slow device shows of a round, the last frame is among them.
                    AtEnd::Loop => to.min(end),
                    AtEnd::GoOn => to,
                };
                self.has_ended = at_end == AtEnd::Stop && to >= end;
                if to != self.at {
                    let is_here = self.moving.as_ref().is_some_and(|moving| moving.front == self.at);
                    self.go_to(gear, to, n as u32, encoder)?;
                    // Playing does not wait for frames that take too long; for the warm-up, and for a solver that is to
                    // come up to kept frames, it does.
                    let is_warm = self.moving.as_ref().is_some_and(|moving| moving.warm_up_left == 0);
                    self.wanted.take_if(|_| is_here && is_warm);
                }
                return Ok(true);
            }
            return Ok(has_moved);
        }
        self.left = 0.0;
        if self.moving.is_none() && self.shot.is_none() {
            let pose = self.pose_at(self.at);
            has_moved |= pose != self.world_from_head;
            self.world_from_head = pose;
        }
        Ok(has_moved)
    }

    /// The head is dragged: what moves goes on by hand; hair that does not is simply there too.
    fn drag(&mut self, gear: &Gear<'_>, playback: &Playback) -> Result<(), StageError> {
        let before = self.inputs.clone();
        self.inputs.dragged = playback.head_pose;
        if playback.is_playing && self.wanted.is_none() {
            if self.moving.as_ref().is_none_or(|moving| moving.front != self.at) {
                self.stand_at_shot(gear)?;
            }
            self.is_by_hand = self.moving.is_some();
        } else {
            self.stop();
            (self.shot, self.wanted) = (None, None);
            self.at = self.inputs.score.movement.start;
        }
        self.leave(before);
        Ok(())
    }

    /// A hand takes hold of hair, goes where the pointer is, or lets go. Its pull acts while it plays: what moves goes on by
    /// hand then, and the frames that are kept stay as they were without it.
    fn hold(&mut self, gear: &Gear<'_>, playback: &Playback, sight: &Sight) -> Result<(), StageError> {
        let hand = playback.hand.as_ref();
        if let Some(hand) = hand
            && self.hold.wants_grab(Some(hand))
        {
            self.stand_here(gear)?;
            let world_from_head = self.world_from_head();
            if let Some(moving) = &self.moving {
                self.hold.grab(hand, &moving.solver, gear.field.map(|field| &**field), &world_from_head, sight)?;
            }
        }
        self.hold.follow(hand, sight);
        if self.plays && self.hold.pull().is_some() {
            self.stand_here(gear)?;
            self.is_by_hand = true;
        }
        Ok(())
    }

    /// A solver at the frame that is shown.
    fn stand_here(&mut self, gear: &Gear<'_>) -> Result<(), StageError> {
        if self.moving.as_ref().is_some_and(|moving| moving.front == self.at && moving.warm_up_left == 0) {
            return Ok(());
        }
        self.stand_at_shot(gear)?;
        if self.moving.is_none() && !self.inputs.layers.is_empty() {
            self.moving = self.make_solver(gear, &self.pose_at(self.at))?;
            self.shot.take_if(|_| self.moving.is_some());
        }
        // It has not come here from the first frame.
        self.is_by_hand = self.moving.is_some();
        Ok(())
    }

    /// A solver that goes on from the kept frame that is shown, with the speed that the two last frames show.
    fn stand_at_shot(&mut self, gear: &Gear<'_>) -> Result<(), StageError> {
        self.stop();
        match self.shown_shots() {
            Some([shot, last]) => self.stand_at(gear, &shot, &last),
            None => Ok(()),
        }
    }

    /// The kept frame that is shown, and the one before; the first is its own.
    fn shown_shots(&self) -> Option<[Arc<Shot>; 2]> {
        let shot = self.frames.get(self.at)?;
        let last = self.at.checked_sub(1).and_then(|at| self.frames.get(at)).unwrap_or(shot);
        Some([Arc::clone(shot), Arc::clone(last)])
    }

    /// A solver whose hair is at a frame, and goes as it did from the `last` one to there.
    fn stand_at(&mut self, gear: &Gear<'_>, shot: &Shot, last: &Shot) -> Result<(), StageError> {
        let Some(mut moving) = self.make_solver(gear, &shot.world_from_head)? else { return Ok(()) };
        let steps_per_frame = self.inputs.score.course.settings.steps_per_second / self.inputs.score.movement.fps;
        let layers = self.maker.hair().iter().zip(&shot.positions).enumerate();
        // Other hair than was shown begins at rest.
        let layers = layers.filter(|(_, (hair, shown))| !shown.is_empty() && shown.len() == hair.n_shown());
        for (layer_idx, (hair, shown)) in layers {
            let last = last.positions.get(layer_idx).unwrap_or(shown);
            let (x, last) = (hair.curves_of(shown), hair.curves_of(last));
            let prev: Vec<Vec3> = x.iter().zip(last).map(|(x, last)| *x - (*x - last) / steps_per_frame).collect();
            moving.solver.set_state(layer_idx, &x, &prev);
        }
        moving.front = self.at;
        self.shot = None;
        self.moving = Some(moving);
        Ok(())
    }

    /// Show a frame; where it is not kept, simulate towards it, `n_most` frames now.
    fn go_to(
        &mut self,
        gear: &Gear<'_>,
        to: u32,
        n_most: u32,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), StageError> {
        self.wanted = None;
        // Hair that is moved on by hand is not where the kept frame has it.
        let goes_on = self.plays && self.is_by_hand && self.moving.as_ref().is_some_and(|moving| moving.front <= to);
        if let Some(shot) = self.frames.get(to).filter(|_| !goes_on) {
            let shot = Arc::clone(shot);
            if std::mem::take(&mut self.is_by_hand) {
                self.stop();
            }
            self.show(gear.gpu, &shot);
            self.at = to;
            return Ok(());
        }
        self.stand_before(gear, to, encoder)?;
        let Some(moving) = &self.moving else {
            if self.maker.is_making() {
                self.wanted = Some(to);
                return Ok(());
            }
            // There is no hair: time passes all the same.
            self.at = to;
            self.world_from_head = self.pose_at(to);
            return Ok(());
        };
        let n_due = moving.warm_up_left + (to - moving.front);
        for _ in 0..n_due.min(n_most) {
            self.simulate_frame(gear, encoder)?;
        }
        self.shot = None;
        if let Some(moving) = &self.moving {
            self.at = moving.front;
            self.wanted = (moving.front < to || moving.warm_up_left > 0).then_some(to);
        }
        self.world_from_head = self.pose_at(self.at);
        Ok(())
    }

    /// Show a frame, whatever the solver has.
    pub fn show(&mut self, gpu: &Gpu, shot: &Shot) {
        let buffer = |positions: &Vec<Vec3>| {
            let positions: Vec<Vec4> = positions.iter().map(|p| p.extend(0.0)).collect();
            gpu.buffer_of("stage.shot", &positions, wgpu::BufferUsages::STORAGE)
        };
        self.world_from_head = shot.world_from_head;
        self.shot = Some(ShotBuffers {
            world_from_head: shot.world_from_head,
            layers: shot.positions.iter().map(buffer).collect(),
        });
    }

    /// A solver at a frame from which `to` can be reached: the one that is there, one from a kept state, or one at rest at
    /// the first frame.
    fn stand_before(&mut self, gear: &Gear<'_>, to: u32, encoder: &mut wgpu::CommandEncoder) -> Result<(), StageError> {
        let kept = self.frames.state_before(to).map_or(0, |(front, _)| front);
        let is_near = |moving: &Moving| moving.front <= to && moving.front >= kept;
        if self.inputs.layers.is_empty() || self.moving.as_ref().is_some_and(is_near) {
            return Ok(());
        }
        self.is_by_hand = false;
        let start = self.inputs.score.movement.start;
        self.stop();
        let Some(mut moving) = self.make_solver(gear, &self.pose_at(start))? else { return Ok(()) };
        if let Some((front, state)) = self.frames.state_before(to)
            && moving.solver.write_state(state)
        {
            moving.front = front;
            self.moving = Some(moving);
            return Ok(());
        }
        let warm_up_left = (self.inputs.score.movement.warm_up_secs * self.inputs.score.movement.fps).round() as u32;
        (moving.front, moving.warm_up_left) = (start, warm_up_left);
        self.moving = Some(moving);
        self.record(gear, encoder);
        Ok(())
    }

    /// A solver at rest; `None` while it is still being made.
    fn make_solver(&mut self, gear: &Gear<'_>, world_from_head: &Affine3A) -> Result<Option<Moving>, ShaderError> {
        let settings = self.inputs.score.course.settings.clone();
        let Some(mut solver) = self.maker.make(gear, &self.inputs.layers, self.inputs.moved, &settings)? else {
            return Ok(None);
        };
        solver.set_head_pose(world_from_head);
        solver.reset();
        Ok(Some(Moving { solver, settings, front: self.at, warm_up_left: 0 }))
    }

    /// Record the solver's way to the next frame.
    fn simulate_frame(&mut self, gear: &Gear<'_>, encoder: &mut wgpu::CommandEncoder) -> Result<(), StageError> {
        let pull = self.hold.pull().filter(|_| self.plays);
        self.is_by_hand |= pull.is_some();
        let Score { course, movement } = &self.inputs.score;
        let Some(moving) = &mut self.moving else { return Ok(()) };
        moving.solver.set_pull(pull);
        let before = movement.secs_of(moving.front);
        let after = if moving.warm_up_left > 0 { before } else { movement.secs_of(moving.front + 1) };
        for piece in pieces(course, movement.fps, before, after, self.inputs.dragged) {
            if moving.settings != piece.settings {
                moving.solver.set_settings(&piece.settings)?;
                moving.settings.clone_from(&piece.settings);
            }
            moving.solver.set_head_pose(&piece.world_from_head);
            moving.solver.advance(encoder, piece.secs)?;
        }
        match moving.warm_up_left.checked_sub(1) {
            Some(left) => moving.warm_up_left = left,
            None => moving.front += 1,
        }
        self.record(gear, encoder);
        Ok(())
    }

    /// Let the solver's frame be brought to the CPU, where it is to be kept.
    fn record(&mut self, gear: &Gear<'_>, encoder: &mut wgpu::CommandEncoder) {
        let Some(moving) = &self.moving else { return };
        let frame_idx = moving.front;
        let is_in_range = frame_idx <= self.inputs.score.movement.end && moving.warm_up_left == 0;
        let n_vertices: usize = self.n_shown().sum();
        let n_bytes = n_vertices * size_of::<Vec3>();
        let has_room = self.frames.n_bytes() < self.budget && n_bytes * FEWEST_FRAMES <= self.budget;
        if self.is_by_hand || !is_in_range || !has_room || self.frames.get(frame_idx).is_some() {
            return;
        }
        let layers = self.n_shown().enumerate().map(|(layer_idx, n_vertices)| {
            let size = (16 * n_vertices as u64).max(16);
            let staging = gear.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage.recorded"),
                size,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            encoder.copy_buffer_to_buffer(moving.solver.positions(layer_idx), 0, &staging, 0, size);
            (n_vertices, staging)
        });
        let layers = layers.collect();
        self.recorded.push(Recorded { frame_idx, world_from_head: self.pose_at(frame_idx), layers });
    }

    /// Let the held hair's place be brought to the CPU.
    pub fn record_held(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        if let Some(moving) = self.moving.as_ref().filter(|_| self.shot.is_none()) {
            self.hold.record(gpu, &moving.solver, encoder);
        }
    }

    /// Keep the frames that were recorded; the commands were submitted, and are done.
    pub fn collect(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        for recorded in std::mem::take(&mut self.recorded) {
            let read = |(n_vertices, staging): &(usize, wgpu::Buffer)| {
                gpu.read_mapped(staging, |bytes| {
                    let positions: Vec<Vec4> = bytemuck::pod_collect_to_vec(bytes);
                    positions[..*n_vertices].iter().map(|p| p.xyz()).collect::<Vec<Vec3>>()
                })
            };
            let positions = recorded.layers.iter().map(read).collect::<Result<_, _>>()?;
            let shot = Shot { world_from_head: recorded.world_from_head, positions };
            self.frames.keep(recorded.frame_idx, Arc::new(shot), self.budget);
            self.make_room();
        }
        self.hold.collect(gpu)
    }

    fn pose_at(&self, frame_idx: u32) -> Affine3A {
        let secs = self.inputs.score.movement.secs_of(frame_idx);
        self.inputs.score.course.pose_with(secs as f32, self.inputs.dragged)
    }

    /// Vertices of what is shown of each layer: guides, or strands.
    fn n_shown(&self) -> impl Iterator<Item = usize> {
        self.inputs.layers.iter().map(|(layer, binding)| n_moved(self.inputs.moved, layer, binding))
    }

    /// Do not wait for what is being prepared: nothing moves until something else is to be moved. Returns what moved before.
    pub fn give_up_making(&mut self) -> Moved {
        self.maker.give_up();
        self.moved_before
    }

    /// Stay at the frame that is shown, whichever was asked for.
    pub fn stay(&mut self) {
        self.wanted = None;
    }

    /// On the way to a frame that was asked for, the next picture may take so many times as long as the last one.
    pub fn simulate_within(&mut self, ratio: f32) {
        self.n_at_once = ((self.n_at_once as f32 * ratio) as u32).clamp(LEAST_AT_ONCE, FRAMES_AT_ONCE);
    }
}
