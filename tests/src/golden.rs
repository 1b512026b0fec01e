//! Golden images: a picture is compared with the one on disk within a stated tolerance.
//!
//! `LORELEI_GOLDEN=write` writes them anew; look at what changed before committing. The measure is the
//! root mean square error of display values over 2x2 boxes, so that a fragment that falls to a
//! neighbouring pixel under another driver's rounding does not count as a difference.

use image::RgbaImage;

use crate::root;

/// Compare with `tests/golden/NAME.png`; panics with the error and the path of the new picture.
///
/// `max_rmse` is in display values, 0-1.
pub fn assert_golden(name: &str, picture: &RgbaImage, max_rmse: f64) {
    let path = root().join("tests").join("golden").join(format!("{name}.png"));
    if std::env::var("LORELEI_GOLDEN").is_ok_and(|value| value == "write") {
        std::fs::create_dir_all(path.parent().expect("the path has a folder")).expect("the golden folder can be made");
        picture.save(&path).expect("the golden image can be written");
        return;
    }
    let golden = image::open(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display())).to_rgba8();
    let rmse = rmse(&golden, picture);
    if rmse > max_rmse {
        let out = root().join("out");
        std::fs::create_dir_all(&out).expect("the folder `out` can be made");
        let new = out.join(format!("{name}.new.png"));
        picture.save(&new).expect("the new picture can be written");
        panic!("{name}: rmse {rmse:.4} over {max_rmse}; the new picture is {}", new.display());
    }
}

/// Root mean square error of display values over 2x2 boxes; 1 where the sizes differ.
pub fn rmse(a: &RgbaImage, b: &RgbaImage) -> f64 {
    if a.dimensions() != b.dimensions() {
        return 1.0;
    }
    let (width, height) = a.dimensions();
    let mut sum = 0.0;
    let mut n = 0.0;
    for y in 0..height / 2 {
        for x in 0..width / 2 {
            for channel in 0..4 {
                let mean = |image: &RgbaImage| -> f64 {
                    let corner = [(0, 0), (1, 0), (0, 1), (1, 1)];
                    corner
                        .iter()
                        .map(|(dx, dy)| f64::from(image.get_pixel(2 * x + dx, 2 * y + dy)[channel]))
                        .sum::<f64>()
                        / 1020.0
                };
                sum += (mean(a) - mean(b)).powi(2);
                n += 1.0;
            }
        }
    }
    f64::sqrt(sum / f64::max(n, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rmse_is_zero_for_equal_and_one_for_opposite_pictures() {
        let black = RgbaImage::from_pixel(4, 4, image::Rgba([0; 4]));
        let white = RgbaImage::from_pixel(4, 4, image::Rgba([255; 4]));
        assert_eq!(rmse(&black, &black), 0.0);
        assert!((rmse(&black, &white) - 1.0).abs() < 1e-12);
    }
}
