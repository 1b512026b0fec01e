//! The brushes as buttons with icons.

use egui::{Color32, Rect, Sense, Stroke, Ui, pos2, vec2};
use lorelei_core::look::Choice;
use lorelei_core::sculpt::SculptBrush;

use super::commands::SculptCommand;
use crate::window::commands::Command;
use crate::window::state_report::mark;
use crate::window::theme;

/// Side of a button, points.
const SIDE: f32 = 32.0;

/// A button for every brush; `kind` becomes the one that is clicked.
pub fn ui(ui: &mut Ui, kind: &mut SculptBrush) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
        for &brush in SculptBrush::ALL {
            let (place, response) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::click());
            let fill = match (*kind == brush, response.hovered()) {
                (true, _) => theme::ACCENT_DIM,
                (false, true) => theme::CONTROL_HOVER,
                (false, false) => theme::CONTROL,
            };
            ui.painter().rect_filled(place, 4.0, fill);
            icon(ui, brush, place, if *kind == brush { theme::TEXT_STRONG } else { theme::TEXT });
            mark(ui.ctx(), || format!("brush {}", brush.info().name), place);
            let row = Command::Sculpt(SculptCommand::Brush(brush)).row();
            let key = row.shortcuts.first().map(|s| ui.ctx().format_shortcut(s)).unwrap_or_default();
            if response.on_hover_text(format!("{} ({key})\n{}", row.label, row.help)).clicked() {
                *kind = brush;
            }
        }
    });
}

/// Lines of an icon within -10..10.
fn lines(brush: SculptBrush) -> &'static [&'static [(i8, i8)]] {
    match brush {
        SculptBrush::Comb => &[
            &[(-8, -7), (8, -7), (8, -3), (-8, -3), (-8, -7)],
            &[(-6, -3), (-6, 7)],
            &[(-2, -3), (-2, 7)],
            &[(2, -3), (2, 7)],
            &[(6, -3), (6, 7)],
        ],
        SculptBrush::Smooth => {
            &[&[(-8, -5), (-4, -7), (0, -4), (4, -5), (8, -5)], &[(-8, 1), (-3, 0), (3, 1), (8, 1)], &[(-8, 6), (8, 6)]]
        }
        SculptBrush::Puff => &[
            &[(-9, 8), (9, 8)],
            &[(-4, 8), (-7, -2)],
            &[(0, 8), (0, -5)],
            &[(4, 8), (7, -2)],
            &[(-3, -3), (0, -8), (3, -3)],
        ],
        SculptBrush::Pinch => &[&[(-9, -6), (-2, 0), (-9, 6)], &[(9, -6), (2, 0), (9, 6)]],
        SculptBrush::Clump => &[&[(-7, -8), (-1, 8)], &[(-3, -8), (0, 8)], &[(3, -8), (0, 8)], &[(7, -8), (1, 8)]],
        SculptBrush::Twist => &[&[(-4, -8), (4, -3), (-4, 2), (4, 7)], &[(4, -8), (-4, -3), (4, 2), (-4, 7)]],
        SculptBrush::Curl => &[&[(-6, -8), (-6, 1), (-3, 6), (2, 7), (6, 3), (5, -2), (1, -3), (-1, 0), (1, 3)]],
        SculptBrush::Part => &[&[(0, -8), (0, 8)], &[(-1, -5), (-5, -1), (-8, 6)], &[(1, -5), (5, -1), (8, 6)]],
        SculptBrush::Length => &[&[(0, -8), (0, 8)], &[(-3, 4), (0, 8), (3, 4)], &[(-5, -8), (5, -8)]],
        SculptBrush::Cut => &[
            &[(-6, -8), (3, 4)],
            &[(6, -8), (-3, 4)],
            &[(-3, 4), (-6, 5), (-5, 8), (-2, 8), (-3, 4)],
            &[(3, 4), (6, 5), (5, 8), (2, 8), (3, 4)],
        ],
        SculptBrush::Add => &[&[(0, -7), (0, 7)], &[(-7, 0), (7, 0)]],
        SculptBrush::Delete => &[&[(-6, -6), (6, 6)], &[(6, -6), (-6, 6)]],
        SculptBrush::Slide => &[
            &[(-8, 5), (8, 5)],
            &[(-5, 5), (-7, -5)],
            &[(3, 5), (1, -5)],
            &[(4, 0), (9, 0)],
            &[(6, -3), (9, 0), (6, 3)],
        ],
        SculptBrush::Freeze => &[
            &[(0, -8), (0, 8)],
            &[(-7, -4), (7, 4)],
            &[(-7, 4), (7, -4)],
            &[(-2, -7), (0, -5), (2, -7)],
            &[(-2, 7), (0, 5), (2, 7)],
        ],
        SculptBrush::Mask => &[
            &[(-8, -4), (8, -4), (7, 3), (3, 5), (0, 2), (-3, 5), (-7, 3), (-8, -4)],
            &[(-5, -1), (-2, -1)],
            &[(2, -1), (5, -1)],
        ],
    }
}

fn icon(ui: &Ui, brush: SculptBrush, place: Rect, colour: Color32) {
    for line in lines(brush) {
        let at = |&(x, y): &(i8, i8)| pos2(place.center().x + f32::from(x), place.center().y + f32::from(y));
        ui.painter().add(egui::Shape::line(line.iter().map(at).collect(), Stroke::new(1.4, colour)));
    }
}
