//! The baked head: the mannequin meshed, cut along the hairline, unwrapped and named.

use std::collections::HashMap;

use glam::Vec3;
use lorelei_core::mesh::{FaceGroup, SCALP_GROUP, TriMesh};

use super::mannequin::Mannequin;
use super::{hairline, mesher, unwrap};

/// Head space: centimetres, Y up, Z out of the nose. Groups `scalp`, `skin` and `ears`.
pub fn head(mannequin: &Mannequin) -> TriMesh {
    let mut surface = mesher::mesh(mannequin);
    let is_scalp = surface.cut(mannequin, |p| hairline::scalp(mannequin, p));
    let of_scalp = mesher::largest_piece(&surface.triangles, &is_scalp);
    let in_scalp: std::collections::BTreeSet<u32> = of_scalp.iter().copied().collect();
    let of_skin: Vec<u32> = (0..surface.triangles.len() as u32).filter(|t| !in_scalp.contains(t)).collect();
    let normals: Vec<Vec3> = surface.positions.iter().map(|&p| mannequin.normal(p)).collect();
    let mut scalp = unwrap::scalp_chart(&surface.positions, &surface.triangles, &of_scalp);
    let mut skin = unwrap::skin_charts(&surface.positions, &normals, &surface.triangles, &of_skin);
    unwrap::pack(&mut scalp, &mut skin);

    let mut mesh = TriMesh::default();
    let [mut scalp_group, mut skin_group, mut ear_group] =
        [SCALP_GROUP, "skin", "ears"].map(|name| FaceGroup { name: name.to_owned(), triangles: Vec::new() });
    for (chart_idx, chart) in std::iter::once(&scalp).chain(&skin).enumerate() {
        let mut index_of: HashMap<u32, u32> = HashMap::new();
        for &t in &chart.triangles {
            let corners = surface.triangles[t as usize];
            let triangle = corners.map(|v| {
                *index_of.entry(v).or_insert_with(|| {
                    mesh.positions.push(surface.positions[v as usize]);
                    mesh.normals.push(normals[v as usize]);
                    mesh.uvs.push(chart.uv_of[&v].to_array());
                    mesh.positions.len() as u32 - 1
                })
            });
            let middle = corners.iter().map(|&v| surface.positions[v as usize]).sum::<Vec3>() / 3.0;
            let group = if chart_idx == 0 {
                &mut scalp_group
            } else if mannequin.ear_distance(middle) < 0.12 {
                &mut ear_group
            } else {
                &mut skin_group
            };
            group.triangles.push(mesh.triangles.len() as u32);
            mesh.triangles.push(triangle);
        }
    }
    mesh.groups = vec![scalp_group, skin_group, ear_group];
    mesh
}
