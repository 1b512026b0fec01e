//! What false colours mean, drawn beside the picture that has them.

use egui::{Align2, Color32, Pos2, Rect, Stroke, Ui, pos2, vec2};
use lorelei_core::groom::Groom;
use lorelei_core::look::view::{Legend, layer_colour, own_colour, part_colour, ramp};

use crate::window::state_report::mark;
use crate::window::theme;

const WIDTH: f32 = 230.0;
const ROW: f32 = 18.0;
/// Steps of a drawn ramp.
const N_STEPS: usize = 64;

/// A colour as a display shows it.
fn colour32([r, g, b]: [f32; 3]) -> Color32 {
    let byte = |channel: f32| (255.0 * channel.clamp(0.0, 1.0)).round() as u8;
    Color32::from_rgb(byte(r), byte(g), byte(b))
}

/// Draw the legend of the groom's view at the viewport's lower right.
pub fn ui(ui: &Ui, groom: &Groom, rect: Rect) {
    let view = groom.look.view;
    let legend = view.legend(&groom.look.view_params);
    if legend == Legend::None {
        return;
    }
    let n_rows = match legend {
        Legend::None => 0,
        Legend::Ramp { .. } | Legend::Own(_) | Legend::Parts => 2,
        Legend::Names(_) => 3,
        Legend::Layers => groom.layers.len(),
    };
    let size = vec2(WIDTH, 30.0 + ROW * n_rows as f32);
    let place = Align2::RIGHT_BOTTOM.anchor_size(rect.right_bottom() - vec2(12.0, 12.0), size);
    ui.painter().rect_filled(place, 6.0, Color32::from_black_alpha(170));
    mark(ui.ctx(), || "legend".to_owned(), place);
    let info = lorelei_core::look::Choice::info(view);
    let at = place.min + vec2(10.0, 6.0);
    text(ui, at, info.label, theme::TEXT_STRONG);
    let body = at + vec2(0.0, 20.0);
    let width = WIDTH - 20.0;
    match legend {
        Legend::None => {}
        Legend::Ramp { unit, low, high } => {
            let step = width / N_STEPS as f32;
            for i in 0..N_STEPS {
                let bar = Rect::from_min_size(body + vec2(step * i as f32, 0.0), vec2(step + 0.5, 12.0));
                ui.painter().rect_filled(bar, 0.0, colour32(ramp((i as f32 + 0.5) / N_STEPS as f32)));
            }
            let numbers = body + vec2(0.0, 15.0);
            text(ui, numbers, &format!("{low}"), theme::TEXT);
            let font = egui::TextStyle::Small.resolve(ui.style());
            ui.painter().text(
                numbers + vec2(0.5 * width, 0.0),
                Align2::CENTER_TOP,
                unit,
                font.clone(),
                theme::TEXT_WEAK,
            );
            ui.painter().text(numbers + vec2(width, 0.0), Align2::RIGHT_TOP, format!("{high}"), font, theme::TEXT);
        }
        Legend::Names(names) => {
            for (i, (name, colour)) in names.into_iter().enumerate() {
                swatch(ui, body + vec2(0.0, ROW * i as f32), colour, name);
            }
        }
        Legend::Own(what) => {
            for i in 0..12_u32 {
                let chip =
                    Rect::from_min_size(body + vec2(i as f32 * width / 12.0, 0.0), vec2(width / 12.0 - 2.0, 12.0));
                ui.painter().rect_filled(chip, 2.0, colour32(own_colour(i)));
            }
            text(ui, body + vec2(0.0, 15.0), &format!("a colour for {what}"), theme::TEXT_WEAK);
        }
        Legend::Parts => {
            for i in 0..12_u32 {
                let chip =
                    Rect::from_min_size(body + vec2(i as f32 * width / 12.0, 0.0), vec2(width / 12.0 - 2.0, 12.0));
                ui.painter().rect_filled(chip, 2.0, colour32(part_colour(i, 12)));
            }
            text(ui, body + vec2(0.0, 15.0), "layers from the lamp on; grey: none", theme::TEXT_WEAK);
        }
        Legend::Layers => {
            for (layer_idx, layer) in groom.layers.iter().enumerate() {
                swatch(ui, body + vec2(0.0, ROW * layer_idx as f32), layer_colour(layer_idx), &layer.name);
            }
        }
    }
}

fn swatch(ui: &Ui, at: Pos2, colour: [f32; 3], name: &str) {
    let chip = Rect::from_min_size(at + vec2(0.0, 1.0), vec2(22.0, 12.0));
    ui.painter().rect_filled(chip, 2.0, colour32(colour));
    ui.painter().rect_stroke(chip, 2.0, Stroke::new(1.0, Color32::from_black_alpha(120)), egui::StrokeKind::Outside);
    text(ui, pos2(at.x + 30.0, at.y), name, theme::TEXT);
}

fn text(ui: &Ui, at: Pos2, text: &str, colour: Color32) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    ui.painter().text(at, Align2::LEFT_TOP, text, font, colour);
}
