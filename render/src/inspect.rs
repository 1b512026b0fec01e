//! The pixel inspector: which strand is under a pixel, and what its light is made of, term by term and lamp by lamp.
//!
//! The shading kernel itself is asked again for that one place, linked with one term at a time and with the other lamps
//! dark, so that the numbers are those of whatever technique is chosen. A CPU copy of every technique was rejected: it
//! would be another thing that can be wrong. One place is a few threads of work.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lorelei_core::look::presets::TERMS;
use lorelei_core::look::{Environment, Look};
use lorelei_shaders::{Gpu, GpuError, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::environment::EnvironmentUniform;
use crate::frame::Targets;
use crate::mirror::StrandBuffers;
use crate::scene::{SceneBuffers, SceneLights};
use crate::shade::{Shade, links};
use crate::shadow::Shadow;

/// Pixels beyond a strand's edge that still count as under the pointer.
const REACH: f32 = 1.5;
/// Twins of `inspect_result.wgsl`.
const PLACE: usize = 0;
const TANGENT: usize = 1;
const STRAND: usize = 2;
const HAIR: usize = 3;
const BODY: usize = 4;
const DISPLAY: usize = 5;
const FIRST_TERM: usize = 8;
const DEPTHS: usize = 24;
const FIRST_LIGHT: usize = 40;
const MOST_LIGHTS: usize = 16;
const N_RESULTS: usize = 56;

/// What is under a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// From the picture's upper left.
    pub pixel: [u32; 2],
    /// Linear radiance of the hair, premultiplied, and its coverage.
    pub hair: [f32; 4],
    /// The same of the body behind it.
    pub body: [f32; 4],
    /// What the display gets, 0-1, premultiplied.
    pub display: [f32; 4],
    /// The frontmost strand within a pixel or two; `None` where there is none.
    pub strand: Option<InspectedStrand>,
}

impl Inspection {
    /// Scene radiance before exposure and tonemapping: hair over body, premultiplied.
    pub fn scene(&self) -> [f32; 4] {
        [0, 1, 2, 3].map(|channel| self.hair[channel] + (1.0 - self.hair[3]) * self.body[channel])
    }
}

/// A strand under a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct InspectedStrand {
    /// Index of the layer in the groom.
    pub layer_idx: u32,
    /// Of those that the layer draws.
    pub strand_idx: u32,
    /// Its stable id.
    pub id: u32,
    /// World, centimetres.
    pub position: Vec3,
    /// World, unit length, towards the tip.
    pub tangent: Vec3,
    /// Share of the strand's length from the root, 0-1.
    pub along: f32,
    /// From the eye along the view axis, centimetres.
    pub depth: f32,
    /// From the pixel's middle to the strand's, pixels.
    pub distance_px: f32,
    pub radius_um: f32,
    /// All of its radiance towards the eye, linear RGB.
    pub radiance: [f32; 3],
    /// What each term adds; lobes, by the labels of [`TERMS`], where they add up to the single scattering.
    pub terms: Vec<(&'static str, [f32; 3])>,
    /// By lamp of the scene; a square lamp is four.
    pub lights: Vec<InspectedLight>,
}

/// What one lamp does at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InspectedLight {
    /// Optical depth of the hair in between; what gets through is `exp(-depth)`.
    pub hair_depth: f32,
    /// What gets past the head, 0-1.
    pub past_head: f32,
    /// What the lamp adds to the radiance, linear RGB.
    pub radiance: [f32; 3],
}

/// Twin of `InspectLayer`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct InspectLayer {
    first_vertex: u32,
    layer: u32,
    n_strands: u32,
    vertices_per_strand: u32,
    pixel: [u32; 2],
    reach: f32,
    pad: f32,
}

/// What the last frame was made from.
pub(crate) struct InspectInput<'a> {
    pub pixel: [u32; 2],
    pub look: &'a Look,
    pub lights: &'a SceneLights,
    pub surroundings: &'a EnvironmentUniform,
    pub eye: Vec3,
    pub strands: &'a StrandBuffers,
    pub shade: &'a Shade,
    pub shadow: &'a Shadow,
    pub view: &'a wgpu::Buffer,
    pub targets: &'a Targets,
}

/// Looks at one place.
#[derive(Default)]
pub(crate) struct Inspector {
    /// By entry point and what is linked.
    kernels: HashMap<String, Hot<Kernel>>,
}

impl Inspector {
    /// Kernel of a file, made where it is asked for first.
    fn kernel(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        (file, entry): (&str, &str),
        links: &[Link<'static>],
    ) -> Result<&Kernel, ShaderError> {
        let make = |library: &ShaderLibrary| library.kernel(gpu, file, entry, &[], links);
        let key = format!("{entry} {links:?}");
        Hot::have(&mut self.kernels, library, &key, make)?;
        Ok(&self.kernels[&key])
    }

    /// Ask for a pixel of the last frame, and wait for the answer.
    pub fn inspect(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        input: &InspectInput<'_>,
    ) -> Result<Inspection, InspectError> {
        let results = gpu.buffer("inspect.results", 16 * N_RESULTS as u64, BufferUsages::STORAGE);
        let nearest = gpu.buffer_of("inspect.nearest", &[f32::INFINITY.to_bits(); 4], BufferUsages::STORAGE);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("inspect") });
        encoder.clear_buffer(&results, 0, None);
        self.record_find(gpu, library, &mut encoder, input, &results, &nearest)?;
        let (terms, n_lights) = self.record_terms(gpu, library, &mut encoder, input, &results)?;
        gpu.queue.submit([encoder.finish()]);
        let results: Vec<[f32; 4]> = gpu.read_buffer(&results)?;
        Ok(answer(input, &results, &terms, n_lights))
    }

    fn record_find(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &InspectInput<'_>,
        results: &wgpu::Buffer,
        nearest: &wgpu::Buffer,
    ) -> Result<(), ShaderError> {
        let shown = &input.targets.output_view;
        for entry in ["find_depth", "find_strand", "read_pixel"] {
            let kernel = self.kernel(gpu, library, ("inspect_find", entry), &[])?;
            for (layer, drawn) in input.strands.layers.iter().enumerate() {
                let uniform = InspectLayer {
                    first_vertex: drawn.first_vertex,
                    layer: layer as u32,
                    n_strands: drawn.n_strands,
                    vertices_per_strand: drawn.vertices_per_strand,
                    pixel: input.pixel,
                    reach: REACH,
                    pad: 0.0,
                };
                let uniform = gpu.buffer_of("inspect.layer", &[uniform], BufferUsages::UNIFORM);
                let bindings = kernel.bind_used(
                    gpu,
                    &[
                        ("view", input.view.as_entire_binding()),
                        ("inspect_layer", uniform.as_entire_binding()),
                        ("vertices", input.strands.vertices.as_entire_binding()),
                        ("nearest", nearest.as_entire_binding()),
                        ("inspected", results.as_entire_binding()),
                        ("head_depth", wgpu::BindingResource::TextureView(&input.targets.head_depth)),
                        ("head_colour", wgpu::BindingResource::TextureView(&input.targets.head_colour)),
                        ("hair", wgpu::BindingResource::TextureView(&input.targets.hair)),
                        ("shown", wgpu::BindingResource::TextureView(shown)),
                    ],
                )?;
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("inspect.find"),
                    timestamp_writes: None,
                });
                let n_items = if entry == "read_pixel" { 1 } else { drawn.n_segments() };
                kernel.dispatch_items(&mut pass, &bindings, n_items);
            }
        }
        Ok(())
    }

    /// The radiance of everything together, of each term and of each lamp, and each lamp's depths.
    fn record_terms(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &InspectInput<'_>,
        results: &wgpu::Buffer,
    ) -> Result<(Vec<&'static str>, usize), ShaderError> {
        let look = input.look;
        let mut asked: Vec<(&'static str, Look)> = vec![
            (TOTAL, look.clone()),
            (LAMPS, Look { environment: Environment::Off, ..look.clone() }),
            (REST, with_lobe(look, None)),
        ];
        for (term, name) in TERMS.iter().filter(|(term, _)| is_lobe(term) && !is_off(look, term)) {
            asked.push((name, with_lobe(look, Some(term))));
        }
        let mut scene = SceneBuffers::new(gpu);
        scene.update(gpu, input.lights, input.surroundings, look, input.eye);
        for (i, (_, look)) in asked.iter().enumerate() {
            self.record_term(gpu, library, encoder, input, results, ("shade_term", FIRST_TERM + i), (look, &scene))?;
        }
        self.record_term(gpu, library, encoder, input, results, ("light_depths", 0), (look, &scene))?;
        let n_lights = input.lights.n_lamps().min(MOST_LIGHTS);
        let lamps = Look { environment: Environment::Off, ..look.clone() };
        for light_idx in 0..n_lights {
            let mut alone = input.lights.clone();
            for (other, light) in alone.lights.iter_mut().enumerate() {
                if other != light_idx {
                    light.irradiance = [0.0; 3];
                }
            }
            let mut scene = SceneBuffers::new(gpu);
            scene.update(gpu, &alone, input.surroundings, &lamps, input.eye);
            let at = ("shade_term", FIRST_LIGHT + light_idx);
            self.record_term(gpu, library, encoder, input, results, at, (&lamps, &scene))?;
        }
        Ok((asked.into_iter().map(|(name, _)| name).collect(), n_lights))
    }

    fn record_term(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &InspectInput<'_>,
        results: &wgpu::Buffer,
        (entry, at): (&str, usize),
        (look, scene): (&Look, &SceneBuffers),
    ) -> Result<(), ShaderError> {
        let kernel = self.kernel(gpu, library, ("inspect_shade", entry), &links(look))?;
        let uniform = gpu.buffer_of("inspect.term", &[at as u32, 0, 0, 0], BufferUsages::UNIFORM);
        let mut resources = vec![
            ("inspect_term", uniform.as_entire_binding()),
            ("inspected", results.as_entire_binding()),
            ("seeds", input.strands.seeds.as_entire_binding()),
        ];
        resources.extend(input.shade.resources());
        resources.extend(scene.resources());
        resources.extend(input.shadow.resources());
        let bindings = kernel.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("inspect.term"), timestamp_writes: None });
        kernel.dispatch(&mut pass, &bindings, [1, 1, 1]);
        Ok(())
    }
}

/// Why a pixel cannot be inspected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InspectError {
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

const TOTAL: &str = "Total";
const LAMPS: &str = "Lamps";
const SINGLE: &str = "Single scattering";
const REST: &str = "Multiple and rest";
const ENVIRONMENT: &str = "Environment";
const ALL_SCATTERING: &str = "All scattering";

/// Whether a term of [`TERMS`] is a lobe of single scattering.
pub fn is_lobe(term: &str) -> bool {
    !matches!(term, "multiple" | "environment")
}

/// The lamps' light by one lobe at most, and by multiple scattering as it is. Multiple scattering stays on: what the
/// way through the hair does to single scattering is decided there.
fn with_lobe(look: &Look, lobe: Option<&str>) -> Look {
    let mut look = Look { environment: Environment::Off, ..look.clone() };
    for slot in look.slots() {
        let is_other = TERMS.iter().any(|(term, _)| *term == slot.key && is_lobe(term)) && lobe != Some(slot.key);
        if is_other && let Some(off) = slot.choice.infos().iter().position(|info| info.name == "off") {
            slot.choice.set_index(off);
        }
    }
    look
}

fn is_off(look: &Look, term: &str) -> bool {
    look.clone().slots().iter().any(|slot| slot.key == term && slot.chosen().name == "off")
}

fn answer(input: &InspectInput<'_>, results: &[[f32; 4]], asked: &[&'static str], n_lights: usize) -> Inspection {
    let rgb = |at: usize| [results[at][0], results[at][1], results[at][2]];
    let [place, tangent, strand] = [PLACE, TANGENT, STRAND].map(|at| results[at]);
    let drawn = input.strands.layers.get(strand[0].to_bits() as usize).filter(|_| place[3] > 0.0);
    let strand = drawn.map(|drawn| {
        let parts: Vec<(&'static str, [f32; 3])> =
            asked.iter().enumerate().map(|(i, name)| (*name, rgb(FIRST_TERM + i))).collect();
        InspectedStrand {
            layer_idx: drawn.material,
            strand_idx: strand[1].to_bits(),
            id: strand[1].to_bits(),
            position: Vec3::from_slice(&place[..3]),
            tangent: Vec3::from_slice(&tangent[..3]),
            along: tangent[3],
            depth: place[3],
            distance_px: strand[2],
            radius_um: 1e4 * strand[3],
            radiance: parts[0].1,
            terms: terms_of(&parts),
            lights: (0..n_lights)
                .map(|light_idx| InspectedLight {
                    hair_depth: results[DEPTHS + light_idx][0],
                    past_head: results[DEPTHS + light_idx][1],
                    radiance: rgb(FIRST_LIGHT + light_idx),
                })
                .collect(),
        }
    });
    Inspection { pixel: input.pixel, hair: results[HAIR], body: results[BODY], display: results[DISPLAY], strand }
}

/// The parts that make up the whole. What is left without any lobe is multiple scattering, and what a model has beyond
/// its lobes; a lobe is what it adds to that. A model that knows no lobes shows the same with and without them, and
/// lobes that do not add up are shown as one.
fn terms_of(parts: &[(&'static str, [f32; 3])]) -> Vec<(&'static str, [f32; 3])> {
    let of = |wanted: &str| parts.iter().find(|(name, _)| *name == wanted).map(|(_, rgb)| Vec3::from_array(*rgb));
    let lamps = of(LAMPS).unwrap_or_default();
    let rest = of(REST).unwrap_or_default();
    let lobes: Vec<(&'static str, Vec3)> = TERMS
        .iter()
        .filter(|(term, _)| is_lobe(term))
        .filter_map(|(_, name)| Some((*name, of(name)? - rest)))
        .collect();
    let single = lamps - rest;
    let slack = 0.01 * lamps.max_element() + 1e-6;
    let add_up = (lobes.iter().map(|(_, rgb)| *rgb).sum::<Vec3>() - single).abs().max_element() <= slack;
    let mut terms = match (single.abs().max_element() <= 1e-6, add_up) {
        (true, _) => vec![(ALL_SCATTERING, lamps)],
        (false, true) => lobes.into_iter().chain([(REST, rest)]).collect(),
        (false, false) => vec![(SINGLE, single), (REST, rest)],
    };
    terms.push((ENVIRONMENT, of(TOTAL).unwrap_or_default() - lamps));
    terms.into_iter().map(|(name, rgb)| (name, rgb.to_array())).collect()
}

#[cfg(test)]
#[path = "inspect_tests.rs"]
mod tests;
