//! The rasteriser's kernels, and what decides which of two does the last pass.

use lorelei_core::look::{Antialiasing, Look, ShadingRate};
use lorelei_shaders::{Gpu, Kernel, Link, ShaderError, ShaderLibrary};

use crate::slot;

/// What the threads of the last pass own: the fastest depends on the kind of device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Threads {
    /// A thread walks the pixels of a segment and adds to sums in workgroup memory: `raster_fine.wgsl`.
    Segments,
    /// A thread is a lane of a CPU's vectors and owns a column of pixels: `raster_lanes.wgsl`.
    Lanes,
}

impl Threads {
    /// The faster one.
    pub fn for_gpu(gpu: &Gpu) -> Self {
        let info = &gpu.adapter_info;
        let has_lanes = gpu.has(wgpu::Features::SUBGROUP) && info.subgroup_min_size >= 8;
        if info.device_type == wgpu::DeviceType::Cpu && has_lanes { Self::Lanes } else { Self::Segments }
    }

    /// What can draw a look: lanes know strands shaded at their vertices and exact areas alone.
    pub fn for_look(self, look: &Look) -> Self {
        let is_plain = match look.antialiasing {
            Antialiasing::Analytic | Antialiasing::Super2 | Antialiasing::Super3 => true,
            Antialiasing::None | Antialiasing::Msaa4 | Antialiasing::AlphaToCoverage => false,
        };
        if is_plain && look.shading_rate == ShadingRate::PerVertex { self } else { Self::Segments }
    }

    /// The file of the last pass.
    pub fn fine_file(self) -> &'static str {
        match self {
            Self::Segments => "raster_fine",
            Self::Lanes => "raster_lanes",
        }
    }

    /// What is linked into it; `is_wide` only matters to lanes.
    pub fn fine_links(self, look: &Look, is_wide: bool) -> Vec<Link<'static>> {
        let mut links = Vec::new();
        match self {
            Self::Segments => {
                links.push(slot::antialiasing(look.antialiasing));
                links.extend(slot::shading_rate(look));
            }
            Self::Lanes => links.extend(is_wide.then_some(Link::Def("WIDE"))),
        }
        links
    }
}

/// The passes before the last.
pub(super) struct Kernels {
    pub gather: Kernel,
    pub find: Kernel,
    pub count: Kernel,
    pub scatter: Kernel,
    pub allocate: Kernel,
    pub plan: Kernel,
}

impl Kernels {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let kernel = |file, entry, links: &[Link<'_>]| library.kernel(gpu, file, entry, &[], links);
        Ok(Self {
            gather: kernel("raster_front", "gather", &[])?,
            find: kernel("raster_front", "find", &[Link::Def("FIND")])?,
            count: kernel("raster_bin", "bin", &[])?,
            scatter: kernel("raster_bin", "bin", &[Link::Def("SCATTER")])?,
            allocate: kernel("raster_alloc", "allocate", &[])?,
            plan: kernel("raster_alloc", "plan", &[])?,
        })
    }
}
