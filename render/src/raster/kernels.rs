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

    /// Side of a tile in pixels.
    pub fn tile_side(self) -> u32 {
        match self {
            Self::Segments => 8,
            Self::Lanes => 8,
        }
    }

    /// Twin of [`Threads::tile_side`], for every shader that knows of tiles.
    pub fn tile_slot(self) -> Link<'static> {
        Link::Slot(
            "tile",
            match self {
                Self::Segments => "tile_8",
                Self::Lanes => "tile_8",
            },
        )
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
        let mut links = vec![self.tile_slot()];
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
    pub fn new(gpu: &Gpu, library: &ShaderLibrary, threads: Threads) -> Result<Self, ShaderError> {
        let kernel = |file, entry, links: &[Link<'_>]| library.kernel(gpu, file, entry, &[], links);
        Ok(Self {
            gather: kernel("raster_front", "gather", &[threads.tile_slot()])?,
            find: kernel("raster_front", "find", &[threads.tile_slot(), Link::Def("FIND")])?,
            count: kernel("raster_bin", "bin", &[threads.tile_slot()])?,
            scatter: kernel("raster_bin", "bin", &[threads.tile_slot(), Link::Def("SCATTER")])?,
            allocate: kernel("raster_alloc", "allocate", &[threads.tile_slot()])?,
            plan: kernel("raster_alloc", "plan", &[threads.tile_slot()])?,
        })
    }
}
