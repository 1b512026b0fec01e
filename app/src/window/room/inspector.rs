//! What is under the pointer, in numbers, beside it.

use egui::{Align2, Color32, FontFamily, FontId, Rect, Response, Ui, vec2};
use lorelei_render::inspect::Inspection;

use crate::window::desk::Desk;
use crate::window::state_report::mark;
use crate::window::theme;

/// One line: a name, its value, and whether it heads others.
struct Line {
    name: String,
    value: String,
    is_head: bool,
}

/// Say which pixel is under the pointer, and write what the stage has found there.
pub fn ui(ui: &Ui, desk: &mut Desk, rect: Rect, response: &Response) {
    desk.room.pixel = None;
    if !desk.room.inspects {
        return;
    }
    let pointer = ui.input(|input| input.pointer.latest_pos());
    let Some(pointer) = pointer.filter(|at| rect.contains(*at) && response.contains_pointer()) else { return };
    let scale = ui.ctx().pixels_per_point();
    let at = (pointer - rect.min) * scale;
    desk.room.pixel = Some([at.x as u32, at.y as u32]);
    ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
    let Some(inspection) = &desk.report.inspection else { return };
    let names: Vec<String> = desk.document.groom.layers.iter().map(|layer| layer.name.clone()).collect();
    let lines = lines(inspection, &names);
    let font = FontId::new(11.0, FontFamily::Monospace);
    let row = 14.0;
    let size = vec2(330.0, 12.0 + row * lines.len() as f32);
    let mut corner = pointer + vec2(18.0, 14.0);
    if corner.x + size.x > rect.right() {
        corner.x = pointer.x - 18.0 - size.x;
    }
    corner.x = corner.x.max(rect.left() + 4.0);
    corner.y = corner.y.min(rect.bottom() - size.y - 4.0).max(rect.top() + 4.0);
    let place = Rect::from_min_size(corner, size);
    mark(ui.ctx(), || "inspector".to_owned(), place);
    let painter = ui.painter();
    painter.rect_filled(place, 6.0, Color32::from_black_alpha(205));
    for (i, line) in lines.iter().enumerate() {
        let at = place.min + vec2(8.0, 6.0 + row * i as f32);
        let colour = if line.is_head { theme::ACCENT } else { theme::TEXT };
        painter.text(at, Align2::LEFT_TOP, &line.name, font.clone(), colour);
        painter.text(at + vec2(314.0, 0.0), Align2::RIGHT_TOP, &line.value, font.clone(), theme::TEXT_STRONG);
    }
}

fn rgb(colour: [f32; 3]) -> String {
    let [r, g, b] = colour;
    format!("{r:7.4} {g:7.4} {b:7.4}")
}

/// What an inspection says.
fn lines(inspection: &Inspection, layers: &[String]) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut line =
        |name: &str, value: String, is_head: bool| lines.push(Line { name: name.to_owned(), value, is_head });
    let [x, y] = inspection.pixel;
    line("Pixel", format!("{x}, {y}"), true);
    let [r, g, b, a] = inspection.scene();
    line("scene radiance", rgb([r, g, b]), false);
    line("coverage", format!("{a:.4}"), false);
    line("of the hair", format!("{:.4}", inspection.hair[3]), false);
    let [r, g, b, _] = inspection.display;
    line("display", rgb([r, g, b]), false);
    let Some(strand) = &inspection.strand else {
        line("No strand here", String::new(), true);
        return lines;
    };
    let layer = layers.get(strand.layer_idx as usize).map_or("", String::as_str);
    line(&format!("Strand {}", strand.id), layer.to_owned(), true);
    let [px, py, pz] = strand.position.to_array();
    line("place, cm", format!("{px:7.2} {py:7.2} {pz:7.2}"), false);
    let [tx, ty, tz] = strand.tangent.to_array();
    line("tangent", format!("{tx:7.3} {ty:7.3} {tz:7.3}"), false);
    line("along", format!("{:.1} %", 100.0 * strand.along), false);
    line("depth, radius", format!("{:.1} cm  {:.0} \u{b5}m", strand.depth, strand.radius_um), false);
    line("Radiance", rgb(strand.radiance), true);
    for (name, radiance) in &strand.terms {
        line(name, rgb(*radiance), false);
    }
    line("Lamps: depth, past head", "radiance".to_owned(), true);
    for (i, light) in strand.lights.iter().enumerate() {
        line(&format!("{}  {:.2}  {:.2}", i + 1, light.hair_depth, light.past_head), rgb(light.radiance), false);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_without_a_strand_says_so_and_scene_is_hair_over_body() {
        let inspection = Inspection {
            pixel: [3, 4],
            hair: [0.1, 0.2, 0.3, 0.5],
            body: [0.2, 0.2, 0.2, 1.0],
            display: [0.5; 4],
            strand: None,
        };
        assert_eq!(inspection.scene(), [0.2, 0.3, 0.4, 1.0]);
        let lines = lines(&inspection, &[]);
        assert!(lines.iter().any(|line| line.name == "No strand here"));
        assert_eq!(lines[0].value, "3, 4");
    }
}
