//! A stroke while it is made: from the pointer's way to changes of the guides.
//!
//! What does not change under a stroke is prepared once ([`SculptBase`]): the hair's paths at the guides, and the
//! head. A stroke then costs what its guides cost, whatever the number of strands.

use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::brushes::{Dab, Hair, Numbers, mirrored};
use super::planted::PlantPlaces;
use super::solve::{segment_lengths, shown, solve};
use super::stroke::{DABS_PER_RADIUS, Footstep, Stroke, StrokePoint, Walker};
use super::view::{DepthMap, View};
use super::{GuidePaths, K, SculptBrush, SculptChange, SculptGuide, SculptRoots, join_changes};
use crate::brush::BrushSpace;
use crate::distance_field::{COLLISION_RESOLUTION, DistanceField};
use crate::groom::{Head, Layer, Source};
use crate::mesh_query::MeshQuery;

/// A layer's guides and head, made ready for strokes.
#[derive(Debug, Clone, Default)]
pub struct SculptBase {
    pub roots: Arc<SculptRoots>,
    pub guides: GuidePaths,
    pub field: Option<Arc<DistanceField>>,
    pub head: Option<MeshQuery>,
    /// Where the add brush plants guides, in layers that are made of them.
    pub plant: Option<PlantPlaces>,
}

/// A sculpt layer that acts less than this on a guide cannot be brushed there: a small stroke would take a huge
/// offset.
const LEAST_SHARE: f32 = 0.05;

impl SculptBase {
    /// Prepare a layer for strokes. It keeps the sculpt guides that it has and gets further ones where it has hair and
    /// none is near; `field` is the head's distance field, where it is known already.
    pub fn prepare(layer: &Layer, head: Option<&Head>, field: Option<Option<Arc<DistanceField>>>) -> Self {
        let known = &layer.sculpt.roots;
        let roots = known.covering(layer, head).map_or_else(|| Arc::clone(known), Arc::new);
        let field = field.unwrap_or_else(|| {
            let field = DistanceField::from_mesh(&head?.mesh, COLLISION_RESOLUTION);
            field.ok().map(Arc::new)
        });
        Self::new(layer, head, roots, field)
    }

    pub fn new(layer: &Layer, head: Option<&Head>, roots: Arc<SculptRoots>, field: Option<Arc<DistanceField>>) -> Self {
        let guides = GuidePaths::shaped(layer, head, &roots);
        let plant = PlantPlaces::of_layer(layer, head);
        Self { roots, guides, field, head: head.and_then(|head| MeshQuery::new(&head.mesh).ok()), plant }
    }

    /// Why there is nothing for a brush here, in words: only the add brush can begin where no hair is.
    pub fn problem(&self, kind: SculptBrush) -> Option<&'static str> {
        let is_bare = self.roots.positions.is_empty() && (kind != SculptBrush::Add || self.plant.is_none());
        is_bare.then_some("this layer has no hair to brush")
    }

    /// The guides as they are seen under all sculpt layers of a layer, head space.
    pub fn shown(&self, layer: &Layer) -> Vec<[Vec3; K]> {
        let field = self.field.as_deref();
        (0..self.guides.n_guides())
            .into_par_iter()
            .map(|g| {
                let guide = layer.sculpt.guide_of(&layer.maps, |_| true, g as u32);
                shown(&self.guides.paths[g], &guide, &self.guides.frames[g], field)
            })
            .collect()
    }

    /// Where the hair of a layer, whose guides are `curves`, or the head is nearest under each part of the window.
    /// Hair that was cut off or deleted is not there to be touched.
    pub fn depths(&self, view: &View, layer: &Layer, curves: &[[Vec3; K]]) -> DepthMap {
        let halves = |(g, curve): (usize, &[Vec3; K])| {
            let (curve, guide) = (*curve, layer.sculpt.guide_of(&layer.maps, |_| true, g as u32));
            let shown = if guide.keep > 0.0 { guide.cut * self.guides.left[g] } else { 0.0 };
            let n = if self.guides.is_there[g] { (2.0 * shown * (K - 1) as f32) as usize + 1 } else { 0 };
            (0..n).map(move |i| 0.5 * (curve[i / 2] + curve[i.div_ceil(2)]))
        };
        DepthMap::new(view, curves.iter().enumerate().flat_map(halves))
    }

    /// The place under the pointer: hair, or the head; `None` where there is neither. A brush that moves roots looks
    /// for the head first: roots are under the hair.
    pub fn pick(&self, view: &View, depths: &DepthMap, kind: SculptBrush, at: Vec2) -> Option<Vec3> {
        let (eye, ray) = view.ray(at);
        let hair = depths.depth(at).map(|depth| view.at_depth(at, depth));
        let head = self.head.as_ref().and_then(|head| head.ray(eye, ray)).map(|hit| hit.position);
        if kind == SculptBrush::Slide && head.is_some() {
            return head;
        }
        [hair, head].into_iter().flatten().min_by(|a, b| view.depth(*a).total_cmp(&view.depth(*b)))
    }
}

/// A stroke that is being made.
#[derive(Debug)]
pub struct LiveStroke {
    base: Arc<SculptBase>,
    stroke: Stroke,
    view: View,
    walker: Option<Walker>,
    depths: DepthMap,
    /// Depth of the last place that was touched.
    depth: f32,
    /// How much of the sculpt layer acts on each guide.
    shares: Vec<Share>,
    /// The guides as they are seen.
    curves: Vec<[Vec3; K]>,
    own: Vec<SculptGuide>,
    /// What the other layers do.
    others: Vec<SculptGuide>,
    /// By any layer, 0-1.
    frozen: Vec<f32>,
    is_changed: Vec<bool>,
    /// Places that the add brush has chosen for new guides.
    to_plant: Vec<u32>,
}

impl LiveStroke {
    /// Begin a stroke on a sculpt layer; one that is not there yet is begun as a new one. The points of `stroke`
    /// are not walked yet: give them to [`LiveStroke::extend`].
    pub fn begin(base: Arc<SculptBase>, layer: &Layer, sculpt_idx: usize, stroke: &Stroke) -> Self {
        let view = View::new(&stroke.view);
        let curves = base.shown(layer);
        let depths = base.depths(&view, layer, &curves);
        let (sculpt, maps) = (&layer.sculpt, &layer.maps);
        let strokes = sculpt.layers.get(sculpt_idx).map(|of| Arc::clone(&of.strokes)).unwrap_or_default();
        let n_guides = base.guides.n_guides();
        let own: Vec<SculptGuide> = (0..n_guides).map(|g| strokes.get(g as u32).copied().unwrap_or_default()).collect();
        let share = |g: usize| match sculpt.layers.get(sculpt_idx) {
            None => Share::FULL,
            Some(of) => Share {
                // With the brush's own mask taken out: that may change under a stroke of the mask brush.
                unmasked: sculpt.share(maps, sculpt_idx, g as u32, &SculptGuide { masked: 0.0, ..own[g] }),
                masked: sculpt.share(maps, sculpt_idx, g as u32, &SculptGuide { masked: 1.0, ..own[g] }),
                is_on: of.on,
            },
        };
        let others = |g: usize| sculpt.guide_of(maps, |idx| idx != sculpt_idx, g as u32);
        let frozen = |g: usize| {
            let of_layers = sculpt.layers.iter().filter_map(|layer| layer.strokes.get(g as u32));
            of_layers.map(|guide| guide.frozen).fold(0.0, f32::max)
        };
        Self {
            view,
            walker: None,
            depth: view.depth(Vec3::ZERO),
            depths,
            shares: (0..n_guides).into_par_iter().map(share).collect(),
            others: (0..n_guides).into_par_iter().map(others).collect(),
            frozen: (0..n_guides).into_par_iter().map(frozen).collect(),
            is_changed: vec![false; n_guides],
            to_plant: Vec::new(),
            own,
            curves,
            base,
            stroke: Stroke { points: Vec::new(), ..*stroke },
        }
    }

    /// The stroke so far.
    pub fn stroke(&self) -> &Stroke {
        &self.stroke
    }

    /// The source of the layer with what the stroke has planted in it; `None` where it planted nothing. To be
    /// asked when the stroke is complete: sources are large.
    pub fn planted(&self, source: &Source) -> Option<Source> {
        let plant = self.base.plant.as_ref().filter(|_| !self.to_plant.is_empty())?;
        plant.planted(source, &self.to_plant)
    }

    /// The place under a point of the window, as the hair was when the stroke began.
    pub fn pick(&self, at: Vec2) -> Option<Vec3> {
        self.base.pick(&self.view, &self.depths, self.stroke.kind, at)
    }

    /// Go on to a point. Returns what the guides that were touched since the last call have become.
    pub fn extend(&mut self, point: StrokePoint) -> Vec<SculptChange> {
        self.stroke.points.push(point);
        let mut walker = *self.walker.get_or_insert_with(|| {
            let at = Vec2::from_array(point.at);
            let radius = match self.stroke.brush.space {
                BrushSpace::Screen => self.stroke.brush.radius_points,
                BrushSpace::Surface => {
                    let place = self.base.pick(&self.view, &self.depths, self.stroke.kind, at);
                    let place = place.unwrap_or_else(|| self.view.at_depth(at, self.depth));
                    self.stroke.brush.radius_cm / self.view.cm_per_point(place).max(1e-6)
                }
            };
            Walker::new(radius / DABS_PER_RADIUS)
        });
        let mut steps = Vec::new();
        walker.go_to(&point, |step| steps.push(step));
        self.walker = Some(walker);
        for step in &steps {
            self.dab(step);
        }
        let changed = self.is_changed.iter_mut().enumerate().filter(|(_, is_changed)| **is_changed);
        changed
            .map(|(g, is_changed)| {
                *is_changed = false;
                let guide = self.own[g];
                SculptChange { guide: g as u32, to: (!guide.is_untouched()).then(|| Box::new(guide)) }
            })
            .collect()
    }

    /// Go on to all of these points, as [`LiveStroke::extend`] does to one.
    pub fn extend_all(&mut self, points: &[StrokePoint]) -> Vec<SculptChange> {
        let mut all = Vec::new();
        for point in points {
            let mut later = self.extend(*point);
            // The later state of a guide is the one that counts.
            join_changes(&mut later, &all);
            all = later;
        }
        all
    }

    fn dab(&mut self, step: &Footstep) {
        let place = self.base.pick(&self.view, &self.depths, self.stroke.kind, step.at);
        let centre = place.unwrap_or_else(|| self.view.at_depth(step.at, self.depth));
        self.depth = self.view.depth(centre);
        let brush = self.stroke.brush.under_pressure(step.pressure);
        let radius_cm = match brush.space {
            BrushSpace::Surface => brush.radius_cm,
            BrushSpace::Screen => brush.radius_points * self.view.cm_per_point(centre),
        };
        let dab = Dab {
            view: &self.view,
            at: step.at,
            before: step.before,
            centre,
            radius_cm,
            brush,
            is_inverted: self.stroke.is_inverted,
            field: self.base.field.as_deref(),
            lock: None,
            is_mirrored: false,
        };
        let kind = self.stroke.kind;
        for is_mirrored in [false, true] {
            if is_mirrored && !brush.is_symmetric {
                break;
            }
            let dab = Dab { is_mirrored, ..dab };
            if kind == SculptBrush::Add
                && !dab.is_inverted
                && let Some(plant) = &self.base.plant
            {
                plant.choose(&dab, &mut self.to_plant);
            }
            let lock = kind.needs_lock().then(|| self.lock(&dab)).flatten();
            let dab = Dab { lock: lock.as_ref(), ..dab };
            let (base, shares, others, frozen) = (&self.base, &self.shares, &self.others, &self.frozen);
            let hairs = self.curves.par_iter_mut().zip(&mut self.own).zip(&mut self.is_changed).enumerate();
            hairs.with_min_len(128).for_each(|(g, ((curve, own), is_changed))| {
                if !base.guides.is_there[g] {
                    return;
                }
                let others = &others[g];
                let free = if kind.ignores_frozen() { 1.0 } else { 1.0 - frozen[g].max(own.frozen) };
                let before = *own;
                let guide = Guide {
                    path: &base.guides.paths[g],
                    left: base.guides.left[g],
                    frame: &base.guides.frames[g],
                    others,
                    share: shares[g],
                    free,
                };
                guide.touch(kind, &dab, curve, own);
                *is_changed |= before != *own;
            });
        }
    }

    /// The mean of the hair under a dab, weighted; `None` where there is none.
    fn lock(&self, dab: &Dab<'_>) -> Option<[Vec3; K]> {
        let weighted: Vec<(usize, f32)> = (0..self.curves.len())
            .into_par_iter()
            .with_min_len(128)
            .filter(|&g| self.base.guides.is_there[g])
            .filter_map(|g| {
                let (points, normal) = seen(&self.curves[g], self.base.guides.frames[g].z_axis, dab.is_mirrored);
                let shown = self.base.guides.left[g] * self.others[g].cut.min(self.own[g].cut);
                let weights = weights(&points, normal, shown, 1.0, dab);
                let weight = weights.into_iter().fold(0.0, f32::max);
                (weight > 0.0).then_some((g, weight))
            })
            .collect();
        let sum: f32 = weighted.iter().map(|(_, weight)| weight).sum();
        let mut lock = [Vec3::ZERO; K];
        for &(g, weight) in &weighted {
            let (points, _) = seen(&self.curves[g], Vec3::Y, dab.is_mirrored);
            lock.iter_mut().zip(points).for_each(|(mean, p)| *mean += weight / sum * p);
        }
        (sum > 0.0).then_some(lock)
    }
}

/// A guide as a dab sees it: mirrored, for the other side of a symmetric one.
fn seen(points: &[Vec3; K], normal: Vec3, is_mirrored: bool) -> ([Vec3; K], Vec3) {
    if is_mirrored { (points.map(mirrored), mirrored(normal)) } else { (*points, normal) }
}

/// How strongly a dab acts on each point that is there. A point speaks for the hair halfway to its neighbours, so
/// that a brush finer than the points misses none.
fn weights(points: &[Vec3; K], normal: Vec3, shown: f32, free: f32, dab: &Dab<'_>) -> [f32; K] {
    /// Places looked at in half a segment: two a radius of the brush, and so many at most.
    const A_RADIUS: f32 = 2.0;
    const MOST: f32 = 16.0;
    let is_there = |u: f32| u <= shown * (K - 1) as f32 + 1e-3;
    std::array::from_fn(|k| {
        if free <= 0.0 || !is_there(k as f32 - 0.5) {
            return 0.0;
        }
        let mut weight = if is_there(k as f32) { dab.weight(points[k], normal) } else { 0.0 };
        for (neighbour, side) in [(k.checked_sub(1), -0.5), (Some(k + 1).filter(|&next| next < K), 0.5)] {
            let Some(neighbour) = neighbour else { continue };
            let half = 0.5 * points[k].distance(points[neighbour]);
            let n = (A_RADIUS * half / dab.radius_cm.max(1e-3)).min(MOST) as usize;
            for i in (1..=n).map(|i| i as f32 / n as f32).filter(|i| is_there(k as f32 + side * i)) {
                weight = weight.max(dab.weight(points[k].lerp(points[neighbour], 0.5 * i), normal));
            }
        }
        free * weight
    })
}

/// How much of the sculpt layer that is brushed acts on a guide.
#[derive(Debug, Clone, Copy)]
struct Share {
    unmasked: f32,
    masked: f32,
    is_on: bool,
}

impl Share {
    /// Of a new layer.
    const FULL: Self = Self { unmasked: 1.0, masked: 1.0, is_on: true };

    fn at(&self, masked: f32) -> f32 {
        let share = self.unmasked + masked * (self.masked - self.unmasked);
        if self.is_on { share } else { 0.0 }
    }
}

/// What a stroke does not change about a guide.
struct Guide<'a> {
    path: &'a [Vec3; K],
    /// Share of the path that there is without brushes.
    left: f32,
    frame: &'a Mat3,
    /// What the other sculpt layers do.
    others: &'a SculptGuide,
    share: Share,
    /// 0 is frozen.
    free: f32,
}

impl Guide<'_> {
    /// Let a brush act on the guide, and see to its lengths, the head, and the sculpt layer's share in it.
    fn touch(&self, kind: SculptBrush, dab: &Dab<'_>, curve: &mut [Vec3; K], own: &mut SculptGuide) {
        // Hair on which the sculpt layer does not act is not touched, but for what says where it acts.
        if !kind.ignores_frozen() && self.share.at(own.masked).abs() < LEAST_SHARE {
            return;
        }
        let (mut points, normal) = seen(curve, self.frame.z_axis, dab.is_mirrored);
        let shown = self.left * self.others.cut.min(own.cut);
        let weights = weights(&points, normal, shown, self.free, dab);
        if weights.iter().all(|weight| *weight <= 0.0) {
            return;
        }
        let unmoved = points;
        let SculptGuide { length, cut, keep, frozen, masked, .. } = *own;
        let mut numbers = Numbers { length, cut, keep, frozen, masked };
        kind.act(
            &mut Hair { points: &mut points, weights, normal, shown, left: self.left, numbers: &mut numbers },
            dab,
        );
        (own.cut, own.keep, own.frozen, own.masked) = (numbers.cut, numbers.keep, numbers.frozen, numbers.masked);
        if points == unmoved && numbers.length == length {
            return;
        }
        let share = self.share.at(own.masked);
        own.length = numbers.length;
        let grown = self.others.length * (1.0 + share * (own.length - 1.0)).max(0.0);
        let lengths = segment_lengths(self.path).map(|length| grown * length);
        (*curve, _) = seen(&points, normal, dab.is_mirrored);
        solve(curve, &lengths, self.frame.z_axis, kind.follow(), dab.field);
        let root_from_head = self.frame.transpose();
        for k in 0..K {
            let offset = root_from_head * (curve[k] - self.path[k]);
            own.offsets[k] = ((offset - Vec3::from_array(self.others.offsets[k])) / share).to_array();
        }
    }
}
