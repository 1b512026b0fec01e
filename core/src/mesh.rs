//! A triangle mesh with named face groups: the head, a collider, a scalp.

use std::borrow::Cow;

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Name of the face group that grows hair.
pub const SCALP_GROUP: &str = "scalp";

/// Triangles, counter-clockwise seen from outside. Positions in centimetres.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct TriMesh {
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex, or empty until [`TriMesh::compute_normals`].
    pub normals: Vec<Vec3>,
    /// One texture coordinate a vertex, or empty.
    pub uvs: Vec<[f32; 2]>,
    pub triangles: Vec<[u32; 3]>,
    /// Named face groups; a triangle is in at most one.
    pub groups: Vec<FaceGroup>,
}

/// Triangles that belong together under a name (OBJ group, glTF primitive or material).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FaceGroup {
    pub name: String,
    /// Indices into [`TriMesh::triangles`].
    pub triangles: Vec<u32>,
}

impl TriMesh {
    /// A ball about the origin, its texture seen from above: the simplest head, for tests and measurements.
    pub fn ball(radius: f32) -> Self {
        const N: u32 = 32;
        let mut mesh = Self::default();
        for i in 0..=N {
            for j in 0..N {
                let turn = |k: u32| k as f32 / N as f32 * std::f32::consts::TAU;
                let (polar, around) = (0.5 * turn(i), turn(j));
                let p = Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
                mesh.positions.push(radius * p);
                mesh.uvs.push([0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z]);
                if i < N {
                    let (a, b) = (i * N + j, i * N + (j + 1) % N);
                    mesh.triangles.extend([[a, a + N, b], [b, a + N, b + N]]);
                }
            }
        }
        mesh
    }

    pub fn corners(&self, triangle_idx: usize) -> [Vec3; 3] {
        self.triangles[triangle_idx].map(|v| self.positions[v as usize])
    }

    pub fn group(&self, name: &str) -> Option<&FaceGroup> {
        self.groups.iter().find(|group| group.name == name)
    }

    /// Smallest box around all vertices as (min, max); `None` where there are none.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p))))
    }

    /// The triangles that grow hair: the scalp group, or all where there is none.
    pub fn scalp_triangles(&self) -> Vec<u32> {
        match self.group(SCALP_GROUP) {
            Some(group) if !group.triangles.is_empty() => group.triangles.clone(),
            Some(_) | None => (0..self.triangles.len() as u32).collect(),
        }
    }

    /// One normal a vertex: the mesh's own, or smooth ones where it has none.
    pub fn vertex_normals(&self) -> Cow<'_, [Vec3]> {
        if self.normals.len() == self.positions.len() {
            return Cow::Borrowed(&self.normals);
        }
        let mut copy = self.clone();
        copy.compute_normals();
        Cow::Owned(copy.normals)
    }

    /// Compute smooth vertex normals, weighted by area. Vertices at one place share their normal, so
    /// that texture seams do not show in the shading.
    pub fn compute_normals(&mut self) {
        use std::collections::HashMap;
        let key = |p: Vec3| p.to_array().map(f32::to_bits);
        let mut normal_at: HashMap<[u32; 3], Vec3> = HashMap::with_capacity(self.positions.len());
        for triangle_idx in 0..self.triangles.len() {
            let [a, b, c] = self.corners(triangle_idx);
            let area_normal = (b - a).cross(c - a);
            for p in [a, b, c] {
                *normal_at.entry(key(p)).or_default() += area_normal;
            }
        }
        self.normals = self
            .positions
            .iter()
            .map(|&p| normal_at.get(&key(p)).copied().unwrap_or_default().normalize_or(Vec3::Y))
            .collect();
    }
}
