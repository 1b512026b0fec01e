//! The document: plain data, the only thing that is saved and undone.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::hair_mesh::HairMesh;
use crate::io::Space;
use crate::light::{Light, three_point_rig};
use crate::lod::LodSettings;
use crate::look::{AnyChoice, Choice, ChoiceInfo, Look, Param, ParamValue, Slot};
use crate::maps::{MapKind, Maps, ScalpMap};
use crate::mesh::TriMesh;
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
    pub lod: LodSettings,
    pub simulation: SimulationSettings,
}

impl Default for Groom {
    fn default() -> Self {
        Self {
            name: "Untitled".to_owned(),
            head: None,
            layers: Vec::new(),
            lights: three_point_rig(),
            look: Look::default(),
            lod: LodSettings::default(),
            simulation: SimulationSettings::default(),
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

/// What the fibres are made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HairMaterial {
    pub pigment: Pigment,
    /// Concentrations in the units of Chiang et al. 2016 / pbrt: absorption per fibre radius is
    /// eumelanin * (0.419, 0.697, 1.37) + pheomelanin * (0.187, 0.4, 1.05).
    pub eumelanin: f32,
    pub pheomelanin: f32,
    /// Linear RGB of the whole head of hair, for [`Pigment::Colour`].
    pub colour: [f32; 3],
    /// Longitudinal roughness: standard deviation of the R lobe.
    pub beta_m_deg: f32,
    /// Azimuthal roughness, 0-1 as in Chiang et al. 2016.
    pub beta_n: f32,
    /// Tilt of the cuticle scales towards the root.
    pub tilt_deg: f32,
    pub index_of_refraction: f32,
    /// Spread of the colour from strand to strand, 0-1.
    pub colour_variation: f32,
    /// Lighter towards the tip: share of the absorption that is gone there, 0-1.
    pub tip_lightening: f32,
}

/// How the absorption is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Pigment {
    Melanin,
    Colour,
}

impl Choice for Pigment {
    const ALL: &'static [Self] = &[Self::Melanin, Self::Colour];
    fn info(self) -> ChoiceInfo {
        match self {
            Self::Melanin => {
                ChoiceInfo { name: "melanin", label: "Melanin", help: "Eumelanin (brown) and pheomelanin (red)" }
            }
            Self::Colour => ChoiceInfo {
                name: "colour",
                label: "Colour",
                help: "The absorption that gives a head of hair this colour (Chiang et al. 2016)",
            },
        }
    }
}

impl Default for HairMaterial {
    fn default() -> Self {
        Self {
            pigment: Pigment::Melanin,
            eumelanin: 1.3,
            pheomelanin: 0.2,
            colour: [0.25, 0.12, 0.05],
            beta_m_deg: 7.5,
            beta_n: 0.3,
            tilt_deg: 3.0,
            index_of_refraction: 1.55,
            colour_variation: 0.15,
            tip_lightening: 0.15,
        }
    }
}

impl HairMaterial {
    /// Absorption coefficient per fibre radius, RGB.
    pub fn sigma_a(&self) -> Vec3 {
        match self.pigment {
            // pbrt-v4, HairBxDF::SigmaAFromConcentration, after d'Eon et al. 2011.
            Pigment::Melanin => {
                Vec3::new(0.419, 0.697, 1.37) * self.eumelanin + Vec3::new(0.187, 0.4, 1.05) * self.pheomelanin
            }
            // Chiang et al. 2016, eq. 9.
            Pigment::Colour => {
                let b = self.beta_n;
                let d =
                    5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
                Vec3::from_array(self.colour.map(|c| (c.clamp(1e-4, 0.999).ln() / d).powi(2)))
            }
        }
    }

    /// The material's settings as a slot, for panels and `--set`.
    #[rustfmt::skip]
    pub fn slot(&mut self) -> Slot<'_> {
        let number = |key: &str, label, unit, (min, max), value, of, help| Param {
            key: format!("hair.{key}"), label, unit, min, max, of, help, value: ParamValue::F32(value),
        };
        Slot { key: "hair", label: "Hair fibre", help: "What the fibres of a layer are made of", choice: &mut self.pigment as &mut dyn AnyChoice, params: vec![
            number("eumelanin", "Eumelanin", "", (0.0, 10.0), &mut self.eumelanin, &["melanin"] as &'static [&'static str], "Brown pigment: 8 black, 1.3 brown, 0.3 blond"),
            number("pheomelanin", "Pheomelanin", "", (0.0, 10.0), &mut self.pheomelanin, &["melanin"], "Red pigment: 1.5-2 in red hair"),
            Param { key: "hair.colour".to_owned(), label: "Colour", unit: "linear RGB", min: 0.0, max: 1.0, of: &["colour"], help: "Colour of the whole head of hair", value: ParamValue::Colour(&mut self.colour) },
            number("beta_m_deg", "Roughness along", "deg", (1.0, 40.0), &mut self.beta_m_deg, &[], "Width of the highlight along the strand"),
            number("beta_n", "Roughness around", "", (0.05, 1.0), &mut self.beta_n, &[], "Width of the scattering around the strand"),
            number("tilt_deg", "Scale tilt", "deg", (-10.0, 10.0), &mut self.tilt_deg, &[], "Shifts the highlights: white to the root, coloured to the tip"),
            number("ior", "Index of refraction", "", (1.1, 2.2), &mut self.index_of_refraction, &[], "1.55 for hair"),
            number("variation", "Colour variation", "", (0.0, 1.0), &mut self.colour_variation, &[], "From strand to strand"),
            number("tip_lightening", "Tip lightening", "", (0.0, 1.0), &mut self.tip_lightening, &[], "Share of the pigment that is gone at the tip"),
        ] }
    }
}

impl Groom {
    /// Strands of all visible layers at level of detail 1.
    pub fn n_strands(&self) -> usize {
        self.layers.iter().filter(|layer| layer.visible).map(|layer| layer.n_strands as usize).sum()
    }

    /// What in the groom has no effect though it is there, for the user.
    pub fn warnings(&self) -> Vec<String> {
        self.layers.iter().filter_map(Layer::warning).collect()
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
            style: Vec::new(),
            sculpt: Sculpt::default(),
            material: HairMaterial::default(),
            maps: Maps::new(),
            read_as: None,
        }
    }
}
