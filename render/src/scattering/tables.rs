//! The tables of scattering on the GPU: what they are baked from, and that they are baked again, on a thread of their own,
//! when that changes.
//!
//! A picture in full detail waits for its tables, so that it never shows the parameters before the last; a coarse one, while
//! something moves, takes what is there. Models without tables bake nothing and bind an empty texture.

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Look, Marschner2003Params, Scattering};
use lorelei_shaders::Gpu;

use super::azimuthal::{self, Blur, N_LOBES};
use super::cylinder::logistic_scale;
use super::fibre::Fibre;
use super::table::Table;
use super::{deon, marschner_2003};

/// Everything that a material's tables depend on, and nothing else: while it is the same they stay.
#[derive(Debug, Clone, PartialEq)]
pub enum Recipe {
    Nothing,
    /// Lobes blurred around the fibre, over (theta, phi): Chiang's and d'Eon's.
    Rough {
        eta: f32,
        blur: Blur,
        /// The lobes' deviations and tilts, where [`deon::balance`] needs them.
        balanced_for: Option<[[f32; 3]; 2]>,
    },
    /// Marschner's lobes over (theta_d, phi).
    Smooth {
        eta: f32,
        params: Marschner2003Params,
    },
    /// Both tables of the Nalu demo.
    Nalu {
        eta: f32,
        params: Marschner2003Params,
        beta: [f32; 3],
        alpha: [f32; 3],
        sigma_a: [f32; 3],
    },
}

impl Recipe {
    pub fn of(material: &HairMaterial, look: &Look) -> Self {
        let eta = material.index_of_refraction;
        match look.scattering {
            Scattering::KajiyaKay | Scattering::KajiyaKay1989 | Scattering::KajiyaKayHalf | Scattering::Marschner => {
                Self::Nothing
            }
            Scattering::Marschner2003 => Self::Smooth { eta, params: look.marschner_2003.clone() },
            Scattering::Marschner2003Nalu => {
                let fibre = Fibre::new(material, look);
                let params = look.marschner_2003.clone();
                Self::Nalu { eta, params, beta: fibre.beta, alpha: fibre.alpha, sigma_a: fibre.sigma_a }
            }
            Scattering::Deon => {
                let Fibre { beta, alpha, .. } = Fibre::new(material, look);
                Self::Rough { eta, blur: deon::blur(material.beta_n), balanced_for: Some([beta, alpha]) }
            }
            Scattering::Chiang => {
                let blur = Blur::Logistic { s: logistic_scale(material.beta_n) };
                Self::Rough { eta, blur, balanced_for: None }
            }
        }
    }

    /// The same kind of table, so that one may stand in for the other while it is made.
    fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }
}

/// The tables of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// Four, or none.
    pub azimuthal: Vec<Table>,
    pub longitudinal: Option<Table>,
}

impl Baked {
    pub fn new(recipe: &Recipe) -> Self {
        match recipe {
            Recipe::Nothing => Self { azimuthal: Vec::new(), longitudinal: None },
            Recipe::Rough { eta, blur, balanced_for } => {
                let mut azimuthal = azimuthal::bake(*eta, *blur).to_vec();
                if let Some([beta, alpha]) = balanced_for {
                    deon::balance(&mut azimuthal, *beta, *alpha);
                }
                Self { azimuthal, longitudinal: None }
            }
            Recipe::Smooth { eta, params } => {
                Self { azimuthal: marschner_2003::bake_lobes(*eta, params), longitudinal: None }
            }
            Recipe::Nalu { eta, params, beta, alpha, sigma_a } => Self {
                azimuthal: marschner_2003::bake_nalu(*eta, params, Vec3::from_array(*sigma_a)),
                longitudinal: Some(marschner_2003::bake_m(*beta, *alpha)),
            },
        }
    }
}

/// Recipes that a thread is at work on, and where the tables come out.
#[derive(Debug)]
struct Work {
    recipes: Vec<Recipe>,
    made: Receiver<(Vec<Baked>, Duration)>,
}

/// The tables of all layers as textures.
#[derive(Debug)]
pub struct FibreTables {
    azimuthal: wgpu::Texture,
    longitudinal: wgpu::Texture,
    views: [wgpu::TextureView; 2],
    sampler: wgpu::Sampler,
    /// What the textures hold.
    recipes: Vec<Recipe>,
    work: Option<Work>,
    generation: u64,
    bake_time: Duration,
}

impl FibreTables {
    pub fn new(gpu: &Gpu) -> Self {
        let azimuthal = texture(gpu, "scattering.azimuthal", [1, 1, 1]);
        let longitudinal = texture(gpu, "scattering.longitudinal", [1, 1, 1]);
        Self {
            views: [view(&azimuthal), view(&longitudinal)],
            azimuthal,
            longitudinal,
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("scattering.tables"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            recipes: Vec::new(),
            work: None,
            generation: 0,
            bake_time: Duration::ZERO,
        }
    }

    /// By name, for `scatter_tables.wgsl`.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 3] {
        [
            ("fibre_azimuthal", wgpu::BindingResource::TextureView(&self.views[0])),
            ("fibre_longitudinal", wgpu::BindingResource::TextureView(&self.views[1])),
            ("table_sampler", wgpu::BindingResource::Sampler(&self.sampler)),
        ]
    }

    /// Changes when [`FibreTables::resources`] are others than before.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// How long the tables that are in use took to bake, all layers together.
    pub fn bake_time(&self) -> Duration {
        self.bake_time
    }

    /// Where the tables of a layer of strands begin: equal recipes share theirs.
    pub fn layer_of(&self, idx: usize) -> u32 {
        let first = self.recipes.iter().position(|recipe| Some(recipe) == self.recipes.get(idx)).unwrap_or(0);
        (N_LOBES * first) as u32
    }

    /// Have the tables of `recipes`, one a layer; where not `waits`, as soon as they are made, and until then the ones
    /// before, if they are of the same kind.
    pub fn prepare(&mut self, gpu: &Gpu, recipes: &[Recipe], waits: bool) {
        if let Some(work) = &self.work
            && let Ok((baked, took)) = work.made.try_recv()
            && let Some(work) = self.work.take()
        {
            self.take_over(gpu, work.recipes, &baked, took);
        }
        if self.recipes == recipes {
            return;
        }
        let can_wait_for_it =
            self.recipes.len() == recipes.len() && self.recipes.iter().zip(recipes).all(|(old, new)| old.is_like(new));
        if self.work.as_ref().is_none_or(|work| work.recipes != recipes) && (waits || self.work.is_none()) {
            self.work = Some(Work { recipes: recipes.to_vec(), made: bake_elsewhere(recipes.to_vec()) });
        }
        if waits || !can_wait_for_it {
            let Some(work) = self.work.take() else { return };
            // A thread that could not be had leaves the work here.
            let (baked, took) = work.made.recv().unwrap_or_else(|_| bake(recipes));
            self.take_over(gpu, work.recipes, &baked, took);
        }
    }

    fn take_over(&mut self, gpu: &Gpu, recipes: Vec<Recipe>, baked: &[Baked], took: Duration) {
        log::debug!("scattering tables of {} layers baked in {took:.1?}", recipes.len());
        let n_layers = recipes.len().max(1) as u32;
        let azimuthal = baked.iter().find_map(|baked| baked.azimuthal.first());
        let longitudinal = baked.iter().find_map(|baked| baked.longitudinal.as_ref());
        let size = |table: Option<&Table>, each: u32| {
            table.map_or([1, 1, 1], |table| [table.width as u32, table.height as u32, each * n_layers])
        };
        for (texture_of, view_of, name, size) in [
            (&mut self.azimuthal, 0, "scattering.azimuthal", size(azimuthal, N_LOBES as u32)),
            (&mut self.longitudinal, 1, "scattering.longitudinal", size(longitudinal, 1)),
        ] {
            if [texture_of.width(), texture_of.height(), texture_of.depth_or_array_layers()] != size {
                *texture_of = texture(gpu, name, size);
                self.views[view_of] = view(texture_of);
                self.generation += 1;
            }
        }
        for (layer_idx, baked) in baked.iter().enumerate() {
            for (lobe, table) in baked.azimuthal.iter().enumerate() {
                write(gpu, &self.azimuthal, layer_idx * N_LOBES + lobe, table);
            }
            if let Some(table) = &baked.longitudinal {
                write(gpu, &self.longitudinal, layer_idx, table);
            }
        }
        (self.recipes, self.bake_time) = (recipes, took);
    }
}

/// The tables of all recipes; equal ones are baked once and stand where the first does.
fn bake(recipes: &[Recipe]) -> (Vec<Baked>, Duration) {
    let start = Instant::now();
    let nothing = Baked { azimuthal: Vec::new(), longitudinal: None };
    let baked = (recipes.iter().enumerate())
        .map(|(i, recipe)| if recipes[..i].contains(recipe) { nothing.clone() } else { Baked::new(recipe) })
        .collect();
    (baked, start.elapsed())
}

fn bake_elsewhere(recipes: Vec<Recipe>) -> Receiver<(Vec<Baked>, Duration)> {
    let (sender, receiver) = channel();
    let spawned = std::thread::Builder::new().name("scattering tables".to_owned()).spawn(move || {
        // Nobody listens any more where the renderer is gone.
        let _ = sender.send(bake(&recipes));
    });
    if let Err(why) = spawned {
        log::warn!("no thread for the scattering tables: {why}");
    }
    receiver
}

fn texture(gpu: &Gpu, label: &str, [width, height, layers]: [u32; 3]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: width.max(height).ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, layer: usize, table: &Table) {
    for (level, mip) in table.clone().mips().into_iter().enumerate() {
        let halves: Vec<u16> = mip.texels.iter().flatten().map(|&value| half(value)).collect();
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: level as u32,
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(&halves),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(8 * mip.width as u32),
                rows_per_image: Some(mip.height as u32),
            },
            wgpu::Extent3d { width: mip.width as u32, height: mip.height as u32, depth_or_array_layers: 1 },
        );
    }
}

/// A number as a half float, rounded to the nearest; what is too large becomes the largest.
pub(crate) fn half(value: f32) -> u16 {
    // 65,504 is the largest half; scaled by 2^-112 a single's exponent is a half's.
    let scaled = value.abs().min(65_504.0) * f32::from_bits(15 << 23);
    let sign = (value.to_bits() >> 31 << 15) as u16;
    sign | ((scaled.to_bits() + 0x0fff + (scaled.to_bits() >> 13 & 1)) >> 13) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_rounded_to_the_nearest() {
        for (value, bits) in
            [(0.0, 0), (1.0, 0x3c00), (0.1, 0x2e66), (65_504.0, 0x7bff), (1e9, 0x7bff), (6e-8, 1), (-1.5, 0xbe00)]
        {
            assert_eq!(half(value), bits, "{value}");
        }
    }

    #[test]
    fn only_what_a_table_depends_on_bakes_it_again() {
        let (look, material) = (Look { scattering: Scattering::Chiang, ..Look::default() }, HairMaterial::default());
        let recipe = Recipe::of(&material, &look);
        let same = HairMaterial { eumelanin: 0.1, beta_m_deg: 20.0, tilt_deg: 1.0, ..material.clone() };
        assert_eq!(Recipe::of(&same, &Look { weight_r: 0.5, ..look.clone() }), recipe);
        assert_ne!(Recipe::of(&HairMaterial { beta_n: 0.4, ..material }, &look), recipe);
    }

    #[test]
    fn every_model_s_tables_are_finite_and_their_time_is_told() {
        for &scattering in <Scattering as lorelei_core::look::Choice>::ALL {
            let recipe = Recipe::of(&HairMaterial::default(), &Look { scattering, ..Look::default() });
            let (baked, took) = bake(std::slice::from_ref(&recipe));
            println!("{scattering:?}: baked in {took:.1?}");
            for table in baked[0].azimuthal.iter().chain(&baked[0].longitudinal) {
                assert!(table.texels.iter().all(|texel| texel.iter().all(|v| v.is_finite())), "{scattering:?}");
                assert!(table.texels.iter().all(|texel| texel[..3].iter().all(|v| *v >= 0.0)), "{scattering:?}");
            }
        }
    }

    #[test]
    fn a_moving_parameter_keeps_the_old_tables_until_the_new_are_made_and_a_still_picture_waits() {
        let gpu = Gpu::headless().unwrap();
        let mut tables = FibreTables::new(&gpu);
        let of = |eta: f32| [Recipe::Rough { eta, blur: Blur::Logistic { s: 0.2 }, balanced_for: None }];
        // The first are waited for in any case.
        tables.prepare(&gpu, &of(1.5), false);
        assert_eq!(tables.recipes, of(1.5));
        let generation = tables.generation();
        tables.prepare(&gpu, &of(1.6), false);
        assert_eq!(tables.recipes, of(1.5));
        tables.prepare(&gpu, &of(1.6), true);
        assert_eq!(tables.recipes, of(1.6));
        // The same textures hold them: nothing is bound again.
        assert_eq!(tables.generation(), generation);
        assert!(tables.bake_time() > Duration::ZERO);
    }
}
