//! Bind group layouts read from a linked module, and a shader module cut down to what one pipeline uses.

use std::collections::BTreeMap;

use naga::valid::{ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, ImageDimension, ScalarKind, ShaderStage, StorageAccess, TypeInner};

use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::link::{Linked, capabilities};
use crate::pipeline::Bindings;

/// Everything that a pipeline is made from, whatever its kind.
pub(crate) struct Reflected {
    pub label: String,
    pub shader: wgpu::ShaderModule,
    pub groups: Groups,
    pub pipeline_layout: wgpu::PipelineLayout,
    pub workgroup_size: [u32; 3],
}

/// Layouts of a pipeline's bind groups, with the names of what is bound.
#[derive(Debug, Clone)]
pub(crate) struct Groups {
    label: String,
    layouts: Vec<wgpu::BindGroupLayout>,
    /// Per group: variable name to binding number.
    names: Vec<BTreeMap<String, u32>>,
}

/// Cut `linked` down to the named entry points, set its overrides, number its bindings, make the shader module.
pub(crate) fn reflect(
    gpu: &Gpu,
    linked: &Linked,
    entries: &[(ShaderStage, &str)],
    overrides: &[(&str, f64)],
) -> Result<Reflected, ShaderError> {
    let names: Vec<&str> = entries.iter().map(|entry| entry.1).collect();
    let label = format!("{}.{}", linked.file, names.join("+"));
    let fail = |message: String| ShaderError::Pipeline { label: label.clone(), message };

    let mut module = linked.module.clone();
    for &(stage, name) in entries {
        if !module.entry_points.iter().any(|entry| entry.stage == stage && entry.name == name) {
            let has: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
            return Err(ShaderError::NoEntry {
                file: linked.file.clone(),
                stage: match stage {
                    ShaderStage::Vertex => "vertex",
                    ShaderStage::Fragment => "fragment",
                    _ => "compute",
                },
                entry: name.to_owned(),
                has: has.join(", "),
            });
        }
    }
    let constants = overrides.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    module.entry_points.retain(|entry| entries.contains(&(entry.stage, entry.name.as_str())));
    let info = validate(&module).map_err(&fail)?;
    let (module, _) = naga::back::pipeline_constants::process_overrides(&module, &info, None, &constants)
        .map_err(|error| fail(error.to_string()))?;
    let mut module = module.into_owned();
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);

    number_bindings(&mut module, &label)?;
    let info = validate(&module).map_err(&fail)?;
    let groups = groups_of(gpu, &module, &info, &label)?;
    let code = naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
        .map_err(|error| fail(error.to_string()))?;
    let (shader, pipeline_layout) = gpu
        .checked(|| {
            let shader = shader_module(gpu, &label, &code);
            let layouts: Vec<Option<&wgpu::BindGroupLayout>> = groups.layouts.iter().map(Some).collect();
            let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&label),
                bind_group_layouts: &layouts,
                immediate_size: 0,
            });
            (shader, layout)
        })
        .map_err(|error| fail(error.to_string()))?;
    let workgroup_size = module.entry_points[0].workgroup_size;
    Ok(Reflected { label, shader, groups, pipeline_layout, workgroup_size })
}

/// In a release build without bounds checks and loop bounds: in some kernels they cost an order of magnitude. Debug
/// builds and tests keep them.
#[allow(unsafe_code)]
fn shader_module(gpu: &Gpu, label: &str, code: &str) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source: wgpu::ShaderSource::Wgsl(code.into()) };
    if cfg!(debug_assertions) {
        return gpu.device.create_shader_module(descriptor);
    }
    // SAFETY: the code comes from this repository's own WGSL files (or, while developing, from the developer's
    // folder), validated by naga; every test runs it with the checks on.
    unsafe { gpu.device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}

fn validate(module: &naga::Module) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), capabilities()).validate(module).map_err(|error| {
        naga::error::ShaderError { source: String::new(), label: None, inner: Box::new(error) }.inner.to_string()
    })
}

/// Give the resources of each group the numbers 0, 1, .. in the order of their names.
fn number_bindings(module: &mut naga::Module, label: &str) -> Result<(), ShaderError> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let mut by_name = BTreeMap::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        let name = variable.name.clone().unwrap_or_default();
        if by_name.insert((binding.group, name.clone()), handle).is_some() {
            let message = format!("two resources are called `{name}`; rename one of them");
            return Err(ShaderError::Pipeline { label: label.to_owned(), message });
        }
    }
    for ((group, _), handle) in by_name {
        let number = next.entry(group).or_insert(0);
        let variable = module.global_variables.get_mut(handle);
        variable.binding = Some(naga::ResourceBinding { group, binding: *number });
        *number += 1;
    }
    Ok(())
}

fn groups_of(gpu: &Gpu, module: &naga::Module, info: &ModuleInfo, label: &str) -> Result<Groups, ShaderError> {
    let mut entries: BTreeMap<u32, Vec<wgpu::BindGroupLayoutEntry>> = BTreeMap::new();
    let mut names: BTreeMap<u32, BTreeMap<String, u32>> = BTreeMap::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        let name = variable.name.clone().unwrap_or_default();
        let mut visibility = wgpu::ShaderStages::empty();
        let mut is_filtered = false;
        for (entry_idx, entry) in module.entry_points.iter().enumerate() {
            let entry_info = info.get_entry_point(entry_idx);
            if !entry_info[handle].is_empty() {
                visibility |= wgpu_naga_bridge::map_naga_stage(entry.stage);
            }
            is_filtered |= entry_info.sampling_set.iter().any(|key| key.image == handle);
        }
        let ty = binding_type(variable.space, &module.types[variable.ty].inner, is_filtered).ok_or_else(|| {
            ShaderError::Pipeline {
                label: label.to_owned(),
                message: format!("`{name}` is of a kind that cannot be bound"),
            }
        })?;
        entries.entry(binding.group).or_default().push(wgpu::BindGroupLayoutEntry {
            binding: binding.binding,
            visibility,
            ty,
            count: None,
        });
        names.entry(binding.group).or_default().insert(name, binding.binding);
    }
    let n_groups = entries.keys().next_back().map_or(0, |&group| group + 1);
    let layouts = (0..n_groups)
        .map(|group| {
            gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: entries.get(&group).map_or(&[], Vec::as_slice),
            })
        })
        .collect();
    let names = (0..n_groups).map(|group| names.remove(&group).unwrap_or_default()).collect();
    Ok(Groups { label: label.to_owned(), layouts, names })
}

fn binding_type(space: AddressSpace, inner: &TypeInner, is_filtered: bool) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    match (space, inner) {
        (AddressSpace::Uniform, _) => Some(buffer(wgpu::BufferBindingType::Uniform)),
        (AddressSpace::Storage { access }, _) => {
            let read_only = !access.contains(StorageAccess::STORE);
            Some(buffer(wgpu::BufferBindingType::Storage { read_only }))
        }
        (AddressSpace::Handle, TypeInner::Sampler { comparison }) => Some(wgpu::BindingType::Sampler(if *comparison {
            wgpu::SamplerBindingType::Comparison
        } else {
            wgpu::SamplerBindingType::Filtering
        })),
        (AddressSpace::Handle, &TypeInner::Image { dim, arrayed, class }) => {
            let view_dimension = match (dim, arrayed) {
                (ImageDimension::D1, _) => wgpu::TextureViewDimension::D1,
                (ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
                (ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
                (ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
                (ImageDimension::Cube, false) => wgpu::TextureViewDimension::Cube,
                (ImageDimension::Cube, true) => wgpu::TextureViewDimension::CubeArray,
            };
            match class {
                ImageClass::Sampled { kind, multi } => Some(wgpu::BindingType::Texture {
                    sample_type: match kind {
                        ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                        ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                        _ => wgpu::TextureSampleType::Float { filterable: is_filtered },
                    },
                    view_dimension,
                    multisampled: multi,
                }),
                ImageClass::Depth { multi } => Some(wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension,
                    multisampled: multi,
                }),
                ImageClass::Storage { format, access } => Some(wgpu::BindingType::StorageTexture {
                    access: match (access.contains(StorageAccess::LOAD), access.contains(StorageAccess::STORE)) {
                        _ if access.contains(StorageAccess::ATOMIC) => wgpu::StorageTextureAccess::Atomic,
                        (true, true) => wgpu::StorageTextureAccess::ReadWrite,
                        (true, false) => wgpu::StorageTextureAccess::ReadOnly,
                        (false, _) => wgpu::StorageTextureAccess::WriteOnly,
                    },
                    format: wgpu_naga_bridge::map_storage_format_from_naga(format),
                    view_dimension,
                }),
                ImageClass::External => None,
            }
        }
        _ => None,
    }
}

impl Groups {
    /// Names of everything that must be bound.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().flat_map(|names| names.keys().map(String::as_str))
    }

    /// Bind by name. `strict` refuses names that the pipeline does not have.
    pub fn bind(
        &self,
        gpu: &Gpu,
        resources: &[(&str, wgpu::BindingResource<'_>)],
        strict: bool,
    ) -> Result<Bindings, ShaderError> {
        if strict && let Some((name, _)) = resources.iter().find(|(name, _)| !self.names().any(|n| n == *name)) {
            return Err(ShaderError::UnknownBinding {
                label: self.label.clone(),
                name: (*name).to_owned(),
                has: self.names().collect::<Vec<_>>().join(", "),
            });
        }
        let mut groups = Vec::with_capacity(self.layouts.len());
        for (layout, names) in self.layouts.iter().zip(&self.names) {
            let mut entries = Vec::with_capacity(names.len());
            for (name, &binding) in names {
                let Some((_, resource)) = resources.iter().find(|(given, _)| given == name) else {
                    return Err(ShaderError::Unbound {
                        label: self.label.clone(),
                        name: name.clone(),
                        bound: resources.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "),
                    });
                };
                entries.push(wgpu::BindGroupEntry { binding, resource: resource.clone() });
            }
            let descriptor = wgpu::BindGroupDescriptor { label: Some(&self.label), layout, entries: &entries };
            let group = gpu
                .checked(|| gpu.device.create_bind_group(&descriptor))
                .map_err(|error| ShaderError::Pipeline { label: self.label.clone(), message: error.to_string() })?;
            groups.push(group);
        }
        Ok(Bindings { groups })
    }
}
