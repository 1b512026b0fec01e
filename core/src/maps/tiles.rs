//! A map's texels: squares of 64 x 64, each behind an `Arc`, so that a stroke copies what it touches and
//! undo keeps what it touched.
//!
//! One flat image was rejected: every step of a stroke would copy a megabyte, and undo would keep it.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::pack;

/// Texels along a tile's side.
pub const TILE_SIDE: u32 = 64;
const N_TILE: usize = (TILE_SIDE * TILE_SIDE) as usize;

/// 64 x 64 texels, row by row.
#[derive(Clone, PartialEq, Eq)]
pub struct Tile(pub [u8; N_TILE]);

impl Tile {
    pub const N_BYTES: usize = N_TILE;

    pub fn filled(texel: u8) -> Self {
        Self([texel; N_TILE])
    }
}

impl fmt::Debug for Tile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (lo, hi) = self.0.iter().fold((255, 0), |(lo, hi), &texel| (lo.min(texel), hi.max(texel)));
        write!(f, "Tile({lo}..={hi})")
    }
}

/// A tile of a map by its index, row by row from v = 1, and its new texels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileChange {
    pub tile_idx: u32,
    pub tile: Arc<Tile>,
}

/// Why texels make no map, or do not fit one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    #[error("a map of {width} x {height} texels: sides are 1 to {}", ScalpMap::MOST_SIDE)]
    Size { width: u32, height: u32 },
    #[error("{found} texels are no map of {width} x {height}")]
    Texels { width: u32, height: u32, found: usize },
    #[error("there is no tile {tile_idx}: the map has {n_tiles}")]
    NoSuchTile { tile_idx: u32, n_tiles: u32 },
}

/// A painted map over the scalp's texture coordinates; v up, row 0 at v = 1.
///
/// Texels of border tiles beyond the map are 0. A map without tiles stands for one whose texels are
/// elsewhere: in a document they lie beside the manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "pack::PackedMap", try_from = "pack::PackedMap")]
pub struct ScalpMap {
    width: u32,
    height: u32,
    tiles: Vec<Arc<Tile>>,
}

impl ScalpMap {
    /// Side of a new map: 0.3 mm a texel on a head's scalp.
    pub const DEFAULT_SIDE: u32 = 1024;
    pub const MOST_SIDE: u32 = 16_384;

    /// The same texel everywhere.
    ///
    /// # Panics
    /// Where a side is 0 or above [`ScalpMap::MOST_SIDE`].
    pub fn filled(width: u32, height: u32, texel: u8) -> Self {
        Self::from_fn(width, height, |_, _| texel).expect("sides within the limits")
    }

    /// From texels row by row, the first row at v = 1.
    pub fn from_texels(width: u32, height: u32, texels: &[u8]) -> Result<Self, MapError> {
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(MapError::Texels { width, height, found: texels.len() });
        }
        Self::from_fn(width, height, |x, y| texels[(y * width + x) as usize])
    }

    /// Each texel from its column and row. Tiles of one value share their memory.
    pub fn from_fn(width: u32, height: u32, texel: impl Fn(u32, u32) -> u8) -> Result<Self, MapError> {
        if width == 0 || height == 0 || width.max(height) > Self::MOST_SIDE {
            return Err(MapError::Size { width, height });
        }
        let mut even: [Option<Arc<Tile>>; 256] = [const { None }; 256];
        let mut map = Self { width, height, tiles: Vec::new() };
        map.tiles = (0..map.n_tiles())
            .map(|tile_idx| {
                let mut tile = Tile::filled(0);
                let [x0, y0, w, h] = map.tile_rect(tile_idx);
                for y in 0..h {
                    for x in 0..w {
                        tile.0[(y * TILE_SIDE + x) as usize] = texel(x0 + x, y0 + y);
                    }
                }
                let first = tile.0[0];
                if tile.0.iter().all(|&other| other == first) {
                    Arc::clone(even[first as usize].get_or_insert_with(|| Arc::new(tile)))
                } else {
                    Arc::new(tile)
                }
            })
            .collect();
        Ok(map)
    }

    /// A map of this size whose texels are elsewhere.
    pub fn without_texels(width: u32, height: u32) -> Self {
        Self { width, height, tiles: Vec::new() }
    }

    pub fn has_texels(&self) -> bool {
        !self.tiles.is_empty()
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    pub fn height(&self) -> u32 {
        self.height
    }

    pub fn tiles_across(&self) -> u32 {
        self.width.div_ceil(TILE_SIDE)
    }

    pub fn n_tiles(&self) -> u32 {
        self.tiles_across() * self.height.div_ceil(TILE_SIDE)
    }

    pub fn tiles(&self) -> &[Arc<Tile>] {
        &self.tiles
    }

    /// A tile's first column and row, and how many columns and rows of it lie on the map.
    pub fn tile_rect(&self, tile_idx: u32) -> [u32; 4] {
        let (x, y) = (tile_idx % self.tiles_across() * TILE_SIDE, tile_idx / self.tiles_across() * TILE_SIDE);
        [x, y, TILE_SIDE.min(self.width.saturating_sub(x)), TILE_SIDE.min(self.height.saturating_sub(y))]
    }

    /// A texel by column and row; row 0 at v = 1. Beyond the border: the border's.
    pub fn texel(&self, x: u32, y: u32) -> u8 {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        let tile = &self.tiles[(y / TILE_SIDE * self.tiles_across() + x / TILE_SIDE) as usize];
        tile.0[(y % TILE_SIDE * TILE_SIDE + x % TILE_SIDE) as usize]
    }

    /// All texels row by row, the first row at v = 1.
    pub fn texels(&self) -> Vec<u8> {
        let mut texels = vec![0; self.width as usize * self.height as usize];
        for (tile_idx, tile) in self.tiles.iter().enumerate() {
            let [x0, y0, w, h] = self.tile_rect(tile_idx as u32);
            for y in 0..h {
                let from = (y * TILE_SIDE) as usize;
                let to = (y0 + y) as usize * self.width as usize + x0 as usize;
                texels[to..to + w as usize].copy_from_slice(&tile.0[from..from + w as usize]);
            }
        }
        texels
    }

    /// Bilinear sample at texture coordinates, 0-1; clamped at the edges. 0-1: [`super::MapKind::max_value`] scales it.
    pub fn sample(&self, [u, v]: [f32; 2]) -> f32 {
        let x = (u.clamp(0.0, 1.0) * self.width as f32 - 0.5).max(0.0);
        let y = ((1.0 - v.clamp(0.0, 1.0)) * self.height as f32 - 0.5).max(0.0);
        let texel = |x: u32, y: u32| f32::from(self.texel(x, y)) / 255.0;
        let (x0, y0) = (x as u32, y as u32);
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let top = texel(x0, y0) * (1.0 - fx) + texel(x0 + 1, y0) * fx;
        let bottom = texel(x0, y0 + 1) * (1.0 - fx) + texel(x0 + 1, y0 + 1) * fx;
        top * (1.0 - fy) + bottom * fy
    }

    /// Put tiles in, one after the other; returns those that were there, so that putting these in is the way
    /// back. On an error nothing has changed.
    pub fn replace_tiles(&mut self, changes: Vec<TileChange>) -> Result<Vec<TileChange>, MapError> {
        let n_tiles = self.tiles.len() as u32;
        if let Some(beyond) = changes.iter().find(|change| change.tile_idx >= n_tiles) {
            return Err(MapError::NoSuchTile { tile_idx: beyond.tile_idx, n_tiles });
        }
        let mut before: Vec<TileChange> = changes
            .into_iter()
            .map(|TileChange { tile_idx, mut tile }| {
                self.clear_beyond(tile_idx, &mut tile);
                let tile = std::mem::replace(&mut self.tiles[tile_idx as usize], tile);
                TileChange { tile_idx, tile }
            })
            .collect();
        before.reverse();
        Ok(before)
    }

    /// Texels of a border tile that lie beyond the map become 0, so that equal maps are equal in memory.
    fn clear_beyond(&self, tile_idx: u32, tile: &mut Arc<Tile>) {
        let [_, _, w, h] = self.tile_rect(tile_idx);
        let is_beyond = |at: usize| at as u32 % TILE_SIDE >= w || at as u32 / TILE_SIDE >= h;
        if (w, h) != (TILE_SIDE, TILE_SIDE) && (0..N_TILE).any(|at| is_beyond(at) && tile.0[at] != 0) {
            let texels = &mut Arc::make_mut(tile).0;
            (0..N_TILE).filter(|&at| is_beyond(at)).for_each(|at| texels[at] = 0);
        }
    }

    /// The tiles of `self` that `other`, a map of the same size, holds otherwise. Cheap: tiles that share their
    /// memory are equal.
    pub fn changed_from(&self, other: &Self) -> Vec<TileChange> {
        let both = self.tiles.iter().zip(&other.tiles).enumerate();
        both.filter(|(_, (new, old))| !Arc::ptr_eq(new, old) && new != old)
            .map(|(tile_idx, (new, _))| TileChange { tile_idx: tile_idx as u32, tile: Arc::clone(new) })
            .collect()
    }

    /// Call `visit` with the address and the bytes of every tile.
    pub fn visit_shared(&self, visit: &mut dyn FnMut(usize, usize)) {
        for tile in &self.tiles {
            visit(Arc::as_ptr(tile) as usize, Tile::N_BYTES);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn ramp(width: u32, height: u32) -> ScalpMap {
        ScalpMap::from_fn(width, height, |x, y| (7 * x + 13 * y) as u8).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn texels_come_back_whatever_the_size(width in 1..200_u32, height in 1..200_u32) {
            let map = ramp(width, height);
            prop_assert_eq!(&ScalpMap::from_texels(width, height, &map.texels()).unwrap(), &map);
            let text = ron::to_string(&map).unwrap();
            prop_assert_eq!(ron::from_str::<ScalpMap>(&text).unwrap(), map);
        }

        #[test]
        fn putting_back_what_was_replaced_is_exact(
            width in 1..200_u32, height in 1..200_u32,
            changes in prop::collection::vec((any::<u32>(), any::<u8>()), 0..9),
        ) {
            let first = ramp(width, height);
            let mut map = first.clone();
            let changes = changes.into_iter().map(|(at, texel)| TileChange {
                tile_idx: at % first.n_tiles(),
                tile: Arc::new(Tile::filled(texel)),
            });
            let before = map.replace_tiles(changes.collect()).unwrap();
            prop_assert_eq!(&ScalpMap::from_texels(width, height, &map.texels()).unwrap(), &map, "equal is equal in memory");
            map.replace_tiles(before).unwrap();
            prop_assert_eq!(map, first);
        }
    }

    #[test]
    fn a_sample_lies_between_its_texels() {
        let map = ScalpMap::from_texels(2, 2, &[0, 255, 51, 102]).unwrap();
        // Texel middles are at a quarter and three quarters; v runs up.
        assert_eq!(map.sample([0.25, 0.75]), 0.0);
        assert_eq!(map.sample([0.75, 0.75]), 1.0);
        assert!((map.sample([0.5, 0.25]) - 0.3).abs() < 1e-6);
        assert!((map.sample([-3.0, 9.0])).abs() < 1e-6);
    }

    #[test]
    fn a_change_shares_all_other_tiles() {
        let first = ramp(256, 256);
        let mut map = first.clone();
        map.replace_tiles(vec![TileChange { tile_idx: 5, tile: Arc::new(Tile::filled(9)) }]).unwrap();
        let changed = map.changed_from(&first);
        assert_eq!(changed.iter().map(|change| change.tile_idx).collect::<Vec<_>>(), [5]);
        let mut seen = std::collections::HashSet::new();
        for map in [&first, &map] {
            map.visit_shared(&mut |address, _| {
                seen.insert(address);
            });
        }
        assert_eq!(seen.len(), 17);
        assert_eq!(
            map.replace_tiles(vec![TileChange { tile_idx: 16, tile: Arc::new(Tile::filled(9)) }]),
            Err(MapError::NoSuchTile { tile_idx: 16, n_tiles: 16 })
        );
    }

    #[test]
    fn an_even_map_is_one_tile_of_memory() {
        let map = ScalpMap::filled(1024, 1024, 128);
        assert!(map.tiles().iter().all(|tile| Arc::ptr_eq(tile, &map.tiles()[0])));
    }

    #[test]
    fn sizes_that_are_no_map_are_refused() {
        assert!(ScalpMap::from_texels(2, 2, &[0; 3]).is_err());
        assert!(ScalpMap::from_fn(0, 4, |_, _| 0).is_err());
        assert!(ScalpMap::from_fn(1, ScalpMap::MOST_SIDE + 1, |_, _| 0).is_err());
        for bad in
            ["(width:2,height:2,png:\"AAAA\")", "(width:0,height:0,png:\"!\")", "(width:9999999,height:1,png:\"AA==\")"]
        {
            assert!(ron::from_str::<ScalpMap>(bad).is_err(), "{bad}");
        }
    }
}
