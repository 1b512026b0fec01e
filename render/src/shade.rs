//! Outgoing radiance of every strand vertex, once a frame: single scattering of each light past what shadows it,
//! multiple scattering, and the environment.
//!
//! Which formulas run is decided when the kernel is linked ([`crate::slot`]); a kernel is kept for each combination that
//! was used, so that switching back costs nothing.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Environment, Look, MultipleScattering, Scattering, Shadowing, Switch};
use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::mirror::StrandBuffers;
use crate::scattering::Fibre;
use crate::scattering::tables::{FibreTables, Recipe};
use crate::scene::SceneBuffers;
use crate::shadow::Shadow;
use crate::slot;

/// Twin of `LayerFibre` in `shade_layers.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct LayerFibre {
    fibre: Fibre,
    first_vertex: u32,
    first_strand: u32,
    n_strands: u32,
    vertices_per_strand: u32,
}

/// What stands in for the slots that `shade_point` asks, for any kernel that shades; what they bind comes from
/// [`Shade::resources`], [`SceneBuffers::resources`] and [`Shadow::resources`].
pub fn links(look: &Look) -> Vec<Link<'static>> {
    let mut links = slot::lobes(look).to_vec();
    links.extend([
        slot::scattering(look.scattering),
        slot::multiple_scattering(look.multiple_scattering),
        slot::environment(look.environment),
    ]);
    links.extend(slot::shadowing(look.shadowing));
    links
}

/// What decides which kernel runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Choices {
    scattering: Scattering,
    lobes: [Switch; 3],
    multiple: MultipleScattering,
    environment: Environment,
    shadowing: Shadowing,
}

impl Choices {
    fn of(look: &Look) -> Self {
        Self {
            scattering: look.scattering,
            lobes: [look.lobe_r, look.lobe_tt, look.lobe_trt],
            multiple: look.multiple_scattering,
            environment: look.environment,
            shadowing: look.shadowing,
        }
    }
}

/// What the bindings were made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BoundTo {
    choices: Choices,
    strands_generation: u64,
    shadow_generation: u64,
    n_layers: usize,
}

/// What a frame shades.
#[derive(Clone, Copy)]
pub struct ShadeInput<'a> {
    pub strands: &'a StrandBuffers,
    pub look: &'a Look,
    /// After [`SceneBuffers::update`], and what that returned.
    pub scene: &'a SceneBuffers,
    pub scene_is_new: bool,
    /// After [`Shadow::prepare`].
    pub shadow: &'a Shadow,
    /// The picture is worth waiting for tables that a parameter's move made stale; see [`FibreTables::prepare`].
    pub waits: bool,
}

/// The shading pass with its result.
pub struct Shade {
    kernels: HashMap<Choices, Hot<Kernel>>,
    radiance: wgpu::Buffer,
    /// What each drawn layer's fibres are made of, and room for how many layers.
    fibres: wgpu::Buffer,
    n_fibres: usize,
    tables: FibreTables,
    layers: Vec<Bindings>,
    bound_to: Option<BoundTo>,
    generation: u64,
}

impl Shade {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernels: HashMap::new(),
            radiance: gpu.buffer("shade.radiance", 0, BufferUsages::STORAGE),
            fibres: gpu.buffer("shade.fibres", 0, BufferUsages::STORAGE),
            n_fibres: 0,
            tables: FibreTables::new(gpu),
            layers: Vec::new(),
            bound_to: None,
            generation: 0,
        }
    }

    /// `array<vec2<u32>>`: four half floats a vertex, linear radiance and opacity, indexed like the vertices.
    pub fn radiance(&self) -> &wgpu::Buffer {
        &self.radiance
    }

    /// What a kernel that calls `shade_point` binds of the shading itself, by name: `fibres` holds the material of every
    /// drawn layer, see `shade_layers.wgsl`; the tables of scattering come along.
    pub fn resources(&self) -> Vec<(&'static str, wgpu::BindingResource<'_>)> {
        let mut resources = vec![("fibres", self.fibres.as_entire_binding())];
        resources.extend(self.tables.resources());
        resources
    }

    /// How long the scattering tables in use took to bake; 0 where the model has none.
    pub fn bake_time(&self) -> std::time::Duration {
        self.tables.bake_time()
    }

    /// Changes when [`Shade::radiance`] or one of [`Shade::resources`] is another than before.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Why a shader that was edited is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.values().find_map(Hot::error)
    }

    /// Make everything fit the frame. `material_of` maps [`crate::mirror::DrawnLayer::material`] to a material.
    pub fn prepare<'m>(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        input: &ShadeInput<'_>,
        material_of: impl Fn(u32) -> &'m HairMaterial,
    ) -> Result<(), ShaderError> {
        let &ShadeInput { strands, look, scene, scene_is_new, shadow, waits } = input;
        let choices = Choices::of(look);
        let make = |library: &ShaderLibrary| library.kernel(gpu, "shade", "shade", &[], &links(look));
        let mut is_stale = scene_is_new | Hot::have(&mut self.kernels, library, &choices, make)?;

        let n_bytes = u64::from(strands.n_vertices) * 8;
        if self.radiance.size() < n_bytes {
            self.radiance = gpu.buffer("shade.radiance", n_bytes, BufferUsages::STORAGE);
            self.generation += 1;
            is_stale = true;
        }
        if self.n_fibres != strands.layers.len() {
            self.n_fibres = strands.layers.len();
            let n_bytes = self.n_fibres * size_of::<LayerFibre>();
            self.fibres =
                gpu.buffer_of("shade.fibres", &vec![0u8; n_bytes.max(size_of::<LayerFibre>())], BufferUsages::STORAGE);
            self.generation += 1;
            is_stale = true;
        }
        let recipes: Vec<Recipe> =
            strands.layers.iter().map(|layer| Recipe::of(material_of(layer.material), look)).collect();
        let before = self.tables.generation();
        self.tables.prepare(gpu, &recipes, waits);
        if self.tables.generation() != before {
            self.generation += 1;
            is_stale = true;
        }
        let bound_to = BoundTo {
            choices,
            strands_generation: strands.generation,
            shadow_generation: shadow.generation(),
            n_layers: strands.layers.len(),
        };
        if is_stale || self.bound_to != Some(bound_to) {
            let kernel = &self.kernels[&choices];
            self.layers.clear();
            for layer_idx in 0..strands.layers.len() as u32 {
                let uniform = gpu.buffer_of("shade.layer", &[layer_idx, 0, 0, 0], BufferUsages::UNIFORM);
                let mut resources = vec![
                    ("shade_layer", uniform.as_entire_binding()),
                    ("vertices", strands.vertices.as_entire_binding()),
                    ("seeds", strands.seeds.as_entire_binding()),
                    ("radiance", self.radiance.as_entire_binding()),
                ];
                resources.extend(self.resources());
                resources.extend(scene.resources());
                resources.extend(shadow.resources());
                self.layers.push(kernel.bind_used(gpu, &resources)?);
            }
            self.bound_to = Some(bound_to);
        }
        let fibres: Vec<LayerFibre> = strands
            .layers
            .iter()
            .enumerate()
            .map(|(idx, layer)| LayerFibre {
                fibre: Fibre { table: self.tables.layer_of(idx), ..Fibre::new(material_of(layer.material), look) },
                first_vertex: layer.first_vertex,
                first_strand: layer.first_strand,
                n_strands: layer.n_strands,
                vertices_per_strand: layer.vertices_per_strand,
            })
            .collect();
        gpu.queue.write_buffer(&self.fibres, 0, bytemuck::cast_slice(&fibres));
        Ok(())
    }

    /// Record the pass.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, strands: &StrandBuffers) {
        let Some(kernel) = self.bound_to.and_then(|bound_to| self.kernels.get(&bound_to.choices)) else { return };
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("shade"), timestamp_writes: None });
        for (layer, bindings) in strands.layers.iter().zip(&self.layers) {
            if layer.n_strands > 0 {
                kernel.dispatch_items(&mut pass, bindings, layer.n_strands * layer.vertices_per_strand);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use lorelei_core::light::Light;

    use super::*;
    use crate::environment::lit::{self, Open};
    use crate::environment::{EnvironmentUniform, Harmonics, lights_of};
    use crate::mirror::DrawnLayer;
    use crate::scattering::multiple::multiple;
    use crate::scattering::volume::volume;
    use crate::scattering::{Directions, marschner};
    use crate::scene::SceneLights;
    use lorelei_core::look::Surroundings;
    use lorelei_core::panorama::Panorama;
    use lorelei_core::panorama::embedded::embedded;

    fn half(bits: u32) -> f32 {
        let (sign, exponent, mantissa) = (bits >> 15 & 1, bits >> 10 & 31, bits & 1023);
        let magnitude = if exponent == 0 {
            mantissa as f32 * 2f32.powi(-24)
        } else {
            (1.0 + mantissa as f32 / 1024.0) * 2f32.powi(exponent as i32 - 15)
        };
        if sign == 1 { -magnitude } else { magnitude }
    }

    /// Radiance of the middle of one strand along x, seen from +Z at 100 cm, unshadowed.
    fn radiance(look: &Look, material: &HairMaterial, lights: &[Light]) -> [f32; 4] {
        radiance_in(look, material, lights, &EnvironmentUniform::dark())
    }

    /// The same in a picture's light.
    fn radiance_in(
        look: &Look,
        material: &HairMaterial,
        lights: &[Light],
        surroundings: &EnvironmentUniform,
    ) -> [f32; 4] {
        let gpu = Gpu::headless().unwrap();
        let library = ShaderLibrary::embedded();
        let vertices: Vec<[f32; 4]> = (0..9).map(|k| [k as f32 - 4.0, 0.0, 0.0, 0.004]).collect();
        let strands = StrandBuffers {
            vertices: gpu.buffer_of("test.vertices", &vertices, BufferUsages::STORAGE),
            seeds: gpu.buffer_of("test.seeds", &[[0x8080_8080u32, 1f32.to_bits()]], BufferUsages::STORAGE),
            layers: vec![DrawnLayer {
                first_vertex: 0,
                first_strand: 0,
                n_strands: 1,
                vertices_per_strand: 9,
                material: 0,
            }],
            n_vertices: 9,
            n_strands: 1,
            widest: 0.01,
            generation: 1,
        };
        let shadow = Shadow::new(&gpu);
        let mut scene = SceneBuffers::new(&gpu);
        let is_new = scene.update(
            &gpu,
            &SceneLights::new(lights).with_probes(look),
            surroundings,
            look,
            Vec3::new(0.0, 0.0, 100.0),
        );
        let mut shade = Shade::new(&gpu);
        let input =
            ShadeInput { strands: &strands, look, scene: &scene, scene_is_new: is_new, shadow: &shadow, waits: true };
        shade.prepare(&gpu, &library, &input, |_| material).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        shade.record(&mut encoder, &strands);
        gpu.queue.submit([encoder.finish()]);
        let [low, high] = gpu.read_buffer::<[u32; 2]>(shade.radiance()).unwrap()[4];
        [half(low & 0xffff), half(low >> 16), half(high & 0xffff), half(high >> 16)]
    }

    fn unshadowed() -> Look {
        Look { shadowing: Shadowing::Off, ..Look::default() }
    }

    fn white() -> HairMaterial {
        HairMaterial { eumelanin: 0.0, pheomelanin: 0.0, ..HairMaterial::default() }
    }

    #[test]
    fn a_white_furnace_stays_white() {
        let look = Look { environment_colour: [1.0; 3], environment_intensity: 0.7, ..unshadowed() };
        let [r, g, b, a] = radiance(&look, &white(), &[]);
        assert!([r, g, b].iter().all(|l| (l / 0.7 - 1.0).abs() < 0.01), "{r} {g} {b}");
        assert_eq!(a, 1.0);
        let dark = radiance(&look, &HairMaterial { eumelanin: 3.0, ..white() }, &[]);
        assert!(dark[0] < 0.1 && dark[0] > 0.01, "{dark:?}");
    }

    /// The law of the environment from a picture: one of a single colour is the constant environment.
    #[test]
    fn a_picture_of_one_colour_is_the_constant_environment() {
        let colour = [0.9, 0.5, 0.2];
        let picture = Panorama::from_fn(256, 128, |_| Vec3::from_array(colour));
        for (scattering, eumelanin) in [
            (Scattering::Marschner, 0.0),
            (Scattering::Marschner, 0.7),
            (Scattering::Deon, 0.3),
            (Scattering::KajiyaKay, 2.0),
        ] {
            let material = HairMaterial { eumelanin, ..white() };
            let constant = Look { scattering, environment_colour: colour, environment_intensity: 1.0, ..unshadowed() };
            let pictured = Look { environment: Environment::Harmonics, ..constant.clone() };
            let lights = EnvironmentUniform::new(&lights_of(&Harmonics::of(&picture), &pictured));
            let (a, b) = (radiance(&constant, &material, &[]), radiance_in(&pictured, &material, &[], &lights));
            // Half floats have eleven bits.
            for k in 0..3 {
                assert!((a[k] / b[k] - 1.0).abs() < 2e-3, "{scattering:?} {eumelanin}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn environments_from_pictures_agree_with_their_twins() {
        let material = HairMaterial { eumelanin: 0.4, ..white() };
        for picture in [Surroundings::Studio, Surroundings::Sunset] {
            let mut look = unshadowed();
            look.environment_picture.picture = picture;
            look.environment_picture.rotation_deg = 70.0;
            let lights = lights_of(&Harmonics::of(&embedded(picture).unwrap()), &look);
            let fibre = Fibre::new(&material, &look).vary(0x8080_8080, 0.5, 1.0);
            let (heap, frame) = (volume(&fibre), (Vec3::X, Vec3::Z));
            let harmonics = lit::harmonics(&fibre, &heap, frame, &Open::WIDE, &lights, |d: &Directions| {
                marschner::scatter(&fibre, d)
            });
            let karis = lit::karis(&fibre, frame, &Open::WIDE, &lights, marschner::scatter, |to_light| {
                multiple(&fibre, &heap, Vec3::X, to_light, Vec3::Z, 0.0)
            });
            for (environment, expected) in [(Environment::Harmonics, harmonics), (Environment::Karis, karis)] {
                look.environment = environment;
                let shown = radiance_in(&look, &material, &[], &EnvironmentUniform::new(&lights));
                let shown = Vec3::from_slice(&shown[..3]);
                assert!((shown / expected - 1.0).abs().max_element() < 5e-3, "{environment:?}: {shown} {expected}");
            }
        }
    }

    #[test]
    fn white_hair_facing_a_light_is_about_as_bright_as_a_white_card_in_either_model() {
        let light = Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3]);
        for scattering in [Scattering::Marschner, Scattering::KajiyaKay] {
            let look = Look { scattering, environment: Environment::Off, ..unshadowed() };
            let l = radiance(&look, &white(), std::slice::from_ref(&light));
            // A white card shows 1 (core::light).
            assert!((0.5..1.8).contains(&l[0]), "{scattering:?}: {l:?}");
        }
    }

    #[test]
    fn every_choice_that_is_off_takes_light_away() {
        let lights =
            [Light::directional("key", 10.0, 0.0, 1.0, [1.0; 3]), Light::directional("rim", 170.0, 0.0, 1.0, [1.0; 3])];
        let material = HairMaterial { eumelanin: 0.4, ..white() };
        let all = radiance(&unshadowed(), &material, &lights)[0];
        let without: [fn(&mut Look); 5] = [
            |look| look.lobe_r = Switch::Off,
            |look| look.lobe_tt = Switch::Off,
            |look| look.lobe_trt = Switch::Off,
            |look| look.multiple_scattering = MultipleScattering::Off,
            |look| look.environment = Environment::Off,
        ];
        for (which, change) in without.into_iter().enumerate() {
            let mut look = unshadowed();
            change(&mut look);
            let less = radiance(&look, &material, &lights)[0];
            assert!(less < 0.998 * all, "{which}: {less} of {all}");
        }
    }
}
