//! What is computed on the CPU before strands can be drawn: the head's distance field, and what each layer's
//! strands hang on. It takes the longest of all that opening a groom takes, so it needs no GPU, can run on any
//! thread, tells its progress and can be cancelled; nothing changes until the mirror takes it over.
//!
//! Each layer is known again by what it was bound from, wherever it has moved to; another style looks only
//! for the clumps again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lorelei_core::binding::{LayerBinding, rebind_layer};
use lorelei_core::clumps::Clumps;
use lorelei_core::distance_field::{COLLISION_RESOLUTION, DistanceField};
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::hair_mesh::HairMesh;
use lorelei_core::io::Watch;
use lorelei_core::maps::MapKind;
use lorelei_core::sculpt::planting::Planting;

/// A groom's layers bound to their guides and head.
#[derive(Debug, Clone, Default)]
pub struct Bound {
    head: Option<Head>,
    pub(crate) field: Option<Arc<DistanceField>>,
    pub(crate) layers: Vec<BoundLayer>,
    /// About what was computed anew.
    pub(crate) warnings: Vec<String>,
}

#[derive(Debug, Clone)]
pub(crate) struct BoundLayer {
    layer: Layer,
    pub(crate) binding: Arc<LayerBinding>,
    /// The same number: the same roots and weights. The clumps may differ, and the guides may have moved.
    pub(crate) places: u64,
}

/// Share of the work that the distance field is, beside a layer of 100,000 strands.
const FIELD_SHARE: f32 = 0.3;

/// For [`BoundLayer::places`].
fn another_number() -> u64 {
    static N_PLACES: AtomicU64 = AtomicU64::new(0);
    N_PLACES.fetch_add(1, Ordering::Relaxed)
}

impl Bound {
    /// Distances from the head, where there is one.
    pub fn field(&self) -> Option<&Arc<DistanceField>> {
        self.field.as_ref()
    }

    /// What each layer's strands hang on; its guides are what a solver moves.
    pub fn bindings(&self) -> impl Iterator<Item = &Arc<LayerBinding>> {
        self.layers.iter().map(|layer| &layer.binding)
    }

    /// Each layer as it is bound, and what its strands hang on.
    pub fn layers(&self) -> impl Iterator<Item = (&Layer, &Arc<LayerBinding>)> {
        self.layers.iter().map(|layer| (&layer.layer, &layer.binding))
    }

    /// Bind a groom; what is bound alike in `self` is kept. `None` where it was cancelled.
    pub fn update(&self, groom: &Groom, watch: Watch<'_>) -> Option<Self> {
        self.update_with(groom, watch, true)
    }

    /// Something to look at while a groom is bound for the first time: about `n_strands` of its strands, wider,
    /// and not kept out of the head. `None` where that would take as long: imported strands, or few.
    pub fn preview(groom: &Groom, n_strands: usize) -> Option<(Groom, Self)> {
        let share = n_strands as f32 / groom.n_strands().max(1) as f32;
        let is_made = |layer: &Layer| !matches!(layer.source, Source::Strands(_));
        if share > 0.5 || !groom.layers.iter().all(is_made) {
            return None;
        }
        let mut thin = groom.clone();
        for layer in &mut thin.layers {
            layer.n_strands = (layer.n_strands as f32 * share).ceil() as u32;
            layer.radius_um /= share;
            layer.style.iter_mut().for_each(|op| op.kind.scale_clumps(share));
        }
        let bound = Self::default().update_with(&thin, Watch::default(), false)?;
        Some((thin, bound))
    }

    fn update_with(&self, groom: &Groom, watch: Watch<'_>, has_field: bool) -> Option<Self> {
        let mut warnings = Vec::new();
        let is_same_head = self.has_head_of(groom);
        let known: Vec<Option<BoundLayer>> =
            groom.layers.iter().map(|layer| self.known_or_moved(layer).filter(|_| is_same_head)).collect();
        let cost_of = |layer: &Layer, known: &Option<BoundLayer>| -> f32 {
            let cost = if known.is_some() { 0.0 } else { 1.0 };
            cost * layer.n_strands as f32 * 1e-5
        };
        let field_cost = if is_same_head { 0.0 } else { FIELD_SHARE };
        let all: f32 = groom.layers.iter().zip(&known).map(|(layer, known)| cost_of(layer, known)).sum();
        let all = (all + field_cost).max(1e-6);
        let field = match is_same_head {
            true => self.field.clone(),
            false if has_field => field_of(groom.head.as_ref(), &mut warnings),
            false => None,
        };
        let mut done = field_cost;
        let mut layers = Vec::with_capacity(groom.layers.len());
        for (layer, known) in groom.layers.iter().zip(known) {
            let cost = cost_of(layer, &known);
            let before = done;
            let on_progress = |share: f32| watch.progress((before + share * cost) / all);
            let watch = Watch { on_progress: Some(&on_progress), cancel: watch.cancel };
            let similar = self.similar(layer).filter(|_| is_same_head);
            layers.push(bind(layer, known.as_ref(), similar, groom.head.as_ref(), watch, &mut warnings)?);
            done += cost;
        }
        Some(Self { head: groom.head.clone(), field, layers, warnings })
    }

    /// Whether [`Bound::update`] has more to do than what is done within a frame.
    pub fn is_behind(&self, groom: &Groom) -> bool {
        let is_current = |layer: &Layer| {
            // Maps other than density are asked again within a frame.
            let is_current = |known: &BoundLayer| known.has_clumps_of(layer) && known.has_sculpt_of(layer);
            self.known(layer).is_some_and(is_current) || self.same_strands(layer).is_some_and(is_current)
        };
        !self.has_head_of(groom) || !groom.layers.iter().all(is_current)
    }

    /// The layer that was bound alike but for what its hair mesh is above the root layer; best one with the same
    /// faces.
    fn same_strands(&self, layer: &Layer) -> Option<&BoundLayer> {
        let Source::HairMesh(mesh) = &layer.source else { return None };
        let alike = |is_alike: fn(&HairMesh, &HairMesh) -> bool| {
            self.layers.iter().find(|known| match &known.layer.source {
                Source::HairMesh(before) => has_same_places(&known.layer, layer) && is_alike(before, mesh),
                Source::Guides(_) | Source::Strands(_) => false,
            })
        };
        alike(HairMesh::differs_in_shape_only).or_else(|| alike(HairMesh::grows_the_same_strands))
    }

    fn has_head_of(&self, groom: &Groom) -> bool {
        match (&self.head, &groom.head) {
            (Some(a), Some(b)) => Arc::ptr_eq(&a.mesh, &b.mesh),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }

    /// A layer whose roots were chosen among the same places: only density, count or style are others.
    fn similar(&self, layer: &Layer) -> Option<&LayerBinding> {
        let is_similar =
            |known: &&BoundLayer| known.layer.seed == layer.seed && known.layer.source.is_same(&layer.source);
        self.layers.iter().find(is_similar).map(|known| &*known.binding)
    }

    fn known_or_moved(&self, layer: &Layer) -> Option<BoundLayer> {
        self.known(layer).cloned().or_else(|| {
            let known = self.same_strands(layer)?;
            let (Source::HairMesh(before), Source::HairMesh(mesh)) = (&known.layer.source, &layer.source) else {
                return None;
            };
            if before.differs_in_shape_only(mesh) {
                return Some(BoundLayer { binding: Arc::new(known.binding.moved(mesh)), ..known.clone() });
            }
            let binding = Arc::new(known.binding.regrown(before, mesh)?);
            Some(BoundLayer { binding, places: another_number(), ..known.clone() })
        })
    }

    /// The layer that was bound alike, best with the same clumps.
    fn known(&self, layer: &Layer) -> Option<&BoundLayer> {
        let mut alike = self.layers.iter().filter(|known| binds_alike(&known.layer, layer));
        let first = alike.clone().next();
        alike.find(|known| known.is_current(layer)).or(first)
    }
}

impl BoundLayer {
    fn is_current(&self, layer: &Layer) -> bool {
        self.has_clumps_of(layer)
            && self.has_maps_of(layer)
            && self.has_sculpt_of(layer)
            && self.layer.tied == layer.tied
    }

    /// Was it bound to the layer's sculpt guides? Where it has none, others do no harm.
    fn has_sculpt_of(&self, layer: &Layer) -> bool {
        let roots = &layer.sculpt.roots;
        roots.positions.is_empty() || self.binding.sculpt.are_of(roots, self.binding.n_strands())
    }

    fn has_clumps_of(&self, layer: &Layer) -> bool {
        Clumps::sizes_of(&layer.style) == self.binding.clumps.sizes
    }

    /// Was it bound with these painted maps? Density is compared where places are.
    fn has_maps_of(&self, layer: &Layer) -> bool {
        let of = |layer: &Layer| -> Vec<_> {
            let maps = layer.maps.iter().filter(|(kind, _)| **kind != MapKind::Density);
            maps.map(|(kind, map)| (kind.clone(), Arc::as_ptr(map))).collect()
        };
        of(&self.layer) == of(layer)
    }
}

fn field_of(head: Option<&Head>, warnings: &mut Vec<String>) -> Option<Arc<DistanceField>> {
    let head = head?;
    match DistanceField::from_mesh(&head.mesh, COLLISION_RESOLUTION) {
        Ok(field) => Some(Arc::new(field)),
        Err(error) => {
            warnings.push(format!("Strands are not kept out of {}: {error}", head.name));
            None
        }
    }
}

fn bind(
    layer: &Layer,
    known: Option<&BoundLayer>,
    similar: Option<&LayerBinding>,
    head: Option<&Head>,
    watch: Watch<'_>,
    warnings: &mut Vec<String>,
) -> Option<BoundLayer> {
    if known.is_none_or(|known| known.layer.style != layer.style) {
        warnings.extend(layer.warning());
    }
    if let Some(known) = known {
        let mut bound = BoundLayer { layer: layer.clone(), ..known.clone() };
        if !known.is_current(layer) {
            let mut binding = LayerBinding::clone(&known.binding);
            binding.restyle(&layer.style);
            binding.resample_maps(layer);
            binding.resculpt(layer, head);
            bound.binding = Arc::new(binding);
        }
        return Some(bound);
    }
    if let Source::HairMesh(mesh) = &layer.source
        && let Err(error) = mesh.check()
    {
        warnings.push(format!("{} has no hair: {error}", layer.name));
    }
    let binding = Arc::new(rebind_layer(layer, head, similar, watch)?);
    Some(BoundLayer { layer: layer.clone(), binding, places: another_number() })
}

/// Do two layers have the same guides, roots and weights?
fn binds_alike(a: &Layer, b: &Layer) -> bool {
    a.source.is_same(&b.source) && has_same_places(a, b)
}

/// Do two layers of the same source have the same strands?
fn has_same_places(a: &Layer, b: &Layer) -> bool {
    let same_density = match (a.density(), b.density()) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    let same_planting = a.has_same_sculpt(b) || Planting::of(a) == Planting::of(b);
    same_density && same_planting && (a.n_strands, a.count, a.seed) == (b.n_strands, b.count, b.seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lorelei_core::hair_mesh::{Along, MeshOp, Weld};

    /// A strip of four quads with two layers above.
    fn strip() -> HairMesh {
        let positions = (0..10).map(|i| Vec3::new((i / 2) as f32, 0.0, (i % 2) as f32)).collect();
        let faces = (0..4).map(|i| vec![2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2]).collect();
        let mut mesh = HairMesh::from_polygons(positions, faces).unwrap();
        mesh.apply(&extrude(vec![0, 1, 2])).unwrap();
        mesh
    }

    fn extrude(bundles: Vec<usize>) -> MeshOp {
        MeshOp::Extrude {
            bundles,
            along: Along::Direction(Vec3::Y),
            length_cm: 2.0,
            n_layers: 2,
            weld: Weld::Neighbours,
        }
    }

    fn groom_of(mesh: HairMesh) -> Groom {
        let layer = Layer { n_strands: 500, ..Layer::new("strip", Source::HairMesh(Arc::new(mesh))) };
        Groom { layers: vec![layer], ..Groom::default() }
    }

    #[test]
    fn what_changes_above_the_roots_is_bound_within_a_frame_and_as_from_scratch() {
        let scratch = |groom: &Groom| Bound::default().update(groom, Watch::default()).unwrap();
        let before = scratch(&groom_of(strip()));
        let mut moved = strip();
        moved.move_vertices(1, |_, p| p + Vec3::X);
        let mut longer = strip();
        longer.apply(&extrude(vec![1])).unwrap();
        for (mesh, has_same_guides) in [(moved, true), (longer, false)] {
            let groom = groom_of(mesh);
            assert!(!before.is_behind(&groom));
            let after = before.update(&groom, Watch::default()).unwrap();
            assert!(after.layers[0].binding == scratch(&groom).layers[0].binding);
            // The number tells the GPU's side whether it has room for the guides.
            assert_eq!(after.layers[0].places == before.layers[0].places, has_same_guides);
        }
        let mut wider = strip();
        wider.apply(&extrude(vec![3])).unwrap();
        assert!(before.is_behind(&groom_of(wider)), "other faces of the scalp grow other strands");
    }
}
