//! The work of the stage's thread: what comes on stage when, and with how much detail it is drawn.
//!
//! A groom whose strands must be bound first is bound on a further thread ([`super::binder`]); until then the groom before
//! it is drawn. While something moves and frames are slow, frames have less detail ([`super::pacer`]); once all is still,
//! one frame with all of it.

use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use lorelei_core::groom::Groom;
use lorelei_render::Bound;
use lorelei_render::inspect::Inspection;
use lorelei_shaders::Gpu;

use super::binder::{Binder, Binding, State};
use super::display::Display;
use super::pacer::Pacer;
use super::report::{Busy, Cancelled, FrameReport, StartTimes, Task, Timeline};
use super::shown::Shown;
use super::thread::{FrameRequest, Shared, StageGpu};
use super::{Stage, StageError};
use crate::movement::range::Ranged;

/// On stage while a preview of a document is, instead of one of its own states.
const PREVIEW: u64 = u64::MAX;

/// Longest time that one frame moves the hair on: after a stall it goes on from where it was.
const LONGEST_FRAME_SECS: f32 = 0.1;
const OTHER_FRAMES: &str = "the frames are of another movement, another head or other hair than this groom has now: simulate the range again, or undo what was changed";
/// Over how long the pace of movement is told, seconds.
const PACE_SECS: f32 = 2.0;
/// A full frame is announced once the last one took longer than this.
const ANNOUNCED_MS: f32 = 500.0;
/// On the way to a frame that was asked for, pictures are to come as often as this, where simulating
/// them is what takes long: a cancel acts between two of them.
const CATCH_UP_MS: f32 = 1000.0;
/// Until the next look how far what moves is prepared.
const LOOK_FOR_SOLVER: Duration = Duration::from_millis(50);

/// Between two looks at the shaders' files, where somebody edits them and nothing else is to be drawn.
const LOOK_FOR_SHADERS: Duration = Duration::from_millis(300);

/// What wakes the thread.
enum Event {
    /// Draw; whether something else is asked for than was drawn last.
    Draw(Box<FrameRequest>, bool),
    Bound(Box<Binding>),
    Cancel,
    End,
}

/// A stage that is there, or that another thread is making.
enum Making {
    Ready(Box<Stage>),
    Compiling(std::thread::JoinHandle<(Result<Stage, StageError>, Duration)>),
    Failed,
}

pub(super) struct Worker {
    shared: Arc<Shared>,
    gpu: StageGpu,
    stage: Making,
    pacer: Pacer,
    binder: Option<Binder>,
    /// What the newest groom is bound to; it outlives the GPU.
    bound: Bound,
    /// The groom on the stage; `None` before the first.
    on_stage: Option<State>,
    /// Share of the strands, while a preview is on stage.
    preview: Option<f32>,
    /// Cancelled, or too large: not tried again.
    refused: Option<State>,
    /// Whose binding ended without a result.
    ended_early: Option<State>,
    seen: u64,
    drawn: Option<FrameRequest>,
    /// A frame of the timeline was asked for that is still to be simulated: since when, and how many frames it was away.
    catching_up: Option<(Instant, u32)>,
    /// What moves is being prepared.
    is_making: bool,
    /// What was offered last, and whether that was told already.
    offered: Option<Arc<Ranged>>,
    n_shots: u64,
    /// Simulated and real seconds while it plays, of late.
    pace: [f32; 2],
    n_losses: u64,
    start: StartTimes,
}

impl Worker {
    pub(super) fn new(shared: Arc<Shared>, gpu: StageGpu) -> Self {
        let is_software = gpu.window.adapter_info.device_type == wgpu::DeviceType::Cpu;
        let mut worker = Self {
            shared,
            gpu,
            stage: Making::Failed,
            pacer: Pacer::new(is_software),
            binder: None,
            bound: Bound::default(),
            on_stage: None,
            preview: None,
            refused: None,
            ended_early: None,
            seen: 0,
            drawn: None,
            catching_up: None,
            is_making: false,
            offered: None,
            n_shots: 0,
            pace: [0.0; 2],
            n_losses: 0,
            start: StartTimes::default(),
        };
        worker.start_compiling();
        worker
    }

    fn start_compiling(&mut self) {
        let display = Display::new(self.gpu.window.clone(), self.gpu.has_own);
        let own = (!self.gpu.has_own).then(|| self.gpu.window.clone());
        let made = std::thread::Builder::new().name("shaders".to_owned()).spawn(move || {
            let start = Instant::now();
            let gpu = own.map_or_else(Gpu::headless, Ok).map_err(StageError::from);
            let stage = gpu.and_then(|gpu| Stage::for_display(gpu, display));
            (stage, start.elapsed())
        });
        self.stage = match made {
            Ok(thread) => Making::Compiling(thread),
            Err(why) => {
                self.shared.publish(|report| report.errors.push(why.to_string()));
                Making::Failed
            }
        };
        let adapter = self.gpu.window.adapter_info.name.clone();
        self.shared.publish(|report| {
            report.adapter = adapter;
            report.busy = Some(Busy { task: Task::CompileShaders, share: None });
        });
    }

    /// The stage, once its shaders are compiled; `None` where that failed.
    fn stage(&mut self) -> Option<&mut Stage> {
        if matches!(self.stage, Making::Compiling(_)) {
            let start = Instant::now();
            let Making::Compiling(thread) = std::mem::replace(&mut self.stage, Making::Failed) else { return None };
            let made = thread.join();
            self.start.waited_for_shaders = start.elapsed();
            match made {
                Ok((Ok(stage), shaders)) => {
                    self.start.shaders = shaders;
                    let adapter = stage.adapter_name();
                    self.shared.publish(|report| report.adapter = adapter);
                    self.stage = Making::Ready(Box::new(stage));
                }
                Ok((Err(why), _)) => self.fail(&why.to_string()),
                Err(_) => self.fail("compiling the shaders ended without an answer: a bug"),
            }
        }
        match &mut self.stage {
            Making::Ready(stage) => Some(stage),
            Making::Compiling(_) | Making::Failed => None,
        }
    }

    fn fail(&self, why: &str) {
        self.shared.publish(|report| {
            report.busy = None;
            report.is_still = true;
            report.errors.push(why.to_owned());
        });
    }

    pub(super) fn run(mut self) {
        loop {
            match self.next_event() {
                Event::End => {
                    if let Some(binder) = self.binder.take() {
                        binder.cancel();
                    }
                    return;
                }
                Event::Cancel => self.cancel(),
                Event::Bound(binding) => self.take_over(*binding),
                Event::Draw(request, _) if self.is_drawn_but_for_words(&request) => self.tell(*request),
                Event::Draw(request, is_new) => {
                    self.prepare(&request);
                    if self.on_stage.is_some() && !self.draw(*request, is_new) {
                        return;
                    }
                }
            }
        }
    }

    /// Wait until there is something to do.
    fn next_event(&mut self) -> Event {
        let shared = Arc::clone(&self.shared);
        let mut mailbox = shared.lock();
        loop {
            if mailbox.should_end {
                return Event::End;
            }
            if let Some(binding) = mailbox.bound.take() {
                return Event::Bound(Box::new(binding));
            }
            let is_cancellable = self.binder.is_some() || self.is_making || self.catching_up.is_some();
            if std::mem::take(&mut mailbox.should_cancel) && is_cancellable {
                return Event::Cancel;
            }
            if let Some(binder) = self.binder.take_if(|binder| binder.has_ended()) {
                // It delivers before it ends, so it has panicked: try again, once.
                if self.ended_early == Some(binder.state) {
                    self.refused = Some(binder.state);
                    mailbox.report.busy = None;
                    mailbox.report.errors.push("preparing the strands ended twice without a result: a bug".to_owned());
                }
                self.ended_early = Some(binder.state);
                self.seen = 0;
            }
            if let Some(binder) = &self.binder {
                let share = binder.share();
                mailbox.report.busy = Some(Busy { task: Task::BindStrands, share: Some(share) });
            }
            if let Some(request) = &mailbox.request {
                let is_new = mailbox.n_requests != self.seen;
                if !is_new
                    && self.is_making
                    && let Making::Ready(stage) = &mut self.stage
                    && !stage.player().has_made()
                {
                    // Nothing moves before; the processors are for what is being prepared.
                    let share = stage.player().made();
                    if let Some(busy) =
                        mailbox.report.busy.as_mut().filter(|busy| busy.task == Task::PrepareEveryStrand)
                    {
                        busy.share = share;
                        (self.shared.wake_window)();
                    }
                    let waited = self.shared.posted.wait_timeout(mailbox, LOOK_FOR_SOLVER);
                    mailbox = waited.unwrap_or_else(PoisonError::into_inner).0;
                    continue;
                }
                if is_new || ((request.playback.is_playing || self.catching_up.is_some()) && self.on_stage.is_some()) {
                    self.seen = mailbox.n_requests;
                    return Event::Draw(Box::new(request.clone()), is_new);
                }
                if self.pacer.wants_full() && self.drawn.is_some() && self.preview.is_none() {
                    let wait = self.pacer.rest_left(Instant::now());
                    // The binder needs the processors more than a picture of the groom before it does.
                    if wait.is_zero() && !request.is_interacting && self.binder.is_none() {
                        return Event::Draw(Box::new(request.clone()), false);
                    }
                    let wait = wait.max(Duration::from_millis(20));
                    let waited = self.shared.posted.wait_timeout(mailbox, wait);
                    mailbox = waited.unwrap_or_else(PoisonError::into_inner).0;
                    continue;
                }
                if let Making::Ready(stage) = &self.stage
                    && stage.watches_shaders()
                {
                    if stage.has_new_shaders() {
                        return Event::Draw(Box::new(request.clone()), true);
                    }
                    let waited = self.shared.posted.wait_timeout(mailbox, LOOK_FOR_SHADERS);
                    mailbox = waited.unwrap_or_else(PoisonError::into_inner).0;
                    continue;
                }
            }
            if self.binder.is_some() {
                let waited = self.shared.posted.wait_timeout(mailbox, Duration::from_millis(200));
                mailbox = waited.unwrap_or_else(PoisonError::into_inner).0;
            } else {
                mailbox = self.shared.posted.wait(mailbox).unwrap_or_else(PoisonError::into_inner);
            }
        }
    }

    /// See to it that the groom that is asked for comes on stage.
    fn prepare(&mut self, request: &FrameRequest) {
        let state = Some(request.state);
        if self.on_stage == state || self.refused == state || self.binder.is_some() {
            return;
        }
        let known = self.bound.clone();
        if !known.is_behind(&request.groom) {
            // Nothing to compute: a look, a light, a width.
            let bound = known.update(&request.groom, lorelei_core::io::Watch::default()).unwrap_or_default();
            self.put_on_stage(request.state, &request.groom, bound);
            return;
        }
        let (on_progress, on_done) = (Arc::clone(&self.shared), Arc::clone(&self.shared));
        let start = Instant::now();
        let binder = Binder::start(
            request.state,
            request.groom.clone(),
            known,
            // Of another document nothing is seen before.
            self.on_stage.is_none_or(|on_stage| on_stage.0 != request.state.0),
            move || {
                on_progress.posted.notify_one();
                (on_progress.wake_window)();
            },
            move |binding| {
                let mut mailbox = on_done.lock();
                if binding.preview.is_none() {
                    mailbox.report.start.bind = start.elapsed();
                }
                // A preview that was not taken yet is not needed any more.
                mailbox.bound = Some(binding);
                drop(mailbox);
                on_done.posted.notify_one();
            },
        );
        match binder {
            Ok(binder) => {
                self.binder = Some(binder);
                self.shared.publish(|report| {
                    report.busy = Some(Busy { task: Task::BindStrands, share: Some(0.0) });
                    report.is_still = false;
                });
            }
            Err(why) => self.fail(&why.to_string()),
        }
    }

    /// Give up what a person does not want to wait for: of several things the one that is announced.
    fn cancel(&mut self) {
        let cancelled = if let Some(binder) = self.binder.take() {
            let state = binder.state;
            binder.cancel();
            self.refused = Some(state);
            self.preview = None;
            // What waited behind it is looked at again.
            self.seen = 0;
            Cancelled::Strands(state)
        } else {
            let is_making = std::mem::take(&mut self.is_making);
            self.catching_up = None;
            let Some(stage) = self.stage() else { return };
            if is_making {
                Cancelled::EveryStrand(stage.player().give_up_making())
            } else {
                stage.player().stay();
                Cancelled::CatchUp
            }
        };
        self.shared.publish(|report| {
            report.busy = None;
            report.cancelled = Some(cancelled);
        });
    }

    /// A groom was bound: it comes on stage, unless it was cancelled meanwhile.
    fn take_over(&mut self, binding: Binding) {
        if self.binder.as_ref().is_none_or(|binder| binder.state != binding.state) {
            return;
        }
        self.seen = 0;
        self.preview = binding.preview;
        if self.preview.is_none() {
            self.binder = None;
        }
        if matches!(self.stage, Making::Compiling(_)) {
            self.shared.publish(|report| report.busy = Some(Busy { task: Task::CompileShaders, share: None }));
        }
        // A preview is no groom that anybody asks for: the groom itself is still to come.
        let state = if self.preview.is_some() { (binding.state.0, PREVIEW) } else { binding.state };
        let known = self.bound.clone();
        self.put_on_stage(state, &binding.groom, binding.bound);
        if self.preview.is_some() {
            self.bound = known;
        }
        self.shared.publish(|report| report.busy = None);
    }

    fn put_on_stage(&mut self, state: State, groom: &Groom, bound: Bound) {
        let Some(stage) = self.stage() else {
            self.refused = Some(state);
            return;
        };
        let kept = bound.clone();
        match stage.set_bound(groom, bound) {
            Ok(warnings) => {
                self.bound = kept;
                self.on_stage = Some(state);
                self.refused = None;
                self.shared.publish(|report| report.warnings.extend(warnings));
            }
            Err(why) => {
                self.refused = Some(state);
                self.shared.publish(|report| report.errors.push(why.to_string()));
            }
        }
    }

    /// Whether the request's picture is there already, in full: only where two looks are wiped, which pixel is to be
    /// inspected, or whether a hand is at work, is another.
    fn is_drawn_but_for_words(&self, request: &FrameRequest) -> bool {
        let Some(drawn) = &self.drawn else { return false };
        let is_same_versus = |a: &Shown, b: &Shown| {
            a.solo == b.solo && a.versus.as_ref().map(|(look, _)| look) == b.versus.as_ref().map(|(look, _)| look)
        };
        let alike = FrameRequest {
            shown: drawn.shown.clone(),
            inspect: drawn.inspect,
            is_interacting: drawn.is_interacting,
            ..request.clone()
        };
        alike == *drawn
            && is_same_versus(&request.shown, &drawn.shown)
            // The very same request is one to draw again: a shader has changed.
            && request != drawn
            && self.on_stage == Some(request.state)
            && !self.pacer.wants_full()
            && !request.playback.is_playing
            && self.catching_up.is_none()
    }

    /// Put the two pictures that are there together anew, and say what is under the pixel.
    fn tell(&mut self, request: FrameRequest) {
        let is_compared = self.drawn.as_ref().is_some_and(|drawn| drawn.shown == request.shown);
        let Some(stage) = self.stage() else { return };
        let mut errors = Vec::new();
        if !is_compared
            && let Some((_, comparison)) = &request.shown.versus
            && let Err(why) = stage.compare_again(*comparison)
        {
            errors.push(why.to_string());
        }
        let inspection = inspected(stage, request.inspect, 1, &mut errors);
        self.shared.publish(|report| {
            report.shown.clone_from(&request.shown);
            report.inspection = inspection;
            report.errors.extend(errors);
        });
        self.drawn = Some(request);
    }

    /// Draw a frame; false where nothing more can be drawn.
    fn draw(&mut self, request: FrameRequest, is_new: bool) -> bool {
        let mut detail = self.pacer.detail_for(&request, self.drawn.as_ref(), is_new || self.catching_up.is_some());
        if self.preview.is_some() {
            // It is thin already.
            detail.lod = 1.0;
        }
        let now = Instant::now();
        let real_secs = self.pacer.tick(now, request.playback.is_playing);
        let dt_secs = real_secs.min(LONGEST_FRAME_SECS);
        let speed = self.speed(dt_secs, real_secs);
        if detail.is_full() && self.pacer.expects_ms() > ANNOUNCED_MS {
            self.shared.publish(|report| report.is_refining = true);
        }
        let offered = request.offered.clone().filter(|offered| {
            let is_known = self.offered.as_ref().is_some_and(|known| Arc::ptr_eq(known, offered));
            !is_known && self.on_stage == Some(request.state)
        });
        if offered.is_some() {
            self.offered.clone_from(&offered);
        }
        let wants_shot = std::mem::replace(&mut self.n_shots, request.n_shots) != request.n_shots;
        let is_to_be_lost = std::mem::replace(&mut self.n_losses, request.n_losses) != request.n_losses;
        let Some(state) = self.on_stage else { return true };
        let Some(stage) = self.stage() else { return true };
        if is_to_be_lost {
            stage.lose_gpu();
        }
        stage.player().set_budget(request.frames_budget);
        let is_refused = offered.is_some_and(|offered| !stage.offer(&offered));
        stage.set_overlay(request.overlay.as_ref());
        stage.set_shown(&request.shown);
        let result = stage.frame(&request.playback, dt_secs, &request.camera, request.size, detail);
        let frame_ms = ms_since(now);
        let wants_picture =
            detail.is_full() && request.n_pictures > self.drawn.as_ref().map_or(0, |drawn| drawn.n_pictures);
        let Some(stage) = self.stage() else { return true };
        let picture = wants_picture.then(|| stage.read_pixels());
        let mut errors = Vec::new();
        if is_refused {
            errors.push(OTHER_FRAMES.to_owned());
        }
        let shot = wants_shot.then(|| stage.player().shot());
        let inspection = inspected(stage, request.inspect, detail.coarseness, &mut errors);
        let air = if request.wants_air { stage.player().air() } else { Ok(None) };
        let is_lost = stage.is_lost();
        let mut news = FrameReport::default();
        stage.describe(&mut news);
        let timeline = Timeline { speed, ..news.timeline };
        let doing = self.doing(&timeline, now, frame_ms);
        let is_catching_up = self.catching_up.is_some();
        if self.preview.is_none() {
            self.pacer.drew(detail, frame_ms, request.moving_budget_ms, request.groom.n_strands());
        }
        let lod = self.preview.unwrap_or(detail.lod);
        let is_first = self.start.picture.is_zero();
        if is_first {
            self.start.first_frame = now.elapsed();
            self.start.picture = self.gpu.started.elapsed();
        }
        let (start, has_own) = (self.start, self.gpu.has_own);
        self.shared.publish(|report| {
            report.frame_idx += 1;
            report.state = state;
            report.camera = Some(request.camera);
            report.size = request.size;
            report.shown.clone_from(&request.shown);
            report.inspection = inspection;
            report.errors.extend(errors);
            report.lod = lod;
            report.coarseness = detail.coarseness;
            report.frame_ms = frame_ms;
            report.is_refining = false;
            report.busy = match report.busy {
                Some(Busy { task: Task::BindStrands | Task::CompileShaders, .. }) => report.busy,
                Some(Busy { task: Task::PrepareEveryStrand | Task::CatchUp, .. }) | None => doing,
            };
            report.is_still =
                detail.is_full() && !request.playback.is_playing && !is_catching_up && state == request.state;
            report.is_lost = is_lost && !has_own;
            report.start = StartTimes { bind: report.start.bind, ..start };
            report.errors.extend(result.err().filter(|_| !is_lost).map(|why| why.to_string()));
            match shot {
                Some(Ok(shot)) => report.shot = Some((request.n_shots, shot.map(Arc::new))),
                Some(Err(why)) => report.errors.push(why.to_string()),
                None => {}
            }
            match picture {
                Some(Ok(picture)) => report.picture = Some((request.n_pictures, picture)),
                Some(Err(why)) => report.errors.push(why.to_string()),
                None => {}
            }
            match air {
                Ok(air) => report.air = air,
                Err(why) if !is_lost => report.errors.push(why.to_string()),
                Err(_) => {}
            }
            report.n_strands = news.n_strands;
            report.n_vertices = news.n_vertices;
            report.n_bytes = news.n_bytes;
            report.n_drawing_bytes = news.n_drawing_bytes;
            report.n_shadow_bytes = news.n_shadow_bytes;
            report.pass_times = news.pass_times;
            report.timeline = timeline;
            report.held = news.held;
            report.world_from_head = news.world_from_head;
            report.texture = news.texture;
        });
        if is_first {
            let bind = self.shared.lock().report.start.bind;
            log::info!(
                "first picture {:.2?} after the start: strands bound in {bind:.2?}, shaders compiled in {:.2?} (waited {:.2?} for them), first frame {:.2?}",
                start.picture,
                start.shaders,
                start.waited_for_shaders,
                start.first_frame
            );
        }
        if is_lost {
            return self.replace_gpu();
        }
        let mut request = request;
        if !detail.is_full()
            && let Some(drawn) = &self.drawn
        {
            // A picture is only kept of a full frame: leave the question open.
            request.n_pictures = drawn.n_pictures;
        }
        self.drawn = Some(request);
        true
    }

    /// What movement waits for after a frame that was begun at `now`, once that is longer than a moment.
    fn doing(&mut self, timeline: &Timeline, now: Instant, frame_ms: f32) -> Option<Busy> {
        self.is_making = timeline.made.is_some();
        let before = self.catching_up.take();
        self.catching_up = timeline.wanted.map(|_| {
            let (since, n_frames) = before.unwrap_or((now, 1));
            (since, n_frames.max(timeline.n_left))
        });
        if self.is_making {
            return Some(Busy { task: Task::PrepareEveryStrand, share: timeline.made });
        }
        let (since, n_frames) = self.catching_up?;
        if let Some(stage) = self.stage() {
            stage.player().simulate_within(CATCH_UP_MS / frame_ms.max(1e-3));
        }
        let share = 1.0 - timeline.n_left as f32 / n_frames as f32;
        (ms_since(since) > ANNOUNCED_MS).then_some(Busy { task: Task::CatchUp, share: Some(share) })
    }

    /// Simulated time over real time, over the last seconds; 1 while nothing plays.
    fn speed(&mut self, dt_secs: f32, real_secs: f32) -> f32 {
        if real_secs == 0.0 {
            self.pace = [0.0; 2];
            return 1.0;
        }
        let fade = (-real_secs / PACE_SECS).exp();
        self.pace = [fade * self.pace[0] + dt_secs, fade * self.pace[1] + real_secs];
        self.pace[0] / self.pace[1]
    }

    /// The stage's own device is lost: another one takes its place, and nothing else changes. The window's
    /// device is the window's to replace: false.
    fn replace_gpu(&mut self) -> bool {
        if !self.gpu.has_own {
            return false;
        }
        self.start_compiling();
        self.on_stage = None;
        self.drawn = None;
        self.seen = 0;
        self.shared.publish(|report| {
            report.is_lost = false;
            report.is_still = false;
            report.n_replaced += 1;
        });
        true
    }
}

/// What is under a pixel of the full picture; nothing where the frame failed.
fn inspected(
    stage: &mut Stage,
    pixel: Option<[u32; 2]>,
    coarseness: u32,
    errors: &mut Vec<String>,
) -> Option<Inspection> {
    match stage.inspect(pixel?.map(|at| at / coarseness)) {
        Ok(inspection) => inspection,
        Err(why) => {
            errors.push(why.to_string());
            None
        }
    }
}

fn ms_since(start: Instant) -> f32 {
    start.elapsed().as_secs_f32() * 1000.0
}
