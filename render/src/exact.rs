//! The exact picture of a set of strands, in f64 on the CPU: what every drawing technique is measured against.
//!
//! Each segment is a strip with the strand's width, clipped against each pixel's square; the clipped area is the
//! fragment's coverage. Fragments are sorted by depth in each pixel and composited front to back. Supersampling was
//! rejected as the reference: at 80 um a hair needs hundreds of samples a pixel before its noise is below what is
//! measured. What remains inexact is inherent in coverage as an alpha: two strands in one pixel are taken to cover it
//! independently of each other. Neighbouring segments of one strand are not: their areas add.

use glam::{DVec2, Mat4, Vec4};
use rayon::prelude::*;

/// Strands as the rasterisers get them.
#[derive(Clone, Copy)]
pub struct ExactStrands<'a> {
    /// World position in centimetres and radius in centimetres, strand after strand.
    pub vertices: &'a [Vec4],
    pub vertices_per_strand: usize,
    /// Outgoing linear radiance of each vertex and the fibre's own opacity.
    pub radiance: &'a [[f32; 4]],
}

/// A surface behind or among the strands, one value a pixel; empty slices: nothing is there.
#[derive(Clone, Copy, Default)]
pub struct Backdrop<'a> {
    /// Distance along the view axis, centimetres.
    pub depth: &'a [f32],
    /// Share of the pixel that the surface covers, 0-1.
    pub coverage: &'a [f32],
}

/// A hair fragment in one pixel.
#[derive(Clone, Copy)]
struct Fragment {
    depth: f64,
    coverage: f64,
    colour: [f64; 3],
    strand_idx: u32,
    segment_idx: u32,
}

/// Premultiplied linear RGB and alpha of the strands of all layers alone, row by row from the top.
///
/// A fragment behind the backdrop shows through the part of the pixel that the backdrop leaves open.
/// `size` is in pixels; `view_from_world` looks along -Z; `clip_from_view` is a perspective.
pub fn composite(
    strands: &[ExactStrands<'_>],
    view_from_world: Mat4,
    clip_from_view: Mat4,
    size: [u32; 2],
    backdrop: Backdrop<'_>,
) -> Vec<[f64; 4]> {
    /// Rows that one task holds in memory at a time.
    const ROWS: usize = 16;
    let [width, height] = size.map(|side| side as usize);
    let projected: Vec<Vec<Projected>> =
        strands.iter().map(|layer| project(*layer, view_from_world, clip_from_view, size)).collect();
    let mut picture = vec![[0.0; 4]; width * height];
    picture.par_chunks_mut(width * ROWS).enumerate().for_each(|(band_idx, pixels)| {
        let first_row = band_idx * ROWS;
        let mut fragments: Vec<Vec<Fragment>> = vec![Vec::new(); pixels.len()];
        let mut first_strand = 0;
        for (layer, projected) in strands.iter().zip(&projected) {
            fragments_of_rows(*layer, projected, first_strand, width, first_row, &mut fragments);
            first_strand += projected.len() / layer.vertices_per_strand;
        }
        for (offset, (pixel, fragments)) in pixels.iter_mut().zip(&mut fragments).enumerate() {
            let pixel_idx = first_row * width + offset;
            let surface = (
                backdrop.depth.get(pixel_idx).map_or(f64::INFINITY, |&depth| f64::from(depth)),
                backdrop.coverage.get(pixel_idx).map_or(0.0, |&coverage| f64::from(coverage)),
            );
            *pixel = composite_pixel(fragments, surface);
        }
    });
    picture
}

/// A vertex in pixels, its distance along the view axis and its half width in pixels.
#[derive(Clone, Copy)]
struct Projected {
    at: DVec2,
    depth: f64,
    half_width: f64,
}

fn project(
    strands: ExactStrands<'_>,
    view_from_world: Mat4,
    clip_from_view: Mat4,
    [width, height]: [u32; 2],
) -> Vec<Projected> {
    let view = view_from_world.as_dmat4();
    let clip = clip_from_view.as_dmat4();
    // Compute pixels per centimetre at unit depth from the projection's vertical focal length.
    let focal_px = clip.y_axis.y * f64::from(height) * 0.5;
    let project = |vertex: &Vec4| {
        let in_view = view.transform_point3(vertex.truncate().as_dvec3());
        let in_clip = clip * in_view.extend(1.0);
        let ndc = in_clip.truncate() / in_clip.w;
        Projected {
            at: DVec2::new((ndc.x * 0.5 + 0.5) * f64::from(width), (0.5 - ndc.y * 0.5) * f64::from(height)),
            depth: -in_view.z,
            half_width: f64::from(vertex.w) * focal_px / -in_view.z,
        }
    };
    strands.vertices.par_iter().map(project).collect()
}

/// Clip every segment against the pixels of some rows.
fn fragments_of_rows(
    strands: ExactStrands<'_>,
    projected: &[Projected],
    first_strand: usize,
    width: usize,
    first_row: usize,
    pixels: &mut [Vec<Fragment>],
) {
    /// Nearer than this the projection says nothing, centimetres.
    const NEAR: f64 = 0.01;
    let n_rows = pixels.len() / width;
    let (top, bottom) = (first_row as f64, (first_row + n_rows) as f64);
    let n = strands.vertices_per_strand;
    for strand_idx in 0..projected.len() / n {
        for segment_idx in 0..n - 1 {
            let vertex_idx = strand_idx * n + segment_idx;
            let (a, b) = (projected[vertex_idx], projected[vertex_idx + 1]);
            let reach = a.half_width.max(b.half_width);
            let outside = a.at.y.max(b.at.y) + reach <= top || a.at.y.min(b.at.y) - reach >= bottom;
            if outside || a.depth < NEAR || b.depth < NEAR || a.at.distance_squared(b.at) < 1e-18 {
                continue;
            }
            let along = (b.at - a.at).normalize();
            let across = DVec2::new(-along.y, along.x);
            let strip = [
                a.at + across * a.half_width,
                a.at - across * a.half_width,
                b.at - across * b.half_width,
                b.at + across * b.half_width,
            ];
            let min = strip.iter().fold(DVec2::MAX, |low, &corner| low.min(corner));
            let max = strip.iter().fold(DVec2::MIN, |high, &corner| high.max(corner));
            let rows = min.y.max(top).floor() as usize..max.y.min(bottom).ceil().max(0.0) as usize;
            for y in rows {
                // Clip once to the row, so that only the row's own columns are visited.
                let in_row = clip(&clip(&strip, DVec2::Y, y as f64), -DVec2::Y, -(y as f64 + 1.0));
                if in_row.len() < 3 {
                    continue;
                }
                let left = in_row.iter().fold(f64::MAX, |low, corner| low.min(corner.x)).max(0.0).floor() as usize;
                let right =
                    in_row.iter().fold(f64::MIN, |high, corner| high.max(corner.x)).min(width as f64).ceil().max(0.0)
                        as usize;
                for x in left..right {
                    let inside = clip(&clip(&in_row, DVec2::X, x as f64), -DVec2::X, -(x as f64 + 1.0));
                    let (area, centre) = area_and_centre(&inside);
                    if area <= 0.0 {
                        continue;
                    }
                    // Compute the place along the segment under the fragment's centre, straight in depth.
                    let t = ((centre - a.at).dot(along) / a.at.distance(b.at)).clamp(0.0, 1.0);
                    let mix = |channel: usize| {
                        f64::from(strands.radiance[vertex_idx][channel]) * (1.0 - t)
                            + f64::from(strands.radiance[vertex_idx + 1][channel]) * t
                    };
                    pixels[(y - first_row) * width + x].push(Fragment {
                        depth: a.depth * (1.0 - t) + b.depth * t,
                        coverage: area * mix(3),
                        colour: [mix(0), mix(1), mix(2)],
                        strand_idx: (first_strand + strand_idx) as u32,
                        segment_idx: segment_idx as u32,
                    });
                }
            }
        }
    }
}

/// Sutherland and Hodgman 1974: the part of a convex polygon where `normal . p >= offset`.
fn clip(polygon: &[DVec2], normal: DVec2, offset: f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (corner_idx, &to) in polygon.iter().enumerate() {
        let from = polygon[(corner_idx + polygon.len() - 1) % polygon.len()];
        let (before, after) = (normal.dot(from) - offset, normal.dot(to) - offset);
        if (before >= 0.0) != (after >= 0.0) {
            kept.push(from + (to - from) * (before / (before - after)));
        }
        if after >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// Area of a polygon and the mean of its corners.
fn area_and_centre(polygon: &[DVec2]) -> (f64, DVec2) {
    if polygon.len() < 3 {
        return (0.0, DVec2::ZERO);
    }
    let n = polygon.len();
    let doubled: f64 = (0..n).map(|i| polygon[i].perp_dot(polygon[(i + 1) % n])).sum();
    (doubled.abs() * 0.5, polygon.iter().copied().sum::<DVec2>() / n as f64)
}

fn composite_pixel(fragments: &mut [Fragment], (surface_depth, surface_coverage): (f64, f64)) -> [f64; 4] {
    // Neighbouring segments of one strand are one piece of hair: their areas add.
    fragments.sort_unstable_by_key(|fragment| (fragment.strand_idx, fragment.segment_idx));
    let mut pieces: Vec<Fragment> = Vec::with_capacity(fragments.len());
    for &fragment in fragments.iter() {
        match pieces.last_mut() {
            Some(piece) if piece.strand_idx == fragment.strand_idx && piece.segment_idx + 1 == fragment.segment_idx => {
                let share = fragment.coverage / (piece.coverage + fragment.coverage).max(1e-300);
                piece.depth += (fragment.depth - piece.depth) * share;
                for channel in 0..3 {
                    piece.colour[channel] += (fragment.colour[channel] - piece.colour[channel]) * share;
                }
                piece.coverage += fragment.coverage;
                piece.segment_idx = fragment.segment_idx;
            }
            _ => pieces.push(fragment),
        }
    }
    pieces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let mut out = [0.0; 4];
    let mut transmittance = 1.0;
    for piece in pieces {
        let open = if piece.depth > surface_depth { 1.0 - surface_coverage } else { 1.0 };
        let alpha = piece.coverage.min(1.0);
        for channel in 0..3 {
            out[channel] += transmittance * open * alpha * piece.colour[channel];
        }
        out[3] += transmittance * open * alpha;
        transmittance *= 1.0 - alpha;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lorelei_core::camera::Camera;

    fn picture(vertices: &[Vec4], radiance: &[[f32; 4]], size: [u32; 2]) -> Vec<[f64; 4]> {
        let camera = Camera { azimuth_deg: 0.0, elevation_deg: 0.0, distance: 50.0, ..Camera::default() };
        let strands = ExactStrands { vertices, vertices_per_strand: 2, radiance };
        let aspect = size[0] as f32 / size[1] as f32;
        composite(&[strands], camera.view_from_world(), camera.clip_from_view(aspect), size, Backdrop::default())
    }

    /// Pixels per centimetre at the target of the test camera.
    fn pixels_per_cm(height: u32) -> f64 {
        f64::from(height) / (2.0 * 50.0 * f64::tan(12f64.to_radians()))
    }

    #[test]
    fn total_coverage_is_the_projected_area() {
        let (a, b, radius) = (Vec3::new(-3.0, -2.5, 0.0), Vec3::new(2.0, 4.0, 0.0), 0.03);
        let pixels = picture(&[a.extend(radius), b.extend(radius)], &[[1.0; 4]; 2], [96, 96]);
        let covered: f64 = pixels.iter().map(|pixel| pixel[3]).sum();
        let expected = f64::from(a.distance(b)) * 2.0 * f64::from(radius) * pixels_per_cm(96).powi(2);
        assert!((covered / expected - 1.0).abs() < 1e-4, "{covered} against {expected}");
    }

    #[test]
    fn nearer_strands_hide_farther_ones_in_any_order() {
        let strand = |z: f32| [Vec4::new(0.0, -9.0, z, 3.0), Vec4::new(0.0, 9.0, z, 3.0)];
        let (red, green) = ([[1.0, 0.0, 0.0, 0.5]; 2], [[0.0, 1.0, 0.0, 0.5]; 2]);
        let red_first = picture(&[strand(5.0), strand(-5.0)].concat(), &[red, green].concat(), [32, 32]);
        let green_first = picture(&[strand(-5.0), strand(5.0)].concat(), &[green, red].concat(), [32, 32]);
        let centre = red_first[16 * 32 + 16];
        assert_eq!(centre, green_first[16 * 32 + 16]);
        for (got, expected) in centre.iter().zip([0.5, 0.25, 0.0, 0.75]) {
            assert!((got - expected).abs() < 1e-9, "{centre:?}");
        }
    }

    #[test]
    fn a_surface_in_front_hides_its_share() {
        let vertices = [Vec4::new(0.0, -9.0, 0.0, 3.0), Vec4::new(0.0, 9.0, 0.0, 3.0)];
        let strands = ExactStrands { vertices: &vertices, vertices_per_strand: 2, radiance: &[[1.0; 4]; 2] };
        let camera = Camera { azimuth_deg: 0.0, elevation_deg: 0.0, distance: 50.0, ..Camera::default() };
        let (depth, coverage) = (vec![10.0; 32 * 32], vec![0.75; 32 * 32]);
        let pixels = composite(
            &[strands],
            camera.view_from_world(),
            camera.clip_from_view(1.0),
            [32, 32],
            Backdrop { depth: &depth, coverage: &coverage },
        );
        assert!((pixels[16 * 32 + 16][3] - 0.25).abs() < 1e-9);
    }
}
