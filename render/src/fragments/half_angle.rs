//! Half-angle slices (Ikits, Kniss, Lefohn and Hansen 2004, GPU Gems, section 39.5.1): shadow and transparency in one go
//! through the hair. Segments are sorted along the vector half way between the ways to the eye and to the light and cut into
//! slices; each slice is shaded by what those before it have left of the light, blended into the picture, and added to the
//! light's buffer.
//!
//! ```text
//! ribbons_keys      sort     for each slice: half_angle_shade   ribbons       half_angle_splat
//! along h          -------->                 by the buffer  --> picture  ---> light's buffer --> next slice
//! ```
//!
//! The slices go away from the light always: nearer to the eye first where the light is on the eye's side, and blended from
//! front to back; farther first where it is behind the hair, and blended over each other. Along a ray from the eye, or from
//! the light, the order of slices is the order of depth: at most 45 degrees lie between ray and half vector.
//!
//! One light shines through the slices; the others have the look's shadow technique. Slices of equal thickness were rejected:
//! most of a head's hair lies in few of them, and how many segments a slice has is known on the GPU alone. So was summing up
//! opacity by blending into a texture: half floats round thin hair away.

use std::collections::HashMap;
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use lorelei_core::look::{FalseColour, Look, Primitive, ShadingRate};
use lorelei_shaders::{Draw, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, BufferUsages};

use super::blended::{drawn_primitive, make_draw};
use super::{Band, FragmentInput, vertices_per_segment};
use crate::scene::{Ball, SceneLight, SceneLights};
use crate::shade;
use crate::shadow::ShadowLight;
use crate::slot;
use crate::sort::Sort;

/// Twin of `HalfAngle`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Uniform {
    half_vector: [f32; 3],
    density: f32,
    first_light: u32,
    n_lights: u32,
    resolution: u32,
    n_slices: u32,
}

/// What slices need to know of a frame besides its fragments.
pub(crate) struct Slicing<'a> {
    pub lights: &'a SceneLights,
    pub ball: Ball,
    pub world_from_head: Affine3A,
    /// Unit vector against the camera's view axis.
    pub to_eye: Vec3,
    /// Segments of all drawn strands.
    pub n_segments: u32,
}

/// Where the colours of a slice come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Colours {
    /// Every vertex has its radiance already: no light shines through the slices, or false colours are shown.
    Given,
    /// Vertices of the slice are shaded.
    Vertices,
    /// Fragments are shaded as they are drawn.
    Fragments,
    /// Vertices of the slice show what of its shadow false colours are about.
    Shown,
}

type DrawKey = (Primitive, bool, Vec<Link<'static>>);
type KernelKey = (&'static str, &'static str, Vec<Link<'static>>);

/// Sorts segments, cuts them into slices, lights and blends these.
#[derive(Default)]
pub(crate) struct HalfAngle {
    sort: Option<Sort>,
    kernels: HashMap<KernelKey, Hot<Kernel>>,
    draws: HashMap<DrawKey, Hot<Draw>>,
    buffers: Option<Buffers>,
    slices: Vec<wgpu::Buffer>,
}

struct Buffers {
    uniform: wgpu::Buffer,
    band: wgpu::Buffer,
    /// Of each light that shines through the slices.
    lights: wgpu::Buffer,
    map: wgpu::Buffer,
    /// As `view_colour_transmittance.wgsl` and `view_colour_shadow_layer.wgsl` want it.
    view_light: wgpu::Buffer,
    n_lights: usize,
    resolution: u32,
}

impl HalfAngle {
    pub fn shader_error(&self) -> Option<&ShaderError> {
        let of_sort = self.sort.as_ref().and_then(Sort::shader_error);
        self.draws.values().find_map(Hot::error).or(self.kernels.values().find_map(Hot::error)).or(of_sort)
    }

    pub fn n_bytes(&self) -> u64 {
        self.sort.as_ref().map_or(0, Sort::n_bytes) + self.buffers.as_ref().map_or(0, |buffers| buffers.map.size())
    }

    /// Let go of the buffers: another technique draws now.
    pub fn release(&mut self) {
        (self.sort, self.buffers) = (None, None);
    }

    /// Record everything into `input.hair`, which was cleared.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &FragmentInput<'_>,
        slicing: &Slicing<'_>,
    ) -> Result<(), crate::RenderError> {
        if slicing.n_segments == 0 {
            return Ok(());
        }
        let look = input.look;
        let through = light_of_slices(slicing.lights, look.drawing.slices_light);
        let colours = colours_of(look, !through.is_empty());
        let (half_vector, is_front_first) = half_vector(slicing, &slicing.lights.lights[through.clone()]);

        // Make everything fit.
        let draw_key: DrawKey = (drawn_primitive(look), is_front_first, links_of_draw(look, colours));
        let light_key: Option<KernelKey> = match colours {
            Colours::Given | Colours::Fragments => None,
            Colours::Vertices => Some(("half_angle_shade", "shade", links_of_slice(look, colours))),
            Colours::Shown => Some(("half_angle_paint", "paint", links_of_slice(look, colours))),
        };
        let keys_key: KernelKey = ("ribbons_keys", "write_keys", vec![Link::Def("HALF_ANGLE")]);
        let splat_key: KernelKey = ("half_angle_splat", "splat", Vec::new());
        for key in [&keys_key, &splat_key].into_iter().chain(&light_key) {
            Hot::have(&mut self.kernels, library, key, |library| library.kernel(gpu, key.0, key.1, &[], &key.2))?;
        }
        let blend = if is_front_first { UNDER } else { BlendState::PREMULTIPLIED_ALPHA_BLENDING };
        Hot::have(&mut self.draws, library, &draw_key, |library| {
            make_draw(gpu, library, draw_key.0, &draw_key.2, blend)
        })?;
        let mut sort = match self.sort.take() {
            Some(sort) => sort,
            None => Sort::new(gpu, library)?,
        };
        sort.prepare(gpu, library, input.n_items)?;
        let sort = &*self.sort.insert(sort);
        let wanted = (through.len().max(1), resolution_of(gpu, look.drawing.slices_resolution, through.len()));
        if self.buffers.as_ref().is_none_or(|buffers| (buffers.n_lights, buffers.resolution) != wanted) {
            self.buffers = None;
            self.buffers = Some(gpu.checked(|| Buffers::new(gpu, wanted.0, wanted.1))?);
        }
        let Some(buffers) = &self.buffers else { return Ok(()) };
        let is_lit = colours != Colours::Given && !through.is_empty();
        let n_slices = if is_lit { look.drawing.n_slices.clamp(1, slicing.n_segments) } else { 1 };
        while self.slices.len() < n_slices as usize {
            self.slices.push(gpu.buffer("half_angle.slice", 16, BufferUsages::UNIFORM));
        }
        let slice = |k: u32| {
            let end = |k: u32| (u64::from(k) * u64::from(slicing.n_segments) / u64::from(n_slices)) as u32;
            end(k)..end(k + 1)
        };
        for k in 0..n_slices {
            let numbers = [slice(k).start, slice(k).len() as u32, k, 0];
            gpu.queue.write_buffer(&self.slices[k as usize], 0, bytemuck::cast_slice(&numbers));
        }
        buffers.send(gpu, input, slicing, through, half_vector, n_slices);

        let mut resources = input.resources.clone();
        resources.extend([
            ("band", buffers.band.as_entire_binding()),
            ("half_angle", buffers.uniform.as_entire_binding()),
            ("half_angle_lights", buffers.lights.as_entire_binding()),
            ("half_angle_map", buffers.map.as_entire_binding()),
            ("keys", sort.keys().as_entire_binding()),
            ("values", sort.values().as_entire_binding()),
            ("order", sort.values().as_entire_binding()),
            ("view_light", buffers.view_light.as_entire_binding()),
        ]);
        let keys = &self.kernels[&keys_key];
        let bindings = keys.bind_used(gpu, &resources)?;
        keys.dispatch_items(&mut encoder.begin_compute_pass(&pass("half_angle.keys")), &bindings, input.n_items);
        sort.record(encoder);
        encoder.clear_buffer(&buffers.map, 0, None);

        // Slice after slice away from the light.
        let draw = &self.draws[&draw_key];
        let drawn = draw.bind_used(gpu, &resources)?;
        let per_segment = vertices_per_segment(draw_key.0);
        for k in 0..n_slices {
            let mut resources = resources.clone();
            resources.push(("half_angle_slice", self.slices[k as usize].as_entire_binding()));
            if let Some(key) = &light_key {
                let kernel = &self.kernels[key];
                let bindings = kernel.bind_used(gpu, &resources)?;
                let mut pass = encoder.begin_compute_pass(&pass("half_angle.light"));
                kernel.dispatch_items(&mut pass, &bindings, 2 * slice(k).len() as u32);
            }
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("half_angle.draw"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: input.hair,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                    })],
                    ..wgpu::RenderPassDescriptor::default()
                });
                draw.draw_range(&mut pass, &drawn, per_segment * slice(k).start..per_segment * slice(k).end);
            }
            if k + 1 < n_slices {
                let splat = &self.kernels[&splat_key];
                let bindings = splat.bind_used(gpu, &resources)?;
                let mut pass = encoder.begin_compute_pass(&pass("half_angle.splat"));
                splat.dispatch_items(&mut pass, &bindings, slice(k).len() as u32);
            }
        }
        Ok(())
    }
}

/// What is drawn later lies behind.
const UNDER: BlendState = {
    let under = BlendComponent {
        src_factor: BlendFactor::OneMinusDstAlpha,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: under, alpha: under }
};

impl Buffers {
    fn new(gpu: &Gpu, n_lights: usize, resolution: u32) -> Self {
        let n_texels = n_lights as u64 * u64::from(resolution).pow(2);
        let storage = |label, n_bytes| gpu.buffer(label, n_bytes, BufferUsages::STORAGE);
        let uniform = |label, n_bytes: usize| gpu.buffer(label, n_bytes as u64, BufferUsages::UNIFORM);
        Self {
            uniform: uniform("half_angle", size_of::<Uniform>()),
            band: uniform("half_angle.band", size_of::<Band>()),
            lights: storage("half_angle.lights", (n_lights * size_of::<ShadowLight>()) as u64),
            map: storage("half_angle.map", 4 * n_texels),
            view_light: uniform("half_angle.view_light", 16),
            n_lights,
            resolution,
        }
    }

    fn send(
        &self,
        gpu: &Gpu,
        input: &FragmentInput<'_>,
        slicing: &Slicing<'_>,
        through: Range<usize>,
        half_vector: Vec3,
        n_slices: u32,
    ) {
        let uniform = Uniform {
            half_vector: half_vector.to_array(),
            density: input.look.shadows.density,
            first_light: through.start as u32,
            n_lights: through.len() as u32,
            resolution: self.resolution,
            n_slices,
        };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let band = Band { n_rows: input.size[1], ..Zeroable::zeroed() };
        gpu.queue.write_buffer(&self.band, 0, bytemuck::bytes_of(&band));
        let shown = [input.look.view_params.light, input.look.view_params.layer, 0, 0];
        gpu.queue.write_buffer(&self.view_light, 0, bytemuck::cast_slice(&shown));
        let view =
            |light: &SceneLight| ShadowLight::new(light, true, slicing.ball, slicing.world_from_head, self.resolution);
        let lights: Vec<ShadowLight> = slicing.lights.lights[through].iter().map(view).collect();
        gpu.queue.write_buffer(&self.lights, 0, bytemuck::cast_slice(&lights));
    }
}

/// The scene's lights (a square lamp is several) of the groom's light of a number, counted from 1; of the next one that is
/// on and casts shadows where that one does not, or the first one. Empty where none does.
fn light_of_slices(lights: &SceneLights, number: u32) -> Range<usize> {
    let asked = number.max(1) - 1;
    let casting = || lights.of_light.iter().zip(&lights.casts_shadow).filter(|(_, casts)| **casts).map(|(of, _)| *of);
    let Some(chosen) = casting().find(|of| *of >= asked).or_else(|| casting().next()) else { return 0..0 };
    let first = lights.of_light.partition_point(|of| *of < chosen);
    first..lights.of_light.partition_point(|of| *of <= chosen)
}

/// Slices lie across it, the first one farthest along it; and whether they go from the eye on. Without lights: the way to
/// the eye.
fn half_vector(slicing: &Slicing<'_>, lights: &[SceneLight]) -> (Vec3, bool) {
    let centre = slicing.world_from_head.transform_point3(slicing.ball.centre);
    let way = |light: &SceneLight| {
        let place = Vec3::from_slice(&light.place[..3]);
        if light.place[3] == 0.0 { place } else { (place - centre).normalize_or_zero() }
    };
    let to_light: Vec3 = lights.iter().map(way).sum::<Vec3>().normalize_or(slicing.to_eye);
    let is_front_first = to_light.dot(slicing.to_eye) >= 0.0;
    let to_eye = if is_front_first { slicing.to_eye } else { -slicing.to_eye };
    ((to_light + to_eye).normalize_or(to_light), is_front_first)
}

fn colours_of(look: &Look, has_light: bool) -> Colours {
    if !look.view.is_light() {
        let shows_shadow = has_light && matches!(look.view, FalseColour::Transmittance | FalseColour::ShadowLayer);
        return if shows_shadow { Colours::Shown } else { Colours::Given };
    }
    match look.shading_rate {
        ShadingRate::PerFragment => Colours::Fragments,
        ShadingRate::PerVertex if has_light => Colours::Vertices,
        ShadingRate::PerVertex => Colours::Given,
    }
}

/// Of what shades a slice: its shadow comes from the light's buffer.
fn links_of_slice(look: &Look, colours: Colours) -> Vec<Link<'static>> {
    let mut links = match colours {
        Colours::Given => Vec::new(),
        Colours::Vertices | Colours::Fragments => shade::links(look),
        Colours::Shown => {
            let mut links = slot::shadowing(look.shadowing);
            links.extend([slot::view_colour(look.view), Link::Slot("shadow_part", "shadow_part_half_angle")]);
            links
        }
    };
    for link in &mut links {
        if let Link::Slot(slot @ "shadow", _) = link {
            *slot = "shadow_others";
        }
    }
    if colours != Colours::Given {
        links.push(Link::Slot("shadow", "shadow_half_angle"));
    }
    links
}

fn links_of_draw(look: &Look, colours: Colours) -> Vec<Link<'static>> {
    let mut links = vec![slot::antialiasing(look.antialiasing)];
    if colours == Colours::Fragments {
        links.extend(links_of_slice(look, colours));
        links.push(Link::Slot("radiance", "radiance_fragment"));
    } else {
        links.push(Link::Slot("radiance", "radiance_vertex"));
    }
    links
}

/// Texels of a side: what was asked for, or as many as one binding shows.
fn resolution_of(gpu: &Gpu, asked: u32, n_lights: usize) -> u32 {
    let most = (gpu.max_storage_binding() / 4 / n_lights.max(1) as u64).isqrt() as u32;
    if most < asked {
        log::warn!(
            "the light buffer of half-angle slices has {most} texels a side and not {asked}: this GPU binds no more"
        );
    }
    asked.clamp(8, most.max(8))
}

fn pass(label: &str) -> wgpu::ComputePassDescriptor<'_> {
    wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None }
}

#[cfg(test)]
#[path = "half_angle_tests.rs"]
mod tests;
