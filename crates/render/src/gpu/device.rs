//! The adapter that is chosen, the device on it, and what it may fail with.

use core::time::Duration;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use wgpu::{DeviceType, ErrorFilter};

use crate::RenderError;

/// Storage buffers that one pass binds.
const STORAGE_BUFFERS: u32 = 23;
/// A submission is a tile; one that takes longer than this hangs.
const LONGEST_WAIT: Duration = Duration::from_secs(600);

/// Which adapters will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterChoice {
    /// Graphics hardware only.
    Hardware,
    /// Hardware, or else a driver that computes on the processor.
    HardwareOrSoftware,
}

/// A device and its queue.
#[derive(Debug)]
pub(super) struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) limits: wgpu::Limits,
    /// Name, driver and interface, as it stands in records.
    pub(super) adapter: String,
    /// The first that went wrong outside of any scope: a lost device, most of all.
    lost: Arc<Mutex<Option<String>>>,
    /// Bytes that came back from it.
    pub(super) bytes_read: AtomicU64,
}

/// Whether the system shows a card at all. Asking the drivers instead would load those that compute on the processor too, a second's
/// work, only to turn them down.
fn may_have_hardware() -> bool {
    const NODES: [&str; 6] = [
        "/dev/dri",
        "/dev/nvidiactl",
        "/dev/dxg",
        "/dev/kgsl-3d0",
        "/dev/mali0",
        "/dev/nvhost-gpu",
    ];
    !cfg!(target_os = "linux") || NODES.iter().any(|node| std::path::Path::new(node).exists())
}

impl Gpu {
    pub(super) fn new(choice: AdapterChoice) -> Result<Self, RenderError> {
        if choice == AdapterChoice::Hardware && !may_have_hardware() {
            return Err(RenderError::NoAdapter {
                wanted: "a graphics card",
            });
        }
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        adapters.retain(|adapter| {
            choice == AdapterChoice::HardwareOrSoftware
                || adapter.get_info().device_type != DeviceType::Cpu
        });
        // The sort is stable: among equals the first that the driver names.
        adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        });
        let Some(adapter) = adapters.first() else {
            return Err(RenderError::NoAdapter {
                wanted: match choice {
                    AdapterChoice::Hardware => "a graphics card",
                    AdapterChoice::HardwareOrSoftware => "a graphics card or a software driver",
                },
            });
        };
        Self::on(adapter)
    }

    fn on(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        let name = format!(
            "{} ({} {}, {})",
            info.name, info.driver, info.driver_info, info.backend
        );
        let limits = adapter.limits();
        let check = |limit: &str, wanted: u64, found: u64| {
            if found >= wanted {
                return Ok(());
            }
            Err(RenderError::AdapterLimit {
                adapter: name.clone(),
                limit: limit.to_owned(),
                wanted,
                found,
            })
        };
        check(
            "storage buffers per shader stage",
            STORAGE_BUFFERS.into(),
            limits.max_storage_buffers_per_shader_stage.into(),
        )?;
        check("bind groups", 4, limits.max_bind_groups.into())?;
        check(
            "invocations per workgroup",
            64,
            limits.max_compute_invocations_per_workgroup.into(),
        )?;
        let refused = |error: &dyn core::fmt::Display| RenderError::Device {
            adapter: name.clone(),
            message: error.to_string(),
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("rodsight"),
            required_limits: limits.clone(),
            // Only to tell how long a pass takes.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| refused(&error))?;
        let lost = Arc::new(Mutex::new(None));
        let note = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, message| {
            note.lock()
                .expect("nobody panics with it")
                .get_or_insert(format!("the device is lost: {message}"));
        });
        let note = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note.lock()
                .expect("nobody panics with it")
                .get_or_insert(error.to_string());
        }));
        Ok(Self {
            device,
            queue,
            limits,
            adapter: name,
            lost,
            bytes_read: AtomicU64::new(0),
        })
    }

    pub(super) fn error(&self, message: impl Into<String>) -> RenderError {
        RenderError::Device {
            adapter: self.adapter.clone(),
            message: message.into(),
        }
    }

    /// Whether a limit of the adapter is kept.
    pub(super) fn check(&self, limit: &str, wanted: u64, found: u64) -> Result<(), RenderError> {
        if wanted <= found {
            return Ok(());
        }
        Err(RenderError::AdapterLimit {
            adapter: self.adapter.clone(),
            limit: limit.to_owned(),
            wanted,
            found,
        })
    }

    /// Whether a storage buffer of so many bytes may be had and bound.
    pub(super) fn check_storage(&self, of: &str, wanted: u64) -> Result<(), RenderError> {
        let limits = &self.limits;
        for (limit, found) in [
            ("max_buffer_size", limits.max_buffer_size),
            (
                "max_storage_buffer_binding_size",
                limits.max_storage_buffer_binding_size,
            ),
        ] {
            self.check(&format!("{limit}, bytes, for the {of}"), wanted, found)?;
        }
        Ok(())
    }

    /// A buffer with these contents.
    pub(super) fn filled(
        &self,
        label: &str,
        contents: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, RenderError> {
        let size = contents.len() as u64;
        self.check_storage(label, size)?;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: true,
        });
        // There is nothing to write to where memory ran out or the device is lost.
        let mut view = buffer.get_mapped_range_mut(..).map_err(|error| {
            self.error(format!("buffer of {size} bytes for the {label}: {error}"))
        })?;
        view.copy_from_slice(contents);
        drop(view);
        buffer.unmap();
        Ok(buffer)
    }

    /// Runs something and reports what the device found wrong in it.
    pub(super) fn watched<T>(
        &self,
        work: impl FnOnce() -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let scopes = [
            ErrorFilter::Validation,
            ErrorFilter::Internal,
            ErrorFilter::OutOfMemory,
        ]
        .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        let mut found = None;
        for scope in scopes.into_iter().rev() {
            found = pollster::block_on(scope.pop()).or(found);
        }
        // On a lost device everything else fails too. That it is lost is told when it is asked.
        self.device.poll(wgpu::PollType::Poll).ok();
        if let Some(message) = self.lost.lock().expect("nobody panics with it").clone() {
            return Err(self.error(message));
        }
        if let Some(error) = found {
            return Err(self.error(error.to_string()));
        }
        result
    }

    /// Reads the beginning of a buffer that a finished submission has written.
    pub(super) fn mapped<T>(
        &self,
        buffer: &wgpu::Buffer,
        size: u64,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        let (tell, told) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, 0..size, move |result| {
            // Nobody listens any more when the poll below has failed.
            tell.send(result).ok();
        });
        let failed = |error: &dyn core::fmt::Display| self.error(format!("reading back: {error}"));
        self.device
            .poll(wgpu::PollType::Poll)
            .map_err(|error| failed(&error))?;
        // It may be another thread's poll that found this buffer ready and is about to say so.
        told.recv_timeout(LONGEST_WAIT)
            .map_err(|error| failed(&error))?
            .map_err(|error| failed(&error))?;
        let view = buffer
            .get_mapped_range(0..size)
            .map_err(|error| failed(&error))?;
        let value = read(&view);
        self.bytes_read.fetch_add(size, Ordering::Relaxed);
        drop(view);
        buffer.unmap();
        Ok(value)
    }

    /// Waits for a submission.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        self.device
            .poll(wgpu::PollType::Wait {
                submission_index: Some(submission),
                timeout: Some(LONGEST_WAIT),
            })
            .map(|_| ())
            .map_err(|error| self.error(format!("waiting for a submission: {error}")))
    }
}
