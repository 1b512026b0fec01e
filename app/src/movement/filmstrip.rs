//! A movement as one picture: frames of it side by side, under each its time.

use egui::Color32;
use image::{Rgba, RgbaImage};

use crate::lettering::Pen;

/// Frames of a strip.
pub const N_PICTURES: u32 = 8;

const BACKGROUND: Rgba<u8> = Rgba([30, 30, 30, 255]);
const STRONG: Color32 = Color32::from_gray(240);
const WEAK: Color32 = Color32::from_gray(165);
const GAP: u32 = 6;
const TITLE: f32 = 20.0;
const SMALL: f32 = 14.0;

/// The frames that a strip of a movement of `n_frames` shows: the first, the last, and evenly between.
pub fn frames_of(n_frames: u32) -> Vec<u32> {
    let mut frames: Vec<u32> = (0..N_PICTURES)
        .map(|i| (f64::from(n_frames) * f64::from(i) / f64::from(N_PICTURES - 1)).round() as u32)
        .collect();
    frames.dedup();
    frames
}

/// Pictures of one size in a row, each over its time in seconds, below a title and a line.
pub fn filmstrip(title: &str, line: &str, frames: &[(f64, RgbaImage)]) -> RgbaImage {
    let [width, height] = frames.first().map_or([1, 1], |(_, picture)| [picture.width(), picture.height()]);
    let mut pen = Pen::new();
    let strip_width = GAP + (width + GAP) * frames.len().max(1) as u32;
    let text_width = strip_width.saturating_sub(2 * GAP);
    let title_height = pen.height(title, TITLE, text_width);
    let top = GAP + title_height + pen.height(line, SMALL, text_width) + 2 * GAP;
    let label_height = pen.height("0.00 s", SMALL, width);
    let mut strip = RgbaImage::from_pixel(strip_width, top + height + GAP + label_height + GAP, BACKGROUND);
    pen.write(&mut strip, [GAP, GAP], title, TITLE, text_width, STRONG);
    pen.write(&mut strip, [GAP, GAP + title_height + GAP / 2], line, SMALL, text_width, WEAK);
    for (i, (secs, picture)) in frames.iter().enumerate() {
        let left = GAP + (width + GAP) * i as u32;
        image::imageops::overlay(&mut strip, picture, i64::from(left), i64::from(top));
        let label = format!("{secs:.2} s");
        pen.write(&mut strip, [left + GAP, top + height + GAP], &label, SMALL, width, STRONG);
    }
    strip
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_shows_the_first_and_the_last_frame_and_every_picture_whole() {
        assert_eq!(frames_of(70), [0, 10, 20, 30, 40, 50, 60, 70]);
        assert_eq!(frames_of(3), [0, 1, 2, 3]);
        assert_eq!(frames_of(0), [0]);
        let frames: Vec<(f64, RgbaImage)> =
            (0..3).map(|i| (f64::from(i), RgbaImage::from_pixel(40, 30, Rgba([200 + i as u8, 0, 0, 255])))).collect();
        let strip = filmstrip("Title", "line", &frames);
        for shade in 200..203 {
            assert_eq!(strip.pixels().filter(|pixel| pixel.0 == [shade, 0, 0, 255]).count(), 40 * 30, "{shade}");
        }
    }
}
