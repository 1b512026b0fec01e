//! Colliders: shapes that hair keeps out of, in a list, and every number of the one that is selected.

use egui::{Ui, vec2};
use glam::{Affine3A, Vec3};
use lorelei_core::collider::{Attachment, Collider, MOST_COLLIDERS};
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;

use super::widgets::{self, Change, form_row};
use crate::window::desk::{Desk, Selection, merge_of};
use crate::window::state_report::mark;

const ON_HELP: &str = "Whether hair feels it";

/// The section of the movement panel.
pub fn section(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "Colliders");
    ui.horizontal(|ui| {
        let sphere = ui.button("+ Sphere").on_hover_text("A ball that hair keeps out of, beside the head");
        mark(ui.ctx(), || "add sphere".to_owned(), sphere.rect);
        if sphere.clicked() {
            add(desk, "Sphere");
        }
        let capsule =
            ui.button("+ Capsule").on_hover_text("Two balls and all between them: an arm, a band, a shoulder");
        mark(ui.ctx(), || "add capsule".to_owned(), capsule.rect);
        if capsule.clicked() {
            add(desk, "Capsule");
        }
    });
    for collider_idx in 0..desk.document.groom.simulation.colliders.len() {
        ui.push_id(("collider", collider_idx), |ui| row(ui, desk, collider_idx));
    }
    if let Selection::Collider(collider_idx) = desk.selection {
        one(ui, desk, collider_idx);
    }
}

fn row(ui: &mut Ui, desk: &mut Desk, collider_idx: usize) {
    let mut colliders = desk.document.groom.simulation.colliders.clone();
    let name = colliders[collider_idx].name.clone();
    let mut change = None;
    ui.horizontal(|ui| {
        if widgets::switch(ui, &mut colliders[collider_idx].on).on_hover_text(ON_HELP).changed() {
            change = Some(format!("Switch {name}"));
        }
        let is_selected = desk.selection == Selection::Collider(collider_idx);
        let label = ui.selectable_label(is_selected, &name);
        if label.on_hover_text("Click to select it: its handles are in the viewport").clicked() {
            desk.selection = if is_selected { Selection::Head } else { Selection::Collider(collider_idx) };
        }
        let side = egui::Layout::right_to_left(egui::Align::Center);
        ui.with_layout(side, |ui| {
            if ui.add(egui::Button::new("\u{d7}").min_size(vec2(20.0, 18.0))).on_hover_text("Remove it").clicked() {
                change = Some(format!("Remove {name}"));
                colliders.remove(collider_idx);
            }
        });
    });
    if let Some(label) = change {
        desk.document.edit(&label, Edit::SetColliders(colliders), Merge::New);
        desk.clamp_selection();
    }
}

/// A new one at the model's left, a little in front: where it is seen at once and no hair rests.
fn add(desk: &mut Desk, kind: &str) {
    let mut colliders = desk.document.groom.simulation.colliders.clone();
    if colliders.len() >= MOST_COLLIDERS {
        let why = format!("The solver looks at {MOST_COLLIDERS} of them");
        desk.notices.error("No more colliders", why);
        return;
    }
    let half = 0.5 * (desk.bounds.1 - desk.bounds.0);
    // To the left and to the right by turns, then lower: handles that lie on each other cannot be told apart.
    let n = colliders.len();
    let side = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let at = desk.centre() + Vec3::new(side * (half.x + 5.0), -10.0 * (n / 2) as f32, 0.4 * half.z);
    let n_same =
        colliders.iter().filter(|collider| collider.name.to_lowercase().starts_with(&kind.to_lowercase())).count();
    let name = format!("{kind} {}", n_same + 1);
    let collider = if kind == "Capsule" {
        Collider::capsule(&name, [at - 6.0 * Vec3::Y, at + 6.0 * Vec3::Y], [3.0; 2])
    } else {
        Collider::sphere(&name, at, 4.0)
    };
    colliders.push(collider);
    let collider_idx = colliders.len() - 1;
    desk.document.edit(&format!("Add {name}"), Edit::SetColliders(colliders), Merge::New);
    desk.selection = Selection::Collider(collider_idx);
}

/// Every number of one collider.
pub fn one(ui: &mut Ui, desk: &mut Desk, collider_idx: usize) {
    let world_from_head = desk.report.world_from_head;
    let mut colliders = desk.document.groom.simulation.colliders.clone();
    let Some(collider) = colliders.get_mut(collider_idx) else { return };
    if let Some(change) = form(ui, collider, &world_from_head) {
        desk.document.edit(&change.label, Edit::SetColliders(colliders), merge_of(change.drag));
    }
}

fn form(ui: &mut Ui, collider: &mut Collider, world_from_head: &Affine3A) -> Option<Change> {
    let mut change = None;
    let mut row = |ui: &mut Ui, name: &str, help: &str, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
        let (_, response) = form_row(ui, name, help, false, control);
        let label = format!("Collider {}", name.to_lowercase());
        if let Some(one) = Change::from_response(&label, &response.on_hover_text(help)) {
            change = Some(one);
        }
    };
    row(ui, "Name", "Click and type", &mut |ui| {
        ui.add(egui::TextEdit::singleline(&mut collider.name).desired_width(f32::INFINITY))
    });
    row(ui, "On", ON_HELP, &mut |ui| widgets::switch(ui, &mut collider.on));
    let attached = collider.attached;
    row(ui, "Moves with", "What it is attached to; it stays where it is now", &mut |ui| {
        let mut chosen = attached;
        let list = egui::ComboBox::from_id_salt("attached").width(ui.available_width());
        let mut response = list
            .selected_text(attached.info().label)
            .show_ui(ui, |ui| {
                for choice in Attachment::ALL {
                    ui.selectable_value(&mut chosen, *choice, choice.info().label).on_hover_text(choice.info().help);
                }
            })
            .response;
        if chosen != attached {
            collider.attach(chosen, world_from_head);
            response.mark_changed();
        }
        response
    });
    row(
        ui,
        "Resting hair stays",
        "Hair that rests inside is left there, as it is on the head; off: it is pushed out",
        &mut |ui| widgets::switch(ui, &mut collider.keeps_rest),
    );
    let is_sphere = collider.is_sphere();
    let mut is_capsule = !is_sphere;
    row(ui, "Capsule", "Two balls and all between them; off: one ball", &mut |ui| widgets::switch(ui, &mut is_capsule));
    if is_capsule && is_sphere {
        collider.ends[1] += 2.0 * (collider.radii[0] + 1.0) * Vec3::Y;
    } else if !is_capsule && !is_sphere {
        let middle = 0.5 * (collider.ends[0] + collider.ends[1]);
        collider.ends = [middle; 2];
        collider.radii = [collider.radii[0]; 2];
    }
    const RADIUS: [&str; 2] = ["Radius", "Radius, end 2"];
    const PLACE: [[&str; 3]; 2] = [["X", "Y", "Z"], ["X, end 2", "Y, end 2", "Z, end 2"]];
    for end in 0..if is_capsule { 2 } else { 1 } {
        let mut radius = collider.radii[end];
        row(ui, RADIUS[end], "Of the ball", &mut |ui| widgets::number(ui, &mut radius, (0.05, 60.0), "cm"));
        if radius != collider.radii[end] {
            collider.set_radius(end, radius);
        }
        let mut place = collider.ends[end];
        for (axis, name) in PLACE[end].into_iter().enumerate() {
            row(ui, name, "Middle of the ball", &mut |ui| {
                let control = egui::DragValue::new(&mut place[axis]).speed(0.05).max_decimals(2).suffix(" cm");
                ui.add_sized(vec2(ui.available_width(), crate::window::theme::ROW), control.update_while_editing(false))
            });
        }
        if place != collider.ends[end] {
            collider.move_end(end, place - collider.ends[end]);
        }
    }
    change
}
