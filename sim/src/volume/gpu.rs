//! The grid on the GPU: count, blur, push, in three dispatches a frame and two more for every further layer.

use lorelei_shaders::{Gpu, Kernel, ShaderError, ShaderLibrary};

use super::{Crowd, VolumeGrid, VolumeParams};
use crate::lanes::Lanes;

/// The kernels, and the buffers of one groom.
pub struct GpuVolume {
    splat: Kernel,
    blur: Kernel,
    push: Kernel,
    counts: wgpu::Buffer,
    blurred: wgpu::Buffer,
    /// Of every layer.
    crowds: Vec<wgpu::Buffer>,
    n_cells: u32,
}

/// A layer's state.
pub struct VolumeLayer<'a> {
    pub state: &'a wgpu::Buffer,
    pub n_vertices: u32,
    pub params: VolumeParams,
}

impl GpuVolume {
    /// `lanes`: how the state of every layer lies. Fails where the shader does not link or the device does not take it.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &ShaderLibrary,
        grid: &VolumeGrid,
        lanes: impl Iterator<Item = Lanes>,
    ) -> Result<Self, ShaderError> {
        let kernel = |entry: &str| library.kernel(gpu, "volume_hair", entry, &[], &[]);
        let storage = wgpu::BufferUsages::STORAGE;
        let n_cells = grid.n.iter().product::<u32>();
        let crowds_of = |(crowds, lanes): (&Vec<Crowd>, Lanes)| {
            gpu.buffer_of("sim.volume.crowds", &Lanes { numbers: 1, ..lanes }.lay(crowds), storage)
        };
        Ok(Self {
            splat: kernel("splat")?,
            blur: kernel("blur")?,
            push: kernel("push")?,
            counts: gpu.buffer("sim.volume.counts", u64::from(n_cells) * 16, storage),
            blurred: gpu.buffer("sim.volume.blurred", u64::from(n_cells) * 16, storage),
            crowds: grid.crowds.iter().zip(lanes).map(crowds_of).collect(),
            n_cells,
        })
    }

    /// Record a frame's work on all layers.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        layers: &[VolumeLayer<'_>],
    ) -> Result<(), ShaderError> {
        let mut splats = Vec::with_capacity(layers.len());
        let mut pushes = Vec::with_capacity(layers.len());
        let mut blur = None;
        for (layer, crowds) in layers.iter().zip(&self.crowds) {
            if layer.n_vertices == 0 {
                continue;
            }
            let params = VolumeParams { n_vertices: layer.n_vertices, ..layer.params };
            let params = gpu.buffer_of("sim.volume.params", &[params], wgpu::BufferUsages::UNIFORM);
            let resources = [
                ("volume", params.as_entire_binding()),
                ("crowds", crowds.as_entire_binding()),
                ("s", layer.state.as_entire_binding()),
                ("counts", self.counts.as_entire_binding()),
                ("blurred", self.blurred.as_entire_binding()),
            ];
            // The last group of guides may not be full.
            let n_threads = layer.n_vertices.next_multiple_of((layer.params.per_guide * layer.params.lanes).max(1));
            splats.push((self.splat.bind_used(gpu, &resources)?, n_threads));
            pushes.push((self.push.bind_used(gpu, &resources)?, n_threads));
            if blur.is_none() {
                blur = Some(self.blur.bind_used(gpu, &resources)?);
            }
        }
        let Some(blur) = blur else { return Ok(()) };
        encoder.clear_buffer(&self.counts, 0, None);
        let label = Some("sim.volume");
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
        for (bindings, n) in &splats {
            self.splat.dispatch_items(&mut pass, bindings, *n);
        }
        self.blur.dispatch_items(&mut pass, &blur, self.n_cells);
        for (bindings, n) in &pushes {
            self.push.dispatch_items(&mut pass, bindings, *n);
        }
        Ok(())
    }
}
