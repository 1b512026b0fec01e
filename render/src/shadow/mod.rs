//! Shadows of hair and head for each light: deep opacity maps (Yuksel and Keyser 2008) and a depth map of the head.
//!
//! Passes, all lights at once: the front of the hair (atomic max of inverted depth), opacity behind it into layers
//! (atomic add), a filter, and the head through the graphics pipeline. Layers start at each texel's own front and grow:
//! the k-th ends at d_k = size k (k + 1) / 2. Opacity is the fibre's projected area over the texel's, an optical depth,
//! so that exp(-sum) is what fibres thinner than a texel let through.
//!
//! Rejected: drawing the hair through the graphics pipeline (an order of magnitude slower for thin segments);
//! filtering in the look-up (every vertex and light pays for what every texel can pay once).
//!
//! Off is a module too: `shadow_off.wgsl` answers the same questions with "all of it".

mod camera;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use glam::Affine3A;
use lorelei_core::look::{DeepOpacityParams, Shadowing};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Bindings, Draw, DrawDescriptor, Gpu, Hot, Kernel, ShaderError, ShaderLibrary, grid_1d};
use wgpu::BufferUsages;

use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::scene::{Ball, SceneLights};

pub use camera::ShadowLight;

/// Layers that the filter has registers for.
pub const MAX_LAYERS: u32 = 7;

/// Twin of `ShadowParams`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Params {
    resolution: u32,
    n_layers: u32,
    layer_size: f32,
    filter_radius: f32,
    density: f32,
    n_lights: u32,
    pad: [u32; 2],
}

/// Twin of `ShadowLayer`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct LayerUniform {
    first_vertex: u32,
    n_segments: u32,
    vertices_per_strand: u32,
    width_scale: f32,
}

/// Twin of `HeadCaster`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct HeadCaster {
    world_from_head: [f32; 16],
    light_idx: u32,
    pad: [u32; 3],
}

/// What the pass needs to know of a frame.
#[derive(Debug, Clone, Copy)]
pub struct ShadowInput<'a> {
    pub shadowing: Shadowing,
    pub params: &'a DeepOpacityParams,
    pub lights: &'a SceneLights,
    pub ball: Ball,
    pub world_from_head: Affine3A,
    /// False: the head stands in no light's way.
    pub head_casts: bool,
}

struct Kernels {
    front: Kernel,
    opacity: Kernel,
    filter: Kernel,
    head: Draw,
    /// That the filter was made for.
    n_layers: u32,
}

struct Head {
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    n_indices: u32,
}

/// Maps of all lights; made for a number of lights, layers and a resolution.
struct Maps {
    size: MapSize,
    params: wgpu::Buffer,
    lights: wgpu::Buffer,
    front: wgpu::Buffer,
    opacity: wgpu::Buffer,
    filtered: wgpu::Buffer,
    head: wgpu::TextureView,
    head_of_light: Vec<wgpu::TextureView>,
    casters: Vec<wgpu::Buffer>,
}

/// Side in texels, layers and lights of the maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MapSize {
    resolution: u32,
    n_layers: u32,
    n_lights: u32,
}

impl MapSize {
    /// The resolution asked for, or the largest of which all lights' layers fit one binding.
    fn new(gpu: &Gpu, params: &DeepOpacityParams, n_lights: usize) -> Self {
        let n_layers = params.n_layers.clamp(1, MAX_LAYERS);
        let n_lights = n_lights.max(1) as u32;
        let texels = gpu.max_storage_binding() / (4 * u64::from(n_layers + 1) * u64::from(n_lights));
        let fits = (texels as f64).sqrt() as u32 & !7;
        Self { resolution: params.resolution.clamp(8, fits.max(8)), n_layers, n_lights }
    }

    fn n_texels(self) -> u64 {
        u64::from(self.resolution) * u64::from(self.resolution) * u64::from(self.n_lights)
    }
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
    layers: Vec<LayerPass>,
    filter: Bindings,
    heads: Vec<Bindings>,
}

struct LayerPass {
    uniform: wgpu::Buffer,
    front: Bindings,
    opacity: Bindings,
}

/// The shadow pass with its maps.
pub struct Shadow {
    kernels: Hot<Kernels>,
    maps: Maps,
    head: Option<Head>,
    casters: Vec<Caster>,
    bound: Option<Bound>,
    generation: u64,
}

impl Shadow {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let size = MapSize { resolution: 8, n_layers: 1, n_lights: 1 };
        Ok(Self {
            kernels: Hot::new(library, |library| make_kernels(gpu, library, size.n_layers))?,
            maps: Maps::new(gpu, size),
            head: None,
            casters: Vec::new(),
            bound: None,
            generation: 0,
        })
    }

    /// The mesh that stands in the lights' way, in head space.
    pub fn set_head(&mut self, gpu: &Gpu, mesh: Option<&TriMesh>) {
        self.head = mesh.filter(|mesh| !mesh.triangles.is_empty()).map(|mesh| Head {
            positions: gpu.buffer_of("shadow.head.positions", &mesh.positions, BufferUsages::STORAGE),
            indices: gpu.buffer_of("shadow.head.indices", &mesh.triangles, BufferUsages::STORAGE),
            n_indices: 3 * mesh.triangles.len() as u32,
        });
        self.bound = None;
    }

    /// Why a shader that was edited is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.error()
    }

    /// Changes when a resource is another one than before: whoever bound [`Shadow::resources`] binds again.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Bytes held on the GPU.
    pub fn n_bytes(&self) -> u64 {
        let n = &self.maps;
        n.front.size() + n.opacity.size() + n.filtered.size() + 4 * n.size.n_texels()
    }

    /// By the names of `shadow_deep_opacity.wgsl`, for `bind_used`.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 4] {
        [
            ("shadow_params", self.maps.params.as_entire_binding()),
            ("shadow_lights", self.maps.lights.as_entire_binding()),
            ("shadow_filtered", self.maps.filtered.as_entire_binding()),
            ("shadow_head", wgpu::BindingResource::TextureView(&self.maps.head)),
        ]
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
        if input.shadowing == Shadowing::Off {
            return Ok(());
        }
        let size = MapSize::new(gpu, input.params, input.lights.lights.len());
        let make = |library: &ShaderLibrary| make_kernels(gpu, library, size.n_layers);
        if self.kernels.refresh(library, make) {
            self.bound = None;
        } else if self.kernels.n_layers != size.n_layers {
            self.kernels = Hot::new(library, make)?;
            self.bound = None;
        }
        if self.maps.size != size {
            self.maps = Maps::new(gpu, size);
            self.generation += 1;
            self.bound = None;
        }
        let params = Params {
            resolution: size.resolution,
            n_layers: size.n_layers,
            layer_size: input.params.layer_size,
            filter_radius: input.params.filter_radius.max(0.0),
            density: input.params.density,
            n_lights: input.lights.lights.len() as u32,
            pad: [0; 2],
        };
        gpu.queue.write_buffer(&self.maps.params, 0, bytemuck::bytes_of(&params));
        let lights: Vec<ShadowLight> = (input.lights.lights.iter())
            .zip(&input.lights.casts_shadow)
            .map(|(light, &casts)| ShadowLight::new(light, casts, input.ball, input.world_from_head, size.resolution))
            .collect();
        gpu.queue.write_buffer(&self.maps.lights, 0, bytemuck::cast_slice(&lights));
        for (light_idx, caster) in self.maps.casters.iter().enumerate() {
            let uniform = HeadCaster {
                world_from_head: glam::Mat4::from(input.world_from_head).to_cols_array(),
                light_idx: light_idx as u32,
                pad: [0; 3],
            };
            gpu.queue.write_buffer(caster, 0, bytemuck::bytes_of(&uniform));
        }
        if self.bound.as_ref().is_none_or(|bound| bound.is_stale(strands)) {
            self.bound = Some(self.bind(gpu, strands)?);
        }
        self.casters = casters(&strands.layers, input.params.n_strands);
        for (caster, pass) in self.casters.iter().zip(self.bound.iter().flat_map(|bound| &bound.layers)) {
            let uniform = LayerUniform {
                first_vertex: caster.layer.first_vertex,
                n_segments: caster.layer.n_segments(),
                vertices_per_strand: caster.layer.vertices_per_strand,
                width_scale: caster.width_scale,
            };
            gpu.queue.write_buffer(&pass.uniform, 0, bytemuck::bytes_of(&uniform));
        }
        Ok(())
    }

    fn bind(&self, gpu: &Gpu, strands: &StrandBuffers) -> Result<Bound, ShaderError> {
        let maps = &self.maps;
        let mut layers = Vec::new();
        for _ in &strands.layers {
            let uniform = gpu.buffer("shadow.layer", size_of::<LayerUniform>() as u64, BufferUsages::UNIFORM);
            let resources = [
                ("shadow_params", maps.params.as_entire_binding()),
                ("shadow_layer", uniform.as_entire_binding()),
                ("shadow_lights", maps.lights.as_entire_binding()),
                ("vertices", strands.vertices.as_entire_binding()),
                ("shadow_front", maps.front.as_entire_binding()),
                ("shadow_opacity", maps.opacity.as_entire_binding()),
                ("shadow_head", wgpu::BindingResource::TextureView(&maps.head)),
            ];
            let front = self.kernels.front.bind_used(gpu, &resources)?;
            let opacity = self.kernels.opacity.bind_used(gpu, &resources)?;
            layers.push(LayerPass { uniform, front, opacity });
        }
        let filter = self.kernels.filter.bind(
            gpu,
            &[
                ("shadow_params", maps.params.as_entire_binding()),
                ("shadow_front", maps.front.as_entire_binding()),
                ("shadow_opacity", maps.opacity.as_entire_binding()),
                ("shadow_filtered", maps.filtered.as_entire_binding()),
            ],
        )?;
        let mut heads = Vec::new();
        if let Some(head) = &self.head {
            for caster in &maps.casters {
                heads.push(self.kernels.head.bind(
                    gpu,
                    &[
                        ("shadow_params", maps.params.as_entire_binding()),
                        ("head_caster", caster.as_entire_binding()),
                        ("shadow_lights", maps.lights.as_entire_binding()),
                        ("head_positions", head.positions.as_entire_binding()),
                        ("head_indices", head.indices.as_entire_binding()),
                    ],
                )?);
            }
        }
        Ok(Bound { strands_generation: strands.generation, layers, filter, heads })
    }

    /// Record the passes. Nothing where shadowing is off.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, input: &ShadowInput<'_>) {
        let (Shadowing::DeepOpacity, Some(bound)) = (input.shadowing, &self.bound) else { return };
        let n_lights = input.lights.lights.len() as u32;
        if n_lights == 0 {
            return;
        }
        encoder.clear_buffer(&self.maps.front, 0, None);
        encoder.clear_buffer(&self.maps.opacity, 0, None);
        // The head first: hair that it hides from a light stays out of that light's map.
        for (light_idx, view) in self.maps.head_of_light.iter().enumerate() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow.head"),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            let casts = input.head_casts && input.lights.casts_shadow.get(light_idx) == Some(&true);
            if let (true, Some(head), Some(bindings)) = (casts, &self.head, bound.heads.get(light_idx)) {
                self.kernels.head.draw(&mut pass, bindings, head.n_indices);
            }
        }
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("shadow.deep_opacity"),
                timestamp_writes: None,
            });
            let layers = || {
                let layers = self.casters.iter().map(|caster| caster.layer);
                layers.zip(&bound.layers).filter(|(layer, _)| layer.n_strands > 0)
            };
            for (layer, buffers) in layers() {
                let grid = grid_1d(layer.n_segments(), self.kernels.front.workgroup_size()[0]);
                self.kernels.front.dispatch(&mut pass, &buffers.front, grid);
            }
            for (layer, buffers) in layers() {
                let grid = grid_1d(layer.n_segments(), self.kernels.opacity.workgroup_size()[0]);
                self.kernels.opacity.dispatch(&mut pass, &buffers.opacity, grid);
            }
            let side = self.maps.size.resolution.div_ceil(8);
            self.kernels.filter.dispatch(&mut pass, &bound.filter, [side, side, n_lights]);
        }
    }
}

impl Bound {
    /// Whether the bindings are out of date.
    fn is_stale(&self, strands: &StrandBuffers) -> bool {
        self.strands_generation != strands.generation || self.layers.len() != strands.layers.len()
    }
}

impl Maps {
    fn new(gpu: &Gpu, size: MapSize) -> Self {
        let n_texels = size.n_texels();
        let head = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow.head.depth"),
            size: wgpu::Extent3d {
                width: size.resolution,
                height: size.resolution,
                depth_or_array_layers: size.n_lights,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Depth32Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = |dimension, base_array_layer, array_layer_count| {
            head.create_view(&wgpu::TextureViewDescriptor {
                label: Some("shadow.head.depth"),
                dimension: Some(dimension),
                base_array_layer,
                array_layer_count,
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let n_layers = u64::from(size.n_layers);
        Self {
            size,
            params: gpu.buffer("shadow.params", size_of::<Params>() as u64, BufferUsages::UNIFORM),
            lights: gpu.buffer(
                "shadow.lights",
                u64::from(size.n_lights) * size_of::<ShadowLight>() as u64,
                BufferUsages::STORAGE,
            ),
            front: gpu.buffer("shadow.deep_opacity.front", 4 * n_texels, BufferUsages::STORAGE),
            opacity: gpu.buffer("shadow.deep_opacity.layers", 4 * n_texels * n_layers, BufferUsages::STORAGE),
            filtered: gpu.buffer("shadow.deep_opacity.filtered", 4 * n_texels * (n_layers + 1), BufferUsages::STORAGE),
            head: view(wgpu::TextureViewDimension::D2Array, 0, None),
            head_of_light: (0..size.n_lights)
                .map(|light_idx| view(wgpu::TextureViewDimension::D2, light_idx, Some(1)))
                .collect(),
            casters: (0..size.n_lights)
                .map(|_| gpu.buffer("shadow.head.caster", size_of::<HeadCaster>() as u64, BufferUsages::UNIFORM))
                .collect(),
        }
    }
}

fn make_kernels(gpu: &Gpu, library: &ShaderLibrary, n_layers: u32) -> Result<Kernels, ShaderError> {
    let build = |pass: f64| library.kernel(gpu, "shadow_build", "build", &[("PASS", pass)], &[]);
    let layers = [("N_LAYERS", f64::from(n_layers))];
    Ok(Kernels {
        n_layers,
        front: build(0.0)?,
        opacity: build(1.0)?,
        filter: library.kernel(gpu, "shadow_filter", "filter_map", &layers, &[])?,
        head: library.draw(
            gpu,
            "shadow_head",
            &DrawDescriptor {
                vertex: "vertex",
                depth: Some(wgpu::DepthStencilState {
                    format: wgpu::TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Less),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                ..DrawDescriptor::default()
            },
        )?,
    })
}
