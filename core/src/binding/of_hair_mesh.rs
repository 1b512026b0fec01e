//! Strands of a hair mesh: mean value coordinates in the root faces weigh the chains at their corners.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::scatter::{Density, Place, Places, Scalp, scatter};
use super::{LayerBinding, MOST_STRANDS};
use crate::clumps::BundleReach;
use crate::groom::Layer;
use crate::guides::{GuideSet, Influence};
use crate::hair_mesh::HairMesh;
use crate::mean_value::{mean_value_weights, weights_within};
use crate::roots::{Root, RootSurface};
use crate::sculpt::planting::Planting;

pub(super) fn bind_hair_mesh(
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
    let weights: Vec<Vec<f32>> =
        scattered.par_iter().map(|(_, root, _)| weights_within(&corners_of(root), root.position)).collect();
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
pub(super) fn root_layer_normals(mesh: &HairMesh) -> Vec<Vec3> {
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
