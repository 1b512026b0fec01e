//! What a layer's strands hang on: guides, each strand's root, its weights and its clumps, all at rest.
//!
//! Everything here changes only when the groom is edited. Per frame only the guides move, and generation
//! (`generate/`, `generate.wgsl`) reads both. Strands are in their order of detail: the first n strands
//! of a layer are a good n strands.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

mod of_guides;
mod of_hair_mesh;
mod places;
mod regrown;
mod scatter;

use crate::clumps::{BundleReach, Clumps, Path};
use crate::groom::{Head, Layer, Source, StrandCount};
use crate::guides::{GuideSet, Influence};
use crate::hair_mesh::HairMesh;
use crate::hash::combine;
use crate::io::Watch;
use crate::maps::MapKind;
use crate::sculpt::SculptShares;
use crate::strands::Strands;
use crate::style::StyleOp;

pub(crate) use of_guides::{scalp_places, spaced_grid};
pub(crate) use places::{bind_places, same_side};

use of_guides::{bind_guides, three_guides};
use of_hair_mesh::{bind_hair_mesh, root_layer_normals};
use scatter::{Place, Places, Scalp};

/// A layer's strands as shares in guides. All arrays per strand are `n_strands()` long.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LayerBinding {
    pub guides: GuideSet,
    /// Parameters of the guides' vertices, 0 root to 1 tip, one run of `guides.n_vertices` for every height of bundle.
    pub knots: Vec<f32>,
    /// Per strand: where its run begins in `knots`.
    pub first_knots: Vec<u32>,
    /// Per strand its bundle; empty where the source is no hair mesh.
    pub bundles: Vec<u32>,
    /// Which bundles may share a clump.
    pub reach: Option<Arc<BundleReach>>,
    /// Strand `s` has `influences[influence_offsets[s]..influence_offsets[s + 1]]`.
    pub influence_offsets: Vec<u32>,
    pub influences: Vec<Influence>,
    /// Stable ids: they stay with their strands when density or count change.
    pub ids: Vec<u32>,
    /// Hash of id and layer seed: where all of a strand's random numbers come from.
    pub seeds: Vec<u32>,
    /// On the scalp, head space, centimetres.
    pub roots: Vec<Vec3>,
    /// Unit vectors out of the scalp.
    pub root_normals: Vec<Vec3>,
    /// Texture coordinates on the scalp ([`scalp_uvs`]); empty where there is no head.
    pub root_uvs: Vec<[f32; 2]>,
    /// From where the guides put the root to where it is: chords of a hair mesh's faces lie under the
    /// scalp, guides beside their strands.
    pub root_offsets: Vec<Vec3>,
    /// Share of the root's offset that is left at the tip: 0 in a hair mesh, 1 beside guides.
    pub offset_at_tip: f32,
    /// Radius of each strand as a share of the layer's; empty is 1.
    pub radius_scales: Vec<f32>,
    /// The painted maps whose values `map_values` holds: all of the layer but its density.
    pub maps: Vec<MapKind>,
    /// What each of `maps` says at the strand's root, in its own measure ([`MapKind::max_value`]): strand `s` has
    /// `map_values[s * maps.len()..]`.
    pub map_values: Vec<f32>,
    /// Share of every strand, from the root, that the layer ties, 0-1; the painted map can say more.
    pub tied: f32,
    /// Where strands may stand, for another density; `None` where they stand where they were imported.
    places: Option<Arc<Places>>,
    pub clumps: Clumps,
    /// Each strand's share in the layer's sculpt guides.
    pub sculpt: SculptShares,
}

/// How a curve of hair is held to the style while the rest moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tie {
    /// Share of it, from the root, that is tied, 0-1.
    pub tied: f32,
    /// Share of the roots' hold that it has along its whole length, 0-1.
    pub hold: f32,
}

impl Tie {
    pub fn up_to(tied: f32) -> Self {
        Self { tied, hold: 0.0 }
    }

    fn up_to_at_least(self, tied: f32) -> Self {
        Self { tied: self.tied.clamp(tied.clamp(0.0, 1.0), 1.0), ..self }
    }
}

/// A mean of ties by weights.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MeanTie {
    sum: Tie,
    weight: f32,
}

impl MeanTie {
    pub(crate) fn add(&mut self, tie: Tie, weight: f32) {
        let Tie { tied, hold } = self.sum;
        self.sum = Tie { tied: tied + weight * tie.tied, hold: hold + weight * tie.hold };
        self.weight += weight;
    }

    /// Of none it is no tie.
    pub(crate) fn tie(self) -> Tie {
        let weight = if self.weight > 0.0 { self.weight } else { 1.0 };
        Tie { tied: self.sum.tied / weight, hold: self.sum.hold / weight }
    }
}

/// Most strands of a layer; a document that asks for more gets these.
pub const MOST_STRANDS: u32 = 4_000_000;
/// Strands that tell what share of them a density leaves.
const N_COUNTED: u32 = 4000;
/// Guides whose paths differ by more than this (cosine) are on two sides of a parting.
const PARTED: f32 = 0.3;

/// Bind a layer's strands to its guides. `head` gives roots their exact place, normal and texture
/// coordinates, where it is near.
pub fn bind_layer(layer: &Layer, head: Option<&Head>) -> LayerBinding {
    bind_layer_watched(layer, head, Watch::default()).unwrap_or_default()
}

/// As [`bind_layer`]; `None` where it was cancelled. A cancel counts between two steps of the work.
pub fn bind_layer_watched(layer: &Layer, head: Option<&Head>, watch: Watch<'_>) -> Option<LayerBinding> {
    rebind_layer(layer, head, None, watch)
}

/// As [`bind_layer_watched`], where a layer with the same source, seed and head was bound before: painting
/// density or asking for other counts then only chooses among places that are known.
pub fn rebind_layer(
    layer: &Layer,
    head: Option<&Head>,
    known: Option<&LayerBinding>,
    watch: Watch<'_>,
) -> Option<LayerBinding> {
    let known = known.and_then(|known| known.places.clone());
    let done = |share: f32| {
        watch.progress(share);
        (!watch.cancelled()).then_some(())
    };
    done(0.0)?;
    let scalp = head.and_then(|head| Scalp::new(&head.mesh));
    done(0.05)?;
    let mut binding = match &layer.source {
        Source::HairMesh(mesh) => bind_hair_mesh(layer, mesh, scalp.as_ref(), known),
        Source::Guides(guides) => bind_guides(layer, guides, scalp.as_ref(), known),
        Source::Strands(strands) => bind_strands(layer, strands, scalp.as_ref()),
    };
    done(0.6)?;
    binding.resample_maps(layer);
    binding.restyle(&layer.style);
    done(0.9)?;
    binding.resculpt(layer, head);
    done(1.0)?;
    Some(binding)
}

/// The layer with its strands counted [`StrandCount::WhereFull`], so that painting density moves none, and about
/// as many of them as before.
pub fn counted_where_full(layer: &Layer, head: Option<&Head>) -> Layer {
    let mut counted = Layer { count: StrandCount::WhereFull, ..layer.clone() };
    if layer.count == StrandCount::Total && layer.density().is_some() && !matches!(layer.source, Source::Strands(_)) {
        let few = |layer: &Layer| Layer { n_strands: N_COUNTED, style: Vec::new(), ..layer.clone() };
        let left = bind_layer(&few(&counted), head).n_strands().max(1) as f32 / N_COUNTED as f32;
        counted.n_strands = ((layer.n_strands as f32 / left).round() as u32).clamp(layer.n_strands, MOST_STRANDS);
    }
    counted
}

impl LayerBinding {
    pub fn n_strands(&self) -> usize {
        self.ids.len()
    }

    pub fn influences(&self, strand_idx: usize) -> &[Influence] {
        &self.influences[self.influence_offsets[strand_idx] as usize..self.influence_offsets[strand_idx + 1] as usize]
    }

    /// Find the clumps again for another style stack; nothing else depends on it.
    pub fn restyle(&mut self, style: &[StyleOp]) {
        if Clumps::sizes_of(style) == self.clumps.sizes
            && self.clumps.middles.len() == self.n_strands() * self.clumps.sizes.len()
        {
            return;
        }
        self.clumps = Clumps::of_style(style, &self.paths(), self.reach.as_deref());
    }

    /// What clumps are found by.
    fn paths(&self) -> Vec<Path> {
        let n_vertices = self.guides.n_vertices as usize;
        let at = |strand_idx: usize, vertex: usize| -> Vec3 {
            self.influences(strand_idx)
                .iter()
                .map(|i| i.weight * self.guides.positions[i.guide_idx as usize * n_vertices + vertex])
                .sum()
        };
        (0..self.n_strands())
            .into_par_iter()
            .map(|strand_idx| {
                if let Some(&bundle) = self.bundles.get(strand_idx) {
                    return Path { root: self.roots[strand_idx], bundle, ..Path::default() };
                }
                let root = at(strand_idx, 0);
                Path {
                    bundle: 0,
                    root: self.roots[strand_idx],
                    to_middle: at(strand_idx, (n_vertices - 1) * 2 / 5) - root,
                    to_tip: at(strand_idx, n_vertices - 1) - root,
                }
            })
            .collect()
    }

    /// Where each strand's run begins in the knots of a hair mesh, by the height of its bundle.
    fn first_knots_in(&self, mesh: &HairMesh) -> Vec<u32> {
        let n_gaps = |bundle: u32| mesh.tip_layer(bundle as usize).unwrap_or(0) as u32;
        self.bundles.iter().map(|&bundle| n_gaps(bundle) * self.guides.n_vertices).collect()
    }

    /// The same strands of a hair mesh whose vertices above the root layer have moved: see
    /// [`HairMesh::differs_in_shape_only`].
    pub fn moved(&self, mesh: &HairMesh) -> Self {
        let (guides, knots) = GuideSet::of_chains(mesh, &mesh.chains());
        Self { guides, knots, ..self.clone() }
    }

    /// Ask the layer's painted maps again; nothing else depends on them, density apart.
    pub fn resample_maps(&mut self, layer: &Layer) {
        let maps: Vec<_> = layer.maps.iter().filter(|(kind, _)| **kind != MapKind::Density).collect();
        self.maps = maps.iter().map(|(kind, _)| (*kind).clone()).collect();
        self.map_values = vec![0.0; maps.len() * self.n_strands()];
        for (i, (kind, map)) in maps.iter().enumerate() {
            let value = |strand_idx: usize| match self.root_uvs.get(strand_idx) {
                Some(&uv) => map.sample(uv) * kind.max_value(),
                None => kind.default_value(),
            };
            let column = self.map_values.par_iter_mut().skip(i).step_by(maps.len());
            column.enumerate().for_each(|(strand_idx, out)| *out = value(strand_idx));
        }
        self.tied = layer.tied.clamp(0.0, 1.0);
    }

    /// How each guide is held to the style: as the layer says, or the mean of what is painted at the roots of its strands,
    /// by their shares in it.
    pub fn guide_ties(&self) -> Vec<Tie> {
        let mut ties = vec![Tie::up_to(self.tied); self.guides.n_guides()];
        let Some(painted) = self.painted_ties() else { return ties };
        let mut means = vec![MeanTie::default(); ties.len()];
        for strand_idx in 0..self.n_strands() {
            let tie = painted(strand_idx);
            for influence in self.influences(strand_idx) {
                means[influence.guide_idx as usize].add(tie, influence.weight);
            }
        }
        for (tie, mean) in ties.iter_mut().zip(means) {
            *tie = mean.tie().up_to_at_least(self.tied);
        }
        ties
    }

    /// How each strand is held to the style.
    pub fn strand_ties(&self) -> Vec<Tie> {
        match self.painted_ties() {
            Some(painted) => (0..self.n_strands()).map(|s| painted(s).up_to_at_least(self.tied)).collect(),
            None => vec![Tie::up_to(self.tied); self.n_strands()],
        }
    }

    /// What is painted about it at a strand's root; `None` where nothing is.
    fn painted_ties(&self) -> Option<impl Fn(usize) -> Tie> {
        let [tied, hold] = [MapKind::Tied, MapKind::Hold].map(|kind| self.map_idx(&kind));
        let at = |strand_idx, map_idx| self.map_value(strand_idx, map_idx, 0.0);
        let is_painted = tied.is_some() || hold.is_some();
        is_painted.then_some(move |strand_idx| Tie { tied: at(strand_idx, tied), hold: at(strand_idx, hold) })
    }

    /// The index of a map in `maps`; `None` where the layer has none of this kind, so that its default applies.
    pub fn map_idx(&self, kind: &MapKind) -> Option<usize> {
        self.maps.iter().position(|known| known == kind)
    }

    /// What a map says at a strand's root: see [`LayerBinding::map_idx`].
    pub fn map_value(&self, strand_idx: usize, map_idx: Option<usize>, default: f32) -> f32 {
        map_idx.map_or(default, |i| self.map_values[strand_idx * self.maps.len() + i])
    }

    /// Find the shares in the sculpt guides again, where the layer has others; nothing else depends on it.
    pub fn resculpt(&mut self, layer: &Layer, head: Option<&Head>) {
        if !self.sculpt.are_of(&layer.sculpt.roots, self.n_strands()) {
            self.sculpt = SculptShares::find(self, layer, head);
        }
    }

    /// Bytes held by the arrays.
    pub fn n_bytes(&self) -> usize {
        self.guides.n_bytes()
            + size_of_val(self.knots.as_slice())
            + size_of_val(self.first_knots.as_slice())
            + size_of_val(self.bundles.as_slice())
            + size_of_val(self.influence_offsets.as_slice())
            + size_of_val(self.influences.as_slice())
            + self.n_strands() * (2 * 4 + 3 * 12)
            + size_of_val(self.root_uvs.as_slice())
            + size_of_val(self.radius_scales.as_slice())
            + size_of_val(self.map_values.as_slice())
            + self
                .places
                .as_ref()
                .map_or(0, |places| size_of_val(places.roots.as_slice()) + size_of_val(places.places.as_slice()))
            + size_of_val(self.clumps.middles.as_slice())
            + size_of_val(self.sculpt.shares.as_slice())
    }

    fn with_capacity(guides: GuideSet, n_strands: usize) -> Self {
        Self {
            knots: guides.even_knots(),
            guides,
            influence_offsets: Vec::from([0]),
            influences: Vec::with_capacity(4 * n_strands),
            ids: Vec::with_capacity(n_strands),
            seeds: Vec::with_capacity(n_strands),
            ..Self::default()
        }
    }

    /// Append a strand's weights; those without effect are left out.
    fn push_influences(&mut self, influences: impl IntoIterator<Item = Influence>) {
        self.influences.extend(influences.into_iter().filter(|i| i.weight.abs() > 1e-6));
        self.influence_offsets.push(self.influences.len() as u32);
    }

    fn push_id(&mut self, id: u32, layer: &Layer) {
        self.first_knots.push(0);
        self.ids.push(id);
        self.seeds.push(combine(id, layer.seed));
    }

    fn push_place(&mut self, place: &Place, scalp: Option<&Scalp<'_>>) {
        self.roots.push(place.position);
        self.root_normals.push(place.normal);
        if scalp.is_some() {
            self.root_uvs.push(place.uv);
        }
    }

    /// Compute each root's offset from where its guides begin.
    fn measure_offsets(&mut self) {
        let n_vertices = self.guides.n_vertices as usize;
        self.root_offsets = (0..self.n_strands())
            .map(|strand_idx| {
                let of_guides: Vec3 = self
                    .influences(strand_idx)
                    .iter()
                    .map(|i| i.weight * self.guides.positions[i.guide_idx as usize * n_vertices])
                    .sum();
                self.roots[strand_idx] - of_guides
            })
            .collect();
    }
}

fn bind_strands(layer: &Layer, strands: &Strands, scalp: Option<&Scalp<'_>>) -> LayerBinding {
    let guides = GuideSet::of_strands(strands);
    // Files list strands by region: a hashed order is a fair order of detail.
    let mut order: Vec<u32> =
        (0..strands.n_strands() as u32).filter(|&s| strands.strand(s as usize).len() >= 2).collect();
    order.sort_by_cached_key(|&s| (combine(strands.id(s as usize), 0x51A7), s));
    let n_roots = order.len().max(1) as f32;
    let middle = order.iter().map(|&s| strands.strand(s as usize)[0]).sum::<Vec3>() / n_roots;
    let places: Vec<Place> = order
        .par_iter()
        .map(|&s| {
            let root = strands.strand(s as usize)[0];
            let mut place = scalp.and_then(|scalp| scalp.project(root)).unwrap_or_else(|| Place {
                position: root,
                normal: (root - middle).normalize_or(Vec3::Y),
                uv: [0.0; 2],
            });
            if let Some(&uv) = strands.root_uvs.get(s as usize) {
                place.uv = uv;
            }
            Place { position: root, ..place }
        })
        .collect();
    let n = strands.n_strands();
    let mut binding = LayerBinding::with_capacity(guides, n);
    for (&s, place) in order.iter().zip(&places) {
        binding.push_influences([Influence { guide_idx: s, weight: 1.0 }]);
        binding.push_id(strands.id(s as usize), layer);
        binding.push_place(place, scalp);
    }
    if !strands.radii_um.is_empty() {
        let root_radius = |s: u32| strands.radii_um[strands.range(s as usize).start];
        let mean = order.iter().map(|&s| root_radius(s)).sum::<f32>() / n_roots;
        binding.radius_scales = order.iter().map(|&s| if mean > 0.0 { root_radius(s) / mean } else { 1.0 }).collect();
    }
    binding.measure_offsets();
    binding
}
