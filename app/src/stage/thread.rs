//! The stage on a thread of its own: preparing strands, compiling shaders and waiting for the GPU never
//! stop the window.
//!
//! The window posts what should be seen ([`FrameRequest`], the newest wins) and picks up what is seen
//! ([`FrameReport`]). While something moves and frames are slow, fewer and wider strands are drawn; once all
//! is still, one frame with all of them.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_shaders::Gpu;

use super::{Playback, Stage};

/// What should be seen.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRequest {
    pub groom: Groom,
    /// Names the groom's content: the same state, the same groom.
    pub state: (u64, u64),
    pub camera: Camera,
    /// Pixels.
    pub size: [u32; 2],
    pub playback: Playback,
    /// A person is dragging something: frames must be quick.
    pub is_interacting: bool,
    /// Milliseconds that a frame may take while something moves.
    pub moving_budget_ms: f32,
    /// Counts requests to keep the next full frame's pixels.
    pub n_pictures: u64,
}

/// What is seen, and what it cost.
#[derive(Debug, Clone, Default)]
pub struct FrameReport {
    /// Frames drawn since the start.
    pub frame_idx: u64,
    /// The groom's state that was drawn.
    pub state: (u64, u64),
    pub camera: Option<Camera>,
    pub size: [u32; 2],
    /// Share of the strands that was drawn.
    pub lod: f32,
    pub texture: Option<wgpu::Texture>,
    /// GPU milliseconds by pass, of the newest frame that was timed.
    pub pass_times: Vec<(String, f32)>,
    /// Recording, and waiting until the GPU was done.
    pub frame_ms: f32,
    pub n_strands: u64,
    pub n_vertices: u64,
    pub n_bytes: u64,
    pub sim_secs: f32,
    pub adapter: String,
    /// What takes long right now, for the status bar.
    pub busy: Option<&'static str>,
    /// Nothing is left to do until another request.
    pub is_still: bool,
    /// What a person should know about the groom that was prepared since the last pick-up.
    pub warnings: Vec<String>,
    /// What went wrong since the last pick-up.
    pub errors: Vec<String>,
    /// The GPU is gone; nothing more will be drawn.
    pub is_lost: bool,
    /// Pixels that were asked for: number of the request, size, straight RGBA.
    pub picture: Option<(u64, image::RgbaImage)>,
}

#[derive(Default)]
struct Mailbox {
    request: Option<FrameRequest>,
    /// Raised with every posted request that differs from the one before.
    n_requests: u64,
    report: FrameReport,
    should_end: bool,
}

struct Shared {
    mailbox: Mutex<Mailbox>,
    posted: Condvar,
    wake_window: Box<dyn Fn() + Send + Sync>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Mailbox> {
        self.mailbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn publish(&self, change: impl FnOnce(&mut FrameReport)) {
        change(&mut self.lock().report);
        (self.wake_window)();
    }
}

/// The window's end of the thread. Dropping it ends the thread.
pub struct StageThread {
    shared: Arc<Shared>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl StageThread {
    /// Start on a device; `wake_window` is called whenever there is something new to pick up.
    pub fn start(gpu: Gpu, wake_window: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared =
            Arc::new(Shared { mailbox: Mutex::default(), posted: Condvar::new(), wake_window: Box::new(wake_window) });
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("stage".to_owned()).spawn(move || run(&theirs, gpu))?;
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

    /// The newest report; its messages and its picture are handed out once.
    pub fn pick_up(&self) -> FrameReport {
        let mut mailbox = self.shared.lock();
        let report = mailbox.report.clone();
        mailbox.report.errors.clear();
        mailbox.report.warnings.clear();
        mailbox.report.picture = None;
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

/// After the last movement, before a full frame that would take long.
const REST_BEFORE_FULL: Duration = Duration::from_millis(250);
/// Full frames quicker than this need no rest first.
const QUICK_MS: f32 = 100.0;
/// Longest time that one frame moves the hair on: after a stall it goes on from where it was.
const LONGEST_FRAME_SECS: f32 = 0.1;
/// Fewer strands no longer look like the groom, and most of a slow frame's time is then in other passes.
const FEWEST_STRANDS: f32 = 2000.0;

fn run(shared: &Shared, gpu: Gpu) {
    let adapter = gpu.adapter_info.name.clone();
    shared.publish(|report| {
        report.adapter = adapter;
        report.busy = Some("Compiling shaders");
    });
    let mut stage = match Stage::new(gpu) {
        Ok(stage) => stage,
        Err(why) => {
            shared.publish(|report| {
                report.busy = None;
                report.is_still = true;
                report.errors.push(why.to_string());
            });
            return;
        }
    };
    shared.publish(|report| report.busy = None);
    let mut pacer = Pacer::default();
    let mut seen = 0;
    let mut drawn: Option<FrameRequest> = None;
    while let Some((request, n_requests)) = next_request(shared, seen, &pacer, drawn.as_ref()) {
        let is_new = n_requests != seen;
        seen = n_requests;
        if drawn.as_ref().map(|drawn| drawn.state) != Some(request.state) {
            shared.publish(|report| {
                report.busy = Some("Preparing strands");
                report.is_still = false;
            });
            let result = stage.set_groom(&request.groom);
            shared.publish(|report| {
                report.busy = None;
                match result {
                    Ok(warnings) => report.warnings.extend(warnings),
                    Err(why) => report.errors.push(why.to_string()),
                }
            });
        }
        let lod = pacer.lod_for(&request, drawn.as_ref(), is_new);
        let now = Instant::now();
        let dt_secs = pacer.tick(now, request.playback.is_playing).min(LONGEST_FRAME_SECS);
        let result = stage.frame(&request.playback, dt_secs, &request.camera, request.size, lod);
        let frame_ms = now.elapsed().as_secs_f32() * 1000.0;
        let coarsest = (FEWEST_STRANDS / request.groom.n_strands().max(1) as f32).min(1.0);
        pacer.drew(lod, frame_ms, request.moving_budget_ms, coarsest);
        let is_full = lod >= 1.0;
        let wants_picture = is_full && drawn.as_ref().is_none_or(|drawn| drawn.n_pictures != request.n_pictures);
        let picture = (wants_picture && request.n_pictures > 0).then(|| stage.read_pixels());
        let is_lost = stage.is_lost();
        shared.publish(|report| {
            report.frame_idx += 1;
            report.state = request.state;
            report.camera = Some(request.camera);
            report.size = request.size;
            report.lod = lod;
            report.frame_ms = frame_ms;
            report.is_still = is_full && !request.playback.is_playing;
            report.is_lost = is_lost;
            report.errors.extend(result.err().map(|why| why.to_string()));
            match picture {
                Some(Ok(picture)) => report.picture = Some((request.n_pictures, picture)),
                Some(Err(why)) => report.errors.push(why.to_string()),
                None => {}
            }
            stage.describe(report);
        });
        if is_lost {
            return;
        }
        let mut request = request;
        if !is_full && let Some(drawn) = &drawn {
            // A picture is only kept of a full frame: leave the question open.
            request.n_pictures = drawn.n_pictures;
        }
        drawn = Some(request);
    }
}

/// Wait until there is something to draw; `None` when the window is gone.
fn next_request(
    shared: &Shared,
    seen: u64,
    pacer: &Pacer,
    drawn: Option<&FrameRequest>,
) -> Option<(FrameRequest, u64)> {
    let mut mailbox = shared.lock();
    loop {
        if mailbox.should_end {
            return None;
        }
        if let Some(request) = &mailbox.request {
            let is_playing = request.playback.is_playing;
            if mailbox.n_requests != seen || is_playing {
                return Some((request.clone(), mailbox.n_requests));
            }
            if pacer.wants_full() && drawn.is_some() {
                let wait = pacer.rest_left(Instant::now());
                if wait.is_zero() && !request.is_interacting {
                    return Some((request.clone(), seen));
                }
                let wait = wait.max(Duration::from_millis(20));
                let waited = shared.posted.wait_timeout(mailbox, wait);
                mailbox = waited.unwrap_or_else(PoisonError::into_inner).0;
                continue;
            }
        }
        mailbox = shared.posted.wait(mailbox).unwrap_or_else(PoisonError::into_inner);
    }
}

/// Decides how many strands a frame can afford.
struct Pacer {
    /// Level of detail of the next frame while something moves.
    moving_lod: f32,
    last_lod: f32,
    /// What a frame with every strand took, or is likely to take.
    full_ms: f32,
    last_drawn: Option<Instant>,
    last_tick: Option<Instant>,
}

impl Default for Pacer {
    fn default() -> Self {
        // A first guess that shows something at once on any GPU.
        Self { moving_lod: 0.1, last_lod: 0.0, full_ms: f32::INFINITY, last_drawn: None, last_tick: None }
    }
}

impl Pacer {
    /// Seconds since the last frame of the same run of movement.
    fn tick(&mut self, now: Instant, is_playing: bool) -> f32 {
        let before = self.last_tick.replace(now);
        if !is_playing {
            self.last_tick = None;
        }
        before.map_or(0.0, |before| (now - before).as_secs_f32())
    }

    fn lod_for(&self, request: &FrameRequest, drawn: Option<&FrameRequest>, is_new: bool) -> f32 {
        let is_moving = request.is_interacting
            || request.playback.is_playing
            || drawn.is_none()
            || drawn.is_some_and(|drawn| drawn.camera != request.camera || drawn.size != request.size);
        let is_hurried = is_moving || (is_new && self.full_ms > QUICK_MS);
        if is_hurried { self.moving_lod } else { 1.0 }
    }

    fn drew(&mut self, lod: f32, frame_ms: f32, budget_ms: f32, coarsest: f32) {
        self.last_lod = lod;
        self.last_drawn = Some(Instant::now());
        if lod >= 1.0 {
            self.full_ms = frame_ms;
        } else {
            // Part of a frame's time has nothing to do with strands, so the step is damped.
            self.full_ms = self.full_ms.min(frame_ms / lod);
        }
        let wanted = (budget_ms / frame_ms.max(0.1)).clamp(0.5, 1.6) * lod;
        self.moving_lod = if budget_ms >= self.full_ms { 1.0 } else { wanted.clamp(coarsest, 1.0) };
    }

    fn wants_full(&self) -> bool {
        self.last_lod < 1.0
    }

    fn rest_left(&self, now: Instant) -> Duration {
        let rest = if self.full_ms > QUICK_MS { REST_BEFORE_FULL } else { Duration::ZERO };
        self.last_drawn.map_or(Duration::ZERO, |at| rest.saturating_sub(now.saturating_duration_since(at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_lose_strands_until_they_fit_and_fast_ones_lose_none() {
        let mut slow = Pacer::default();
        let mut lod = 1.0;
        for _ in 0..20 {
            // 200 ms for every strand, 10 ms for the rest.
            slow.drew(lod, 10.0 + 200.0 * lod, 50.0, 0.02);
            lod = slow.moving_lod;
        }
        assert!((10.0 + 200.0 * lod) < 55.0 && lod > 0.15, "{lod}");
        assert!(slow.wants_full());
        let mut fast = Pacer::default();
        fast.drew(0.1, 2.0, 50.0, 0.02);
        assert_eq!(fast.moving_lod, 1.0);
    }
}
