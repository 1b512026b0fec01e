//! Layers of a hair mesh from polygons whose parts are layers: by their names, or by their likeness.

use std::collections::BTreeMap;

use glam::Vec3;

use super::polygons::Polygons;
use crate::hair_mesh::{HairMesh, HairMeshLayer};
use crate::mesh_query::MeshQuery;

/// A hair mesh, and in words what it was found to be.
pub(super) type Found = (HairMesh, Vec<String>);

/// Faces of one layer, with the number of each one's bundle where the file says it.
#[derive(Default)]
struct Part {
    name: String,
    faces: Vec<Vec<u32>>,
}

/// `Some` where parts are named `layer_0`, `layer_1`, .. ("Layer 3" and "hair.layer-3" count too).
pub(super) fn by_names(polygons: &Polygons) -> Option<Result<Found, String>> {
    let mut layers: BTreeMap<u32, Part> = BTreeMap::new();
    let mut n_others = 0;
    for face in &polygons.faces {
        let names = [polygons.name(face.object), polygons.name(face.group)];
        match names.into_iter().find_map(|name| Some((layer_number(name)?, name))) {
            Some((number, name)) => {
                let part = layers.entry(number).or_default();
                name.clone_into(&mut part.name);
                part.faces.push(face.corners.clone());
            }
            None => n_others += 1,
        }
    }
    if layers.len() < 2 {
        return None;
    }
    let mut found = vec![format!(
        "{} layers by their names, `{}` to `{}`",
        layers.len(),
        layers.first_key_value().map_or("", |(_, part)| &part.name),
        layers.last_key_value().map_or("", |(_, part)| &part.name),
    )];
    if n_others > 0 {
        found.push(format!("{n_others} faces are in no part that is named like a layer: left out"));
    }
    Some(stacked(&polygons.positions, &layers.into_values().collect::<Vec<_>>(), found))
}

/// `Some` where the file has several parts that have the same polygons: each is a layer.
pub(super) fn by_groups(polygons: &Polygons, head: Option<&MeshQuery>) -> Option<Result<Found, String>> {
    let mut parts: Vec<Part> = Vec::new();
    let mut part_of = std::collections::HashMap::new();
    for face in &polygons.faces {
        let at = *part_of.entry((face.object, face.group)).or_insert_with(|| {
            let name = format!("{} {}", polygons.name(face.object), polygons.name(face.group));
            parts.push(Part { name: name.trim().to_owned(), faces: Vec::new() });
            parts.len() - 1
        });
        parts[at].faces.push(face.corners.clone());
    }
    let counts = |part: &Part| part.faces.iter().map(Vec::len).collect::<Vec<_>>();
    let (first, rest) = parts.split_first()?;
    if rest.is_empty() || rest.iter().any(|part| counts(part) != counts(first)) {
        return None;
    }
    let mut found = vec![format!("{} groups of {} alike faces: each is a layer", parts.len(), parts[0].faces.len())];
    if let Some(head) = head {
        let distance = |part: &Part| -> f32 {
            let vertices: Vec<u32> = part.faces.iter().flatten().copied().collect();
            let far = vertices.iter().map(|&v| head.closest(polygons.positions[v as usize]).distance);
            far.sum::<f32>() / vertices.len().max(1) as f32
        };
        if distance(&parts[parts.len() - 1]) < distance(&parts[0]) {
            parts.reverse();
            found.push("the last group is the nearest to the scalp: taken as the root layer".to_owned());
        }
    }
    Some(stacked(&polygons.positions, &parts, found))
}

/// The number in a name like `layer_3`.
fn layer_number(name: &str) -> Option<u32> {
    let name = name.to_lowercase();
    let after = &name[name.rfind("layer")? + "layer".len()..];
    let digits = after.trim_start_matches(['_', '-', '.', ' ']);
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

/// Put layers on each other, face on face.
fn stacked(positions: &[Vec3], parts: &[Part], mut found: Vec<String>) -> Result<Found, String> {
    let mut layers: Vec<HairMeshLayer> = Vec::new();
    let n_bundles = parts[0].faces.len();
    // The file's vertices of each bundle's face, in the layer before.
    let mut below: Vec<Option<Vec<u32>>> = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        let faces: Vec<Option<Vec<u32>>> = if k == 0 {
            part.faces.iter().cloned().map(Some).collect()
        } else {
            on_faces_below(positions, part, &parts[k - 1], &below, &mut found)?
        };
        let mut used: Vec<u32> = faces.iter().flatten().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let local = |v: u32| used.partition_point(|&u| u < v) as u32;
        layers.push(HairMeshLayer {
            positions: used.iter().map(|&v| positions[v as usize]).collect(),
            faces: faces.iter().map(|face| Some(face.as_ref()?.iter().map(|&v| local(v)).collect())).collect(),
            pinned: Vec::new(),
        });
        below = faces;
    }
    let mesh = HairMesh { layers };
    let (mesh, n_split) = mesh.with_one_below_each().map_err(|error| error.to_string())?;
    if n_split > 0 {
        found.push(format!("{n_split} vertices stood on several of the layer below: separated"));
    }
    found.push(format!("{n_bundles} bundles, {} vertices", mesh.n_vertices()));
    Ok((mesh, found))
}

/// Which face of `part` belongs to which bundle, corner by corner.
fn on_faces_below(
    positions: &[Vec3],
    part: &Part,
    part_below: &Part,
    below: &[Option<Vec<u32>>],
    found: &mut Vec<String>,
) -> Result<Vec<Option<Vec<u32>>>, String> {
    let standing: Vec<usize> = (0..below.len()).filter(|&bundle| below[bundle].is_some()).collect();
    let (n, n_below) = (part.faces.len(), standing.len());
    if n > n_below {
        return Err(format!(
            "`{}` has {n} faces and `{}` below it only {n_below}: every face must stand on one",
            part.name, part_below.name
        ));
    }
    let n_corners = |bundle: usize| below[bundle].as_ref().map_or(0, Vec::len);
    let mut faces = vec![None; below.len()];
    if n == n_below && standing.iter().zip(&part.faces).all(|(&bundle, face)| n_corners(bundle) == face.len()) {
        for (&bundle, face) in standing.iter().zip(&part.faces) {
            faces[bundle] = Some(face.clone());
        }
        return Ok(faces);
    }
    found.push(format!("`{}` has other faces than `{}`: each stands on the nearest", part.name, part_below.name));
    let middle = |face: &[u32]| face.iter().map(|&v| positions[v as usize]).sum::<Vec3>() / face.len() as f32;
    let mut pairs: Vec<(f32, usize, usize)> = Vec::new();
    for (face_idx, face) in part.faces.iter().enumerate() {
        for &bundle in standing.iter().filter(|&&bundle| n_corners(bundle) == face.len()) {
            let there = below[bundle].as_deref().map(middle).unwrap_or_default();
            pairs.push((middle(face).distance(there), face_idx, bundle));
        }
    }
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut is_placed = vec![false; n];
    for (_, face_idx, bundle) in pairs {
        if is_placed[face_idx] || faces[bundle].is_some() {
            continue;
        }
        is_placed[face_idx] = true;
        let (face, there) = (&part.faces[face_idx], below[bundle].as_deref().unwrap_or_default());
        // The turn that moves its corners least.
        let at = |v: u32| positions[v as usize];
        let far = |turn: usize| -> f32 {
            (0..face.len()).map(|i| at(face[(i + turn) % face.len()]).distance(at(there[i]))).sum()
        };
        let turn = (0..face.len()).min_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(0);
        faces[bundle] = Some((0..face.len()).map(|i| face[(i + turn) % face.len()]).collect());
    }
    match is_placed.iter().position(|placed| !placed) {
        Some(left) => Err(format!(
            "face {left} of `{}` has {} corners, and no face like that is left in `{}` to stand on",
            part.name,
            part.faces[left].len(),
            part_below.name
        )),
        None => Ok(faces),
    }
}
