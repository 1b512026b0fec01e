//! The exact optical depth of the hair between a place and a light, in f64 on the CPU: what every shadow technique is
//! measured against.
//!
//! A place sees the light through a small disc across the way; every piece of every other strand that is nearer to the
//! light covers a share of the disc, and the shares add. Nothing is sorted, since a sum has no order. exp(-sum) is the
//! light that is left where strands cover the disc independently of each other, as all techniques have it. A line without
//! width was rejected: light through a head of hair is then all or nothing, and what is measured is noise.

use glam::{DVec2, DVec3, Vec4};

use crate::scene::SceneLight;

/// A layer's strands: world position and radius in centimetres, strand after strand.
#[derive(Debug, Clone, Copy)]
pub struct Occluders<'a> {
    pub vertices: &'a [Vec4],
    pub vertices_per_strand: usize,
}

struct Segment {
    a: DVec3,
    b: DVec3,
    width: f64,
    strand_idx: u32,
}

/// All segments of all strands as a light sees them, in a grid over the light's picture.
pub struct ExactShadow {
    view: LightView,
    segments: Vec<Segment>,
    /// Lower corner and cells a unit of the grid.
    corner: DVec2,
    cells_per_unit: f64,
    n_cells: [usize; 2],
    /// Of each cell, where its segments begin; one more at the end.
    starts: Vec<u32>,
    of_cell: Vec<u32>,
}

/// From the world to (picture, depth): parallel or perspective.
#[derive(Clone, Copy)]
struct LightView {
    origin: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    is_point: bool,
}

impl LightView {
    fn new(light: &SceneLight, middle: DVec3) -> Self {
        let place = DVec3::from(glam::Vec3::from_slice(&light.place[..3]));
        let is_point = light.place[3] != 0.0;
        let forward = if is_point { (middle - place).normalize() } else { -place };
        let (right, up) = forward.any_orthonormal_pair();
        Self { origin: if is_point { place } else { DVec3::ZERO }, right, up, forward, is_point }
    }

    /// Right, up, depth, centimetres.
    fn view(&self, p: DVec3) -> DVec3 {
        let p = p - self.origin;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    /// Scale of what is at a depth.
    fn scale(&self, depth: f64) -> f64 {
        if self.is_point { 1.0 / depth.max(1e-3) } else { 1.0 }
    }

    fn picture(&self, view: DVec3) -> DVec2 {
        view.truncate() * self.scale(view.z)
    }
}

impl ExactShadow {
    /// `footprint_cm`: radius of the disc at a place; the same for every look-up.
    pub fn new(layers: &[Occluders<'_>], light: &SceneLight, middle: DVec3, footprint_cm: f64) -> Self {
        let view = LightView::new(light, middle);
        let mut segments = Vec::new();
        let mut strand_idx = 0;
        for layer in layers {
            for strand in layer.vertices.chunks_exact(layer.vertices_per_strand) {
                for ends in strand.windows(2) {
                    segments.push(Segment {
                        a: view.view(ends[0].truncate().as_dvec3()),
                        b: view.view(ends[1].truncate().as_dvec3()),
                        width: f64::from(ends[0].w) + f64::from(ends[1].w),
                        strand_idx,
                    });
                }
                strand_idx += 1;
            }
        }
        let nearest = segments.iter().map(|s| s.a.z.min(s.b.z)).fold(f64::INFINITY, f64::min);
        // The widest that a footprint is in the picture.
        let reach = footprint_cm * view.scale(nearest);
        let cells_per_unit = 0.5 / reach;
        let bounds = |s: &Segment| {
            let (a, b) = (view.picture(s.a), view.picture(s.b));
            (a.min(b) - reach, a.max(b) + reach)
        };
        let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (a, b) in segments.iter().map(bounds) {
            (lo, hi) = (lo.min(a), hi.max(b));
        }
        let n_cells = [0, 1].map(|axis| (((hi - lo)[axis] * cells_per_unit) as usize + 1).min(1 << 12));
        let cells_of = |s: &Segment| {
            let (a, b) = bounds(s);
            let range = [0, 1].map(|axis| {
                let cell = |x: f64| (((x - lo[axis]) * cells_per_unit) as usize).min(n_cells[axis] - 1);
                cell(a[axis])..=cell(b[axis])
            });
            let [columns, rows] = range;
            rows.flat_map(move |y| columns.clone().map(move |x| y * n_cells[0] + x))
        };
        let mut starts = vec![0_u32; n_cells[0] * n_cells[1] + 1];
        for segment in &segments {
            cells_of(segment).for_each(|cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let mut of_cell = vec![0; starts[starts.len() - 1] as usize];
        for (segment_idx, segment) in segments.iter().enumerate() {
            for cell in cells_of(segment) {
                of_cell[next[cell] as usize] = segment_idx as u32;
                next[cell] += 1;
            }
        }
        Self { view, segments, corner: lo, cells_per_unit, n_cells, starts, of_cell }
    }

    /// Optical depth before a place on a strand (its index over all layers; `None`: on none), through a disc of
    /// `footprint_cm`.
    pub fn optical_depth(&self, place: DVec3, strand_idx: Option<u32>, footprint_cm: f64) -> f64 {
        let place = self.view.view(place);
        let at = self.view.picture(place);
        let radius = footprint_cm * self.view.scale(place.z);
        let cell = (at - self.corner) * self.cells_per_unit;
        if cell.min_element() < 0.0 || cell.x as usize >= self.n_cells[0] || cell.y as usize >= self.n_cells[1] {
            return 0.0;
        }
        let cell = cell.y as usize * self.n_cells[0] + cell.x as usize;
        let in_cell = &self.of_cell[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        let shares = in_cell.iter().map(|&segment_idx| {
            let segment = &self.segments[segment_idx as usize];
            if strand_idx == Some(segment.strand_idx) {
                return 0.0;
            }
            let Some((a, b)) = nearer_part(segment.a, segment.b, place.z) else { return 0.0 };
            let length = length_in_disc(self.view.picture(a) - at, self.view.picture(b) - at, radius);
            length * segment.width * self.view.scale(0.5 * (a.z + b.z))
        });
        shares.sum::<f64>() / (std::f64::consts::PI * radius * radius)
    }
}

/// The part of a segment whose depth is less than `depth`.
fn nearer_part(a: DVec3, b: DVec3, depth: f64) -> Option<(DVec3, DVec3)> {
    let (near, far) = if a.z < b.z { (a, b) } else { (b, a) };
    if near.z >= depth {
        return None;
    }
    let share = if far.z > depth { (depth - near.z) / (far.z - near.z) } else { 1.0 };
    Some((near, near.lerp(far, share)))
}

/// Length of the part of a segment that is inside a disc around 0.
fn length_in_disc(a: DVec2, b: DVec2, radius: f64) -> f64 {
    let along = b - a;
    let length2 = along.length_squared();
    if length2 < 1e-24 {
        return 0.0;
    }
    // |a + t along|^2 = radius^2
    let half = a.dot(along) / length2;
    let root2 = half * half - (a.length_squared() - radius * radius) / length2;
    if root2 <= 0.0 {
        return 0.0;
    }
    let root = root2.sqrt();
    ((root - half).min(1.0) - (-root - half).max(0.0)).max(0.0) * length2.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneLights;
    use glam::Vec3;
    use lorelei_core::light::{Light, LightKind};

    #[test]
    fn a_slab_of_strands_has_the_depth_of_its_area() {
        // 40 sheets of parallel strands, 0.05 cm apart, 0.004 cm thick: 0.08 of each sheet is covered.
        let mut vertices = Vec::new();
        for sheet in 0..40 {
            for k in 0..200 {
                let (y, z) = (0.05 * k as f32 - 5.0 + 0.013 * (sheet % 4) as f32, 0.1 * sheet as f32);
                vertices.extend([Vec4::new(-5.0, y, z, 0.002), Vec4::new(5.0, y, z, 0.002)]);
            }
        }
        let strands = Occluders { vertices: &vertices, vertices_per_strand: 2 };
        let key = Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3]);
        let lamp = Light { kind: LightKind::Point { position: Vec3::new(0.0, 0.0, 200.0) }, ..key.clone() };
        for (light, tolerance) in [(key, 0.01), (lamp, 0.03)] {
            let light = SceneLights::new(&[light]).lights[0];
            let exact = ExactShadow::new(&[strands], &light, DVec3::ZERO, 0.3);
            for (z, n_sheets) in [(3.95, 0.0), (2.95, 10.0), (-1.0, 40.0)] {
                let tau = exact.optical_depth(DVec3::new(0.3, 0.2, z), None, 0.3);
                assert!((tau - 0.08 * n_sheets).abs() <= tolerance * 3.2, "{z}: {tau}");
            }
        }
    }

    #[test]
    fn a_strand_does_not_shadow_itself() {
        let vertices = [Vec4::new(0.0, -1.0, 1.0, 0.01), Vec4::new(0.0, 1.0, 1.0, 0.01)];
        let strands = Occluders { vertices: &vertices, vertices_per_strand: 2 };
        let light = SceneLights::new(&[Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3])]).lights[0];
        let exact = ExactShadow::new(&[strands], &light, DVec3::ZERO, 0.1);
        assert_eq!(exact.optical_depth(DVec3::ZERO, Some(0), 0.1), 0.0);
        // Its width over the disc's mean chord.
        let tau = exact.optical_depth(DVec3::ZERO, None, 0.1);
        assert!((tau - 0.2 * 0.02 / (std::f64::consts::PI * 0.01)).abs() < 1e-6, "{tau}");
    }
}
