//! The embedded mannequin: `head.glb` read back into a mesh with named face groups.

use std::sync::OnceLock;

use glam::Vec3;
use lorelei_core::groom::{Groom, Head, Source};
use lorelei_core::mesh::{FaceGroup, TriMesh};

const GLB: &[u8] = include_bytes!("../head.glb");

/// Head, ears, neck and shoulders of a salon training head. Centimetres, Y up, Z out of the nose; the
/// eye line is y = 0. Groups `scalp`, `skin` and `ears`; the scalp is one chart at the left of the
/// texture square.
///
/// # Panics
/// If the embedded file is damaged, which a test rules out.
pub fn head() -> TriMesh {
    read(GLB).expect("the embedded head is a valid GLB")
}

/// The name under which documents refer to the mannequin.
const MANNEQUIN: &str = "mannequin";

/// The mannequin as a groom's head, read once: all grooms share its mesh.
pub fn mannequin() -> Head {
    static HEAD: OnceLock<Head> = OnceLock::new();
    HEAD.get_or_init(|| Head { embedded: Some(MANNEQUIN.to_owned()), ..Head::new("Mannequin", head()) }).clone()
}

/// Give a head that only names the embedded one its mesh.
pub fn complete_head(head: &mut Head) {
    if head.embedded.as_deref() == Some(MANNEQUIN) && head.mesh.positions.is_empty() {
        head.mesh = mannequin().mesh;
    }
}

/// Give a groom that was just read from a document the embedded head that it refers to. Hair meshes of a
/// document without any head get the mannequin too: they are modelled on it, and nothing else says where
/// their roots lie. Returns what is to be told to the user.
pub fn complete(groom: &mut Groom) -> Option<String> {
    let has_hair_mesh = groom.layers.iter().any(|layer| matches!(layer.source, Source::HairMesh(_)));
    match groom.head.as_ref().map(|head| head.embedded.as_deref()) {
        Some(Some(MANNEQUIN)) => {
            groom.head = Some(mannequin());
            None
        }
        Some(Some(unknown)) => {
            let note = format!("The head `{unknown}` is not in this version of Lorelei: shown on the mannequin");
            groom.head = Some(mannequin());
            Some(note)
        }
        None if has_hair_mesh => {
            groom.head = Some(mannequin());
            Some("The file has no head: shown on the mannequin".to_owned())
        }
        Some(None) | None => None,
    }
}

/// The first mesh of a GLB; primitives become groups named by their material.
fn read(bytes: &[u8]) -> Option<TriMesh> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).ok()?;
    let blob = blob?;
    let mut mesh = TriMesh::default();
    for primitive in document.meshes().next()?.primitives() {
        let reader = primitive.reader(|_| Some(&blob));
        // All primitives share their vertices.
        if mesh.positions.is_empty() {
            mesh.positions = reader.read_positions()?.map(|p| 100.0 * Vec3::from_array(p)).collect();
            mesh.normals = reader.read_normals()?.map(Vec3::from_array).collect();
            mesh.uvs = reader.read_tex_coords(0)?.into_f32().map(|[u, v]| [u, 1.0 - v]).collect();
        }
        let indices: Vec<u32> = reader.read_indices()?.into_u32().collect();
        let first = mesh.triangles.len() as u32;
        mesh.triangles.extend(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
        let name = primitive.material().name()?.to_owned();
        mesh.groups.push(FaceGroup { name, triangles: (first..mesh.triangles.len() as u32).collect() });
    }
    Some(mesh)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use glam::{DVec2, dvec2};
    use lorelei_core::mesh::SCALP_GROUP;
    use lorelei_core::mesh_query::MeshQuery;

    use super::*;

    #[test]
    fn a_hair_mesh_without_a_head_gets_the_mannequin_and_nothing_else_does() {
        let styled = crate::hairstyle("bob").unwrap();
        let mut headless = Groom { head: None, ..styled.clone() };
        assert!(complete(&mut headless).is_some());
        assert_eq!(headless.head, Some(mannequin()));
        let empty = Head { embedded: Some(MANNEQUIN.to_owned()), ..Head::default() };
        let mut referring = Groom { head: Some(empty), ..styled.clone() };
        assert_eq!(complete(&mut referring), None);
        assert!(referring == styled);
        let mut bare = Groom::default();
        assert!(complete(&mut bare).is_none() && bare.head.is_none());
        let mut own = Groom { head: Some(Head::new("own", head())), ..styled };
        assert!(complete(&mut own).is_none());
        assert_eq!(own.head.map(|head| head.name), Some("own".to_owned()));
    }

    /// Distance from `from` along `towards` to the first skin.
    fn reach(query: &MeshQuery, from: Vec3, towards: Vec3) -> f32 {
        query.ray(from, towards).map_or(f32::NAN, |hit| hit.position.distance(from))
    }

    fn is_about(value: f32, wanted: f32, tolerance: f32) {
        assert!((value - wanted).abs() <= tolerance, "{value} is not {wanted} +- {tolerance}");
    }

    #[test]
    fn head_has_the_proportions_of_a_salon_head() {
        let mesh = head();
        let query = MeshQuery::new(&mesh).unwrap();
        let (min, max) = mesh.bounds().unwrap();
        // Vertex to chin 22.5 with the eyes half way.
        is_about(max.y, 11.25, 0.15);
        let chin = mesh.positions.iter().filter(|p| p.x.abs() < 1.0 && p.z > 6.0).map(|p| p.y).fold(f32::MAX, f32::min);
        is_about(chin, -11.25, 0.3);
        // Breadth over the ears 15.2; glabella to the back of the head 19.5.
        let left = reach(&query, Vec3::new(0.0, 4.0, -2.0), Vec3::X);
        is_about(2.0 * left, 15.2, 0.4);
        let glabella = reach(&query, Vec3::new(0.0, 2.3, 0.0), Vec3::Z);
        let back = mesh.positions.iter().filter(|p| p.y > -3.0).map(|p| p.z).fold(f32::MAX, f32::min);
        is_about(glabella - back, 19.5, 0.4);
        // The nose ends half way from brow (2.2) to chin, and stands out.
        let tip = mesh.positions.iter().filter(|p| p.z > 11.0).map(|p| p.y);
        let nose_base = tip.fold(f32::MAX, f32::min);
        is_about(nose_base, -4.5, 0.8);
        // Neck 11-12 across; shoulders cut 38-40 wide; a flat base.
        let neck = reach(&query, Vec3::new(0.0, -13.0, -3.8), Vec3::X);
        is_about(2.0 * neck, 11.5, 0.5);
        is_about(max.x - min.x, 39.0, 1.0);
        assert!(mesh.positions.iter().filter(|p| p.y < min.y + 0.02).count() > 50);
    }

    #[test]
    fn head_is_closed_and_of_the_right_size() {
        let mesh = head();
        assert!((10_000..=30_000).contains(&mesh.triangles.len()), "{} triangles", mesh.triangles.len());
        let mut id_of: HashMap<[u32; 3], u32> = HashMap::new();
        let ids: Vec<u32> = mesh
            .positions
            .iter()
            .map(|p| {
                let next = id_of.len() as u32;
                *id_of.entry(p.to_array().map(f32::to_bits)).or_insert(next)
            })
            .collect();
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| ids[v as usize]);
            assert!(a != b && b != c && c != a);
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        assert!(
            edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)),
            "an open or branching edge"
        );
        let n_edges = edges.len() / 2;
        assert_eq!(id_of.len() + mesh.triangles.len(), n_edges + 2, "a closed surface without handles");
        let in_groups: usize = mesh.groups.iter().map(|group| group.triangles.len()).sum();
        assert_eq!(in_groups, mesh.triangles.len());
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
        assert!(mesh.uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    }

    #[test]
    fn scalp_chart_is_nearly_rigid_and_its_area_that_of_a_scalp() {
        let mesh = head();
        let scalp = mesh.group(SCALP_GROUP).unwrap();
        let mut singular: Vec<(f64, f64, f64)> = Vec::new();
        for &t in &scalp.triangles {
            let [a, b, c] = mesh.corners(t as usize).map(Vec3::as_dvec3);
            let [ua, ub, uc] =
                mesh.triangles[t as usize].map(|v| DVec2::from_array(mesh.uvs[v as usize].map(f64::from)));
            let (e1, e2) = (b - a, c - a);
            let x = e1.normalize();
            let height = e1.cross(e2).length() / e1.length();
            // Columns of d(uv) / d(surface).
            let du = (ub - ua) / e1.length();
            let dv = (uc - ua - du * e2.dot(x)) / height;
            let det = du.perp_dot(dv);
            assert!(det > 0.0, "triangle {t} is folded");
            let (s, d) = (
                du.length_squared() + dv.length_squared(),
                (dvec2(du.length_squared() - dv.length_squared(), 2.0 * du.dot(dv))).length(),
            );
            singular.push((f64::midpoint(s, d).sqrt(), ((s - d).max(0.0) / 2.0).sqrt(), 0.5 * e1.cross(e2).length()));
        }
        let area: f64 = singular.iter().map(|s| s.2).sum();
        assert!((560.0..=720.0).contains(&area), "scalp of {area} cm2");
        // Every centimetre of the scalp as long in the chart as the average one, within a share.
        let scale = (singular.iter().map(|s| s.0 * s.1 * s.2).sum::<f64>() / area).sqrt();
        let well = |limit: f64| {
            let fine = singular.iter().filter(|s| s.0 / scale < limit && s.1 / scale > 1.0 / limit);
            fine.map(|s| s.2).sum::<f64>() / area
        };
        let worst = singular.iter().map(|s| (s.0 / scale).max(scale / s.1)).fold(0.0, f64::max);
        println!("area {area:.0} cm2, within 1.25: {:.3}, within 1.5: {:.3}, worst {worst:.2}", well(1.25), well(1.5));
        assert!(well(1.5) > 0.95 && worst < 3.0, "{:.3} within 1.5, worst {worst:.2}", well(1.5));
    }
}
