//! Binding strands on a thread of its own, so that the old groom can still be looked at from all sides
//! meanwhile, and so that it can be cancelled at once: a cancelled worker is left to find that out.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use lorelei_core::groom::Groom;
use lorelei_core::io::Watch;
use lorelei_render::Bound;

/// Names a groom's content, as [`super::thread::FrameRequest::state`].
pub type State = (u64, u64);

/// What a worker leaves for the stage.
#[derive(Debug)]
pub struct Binding {
    pub state: State,
    pub groom: Groom,
    pub bound: Bound,
    /// Share of the strands that this is a preview with; the rest follows.
    pub preview: Option<f32>,
}

/// Strands of a preview: few enough to be bound within a moment.
const N_PREVIEW: usize = 4000;

/// A worker.
pub struct Binder {
    pub state: State,
    cancel: Arc<AtomicBool>,
    progress: Arc<AtomicU32>,
    thread: std::thread::JoinHandle<()>,
}

impl Binder {
    /// Start to bind a groom. `on_done` gets the result unless it was cancelled, and before that a preview where
    /// one is wanted; `on_progress` is called when there is another share to show.
    pub fn start(
        state: State,
        groom: Groom,
        known: Bound,
        wants_preview: bool,
        on_progress: impl Fn() + Send + 'static,
        on_done: impl Fn(Binding) + Send + 'static,
    ) -> std::io::Result<Self> {
        let cancel = Arc::new(AtomicBool::new(false));
        let progress = Arc::new(AtomicU32::new(0));
        let (theirs, share) = (Arc::clone(&cancel), Arc::clone(&progress));
        let thread = std::thread::Builder::new().name("bind".to_owned()).spawn(move || {
            let on_share = |done: f32| {
                share.store(done.to_bits(), Ordering::Relaxed);
                on_progress();
            };
            if wants_preview && let Some((thin, bound)) = Bound::preview(&groom, N_PREVIEW) {
                let share = thin.n_strands() as f32 / groom.n_strands().max(1) as f32;
                on_done(Binding { state, groom: thin, bound, preview: Some(share) });
            }
            let bound = known.update(&groom, Watch::new(&on_share, &theirs));
            if let Some(bound) = bound.filter(|_| !theirs.load(Ordering::Relaxed)) {
                on_done(Binding { state, groom, bound, preview: None });
            }
        })?;
        Ok(Self { state, cancel, progress, thread })
    }

    /// Share of the work that is done, 0-1.
    pub fn share(&self) -> f32 {
        f32::from_bits(self.progress.load(Ordering::Relaxed))
    }

    /// It has ended: what has not come by now will not come.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Nothing will come of it any more.
    pub fn cancel(self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}
