//! Correcting a guess: what was imported as one space becomes another, without reading the file again.

use std::sync::Arc;

use glam::Affine3A;

use super::space::{Space, transform_points};
use crate::edit::Edit;
use crate::groom::{Groom, Head, Layer, Source};
use crate::strands::Strands;

/// The edit after which everything that was imported as `from` lies as if it had been imported as `to`:
/// hair and head of one import stay together.
pub fn reread(groom: &Groom, from: Space, to: Space) -> Edit {
    let correction = from.correction(to);
    let mut edits = Vec::new();
    if let Some(head) = groom.head.as_ref().filter(|head| head.read_as == Some(from)) {
        let mut mesh = (*head.mesh).clone();
        transform_points(correction, &mut mesh.positions);
        mesh.compute_normals();
        edits.push(Edit::SetHead(Some(Head { mesh: Arc::new(mesh), read_as: Some(to), ..head.clone() })));
    }
    for (layer_idx, layer) in groom.layers.iter().enumerate().filter(|(_, layer)| layer.read_as == Some(from)) {
        edits.push(Edit::SetLayer { layer_idx, layer: Box::new(moved(layer, correction, from, to)) });
    }
    Edit::Batch(edits)
}

/// Radii that hair, or strands that stand for several hairs, can have, micrometres.
const PLAUSIBLE_RADIUS_UM: std::ops::RangeInclusive<f32> = 2.0..=2000.0;

fn moved(layer: &Layer, correction: Affine3A, from: Space, to: Space) -> Layer {
    let mut layer = Layer { read_as: Some(to), ..layer.clone() };
    let move_strands = |strands: &mut Arc<Strands>, radius_um: &mut f32| {
        let strands = Arc::make_mut(strands);
        transform_points(correction, &mut strands.points);
        // Widths from the file were lengths too, unless they were only proportions.
        let scale = to.unit.in_cm() / from.unit.in_cm();
        if !strands.radii_um.is_empty() && PLAUSIBLE_RADIUS_UM.contains(&(*radius_um * scale)) {
            strands.radii_um.iter_mut().for_each(|radius| *radius *= scale);
            *radius_um *= scale;
        }
    };
    match &mut layer.source {
        Source::Guides(strands) | Source::Strands(strands) => move_strands(strands, &mut layer.radius_um),
        Source::HairMesh(hair_mesh) => {
            for layer in &mut Arc::make_mut(hair_mesh).layers {
                transform_points(correction, &mut layer.positions);
            }
        }
    }
    layer
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::space::{Axis, Unit};
    use super::*;
    use crate::mesh::TriMesh;

    #[test]
    fn a_corrected_import_lies_as_if_it_had_been_read_so_and_undo_brings_it_back() {
        let file_points = [Vec3::new(0.1, 0.2, 1.6), Vec3::new(0.1, 0.25, 1.5)];
        let (wrong, right) = (Space::new(Unit::Centimetre, Axis::Y), Space::new(Unit::Metre, Axis::Z));
        let read_as = |space: Space| {
            let place = |p: Vec3| space.world_from_file().transform_point3(p);
            let mut strands = Strands::default();
            strands.push(&file_points.map(place));
            let mesh = TriMesh { positions: file_points.map(place).to_vec(), ..TriMesh::default() };
            let layer = Layer { read_as: Some(space), ..Layer::from_strands("hair", strands) };
            let head = Head { read_as: Some(space), ..Head::new("head", mesh) };
            Groom { head: Some(head), layers: vec![layer, Layer::default()], ..Groom::default() }
        };
        let before = read_as(wrong);
        let mut groom = before.clone();
        let undo = groom.apply(reread(&groom, wrong, right)).expect("the edit fits");
        let points = |groom: &Groom| match &groom.layers[0].source {
            Source::Strands(strands) => strands.points.clone(),
            Source::Guides(_) | Source::HairMesh(_) => Vec::new(),
        };
        for (p, q) in points(&groom).iter().zip(points(&read_as(right))) {
            assert!(p.distance(q) < 1e-4, "{p} {q}");
        }
        let head = |groom: &Groom| groom.head.clone().expect("a head").mesh.positions.clone();
        for (p, q) in head(&groom).iter().zip(head(&read_as(right))) {
            assert!(p.distance(q) < 1e-4, "{p} {q}");
        }
        assert_eq!(groom.layers[0].read_as, Some(right));
        groom.apply(undo).expect("an inverse fits");
        assert_eq!(groom, before);
    }
}
