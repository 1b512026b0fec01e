//! WGSL files linked, reloaded while developing, and turned into pipelines whose layouts are read from
//! the module: nobody writes a bind group layout by hand or binds by position. Nothing here knows hair.
//!
//! In a `.wgsl` file of `shaders/wgsl/`:
//! - `#define_import_path lorelei::NAME` makes it importable, `NAME` being its file stem;
//! - `#import lorelei::NAME::{item, ..}` imports;
//! - resources are `@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;`: numbers are given
//!   per entry point after linking, to the variables that it uses;
//! - `override N: u32 = 4u;` is set by name when the pipeline is made, but cannot size a workgroup (naga_oil 0.23
//!   loses such an override's expression): `@workgroup_size(#{WIDTH})` with [`Link::DefU32`] can;
//! - a *slot* is an import path that no file defines: [`Link::Slot`] says which file stands in for it. A file that can
//!   says so by a line `// slot: NAME`, so that a test links every combination.

mod draw;
mod error;
mod gpu;
mod hot;
mod kernel;
mod layout;
mod library;
mod link;
mod pipeline;

pub use draw::{Draw, DrawDescriptor};
pub use error::{GpuError, ShaderError};
pub use gpu::Gpu;
pub use hot::Hot;
pub use kernel::{Kernel, grid_1d};
pub use library::{Link, ShaderLibrary};
pub use pipeline::{Bindings, Pipeline};
