//! What brushes need to know of the hair, prepared on a thread: the guides' places and paths, and the head.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use lorelei_core::distance_field::{COLLISION_RESOLUTION, DistanceField};
use lorelei_core::groom::{Head, Layer, Source};
use lorelei_core::mesh::TriMesh;
use lorelei_core::sculpt::{SculptBase, SculptRoots};

/// What a preparation is made from.
#[derive(Clone)]
struct Of {
    source: Source,
    seed: u32,
    roots: Arc<SculptRoots>,
    head: Option<Arc<TriMesh>>,
}

impl Of {
    fn is_of(&self, layer: &Layer, head: Option<&Head>) -> bool {
        let has_head = match (&self.head, head) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, &b.mesh),
            (a, b) => a.is_none() && b.is_none(),
        };
        has_head && self.is_of_source(layer) && Arc::ptr_eq(&self.roots, &layer.sculpt.roots)
    }

    fn is_of_source(&self, layer: &Layer) -> bool {
        let is_same = match (&self.source, &layer.source) {
            (Source::HairMesh(a), Source::HairMesh(b)) => Arc::ptr_eq(a, b),
            (Source::Guides(a), Source::Guides(b)) | (Source::Strands(a), Source::Strands(b)) => Arc::ptr_eq(a, b),
            (Source::HairMesh(_) | Source::Guides(_) | Source::Strands(_), _) => false,
        };
        is_same && self.seed == layer.seed
    }
}

type Field = Option<Arc<DistanceField>>;

/// The newest preparation.
#[derive(Default)]
pub struct Preparation {
    ready: Option<(Of, Arc<SculptBase>)>,
    running: Option<(Of, Receiver<SculptBase>)>,
    field: Option<(Arc<TriMesh>, Field)>,
}

impl Preparation {
    /// Prepare what is not, and take over what has been.
    pub fn follow(&mut self, ctx: &egui::Context, layer: &Layer, head: Option<&Head>) {
        if let Some((of, receiver)) = &self.running {
            match receiver.try_recv() {
                Ok(base) => {
                    if let Some(mesh) = &of.head {
                        self.field = Some((Arc::clone(mesh), base.field.clone()));
                    }
                    self.ready = Some((of.clone(), Arc::new(base)));
                    self.running = None;
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => self.running = None,
            }
        }
        let is_ready = self.ready.as_ref().is_some_and(|(of, base)| {
            // The first stroke gives the layer the guides that were prepared for it.
            of.is_of(layer, head) || (of.is_of_source(layer) && Arc::ptr_eq(&base.roots, &layer.sculpt.roots))
        });
        if is_ready {
            return;
        }
        let of = Of {
            source: layer.source.clone(),
            seed: layer.seed,
            roots: Arc::clone(&layer.sculpt.roots),
            head: head.map(|head| Arc::clone(&head.mesh)),
        };
        let field = match (&self.field, &of.head) {
            (Some((mesh, field)), Some(head)) if Arc::ptr_eq(mesh, head) => Some(field.clone()),
            _ => None,
        };
        let (sender, receiver) = channel();
        let (ctx, layer, head) = (ctx.clone(), layer.clone(), head.cloned());
        let thread = std::thread::Builder::new().name("sculpt".to_owned()).spawn(move || {
            let head = head.as_ref();
            let field = field.unwrap_or_else(|| {
                let field = DistanceField::from_mesh(&head?.mesh, COLLISION_RESOLUTION);
                field.ok().map(Arc::new)
            });
            let known = &layer.sculpt.roots;
            let roots = known.covering(&layer, head).map_or_else(|| Arc::clone(known), Arc::new);
            // Where the window has gone on meanwhile, nobody listens.
            drop(sender.send(SculptBase::new(&layer, head, roots, field)));
            ctx.request_repaint();
        });
        match thread {
            Ok(_) => self.running = Some((of, receiver)),
            Err(why) => log::error!("the hair cannot be prepared for brushes: {why}"),
        }
    }

    /// What was prepared for a layer, where it is ready.
    pub fn base(&self, layer: &Layer) -> Option<Arc<SculptBase>> {
        let (of, base) = self.ready.as_ref()?;
        let has_guides = Arc::ptr_eq(&base.roots, &layer.sculpt.roots) || Arc::ptr_eq(&of.roots, &layer.sculpt.roots);
        (of.is_of_source(layer) && has_guides).then(|| Arc::clone(base))
    }

    pub fn is_ready(&self) -> bool {
        self.ready.is_some() && self.running.is_none()
    }

    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }
}
