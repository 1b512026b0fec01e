//! The levels of detail of a groom as pictures with what each cost, on a device of their own: for the command line and
//! for the panel alike.

use std::time::Instant;

use image::RgbaImage;
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::lod::LodChoice;
use lorelei_shaders::Gpu;

use crate::stage::pacer::Detail;
use crate::stage::{Playback, Stage, StageError};

/// Frames of a level whose times are compared; the quickest counts, which nothing else on the machine disturbed.
const N_FRAMES: usize = 3;

/// One level, drawn.
#[derive(Debug, Clone)]
pub struct LevelPicture {
    pub level: f32,
    pub n_strands: u32,
    pub n_vertices: u32,
    /// The whole frame, everything made again.
    pub ms: f32,
    pub picture: RgbaImage,
}

/// A groom on a stage that draws any of its levels.
pub struct LevelStage {
    stage: Stage,
    groom: Groom,
    camera: Camera,
    size: [u32; 2],
}

impl LevelStage {
    pub fn new(groom: &Groom, camera: Camera, size: [u32; 2]) -> Result<Self, StageError> {
        let mut stage = Stage::new(Gpu::headless()?)?;
        stage.set_groom(groom)?;
        Ok(Self { stage, groom: groom.clone(), camera, size })
    }

    /// Draw a level; between whole numbers a blend.
    pub fn draw(&mut self, level: f32) -> Result<LevelPicture, StageError> {
        self.groom.lod.choice = LodChoice::Level(level);
        self.stage.set_groom(&self.groom)?;
        let mut ms = f32::INFINITY;
        for _ in 0..N_FRAMES {
            self.stage.forget();
            let start = Instant::now();
            self.stage.frame(&Playback::default(), 0.0, &self.camera, self.size, Detail::FULL)?;
            ms = ms.min(start.elapsed().as_secs_f32() * 1e3);
        }
        let statistics = self.stage.statistics();
        let picture = self.stage.read_pixels()?;
        Ok(LevelPicture { level, n_strands: statistics.n_strands, n_vertices: statistics.n_vertices, ms, picture })
    }
}

/// The pictures in a row.
pub fn side_by_side(levels: &[LevelPicture]) -> RgbaImage {
    let width = levels.iter().map(|drawn| drawn.picture.width()).sum::<u32>().max(1);
    let height = levels.iter().map(|drawn| drawn.picture.height()).max().unwrap_or(1);
    let mut strip = RgbaImage::new(width, height);
    let mut left = 0;
    for drawn in levels {
        image::imageops::replace(&mut strip, &drawn.picture, left, 0);
        left += i64::from(drawn.picture.width());
    }
    strip
}
