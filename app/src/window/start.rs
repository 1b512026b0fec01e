//! Opening the window: eframe with the features and limits that the renderer wants, and once more from
//! the start where the GPU was lost.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use lorelei_shaders::Gpu;

use super::Studio;

/// What the window is opened with.
#[derive(Debug, Clone)]
pub struct StartOptions {
    pub file: Option<PathBuf>,
    pub head: Option<PathBuf>,
    /// `--report-state`.
    pub report_state: Option<PathBuf>,
    /// Where settings and recovery files are kept; `None`: where the system keeps such.
    pub data_folder: Option<PathBuf>,
    /// Draw on the window's device even where its driver is software, for tests.
    pub share_gpu: bool,
    /// When the program started.
    pub started: Instant,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    #[error(
        "the window could not be opened: {0}\nA display and a Vulkan, Metal or DirectX 12 driver are needed; `lorelei render` needs no display"
    )]
    Eframe(String),
    #[error("the GPU was lost {0} times in a row; the groom was kept at {1}")]
    GpuLost(u32, String),
}

/// A window that ended because the GPU was lost leaves here what to go on with.
pub type Handover = Arc<Mutex<Option<PathBuf>>>;

/// Times that a new window is opened after the GPU was lost.
const MAX_LOSSES: u32 = 3;

/// Open the window; returns when it was closed.
pub fn open(options: StartOptions) -> Result<(), WindowError> {
    let mut options = options;
    for n_losses in 0..=MAX_LOSSES {
        let handover = Handover::default();
        run_once(options.clone(), n_losses > 0, Arc::clone(&handover))?;
        let kept = handover.lock().unwrap_or_else(PoisonError::into_inner).take();
        match kept {
            None => return Ok(()),
            Some(path) => {
                options.file = Some(path);
                options.started = Instant::now();
            }
        }
    }
    let kept = options.file.unwrap_or_default();
    Err(WindowError::GpuLost(MAX_LOSSES + 1, kept.display().to_string()))
}

fn run_once(options: StartOptions, is_after_loss: bool, handover: Handover) -> Result<(), WindowError> {
    let mut setup = egui_wgpu_setup();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(new) = &mut setup {
        new.device_descriptor = Arc::new(Gpu::device_descriptor);
        // OpenGL has no compute shaders of the kind that the rasteriser needs.
        new.instance_descriptor.backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    }
    let mut native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Lorelei")
            .with_app_id("lorelei")
            .with_inner_size([1500.0, 940.0])
            .with_min_inner_size([820.0, 520.0])
            .with_icon(icon())
            .with_drag_and_drop(true),
        persistence_path: options.data_folder.as_ref().map(|folder| folder.join("settings.ron")),
        ..eframe::NativeOptions::default()
    };
    native.wgpu_options.wgpu_setup = setup;
    let make: eframe::AppCreator<'_> =
        Box::new(move |context| Ok(Box::new(Studio::new(context, options, is_after_loss, handover)?)));
    eframe::run_native("Lorelei", native, make).map_err(|why| WindowError::Eframe(why.to_string()))
}

fn egui_wgpu_setup() -> eframe::egui_wgpu::WgpuSetup {
    eframe::egui_wgpu::WgpuSetup::without_display_handle()
}

/// A lock of hair on dark grey, drawn here so that there is no file to keep.
fn icon() -> egui::IconData {
    const SIDE: u32 = 64;
    let mut rgba = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (u, v) = (x as f32 / SIDE as f32, y as f32 / SIDE as f32);
            let from_middle = ((u - 0.5).powi(2) + (v - 0.5).powi(2)).sqrt();
            let alpha = ((0.48 - from_middle) * SIDE as f32).clamp(0.0, 1.0);
            // Seven strands that swing together and part at the tips.
            let light = (0..7).map(|strand| {
                let offset = (strand as f32 - 3.0) * (0.045 + 0.05 * v);
                let centre = 0.5 + 0.13 * (v * 6.0 + 0.4).sin() + offset;
                (1.0 - (u - centre).abs() * 34.0).clamp(0.0, 1.0)
            });
            let light = light.fold(0.0_f32, f32::max) * (1.0 - (v - 0.45).abs()).clamp(0.0, 1.0);
            let mix = |dark: f32, bright: f32| (dark + (bright - dark) * light) as u8;
            rgba.extend([mix(34.0, 236.0), mix(34.0, 186.0), mix(34.0, 104.0), (255.0 * alpha) as u8]);
        }
    }
    egui::IconData { rgba, width: SIDE, height: SIDE }
}
