//! A shadow technique as data: what it holds, and what is done in what order. [`super::Shadow`] carries a plan out.
//!
//! Each technique's file makes one; a trait with a method for each pass was rejected: bindings, clearing, layers and
//! lights would be written nine times.

use lorelei_core::look::{ShadowParams, Shadowing};

use super::params::{MapSize, n_parts};
use super::{clusters, deep_opacity, deep_shadow, front, occupancy, opacity_maps, voxels};

/// Words on the GPU under the name that shaders bind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Words {
    pub name: &'static str,
    pub label: &'static str,
    pub n: u64,
    /// Zero when a frame begins.
    pub clear: bool,
}

impl Words {
    pub fn cleared(name: &'static str, label: &'static str, n: u64) -> Self {
        Self { name, label, n, clear: true }
    }

    /// Written whole by a pass.
    pub fn written(name: &'static str, label: &'static str, n: u64) -> Self {
        Self { name, label, n, clear: false }
    }
}

/// One pass.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// Every segment of the strands that cast through the texels of every light's map, into a sink.
    Walk { sink: &'static str },
    /// Every segment of the strands that cast, in the world.
    Segments { file: &'static str, entry: &'static str },
    /// As many threads as there are items.
    Items { file: &'static str, entry: &'static str, n: u64 },
    /// Groups of 8 x 8 texels of every light's map.
    Texels { file: &'static str, entry: &'static str, overrides: Vec<(&'static str, f64)>, def: Option<&'static str> },
}

impl Step {
    /// The same pass over nothing: what its kernel is made from.
    pub fn kernel(&self) -> Self {
        match self {
            Self::Items { file, entry, .. } => Self::Items { file, entry, n: 0 },
            Self::Walk { .. } | Self::Segments { .. } | Self::Texels { .. } => self.clone(),
        }
    }
}

/// What a technique holds and does.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    pub buffers: Vec<Words>,
    pub steps: Vec<Step>,
}

impl Plan {
    /// `None` where nothing is drawn.
    pub fn of(shadowing: Shadowing, params: &ShadowParams, size: MapSize, scene: &SceneSize) -> Option<Self> {
        match shadowing {
            Shadowing::Off => None,
            Shadowing::ShadowMap | Shadowing::Exponential => Some(front::plan(size)),
            Shadowing::OpacityMaps => Some(opacity_maps::plan(size, n_parts(shadowing, params))),
            Shadowing::Clusters => Some(clusters::plan(size, params.n_rounds)),
            Shadowing::DeepOpacity => Some(deep_opacity::plan(size, n_parts(shadowing, params), params.beyond_last)),
            Shadowing::Occupancy => Some(occupancy::plan(size)),
            Shadowing::DeepShadow => Some(deep_shadow::plan(size, scene)),
            Shadowing::Voxels => Some(voxels::plan(params.n_voxels)),
        }
    }

    pub fn has_kernels_of(&self, other: &Self) -> bool {
        self.steps.iter().map(Step::kernel).eq(other.steps.iter().map(Step::kernel))
    }

    /// Bytes of the largest buffer.
    pub fn largest(&self) -> u64 {
        self.buffers.iter().map(|words| 4 * words.n).max().unwrap_or(0)
    }

    pub fn n_bytes(&self) -> u64 {
        self.buffers.iter().map(|words| 4 * words.n).sum()
    }

    /// Room for as many words as a buffer has.
    pub fn n_words(&self, name: &str) -> u64 {
        self.buffers.iter().find(|words| words.name == name).map_or(0, |words| words.n)
    }
}

/// What of the strands decides how much room lists need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SceneSize {
    /// Of the strands that cast.
    pub n_strands: u64,
    pub n_segments: u64,
}
