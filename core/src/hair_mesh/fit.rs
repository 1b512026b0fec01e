//! A hair mesh around guides that are there: imported curves become something to model with.
//!
//! The root layer is a grid on the scalp under the guides. Each of its vertices grows a path like the guides
//! around it, blended as strands are between guides; layers cut those paths at even shares of their length.
//! Fitting a closed surface around the guides was rejected: their tips say little about a surface, and the
//! inside would have to be guessed again.

use glam::Vec3;

use super::{HairMesh, HairMeshError, MeshOp};
use crate::curve::{catmull_rom, even_parameters};
use crate::mesh::TriMesh;
use crate::point_grid::PointGrid;
use crate::strands::Strands;

/// Guides that a path is blended from, at most.
const N_NEAREST: usize = 6;
/// Guides that go another way than the nearest one (cosine from root to tip) are on the other side of a
/// parting.
const PARTED: f32 = 0.3;
/// Root faces with no guide within this many cells grow nothing.
const COVERS: f32 = 0.9;
/// More layers than this are not worth having.
const MOST_LAYERS: usize = 64;

impl HairMesh {
    /// Fit a hair mesh of `n_layers` above the root around guides that grow on `head`, with root faces of about
    /// `cell_cm`.
    pub fn around_guides(
        guides: &Strands,
        head: &TriMesh,
        cell_cm: f32,
        n_layers: usize,
    ) -> Result<Self, HairMeshError> {
        if !(1..=MOST_LAYERS).contains(&n_layers) {
            return Err(HairMeshError::OutOfRange { what: "the number of layers", min: "1", max: "64" });
        }
        // Each guide at even shares of its length.
        let shapes: Vec<Vec<Vec3>> = guides
            .iter()
            .filter(|points| points.len() >= 2)
            .map(|points| even_parameters(points, n_layers + 1).iter().map(|&u| catmull_rom(points, u)).collect())
            .collect();
        if shapes.is_empty() {
            return Err(HairMeshError::NothingSelected { needed: "guides of two points or more" });
        }
        let roots: Vec<Vec3> = shapes.iter().map(|shape| shape[0]).collect();
        let grid = PointGrid::new(&roots, cell_cm.max(0.1));
        let mut mesh = Self::on_scalp(head, &head.scalp_triangles(), cell_cm)?;
        let bare = mesh.faces_far_from(&grid, &roots, COVERS * cell_cm);
        if bare.len() == mesh.n_bundles() {
            return Err(HairMeshError::NothingSelected { needed: "guides that grow on the scalp" });
        }
        if !bare.is_empty() {
            mesh.apply(&MeshOp::DeleteBundles { bundles: bare })?;
        }
        // Deleted bundles would only be gaps in the numbers.
        let faces: Vec<Vec<u32>> = mesh.layers[0].faces.iter().flatten().cloned().collect();
        let paths: Vec<Vec<Vec3>> =
            mesh.layers[0].positions.iter().map(|&p| path_like_guides(p, &grid, &shapes, cell_cm)).collect();
        let layers_at: Vec<f32> = (1..=n_layers).map(|k| k as f32 / n_layers as f32).collect();
        Self::from_paths(&paths, &faces, &layers_at)
    }

    /// Bundles without any of the points near their root face's middle, except those that are the nearest to one.
    fn faces_far_from(&self, grid: &PointGrid<'_>, points: &[Vec3], distance: f32) -> Vec<usize> {
        let middles: Vec<Vec3> = (0..self.n_bundles())
            .map(|bundle| {
                let face = self.face(0, bundle).unwrap_or_default();
                face.iter().map(|&v| self.layers[0].positions[v as usize]).sum::<Vec3>() / face.len().max(1) as f32
            })
            .collect();
        let mut is_near: Vec<bool> = middles
            .iter()
            .map(|&middle| {
                let mut is_near = false;
                grid.within(middle, distance, |_, _| is_near = true);
                is_near
            })
            .collect();
        let of_middles = PointGrid::new(&middles, distance);
        for &p in points {
            let ([(nearest, squared)], n_found) = of_middles.nearest::<1>(p);
            if n_found > 0 && squared < 4.0 * distance * distance {
                is_near[nearest] = true;
            }
        }
        (0..middles.len()).filter(|&bundle| !is_near[bundle]).collect()
    }
}

/// The blend of the nearest guides' shapes, moved to begin at `root`.
fn path_like_guides(root: Vec3, grid: &PointGrid<'_>, shapes: &[Vec<Vec3>], cell_cm: f32) -> Vec<Vec3> {
    let (nearest, n_found) = grid.nearest::<N_NEAREST>(root);
    let way = |guide: usize| (shapes[guide][shapes[guide].len() - 1] - shapes[guide][0]).normalize_or_zero();
    let first = way(nearest[0].0);
    let mut path = vec![Vec3::ZERO; shapes[0].len()];
    let mut sum = 0.0;
    for &(guide, squared) in &nearest[..n_found] {
        if way(guide).dot(first) < PARTED {
            continue;
        }
        let weight = 1.0 / (squared + 0.01 * cell_cm * cell_cm);
        sum += weight;
        for (offset, p) in path.iter_mut().zip(&shapes[guide]) {
            *offset += weight * (*p - shapes[guide][0]);
        }
    }
    path.into_iter().map(|offset| root + offset / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mean_value::mean_value_weights;
    use crate::mesh_query::tests::sphere;

    #[test]
    fn a_mesh_around_guides_traces_them_again() {
        let head = sphere(Vec3::ZERO, 9.0, 48);
        // Guides all over the crown that bend to the back.
        let mut guides = Strands::default();
        for i in 0..400_u32 {
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let polar = 1.1 * ((i as f32 + 0.5) / 400.0).sqrt();
            let d = Vec3::new(polar.sin() * cos, polar.cos(), polar.sin() * sin);
            let points = (0..=12).map(|k| {
                let t = k as f32;
                9.0 * d + d * t - Vec3::Z * 0.04 * t * t + Vec3::X * 0.02 * d.x * t * t
            });
            guides.push(&points.collect::<Vec<_>>());
        }
        let mesh = HairMesh::around_guides(&guides, &head, 2.0, 6).unwrap();
        mesh.check().unwrap();
        assert_eq!(mesh.layers.len(), 7);
        assert!((0..mesh.n_bundles()).all(|bundle| mesh.tip_layer(bundle) == Some(6)));
        // Only the crown is covered.
        assert!(mesh.layers[0].positions.iter().all(|p| p.y > 0.0));
        let mut n_in_faces = 0;
        for guide in guides.iter() {
            let middle = |bundle: usize| -> Vec3 {
                mesh.face(0, bundle).unwrap().iter().map(|&v| mesh.layers[0].positions[v as usize] / 4.0).sum()
            };
            let nearest = (0..mesh.n_bundles())
                .min_by(|&a, &b| middle(a).distance(guide[0]).total_cmp(&middle(b).distance(guide[0])))
                .unwrap();
            let at = |layer: usize| -> Vec<Vec3> {
                mesh.face(layer, nearest).unwrap().iter().map(|&v| mesh.layers[layer].positions[v as usize]).collect()
            };
            let weights = mean_value_weights(&at(0), guide[0]);
            if weights.iter().any(|w| *w < 0.0) {
                continue;
            }
            n_in_faces += 1;
            let blend = |layer: usize| -> Vec3 { at(layer).iter().zip(&weights).map(|(p, w)| *p * *w).sum() };
            let traced = guide[0] + blend(6) - blend(0);
            assert!(traced.distance(guide[12]) < 1.0, "{traced} for {}", guide[12]);
        }
        assert!(n_in_faces > 100, "{n_in_faces}");
        assert!(HairMesh::around_guides(&Strands::default(), &head, 2.0, 6).is_err());
    }
}
