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
}

/// A worker.
pub struct Binder {
    pub state: State,
    cancel: Arc<AtomicBool>,
    progress: Arc<AtomicU32>,
}

impl Binder {
    /// Start to bind a groom. `on_done` gets the result unless it was cancelled; `on_progress` is called when
    /// there is another share to show.
    pub fn start(
        state: State,
        groom: Groom,
        known: Bound,
        on_progress: impl Fn() + Send + 'static,
        on_done: impl FnOnce(Binding) + Send + 'static,
    ) -> std::io::Result<Self> {
        let cancel = Arc::new(AtomicBool::new(false));
        let progress = Arc::new(AtomicU32::new(0));
        let (theirs, share) = (Arc::clone(&cancel), Arc::clone(&progress));
        std::thread::Builder::new().name("bind".to_owned()).spawn(move || {
            let on_share = |done: f32| {
                share.store(done.to_bits(), Ordering::Relaxed);
                on_progress();
            };
            let bound = known.update(&groom, Watch::new(&on_share, &theirs));
            if let Some(bound) = bound.filter(|_| !theirs.load(Ordering::Relaxed)) {
                on_done(Binding { state, groom, bound });
            }
        })?;
        Ok(Self { state, cancel, progress })
    }

    /// Share of the work that is done, 0-1.
    pub fn share(&self) -> f32 {
        f32::from_bits(self.progress.load(Ordering::Relaxed))
    }

    /// Nothing will come of it any more.
    pub fn cancel(self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}
