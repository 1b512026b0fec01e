//! Painting: a stroke over the scalp becomes new tiles of a map.
//!
//! A stroke is a line through space with a radius; how much of it a texel gets is the largest falloff that
//! any part of the line has there. So a stroke is the same however many pointer events it came in, and going
//! over a place twice in one stroke does not darken it; a second stroke does. Stamping dabs one on the other
//! was rejected: their number depends on the machine. Only smoothing acts in dabs, one each quarter radius.
//!
//! Distances are taken in space, not in the map: a brush is round on the head whatever its charts are, and
//! reaches across their seams.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{IVec3, Mat4, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::atlas::{AtlasTexel, Block, ScalpAtlas};
use super::tiles::{ScalpMap, Tile, TileChange};
use super::{MapKind, Maps};
use crate::brush::{Brush, Falloff};
use crate::mesh::TriMesh;

/// What a brush does to a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum PaintMode {
    /// Towards the value.
    #[default]
    Paint,
    /// More by the value.
    Add,
    /// Less by the value.
    Subtract,
    /// Towards the mean around.
    Smooth,
    /// Towards the map's default.
    Erase,
}

impl PaintMode {
    pub const ALL: [Self; 5] = [Self::Paint, Self::Add, Self::Subtract, Self::Smooth, Self::Erase];

    pub fn label(self) -> &'static str {
        match self {
            Self::Paint => "Paint",
            Self::Add => "Add",
            Self::Subtract => "Subtract",
            Self::Smooth => "Smooth",
            Self::Erase => "Erase",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::Paint => "Towards the value",
            Self::Add => "More, by the value",
            Self::Subtract => "Less, by the value",
            Self::Smooth => "Towards the mean around",
            Self::Erase => "Back to what the map is without paint",
        }
    }

    /// What the brush does with Ctrl held.
    pub fn inverted(self) -> Self {
        match self {
            Self::Paint => Self::Erase,
            Self::Erase => Self::Paint,
            Self::Add => Self::Subtract,
            Self::Subtract => Self::Add,
            Self::Smooth => Self::Smooth,
        }
    }
}

/// A stroke as data: replayed, it gives the same tiles. Places are in the head's space at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MapStroke {
    pub brush: Brush,
    pub mode: PaintMode,
    /// In the map's own measure.
    pub value: f32,
    /// What faces away from here is left out, where the brush does not paint through.
    pub eye: Option<Vec3>,
    pub points: Vec<StrokePoint>,
}

impl Default for MapStroke {
    fn default() -> Self {
        Self { brush: Brush::default(), mode: PaintMode::Paint, value: 1.0, eye: None, points: Vec::new() }
    }
}

/// One pointer event of a stroke.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StrokePoint {
    pub position: Vec3,
    /// A pen's, 0-1.
    #[serde(default = "full_pressure")]
    pub pressure: f32,
}

fn full_pressure() -> f32 {
    1.0
}

impl MapStroke {
    /// The tiles that the stroke changes in a layer's map.
    pub fn replay(&self, mesh: &TriMesh, maps: &Maps, kind: &MapKind) -> Vec<TileChange> {
        let map = maps.get(kind).map_or_else(|| kind.empty_map(), |map| ScalpMap::clone(map));
        let atlas = Arc::new(ScalpAtlas::new(mesh, map.width(), map.height()));
        let mut stroke = Stroke::new(atlas, map.clone(), kind, self.brush.falloff, self.mode, self.value);
        for point in &self.points {
            let brush = self.brush.under_pressure(point.pressure);
            stroke.go_on(&Dab {
                place: Place::Surface { centre: point.position, radius: brush.radius_cm },
                strength: brush.strength,
                eye: self.eye.filter(|_| !brush.has_back_faces),
                is_symmetric: brush.is_symmetric,
            });
        }
        stroke.map().changed_from(&map)
    }
}

/// Where a brush is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// A ball in the head's space, centimetres.
    Surface { centre: Vec3, radius: f32 },
    /// A circle on the screen: `screen_from_head` takes a place to points of the window after the division
    /// by w.
    Screen { screen_from_head: Mat4, at: Vec2, radius: f32 },
}

/// The brush at one moment of a stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dab {
    pub place: Place,
    /// 0-1.
    pub strength: f32,
    /// What faces away from here is left out; `None`: nothing is.
    pub eye: Option<Vec3>,
    /// The same on the other side of X = 0.
    pub is_symmetric: bool,
}

/// Length between two dabs of smoothing, in radii, and how far one goes at full strength.
const SMOOTH_SPACING: f32 = 0.25;
const SMOOTH_STEP: f32 = 0.5;
/// Side of the cells whose means smoothing goes towards, in radii.
const SMOOTH_CELL: f32 = 0.35;

/// A stroke being painted.
pub struct Stroke {
    atlas: Arc<ScalpAtlas>,
    before: ScalpMap,
    map: ScalpMap,
    falloff: Falloff,
    mode: PaintMode,
    /// In texels.
    value: f32,
    default: f32,
    /// By tile: how much of the stroke each texel has got; where it is smoothed, its value in texels.
    worked: HashMap<u32, Box<[f32; Tile::N_BYTES]>>,
    last: Option<Dab>,
    /// Way since the last dab of smoothing, in radii.
    carried: f32,
}

impl Stroke {
    /// Begin a stroke on a map, whose size the atlas is of. `value` is in the map's own measure.
    pub fn new(
        atlas: Arc<ScalpAtlas>,
        map: ScalpMap,
        kind: &MapKind,
        falloff: Falloff,
        mode: PaintMode,
        value: f32,
    ) -> Self {
        debug_assert!(atlas.fits(&map), "an atlas of the map's size");
        Self {
            atlas,
            before: map.clone(),
            map,
            falloff,
            mode,
            value: (value / kind.step()).clamp(0.0, 255.0),
            default: f32::from(kind.default_texel()),
            worked: HashMap::new(),
            last: None,
            carried: 0.0,
        }
    }

    /// The map as it is now.
    pub fn map(&self) -> &ScalpMap {
        &self.map
    }

    /// The pen is lifted: the next place is not joined to the last one.
    pub fn lift(&mut self) {
        self.last = None;
    }

    /// Go on to the brush's next place. Returns the tiles that it changed.
    pub fn go_on(&mut self, dab: &Dab) -> Vec<TileChange> {
        let from = self.last.unwrap_or(*dab);
        let before = self.map.clone();
        match self.mode {
            PaintMode::Smooth => self.smooth_along(&from, dab),
            PaintMode::Paint | PaintMode::Add | PaintMode::Subtract | PaintMode::Erase => {
                self.cover(&Segment::new(&from, dab, self.falloff));
                if dab.is_symmetric {
                    self.cover(&Segment::new(&from, dab, self.falloff).mirrored());
                }
            }
        }
        self.last = Some(*dab);
        self.map.changed_from(&before)
    }

    /// Give the texels under a part of the stroke what they have not got yet.
    fn cover(&mut self, segment: &Segment) {
        let atlas = Arc::clone(&self.atlas);
        let mut open = Open::default();
        for texel in atlas.texels_in(|block| segment.meets(block)) {
            let share = segment.share(texel);
            if share <= 0.0 {
                continue;
            }
            let worked = self.worked.entry(texel.tile_idx).or_insert_with(|| Box::new([0.0; Tile::N_BYTES]));
            let covered = &mut worked[texel.at as usize];
            if share <= *covered {
                continue;
            }
            *covered = share;
            let was = f32::from(self.before.tiles()[texel.tile_idx as usize].0[texel.at as usize]);
            let is = match self.mode {
                PaintMode::Paint => was + share * (self.value - was),
                PaintMode::Erase => was + share * (self.default - was),
                PaintMode::Add => was + share * self.value,
                PaintMode::Subtract => was - share * self.value,
                PaintMode::Smooth => was,
            };
            open.set(&mut self.map, texel, is);
        }
        open.close(&mut self.map);
    }

    /// Smooth at every quarter radius of the way.
    fn smooth_along(&mut self, from: &Dab, to: &Dab) {
        let way = from.place.way_to(&to.place);
        let is_first = self.last.is_none();
        let mut at = if is_first { 0.0 } else { SMOOTH_SPACING - self.carried };
        while at <= way {
            let t = if way > 0.0 { at / way } else { 1.0 };
            let dab = from.mix(to, t);
            let segment = Segment::new(&dab, &dab, self.falloff);
            self.smooth(&segment);
            if dab.is_symmetric {
                self.smooth(&segment.mirrored());
            }
            at += SMOOTH_SPACING;
        }
        self.carried = way - (at - SMOOTH_SPACING);
    }

    /// Move the texels under the brush towards the mean around them, taken over cells in space.
    fn smooth(&mut self, segment: &Segment) {
        let atlas = Arc::clone(&self.atlas);
        let touched: Vec<(&AtlasTexel, f32)> = atlas
            .texels_in(|block| segment.meets(block))
            .map(|texel| (texel, segment.share(texel)))
            .filter(|(_, share)| *share > 0.0)
            .collect();
        let (lo, hi) = touched
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(lo, hi), (texel, _)| (lo.min(texel.position), hi.max(texel.position)));
        // In screen space the brush has no radius in centimetres: the box around what it touches has.
        let radius = match segment.from {
            Place::Surface { radius, .. } => radius,
            Place::Screen { .. } => 0.5 * (hi - lo).max_element(),
        };
        let cell = (SMOOTH_CELL * radius).max(1e-3);
        for (texel, _) in &touched {
            let tile = &self.map.tiles()[texel.tile_idx as usize];
            self.worked
                .entry(texel.tile_idx)
                .or_insert_with(|| Box::new(std::array::from_fn(|at| f32::from(tile.0[at]))));
        }
        let corners = |p: Vec3| {
            let low = (p / cell).floor();
            let f = p / cell - low;
            (0..8).map(move |corner| {
                let side = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                let w = Vec3::select(side.cmpeq(IVec3::ONE), f, 1.0 - f);
                (low.as_ivec3() + side, w.x * w.y * w.z)
            })
        };
        let mut means: HashMap<IVec3, (f32, f32)> = HashMap::new();
        for (texel, _) in &touched {
            let value = self.worked[&texel.tile_idx][texel.at as usize];
            for (at, weight) in corners(texel.position) {
                let mean = means.entry(at).or_default();
                *mean = (mean.0 + weight * value, mean.1 + weight);
            }
        }
        let mut open = Open::default();
        for (texel, share) in &touched {
            let mean: f32 = corners(texel.position)
                .filter_map(|(at, weight)| means.get(&at).map(|(sum, n)| weight * sum / n.max(1e-9)))
                .sum();
            let Some(worked) = self.worked.get_mut(&texel.tile_idx) else { continue };
            let value = &mut worked[texel.at as usize];
            *value += SMOOTH_STEP * share * (mean - *value);
            open.set(&mut self.map, texel, *value);
        }
        open.close(&mut self.map);
    }
}

/// The tile that is being written: its texels are copied once for many of them.
#[derive(Default)]
struct Open {
    tile: Option<(u32, Box<Tile>)>,
}

impl Open {
    fn set(&mut self, map: &mut ScalpMap, texel: &AtlasTexel, value: f32) {
        if self.tile.as_ref().is_none_or(|(tile_idx, _)| *tile_idx != texel.tile_idx) {
            self.close(map);
            self.tile = Some((texel.tile_idx, Box::new(Tile::clone(&map.tiles()[texel.tile_idx as usize]))));
        }
        if let Some((_, tile)) = &mut self.tile {
            tile.0[texel.at as usize] = value.round().clamp(0.0, 255.0) as u8;
        }
    }

    fn close(&mut self, map: &mut ScalpMap) {
        if let Some((tile_idx, tile)) = self.tile.take() {
            let change = TileChange { tile_idx, tile: Arc::from(tile) };
            map.replace_tiles(vec![change]).expect("a tile of the atlas is one of the map");
        }
    }
}

impl Place {
    /// The way between two places of a stroke, in radii.
    fn way_to(&self, to: &Self) -> f32 {
        match (self, to) {
            (Self::Surface { centre: a, radius }, Self::Surface { centre: b, .. }) => a.distance(*b) / radius.max(1e-6),
            (Self::Screen { at: a, radius, .. }, Self::Screen { at: b, .. }) => a.distance(*b) / radius.max(1e-6),
            (Self::Surface { .. }, Self::Screen { .. }) | (Self::Screen { .. }, Self::Surface { .. }) => 0.0,
        }
    }

    fn mix(&self, to: &Self, t: f32) -> Self {
        match (*self, *to) {
            (Self::Surface { centre, radius }, Self::Surface { centre: to, radius: to_radius }) => {
                Self::Surface { centre: centre.lerp(to, t), radius: radius + t * (to_radius - radius) }
            }
            (Self::Screen { at, radius, .. }, Self::Screen { screen_from_head, at: to, radius: to_radius }) => {
                Self::Screen { screen_from_head, at: at.lerp(to, t), radius: radius + t * (to_radius - radius) }
            }
            (_, to) => to,
        }
    }
}

impl Dab {
    fn mix(&self, to: &Self, t: f32) -> Self {
        Self { place: self.place.mix(&to.place, t), strength: self.strength + t * (to.strength - self.strength), ..*to }
    }
}

/// A straight part of a stroke.
struct Segment {
    from: Place,
    to: Place,
    strength: [f32; 2],
    eye: Option<Vec3>,
    falloff: Falloff,
    is_mirrored: bool,
}

impl Segment {
    fn new(from: &Dab, to: &Dab, falloff: Falloff) -> Self {
        Self {
            from: from.place,
            to: to.place,
            strength: [from.strength, to.strength],
            eye: to.eye,
            falloff,
            is_mirrored: false,
        }
    }

    /// The same for texels on the other side of X = 0.
    fn mirrored(mut self) -> Self {
        self.is_mirrored = !self.is_mirrored;
        self
    }

    /// A place as the brush sees it.
    fn seen(&self, v: Vec3) -> Vec3 {
        if self.is_mirrored { v * Vec3::new(-1.0, 1.0, 1.0) } else { v }
    }

    /// Whether any texel of a block may be reached.
    fn meets(&self, block: &Block) -> bool {
        let (a, b) = (self.seen(block.min), self.seen(block.max));
        let (min, max) = (a.min(b), a.max(b));
        match (self.from, self.to) {
            (Place::Surface { centre: a, radius: ra }, Place::Surface { centre: b, radius: rb }) => {
                let reach = ra.max(rb);
                let (lo, hi) = (a.min(b) - reach, a.max(b) + reach);
                max.cmpge(lo).all() && min.cmple(hi).all()
            }
            (Place::Screen { at: a, radius: ra, .. }, Place::Screen { screen_from_head, at: b, radius: rb }) => {
                let reach = ra.max(rb);
                let (lo, hi) = (a.min(b) - reach, a.max(b) + reach);
                let (mut seen_lo, mut seen_hi) = (Vec2::MAX, Vec2::MIN);
                for corner in 0..8 {
                    let side = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
                    // A box partly behind the eye may be anywhere.
                    let Some(at) = on_screen(&screen_from_head, Vec3::select(side.cmpeq(IVec3::ONE), max, min)) else {
                        return true;
                    };
                    (seen_lo, seen_hi) = (seen_lo.min(at), seen_hi.max(at));
                }
                seen_hi.cmpge(lo).all() && seen_lo.cmple(hi).all()
            }
            (Place::Surface { .. }, Place::Screen { .. }) | (Place::Screen { .. }, Place::Surface { .. }) => false,
        }
    }

    /// How much of the stroke a texel gets from this part, 0-1.
    fn share(&self, texel: &AtlasTexel) -> f32 {
        let p = self.seen(texel.position);
        if self.eye.is_some_and(|eye| self.seen(texel.normal()).dot(eye - p) <= 0.0) {
            return 0.0;
        }
        let (t, distance, radius) = match (self.from, self.to) {
            (Place::Surface { centre: a, radius: ra }, Place::Surface { centre: b, radius: rb }) => {
                let along = b - a;
                let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                (t, p.distance(a + t * along), ra + t * (rb - ra))
            }
            (Place::Screen { at: a, radius: ra, .. }, Place::Screen { screen_from_head, at: b, radius: rb }) => {
                let Some(p) = on_screen(&screen_from_head, p) else { return 0.0 };
                let along = b - a;
                let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                (t, p.distance(a + t * along), ra + t * (rb - ra))
            }
            (Place::Surface { .. }, Place::Screen { .. }) | (Place::Screen { .. }, Place::Surface { .. }) => {
                return 0.0;
            }
        };
        let strength = self.strength[0] + t * (self.strength[1] - self.strength[0]);
        strength * self.falloff.at(distance / radius.max(1e-6))
    }
}

/// A place in points of the window; `None` behind the eye.
fn on_screen(screen_from_head: &Mat4, p: Vec3) -> Option<Vec2> {
    let clip = *screen_from_head * p.extend(1.0);
    (clip.w > 1e-6).then(|| Vec2::new(clip.x, clip.y) / clip.w)
}

#[cfg(test)]
mod tests;
