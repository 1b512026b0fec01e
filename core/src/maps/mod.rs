//! Painted maps on the scalp: which there are, what their texels mean, and the tiles that hold them.
//!
//! A map is a picture over the scalp's texture coordinates. A layer holds the maps that were painted or
//! loaded for it, by [`MapKind`]; a kind that is not there is everywhere at its default. Eight bits a texel:
//! what is painted by hand is no finer, and a stroke then changes a quarter of the memory that floats would.

pub mod atlas;
mod pack;
pub mod paint;
pub mod picture;
mod tiles;
pub mod uvs;

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use tiles::{MapError, ScalpMap, TILE_SIDE, Tile, TileChange};

/// The maps of a layer. Each is behind an `Arc`, and so are its tiles: a clone shares all texels.
pub type Maps = BTreeMap<MapKind, Arc<ScalpMap>>;

/// Levels of detail that maps can be painted for: 0 is the finest.
pub const MOST_LOD_LEVELS: u8 = 8;

/// What a painted map changes.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum MapKind {
    /// Strands per area, as a share of the most.
    Density,
    /// Length as a share of the strand's own: what is above it is cut off.
    Length,
    /// Width as a multiple of the layer's.
    Width,
    /// Share of every clump operator's strength.
    Clump,
    /// Share of every wave's and curl's strength.
    Curl,
    /// Share of the material's dye: a colour is painted by where it is taken.
    Dye,
    /// Share of a strand, from the root, that is tied: it stays with the style while the rest moves.
    Tied,
    /// Share of the roots' hold to the style that a strand has along its whole length.
    Hold,
    /// A region under a name, for operators and brushes that ask for it.
    Mask(String),
    /// Share of the strands that this level of detail keeps.
    LodDensity(u8),
    /// Width at this level of detail as a multiple of what keeps the covered area.
    LodThickness(u8),
}

impl MapKind {
    /// The kinds without a name or a number, in the order of lists.
    pub const PLAIN: [Self; 8] =
        [Self::Density, Self::Length, Self::Width, Self::Clump, Self::Curl, Self::Dye, Self::Tied, Self::Hold];

    /// The value of one step of a texel. A power of two for multiples, so that 1 is exactly one texel value.
    pub fn step(&self) -> f32 {
        match self {
            Self::Width => 1.0 / 128.0,
            Self::LodThickness(_) => 1.0 / 64.0,
            Self::Density
            | Self::Length
            | Self::Clump
            | Self::Curl
            | Self::Dye
            | Self::Tied
            | Self::Hold
            | Self::Mask(_)
            | Self::LodDensity(_) => 1.0 / 255.0,
        }
    }

    /// The largest value; the smallest is 0.
    pub fn max_value(&self) -> f32 {
        255.0 * self.step()
    }

    /// The value where nothing was painted: without effect, except that a mask covers nothing and nothing is tied or held.
    pub fn default_value(&self) -> f32 {
        match self {
            Self::Mask(_) | Self::Tied | Self::Hold => 0.0,
            Self::Density
            | Self::Length
            | Self::Width
            | Self::Clump
            | Self::Curl
            | Self::Dye
            | Self::LodDensity(_)
            | Self::LodThickness(_) => 1.0,
        }
    }

    /// The texel of a value; values beyond the range are taken to its end.
    pub fn texel(&self, value: f32) -> u8 {
        (value / self.step()).round().clamp(0.0, 255.0) as u8
    }

    pub fn default_texel(&self) -> u8 {
        self.texel(self.default_value())
    }

    /// A map of this kind with its default everywhere, 1024 x 1024.
    pub fn empty_map(&self) -> ScalpMap {
        ScalpMap::filled(ScalpMap::DEFAULT_SIDE, ScalpMap::DEFAULT_SIDE, self.default_texel())
    }

    /// The value of a layer's map at texture coordinates; the default where the layer has none of this kind.
    pub fn sample(&self, maps: &Maps, uv: [f32; 2]) -> f32 {
        maps.get(self).map_or(self.default_value(), |map| map.sample(uv) * self.max_value())
    }

    /// What a person reads.
    pub fn label(&self) -> String {
        match self {
            Self::Density => "Density".to_owned(),
            Self::Length => "Length".to_owned(),
            Self::Width => "Width".to_owned(),
            Self::Clump => "Clumping".to_owned(),
            Self::Curl => "Curl".to_owned(),
            Self::Dye => "Dye".to_owned(),
            Self::Tied => "Tied".to_owned(),
            Self::Hold => "Hold".to_owned(),
            Self::Mask(name) => format!("Mask \u{201c}{name}\u{201d}"),
            Self::LodDensity(level) => format!("Density of level {level}"),
            Self::LodThickness(level) => format!("Thickness of level {level}"),
        }
    }

    pub fn help(&self) -> &'static str {
        match self {
            Self::Density => "Strands per area, as a share of the most",
            Self::Length => "Length as a share of the strand's own: what is above it is cut off",
            Self::Width => "Width as a multiple of the layer's",
            Self::Clump => "Share of every clump operator's strength",
            Self::Curl => "Share of every wave's and curl's strength",
            Self::Dye => "Share of the material's dye: strands take its colour where it is painted",
            Self::Tied => {
                "Share of a strand, from the root, that stays with the style while the rest moves: up to a band, a pin, a braid"
            }
            Self::Hold => {
                "Share of the roots' hold that a strand has along its whole length: hair that stays nearer to the style while it moves"
            }
            Self::Mask(_) => "A region under a name: operators can be limited to it",
            Self::LodDensity(_) => "Share of the strands that the level of detail keeps",
            Self::LodThickness(_) => "Width at the level of detail, as a multiple of what keeps the covered area",
        }
    }

    /// What a value is measured in.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Density => "of the most strands",
            Self::Length => "of the length",
            Self::Width | Self::LodThickness(_) => "times the width",
            Self::Clump | Self::Curl => "of the strength",
            Self::Dye => "of the dye",
            Self::Tied => "of the strand",
            Self::Hold => "of the hold",
            Self::Mask(_) => "covered",
            Self::LodDensity(_) => "of the strands",
        }
    }
}

/// The word of the command line and of files: `density`, `mask:fringe`, `lod-density:2`.
impl fmt::Display for MapKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Density => f.write_str("density"),
            Self::Length => f.write_str("length"),
            Self::Width => f.write_str("width"),
            Self::Clump => f.write_str("clump"),
            Self::Curl => f.write_str("curl"),
            Self::Dye => f.write_str("dye"),
            Self::Tied => f.write_str("tied"),
            Self::Hold => f.write_str("hold"),
            Self::Mask(name) => write!(f, "mask:{name}"),
            Self::LodDensity(level) => write!(f, "lod-density:{level}"),
            Self::LodThickness(level) => write!(f, "lod-thickness:{level}"),
        }
    }
}

/// A word that names no map.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{word}` is no map: density, length, width, clump, curl, dye, tied, hold, mask:NAME, lod-density:LEVEL or lod-thickness:LEVEL with a level of 0-7"
)]
pub struct NoSuchMap {
    word: String,
}

impl FromStr for MapKind {
    type Err = NoSuchMap;

    fn from_str(word: &str) -> Result<Self, NoSuchMap> {
        let no_such = || NoSuchMap { word: word.to_owned() };
        if let Some(plain) = Self::PLAIN.iter().find(|kind| kind.to_string() == word) {
            return Ok(plain.clone());
        }
        let (kind, rest) = word.split_once(':').ok_or_else(no_such)?;
        let level = || rest.parse().ok().filter(|&level| level < MOST_LOD_LEVELS).ok_or_else(no_such);
        match kind {
            "mask" if !rest.trim().is_empty() => Ok(Self::Mask(rest.to_owned())),
            "lod-density" => Ok(Self::LodDensity(level()?)),
            "lod-thickness" => Ok(Self::LodThickness(level()?)),
            _ => Err(no_such()),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    pub(crate) fn any_kind() -> impl Strategy<Value = MapKind> {
        prop_oneof![
            prop::sample::select(MapKind::PLAIN.to_vec()),
            "[a-c]{1,2}".prop_map(MapKind::Mask),
            (0..MOST_LOD_LEVELS).prop_map(MapKind::LodDensity),
            (0..MOST_LOD_LEVELS).prop_map(MapKind::LodThickness),
        ]
    }

    proptest! {
        #[test]
        fn a_kind_is_read_as_it_is_written(kind in any_kind()) {
            prop_assert_eq!(kind.to_string().parse::<MapKind>().unwrap(), kind);
        }

        #[test]
        fn a_default_is_one_texel_exactly(kind in any_kind()) {
            prop_assert_eq!(f32::from(kind.default_texel()) * kind.step(), kind.default_value());
            let map = Maps::from([(kind.clone(), Arc::new(kind.empty_map()))]);
            prop_assert!((kind.sample(&map, [0.3, 0.7]) - kind.default_value()).abs() < 1e-6);
        }
    }

    #[test]
    fn words_that_name_no_map_are_refused_with_those_that_do() {
        for word in ["", "colour", "mask:", "lod-density:9", "lod-thickness:x", "density:1"] {
            let error = word.parse::<MapKind>().unwrap_err().to_string();
            assert!(error.contains("density, length"), "{error}");
        }
    }
}
