//! Laws of every brush, on a ball with hair that falls to all sides.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec3};

use super::SculptBrush;
use crate::brush::{Brush, BrushSpace};
use crate::camera::Camera;
use crate::distance_field::DistanceField;
use crate::edit::Edit;
use crate::groom::{Groom, Layer};
use crate::history::{History, Merge};
use crate::look::Choice;
use crate::record::Record;
use crate::sculpt::solve::segment_lengths;
use crate::sculpt::tests::{ball, fallen_hair};
use crate::sculpt::view::View;
use crate::sculpt::{
    K, LiveStroke, SculptBase, SculptChange, SculptLayer, SculptRoots, Stroke, StrokePoint, StrokeView,
};

pub(super) struct Scene {
    pub layer: Layer,
    pub base: Arc<SculptBase>,
}

/// Guides on one side of X = 0 first, then their mirror images.
pub(super) static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let head = ball();
    let mut layer = fallen_hair(6);
    let right = SculptRoots::of_layer(&layer, Some(&head)).positions.into_iter().filter(|p| p.x > 0.3);
    let right: Vec<Vec3> = right.take(600).collect();
    let left = right.iter().map(|p| Vec3::new(-p.x, p.y, p.z));
    let positions = right.iter().copied().chain(left).collect();
    layer.sculpt.roots = Arc::new(SculptRoots { positions, uvs: Vec::new() });
    layer.sculpt.layers.push(SculptLayer::new("first"));
    let field = DistanceField::from_mesh(&head.mesh, 64).unwrap();
    let roots = Arc::clone(&layer.sculpt.roots);
    let base = SculptBase::new(&layer, Some(&head), roots, Some(Arc::new(field)));
    Scene { layer, base: Arc::new(base) }
});

pub(super) fn view() -> StrokeView {
    let camera =
        Camera { target: Vec3::Y * 4.0, azimuth_deg: 0.0, elevation_deg: 10.0, distance: 60.0, ..Camera::default() };
    StrokeView { camera, size: [800.0, 600.0], ..StrokeView::default() }
}

/// From in front of the hair at a place to the side by so many points of the window.
pub(super) fn stroke(kind: SculptBrush, from: Vec3, by: Vec2) -> Stroke {
    let brush = Brush { radius_cm: 2.5, strength: 0.8, ..Brush::default() };
    let at = View::new(&view()).project(from).unwrap();
    let points = vec![StrokePoint::new(at.x, at.y), StrokePoint::new(at.x + by.x, at.y + by.y)];
    Stroke { kind, brush, view: view(), points, ..Stroke::default() }
}

pub(super) const FRONT: Vec3 = Vec3::new(3.0, 5.0, 9.0);

pub(super) fn after(layer: &Layer, changes: &[SculptChange]) -> Layer {
    let mut layer = layer.clone();
    Arc::make_mut(&mut layer.sculpt.layers[0].strokes).apply(changes);
    layer
}

pub(super) fn made(layer: &Layer, stroke: &Stroke) -> Layer {
    let changes = stroke.changes(Arc::clone(&SCENE.base), layer, 0);
    assert!(!changes.is_empty(), "{:?} touches nothing", stroke.kind);
    after(layer, &changes)
}

pub(super) fn changed(before: &Layer, after: &Layer) -> Vec<usize> {
    let guide = |layer: &Layer, g: usize| layer.sculpt.layers[0].strokes.get(g as u32).copied().unwrap_or_default();
    (0..SCENE.base.guides.n_guides()).filter(|&g| guide(before, g) != guide(after, g)).collect()
}

#[test]
fn comb_keeps_length() {
    let combed = made(&SCENE.layer, &stroke(SculptBrush::Comb, FRONT, Vec2::new(90.0, -30.0)));
    let (before, after) = (SCENE.base.shown(&SCENE.layer), SCENE.base.shown(&combed));
    let mut farthest: f32 = 0.0;
    for g in changed(&SCENE.layer, &combed) {
        let lengths = segment_lengths(&SCENE.base.guides.paths[g]);
        for (a, b) in segment_lengths(&after[g]).iter().zip(&lengths) {
            assert!((a / b - 1.0).abs() < 0.02, "guide {g}: {a} of {b}");
        }
        assert_eq!(after[g][0], before[g][0], "a comb pulls no root");
        farthest = farthest.max(after[g][K - 1].distance(before[g][K - 1]));
    }
    assert!(farthest > 1.5, "the comb moved nothing farther than {farthest} cm");
}

#[test]
fn no_brush_enters_the_scalp() {
    let field = SCENE.base.field.as_ref().unwrap();
    let unbrushed = SCENE.base.shown(&SCENE.layer);
    for &kind in SculptBrush::ALL {
        for is_inverted in [false, true] {
            // Across the ball and back, so that combs press hair into it.
            let mut stroke = Stroke { is_inverted, ..stroke(kind, FRONT, Vec2::new(-200.0, 40.0)) };
            stroke.points.push(stroke.points[0]);
            stroke.brush = Brush { strength: 1.0, radius_cm: 4.0, ..stroke.brush };
            let changes = stroke.changes(Arc::clone(&SCENE.base), &SCENE.layer, 0);
            let touched = after(&SCENE.layer, &changes);
            let shown = SCENE.base.shown(&touched);
            for change in &changes {
                let g = change.guide as usize;
                for (p, before) in shown[g].iter().zip(&unbrushed[g]).skip(1) {
                    let distance = field.sample(*p);
                    let is_no_deeper = distance >= field.sample(*before) - 1e-3;
                    assert!(p.is_finite() && (distance > -5e-3 || is_no_deeper), "{kind:?}: {distance} cm");
                }
            }
        }
    }
}

#[test]
fn frozen_hair_stays() {
    let frozen = made(
        &SCENE.layer,
        &Stroke {
            brush: Brush {
                strength: 1.0,
                radius_cm: 2.0,
                falloff: crate::brush::Falloff::Constant,
                ..Brush::default()
            },
            ..stroke(SculptBrush::Freeze, FRONT, Vec2::new(60.0, 0.0))
        },
    );
    let strokes = &frozen.sculpt.layers[0].strokes;
    let is_frozen = |g: usize| strokes.get(g as u32).is_some_and(|guide| guide.frozen == 1.0);
    let n_frozen = (0..SCENE.base.guides.n_guides()).filter(|&g| is_frozen(g)).count();
    assert!(n_frozen > 20, "{n_frozen}");
    for &kind in SculptBrush::ALL {
        if kind.ignores_frozen() {
            continue;
        }
        let changes = stroke(kind, FRONT, Vec2::new(90.0, 0.0)).changes(Arc::clone(&SCENE.base), &frozen, 0);
        assert!(changes.iter().all(|change| !is_frozen(change.guide as usize)), "{kind:?} moves frozen hair");
    }
    // Thawed, it can be combed again.
    let thaw = Stroke { is_inverted: true, ..stroke(SculptBrush::Freeze, FRONT, Vec2::new(60.0, 0.0)) };
    let thawed = made(&frozen, &Stroke { brush: Brush { strength: 1.0, radius_cm: 4.0, ..thaw.brush }, ..thaw });
    let n_left = thawed.sculpt.layers[0].strokes.guides.iter().filter(|guide| guide.frozen == 1.0).count();
    assert!(n_left < n_frozen / 4, "{n_left} of {n_frozen}");
}

#[test]
fn symmetry_mirrors() {
    for &kind in SculptBrush::ALL {
        let mut stroke = stroke(kind, FRONT, Vec2::new(60.0, -40.0));
        // Roots are to be slid too: brush them where they stand.
        if kind == SculptBrush::Slide {
            stroke = self::stroke(kind, Vec3::new(3.0, 7.0, 2.5), Vec2::new(20.0, 0.0));
        }
        // There is nothing to bring back.
        stroke.is_inverted = kind == SculptBrush::Add;
        stroke.brush.is_symmetric = true;
        let mirrored = made(&SCENE.layer, &stroke);
        let (before, shown) = (SCENE.base.shown(&SCENE.layer), SCENE.base.shown(&mirrored));
        let n = shown.len() / 2;
        let (mut worst, mut farthest, mut n_changed): (f32, f32, usize) = (0.0, 0.0, 0);
        let strokes = &mirrored.sculpt.layers[0].strokes;
        for g in 0..n {
            let (right, left) = (strokes.get(g as u32), strokes.get((g + n) as u32));
            n_changed += usize::from(right.is_some());
            for (a, b) in shown[g].iter().zip(&shown[g + n]) {
                worst = worst.max(a.distance(Vec3::new(-b.x, b.y, b.z)));
            }
            farthest = farthest.max(shown[g][K - 1].distance(before[g][K - 1]));
            let numbers = |g: Option<&crate::sculpt::SculptGuide>| {
                g.map_or([1.0, 1.0, 1.0, 0.0, 0.0], |g| [g.length, g.cut, g.keep, g.frozen, g.masked])
            };
            for (a, b) in numbers(right).iter().zip(numbers(left)) {
                assert!((a - b).abs() < 0.02, "{kind:?}: {a} and {b}");
            }
        }
        assert!(n_changed > 5, "{kind:?}");
        // The distance field's nodes do not lie mirrored.
        assert!(worst < 0.05 + 0.05 * farthest, "{kind:?}: the sides differ by {worst} cm, moved {farthest} cm");
        stroke.brush.is_symmetric = false;
        let one_side = made(&SCENE.layer, &stroke);
        assert!(changed(&SCENE.layer, &one_side).iter().filter(|&&g| g >= n).count() < n_changed / 2, "{kind:?}");
    }
}

#[test]
fn a_stroke_does_not_depend_on_the_number_of_pointer_events() {
    for kind in [SculptBrush::Comb, SculptBrush::Puff, SculptBrush::Length, SculptBrush::Delete] {
        let few = stroke(kind, FRONT, Vec2::new(90.0, -30.0));
        let (a, b) = (Vec2::from_array(few.points[0].at), Vec2::from_array(few.points[1].at));
        let between = |i: usize| {
            let at = a.lerp(b, i as f32 / 64.0);
            StrokePoint::new(at.x, at.y)
        };
        let many = Stroke { points: (0..=64).map(between).collect(), ..few.clone() };
        let (few, many) = (made(&SCENE.layer, &few), made(&SCENE.layer, &many));
        let (few_shown, many_shown) = (SCENE.base.shown(&few), SCENE.base.shown(&many));
        let differ =
            |g: usize| few_shown[g].iter().zip(&many_shown[g]).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let worst = (0..few_shown.len()).map(differ).fold(0.0, f32::max);
        assert!(worst < 0.01, "{kind:?}: {worst} cm");
        for (a, b) in few.sculpt.layers[0].strokes.guides.iter().zip(&many.sculpt.layers[0].strokes.guides) {
            assert!((a.length - b.length).abs() < 1e-3 && (a.keep - b.keep).abs() < 1e-3);
        }
    }
}

#[test]
fn a_screen_brush_reaches_all_depths_in_front_of_the_head_and_through_it_when_asked() {
    let mut stroke = stroke(SculptBrush::Puff, Vec3::new(0.0, 6.0, 9.0), Vec2::new(10.0, 0.0));
    stroke.brush.space = BrushSpace::Screen;
    stroke.brush.radius_points = 120.0;
    let behind = |layer: &Layer| {
        let roots = &layer.sculpt.roots.positions;
        changed(&SCENE.layer, layer).iter().filter(|&&g| roots[g].z < -3.0).count()
    };
    let front = made(&SCENE.layer, &stroke);
    stroke.brush.has_back_faces = true;
    let through = made(&SCENE.layer, &stroke);
    assert!(behind(&through) > 30 + 2 * behind(&front), "{} {}", behind(&through), behind(&front));
}

#[test]
fn a_replayed_stroke_is_the_stroke_and_its_inverse_takes_it_back() {
    let mut groom = Groom { head: Some(ball()), layers: vec![fallen_hair(6)], ..Groom::default() };
    let first = groom.clone();
    let stroke = Box::new(stroke(SculptBrush::Comb, FRONT, Vec2::new(90.0, -30.0)));
    let edit = Edit::Stroke { layer_idx: 0, sculpt_idx: 0, stroke };
    let text = ron::to_string(&edit).unwrap();
    let undo = groom.apply(ron::from_str(&text).unwrap()).unwrap();
    let sculpted = groom.clone();
    assert_eq!(sculpted.layers[0].sculpt.layers.len(), 1);
    assert!(sculpted.layers[0].sculpt.layers[0].strokes.ids.len() > 20);
    let redo = groom.apply(undo).unwrap();
    assert_eq!(groom, first);
    groom.apply(redo).unwrap();
    assert_eq!(groom, sculpted);
    let mut again = first.clone();
    again.apply(edit.clone()).unwrap();
    assert_eq!(again, sculpted);
    let Edit::Stroke { stroke, .. } = edit else { panic!("it is a stroke") };
    let beyond = Edit::Stroke { layer_idx: 0, sculpt_idx: 5, stroke };
    assert!(groom.apply(beyond).unwrap_err().to_string().contains("no sculpt layer 5"));
}

#[test]
fn a_stroke_is_written_down_as_a_stroke_and_replays_to_the_same_bits() {
    let mut groom = Groom { head: Some(ball()), layers: vec![fallen_hair(6)], ..Groom::default() };
    let first = groom.clone();
    let mut history = History::default();
    history.record();
    let mut records = Vec::new();
    for (n, kind) in [SculptBrush::Comb, SculptBrush::Smooth, SculptBrush::Add].into_iter().enumerate() {
        let made = stroke(kind, FRONT, Vec2::new(90.0, -30.0));
        // As the viewport makes it: an edit a frame.
        let base = Arc::new(SculptBase::prepare(&groom.layers[0], groom.head.as_ref(), None));
        history.hold();
        let merge = Merge::Stroke(n as u64);
        if n == 0 {
            let begin = vec![
                Edit::SetSculptRoots { layer_idx: 0, roots: Arc::clone(&base.roots) },
                Edit::AddSculpt { layer_idx: 0, sculpt_idx: 0, sculpt: Box::new(SculptLayer::new("Sculpt 1")) },
            ];
            history.apply(&mut groom, "stroke", Edit::Batch(begin), merge).unwrap();
        }
        let mut live = LiveStroke::begin(base, &groom.layers[0], 0, &made);
        for point in
            [made.points[0], StrokePoint::new(made.points[0].at[0] + 33.3, made.points[0].at[1]), made.points[1]]
        {
            let changes = live.extend(point);
            history.apply(&mut groom, "stroke", Edit::Sculpt { layer_idx: 0, sculpt_idx: 0, changes }, merge).unwrap();
            records.extend(history.take_records());
        }
        history.end_drag();
        let stroke = Box::new(live.stroke().clone());
        history.release(Some(Edit::Stroke { layer_idx: 0, sculpt_idx: 0, stroke }));
        records.extend(history.take_records());
    }
    assert_eq!((history.n_done(), records.len()), (3, 3), "a record a stroke");
    assert!(records.iter().all(|record| matches!(record.edit, Edit::Stroke { .. })));
    let text = ron::to_string(&records).unwrap();
    assert!(text.len() < 6000, "{} bytes for three strokes", text.len());
    let read: Vec<Record> = ron::from_str(&text).unwrap();
    let (mut again, mut replayed) = (first.clone(), History::default());
    for record in read {
        replayed.replay(&mut again, record).unwrap();
    }
    assert_eq!(again, groom);
    assert_eq!(ron::to_string(&again).unwrap(), ron::to_string(&groom).unwrap());
    while replayed.undo(&mut again).is_some() {}
    assert_eq!(again, first);
}
