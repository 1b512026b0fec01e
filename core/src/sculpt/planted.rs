//! Guides that the add brush plants on bare scalp, in layers that are made of guides or of strands as they came.
//!
//! Where such a layer has hair, more of it is a matter of density ([`super::planting`]); where it has none there is
//! nothing to be dense. There the brush puts guides at places of a sequence over the whole scalp, which is the same
//! for every stroke, so a place is planted once however often it is brushed. A planted guide is shaped as its
//! neighbours are, turned as the scalp turns from them to it, or stands up where there are none. It joins the
//! layer's own guides under an id from [`PLANTED`] on, by which binding tells it from those that were there: these
//! keep their strands, and a planted guide brings its own.

use glam::{Quat, Vec3};

use super::K;
use super::brushes::{Dab, mirrored};
use crate::binding::{scalp_places, spaced_grid};
use crate::curve::{catmull_rom, even_parameters};
use crate::groom::{Head, Layer, Source};
use crate::hash::{combine, random};
use crate::point_grid::PointGrid;
use crate::strands::{Strands, polyline_length};

/// Ids of planted guides begin here: `PLANTED + place`.
pub const PLANTED: u32 = 0x4000_0000;
/// Of the sequence of places.
const SEED: u32 = 0x9A17;
/// Most places on a scalp.
const MOST_PLACES: f32 = 20_000.0;
/// Places for each guide that would stand there at the layer's own spacing: what the rest is for is to fit between.
const PLACES_A_GUIDE: f32 = 1.6;
/// A place nearer to a guide than this share of the guides' spacing is taken.
const TAKEN: f32 = 0.75;
/// Neighbours farther away have no say in a planted guide's shape, in spacings and in centimetres.
const NEIGHBOURHOOD: (f32, f32) = (4.0, 1.0);
/// Where there is no neighbour at all: centimetres.
const FIRST_LENGTH: f32 = 8.0;
/// Spacing of the guides of a layer that has none yet, centimetres.
const FIRST_SPACING: f32 = 1.0;

/// Where guides may be planted.
#[derive(Debug, Clone, Default)]
pub struct PlantPlaces {
    /// On the scalp, with the way out of it; head space, centimetres.
    places: Vec<(Vec3, Vec3)>,
    spacing: f32,
}

impl PlantPlaces {
    /// `None` for a hair mesh, which says itself where hair grows, and where there is no head.
    pub fn of_layer(layer: &Layer, head: Option<&Head>) -> Option<Self> {
        let strands = strands_of(&layer.source)?;
        let roots = roots_of(strands, |id| id < PLANTED);
        let spacing = if roots.len() < 2 { FIRST_SPACING } else { spaced_grid(&roots).1 };
        let n_places = |area: f32| (PLACES_A_GUIDE * area / (spacing * spacing)).min(MOST_PLACES) as usize;
        let places = scalp_places(head?, n_places, SEED);
        Some(Self { places, spacing })
    }

    /// The places that a dab plants, as far as they are not in `chosen` yet.
    pub(super) fn choose(&self, dab: &Dab<'_>, chosen: &mut Vec<u32>) {
        for (place_idx, &(p, normal)) in self.places.iter().enumerate() {
            let (seen, outwards) = if dab.is_mirrored { (mirrored(p), mirrored(normal)) } else { (p, normal) };
            let weight = dab.weight(seen, outwards);
            // A strong brush plants every place, a weak one some of them.
            if weight > random(combine(SEED, place_idx as u32), 0) && !chosen.contains(&(place_idx as u32)) {
                chosen.push(place_idx as u32);
            }
        }
    }

    /// A source with guides at chosen places, or `None` where all of them were taken.
    pub(super) fn planted(&self, source: &Source, chosen: &[u32]) -> Option<Source> {
        let before = strands_of(source)?;
        let mut strands = before.clone();
        if strands.ids.is_empty() {
            strands.ids = (0..before.n_strands() as u32).collect();
        }
        let known = roots_of(before, |_| true);
        let shapes = Shapes::new(before, &known, self.spacing);
        let n_points = shapes.n_points();
        let mut roots = known.clone();
        let mut in_order = chosen.to_vec();
        in_order.sort_unstable();
        for place_idx in in_order {
            let (p, normal) = self.places[place_idx as usize];
            let is_taken = |q: &Vec3| q.distance_squared(p) < (TAKEN * self.spacing).powi(2);
            let id = PLANTED + place_idx;
            if roots.iter().any(is_taken) || strands.ids.contains(&id) {
                continue;
            }
            roots.push(p);
            strands.ids.push(id);
            strands.push(&shapes.at(p, normal, n_points));
            if let Some(last) = strands.root_uvs.last().copied() {
                strands.root_uvs.push(last);
            }
            // Widths, colours and opacities go on as those of the strand before.
            fn extend<T: Copy>(values: &mut Vec<T>, n_points: usize) {
                if let Some(last) = values.last().copied() {
                    values.extend(std::iter::repeat_n(last, n_points));
                }
            }
            extend(&mut strands.radii_um, n_points);
            extend(&mut strands.colours, n_points);
            extend(&mut strands.opacities, n_points);
        }
        let strands = (strands.n_strands() > before.n_strands()).then(|| std::sync::Arc::new(strands))?;
        Some(match source {
            Source::Strands(_) => Source::Strands(strands),
            Source::Guides(_) | Source::HairMesh(_) => Source::Guides(strands),
        })
    }
}

fn strands_of(source: &Source) -> Option<&Strands> {
    match source {
        Source::Guides(strands) | Source::Strands(strands) => Some(strands),
        Source::HairMesh(_) => None,
    }
}

fn roots_of(strands: &Strands, is_one: impl Fn(u32) -> bool) -> Vec<Vec3> {
    let of = (0..strands.n_strands()).filter(|&s| strands.strand(s).len() >= 2 && is_one(strands.id(s)));
    of.map(|s| strands.strand(s)[0]).collect()
}

/// What hair looks like around a place.
struct Shapes<'a> {
    strands: &'a Strands,
    /// Strands that have a shape, and their roots.
    usable: Vec<usize>,
    roots: PointGrid<'a>,
    spacing: f32,
    length: f32,
}

impl<'a> Shapes<'a> {
    /// `roots`: of all strands that have a shape.
    fn new(strands: &'a Strands, roots: &'a [Vec3], spacing: f32) -> Self {
        let usable: Vec<usize> = (0..strands.n_strands()).filter(|&s| strands.strand(s).len() >= 2).collect();
        let lengths: f32 = usable.iter().map(|&s| polyline_length(strands.strand(s))).sum();
        let length = if usable.is_empty() { FIRST_LENGTH } else { lengths / usable.len() as f32 };
        Self { strands, usable, roots: PointGrid::new(roots, spacing.max(0.05)), spacing, length }
    }

    /// As many as all the others have, where they have one number of them, so that none need be resampled.
    fn n_points(&self) -> usize {
        let first = self.usable.first().map_or(K, |&s| self.strands.strand(s).len());
        if self.strands.iter().all(|points| points.len() == first) { first } else { K }
    }

    fn at(&self, p: Vec3, normal: Vec3, n_points: usize) -> Vec<Vec3> {
        let reach = (NEIGHBOURHOOD.0 * self.spacing).max(NEIGHBOURHOOD.1);
        let (nearest, n_found) = self.roots.nearest::<3>(p);
        let near: Vec<_> = nearest[..n_found].iter().filter(|(_, squared)| *squared < reach * reach).collect();
        let last = (n_points - 1) as f32;
        if near.is_empty() {
            return (0..n_points).map(|k| p + self.length * (k as f32 / last) * normal).collect();
        }
        let mut points = vec![Vec3::ZERO; n_points];
        let mut total = 0.0;
        for &&(near_idx, squared) in &near {
            let neighbour = self.strands.strand(self.usable[near_idx]);
            let turn = Self::turn_to(neighbour[0], p, normal);
            let weight = 1.0 / (squared + 1e-4);
            total += weight;
            for (out, u) in points.iter_mut().zip(even_parameters(neighbour, n_points)) {
                *out += weight * (turn * (catmull_rom(neighbour, u) - neighbour[0]));
            }
        }
        points.iter().map(|offset| p + *offset / total).collect()
    }

    /// From a neighbour's root to a place: the way out of the scalp there is taken from a sphere through both.
    fn turn_to(root: Vec3, p: Vec3, normal: Vec3) -> Quat {
        let chord = p - root;
        // On a sphere the normals at the two ends are mirror images in the plane halfway between them.
        let there = match chord.try_normalize() {
            Some(along) => normal - 2.0 * normal.dot(along) * along,
            None => normal,
        };
        Quat::from_rotation_arc(there, normal)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::binding::bind_layer;
    use crate::brush::{Brush, Falloff};
    use crate::edit::Edit;
    use crate::groom::Groom;
    use crate::sculpt::tests::ball;
    use crate::sculpt::view::View;
    use crate::sculpt::{SculptBrush, Stroke, StrokePoint, StrokeView};

    /// Guides that stand on one side of the ball's upper half and lean over.
    fn one_sided() -> Strands {
        let mut strands = Strands::default();
        for i in 0..160 {
            let t = (i as f32 + 0.5) / 160.0;
            let (height, turn) = (1.0 - t, i as f32 * 2.399_963);
            let ring = (1.0 - height * height).sqrt();
            let out = Vec3::new(ring * turn.cos(), height, ring * turn.sin());
            if out.x < -0.1 {
                let points: Vec<Vec3> =
                    (0..8).map(|k| 8.0 * out + 0.6 * k as f32 * out - 0.03 * (k * k) as f32 * Vec3::X).collect();
                strands.push(&points);
            }
        }
        strands
    }

    /// From above over the bare side.
    fn stroke(view: &StrokeView) -> Stroke {
        let at = |p: Vec3| View::new(view).project(p).unwrap();
        let (a, b) = (at(Vec3::new(1.5, 7.8, 0.0)), at(Vec3::new(4.0, 6.9, 0.0)));
        let brush = Brush { radius_cm: 2.0, strength: 1.0, falloff: Falloff::Constant, ..Brush::default() };
        let points = vec![StrokePoint::new(a.x, a.y), StrokePoint::new(b.x, b.y)];
        Stroke { kind: SculptBrush::Add, brush, view: *view, points, ..Stroke::default() }
    }

    fn from_above() -> StrokeView {
        let camera = crate::camera::Camera {
            target: Vec3::Y * 4.0,
            azimuth_deg: 0.0,
            elevation_deg: 80.0,
            distance: 60.0,
            ..crate::camera::Camera::default()
        };
        StrokeView { camera, size: [800.0, 600.0], ..StrokeView::default() }
    }

    #[test]
    fn the_add_brush_plants_guides_on_bare_scalp_and_undo_digs_them_up() {
        for is_strands in [false, true] {
            let strands = Arc::new(one_sided());
            let source = if is_strands { Source::Strands(strands) } else { Source::Guides(strands) };
            let layer = Layer { n_strands: 900, ..Layer::new("hair", source) };
            let mut groom = Groom { head: Some(ball()), layers: vec![layer], ..Groom::default() };
            let first = groom.clone();
            let before = bind_layer(&groom.layers[0], groom.head.as_ref());
            let edit = Edit::Stroke { layer_idx: 0, sculpt_idx: 0, stroke: Box::new(stroke(&from_above())) };
            let undo = groom.apply(edit.clone()).unwrap();
            let planted = groom.clone();
            let strands = strands_of(&planted.layers[0].source).unwrap();
            let is_new = |s: &usize| strands.id(*s) >= PLANTED;
            let new: Vec<usize> = (0..strands.n_strands()).filter(is_new).collect();
            assert!(new.len() > 5, "{} planted", new.len());
            let field = crate::distance_field::DistanceField::from_mesh(&ball().mesh, 64).unwrap();
            let spacing = spaced_grid(&roots_of(&one_sided(), |_| true)).1;
            for &s in &new {
                let points = strands.strand(s);
                assert!(field.sample(points[0]).abs() < 0.1, "roots stand on the scalp");
                assert!(points[1..].iter().all(|&p| field.sample(p) > 0.0));
                // As long as the hair around it, or as the layer's hair is.
                assert!((polyline_length(points) / polyline_length(one_sided().strand(0)) - 1.0).abs() < 0.3);
                let nearest = (0..strands.n_strands()).filter(|&other| other != s);
                let nearest = nearest.map(|other| strands.strand(other)[0].distance(points[0])).fold(9.0, f32::min);
                assert!(nearest > TAKEN * spacing - 1e-3);
            }
            // Strands that were there stay, and new ones grow over the bare side.
            let after = bind_layer(&groom.layers[0], groom.head.as_ref());
            let place_of = |id: u32| after.ids.iter().position(|&known| known == id).map(|s| after.roots[s]);
            for (s, &id) in before.ids.iter().enumerate() {
                assert_eq!(place_of(id), Some(before.roots[s]), "strand {id}");
            }
            let n_more = after.n_strands() - before.n_strands();
            assert!(n_more >= new.len() * if is_strands { 1 } else { 4 }, "{n_more} strands of {} guides", new.len());
            assert!(after.roots.iter().any(|p| p.x > 3.0), "on the bare side");
            // The same stroke again finds its places taken; undo gives the first groom.
            let redo = groom.apply(undo).unwrap();
            assert!(groom == first);
            groom.apply(redo).unwrap();
            assert!(groom == planted);
            groom.apply(edit).unwrap();
            assert_eq!(strands_of(&groom.layers[0].source).unwrap().n_strands(), strands.n_strands());
        }
    }
}
