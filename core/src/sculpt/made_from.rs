//! What a [`SculptBase`](super::SculptBase) is made from, to tell whether one that was made still holds: preparing
//! it takes longer than a stroke.

use std::sync::{Arc, Weak};

use super::SculptRoots;
use super::guides::shaping;
use crate::groom::{Head, Layer, Source};
use crate::hair_mesh::HairMesh;
use crate::maps::{MapKind, ScalpMap};
use crate::mesh::TriMesh;
use crate::strands::Strands;
use crate::style::StyleOp;

/// The parts of a layer and its head that a base depends on. Keeps nothing alive: large parts are known by where
/// they are, which no other takes as long as a weak reference is held.
#[derive(Debug, Clone)]
pub struct MadeFrom {
    source: WeakSource,
    seed: u32,
    style: Vec<StyleOp>,
    maps: Vec<(MapKind, Weak<ScalpMap>)>,
    head: Option<Weak<TriMesh>>,
    /// The sculpt guides that the layer had, and those that the base has.
    roots: [Weak<SculptRoots>; 2],
}

#[derive(Debug, Clone)]
enum WeakSource {
    HairMesh(Weak<HairMesh>),
    Guides(Weak<Strands>),
    Strands(Weak<Strands>),
}

fn is_of<T>(weak: &Weak<T>, arc: &Arc<T>) -> bool {
    std::ptr::eq(weak.as_ptr(), Arc::as_ptr(arc))
}

impl MadeFrom {
    /// `roots` are those of the base.
    pub fn new(layer: &Layer, head: Option<&Head>, roots: &Arc<SculptRoots>) -> Self {
        let source = match &layer.source {
            Source::HairMesh(mesh) => WeakSource::HairMesh(Arc::downgrade(mesh)),
            Source::Guides(guides) => WeakSource::Guides(Arc::downgrade(guides)),
            Source::Strands(strands) => WeakSource::Strands(Arc::downgrade(strands)),
        };
        Self {
            source,
            seed: layer.seed,
            style: shaping(&layer.style),
            maps: layer.maps.iter().map(|(kind, map)| (kind.clone(), Arc::downgrade(map))).collect(),
            head: head.map(|head| Arc::downgrade(&head.mesh)),
            roots: [&layer.sculpt.roots, roots].map(Arc::downgrade),
        }
    }

    /// Whether a layer and a head are those that the base was made from, or that layer after its first stroke gave
    /// it the base's guides.
    pub fn holds_for(&self, layer: &Layer, head: Option<&Head>) -> bool {
        let has_source = match (&self.source, &layer.source) {
            (WeakSource::HairMesh(a), Source::HairMesh(b)) => is_of(a, b),
            (WeakSource::Guides(a), Source::Guides(b)) | (WeakSource::Strands(a), Source::Strands(b)) => is_of(a, b),
            (WeakSource::HairMesh(_) | WeakSource::Guides(_) | WeakSource::Strands(_), _) => false,
        };
        has_source
            && self.seed == layer.seed
            && self.is_of_head(head)
            && self.roots.iter().any(|roots| is_of(roots, &layer.sculpt.roots))
            && self.style == shaping(&layer.style)
            && self.has_maps_of(layer)
    }

    pub fn is_of_head(&self, head: Option<&Head>) -> bool {
        match (&self.head, head) {
            (Some(a), Some(b)) => is_of(a, &b.mesh),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// Painted length, and what operators of the shape ask.
    fn has_maps_of(&self, layer: &Layer) -> bool {
        let is_asked =
            |kind: &MapKind| *kind == MapKind::Length || self.style.iter().any(|op| op.map.as_ref() == Some(kind));
        let known = self.maps.iter().filter(|(kind, _)| is_asked(kind));
        let asked = layer.maps.iter().filter(|(kind, _)| is_asked(kind));
        known.map(|(kind, map)| (kind, map.as_ptr())).eq(asked.map(|(kind, map)| (kind, Arc::as_ptr(map))))
    }
}
