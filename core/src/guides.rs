//! What strands are made from: guide curves of one resolution, and each strand's share in them.
//!
//! A hair mesh and a set of imported guides become the same thing: the chains of a hair mesh's corners
//! are guides, and a strand's mean value coordinates in its face are its weights. So solver and
//! generator know one input. Guides have one vertex count for all, so that index arithmetic is a product.
//!
//! A chain is resampled along its Catmull-Rom curve with the hair mesh's own vertices among the samples, every
//! gap between two layers divided alike: blending resampled chains is then exactly the paper's tracing at the
//! layers. Dividing long gaps into more parts was rejected: while a vertex is dragged, a part would jump from
//! one gap to the next, and every strand with it. Instead a strand's parameter runs evenly over the mean length
//! of the gaps ([`GuideSet::of_chains`]' knots), which changes smoothly with the mesh.

use glam::Vec3;

use crate::curve::{catmull_rom, even_parameters};
use crate::hair_mesh::{Chains, HairMesh};
use crate::strands::Strands;

pub use crate::binding::{LayerBinding, bind_layer};

/// Guide curves in head space at rest. Vertex `k` of guide `g` is `positions[g * n_vertices + k]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GuideSet {
    /// Vertices of every guide, root first; at least 2.
    pub n_vertices: u32,
    /// Centimetres.
    pub positions: Vec<Vec3>,
}

/// A guide's share in a strand. The weights of a strand sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Influence {
    pub guide_idx: u32,
    pub weight: f32,
}

/// Segments of a hair mesh's guides: enough to draw the spline, few enough for the solver.
const FEWEST_SEGMENTS: usize = 15;
const MOST_SEGMENTS: usize = 24;
/// Most vertices of imported guides and strands; longer ones are resampled.
const MOST_IMPORTED_VERTICES: usize = 64;

impl GuideSet {
    pub fn n_guides(&self) -> usize {
        self.positions.len().checked_div(self.n_vertices as usize).unwrap_or(0)
    }

    pub fn guide(&self, guide_idx: usize) -> &[Vec3] {
        let n = self.n_vertices as usize;
        &self.positions[guide_idx * n..(guide_idx + 1) * n]
    }

    /// The chains of a hair mesh, resampled to one vertex count. Guide `i` is `chains.chains[i]`.
    ///
    /// Also the knots of every height of bundle: vertex `k` of a guide with `n_gaps` gaps is at the parameter
    /// `knots[n_gaps * n_vertices + k]`, 0 root to 1 tip, by the mean length of the gaps.
    pub fn of_chains(mesh: &HairMesh, chains: &Chains) -> (Self, Vec<f32>) {
        let n_gaps_most = mesh.layers.len().saturating_sub(1);
        let n_gaps = n_gaps_most.max(1);
        // Every gap alike where that is possible.
        let n_segments = FEWEST_SEGMENTS.div_ceil(n_gaps) * n_gaps;
        let n_vertices = if n_segments > MOST_SEGMENTS { MOST_SEGMENTS.max(n_gaps) } else { n_segments } + 1;
        let control: Vec<Vec<Vec3>> = chains
            .chains
            .iter()
            .map(|chain| chain.iter().zip(&mesh.layers).map(|(&v, layer)| layer.positions[v as usize]).collect())
            .collect();
        // All bundles of one height share their parameters: only then may their chains be blended.
        let parameters_of_height: Vec<Vec<f32>> =
            (0..=n_gaps_most).map(|n_gaps| divide_gaps(n_gaps, n_vertices - 1)).collect();
        let mut knots = Vec::with_capacity(n_vertices * parameters_of_height.len());
        for (n_gaps, parameters) in parameters_of_height.iter().enumerate() {
            let mut gap_length = vec![0.0; n_gaps];
            for points in control.iter().filter(|points| points.len() == n_gaps + 1) {
                for (length, ends) in gap_length.iter_mut().zip(points.windows(2)) {
                    *length += ends[0].distance(ends[1]);
                }
            }
            knots.extend(knots_of(&gap_length, parameters));
        }
        let mut positions = Vec::with_capacity(control.len() * n_vertices);
        for points in &control {
            let parameters = &parameters_of_height[points.len() - 1];
            positions.extend(parameters.iter().map(|&u| catmull_rom(points, u)));
        }
        (Self { n_vertices: n_vertices as u32, positions }, knots)
    }

    /// Which vertices of a guide of `n_vertices` are the vertices of the chain of `n_chain` that it was made of, root first.
    pub fn samples_of_chain(n_chain: usize, n_vertices: usize) -> Vec<usize> {
        let parameters = divide_gaps(n_chain.saturating_sub(1), n_vertices.saturating_sub(1));
        let sample_at = |k: usize| parameters.iter().position(|&u| u >= k as f32).unwrap_or(parameters.len() - 1);
        (0..n_chain).map(sample_at).collect()
    }

    /// Knots of guides whose vertices are evenly spaced.
    pub fn even_knots(&self) -> Vec<f32> {
        let last = self.n_vertices.max(2) - 1;
        (0..=last).map(|k| k as f32 / last as f32).collect()
    }

    /// Imported curves. Where all have one moderate point count they stay as they are; otherwise they are
    /// resampled evenly.
    pub fn of_strands(strands: &Strands) -> Self {
        let most = strands.iter().map(<[Vec3]>::len).max().unwrap_or(0);
        let alike = strands.iter().all(|points| points.len() == most);
        if alike && (2..=MOST_IMPORTED_VERTICES).contains(&most) {
            return Self { n_vertices: most as u32, positions: strands.points.clone() };
        }
        let n_vertices = most.clamp(4, MOST_IMPORTED_VERTICES);
        let mut positions = Vec::with_capacity(strands.n_strands() * n_vertices);
        for points in strands.iter() {
            if points.is_empty() {
                positions.extend(std::iter::repeat_n(Vec3::ZERO, n_vertices));
            } else {
                positions.extend(even_parameters(points, n_vertices).iter().map(|&u| catmull_rom(points, u)));
            }
        }
        Self { n_vertices: n_vertices as u32, positions }
    }

    /// Bytes held by the arrays.
    pub fn n_bytes(&self) -> usize {
        size_of_val(self.positions.as_slice())
    }
}

/// Parameters of `n_segments + 1` samples over `n_gaps` gaps of length 1: every gap's ends are samples, and no gap
/// has more than one part more than another. One sample at 0 repeated where there is no gap.
pub(crate) fn divide_gaps(n_gaps: usize, n_segments: usize) -> Vec<f32> {
    if n_gaps == 0 {
        return vec![0.0; n_segments + 1];
    }
    let mut parameters = vec![0.0];
    for gap in 0..n_gaps {
        // The first gaps, where hair bends most, get the parts that are left over.
        let n_parts = n_segments / n_gaps + usize::from(gap < n_segments % n_gaps);
        parameters.extend((1..=n_parts).map(|part| gap as f32 + part as f32 / n_parts as f32));
    }
    parameters
}

/// How far along the whole length (0-1) samples at `parameters` are, where gap `i` has `gap_length[i]`.
fn knots_of(gap_length: &[f32], parameters: &[f32]) -> Vec<f32> {
    let total: f32 = gap_length.iter().sum();
    let last = (parameters.len() - 1) as f32;
    if total <= 0.0 {
        return (0..parameters.len()).map(|k| k as f32 / last).collect();
    }
    let up_to: Vec<f32> = std::iter::once(0.0)
        .chain(gap_length.iter().scan(0.0, |sum, length| {
            *sum += length / total;
            Some(*sum)
        }))
        .collect();
    let at = |u: f32| {
        let gap = (u as usize).min(gap_length.len() - 1);
        up_to[gap] + (u - gap as f32) * (up_to[gap + 1] - up_to[gap])
    };
    let mut knots: Vec<f32> = parameters.iter().map(|&u| at(u)).collect();
    // Rounding must not leave the tip out.
    if let Some(tip) = knots.last_mut() {
        *tip = 1.0;
    }
    knots
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::Weld;
    use crate::hair_mesh::tests::straight_grid;

    #[test]
    fn guides_pass_every_layer_of_every_chain() {
        let mut mesh = straight_grid(2, 3);
        mesh.extrude(&[0, 1], Weld::Neighbours, |v| v.position + Vec3::new(0.5, 4.0, 1.0)).unwrap();
        let chains = mesh.chains();
        let (guides, knots) = GuideSet::of_chains(&mesh, &chains);
        assert_eq!((guides.n_guides(), guides.n_vertices), (chains.chains.len(), 17));
        assert_eq!(knots.len(), 17 * mesh.layers.len());
        for (guide_idx, chain) in chains.chains.iter().enumerate() {
            for (layer, &v) in mesh.layers.iter().zip(chain) {
                let p = layer.positions[v as usize];
                assert!(guides.guide(guide_idx).iter().any(|q| q.distance(p) < 1e-5), "{p}");
            }
        }
        // Evenly spaced knots are evenly spaced along the mean chain of their height, long gap or short.
        let tall = &knots[4 * 17..];
        assert_eq!((tall[0], tall[16]), (0.0, 1.0));
        let long_gap = Vec3::new(0.5, 4.0, 1.0).length();
        assert!((tall[12] - 3.0 / (3.0 + long_gap)).abs() < 1e-5, "{tall:?}");
        assert!(tall.windows(2).all(|pair| pair[1] > pair[0]));
    }

    #[test]
    fn imported_curves_of_one_length_stay_and_others_are_made_even() {
        let mut strands = Strands::default();
        let bent = [Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 3.0, 0.0), Vec3::new(1.0, 3.5, 0.0), Vec3::new(2.0, 3.5, 0.0)];
        strands.push(&bent);
        strands.push(&bent);
        assert_eq!(GuideSet::of_strands(&strands).positions, strands.points);
        strands.push(&bent[..3]);
        strands.push(&bent[..1]);
        strands.push(&[]);
        let guides = GuideSet::of_strands(&strands);
        assert_eq!((guides.n_guides(), guides.n_vertices), (5, 5));
        assert_eq!(guides.guide(2)[4], bent[2]);
        assert!(guides.positions.iter().all(|p| p.is_finite()));
        assert_eq!(GuideSet::of_strands(&Strands::default()).n_guides(), 0);
    }
}
