//! The stage on a thread of its own: preparing strands, compiling shaders and waiting for the GPU never
//! stop the window.
//!
//! The window posts what should be seen ([`FrameRequest`], the newest wins) and picks up what is seen
//! ([`FrameReport`]); [`super::worker`] does the work.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_render::overlay::Overlay;
use lorelei_shaders::Gpu;

use super::Playback;
use super::binder::{Binding, State};
use super::report::FrameReport;
use super::shown::Shown;
use super::worker::Worker;
use crate::movement::range::Ranged;

/// What should be seen.
#[derive(Debug, Clone)]
pub struct FrameRequest {
    pub groom: Groom,
    /// Names the groom's content: the same state, the same groom.
    pub state: State,
    pub camera: Camera,
    /// Pixels.
    pub size: [u32; 2],
    pub playback: Playback,
    /// A painted map that is shown on the scalp.
    pub overlay: Option<Overlay>,
    /// What of it is shown.
    pub shown: Shown,
    /// The pixel whose light is to be told.
    pub inspect: Option<[u32; 2]>,
    /// The air is drawn over the picture.
    pub wants_air: bool,
    /// A person is dragging something: frames must be quick.
    pub is_interacting: bool,
    /// Milliseconds that a frame may take while something moves.
    pub moving_budget_ms: f32,
    /// Bytes that kept frames of the movement may take.
    pub frames_budget: usize,
    /// Frames of the movement that were simulated elsewhere.
    pub offered: Option<Arc<Ranged>>,
    /// Counts requests to say where the guides are.
    pub n_shots: u64,
    /// Counts requests to keep the next full frame's pixels.
    pub n_pictures: u64,
    /// Counts requests to lose the GPU, for tests.
    pub n_losses: u64,
}

impl PartialEq for FrameRequest {
    /// Grooms are compared by their state: comparing a million imported strands would take a frame's time.
    fn eq(&self, other: &Self) -> bool {
        // Every field is named, so that a new one is not forgotten.
        let Self {
            groom: _,
            state,
            camera,
            size,
            playback,
            overlay,
            shown,
            inspect,
            wants_air,
            is_interacting,
            moving_budget_ms,
            frames_budget,
            offered,
            n_shots,
            n_pictures,
            n_losses,
        } = self;
        (state, camera, size, playback) == (&other.state, &other.camera, &other.size, &other.playback)
            && *overlay == other.overlay
            && (shown, inspect) == (&other.shown, &other.inspect)
            && *wants_air == other.wants_air
            && *is_interacting == other.is_interacting
            && (*moving_budget_ms, *frames_budget) == (other.moving_budget_ms, other.frames_budget)
            && offered.as_ref().map(Arc::as_ptr) == other.offered.as_ref().map(Arc::as_ptr)
            && (*n_shots, *n_pictures, *n_losses) == (other.n_shots, other.n_pictures, other.n_losses)
    }
}

#[derive(Default)]
pub(super) struct Mailbox {
    pub(super) request: Option<FrameRequest>,
    /// Raised with every posted request that differs from the one before.
    pub(super) n_requests: u64,
    pub(super) report: FrameReport,
    pub(super) bound: Option<Binding>,
    pub(super) should_cancel: bool,
    pub(super) should_end: bool,
}

pub(super) struct Shared {
    pub(super) mailbox: Mutex<Mailbox>,
    pub(super) posted: Condvar,
    pub(super) wake_window: Box<dyn Fn() + Send + Sync>,
}

impl Shared {
    pub(super) fn lock(&self) -> MutexGuard<'_, Mailbox> {
        self.mailbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn publish(&self, change: impl FnOnce(&mut FrameReport)) {
        change(&mut self.lock().report);
        (self.wake_window)();
    }
}

/// The window's end of the thread. Dropping it ends the thread.
pub struct StageThread {
    shared: Arc<Shared>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// What the stage draws on, and how to get another when it is lost.
pub struct StageGpu {
    /// The window's device.
    pub window: Gpu,
    /// Draw on another device than the window does: where the window's driver is software.
    pub has_own: bool,
    /// When the program started, for [`StartTimes`].
    pub started: Instant,
}

impl StageThread {
    /// Start on a device; `wake_window` is called whenever there is something new to pick up.
    pub fn start(gpu: StageGpu, wake_window: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared =
            Arc::new(Shared { mailbox: Mutex::default(), posted: Condvar::new(), wake_window: Box::new(wake_window) });
        let theirs = Arc::clone(&shared);
        let thread =
            std::thread::Builder::new().name("stage".to_owned()).spawn(move || Worker::new(theirs, gpu).run())?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Ask for a frame.
    pub fn post(&self, request: &FrameRequest) {
        let mut mailbox = self.shared.lock();
        if mailbox.request.as_ref() != Some(request) {
            mailbox.request = Some(request.clone());
            mailbox.n_requests += 1;
            self.shared.posted.notify_one();
        }
    }

    /// Give up what is being prepared.
    pub fn cancel(&self) {
        self.shared.lock().should_cancel = true;
        self.shared.posted.notify_one();
    }

    /// The newest report; its messages and its picture are handed out once.
    pub fn pick_up(&self) -> FrameReport {
        let has_ended = self.thread.as_ref().is_some_and(std::thread::JoinHandle::is_finished);
        let mut mailbox = self.shared.lock();
        let mut report = mailbox.report.clone();
        // It ends by itself only where it panicked, or has said already that the GPU is lost.
        report.is_lost |= has_ended;
        mailbox.report.errors.clear();
        mailbox.report.warnings.clear();
        mailbox.report.picture = None;
        mailbox.report.shot = None;
        mailbox.report.cancelled = None;
        report
    }
}

impl Drop for StageThread {
    fn drop(&mut self) {
        self.shared.lock().should_end = true;
        self.shared.posted.notify_one();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the stage's thread had panicked");
        }
    }
}
