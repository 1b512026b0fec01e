//! What a layer's strands hang on: guides, each strand's root, its weights and its clumps, all at rest.
//!
//! Everything here changes only when the groom is edited. Per frame only the guides move, and generation
//! (`generate/`, `generate.wgsl`) reads both. Strands are in their order of detail: the first n strands
//! of a layer are a good n strands.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

mod places;
mod regrown;

use crate::clumps::{BundleReach, Clumps, Path};
use crate::groom::{Head, Layer, Source, StrandCount};
use crate::guides::{GuideSet, Influence};
use crate::hair_mesh::HairMesh;
use crate::hash::{combine, random};
use crate::io::Watch;
use crate::maps::uvs::scalp_uvs;
use crate::maps::{MapKind, ScalpMap};
use crate::mean_value::mean_value_weights;
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;
use crate::point_grid::PointGrid;
use crate::roots::{Root, RootSurface, key, select};
use crate::sculpt::SculptShares;
use crate::sculpt::planted::PLANTED;
use crate::sculpt::planting::{Planting, PlantingField};
use crate::strands::Strands;
use crate::style::StyleOp;

pub(crate) use places::{bind_places, same_side};

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
    /// Where strands may stand, for another density; `None` where they stand where they were imported.
    places: Option<Arc<Places>>,
    pub clumps: Clumps,
    /// Each strand's share in the layer's sculpt guides.
    pub sculpt: SculptShares,
}

/// Root layers farther from the head than this were not meant to lie on it, in centimetres.
const FARTHEST_ROOT: f32 = 2.0;
/// Most strands of a layer; a document that asks for more gets these.
pub const MOST_STRANDS: u32 = 4_000_000;
/// Most places of a sequence that are looked at for painted density, for each strand wanted: a map that
/// is nearly empty gives fewer strands than asked for.
const MOST_PLACES_A_STRAND: usize = 100;
/// Most of them in all, where there are more than strands.
const MOST_PLACES: usize = 3_000_000;
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

/// A beginning of a root sequence with each root's place; `None` where none can be.
#[derive(Debug, Clone, PartialEq, Default)]
struct Places {
    roots: Vec<Root>,
    places: Vec<Option<Place>>,
}

/// A root's place on the scalp.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    position: Vec3,
    normal: Vec3,
    uv: [f32; 2],
}

/// The triangles that grow hair ([`TriMesh::scalp_triangles`]).
struct Scalp<'a> {
    mesh: &'a TriMesh,
    triangles: Vec<u32>,
    query: MeshQuery,
    normals: Cow<'a, [Vec3]>,
    uvs: Cow<'a, [[f32; 2]]>,
}

impl<'a> Scalp<'a> {
    fn new(mesh: &'a TriMesh) -> Option<Self> {
        let triangles = mesh.scalp_triangles();
        let query = MeshQuery::of_triangles(mesh, triangles.iter().copied()).ok()?;
        let normals = mesh.vertex_normals();
        Some(Self { mesh, triangles, query, normals, uvs: scalp_uvs(mesh) })
    }

    fn at(&self, triangle_idx: u32, barycentric: [f32; 3], position: Vec3) -> Place {
        let vertices = self.mesh.triangles[triangle_idx as usize].map(|v| v as usize);
        let mut place = Place { position, normal: Vec3::ZERO, uv: [0.0; 2] };
        for (v, w) in vertices.into_iter().zip(barycentric) {
            place.normal += w * self.normals[v];
            place.uv[0] += w * self.uvs[v][0];
            place.uv[1] += w * self.uvs[v][1];
        }
        place.normal = place.normal.normalize_or(Vec3::Y);
        place
    }

    /// The nearest place on the scalp, where one is near enough.
    fn project(&self, p: Vec3) -> Option<Place> {
        let hit = self.query.closest_within(p, FARTHEST_ROOT)?;
        Some(self.at(hit.triangle_idx, hit.barycentric.to_array(), hit.position))
    }
}

/// How dense a layer's strands are over the scalp.
struct Density<'a> {
    /// Painted, 0-1.
    map: Option<&'a ScalpMap>,
    /// Above 1 where hair was planted.
    planting: Option<(PlantingField<'a>, f32)>,
}

impl<'a> Density<'a> {
    fn new(map: Option<&'a ScalpMap>, planting: Option<&'a Planting>) -> Self {
        Self { map, planting: planting.map(|planting| (planting.field(), planting.most())) }
    }

    fn painted(&self, place: Option<&Place>) -> f32 {
        place.map_or(0.0, |place| self.map.map_or(1.0, |map| map.sample(place.uv)))
    }

    /// Those of a sequence whose keys are below `limit`, planted ones among them, in the order of their keys.
    /// `extend` makes the sequence longer.
    fn alive(
        &self,
        known: &mut Arc<Places>,
        limit: f64,
        most_places: usize,
        extend: impl Fn(&mut Arc<Places>, usize),
    ) -> Vec<u32> {
        let most = self.planting.as_ref().map_or(1.0, |(_, most)| *most);
        // The map's largest value is 1, so no later place has a key below the limit.
        let n_places = ((limit * f64::from(most)).ceil() as usize).min(most_places);
        extend(known, n_places);
        let density = |place: Option<&Place>| {
            let planted = match (&self.planting, place) {
                (Some((field, _)), Some(place)) => field.at(place.position),
                _ => 1.0,
            };
            self.painted(place) * planted
        };
        let densities: Vec<f32> = known.places.par_iter().take(n_places).map(|place| density(place.as_ref())).collect();
        let mut ids = select(&densities, densities.len());
        ids.retain(|&id| key(id, densities[id as usize]) < limit);
        ids.truncate(MOST_STRANDS as usize);
        ids
    }
}

/// The roots of `n` strands as (id, root, place), thinned by painted density; planted ones come on top.
fn scatter(
    surface: &RootSurface,
    (n, count): (usize, StrandCount),
    seed: u32,
    density: &Density<'_>,
    known: Option<Arc<Places>>,
    place: impl Fn(&Root) -> Option<Place> + Sync,
) -> (Vec<(u32, Root, Place)>, Arc<Places>) {
    let mut known = known.unwrap_or_default();
    let extend = |known: &mut Arc<Places>, n_places: usize| {
        if known.roots.len() < n_places {
            let Places { roots, places } = Arc::make_mut(known);
            surface.extend(roots, n_places, seed);
            places.par_extend(roots[places.len()..].par_iter().map(&place));
        }
    };
    let chosen = |known: &Places, ids: Vec<u32>| -> Vec<(u32, Root, Place)> {
        let of = |id: u32| Some((id, known.roots[id as usize], known.places[id as usize]?));
        ids.into_iter().filter_map(of).collect()
    };
    let most_places = (MOST_PLACES_A_STRAND * n).min(MOST_PLACES.max(2 * n));
    if count == StrandCount::WhereFull {
        // The beginning of the sequence that has `n` places where a strand can be.
        let mut n_places = n;
        loop {
            extend(&mut known, n_places);
            let mut there = known.places.iter().enumerate().filter(|(_, place)| place.is_some());
            if let Some((last, _)) = n.checked_sub(1).and_then(|last| there.nth(last)) {
                n_places = last + 1;
                break;
            }
            if n_places >= most_places || n == 0 {
                break;
            }
            n_places = (n_places * 3 / 2 + 64).min(most_places);
        }
        let ids = density.alive(&mut known, n_places as f64, most_places, extend);
        return (chosen(&known, ids), known);
    }
    // How many places are alive tells how many are needed.
    let n_probed = 4096.min(MOST_PLACES_A_STRAND * n);
    extend(&mut known, n_probed);
    let probe: Vec<f32> = known.places.iter().take(n_probed).map(|place| density.painted(place.as_ref())).collect();
    let mean = probe.iter().sum::<f32>() / probe.len().max(1) as f32;
    let most = probe.iter().copied().fold(0.0, f32::max);
    if most <= 0.0 {
        return (Vec::new(), known);
    }
    let mut n_places = if mean >= 1.0 { n } else { (1.05 * n as f32 * most / mean) as usize + 64 };
    loop {
        n_places = n_places.min(most_places);
        extend(&mut known, n_places);
        let places = &known.places[..n_places.min(known.places.len())];
        let densities: Vec<f32> = places.par_iter().map(|place| density.painted(place.as_ref())).collect();
        let ids = select(&densities, n);
        // A later place may come before the last one chosen as long as its id is below that one's key.
        let largest_key = ids.last().map_or(0.0, |&id| key(id, densities[id as usize]));
        let most = densities.iter().copied().fold(0.0, f32::max);
        if (ids.len() == n && largest_key as f32 * most <= n_places as f32) || n_places >= most_places {
            if density.planting.is_none() || ids.len() < n {
                return (chosen(&known, ids), known);
            }
            let ids = density.alive(&mut known, largest_key.next_up(), most_places, extend);
            return (chosen(&known, ids), known);
        }
        n_places = n_places * 3 / 2 + 64;
    }
}

fn bind_hair_mesh(
    layer: &Layer,
    mesh: &HairMesh,
    scalp: Option<&Scalp<'_>>,
    known: Option<Arc<Places>>,
) -> LayerBinding {
    if mesh.layers.is_empty() || mesh.check().is_err() {
        return LayerBinding::with_capacity(GuideSet { n_vertices: 2, positions: Vec::new() }, 0);
    }
    let chains = mesh.chains();
    let (guides, knots) = GuideSet::of_chains(mesh, &chains);
    let surface = RootSurface::of_hair_mesh(mesh);
    let normals = root_layer_normals(mesh);
    let corners_of = |root: &Root| -> Vec<Vec3> {
        let face = mesh.face(0, root.face as usize).unwrap_or_default();
        face.iter().map(|&v| mesh.layers[0].positions[v as usize]).collect()
    };
    let place = |root: &Root| -> Option<Place> {
        scalp.and_then(|scalp| scalp.project(root.position)).or_else(|| {
            let face = mesh.face(0, root.face as usize)?;
            let weights = mean_value_weights(&corners_of(root), root.position);
            let normal: Vec3 = face.iter().zip(&weights).map(|(&v, w)| *w * normals[v as usize]).sum();
            Some(Place { position: root.position, normal: normal.normalize_or(Vec3::Y), uv: [0.0; 2] })
        })
    };
    let planting = Planting::of(layer);
    let density = Density::new(layer.density().map(|map| &**map).filter(|_| scalp.is_some()), planting.as_ref());
    let n_strands = layer.n_strands.min(MOST_STRANDS) as usize;
    let (scattered, places) = scatter(&surface, (n_strands, layer.count), layer.seed, &density, known, place);
    // In a face that is not convex mean values can be far below 0: such a strand would leave its lock.
    let weights: Vec<Vec<f32>> = scattered
        .par_iter()
        .map(|(_, root, _)| {
            let mut weights = mean_value_weights(&corners_of(root), root.position);
            let sum: f32 = weights.iter().map(|w| w.max(0.0)).sum();
            for w in &mut weights {
                *w = w.max(0.0) / sum;
            }
            weights
        })
        .collect();
    let mut binding = LayerBinding::with_capacity(guides, scattered.len());
    binding.knots = knots;
    binding.places = Some(places);
    binding.reach = Some(Arc::new(BundleReach::of(mesh)));
    for ((id, root, place), weights) in scattered.iter().zip(weights) {
        let guides = &chains.of_bundle[root.face as usize];
        binding.push_influences(guides.iter().zip(weights).map(|(&guide_idx, weight)| Influence { guide_idx, weight }));
        binding.push_id(*id, layer);
        binding.push_place(place, scalp);
        binding.bundles.push(root.face);
    }
    binding.first_knots = binding.first_knots_in(mesh);
    binding.measure_offsets();
    binding
}

/// Normals of the root layer's vertices on the side where the hair is.
fn root_layer_normals(mesh: &HairMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; mesh.layers[0].positions.len()];
    let mut outwards = 0.0;
    for bundle in 0..mesh.n_bundles() {
        let Some(face) = mesh.face(0, bundle) else { continue };
        let p = |corner: usize| mesh.layers[0].positions[face[corner % face.len()] as usize];
        let area: Vec3 = (0..face.len()).map(|i| p(i).cross(p(i + 1))).sum();
        for &v in face {
            normals[v as usize] += area;
        }
        for corner in 0..face.len() {
            let mut along = mesh.corner_positions(bundle, corner);
            if let (Some(root), Some(next)) = (along.next(), along.next()) {
                outwards += area.dot(next - root);
            }
        }
    }
    let side = if outwards < 0.0 { -1.0 } else { 1.0 };
    normals.iter().map(|n| (side * n).normalize_or(Vec3::Y)).collect()
}

fn bind_guides(
    layer: &Layer,
    strands: &Strands,
    scalp: Option<&Scalp<'_>>,
    known: Option<Arc<Places>>,
) -> LayerBinding {
    let guides = GuideSet::of_strands(strands);
    if guides.n_guides() == 0 {
        return LayerBinding::with_capacity(guides, 0);
    }
    let all_roots: Vec<Vec3> = (0..guides.n_guides()).map(|guide_idx| guides.guide(guide_idx)[0]).collect();
    // Planted guides come last, and change nothing about the strands of the others.
    let n_own = (0..guides.n_guides()).take_while(|&guide_idx| strands.id(guide_idx) < PLANTED).count();
    let n_own = if n_own == 0 { all_roots.len() } else { n_own };
    let roots = all_roots[..n_own].to_vec();
    let (grid, spacing) = spaced_grid(&roots);
    let reach = 1.5 * spacing;
    let near_guide = |p: Vec3| grid.nearest::<1>(p).0[0].1 <= reach * reach;
    // The part of the scalp that guides stand on.
    let on_scalp = scalp.and_then(|scalp| {
        let near: Vec<u32> = scalp
            .triangles
            .par_iter()
            .copied()
            .filter(|&triangle_idx| {
                let [a, b, c] = scalp.mesh.corners(triangle_idx as usize);
                let middle = (a + b + c) / 3.0;
                let radius = middle.distance(a).max(middle.distance(b)).max(middle.distance(c));
                grid.nearest::<1>(middle).0[0].1 <= (reach + radius).powi(2)
            })
            .collect();
        let surface = RootSurface::of_triangles(scalp.mesh, near);
        (surface.area() > 0.0).then_some((scalp, surface))
    });
    let (surface, scalp) = match on_scalp {
        Some((scalp, surface)) => (surface, Some(scalp)),
        None => (discs(&roots, 0.6 * spacing), None),
    };
    let middle = roots.iter().sum::<Vec3>() / roots.len() as f32;
    let place = |root: &Root| -> Option<Place> {
        let Some(scalp) = scalp else {
            let normal = (root.position - middle).normalize_or(Vec3::Y);
            return Some(Place { position: root.position, normal, uv: [0.0; 2] });
        };
        near_guide(root.position).then(|| scalp.at(root.face, root.barycentric, root.position))
    };
    let planting = Planting::of(layer);
    let density = Density::new(layer.density().map(|map| &**map).filter(|_| scalp.is_some()), planting.as_ref());
    let n_strands = layer.n_strands.min(MOST_STRANDS) as usize;
    let (scattered, places) = scatter(&surface, (n_strands, layer.count), layer.seed, &density, known, place);
    let influences: Vec<[Influence; 3]> =
        scattered.par_iter().map(|(_, root, _)| three_guides(&guides, &roots, &grid, root.position)).collect();
    let mut strands: Vec<(f64, u32, Place, [Influence; 3])> = scattered
        .into_iter()
        .zip(influences)
        .enumerate()
        .map(|(order, ((id, _, place), influences))| (order as f64, id, place, influences))
        .collect();
    if n_own < all_roots.len() {
        let a_guide = strands.len() as f32 / n_own as f32;
        let tufts = Tufts { guides: &guides, roots: &all_roots, n_own, spacing, n_strands: a_guide, scalp };
        let n_before = strands.len() as f64;
        // Between the others in the order of detail: a share of the layer has a share of every tuft.
        strands.extend(
            tufts.strands(layer.seed).map(|(at, id, place, influences)| (at * n_before, id, place, influences)),
        );
        strands.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    let mut binding = LayerBinding::with_capacity(guides, strands.len());
    for (_, id, place, influences) in &strands {
        binding.push_influences(*influences);
        binding.push_id(*id, layer);
        binding.push_place(place, scalp);
    }
    binding.places = Some(places);
    binding.offset_at_tip = 1.0;
    binding.measure_offsets();
    binding
}

/// The strands of planted guides: each guide has as many around it as the layer's own have.
struct Tufts<'a> {
    guides: &'a GuideSet,
    /// Of all guides; those from `n_own` on are planted.
    roots: &'a [Vec3],
    n_own: usize,
    /// Of the layer's own guides, centimetres.
    spacing: f32,
    /// Strands for each guide.
    n_strands: f32,
    scalp: Option<&'a Scalp<'a>>,
}

impl Tufts<'_> {
    /// Places in the order of detail (0-1), ids, places and weights.
    fn strands(&self, seed: u32) -> impl Iterator<Item = (f64, u32, Place, [Influence; 3])> {
        let (grid, n_each) = (PointGrid::new(self.roots, self.spacing), self.n_strands.ceil().max(1.0) as u32);
        let middle = self.roots.iter().sum::<Vec3>() / self.roots.len() as f32;
        let tuft = |guide_idx: usize| {
            let root = self.roots[guide_idx];
            let project = |p: Vec3| match self.scalp {
                Some(scalp) => scalp.project(p),
                None => Some(Place { position: p, normal: (p - middle).normalize_or(Vec3::Y), uv: [0.0; 2] }),
            };
            let normal = project(root).map_or(Vec3::Y, |place| place.normal);
            let (x, y) = normal.any_orthonormal_pair();
            let of_tuft = combine(
                combine(seed, PLANTED),
                root.x.to_bits() ^ root.y.to_bits().rotate_left(11) ^ root.z.to_bits().rotate_left(22),
            );
            let strand = |i: u32| {
                // Vogel 1979: even over a disc, every beginning of it too.
                let radius = self.spacing * TUFT * ((i as f32 + 0.5) / n_each as f32).sqrt();
                let (sin, cos) = (i as f32 * 2.399_963 + 6.3 * random(of_tuft, 0)).sin_cos();
                let place = project(root + radius * (cos * x + sin * y))?;
                let at = (f64::from(i) + f64::from(random(of_tuft, 1 + i))) / f64::from(n_each);
                Some((
                    at,
                    combine(of_tuft, i) | PLANTED,
                    place,
                    three_guides(self.guides, self.roots, &grid, place.position),
                ))
            };
            (0..n_each).filter_map(strand).collect::<Vec<_>>()
        };
        (self.n_own..self.roots.len()).flat_map(tuft).collect::<Vec<_>>().into_iter()
    }
}

/// Radius of the disc that a guide has for itself, in spacings of guides: pi r^2 is the area of one in a grid.
const TUFT: f32 = 0.62;

/// Places spread over the scalp of a head, as (position, way out of it): the beginning, `n_places(area)` long, of a
/// sequence that is the same for every length. Area in square centimetres.
pub(crate) fn scalp_places(head: &Head, n_places: impl Fn(f32) -> usize, seed: u32) -> Vec<(Vec3, Vec3)> {
    let Some(scalp) = Scalp::new(&head.mesh) else { return Vec::new() };
    let surface = RootSurface::of_triangles(scalp.mesh, scalp.triangles.iter().copied());
    let roots = surface.sequence(n_places(surface.area() as f32), seed);
    let place = |root: &Root| scalp.at(root.face, root.barycentric, root.position);
    roots.par_iter().map(place).map(|place| (place.position, place.normal)).collect()
}

/// A grid over points and their mean spacing in centimetres.
pub(crate) fn spaced_grid(points: &[Vec3]) -> (PointGrid<'_>, f32) {
    let first = points.first().copied().unwrap_or_default();
    let (lo, hi) = points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let size = (hi - lo).max_element();
    let coarse = PointGrid::new(points, size / (points.len() as f32).sqrt());
    let distances = points.iter().map(|&p| coarse.nearest::<2>(p).0[1].1.sqrt()).filter(|d| d.is_finite());
    let (sum, n) = distances.fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
    let spacing = if n > 0 && sum > 0.0 { sum / n as f32 } else { 1.0 };
    (PointGrid::new(points, spacing), spacing)
}

/// Hexagons around points, across the way out of their middle: a root surface where there is no scalp.
fn discs(points: &[Vec3], radius: f32) -> RootSurface {
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let mut mesh = TriMesh::default();
    for &p in points {
        let (x, y) = (p - middle).normalize_or(Vec3::Y).any_orthonormal_pair();
        let first = mesh.positions.len() as u32;
        mesh.positions.push(p);
        for k in 0..6_u32 {
            let (sin, cos) = (k as f32 / 6.0 * std::f32::consts::TAU).sin_cos();
            mesh.positions.push(p + radius * (cos * x + sin * y));
            mesh.triangles.push([first, first + 1 + k, first + 1 + (k + 1) % 6]);
        }
    }
    RootSurface::of_triangles(&mesh, 0..mesh.triangles.len() as u32)
}

/// The three nearest guides with barycentric weights on their plane; guides across a parting get none.
fn three_guides(guides: &GuideSet, roots: &[Vec3], grid: &PointGrid<'_>, p: Vec3) -> [Influence; 3] {
    let (nearest, n_found) = grid.nearest::<3>(p);
    let guide_idx = |i: usize| if i < n_found { nearest[i].0 } else { nearest[0].0 };
    let [a, b, c] = [guide_idx(0), guide_idx(1), guide_idx(2)];
    let (u, v, w) = (roots[b] - roots[a], roots[c] - roots[a], p - roots[a]);
    // Compute barycentric coordinates of p's projection (Ericson 2005, section 3.4).
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let determinant = uu * vv - uv * uv;
    let mut weights = if determinant > 1e-3 * uu * vv {
        let (beta, gamma) = ((vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant);
        [1.0 - beta - gamma, beta, gamma]
    } else {
        // Guides in a row: by distance.
        std::array::from_fn(|i| if i < n_found { 1.0 / (nearest[i].1 + 1e-6) } else { 0.0 })
    };
    let path = |guide_idx: usize| {
        let guide = guides.guide(guide_idx);
        (guide[guide.len() / 2] - guide[0]).normalize_or(Vec3::Y)
    };
    for (i, weight) in weights.iter_mut().enumerate() {
        let same_side = i == 0 || path(guide_idx(i)).dot(path(a)) > PARTED;
        *weight = if same_side { weight.max(0.0) } else { 0.0 };
    }
    weights[0] = if weights.iter().sum::<f32>() > 0.0 { weights[0] } else { 1.0 };
    let sum: f32 = weights.iter().sum();
    std::array::from_fn(|i| Influence { guide_idx: guide_idx(i) as u32, weight: weights[i] / sum })
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
