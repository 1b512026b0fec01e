//! What is rendered: the default look, and for each slot the look with another choice there.

use std::path::{Path, PathBuf};

use glam::{Affine3A, Vec3};
use image::RgbaImage;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, HairMaterial};
use lorelei_core::look::{Look, Slot, Transparency};
use lorelei_render::{FrameInput, Renderer};
use lorelei_shaders::{Gpu, ShaderLibrary};

const SIZE: [u32; 2] = [256, 256];

/// One golden image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Case {
    /// `default`, or `SLOT=CHOICE`.
    pub name: String,
    /// The slot's place in the list of all slots, and the choice's in the slot.
    change: Option<(usize, usize)>,
}

impl Case {
    /// Its picture in `folder`.
    pub fn path(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.png", self.name.replace('=', "-is-")))
    }

    /// Pixels mix the strands that touch them, and do not choose among them.
    pub fn is_blended(&self) -> bool {
        match self.groom().look.transparency {
            Transparency::FrontToBack
            | Transparency::WeightedAverage
            | Transparency::Sorted
            | Transparency::HalfAngle
            | Transparency::DepthPeeling
            | Transparency::Occupancy
            | Transparency::KNearest => true,
            Transparency::Opaque
            | Transparency::AlphaTest
            | Transparency::Hashed
            | Transparency::AlphaToCoverage
            | Transparency::Stochastic
            | Transparency::ThreeSubsets => false,
        }
    }

    /// The choice is another way to the default's picture: how strands are drawn, or what order they come in.
    pub fn is_another_way(&self) -> bool {
        let slot = self.name.split('=').next().unwrap_or_default();
        let look = self.groom().look;
        let is_ordered = match look.transparency {
            Transparency::FrontToBack
            | Transparency::Sorted
            | Transparency::HalfAngle
            | Transparency::DepthPeeling
            | Transparency::Occupancy
            | Transparency::KNearest
            // Right on average.
            | Transparency::Stochastic
            | Transparency::WeightedAverage => true,
            Transparency::Opaque
            | Transparency::AlphaTest
            | Transparency::Hashed
            | Transparency::AlphaToCoverage | Transparency::ThreeSubsets => false,
        };
        let draws = ["primitive", "antialiasing", "rate"].contains(&slot);
        draws || (slot == "transparency" && is_ordered)
    }

    /// The choice answers the question as the default does, by another formula: a picture of brown hair in a room differs
    /// by less than machines may. That the formulas differ is for the tests beside them.
    pub fn is_subtle(&self) -> bool {
        ["fresnel=", "offsets=", "scattering=marschner-2003", "hair=absorption"]
            .iter()
            .any(|start| self.name.starts_with(start))
    }

    fn groom(&self) -> Groom {
        let mut groom = super::groom::groom();
        if let Some((slot_idx, choice_idx)) = self.change {
            let Groom { look, layers, .. } = &mut groom;
            slots(look, &mut layers[0].material)[slot_idx].choice.set_index(choice_idx);
        }
        groom
    }
}

/// Every slot that a still picture shows.
pub fn slots<'a>(look: &'a mut Look, material: &'a mut HairMaterial) -> Vec<Slot<'a>> {
    let mut slots = look.slots();
    slots.push(material.slot());
    slots
}

/// The default look first, then every choice that is not the default's.
pub fn all() -> Vec<Case> {
    let (mut look, mut material) = (Look::default(), HairMaterial::default());
    let mut cases = vec![Case { name: "default".to_owned(), change: None }];
    for (slot_idx, slot) in slots(&mut look, &mut material).iter().enumerate() {
        for (choice_idx, info) in slot.choice.infos().iter().enumerate() {
            if choice_idx != slot.choice.index() {
                let name = format!("{}={}", slot.key, info.name);
                cases.push(Case { name, change: Some((slot_idx, choice_idx)) });
            }
        }
    }
    cases
}

/// A renderer that renders case after case.
pub struct Studio {
    renderer: Renderer,
}

impl Studio {
    pub fn new(gpu: &Gpu) -> Result<Self, String> {
        let renderer = Renderer::new(gpu, ShaderLibrary::embedded()).map_err(|why| why.to_string())?;
        Ok(Self { renderer })
    }

    /// The picture of one case, straight alpha.
    pub fn render(&mut self, case: &Case) -> Result<RgbaImage, String> {
        let failed = |why: &dyn std::fmt::Display| format!("{}: {why}", case.name);
        self.renderer.set_groom(&case.groom()).map_err(|why| failed(&why))?;
        let camera = Camera { target: Vec3::new(0.0, 1.0, 0.0), distance: 80.0, ..Camera::default() };
        let world_from_head = Affine3A::IDENTITY;
        let input =
            FrameInput { camera: &camera, size: SIZE, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
        let pixels = self.renderer.render_pixels(&input).map_err(|why| failed(&why))?;
        let [width, height] = pixels.size;
        RgbaImage::from_raw(width, height, pixels.rgba).ok_or_else(|| failed(&"the picture has too few bytes"))
    }
}
