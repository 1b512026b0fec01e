//! Painting: what a stroke promises.

use super::*;
use crate::mesh_query::tests::sphere;

const RADIUS: f32 = 9.0;

/// A ball whose charts are two halves side by side in the map, cut at X = 0, with a gap between them.
fn two_charts() -> TriMesh {
    let ball = sphere(Vec3::ZERO, RADIUS, 48);
    let mut mesh = TriMesh::default();
    for triangle_idx in 0..ball.triangles.len() {
        let corners = ball.corners(triangle_idx);
        let side = if corners.iter().map(|p| p.x).sum::<f32>() < 0.0 { 0.25 } else { 0.75 };
        let first = mesh.positions.len() as u32;
        for p in corners {
            // Each half seen from its own side of X.
            let away = 0.5 * (1.0 - p.x.abs() / RADIUS).max(0.0);
            let around = glam::vec2(p.z, p.y).normalize_or(Vec2::X);
            let uv = glam::vec2(side, 0.5) + 0.22 * (2.0 * away).sqrt() * around;
            mesh.positions.push(p);
            mesh.normals.push(p.normalize());
            mesh.uvs.push(uv.to_array());
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

fn dab(centre: Vec3, radius: f32, strength: f32) -> Dab {
    Dab { place: Place::Surface { centre, radius }, strength, eye: None, is_symmetric: false }
}

fn stroke_of(mesh: &TriMesh, side: u32, kind: &MapKind, mode: PaintMode, value: f32) -> Stroke {
    let map = ScalpMap::filled(side, side, kind.default_texel());
    Stroke::new(Arc::new(ScalpAtlas::new(mesh, side, side)), map, kind, Falloff::Smooth, mode, value)
}

/// What the map says at a place of the ball, read through each triangle that is there: `(least, most)`.
fn said_at(mesh: &TriMesh, map: &ScalpMap, p: Vec3) -> (f32, f32) {
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for (corners, triangle) in (0..mesh.triangles.len()).map(|t| (mesh.corners(t), mesh.triangles[t])) {
        for (corner, v) in corners.iter().zip(triangle) {
            if corner.distance(p) < 1e-4 {
                let value = map.sample(mesh.uvs[v as usize]);
                (least, most) = (least.min(value), most.max(value));
            }
        }
    }
    (least, most)
}

#[test]
fn a_seam_does_not_show() {
    let mesh = two_charts();
    let mut stroke = stroke_of(&mesh, 512, &MapKind::Mask(String::new()), PaintMode::Paint, 1.0);
    // Along the seam, and a little to one side of it.
    let on_ball = |turn: f32, x: f32| RADIUS * Vec3::new(x, turn.sin(), turn.cos()).normalize();
    for i in 0..=6 {
        stroke.go_on(&dab(on_ball(0.2 * i as f32, 0.03), 2.5, 1.0));
    }
    let mut n = 0;
    for p in mesh.positions.iter().filter(|p| p.x.abs() < 1e-4) {
        let (least, most) = said_at(&mesh, stroke.map(), *p);
        // Both charts end here; a step of one part in fifty is not seen on hair.
        assert!(most - least < 0.02, "{p}: {least} and {most}");
        n += i32::from(most > 0.5);
    }
    assert!(n > 20, "{n} places of the seam are painted");
}

#[test]
fn a_brush_is_round_in_space_whatever_the_chart() {
    let mesh = two_charts();
    let mut stroke = stroke_of(&mesh, 512, &MapKind::Mask(String::new()), PaintMode::Paint, 1.0);
    let centre = RADIUS * Vec3::new(0.9, 0.3, 0.3).normalize();
    stroke.go_on(&dab(centre, 4.0, 0.8));
    for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let expected = 0.8 * Falloff::Smooth.at(p.distance(centre) / 4.0);
        assert!((stroke.map().sample(*uv) - expected).abs() < 0.03, "{p}: {} for {expected}", stroke.map().sample(*uv));
    }
}

#[test]
fn a_stroke_is_the_same_in_two_events_and_in_fifty() {
    let mesh = two_charts();
    let (a, b) = (Vec3::new(8.0, 3.0, 3.0), Vec3::new(8.0, -3.0, 3.0));
    for mode in PaintMode::ALL {
        let painted = |n: usize| {
            let mut stroke = stroke_of(&mesh, 256, &MapKind::Length, mode, 0.3);
            // Something to smooth and to erase.
            let half = ScalpMap::from_fn(256, 256, |_, y| if y < 128 { 40 } else { 200 }).unwrap();
            (stroke.before, stroke.map) = (half.clone(), half);
            for i in 0..=n {
                stroke.go_on(&dab(a.lerp(b, i as f32 / n as f32), 3.0, 0.6));
            }
            stroke.map.texels()
        };
        let (few, many) = (painted(1), painted(50));
        let worst = few.iter().zip(&many).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(worst <= 2, "{mode:?}: {worst}");
        assert!(few.iter().any(|&texel| texel != 40 && texel != 200), "{mode:?} did something");
    }
}

#[test]
fn going_over_a_place_twice_in_a_stroke_changes_nothing() {
    let mesh = two_charts();
    let mut stroke = stroke_of(&mesh, 256, &MapKind::Density, PaintMode::Subtract, 0.5);
    let there = dab(Vec3::new(8.5, 1.0, 1.0), 2.0, 0.5);
    assert!(!stroke.go_on(&there).is_empty());
    assert!(stroke.go_on(&there).is_empty());
}

#[test]
fn every_mode_goes_where_it_says() {
    let mesh = two_charts();
    let centre = Vec3::new(RADIUS, 0.0, 0.0);
    let uv = [0.75, 0.5];
    let kind = MapKind::Width;
    let after = |mode, value, strength| {
        let mut stroke = stroke_of(&mesh, 256, &kind, mode, value);
        let half = ScalpMap::filled(256, 256, kind.texel(0.5));
        (stroke.before, stroke.map) = (half.clone(), half);
        stroke.go_on(&dab(centre, 3.0, strength));
        stroke.map.sample(uv) * kind.max_value()
    };
    for (mode, value, strength, expected) in [
        (PaintMode::Paint, 1.5, 1.0, 1.5),
        (PaintMode::Paint, 1.5, 0.5, 1.0),
        (PaintMode::Add, 0.75, 1.0, 1.25),
        (PaintMode::Subtract, 0.25, 1.0, 0.25),
        (PaintMode::Subtract, 1.9, 1.0, 0.0),
        (PaintMode::Erase, 1.9, 1.0, 1.0),
        (PaintMode::Smooth, 1.9, 1.0, 0.5),
    ] {
        assert!((after(mode, value, strength) - expected).abs() < 0.02, "{mode:?} {value} {strength}");
    }
}

#[test]
fn smoothing_takes_a_step_away_across_a_seam_and_keeps_what_is_even() {
    let mesh = two_charts();
    let kind = MapKind::Density;
    let mut stroke = stroke_of(&mesh, 512, &kind, PaintMode::Smooth, 0.0);
    // One chart is 0, the other full.
    let halves = ScalpMap::from_fn(512, 512, |x, _| if x < 256 { 0 } else { 255 }).unwrap();
    (stroke.before, stroke.map) = (halves.clone(), halves);
    for i in 0..=40 {
        let turn = 0.5 - 0.025 * i as f32;
        stroke.go_on(&dab(RADIUS * Vec3::new(0.0, turn.sin(), turn.cos()), 3.0, 1.0));
    }
    let (least, most) = said_at(&mesh, stroke.map(), Vec3::new(0.0, 0.0, RADIUS));
    assert!(most - least < 0.25, "{least} to {most} where it was 0 to 1");
    assert!(stroke.map().sample([0.75, 0.5]) > 0.999, "far from the brush");
}

#[test]
fn what_faces_away_is_left_out_unless_painted_through_and_a_mirror_does_the_other_side() {
    let mesh = two_charts();
    let paint = |eye: Option<Vec3>, is_symmetric: bool| {
        let mut stroke = stroke_of(&mesh, 256, &MapKind::Mask(String::new()), PaintMode::Paint, 1.0);
        stroke.go_on(&Dab { eye, is_symmetric, ..dab(Vec3::new(5.0, 0.0, 0.0), 20.0, 1.0) });
        [0.25, 0.75].map(|u| stroke.map().sample([u, 0.5]) > 0.0)
    };
    let eye = Some(Vec3::new(50.0, 0.0, 0.0));
    assert_eq!(paint(eye, false), [false, true]);
    assert_eq!(paint(None, false), [true, true]);
    assert_eq!(paint(eye, true), [true, true]);
}

#[test]
fn a_circle_on_the_screen_reaches_all_depths() {
    let mesh = two_charts();
    let mut stroke = stroke_of(&mesh, 256, &MapKind::Mask(String::new()), PaintMode::Paint, 1.0);
    // An orthographic view along X: z to the right, y down, ten points a centimetre.
    let screen_from_head =
        Mat4::from_cols_array(&[0.0, 0.0, 0.0, 0.0, 0.0, -10.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 100.0, 100.0, 0.0, 1.0]);
    stroke.go_on(&Dab {
        place: Place::Screen { screen_from_head, at: Vec2::new(100.0, 100.0), radius: 30.0 },
        ..dab(Vec3::ZERO, 1.0, 1.0)
    });
    for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let expected = Falloff::Smooth.at(glam::vec2(p.z, p.y).length() / 3.0);
        assert!((stroke.map().sample(*uv) - expected).abs() < 0.03, "{p}");
    }
}

#[test]
fn a_stroke_as_data_gives_the_same_tiles() {
    let mesh = two_charts();
    let points = [Vec3::new(8.0, 3.0, 3.0), Vec3::new(8.0, -3.0, 3.0)];
    let data = MapStroke {
        mode: PaintMode::Erase,
        points: points.map(|position| StrokePoint { position, pressure: 1.0 }).to_vec(),
        ..MapStroke::default()
    };
    let read: MapStroke = ron::from_str(&ron::to_string(&data).unwrap()).unwrap();
    let maps = Maps::from([(MapKind::Length, Arc::new(ScalpMap::filled(256, 256, 10)))]);
    let changes = read.replay(&mesh, &maps, &MapKind::Length);
    assert!(!changes.is_empty());
    assert_eq!(changes, data.replay(&mesh, &maps, &MapKind::Length));
}
