//! The compute rasteriser: segments into tiles, counted into buckets of depth, composited near to far.
//!
//! ```text
//! gather    a segment of a sampled strand a thread   what they cover in each tile, by depth
//! find      a tile a thread      where strands begin to hide what is behind them
//! count     a segment a thread   vertices -> line in pixels, depths, widths; how many each (tile, bucket) gets
//! allocate  a tile a thread      where in the list each bucket starts
//! scatter   a segment a thread   segments into their buckets
//! fine      see [`Threads`]      coverage of each segment in turn, composited, until nothing shines through
//! ```
//!
//! There is no sort: the list is made by counting. Buckets are finest where a tile's hair begins to hide what is behind
//! it, and a fragment goes to the bucket of its own depth (raster_buckets.wgsl). Segments behind a tile that is all head
//! are never listed. The list is made in up to N_ROUNDS parts (raster_alloc.wgsl); what would need more is left out, and
//! [`Raster::n_entries`] tells.
//!
//! Rejected: a thread a pixel that reads all of its tile's segments (twice the time on an H200 and on a CPU); the whole
//! of a segment in one bucket (where locks cross, tiles showed); one thread a segment with atomics on pixels in memory (a
//! global atomic per fragment and channel, two passes over all fragments for their order); sorting fragments (tens of
//! millions a frame).

mod kernels;

use std::collections::HashMap;

use lorelei_shaders::{Gpu, GpuError, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::fragments::FragmentInput;
use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::scene::Ball;
use crate::view::View;

use kernels::Kernels;
pub(crate) use kernels::Threads;

/// Side of a tile in pixels: twin of tile.wgsl.
pub(crate) const TILE: u32 = 8;
/// Twins of `N_BUCKETS` and `N_BINS`.
const N_BUCKETS: u64 = 32;
const N_BINS: u64 = 128;
/// A list entry keeps its vertex in 26 bits.
const MAX_VERTICES: u32 = 1 << 26;
/// Parts that the list may be made in. One is enough but for a groom of few, very long segments.
const N_ROUNDS: u64 = 4;
/// Entries that a round has room for: this many a vertex (a segment of 25 pixels touches five tiles), and no fewer
/// than this.
const ENTRIES_PER_VERTEX: u64 = 6;
const MIN_ENTRIES: u64 = 1 << 22;

/// Twin of `RasterFrame`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FrameUniform {
    view: View,
    n_tiles: [u32; 2],
    n_items: u32,
    n_layers: u32,
    round_size: u32,
    n_rounds: u32,
    exposure: f32,
    nearest: f32,
    sample_step: u32,
    bins_per_cm: f32,
    supersampling: u32,
    pad: u32,
}

/// Segments in pixels: what tiles are filled from. Handles: a clone is the same.
#[derive(Debug, Clone)]
pub(crate) struct Segments {
    pub frame: wgpu::Buffer,
    pub layers: wgpu::Buffer,
    pub lines: wgpu::Buffer,
    pub spans: wgpu::Buffer,
    bins: wgpu::Buffer,
    fronts: wgpu::Buffer,
    pub tile_backs: wgpu::Buffer,
    /// Vertices of drawn strands, and of those that stand for all.
    pub n_items: u32,
    n_sampled: u32,
}

impl Segments {
    /// What the frame and its strands are: whatever goes over segments binds it.
    pub fn frame_resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 2] {
        [("raster", self.frame.as_entire_binding()), ("raster_layers", self.layers.as_entire_binding())]
    }
}

/// The rasteriser with its buffers.
pub(crate) struct Raster {
    threads: Threads,
    kernels: Hot<Kernels>,
    /// By what is linked into them.
    fine: HashMap<Vec<Link<'static>>, Hot<Kernel>>,
    pub segments: Segments,
    buckets: wgpu::Buffer,
    tiles: wgpu::Buffer,
    entries: wgpu::Buffer,
    totals: wgpu::Buffer,
    tile_list: wgpu::Buffer,
    arguments: wgpu::Buffer,
    rounds: Vec<wgpu::Buffer>,
    n_tiles: [u32; 2],
    /// Strands may be wider on the screen than [`WIDE`].
    is_wide: bool,
}

/// Half width in pixels up to which a strip is a line with a weight: `THIN` of coverage.wgsl, and what it costs to be
/// wrong about a few strands that come nearer than the ball around the groom.
const WIDE: f32 = 0.2;

/// What a frame asks of the rasteriser.
pub(crate) struct RasterInput {
    pub view: View,
    /// Around the groom.
    pub ball: Ball,
    /// What the picture's light is multiplied with.
    pub exposure: f32,
    /// Pixels of `view` for one of the head, along a side.
    pub supersampling: u32,
    pub threads: Threads,
    /// Strands are composited in tiles; where other passes draw them, these only want to know the frame.
    pub fills_tiles: bool,
}

const STORAGE: BufferUsages = BufferUsages::STORAGE;

/// What cannot be drawn on this GPU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{n_vertices} strand vertices need {needed} MiB at once and this GPU binds {available} MiB; draw fewer strands or fewer vertices each"
)]
pub struct TooManyVertices {
    pub n_vertices: u32,
    pub needed: u64,
    pub available: u64,
}

/// What tiles cannot be made for on this GPU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "compositing {width} x {height} samples of hair in tiles needs {needed} MiB at once and this GPU binds {available} MiB; make the picture smaller, or choose another antialiasing or transparency"
)]
pub struct TooManyTiles {
    pub width: u32,
    pub height: u32,
    pub needed: u64,
    pub available: u64,
}

impl Raster {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let storage = |label| gpu.buffer(label, 0, STORAGE);
        Ok(Self {
            threads: Threads::Segments,
            kernels: Hot::new(library, |library| Kernels::new(gpu, library))?,
            fine: HashMap::new(),
            segments: Segments {
                frame: gpu.buffer("raster.frame", size_of::<FrameUniform>() as u64, BufferUsages::UNIFORM),
                layers: storage("raster.layers"),
                lines: storage("raster.lines"),
                spans: storage("raster.spans"),
                bins: storage("raster.bins"),
                fronts: storage("raster.fronts"),
                tile_backs: storage("raster.tile_backs"),
                n_items: 0,
                n_sampled: 0,
            },
            buckets: storage("raster.buckets"),
            tiles: storage("raster.tiles"),
            entries: storage("raster.entries"),
            totals: gpu.buffer("raster.totals", 4 * (1 + N_ROUNDS), STORAGE),
            tile_list: storage("raster.tile_list"),
            arguments: gpu.buffer("raster.arguments", N_ROUNDS * 32, STORAGE | BufferUsages::INDIRECT),
            rounds: (0..N_ROUNDS as u32)
                .map(|round| gpu.buffer_of("raster.round", &[round], BufferUsages::UNIFORM))
                .collect(),
            n_tiles: [0; 2],
            is_wide: false,
        })
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.fine.values().find_map(Hot::error).or(self.kernels.error())
    }

    /// Bytes of all buffers.
    pub fn n_bytes(&self) -> u64 {
        let segments = &self.segments;
        [
            &segments.lines,
            &segments.spans,
            &segments.bins,
            &segments.fronts,
            &segments.tile_backs,
            &self.buckets,
            &self.tiles,
            &self.tile_list,
            &self.entries,
        ]
        .iter()
        .map(|buffer| buffer.size())
        .sum()
    }

    /// Entries of the last frame's list, and how many fit: for tests and statistics.
    pub fn n_entries(&self, gpu: &Gpu) -> Result<(u64, u64), GpuError> {
        let listed = gpu.read_buffer::<u32>(&self.totals)?[0];
        Ok((u64::from(listed), N_ROUNDS * self.round_size()))
    }

    fn round_size(&self) -> u64 {
        (self.entries.size() / 4).saturating_sub(u64::from(self.segments.n_items))
    }

    /// Make every buffer fit the frame and send its numbers.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        strands: &StrandBuffers,
        input: &RasterInput,
    ) -> Result<(), crate::RenderError> {
        self.threads = input.threads;
        self.kernels.refresh(library, |library| Kernels::new(gpu, library));
        let n_items: u32 = strands.layers.iter().map(|layer| layer.n_strands * layer.vertices_per_strand).sum();
        let n_vertices = strands.n_vertices;
        let available = gpu.max_storage_binding();
        let least = u64::from(n_items) * 2;
        let needed = (u64::from(n_vertices) * 16).max(least * 4);
        if needed > available || n_vertices >= MAX_VERTICES {
            let (needed, available) = (needed >> 20, available >> 20);
            return Err(TooManyVertices { n_vertices, needed, available }.into());
        }
        let view = input.view;
        let [width, height] = view.size;
        let n_tiles = [width.div_ceil(TILE), height.div_ceil(TILE)];
        let n_all_tiles = u64::from(n_tiles[0]) * u64::from(n_tiles[1]);
        let n_filled_tiles = if input.fills_tiles { n_all_tiles } else { 0 };
        let needed = n_filled_tiles * N_BINS.max(N_BUCKETS) * 4;
        if needed > available {
            let (needed, available) = (needed >> 20, available >> 20);
            return Err(TooManyTiles { width, height, needed, available }.into());
        }
        let round_size = (u64::from(n_items) * ENTRIES_PER_VERTEX)
            .max(MIN_ENTRIES)
            .min(available / 4 - u64::from(n_items))
            // The total of all rounds is counted in 32 bits.
            .min(u64::from(u32::MAX) / (2 * N_ROUNDS));
        let segments = &mut self.segments;
        gpu.checked(|| {
            fit(gpu, &mut segments.lines, u64::from(n_vertices) * 16);
            fit(gpu, &mut segments.spans, u64::from(n_vertices) * 16);
            fit(gpu, &mut segments.layers, (strands.layers.len() * size_of::<DrawnLayer>()) as u64);
            fit(gpu, &mut segments.bins, n_filled_tiles * N_BINS * 4);
            fit(gpu, &mut segments.fronts, n_filled_tiles * 4);
            fit(gpu, &mut segments.tile_backs, n_all_tiles * 4);
            fit(gpu, &mut self.buckets, n_filled_tiles * N_BUCKETS * 4);
            fit(gpu, &mut self.tiles, n_filled_tiles * 16);
            fit(gpu, &mut self.tile_list, n_filled_tiles * N_ROUNDS * 4);
            let n_entries = if input.fills_tiles { round_size + u64::from(n_items) } else { 0 };
            fit(gpu, &mut self.entries, n_entries * 4);
        })?;
        segments.n_items = n_items;
        // Enough strands that a tile of dense hair has some.
        let n_strands: u32 = strands.layers.iter().map(|layer| layer.n_strands).sum();
        let sample_step = (n_strands / 2000).clamp(1, 16);
        segments.n_sampled =
            strands.layers.iter().map(|layer| layer.n_strands.div_ceil(sample_step) * layer.vertices_per_strand).sum();
        let nearest = (input.ball.centre.distance(view.eye.into()) - input.ball.radius).max(view.near);
        self.is_wide = strands.widest * view.pixels_per_tangent > WIDE * nearest;
        self.n_tiles = n_tiles;
        let frame = FrameUniform {
            view,
            n_tiles,
            n_items,
            n_layers: strands.layers.len() as u32,
            round_size: self.round_size().min(u64::from(u32::MAX)) as u32,
            n_rounds: N_ROUNDS as u32,
            exposure: input.exposure,
            nearest,
            sample_step,
            // The bins span the ball.
            bins_per_cm: N_BINS as f32 / (2.0 * input.ball.radius),
            supersampling: input.supersampling,
            pad: 0,
        };
        gpu.queue.write_buffer(&self.segments.frame, 0, bytemuck::bytes_of(&frame));
        gpu.queue.write_buffer(&self.segments.layers, 0, bytemuck::cast_slice(&strands.layers));
        Ok(())
    }

    /// How near the hair comes; segments into pixels; how long the list is and where each tile's part begins.
    pub fn record_count(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        strands: &StrandBuffers,
    ) -> Result<(), ShaderError> {
        encoder.clear_buffer(&self.segments.bins, 0, None);
        encoder.clear_buffer(&self.buckets, 0, None);
        encoder.clear_buffer(&self.totals, 0, None);
        let mut resources = self.resources();
        resources.push(("vertices", strands.vertices.as_entire_binding()));
        let gather = self.kernels.gather.bind_used(gpu, &resources)?;
        let find = self.kernels.find.bind_used(gpu, &resources)?;
        let count = self.kernels.count.bind_used(gpu, &resources)?;
        let allocate = self.kernels.allocate.bind_used(gpu, &resources)?;
        let plan = self.kernels.plan.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("raster.count"), timestamp_writes: None });
        self.kernels.gather.dispatch_items(&mut pass, &gather, self.segments.n_sampled);
        self.kernels.find.dispatch_items(&mut pass, &find, self.n_tiles[0] * self.n_tiles[1]);
        self.kernels.count.dispatch_items(&mut pass, &count, self.segments.n_items);
        self.kernels.allocate.dispatch_items(&mut pass, &allocate, self.n_tiles[0] * self.n_tiles[1]);
        self.kernels.plan.dispatch(&mut pass, &plan, [1, 1, 1]);
        Ok(())
    }

    /// Fill the list for a round.
    fn record_scatter(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, round: usize) -> Result<(), ShaderError> {
        let mut resources = self.resources();
        resources.push(("round", self.rounds[round].as_entire_binding()));
        let scatter = self.kernels.scatter.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("raster.scatter"), timestamp_writes: None });
        self.kernels.scatter.dispatch_indirect(&mut pass, &scatter, &self.arguments, 32 * round as u64);
        Ok(())
    }

    /// Draw a round's tiles into `input.hair`.
    fn record_fine(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        fine: &Kernel,
        input: &FragmentInput<'_>,
        round: usize,
    ) -> Result<(), ShaderError> {
        let mut resources = self.resources();
        resources.extend(input.resources.iter().cloned());
        resources.extend([
            ("round", self.rounds[round].as_entire_binding()),
            ("bucket_ends", self.buckets.as_entire_binding()),
            ("hair", wgpu::BindingResource::TextureView(input.hair)),
        ]);
        let bindings = fine.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("raster.fine"), timestamp_writes: None });
        fine.dispatch_indirect(&mut pass, &bindings, &self.arguments, 32 * round as u64 + 16);
        Ok(())
    }

    /// Fill the list and draw from it into `input.hair`, which was cleared, as often as its length asks for.
    pub fn record_tiles(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &FragmentInput<'_>,
        profile: &mut crate::profile::Profile,
    ) -> Result<(), ShaderError> {
        let threads = self.threads;
        let key = threads.fine_links(input.look, self.is_wide);
        let make = |library: &ShaderLibrary| library.kernel(gpu, threads.fine_file(), "fine", &[], &key);
        Hot::have(&mut self.fine, library, &key, make)?;
        let fine = &self.fine[&key];
        profile.pass("raster.scatter", encoder, |encoder| self.record_scatter(gpu, encoder, 0))?;
        profile.pass("raster.fine", encoder, |encoder| self.record_fine(gpu, encoder, fine, input, 0))?;
        profile.pass("raster.more_rounds", encoder, |encoder| {
            for round in 1..N_ROUNDS as usize {
                self.record_scatter(gpu, encoder, round)?;
                self.record_fine(gpu, encoder, fine, input, round)?;
            }
            Ok(())
        })
    }

    fn resources(&self) -> Vec<(&'static str, wgpu::BindingResource<'_>)> {
        let segments = &self.segments;
        let [frame, layers] = segments.frame_resources();
        vec![
            frame,
            layers,
            ("lines", segments.lines.as_entire_binding()),
            ("spans", segments.spans.as_entire_binding()),
            ("bins", segments.bins.as_entire_binding()),
            ("fronts", segments.fronts.as_entire_binding()),
            ("tile_backs", segments.tile_backs.as_entire_binding()),
            ("buckets", self.buckets.as_entire_binding()),
            ("tiles", self.tiles.as_entire_binding()),
            ("entries", self.entries.as_entire_binding()),
            ("totals", self.totals.as_entire_binding()),
            ("tile_list", self.tile_list.as_entire_binding()),
            ("arguments", self.arguments.as_entire_binding()),
        ]
    }
}

/// Grow a buffer, or shrink it where most of it would lie idle.
pub(crate) fn fit(gpu: &Gpu, buffer: &mut wgpu::Buffer, size: u64) {
    let size = size.max(16);
    if buffer.size() < size || buffer.size() > 4 * size.max(1 << 20) {
        *buffer = gpu.buffer("raster", size, STORAGE);
    }
}
