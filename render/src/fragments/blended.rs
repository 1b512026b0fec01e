//! Segments sorted on the GPU from back to front and blended by the graphics pipeline, as strips or as lines: what the
//! references describe and what the compute rasteriser is measured against.

use std::collections::HashMap;

use lorelei_core::look::{Look, Primitive};
use lorelei_shaders::{Draw, DrawDescriptor, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use super::{Band, FragmentInput, vertices_per_segment};
use crate::frame::COLOUR;
use crate::slot;
use crate::sort::Sort;

/// Sorts segments and blends them.
pub(crate) struct Blended {
    keys: Hot<Kernel>,
    sort: Sort,
    draws: HashMap<(Primitive, Vec<Link<'static>>), Hot<Draw>>,
    band: wgpu::Buffer,
}

impl Blended {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            keys: Hot::new(library, |library| make_keys(gpu, library))?,
            sort: Sort::new(gpu, library)?,
            draws: HashMap::new(),
            band: gpu.buffer("blended.band", size_of::<Band>() as u64, BufferUsages::UNIFORM),
        })
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.draws.values().find_map(Hot::error).or(self.keys.error()).or(self.sort.shader_error())
    }

    pub fn n_bytes(&self) -> u64 {
        self.sort.n_bytes()
    }

    /// Record sorting and drawing into `input.hair`, which was cleared.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &FragmentInput<'_>,
    ) -> Result<(), crate::RenderError> {
        let look = input.look;
        self.keys.refresh(library, |library| make_keys(gpu, library));
        let primitive = drawn_primitive(look);
        let key = (primitive, links_of(look));
        let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        let make = |library: &ShaderLibrary| make_draw(gpu, library, primitive, &key.1, over);
        Hot::have(&mut self.draws, library, &key, make)?;
        self.sort.prepare(gpu, library, input.n_items)?;
        let band = Band { n_rows: input.size[1], ..bytemuck::Zeroable::zeroed() };
        gpu.queue.write_buffer(&self.band, 0, bytemuck::bytes_of(&band));

        let mut resources = input.resources.clone();
        resources.push(("band", self.band.as_entire_binding()));
        resources.push(("keys", self.sort.keys().as_entire_binding()));
        resources.push(("values", self.sort.values().as_entire_binding()));
        resources.push(("order", self.sort.values().as_entire_binding()));
        let bindings = self.keys.bind_used(gpu, &resources)?;
        {
            let descriptor = wgpu::ComputePassDescriptor { label: Some("blended.keys"), timestamp_writes: None };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            self.keys.dispatch_items(&mut pass, &bindings, input.n_items);
        }
        self.sort.record(encoder);
        let draw = &self.draws[&key];
        let bindings = draw.bind_used(gpu, &resources)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("blended.draw"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: input.hair,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        draw.draw(&mut pass, &bindings, input.n_items * vertices_per_segment(primitive));
        Ok(())
    }
}

/// Strips stand for what is drawn by the compute path, too: there is nothing to blend with.
pub(super) fn drawn_primitive(look: &Look) -> Primitive {
    match look.primitive {
        Primitive::Compute | Primitive::Ribbons => Primitive::Ribbons,
        Primitive::Polylines => Primitive::Polylines,
    }
}

fn make_keys(gpu: &Gpu, library: &ShaderLibrary) -> Result<Kernel, ShaderError> {
    library.kernel(gpu, "ribbons_keys", "write_keys", &[], &[])
}

fn links_of(look: &Look) -> Vec<Link<'static>> {
    let mut links = vec![slot::antialiasing(look.antialiasing)];
    links.extend(slot::shading_rate(look));
    links
}

/// The segments of a list (`order` of ribbons.wgsl) blended one after the other.
pub(super) fn make_draw(
    gpu: &Gpu,
    library: &ShaderLibrary,
    primitive: Primitive,
    links: &[Link<'static>],
    blend: wgpu::BlendState,
) -> Result<Draw, ShaderError> {
    let (vertex, fragment, topology) = match primitive {
        Primitive::Compute | Primitive::Ribbons => ("strip", "strip_fragment", wgpu::PrimitiveTopology::TriangleList),
        Primitive::Polylines => ("line", "line_fragment", wgpu::PrimitiveTopology::LineList),
    };
    let target = wgpu::ColorTargetState { format: COLOUR, blend: Some(blend), write_mask: wgpu::ColorWrites::ALL };
    let descriptor = DrawDescriptor {
        vertex,
        fragment: Some(fragment),
        links,
        primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
        targets: &[Some(target)],
        ..DrawDescriptor::default()
    };
    library.draw(gpu, "ribbons", &descriptor)
}
