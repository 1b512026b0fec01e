//! Paths of hair grown from the scalp over the body: how the corners of a hair mesh are placed by code.
//!
//! A path leaves the scalp between its normal and the flow of the hair, gives way to its weight the longer
//! it is, and slides along the body at a clearance. Strands with a larger clearance lie on top of those
//! with a smaller one, so a groom gets its layers by giving upper rows more. Solving for a rest shape was
//! rejected: its result is hard to aim.

use glam::Vec3;

use crate::curve::catmull_rom;
use crate::distance_field::DistanceField;
use crate::hair_mesh::{HairMesh, HairMeshError, HairMeshLayer};

/// How one path grows. Lengths in centimetres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Growth {
    pub length: f32,
    /// 0 leaves along the scalp, 1 along its normal.
    pub lift: f32,
    /// How much the direction turns down in a centimetre, at the root.
    pub fall: f32,
    /// How much more it turns down in a centimetre for every centimetre from the root.
    pub weight: f32,
    /// Distance from the body that the path keeps, reached over `clear_over` from the root.
    pub clearance: f32,
    pub clear_over: f32,
}

impl Default for Growth {
    fn default() -> Self {
        Self { length: 30.0, lift: 0.35, fall: 0.12, weight: 0.02, clearance: 1.0, clear_over: 4.0 }
    }
}

/// Length of a step, in centimetres.
const STEP: f32 = 0.25;

/// Grow a path from `root` with the scalp's unit normal there, first along `flow` (any length; its part
/// along the scalp counts). Points are evenly spaced by about a quarter of a centimetre, root first.
pub fn grow(body: &DistanceField, root: Vec3, normal: Vec3, flow: Vec3, growth: &Growth) -> Vec<Vec3> {
    let along = flow.reject_from_normalized(normal).normalize_or(Vec3::NEG_Y);
    let n_steps = (growth.length / STEP).ceil().max(1.0) as usize;
    let step = growth.length / n_steps as f32;
    let mut direction = along.lerp(normal, growth.lift.clamp(0.0, 1.0)).normalize_or(normal);
    let mut points = vec![root];
    let mut p = root;
    for k in 1..=n_steps {
        let length = k as f32 * step;
        direction = (direction + Vec3::NEG_Y * step * (growth.fall + growth.weight * length)).normalize_or(Vec3::NEG_Y);
        let mut next = p + direction * step;
        let clearance = growth.clearance * (length / growth.clear_over.max(step)).min(1.0);
        // A few small corrections follow a curved body better than one.
        for _ in 0..3 {
            let distance = body.sample(next);
            if distance < clearance {
                next += 0.5 * (clearance - distance) * body.gradient(next).normalize_or(normal);
            }
        }
        direction = (next - p).normalize_or(direction);
        p += direction * step;
        points.push(p);
    }
    points
}

impl HairMesh {
    /// A hair mesh whose chains are given: `paths[v]` begins at root vertex `v`, and layer `k` cuts every
    /// path at the share `layers_at[k - 1]` (rising, 0-1] of its points. Vertices that stand for two sides
    /// of a parting are simply two vertices at one place.
    pub fn from_paths(paths: &[Vec<Vec3>], faces: &[Vec<u32>], layers_at: &[f32]) -> Result<Self, HairMeshError> {
        let at = |share: f32| -> HairMeshLayer {
            let cut = |path: &Vec<Vec3>| catmull_rom(path, share * path.len().saturating_sub(1) as f32);
            HairMeshLayer {
                positions: paths.iter().map(cut).collect(),
                faces: faces.iter().map(|face| Some(face.clone())).collect(),
                pinned: Vec::new(),
            }
        };
        let mesh = Self { layers: std::iter::once(&0.0).chain(layers_at).map(|&share| at(share)).collect() };
        mesh.check()?;
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_query::tests::sphere;
    use crate::strands::polyline_length;

    #[test]
    fn paths_have_their_length_keep_clear_and_fall() {
        let body = DistanceField::from_mesh(&sphere(Vec3::ZERO, 8.0, 48), 64).unwrap();
        let mut paths = Vec::new();
        for (clearance, turn) in [(0.4, 0.0), (1.2, 0.8), (2.0, 2.0)] {
            let normal = Vec3::new(turn, 2.0, 0.5).normalize();
            let growth = Growth { clearance, length: 30.0, ..Growth::default() };
            let path = grow(&body, 8.0 * normal, normal, Vec3::new(1.0, 0.0, 0.2), &growth);
            assert!((polyline_length(&path) - 30.0).abs() < 0.1);
            assert_eq!(path[0], 8.0 * normal);
            for (k, p) in path.iter().enumerate().skip(20) {
                // Past the widest part the path hangs free.
                assert!(p.length() - 8.0 > 0.75 * clearance, "{} of {clearance} at {k}", p.length() - 8.0);
            }
            assert!(path[path.len() - 1].y < -10.0);
            paths.push(path);
        }
        let mesh = HairMesh::from_paths(&paths, &[vec![0, 1, 2]], &[0.1, 0.3, 0.6, 1.0]).unwrap();
        assert_eq!((mesh.layers.len(), mesh.tip_layer(0)), (5, Some(4)));
        assert!(mesh.layers[4].positions[1].distance(paths[1][120]) < 1e-5);
        HairMesh::from_paths(&paths, &[vec![0, 1, 7]], &[1.0]).unwrap_err();
    }
}
