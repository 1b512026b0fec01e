//! What brushes need to know of the hair, prepared on a thread: the guides' places and paths, and the head.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use lorelei_core::distance_field::DistanceField;
use lorelei_core::groom::{Head, Layer};
use lorelei_core::mesh::TriMesh;
use lorelei_core::sculpt::{MadeFrom, SculptBase};

type Field = Option<Arc<DistanceField>>;
/// A base, what it was made from, and the head that its field is of.
type Made = (MadeFrom, Arc<SculptBase>, Option<Arc<TriMesh>>);

/// The newest preparation.
#[derive(Default)]
pub struct Preparation {
    ready: Option<(MadeFrom, Arc<SculptBase>)>,
    running: Option<Receiver<Made>>,
    field: Option<(Arc<TriMesh>, Field)>,
}

impl Preparation {
    /// Prepare what is not, and take over what has been.
    pub fn follow(&mut self, ctx: &egui::Context, layer: &Layer, head: Option<&Head>) {
        if let Some(receiver) = &self.running {
            match receiver.try_recv() {
                Ok((of, base, head)) => {
                    if let Some(mesh) = head {
                        self.field = Some((mesh, base.field.clone()));
                    }
                    self.ready = Some((of, base));
                    self.running = None;
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => self.running = None,
            }
        }
        if self.ready.as_ref().is_some_and(|(of, _)| of.holds_for(layer, head)) {
            return;
        }
        let field = match (&self.field, head) {
            (Some((mesh, field)), Some(head)) if Arc::ptr_eq(mesh, &head.mesh) => Some(field.clone()),
            _ => None,
        };
        let (sender, receiver) = channel();
        let (ctx, layer, head) = (ctx.clone(), layer.clone(), head.cloned());
        let thread = std::thread::Builder::new().name("sculpt".to_owned()).spawn(move || {
            let head = head.as_ref();
            let base = Arc::new(SculptBase::prepare(&layer, head, field));
            let of = MadeFrom::new(&layer, head, &base.roots);
            // Where the window has gone on meanwhile, nobody listens.
            drop(sender.send((of, base, head.map(|head| Arc::clone(&head.mesh)))));
            ctx.request_repaint();
        });
        match thread {
            Ok(_) => self.running = Some(receiver),
            Err(why) => log::error!("the hair cannot be prepared for brushes: {why}"),
        }
    }

    /// What was prepared for a layer, where it is ready.
    pub fn base(&self, layer: &Layer, head: Option<&Head>) -> Option<Arc<SculptBase>> {
        let (of, base) = self.ready.as_ref()?;
        of.holds_for(layer, head).then(|| Arc::clone(base))
    }

    pub fn is_ready(&self) -> bool {
        self.ready.is_some() && self.running.is_none()
    }

    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }
}
