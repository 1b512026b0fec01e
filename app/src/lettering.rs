//! Text in a picture, without a window: egui lays it out, and its glyphs are copied out of its font atlas.
//!
//! A bitmap font of our own was rejected: it would be another look than the studio's, and another file.

use std::sync::Arc;

use egui::epaint::text::{Fonts, Galley, TextOptions};
use egui::{Color32, FontDefinitions, FontId};
use image::{Rgba, RgbaImage};

/// Writes with the studio's own font.
pub struct Pen {
    fonts: Fonts,
}

impl Pen {
    pub fn new() -> Self {
        Self { fonts: Fonts::new(TextOptions::default(), FontDefinitions::default()) }
    }

    fn lay_out(&mut self, text: &str, size: f32, width: f32) -> Arc<Galley> {
        let font = FontId::proportional(size);
        self.fonts.with_pixels_per_point(1.0).layout(text.to_owned(), font, Color32::WHITE, width)
    }

    /// Pixels in height of a text of a size, broken at a width in pixels.
    pub fn height(&mut self, text: &str, size: f32, width: u32) -> u32 {
        self.lay_out(text, size, width as f32).rect.height().ceil() as u32
    }

    /// Write a text with its upper left corner at `at`, broken at a width in pixels. What lies outside the picture is
    /// left out.
    pub fn write(&mut self, picture: &mut RgbaImage, at: [u32; 2], text: &str, size: f32, width: u32, colour: Color32) {
        let galley = self.lay_out(text, size, width as f32);
        let atlas = self.fonts.image();
        for row in &galley.rows {
            for glyph in row.glyphs.iter().filter(|glyph| !glyph.uv_rect.is_nothing()) {
                let corner = (row.pos + glyph.pos.to_vec2() + glyph.uv_rect.offset).round();
                let ([left, top], [right, bottom]) = (glyph.uv_rect.min, glyph.uv_rect.max);
                for y in top..bottom {
                    for x in left..right {
                        let coverage = atlas.pixels[usize::from(y) * atlas.size[0] + usize::from(x)].a();
                        let px = at[0] as f32 + corner.x + f32::from(x - left);
                        let py = at[1] as f32 + corner.y + f32::from(y - top);
                        if px >= 0.0 && py >= 0.0 {
                            cover(picture, [px as u32, py as u32], colour, f32::from(coverage) / 255.0);
                        }
                    }
                }
            }
        }
    }
}

/// Mix a colour into a pixel by its share of it.
fn cover(picture: &mut RgbaImage, [x, y]: [u32; 2], colour: Color32, share: f32) {
    let Some(pixel) = picture.get_pixel_mut_checked(x, y) else { return };
    let [r, g, b, _] = colour.to_array();
    let mix = |under: u8, over: u8| (f32::from(under) + share * (f32::from(over) - f32::from(under))).round() as u8;
    *pixel = Rgba([mix(pixel[0], r), mix(pixel[1], g), mix(pixel[2], b), mix(pixel[3], 255)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_leaves_ink_where_it_was_written_and_breaks_at_its_width() {
        let mut pen = Pen::new();
        let mut picture = RgbaImage::from_pixel(120, 80, Rgba([0, 0, 0, 255]));
        pen.write(&mut picture, [10, 20], "Hair", 16.0, 100, Color32::WHITE);
        let ink: Vec<(u32, u32)> =
            picture.enumerate_pixels().filter(|(.., pixel)| pixel[0] > 128).map(|(x, y, _)| (x, y)).collect();
        assert!(ink.len() > 30, "{}", ink.len());
        assert!(ink.iter().all(|&(x, y)| (10..60).contains(&x) && (20..42).contains(&y)), "{ink:?}");
        // Nothing is written outside, and nothing panics there.
        pen.write(&mut picture, [110, 75], "Hair", 16.0, 100, Color32::WHITE);
        let one = pen.height("many words on one line", 14.0, 1000);
        assert!(pen.height("many words on one line", 14.0, 60) >= 2 * one);
    }
}
