//! A device with its queue, and the one place that says which features and limits the studio asks for.

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::GpuError;

/// Bytes of the smallest buffer: an empty array still needs room for one element to be bound.
const SMALLEST: u64 = 256;

/// Handles to a GPU; a clone is the same GPU.
#[derive(Debug, Clone)]
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter_info: wgpu::AdapterInfo,
    /// The first error that no error scope caught, since [`Gpu::take_error`].
    failure: Arc<Mutex<Option<GpuError>>>,
}

impl Gpu {
    /// The best GPU without a window. `WGPU_ADAPTER_NAME` (part of a name, any case) and `WGPU_BACKEND` choose
    /// another one.
    pub fn headless() -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        descriptor.flags = Self::instance_flags();
        // OpenGL, which another crate may have built in, lacks what the shaders need: saying that there is no GPU
        // is kinder than its errors.
        descriptor.backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
        let backends = descriptor.backends;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = match std::env::var("WGPU_ADAPTER_NAME") {
            Ok(name) => {
                let adapters = pollster::block_on(instance.enumerate_adapters(backends));
                let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
                let wanted = name.to_lowercase();
                let found = adapters.into_iter().find(|a| a.get_info().name.to_lowercase().contains(&wanted));
                found.ok_or_else(|| {
                    GpuError::NoAdapter(format!("none is called `{name}`; there are: {}", names.join(", ")))
                })?
            }
            Err(_) => pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..wgpu::RequestAdapterOptions::default()
            }))
            .map_err(|error| GpuError::NoAdapter(error.to_string()))?,
        };
        let adapter_info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&Self::device_descriptor(&adapter)))
            .map_err(|error| GpuError::NoDevice { adapter: adapter_info.name.clone(), reason: error.to_string() })?;
        Ok(Self::from_parts(device, queue, adapter_info))
    }

    /// What an instance checks: in a release build not the counts of indirect dispatches and draws. Only our own kernels
    /// write them, and each check is a dispatch and two barriers. Debug builds, and so all tests, check them.
    #[must_use]
    pub fn instance_flags() -> wgpu::InstanceFlags {
        let mut flags = wgpu::InstanceFlags::from_build_config();
        if !cfg!(debug_assertions) {
            flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
        }
        flags.with_env()
    }

    /// Take over a device that somebody else made (eframe), best by [`Gpu::device_descriptor`].
    ///
    /// From here on its uncaught errors are kept for [`Gpu::take_error`] instead of ending the program.
    pub fn from_parts(device: wgpu::Device, queue: wgpu::Queue, adapter_info: wgpu::AdapterInfo) -> Self {
        let failure = Arc::new(Mutex::new(None));
        let keep = {
            let failure = Arc::clone(&failure);
            move |error: GpuError| {
                let mut slot = failure.lock().unwrap_or_else(PoisonError::into_inner);
                log::error!("{error}");
                // What comes after the first error is mostly its consequence.
                slot.get_or_insert(error);
            }
        };
        let keep_lost = keep.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(gpu_error(&error))));
        device.set_device_lost_callback(move |reason, message| {
            // `Destroyed` is our own doing, at the end of the program.
            if reason == wgpu::DeviceLostReason::Unknown {
                keep_lost(GpuError::DeviceLost(message));
            }
        });
        Self { device, queue, adapter_info, failure }
    }

    /// What to ask an adapter for: every optional feature that the studio can use, limits as large as it gives.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("lorelei"),
            required_features: Self::required_features(adapter),
            required_limits: Self::required_limits(adapter),
            ..wgpu::DeviceDescriptor::default()
        }
    }

    /// The optional features that the adapter has. Ask [`Gpu::has`] before using one.
    pub fn required_features(adapter: &wgpu::Adapter) -> wgpu::Features {
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
            | wgpu::Features::SHADER_INT64
            | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX
            | wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS
            | wgpu::Features::SUBGROUP
            | wgpu::Features::FLOAT32_FILTERABLE;
        adapter.features() & wanted
    }

    pub fn required_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
        adapter.limits()
    }

    pub fn has(&self, features: wgpu::Features) -> bool {
        self.device.features().contains(features)
    }

    /// Largest buffer that one binding can show to a shader, bytes.
    pub fn max_storage_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// The first error that happened outside of any error scope since the last call: a lost device, memory that ran
    /// out, a refused command.
    pub fn take_error(&self) -> Result<(), GpuError> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Run `work` and return the errors that it caused, memory running out included.
    pub fn checked<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let value = work();
        let errors = [internal, memory, validation].map(|scope| pollster::block_on(scope.pop()));
        match errors.iter().flatten().next() {
            Some(error) => Err(gpu_error(error)),
            None => Ok(value),
        }
    }

    /// Block until everything submitted has been done.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| GpuError::DeviceLost(error.to_string()))?;
        self.take_error()
    }

    /// A buffer with the bytes of `contents` in it; empty contents make a buffer of one
    /// element, since a binding holds at least that.
    pub fn buffer_of<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        contents: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let size = (bytes.len() as u64).max(size_of::<T>() as u64).next_multiple_of(16).max(16);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if !bytes.is_empty() {
            self.queue.write_buffer(&buffer, 0, bytes);
        }
        buffer
    }

    /// A buffer of `size` bytes (at least 256), zeroed.
    pub fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.next_multiple_of(16).max(SMALLEST),
            usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    /// Copy a buffer back and wait for it: for tests, statistics and export, never for a frame.
    pub fn read_buffer<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
        let size = buffer.size();
        let staging = self.checked(|| {
            let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("gpu.read_buffer"),
                size,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
            self.queue.submit([encoder.finish()]);
            staging
        })?;
        self.read_mapped(&staging, bytemuck::pod_collect_to_vec)
    }

    /// Map a `MAP_READ` buffer, wait, and look at its bytes.
    pub fn read_mapped<R>(&self, staging: &wgpu::Buffer, read: impl FnOnce(&[u8]) -> R) -> Result<R, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when this function has already returned an error.
            let _ = sender.send(result);
        });
        self.wait()?;
        match receiver.recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(GpuError::Refused(error.to_string())),
            Err(_) => return Err(GpuError::DeviceLost("no answer to a read".to_owned())),
        }
        let result = {
            let view = staging.slice(..).get_mapped_range().map_err(|error| GpuError::Refused(error.to_string()))?;
            read(&view)
        };
        staging.unmap();
        Ok(result)
    }
}

fn gpu_error(error: &wgpu::Error) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
            GpuError::Refused(description.clone())
        }
    }
}
