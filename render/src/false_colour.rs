//! False colours: one quantity of the hair in place of its light.
//!
//! What belongs to a whole strand is a colour that the CPU makes once ([`strand_colours`]); what differs along a strand
//! is made by a kernel from the vertices; how many strands lie in a pixel is counted by strips that are added up,
//! whatever draws the picture. Colours are stored as light and shown without exposure and tonemapping, so that a
//! display shows exactly the colours that the legend has.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::Vec3;
use lorelei_core::binding::LayerBinding;
use lorelei_core::look::view::{NO_COLOUR, ROOT_BLUE, layer_colour, own_colour, ramp};
use lorelei_core::look::{FalseColour, Look, ShadingRate, Shadowing, Tonemapping, WhiteBalance};
use lorelei_shaders::{Draw, DrawDescriptor, Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::{BufferUsages, TextureFormat};

use crate::frame::Targets;
use crate::mirror::{DrawnLayer, Mirror, StrandBuffers};
use crate::scene::SceneBuffers;
use crate::shadow::Shadow;
use crate::slot;

/// The look that is drawn: false colours reach the display as they are.
pub fn drawn_look(look: &Look) -> Cow<'_, Look> {
    if look.view.is_light() {
        return Cow::Borrowed(look);
    }
    Cow::Owned(Look {
        tonemapping: Tonemapping::Linear,
        exposure: 0.0,
        white_balance: WhiteBalance::NEUTRAL,
        // What is painted is each vertex's radiance.
        shading_rate: ShadingRate::PerVertex,
        ..look.clone()
    })
}

/// A direction as a colour, encoded for a display: 0 is grey. Twin of `view_colour_tangent.wgsl`.
pub fn direction_colour(direction: Vec3) -> [f32; 3] {
    (0.5 + 0.5 * direction).to_array()
}

/// A colour for each strand of a layer, encoded for a display; `None` where the view has none.
pub fn strand_colours(view: FalseColour, binding: &LayerBinding, layer_idx: usize) -> Option<Vec<[f32; 3]>> {
    let n = binding.n_strands();
    let colour: Box<dyn Fn(usize) -> [f32; 3]> = match view {
        FalseColour::RootUv => {
            Box::new(|s| binding.root_uvs.get(s).map_or(NO_COLOUR, |&[u, v]| [u.fract(), v.fract(), ROOT_BLUE]))
        }
        FalseColour::Strand => Box::new(|s| own_colour(binding.seeds[s])),
        FalseColour::Group => Box::new(move |_| layer_colour(layer_idx)),
        FalseColour::Guides => Box::new(|s| guide_mix(binding, s)),
        // Strands are in their order of detail: the first n are what is left of them.
        FalseColour::Lod => Box::new(move |s| ramp((s as f32 + 0.5) / n.max(1) as f32)),
        FalseColour::Clump => Box::new(|s| clump_colour(binding, s)),
        FalseColour::Final
        | FalseColour::Tangent
        | FalseColour::Overdraw
        | FalseColour::Depth
        | FalseColour::Coverage
        | FalseColour::Transmittance
        | FalseColour::ShadowLayer
        | FalseColour::Normals => return None,
    };
    Some((0..n).map(colour).collect())
}

/// The colours of a strand's guides by their shares in it.
fn guide_mix(binding: &LayerBinding, strand_idx: usize) -> [f32; 3] {
    let [from, to] = [0, 1].map(|end| binding.influence_offsets[strand_idx + end] as usize);
    let influences = &binding.influences[from..to];
    // Mean value coordinates may be a little below 0 outside a face.
    let sum: f32 = influences.iter().map(|influence| influence.weight.max(0.0)).sum();
    let mut mix = Vec3::ZERO;
    for influence in influences {
        mix += influence.weight.max(0.0) * Vec3::from_array(own_colour(influence.guide_idx));
    }
    if sum > 0.0 { (mix / sum).to_array() } else { NO_COLOUR }
}

/// The hue of the strand's largest clump, in a shade of its smallest.
fn clump_colour(binding: &LayerBinding, strand_idx: usize) -> [f32; 3] {
    let n_sizes = binding.clumps.sizes.len();
    let middles = binding.clumps.middles.get(strand_idx * n_sizes..(strand_idx + 1) * n_sizes).unwrap_or_default();
    let (Some(&finest), Some(&coarsest)) = (middles.first(), middles.last()) else { return NO_COLOUR };
    let shade = if n_sizes > 1 { 0.65 + 0.35 * lorelei_core::hash::random(finest, FOR_SHADE) } else { 1.0 };
    own_colour(coarsest).map(|channel| channel * shade)
}

const FOR_SHADE: u32 = 0xC013;

/// What counts are added up in: strands that touch a pixel, and the sum of their coverage. Half floats count exactly
/// to 2048.
const COUNT: TextureFormat = TextureFormat::Rgba16Float;

/// What the colours on the GPU were made from: each layer's binding by its address, and its place.
type ColoursKey = (FalseColour, Vec<(usize, DrawnLayer)>);

/// Paints strands, and counts them.
pub(crate) struct FalseColourPass {
    paint: HashMap<(FalseColour, Shadowing), Hot<Kernel>>,
    count: Option<Hot<Draw>>,
    /// `array<u32>`: four bytes a strand.
    colours: wgpu::Buffer,
    colours_of: Option<ColoursKey>,
    layers: Vec<wgpu::Buffer>,
    light: wgpu::Buffer,
    count_look: wgpu::Buffer,
    counted: Option<([u32; 2], wgpu::TextureView)>,
    nothing: wgpu::TextureView,
}

/// What a frame in false colours is made from.
pub(crate) struct FalseColourInput<'a> {
    pub look: &'a Look,
    pub mirror: &'a Mirror,
    pub radiance: &'a wgpu::Buffer,
    pub view: &'a wgpu::Buffer,
    pub targets: &'a Targets,
    pub scene: &'a SceneBuffers,
    pub shadow: &'a Shadow,
}

impl FalseColourPass {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            paint: HashMap::new(),
            count: None,
            colours: gpu.buffer("view.colours", 16, BufferUsages::STORAGE),
            colours_of: None,
            layers: Vec::new(),
            light: gpu.buffer("view.light", 16, BufferUsages::UNIFORM),
            count_look: gpu.buffer("view.count_look", 16, BufferUsages::UNIFORM),
            counted: None,
            nothing: count_texture(gpu, [1, 1]),
        }
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.paint.values().find_map(Hot::error).or(self.count.as_ref().and_then(Hot::error))
    }

    /// GPU memory held, bytes.
    pub fn n_bytes(&self) -> u64 {
        let counted = self.counted.as_ref().map_or(0, |([width, height], _)| 8 * u64::from(width * height));
        self.colours.size() + counted
    }

    /// Record what replaces every vertex's radiance.
    pub fn record_paint(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &FalseColourInput<'_>,
    ) -> Result<(), ShaderError> {
        let strands = &input.mirror.buffers;
        let key = (input.look.view, input.look.shadowing);
        let make = |library: &ShaderLibrary| {
            let mut links = slot::shadowing(key.1);
            links.extend([slot::view_colour(key.0), slot::shadow_part(key.1)]);
            library.kernel(gpu, "view_vertex", "paint", &[], &links)
        };
        Hot::have(&mut self.paint, library, &key, make)?;
        self.send_layers(gpu, strands);
        self.send_colours(gpu, input);
        let shown = [input.look.view_params.light, input.look.view_params.layer, 0, 0];
        gpu.queue.write_buffer(&self.light, 0, bytemuck::cast_slice(&shown));
        let kernel = &self.paint[&key];
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("view"), timestamp_writes: None });
        for (layer, uniform) in strands.layers.iter().zip(&self.layers) {
            let mut resources = vec![
                ("view_layer", uniform.as_entire_binding()),
                ("vertices", strands.vertices.as_entire_binding()),
                ("radiance", input.radiance.as_entire_binding()),
                ("strand_colours", self.colours.as_entire_binding()),
                ("view_light", self.light.as_entire_binding()),
            ];
            resources.extend(input.scene.resources());
            resources.extend(input.shadow.resources());
            let bindings = kernel.bind_used(gpu, &resources)?;
            kernel.dispatch_items(&mut pass, &bindings, layer.n_strands * layer.vertices_per_strand);
        }
        Ok(())
    }

    /// Record the count of strands in every pixel, where the view shows it.
    pub fn record_count(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &FalseColourInput<'_>,
    ) -> Result<(), ShaderError> {
        if !matches!(input.look.view, FalseColour::Overdraw | FalseColour::Depth) {
            self.counted = None;
            return Ok(());
        }
        let size = input.targets.size;
        if self.counted.as_ref().is_none_or(|(of, _)| *of != size) {
            self.counted = Some((size, count_texture(gpu, size)));
        }
        let make = |library: &ShaderLibrary| make_count(gpu, library);
        match &mut self.count {
            Some(count) => {
                count.refresh(library, make);
            }
            None => self.count = Some(Hot::new(library, make)?),
        }
        let most = input.look.view_params.most.max(1e-3);
        gpu.queue.write_buffer(&self.count_look, 0, bytemuck::cast_slice(&[most, 0.0, 0.0, 0.0]));
        let strands = &input.mirror.buffers;
        self.send_layers(gpu, strands);
        let (Some(count), Some((_, target))) = (&self.count, &self.counted) else { return Ok(()) };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("view.count"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        for (layer, uniform) in strands.layers.iter().zip(&self.layers) {
            let bindings = count.bind(
                gpu,
                &[
                    ("view", input.view.as_entire_binding()),
                    ("view_layer", uniform.as_entire_binding()),
                    ("vertices", strands.vertices.as_entire_binding()),
                    ("head_depth", wgpu::BindingResource::TextureView(&input.targets.head_depth)),
                ],
            )?;
            count.draw(&mut pass, &bindings, 6 * layer.n_segments());
        }
        Ok(())
    }

    /// What the last pass binds of it, by the names of `view_counts.wgsl`.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 2] {
        let counted = self.counted.as_ref().map_or(&self.nothing, |(_, view)| view);
        [
            ("view_count", wgpu::BindingResource::TextureView(counted)),
            ("count_look", self.count_look.as_entire_binding()),
        ]
    }

    fn send_layers(&mut self, gpu: &Gpu, strands: &StrandBuffers) {
        while self.layers.len() < strands.layers.len() {
            self.layers.push(gpu.buffer("view.layer", 16, BufferUsages::UNIFORM));
        }
        for (layer, buffer) in strands.layers.iter().zip(&self.layers) {
            let numbers = [layer.first_vertex, layer.first_strand, layer.n_strands, layer.vertices_per_strand];
            gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&numbers));
        }
    }

    /// Make the strands' colours anew where they are of another view or other strands.
    fn send_colours(&mut self, gpu: &Gpu, input: &FalseColourInput<'_>) {
        let places: Vec<(usize, DrawnLayer)> = (input.mirror.layers.iter())
            .filter_map(|layer| Some((std::sync::Arc::as_ptr(&layer.binding).addr(), layer.place?)))
            .collect();
        let key = (input.look.view, places);
        if self.colours_of.as_ref() == Some(&key) {
            return;
        }
        let mut packed: Vec<u32> = Vec::new();
        for (layer_idx, layer) in input.mirror.layers.iter().enumerate() {
            let Some(place) = layer.place else { continue };
            let Some(colours) = strand_colours(key.0, &layer.binding, layer_idx) else { continue };
            packed.resize(place.first_strand as usize, 0);
            packed.extend(colours.iter().take(place.n_strands as usize).map(pack));
        }
        if !packed.is_empty() {
            self.colours = gpu.buffer_of("view.colours", &packed, BufferUsages::STORAGE);
        }
        self.colours_of = Some(key);
    }
}

fn pack(colour: &[f32; 3]) -> u32 {
    let [r, g, b] = colour.map(|channel| (255.0 * channel.clamp(0.0, 1.0)).round() as u32);
    r | g << 8 | b << 16 | 255 << 24
}

fn count_texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("view.count"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COUNT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn make_count(gpu: &Gpu, library: &ShaderLibrary) -> Result<Draw, ShaderError> {
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let target = wgpu::ColorTargetState {
        format: COUNT,
        blend: Some(wgpu::BlendState { color: add, alpha: add }),
        write_mask: wgpu::ColorWrites::ALL,
    };
    let descriptor = DrawDescriptor {
        vertex: "strip",
        fragment: Some("count"),
        targets: &[Some(target)],
        ..DrawDescriptor::default()
    };
    library.draw(gpu, "view_count", &descriptor)
}

#[cfg(test)]
#[path = "false_colour_tests.rs"]
mod tests;
