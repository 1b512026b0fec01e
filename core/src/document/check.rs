//! Whether a groom's arrays fit each other: asked before saving and after opening, so that everything
//! behind may index without asking again.

use glam::Vec3;

use crate::groom::{Groom, Source};
use crate::mesh::TriMesh;
use crate::strands::Strands;

/// The first problem, in words, or nothing.
pub(super) fn check(groom: &Groom) -> Result<(), String> {
    if let Some(head) = &groom.head {
        check_mesh(&head.mesh).map_err(|problem| format!("head `{}`: {problem}", head.name))?;
    }
    if let Some(panorama) = &groom.panorama {
        panorama.check().map_err(|problem| format!("its picture of the environment: {problem}"))?;
    }
    for layer in &groom.layers {
        let checked = match &layer.source {
            Source::HairMesh(hair_mesh) => hair_mesh.check().map_err(|error| error.to_string()),
            Source::Guides(strands) | Source::Strands(strands) => check_strands(strands),
        };
        checked.map_err(|problem| format!("layer `{}`: {problem}", layer.name))?;
        layer.sculpt.check().map_err(|problem| format!("layer `{}`: {problem}", layer.name))?;
        if let Some((kind, _)) = layer.maps.iter().find(|(_, map)| !map.has_texels()) {
            return Err(format!("layer `{}`: its map {kind} has no texels", layer.name));
        }
    }
    Ok(())
}

fn check_mesh(mesh: &TriMesh) -> Result<(), String> {
    let n = mesh.positions.len();
    check_finite(&mesh.positions)?;
    for (name, len) in [("normals", mesh.normals.len()), ("texture coordinates", mesh.uvs.len())] {
        if len != 0 && len != n {
            return Err(format!("{len} {name} for {n} vertices"));
        }
    }
    if let Some(bad) = mesh.triangles.iter().position(|triangle| triangle.iter().any(|&v| v as usize >= n)) {
        return Err(format!("triangle {bad} names a vertex beyond the {n} there are"));
    }
    for group in &mesh.groups {
        if group.triangles.iter().any(|&t| t as usize >= mesh.triangles.len()) {
            return Err(format!("group `{}` names a triangle that does not exist", group.name));
        }
    }
    Ok(())
}

fn check_strands(strands: &Strands) -> Result<(), String> {
    let n_points = strands.points.len();
    let offsets = &strands.offsets;
    if offsets.first() != Some(&0) || offsets.last().copied() != u32::try_from(n_points).ok() || !offsets.is_sorted() {
        return Err(format!("strand offsets that do not divide {n_points} points"));
    }
    if let Some(short) = offsets.windows(2).position(|pair| pair[1] - pair[0] < 2) {
        return Err(format!("strand {short} has fewer than two points"));
    }
    let n_strands = offsets.len() - 1;
    for (name, len, expected) in [
        ("ids", strands.ids.len(), n_strands),
        ("root texture coordinates", strands.root_uvs.len(), n_strands),
        ("radii", strands.radii_um.len(), n_points),
        ("colours", strands.colours.len(), n_points),
        ("opacities", strands.opacities.len(), n_points),
    ] {
        if len != 0 && len != expected {
            return Err(format!("{len} {name} where {expected} are due"));
        }
    }
    check_finite(&strands.points)
}

fn check_finite(points: &[Vec3]) -> Result<(), String> {
    match points.iter().position(|p| !p.is_finite()) {
        Some(bad) => Err(format!("point {bad} is at no place: {}", points[bad])),
        None => Ok(()),
    }
}
