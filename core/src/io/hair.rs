//! Cem Yuksel's `.hair`: a 128-byte header, then the arrays that its flags name.
//!
//! Source: the format's own page, <http://www.cemyuksel.com/research/hairmodels/>. Thickness is read as a
//! diameter in the file's unit, and colours as linear RGB: the page leaves both open.

use std::io::{self, Write};

use glam::Vec3;

use super::detect::Format;
use super::error::{Place, ReadError};
use super::import::{RawStrands, StrandImport};
use super::source::Source;
use crate::strands::Strands;

const HEADER_BYTES: u64 = 128;
const HAS_SEGMENTS: u32 = 1;
const HAS_POINTS: u32 = 2;
const HAS_THICKNESS: u32 = 4;
const HAS_TRANSPARENCY: u32 = 8;
const HAS_COLOURS: u32 = 16;

/// What cyHairFile, the format's own library, leaves in the header of files without widths.
const UNSET_THICKNESS: f32 = 1.0;

pub(crate) fn read(source: &mut Source<'_>) -> Result<StrandImport, ReadError> {
    source.seek(4)?;
    let n_strands = u64::from(source.u32("the header")?);
    let n_points = u64::from(source.u32("the header")?);
    let flags = source.u32("the header")?;
    let default_segments = source.u32("the header")?;
    let default_thickness = source.f32("the header")?;
    let default_transparency = source.f32("the header")?;
    let default_colour = [source.f32("the header")?, source.f32("the header")?, source.f32("the header")?];
    source.require(u128::from(HEADER_BYTES - source.offset()), "the header")?;
    source.seek(HEADER_BYTES)?;
    if n_strands == 0 || n_points == 0 {
        return Err(source.nothing(
            format!("holds no hair: its header counts {n_strands} strands and {n_points} points"),
            "Export it again with curves selected",
        ));
    }
    if flags & HAS_POINTS == 0 {
        return Err(source.nothing("holds no points: the header's points flag is off", "Export it again"));
    }

    // Every array is checked against the file's length before the first is read.
    let has = |flag: u32| u128::from(flags & flag != 0);
    let per_point = 12 + 4 * has(HAS_THICKNESS) + 4 * has(HAS_TRANSPARENCY) + 12 * has(HAS_COLOURS);
    let needed = u128::from(n_strands) * 2 * has(HAS_SEGMENTS) + u128::from(n_points) * per_point;
    source.require(needed, &format!("the data of {n_strands} strands and {n_points} points that the header counts"))?;

    let mut raw = RawStrands::default();
    raw.strands.offsets = read_offsets(source, flags, n_strands, n_points, default_segments)?;
    raw.strands.points = source.array::<Vec3>(n_points, "the points")?;
    if flags & HAS_THICKNESS != 0 {
        raw.thickness = source.array(n_points, "the thickness of each point")?;
        raw.attributes.push("thickness");
    } else if default_thickness > 0.0 && default_thickness.is_finite() && default_thickness != UNSET_THICKNESS {
        raw.thickness = source.reserve(n_points)?;
        raw.thickness.resize(n_points as usize, default_thickness);
    }
    if flags & HAS_TRANSPARENCY != 0 {
        raw.strands.opacities = source.array(n_points, "the transparency of each point")?;
        raw.strands.opacities.iter_mut().for_each(|value| *value = 1.0 - *value);
        raw.attributes.push("transparency");
    } else if default_transparency > 0.0 && default_transparency < 1.0 {
        raw.strands.opacities = source.reserve(n_points)?;
        raw.strands.opacities.resize(n_points as usize, 1.0 - default_transparency);
    }
    if flags & HAS_COLOURS != 0 {
        raw.strands.colours = source.array(n_points, "the colour of each point")?;
        raw.attributes.push("colour");
    } else if default_colour.iter().all(|c| (0.0..=1.0).contains(c))
        && default_colour != [1.0; 3]
        && default_colour != [0.0; 3]
    {
        // White and black are what writers leave there who have no colour.
        raw.warnings.push(format!("the file's one colour {default_colour:?} is left to the layer's material"));
    }
    if flags & !31 != 0 {
        raw.warnings
            .push(format!("flags {:#x} in the header are unknown: whatever they announce was not read", flags & !31));
    }
    if source.remaining() > 0 {
        raw.warnings.push(format!("{} bytes after the last array were not read", source.remaining()));
    }
    raw.finish(source, Format::Hair)
}

fn read_offsets(
    source: &mut Source<'_>,
    flags: u32,
    n_strands: u64,
    n_points: u64,
    default_segments: u32,
) -> Result<Vec<u32>, ReadError> {
    let wrong_sum = |source: &Source<'_>, sum: u64| {
        source.corrupt(
            Place::Byte(8),
            format!("has {sum} points by its strands, but {n_points} by its header,"),
            "The file is damaged: export it again",
        )
    };
    if flags & HAS_SEGMENTS == 0 {
        let per_strand = u64::from(default_segments) + 1;
        if n_strands * per_strand != n_points {
            return Err(wrong_sum(source, n_strands * per_strand));
        }
        let mut offsets = source.reserve(n_strands + 1)?;
        offsets.extend((0..=n_strands).map(|strand_idx| (strand_idx * per_strand) as u32));
        return Ok(offsets);
    }
    let n_segments: Vec<u16> = source.array(n_strands, "the segments of each strand")?;
    let sum = n_segments.iter().map(|&n| u64::from(n) + 1).sum();
    if sum != n_points {
        return Err(wrong_sum(source, sum));
    }
    let mut offsets = source.reserve(n_strands + 1)?;
    offsets.push(0u32);
    let mut end = 0;
    offsets.extend(n_segments.iter().map(|&n| {
        end += u32::from(n) + 1;
        end
    }));
    Ok(offsets)
}

/// Most points that a strand can have: segments are u16.
pub(crate) const MAX_POINTS: usize = u16::MAX as usize + 1;

/// Write strands whose points are in the file's numbers already. `diameter_per_um` makes diameters in
/// the file's unit from radii in micrometres.
pub(crate) fn write(out: &mut dyn Write, strands: &Strands, diameter_per_um: f32) -> io::Result<()> {
    let mut flags = HAS_SEGMENTS | HAS_POINTS;
    for (flag, is_there) in [
        (HAS_THICKNESS, !strands.radii_um.is_empty()),
        (HAS_TRANSPARENCY, !strands.opacities.is_empty()),
        (HAS_COLOURS, !strands.colours.is_empty()),
    ] {
        flags |= if is_there { flag } else { 0 };
    }
    let mut header = Vec::with_capacity(HEADER_BYTES as usize);
    header.extend_from_slice(b"HAIR");
    for value in [strands.n_strands() as u32, strands.n_points() as u32, flags, 0] {
        header.extend_from_slice(&value.to_le_bytes());
    }
    // Thickness 0: not given. Transparency 0, white.
    for value in [0.0f32, 0.0, 1.0, 1.0, 1.0] {
        header.extend_from_slice(&value.to_le_bytes());
    }
    header.extend_from_slice(b"Lorelei");
    header.resize(HEADER_BYTES as usize, 0);
    out.write_all(&header)?;
    for strand in strands.iter() {
        out.write_all(&((strand.len() - 1) as u16).to_le_bytes())?;
    }
    out.write_all(bytemuck::cast_slice(&strands.points))?;
    for &radius_um in &strands.radii_um {
        out.write_all(&(radius_um * diameter_per_um).to_le_bytes())?;
    }
    for &opacity in &strands.opacities {
        out.write_all(&(1.0 - opacity).to_le_bytes())?;
    }
    out.write_all(bytemuck::cast_slice(&strands.colours))
}
