//! Makes the solver of a groom: at once where that is quick; on a thread of its own where every strand is moved, which takes
//! seconds. A solver that is not needed for a while is kept, so that it need not be made again.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;

use lorelei_core::binding::LayerBinding;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::groom::Layer;
use lorelei_core::io::Watch;
use lorelei_core::moved::{MovedHair, g_per_cm, n_moved};
use lorelei_core::simulation::{Moved, SimulationSettings};
use lorelei_shaders::{Gpu, ShaderError, ShaderLibrary};
use lorelei_sim::GpuSolver;
use lorelei_sim::gpu::{TooMuchHair, check_room};

/// Moved vertices up to which a solver is made within a frame.
const QUICK: usize = 60_000;

/// Share of the work that it takes to draw every strand at rest.
const DRAWN: f32 = 0.25;

/// A layer, and what its strands hang on.
pub type LayerHair = (Layer, Arc<LayerBinding>);

/// What a solver is made from.
pub struct Gear<'s> {
    pub gpu: &'s Gpu,
    pub library: &'s ShaderLibrary,
    pub field: Option<&'s Arc<DistanceField>>,
    /// Nobody looks on: a frame may take as long as it takes.
    pub waits: bool,
}

/// Hair, and the solver that moves it.
type Made = (Arc<Vec<MovedHair>>, GpuSolver);

/// A solver that is being made.
struct Job {
    /// What was cancelled makes nothing. `None` once it is waited for.
    thread: Option<JoinHandle<Result<Option<Made>, ShaderError>>>,
    is_cancelled: Arc<AtomicBool>,
    /// Bits of the share that is done.
    done: Arc<AtomicU32>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }
}

impl Job {
    fn start(
        make: impl FnOnce(Watch<'_>) -> Result<Option<Made>, ShaderError> + Send + 'static,
    ) -> std::io::Result<Self> {
        let (is_cancelled, done) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU32::new(0)));
        let (cancel, share) = (Arc::clone(&is_cancelled), Arc::clone(&done));
        let work = move || make(Watch::new(&|done: f32| share.store(done.to_bits(), Ordering::Relaxed), &cancel));
        let thread = std::thread::Builder::new().name("solver".to_owned()).spawn(work)?;
        Ok(Self { thread: Some(thread), is_cancelled, done })
    }

    fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Wait for what comes of it. A panic of the thread is one of this one.
    fn join(mut self) -> Result<Option<Made>, ShaderError> {
        let made = self.thread.take().map(JoinHandle::join);
        made.map_or(Ok(None), |made| made.unwrap_or_else(|why| std::panic::resume_unwind(why)))
    }
}

/// Where solvers come from.
#[derive(Default)]
pub struct Maker {
    /// What of the groom is moved, once that is known.
    hair: Option<Arc<Vec<MovedHair>>>,
    job: Option<Job>,
    /// The groom is another than when the job began.
    is_stale: bool,
    /// A person does not want to wait for this hair.
    is_given_up: bool,
    spare: Option<GpuSolver>,
}

impl Maker {
    /// The hair has changed.
    pub fn forget(&mut self) {
        (self.hair, self.spare) = (None, None);
        self.is_given_up = false;
        self.is_stale = self.job.is_some();
        if let Some(job) = &self.job {
            job.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Do not wait for what is being made: there is no solver until the hair has changed.
    pub fn give_up(&mut self) {
        (self.job, self.is_stale, self.is_given_up) = (None, false, true);
    }

    /// Only the ties have changed; a solver that is in use is told by whoever uses it.
    pub fn set_ties(&mut self, layers: &[LayerHair]) {
        let Some(hair) = &mut self.hair else { return };
        for (layer_idx, (hair, (_, binding))) in Arc::make_mut(hair).iter_mut().zip(layers).enumerate() {
            hair.ties = hair.ties_of(binding);
            if let Some(spare) = &mut self.spare {
                spare.set_ties(layer_idx, &hair.ties);
            }
        }
    }

    /// Only how much hair there is has changed; a solver that is in use is told by whoever uses it.
    pub fn set_masses(&mut self, layers: &[LayerHair]) {
        for (layer_idx, (layer, binding)) in layers.iter().enumerate() {
            let g_per_cm = g_per_cm(layer, binding);
            if let Some(hair) = &mut self.hair {
                Arc::make_mut(hair)[layer_idx].g_per_cm = g_per_cm;
            }
            if let Some(spare) = &mut self.spare {
                spare.set_g_per_cm(layer_idx, g_per_cm);
            }
        }
        self.is_stale |= self.job.is_some();
    }

    /// Keep a solver of the present hair.
    pub fn put_back(&mut self, solver: GpuSolver) {
        self.spare = Some(solver);
    }

    /// What of the groom is moved; empty before the first solver was made.
    pub fn hair(&self) -> &[MovedHair] {
        self.hair.as_deref().map_or(&[], Vec::as_slice)
    }

    /// A solver is on its way.
    pub fn is_making(&self) -> bool {
        self.job.is_some()
    }

    /// It is there to be taken with [`Maker::make`].
    pub fn has_made(&self) -> bool {
        self.job.as_ref().is_some_and(Job::is_finished)
    }

    /// How much of it is done, 0-1.
    pub fn share(&self) -> Option<f32> {
        let job = self.job.as_ref().filter(|_| !self.is_stale);
        job.map(|job| f32::from_bits(job.done.load(Ordering::Relaxed))).or(self.is_making().then_some(0.0))
    }

    /// A solver of the present hair, in whatever state; `None` while it is still being made, or was given up.
    pub fn make(
        &mut self,
        gear: &Gear<'_>,
        layers: &[LayerHair],
        moved: Moved,
        settings: &SimulationSettings,
    ) -> Result<Option<GpuSolver>, ShaderError> {
        if let Some(mut solver) = self.spare.take() {
            solver.set_settings(settings)?;
            return Ok(Some(solver));
        }
        if self.is_given_up {
            return Ok(None);
        }
        let n_vertices: usize = layers.iter().map(|(layer, binding)| n_moved(moved, layer, binding)).sum();
        if self.is_stale && n_vertices <= QUICK {
            // What is made at once does not wait for what nobody wants any more.
            (self.job, self.is_stale) = (None, false);
        }
        loop {
            if self.job.as_ref().is_some_and(|job| gear.waits || job.is_finished()) {
                let made = self.job.take().map(Job::join);
                if std::mem::take(&mut self.is_stale) {
                    continue;
                }
                let Some((hair, mut solver)) = made.transpose()?.flatten() else { continue };
                self.hair = Some(hair);
                solver.set_settings(settings)?;
                return Ok(Some(solver));
            }
            if self.job.is_some() {
                return Ok(None);
            }
            let (gpu, library, settings) = (gear.gpu.clone(), gear.library.clone(), settings.clone());
            let field = gear.field.cloned();
            let known = self.hair.clone();
            let layers = layers.to_vec();
            let make = move |watch: Watch<'_>| {
                let of_layer = |(layer, binding): &LayerHair| MovedHair::new(moved, layer, binding, field.as_deref());
                let hair = known.unwrap_or_else(|| Arc::new(layers.iter().map(of_layer).collect()));
                watch.progress(DRAWN);
                let of_rest = |share: f32| watch.progress(DRAWN + (1.0 - DRAWN) * share);
                let rest = Watch { on_progress: Some(&of_rest), cancel: watch.cancel };
                let solver = GpuSolver::of_hair_watched(&gpu, &library, &hair, field.as_deref(), &settings, rest)?;
                Ok(solver.map(|solver| (hair, solver)))
            };
            if gear.waits || n_vertices <= QUICK {
                let made = make(Watch::default())?;
                return Ok(made.map(|(hair, solver)| {
                    self.hair = Some(hair);
                    solver
                }));
            }
            match Job::start(make) {
                Ok(job) => self.job = Some(job),
                Err(why) => {
                    let label = "a thread for every strand".to_owned();
                    return Err(ShaderError::Pipeline { label, message: why.to_string() });
                }
            }
        }
    }
}

/// What is moved on a device: what is asked for where its solver has room, else guides; and what to say then.
pub fn moved_on(gpu: &Gpu, moved: Moved, layers: &[LayerHair]) -> (Moved, Option<TooMuchHair>) {
    if moved != Moved::Strands {
        return (moved, None);
    }
    let too_much =
        layers.iter().find_map(|(layer, binding)| check_room(gpu, &layer.name, n_moved(moved, layer, binding)).err());
    (if too_much.is_some() { Moved::Guides } else { moved }, too_much)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;
    use lorelei_core::binding::bind_layer;
    use lorelei_core::groom::Source;
    use lorelei_core::strands::Strands;

    use super::*;

    /// More than is made at once.
    fn many_strands() -> [LayerHair; 1] {
        let mut strands = Strands::default();
        for i in 0..40 {
            let points: Vec<Vec3> = (0..8).map(|k| Vec3::new(i as f32, -1.5 * k as f32, 6.0)).collect();
            strands.push(&points);
        }
        let layer =
            Layer { n_strands: 1100, vertices_per_strand: 64, ..Layer::new("a", Source::Guides(Arc::new(strands))) };
        let layers = [(layer.clone(), Arc::new(bind_layer(&layer, None)))];
        assert!(n_moved(Moved::Strands, &layers[0].0, &layers[0].1) > QUICK);
        layers
    }

    #[test]
    fn what_nobody_wants_to_wait_for_is_not_made_until_there_is_other_hair() {
        let layers = many_strands();
        let (gpu, library) = (Gpu::headless().unwrap(), ShaderLibrary::embedded());
        let gear = Gear { gpu: &gpu, library: &library, field: None, waits: false };
        let settings = SimulationSettings { moved: Moved::Strands, ..SimulationSettings::default() };
        let mut maker = Maker::default();
        let make = |maker: &mut Maker| maker.make(&gear, &layers, Moved::Strands, &settings).unwrap();
        assert!(maker.share().is_none() && make(&mut maker).is_none());
        let is_cancelled = Arc::clone(&maker.job.as_ref().unwrap().is_cancelled);
        assert!(maker.share().is_some_and(|share| (0.0..1.0).contains(&share)));
        maker.give_up();
        assert!(is_cancelled.load(Ordering::Relaxed), "its thread ends early");
        assert!(maker.share().is_none() && make(&mut maker).is_none() && !maker.is_making());
        maker.forget();
        assert!(make(&mut maker).is_none() && maker.is_making());
        let mut last = 0.0;
        while make(&mut maker).is_none() {
            let share = maker.share().unwrap();
            assert!(share >= last, "{share} after {last}");
            last = share;
        }
        assert!(last > 0.0);
    }

    #[test]
    fn every_strand_is_prepared_beside_the_frames_and_what_changed_meanwhile_is_prepared_again() {
        let layers = many_strands();
        let (gpu, library) = (Gpu::headless().unwrap(), ShaderLibrary::embedded());
        let gear = Gear { gpu: &gpu, library: &library, field: None, waits: false };
        let settings = SimulationSettings { moved: Moved::Strands, ..SimulationSettings::default() };
        let mut maker = Maker::default();
        let wait = |maker: &mut Maker| loop {
            if let Some(solver) = maker.make(&gear, &layers, Moved::Strands, &settings).unwrap() {
                return solver;
            }
            assert!(maker.is_making());
            std::thread::sleep(std::time::Duration::from_millis(5));
        };
        assert!(
            maker.make(&gear, &layers, Moved::Strands, &settings).unwrap().is_none(),
            "it takes its time elsewhere"
        );
        maker.forget();
        let solver = wait(&mut maker);
        assert!(!maker.is_making() && maker.hair()[0].curves.n_guides() == 1100);
        // What is kept is there at once, and guides always are.
        maker.put_back(solver);
        assert!(maker.make(&gear, &layers, Moved::Strands, &settings).unwrap().is_some());
        maker.forget();
        assert!(maker.make(&gear, &layers, Moved::Guides, &settings).unwrap().is_some());
        assert_eq!(maker.hair()[0].curves.n_guides(), 40);
        // They do not even wait for strands that nobody wants any more.
        maker.forget();
        assert!(maker.make(&gear, &layers, Moved::Strands, &settings).unwrap().is_none());
        maker.forget();
        assert!(maker.make(&gear, &layers, Moved::Guides, &settings).unwrap().is_some() && !maker.is_making());
    }
}
