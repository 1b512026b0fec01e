//! What hangs together on the scalp as one rope: its middle, and guides around it.

use std::collections::HashMap;

use glam::Vec3;

use super::{BEYOND, Spline, row_at, sample_at};
use crate::curve::{catmull_rom, even_parameters};
use crate::guides::{GuideSet, divide_gaps};
use crate::hair_mesh::{Chains, HairMesh};

/// Vertices of a rope.
const N_ROPE: usize = 24;

/// A rope for every piece of the mesh whose faces hang together on the scalp, through the middles of the piece's chains, layer by
/// layer; and where its guides lie beside it.
pub(super) fn ropes_of(mesh: &HairMesh, chains: &Chains, guides: &GuideSet) -> (GuideSet, Spline) {
    let pieces = pieces_of(mesh, chains);
    let n_pieces = pieces.iter().max().map_or(0, |&last| last as usize + 1);
    let n_guide = guides.n_vertices as usize;
    let mut curves = GuideSet { n_vertices: N_ROPE as u32, positions: Vec::with_capacity(n_pieces * N_ROPE) };
    let n_gaps_most = mesh.layers.len() - 1;
    let n_runs = n_gaps_most + 1;
    let joints: Vec<u32> = (0..N_ROPE as u32).collect();
    let (mut rows, mut samples) = (Vec::new(), Vec::new());
    for piece in 0..n_pieces {
        let middles = middles_of(mesh, chains, |chain_idx| pieces[chain_idx] as usize == piece);
        let of_rope = even_parameters(&middles, N_ROPE);
        curves.positions.extend(of_rope.iter().map(|&u| catmull_rom(&middles, u)));
        for n_gaps in 0..n_runs {
            let of_guide = divide_gaps(n_gaps, n_guide - 1);
            rows.extend(of_guide.iter().map(|&u| row_at(&joints, sample_at(&of_rope, u))));
            let sample = |&u: &f32| if u > n_gaps as f32 { BEYOND } else { sample_at(&of_guide, u) };
            samples.extend(of_rope.iter().map(sample));
        }
    }
    let height = |chain: &[u32]| chain.len() - 1;
    let first_rows: Vec<u32> = (chains.chains.iter().zip(&pieces))
        .map(|(chain, &piece)| ((piece as usize * n_runs + height(chain)) * n_guide) as u32)
        .collect();
    let beside = |idx: usize| {
        let row = &rows[first_rows[idx / n_guide] as usize + idx % n_guide];
        let rope = curves.guide(pieces[idx / n_guide] as usize);
        guides.positions[idx] - Spline::place(row, |v| rope[v as usize], None, glam::Quat::IDENTITY)
    };
    let offsets = (0..guides.positions.len()).map(beside).collect();
    let spline = Spline { n_vertices: guides.n_vertices, curve_of: pieces, first_rows, rows, offsets, samples };
    (curves, spline)
}

/// The mean place of some chains in each layer that one of them reaches.
fn middles_of(mesh: &HairMesh, chains: &Chains, is_taken: impl Fn(usize) -> bool) -> Vec<Vec3> {
    let mut sums: Vec<(Vec3, f32)> = vec![(Vec3::ZERO, 0.0); mesh.layers.len()];
    for (_, chain) in chains.chains.iter().enumerate().filter(|(chain_idx, _)| is_taken(*chain_idx)) {
        for ((sum, layer), &v) in sums.iter_mut().zip(&mesh.layers).zip(chain) {
            *sum = (sum.0 + layer.positions[v as usize], sum.1 + 1.0);
        }
    }
    sums.into_iter().take_while(|(_, n)| *n > 0.0).map(|(sum, n)| sum / n).collect()
}

/// The piece of each chain: chains of one bundle, and of bundles that share a vertex of the scalp, are of one.
fn pieces_of(mesh: &HairMesh, chains: &Chains) -> Vec<u32> {
    let mut parents: Vec<usize> = (0..mesh.layers[0].positions.len()).collect();
    fn root_of(parents: &mut [usize], mut v: usize) -> usize {
        while parents[v] != v {
            parents[v] = parents[parents[v]];
            v = parents[v];
        }
        v
    }
    for bundle in 0..mesh.n_bundles() {
        let Some(face) = mesh.face(0, bundle) else { continue };
        for pair in face.windows(2) {
            let (a, b) = (root_of(&mut parents, pair[0] as usize), root_of(&mut parents, pair[1] as usize));
            parents[a] = b;
        }
    }
    let mut numbers = HashMap::new();
    let mut piece = |chain: &Vec<u32>| {
        let root = root_of(&mut parents, chain[0] as usize);
        let next = numbers.len() as u32;
        *numbers.entry(root).or_insert(next)
    };
    chains.chains.iter().map(&mut piece).collect()
}
