//! A compute entry point as a pipeline that is bound by variable name.

use naga::ShaderStage;

use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::layout::reflect;
use crate::link::Linked;
use crate::pipeline::{Bindings, Pipeline};

/// A compute pipeline. Its layouts come from the shader.
pub type Kernel = Pipeline<wgpu::ComputePipeline>;

impl Kernel {
    pub(crate) fn new(gpu: &Gpu, linked: &Linked, entry: &str, overrides: &[(&str, f64)]) -> Result<Self, ShaderError> {
        let reflected = reflect(gpu, linked, &[(ShaderStage::Compute, entry)], overrides)?;
        let pipeline = gpu
            .checked(|| {
                gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(&reflected.label),
                    layout: Some(&reflected.pipeline_layout),
                    module: &reflected.shader,
                    entry_point: None,
                    compilation_options: wgpu::PipelineCompilationOptions {
                        // Every kernel writes its workgroup memory before it reads it.
                        zero_initialize_workgroup_memory: false,
                        ..wgpu::PipelineCompilationOptions::default()
                    },
                    cache: None,
                })
            })
            .map_err(|error| ShaderError::Pipeline { label: reflected.label.clone(), message: error.to_string() })?;
        Ok(Self {
            label: reflected.label,
            inner: pipeline,
            groups: reflected.groups,
            workgroup_size: reflected.workgroup_size,
        })
    }

    /// Threads of a workgroup, overrides applied.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }

    /// Record a dispatch of this many workgroups.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, bindings: &Bindings, workgroups: [u32; 3]) {
        self.set(pass, bindings);
        pass.dispatch_workgroups(workgroups[0], workgroups[1], workgroups[2]);
    }

    /// Record a dispatch of at least `n_items` threads along x (and y, see [`grid_1d`]).
    pub fn dispatch_items(&self, pass: &mut wgpu::ComputePass<'_>, bindings: &Bindings, n_items: u32) {
        self.dispatch(pass, bindings, grid_1d(n_items, self.workgroup_size[0]));
    }

    /// Record a dispatch whose workgroup counts (three `u32`) are in a buffer.
    pub fn dispatch_indirect(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &Bindings,
        counts: &wgpu::Buffer,
        offset: u64,
    ) {
        self.set(pass, bindings);
        pass.dispatch_workgroups_indirect(counts, offset);
    }

    fn set(&self, pass: &mut wgpu::ComputePass<'_>, bindings: &Bindings) {
        pass.set_pipeline(&self.inner);
        for (group_idx, group) in bindings.groups.iter().enumerate() {
            pass.set_bind_group(group_idx as u32, group, &[]);
        }
    }
}

/// Workgroups for `n_items` items, folded into y where x alone would be over the limit of 65,535. The shader's item:
/// `id.x + id.y * num_workgroups.x * workgroup_size`, to be compared with the number of items.
pub fn grid_1d(n_items: u32, workgroup_size: u32) -> [u32; 3] {
    let n_groups = n_items.div_ceil(workgroup_size.max(1));
    let n_rows = n_groups.div_ceil(65_535).max(1);
    [n_groups.div_ceil(n_rows), n_rows, 1]
}
