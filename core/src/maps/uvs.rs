//! Texture coordinates of the scalp: the head's own where they can carry a map, made ones otherwise.
//!
//! Made ones are Lambert's azimuthal equal-area projection around the scalp's middle, so that a texel is
//! about the same area everywhere and the only border is the hairline. They depend on the mesh alone: a
//! document holds maps over them without holding them. Unfolding by conformal maps was rejected here: it
//! costs a linear solve whenever a head is opened, for a scalp that is nearly a part of a sphere.

use std::borrow::Cow;

use glam::{DMat4, DVec4, Quat, Vec3};

use crate::mesh::TriMesh;

/// Share of the map's half side that made coordinates reach to.
const REACH: f32 = 0.96;

/// One texture coordinate a vertex of the mesh. Those of vertices off the scalp may leave 0-1.
pub fn scalp_uvs(mesh: &TriMesh) -> Cow<'_, [[f32; 2]]> {
    let triangles = mesh.scalp_triangles();
    if can_carry(mesh, &triangles) { Cow::Borrowed(&mesh.uvs) } else { Cow::Owned(made_uvs(mesh, &triangles)) }
}

/// Whether the head's own coordinates are there, lie in the unit square, and cover some of it.
fn can_carry(mesh: &TriMesh, triangles: &[u32]) -> bool {
    if mesh.uvs.is_empty() || mesh.uvs.len() != mesh.positions.len() {
        return false;
    }
    let mut area = 0.0;
    for &triangle_idx in triangles {
        let [a, b, c] = mesh.triangles[triangle_idx as usize].map(|v| glam::Vec2::from(mesh.uvs[v as usize]));
        if [a, b, c].iter().any(|uv| !(uv.cmpge(glam::Vec2::splat(-1e-3)) & uv.cmple(glam::Vec2::splat(1.001))).all()) {
            return false;
        }
        area += 0.5 * (b - a).perp_dot(c - a).abs();
    }
    area > 1e-4
}

fn made_uvs(mesh: &TriMesh, triangles: &[u32]) -> Vec<[f32; 2]> {
    let on_scalp = || triangles.iter().flat_map(|&t| mesh.corners(t as usize)).filter(|p| p.is_finite());
    let (lo, hi) = on_scalp().fold((Vec3::MAX, Vec3::MIN), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let middle = 0.5 * (lo + hi);
    let area_normal: Vec3 = triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh.corners(t as usize);
            (b - a).cross(c - a)
        })
        .filter(|n| n.is_finite())
        .sum();
    // A closed surface has no middle: up.
    let total: f32 = (hi - lo).length_squared();
    let axis = if area_normal.length() > 1e-2 * total { area_normal.normalize_or(Vec3::Y) } else { Vec3::Y };
    let centre = middle + sphere_centre(on_scalp().map(|p| p - middle)).unwrap_or(-axis * 0.5 * total.sqrt());
    let to_pole = Quat::from_rotation_arc(axis, Vec3::Y);
    // Compute rho = sin(theta / 2), whose square is the share of a sphere's area within theta of the pole.
    let place = |p: Vec3| {
        let d = (to_pole * (p - centre)).normalize_or(Vec3::Y);
        let rho = (0.5 * (1.0 - d.y)).max(0.0).sqrt();
        let around = glam::vec2(d.x, -d.z).normalize_or(glam::Vec2::X);
        rho * around
    };
    let farthest = on_scalp().map(|p| place(p).length()).fold(1e-6, f32::max);
    mesh.positions.iter().map(|&p| (0.5 + 0.5 * REACH / farthest * place(p)).to_array()).collect()
}

/// The centre of the sphere that fits points best: the least squares of |p|^2 = 2 c p + k, which is linear in
/// c and k. `None` where they lie in a plane.
fn sphere_centre(points: impl Iterator<Item = Vec3>) -> Option<Vec3> {
    let (mut normal_matrix, mut right_side) = (DMat4::ZERO, DVec4::ZERO);
    for p in points {
        let row = (2.0 * p.as_dvec3()).extend(1.0);
        normal_matrix += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
        right_side += row * p.as_dvec3().length_squared();
    }
    let scale = (normal_matrix.x_axis.x + normal_matrix.y_axis.y + normal_matrix.z_axis.z) / 3.0;
    let is_flat = normal_matrix.determinant() < 1e-6 * scale.powi(3) * normal_matrix.w_axis.w;
    (!is_flat).then(|| (normal_matrix.inverse() * right_side).truncate().as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{FaceGroup, SCALP_GROUP};
    use crate::mesh_query::tests::sphere;

    /// A ball whose upper part is scalp, without coordinates of its own.
    fn bald_ball() -> TriMesh {
        let mut ball = sphere(Vec3::new(0.0, 3.0, 1.0), 9.0, 48);
        let triangles = (0..ball.triangles.len() as u32)
            .filter(|&t| ball.corners(t as usize).iter().all(|p| p.y > 3.0 + 9.0 * 0.2))
            .collect();
        ball.groups = vec![FaceGroup { name: SCALP_GROUP.to_owned(), triangles }];
        ball
    }

    #[test]
    fn made_coordinates_keep_areas_and_stay_in_the_map() {
        let ball = bald_ball();
        let uvs = scalp_uvs(&ball);
        assert!(matches!(uvs, Cow::Owned(_)));
        let ratios: Vec<f32> = ball
            .scalp_triangles()
            .into_iter()
            .map(|t| {
                let [a, b, c] = ball.corners(t as usize);
                let area = 0.5 * (b - a).cross(c - a).length();
                let [a, b, c] = ball.triangles[t as usize].map(|v| glam::Vec2::from(uvs[v as usize]));
                for uv in [a, b, c] {
                    assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{uv}");
                }
                (0.5 * (b - a).perp_dot(c - a).abs(), area)
            })
            .filter(|(_, area)| *area > 1e-4)
            .map(|(in_map, area)| in_map / area)
            .collect();
        let mean = ratios.iter().sum::<f32>() / ratios.len() as f32;
        // Exact for small triangles of a sphere; these are chords of 4 degrees.
        assert!(ratios.iter().all(|ratio| (0.95..1.05).contains(&(ratio / mean))), "of {mean}");
    }

    #[test]
    fn coordinates_that_carry_a_map_are_kept_and_others_are_not() {
        let mut ball = bald_ball();
        ball.uvs = ball.positions.iter().map(|p| [0.5 + p.x / 20.0, 0.5 + p.z / 40.0]).collect();
        assert!(matches!(scalp_uvs(&ball), Cow::Borrowed(_)));
        let own = ball.uvs.clone();
        ball.uvs.iter_mut().for_each(|uv| uv[0] += 3.0);
        assert!(matches!(scalp_uvs(&ball), Cow::Owned(_)), "beyond the unit square");
        ball.uvs = vec![[0.5; 2]; own.len()];
        assert!(matches!(scalp_uvs(&ball), Cow::Owned(_)), "all at one place");
    }

    #[test]
    fn the_same_head_gives_the_same_coordinates() {
        assert_eq!(scalp_uvs(&bald_ball()), scalp_uvs(&bald_ball()));
    }
}
