//! Opening the window: eframe with the features and limits that the renderer wants; and once more, in a new
//! process, where it ended badly: the GPU was lost.

use std::cell::Cell;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use lorelei_core::groom::Groom;
use lorelei_shaders::Gpu;

use super::{Studio, recovery};

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
    /// What a window that ended badly had open, and the file that it belongs to.
    pub recovered: Option<PathBuf>,
    pub recovered_path: Option<PathBuf>,
    /// Windows that ended badly, one after the other.
    pub n_losses: u32,
    /// Between two writes of unsaved changes.
    pub autosave: Duration,
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
    #[error("the GPU was lost {0} times in a row; the groom was kept at {1}: open it when the driver works again")]
    GpuLost(u32, String),
    #[error("the window ended unexpectedly; what was changed is offered at the next start")]
    Ended,
    #[error("the window ended unexpectedly, and the groom could not be kept: {0}")]
    NotKept(String),
    #[error("the window ended unexpectedly, and no new one could be opened: {1}\nThe groom was kept at {0}")]
    NotAgain(String, std::io::Error),
}

/// What a window that ends badly leaves to go on with.
#[derive(Debug, Default)]
pub struct Kept {
    /// The document as it is, with its file; renewed by every change.
    pub latest: Option<(Groom, Option<PathBuf>)>,
    /// Where it is written; `None` where nothing can be kept.
    pub file: Option<PathBuf>,
    /// The window ended because the GPU was lost.
    pub is_lost: bool,
}

pub type Handover = Arc<Mutex<Kept>>;

/// Times that a new window is opened after one that ended badly.
const MAX_LOSSES: u32 = 3;

thread_local! {
    /// Panics of this thread's window that are not caught yet.
    static N_PANICS: Cell<u32> = const { Cell::new(0) };
}

/// Open the window; returns when it was closed.
pub fn open(options: &StartOptions) -> Result<(), WindowError> {
    let handover = Handover::default();
    rescue_from_second_panic(options.clone(), Arc::clone(&handover));
    let theirs = (options.clone(), Arc::clone(&handover));
    // Painting on a lost device panics inside egui's renderer.
    let ended = std::panic::catch_unwind(AssertUnwindSafe(move || run_once(theirs.0, theirs.1)));
    N_PANICS.set(0);
    let kept = std::mem::take(&mut *handover.lock().unwrap_or_else(PoisonError::into_inner));
    match ended {
        Ok(result) if !kept.is_lost => return result,
        Ok(_) | Err(_) => {}
    }
    go_on(options, kept)
}

/// What lets go of a lost device may panic as well while the first panic unwinds, and the language then aborts: so go on
/// from where the second is told, as nothing comes after it. The window that is dead lies behind the new one until
/// that ends.
fn rescue_from_second_panic(options: StartOptions, handover: Handover) {
    let window_thread = std::thread::current().id();
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        tell(panic);
        if std::thread::current().id() != window_thread {
            return;
        }
        N_PANICS.set(N_PANICS.get() + 1);
        if N_PANICS.get() != 2 {
            return;
        }
        let kept = match handover.try_lock() {
            Ok(mut kept) => std::mem::take(&mut *kept),
            Err(TryLockError::Poisoned(kept)) => std::mem::take(&mut *kept.into_inner()),
            Err(TryLockError::WouldBlock) => return,
        };
        let ended = go_on(&options, kept);
        if let Err(why) = &ended {
            eprintln!("{why}");
        }
        std::process::exit(i32::from(ended.is_err()));
    }));
}

/// After a window that ended badly: write down what it had, and open another.
fn go_on(options: &StartOptions, kept: Kept) -> Result<(), WindowError> {
    let Some(((groom, path), file)) = kept.latest.zip(kept.file) else { return Err(WindowError::Ended) };
    lorelei_core::document::save(&groom, &file).map_err(|why| WindowError::NotKept(why.to_string()))?;
    let n_losses = options.n_losses;
    if n_losses >= MAX_LOSSES {
        return Err(WindowError::GpuLost(n_losses + 1, file.display().to_string()));
    }
    open_again(options, path.as_deref(), &file)
}

/// Go on in a new process: a process has one event loop, and after a panic nothing of it can be trusted.
fn open_again(options: &StartOptions, path: Option<&Path>, kept: &Path) -> Result<(), WindowError> {
    let failed = |why: std::io::Error| WindowError::NotAgain(kept.display().to_string(), why);
    let mut command = std::process::Command::new(std::env::current_exe().map_err(failed)?);
    command.arg("--recovered").arg(kept).arg("--losses").arg((options.n_losses + 1).to_string());
    for (name, value) in [
        ("--report-state", options.report_state.as_deref()),
        ("--data-folder", options.data_folder.as_deref()),
        ("--recovered-path", path),
    ] {
        if let Some(value) = value {
            command.arg(name).arg(value);
        }
    }
    if options.share_gpu {
        command.arg("--share-gpu");
    }
    match command.status() {
        Ok(status) if status.success() => {
            // The other process went on with it.
            kept.parent().map_or(Ok(()), recovery::forget_own_run).map_err(failed)
        }
        Ok(_) => Err(WindowError::Ended),
        Err(why) => Err(failed(why)),
    }
}

fn run_once(options: StartOptions, handover: Handover) -> Result<(), WindowError> {
    let mut setup = egui_wgpu_setup();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(new) = &mut setup {
        new.device_descriptor = Arc::new(Gpu::device_descriptor);
        // OpenGL has no compute shaders of the kind that the rasteriser needs.
        new.instance_descriptor.flags = Gpu::instance_flags();
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
    let make: eframe::AppCreator<'_> = Box::new(move |context| Ok(Box::new(Studio::new(context, options, handover)?)));
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
