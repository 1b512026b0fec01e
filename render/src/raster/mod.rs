//! The compute rasteriser: segments binned into tiles, composited front to back.
//!
//! Every vertex is projected once. Each segment is counted into the slabs of depth of the tiles that it touches, the
//! counts become places in one list, and the segment is written there. Then one thread a pixel walks its tile's list
//! front to back and stops when the pixel is opaque. A surface that covers a whole tile hides what is behind it before
//! it is binned.
//!
//! Rejected: one global atomic a fragment (no transparency, and four passes over all fragments for an approximate
//! one); sorting all segments first (three more passes over them, and bins filled in parallel forget the order);
//! compositing in workgroup memory with barriers (a barrier costs the software driver more than the walk).
//!
//! The list's length is known only on the GPU. A frame that needed more room than there was says so afterwards
//! ([`Rasteriser::settle`]), the room grows, and the frame is drawn again: no segment is ever left out for good.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::{BufferUsages, TextureFormat};

use crate::mirror::StrandBuffers;

/// Of the texture that is written: premultiplied linear RGB and alpha.
pub const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// Side of a tile in pixels; twin of `TILE` in `raster_bin.wgsl` and `raster_fine.wgsl`.
const TILE: u32 = 8;
/// Slabs of depth in a tile.
const N_BUCKETS: u32 = 64;
/// Centimetres behind a tile's nearest hair that are cut into slabs: a head of hair's depth.
const REACH: f32 = 30.0;

/// Draws strands.
pub struct Rasteriser {
    pipelines: Hot<Pipelines>,
    projected: wgpu::Buffer,
    tiles: wgpu::Buffer,
    /// Per tile: nearest depth, first entry, depth that a surface hides.
    nearest: wgpu::Buffer,
    starts: wgpu::Buffer,
    hidden: wgpu::Buffer,
    slabs: wgpu::Buffer,
    total: wgpu::Buffer,
    list: wgpu::Buffer,
    layers: Vec<[wgpu::Buffer; 2]>,
    feedback: Feedback,
}

struct Pipelines {
    project: Kernel,
    hide: Kernel,
    count: Kernel,
    place: Kernel,
    scatter: Kernel,
    front_to_back: Kernel,
    nearest_only: Kernel,
}

/// How many entries the last finished frame needed, read back without waiting.
struct Feedback {
    staging: Arc<wgpu::Buffer>,
    /// The last answer, and how many answers came.
    needed: Arc<AtomicU32>,
    n_answers: Arc<AtomicU64>,
    n_asked: u64,
    /// A copy was recorded and not yet asked for.
    recorded: bool,
}

/// What is drawn.
#[derive(Clone, Copy)]
pub struct RasterInput<'a> {
    pub strands: &'a StrandBuffers,
    /// Shaded radiance of every vertex, `array<vec2<u32>>` of packed halves.
    pub radiance: &'a wgpu::Buffer,
    /// `View` of camera.wgsl.
    pub view: &'a wgpu::Buffer,
    /// Pixels.
    pub size: [u32; 2],
    /// View depth of the head in centimetres, red channel.
    pub head_depth: &'a wgpu::TextureView,
    /// The head's colour with its coverage as alpha.
    pub head_colour: &'a wgpu::TextureView,
    /// The nearest strand covers the whole pixel.
    pub opaque: bool,
}

/// Twin of `Tiles` in the shaders.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Tiles {
    n: [u32; 2],
    reach: f32,
    capacity: u32,
}

const STORAGE: BufferUsages = BufferUsages::STORAGE;

impl Rasteriser {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            pipelines: Hot::new(library, |library| Pipelines::new(gpu, library))?,
            projected: gpu.buffer("raster.projected", 16, STORAGE),
            tiles: gpu.buffer("raster.tiles", size_of::<Tiles>() as u64, BufferUsages::UNIFORM),
            nearest: gpu.buffer("raster.nearest", 16, STORAGE),
            starts: gpu.buffer("raster.starts", 16, STORAGE),
            hidden: gpu.buffer("raster.hidden", 16, STORAGE),
            slabs: gpu.buffer("raster.slabs", 16, STORAGE),
            total: gpu.buffer("raster.total", 4, STORAGE),
            list: gpu.buffer("raster.list", 16, STORAGE),
            layers: Vec::new(),
            feedback: Feedback::new(gpu),
        })
    }

    /// Record the drawing into a storage texture of [`FORMAT`], every pixel of it. Call [`Rasteriser::settle`] after
    /// the commands were submitted.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &RasterInput<'_>,
        target: &wgpu::TextureView,
    ) -> Result<(), ShaderError> {
        self.pipelines.refresh(library, |library| Pipelines::new(gpu, library));
        let n = input.size.map(|side| side.div_ceil(TILE));
        self.make_room(gpu, input, n);
        let capacity = (self.list.size() / 4) as u32;
        gpu.queue.write_buffer(&self.tiles, 0, bytemuck::bytes_of(&Tiles { n, reach: REACH, capacity }));
        encoder.clear_buffer(&self.nearest, 0, None);
        encoder.clear_buffer(&self.slabs, 0, None);
        encoder.clear_buffer(&self.total, 0, None);
        {
            let mut pass = begin(encoder, "raster.project");
            self.each_layer(gpu, input, &self.pipelines.project, 0, &mut pass)?;
            let kernel = &self.pipelines.hide;
            kernel.dispatch_items(&mut pass, &self.bind(gpu, input, kernel, None)?, n[0] * n[1]);
        }
        {
            let mut pass = begin(encoder, "raster.bin");
            self.each_layer(gpu, input, &self.pipelines.count, 1, &mut pass)?;
            let kernel = &self.pipelines.place;
            kernel.dispatch_items(&mut pass, &self.bind(gpu, input, kernel, None)?, n[0] * n[1]);
            self.each_layer(gpu, input, &self.pipelines.scatter, 1, &mut pass)?;
        }
        {
            let mut pass = begin(encoder, "raster.composite");
            let kernel = if input.opaque { &self.pipelines.nearest_only } else { &self.pipelines.front_to_back };
            let bindings = self.bind(gpu, input, kernel, Some(target))?;
            let n_tiles = n[0] * n[1];
            let n_rows = n_tiles.div_ceil(65_535);
            kernel.dispatch(&mut pass, &bindings, [n_tiles.div_ceil(n_rows), n_rows, 1]);
        }
        self.feedback.record(encoder, &self.total);
        Ok(())
    }

    /// After a submit: ask for the number of entries that the frame needed, without waiting for it. True where an
    /// earlier answer says that the list was too short: it has room now, and the frame should be drawn again.
    pub fn settle(&mut self, gpu: &Gpu) -> bool {
        self.feedback.ask();
        self.grow(gpu)
    }

    /// Like [`Rasteriser::settle`], for pictures: waits for the answer.
    pub fn settle_now(&mut self, gpu: &Gpu) -> Result<bool, lorelei_shaders::GpuError> {
        self.feedback.ask();
        gpu.wait()?;
        Ok(self.grow(gpu))
    }

    /// Bytes of all lists.
    pub fn n_bytes(&self) -> u64 {
        [&self.projected, &self.nearest, &self.starts, &self.hidden, &self.slabs, &self.list]
            .iter()
            .map(|buffer| buffer.size())
            .sum()
    }

    fn grow(&mut self, gpu: &Gpu) -> bool {
        let needed = 4 * u64::from(self.feedback.needed.load(Ordering::Acquire));
        let most = gpu.max_storage_binding();
        if needed <= self.list.size() || self.list.size() >= most {
            return false;
        }
        // A quarter more than was needed, so that an orbit does not grow it frame by frame.
        self.list = gpu.buffer("raster.list", (needed + needed / 4).min(most), STORAGE);
        true
    }

    fn make_room(&mut self, gpu: &Gpu, input: &RasterInput<'_>, n: [u32; 2]) {
        let n_tiles = u64::from(n[0] * n[1]);
        let room = |buffer: &mut wgpu::Buffer, label: &str, size: u64| {
            if buffer.size() < size {
                *buffer = gpu.buffer(label, size, STORAGE);
            }
        };
        room(&mut self.projected, "raster.projected", 16 * u64::from(input.strands.n_vertices));
        room(&mut self.nearest, "raster.nearest", 4 * n_tiles);
        room(&mut self.starts, "raster.starts", 4 * n_tiles);
        room(&mut self.hidden, "raster.hidden", 4 * n_tiles);
        room(&mut self.slabs, "raster.slabs", 4 * n_tiles * u64::from(N_BUCKETS));
        // Two tiles a segment to begin with; the first frame says what it really takes.
        let n_segments: u64 = input.strands.layers.iter().map(|layer| u64::from(layer.n_segments())).sum();
        room(&mut self.list, "raster.list", (8 * n_segments).min(gpu.max_storage_binding()));
        while self.layers.len() < input.strands.layers.len() {
            let uniform = || gpu.buffer("raster.layer", 16, BufferUsages::UNIFORM);
            self.layers.push([uniform(), uniform()]);
        }
        for (layer, [by_vertex, by_segment]) in input.strands.layers.iter().zip(&self.layers) {
            let numbers = |n_items: u32| [layer.first_vertex, layer.n_strands, layer.vertices_per_strand, n_items];
            let n_vertices = layer.n_strands * layer.vertices_per_strand;
            gpu.queue.write_buffer(by_vertex, 0, bytemuck::cast_slice(&numbers(n_vertices)));
            gpu.queue.write_buffer(by_segment, 0, bytemuck::cast_slice(&numbers(layer.n_segments())));
        }
    }

    /// Dispatch a kernel over the vertices (`by` 0) or the segments (`by` 1) of every layer.
    fn each_layer(
        &self,
        gpu: &Gpu,
        input: &RasterInput<'_>,
        kernel: &Kernel,
        by: usize,
        pass: &mut wgpu::ComputePass<'_>,
    ) -> Result<(), ShaderError> {
        for (layer, buffers) in input.strands.layers.iter().zip(&self.layers) {
            let bindings = self.bind_layer(gpu, input, kernel, &buffers[by])?;
            let n_items = if by == 0 { layer.n_strands * layer.vertices_per_strand } else { layer.n_segments() };
            kernel.dispatch_items(pass, &bindings, n_items);
        }
        Ok(())
    }

    fn bind(
        &self,
        gpu: &Gpu,
        input: &RasterInput<'_>,
        kernel: &Kernel,
        target: Option<&wgpu::TextureView>,
    ) -> Result<Bindings, ShaderError> {
        let mut resources = self.resources(input);
        resources.extend(target.map(|target| ("picture", wgpu::BindingResource::TextureView(target))));
        kernel.bind_used(gpu, &resources)
    }

    fn bind_layer(
        &self,
        gpu: &Gpu,
        input: &RasterInput<'_>,
        kernel: &Kernel,
        layer: &wgpu::Buffer,
    ) -> Result<Bindings, ShaderError> {
        let mut resources = self.resources(input);
        resources.push(("layer", layer.as_entire_binding()));
        kernel.bind_used(gpu, &resources)
    }

    fn resources<'a>(&'a self, input: &RasterInput<'a>) -> Vec<(&'static str, wgpu::BindingResource<'a>)> {
        vec![
            ("view", input.view.as_entire_binding()),
            ("vertices", input.strands.vertices.as_entire_binding()),
            ("radiance", input.radiance.as_entire_binding()),
            ("head_depth", wgpu::BindingResource::TextureView(input.head_depth)),
            ("head_colour", wgpu::BindingResource::TextureView(input.head_colour)),
            ("tiles", self.tiles.as_entire_binding()),
            ("projected", self.projected.as_entire_binding()),
            ("nearest", self.nearest.as_entire_binding()),
            ("starts", self.starts.as_entire_binding()),
            ("hidden", self.hidden.as_entire_binding()),
            ("slabs", self.slabs.as_entire_binding()),
            ("total", self.total.as_entire_binding()),
            ("list", self.list.as_entire_binding()),
        ]
    }
}

fn begin<'a>(encoder: &'a mut wgpu::CommandEncoder, label: &str) -> wgpu::ComputePass<'a> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None })
}

impl Pipelines {
    fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let buckets = ("N_BUCKETS", f64::from(N_BUCKETS));
        let bin = |entry, overrides: &[(&str, f64)]| library.kernel(gpu, "raster_bin", entry, overrides, &[]);
        let fine = |entry| library.kernel(gpu, "raster_fine", entry, &[buckets], &[]);
        Ok(Self {
            project: bin("project_vertices", &[])?,
            hide: bin("hide_tiles", &[])?,
            count: bin("walk", &[buckets, ("SCATTER", 0.0)])?,
            place: bin("place_tiles", &[buckets])?,
            scatter: bin("walk", &[buckets, ("SCATTER", 1.0)])?,
            front_to_back: fine("front_to_back")?,
            nearest_only: fine("nearest_only")?,
        })
    }
}

impl Feedback {
    fn new(gpu: &Gpu) -> Self {
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("raster.feedback"),
            size: 4,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            staging: Arc::new(staging),
            needed: Arc::new(AtomicU32::new(0)),
            n_answers: Arc::new(AtomicU64::new(0)),
            n_asked: 0,
            recorded: false,
        }
    }

    fn record(&mut self, encoder: &mut wgpu::CommandEncoder, total: &wgpu::Buffer) {
        // The staging buffer is mapped until the last answer has come.
        if self.n_answers.load(Ordering::Acquire) == self.n_asked && !self.recorded {
            encoder.copy_buffer_to_buffer(total, 0, &self.staging, 0, 4);
            self.recorded = true;
        }
    }

    fn ask(&mut self) {
        if !self.recorded {
            return;
        }
        self.recorded = false;
        self.n_asked += 1;
        let (needed, n_answers, staging) =
            (Arc::clone(&self.needed), Arc::clone(&self.n_answers), Arc::clone(&self.staging));
        self.staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            if result.is_ok() {
                if let Ok(view) = staging.slice(..).get_mapped_range() {
                    let bytes: [u8; 4] = [view[0], view[1], view[2], view[3]];
                    needed.store(u32::from_le_bytes(bytes), Ordering::Release);
                }
                staging.unmap();
            }
            n_answers.fetch_add(1, Ordering::Release);
        });
    }
}

#[cfg(test)]
mod tests;
