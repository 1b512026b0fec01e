//! What strands are made from: guide curves of one resolution, and each strand's share in them.
//!
//! A hair mesh and a set of imported guides become the same thing: the chains of a hair mesh's corners
//! are guides, and a strand's mean value coordinates in its face are its weights. So solver and
//! generator know one input. Guides have one vertex count for all, so that index arithmetic is a product.
//!
//! A chain is resampled along its Catmull-Rom curve with the hair mesh's own vertices among the samples,
//! each layer gap divided by its mean length: blending resampled chains is then exactly the paper's
//! tracing at the layers, and the spacing stays even enough for the solver.

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
    pub fn of_chains(mesh: &HairMesh, chains: &Chains) -> Self {
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
        let parameters_of_height: Vec<Vec<f32>> = (0..=n_gaps_most)
            .map(|n_gaps| {
                let mut gap_length = vec![0.0; n_gaps];
                for points in control.iter().filter(|points| points.len() == n_gaps + 1) {
                    for (length, ends) in gap_length.iter_mut().zip(points.windows(2)) {
                        *length += ends[0].distance(ends[1]);
                    }
                }
                divide_gaps(&gap_length, n_vertices - 1)
            })
            .collect();
        let mut positions = Vec::with_capacity(control.len() * n_vertices);
        for points in &control {
            let parameters = &parameters_of_height[points.len() - 1];
            positions.extend(parameters.iter().map(|&u| catmull_rom(points, u)));
        }
        Self { n_vertices: n_vertices as u32, positions }
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

/// Parameters of `n_segments + 1` samples over gaps of the given lengths: every gap's ends are samples,
/// and gaps are divided in proportion to their length. One sample at 0 repeated where there is no gap.
fn divide_gaps(gap_length: &[f32], n_segments: usize) -> Vec<f32> {
    let n_gaps = gap_length.len();
    if n_gaps == 0 {
        return vec![0.0; n_segments + 1];
    }
    let mut n_parts = vec![1_usize; n_gaps];
    for _ in n_gaps..n_segments {
        let longest = |gap: &usize| gap_length[*gap] / n_parts[*gap] as f32;
        let gap = (0..n_gaps).max_by(|a, b| longest(a).total_cmp(&longest(b)).then(b.cmp(a))).unwrap_or(0);
        n_parts[gap] += 1;
    }
    let mut parameters = vec![0.0];
    for (gap, &n_parts) in n_parts.iter().enumerate() {
        parameters.extend((1..=n_parts).map(|part| gap as f32 + part as f32 / n_parts as f32));
    }
    parameters
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
        let guides = GuideSet::of_chains(&mesh, &chains);
        assert_eq!((guides.n_guides(), guides.n_vertices), (chains.chains.len(), 17));
        for (guide_idx, chain) in chains.chains.iter().enumerate() {
            for (layer, &v) in mesh.layers.iter().zip(chain) {
                let p = layer.positions[v as usize];
                assert!(guides.guide(guide_idx).iter().any(|q| q.distance(p) < 1e-5), "{p}");
            }
            let steps: Vec<f32> = guides.guide(guide_idx).windows(2).map(|s| s[0].distance(s[1])).collect();
            let (min, max) = steps.iter().fold((f32::MAX, 0.0_f32), |(lo, hi), &s| (lo.min(s), hi.max(s)));
            assert!(max < 2.2 * min, "{steps:?}");
        }
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
