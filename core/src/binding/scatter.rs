//! Where strands stand: a root sequence on the scalp, and which of its places density and count choose.

use std::borrow::Cow;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::MOST_STRANDS;
use crate::groom::StrandCount;
use crate::maps::ScalpMap;
use crate::maps::uvs::scalp_uvs;
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;
use crate::roots::{Root, RootSurface, key, select};
use crate::sculpt::planting::{Planting, PlantingField};

/// Root layers farther from the head than this were not meant to lie on it, in centimetres.
const FARTHEST_ROOT: f32 = 2.0;
/// Most places of a sequence that are looked at for painted density, for each strand wanted: a map that
/// is nearly empty gives fewer strands than asked for.
const MOST_PLACES_A_STRAND: usize = 100;
/// Most of them in all, where there are more than strands.
const MOST_PLACES: usize = 3_000_000;

/// A beginning of a root sequence with each root's place; `None` where none can be.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Places {
    pub(super) roots: Vec<Root>,
    pub(super) places: Vec<Option<Place>>,
}

/// A root's place on the scalp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    pub(super) uv: [f32; 2],
}

/// The triangles that grow hair ([`TriMesh::scalp_triangles`]).
pub(super) struct Scalp<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) triangles: Vec<u32>,
    pub(super) query: MeshQuery,
    pub(super) normals: Cow<'a, [Vec3]>,
    pub(super) uvs: Cow<'a, [[f32; 2]]>,
}

impl<'a> Scalp<'a> {
    pub(super) fn new(mesh: &'a TriMesh) -> Option<Self> {
        let triangles = mesh.scalp_triangles();
        let query = MeshQuery::of_triangles(mesh, triangles.iter().copied()).ok()?;
        let normals = mesh.vertex_normals();
        Some(Self { mesh, triangles, query, normals, uvs: scalp_uvs(mesh) })
    }

    pub(super) fn at(&self, triangle_idx: u32, barycentric: [f32; 3], position: Vec3) -> Place {
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
    pub(super) fn project(&self, p: Vec3) -> Option<Place> {
        let hit = self.query.closest_within(p, FARTHEST_ROOT)?;
        Some(self.at(hit.triangle_idx, hit.barycentric.to_array(), hit.position))
    }
}

/// How dense a layer's strands are over the scalp.
pub(super) struct Density<'a> {
    /// Painted, 0-1.
    pub(super) map: Option<&'a ScalpMap>,
    /// Above 1 where hair was planted.
    pub(super) planting: Option<(PlantingField<'a>, f32)>,
}

impl<'a> Density<'a> {
    pub(super) fn new(map: Option<&'a ScalpMap>, planting: Option<&'a Planting>) -> Self {
        Self { map, planting: planting.map(|planting| (planting.field(), planting.most())) }
    }

    pub(super) fn painted(&self, place: Option<&Place>) -> f32 {
        place.map_or(0.0, |place| self.map.map_or(1.0, |map| map.sample(place.uv)))
    }

    /// Those of a sequence whose keys are below `limit`, planted ones among them, in the order of their keys.
    /// `extend` makes the sequence longer.
    pub(super) fn alive(
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
pub(super) fn scatter(
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
