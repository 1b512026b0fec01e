//! What hangs together as one rope: its middle, and guides around it.
//!
//! Faces that share a vertex of the scalp are one piece. Pieces that lie against each other for most of their length are one
//! rope: the strands of a braid. Which strand goes over which is no matter: all turn with the middle of them all.

use std::collections::HashMap;

use glam::Vec3;

use super::{BEYOND, Spline, row_at, sample_at};
use crate::curve::{catmull_rom, even_parameters};
use crate::guides::{GuideSet, divide_gaps};
use crate::hair_mesh::{Chains, HairMesh};

/// Vertices of a rope.
const N_ROPE: usize = 24;

/// Pieces lie against each other where their middles are nearer than this many times the sum of their radii.
const AGAINST: f32 = 1.25;
/// Share of the layers in which they do, for one rope.
const MOST: f32 = 0.6;

/// The ropes of a mesh, through the middles of their chains, layer by layer; and where its guides lie beside them.
pub(super) fn ropes_of(mesh: &HairMesh, chains: &Chains, guides: &GuideSet) -> (GuideSet, Spline) {
    let pieces = plaited(mesh, chains, &pieces_of(mesh, chains));
    let n_pieces = pieces.iter().max().map_or(0, |&last| last as usize + 1);
    let n_guide = guides.n_vertices as usize;
    let mut curves = GuideSet { n_vertices: N_ROPE as u32, positions: Vec::with_capacity(n_pieces * N_ROPE) };
    let n_gaps_most = mesh.layers.len() - 1;
    let n_runs = n_gaps_most + 1;
    let joints: Vec<u32> = (0..N_ROPE as u32).collect();
    let (mut rows, mut samples) = (Vec::new(), Vec::new());
    for piece in 0..n_pieces {
        let middles = middles_of(mesh, chains, |chain_idx| pieces[chain_idx] as usize == piece);
        let middles: Vec<Vec3> = middles.into_iter().map(|(middle, _)| middle).collect();
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

/// The mean place of some chains in each layer that one of them reaches, and how far they are from it (root mean square).
fn middles_of(mesh: &HairMesh, chains: &Chains, is_taken: impl Fn(usize) -> bool) -> Vec<(Vec3, f32)> {
    // Sums of 1, of places and of their squares.
    let mut sums: Vec<(f32, Vec3, f32)> = vec![(0.0, Vec3::ZERO, 0.0); mesh.layers.len()];
    for (_, chain) in chains.chains.iter().enumerate().filter(|(chain_idx, _)| is_taken(*chain_idx)) {
        for ((sum, layer), &v) in sums.iter_mut().zip(&mesh.layers).zip(chain) {
            let p = layer.positions[v as usize];
            *sum = (sum.0 + 1.0, sum.1 + p, sum.2 + p.length_squared());
        }
    }
    let mean = |(n, sum, squares): (f32, Vec3, f32)| {
        let middle = sum / n;
        (middle, (squares / n - middle.length_squared()).max(0.0).sqrt())
    };
    sums.into_iter().take_while(|(n, ..)| *n > 0.0).map(mean).collect()
}

/// The rope of each chain, whose piece is known.
fn plaited(mesh: &HairMesh, chains: &Chains, pieces: &[u32]) -> Vec<u32> {
    let n_pieces = pieces.iter().max().map_or(0, |&last| last + 1);
    let middles: Vec<Vec<(Vec3, f32)>> =
        (0..n_pieces).map(|piece| middles_of(mesh, chains, |chain_idx| pieces[chain_idx] == piece)).collect();
    let is_against = |a: &[(Vec3, f32)], b: &[(Vec3, f32)]| {
        let near = a.iter().zip(b).filter(|((p, r), (q, s))| p.distance(*q) <= AGAINST * (r + s)).count();
        near as f32 >= MOST * a.len().max(b.len()) as f32
    };
    let mut parents: Vec<usize> = (0..middles.len()).collect();
    for (a, of_a) in middles.iter().enumerate() {
        for (b, of_b) in middles.iter().enumerate().skip(a + 1) {
            if is_against(of_a, of_b) {
                join(&mut parents, a, b);
            }
        }
    }
    numbered(pieces.iter().map(|&piece| top_of(&mut parents, piece as usize)))
}

/// What stands for all that were joined with `v`.
fn top_of(parents: &mut [usize], mut v: usize) -> usize {
    while parents[v] != v {
        parents[v] = parents[parents[v]];
        v = parents[v];
    }
    v
}

fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (top_of(parents, a), top_of(parents, b));
    parents[a] = b;
}

/// The same numbers where these are the same, from 0 on without a gap.
fn numbered(tops: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut numbers = HashMap::new();
    let number = |top: usize| {
        let next = numbers.len() as u32;
        *numbers.entry(top).or_insert(next)
    };
    tops.map(number).collect()
}

/// The piece of each chain: chains of one bundle, and of bundles that share a vertex of the scalp, are of one.
fn pieces_of(mesh: &HairMesh, chains: &Chains) -> Vec<u32> {
    let mut parents: Vec<usize> = (0..mesh.layers[0].positions.len()).collect();
    for bundle in 0..mesh.n_bundles() {
        let Some(face) = mesh.face(0, bundle) else { continue };
        for pair in face.windows(2) {
            join(&mut parents, pair[0] as usize, pair[1] as usize);
        }
    }
    numbered(chains.chains.iter().map(|chain| top_of(&mut parents, chain[0] as usize)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::HairMeshLayer;

    /// Two squares on the scalp, `apart` centimetres, whose bundles wind around each other.
    fn pair(apart: f32) -> HairMesh {
        let layer = |k: usize| {
            let angle = 0.5 * k as f32;
            let square = |side: f32| {
                let middle = 0.5 * side * apart * Vec3::new(angle.cos(), 0.0, angle.sin()) - 1.5 * k as f32 * Vec3::Y;
                [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| middle + Vec3::new(x, 0.0, z))
            };
            HairMeshLayer {
                positions: [square(-1.0), square(1.0)].concat(),
                faces: vec![Some(vec![0, 1, 2, 3]), Some(vec![4, 5, 6, 7])],
                pinned: Vec::new(),
            }
        };
        HairMesh { layers: (0..12).map(layer).collect() }
    }

    #[test]
    fn what_lies_against_each_other_is_one_rope_and_two_tails_are_two() {
        for (apart, n_ropes) in [(2.2, 1), (9.0, 2)] {
            let mesh = pair(apart);
            let chains = mesh.chains();
            let (guides, _) = GuideSet::of_chains(&mesh, &chains);
            let (curves, spline) = ropes_of(&mesh, &chains, &guides);
            assert_eq!(curves.n_guides(), n_ropes, "{apart}");
            assert_eq!(spline.curve_of.len(), 8);
            // The middle of a pair is straight, whatever winds around it.
            if n_ropes == 1 {
                assert!(curves.positions.iter().all(|p| p.x.abs() + p.z.abs() < 1e-4));
            }
        }
    }
}
