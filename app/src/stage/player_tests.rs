//! Time on the stage: frames come back bit for bit, and what a person changes moves on from where the hair is.

use std::sync::Arc;

use lorelei_core::groom::Layer;
use lorelei_core::look::Shadowing;
use lorelei_core::maps::{MapKind, ScalpMap};
use lorelei_core::motion::{AtEnd, Motion, Movement};
use lorelei_core::pin::Pin;
use lorelei_core::simulation::Moved;
use lorelei_core::strands::Strands;

use super::hold::Hand;
use super::*;
use crate::movement::range::simulate_range;
use crate::movement::solver::On;

fn groom() -> Groom {
    let mut strands = Strands::default();
    for i in 0..12 {
        let x = i as f32 - 6.0;
        let points: Vec<Vec3> = (0..10).map(|k| Vec3::new(x, -1.5 * k as f32, 6.0)).collect();
        strands.push(&points);
    }
    let layer = Layer { n_strands: 20, ..Layer::new("a", Source::Guides(Arc::new(strands))) };
    let movement = Movement { motion: Motion::Shake, end: 40, ..Movement::default() };
    let mut groom = Groom { layers: vec![layer], movement, ..Groom::default() };
    // Nothing is looked at here.
    groom.look.shadowing = Shadowing::Off;
    groom
}

struct Show {
    stage: Stage,
    playback: Playback,
}

impl Show {
    fn new(groom: &Groom) -> Self {
        let mut stage = Stage::new(Gpu::headless().unwrap()).unwrap();
        stage.player().set_budget(1 << 20);
        stage.set_groom(groom).unwrap();
        Self { stage, playback: Playback::default() }
    }

    fn frame(&mut self, dt_secs: f32) {
        let detail = Detail { lod: 0.0, ..Detail::FULL };
        self.stage.frame(&self.playback, dt_secs, &Camera::default(), [16, 16], detail).unwrap();
    }

    fn play(&mut self, n_frames: u32) {
        self.playback.is_playing = true;
        for _ in 0..n_frames {
            self.frame(1.0 / 60.0);
        }
        self.playback.is_playing = false;
        self.frame(0.0);
    }

    fn seek(&mut self, frame_idx: u32) -> (u32, Option<Shot>) {
        self.playback.seek(frame_idx);
        self.frame(0.0);
        while self.stage.player().wanted().is_some() {
            self.frame(0.0);
        }
        (self.at(), self.shot())
    }

    fn at(&mut self) -> u32 {
        self.stage.player().now().0
    }

    fn shot(&mut self) -> Option<Shot> {
        self.stage.player().shot().unwrap()
    }
}

#[test]
fn scrubbing_back_gives_the_identical_frame_and_so_does_simulating_elsewhere() {
    let groom = groom();
    let mut show = Show::new(&groom);
    show.frame(0.0);
    assert_eq!((show.at(), show.shot()), (0, None), "nothing moves until it plays");
    let mut seen = Vec::new();
    for _ in 0..20 {
        show.play(1);
        seen.push((show.at(), show.shot().unwrap()));
    }
    assert_eq!(seen[0].0, 0, "the first frame is shown first");
    assert_eq!(seen[19].0, 19);
    for (frame_idx, shot) in seen.iter().rev() {
        assert_eq!(show.seek(*frame_idx), (*frame_idx, Some(shot.clone())));
    }
    // Forward beyond what there is, one by one and back.
    assert_eq!(show.seek(33).0, 33);
    show.playback.n_steps += 1;
    show.frame(0.0);
    let there = (show.at(), show.shot());
    assert_eq!(there.0, 34);
    show.playback.n_steps -= 1;
    show.frame(0.0);
    assert_eq!(show.at(), 33);
    assert_eq!(show.seek(34), there);
    // The same in the background, on a device of its own.
    let subject = Subject::of(show.stage.bound(), Moved::Guides);
    let on = On::Gpu(Box::new(Gpu::headless().unwrap()));
    let course = Course::of(&groom);
    let mut ranged = simulate_range(on, &subject, &course, &groom.movement, 1 << 20, None, Watch::default()).unwrap();
    assert_eq!(ranged.frames.get(34).map(|shot| Shot::clone(shot)), there.1);
    assert!(show.stage.offer(&ranged));
    assert_eq!(show.stage.player().frames().runs(), [0..=40]);
    assert_eq!(show.seek(34), there);
    ranged.key ^= 1;
    assert!(!show.stage.offer(&ranged), "frames of something else");
}

#[test]
fn on_the_way_to_a_frame_it_is_told_how_far_that_is_and_one_can_stay_where_it_has_come_to() {
    let mut groom = groom();
    groom.movement.warm_up_secs = 0.5;
    let mut show = Show::new(&groom);
    show.playback.seek(33);
    show.frame(0.0);
    let n_warm_up = 30;
    assert_eq!((show.stage.player().wanted(), show.stage.player().n_left()), (Some(33), n_warm_up + 33 - 12));
    // A picture that took four times too long: a quarter as many frames are simulated for the next.
    show.stage.player().simulate_within(0.25);
    show.frame(0.0);
    assert_eq!(show.stage.player().n_left(), n_warm_up + 33 - 12 - 3);
    show.stage.player().simulate_within(100.0);
    while show.at() < 10 {
        show.frame(0.0);
    }
    let at = show.at();
    assert!(at < 33 && show.stage.player().n_left() == 33 - at);
    show.stage.player().stay();
    show.frame(0.0);
    assert_eq!((show.at(), show.stage.player().wanted(), show.stage.player().n_left()), (at, None, 0));
    assert_eq!(show.seek(33).0, 33);
}

#[test]
fn time_loops_stops_or_goes_on_at_the_end() {
    let mut groom = groom();
    groom.movement.end = 6;
    let mut show = Show::new(&groom);
    show.play(10);
    assert!(show.at() < 6 && show.stage.player().frames().runs() == [0..=6], "{}", show.at());
    groom.movement.at_end = AtEnd::Stop;
    show.stage.set_groom(&groom).unwrap();
    assert_eq!(show.stage.player().frames().runs(), [0..=6], "what happens at the end changes no frame");
    show.playback.is_playing = true;
    (0..7).for_each(|_| show.frame(1.0 / 60.0));
    assert!(show.at() == 6 && show.stage.player().has_ended());
    groom.movement.at_end = AtEnd::GoOn;
    show.stage.set_groom(&groom).unwrap();
    show.play(4);
    assert_eq!(show.at(), 10);
    assert_eq!(show.stage.player().frames().runs(), [0..=6], "what is behind the range is not kept");
}

#[test]
fn what_is_changed_while_it_plays_moves_on_and_is_not_kept() {
    let mut groom = groom();
    let mut show = Show::new(&groom);
    show.play(25);
    let before = show.shot().unwrap();
    // A look changes no frame; another stiffness does, and the hair goes on from where it is.
    groom.look.exposure += 1.0;
    show.stage.set_groom(&groom).unwrap();
    assert_eq!(show.stage.player().frames().runs(), [0..=24]);
    groom.simulation.bend_length += 2.0;
    show.stage.set_groom(&groom).unwrap();
    assert!(show.stage.player().frames().runs().is_empty());
    show.play(1);
    let after = show.shot().unwrap();
    let farthest = |a: &Shot, b: &Shot| {
        let pairs = a.positions.iter().flatten().zip(b.positions.iter().flatten());
        pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    };
    assert!(show.at() == 25 && show.stage.player().is_by_hand() && farthest(&before, &after) < 4.0);
    assert!(show.stage.player().frames().runs().is_empty());
    // Scrubbing back simulates it as it is now, and keeps it.
    let (at, shot) = show.seek(24);
    assert!(at == 24 && !show.stage.player().is_by_hand());
    assert_eq!(show.stage.player().frames().runs(), [0..=24]);
    // The head is dragged while kept frames play: the hair goes on from the frame that is seen.
    show.seek(10);
    show.playback.is_playing = true;
    show.playback.head_pose.shift.x = 1.0;
    show.frame(1.0 / 60.0);
    show.frame(1.0 / 60.0);
    let dragged = show.shot().unwrap();
    assert!(show.stage.player().is_by_hand() && show.at() == 12, "{}", show.at());
    assert!(farthest(&dragged, &shot.unwrap()) > 0.1);
    assert!(dragged.positions.iter().flatten().all(|p| p.is_finite()));
    // Other guides of the same number take over where the hair is; time goes on.
    let Source::Guides(strands) = &groom.layers[0].source else { panic!() };
    let mut longer = Strands::clone(strands);
    longer.points.iter_mut().for_each(|p| p.y *= 1.02);
    groom.layers[0].source = Source::Guides(Arc::new(longer));
    show.stage.set_groom(&groom).unwrap();
    show.frame(1.0 / 60.0);
    let grown = show.shot().unwrap();
    assert!(show.at() == 13 && farthest(&dragged, &grown) < 4.0, "{}", farthest(&dragged, &grown));
}

#[test]
fn what_is_changed_while_kept_frames_are_seen_moves_on_from_the_one_that_is_seen() {
    let mut groom = groom();
    let mut show = Show::new(&groom);
    show.play(30);
    let farthest = |a: &Shot, b: &Shot| {
        let pairs = a.positions.iter().flatten().zip(b.positions.iter().flatten());
        pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    };
    for at in [18, 9] {
        let (_, seen) = show.seek(at);
        groom.simulation.bend_length += 1.0;
        show.stage.set_groom(&groom).unwrap();
        show.play(1);
        let after = show.shot().unwrap();
        assert_eq!((show.at(), show.stage.player().is_by_hand()), (at + 1, true));
        assert!(farthest(&seen.unwrap(), &after) < 4.0 && after.positions[0].len() == 120);
        // Kept frames for the next round.
        show.seek(0);
        show.seek(20);
    }
    // Fewer points: other hair, at rest where time is.
    show.seek(10);
    let Source::Guides(strands) = &groom.layers[0].source else { panic!() };
    let mut fewer = Strands::default();
    strands.iter().take(7).for_each(|points| fewer.push(&points[..8]));
    groom.layers[0].source = Source::Guides(Arc::new(fewer));
    show.stage.set_groom(&groom).unwrap();
    show.play(1);
    let rest = show.shot().unwrap();
    assert!(rest.positions[0].iter().all(|p| p.is_finite()) && rest.positions[0].len().is_multiple_of(7));
}

#[test]
fn undo_and_redo_bring_back_the_frames_of_the_state_that_they_come_to() {
    let first = groom();
    let mut show = Show::new(&first);
    let runs = |show: &mut Show| show.stage.player().frames().runs();
    show.play(25);
    let (_, at_12) = show.seek(12);
    let mut stiffer = first.clone();
    stiffer.simulation.bend_length += 2.0;
    show.stage.set_groom(&stiffer).unwrap();
    assert!(runs(&mut show).is_empty());
    show.seek(0);
    let (_, stiffer_at_12) = show.seek(12);
    assert!(runs(&mut show) == [0..=12] && stiffer_at_12 != at_12);
    // Undo: all of the frames, and the one that is shown with them.
    show.stage.set_groom(&first).unwrap();
    assert_eq!(runs(&mut show), [0..=24]);
    show.frame(0.0);
    assert_eq!((show.at(), show.shot(), show.stage.player().is_by_hand()), (12, at_12.clone(), false));
    // Redo.
    show.stage.set_groom(&stiffer).unwrap();
    show.frame(0.0);
    assert_eq!((runs(&mut show), show.shot()), (vec![0..=12], stiffer_at_12));
    // Another movement, and back: nothing is simulated on the way to the frame.
    let mut nodding = first.clone();
    nodding.movement.motion = Motion::Nod;
    show.stage.set_groom(&nodding).unwrap();
    show.seek(12);
    show.stage.set_groom(&first).unwrap();
    show.frame(0.0);
    assert_eq!((show.at(), show.shot(), show.stage.player().wanted()), (12, at_12.clone(), None));
    // What was combed and taken back is the same hair.
    let mut longer = first.clone();
    let Source::Guides(strands) = &first.layers[0].source else { panic!() };
    let mut points = Strands::clone(strands);
    points.points.iter_mut().for_each(|p| p.y *= 1.02);
    longer.layers[0].source = Source::Guides(Arc::new(points));
    show.stage.set_groom(&longer).unwrap();
    assert!(runs(&mut show).is_empty());
    show.stage.set_groom(&first).unwrap();
    assert_eq!(runs(&mut show), [0..=24]);
    // The head that is dragged and put back, too.
    show.playback.head_pose.shift.x = 1.0;
    show.frame(0.0);
    assert!(runs(&mut show).is_empty());
    show.playback.head_pose.shift.x = 0.0;
    show.frame(0.0);
    assert_eq!((runs(&mut show), show.seek(12)), (vec![0..=24], (12, at_12)));
    // The memory is one for all: what is kept now goes before what was left.
    show.stage.player().set_budget(25 * (16 * 120 + 100));
    show.stage.set_groom(&stiffer).unwrap();
    show.seek(0);
    show.seek(24);
    show.stage.set_groom(&first).unwrap();
    assert!(runs(&mut show).is_empty());
}

#[test]
fn what_is_painted_to_be_held_and_what_is_pinned_while_it_plays_is_held_from_then_on() {
    let mut groom = lorelei_assets::hairstyle("braid").unwrap();
    groom.look.shadowing = Shadowing::Off;
    groom.movement = Movement { motion: Motion::Shake, end: 60, ..Movement::default() };
    groom.layers.iter_mut().for_each(|layer| layer.n_strands = 200);
    (groom.simulation.moved, groom.simulation.hold) = (Moved::Rope, 20.0);
    // How far from its place on the head the hair comes in twenty frames after a change in the middle.
    let farthest_after = |change: &dyn Fn(&mut Groom)| {
        let mut show = Show::new(&groom);
        show.stage.player().set_budget(1 << 28);
        show.play(1);
        let places = show.shot().unwrap();
        let on_head = |shot: &Shot| {
            let head_from_world = shot.world_from_head.inverse();
            shot.positions.iter().flatten().map(|p| head_from_world.transform_point3(*p)).collect::<Vec<_>>()
        };
        let places = on_head(&places);
        show.play(19);
        let mut changed = groom.clone();
        change(&mut changed);
        show.stage.set_groom(&changed).unwrap();
        assert_eq!(show.stage.player().frames().runs().is_empty(), changed != groom);
        let mut farthest = 0.0_f32;
        for frame in 0..30 {
            show.play(1);
            let apart =
                on_head(&show.shot().unwrap()).iter().zip(&places).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            // A moment to come back.
            farthest = if frame < 10 { 0.0 } else { farthest.max(apart) };
        }
        farthest
    };
    let free = farthest_after(&|_| ());
    let painted = farthest_after(&|groom| {
        for layer in &mut groom.layers {
            layer.maps.insert(MapKind::Hold, Arc::new(ScalpMap::filled(64, 64, 255)));
        }
    });
    let pinned = farthest_after(&|groom| {
        let (low, high) = bounds_of(groom);
        groom.simulation.pins = vec![Pin { centre: 0.5 * (low + high), radius: 40.0, ..Pin::default() }];
    });
    println!("free {free}, painted {painted}, pinned {pinned}");
    assert!(2.0 * painted < free && 2.0 * pinned < free, "free {free}, painted {painted}, pinned {pinned}");
}

#[test]
fn the_budget_ends_what_is_kept_and_the_warm_up_comes_first() {
    let mut groom = groom();
    groom.movement.warm_up_secs = 0.5;
    groom.simulation.bend_length = 0.1;
    let mut show = Show::new(&groom);
    let n_bytes = 16 * 120 + 200;
    show.stage.player().set_budget(24 * n_bytes);
    let (_, settled) = show.seek(0);
    let at_rest = &show.stage.bound().bindings().next().unwrap().guides.positions;
    let moved = settled.unwrap().positions[0].iter().zip(at_rest).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved.is_finite());
    show.play(38);
    let kept = show.stage.player().frames().runs();
    assert!(kept.len() == 1 && (25..37).contains(kept[0].end()), "{kept:?}");
    assert!(show.at() >= 37);
}

#[test]
fn every_strand_plays_and_comes_back_and_starts_again_in_another_style() {
    let mut groom = groom();
    groom.simulation.moved = Moved::Strands;
    groom.layers[0].vertices_per_strand = 12;
    let mut show = Show::new(&groom);
    show.play(15);
    let (at, shot) = (show.at(), show.shot().unwrap());
    assert_eq!((at, shot.positions[0].len()), (14, 20 * 12));
    let (_, first) = show.seek(0);
    assert_ne!(first.as_ref(), Some(&shot), "it is shaken");
    assert_eq!(show.seek(14), (14, Some(shot)));
    // Wider strands are the same strands; others are not.
    groom.layers[0].radius_um += 10.0;
    show.stage.set_groom(&groom).unwrap();
    assert_eq!(show.stage.player().frames().runs(), [0..=14]);
    groom.layers[0].style.clear();
    groom.layers[0].vertices_per_strand = 10;
    show.stage.set_groom(&groom).unwrap();
    show.play(2);
    assert_eq!(show.shot().unwrap().positions[0].len(), 20 * 10);
    // And back to guides.
    groom.simulation.moved = Moved::Guides;
    show.stage.set_groom(&groom).unwrap();
    show.play(2);
    assert_eq!(show.shot().unwrap().positions[0].len(), 12 * 10);
}

#[test]
fn a_hand_pulls_while_it_plays_and_kept_frames_stay_as_they_were_without_it() {
    let mut groom = groom();
    groom.movement.motion = Motion::None;
    groom.movement.at_end = AtEnd::GoOn;
    let mut show = Show::new(&groom);
    show.play(8);
    let (_, kept) = show.seek(7);
    assert_eq!(show.stage.player().frames().runs(), [0..=7]);
    // The camera looks at the origin: the middle strand's root, from the front.
    let looked_at =
        Camera { target: Vec3::new(0.0, -12.0, 6.0), azimuth_deg: 0.0, elevation_deg: 0.0, ..Camera::default() };
    let frame = |show: &mut Show, hand: Option<glam::Vec2>, is_playing: bool| {
        show.playback.is_playing = is_playing;
        show.playback.hand = hand.map(|at| Hand { n_grabs: 1, at, radius: 1.5, strength: 2000.0 });
        let detail = Detail { lod: 0.0, ..Detail::FULL };
        show.stage.frame(&show.playback, 1.0 / 60.0, &looked_at, [16, 16], detail).unwrap();
        show.stage.player().held()
    };
    // Taken while time stands still: nothing moves until it plays.
    show.seek(3);
    let middle = glam::Vec2::ZERO;
    let aside = glam::Vec2::new(0.2, 0.1);
    let taken = frame(&mut show, Some(middle), false).expect("hair under the pointer");
    assert!((taken.at.y + 12.0).abs() < 0.8 && taken.hand.distance(taken.at) < 1e-3, "{taken:?}");
    let before = show.shot().unwrap();
    let paused = frame(&mut show, Some(aside), false).unwrap();
    assert!(paused.hand.distance(taken.hand) > 3.0 && show.shot().unwrap() == before);
    // It plays: what is held goes to the hand, and what rests far from it stays.
    let mut held = paused;
    for _ in 0..40 {
        held = frame(&mut show, Some(aside), true).unwrap();
    }
    assert!(held.at.distance(held.hand) < 1.0 && held.at.distance(taken.at) > 2.5, "{held:?}");
    let pulled = show.shot().unwrap();
    let moved = |strand: usize| pulled.positions[0][10 * strand + 8].distance(before.positions[0][10 * strand + 8]);
    assert!(moved(0) < 0.1 && moved(11) < 0.1, "{} {}", moved(0), moved(11));
    let lengths = pulled.positions[0].chunks(10).flat_map(|strand| strand.windows(2).map(|e| e[0].distance(e[1])));
    assert!(lengths.into_iter().all(|length| (length - 1.5).abs() < 1e-4));
    assert!(show.stage.player().is_by_hand());
    assert_eq!(show.stage.player().frames().runs(), [0..=7], "none was made without the hand");
    // Let go of, it swings back; scrubbing shows the frames as they were.
    let mut free = None;
    for _ in 0..20 {
        free = frame(&mut show, None, true);
    }
    assert!(free.is_none() && show.stage.player().is_by_hand());
    assert!(show.shot().unwrap().positions[0][10 * 6 + 8].distance(pulled.positions[0][10 * 6 + 8]) > 0.5);
    assert_eq!(show.seek(7), (7, kept));
    assert!(!show.stage.player().is_by_hand());
    // Playing on from a kept frame catches up with it first.
    show.play(1);
    while show.stage.player().wanted().is_some() {
        show.frame(0.0);
    }
    assert_eq!((show.at(), show.stage.player().frames().runs()), (8, vec![0..=8]));
    // A press beside all hair holds nothing.
    show.playback.hand = Some(Hand { n_grabs: 2, at: glam::Vec2::splat(0.9), radius: 1.5, strength: 2000.0 });
    show.frame(1.0 / 60.0);
    assert!(show.stage.player().held().is_none());
}

#[test]
fn playing_on_past_kept_frames_goes_on_from_the_last_of_them_and_never_shows_earlier_ones() {
    let mut groom = groom();
    groom.movement.at_end = AtEnd::GoOn;
    let mut show = Show::new(&groom);
    show.play(4);
    assert!(show.at() < 6);
    // The range is simulated elsewhere while the solver stands near its beginning.
    let subject = Subject::of(show.stage.bound(), Moved::Guides);
    let on = On::Gpu(Box::new(Gpu::headless().unwrap()));
    let course = Course::of(&groom);
    let ranged = simulate_range(on, &subject, &course, &groom.movement, 1 << 20, None, Watch::default()).unwrap();
    assert!(show.stage.offer(&ranged));
    show.seek(38);
    show.playback.is_playing = true;
    let mut last = 38;
    for _ in 0..6 {
        show.frame(1.0 / 60.0);
        assert!(show.at() > last, "{} after {last}", show.at());
        last = show.at();
    }
    assert!(last >= 44, "{last}");
}
