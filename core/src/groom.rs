//! The document: plain data, the only thing that is saved and undone.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::edit::Edit;
use crate::hair_mesh::HairMesh;
use crate::io::Space;
use crate::light::{Light, three_point_rig};
use crate::lod::LodSettings;
use crate::look::{Background, Environment, Look, Param, ParamValue, Surroundings};
use crate::maps::{MapKind, Maps, ScalpMap};
pub use crate::material::{HairMaterial, HairPreset, Pigment};
use crate::mesh::TriMesh;
use crate::motion::Movement;
use crate::panorama::{Panorama, embedded::embedded};
use crate::sculpt::Sculpt;
use crate::simulation::SimulationSettings;
use crate::strands::Strands;
use crate::style::{StyleOp, left_out};

/// A hairstyle on a head, with its lights, look and movement. Camera and window layout are not in it.
///
/// Large parts are behind `Arc`: a clone is cheap, and `Arc::ptr_eq` tells what changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Groom {
    pub name: String,
    pub head: Option<Head>,
    pub layers: Vec<Layer>,
    pub lights: Vec<Light>,
    pub look: Look,
    /// What is all around, where it was loaded from a file; the look says whether it is used.
    pub panorama: Option<Arc<Panorama>>,
    pub lod: LodSettings,
    pub simulation: SimulationSettings,
    /// What happens on the timeline.
    pub movement: Movement,
}

impl Default for Groom {
    fn default() -> Self {
        Self {
            name: "Untitled".to_owned(),
            head: None,
            layers: Vec::new(),
            lights: three_point_rig(),
            look: Look::default(),
            panorama: None,
            lod: LodSettings::default(),
            simulation: SimulationSettings::default(),
            movement: Movement::default(),
        }
    }
}

/// The body that hair grows on, hides behind and collides with.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Head {
    pub name: String,
    pub mesh: Arc<TriMesh>,
    /// What the file's numbers were taken for, where the head was imported: `io::reread` changes it.
    pub read_as: Option<Space>,
    /// Which of the studio's own heads this is. A document then holds this name instead of the mesh, so the
    /// mesh is empty until whoever opens the document puts it in.
    pub embedded: Option<String>,
}

impl Head {
    pub fn new(name: impl Into<String>, mesh: impl Into<Arc<TriMesh>>) -> Self {
        Self { name: name.into(), mesh: mesh.into(), read_as: None, embedded: None }
    }
}

/// Strands that share a source, a style and a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layer {
    pub name: String,
    pub visible: bool,
    pub source: Source,
    /// Strands at level of detail 1, counted as `count` says. For [`Source::Strands`]: how many there are.
    pub n_strands: u32,
    pub count: StrandCount,
    /// 4-128.
    pub vertices_per_strand: u32,
    /// Radius at the root, micrometres.
    pub radius_um: f32,
    /// Radius at the tip as a share of the root's.
    pub tip_radius: f32,
    pub seed: u32,
    /// Share of every strand, from the root, that is tied: it stays with the style while the rest moves, 0-1. Where the map
    /// of ties says more, that counts.
    #[serde(default)]
    pub tied: f32,
    pub style: Vec<StyleOp>,
    /// What brushes did, above the style.
    pub sculpt: Sculpt,
    pub material: HairMaterial,
    /// Painted maps over the scalp's texture coordinates; a kind that is not there is everywhere its default.
    pub maps: Maps,
    /// What the file's numbers were taken for, where the strands were imported: `io::reread` changes it.
    pub read_as: Option<Space>,
}

/// What a layer's number of strands counts where density is painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum StrandCount {
    /// As many as there would be with full density everywhere: painting density adds and takes away strands,
    /// and moves none.
    #[default]
    WhereFull,
    /// All that there are: density only says where.
    Total,
}

/// Where a layer's strands come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Source {
    /// Bundles of a hair mesh; strands by mean value coordinates.
    HairMesh(Arc<HairMesh>),
    /// Imported or placed guides; strands by interpolation of the nearest three.
    Guides(Arc<Strands>),
    /// Strands as they were imported, each its own guide.
    Strands(Arc<Strands>),
}

impl Source {
    /// Whether this is the very same source, and not only an equal one: told by where it is, since comparing hundreds
    /// of megabytes of strands would take longer than drawing them.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::HairMesh(a), Self::HairMesh(b)) => Arc::ptr_eq(a, b),
            (Self::Guides(a), Self::Guides(b)) | (Self::Strands(a), Self::Strands(b)) => Arc::ptr_eq(a, b),
            (Self::HairMesh(_) | Self::Guides(_) | Self::Strands(_), _) => false,
        }
    }
}

impl Groom {
    /// Strands of all visible layers at level of detail 1.
    pub fn n_strands(&self) -> usize {
        self.layers.iter().filter(|layer| layer.visible).map(|layer| layer.n_strands as usize).sum()
    }

    /// What in the groom has no effect though it is there, for the user.
    pub fn warnings(&self) -> Vec<String> {
        self.layers.iter().filter_map(Layer::warning).chain(self.lacks_panorama()).collect()
    }

    /// That the look asks for a picture from a file and there is none, for the user.
    pub fn lacks_panorama(&self) -> Option<String> {
        let look = &self.look;
        let is_pictured = look.environment.is_pictured() || look.background == Background::Environment;
        let lacks = is_pictured && look.environment_picture.picture == Surroundings::File && self.panorama.is_none();
        lacks.then(|| {
            "the environment is to come from a file, and none is loaded: the studio's stands in for it. Load a .hdr or \
             .exr, or choose another picture"
                .to_owned()
        })
    }

    /// The edit that lights the groom with a picture from a file, as one step: by harmonics, unless the look takes its light
    /// from a picture already.
    pub fn lit_by(&self, panorama: Panorama) -> Edit {
        let mut look = self.look.clone();
        look.environment_picture.picture = Surroundings::File;
        if !look.environment.is_pictured() {
            look.environment = Environment::Harmonics;
        }
        Edit::Batch(vec![Edit::SetPanorama(Some(Arc::new(panorama))), Edit::SetLook(Box::new(look))])
    }

    /// The picture that the look's environment is; the studio's where it is to be a file's and none is loaded.
    pub fn surroundings(&self) -> Arc<Panorama> {
        let choice = self.look.environment_picture.picture;
        let studio = || embedded(Surroundings::Studio).unwrap_or_default();
        embedded(choice).or_else(|| self.panorama.clone()).unwrap_or_else(studio)
    }
}

impl Default for Layer {
    /// A layer without strands.
    fn default() -> Self {
        Self::new("Layer", Source::Strands(Arc::default()))
    }
}

impl Layer {
    /// Counts and widths, for the outliner's panel.
    #[rustfmt::skip]
    pub fn params(&mut self) -> Vec<Param<'_>> {
        let given = matches!(self.source, Source::Strands(_));
        let mut params = vec![
            Param { key: "layer.vertices".to_owned(), label: "Vertices a strand", unit: "", min: 4.0, max: 128.0, of: &[], help: "Smoothness of every strand", value: ParamValue::U32(&mut self.vertices_per_strand) },
            Param { key: "layer.radius".to_owned(), label: "Radius", unit: "\u{b5}m", min: 5.0, max: 500.0, of: &[], help: "At the root; 25-50 is human hair", value: ParamValue::F32(&mut self.radius_um) },
            Param { key: "layer.tip".to_owned(), label: "Tip", unit: "of the root", min: 0.0, max: 1.0, of: &[], help: "Radius at the tip as a share of the root's", value: ParamValue::F32(&mut self.tip_radius) },
            Param { key: "layer.seed".to_owned(), label: "Seed", unit: "", min: 0.0, max: 9999.0, of: &[], help: "Another seed, another head of hair of the same style", value: ParamValue::U32(&mut self.seed) },
            Param { key: "layer.tied".to_owned(), label: "Tied", unit: "of the strand", min: 0.0, max: 1.0, of: &[], help: "Share of every strand, from the root, that stays with the style while the rest moves: up to a band, a pin, a braid", value: ParamValue::F32(&mut self.tied) },
        ];
        if !given {
            params.insert(0, Param { key: "layer.strands".to_owned(), label: "Strands", unit: "", min: 1.0, max: 1_000_000.0, of: &[], help: "At level of detail 1", value: ParamValue::U32(&mut self.n_strands) });
        }
        params
    }

    /// What of the layer has no effect though it is there, for the user.
    pub fn warning(&self) -> Option<String> {
        Some(format!("{}: {}", self.name, left_out(&self.style)?))
    }

    /// The painted density; `None` is everywhere full.
    pub fn density(&self) -> Option<&Arc<ScalpMap>> {
        self.maps.get(&MapKind::Density)
    }

    /// A layer of strands as imported, at the width of average hair.
    pub fn from_strands(name: &str, strands: Strands) -> Self {
        Self { n_strands: strands.n_strands() as u32, ..Self::new(name, Source::Strands(Arc::new(strands))) }
    }

    pub fn new(name: &str, source: Source) -> Self {
        Self {
            name: name.to_owned(),
            visible: true,
            source,
            n_strands: 100_000,
            count: StrandCount::WhereFull,
            vertices_per_strand: 32,
            radius_um: 40.0,
            tip_radius: 0.3,
            seed: 0,
            tied: 0.0,
            style: Vec::new(),
            sculpt: Sculpt::default(),
            material: HairMaterial::default(),
            maps: Maps::new(),
            read_as: None,
        }
    }
}
