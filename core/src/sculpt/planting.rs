//! Where the add brush lets more hair grow than the style has: how many times denser the layer is at a place.
//!
//! A layer's strands are a beginning of its root sequence, and density is chosen after the fact: a place of the
//! sequence is alive while `id / density` is small ([`crate::roots`]). Planting is a density above 1. So planted
//! strands are later places of the same sequence: they keep their ids and random numbers, those that were there
//! before stay, and another count, density map or hair mesh plants the same places again. Lists of planted roots
//! were rejected where a layer has a sequence: they would have to be thinned and styled beside it.

use std::sync::Arc;

use glam::Vec3;

use super::SculptRoots;
use super::near::nearest_share;
use crate::groom::Layer;
use crate::point_grid::PointGrid;

/// Most strands for each one that the style has.
pub const DENSEST: f32 = 4.0;

/// How much denser than its style a layer is around its sculpt guides.
#[derive(Debug, Clone, PartialEq)]
pub struct Planting {
    roots: Arc<SculptRoots>,
    /// Those above 1, as (guide, density), in ascending order of guides.
    denser: Vec<(u32, f32)>,
}

impl Planting {
    /// `None` where nothing was planted.
    pub fn of(layer: &Layer) -> Option<Self> {
        let sculpt = &layer.sculpt;
        let active = sculpt.layers.iter().filter(|of| of.is_active());
        let planted = active.flat_map(|of| {
            let guides = of.strokes.ids.iter().zip(&of.strokes.guides);
            guides.filter(|(_, guide)| guide.keep > 1.0).map(|(&id, _)| id)
        });
        let mut ids: Vec<u32> = planted.collect();
        ids.sort_unstable();
        ids.dedup();
        let density = |id: u32| sculpt.guide_of(&layer.maps, |_| true, id).keep.min(DENSEST);
        let denser: Vec<_> =
            ids.into_iter().map(|id| (id, density(id))).filter(|(_, density)| *density > 1.0).collect();
        (!denser.is_empty()).then(|| Self { roots: Arc::clone(&sculpt.roots), denser })
    }

    /// The largest density.
    pub fn most(&self) -> f32 {
        self.denser.iter().map(|(_, density)| *density).fold(1.0, f32::max)
    }

    /// Made ready to be asked at many places.
    pub fn field(&self) -> PlantingField<'_> {
        let mut densities = vec![1.0; self.roots.positions.len()];
        for &(id, density) in &self.denser {
            densities[id as usize] = density;
        }
        let names = (0..densities.len() as u32).collect();
        PlantingField { grid: PointGrid::new(&self.roots.positions, 0.5), densities, names }
    }
}

/// See [`Planting::field`].
pub struct PlantingField<'a> {
    grid: PointGrid<'a>,
    densities: Vec<f32>,
    names: Vec<u32>,
}

impl PlantingField<'_> {
    /// Strands for each one that the style has at a place of the scalp; 1 or more.
    pub fn at(&self, p: Vec3) -> f32 {
        let share = nearest_share(&self.grid, &self.names, p);
        let of_guide = |(&guide, &weight): (&u32, &f32)| weight * (self.densities[guide as usize] - 1.0);
        1.0 + share.guides.iter().zip(&share.weights).map(of_guide).sum::<f32>()
    }
}
