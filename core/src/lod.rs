//! Levels of detail: discrete ones that an artist sets and paints, and the blend between them that is drawn.
//!
//! A level says what share of the strands and of their vertices is left, and how wide they are beyond what
//! keeps the covered area. Between two levels everything runs through, so that a groom that walks away never
//! pops. Maps painted for a level thin strands out where the artist wants them fewest; those that are left
//! there are wider, up to [`MOST_WIDER`] times, so that the same area stays covered.

use serde::{Deserialize, Serialize};

use crate::binding::LayerBinding;
use crate::maps::{MOST_LOD_LEVELS, MapKind};

/// How many times wider a strand gets, at most, where a painted map took its neighbours away.
pub const MOST_WIDER: f32 = 4.0;

/// One level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LodLevel {
    /// Share of the strands, 0-1.
    pub strands: f32,
    /// Share of the vertices of each strand, 0-1; 4 always stay.
    pub vertices: f32,
    /// Width as a multiple of what keeps the covered area.
    pub thickness: f32,
    /// Where the hair's height in the picture, as a share of the picture's, falls to this, the level is reached.
    pub screen_size: f32,
}

impl Default for LodLevel {
    fn default() -> Self {
        Self { strands: 1.0, vertices: 1.0, thickness: 1.0, screen_size: 0.8 }
    }
}

/// Which level is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum LodChoice {
    /// The finest, whatever is seen of it.
    #[default]
    Finest,
    /// By the hair's height in the picture.
    Automatic,
    /// This one; between whole numbers a blend.
    Level(f32),
}

/// The levels of a groom, finest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LodSettings {
    pub choice: LodChoice,
    pub levels: Vec<LodLevel>,
}

impl Default for LodSettings {
    fn default() -> Self {
        let level = |strands, vertices, screen_size| LodLevel { strands, vertices, screen_size, ..LodLevel::default() };
        Self {
            choice: LodChoice::Finest,
            levels: vec![level(1.0, 1.0, 0.8), level(0.5, 0.75, 0.4), level(0.2, 0.5, 0.18), level(0.06, 0.35, 0.07)],
        }
    }
}

/// What is drawn of every layer: between two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LodBlend {
    pub strands: f32,
    pub vertices: f32,
    pub thickness: f32,
    /// The two levels whose painted maps count, and the share of the second.
    pub levels: [u8; 2],
    pub between: f32,
}

impl Default for LodBlend {
    fn default() -> Self {
        Self { strands: 1.0, vertices: 1.0, thickness: 1.0, levels: [0, 0], between: 0.0 }
    }
}

impl LodSettings {
    /// The coarsest level's number.
    pub fn last(&self) -> f32 {
        self.levels.len().saturating_sub(1).min(usize::from(MOST_LOD_LEVELS - 1)) as f32
    }

    /// The level at a height in the picture, as a share of the picture's: linear in its logarithm between two
    /// levels.
    pub fn level_at(&self, screen_size: f32) -> f32 {
        let size = |level: &LodLevel| level.screen_size.max(1e-4);
        let at = screen_size.max(1e-4);
        let mut found = 0.0;
        for (i, pair) in self.levels.windows(2).enumerate() {
            let (from, to) = (size(&pair[0]), size(&pair[1]).min(size(&pair[0]) * 0.999));
            if at <= from {
                found = i as f32 + ((from / at).ln() / (from / to).ln()).clamp(0.0, 1.0);
            }
        }
        found.min(self.last())
    }

    /// What is drawn at a level; between whole numbers a blend. Shares run geometrically: half way between all and
    /// a quarter is a half.
    pub fn blend(&self, level: f32) -> LodBlend {
        if self.levels.is_empty() {
            return LodBlend::default();
        }
        let level = level.clamp(0.0, self.last());
        let from = level.floor() as usize;
        let to = (from + 1).min(self.last() as usize);
        let t = level - from as f32;
        let (a, b) = (self.levels[from], self.levels[to]);
        let share = |a: f32, b: f32| {
            let (a, b) = (a.clamp(1e-3, 1.0), b.clamp(1e-3, 1.0));
            a * (b / a).powf(t)
        };
        LodBlend {
            strands: share(a.strands, b.strands),
            vertices: share(a.vertices, b.vertices),
            thickness: a.thickness + t * (b.thickness - a.thickness),
            levels: [from as u8, to as u8],
            between: t,
        }
    }

    /// What is drawn where the hair has this height in the picture, as a share of the picture's.
    pub fn drawn(&self, screen_size: f32) -> LodBlend {
        match self.choice {
            LodChoice::Finest => LodBlend::default(),
            LodChoice::Automatic => self.blend(self.level_at(screen_size)),
            LodChoice::Level(level) => self.blend(level),
        }
    }

    /// The level whose cost is nearest to a target, and that cost. `cost` is asked for some levels; it should not
    /// rise with the level.
    pub fn solve(&self, target: f32, mut cost: impl FnMut(f32) -> f32) -> (f32, f32) {
        let (mut fine, mut coarse) = (0.0, self.last());
        let mut best = (fine, cost(fine));
        if best.1 <= target {
            return best;
        }
        for _ in 0..N_HALVINGS {
            let level = f32::midpoint(fine, coarse);
            let found = cost(level);
            if (found - target).abs() < (best.1 - target).abs() {
                best = (level, found);
            }
            if found > target { fine = level } else { coarse = level }
        }
        best
    }
}

/// Halvings of the range of levels until a target is met: to a hundredth of a level.
const N_HALVINGS: usize = 8;

impl LodBlend {
    /// Vertices of a strand that has `n` at the finest level.
    pub fn n_vertices(&self, n: u32) -> u32 {
        ((n as f32 * self.vertices).round() as u32).clamp(4.min(n), n)
    }

    /// Indices into a binding's maps: density and thickness of both levels.
    pub fn maps(&self, binding: &LayerBinding) -> [Option<usize>; 4] {
        let [from, to] = self.levels;
        [MapKind::LodDensity(from), MapKind::LodDensity(to), MapKind::LodThickness(from), MapKind::LodThickness(to)]
            .map(|kind| binding.map_idx(&kind))
    }

    /// What painted maps say of a strand: the share of its neighbours that is left, and how many times wider it is.
    pub fn painted(&self, binding: &LayerBinding, maps: [Option<usize>; 4], strand_idx: usize) -> (f32, f32) {
        let at = |map| binding.map_value(strand_idx, map, 1.0);
        let mix = |a: f32, b: f32| a * (1.0 - self.between) + b * self.between;
        let kept = mix(at(maps[0]), at(maps[1]));
        let thickness = mix(at(maps[2]), at(maps[3]));
        (kept, thickness * (1.0 / kept.max(1e-3)).min(MOST_WIDER))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_what_it_says_and_between_two_everything_runs_through() {
        let settings = LodSettings::default();
        for (i, level) in settings.levels.iter().enumerate() {
            let blend = settings.blend(i as f32);
            assert!((blend.strands - level.strands).abs() < 1e-6 && (blend.vertices - level.vertices).abs() < 1e-6);
        }
        let mut before = settings.blend(0.0);
        for step in 1..=300 {
            let now = settings.blend(0.01 * step as f32);
            assert!(now.strands <= before.strands && now.strands / before.strands > 0.98, "{step}");
            before = now;
        }
        assert_eq!(LodSettings { levels: Vec::new(), ..settings }.blend(2.0), LodBlend::default());
    }

    #[test]
    fn smaller_in_the_picture_is_coarser_and_each_level_begins_where_it_is_set() {
        let settings = LodSettings::default();
        for (i, level) in settings.levels.iter().enumerate() {
            assert!((settings.level_at(level.screen_size) - i as f32).abs() < 1e-3, "{i}");
        }
        let sizes = (0..200).map(|i| 1.5 * 0.97_f32.powi(i));
        let levels: Vec<f32> = sizes.map(|size| settings.level_at(size)).collect();
        assert!(levels.is_sorted() && levels[0] == 0.0 && levels[199] == 3.0);
        assert!(levels.windows(2).all(|pair| pair[1] - pair[0] < 0.1));
    }

    #[test]
    fn a_target_is_met() {
        let settings = LodSettings::default();
        let strands = |level: f32| 100_000.0 * settings.blend(level).strands;
        for target in [80_000.0, 50_000.0, 12_345.0, 7000.0] {
            let (level, found) = settings.solve(target, strands);
            assert!((found / target - 1.0).abs() < 0.02, "{target}: {found} at {level}");
        }
        // What cannot be met ends at an end.
        assert_eq!(settings.solve(1e9, strands).0, 0.0);
        assert!((settings.solve(1.0, strands).0 - settings.last()).abs() < 0.02);
    }
}
