//! A contact sheet as one picture: tiles in rows, under each its label, its cost and what it is.

use egui::Color32;
use image::{Rgba, RgbaImage};

use super::{Sheet, Tile};
use crate::lettering::Pen;

const BACKGROUND: Rgba<u8> = Rgba([30, 30, 30, 255]);
/// Around what the groom's own look has.
const CHOSEN: Rgba<u8> = Rgba([222, 168, 82, 255]);
const STRONG: Color32 = Color32::from_gray(240);
const WEAK: Color32 = Color32::from_gray(165);
const ACCENT: Color32 = Color32::from_rgb(222, 168, 82);

/// Pixels between tiles, and around all of them.
const GAP: u32 = 18;
const TITLE: f32 = 24.0;
const LABEL: f32 = 17.0;
const SMALL: f32 = 13.0;
/// The shape that a sheet comes nearest to, width by height.
const SHAPE: f32 = 1.6;

/// Tiles a row, so that the sheet is about as wide as a screen and few places stay empty.
fn n_columns(n_tiles: usize, [width, height]: [u32; 2]) -> usize {
    let cost = |columns: usize| {
        let rows = n_tiles.div_ceil(columns);
        let shape = (columns as f32 * width as f32) / (rows as f32 * height as f32);
        (shape / SHAPE).ln().abs() + 0.2 * (rows * columns - n_tiles) as f32
    };
    (1..=n_tiles).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(1)
}

/// What a tile cost, as a line.
fn cost_line(sheet: &Sheet, tile: &Tile) -> String {
    let mut parts = vec![format!("{}={}", sheet.slot, tile.info.name)];
    if let Some(ms) = tile.gpu_ms {
        parts.push(if ms < 10.0 { format!("{ms:.2} ms GPU") } else { format!("{ms:.0} ms GPU") });
    }
    if tile.n_bytes > 0 {
        parts.push(format!("{:.1} MiB", tile.n_bytes as f64 / f64::from(1 << 20)));
    }
    parts.join("   ")
}

impl Sheet {
    /// The sheet as one opaque picture.
    pub fn picture(&self) -> RgbaImage {
        let drawn = self.tiles.iter().find_map(|tile| tile.picture.as_ref().ok());
        let size = drawn.map_or([320, 240], |picture| [picture.width(), picture.height()]);
        let mut pen = Pen::new();
        let columns = n_columns(self.tiles.len(), size);
        let rows = self.tiles.len().div_ceil(columns);
        let label = pen.height("Hg", LABEL, 1000);
        let lines: Vec<String> = self.tiles.iter().map(|tile| cost_line(self, tile)).collect();
        let cost = lines.iter().map(|line| pen.height(line, SMALL, size[0])).max().unwrap_or(0);
        let help = self.tiles.iter().map(|tile| pen.height(tile.info.help, SMALL, size[0])).max().unwrap_or(0);
        let (label_at, cost_at) = (size[1] + 8, size[1] + 8 + label + 2);
        let help_at = cost_at + cost + 3;
        let cell = [size[0] + GAP, help_at + help + GAP];
        let width = GAP + cell[0] * columns as u32;
        let text_width = width - 2 * GAP;
        let title_height = pen.height(self.label, TITLE, text_width);
        let line = format!("{}   \u{b7}   {}", self.help, self.subject);
        let header = GAP + title_height + 4 + pen.height(&line, SMALL, text_width) + GAP;
        let mut sheet = RgbaImage::from_pixel(width, header + cell[1] * rows as u32, BACKGROUND);
        pen.write(&mut sheet, [GAP, GAP], self.label, TITLE, text_width, STRONG);
        pen.write(&mut sheet, [GAP, GAP + title_height + 4], &line, SMALL, text_width, WEAK);
        for (i, tile) in self.tiles.iter().enumerate() {
            let left = GAP + cell[0] * (i % columns) as u32;
            let top = header + cell[1] * (i / columns) as u32;
            match &tile.picture {
                Ok(picture) => put(&mut sheet, picture, [left, top]),
                Err(why) => pen.write(&mut sheet, [left, top], why, SMALL, size[0], ACCENT),
            }
            if tile.is_chosen {
                frame(&mut sheet, [left, top], size);
            }
            let colour = if tile.is_chosen { ACCENT } else { STRONG };
            pen.write(&mut sheet, [left, top + label_at], tile.info.label, LABEL, size[0], colour);
            pen.write(&mut sheet, [left, top + cost_at], &lines[i], SMALL, size[0], STRONG);
            pen.write(&mut sheet, [left, top + help_at], tile.info.help, SMALL, size[0], WEAK);
        }
        sheet
    }
}

/// A tile's picture over a check pattern, which shows where it is transparent.
fn put(sheet: &mut RgbaImage, picture: &RgbaImage, [left, top]: [u32; 2]) {
    for (x, y, pixel) in picture.enumerate_pixels() {
        let check = if (x / 12 + y / 12) % 2 == 0 { 70.0 } else { 95.0 };
        let alpha = f32::from(pixel[3]) / 255.0;
        let mix = |channel: u8| (check + alpha * (f32::from(channel) - check)).round() as u8;
        sheet.put_pixel(left + x, top + y, Rgba([mix(pixel[0]), mix(pixel[1]), mix(pixel[2]), 255]));
    }
}

/// A frame of three pixels just outside a tile.
fn frame(sheet: &mut RgbaImage, [left, top]: [u32; 2], [width, height]: [u32; 2]) {
    for y in top - 3..top + height + 3 {
        for x in left - 3..left + width + 3 {
            let is_inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
            if !is_inside {
                sheet.put_pixel(x, y, CHOSEN);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use lorelei_core::look::ChoiceInfo;

    use super::*;

    #[test]
    fn a_sheet_shows_every_tile_and_marks_the_chosen_one() {
        let tile = |shade: u8, is_chosen: bool| Tile {
            info: ChoiceInfo { name: "a", label: "A", help: "help" },
            is_chosen,
            gpu_ms: Some(1.5),
            passes: Vec::new(),
            n_bytes: 1 << 20,
            n_strands: 5,
            picture: Ok(RgbaImage::from_pixel(200, 150, Rgba([shade, 0, 0, 255]))),
        };
        let mut tiles = vec![tile(200, false), tile(201, true), tile(202, false)];
        tiles.push(Tile { picture: Err("does not fit".to_owned()), ..tile(0, false) });
        let sheet = Sheet { slot: "s", label: "Slot", help: "what", subject: "groom".to_owned(), tiles };
        let picture = sheet.picture();
        for shade in [200, 201, 202] {
            let n = picture.pixels().filter(|pixel| pixel.0 == [shade, 0, 0, 255]).count();
            assert_eq!(n, 200 * 150, "{shade}");
        }
        let n_frame = picture.pixels().filter(|pixel| **pixel == CHOSEN).count();
        assert!(n_frame >= 206 * 156 - 200 * 150, "{n_frame}");
        assert_eq!(n_columns(4, [200, 150]), 2);
        assert_eq!(n_columns(1, [200, 150]), 1);
    }
}
