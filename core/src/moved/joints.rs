//! The edges that lead a vertex of a hair mesh from layer to layer, as the links of a chain.

use glam::Vec3;

use super::{Spline, row_at, sample_at};
use crate::curve::catmull_rom;
use crate::guides::{GuideSet, divide_gaps};
use crate::hair_mesh::{Chains, HairMesh};

/// Where a chain has a vertex that is no joint, as a share of its first part: the way that hair leaves the scalp.
const ROOT_SHARE: f32 = 0.15;

/// The chains of a hair mesh as curves of one vertex count, and how its guides run through their joints. Chains of lower
/// bundles have vertices between their joints.
pub(super) fn joints_of(mesh: &HairMesh, chains: &Chains, n_guide: u32) -> (GuideSet, Spline) {
    let n_gaps_most = mesh.layers.len() - 1;
    let parameters_of: Vec<Vec<f32>> = (0..=n_gaps_most).map(|n_gaps| with_root(n_gaps, n_gaps_most)).collect();
    let n_vertices = n_gaps_most as u32 + 2;
    let mut positions = Vec::with_capacity(chains.chains.len() * n_vertices as usize);
    for chain in &chains.chains {
        let joints: Vec<Vec3> = chain.iter().zip(&mesh.layers).map(|(&v, layer)| layer.positions[v as usize]).collect();
        positions.extend(parameters_of[joints.len() - 1].iter().map(|&u| catmull_rom(&joints, u)));
    }
    let mut rows = Vec::with_capacity((n_gaps_most + 1) * n_guide as usize);
    let mut samples = Vec::with_capacity((n_gaps_most + 1) * n_vertices as usize);
    for (n_gaps, parameters) in parameters_of.iter().enumerate() {
        let joint = |k: usize| {
            let at = parameters.iter().position(|&u| u >= k as f32);
            at.unwrap_or(parameters.len() - 1) as u32
        };
        let joints: Vec<u32> = (0..=n_gaps).map(joint).collect();
        let of_guide = divide_gaps(n_gaps, n_guide.max(2) as usize - 1);
        rows.extend(of_guide.iter().map(|&u| row_at(&joints, u)));
        samples.extend(parameters.iter().map(|&u| sample_at(&of_guide, u)));
    }
    let first_rows = chains.chains.iter().map(|chain| (chain.len() as u32 - 1) * n_guide).collect();
    let curve_of = (0..chains.chains.len() as u32).collect();
    let spline = Spline { n_vertices: n_guide, curve_of, first_rows, rows, offsets: Vec::new(), samples };
    (GuideSet { n_vertices, positions }, spline)
}

/// Parameters of a chain's vertices, in gaps: root, the way out of the scalp, and on, joints among them.
fn with_root(n_gaps: usize, n_gaps_most: usize) -> Vec<f32> {
    let mut parameters = divide_gaps(n_gaps, n_gaps_most);
    parameters.insert(1, ROOT_SHARE * parameters[1]);
    parameters
}
