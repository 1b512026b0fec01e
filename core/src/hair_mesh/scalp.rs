//! Beginning a hair mesh: a root layer of polygons on the scalp.
//!
//! Two ways: the head's own triangles, paired to quads where that makes good ones, exactly where they are; or
//! a grid of quads of a chosen size. The grid is that of a cube around the head, so that it has four
//! irregular vertices and else rows from ear to ear and from forehead to nape; a map by latitude and longitude
//! was rejected, since all its rows meet in one vertex on the crown.

use std::collections::HashMap;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Mat3, Vec3};

use super::{HairMesh, HairMeshError};
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;

/// Grid cells that keep less than this share of their area on the scalp are left out.
const SMALLEST_CELL: f32 = 0.3;
/// Most cells across the crown of a grid.
const MOST_CELLS: u32 = 128;
const NO_SCALP: HairMeshError = HairMeshError::NothingSelected { needed: "faces of the scalp" };

impl HairMesh {
    /// A root layer of the given triangles of the head, neighbours merged to quads where those are good.
    pub fn from_scalp(head: &TriMesh, triangles: &[u32]) -> Result<Self, HairMeshError> {
        // Vertices at one place are one: texture seams do not part hair.
        let mut vertex_at: HashMap<[u32; 3], u32> = HashMap::new();
        let mut positions: Vec<Vec3> = Vec::new();
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for triangle_idx in triangles {
            let Some(triangle) = head.triangles.get(*triangle_idx as usize) else { continue };
            let corner = triangle.map(|v| {
                let p = head.positions[v as usize];
                *vertex_at.entry(p.to_array().map(f32::to_bits)).or_insert_with(|| {
                    positions.push(p);
                    positions.len() as u32 - 1
                })
            });
            if corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0] {
                corners.push(corner);
            }
        }
        if corners.is_empty() {
            return Err(NO_SCALP);
        }
        Self::from_polygons(positions.clone(), paired_to_quads(&positions, &corners))
    }

    /// A root layer of quads of about `cell_cm` on the given triangles of the head. On a head that is symmetric
    /// across X = 0 the quads are too.
    pub fn on_scalp(head: &TriMesh, triangles: &[u32], cell_cm: f32) -> Result<Self, HairMeshError> {
        if !(0.1..=50.0).contains(&cell_cm) {
            return Err(HairMeshError::OutOfRange { what: "the size of a face", min: "0.1", max: "50 cm" });
        }
        let query = MeshQuery::of_triangles(head, triangles.iter().copied()).map_err(|_| NO_SCALP)?;
        let ball = Ball::around(head, triangles).ok_or(NO_SCALP)?;
        let n = (FRAC_PI_2 * ball.radius / cell_cm / 2.0).round().max(1.0) as u32 * 2;
        let grid = CubeGrid { n: n.min(MOST_CELLS) };
        // Rays from the middle of the head; what misses goes to the border.
        let place = |direction: Vec3| match query.ray(ball.centre, direction) {
            Some(hit) => (hit.position, true),
            None => (query.closest(ball.centre + ball.radius * direction).position, false),
        };
        let (directions, quads) = grid.quads();
        let places: Vec<(Vec3, bool)> = directions.iter().map(|&d| place(ball.rotation * d)).collect();
        let mut new_index = vec![u32::MAX; places.len()];
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for quad in quads {
            let n_inside = quad.iter().filter(|&&v| places[v as usize].1).count();
            if n_inside < 2 {
                continue;
            }
            let [a, b, c, d] = quad.map(|v| places[v as usize].0);
            let area = 0.5 * (c - a).cross(d - b);
            let middle = (a + b + c + d) / 4.0 - ball.centre;
            if area.dot(middle.normalize_or_zero()) < SMALLEST_CELL * cell_cm * cell_cm && n_inside < 4 {
                continue;
            }
            faces.push(Vec::from(quad.map(|v| {
                if new_index[v as usize] == u32::MAX {
                    new_index[v as usize] = positions.len() as u32;
                    positions.push(places[v as usize].0);
                }
                new_index[v as usize]
            })));
        }
        if faces.is_empty() {
            // A patch smaller than a cell.
            return Self::from_scalp(head, triangles);
        }
        Self::from_polygons(positions, faces)
    }
}

/// Where a scalp's normals come from, and how far out it lies.
struct Ball {
    centre: Vec3,
    radius: f32,
    /// From the grid's axes (Y to the crown, Z to the face) to head space.
    rotation: Mat3,
}

impl Ball {
    fn around(head: &TriMesh, triangles: &[u32]) -> Option<Self> {
        let (mut matrix, mut right, mut pole) = (Mat3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let (mut area, mut middle) = (0.0, Vec3::ZERO);
        let of_triangles: Vec<(Vec3, Vec3)> = triangles
            .iter()
            .filter(|&&t| (t as usize) < head.triangles.len())
            .map(|&t| {
                let [a, b, c] = head.corners(t as usize);
                ((a + b + c) / 3.0, 0.5 * (b - a).cross(c - a))
            })
            .filter(|(p, n)| p.is_finite() && n.length() > 0.0)
            .collect();
        // Compute the point nearest to all lines along normals: sum (I - n n^T) (c - p) = 0 by area.
        for &(p, n) in &of_triangles {
            let (weight, n) = (n.length(), n.normalize());
            let across = Mat3::IDENTITY - Mat3::from_cols(n * n.x, n * n.y, n * n.z);
            matrix += across * weight;
            right += across * p * weight;
            pole += n * weight;
            middle += p * weight;
            area += weight;
        }
        if area <= 0.0 {
            return None;
        }
        // A flat patch has no centre of its own: a faint pull to a point below it decides.
        let below = middle / area - pole.normalize_or(Vec3::Y) * 10.0;
        let pull = 1e-3 * area;
        matrix += Mat3::IDENTITY * pull;
        right += below * pull;
        let mut centre = matrix.inverse() * right;
        let size = of_triangles.iter().map(|(p, _)| p.distance(centre)).fold(0.0, f32::max);
        if centre.x.abs() < 0.05 * size {
            centre.x = 0.0;
            pole.x = 0.0;
        }
        let radius = of_triangles.iter().map(|(p, n)| p.distance(centre) * n.length()).sum::<f32>() / area;
        let up = pole.normalize_or(Vec3::Y);
        let front = Vec3::Z.reject_from_normalized(up).normalize_or(up.any_orthonormal_vector());
        Some(Self { centre, radius, rotation: Mat3::from_cols(up.cross(front), up, front) })
    }
}

/// The upper face of a cube and its four sides, as a grid of directions at even angles. `n` cells across the
/// upper face, and as many rows down the sides, to 135 degrees from the crown.
struct CubeGrid {
    n: u32,
}

impl CubeGrid {
    /// Directions and quads, counter-clockwise seen from outside.
    fn quads(&self) -> (Vec<Vec3>, Vec<[u32; 4]>) {
        let n = self.n;
        let tan = |i: u32| (FRAC_PI_2 * i as f32 / n as f32 - FRAC_PI_4).tan();
        let mut directions: Vec<Vec3> = Vec::new();
        for j in 0..=n {
            directions.extend((0..=n).map(|i| Vec3::new(tan(i), 1.0, tan(j))));
        }
        let top = |i: u32, j: u32| i + (n + 1) * j;
        let mut quads = Vec::new();
        for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
            quads.push([top(i, j), top(i, j + 1), top(i + 1, j + 1), top(i + 1, j)]);
        }
        // Around the rim, left to right seen from outside: along +Z, then +X, -Z and -X.
        let rim: Vec<u32> = (0..n)
            .map(|i| top(i, n))
            .chain((0..n).map(|j| top(n, n - j)))
            .chain((0..n).map(|i| top(n - i, 0)))
            .chain((0..n).map(|j| top(0, j)))
            .collect();
        let mut above = rim.clone();
        for row in 1..=n {
            let down = tan(n - row);
            let below: Vec<u32> = rim
                .iter()
                .enumerate()
                .map(|(k, &v)| {
                    let d = directions[v as usize];
                    // The rim's corners lie on two sides; both say the same.
                    let side = if k < n as usize || (2 * n as usize..3 * n as usize).contains(&k) { d.z } else { d.x };
                    let scale = side.abs().max(f32::MIN_POSITIVE);
                    directions.push(Vec3::new(d.x / scale, down, d.z / scale));
                    directions.len() as u32 - 1
                })
                .collect();
            for k in 0..rim.len() {
                let next = (k + 1) % rim.len();
                quads.push([above[k], below[k], below[next], above[next]]);
            }
            above = below;
        }
        (directions.into_iter().map(Vec3::normalize).collect(), quads)
    }
}

/// Polygons of triangles: the best quads first, then the triangles that are left.
fn paired_to_quads(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut triangles_of: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for (triangle_idx, [a, b, c]) in triangles.iter().copied().enumerate() {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            triangles_of.entry([a.min(b), a.max(b)]).or_default().push(triangle_idx);
        }
    }
    let mut pairs: Vec<(f32, usize, usize, [u32; 4])> = Vec::new();
    for (&[a, b], of_edge) in &triangles_of {
        let &[one, other] = of_edge.as_slice() else { continue };
        let apex = |t: usize| triangles[t].into_iter().find(|v| *v != a && *v != b).unwrap_or(a);
        let (p, q) = (apex(one), apex(other));
        if p == q {
            continue;
        }
        // From the apex of the one, along its own direction of turning.
        let at = triangles[one].iter().position(|&v| v == p).unwrap_or(0);
        let quad = [p, triangles[one][(at + 1) % 3], q, triangles[one][(at + 2) % 3]];
        let quality = quad_quality(quad.map(|v| positions[v as usize]));
        if quality > 0.0 {
            pairs.push((quality, one.min(other), one.max(other), quad));
        }
    }
    pairs.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut is_used = vec![false; triangles.len()];
    let mut faces: Vec<(usize, Vec<u32>)> = Vec::new();
    for (_, one, other, quad) in pairs {
        if !is_used[one] && !is_used[other] {
            is_used[one] = true;
            is_used[other] = true;
            faces.push((one, quad.to_vec()));
        }
    }
    faces.extend((0..triangles.len()).filter(|&t| !is_used[t]).map(|t| (t, triangles[t].to_vec())));
    faces.sort_unstable_by_key(|(first, _)| *first);
    faces.into_iter().map(|(_, face)| face).collect()
}

/// 1 for a flat rectangle, less the further corners are from right angles or the halves from one plane; not
/// above 0 for what should stay two triangles.
fn quad_quality(corners: [Vec3; 4]) -> f32 {
    let edge = |i: usize| (corners[(i + 1) % 4] - corners[i % 4]).normalize_or_zero();
    let worst = (0..4).map(|i| edge(i).dot(edge(i + 1)).abs()).fold(0.0, f32::max);
    let half = |i: usize| (corners[i + 1] - corners[i]).cross(corners[(i + 2) % 4] - corners[i]).normalize_or_zero();
    let flat = half(0).dot((corners[2] - corners[0]).cross(corners[3] - corners[0]).normalize_or_zero());
    // 45 and 135 degrees, and a fold of 45 degrees, are too much.
    (1.0 - worst / 0.75).min((flat - 0.7) / 0.3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_query::tests::sphere;

    /// The upper part of a sphere of 9 cm: a scalp.
    fn cap() -> (TriMesh, Vec<u32>) {
        let head = sphere(Vec3::new(0.0, 3.0, 1.0), 9.0, 48);
        let on_cap = |&t: &u32| head.corners(t as usize).iter().all(|p| p.y > 2.0 - 0.4 * p.z);
        let triangles = (0..head.triangles.len() as u32).filter(on_cap).collect();
        (head, triangles)
    }

    fn area(mesh: &HairMesh, bundle: usize) -> Vec3 {
        let corners: Vec<Vec3> =
            mesh.face(0, bundle).unwrap().iter().map(|&v| mesh.layers[0].positions[v as usize]).collect();
        let fan = (1..corners.len() - 1).map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]));
        0.5 * fan.sum::<Vec3>()
    }

    #[test]
    fn a_grid_covers_the_scalp_with_even_quads_that_face_out_and_are_symmetric() {
        let (head, triangles) = cap();
        let scalp_area: f32 = triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = head.corners(t as usize);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        for cell_cm in [1.5, 2.5, 4.0] {
            let mesh = HairMesh::on_scalp(&head, &triangles, cell_cm).unwrap();
            let areas: Vec<Vec3> = (0..mesh.n_bundles()).map(|bundle| area(&mesh, bundle)).collect();
            let total: f32 = areas.iter().map(|a| a.length()).sum();
            // Flat faces lie under a round scalp, the more the larger they are.
            assert!((total / scalp_area - 1.0).abs() < 0.09 + 0.015 * cell_cm, "{total} of {scalp_area} at {cell_cm}");
            let centre = Vec3::new(0.0, 3.0, 1.0);
            for (bundle, area) in areas.iter().enumerate() {
                let p = mesh.layers[0].positions[mesh.face(0, bundle).unwrap()[0] as usize];
                assert!(area.dot(p - centre) > 0.0, "{bundle} faces in");
                assert!(area.length() < 2.0 * cell_cm * cell_cm, "{}", area.length());
            }
            for &p in &mesh.layers[0].positions {
                assert!((p.distance(centre) - 9.0).abs() < 0.1, "on the scalp");
                if p.y < 3.0 - 0.4 * p.z {
                    // The border of this scalp is as ragged as its triangles, which are not symmetric.
                    continue;
                }
                let image = Vec3::new(-p.x, p.y, p.z);
                assert!(mesh.layers[0].positions.iter().any(|q| q.distance(image) < 0.1), "{p}");
            }
        }
        assert!(HairMesh::on_scalp(&head, &[], 2.0).is_err());
        assert!(HairMesh::on_scalp(&head, &triangles, 0.0).is_err());
        // A patch smaller than a cell is still a beginning.
        assert!(HairMesh::on_scalp(&head, &triangles[..2], 40.0).unwrap().n_bundles() > 0);
    }

    #[test]
    fn triangles_of_the_scalp_are_paired_to_quads_where_they_are() {
        let (head, triangles) = cap();
        let mesh = HairMesh::from_scalp(&head, &triangles).unwrap();
        let n_quads = (0..mesh.n_bundles()).filter(|&b| mesh.face(0, b).unwrap().len() == 4).count();
        let n_triangles = mesh.n_bundles() - n_quads;
        let has_corners = |t: &&u32| {
            let [a, b, c] = head.corners(**t as usize);
            a != b && b != c && c != a
        };
        assert_eq!(2 * n_quads + n_triangles, triangles.iter().filter(has_corners).count());
        assert!(n_quads > 4 * n_triangles, "{n_quads} quads, {n_triangles} triangles");
        assert!((0..mesh.n_bundles()).all(|bundle| {
            let p = mesh.layers[0].positions[mesh.face(0, bundle).unwrap()[0] as usize];
            area(&mesh, bundle).dot(p - Vec3::new(0.0, 3.0, 1.0)) > 0.0
        }));
        // Every vertex is one of the head's.
        assert!(mesh.layers[0].positions.iter().all(|p| head.positions.contains(p)));
        assert_eq!(HairMesh::from_scalp(&head, &[]), Err(NO_SCALP));
    }
}
