//! From what a person names to a groom: an embedded hairstyle, a document, or hair of another program. The
//! window and the command line open the same things in the same way.

use std::path::Path;
use std::sync::Arc;

use lorelei_core::document::DocumentError;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::hair_mesh::HairMesh;
use lorelei_core::io::{self, Contents, GroomImport, ImportOptions, ReadError, Watch};

/// A groom with what is to be told about it.
#[derive(Debug)]
pub struct Opened {
    pub groom: Groom,
    pub notes: Vec<String>,
    /// How unit and axes were found; empty for documents.
    pub space_reason: String,
    /// It came from a `.lorelei` file, so that is where it is saved.
    pub is_document: bool,
}

#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    #[error(transparent)]
    Document(#[from] DocumentError),
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(
        "{0} is a mesh, not hair: give it with --head, beside a groom or hair; in the window, import it as the head"
    )]
    IsMesh(String),
}

impl OpenError {
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Document(why) => why.is_cancelled(),
            Self::Read(why) => why.is_cancelled(),
            Self::IsMesh(_) => false,
        }
    }
}

/// The embedded hairstyle that is meant by `path`: its name, and no file of that name.
pub fn hairstyle_named(path: &Path) -> Option<&'static str> {
    let name = path.to_str()?;
    let mut keys = lorelei_assets::hairstyle_names().iter().copied().chain([lorelei_assets::BARE]);
    keys.find(|key| *key == name && !path.exists())
}

/// Open a file or an embedded hairstyle, with another head where one is given.
pub fn open(path: &Path, head: Option<&Path>, options: ImportOptions, watch: Watch<'_>) -> Result<Opened, OpenError> {
    let named = hairstyle_named(path).and_then(lorelei_assets::hairstyle);
    let contents = if named.is_some() { Contents::Document } else { io::detect(path)?.contents() };
    match contents {
        Contents::Document => {
            let is_document = named.is_none();
            let (mut groom, mut notes) = match named {
                Some(groom) => (groom, Vec::new()),
                None => document(path, watch)?,
            };
            if let Some(head) = head {
                notes.extend(put_on(&mut groom, head, watch)?);
            }
            Ok(Opened { groom, notes, space_reason: String::new(), is_document })
        }
        Contents::Strands => {
            let GroomImport { groom, space_reason, warnings, .. } = io::import_groom(path, head, options, watch)?;
            Ok(Opened { groom, notes: warnings, space_reason, is_document: false })
        }
        Contents::Mesh => Err(OpenError::IsMesh(path.display().to_string())),
    }
}

/// Read a document; a head that it only names is put in.
pub fn document(path: &Path, watch: Watch<'_>) -> Result<(Groom, Vec<String>), DocumentError> {
    let mut groom = lorelei_core::document::open_watched(path, watch)?;
    let notes = lorelei_assets::complete(&mut groom).into_iter().collect();
    Ok((groom, notes))
}

/// Read polygons as a layer with a hair mesh that stands on `head`, with what was found in the file.
pub fn hair_mesh_layer(
    path: &Path,
    head: &Head,
    options: ImportOptions,
    watch: Watch<'_>,
) -> Result<(Layer, Vec<String>), ReadError> {
    let import = io::read_hair_mesh(path, Some(&head.mesh), options, watch)?;
    let mut notes = vec![import.space_reason];
    notes.extend(import.found);
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let layer = Layer { read_as: Some(import.space), ..Layer::new(&name, Source::HairMesh(Arc::new(import.mesh))) };
    Ok((layer, notes))
}

/// The hair mesh of the chosen layer, or the first that there is.
pub fn hair_mesh_of(groom: &Groom, layer_idx: Option<usize>) -> Option<&HairMesh> {
    let of_layer = |layer: &'_ Layer| match &layer.source {
        Source::HairMesh(_) => true,
        Source::Guides(_) | Source::Strands(_) => false,
    };
    let chosen = layer_idx.and_then(|layer_idx| groom.layers.get(layer_idx)).filter(|layer| of_layer(layer));
    match &chosen.or_else(|| groom.layers.iter().find(|layer| of_layer(layer)))?.source {
        Source::HairMesh(mesh) => Some(mesh),
        Source::Guides(_) | Source::Strands(_) => None,
    }
}

/// Replace the head by a mesh from a file. Returns warnings.
pub fn put_on(groom: &mut Groom, path: &Path, watch: Watch<'_>) -> Result<Vec<String>, ReadError> {
    let (head, notes) = read_head(path, watch)?;
    groom.head = Some(head);
    Ok(notes)
}

/// Read a mesh as a head, with how it was read and warnings.
pub fn read_head(path: &Path, watch: Watch<'_>) -> Result<(Head, Vec<String>), ReadError> {
    let import = io::read_mesh(path, watch)?;
    let mut notes = vec![format!("Read as {}", import.space_reason)];
    notes.extend(import.warnings.iter().cloned());
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((Head { read_as: Some(import.space), ..Head::new(name, import.place()) }, notes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saved_hairstyle_is_small_and_opens_with_its_head() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bob.lorelei");
        let groom = lorelei_assets::hairstyle("bob").unwrap();
        lorelei_core::document::save(&groom, &path).unwrap();
        // The head's mesh alone would be a megabyte.
        assert!(std::fs::metadata(&path).unwrap().len() < 400_000);
        let opened = open(&path, None, ImportOptions::default(), Watch::default()).unwrap();
        assert!(opened.groom == groom && opened.is_document);
    }

    #[test]
    fn a_name_opens_an_embedded_style_unless_a_file_is_called_that() {
        let opened = open(Path::new("curls"), None, ImportOptions::default(), Watch::default()).unwrap();
        assert!(opened.groom == lorelei_assets::hairstyle("curls").unwrap() && !opened.is_document);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("curls"), b"not hair").unwrap();
        assert_eq!(hairstyle_named(&folder.path().join("curls")), None);
        assert!(open(Path::new("mullet"), None, ImportOptions::default(), Watch::default()).is_err());
    }
}
