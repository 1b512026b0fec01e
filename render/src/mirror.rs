//! The groom on the GPU: what of it is there, and that only what changed is sent.
//!
//! Each layer keeps what it was made from. The same source, head, count, seed and density keep its guides,
//! roots and weights; another style sends operators and clump middles; widths, colours and the level of
//! detail send nothing but the few numbers of a dispatch. All strands of all layers share one vertex
//! buffer, so that every later pass is one pass.

use std::sync::Arc;

use lorelei_core::binding::LayerBinding;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::generate::Lod;
use lorelei_core::generate::plan::{Plan, Step};
use lorelei_core::groom::{Groom, Layer};
use lorelei_core::maps::MapKind;
use lorelei_core::sculpt::{Composite, SculptRoots, compose::Composed};
use lorelei_core::simulation::Interpolated;
use lorelei_core::style::Blend;
use lorelei_shaders::{Gpu, GpuError, ShaderError};
use wgpu::BufferUsages;

use crate::bound::{Bound, BoundLayer};

/// Why strands cannot be made on this GPU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MirrorError {
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(
        "{what} of layer {layer} need {needed} MiB and this GPU binds {available} MiB at once: use fewer strands, or fewer points each"
    )]
    TooLarge { layer: String, what: &'static str, needed: u64, available: u64 },
}

/// The strands of a layer in the shared buffers. Strand `s` has the vertices from
/// `first_vertex + s * vertices_per_strand`, and its seed at `first_strand + s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DrawnLayer {
    pub first_vertex: u32,
    pub first_strand: u32,
    /// Drawn at the present level of detail.
    pub n_strands: u32,
    pub vertices_per_strand: u32,
    /// Index of the layer in the groom.
    pub material: u32,
}

impl DrawnLayer {
    pub fn n_segments(&self) -> u32 {
        self.n_strands * (self.vertices_per_strand - 1)
    }
}

/// All strands, as the passes after generation read them.
#[derive(Debug, Clone)]
pub struct StrandBuffers {
    /// `array<vec4<f32>>`: place in world centimetres, radius in centimetres.
    pub vertices: wgpu::Buffer,
    /// `array<vec2<u32>>`: of each strand the hash of its stable id, and the bits of the share of the dye that it takes.
    pub seeds: wgpu::Buffer,
    /// What is drawn this frame; layers that are hidden or empty are left out.
    pub layers: Vec<DrawnLayer>,
    /// Vertices and strands that the buffers have room for.
    pub n_vertices: u32,
    pub n_strands: u32,
    /// Radius of the widest strand of the last recorded frame, centimetres.
    pub widest: f32,
    /// Changes when a buffer is another one than before: what was bound must be bound again.
    pub generation: u64,
}

/// A layer on the GPU.
#[derive(Debug, Clone)]
pub(crate) struct LayerMirror {
    pub(crate) layer: Layer,
    pub(crate) binding: Arc<LayerBinding>,
    /// [`BoundLayer::places`] of what the buffers hold.
    places: u64,
    pub(crate) guides: wgpu::Buffer,
    pub(crate) knots: wgpu::Buffer,
    pub(crate) strands: wgpu::Buffer,
    pub(crate) influences: wgpu::Buffer,
    pub(crate) middles: wgpu::Buffer,
    pub(crate) ops: wgpu::Buffer,
    pub(crate) curves: wgpu::Buffer,
    pub(crate) map_values: wgpu::Buffer,
    /// What brushes did to each sculpt guide, then each strand's shares in them.
    pub(crate) sculpt: wgpu::Buffer,
    /// What of it is on the GPU; empty where nothing is sculpted.
    pub(crate) composite: Composite,
    sculpt_roots: Arc<SculptRoots>,
    pub(crate) plan: PlanNumbers,
    /// Of the widest strand, times the layer's radius.
    pub(crate) widest_scale: f32,
    /// Place in the shared buffers, with as many strands as there is room for; `None` where hidden.
    pub(crate) place: Option<DrawnLayer>,
}

/// The groom's layers and head on the GPU.
#[derive(Debug)]
pub struct Mirror {
    pub(crate) layers: Vec<LayerMirror>,
    bound: Bound,
    pub(crate) field_buffer: wgpu::Buffer,
    /// How strands between moved guides are kept out of the head.
    pub(crate) interpolated: Interpolated,
    pub(crate) buffers: StrandBuffers,
}

/// Twin of `Strand` in generate.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct GpuStrand {
    root_offset: [f32; 3],
    seed: u32,
    root_normal: [f32; 3],
    radius_scale: f32,
    first_influence: u32,
    n_influences: u32,
    first_knot: u32,
    pad: u32,
}

/// Twin of `Op` in generate.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct GpuOp {
    kind: u32,
    size_idx: u32,
    seed: u32,
    flags: u32,
    strength: f32,
    from: f32,
    ramp: f32,
    table: u32,
    numbers: [f32; 6],
    maps: [u32; 2],
}

/// What of a plan stands in the parameters of a dispatch; an index is [`NONE`] where there is none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanNumbers {
    pub(crate) n_ops: u32,
    pub(crate) smooth_op: u32,
    pub(crate) wisp_size: u32,
    pub(crate) length_map: u32,
    pub(crate) width_map: u32,
    pub(crate) is_plain: bool,
}

impl PlanNumbers {
    const EMPTY: Self =
        Self { n_ops: 0, smooth_op: NONE, wisp_size: NONE, length_map: NONE, width_map: NONE, is_plain: true };

    /// The kernel that the plan needs.
    pub(crate) fn sort(self) -> Sort {
        match (self.smooth_op != NONE, self.is_plain) {
            (true, _) => Sort::Ironing,
            (false, true) => Sort::Plain,
            (false, false) => Sort::Full,
        }
    }
}

/// Which kernel makes a layer's strands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Sort {
    Plain,
    Full,
    /// As full, with the operator that irons paths.
    Ironing,
}

/// Twin of `NONE` in generate.wgsl.
const NONE: u32 = u32::MAX;

/// Twin of `PER_WISP` in generate.wgsl; the blend is the bits below.
const PER_WISP: u32 = 4;

const STORAGE: BufferUsages = BufferUsages::STORAGE;

impl Mirror {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let buffers = StrandBuffers {
            vertices: gpu.buffer("strands.vertices", 0, STORAGE),
            seeds: gpu.buffer("strands.seeds", 0, STORAGE),
            layers: Vec::new(),
            n_vertices: 0,
            n_strands: 0,
            widest: 0.0,
            generation: 0,
        };
        Self {
            layers: Vec::new(),
            bound: Bound::default(),
            field_buffer: gpu.buffer("generate.field", 0, STORAGE),
            interpolated: Interpolated::Pushed,
            buffers,
        }
    }

    /// Bring the GPU up to date with the groom, whose strands were bound as `bound`. What it returns is to be
    /// shown to the user: what did not fit. After an error the GPU holds what it held before.
    pub(crate) fn set_bound(&mut self, gpu: &Gpu, groom: &Groom, bound: Bound) -> Result<Vec<String>, MirrorError> {
        let mut warnings = bound.warnings.clone();
        let mut layers: Vec<LayerMirror> = Vec::with_capacity(groom.layers.len());
        for (layer, bound) in groom.layers.iter().zip(&bound.layers) {
            // Two layers of the same strands have buffers of their own: their styles may differ.
            let is_taken = |old: &LayerMirror| layers.iter().any(|new| new.guides == old.guides);
            let known = self.layers.iter().find(|old| old.places == bound.places && !is_taken(old));
            let mirror = match known.cloned() {
                Some(mut known) => {
                    known.restyle(gpu, layer, &bound.binding);
                    known
                }
                None => LayerMirror::new(gpu, layer, bound)?,
            };
            layers.push(mirror);
        }
        let before = std::mem::replace(&mut self.layers, layers);
        if let Err(error) = self.place_layers(gpu, &mut warnings) {
            self.layers = before;
            return Err(error);
        }
        let is_same_field = match (&self.bound.field, &bound.field) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if !is_same_field {
            let values = bound.field.as_ref().map_or(&[] as &[f32], |field| &field.values);
            self.field_buffer = gpu.buffer_of("generate.field", values, STORAGE);
        }
        self.bound = bound;
        self.interpolated = groom.simulation.interpolated;
        Ok(warnings)
    }

    /// What the strands on the GPU were bound to.
    pub fn bound(&self) -> &Bound {
        &self.bound
    }

    /// Give every visible layer its room in the shared buffers.
    fn place_layers(&mut self, gpu: &Gpu, warnings: &mut Vec<String>) -> Result<(), MirrorError> {
        let vertices_of = |mirror: &LayerMirror| u64::from(mirror.layer.vertices_per_strand.clamp(4, 128));
        let wanted: u64 = self
            .layers
            .iter()
            .filter(|mirror| mirror.layer.visible)
            .map(|mirror| mirror.binding.n_strands() as u64 * vertices_of(mirror))
            .sum();
        let most = gpu.max_storage_binding() / 16;
        let share = if wanted > most { most as f64 / wanted as f64 } else { 1.0 };
        if share < 1.0 {
            warnings.push(format!(
                "{:.0} % of the strands are drawn, wider: all of them need {} MiB and this GPU binds {} MiB at once. Fewer vertices a strand would fit.",
                100.0 * share,
                wanted >> 16,
                most >> 16
            ));
        }
        let (mut n_vertices, mut n_strands) = (0_u64, 0_u64);
        let mut seeds: Vec<[u32; 2]> = Vec::new();
        for (layer_idx, mirror) in self.layers.iter_mut().enumerate() {
            let n = (mirror.binding.n_strands() as f64 * share) as u64;
            mirror.place = (mirror.layer.visible && n > 0).then_some(DrawnLayer {
                first_vertex: n_vertices as u32,
                first_strand: n_strands as u32,
                n_strands: n as u32,
                vertices_per_strand: vertices_of(mirror) as u32,
                material: layer_idx as u32,
            });
            if mirror.place.is_some() {
                n_vertices += n * vertices_of(mirror);
                n_strands += n;
                let dye = mirror.binding.map_idx(&MapKind::Dye);
                let of_strand = |s: usize| {
                    [mirror.binding.seeds[s], mirror.binding.map_value(s, dye, MapKind::Dye.default_value()).to_bits()]
                };
                seeds.extend((0..n as usize).map(of_strand));
            }
        }
        let buffers = &mut self.buffers;
        let size = (n_vertices * 16).max(16);
        if buffers.vertices.size() < size || buffers.vertices.size() > 2 * size {
            buffers.vertices = gpu.checked(|| gpu.buffer("strands.vertices", size, STORAGE | BufferUsages::VERTEX))?;
            buffers.generation += 1;
        }
        let size = (n_strands * 8).max(16);
        if buffers.seeds.size() < size || buffers.seeds.size() > 2 * size {
            buffers.seeds = gpu.checked(|| gpu.buffer("strands.seeds", size, STORAGE))?;
            buffers.generation += 1;
        }
        gpu.queue.write_buffer(&buffers.seeds, 0, bytemuck::cast_slice(&seeds));
        (buffers.n_vertices, buffers.n_strands) = (n_vertices as u32, n_strands as u32);
        buffers.layers.clear();
        Ok(())
    }

    /// The head's distance field, head space.
    pub fn field(&self) -> Option<&Arc<DistanceField>> {
        self.bound.field.as_ref()
    }

    /// What a layer's strands hang on; its guides are what a solver moves.
    pub fn binding(&self, layer_idx: usize) -> Option<&Arc<LayerBinding>> {
        Some(&self.layers.get(layer_idx)?.binding)
    }

    /// The strands as the last recorded frame has them.
    pub fn strands(&self) -> &StrandBuffers {
        &self.buffers
    }

    /// Bytes of all buffers of strands, guides and weights.
    pub fn n_bytes(&self) -> u64 {
        let of_layer = |mirror: &LayerMirror| {
            let of_roots = [&mirror.guides, &mirror.knots, &mirror.strands, &mirror.influences];
            let of_style = [&mirror.middles, &mirror.ops, &mirror.curves, &mirror.map_values, &mirror.sculpt];
            of_roots.into_iter().chain(of_style).map(wgpu::Buffer::size).sum::<u64>()
        };
        self.layers.iter().map(of_layer).sum::<u64>()
            + self.buffers.vertices.size()
            + self.buffers.seeds.size()
            + self.field_buffer.size()
    }
}

impl LayerMirror {
    fn new(gpu: &Gpu, layer: &Layer, bound: &BoundLayer) -> Result<Self, MirrorError> {
        let binding = &bound.binding;
        let available = gpu.max_storage_binding();
        for (what, needed) in [
            ("The guides", 16 * binding.guides.positions.len()),
            ("The roots", size_of::<GpuStrand>() * binding.n_strands()),
            ("The weights", size_of_val(binding.influences.as_slice())),
            ("The clumps", size_of_val(binding.clumps.middles.as_slice())),
            (
                "The sculpted guides",
                size_of_val(binding.sculpt.shares.as_slice())
                    + (layer.sculpt.roots.positions.len() * size_of::<Composed>()),
            ),
        ] {
            if needed as u64 > available {
                let (needed, available) = (needed as u64 >> 20, available >> 20);
                return Err(MirrorError::TooLarge { layer: layer.name.clone(), what, needed, available });
            }
        }
        let strands: Vec<GpuStrand> = (0..binding.n_strands())
            .map(|s| GpuStrand {
                root_offset: binding.root_offsets[s].to_array(),
                seed: binding.seeds[s],
                root_normal: binding.root_normals[s].to_array(),
                radius_scale: binding.radius_scales.get(s).copied().unwrap_or(1.0),
                first_influence: binding.influence_offsets[s],
                n_influences: binding.influence_offsets[s + 1] - binding.influence_offsets[s],
                first_knot: binding.first_knots[s],
                pad: 0,
            })
            .collect();
        let mut mirror = gpu.checked(|| Self {
            layer: layer.clone(),
            guides: gpu.buffer_of(
                "strands.guides",
                &guides_of(binding),
                STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            ),
            knots: gpu.buffer_of("generate.knots", &binding.knots, STORAGE | BufferUsages::COPY_DST),
            strands: gpu.buffer_of("generate.strands", &strands, STORAGE),
            influences: gpu.buffer_of("generate.influences", &binding.influences, STORAGE),
            middles: gpu.buffer_of("generate.middles", &binding.clumps.middles, STORAGE),
            ops: gpu.buffer("generate.ops", 16, STORAGE),
            curves: gpu.buffer("generate.curves", 16, STORAGE),
            map_values: gpu.buffer_of("generate.map_values", &binding.map_values, STORAGE),
            sculpt: gpu.buffer("generate.sculpt", 16, STORAGE),
            composite: Composite::default(),
            sculpt_roots: Arc::default(),
            plan: PlanNumbers::EMPTY,
            widest_scale: 1.0,
            binding: Arc::clone(binding),
            places: bound.places,
            place: None,
        })?;
        mirror.send_ops(gpu);
        mirror.send_sculpt(gpu);
        Ok(mirror)
    }

    /// Take over a layer whose roots and weights are the same.
    fn restyle(&mut self, gpu: &Gpu, layer: &Layer, binding: &Arc<LayerBinding>) {
        let is_same = self.layer.style == layer.style && Arc::ptr_eq(&self.binding, binding);
        let is_sculpted_alike = self.layer.has_same_sculpt(layer) && Arc::ptr_eq(&self.binding, binding);
        self.layer = layer.clone();
        if !is_same {
            self.rebind(gpu, binding);
        }
        if !is_sculpted_alike {
            self.send_sculpt(gpu);
        }
    }

    /// Take over another style, or what else of the binding changed.
    fn rebind(&mut self, gpu: &Gpu, binding: &Arc<LayerBinding>) {
        if !Arc::ptr_eq(&self.binding, binding) {
            if self.binding.clumps != binding.clumps {
                self.middles = gpu.buffer_of("generate.middles", &binding.clumps.middles, STORAGE);
            }
            if self.binding.guides != binding.guides {
                // As many as before: other counts have other places.
                gpu.queue.write_buffer(&self.guides, 0, bytemuck::cast_slice(&guides_of(binding)));
                gpu.queue.write_buffer(&self.knots, 0, bytemuck::cast_slice(&binding.knots));
            }
            if self.binding.map_values != binding.map_values {
                self.map_values = gpu.buffer_of("generate.map_values", &binding.map_values, STORAGE);
            }
            self.binding = Arc::clone(binding);
        }
        self.send_ops(gpu);
    }

    fn send_ops(&mut self, gpu: &Gpu) {
        let plan = Plan::new(&self.layer.style, &self.binding);
        let mut curves: Vec<f32> = Vec::new();
        let mut ops = Vec::with_capacity(plan.steps.len());
        for step in &plan.steps {
            let table = step.table.map_or(NONE, |table| {
                curves.extend(table);
                (curves.len() - table.len()) as u32
            });
            ops.push(gpu_op(step, table));
        }
        self.plan = PlanNumbers {
            n_ops: ops.len() as u32,
            smooth_op: index_or_none(plan.smooth),
            wisp_size: index_or_none(plan.wisp_size_idx()),
            length_map: index_or_none(plan.length_map),
            width_map: index_or_none(plan.width_map),
            is_plain: plan.is_plain(),
        };
        let widest = self.binding.radius_scales.iter().copied().fold(1.0, f32::max);
        self.widest_scale = widest * plan.width_map.map_or(1.0, |_| MapKind::Width.max_value());
        self.ops = gpu.buffer_of("generate.ops", &ops, STORAGE);
        self.curves = gpu.buffer_of("generate.curves", &curves, STORAGE);
    }

    /// Send what brushes did. A stroke sends the guides that it touched; the strands' shares in them are sent once.
    fn send_sculpt(&mut self, gpu: &Gpu) {
        let shares = &self.binding.sculpt;
        let is_bound = shares.are_of(&self.layer.sculpt.roots, self.binding.n_strands());
        let composite = if is_bound { Composite::of(&self.layer) } else { Composite::default() };
        let n_bytes = size_of_val(composite.guides.as_slice()) + size_of_val(shares.shares.as_slice());
        let has_shares = Arc::ptr_eq(&self.sculpt_roots, &shares.roots) && self.sculpt.size() >= n_bytes as u64;
        if has_shares && self.composite.guides.len() == composite.guides.len() {
            for range in composite.changed_since(&self.composite) {
                let offset = (range.start * size_of::<Composed>()) as u64;
                gpu.queue.write_buffer(&self.sculpt, offset, bytemuck::cast_slice(&composite.guides[range]));
            }
        } else if !composite.guides.is_empty() {
            let mut bytes: Vec<u8> = Vec::with_capacity(n_bytes);
            bytes.extend_from_slice(bytemuck::cast_slice(&composite.guides));
            bytes.extend_from_slice(bytemuck::cast_slice(&shares.shares));
            self.sculpt = gpu.buffer_of("generate.sculpt", &bytes, STORAGE | BufferUsages::COPY_SRC);
            self.sculpt_roots = Arc::clone(&shares.roots);
        }
        self.composite = composite;
    }

    /// Which kernel makes the layer's strands: the plain one knows nothing of brushes.
    pub(crate) fn sort(&self) -> Sort {
        match self.plan.sort() {
            Sort::Plain if !self.composite.guides.is_empty() => Sort::Full,
            sort => sort,
        }
    }

    /// Strands drawn at a level of detail, and their widths.
    pub(crate) fn lod(&self, lod: f32) -> Lod {
        let n_room = self.place.map_or(0, |place| place.n_strands);
        let mut lod = Lod::new(self.binding.n_strands(), lod.min(self.most_lod()));
        lod.n_drawn = lod.n_drawn.min(n_room);
        lod
    }

    /// The level of detail at which the layer's room is full.
    fn most_lod(&self) -> f32 {
        let n = self.binding.n_strands() as f32;
        let n_room = self.place.map_or(0, |place| place.n_strands) as f32;
        if n_room >= n { 1.0 } else { n_room / n / (1.0 + lorelei_core::generate::LOD_FADE) }
    }
}

fn gpu_op(step: &Step, table: u32) -> GpuOp {
    let (kind, numbers) = step.numbers();
    let blend = match step.blend {
        Blend::Add => 0,
        Blend::Replace => 1,
        Blend::Modulate => 2,
    };
    GpuOp {
        kind,
        size_idx: index_or_none(step.size_idx),
        seed: step.seed,
        flags: blend | if step.per_wisp { PER_WISP } else { 0 },
        strength: step.strength,
        from: step.from,
        ramp: step.ramp,
        table,
        numbers,
        maps: step.maps.map(index_or_none),
    }
}

fn guides_of(binding: &LayerBinding) -> Vec<[f32; 4]> {
    binding.guides.positions.iter().map(|p| [p.x, p.y, p.z, 0.0]).collect()
}

fn index_or_none(index: Option<usize>) -> u32 {
    index.map_or(NONE, |index| index as u32)
}
