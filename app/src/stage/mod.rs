//! What draws and moves one groom on one device, for the window and for the command line alike.
//!
//! A frame from top to bottom: time, the head's pose, solver steps ([`player`]), strands, picture. Without a solver, guides
//! rest on the head and follow it rigidly.

mod binder;
mod display;
pub mod hold;
mod inputs;
mod maker;
pub mod pacer;
pub mod player;
pub mod report;
pub mod shown;
pub mod thread;
mod worker;

#[cfg(test)]
mod player_tests;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::Vec3;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::io::Watch;
use lorelei_core::light::Light;
use lorelei_core::look::Look;
use lorelei_core::motion::{HeadPose, neck_pivot};
use lorelei_render::inspect::{InspectError, Inspection};
use lorelei_render::overlay::Overlay;
use lorelei_render::versus::{Comparison, Versus};
use lorelei_render::{Bound, FrameInput, RenderError, Renderer};
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};

use display::Display;
use hold::{Hand, Sight};
use maker::Gear;
use pacer::Detail;
use player::{Player, Score};
use report::{FrameReport, Timeline};
use shown::Shown;

use crate::movement::range::Ranged;
use crate::movement::{Course, Shot, Subject};

/// What a person does with the timeline: not in the document, never undone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Playback {
    pub is_playing: bool,
    /// Where the head was dragged to, on top of the movement.
    pub head_pose: HeadPose,
    /// Frames forward, less frames back, asked for one by one since the start.
    pub n_steps: i64,
    /// Resets asked for, since the start.
    pub n_resets: u64,
    /// Times that a frame was asked for, and the last one of them.
    pub n_seeks: u64,
    pub seek: u32,
    /// Holds hair.
    pub hand: Option<Hand>,
}

impl Playback {
    /// Ask for a frame.
    pub fn seek(&mut self, frame_idx: u32) {
        self.n_seeks += 1;
        self.seek = frame_idx;
    }
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
    player: Player,
    /// Times that guides moved.
    n_moves: u64,
    look: Look,
    lights: Vec<Light>,
    shown: Shown,
    versus: Versus,
    /// Where a window finds the picture.
    display: Option<Display>,
    /// Why the last edit of a shader is not in use, once that was told.
    shader_fault: Option<ShaderError>,
    /// Why guides are moved instead of strands, once that was told.
    too_much: Option<String>,
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
            player: Player::new(),
            n_moves: 0,
            look: Look::default(),
            lights: Vec::new(),
            shown: Shown::default(),
            display,
            shader_fault: None,
            too_much: None,
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
        let layers = self.bound().layers().map(|(layer, binding)| (layer.clone(), Arc::clone(binding))).collect();
        let score = Score { course: Course::of(groom), movement: groom.movement.bounded() };
        let gear = Gear {
            gpu: &self.gpu,
            library: &self.library,
            field: self.renderer.mirror().field(),
            waits: self.display.is_none(),
        };
        let too_much = self.player.set_score(&gear, layers, score)?;
        self.n_moves += 1;
        let too_much = too_much.map(|too_much| format!("Guides are moved instead of strands: {too_much}"));
        // Said once, not with every edit.
        let is_news = too_much != self.too_much;
        self.too_much.clone_from(&too_much);
        Ok(warnings.into_iter().chain(too_much.filter(|_| is_news)).collect())
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

    /// Show a frame that was simulated elsewhere, until something moves. Layers that the shot does not fit are shown at rest.
    pub fn show_shot(&mut self, shot: &Shot) {
        self.player.show(&self.gpu, shot);
        self.n_moves += 1;
    }

    /// Take over frames that were simulated elsewhere; false where they are of another movement, hair or head.
    pub fn offer(&mut self, ranged: &Ranged) -> bool {
        let subject = Subject::of(self.bound(), self.player.moved());
        let is_fit = self.player.key(&subject) == ranged.key;
        if is_fit {
            self.player.set_frames(ranged.frames.clone());
        }
        is_fit
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
        let gear = Gear {
            gpu: &self.gpu,
            library: &self.library,
            field: self.renderer.mirror().field(),
            waits: self.display.is_none(),
        };
        let sight = Sight { camera: *camera, aspect: size[0].max(1) as f32 / size[1].max(1) as f32 };
        if self.player.pass(&gear, playback, &sight, dt_secs, &mut encoder)? {
            self.n_moves += 1;
        }
        self.player.record_held(&self.gpu, &mut encoder);
        let moved = self.player.moved_layers();
        let world_from_head = self.player.world_from_head();
        let input = FrameInput {
            camera,
            size,
            world_from_head,
            moved: &moved,
            moved_stamp: self.n_moves,
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
        self.player.collect(&self.gpu)?;
        self.renderer.collect_times();
        let (listed, room) = self.renderer.n_tile_entries()?;
        if listed > room {
            return Err(StageError::LeftOut { listed, room });
        }
        Ok(())
    }

    /// The timeline's present, and the frames that are kept.
    pub fn player(&mut self) -> &mut Player {
        &mut self.player
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
        report.world_from_head = self.player.world_from_head();
        report.timeline = Timeline::of(&self.player);
        report.held = self.player.held();
        report.texture = self.display.as_ref().and_then(Display::texture).cloned();
    }
}

/// Below the neck's joint, a bust is no part of the portrait, centimetres.
const BELOW_NECK: f32 = 8.0;

/// Vertices of the head, without what a bust has below the neck.
pub fn portrait_of(groom: &Groom) -> impl Iterator<Item = Vec3> {
    let lowest = neck_of(groom).y - BELOW_NECK;
    let all = groom.head.iter().flat_map(|head| head.mesh.positions.iter().copied());
    all.filter(move |p| p.y >= lowest)
}

/// The box around hair and head at rest, without what a bust has below the neck; a box of a head's size
/// where there is nothing.
pub fn bounds_of(groom: &Groom) -> (Vec3, Vec3) {
    let mut all = portrait_of(groom)
        .fold(None, |all: Option<(Vec3, Vec3)>, p| Some(all.map_or((p, p), |(lo, hi)| (lo.min(p), hi.max(p)))));
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
