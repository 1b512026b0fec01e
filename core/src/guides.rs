//! What strands are made from: guide curves of one resolution, and each strand's share in them.
//!
//! A hair mesh and a set of imported guides become the same thing: the chains of a hair mesh's corners
//! are guides, and a strand's mean value coordinates in its face are its weights. So solver and
//! generator know one input. Guides have one vertex count for all, so that index arithmetic is a product.

use glam::Vec3;

/// Guide curves in head space at rest. Vertex `k` of guide `g` is `positions[g * n_vertices + k]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GuideSet {
    /// Vertices of every guide, root first; at least 2.
    pub n_vertices: u32,
    /// Centimetres.
    pub positions: Vec<Vec3>,
}

impl GuideSet {
    pub fn n_guides(&self) -> usize {
        self.positions.len().checked_div(self.n_vertices as usize).unwrap_or(0)
    }

    pub fn guide(&self, guide_idx: usize) -> &[Vec3] {
        let n = self.n_vertices as usize;
        &self.positions[guide_idx * n..(guide_idx + 1) * n]
    }
}

/// A guide's share in a strand. The weights of a strand sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Influence {
    pub guide_idx: u32,
    pub weight: f32,
}
