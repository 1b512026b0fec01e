//! Pulling hair while it plays: a press takes hold of the hair under the pointer, and it comes along until it is released.
//!
//! The document knows nothing of it: the stage holds the hair ([`crate::stage::hold`]), and what is shown is where it has it.

use egui::{Align2, Color32, CursorIcon, Stroke, Ui, vec2};
use glam::Vec2;

use super::View;
use crate::stage::hold::Hand;
use crate::window::desk::Desk;
use crate::window::panels::widgets;
use crate::window::projection::Projection;
use crate::window::state_report::mark;
use crate::window::theme;

/// What the tool keeps.
pub struct PullTool {
    /// How far around what is held hair follows, cm.
    pub radius: f32,
    /// 1/s2.
    pub strength: f32,
    n_grabs: u64,
    /// The press that goes on was on the picture.
    is_pressed: bool,
}

const RADIUS: f32 = 2.0;
/// The weight of a whole strand hangs 0.5 cm below the hand.
const STRENGTH: f32 = 2000.0;

impl Default for PullTool {
    fn default() -> Self {
        Self { radius: RADIUS, strength: STRENGTH, n_grabs: 0, is_pressed: false }
    }
}

impl PullTool {
    /// Hold what was pressed on; true while the button is down. `projection` is that of the world.
    pub fn viewport(&mut self, ui: &mut Ui, desk: &mut Desk, projection: Projection, view: &View<'_>) -> bool {
        let (is_pressed, is_down, at) = ui.input(|input| {
            let pointer = &input.pointer;
            (pointer.primary_pressed(), pointer.primary_down(), pointer.latest_pos())
        });
        if is_pressed && view.pointer(ui).is_some() && view.response.is_pointer_button_down_on() {
            self.is_pressed = true;
            self.n_grabs += 1;
        }
        self.is_pressed &= is_down;
        let rect = projection.rect();
        desk.playback.hand = at.filter(|_| self.is_pressed).map(|at| {
            let from_middle = (at - rect.center()) / (0.5 * rect.size());
            let at = Vec2::new(from_middle.x, -from_middle.y);
            Hand { n_grabs: self.n_grabs, at, radius: self.radius, strength: self.strength }
        });
        if view.pointer(ui).is_some() {
            ui.ctx().set_cursor_icon(if self.is_pressed { CursorIcon::Grabbing } else { CursorIcon::Grab });
        }
        if self.is_pressed
            && let Some(at) = at
        {
            self.draw(ui, desk, projection, at);
        }
        self.is_pressed
    }

    /// A ring where the hair is held, as wide as what follows it, and a line to the pointer.
    fn draw(&self, ui: &Ui, desk: &Desk, projection: Projection, pointer: egui::Pos2) {
        let Some(held) = desk.report.held else { return };
        let Some(at) = projection.point(held.at) else { return };
        let painter = ui.painter();
        let shade = Color32::from_black_alpha(120);
        painter.line_segment([at, pointer], Stroke::new(3.5, shade));
        painter.line_segment([at, pointer], Stroke::new(1.6, theme::ACCENT));
        painter.circle_stroke(
            at,
            self.radius / projection.cm_per_point(held.at).max(1e-6),
            Stroke::new(1.0, theme::ACCENT.gamma_multiply(0.6)),
        );
        painter.circle_filled(at, 5.5, shade);
        painter.circle_filled(at, 4.0, theme::ACCENT);
        painter.circle(pointer, 4.0, shade, Stroke::new(1.4, theme::ACCENT));
        if !desk.playback.is_playing {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let place = pointer + vec2(12.0, -12.0);
            let words = "Space: let time pass";
            painter.text(place + vec2(1.0, 1.0), Align2::LEFT_BOTTOM, words, font.clone(), shade);
            painter.text(place, Align2::LEFT_BOTTOM, words, font, theme::TEXT_STRONG);
        }
    }

    pub fn panel(&mut self, ui: &mut Ui, desk: &Desk) {
        ui.label(
            "Drag hair in the viewport while it plays. It is held where you press, and swings back when you let go.",
        );
        let help = "Hair that rests within this of what is held comes along, the less the farther away";
        number(ui, "Radius", help, &mut self.radius, RADIUS, (0.2, 15.0), "cm");
        let help =
            "Force over the mass of a strand and its way to the hand: at 2000 a strand's weight hangs 0.5 cm below it";
        number(ui, "Strength", help, &mut self.strength, STRENGTH, (50.0, 20000.0), "1/s\u{b2}");
        let words = if desk.playback.is_playing {
            "What is pulled is not kept on the timeline, and the groom stays as it is."
        } else {
            "Time stands still: press Space, and the pull acts."
        };
        ui.label(egui::RichText::new(words).color(theme::TEXT_WEAK));
    }
}

fn number(ui: &mut Ui, name: &str, help: &str, value: &mut f32, default: f32, range: (f32, f32), unit: &str) {
    let is_changed = (*value - default).abs() > 1e-6;
    let (is_reset, response) =
        widgets::form_row(ui, name, help, is_changed, |ui| widgets::number(ui, value, range, unit));
    mark(ui.ctx(), || format!("pull {name}"), response.rect);
    response.on_hover_text(help);
    if is_reset {
        *value = default;
    }
}
