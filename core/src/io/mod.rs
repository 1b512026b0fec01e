//! Files of other programs in and out: strands and heads.
//!
//! [`read_strands`] and [`read_mesh`] find the format by content, [`import_groom`] makes a document of a
//! strand file and a head that share a space, [`write_strands`] writes what other programs read,
//! [`info`] and [`convert`] are the commands of the same names. Layouts are as published by each format's
//! makers; every reader checks counts and offsets against the file's length before it allocates.

mod atomic;
mod convert;
mod detect;
mod error;
mod glb;
mod gltf_mesh;
pub mod gltf_motion;
mod groom;
mod guess;
mod hair;
mod hair_mesh;
mod import;
mod info;
mod obj;
mod ply;
mod ply_body;
mod ply_header;
mod reread;
mod salon;
mod source;
mod space;
mod tfx;
mod usda;
mod write;

#[cfg(test)]
mod tests;

use std::path::Path;

pub use atomic::write_atomically;
pub use convert::{ConvertError, ConvertOptions, Converted, What, convert, strands_of, strands_of_watched};
pub use detect::{Contents, Format, MESH_EXTENSIONS, OUTPUT_EXTENSIONS, STRAND_EXTENSIONS, detect};
pub use error::{Place, ReadError, WriteError};
pub use glb::to_glb;
pub use groom::{GroomImport, ImportOptions, groom_of, import_groom};
pub use guess::Guess;
pub use hair_mesh::{HAIR_MESH_EXTENSIONS, HairMeshImport, read_hair_mesh, write_hair_mesh};
pub use import::{MeshImport, PlacedStrands, StrandImport};
pub use info::{Info, InfoError, info};
pub use reread::reread;
pub(crate) use source::Source;
pub use source::Watch;
pub(crate) use source::usable_memory;
pub use space::{Axis, Space, Unit};
pub use write::{WriteOptions, write_strands};

/// Read strands in whichever format they are.
pub fn read_strands(path: &Path, watch: Watch<'_>) -> Result<StrandImport, ReadError> {
    strands_from(&mut Source::open(path, watch)?)
}

/// Read strands from memory; `name` stands for the path in errors, and its extension helps as a file's would.
pub fn read_strands_from_bytes(name: &str, bytes: &[u8]) -> Result<StrandImport, ReadError> {
    strands_from(&mut Source::from_bytes(name, bytes, Watch::default())?)
}

/// Read a head's mesh in whichever format it is.
pub fn read_mesh(path: &Path, watch: Watch<'_>) -> Result<MeshImport, ReadError> {
    mesh_from(&mut Source::open(path, watch)?)
}

/// Read a mesh from memory; `name` stands for the path in errors, and its extension helps as a file's would.
pub fn read_mesh_from_bytes(name: &str, bytes: &[u8]) -> Result<MeshImport, ReadError> {
    mesh_from(&mut Source::from_bytes(name, bytes, Watch::default())?)
}

fn strands_from(source: &mut Source<'_>) -> Result<StrandImport, ReadError> {
    let format = detect::detect_source(source)?;
    source.rewind()?;
    match format {
        Format::Hair => hair::read(source),
        Format::Tfx => tfx::read(source),
        Format::Data | Format::Bin => salon::read(source, format),
        Format::PlyStrands => ply::read_strands(source),
        Format::PlyMesh | Format::Obj | Format::Gltf => Err(source.wrong_kind(
            format!("holds a mesh ({}), not strands", format.label()),
            "Open it as the head, and a file with strands beside it",
        )),
        Format::Lorelei | Format::Usda => Err(source.wrong_kind(
            format!("is a {}, not a strand file", format.label()),
            "Open it as a document instead of importing it",
        )),
    }
}

fn mesh_from(source: &mut Source<'_>) -> Result<MeshImport, ReadError> {
    let format = detect::detect_source(source)?;
    source.rewind()?;
    match format {
        Format::PlyMesh => ply::read_mesh(source),
        Format::Obj => obj::read(source),
        Format::Gltf => gltf_mesh::read(source),
        Format::Hair | Format::Tfx | Format::Data | Format::Bin | Format::PlyStrands => Err(source.wrong_kind(
            format!("holds strands ({}), not a mesh", format.label()),
            "Open it as hair; a head is read from .obj, .gltf, .glb or .ply",
        )),
        Format::Lorelei | Format::Usda => Err(source.wrong_kind(
            format!("is a {}, not a mesh", format.label()),
            "A head is read from .obj, .gltf, .glb or .ply",
        )),
    }
}
