//! `.data` (USC-HairSalon) and `.bin` (CT2Hair): a strand count, then each strand's point count and points.
//!
//! Neither has a magic number. They differ in four floats after each point of a `.bin`; so the file is
//! walked from count to count, and the layout that ends exactly at the file's end is the right one.

use std::io::{self, Write};

use glam::Vec3;

use super::detect::{Format, extension};
use super::error::{Place, ReadError};
use super::import::{RawStrands, StrandImport};
use super::source::Source;
use crate::strands::Strands;

/// Floats a point.
const DATA_FLOATS: u64 = 3;
const BIN_FLOATS: u64 = 7;

/// Which of the two a file is, by its length.
pub(crate) fn detect(source: &mut Source<'_>) -> Result<Format, ReadError> {
    let is_bin = extension(source.path()) == "bin";
    let (expected, floats, other, other_floats) = if is_bin {
        (Format::Bin, BIN_FLOATS, Format::Data, DATA_FLOATS)
    } else {
        (Format::Data, DATA_FLOATS, Format::Bin, BIN_FLOATS)
    };
    let Err(error) = walk(source, floats) else { return Ok(expected) };
    if error.is_cancelled() {
        return Err(error);
    }
    if walk(source, other_floats).is_ok() {
        return Ok(other);
    }
    if is_bin || extension(source.path()) == "data" {
        return Err(error);
    }
    Err(source.wrong_kind(
        "is in no format that is known here",
        "Strands are read from .hair, .tfx, .data, .bin and .ply, heads from .obj, .gltf, .glb and .ply",
    ))
}

/// The offsets of all strands, read from count to count without reading a point.
fn walk(source: &mut Source<'_>, floats: u64) -> Result<Vec<u32>, ReadError> {
    const NEXT: &str = "The file is damaged, or is not what its name says: copy or export it again";
    source.rewind()?;
    let n_strands = source.u32("the strand count")?;
    // A strand takes four bytes at least: its count.
    source.require(u128::from(n_strands) * 4, &format!("the {n_strands} strands that it counts at its beginning"))?;
    let mut offsets: Vec<u32> = source.reserve(u64::from(n_strands) + 1)?;
    offsets.push(0);
    let mut n_points = 0u64;
    for strand_idx in 0..u64::from(n_strands) {
        let count_at = source.offset();
        let n = source.u32("a strand's point count")?;
        let n_bytes = u64::from(n) * floats * 4;
        if n_bytes > source.remaining() {
            return Err(source.corrupt(
                Place::Strand(strand_idx, None),
                format!(
                    "counts {n} points at byte {count_at} ({n_bytes} bytes), but {} bytes are left,",
                    source.remaining()
                ),
                NEXT,
            ));
        }
        n_points += u64::from(n);
        let Ok(end) = u32::try_from(n_points) else {
            return Err(source.wrong_kind("has more than 4 billion points", "Split the groom into several files"));
        };
        offsets.push(end);
        source.seek(source.offset() + n_bytes)?;
    }
    if source.remaining() > 0 {
        let left = source.remaining();
        return Err(source.corrupt(
            Place::Byte(source.offset()),
            format!("has {left} bytes more than its {n_strands} strands take,"),
            NEXT,
        ));
    }
    Ok(offsets)
}

pub(crate) fn read(source: &mut Source<'_>, format: Format) -> Result<StrandImport, ReadError> {
    let floats = if format == Format::Bin { BIN_FLOATS } else { DATA_FLOATS };
    let mut raw = RawStrands::default();
    raw.strands.offsets = walk(source, floats)?;
    source.rewind()?;
    source.u32("the strand count")?;
    let n_points = raw.strands.offsets.last().copied().unwrap_or(0);
    raw.strands.points = source.reserve(u64::from(n_points))?;
    if format == Format::Bin {
        raw.warnings.push("the four extra numbers of each point have no known meaning and were left out".to_owned());
    }
    let mut row = [0.0f32; BIN_FLOATS as usize];
    for strand_idx in 0..raw.strands.n_strands() {
        source.u32("a strand's point count")?;
        if format == Format::Data {
            let range = raw.strands.range(strand_idx);
            raw.strands.points.resize(range.end, Vec3::ZERO);
            source.fill(&mut raw.strands.points[range], "points")?;
            continue;
        }
        for _ in raw.strands.range(strand_idx) {
            source.fill(&mut row, "points")?;
            raw.strands.points.push(Vec3::from_slice(&row));
        }
    }
    raw.finish(source, format)
}

/// Write `.data`; points are in the file's numbers already.
pub(crate) fn write(out: &mut dyn Write, strands: &Strands) -> io::Result<()> {
    out.write_all(&(strands.n_strands() as u32).to_le_bytes())?;
    for strand in strands.iter() {
        out.write_all(&(strand.len() as u32).to_le_bytes())?;
        out.write_all(bytemuck::cast_slice(strand))?;
    }
    Ok(())
}
