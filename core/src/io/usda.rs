//! USD BasisCurves as text (`.usda`): cubic Catmull-Rom with pinned ends, so that curves pass through
//! their points and end at them.
//!
//! No normals: they would make ribbons of the curves. Widths are diameters, one a vertex. Source: the USD
//! glossary and schema documentation of UsdGeomBasisCurves, <https://openusd.org/release/>.

use std::io::{self, Write};

use glam::Vec3;

use super::groom::default_radius_um;
use super::space::{Axis, Space, Unit};
use crate::strands::Strands;

/// Write strands whose points are in the file's numbers already.
pub(crate) fn write(out: &mut dyn Write, strands: &Strands, space: Space, diameter_per_um: f32) -> io::Result<()> {
    let metres_per_unit = match space.unit {
        Unit::Millimetre => "0.001",
        Unit::Centimetre => "0.01",
        Unit::Inch => "0.0254",
        Unit::Metre => "1",
    };
    // USD knows Y and Z only.
    let up = if space.up == Axis::Z { "Z" } else { "Y" };
    writeln!(
        out,
        "#usda 1.0\n(\n    defaultPrim = \"Hair\"\n    doc = \"Written by Lorelei\"\n    metersPerUnit = {metres_per_unit}\n    \
         upAxis = \"{up}\"\n)\n\ndef Xform \"Hair\" (\n    kind = \"component\"\n)\n{{\n    def BasisCurves \"Strands\"\n    {{"
    )?;
    writeln!(out, "        uniform token type = \"cubic\"")?;
    writeln!(out, "        uniform token basis = \"catmullRom\"")?;
    writeln!(out, "        uniform token wrap = \"pinned\"")?;
    write!(out, "        int[] curveVertexCounts = [")?;
    list(out, strands.iter(), |out, points| write!(out, "{}", points.len()))?;
    // Without widths a renderer would take its own, often a whole unit.
    let constant_um = default_radius_um(strands.n_strands());
    let widest = strands.radii_um.iter().copied().reduce(f32::max).unwrap_or(constant_um) * diameter_per_um;
    // As USD computes it: the box of the points, grown by the widest radius.
    let (min, max) = strands.bounds().unwrap_or_default();
    let grown = [min - Vec3::splat(0.5 * widest), max + Vec3::splat(0.5 * widest)];
    write!(out, "]\n        float3[] extent = [")?;
    list(out, grown.iter(), |out, p| tuple(out, &p.to_array()))?;
    write!(out, "]\n        point3f[] points = [")?;
    list(out, strands.points.iter(), |out, p| tuple(out, &p.to_array()))?;
    writeln!(out, "]")?;
    if strands.radii_um.is_empty() {
        writeln!(
            out,
            "        float[] widths = [{}] (\n            interpolation = \"constant\"\n        )",
            constant_um * diameter_per_um
        )?;
    } else {
        write!(out, "        float[] widths = [")?;
        list(out, strands.radii_um.iter(), |out, radius_um| write!(out, "{}", radius_um * diameter_per_um))?;
        writeln!(out, "] (\n            interpolation = \"vertex\"\n        )")?;
    }
    if !strands.colours.is_empty() {
        write!(out, "        color3f[] primvars:displayColor = [")?;
        list(out, strands.colours.iter(), |out, colour| tuple(out, colour))?;
        writeln!(out, "] (\n            interpolation = \"vertex\"\n        )")?;
    }
    if !strands.opacities.is_empty() {
        write!(out, "        float[] primvars:displayOpacity = [")?;
        list(out, strands.opacities.iter(), |out, opacity| write!(out, "{opacity}"))?;
        writeln!(out, "] (\n            interpolation = \"vertex\"\n        )")?;
    }
    if !strands.root_uvs.is_empty() {
        write!(out, "        texCoord2f[] primvars:st = [")?;
        list(out, strands.root_uvs.iter(), |out, uv| tuple(out, uv))?;
        writeln!(out, "] (\n            interpolation = \"uniform\"\n        )")?;
    }
    writeln!(out, "    }}\n}}")
}

fn list<T>(
    out: &mut dyn Write,
    values: impl Iterator<Item = T>,
    mut one: impl FnMut(&mut dyn Write, T) -> io::Result<()>,
) -> io::Result<()> {
    for (idx, value) in values.enumerate() {
        if idx > 0 {
            out.write_all(b", ")?;
        }
        one(out, value)?;
    }
    Ok(())
}

/// Rust's shortest decimal form gives back the same f32.
fn tuple(out: &mut dyn Write, values: &[f32]) -> io::Result<()> {
    out.write_all(b"(")?;
    list(out, values.iter(), |out, value| write!(out, "{value}"))?;
    out.write_all(b")")
}
