//! What draws and moves one groom on one device, for the window and for the command line alike.
//!
//! A frame from top to bottom: time, the head's pose, solver steps, strands, picture. The solver exists
//! from the first movement to the next reset; without it, guides rest on the head and follow it rigidly.

mod binder;
mod display;
pub mod pacer;
pub mod shown;
pub mod thread;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};
use lorelei_core::binding::LayerBinding;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::io::Watch;
use lorelei_core::light::Light;
use lorelei_core::look::Look;
use lorelei_core::motion::{HeadPose, Motion, neck_pivot};
use lorelei_core::simulation::SimulationSettings;
use lorelei_render::inspect::{InspectError, Inspection};
use lorelei_render::overlay::Overlay;
use lorelei_render::versus::{Comparison, Versus};
use lorelei_render::{Bound, FrameInput, RenderError, Renderer};
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};
use lorelei_sim::GpuSolver;

use crate::movement::Shot;
use display::Display;
use pacer::Detail;
use shown::Shown;
use thread::FrameReport;

/// Movement: not in the document, never undone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Playback {
    pub is_playing: bool,
    pub motion: Motion,
    /// Where the head was dragged to, on top of the preset.
    pub head_pose: HeadPose,
    /// Solver steps asked for one by one, since the start.
    pub n_steps: u64,
    /// Resets asked for, since the start.
    pub n_resets: u64,
}

/// Why a frame is missing or incomplete.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Inspect(#[from] InspectError),
    #[error(
        "the picture is incomplete: {listed} pieces of strands lie on its tiles and there is room for {room}; draw fewer strands, a smaller picture, or ribbons"
    )]
    LeftOut { listed: u64, room: u64 },
}

impl StageError {
    /// Nothing more can be drawn on this device.
    pub fn is_lost(&self) -> bool {
        let gpu = match self {
            Self::Gpu(gpu) | Self::Render(RenderError::Gpu(gpu)) | Self::Inspect(InspectError::Gpu(gpu)) => gpu,
            Self::Render(_) | Self::Inspect(_) | Self::Shader(_) | Self::LeftOut { .. } => return false,
        };
        matches!(gpu, GpuError::DeviceLost(_))
    }
}

/// The solver with what it was made for.
struct Moving {
    solver: GpuSolver,
    bindings: Vec<Arc<LayerBinding>>,
}

/// Guides of a [`Shot`] on the GPU.
struct ShotBuffers {
    world_from_head: Affine3A,
    guides: Vec<wgpu::Buffer>,
}

/// Shaders of a folder where `LORELEI_SHADERS` names one, for whoever edits them: each frame looks whether a file has
/// changed. The program's own otherwise.
pub fn shader_library() -> Result<ShaderLibrary, ShaderError> {
    match std::env::var_os("LORELEI_SHADERS") {
        Some(folder) => ShaderLibrary::watching(folder.as_ref()),
        None => Ok(ShaderLibrary::embedded()),
    }
}

/// One groom on one device.
pub struct Stage {
    gpu: Gpu,
    library: ShaderLibrary,
    renderer: Renderer,
    moving: Option<Moving>,
    n_layers: usize,
    settings: SimulationSettings,
    neck: Vec3,
    time_secs: f32,
    world_from_head: Affine3A,
    n_steps: u64,
    n_resets: u64,
    /// Times that guides moved.
    n_moves: u64,
    /// A frame that was simulated elsewhere, in place of what the stage's own solver says.
    shot: Option<ShotBuffers>,
    look: Look,
    lights: Vec<Light>,
    shown: Shown,
    versus: Versus,
    /// Where a window finds the picture.
    display: Option<Display>,
    /// Why the last edit of a shader is not in use, once that was told.
    shader_fault: Option<ShaderError>,
    is_lost: bool,
}

impl Stage {
    /// A stage whose pictures are read back.
    pub fn new(gpu: Gpu) -> Result<Self, StageError> {
        Self::with_library(gpu, None, shader_library()?)
    }

    /// A stage whose pictures a window shows.
    pub fn for_display(gpu: Gpu, display: Display) -> Result<Self, StageError> {
        Self::with_library(gpu, Some(display), shader_library()?)
    }

    fn with_library(gpu: Gpu, display: Option<Display>, library: ShaderLibrary) -> Result<Self, StageError> {
        Ok(Self {
            renderer: Renderer::new(&gpu, library.clone())?,
            versus: Versus::new(&gpu, &library)?,
            gpu,
            library,
            moving: None,
            n_layers: 0,
            settings: SimulationSettings::default(),
            neck: Vec3::ZERO,
            time_secs: 0.0,
            world_from_head: Affine3A::IDENTITY,
            n_steps: 0,
            n_resets: 0,
            n_moves: 0,
            shot: None,
            look: Look::default(),
            lights: Vec::new(),
            shown: Shown::default(),
            display,
            shader_fault: None,
            is_lost: false,
        })
    }

    /// Take over what changed in the groom. Returns warnings for the user.
    pub fn set_groom(&mut self, groom: &Groom) -> Result<Vec<String>, StageError> {
        let bound = self.bound().update(groom, Watch::default()).unwrap_or_default();
        self.set_bound(groom, bound)
    }

    /// What the strands on the stage are bound to.
    pub fn bound(&self) -> &Bound {
        self.renderer.mirror().bound()
    }

    /// As [`Stage::set_groom`], where the strands were bound already.
    pub fn set_bound(&mut self, groom: &Groom, bound: Bound) -> Result<Vec<String>, StageError> {
        let result = self.renderer.set_bound(groom, bound).map_err(StageError::from);
        self.is_lost |= result.as_ref().is_err_and(StageError::is_lost);
        let warnings = result?;
        self.look.clone_from(&groom.look);
        self.lights.clone_from(&groom.lights);
        self.n_layers = groom.layers.len();
        self.neck = neck_of(groom);
        if self.settings != groom.simulation {
            self.settings = groom.simulation.clone();
            if let Some(moving) = &mut self.moving {
                moving.solver.set_settings(&self.settings)?;
            }
        }
        let bindings = self.bindings();
        let is_same = |old: &Moving| {
            // Another style on the same guides moves on.
            old.bindings.len() == bindings.len()
                && old.bindings.iter().zip(&bindings).all(|(a, b)| Arc::ptr_eq(a, b) || a.guides == b.guides)
        };
        self.moving = self.moving.take().filter(is_same);
        if let Some(moving) = &mut self.moving {
            for (layer_idx, binding) in bindings.iter().enumerate() {
                moving.solver.set_ties(layer_idx, &binding.guide_ties);
            }
        }
        self.n_moves += 1;
        Ok(warnings)
    }

    fn bindings(&self) -> Vec<Arc<LayerBinding>> {
        (0..self.n_layers).filter_map(|layer_idx| self.renderer.mirror().binding(layer_idx).cloned()).collect()
    }

    /// Show a painted map on the scalp, or skin.
    pub fn set_overlay(&mut self, overlay: Option<&Overlay>) {
        self.renderer.set_overlay(overlay);
    }

    /// Show one term of the light alone, or another look beside the groom's own, from the next frame on.
    pub fn set_shown(&mut self, shown: &Shown) {
        self.shown.clone_from(shown);
        if shown.versus.is_none() {
            self.versus.clear();
        }
    }

    /// Show a frame that was simulated elsewhere, from the next frame on; `None`: what moves here. Layers that the shot does
    /// not fit are shown at rest.
    pub fn set_shot(&mut self, shot: Option<&Shot>) {
        self.shot = shot.map(|shot| {
            let buffer =
                |positions: &Vec<Vec4>| self.gpu.buffer_of("stage.shot", positions, wgpu::BufferUsages::STORAGE);
            ShotBuffers { world_from_head: shot.world_from_head, guides: shot.positions.iter().map(buffer).collect() }
        });
        self.n_moves += 1;
    }

    /// Make everything again in the next frame: for measurements.
    pub fn forget(&mut self) {
        self.renderer.forget();
    }

    /// Draw a frame and wait until it is on the GPU's output.
    pub fn frame(
        &mut self,
        playback: &Playback,
        dt_secs: f32,
        camera: &Camera,
        size: [u32; 2],
        detail: Detail,
    ) -> Result<(), StageError> {
        let result = self.record(playback, dt_secs, camera, size, detail).and_then(|()| self.tell_shader_fault());
        self.is_lost |= result.as_ref().is_err_and(StageError::is_lost);
        result
    }

    /// An edit of a shader that does not work, as an error of the first frame without it.
    fn tell_shader_fault(&mut self) -> Result<(), StageError> {
        let fault = self.renderer.shader_error().cloned();
        if fault == self.shader_fault {
            return Ok(());
        }
        self.shader_fault.clone_from(&fault);
        fault.map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Whether somebody edits shaders while the studio runs.
    pub fn watches_shaders(&self) -> bool {
        self.library.is_watching()
    }

    /// Whether a shader has changed on the disk since this was last asked or a frame was drawn.
    pub fn has_new_shaders(&self) -> bool {
        // A folder that is gone is told by the frame.
        self.library.poll().unwrap_or(true)
    }

    fn record(
        &mut self,
        playback: &Playback,
        dt_secs: f32,
        camera: &Camera,
        size: [u32; 2],
        detail: Detail,
    ) -> Result<(), StageError> {
        self.library.poll()?;
        let size = detail.size(size);
        self.renderer.set_look(&detail.look(&self.shown.look(&self.look)));
        self.renderer.set_lights(&self.shown.lights(&self.lights));
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("stage.frame") });
        if self.n_resets != playback.n_resets {
            self.n_resets = playback.n_resets;
            self.moving = None;
            self.n_moves += 1;
            self.time_secs = 0.0;
        }
        let n_steps = playback.n_steps.saturating_sub(self.n_steps);
        self.n_steps = playback.n_steps;
        if playback.is_playing {
            self.n_moves += 1;
            self.pass_time(playback, dt_secs, &mut encoder)?;
        } else if n_steps > 0 {
            self.n_moves += 1;
            for _ in 0..n_steps.min(16) {
                self.pass_step(playback, &mut encoder)?;
            }
        } else {
            let pose = self.pose(playback);
            if pose != self.world_from_head {
                // Put somewhere else while nothing moves: the hair is simply there too.
                self.moving = None;
                self.n_moves += 1;
                self.world_from_head = pose;
            }
        }
        let solver = self.moving.as_ref().map(|moving| &moving.solver);
        let guides: Vec<Option<&wgpu::Buffer>> = match &self.shot {
            Some(shot) => (0..self.n_layers).map(|layer_idx| self.shot_of_layer(shot, layer_idx)).collect(),
            None => (0..self.n_layers)
                .map(|layer_idx| solver.filter(|solver| layer_idx < solver.n_layers()).map(|s| s.positions(layer_idx)))
                .collect(),
        };
        let world_from_head = self.shot.as_ref().map_or(self.world_from_head, |shot| shot.world_from_head);
        let input = FrameInput {
            camera,
            size,
            world_from_head,
            guides: &guides,
            guides_stamp: self.n_moves,
            lod_scale: detail.lod,
        };
        self.renderer.render(&mut encoder, &input)?;
        let mut picture = self.renderer.output().clone();
        if let Some((look, comparison)) = &self.shown.versus {
            // One renderer draws both, one after the other: strands are made once, and so are shadows where the looks
            // cast the same.
            self.versus.keep(&self.gpu, &mut encoder, &picture);
            self.gpu.queue.submit([encoder.finish()]);
            self.renderer.collect_times();
            self.renderer.set_look(&detail.look(&self.shown.look(look)));
            encoder =
                self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("stage.versus") });
            self.renderer.render(&mut encoder, &input)?;
            self.versus.record(&self.gpu, &self.library, &mut encoder, self.renderer.output(), *comparison)?;
            picture = self.versus.output().unwrap_or(self.renderer.output()).clone();
        }
        if let Some(display) = &mut self.display {
            display.record(&self.gpu, &picture, &mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.renderer.collect_times();
        match &mut self.display {
            Some(display) => display.finish(&self.gpu, &picture)?,
            None => self.gpu.wait()?,
        }
        self.renderer.collect_times();
        let (listed, room) = self.renderer.n_tile_entries()?;
        if listed > room {
            return Err(StageError::LeftOut { listed, room });
        }
        Ok(())
    }

    /// A shot's guides of a layer, where there are as many as the layer has.
    fn shot_of_layer<'s>(&self, shot: &'s ShotBuffers, layer_idx: usize) -> Option<&'s wgpu::Buffer> {
        let n_vertices = self.renderer.mirror().binding(layer_idx)?.guides.positions.len() as u64;
        shot.guides.get(layer_idx).filter(|buffer| buffer.size() == (16 * n_vertices).max(16))
    }

    /// Put the two pictures of the last frame together in another way, without drawing them again.
    pub fn compare_again(&mut self, comparison: Comparison) -> Result<(), StageError> {
        if let Some((_, shown)) = &mut self.shown.versus {
            *shown = comparison;
        }
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("stage.versus") });
        self.versus.record(&self.gpu, &self.library, &mut encoder, self.renderer.output(), comparison)?;
        let Some(picture) = self.versus.output() else { return Ok(()) };
        if let Some(display) = &mut self.display {
            display.record(&self.gpu, picture, &mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        if let Some(display) = &mut self.display {
            display.finish(&self.gpu, picture)?;
        }
        Ok(())
    }

    /// What is under a pixel of the last frame.
    pub fn inspect(&mut self, pixel: [u32; 2]) -> Result<Option<Inspection>, StageError> {
        Ok(self.renderer.inspect(pixel)?)
    }

    fn pose(&self, playback: &Playback) -> Affine3A {
        (playback.motion.head_pose(self.time_secs) + playback.head_pose).world_from_head(self.neck)
    }

    fn pass_time(
        &mut self,
        playback: &Playback,
        dt_secs: f32,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), StageError> {
        self.start_moving(playback)?;
        self.time_secs += dt_secs;
        let pose = self.pose(playback);
        self.world_from_head = pose;
        if let Some(moving) = &mut self.moving {
            moving.solver.set_head_pose(&pose);
            moving.solver.advance(encoder, dt_secs)?;
        }
        Ok(())
    }

    fn pass_step(&mut self, playback: &Playback, encoder: &mut wgpu::CommandEncoder) -> Result<(), StageError> {
        self.start_moving(playback)?;
        self.time_secs += self.settings.steps_per_second.recip();
        let pose = self.pose(playback);
        self.world_from_head = pose;
        if let Some(moving) = &mut self.moving {
            moving.solver.set_head_pose(&pose);
            moving.solver.step_once(encoder)?;
        }
        Ok(())
    }

    /// Make the solver where there is none yet, at rest in the present pose.
    fn start_moving(&mut self, playback: &Playback) -> Result<(), StageError> {
        let bindings = self.bindings();
        if self.moving.is_some() || bindings.is_empty() {
            return Ok(());
        }
        let guides: Vec<_> = bindings.iter().map(|binding| &binding.guides).collect();
        let field = self.renderer.mirror().field().cloned();
        let mut solver = GpuSolver::new(&self.gpu, &self.library, &guides, field.as_deref(), &self.settings)?;
        for (layer_idx, binding) in bindings.iter().enumerate() {
            solver.set_ties(layer_idx, &binding.guide_ties);
        }
        self.world_from_head = self.pose(playback);
        solver.set_head_pose(&self.world_from_head);
        solver.reset();
        self.moving = Some(Moving { solver, bindings });
        Ok(())
    }

    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Lose the GPU as a driver that was reset would, for tests.
    pub fn lose_gpu(&mut self) {
        self.gpu.device.destroy();
        self.is_lost = true;
    }

    pub fn adapter_name(&self) -> String {
        self.gpu.adapter_info.name.clone()
    }

    /// The picture of the last frame: straight alpha, encoded for an sRGB display.
    pub fn read_pixels(&self) -> Result<image::RgbaImage, StageError> {
        let picture = self.versus.output().unwrap_or(self.renderer.output());
        let pixels = self.renderer.read_pixels_of(picture)?;
        let [width, height] = pixels.size;
        Ok(image::RgbaImage::from_raw(width, height, pixels.rgba).expect("as many bytes as the size says"))
    }

    /// GPU milliseconds by pass, of the newest frame that was timed.
    pub fn pass_times(&self) -> Vec<(String, f32)> {
        self.renderer.pass_times().into_iter().map(|(pass, ms)| (pass, ms as f32)).collect()
    }

    pub fn statistics(&self) -> lorelei_render::FrameStatistics {
        let statistics = self.renderer.statistics();
        lorelei_render::FrameStatistics { n_bytes: statistics.n_bytes + self.versus.n_bytes(), ..statistics }
    }

    /// Fill in what the last frame was made of.
    pub fn describe(&self, report: &mut FrameReport) {
        let statistics = self.statistics();
        report.n_strands = u64::from(statistics.n_strands);
        report.n_vertices = u64::from(statistics.n_vertices);
        report.n_bytes = statistics.n_bytes;
        report.n_drawing_bytes = statistics.n_drawing_bytes;
        report.n_shadow_bytes = statistics.n_shadow_bytes;
        report.pass_times = self.pass_times();
        report.sim_secs = self.time_secs;
        report.world_from_head = self.world_from_head;
        report.texture = self.display.as_ref().and_then(Display::texture).cloned();
    }
}

/// Below the neck's joint, a bust is no part of the portrait, centimetres.
const BELOW_NECK: f32 = 8.0;

/// The box around hair and head at rest, without what a bust has below the neck; a box of a head's size
/// where there is nothing.
pub fn bounds_of(groom: &Groom) -> (Vec3, Vec3) {
    let lowest = neck_of(groom).y - BELOW_NECK;
    let above = groom.head.iter().flat_map(|head| head.mesh.positions.iter().filter(|p| p.y >= lowest));
    let mut all =
        above.fold(None, |all: Option<(Vec3, Vec3)>, &p| Some(all.map_or((p, p), |(lo, hi)| (lo.min(p), hi.max(p)))));
    let mut add = |(min, max): (Vec3, Vec3)| {
        all = Some(all.map_or((min, max), |(lo, hi)| (lo.min(min), hi.max(max))));
    };
    for layer in groom.layers.iter().filter(|layer| layer.visible) {
        match &layer.source {
            Source::Guides(strands) | Source::Strands(strands) => strands.bounds().into_iter().for_each(&mut add),
            Source::HairMesh(mesh) => {
                mesh.layers.iter().flat_map(|layer| &layer.positions).for_each(|&p| add((p, p)));
            }
        }
    }
    all.unwrap_or((Vec3::splat(-12.0), Vec3::splat(12.0)))
}

/// What the head turns about, in head space.
pub fn neck_of(groom: &Groom) -> Vec3 {
    groom.head.as_ref().map_or(Vec3::ZERO, |head| neck_pivot(&head.mesh))
}
