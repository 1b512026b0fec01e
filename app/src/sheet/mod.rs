//! Contact sheets: every choice of one slot of the look in one picture, with what each costs on this machine. For the
//! command line and for the window alike.
//!
//! Each choice gets a stage of its own, so that its bytes are its own and not what another choice has left behind.

mod picture;

use std::time::{Duration, Instant};

use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, HairMaterial};
use lorelei_core::io::Watch;
use lorelei_core::look::{ChoiceInfo, Look};
use lorelei_render::Bound;
use lorelei_shaders::Gpu;

use crate::stage::pacer::Detail;
use crate::stage::{Playback, Stage, StageError};

/// One choice, drawn.
pub struct Tile {
    pub info: ChoiceInfo,
    /// It is what the groom's own look has.
    pub is_chosen: bool,
    /// GPU milliseconds of a frame in which everything is made anew; `None` where the GPU has no timestamps.
    pub gpu_ms: Option<f32>,
    /// By pass, of the frame that `gpu_ms` is of.
    pub passes: Vec<(String, f32)>,
    /// GPU memory of buffers and textures.
    pub n_bytes: u64,
    pub n_strands: u32,
    /// The picture, or why there is none.
    pub picture: Result<image::RgbaImage, String>,
}

/// Every choice of one slot, drawn.
pub struct Sheet {
    pub slot: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    /// What was drawn, for the line under the title.
    pub subject: String,
    pub tiles: Vec<Tile>,
}

/// What a sheet is drawn of.
#[derive(Clone, Copy)]
pub struct SheetInput<'a> {
    pub groom: &'a Groom,
    pub camera: &'a Camera,
    /// Pixels of a tile.
    pub size: [u32; 2],
    /// Frames that are timed, after one that is not; the quickest counts.
    pub n_frames: u32,
}

/// A slot's key, label and help.
type SlotName = (&'static str, &'static str, &'static str);

/// The slots that a sheet can be made of: the look's and the fibre's.
pub fn slots() -> Vec<SlotName> {
    let (mut look, mut material) = (Look::default(), HairMaterial::default());
    let mut names: Vec<SlotName> = look.slots().iter().map(|slot| (slot.key, slot.label, slot.help)).collect();
    let fibre = material.slot();
    names.push((fibre.key, fibre.label, fibre.help));
    names
}

/// The choices of a slot, and which of them the groom has. The fibre is the first layer's.
fn choices(groom: &Groom, key: &str) -> (Vec<ChoiceInfo>, usize) {
    let mut look = groom.look.clone();
    let mut material = groom.layers.first().map_or_else(HairMaterial::default, |layer| layer.material.clone());
    let mut slots = look.slots();
    slots.push(material.slot());
    let found = slots.iter().find(|slot| slot.key == key);
    found.map_or((Vec::new(), 0), |slot| (slot.choice.infos(), slot.choice.index()))
}

/// The groom with another choice in a slot; the fibre of every layer.
fn with_choice(groom: &Groom, key: &str, choice_idx: usize) -> Groom {
    let mut groom = groom.clone();
    for slot in groom.look.slots().iter_mut().filter(|slot| slot.key == key) {
        slot.choice.set_index(choice_idx);
    }
    for layer in &mut groom.layers {
        let fibre = layer.material.slot();
        if fibre.key == key {
            fibre.choice.set_index(choice_idx);
        }
    }
    groom
}

/// Draw every choice of a slot of [`slots`]; `None` where it was cancelled.
pub fn draw(
    gpu: &Gpu,
    (slot, label, help): SlotName,
    input: &SheetInput<'_>,
    watch: Watch<'_>,
) -> Result<Option<Sheet>, StageError> {
    let (infos, chosen) = choices(input.groom, slot);
    let mut bound = Bound::default();
    let mut tiles = Vec::with_capacity(infos.len());
    let n = infos.len().max(1) as f32;
    for (choice_idx, info) in infos.into_iter().enumerate() {
        watch.progress(choice_idx as f32 / n);
        let groom = with_choice(input.groom, slot, choice_idx);
        let Some(next) = bound.update(&groom, Watch { on_progress: None, cancel: watch.cancel }) else {
            return Ok(None);
        };
        bound = next;
        let mut tile = Tile {
            info,
            is_chosen: choice_idx == chosen,
            gpu_ms: None,
            passes: Vec::new(),
            n_bytes: 0,
            n_strands: 0,
            picture: Err(String::new()),
        };
        match draw_tile(gpu, &groom, bound.clone(), input, &mut tile) {
            Ok(picture) => tile.picture = Ok(picture),
            Err(why) if why.is_lost() => return Err(why),
            Err(why) => tile.picture = Err(why.to_string()),
        }
        tiles.push(tile);
        if watch.cancelled() {
            return Ok(None);
        }
    }
    watch.progress(1.0);
    let n_strands = tiles.iter().map(|tile| tile.n_strands).max().unwrap_or(0);
    let [width, height] = input.size;
    let adapter = &gpu.adapter_info.name;
    let subject = format!("{}, {n_strands} strands, {width} x {height}, {adapter}", input.groom.name);
    Ok(Some(Sheet { slot, label, help, subject, tiles }))
}

/// How long a GPU draws a choice at least: while shaders are compiled it rests, and takes a while to come back to its speed.
const WARM_UP: Duration = Duration::from_millis(300);

fn draw_tile(
    gpu: &Gpu,
    groom: &Groom,
    bound: Bound,
    input: &SheetInput<'_>,
    tile: &mut Tile,
) -> Result<image::RgbaImage, StageError> {
    let mut stage = Stage::new(gpu.clone())?;
    stage.set_bound(groom, bound)?;
    let is_software = gpu.adapter_info.device_type == wgpu::DeviceType::Cpu;
    let warm_up = if is_software || input.n_frames == 0 { Duration::ZERO } else { WARM_UP };
    let begin = Instant::now();
    for frame in 0.. {
        if frame > input.n_frames && begin.elapsed() >= warm_up {
            break;
        }
        stage.forget();
        stage.frame(&Playback::default(), 0.0, input.camera, input.size, Detail::FULL)?;
        let passes = stage.pass_times();
        let ms: f32 = passes.iter().map(|(_, ms)| ms).sum();
        let is_quickest = tile.gpu_ms.is_none_or(|quickest| ms < quickest);
        // The first frame also compiles; it counts where no other is drawn.
        if !passes.is_empty() && is_quickest && (frame > 0 || input.n_frames == 0) {
            (tile.gpu_ms, tile.passes) = (Some(ms), passes);
        }
    }
    let statistics = stage.statistics();
    (tile.n_bytes, tile.n_strands) = (statistics.n_bytes, statistics.n_strands);
    stage.read_pixels()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slot_has_choices_and_another_choice_changes_only_that_slot() {
        let groom = lorelei_assets::default_groom();
        for (key, ..) in slots() {
            let (infos, chosen) = choices(&groom, key);
            assert!(!infos.is_empty(), "{key}");
            assert!(with_choice(&groom, key, chosen) == groom, "{key}");
            for choice_idx in (0..infos.len()).filter(|idx| *idx != chosen) {
                let other = with_choice(&groom, key, choice_idx);
                assert_eq!(choices(&other, key).1, choice_idx, "{key}");
                let back = with_choice(&other, key, chosen);
                assert!(other != groom && back == groom, "{key}");
            }
        }
    }
}
