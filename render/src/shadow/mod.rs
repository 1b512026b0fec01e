//! Shadows of hair and head for each light: a technique's maps of the hair, and a depth map of the head.
//!
//! A technique is a [`Plan`]: buffers and passes by name, made in a file of its own. All of them walk the strands through
//! the texels of every light's map by one kernel (`shadow_walk.wgsl`) with one of many sinks. Opacity is the fibre's
//! projected area over the texel's, an optical depth, so that exp(-sum) is what fibres thinner than a texel let through.
//!
//! Rejected: drawing the hair through the graphics pipeline (an order of magnitude slower for thin segments).
//!
//! Off is a module too: `shadow_off.wgsl` answers the same questions with "all of it".

mod camera;
mod clusters;
mod deep_opacity;
mod deep_shadow;
pub mod exact;
mod front;
mod head;
pub mod measure;
mod occupancy;
mod opacity_maps;
mod params;
mod plan;
#[cfg(test)]
mod tests;
mod voxels;

use bytemuck::{Pod, Zeroable};
use glam::Affine3A;
use lorelei_core::look::{ShadowParams, Shadowing};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary, grid_1d};
use wgpu::BufferUsages;

use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::scene::{Ball, SceneLights};

use head::{HeadMaps, HeadMesh};
use params::{MapSize, Params};
use plan::{Plan, SceneSize, Step};

pub use camera::ShadowLight;
pub use deep_shadow::compress;
pub use params::MAX_LAYERS;

/// Twin of `ShadowLayer`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct LayerUniform {
    first_vertex: u32,
    n_segments: u32,
    vertices_per_strand: u32,
    width_scale: f32,
}

/// What the pass needs to know of a frame.
#[derive(Debug, Clone, Copy)]
pub struct ShadowInput<'a> {
    pub shadowing: Shadowing,
    pub params: &'a ShadowParams,
    pub lights: &'a SceneLights,
    pub ball: Ball,
    pub world_from_head: Affine3A,
    /// False: the head stands in no light's way.
    pub head_casts: bool,
}

struct Kernels {
    head: Kernel,
    /// Of each step of the plan.
    steps: Vec<Kernel>,
}

/// What was made for a plan.
struct Made {
    plan: Plan,
    size: MapSize,
    kernels: Hot<Kernels>,
    buffers: Vec<wgpu::Buffer>,
    lights: wgpu::Buffer,
    head: HeadMaps,
}

/// The first strands of a layer, that stand for all of them: strands are in the order of the level of detail.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Caster {
    layer: DrawnLayer,
    width_scale: f32,
}

/// At most about `most` strands in all, the same share of each layer.
fn casters(layers: &[DrawnLayer], most: u32) -> Vec<Caster> {
    let n_all: u32 = layers.iter().map(|layer| layer.n_strands).sum();
    let share = (f64::from(most) / f64::from(n_all.max(1))).min(1.0);
    let caster = |layer: &DrawnLayer| {
        let n_strands = (f64::from(layer.n_strands) * share).ceil() as u32;
        let width_scale = layer.n_strands as f32 / n_strands.max(1) as f32;
        Caster { layer: DrawnLayer { n_strands, ..*layer }, width_scale }
    };
    layers.iter().map(caster).collect()
}

/// Bindings that hold as long as the maps and the strands' buffers are the same.
struct Bound {
    strands_generation: u64,
    layers: Vec<wgpu::Buffer>,
    /// Of each step: one for each layer where it walks strands, else one.
    steps: Vec<Vec<Bindings>>,
    head: Option<Bindings>,
}

/// The shadow pass with its maps.
pub struct Shadow {
    params: wgpu::Buffer,
    made: Option<Made>,
    head: Option<HeadMesh>,
    casters: Vec<Caster>,
    bound: Option<Bound>,
    generation: u64,
}

impl Shadow {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            params: gpu.buffer("shadow.params", size_of::<Params>() as u64, BufferUsages::UNIFORM),
            made: None,
            head: None,
            casters: Vec::new(),
            bound: None,
            generation: 0,
        }
    }

    /// The mesh that stands in the lights' way, in head space.
    pub fn set_head(&mut self, gpu: &Gpu, mesh: Option<&TriMesh>) {
        self.head = mesh.filter(|mesh| !mesh.triangles.is_empty()).map(|mesh| HeadMesh::new(gpu, mesh));
        self.bound = None;
    }

    /// Why a shader that was edited is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.made.as_ref().and_then(|made| made.kernels.error())
    }

    /// Changes when a resource is another one than before: whoever bound [`Shadow::resources`] binds again.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Bytes held on the GPU.
    pub fn n_bytes(&self) -> u64 {
        self.made.as_ref().map_or(0, |made| made.plan.n_bytes() + 4 * made.size.n_texels())
    }

    /// Side of the maps in texels: less than was asked for where the GPU can bind no more. 0 where nothing is drawn.
    pub fn resolution(&self) -> u32 {
        self.made.as_ref().map_or(0, |made| made.size.resolution)
    }

    /// By the names of the modules of the slots `shadow` and `shadow_technique`, for `bind_used`.
    pub fn resources(&self) -> Vec<(&'static str, wgpu::BindingResource<'_>)> {
        let mut resources = vec![("shadow_params", self.params.as_entire_binding())];
        if let Some(made) = &self.made {
            resources.extend([
                ("shadow_lights", made.lights.as_entire_binding()),
                ("shadow_head", made.head.fronts.as_entire_binding()),
            ]);
            let named = made.plan.buffers.iter().zip(&made.buffers);
            resources.extend(named.map(|(words, buffer)| (words.name, buffer.as_entire_binding())));
        }
        resources
    }

    /// Make everything fit the frame; nothing is recorded. Call before [`Shadow::record`] and before binding
    /// [`Shadow::resources`].
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        strands: &StrandBuffers,
        input: &ShadowInput<'_>,
    ) -> Result<(), ShaderError> {
        self.casters = casters(&strands.layers, most_casters(gpu, input, &strands.layers));
        let params = ShadowParams {
            n_voxels: input.params.n_voxels.min(voxels::most(gpu.max_storage_binding())),
            ..input.params.clone()
        };
        let scene = SceneSize {
            n_strands: self.casters.iter().map(|caster| u64::from(caster.layer.n_strands)).sum(),
            n_segments: self.casters.iter().map(|caster| u64::from(caster.layer.n_segments())).sum(),
        };
        let Some((plan, size)) = fitting(gpu, input, &params, &scene) else {
            if self.made.take().is_some() {
                self.generation += 1;
            }
            self.bound = None;
            return Ok(());
        };
        self.make(gpu, library, plan, size, input.params.resolution)?;
        let Some(made) = &self.made else { return Ok(()) };
        let n_fragments = made.plan.n_words("shadow_fragments");
        let params = Params::new(input.shadowing, &params, size, n_fragments, input.ball, input.world_from_head);
        gpu.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
        let lights: Vec<ShadowLight> = (input.lights.lights.iter())
            .zip(&input.lights.casts_shadow)
            .map(|(light, &casts)| ShadowLight::new(light, casts, input.ball, input.world_from_head, size.resolution))
            .collect();
        gpu.queue.write_buffer(&made.lights, 0, bytemuck::cast_slice(&lights));
        made.head.place(gpu, self.head.as_ref(), input.world_from_head);
        if self.bound.as_ref().is_none_or(|bound| bound.is_stale(strands)) {
            self.bound = Some(self.bind(gpu, made, strands)?);
        }
        for (caster, buffer) in self.casters.iter().zip(self.bound.iter().flat_map(|bound| &bound.layers)) {
            let uniform = LayerUniform {
                first_vertex: caster.layer.first_vertex,
                n_segments: caster.layer.n_segments(),
                vertices_per_strand: caster.layer.vertices_per_strand,
                width_scale: caster.width_scale,
            };
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&uniform));
        }
        Ok(())
    }

    /// Have what a plan needs; what is there already stays.
    fn make(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        plan: Plan,
        size: MapSize,
        asked: u32,
    ) -> Result<(), ShaderError> {
        let make = |library: &ShaderLibrary| make_kernels(gpu, library, &plan.steps);
        let kernels = match self.made.take() {
            Some(mut made) if made.plan.has_kernels_of(&plan) => {
                if made.kernels.refresh(library, make) {
                    self.bound = None;
                }
                if made.plan == plan && made.size == size {
                    self.made = Some(made);
                    return Ok(());
                }
                made.kernels
            }
            _ => Hot::new(library, make)?,
        };
        if size.resolution < asked {
            log::warn!(
                "shadow maps have {} texels a side and not {asked}: this GPU can bind {} MiB at once",
                size.resolution,
                gpu.max_storage_binding() >> 20
            );
        }
        self.bound = None;
        self.generation += 1;
        let n_bytes = u64::from(size.n_lights) * size_of::<ShadowLight>() as u64;
        self.made = Some(Made {
            kernels,
            buffers: (plan.buffers.iter())
                .map(|words| gpu.buffer(words.label, 4 * words.n, BufferUsages::STORAGE))
                .collect(),
            lights: gpu.buffer("shadow.lights", n_bytes, BufferUsages::STORAGE),
            head: HeadMaps::new(gpu, size),
            plan,
            size,
        });
        Ok(())
    }

    fn bind(&self, gpu: &Gpu, made: &Made, strands: &StrandBuffers) -> Result<Bound, ShaderError> {
        let shared = self.resources();
        let layers: Vec<wgpu::Buffer> = (strands.layers.iter())
            .map(|_| gpu.buffer("shadow.layer", size_of::<LayerUniform>() as u64, BufferUsages::UNIFORM))
            .collect();
        let bind = |(step, kernel): (&Step, &Kernel)| match step {
            Step::Walk { .. } | Step::Segments { .. } => {
                let of_layer = layers.iter().map(|layer| {
                    let mut resources = shared.clone();
                    resources.push(("shadow_layer", layer.as_entire_binding()));
                    resources.push(("vertices", strands.vertices.as_entire_binding()));
                    kernel.bind_used(gpu, &resources)
                });
                of_layer.collect()
            }
            Step::Items { .. } | Step::Texels { .. } => Ok(vec![kernel.bind_used(gpu, &shared)?]),
        };
        let steps: Result<Vec<Vec<Bindings>>, ShaderError> =
            made.plan.steps.iter().zip(&made.kernels.steps).map(bind).collect();
        let mesh = self.head.as_ref();
        let head = mesh.map(|mesh| made.head.bind(gpu, &made.kernels.head, mesh, &shared)).transpose()?;
        let steps = steps?;
        Ok(Bound { strands_generation: strands.generation, layers, steps, head })
    }

    /// Record the passes. Nothing where shadowing is off.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, input: &ShadowInput<'_>) {
        self.record_head(encoder, input);
        self.record_hair(encoder, input);
    }

    /// What of the head each light sees. First of the passes: hair that the head hides from a light stays out of that
    /// light's map.
    pub fn record_head(&self, encoder: &mut wgpu::CommandEncoder, input: &ShadowInput<'_>) {
        let (Some(made), Some(bound)) = (&self.made, &self.bound) else { return };
        let drawn = self.head.as_ref().zip(bound.head.as_ref()).filter(|_| input.head_casts);
        made.head.record(encoder, &made.kernels.head, drawn);
    }

    /// The technique's own passes.
    pub fn record_hair(&self, encoder: &mut wgpu::CommandEncoder, input: &ShadowInput<'_>) {
        let (Some(made), Some(bound)) = (&self.made, &self.bound) else { return };
        let n_lights = input.lights.lights.len() as u32;
        if n_lights == 0 {
            return;
        }
        for (words, buffer) in made.plan.buffers.iter().zip(&made.buffers).filter(|(words, _)| words.clear) {
            encoder.clear_buffer(buffer, 0, Some((4 * words.n).next_multiple_of(4)));
        }
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("shadow"), timestamp_writes: None });
        for ((step, kernel), bindings) in made.plan.steps.iter().zip(&made.kernels.steps).zip(&bound.steps) {
            let width = kernel.workgroup_size()[0];
            match step {
                Step::Walk { .. } | Step::Segments { .. } => {
                    for (caster, bindings) in self.casters.iter().zip(bindings) {
                        if caster.layer.n_strands > 0 {
                            kernel.dispatch(&mut pass, bindings, grid_1d(caster.layer.n_segments(), width));
                        }
                    }
                }
                Step::Items { n, .. } => kernel.dispatch(&mut pass, &bindings[0], grid_1d(*n as u32, width)),
                Step::Texels { .. } => {
                    let side = made.size.resolution.div_ceil(width);
                    kernel.dispatch(&mut pass, &bindings[0], [side, side, n_lights]);
                }
            }
        }
    }
}

/// Strands that cast at most: those asked for, or what lists of all their fragments have room for.
fn most_casters(gpu: &Gpu, input: &ShadowInput<'_>, layers: &[DrawnLayer]) -> u32 {
    let segments = layers.iter().map(|layer| u64::from(layer.vertices_per_strand)).max().unwrap_or(2);
    let room = deep_shadow::most_strands(gpu.max_storage_binding(), input.lights.lights.len(), segments);
    if input.shadowing == Shadowing::DeepShadow { input.params.n_strands.min(room) } else { input.params.n_strands }
}

/// The technique's plan, with the resolution asked for or the largest of which every buffer fits one binding. `None`
/// where nothing is drawn.
fn fitting(gpu: &Gpu, input: &ShadowInput<'_>, params: &ShadowParams, scene: &SceneSize) -> Option<(Plan, MapSize)> {
    let n_lights = input.lights.lights.len().max(1) as u32;
    let most_side = gpu.device.limits().max_texture_dimension_2d;
    // Whole squares of texels: see `texel_index` of shadow_map.wgsl.
    let mut resolution = params.resolution.clamp(8, most_side).next_multiple_of(8).min(most_side & !7);
    loop {
        let size = MapSize { resolution, n_lights };
        let plan = Plan::of(input.shadowing, params, size, scene)?;
        // Besides the plan's, a depth of the head for each texel.
        let share = gpu.max_storage_binding() as f64 / plan.largest().max(4 * size.n_texels()) as f64;
        if share >= 1.0 || resolution == 8 {
            return Some((plan, size));
        }
        // Buffers grow with the side at least, and with its square at most.
        let next = (f64::from(resolution) * share.sqrt()) as u32 & !7;
        resolution = next.clamp(8, (resolution - 1).max(8) & !7);
    }
}

impl Bound {
    /// Whether the bindings are out of date.
    fn is_stale(&self, strands: &StrandBuffers) -> bool {
        self.strands_generation != strands.generation || self.layers.len() != strands.layers.len()
    }
}

fn make_kernels(gpu: &Gpu, library: &ShaderLibrary, steps: &[Step]) -> Result<Kernels, ShaderError> {
    let kernel = |step: &Step| match step {
        Step::Walk { sink } => library.kernel(gpu, "shadow_walk", "build", &[], &[Link::Slot("shadow_sink", sink)]),
        Step::Segments { file, entry } | Step::Items { file, entry, .. } => library.kernel(gpu, file, entry, &[], &[]),
        Step::Texels { file, entry, overrides, def } => {
            let defs: Vec<Link<'_>> = def.iter().map(|def| Link::Def(def)).collect();
            library.kernel(gpu, file, entry, overrides, &defs)
        }
    };
    let steps: Result<Vec<Kernel>, ShaderError> = steps.iter().map(kernel).collect();
    Ok(Kernels { head: head::make_kernel(gpu, library)?, steps: steps? })
}
