//! Colliders in the viewport: their outlines, and what moves and resizes them, also while hair moves.
//!
//! A dot in the middle selects and moves; a selected one has a dot at each end that moves it and a square on each rim
//! that sets its radius. All move in the plane of the picture.

use egui::{Color32, Pos2, Stroke, Ui};
use glam::Vec3;
use lorelei_core::collider::Collider;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;

use super::desk::{Desk, Selection};
use super::handles::{GRIP, Grip, GripShape, picture_plane};
use super::projection::Projection;
use super::theme;

/// Sides of a ball's outline.
const N_SIDES: u32 = 40;
/// Names the drags of colliders among all drags.
const DRAGS: u64 = 0xC011_1DE5 << 16;

/// What a handle moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Whole,
    End(usize),
    Rim(usize),
}

/// The handles of every collider; true while one is dragged.
pub fn colliders(ui: &mut Ui, desk: &mut Desk, projection: Projection) -> bool {
    let world_from_head = desk.report.world_from_head;
    let (right, up) = picture_plane(&desk.camera);
    let mut is_dragging = false;
    for collider_idx in 0..desk.document.groom.simulation.colliders.len() {
        let collider = desk.document.groom.simulation.colliders[collider_idx].clone();
        let world_from_ends = collider.world_from_ends(&world_from_head);
        let ends = collider.ends.map(|end| world_from_ends.transform_point3(end));
        if !collider.ends.iter().all(|end| end.is_finite()) {
            continue;
        }
        let is_selected = desk.selection == Selection::Collider(collider_idx);
        let outline = outline(projection, ends, collider.radii, (right, up));
        let colour = if is_selected { theme::ACCENT } else { GRIP };
        draw(ui, &outline, colour, is_selected, collider.on);
        let mut parts = vec![(Part::Whole, 0.5 * (ends[0] + ends[1]))];
        if is_selected {
            let n_ends = if collider.is_sphere() { 1 } else { 2 };
            for (end, &at) in ends.iter().enumerate().take(n_ends) {
                if n_ends == 2 {
                    parts.push((Part::End(end), at));
                }
                parts.push((Part::Rim(end), at + collider.radii[end] * right));
            }
        }
        for (part_idx, (part, at_world)) in parts.into_iter().enumerate() {
            let id = ui.scope_id().with(("collider", collider_idx, part_idx));
            let shape = match part {
                Part::Whole => GripShape::Dot,
                Part::End(_) => GripShape::Ring,
                Part::Rim(_) => GripShape::Square,
            };
            let label = (part == Part::Whole).then(|| format!("{}  {:.1} cm", collider.name, collider.radii[0]));
            let grip = Grip { place: at_world, id, shape, colour: GRIP, is_selected, is_on: collider.on, label };
            let name = || format!("collider {collider_idx} {part:?}");
            let Some(gripped) = grip.ui(ui, &desk.camera, projection, name) else { continue };
            if gripped.is_taken {
                desk.selection = Selection::Collider(collider_idx);
            }
            is_dragging |= gripped.is_dragged;
            if let Some(by) = gripped.by {
                let by = world_from_ends.inverse().transform_vector3(by);
                let along = world_from_ends.inverse().transform_vector3(right);
                let mut colliders = desk.document.groom.simulation.colliders.clone();
                let what = move_part(&mut colliders[collider_idx], part, by, along);
                let label = format!("{what} {}", collider.name);
                let id = DRAGS + 8 * collider_idx as u64 + part_idx as u64;
                desk.document.edit(&label, Edit::SetColliders(colliders), Merge::Drag(id));
            }
        }
    }
    is_dragging
}

/// Move a part by a way in the collider's own space, in which `along` goes to the right in the picture; says what was
/// done.
fn move_part(collider: &mut Collider, part: Part, by: Vec3, along: Vec3) -> &'static str {
    match part {
        Part::Whole => {
            collider.shift(by);
            "Move"
        }
        Part::End(end) => {
            collider.move_end(end, by);
            "Move"
        }
        Part::Rim(end) => {
            collider.set_radius(end, collider.radii[end] + by.dot(along));
            "Resize"
        }
    }
}

/// The outline of two balls and what is between them, as seen: the hull of two circles.
pub(super) fn outline(
    projection: Projection,
    ends: [Vec3; 2],
    radii: [f32; 2],
    (right, up): (Vec3, Vec3),
) -> Vec<Pos2> {
    let mut points = Vec::new();
    for (end, radius) in ends.into_iter().zip(radii) {
        for i in 0..N_SIDES {
            let (sin, cos) = (i as f32 / N_SIDES as f32 * std::f32::consts::TAU).sin_cos();
            // A ball that is cut by the plane of the eye has no outline.
            let Some(at) = projection.point(end + radius * (cos * right + sin * up)) else { return Vec::new() };
            points.push(at);
        }
    }
    hull(points)
}

/// The convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<Pos2>) -> Vec<Pos2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let turns = |chain: &[Pos2], p: Pos2| -> bool {
        let [.., a, b] = chain else { return true };
        (*b - *a).x * (p - *a).y - (*b - *a).y * (p - *a).x > 0.0
    };
    let half = |points: &mut dyn Iterator<Item = Pos2>| {
        let mut chain: Vec<Pos2> = Vec::new();
        for p in points {
            while !turns(&chain, p) {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

/// An outline filled with a breath of its colour.
pub(super) fn draw(ui: &Ui, outline: &[Pos2], colour: Color32, is_selected: bool, is_on: bool) {
    if outline.len() < 3 {
        return;
    }
    let strength = if is_on { 1.0 } else { 0.35 };
    let fill = colour.gamma_multiply(strength * if is_selected { 0.14 } else { 0.06 });
    let stroke = Stroke::new(if is_selected { 1.8 } else { 1.0 }, colour.gamma_multiply(0.8 * strength));
    ui.painter().add(egui::Shape::convex_polygon(outline.to_vec(), fill, stroke));
}

#[cfg(test)]
mod tests {
    use egui::{Rect, pos2, vec2};
    use lorelei_core::camera::Camera;

    use super::*;

    #[test]
    fn the_outline_holds_both_balls() {
        let camera = Camera { target: Vec3::ZERO, ..Camera::default() };
        let projection = Projection::new(&camera, Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 600.0)));
        let ends = [Vec3::new(-5.0, 0.0, 0.0), Vec3::new(6.0, 2.0, 1.0)];
        let (right, up) = picture_plane(&camera);
        let outline = outline(projection, ends, [2.0, 3.0], (right, up));
        let is_inside = |p: Pos2| {
            (0..outline.len()).all(|i| {
                let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
                (b - a).x * (p - a).y - (b - a).y * (p - a).x >= -1e-2
            })
        };
        for at in [ends[0], ends[1], 0.5 * (ends[0] + ends[1]), ends[1] + 2.9 * up, ends[0] - 1.9 * right] {
            assert!(is_inside(projection.point(at).unwrap()), "{at}");
        }
        assert!(!is_inside(projection.point(ends[0] - 3.0 * right).unwrap()));
    }

    #[test]
    fn parts_move_what_they_are_of() {
        let mut arm = Collider::capsule("arm", [Vec3::ZERO, Vec3::Y], [2.0, 1.0]);
        move_part(&mut arm, Part::End(1), Vec3::X, Vec3::X);
        assert_eq!(arm.ends, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]);
        move_part(&mut arm, Part::Rim(0), Vec3::new(0.5, 3.0, 0.0), Vec3::X);
        assert_eq!(arm.radii, [2.5, 1.0]);
        move_part(&mut arm, Part::Whole, Vec3::Z, Vec3::X);
        assert_eq!(arm.ends, [Vec3::Z, Vec3::new(1.0, 1.0, 1.0)]);
    }
}
