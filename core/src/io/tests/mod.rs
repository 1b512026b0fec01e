//! Readers and writers on files that the tests make themselves, on bad ones, and on foreign ones.

mod bad_input;
mod foreign;
mod heads;
mod properties;
mod round_trip;

use std::path::PathBuf;

use glam::Vec3;

use super::{Format, StrandImport, WriteOptions, read_strands_from_bytes, write_strands};
use crate::io::Watch;
use crate::strands::Strands;

/// Hair that falls from a scalp of 9 cm radius, as many points a strand as `n_points` gives by index.
fn sample_hair(n_strands: usize, n_points: impl Fn(usize) -> usize) -> Strands {
    let mut strands = Strands::default();
    for strand_idx in 0..n_strands {
        let azimuth = strand_idx as f32 * 2.399_963;
        let y = 1.0 - 0.9 * (strand_idx as f32 + 0.5) / n_strands as f32;
        let n = Vec3::new((1.0 - y * y).sqrt() * azimuth.cos(), y, (1.0 - y * y).sqrt() * azimuth.sin());
        let last = (n_points(strand_idx) - 1) as f32;
        let points: Vec<Vec3> = (0..n_points(strand_idx))
            .map(|k| k as f32 / last)
            .map(|t| 9.0 * n + 5.0 * t * n - Vec3::Y * (16.0 * t * t))
            .collect();
        strands.push(&points);
    }
    strands
}

/// The same with every attribute.
fn with_attributes(mut strands: Strands) -> Strands {
    let n_points = strands.n_points();
    strands.radii_um = (0..n_points).map(|k| 30.0 + (k % 7) as f32).collect();
    strands.colours = (0..n_points).map(|k| [0.1 + (k % 5) as f32 * 0.1, 0.25, 0.125]).collect();
    strands.opacities = (0..n_points).map(|k| 1.0 - (k % 3) as f32 * 0.25).collect();
    strands.root_uvs = (0..strands.n_strands()).map(|k| [k as f32 / 64.0, 0.5]).collect();
    strands
}

/// The bytes of a strand file as Lorelei writes it.
fn written(strands: &Strands, extension: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(format!("sample.{extension}"));
    write_strands(&path, strands, WriteOptions::default(), Watch::default()).expect("the sample is writable");
    std::fs::read(path).expect("it was just written")
}

/// The bytes of a CT2Hair `.bin`, which Lorelei does not write.
fn as_bin(strands: &Strands) -> Vec<u8> {
    let mut bytes = (strands.n_strands() as u32).to_le_bytes().to_vec();
    for strand in strands.iter() {
        bytes.extend((strand.len() as u32).to_le_bytes());
        for p in strand {
            for value in [p.x, p.y, p.z, 0.0, 0.0, 0.0, 0.0] {
                bytes.extend(value.to_le_bytes());
            }
        }
    }
    bytes
}

/// The bytes of PLY strands.
fn as_ply(strands: &Strands, encoding: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement strand {}\nproperty ushort nsegs\nend_header\n",
        strands.n_points(),
        strands.n_strands()
    )
    .into_bytes();
    for p in &strands.points {
        match encoding {
            "ascii" => bytes.extend(format!("{} {} {} 255 0 128\n", p.x, p.y, p.z).bytes()),
            "binary_little_endian" => bytes.extend(p.to_array().iter().flat_map(|v| v.to_le_bytes())),
            _ => bytes.extend(p.to_array().iter().flat_map(|v| v.to_be_bytes())),
        }
        if encoding != "ascii" {
            bytes.extend([255, 0, 128]);
        }
    }
    for strand in strands.iter() {
        let n_segments = (strand.len() - 1) as u16;
        match encoding {
            "ascii" => bytes.extend(format!("{n_segments}\n").bytes()),
            "binary_little_endian" => bytes.extend(n_segments.to_le_bytes()),
            _ => bytes.extend(n_segments.to_be_bytes()),
        }
    }
    bytes
}

/// Every strand format with a small sample of it.
fn samples() -> Vec<(&'static str, Format, Vec<u8>)> {
    let strands = with_attributes(sample_hair(12, |strand_idx| 4 + strand_idx % 3));
    let even = with_attributes(sample_hair(12, |_| 8));
    vec![
        ("a.hair", Format::Hair, written(&strands, "hair")),
        ("a.tfx", Format::Tfx, written(&even, "tfx")),
        ("a.data", Format::Data, written(&strands, "data")),
        ("a.bin", Format::Bin, as_bin(&strands)),
        ("ascii.ply", Format::PlyStrands, as_ply(&strands, "ascii")),
        ("binary.ply", Format::PlyStrands, as_ply(&strands, "binary_little_endian")),
        ("big.ply", Format::PlyStrands, as_ply(&strands, "binary_big_endian")),
    ]
}

fn read(name: &str, bytes: &[u8]) -> Result<StrandImport, String> {
    read_strands_from_bytes(name, bytes).map_err(|error| error.to_string())
}

/// A file of the shared test data, where it is there; says `skipped` where it is not.
fn shared_file(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: {} is not there", path.display());
    None
}
