//! Which format a file is in: by its content first, by its name only where the content says nothing.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::ReadError;
use super::ply;
use super::salon;
use super::source::{Source, Watch};

/// Everything that can be read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Format {
    /// Cem Yuksel's `.hair`.
    Hair,
    /// TressFX 4.
    Tfx,
    /// USC-HairSalon `.data`.
    Data,
    /// CT2Hair `.bin`: as `.data`, with four more numbers a point.
    Bin,
    /// PLY whose vertices come in strands.
    PlyStrands,
    /// PLY with faces.
    PlyMesh,
    Obj,
    /// glTF 2.0, as text or binary.
    Gltf,
    /// USD as text; written only.
    Usda,
    /// Lorelei's own document.
    Lorelei,
}

/// What is inside a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Contents {
    Strands,
    Mesh,
    Document,
}

impl Format {
    pub fn contents(self) -> Contents {
        match self {
            Self::Hair | Self::Tfx | Self::Data | Self::Bin | Self::PlyStrands | Self::Usda => Contents::Strands,
            Self::PlyMesh | Self::Obj | Self::Gltf => Contents::Mesh,
            Self::Lorelei => Contents::Document,
        }
    }

    pub fn label(self) -> &'static str {
        match self {
            Self::Hair => "Cem Yuksel's hair file",
            Self::Tfx => "TressFX file",
            Self::Data => "USC-HairSalon strands",
            Self::Bin => "CT2Hair strands",
            Self::PlyStrands => "PLY strands",
            Self::PlyMesh => "PLY mesh",
            Self::Obj => "OBJ mesh",
            Self::Gltf => "glTF scene",
            Self::Usda => "USD curves",
            Self::Lorelei => "Lorelei document",
        }
    }

    /// The format that a name to be written asks for.
    pub fn of_output(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "hair" => Some(Self::Hair),
            "tfx" => Some(Self::Tfx),
            "data" => Some(Self::Data),
            "usda" => Some(Self::Usda),
            "lorelei" => Some(Self::Lorelei),
            _ => None,
        }
    }
}

/// Extensions that hold strands, for file dialogs.
pub const STRAND_EXTENSIONS: &[&str] = &["hair", "tfx", "data", "bin", "ply"];
/// Extensions that hold heads, for file dialogs.
pub const MESH_EXTENSIONS: &[&str] = &["obj", "glb", "gltf", "ply"];
/// Extensions that strands can be written as.
pub const OUTPUT_EXTENSIONS: &[&str] = &["hair", "tfx", "data", "usda"];

/// What kind of file this is; an error that names what it seems to be where it is none of ours.
pub fn detect(path: &Path) -> Result<Format, ReadError> {
    detect_source(&mut Source::open(path, Watch::default())?)
}

/// Bytes looked at.
const N_START: usize = 4096;

pub(crate) fn detect_source(source: &mut Source<'_>) -> Result<Format, ReadError> {
    let start = source.peek_start(N_START)?;
    let extension = extension(source.path());
    if start.starts_with(b"HAIR") {
        return Ok(Format::Hair);
    }
    if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
        return ply::kind(source);
    }
    if start.starts_with(b"glTF") || (extension == "gltf" && starts_as_json(&start)) {
        return Ok(Format::Gltf);
    }
    // 4.0f32, and arrays that begin no earlier than the header ends.
    if start.starts_with(&4.0f32.to_le_bytes()) && (extension == "tfx" || first_u32(&start, 12) >= Some(160)) {
        return Ok(Format::Tfx);
    }
    if start.starts_with(b"PK\x03\x04") && (extension == "lorelei" || contains(&start, b"manifest.ron")) {
        return Ok(Format::Lorelei);
    }
    if let Some((what, next)) = known_stranger(&start) {
        return Err(source.wrong_kind(format!("is {what}{}", claim(&extension)), next));
    }
    if looks_like_obj(&start) {
        return Ok(Format::Obj);
    }
    let expected = match extension.as_str() {
        "hair" => "a .hair file begins with the letters HAIR",
        "tfx" => "a TressFX file begins with the number 4.0",
        "ply" => "a PLY file begins with the letters ply",
        "glb" => "a GLB file begins with the letters glTF",
        "gltf" => "a .gltf file is JSON and begins with {",
        "lorelei" => "a Lorelei document is a zip archive and begins with the letters PK",
        "obj" => "an OBJ file is text with lines that begin with v and f",
        // No magic number: only the whole file's length can tell.
        _ => return salon::detect(source),
    };
    Err(source.wrong_kind(
        format!("is not what its name says: {expected}"),
        "The file is damaged or has the wrong name: copy or export it again",
    ))
}

/// Lower-case extension of a path, or nothing.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn claim(extension: &str) -> String {
    let is_ours =
        STRAND_EXTENSIONS.contains(&extension) || MESH_EXTENSIONS.contains(&extension) || extension == "lorelei";
    if is_ours { format!(", although it is named .{extension}") } else { String::new() }
}

fn first_u32(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

fn starts_as_json(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    text.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{')
}

/// Formats that are not read, so that the message can name them.
fn known_stranger(start: &[u8]) -> Option<(&'static str, &'static str)> {
    const PICTURE: &str = "Choose a file with strands (.hair, .tfx, .data, .bin, .ply) or a head (.obj, .glb, .ply)";
    const UNREAD: &str = "Export the strands as .hair, .tfx, .data or .ply, or the head as .obj, .glb or .ply";
    const PACKED: &str = "Unpack it and open a file from it";
    let strangers: [(&[u8], &str, &str); 18] = [
        (b"\x89PNG", "a PNG picture", PICTURE),
        (b"\xff\xd8\xff", "a JPEG picture", PICTURE),
        (b"GIF8", "a GIF picture", PICTURE),
        (b"BM", "a BMP picture", PICTURE),
        (b"v/1\x01", "an OpenEXR picture", PICTURE),
        (b"#?RADIANCE", "a Radiance HDR picture", PICTURE),
        (b"II*\0", "a TIFF picture", PICTURE),
        (b"MM\0*", "a TIFF picture", PICTURE),
        (b"%PDF", "a PDF document", PICTURE),
        (b"PK\x03\x04", "a zip archive", PACKED),
        (b"\x1f\x8b", "a gzip archive", PACKED),
        (b"Rar!", "a RAR archive", PACKED),
        (b"7z\xbc\xaf", "a 7-Zip archive", PACKED),
        (b"Ogawa", "an Alembic file, which is not read yet", UNREAD),
        (b"\x89HDF", "an HDF5 file (old Alembic), which is not read", UNREAD),
        (b"PXR-USDC", "a USD file, which is not read yet", UNREAD),
        (b"#usda", "a USD file, which is not read yet", UNREAD),
        (b"Kaydara FBX", "an FBX file, which is not read", UNREAD),
    ];
    if start.starts_with(b"BLENDER") || start.starts_with(b"\x28\xb5\x2f\xfd") {
        return Some(("a Blender or compressed file, which is not read", UNREAD));
    }
    // Two letters are little evidence: a bitmap also repeats its length... of which only zeros are sure.
    if start.starts_with(b"BM") && start.get(6..10) != Some(&[0; 4]) {
        return None;
    }
    strangers.iter().find(|(magic, ..)| start.starts_with(magic)).map(|&(_, what, next)| (what, next))
}

fn looks_like_obj(start: &[u8]) -> bool {
    if start.contains(&0) {
        return false;
    }
    let text = String::from_utf8_lossy(start);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let Some(first) = lines.next() else { return false };
    let word = first.split_whitespace().next().unwrap_or_default();
    matches!(word, "v" | "vn" | "vt" | "vp" | "f" | "l" | "p" | "o" | "g" | "s" | "mtllib" | "usemtl")
}
