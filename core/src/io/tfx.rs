//! TressFX 4 `.tfx`: a 160-byte header of offsets, then arrays; every strand has as many vertices.
//!
//! Source: `TressFXFileFormat.h` of AMD's TressFX 4.1. Its strand thickness is read as a diameter in the
//! file's unit, or in proportion where no hair is that wide (TressFX itself takes it as a factor).

use std::io::{self, Write};

use glam::{Vec3, Vec4};

use super::detect::Format;
use super::error::{Place, ReadError};
use super::import::{RawStrands, StrandImport};
use super::source::Source;
use crate::strands::Strands;

const HEADER_BYTES: u32 = 160;

pub(crate) fn read(source: &mut Source<'_>) -> Result<StrandImport, ReadError> {
    source.require(u128::from(HEADER_BYTES), "the header")?;
    let version = source.f32("the header")?;
    if version != 4.0 {
        return Err(source.wrong_kind(
            format!("is a TressFX file of version {version}, and only version 4 is read"),
            "Export it with the TressFX 4 exporter",
        ));
    }
    let mut next = || source.u32("the header").map(u64::from);
    let (n_strands, n_vertices) = (next()?, next()?);
    let [positions_at, strand_uvs_at, vertex_uvs_at, thickness_at, colours_at] =
        [next()?, next()?, next()?, next()?, next()?];
    if n_strands == 0 || n_vertices == 0 {
        return Err(source.nothing(
            format!("holds no hair: its header counts {n_strands} strands of {n_vertices} vertices"),
            "Export it again with curves selected",
        ));
    }
    let n_points = u128::from(n_strands) * u128::from(n_vertices);
    seek_array(source, positions_at, n_points * 16, "the vertex positions")?;
    if n_points > u128::from(u32::MAX) {
        return Err(source.wrong_kind("has more than 4 billion points", "Split the groom into several files"));
    }
    let n_points = n_points as u64;

    let mut raw = RawStrands::default();
    raw.strands.points = source.reserve(n_points)?;
    let mut row = vec![Vec4::ZERO; n_vertices as usize];
    for _ in 0..n_strands {
        source.fill(&mut row, "vertex positions")?;
        raw.strands.points.extend(row.iter().map(|p| p.truncate()));
    }
    raw.strands.offsets = source.reserve(n_strands + 1)?;
    raw.strands.offsets.extend((0..=n_strands).map(|strand_idx| (strand_idx * n_vertices) as u32));

    if strand_uvs_at != 0 {
        seek_array(source, strand_uvs_at, u128::from(n_strands) * 8, "strand texture coordinates")?;
        raw.strands.root_uvs = source.array(n_strands, "strand texture coordinates")?;
        raw.attributes.push("root_uv");
        if n_strands > 1 && raw.strands.root_uvs.iter().all(|uv| *uv == raw.strands.root_uvs[0]) {
            raw.strands.root_uvs = Vec::new();
            raw.warnings.push("all strand texture coordinates are the same: taken as not given".to_owned());
        }
    } else if vertex_uvs_at != 0 {
        seek_array(source, vertex_uvs_at, u128::from(n_points) * 8, "vertex texture coordinates")?;
        raw.strands.root_uvs = source.reserve(n_strands)?;
        let mut row = vec![[0.0f32; 2]; n_vertices as usize];
        for _ in 0..n_strands {
            source.fill(&mut row, "vertex texture coordinates")?;
            raw.strands.root_uvs.push(row[0]);
        }
        raw.attributes.push("root_uv");
    }
    if thickness_at != 0 {
        seek_array(source, thickness_at, u128::from(n_strands) * 4, "strand thickness")?;
        raw.thickness = source.reserve(n_points)?;
        for _ in 0..n_strands {
            let value = source.f32("strand thickness")?;
            raw.thickness.extend(std::iter::repeat_n(value, n_vertices as usize));
        }
        raw.attributes.push("thickness");
    }
    if colours_at != 0 {
        seek_array(source, colours_at, u128::from(n_points) * 16, "vertex colours")?;
        raw.strands.colours = source.reserve(n_points)?;
        for _ in 0..n_strands {
            source.fill(&mut row, "vertex colours")?;
            raw.strands.colours.extend(row.iter().map(|c| c.truncate().to_array()));
        }
        raw.attributes.push("colour");
    }
    raw.finish(source, Format::Tfx)
}

fn seek_array(source: &mut Source<'_>, at: u64, n_bytes: u128, part: &str) -> Result<(), ReadError> {
    if at < u64::from(HEADER_BYTES) || at > source.n_bytes() {
        return Err(source.corrupt(
            Place::Byte(12),
            format!(
                "says that its {part} begin at byte {at}, outside the file's data ({HEADER_BYTES}..{}),",
                source.n_bytes()
            ),
            "The header is damaged: export the file again",
        ));
    }
    source.seek(at)?;
    source.require(n_bytes, part)
}

/// Vertices per strand that TressFX takes: more than 2, dividing its 64 threads.
pub(crate) const VERTEX_COUNTS: [usize; 4] = [8, 16, 32, 64];

/// Write strands of one vertex count whose points are in the file's numbers already.
pub(crate) fn write(out: &mut dyn Write, strands: &Strands, diameter_per_um: f32) -> io::Result<()> {
    let (n_strands, n_points) = (strands.n_strands() as u64, strands.n_points() as u64);
    let n_vertices = n_points / n_strands.max(1);
    // Offsets are multiples of 8, as the format's header asks.
    let aligned = |at: u64| at.next_multiple_of(8);
    let uvs_at = u64::from(HEADER_BYTES) + n_points * 16;
    let thickness_at = aligned(uvs_at + n_strands * 8);
    let after_thickness = if strands.radii_um.is_empty() { thickness_at } else { thickness_at + n_strands * 4 };
    let colours_at = aligned(after_thickness);
    let end = if strands.colours.is_empty() { colours_at } else { colours_at + n_points * 16 };
    if u32::try_from(end).is_err() {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "a .tfx file cannot be larger than 4 GiB"));
    }
    let mut header = Vec::with_capacity(HEADER_BYTES as usize);
    header.extend_from_slice(&4.0f32.to_le_bytes());
    let or_none = |at: u64, is_there: bool| if is_there { at as u32 } else { 0 };
    for value in [
        n_strands as u32,
        n_vertices as u32,
        HEADER_BYTES,
        uvs_at as u32,
        0,
        or_none(thickness_at, !strands.radii_um.is_empty()),
        or_none(colours_at, !strands.colours.is_empty()),
    ] {
        header.extend_from_slice(&value.to_le_bytes());
    }
    header.resize(HEADER_BYTES as usize, 0);
    out.write_all(&header)?;
    for strand in strands.iter() {
        for (vertex_idx, &point) in strand.iter().enumerate() {
            // w is the inverse mass: the root is pinned.
            let w = if vertex_idx == 0 { 0.0 } else { 1.0 };
            out.write_all(bytemuck::bytes_of(&point.extend(w)))?;
        }
    }
    for strand_idx in 0..strands.n_strands() {
        // TressFX reads them without asking whether they are there.
        let uv = strands.root_uvs.get(strand_idx).copied().unwrap_or_default();
        out.write_all(bytemuck::bytes_of(&uv))?;
    }
    let mut at = uvs_at + n_strands * 8;
    if !strands.radii_um.is_empty() {
        pad(out, &mut at, thickness_at)?;
        for strand_idx in 0..strands.n_strands() {
            let root_radius_um = strands.radii_um[strands.range(strand_idx).start];
            out.write_all(&(root_radius_um * diameter_per_um).to_le_bytes())?;
        }
        at += n_strands * 4;
    }
    if !strands.colours.is_empty() {
        pad(out, &mut at, colours_at)?;
        for &colour in &strands.colours {
            out.write_all(bytemuck::bytes_of(&Vec3::from_array(colour).extend(1.0)))?;
        }
    }
    Ok(())
}

fn pad(out: &mut dyn Write, at: &mut u64, to: u64) -> io::Result<()> {
    out.write_all(&[0; 8][..(to - *at) as usize])?;
    *at = to;
    Ok(())
}
