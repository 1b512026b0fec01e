//! Transparency by passes over all fragments, in any order: each pass hands every fragment of every strand to a sink, which
//! counts, adds or compares into buffers of the pixel; a last kernel makes the pixel from them.
//!
//! ```text
//! technique.rs          which passes, which buffers
//! fragments_splat.wgsl  primitive `compute`: a thread walks the pixels of a segment
//! fragments_draw.wgsl   primitives `ribbons` and `polylines`: the graphics pipeline finds them, and writes no colour
//! fragments_*.wgsl      slot `sink`: what is done to a fragment
//! composite_*.wgsl      pixels from what the sinks have gathered
//! blended.rs            what needs an order instead: sorted segments, blended by the graphics pipeline
//! half_angle.rs         the same in slices that light one another
//! ```
//!
//! So a technique is written once, whatever draws it. Where buffers of the whole picture are too large for the device
//! or for [`MOST_BYTES`], the picture is made in bands of rows.
//!
//! Rejected: fixed-function depth test and blending for each technique (every one written again for the compute path, and
//! occupancy bits and sorted depths cannot be blended); 64-bit atomics for depth and colour in one pass (not on every
//! device; two passes of 32 bits give the same picture).

mod blended;
mod half_angle;
mod technique;

#[cfg(test)]
mod hashed_tests;

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use lorelei_core::look::{Look, Primitive};
use lorelei_shaders::{Draw, DrawDescriptor, Gpu, GpuError, Hot, Kernel, Link, ShaderError, ShaderLibrary, grid_1d};
use wgpu::BufferUsages;

use crate::frame::COLOUR;
use crate::slot;

pub(crate) use blended::Blended;
pub(crate) use half_angle::{HalfAngle, Slicing};
pub(crate) use technique::{Technique, Way, way};

/// Bytes of all buffers together, at most; more rows of the picture at a time are hardly faster.
const MOST_BYTES: u64 = 768 << 20;

/// Twin of `Band`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct Band {
    first_row: u32,
    n_rows: u32,
    n_samples: u32,
    n_all_samples: u32,
    first_sample: u32,
    seed: u32,
    n_nearest: u32,
    cutoff: f32,
}

/// What all fragments come from, by the names of the shaders.
pub(crate) type Resources<'a> = Vec<(&'static str, wgpu::BindingResource<'a>)>;

/// What the fragments of a frame are made from and go to.
pub(crate) struct FragmentInput<'a> {
    pub look: &'a Look,
    /// `raster`, `raster_layers`, `vertices`, `seeds`, `head_depth`, `head_colour`, `radiance` and whatever else shades a
    /// fragment.
    pub resources: &'a Resources<'a>,
    /// Vertices of drawn strands.
    pub n_items: u32,
    /// Where the hair goes, and its size in pixels.
    pub hair: &'a wgpu::TextureView,
    pub size: [u32; 2],
}

/// What decides about the shaders of a pass over all fragments.
type PassKey = (Primitive, Vec<Link<'static>>);

enum Pass {
    Splat(Kernel),
    Draw(Draw),
}

/// The passes over all fragments, with their buffers.
pub(crate) struct Fragments {
    passes: HashMap<PassKey, Hot<Pass>>,
    composites: HashMap<&'static str, Hot<Kernel>>,
    plans: Hot<[Kernel; 2]>,
    buffers: HashMap<&'static str, wgpu::Buffer>,
    bands: Vec<wgpu::Buffer>,
    /// What the passes of a repeat are dispatched with, where something is left; and as it is now.
    full_arguments: wgpu::Buffer,
    arguments: wgpu::Buffer,
    n_peeled: wgpu::Buffer,
}

impl Fragments {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            passes: HashMap::new(),
            composites: HashMap::new(),
            plans: Hot::new(library, |library| make_plans(gpu, library))?,
            buffers: HashMap::new(),
            bands: Vec::new(),
            full_arguments: gpu.buffer("fragments.full_arguments", 64, BufferUsages::STORAGE),
            arguments: gpu.buffer("fragments.arguments", 64, BufferUsages::STORAGE | BufferUsages::INDIRECT),
            n_peeled: gpu.buffer("fragments.n_peeled", 16, BufferUsages::STORAGE),
        })
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        let of_passes = self.passes.values().find_map(Hot::error);
        of_passes.or(self.composites.values().find_map(Hot::error)).or(self.plans.error())
    }

    pub fn n_bytes(&self) -> u64 {
        self.buffers.values().map(wgpu::Buffer::size).sum()
    }

    /// Let go of the buffers: another technique draws now.
    pub fn release(&mut self) {
        self.buffers.clear();
    }

    /// Record all passes of a technique into `input.hair`, which was cleared.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        technique: &Technique,
        input: &FragmentInput<'_>,
    ) -> Result<(), crate::RenderError> {
        self.refresh(gpu, library, technique, input.look)?;
        let [width, height] = input.size;
        let n_rows = rows_at_a_time(gpu, technique, input.size)?;
        self.make_room(gpu, technique, u64::from(width) * u64::from(n_rows))?;
        let params = &input.look.drawing;
        let n_bands = height.div_ceil(n_rows);
        let n_uniforms = (n_bands * technique.n_repeats) as usize;
        while self.bands.len() < n_uniforms {
            self.bands.push(gpu.buffer("fragments.band", size_of::<Band>() as u64, BufferUsages::UNIFORM));
        }
        for band_idx in 0..n_bands {
            let first_row = band_idx * n_rows;
            let band = Band {
                first_row,
                n_rows: n_rows.min(height - first_row),
                n_samples: technique.n_samples,
                n_all_samples: technique.n_all_samples,
                first_sample: 0,
                seed: params.seed,
                n_nearest: params.n_nearest.max(1),
                cutoff: params.alpha_cutoff,
            };
            self.record_band(gpu, encoder, technique, input, (band_idx * technique.n_repeats) as usize, band)?;
        }
        Ok(())
    }

    fn record_band(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        technique: &Technique,
        input: &FragmentInput<'_>,
        first_uniform: usize,
        band: Band,
    ) -> Result<(), ShaderError> {
        for (name, _) in &technique.words {
            encoder.clear_buffer(&self.buffers[name], 0, None);
        }
        let n_pixels = band.n_rows * input.size[0];
        let composite = &self.composites[technique.composite];
        if technique.stops {
            // Compute what the passes of every repeat take: splat, composite, draw.
            let per_segment = vertices_per_segment(input.look.primitive);
            let [a, b, c] = grid_1d(input.n_items, 64);
            let [d, e, f] = grid_1d(n_pixels, 64);
            let full = [a, b, c, 0, d, e, f, 0, input.n_items * per_segment, 1, 0, 0];
            gpu.queue.write_buffer(&self.full_arguments, 0, bytemuck::cast_slice(&full));
        }
        for repeat in 0..technique.n_repeats {
            let uniform = &self.bands[first_uniform + repeat as usize];
            let contents = Band { first_sample: repeat * technique.n_samples, ..band };
            gpu.queue.write_buffer(uniform, 0, bytemuck::bytes_of(&contents));
            let mut resources = input.resources.clone();
            resources.push(("band", uniform.as_entire_binding()));
            resources.push(("hair", wgpu::BindingResource::TextureView(input.hair)));
            resources.push(("n_peeled", self.n_peeled.as_entire_binding()));
            resources.push(("full_arguments", self.full_arguments.as_entire_binding()));
            resources.push(("arguments", self.arguments.as_entire_binding()));
            resources.extend(technique.words.iter().map(|(name, _)| (*name, self.buffers[name].as_entire_binding())));
            if technique.stops {
                let plan = &self.plans[usize::from(repeat == 0)];
                let bindings = plan.bind_used(gpu, &resources)?;
                let mut pass = encoder.begin_compute_pass(&compute("fragments.plan"));
                plan.dispatch(&mut pass, &bindings, [1, 1, 1]);
            }
            for &sink in &technique.sinks {
                match &*self.passes[&key_of(input.look, technique, sink)] {
                    Pass::Splat(kernel) => {
                        let bindings = kernel.bind_used(gpu, &resources)?;
                        let mut pass = encoder.begin_compute_pass(&compute(sink));
                        if technique.stops {
                            kernel.dispatch_indirect(&mut pass, &bindings, &self.arguments, 0);
                        } else {
                            kernel.dispatch_items(&mut pass, &bindings, input.n_items);
                        }
                    }
                    Pass::Draw(draw) => {
                        let bindings = draw.bind_used(gpu, &resources)?;
                        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                            label: Some(sink),
                            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                                view: input.hair,
                                depth_slice: None,
                                resolve_target: None,
                                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                            })],
                            ..wgpu::RenderPassDescriptor::default()
                        });
                        pass.set_scissor_rect(0, band.first_row, input.size[0], band.n_rows);
                        if technique.stops {
                            draw.draw_indirect(&mut pass, &bindings, &self.arguments, 32);
                        } else {
                            let per_segment = vertices_per_segment(input.look.primitive);
                            draw.draw(&mut pass, &bindings, input.n_items * per_segment);
                        }
                    }
                }
            }
            let bindings = composite.bind_used(gpu, &resources)?;
            let mut pass = encoder.begin_compute_pass(&compute(technique.composite));
            if technique.stops {
                composite.dispatch_indirect(&mut pass, &bindings, &self.arguments, 16);
            } else {
                composite.dispatch_items(&mut pass, &bindings, n_pixels);
            }
        }
        Ok(())
    }

    fn refresh(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        technique: &Technique,
        look: &Look,
    ) -> Result<(), ShaderError> {
        for &sink in &technique.sinks {
            let key = key_of(look, technique, sink);
            let make = |library: &ShaderLibrary| make_pass(gpu, library, &key);
            Hot::have(&mut self.passes, library, &key, make)?;
        }
        let make = |library: &ShaderLibrary| library.kernel(gpu, technique.composite, "composite", &[], &[]);
        if let Some(kernel) = self.composites.get_mut(technique.composite) {
            kernel.refresh(library, make);
        } else {
            self.composites.insert(technique.composite, Hot::new(library, make)?);
        }
        self.plans.refresh(library, |library| make_plans(gpu, library));
        Ok(())
    }

    /// Buffers for so many pixels; those that this technique has no use for go.
    fn make_room(&mut self, gpu: &Gpu, technique: &Technique, n_pixels: u64) -> Result<(), GpuError> {
        self.buffers.retain(|name, _| technique.words.iter().any(|(used, _)| used == name));
        gpu.checked(|| {
            for &(name, words) in &technique.words {
                let size = (n_pixels * u64::from(words) * 4).next_multiple_of(16).max(256);
                if self.buffers.get(name).is_none_or(|buffer| buffer.size() != size) {
                    self.buffers.insert(name, gpu.buffer(name, size, BufferUsages::STORAGE));
                }
            }
        })
    }
}

fn key_of(look: &Look, technique: &Technique, sink: &'static str) -> PassKey {
    let mut links = technique.links(sink);
    links.push(slot::antialiasing(look.antialiasing));
    links.extend(slot::shading_rate(look));
    (look.primitive, links)
}

/// What does not fit.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "a row of {width} pixels needs {needed} bytes in one buffer for this transparency and the GPU binds {available}; make the picture narrower"
)]
pub struct TooWide {
    pub width: u32,
    pub needed: u64,
    pub available: u64,
}

/// Rows of which all buffers fit the device.
fn rows_at_a_time(gpu: &Gpu, technique: &Technique, [width, height]: [u32; 2]) -> Result<u32, TooWide> {
    let words = technique.words.iter().map(|(_, words)| u64::from(*words));
    let (most, all) = (words.clone().max().unwrap_or(1), words.sum::<u64>().max(1));
    let row = 4 * u64::from(width);
    let available = gpu.max_storage_binding();
    let rows = (available / (row * most)).min((MOST_BYTES / (row * all)).max(1)).min(u64::from(height));
    if rows == 0 { Err(TooWide { width, needed: row * most, available }) } else { Ok(rows as u32) }
}

fn vertices_per_segment(primitive: Primitive) -> u32 {
    match primitive {
        Primitive::Ribbons | Primitive::Compute => 6,
        Primitive::Polylines => 2,
    }
}

fn compute(label: &str) -> wgpu::ComputePassDescriptor<'_> {
    wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None }
}

/// The shaders of a pass over all fragments.
fn make_pass(gpu: &Gpu, library: &ShaderLibrary, (primitive, links): &PassKey) -> Result<Pass, ShaderError> {
    let (vertex, fragment, topology) = match primitive {
        Primitive::Compute => return library.kernel(gpu, "fragments_splat", "splat", &[], links).map(Pass::Splat),
        Primitive::Ribbons => ("strip", "strip_fragment", wgpu::PrimitiveTopology::TriangleList),
        Primitive::Polylines => ("line", "line_fragment", wgpu::PrimitiveTopology::LineList),
    };
    // A pass must have a target; its fragments write to buffers.
    let target = wgpu::ColorTargetState { format: COLOUR, blend: None, write_mask: wgpu::ColorWrites::empty() };
    let descriptor = DrawDescriptor {
        vertex,
        fragment: Some(fragment),
        links,
        primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
        targets: &[Some(target)],
        ..DrawDescriptor::default()
    };
    library.draw(gpu, "fragments_draw", &descriptor).map(Pass::Draw)
}

fn make_plans(gpu: &Gpu, library: &ShaderLibrary) -> Result<[Kernel; 2], ShaderError> {
    let plan = |is_first: f64| library.kernel(gpu, "peel_plan", "plan", &[("IS_FIRST", is_first)], &[]);
    Ok([plan(0.0)?, plan(1.0)?])
}
