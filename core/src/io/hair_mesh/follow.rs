//! A hair mesh from a plain surface: root faces are those that lie on the scalp, and layers are the rings of
//! quads that rise from their border.
//!
//! The surface need not be closed: where a tube of quads stands open on the scalp, its rim is the root face;
//! what closes it above, a cap or a point, ends it. Vertices between the ring's are placed by mean value
//! coordinates in the ring, as they lie at the root.

use std::collections::{HashMap, HashSet};

use glam::Vec3;

use super::layers::Found;
use super::polygons::Polygons;
use crate::hair_mesh::{HairMesh, HairMeshLayer};
use crate::mean_value::mean_value_weights;
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;

/// A vertex this near to the head lies on it, in centimetres; a face is turned along it from this cosine on.
const LIES_ON: f32 = 0.6;
const ALONG: f32 = 0.6;
/// A point ends in a face this much of the way to it.
const INTO_POINT: f32 = 0.97;
/// More rings than this are no hair.
const MOST_RINGS: usize = 1000;

/// Root faces that hold together, with the cycle of vertices around them.
struct Root {
    faces: Vec<Vec<u32>>,
    ring: Vec<u32>,
}

type FacesOf = HashMap<[u32; 2], Vec<usize>>;

pub(super) fn follow(polygons: &Polygons, head: &TriMesh, query: &MeshQuery) -> Result<Found, String> {
    let mut faces_of: FacesOf = HashMap::new();
    for (face_idx, face) in polygons.faces.iter().enumerate() {
        for [a, b] in edges(&face.corners) {
            faces_of.entry(unordered(a, b)).or_default().push(face_idx);
        }
    }
    let surface: Vec<_> = polygons.positions.iter().map(|&p| query.closest(p)).collect();
    let outward = |v: u32| {
        let [a, b, c] = head.corners(surface[v as usize].triangle_idx as usize);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let lies_on = |v: &u32| surface[*v as usize].distance < LIES_ON;
    let is_root = |corners: &[u32]| {
        let normal = area(&polygons.positions, corners).normalize_or_zero();
        corners.iter().all(lies_on) && corners.iter().all(|&v| normal.dot(outward(v)).abs() > ALONG)
    };
    let root_faces: Vec<usize> = (0..polygons.faces.len()).filter(|&f| is_root(&polygons.faces[f].corners)).collect();
    let mut found = Vec::new();
    let roots = if root_faces.is_empty() {
        let rims = open_rims(polygons, &faces_of, &lies_on);
        if rims.is_empty() {
            return Err(format!(
                "no face lies on the scalp and no open edge ends on it (within {LIES_ON} cm): put the hair where it \
                 grows, or name its parts layer_0, layer_1, .."
            ));
        }
        found.push(format!("{} open tubes stand on the scalp: each rim is a root face", rims.len()));
        rims
    } else {
        let (roots, n_odd) = patches(polygons, &root_faces);
        found.push(format!("{} faces lie on the scalp, in {} places", root_faces.len(), roots.len()));
        if n_odd > 0 {
            found.push(format!("{n_odd} places on the scalp are no discs: left out"));
        }
        roots
    };
    let on_root: HashSet<usize> = root_faces.into_iter().collect();
    let mut mesh = HairMesh::default();
    let mut heights = Vec::new();
    let mut n_flat = 0;
    for mut root in roots {
        let middle = root.ring[0];
        let sum: Vec3 = root.faces.iter().map(|face| area(&polygons.positions, face)).sum();
        if sum.dot(outward(middle)) < 0.0 {
            root.faces.iter_mut().for_each(|face| face.reverse());
        }
        let rings = rise(polygons, &faces_of, &on_root, &root.ring);
        if rings.len() < 2 {
            n_flat += 1;
            continue;
        }
        heights.push(rings.len() - 1);
        put(&mut mesh, &polygons.positions, &root, &rings);
    }
    if heights.is_empty() {
        return Err("nothing rises from the faces on the scalp: no closed ring of quads stands around them".to_owned());
    }
    if n_flat > 0 {
        found.push(format!("nothing rises from {n_flat} places on the scalp: left out"));
    }
    let (low, high) = heights.iter().fold((usize::MAX, 0), |(lo, hi), &h| (lo.min(h), hi.max(h)));
    let height = if low == high { format!("{low}") } else { format!("{low} to {high}") };
    found.push(format!("followed quads up from {} places: {height} layers above the root", heights.len()));
    let n_bundles = mesh.n_bundles();
    for layer in &mut mesh.layers {
        layer.faces.resize(n_bundles, None);
    }
    mesh.check().map_err(|error| error.to_string())?;
    found.push(format!("{n_bundles} bundles, {} vertices", mesh.n_vertices()));
    Ok((mesh, found))
}

fn edges(face: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]])
}

fn unordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn area(positions: &[Vec3], corners: &[u32]) -> Vec3 {
    let p = |i: usize| positions[corners[i] as usize];
    (1..corners.len().saturating_sub(1)).map(|i| 0.5 * (p(i) - p(0)).cross(p(i + 1) - p(0))).sum()
}

/// Root faces in groups that share vertices, each with its border; and how many groups are no discs.
fn patches(polygons: &Polygons, root_faces: &[usize]) -> (Vec<Root>, usize) {
    let mut faces_at: HashMap<u32, Vec<usize>> = HashMap::new();
    for &face in root_faces {
        for &v in &polygons.faces[face].corners {
            faces_at.entry(v).or_default().push(face);
        }
    }
    let mut seen = HashSet::new();
    let (mut roots, mut n_odd) = (Vec::new(), 0);
    for &first in root_faces {
        let (mut open, mut faces) = (vec![first], Vec::new());
        while let Some(face) = open.pop() {
            if seen.insert(face) {
                faces.push(face);
                open.extend(polygons.faces[face].corners.iter().flat_map(|v| &faces_at[v]));
            }
        }
        if faces.is_empty() {
            continue;
        }
        faces.sort_unstable();
        let faces: Vec<Vec<u32>> = faces.into_iter().map(|face| polygons.faces[face].corners.clone()).collect();
        let directed: HashSet<[u32; 2]> = faces.iter().flat_map(|face| edges(face)).collect();
        let border = directed.iter().copied().filter(|[a, b]| !directed.contains(&[*b, *a]));
        match cycles(border).as_mut_slice() {
            [ring] => roots.push(Root { faces, ring: std::mem::take(ring) }),
            _ => n_odd += 1,
        }
    }
    (roots, n_odd)
}

/// The cycles of directed edges, each from its lowest vertex; those that branch are left out.
fn cycles(border: impl Iterator<Item = [u32; 2]>) -> Vec<Vec<u32>> {
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    for [a, b] in border {
        next.entry(a).or_default().push(b);
    }
    let mut starts: Vec<u32> = next.keys().copied().collect();
    starts.sort_unstable();
    let mut seen = HashSet::new();
    let mut cycles = Vec::new();
    for start in starts {
        let mut cycle = Vec::new();
        let mut at = start;
        while seen.insert(at) {
            cycle.push(at);
            match next.get(&at).map(Vec::as_slice) {
                Some(&[only]) => at = only,
                Some(_) | None => break,
            }
        }
        if at == start && cycle.len() >= 3 {
            cycles.push(cycle);
        }
    }
    cycles
}

/// Rims of an open surface that lie on the scalp, each as one polygon.
fn open_rims(polygons: &Polygons, faces_of: &FacesOf, lies_on: &dyn Fn(&u32) -> bool) -> Vec<Root> {
    let rim = polygons
        .faces
        .iter()
        .flat_map(|face| edges(&face.corners))
        .filter(|[a, b]| faces_of[&unordered(*a, *b)].len() == 1 && lies_on(a) && lies_on(b));
    // A face's own direction runs the other way around the rim.
    cycles(rim.map(|[a, b]| [b, a])).into_iter().map(|ring| Root { faces: vec![ring.clone()], ring }).collect()
}

/// The rings of places above a root's border, with the border itself.
fn rise(polygons: &Polygons, faces_of: &FacesOf, on_root: &HashSet<usize>, border: &[u32]) -> Vec<Vec<Vec3>> {
    let places = |ring: &[u32]| ring.iter().map(|&v| polygons.positions[v as usize]).collect::<Vec<Vec3>>();
    let mut rings = vec![places(border)];
    let mut visited = on_root.clone();
    let mut used: HashSet<u32> = border.iter().copied().collect();
    let mut ring = border.to_vec();
    while rings.len() <= MOST_RINGS {
        let n = ring.len();
        let above = |i: usize| {
            let of_edge = faces_of.get(&unordered(ring[i], ring[(i + 1) % n]))?;
            let mut open = of_edge.iter().copied().filter(|face| !visited.contains(face));
            open.next().filter(|_| open.next().is_none())
        };
        let Some(faces) = (0..n).map(above).collect::<Option<Vec<usize>>>() else { break };
        if faces.iter().collect::<HashSet<_>>().len() < n {
            break;
        }
        // The corners beside each edge's ends, in the face above it.
        let beside = |i: usize| -> Option<[u32; 2]> {
            let (face, a, b) = (&polygons.faces[faces[i]].corners, ring[i], ring[(i + 1) % n]);
            let other = |v: u32, not: u32| {
                let at = face.iter().position(|&u| u == v)?;
                let around = [face[(at + 1) % face.len()], face[(at + face.len() - 1) % face.len()]];
                around.into_iter().find(|&u| u != not)
            };
            Some([other(a, b)?, other(b, a)?])
        };
        let Some(beside) = (0..n).map(beside).collect::<Option<Vec<[u32; 2]>>>() else { break };
        let all_have = |n_corners: usize| faces.iter().all(|&f| polygons.faces[f].corners.len() == n_corners);
        let apex = beside[0][0];
        if all_have(3) && beside.iter().flatten().all(|&v| v == apex) {
            let point = polygons.positions[apex as usize];
            rings.push(places(&ring).into_iter().map(|p| p.lerp(point, INTO_POINT)).collect());
            break;
        }
        let agree = (0..n).all(|i| beside[i][1] == beside[(i + 1) % n][0]);
        let next: Vec<u32> = beside.iter().map(|ends| ends[0]).collect();
        if !all_have(4) || !agree || !next.iter().all(|&v| used.insert(v)) {
            break;
        }
        visited.extend(faces);
        rings.push(places(&next));
        ring = next;
    }
    rings
}

/// Append a root and its rings: vertices of the ring first, then those between.
fn put(mesh: &mut HairMesh, positions: &[Vec3], root: &Root, rings: &[Vec<Vec3>]) {
    let mut inner: Vec<u32> = root.faces.iter().flatten().copied().filter(|v| !root.ring.contains(v)).collect();
    inner.sort_unstable();
    inner.dedup();
    let weights: Vec<Vec<f32>> = inner.iter().map(|&v| mean_value_weights(&rings[0], positions[v as usize])).collect();
    let local = |v: u32| {
        root.ring.iter().position(|&u| u == v).unwrap_or_else(|| root.ring.len() + inner.partition_point(|&u| u < v))
    };
    let n_bundles = mesh.n_bundles();
    for (k, ring) in rings.iter().enumerate() {
        if mesh.layers.len() == k {
            mesh.layers.push(HairMeshLayer::default());
        }
        let layer = &mut mesh.layers[k];
        layer.faces.resize(n_bundles, None);
        let first = layer.positions.len();
        layer.positions.extend_from_slice(ring);
        for (i, weights) in weights.iter().enumerate() {
            let place = if k == 0 {
                positions[inner[i] as usize]
            } else {
                ring.iter().zip(weights).map(|(p, weight)| *p * *weight).sum()
            };
            layer.positions.push(place);
        }
        let face = |face: &Vec<u32>| Some(face.iter().map(|&v| (first + local(v)) as u32).collect());
        layer.faces.extend(root.faces.iter().map(face));
    }
}
