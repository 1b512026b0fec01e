//! How far two pictures are apart, and how far two drivers may be.
//!
//! The measures are taken over means of 2x2 pixels, so that a fragment which falls to a neighbouring pixel under
//! another driver's rounding does not count as a difference.

use image::{Rgba, RgbaImage};

/// Root mean square over all boxes and channels, display values 0-1, that is still the same picture.
pub const MOST_RMSE: f64 = 0.01;
/// A box whose difference in any channel is larger than this, in display values 0-1, is off.
pub const OFF: f64 = 0.1;
/// Share of the boxes that may be off: less than one tile of 16x16 pixels in a picture of 256x256.
pub const MOST_OFF: f64 = 0.003;
/// The same where nothing is blended: which of two strands is the nearest one, and whether it touches a pixel at all, is
/// decided by the last bits.
const MOST_OFF_UNBLENDED: f64 = 0.01;

/// How far apart two pictures of one size are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    pub rmse: f64,
    /// Share of the boxes that are off, 0-1.
    pub share_off: f64,
    /// Largest difference of a box in any channel.
    pub largest: f64,
}

impl Difference {
    /// An error where the sizes differ.
    pub fn between(a: &RgbaImage, b: &RgbaImage) -> Result<Self, String> {
        let (width, height) = a.dimensions();
        if (width, height) != b.dimensions() {
            return Err(format!("{width}x{height} against {}x{}", b.width(), b.height()));
        }
        let (mut squares, mut n_boxes, mut n_off, mut largest) = (0.0, 0, 0, 0.0);
        for y in 0..height / 2 {
            for x in 0..width / 2 {
                let (a, b) = (box_mean(a, 2 * x, 2 * y), box_mean(b, 2 * x, 2 * y));
                let apart = [0, 1, 2, 3].map(|channel| f64::abs(a[channel] - b[channel]));
                squares += apart.iter().map(|d| d * d).sum::<f64>();
                let most = apart.into_iter().fold(0.0, f64::max);
                largest = f64::max(largest, most);
                n_off += u32::from(most > OFF);
                n_boxes += 1;
            }
        }
        let n = f64::from(n_boxes.max(1));
        Ok(Self { rmse: (squares / (4.0 * n)).sqrt(), share_off: f64::from(n_off) / n, largest })
    }

    /// `is_blended`: pixels mix the strands that touch them.
    pub fn is_within(&self, is_blended: bool) -> bool {
        let most_off = if is_blended { MOST_OFF } else { MOST_OFF_UNBLENDED };
        self.rmse <= MOST_RMSE && self.share_off <= most_off
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { rmse, share_off, largest } = self;
        write!(f, "rmse {rmse:.5}  off {:6.3} %  largest {largest:.3}", 100.0 * share_off)
    }
}

/// Mean of the four pixels from (`x`, `y`) on, 0-1, premultiplied: where nothing covers a pixel its colour says nothing.
fn box_mean(picture: &RgbaImage, x: u32, y: u32) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let pixel = picture.get_pixel(x + dx, y + dy);
        let alpha = f64::from(pixel[3]) / 255.0;
        for channel in 0..3 {
            sum[channel] += alpha * f64::from(pixel[channel]) / 1020.0;
        }
        sum[3] += alpha / 4.0;
    }
    sum
}

/// Ten times the absolute difference of the colours as stored; alpha's is shown as grey.
pub fn difference_picture(a: &RgbaImage, b: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(a.width(), a.height(), |x, y| {
        let (a, b) = (a.get_pixel(x, y), b.get_pixel(x, y));
        let apart = |channel: usize| a[channel].abs_diff(b[channel]);
        let shown = |channel: usize| apart(channel).max(apart(3)).saturating_mul(10);
        Rgba([shown(0), shown(1), shown(2), 255])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_are_equal_and_opposite_ones_are_far_apart() {
        let black = RgbaImage::from_pixel(4, 4, Rgba([0; 4]));
        let white = RgbaImage::from_pixel(4, 4, Rgba([255; 4]));
        assert_eq!(
            Difference::between(&black, &black).unwrap(),
            Difference { rmse: 0.0, share_off: 0.0, largest: 0.0 }
        );
        let opposite = Difference::between(&black, &white).unwrap();
        assert!((opposite.rmse - 1.0).abs() < 1e-12 && opposite.share_off == 1.0);
        Difference::between(&black, &RgbaImage::new(4, 2)).unwrap_err();
    }

    #[test]
    fn a_lost_tile_is_seen_and_a_shifted_fragment_is_not() {
        let grey = RgbaImage::from_pixel(256, 256, Rgba([90, 90, 90, 255]));
        let mut tile = grey.clone();
        let mut fragments = grey.clone();
        for y in 0..16 {
            for x in 0..16 {
                // Hair of half the background's light is gone in one tile.
                tile.put_pixel(64 + x, 64 + y, Rgba([45, 45, 45, 255]));
            }
            // In sixteen places a bright fragment is one pixel further.
            fragments.put_pixel(16 * y, 100, Rgba([200, 200, 200, 255]));
        }
        let mut shifted = grey.clone();
        for k in 0..16 {
            shifted.put_pixel(16 * k + 1, 100, Rgba([200, 200, 200, 255]));
        }
        assert!(!Difference::between(&grey, &tile).unwrap().is_within(true));
        assert!(Difference::between(&fragments, &shifted).unwrap().is_within(true));
    }
}
