//! What brushes did to a strand: the blend of its sculpt guides. Twin of the `sculpt_` functions in
//! generate.wgsl.
//!
//! The styled strand is displaced point by point; then its segments get back the lengths that the style gave
//! them, times what grew. So a comb bends hair and never stretches it, whatever hangs between two guides.

use glam::{Affine3A, Mat3, Vec3};

use super::any_tangent;
use crate::curve::catmull_rom_weights;
use crate::hash::random;
use crate::sculpt::K;
use crate::sculpt::compose::Composed;
use crate::sculpt::near::Share;

/// What the random number is for that decides whether a strand is among those left.
const FOR_KEEP: u32 = 64;
/// Roots that were moved less than this stay where they are, in centimetres.
const SLID: f32 = 1e-5;

/// A root's own frame: columns are two directions along the scalp, and the way out of it.
pub fn root_frame(normal: Vec3) -> Mat3 {
    let x = any_tangent(normal);
    Mat3::from_cols(x, normal.cross(x), normal)
}

/// A strand's blend of guides.
#[derive(Clone, Copy)]
pub(super) struct Sculpted<'a> {
    guides: &'a [Composed],
    share: Share,
    world_from_root: Mat3,
    /// Share of the styled length.
    pub length: f32,
    /// Share of the path that is left.
    pub cut: f32,
    pub is_deleted: bool,
}

impl<'a> Sculpted<'a> {
    /// `None` where no guide is near.
    pub fn new(
        guides: &'a [Composed],
        share: Share,
        seed: u32,
        normal: Vec3,
        world_from_head: &Affine3A,
    ) -> Option<Self> {
        if share.weights == [0.0; 3] {
            return None;
        }
        let world_from_root = Mat3::from(world_from_head.matrix3) * root_frame(normal);
        let blend = |point: usize| -> f32 {
            (0..3).map(|i| share.weights[i] * guides[share.guides[i] as usize][point][3]).sum()
        };
        let is_deleted = random(seed, FOR_KEEP) >= blend(2);
        Some(Self { guides, share, world_from_root, length: blend(0), cut: blend(1), is_deleted })
    }

    fn control(&self, point: i32) -> Vec3 {
        let last = K as i32 - 1;
        if point < 0 {
            return 2.0 * self.control(0) - self.control(1);
        }
        if point > last {
            return 2.0 * self.control(last) - self.control(last - 1);
        }
        let mut offset = Vec3::ZERO;
        for i in 0..3 {
            let [x, y, z, _] = self.guides[self.share.guides[i] as usize][point as usize];
            offset += self.share.weights[i] * Vec3::new(x, y, z);
        }
        offset
    }

    /// Displacement at parameter `t` of the path, 0 root to 1 tip. World space.
    pub fn offset(&self, t: f32) -> Vec3 {
        let n_segments = K as i32 - 1;
        let u = t * n_segments as f32;
        let segment = (u as i32).min(n_segments - 1);
        let w = catmull_rom_weights(u - segment as f32);
        self.world_from_root
            * (w[0] * self.control(segment - 1)
                + w[1] * self.control(segment)
                + w[2] * self.control(segment + 1)
                + w[3] * self.control(segment + 2))
    }

    /// Whether the root itself was moved along the scalp.
    pub fn has_slid(&self) -> bool {
        self.control(0).length_squared() > SLID * SLID
    }
}

/// A strand's chain of segments while it is displaced from root to tip.
#[derive(Clone, Copy, Default)]
pub(super) struct Chain {
    styled: Vec3,
    displaced: Vec3,
    placed: Vec3,
}

impl Chain {
    pub fn begin(styled: Vec3, placed: Vec3) -> Self {
        Self { styled, displaced: placed, placed }
    }

    /// The place of the next vertex, which the style puts at `styled` and brushes move by `offset`.
    pub fn next(&mut self, styled: Vec3, offset: Vec3, length: f32, tangent: Vec3) -> Vec3 {
        let displaced = styled + offset;
        let segment = length * styled.distance(self.styled);
        self.placed += segment * (displaced - self.displaced).normalize_or(tangent);
        (self.styled, self.displaced) = (styled, displaced);
        self.placed
    }
}
