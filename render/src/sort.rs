//! Sorting on the GPU: 32-bit keys with a value each, stable, by radix (sort_radix.wgsl).
//!
//! Four passes of eight bits. Rejected: a bitonic sort (not stable, and log2(n)^2 passes over all items), and one pass
//! over as many buckets as there are depths (quantised: equal depths come in the order of atomics).

use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

/// Twins of `BLOCK` and `SCANNED`.
const BLOCK: u32 = 4096;
const SCANNED: u32 = 1024;
const N_PASSES: u32 = 4;

struct Kernels {
    count: Kernel,
    scan: Kernel,
    scan_sums: Kernel,
    scatter: Kernel,
}

/// Buffers of keys and values, and how to sort them.
pub struct Sort {
    kernels: Hot<Kernels>,
    /// Keys and values; after each pass the other pair holds them, after four the first does.
    pairs: [[wgpu::Buffer; 2]; 2],
    counts: wgpu::Buffer,
    sums: wgpu::Buffer,
    passes: Vec<wgpu::Buffer>,
    bound: Option<(u32, Vec<[Bindings; 4]>)>,
}

impl Sort {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let storage = |label| gpu.buffer(label, 16, BufferUsages::STORAGE);
        let uniform = |_| gpu.buffer("sort.pass", 16, BufferUsages::UNIFORM);
        Ok(Self {
            kernels: Hot::new(library, |library| Kernels::new(gpu, library))?,
            pairs: [[storage("sort.keys"), storage("sort.values")], [storage("sort.keys"), storage("sort.values")]],
            counts: storage("sort.counts"),
            sums: storage("sort.sums"),
            passes: (0..N_PASSES).map(uniform).collect(),
            bound: None,
        })
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.error()
    }

    /// Where to write the keys before [`Sort::record`], and where they are, ascending, after it.
    pub fn keys(&self) -> &wgpu::Buffer {
        &self.pairs[0][0]
    }

    /// The same for the values.
    pub fn values(&self) -> &wgpu::Buffer {
        &self.pairs[0][1]
    }

    pub fn n_bytes(&self) -> u64 {
        self.pairs.iter().flatten().chain([&self.counts, &self.sums]).map(wgpu::Buffer::size).sum()
    }

    /// Make room for items; before keys are written.
    pub fn prepare(&mut self, gpu: &Gpu, library: &ShaderLibrary, n_items: u32) -> Result<(), crate::RenderError> {
        if self.kernels.refresh(library, |library| Kernels::new(gpu, library)) {
            self.bound = None;
        }
        if self.bound.as_ref().is_some_and(|(bound, _)| *bound == n_items) {
            return Ok(());
        }
        let n_blocks = n_items.div_ceil(BLOCK).max(1);
        let n_counts = 256 * n_blocks;
        gpu.checked(|| {
            for buffer in self.pairs.iter_mut().flatten() {
                fit(gpu, buffer, u64::from(n_items) * 4);
            }
            fit(gpu, &mut self.counts, u64::from(n_counts) * 4);
            fit(gpu, &mut self.sums, u64::from(n_counts.div_ceil(SCANNED)) * 4);
        })?;
        let mut bound = Vec::new();
        for (pass, uniform) in self.passes.iter().enumerate() {
            gpu.queue.write_buffer(uniform, 0, bytemuck::cast_slice(&[n_items, n_blocks, 8 * pass as u32, 0]));
            let (from, to) = (&self.pairs[pass % 2], &self.pairs[(pass + 1) % 2]);
            let resources = [
                ("sort_pass", uniform.as_entire_binding()),
                ("keys_in", from[0].as_entire_binding()),
                ("values_in", from[1].as_entire_binding()),
                ("keys_out", to[0].as_entire_binding()),
                ("values_out", to[1].as_entire_binding()),
                ("counts", self.counts.as_entire_binding()),
                ("sums", self.sums.as_entire_binding()),
            ];
            let kernels = &*self.kernels;
            bound.push([
                kernels.count.bind_used(gpu, &resources)?,
                kernels.scan.bind_used(gpu, &resources)?,
                kernels.scan_sums.bind_used(gpu, &resources)?,
                kernels.scatter.bind_used(gpu, &resources)?,
            ]);
        }
        self.bound = Some((n_items, bound));
        Ok(())
    }

    /// Sort what [`Sort::prepare`] made room for. Keys and values were written by an earlier pass.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let Some((n_items, bound)) = &self.bound else { return };
        let n_blocks = n_items.div_ceil(BLOCK).max(1);
        let n_scans = (256 * n_blocks).div_ceil(SCANNED);
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sort"), timestamp_writes: None });
        let kernels = &*self.kernels;
        for [count, scan, scan_sums, scatter] in bound {
            kernels.count.dispatch(&mut pass, count, [n_blocks, 1, 1]);
            kernels.scan.dispatch(&mut pass, scan, [n_scans, 1, 1]);
            kernels.scan_sums.dispatch(&mut pass, scan_sums, [1, 1, 1]);
            kernels.scatter.dispatch(&mut pass, scatter, [n_blocks, 1, 1]);
        }
    }
}

fn fit(gpu: &Gpu, buffer: &mut wgpu::Buffer, size: u64) {
    if buffer.size() < size.max(16) {
        *buffer = gpu.buffer("sort", size, BufferUsages::STORAGE);
    }
}

impl Kernels {
    fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let kernel = |entry| library.kernel(gpu, "sort_radix", entry, &[], &[]);
        Ok(Self {
            count: kernel("count")?,
            scan: kernel("scan")?,
            scan_sums: kernel("scan_sums")?,
            scatter: kernel("scatter")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(gpu: &Gpu, keys: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let library = ShaderLibrary::embedded();
        let mut sort = Sort::new(gpu, &library).unwrap();
        let n = keys.len() as u32;
        sort.prepare(gpu, &library, n).unwrap();
        gpu.queue.write_buffer(sort.keys(), 0, bytemuck::cast_slice(keys));
        let values: Vec<u32> = (0..n).collect();
        gpu.queue.write_buffer(sort.values(), 0, bytemuck::cast_slice(&values));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        sort.record(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let read = |buffer| gpu.read_buffer::<u32>(buffer).unwrap()[..keys.len()].to_vec();
        (read(sort.keys()), read(sort.values()))
    }

    #[test]
    fn keys_are_sorted_and_equal_ones_stay_in_order() {
        let gpu = Gpu::headless().unwrap();
        for (n, mask) in [(1_u32, u32::MAX), (255, u32::MAX), (4_097, 0xff), (70_001, 0xf00f_0003), (20_000, u32::MAX)]
        {
            let keys: Vec<u32> = (0..n).map(|i| i.wrapping_mul(2_654_435_761).rotate_left(7) & mask).collect();
            let mut expected: Vec<u32> = (0..n).collect();
            expected.sort_by_key(|&i| keys[i as usize]);
            let (sorted_keys, values) = sorted(&gpu, &keys);
            assert!(sorted_keys.is_sorted(), "{n} items");
            assert_eq!(values, expected, "{n} items");
        }
    }
}
