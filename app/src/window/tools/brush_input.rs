//! How a brush's size and strength are set with the hand on it: `[` `]`, Shift with them,
//! B with a drag, or F and then the pointer.

use egui::{Color32, Key, Pos2, Stroke, Ui};
use glam::Vec3;
use lorelei_core::brush::{Brush, BrushSpace, Falloff};

use super::View;
use crate::window::panels::widgets;

/// What one press of a bracket does to a radius or a strength.
const STEP: f32 = 1.15;

/// Take the keys and drags that set a brush. True while one is being set: the pointer is then no stroke.
pub fn adjust(ui: &Ui, view: &View<'_>, brush: &mut Brush) -> bool {
    if ui.ctx().text_edit_focused() {
        return false;
    }
    ui.input(|input| {
        let by = |key: Key| input.num_presses(key) as i32;
        let n = by(Key::CloseBracket) - by(Key::OpenBracket);
        if n != 0 && input.modifiers.shift {
            brush.strength = (brush.strength * STEP.powi(n)).clamp(0.01, 1.0);
        } else if n != 0 {
            brush.scale_radius(STEP.powi(n));
        }
        let is_setting = input.key_down(Key::B) && !input.modifiers.any();
        if is_setting && view.response.dragged_by(egui::PointerButton::Primary) {
            let delta = input.pointer.delta();
            brush.scale_radius((0.01 * delta.x).exp());
            brush.strength = (brush.strength - 0.003 * delta.y).clamp(0.01, 1.0);
        }
        is_setting
    })
}

/// A radius or strength that follows the pointer after F, as in Blender.
pub struct Setting {
    is_strength: bool,
    before: Brush,
}

impl Setting {
    pub fn new(is_strength: bool, brush: &Brush) -> Self {
        Self { is_strength, before: *brush }
    }
}

/// Follow the pointer with a setting until it is kept or taken back. True while one is being set.
pub fn follow(ui: &Ui, setting: &mut Option<Setting>, brush: &mut Brush) -> bool {
    let Some(following) = setting else { return false };
    let (delta, is_kept, is_taken_back) = ui.input(|input| {
        let is_kept = input.pointer.primary_pressed() || input.key_pressed(Key::Enter);
        let is_taken_back = input.pointer.secondary_pressed() || input.key_pressed(Key::Escape);
        (input.pointer.delta(), is_kept, is_taken_back)
    });
    if following.is_strength {
        brush.strength = (brush.strength + 0.004 * delta.x).clamp(0.01, 1.0);
    } else {
        brush.scale_radius((0.01 * delta.x).exp());
    }
    if is_taken_back {
        *brush = following.before;
    }
    if is_kept || is_taken_back {
        *setting = None;
    }
    true
}

/// The brush's rim around a place, and a thinner ring at half its strength.
pub fn ring(ui: &Ui, view: &View<'_>, brush: &Brush, at: Pos2, place: Option<(Vec3, Vec3)>, colour: Color32) {
    let half = (1..100).map(|i| i as f32 / 100.0).find(|&x| brush.falloff.at(x) <= 0.5).unwrap_or(1.0);
    for (share, alpha) in [(1.0, 0.9), (half, 0.4)] {
        let stroke = Stroke::new(1.3, colour.gamma_multiply(alpha));
        match (brush.space, place) {
            (BrushSpace::Surface, Some((position, normal))) => {
                let (x, y) = normal.any_orthonormal_pair();
                let points: Vec<Pos2> = (0..=48)
                    .filter_map(|i| {
                        let (sin, cos) = (i as f32 / 48.0 * std::f32::consts::TAU).sin_cos();
                        view.projection.point(position + share * brush.radius_cm * (cos * x + sin * y))
                    })
                    .collect();
                ui.painter().add(egui::Shape::line(points, stroke));
            }
            (BrushSpace::Screen, _) => {
                ui.painter().circle_stroke(at, share * brush.radius_points, stroke);
            }
            (BrushSpace::Surface, None) => {
                // Off the surface there is nothing to reach.
                ui.painter().circle_stroke(at, 3.0, stroke);
            }
        }
    }
}

/// The brush's settings, for the tool's panel.
pub fn panel(ui: &mut Ui, brush: &mut Brush) {
    let default = Brush::default();
    match brush.space {
        BrushSpace::Surface => {
            let help = "Around the place under the pointer; [ and ], or B and a drag to the side";
            row(ui, "Radius", help, &mut brush.radius_cm, default.radius_cm, Brush::RADIUS_CM, "cm");
        }
        BrushSpace::Screen => {
            let help = "Around the pointer, at any depth; [ and ], or B and a drag to the side";
            row(ui, "Radius", help, &mut brush.radius_points, default.radius_points, Brush::RADIUS_POINTS, "px");
        }
    }
    let help = "Shift with [ and ], or B and a drag up and down";
    row(ui, "Strength", help, &mut brush.strength, default.strength, (0.01, 1.0), "");
    let choose = |ui: &mut Ui, name: &str, help: &str, text: &str, add: &mut dyn FnMut(&mut Ui)| {
        widgets::form_row(ui, name, help, false, |ui| {
            egui::ComboBox::from_id_salt(name)
                .selected_text(text)
                .width(ui.available_width())
                .show_ui(ui, |ui| add(ui))
                .response
                .on_hover_text(help);
        });
    };
    let text = brush.falloff.label();
    choose(ui, "Falloff", "How the strength falls from the middle to the rim", text, &mut |ui| {
        for falloff in Falloff::ALL {
            ui.selectable_value(&mut brush.falloff, falloff, falloff.label());
        }
    });
    let label = |space: BrushSpace| match space {
        BrushSpace::Surface => "On the surface",
        BrushSpace::Screen => "On the screen",
    };
    let text = label(brush.space);
    choose(ui, "Reach", "A ball around the place under the pointer, or all depths under a circle", text, &mut |ui| {
        for space in [BrushSpace::Surface, BrushSpace::Screen] {
            ui.selectable_value(&mut brush.space, space, label(space));
        }
    });
    for (value, name, help) in [
        (&mut brush.is_symmetric, "Mirror across X", "The same on the other side of the face"),
        (&mut brush.has_back_faces, "Through", "Reach what faces away, too"),
        (&mut brush.pressure_sets_radius, "Pen sets radius", "By how hard a pen presses"),
        (&mut brush.pressure_sets_strength, "Pen sets strength", "By how hard a pen presses"),
    ] {
        widgets::form_row(ui, name, help, false, |ui| widgets::switch(ui, value).on_hover_text(help));
    }
}

fn row(ui: &mut Ui, name: &str, help: &str, value: &mut f32, default: f32, range: (f32, f32), unit: &str) {
    let is_changed = (*value - default).abs() > 1e-6;
    let (is_reset, response) =
        widgets::form_row(ui, name, help, is_changed, |ui| widgets::number(ui, value, range, unit));
    response.on_hover_text(help);
    if is_reset {
        *value = default;
    }
}

/// How hard a pen presses; 1 for a mouse.
pub fn pressure(ui: &Ui) -> f32 {
    ui.input(|input| {
        let force = input.events.iter().rev().find_map(|event| match event {
            egui::Event::Touch { force, .. } => *force,
            _ => None,
        });
        force.unwrap_or(1.0)
    })
}
