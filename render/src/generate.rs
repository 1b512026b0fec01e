//! All strand vertices, every frame, on the GPU: one dispatch a layer of `generate.wgsl`.
//!
//! Guides may move every frame without leaving the GPU: the solver's buffer is bound where the mirror's
//! own would be. Keeping last frame's vertices while nothing moves was rejected: making them costs less
//! than finding out.

use std::collections::HashMap;

use glam::Affine3A;
use lorelei_core::generate::Lod;
use lorelei_core::groom::Groom;
use lorelei_core::io::Watch;
use lorelei_core::lod::{LodBlend, MOST_WIDER};
use lorelei_core::maps::MapKind;
use lorelei_core::simulation::Interpolated;
use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::bound::Bound;
use crate::mirror::{DrawnLayer, LayerMirror, Mirror, MirrorError, Sort, StrandBuffers};
use crate::overlay::Veil;
use crate::raster::fit;

/// Makes the strands of a groom.
pub struct StrandGenerator {
    kernels: HashMap<Variant, Hot<Kernel>>,
    /// Control points are blended before strands are made: see generate.wgsl. A CPU gains nothing by it.
    blends_before: bool,
    /// Those control points, of one layer after the other.
    paths: wgpu::Buffer,
    /// Where strands enter the head, of one layer after the other.
    hits: wgpu::Buffer,
    mirror: Mirror,
    params: Vec<wgpu::Buffer>,
}

/// What a kernel of generate.wgsl is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    pass: Pass,
    /// How strands between moved guides are kept out of the head.
    interpolated: Interpolated,
}

/// What of the work a kernel does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Pass {
    /// Where strands enter the head.
    Hits,
    /// Strands that blend their control points themselves.
    Direct(Sort),
    /// Strands from control points that are there; all styles, or those that
    /// [`Plan::is_plain`](lorelei_core::generate::plan::Plan::is_plain) says are plain.
    FromPaths { is_full: bool },
    /// The control points; ironed or as they are.
    Paths { irons: bool },
    /// Strands that were moved themselves, where they are now.
    Place,
}

impl Variant {
    fn make(self, library: &ShaderLibrary, gpu: &Gpu) -> Result<Kernel, ShaderError> {
        if self.pass == Pass::Place {
            return library.kernel(gpu, "place_moved", "place_strands", &[], &[]);
        }
        let (entry, is_full, of_pass): (_, _, &[&str]) = match self.pass {
            Pass::Hits | Pass::Place => ("find_hits", true, &["FINDS_HITS"]),
            Pass::Direct(Sort::Plain) => ("generate", false, &[]),
            Pass::Direct(Sort::Full) => ("generate", true, &[]),
            Pass::Direct(Sort::Ironing) => ("generate", true, &["IRONS"]),
            Pass::FromPaths { is_full } => ("generate", is_full, &["READS_PATHS"]),
            Pass::Paths { irons: false } => ("make_paths", true, &["MAKES_PATHS"]),
            Pass::Paths { irons: true } => ("make_paths", true, &["MAKES_PATHS", "IRONS"]),
        };
        let of_choice: &[&str] = match (self.interpolated, self.pass) {
            (Interpolated::SingleGuide, Pass::Direct(_) | Pass::Paths { .. }) => &["READS_HITS"],
            (Interpolated::Free, Pass::Direct(_) | Pass::FromPaths { .. }) => &["FREE"],
            (_, _) => &[],
        };
        let defs: Vec<Link<'_>> = of_pass.iter().chain(of_choice).map(|&name| Link::Def(name)).collect();
        library.kernel(gpu, "generate", entry, &[("FULL", f64::from(u8::from(is_full)))], &defs)
    }
}

/// What of a layer has moved, in world space: `array<vec4<f32>>`.
#[derive(Debug, Clone, Copy, Default)]
pub enum MovedLayer<'a> {
    /// It rests on the head.
    #[default]
    Nothing,
    /// Its guides.
    Guides(&'a wgpu::Buffer),
    /// Its strands, of `n_vertices` each, in their order.
    Strands { positions: &'a wgpu::Buffer, n_vertices: u32 },
}

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy)]
pub struct StrandPose<'a> {
    pub world_from_head: Affine3A,
    /// Per layer; a list that ends earlier: at rest.
    pub moved: &'a [MovedLayer<'a>],
    /// Level of detail: share of the strands that are drawn, 0-1.
    pub lod: f32,
    /// The levels that are blended; their share of the strands comes on top of `lod`.
    pub blend: LodBlend,
    /// How much of the hair is drawn where a painted map is looked at.
    pub veil: Veil,
}

/// Twin of `Params` in generate.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Params {
    world_from_head: [[f32; 4]; 3],
    head_from_world: [[f32; 4]; 3],
    world_from_guides: [[f32; 4]; 3],
    field_min: [f32; 3],
    field_cell: f32,
    field_n: [u32; 3],
    n_drawn: u32,
    n_vertices: u32,
    guide_vertices: u32,
    first_vertex: u32,
    n_ops: u32,
    n_sizes: u32,
    radius: f32,
    tip_radius: f32,
    offset_at_tip: f32,
    lod_scale: f32,
    lod_end: f32,
    lod_fade: f32,
    smooth_op: u32,
    wisp_size: u32,
    n_maps: u32,
    length_map: u32,
    width_map: u32,
    lod_maps: [u32; 4],
    lod_between: f32,
    n_sculpt: u32,
    n_paths: u32,
    pad: u32,
}

/// Twin of `PlaceParams` in place_moved.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct PlaceParams {
    first_vertex: u32,
    n_vertices: u32,
    n_moved: u32,
    n_strands: u32,
}

impl PlaceParams {
    /// For strands of `n_moved` vertices each, and how many vertices are placed; strands that were not moved stay where they
    /// rest.
    fn new(drawn: DrawnLayer, positions: &wgpu::Buffer, n_moved: u32) -> (Self, u32) {
        let n_moved = n_moved.max(2);
        let n_strands = u64::from(drawn.n_strands).min(positions.size() / (16 * u64::from(n_moved))) as u32;
        let (first_vertex, n_vertices) = (drawn.first_vertex, drawn.vertices_per_strand);
        (Self { first_vertex, n_vertices, n_moved, n_strands }, n_strands * n_vertices)
    }
}

impl StrandGenerator {
    pub fn new(gpu: &Gpu) -> Self {
        Self::blending_before(gpu, gpu.adapter_info.device_type != wgpu::DeviceType::Cpu)
    }

    fn blending_before(gpu: &Gpu, blends_before: bool) -> Self {
        Self {
            kernels: HashMap::new(),
            blends_before,
            paths: gpu.buffer("generate.paths", 0, BufferUsages::STORAGE),
            hits: gpu.buffer("generate.hits", 0, BufferUsages::STORAGE),
            mirror: Mirror::new(gpu),
            params: Vec::new(),
        }
    }

    /// Take over what changed in the groom. Returns what the user should know.
    pub fn set_groom(&mut self, gpu: &Gpu, groom: &Groom) -> Result<Vec<String>, MirrorError> {
        let bound = self.mirror.bound().update(groom, Watch::default()).unwrap_or_default();
        self.mirror.set_bound(gpu, groom, bound)
    }

    /// As [`StrandGenerator::set_groom`], where the strands were bound already.
    pub fn set_bound(&mut self, gpu: &Gpu, groom: &Groom, bound: Bound) -> Result<Vec<String>, MirrorError> {
        self.mirror.set_bound(gpu, groom, bound)
    }

    pub fn mirror(&self) -> &Mirror {
        &self.mirror
    }

    /// The strands as the last recorded frame makes them.
    pub fn strands(&self) -> &StrandBuffers {
        self.mirror.strands()
    }

    /// Why the last edit of the shader is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.values().find_map(Hot::error)
    }

    /// Send this frame's numbers and bind each drawn layer; `record` then dispatches. Call once a frame.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        pose: &StrandPose<'_>,
    ) -> Result<PreparedStrands, MirrorError> {
        let reads_maps = |layer: &LayerMirror| pose.blend.maps(&layer.binding).iter().any(Option::is_some);
        let mut dispatches = Vec::new();
        self.mirror.buffers.layers.clear();
        self.mirror.buffers.widest = 0.0;
        while self.params.len() < self.mirror.layers.len() {
            let size = size_of::<Params>() as u64;
            self.params.push(gpu.buffer("generate.params", size, BufferUsages::UNIFORM));
        }
        let field = self.mirror.field().cloned();
        for (layer_idx, (layer, params_buffer)) in self.mirror.layers.iter().zip(&self.params).enumerate() {
            let Some(place) = layer.place else { continue };
            let moved = pose.moved.get(layer_idx).copied().unwrap_or_default();
            let (moved, moved_strands) = match moved {
                MovedLayer::Nothing => (None, None),
                MovedLayer::Guides(guides) => (Some(guides), None),
                MovedLayer::Strands { positions, n_vertices } => (None, Some((positions, n_vertices))),
            };
            let world_from_guides = if moved.is_some() { Affine3A::IDENTITY } else { pose.world_from_head };
            let lod = match pose.veil {
                Veil::Full => layer.lod(pose.lod * pose.blend.strands),
                Veil::Thin => Lod { scale: 1.0, ..layer.lod(pose.lod * pose.blend.strands * Veil::THIN) },
                Veil::Hidden => continue,
            };
            let place = DrawnLayer { vertices_per_strand: pose.blend.n_vertices(place.vertices_per_strand), ..place };
            let lod_maps = pose.blend.maps(&layer.binding);
            let params = Params {
                world_from_head: rows(&pose.world_from_head),
                head_from_world: rows(&pose.world_from_head.inverse()),
                world_from_guides: rows(&world_from_guides),
                field_min: field.as_ref().map_or([0.0; 3], |field| field.min.to_array()),
                field_cell: field.as_ref().map_or(1.0, |field| field.cell),
                field_n: field.as_ref().map_or([0; 3], |field| field.n),
                n_drawn: lod.n_drawn,
                n_vertices: place.vertices_per_strand,
                guide_vertices: layer.binding.guides.n_vertices,
                first_vertex: place.first_vertex,
                n_ops: layer.plan.n_ops,
                n_sizes: layer.binding.clumps.sizes.len() as u32,
                radius: layer.layer.radius_um * 1e-4 * pose.blend.thickness,
                tip_radius: layer.layer.tip_radius,
                offset_at_tip: layer.binding.offset_at_tip,
                lod_scale: lod.scale,
                lod_end: lod.end,
                lod_fade: lod.fade,
                smooth_op: layer.plan.smooth_op,
                wisp_size: layer.plan.wisp_size,
                n_maps: layer.binding.maps.len() as u32,
                length_map: layer.plan.length_map,
                width_map: layer.plan.width_map,
                lod_maps: lod_maps.map(|map| map.map_or(u32::MAX, |map| map as u32)),
                lod_between: pose.blend.between,
                n_sculpt: layer.composite.guides.len() as u32,
                n_paths: layer.binding.n_strands() as u32,
                pad: 0,
            };
            let wider = |maps: &[Option<usize>], most: f32| if maps.iter().any(Option::is_some) { most } else { 1.0 };
            let painted =
                wider(&lod_maps[..2], MOST_WIDER) * wider(&lod_maps[2..], MapKind::LodThickness(0).max_value());
            let widest = params.radius * lod.scale * layer.widest_scale * painted;
            self.mirror.buffers.widest = self.mirror.buffers.widest.max(widest);
            gpu.queue.write_buffer(params_buffer, 0, bytemuck::bytes_of(&params));
            // The plain kernel reads no maps.
            let sort = if reads_maps(layer) && layer.sort() == Sort::Plain { Sort::Full } else { layer.sort() };
            let n_points = u64::from(params.n_paths) * u64::from(params.guide_vertices);
            // Where few of the strands are drawn, most of what was blended would be for nothing.
            let is_worth_it = 2 * u64::from(lod.n_drawn) >= u64::from(params.n_paths);
            let from_paths = self.blends_before
                && is_worth_it
                && n_points * 16 <= gpu.max_storage_binding()
                && u32::try_from(n_points).is_ok();
            if from_paths {
                gpu.checked(|| fit(gpu, &mut self.paths, n_points * 16))?;
            }
            let interpolated = if moved.is_some() { self.mirror.interpolated } else { Interpolated::Pushed };
            // Without a head there is nothing to hit.
            let interpolated = if field.is_some() { interpolated } else { Interpolated::Pushed };
            let finds_hits = interpolated == Interpolated::SingleGuide;
            if finds_hits {
                gpu.checked(|| fit(gpu, &mut self.hits, u64::from(params.n_paths) * 16))?;
            }
            let resources = [
                ("params", params_buffer.as_entire_binding()),
                ("guides", moved.unwrap_or(&layer.guides).as_entire_binding()),
                ("strands", layer.strands.as_entire_binding()),
                ("influences", layer.influences.as_entire_binding()),
                ("middles", layer.middles.as_entire_binding()),
                ("ops", layer.ops.as_entire_binding()),
                ("curves", layer.curves.as_entire_binding()),
                ("map_values", layer.map_values.as_entire_binding()),
                ("sculpt", layer.sculpt.as_entire_binding()),
                ("field", self.mirror.field_buffer.as_entire_binding()),
                ("knots", layer.knots.as_entire_binding()),
                ("paths", self.paths.as_entire_binding()),
                ("rest_guides", layer.guides.as_entire_binding()),
                ("hits", self.hits.as_entire_binding()),
                ("vertices", self.mirror.buffers.vertices.as_entire_binding()),
            ];
            let of_hits = (Pass::Hits, params.n_paths);
            let of_paths = (Pass::Paths { irons: sort == Sort::Ironing }, n_points as u32);
            let of_strands = if from_paths {
                (Pass::FromPaths { is_full: sort != Sort::Plain }, lod.n_drawn)
            } else {
                (Pass::Direct(sort), lod.n_drawn)
            };
            let passes = finds_hits.then_some(of_hits).into_iter().chain(from_paths.then_some(of_paths));
            for (pass, n_items) in passes.chain([of_strands]) {
                let variant = Variant { pass, interpolated };
                let make = |library: &ShaderLibrary| variant.make(library, gpu);
                Hot::have(&mut self.kernels, library, &variant, make)?;
                let bindings = self.kernels[&variant].bind_used(gpu, &resources)?;
                dispatches.push(Dispatch { bindings, n_items, variant });
            }
            if let Some((positions, n_moved)) = moved_strands {
                let drawn = DrawnLayer { n_strands: lod.n_drawn, ..place };
                let (params, n_items) = PlaceParams::new(drawn, positions, n_moved);
                let params = gpu.buffer_of("generate.place", &[params], BufferUsages::UNIFORM);
                let variant = Variant { pass: Pass::Place, interpolated: Interpolated::Pushed };
                Hot::have(&mut self.kernels, library, &variant, |library| variant.make(library, gpu))?;
                let resources = [
                    ("place", params.as_entire_binding()),
                    ("moved", positions.as_entire_binding()),
                    ("vertices", self.mirror.buffers.vertices.as_entire_binding()),
                ];
                let bindings = self.kernels[&variant].bind(gpu, &resources)?;
                dispatches.push(Dispatch { bindings, n_items, variant });
            }
            self.mirror.buffers.layers.push(DrawnLayer { n_strands: lod.n_drawn, ..place });
        }
        Ok(PreparedStrands { dispatches })
    }

    /// Record the dispatches of a prepared frame.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, prepared: &PreparedStrands) {
        for Dispatch { bindings, n_items, variant } in &prepared.dispatches {
            self.kernels[variant].dispatch_items(pass, bindings, *n_items);
        }
    }

    /// Bytes of the control points and of the places where strands enter the head.
    pub fn n_bytes(&self) -> u64 {
        self.paths.size() + self.hits.size()
    }
}

/// A frame's dispatches.
#[derive(Debug)]
pub struct PreparedStrands {
    dispatches: Vec<Dispatch>,
}

/// One of a layer's.
#[derive(Debug)]
struct Dispatch {
    bindings: Bindings,
    n_items: u32,
    variant: Variant,
}

/// The rows of a transform: rotation and scale, then the translation.
fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let m = transform.matrix3;
    let t = transform.translation;
    [0, 1, 2].map(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]])
}

#[cfg(test)]
#[path = "generate_tests.rs"]
mod tests;
