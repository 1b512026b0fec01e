//! Strands into other programs' formats: one options struct, one function, and what could not be kept.

use std::io::{self, Write};
use std::path::Path;

use glam::Vec3;

use super::atomic::write_atomically;
use super::detect::Format;
use super::error::WriteError;
use super::groom::default_radius_um;
use super::source::Watch;
use super::space::{Axis, Space, Unit, transform_points};
use super::{hair, salon, tfx, usda};
use crate::strands::{Strands, polyline_length};

/// How strands are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// `None`: what the format's readers expect, centimetres where they do not care.
    pub unit: Option<Unit>,
    /// `None`: Y, except for `.hair`, whose models are Z-up.
    pub up: Option<Axis>,
}

impl WriteOptions {
    fn space(self, format: Format) -> Space {
        let custom = if format == Format::Hair { Axis::Z } else { Axis::Y };
        Space::new(self.unit.unwrap_or(Unit::Centimetre), self.up.unwrap_or(custom))
    }
}

/// Write strands (world space) in the format that the name's extension asks for. Returns warnings: what
/// the format could not hold.
pub fn write_strands(
    path: &Path,
    strands: &Strands,
    options: WriteOptions,
    watch: Watch<'_>,
) -> Result<Vec<String>, WriteError> {
    let refused =
        |problem: String, next: &str| WriteError::Refused { path: path.to_owned(), problem, next: next.to_owned() };
    let Some(format @ (Format::Hair | Format::Tfx | Format::Data | Format::Usda)) = Format::of_output(path) else {
        return Err(refused(
            "strands are not written in a format of this name".to_owned(),
            "Let the name end in .hair, .tfx, .data or .usda",
        ));
    };
    if strands.n_strands() == 0 {
        return Err(refused(
            "there are no strands to write".to_owned(),
            "Make a layer visible, or choose other strands",
        ));
    }
    if let Some(short) = strands.iter().position(|points| points.len() < 2) {
        return Err(refused(format!("strand {short} has fewer than two points"), "Remove it first"));
    }
    if let Some(bad) = strands.points.iter().position(|p| !p.is_finite()) {
        return Err(refused(
            format!("point {bad} is at no place ({})", strands.points[bad]),
            "Reset the simulation first",
        ));
    }
    let mut warnings = Vec::new();
    let space = options.space(format);
    let mut placed = match format {
        Format::Tfx => resampled_for_tfx(strands, &mut warnings),
        _ => strands.clone(),
    };
    transform_points(space.file_from_world(), &mut placed.points);
    let diameter_per_um = 2e-4 / space.unit.in_cm();
    let lost = |name: &str, is_there: bool| is_there.then(|| format!("{name} cannot be kept in this format"));
    match format {
        Format::Hair => {
            if let Some(long) = placed.iter().position(|points| points.len() > hair::MAX_POINTS) {
                return Err(refused(
                    format!(
                        "strand {long} has {} points, and .hair holds {} at most",
                        placed.strand(long).len(),
                        hair::MAX_POINTS
                    ),
                    "Write .usda or .data instead",
                ));
            }
            warnings.extend(lost("root texture coordinates", !placed.root_uvs.is_empty()));
        }
        Format::Tfx => {
            warnings.extend(lost("opacity", !placed.opacities.is_empty()));
            let tapers = placed.offsets.windows(2).any(|o| {
                placed
                    .radii_um
                    .get(o[0] as usize..o[1] as usize)
                    .is_some_and(|r| r.iter().any(|&radius| radius != r[0]))
            });
            if tapers {
                warnings.push("only the width at the root of each strand is kept in this format".to_owned());
            }
            if placed.root_uvs.is_empty() {
                warnings.push("the strands have no root texture coordinates: zeros were written".to_owned());
            }
        }
        Format::Data => {
            warnings.extend(lost("width", !placed.radii_um.is_empty()));
            warnings.extend(lost("colour", !placed.colours.is_empty()));
            warnings.extend(lost("opacity", !placed.opacities.is_empty()));
            warnings.extend(lost("root texture coordinates", !placed.root_uvs.is_empty()));
        }
        Format::Usda if placed.radii_um.is_empty() => {
            let radius_um = default_radius_um(placed.n_strands());
            warnings.push(format!("the strands have no widths: {radius_um:.0} um radius was written for all"));
        }
        _ => {}
    }
    let is_cancelled = std::cell::Cell::new(false);
    let written = write_atomically(path, |out| {
        let mut out =
            Watched { out, watch, n_bytes: 0, told: 0, expected: placed.n_bytes() as u64, is_cancelled: &is_cancelled };
        match format {
            Format::Hair => hair::write(&mut out, &placed, diameter_per_um),
            Format::Tfx => tfx::write(&mut out, &placed, diameter_per_um),
            Format::Data => salon::write(&mut out, &placed),
            _ => usda::write(&mut out, &placed, space, diameter_per_um),
        }
    });
    if is_cancelled.get() {
        return Err(WriteError::Cancelled { path: path.to_owned() });
    }
    written.map(|()| warnings)
}

/// Tells about progress, and stops when cancelled.
struct Watched<'w, W> {
    out: &'w mut W,
    watch: Watch<'w>,
    n_bytes: u64,
    told: u64,
    /// About as many bytes as will be written.
    expected: u64,
    is_cancelled: &'w std::cell::Cell<bool>,
}

impl<W: Write> Write for Watched<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.out.write(bytes)?;
        self.n_bytes += n as u64;
        if self.n_bytes >= self.told + (1 << 20) {
            self.told = self.n_bytes;
            if self.watch.cancelled() {
                self.is_cancelled.set(true);
                return Err(io::Error::other("cancelled"));
            }
            self.watch.progress((self.n_bytes as f32 / self.expected.max(1) as f32).min(1.0));
        }
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Strands of one vertex count that TressFX takes: the smallest that keeps every point where all fit, by
/// equal steps along the strand. Unchanged where they are so already.
fn resampled_for_tfx(strands: &Strands, warnings: &mut Vec<String>) -> Strands {
    let most = strands.iter().map(<[Vec3]>::len).max().unwrap_or(0);
    let n = tfx::VERTEX_COUNTS.into_iter().find(|&n| n >= most).unwrap_or(64);
    if strands.iter().all(|points| points.len() == n) {
        return strands.clone();
    }
    warnings.push(format!(
        "TressFX wants one vertex count that divides 64: strands of up to {most} points were resampled to {n}"
    ));
    let mut out = Strands { ids: strands.ids.clone(), root_uvs: strands.root_uvs.clone(), ..Strands::default() };
    for strand_idx in 0..strands.n_strands() {
        let range = strands.range(strand_idx);
        let points = strands.strand(strand_idx);
        let length = polyline_length(points);
        let (mut gap, mut start) = (0, 0.0);
        for k in 0..n {
            let along = length * k as f32 / (n - 1) as f32;
            let mut step = points[gap].distance(points[gap + 1]);
            while along > start + step && gap + 2 < points.len() {
                start += step;
                gap += 1;
                step = points[gap].distance(points[gap + 1]);
            }
            // The ends are kept exactly.
            let t = match k {
                0 => 0.0,
                _ if k == n - 1 => {
                    gap = points.len() - 2;
                    1.0
                }
                _ if step > 0.0 => ((along - start) / step).clamp(0.0, 1.0),
                _ => 0.0,
            };
            let (a, b) = (range.start + gap, range.start + gap + 1);
            let mix = |x: f32, y: f32| x * (1.0 - t) + y * t;
            let (p, q) = (points[gap], points[gap + 1]);
            out.points.push(Vec3::new(mix(p.x, q.x), mix(p.y, q.y), mix(p.z, q.z)));
            if let (Some(x), Some(y)) = (strands.radii_um.get(a), strands.radii_um.get(b)) {
                out.radii_um.push(mix(*x, *y));
            }
            if let (Some(x), Some(y)) = (strands.opacities.get(a), strands.opacities.get(b)) {
                out.opacities.push(mix(*x, *y));
            }
            if let (Some(x), Some(y)) = (strands.colours.get(a), strands.colours.get(b)) {
                out.colours.push(std::array::from_fn(|c| mix(x[c], y[c])));
            }
        }
        out.offsets.push(out.points.len() as u32);
    }
    out
}
