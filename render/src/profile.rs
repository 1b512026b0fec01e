//! GPU time of every pass, a few frames late, from timestamps (wgpu-profiler).

use std::ops::Range;

use lorelei_shaders::{Gpu, GpuError};
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

/// How the passes begin that turn shaded strands into pixels, whichever technique does it.
pub const DRAWING_PASSES: &[&str] = &["raster.", "blended", "sliced", "fragments", "downsample"];

/// Times passes on the encoder's own line, so that whoever records a pass need not know about it.
pub(crate) struct Profile {
    profiler: GpuProfiler,
    /// A frame has been recorded and not yet ended.
    is_open: bool,
    /// Milliseconds by pass of the latest frame that came back.
    times: Vec<(String, f64)>,
}

impl Profile {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        // Mesa 22.3's software driver crashes in vkCmdBeginDebugUtilsLabelEXT.
        let settings = GpuProfilerSettings {
            max_num_pending_frames: 4,
            enable_debug_groups: false,
            ..GpuProfilerSettings::default()
        };
        let profiler = GpuProfiler::new(&gpu.device, settings).map_err(|error| GpuError::Refused(error.to_string()))?;
        Ok(Self { profiler, is_open: false, times: Vec::new() })
    }

    /// Record a pass between two timestamps.
    pub fn pass<R>(
        &mut self,
        label: &str,
        encoder: &mut wgpu::CommandEncoder,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> R,
    ) -> R {
        self.is_open = true;
        let query = self.profiler.begin_query(label, encoder);
        let result = record(encoder);
        self.profiler.end_query(encoder, query);
        result
    }

    /// After the last pass of a frame, on the same encoder.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.profiler.resolve_queries(encoder);
    }

    /// After the frame's encoder was submitted: ask for its times, and take those that have come.
    pub fn collect(&mut self, gpu: &Gpu) {
        if std::mem::take(&mut self.is_open)
            && let Err(error) = self.profiler.end_frame()
        {
            log::warn!("no GPU times for this frame: {error}");
        }
        while let Some(frame) = self.profiler.process_finished_frame(gpu.queue.get_timestamp_period()) {
            self.times = frame.into_iter().filter_map(pass_time).collect();
        }
    }

    pub fn times(&self) -> &[(String, f64)] {
        &self.times
    }
}

fn pass_time(query: GpuTimerQueryResult) -> Option<(String, f64)> {
    let Range { start, end } = query.time?;
    Some((query.label, (end - start) * 1e3))
}
