//! What can go wrong between a shader file, a device and a pipeline; each says where and what to do.

/// The GPU itself failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error(
        "no GPU was found ({0}); install a Vulkan driver (Debian and Ubuntu: `apt-get install mesa-vulkan-drivers libvulkan1`, which also brings a software one)"
    )]
    NoAdapter(String),
    #[error("the GPU `{adapter}` gave no device: {reason}")]
    NoDevice { adapter: String, reason: String },
    #[error("the GPU ran out of memory; use fewer strands, fewer vertices or a smaller picture")]
    OutOfMemory,
    #[error("the GPU device was lost ({0}); reopen the document to start it again")]
    DeviceLost(String),
    #[error("the GPU refused a command: {0}")]
    Refused(String),
}

/// A shader could not be linked, made into a pipeline or bound.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// A fault in a WGSL file. `line` starts at 1; 0 where the fault has no place.
    #[error("{file}.wgsl:{line}: {message}")]
    Source { file: String, line: u32, message: String },
    #[error("there is no shader file `{file}.wgsl`")]
    NoFile { file: String },
    #[error("`{file}.wgsl` imports `{import}`, which no file defines and no slot stands in for")]
    NoImport { file: String, import: String },
    #[error("`{file}.wgsl` has no {stage} entry point `{entry}`; it has: {has}")]
    NoEntry { file: String, stage: &'static str, entry: String, has: String },
    #[error("`{label}`: {message}")]
    Pipeline { label: String, message: String },
    #[error("`{label}` needs `{name}` bound; bound were: {bound}")]
    Unbound { label: String, name: String, bound: String },
    #[error("`{label}` has no variable `{name}`; it has: {has}")]
    UnknownBinding { label: String, name: String, has: String },
    #[error("cannot read shader folder {folder}: {message}")]
    Folder { folder: String, message: String },
}
