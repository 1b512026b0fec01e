//! What each brush does, one test a brush: its effect, and the opposite where it has one.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::tests::{FRONT, SCENE, after, changed, made, stroke, view};
use super::{SculptBrush, mirrored};
use crate::binding::bind_layer;
use crate::brush::Brush;
use crate::generate::{Pose, generate};
use crate::groom::Layer;
use crate::look::Choice;
use crate::sculpt::planting::DENSEST;
use crate::sculpt::solve::segment_lengths;
use crate::sculpt::tests::{ball, fallen_hair};
use crate::sculpt::view::View;
use crate::sculpt::{K, SculptBase, SculptGuide, SculptMask, Stroke};
use crate::style::{StyleKind, StyleOp};

type Curve = [Vec3; K];

/// Before and after a stroke: the curves of the guides that it changed.
fn curves(stroke: &Stroke) -> Vec<(Curve, Curve)> {
    let touched = made(&SCENE.layer, stroke);
    let (before, after) = (SCENE.base.shown(&SCENE.layer), SCENE.base.shown(&touched));
    changed(&SCENE.layer, &touched).into_iter().map(|g| (before[g], after[g])).collect()
}

/// The third of them that moved farthest: at the brush's rim little is to be seen.
fn strongest(stroke: &Stroke) -> Vec<(Curve, Curve)> {
    let mut all = curves(stroke);
    let moved = |(a, b): &(Curve, Curve)| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    all.sort_by(|a, b| moved(b).total_cmp(&moved(a)));
    all.truncate((all.len() / 3).max(4));
    all
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, n) = values.fold((0.0, 0), |(sum, n), value| (sum + value, n + 1));
    sum / n.max(1) as f32
}

fn inverted(stroke: Stroke) -> Stroke {
    Stroke { is_inverted: true, ..stroke }
}

/// How much a curve turns from root to tip, radians.
fn turning(curve: &Curve) -> f32 {
    (1..K - 1).map(|k| (curve[k] - curve[k - 1]).angle_between(curve[k + 1] - curve[k])).sum()
}

/// The same in the plane of the picture, to the left above 0.
fn turning_in_picture(curve: &Curve) -> f32 {
    let view = View::new(&view());
    let at = |k: usize| view.project(curve[k]).unwrap();
    (1..K - 1).map(|k| (at(k) - at(k - 1)).angle_to(at(k + 1) - at(k))).sum()
}

#[test]
fn every_brush_keeps_lengths_unless_that_is_its_job_and_roots_unless_it_slides_them() {
    for &kind in SculptBrush::ALL {
        for (before, after) in [stroke(kind, FRONT, Vec2::new(60.0, -20.0))].iter().flat_map(curves_of_any) {
            if kind != SculptBrush::Length {
                for (a, b) in segment_lengths(&after).iter().zip(segment_lengths(&before)) {
                    // Hair that lies at the scalp is spread above it, which no brush does.
                    assert!((a / b - 1.0).abs() < 0.03, "{kind:?}: {a} of {b}");
                }
            }
            if kind != SculptBrush::Slide {
                assert_eq!(after[0], before[0], "{kind:?} moves a root");
            }
        }
    }
}

/// As [`curves`], of a stroke that may touch nothing.
fn curves_of_any(stroke: &Stroke) -> Vec<(Curve, Curve)> {
    let changes = stroke.changes(Arc::clone(&SCENE.base), &SCENE.layer, 0);
    let touched = after(&SCENE.layer, &changes);
    let (before, after) = (SCENE.base.shown(&SCENE.layer), SCENE.base.shown(&touched));
    changes.iter().map(|change| (before[change.guide as usize], after[change.guide as usize])).collect()
}

#[test]
fn smooth_takes_bends_out_and_keeps_lengths_and_roots() {
    let mut jagged = SCENE.layer.clone();
    let strokes = Arc::make_mut(&mut jagged.sculpt.layers[0].strokes);
    for g in 0..SCENE.base.guides.n_guides() {
        let offset = |k: usize| [if k % 2 == 1 { 0.35 } else { -0.35 }, 0.0, 0.0].map(|x| if k == 0 { 0.0 } else { x });
        strokes.ids.push(g as u32);
        strokes.guides.push(SculptGuide { offsets: std::array::from_fn(offset), ..SculptGuide::default() });
    }
    let smoothed = made(&jagged, &stroke(SculptBrush::Smooth, FRONT, Vec2::new(80.0, 0.0)));
    let (before, after) = (SCENE.base.shown(&jagged), SCENE.base.shown(&smoothed));
    let mut ids = changed(&jagged, &smoothed);
    assert!(ids.len() > 40, "{}", ids.len());
    for &g in &ids {
        assert_eq!(after[g][0], before[g][0]);
        for (a, b) in segment_lengths(&after[g]).iter().zip(segment_lengths(&SCENE.base.guides.paths[g])) {
            assert!((a / b - 1.0).abs() < 0.03, "guide {g}: {a} of {b}");
        }
    }
    // At the brush's rim little is to be seen.
    let straighter = |g: &usize| turning(&before[*g]) - turning(&after[*g]);
    ids.sort_by(|a, b| straighter(b).total_cmp(&straighter(a)));
    ids.truncate(ids.len() / 3);
    let (first, last) = (mean(ids.iter().map(|&g| turning(&before[g]))), mean(ids.iter().map(|&g| turning(&after[g]))));
    eprintln!("smooth: hair turns by {first:.2} rad before, {last:.2} rad after");
    assert!(last < 0.6 * first, "{last} of {first}");
}

#[test]
fn comb_takes_hair_the_way_of_the_pointer() {
    let view = View::new(&view());
    let by = Vec2::new(80.0, -20.0);
    let along = |(before, after): &(Curve, Curve)| {
        let at = |p: Vec3| view.project(p).unwrap();
        (0..K).map(|k| (at(after[k]) - at(before[k])).dot(by.normalize())).fold(0.0, f32::max)
    };
    let moved = mean(strongest(&stroke(SculptBrush::Comb, FRONT, by)).iter().map(along));
    assert!(moved > 25.0, "hair moves by {moved} of 82 points along the stroke");
}

#[test]
fn puff_lifts_and_presses() {
    let field = SCENE.base.field.as_ref().unwrap();
    let height = |curve: &Curve| mean(curve.iter().map(|&p| field.sample(p)));
    let rise = |stroke: &Stroke| mean(curves(stroke).iter().map(|(a, b)| height(b) - height(a)));
    let puff = stroke(SculptBrush::Puff, FRONT, Vec2::new(50.0, 0.0));
    assert!(rise(&puff) > 0.05 && rise(&inverted(puff.clone())) < -0.02);
}

#[test]
fn pinch_gathers_in_the_picture_and_clump_in_its_lock() {
    let spread = |curves: &[Curve]| {
        let middle = |k: usize| curves.iter().map(|c| c[k]).sum::<Vec3>() / curves.len() as f32;
        (1..K).map(|k| mean(curves.iter().map(|c| c[k].distance(middle(k))))).sum::<f32>()
    };
    for kind in [SculptBrush::Pinch, SculptBrush::Clump] {
        let by_how_much = |stroke: &Stroke| {
            let (before, after): (Vec<_>, Vec<_>) = strongest(stroke).into_iter().unzip();
            spread(&after) / spread(&before)
        };
        let gather = stroke(kind, FRONT, Vec2::new(30.0, 0.0));
        let (together, apart) = (by_how_much(&gather), by_how_much(&inverted(gather.clone())));
        assert!(together < 0.98 && apart > together + 0.02, "{kind:?}: {together} and {apart}");
    }
}

#[test]
fn twist_turns_the_lock_one_way_and_the_other() {
    let twist = stroke(SculptBrush::Twist, FRONT, Vec2::new(12.0, 0.0));
    let (one, other) = (strongest(&twist), curves(&inverted(twist.clone())));
    let by = |(before, after): &(Curve, Curve)| -> Curve { std::array::from_fn(|k| after[k] - before[k]) };
    let dot = |a: Curve, b: Curve| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f32>();
    let pairs: Vec<_> = one.iter().filter_map(|a| Some((a, other.iter().find(|b| a.0 == b.0)?))).collect();
    let against = pairs.iter().filter(|(a, b)| dot(by(a), by(b)) < 0.0).count();
    assert!(pairs.len() > 3 && against > pairs.len() * 2 / 3, "{against} of {}", pairs.len());
    let far = mean(one.iter().map(|pair| by(pair).iter().map(|by| by.length()).fold(0.0, f32::max)));
    assert!(far > 0.1, "{far} cm");
}

#[test]
fn curl_rolls_hair_up_to_either_side() {
    let turned = |stroke: &Stroke| {
        mean(curves(stroke).iter().map(|(before, after)| turning_in_picture(after) - turning_in_picture(before)))
    };
    let curl = stroke(SculptBrush::Curl, FRONT, Vec2::new(30.0, 0.0));
    let (one, other) = (turned(&curl), turned(&inverted(curl.clone())));
    assert!(one * other < 0.0 && one.abs() > 0.15 && other.abs() > 0.15, "{one} and {other} rad");
}

#[test]
fn part_lays_hair_to_the_side_where_it_grows() {
    // Down the middle of the front, over hair whose roots stand to both sides of the stroke.
    let from = Vec3::new(0.0, 8.0, 5.0);
    let part = stroke(SculptBrush::Part, from, Vec2::new(0.0, 90.0));
    let view = View::new(&view());
    let line = view.project(from).unwrap().x;
    let aside = |curves: &[(Curve, Curve)], is_right: bool| {
        let at = |p: Vec3| view.project(p).unwrap().x;
        let of_side = curves.iter().filter(|(before, _)| (at(before[0]) > line) == is_right);
        mean(of_side.map(|(before, after)| at(after[K / 2]) - at(before[K / 2])))
    };
    let curves = strongest(&part);
    let (left, right) = (aside(&curves, false), aside(&curves, true));
    assert!(left < -2.0 && right > 2.0, "{left} and {right} points");
}

#[test]
fn length_grows_and_shrinks_the_whole_hair() {
    let share = |stroke: &Stroke| {
        mean(curves(stroke).iter().map(|(before, after)| {
            segment_lengths(after).iter().sum::<f32>() / segment_lengths(before).iter().sum::<f32>()
        }))
    };
    let grow = stroke(SculptBrush::Length, FRONT, Vec2::new(50.0, 0.0));
    assert!(share(&grow) > 1.05 && share(&inverted(grow.clone())) < 0.97);
}

#[test]
fn cut_takes_off_what_lies_beyond_the_pointer_and_lets_it_come_back() {
    let cut = stroke(SculptBrush::Cut, FRONT, Vec2::new(50.0, 0.0));
    let touched = made(&SCENE.layer, &cut);
    let view = View::new(&view());
    let from = Vec2::from_array(cut.points[0].at);
    let shown = SCENE.base.shown(&SCENE.layer);
    let strokes = &touched.sculpt.layers[0].strokes;
    for (&g, guide) in strokes.ids.iter().zip(&strokes.guides) {
        assert_eq!(guide.offsets, [[0.0; 3]; K], "scissors bend nothing");
        let u = guide.cut * (K - 1) as f32;
        let k = (u as usize).min(K - 2);
        let end = shown[g as usize][k].lerp(shown[g as usize][k + 1], u - k as f32);
        let x = view.project(end).unwrap().x;
        let radius = cut.brush.radius_cm / view.cm_per_point(end);
        assert!((from.x - radius..from.x + 50.0 + radius).contains(&x), "a cut at {x}, beside the stroke");
    }
    let back = inverted(Stroke { brush: Brush { radius_cm: 6.0, strength: 1.0, ..cut.brush }, ..cut.clone() });
    let again = made(&touched, &back);
    let left = mean(again.sculpt.layers[0].strokes.guides.iter().map(|guide| guide.cut));
    assert!(left > mean(strokes.guides.iter().map(|guide| guide.cut)) + 0.1);
}

#[test]
fn delete_thins_and_add_brings_back_and_then_plants() {
    let delete = stroke(SculptBrush::Delete, FRONT, Vec2::new(50.0, 0.0));
    let bald = made(&SCENE.layer, &delete);
    let kept = |layer: &Layer| mean(layer.sculpt.layers[0].strokes.guides.iter().map(|guide| guide.keep));
    assert!(kept(&bald) < 0.7);
    let wide = Brush { radius_cm: 5.0, strength: 1.0, ..Brush::default() };
    let add = Stroke { brush: wide, ..stroke(SculptBrush::Add, FRONT, Vec2::new(150.0, 0.0)) };
    let back = made(&bald, &add);
    let guides = &back.sculpt.layers[0].strokes.guides;
    assert!(guides.iter().all(|guide| guide.keep > 0.99) && guides.iter().any(|guide| guide.keep > 1.2));
    assert!(guides.iter().all(|guide| guide.keep <= DENSEST));
    // What was only deleted comes back, and no more than that.
    let only_back = made(&bald, &inverted(Stroke { brush: wide, ..delete.clone() }));
    assert!(only_back.sculpt.layers[0].strokes.guides.iter().all(|guide| guide.keep <= 1.0));
    // The add brush turned round is the delete brush.
    assert!(kept(&made(&SCENE.layer, &inverted(add))) < 0.7);
}

#[test]
fn slide_moves_roots_along_the_scalp_with_all_their_hair() {
    let field = SCENE.base.field.as_ref().unwrap();
    let slide = stroke(SculptBrush::Slide, Vec3::new(3.0, 7.0, 2.5), Vec2::new(20.0, 0.0));
    let mut farthest: f32 = 0.0;
    for (before, after) in curves(&slide) {
        let by = after[0] - before[0];
        farthest = farthest.max(by.length());
        assert!((field.sample(after[0]) - field.sample(before[0])).abs() < 0.03, "the root leaves the scalp");
        // What comes to lie under the scalp is spread above it.
        let [a, b] = [before, after].map(|curve| segment_lengths(&curve).iter().sum::<f32>());
        assert!((a / b - 1.0).abs() < 0.15, "{a} and {b} cm");
    }
    assert!(farthest > 0.4, "{farthest} cm");
}

#[test]
fn mask_and_freeze_move_nothing_and_a_masked_layer_leaves_hair_alone() {
    let constant =
        Brush { radius_cm: 2.0, strength: 1.0, falloff: crate::brush::Falloff::Constant, ..Brush::default() };
    for kind in [SculptBrush::Mask, SculptBrush::Freeze] {
        let stroke = Stroke { brush: constant, ..stroke(kind, FRONT, Vec2::new(50.0, 0.0)) };
        assert!(curves(&stroke).iter().all(|(before, after)| before == after), "{kind:?}");
    }
    let mask = Stroke { brush: constant, ..stroke(SculptBrush::Mask, FRONT, Vec2::new(50.0, 0.0)) };
    let mut masked = made(&SCENE.layer, &mask);
    masked.sculpt.layers[0].mask = SculptMask::Painted;
    let strokes = &masked.sculpt.layers[0].strokes;
    let is_masked = |g: u32| strokes.get(g).is_some_and(|guide| guide.masked == 1.0);
    assert!(strokes.ids.iter().filter(|&&g| is_masked(g)).count() > 20);
    for &kind in SculptBrush::ALL.iter().filter(|kind| !kind.ignores_frozen()) {
        let changes = stroke(kind, FRONT, Vec2::new(60.0, 0.0)).changes(Arc::clone(&SCENE.base), &masked, 0);
        assert!(changes.iter().all(|change| !is_masked(change.guide)), "{kind:?} touches masked hair");
    }
}

#[test]
fn a_brush_touches_the_hair_as_it_is_styled() {
    let head = ball();
    let bend =
        StyleKind::Bend { heading_deg: 0.0, elevation_deg: 0.0, gravity: 0.0, variation: 0.3, strands_per_clump: 50.0 };
    let curl = StyleKind::Curl { radius: 0.8, pitch: 3.0, strands_per_clump: 40.0, loosen: 0.0 };
    for (kind, strength) in [(bend, 1.0), (curl, 1.0)] {
        let mut layer = Layer { style: vec![StyleOp { strength, ..StyleOp::new(kind) }], ..fallen_hair(6) };
        let base = Arc::new(SculptBase::prepare(&layer, Some(&head), Some(SCENE.base.field.clone())));
        layer.sculpt.roots = Arc::clone(&base.roots);
        layer.sculpt.layers = SCENE.layer.sculpt.layers.clone();
        let binding = bind_layer(&layer, Some(&head));
        let pose = Pose { field: base.field.as_deref(), ..Pose::default() };
        let before = generate(&binding, &layer, &binding.guides.positions, &pose);
        // What an artist sees in front, well away from the head.
        let depth = |p: Vec3| p.z - (p.x - 2.0).abs();
        let (s, p) = (0..before.n_strands())
            .map(|s| (s, before.strand(s)[23]))
            .max_by(|a, b| depth(a.1).total_cmp(&depth(b.1)))
            .unwrap();
        let comb = stroke(SculptBrush::Comb, p, Vec2::new(60.0, 0.0));
        let combed = after(&layer, &comb.changes(Arc::clone(&base), &layer, 0));
        let after = generate(&binding, &combed, &binding.guides.positions, &pose);
        let moved = before.strand(s)[23].distance(after.strand(s)[23]);
        assert!(moved > 0.5, "{kind:?}: the hair under the pointer moves by {moved} cm");
    }
}

#[test]
fn symmetric_strokes_leave_mirrored_offsets() {
    let mut comb = stroke(SculptBrush::Comb, FRONT, Vec2::new(60.0, -40.0));
    comb.brush.is_symmetric = true;
    let combed = made(&SCENE.layer, &comb);
    let n = SCENE.base.guides.n_guides() / 2;
    let strokes = &combed.sculpt.layers[0].strokes;
    let mut n_compared = 0;
    for g in 0..n {
        let (Some(right), Some(left)) = (strokes.get(g as u32), strokes.get((g + n) as u32)) else { continue };
        let in_head = |at: usize, offset: [f32; 3]| SCENE.base.guides.frames[at] * Vec3::from_array(offset);
        for (a, b) in right.offsets.iter().zip(&left.offsets) {
            let (a, b) = (in_head(g, *a), mirrored(in_head(g + n, *b)));
            assert!(a.distance(b) < 0.05 + 0.05 * a.length(), "guide {g}: {a} and {b}");
        }
        n_compared += 1;
    }
    assert!(n_compared > 20);
}

#[test]
fn a_fine_brush_misses_no_hair_that_it_crosses() {
    // Across the whole front, with scissors far finer than the guides' points lie apart.
    let mut cut = stroke(SculptBrush::Cut, Vec3::new(-6.0, 4.0, 9.0), Vec2::new(330.0, 0.0));
    cut.brush =
        Brush { space: crate::brush::BrushSpace::Screen, radius_points: 3.0, has_back_faces: true, ..cut.brush };
    let touched = made(&SCENE.layer, &cut);
    let (view, y) = (View::new(&view()), cut.points[0].at[1]);
    let across = cut.points[0].at[0] + 5.0..cut.points[1].at[0] - 5.0;
    let mut n_crossed = 0;
    for (g, curve) in SCENE.base.shown(&SCENE.layer).iter().enumerate() {
        let at = curve.map(|p| view.project(p).unwrap());
        let crosses = at.windows(2).any(|ends| {
            let x = ends[0].lerp(ends[1], ((y - ends[0].y) / (ends[1].y - ends[0].y)).clamp(0.0, 1.0)).x;
            (ends[0].y - y) * (ends[1].y - y) < 0.0 && across.contains(&x)
        });
        if crosses {
            n_crossed += 1;
            let cut = touched.sculpt.layers[0].strokes.get(g as u32).map_or(1.0, |guide| guide.cut);
            assert!(cut < 1.0, "guide {g} is crossed and not cut");
        }
    }
    assert!(n_crossed > 100, "{n_crossed}");
}
