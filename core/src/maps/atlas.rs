//! Where on the head each texel of a map lies, so that a brush in space finds its texels.
//!
//! Every scalp triangle is drawn into the map once, a few texels beyond its border: a bilinear sample at the
//! rim of a chart reads those, and they are painted as the rim is, so that no seam shows. Texels are kept by
//! blocks of 16 x 16 with a box around each: a brush looks at boxes, then only into those it meets.

use glam::{Vec2, Vec3};

use super::tiles::{ScalpMap, TILE_SIDE};
use super::uvs::scalp_uvs;
use crate::mesh::TriMesh;

/// Texels that a chart is painted beyond its border.
pub const BLEED: f32 = 3.0;
/// Texels along a block's side; a tile has 4 x 4 blocks.
const BLOCK_SIDE: u32 = 16;

/// A texel on the scalp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AtlasTexel {
    /// Index of the tile, and of the texel in it.
    pub tile_idx: u32,
    pub at: u16,
    /// Unit normal, in 127ths.
    normal: [i8; 3],
    pub position: Vec3,
}

impl AtlasTexel {
    pub(super) fn normal(&self) -> Vec3 {
        Vec3::from_array(self.normal.map(|n| f32::from(n) / 127.0))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    first: u32,
    end: u32,
    pub min: Vec3,
    pub max: Vec3,
}

/// The texels of a map of one size over one head.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalpAtlas {
    width: u32,
    height: u32,
    texels: Vec<AtlasTexel>,
    blocks: Vec<Block>,
}

impl ScalpAtlas {
    /// Draw the scalp of a head into a map of this size.
    pub fn new(mesh: &TriMesh, width: u32, height: u32) -> Self {
        let mut atlas = Self { width, height, texels: Vec::new(), blocks: Vec::new() };
        let triangles = mesh.scalp_triangles();
        if triangles.is_empty() {
            return atlas;
        }
        let uvs = scalp_uvs(mesh);
        let normals = mesh.vertex_normals();
        let size = Vec2::new(width as f32, height as f32);
        let in_texels = |v: u32| {
            let [u, v] = uvs[v as usize];
            Vec2::new(u, 1.0 - v) * size - 0.5
        };
        // For each texel the nearest triangle, its distance in texels, and the weights of its corners there.
        let mut nearest = vec![(f32::INFINITY, u32::MAX, [0.0_f32; 2]); (width * height) as usize];
        for triangle_idx in triangles {
            let corners = mesh.triangles[triangle_idx as usize].map(in_texels);
            let [a, b, c] = corners;
            if !corners.iter().all(|p| p.is_finite()) || (b - a).perp_dot(c - a) == 0.0 {
                continue;
            }
            let (lo, hi) = (a.min(b).min(c) - BLEED, a.max(b).max(c) + BLEED);
            let (lo, hi) =
                (lo.ceil().max(Vec2::ZERO).as_uvec2(), hi.floor().min(size - 1.0).max(Vec2::NEG_ONE).as_ivec2());
            for y in lo.y as i32..=hi.y {
                for x in lo.x as i32..=hi.x {
                    let (squared, weights) = closest_in_triangle(Vec2::new(x as f32, y as f32), corners);
                    let texel = &mut nearest[(y as u32 * width + x as u32) as usize];
                    if squared < texel.0 && squared <= BLEED * BLEED {
                        *texel = (squared, triangle_idx, weights);
                    }
                }
            }
        }
        let across = width.div_ceil(TILE_SIDE);
        for block_y in 0..height.div_ceil(BLOCK_SIDE) {
            for block_x in 0..width.div_ceil(BLOCK_SIDE) {
                let first = atlas.texels.len() as u32;
                let (mut min, mut max) = (Vec3::MAX, Vec3::MIN);
                for y in block_y * BLOCK_SIDE..((block_y + 1) * BLOCK_SIDE).min(height) {
                    for x in block_x * BLOCK_SIDE..((block_x + 1) * BLOCK_SIDE).min(width) {
                        let (_, triangle_idx, [wb, wc]) = nearest[(y * width + x) as usize];
                        let Some(corners) = mesh.triangles.get(triangle_idx as usize) else { continue };
                        let mix = |of: &[Vec3]| -> Vec3 {
                            let [a, b, c] = corners.map(|v| of[v as usize]);
                            (1.0 - wb - wc) * a + wb * b + wc * c
                        };
                        let position = mix(&mesh.positions);
                        (min, max) = (min.min(position), max.max(position));
                        atlas.texels.push(AtlasTexel {
                            tile_idx: y / TILE_SIDE * across + x / TILE_SIDE,
                            at: (y % TILE_SIDE * TILE_SIDE + x % TILE_SIDE) as u16,
                            normal: (127.0 * mix(&normals).normalize_or_zero()).round().to_array().map(|n| n as i8),
                            position,
                        });
                    }
                }
                let end = atlas.texels.len() as u32;
                if end > first {
                    atlas.blocks.push(Block { first, end, min, max });
                }
            }
        }
        atlas
    }

    /// Whether it is of maps of this one's size.
    pub fn fits(&self, map: &ScalpMap) -> bool {
        (self.width, self.height) == (map.width(), map.height())
    }

    pub fn n_texels(&self) -> usize {
        self.texels.len()
    }

    /// The texels of all blocks whose box is wanted.
    pub(super) fn texels_in(&self, is_wanted: impl Fn(&Block) -> bool) -> impl Iterator<Item = &AtlasTexel> {
        let wanted = self.blocks.iter().filter(move |block| is_wanted(block));
        wanted.flat_map(|block| &self.texels[block.first as usize..block.end as usize])
    }
}

/// Squared distance of a point to a triangle of the plane, and the weights of corners b and c at the
/// triangle's nearest point.
fn closest_in_triangle(p: Vec2, [a, b, c]: [Vec2; 3]) -> (f32, [f32; 2]) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let det = ab.perp_dot(ac);
    let (wb, wc) = (ap.perp_dot(ac) / det, ab.perp_dot(ap) / det);
    if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
        return (0.0, [wb, wc]);
    }
    let on_edge = |from: Vec2, to: Vec2| {
        let along = to - from;
        let t = ((p - from).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        (p.distance_squared(from + t * along), t)
    };
    let (to_ab, t_ab) = on_edge(a, b);
    let (to_bc, t_bc) = on_edge(b, c);
    let (to_ca, t_ca) = on_edge(c, a);
    if to_ab <= to_bc && to_ab <= to_ca {
        (to_ab, [t_ab, 0.0])
    } else if to_bc <= to_ca {
        (to_bc, [1.0 - t_bc, t_bc])
    } else {
        (to_ca, [0.0, 1.0 - t_ca])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle_is_no_farther_than_any_other() {
        let triangle = [Vec2::new(1.0, 1.0), Vec2::new(5.0, 2.0), Vec2::new(2.0, 6.0)];
        let at = |[wb, wc]: [f32; 2]| (1.0 - wb - wc) * triangle[0] + wb * triangle[1] + wc * triangle[2];
        for i in 0..64 {
            let p = Vec2::new((i % 8) as f32, (i / 8) as f32);
            let (squared, weights) = closest_in_triangle(p, triangle);
            assert!((p.distance_squared(at(weights)) - squared).abs() < 1e-4);
            for k in 0..=400 {
                let (wb, wc) = ((k % 21) as f32 / 20.0, (k / 21) as f32 / 20.0);
                if wb + wc <= 1.0 {
                    assert!(p.distance_squared(at([wb, wc])) >= squared - 1e-4, "{p}");
                }
            }
        }
    }
}
