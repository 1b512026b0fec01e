//! No bald patch: how much of the scalp shows through the embedded hairstyles, from all around.
//!
//! Seen from a direction without perspective, strands are counted into square cells: what covers a place
//! of the scalp is the width times length of all strands in its cell that lie in front of it. Of strands
//! that lie at random the share exp(-covered / cell) is seen through.

use glam::Vec3;
use lorelei_core::binding::bind_layer;
use lorelei_core::camera::direction_from_deg;
use lorelei_core::generate::{Pose, generate};
use lorelei_core::groom::Groom;
use lorelei_core::mesh::{SCALP_GROUP, TriMesh};
use lorelei_core::mesh_query::MeshQuery;
use lorelei_core::roots::RootSurface;

/// Side of a cell in centimetres: a few strands' spacing, smaller than anything one would call a patch.
const CELL: f32 = 0.25;
const N_CELLS: usize = 200;
/// Hair thins out towards the hairline: places nearer to it are not asked, in centimetres.
const HAIRLINE: f32 = 1.5;
/// Radius of what one would call a patch.
const PATCH: f32 = 1.0;

/// Half the strands, wider, cover as much.
const LOD: f32 = 0.5;
/// Strands below this height cover no scalp.
const LOWEST: f32 = -14.0;

/// A part of a strand: place, and the area that it covers seen from the side.
struct Piece {
    middle: Vec3,
    along: Vec3,
    width: f32,
}

fn pieces(groom: &Groom) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for layer in &groom.layers {
        let binding = bind_layer(layer, groom.head.as_ref());
        let strands = generate(&binding, layer, &binding.guides.positions, &Pose { lod: LOD, ..Pose::default() });
        for s in 0..strands.n_strands() {
            let width = 2e-4 * strands.radii_um[strands.range(s).start];
            for ends in strands.strand(s).windows(2).filter(|ends| ends[0].y > LOWEST) {
                let along = ends[1] - ends[0];
                let n = (along.length() / (0.5 * CELL)).ceil().max(1.0);
                pieces.extend((0..n as u32).map(|k| Piece {
                    middle: ends[0] + (k as f32 + 0.5) / n * along,
                    along: along / n,
                    width,
                }));
            }
        }
    }
    pieces
}

/// Places on the scalp, with normals, that should be covered.
fn scalp_places(head: &TriMesh) -> Vec<(Vec3, Vec3)> {
    let scalp = head.group(SCALP_GROUP).expect("the mannequin has a scalp");
    let on_scalp: std::collections::HashSet<u32> = scalp.triangles.iter().copied().collect();
    let around = (0..head.triangles.len() as u32).filter(|t| !on_scalp.contains(t));
    let skin = MeshQuery::of_triangles(head, around).expect("there is skin around the scalp");
    RootSurface::of_triangles(head, scalp.triangles.iter().copied())
        .sequence(4000, 0)
        .into_iter()
        .filter(|root| skin.closest_within(root.position, HAIRLINE).is_none())
        .map(|root| {
            let [a, b, c] = head.corners(root.face as usize);
            (root.position, (b - a).cross(c - a).normalize_or(Vec3::Y))
        })
        .collect()
}

/// Each place that faces the direction, and the share of it that is seen through the hair.
fn seen(pieces: &[Piece], places: &[(Vec3, Vec3)], towards_eye: Vec3) -> Vec<(Vec3, f32)> {
    let (x, y) = towards_eye.any_orthonormal_pair();
    let cell_of = |p: Vec3| {
        let [i, j] = [p.dot(x), p.dot(y)].map(|v| (v / CELL + 0.5 * N_CELLS as f32).clamp(0.0, N_CELLS as f32 - 1.0));
        i as usize + N_CELLS * j as usize
    };
    let mut in_cell: Vec<Vec<(f32, f32)>> = vec![Vec::new(); N_CELLS * N_CELLS];
    for piece in pieces {
        let covered = piece.width * piece.along.reject_from_normalized(towards_eye).length();
        in_cell[cell_of(piece.middle)].push((piece.middle.dot(towards_eye), covered));
    }
    let facing = places.iter().filter(|(_, normal)| normal.dot(towards_eye) > 0.5);
    facing
        .map(|(p, _)| {
            let depth = p.dot(towards_eye);
            let covered: f32 = in_cell[cell_of(*p)].iter().filter(|piece| piece.0 > depth).map(|piece| piece.1).sum();
            (*p, (-covered / (CELL * CELL)).exp())
        })
        .collect()
}

/// The mean of all places, and of the most visible patch. A parting is a line in its patch.
fn mean_and_worst_patch(seen: &[(Vec3, f32)]) -> (f32, f32) {
    let mean_within = |centre: Vec3, radius: f32| {
        let near = seen.iter().filter(|(p, _)| p.distance(centre) <= radius);
        let (sum, n) = near.fold((0.0, 0), |(sum, n), (_, seen)| (sum + seen, n + 1));
        sum / n as f32
    };
    let worst = seen.iter().map(|&(p, _)| mean_within(p, PATCH)).fold(0.0, f32::max);
    (mean_within(Vec3::ZERO, f32::INFINITY), worst)
}

#[test]
fn no_hairstyle_shows_its_scalp() {
    for &key in lorelei_assets::hairstyle_names() {
        let groom = lorelei_assets::hairstyle(key).expect("every name has a hairstyle");
        let head = groom.head.as_ref().expect("hairstyles come with the mannequin");
        let (pieces, places) = (pieces(&groom), scalp_places(&head.mesh));
        assert!(places.len() > 1600, "{}", places.len());
        for (view, azimuth_deg, elevation_deg) in [
            ("front", 0.0, 20.0),
            ("left", 90.0, 10.0),
            ("right", -90.0, 10.0),
            ("back", 180.0, 10.0),
            ("top", 180.0, 80.0),
        ] {
            let (mean, worst) =
                mean_and_worst_patch(&seen(&pieces, &places, direction_from_deg(azimuth_deg, elevation_deg)));
            println!(
                "{key} from {view}: {:.1} % of the scalp is seen, {:.0} % of the worst patch",
                100.0 * mean,
                100.0 * worst
            );
            // Measured on 2026-11-22: at most 3.5 % from the front, where a parting or the hairline is most of what is
            // seen, and 37 % of a patch on a parting, 33 % on the crop's whorl and 20 % elsewhere.
            assert!(mean < 0.05, "{key} from {view}: {mean}");
            assert!(worst < 0.45, "{key} from {view}: {worst}");
        }
        // The measure itself: a shaved square of two centimetres is a patch.
        let shaved = |p: Vec3| (p.y - 6.0).abs() < 1.0 && (p.z + 3.0).abs() < 1.0 && p.x < 0.0;
        let shaved: Vec<Piece> = pieces.into_iter().filter(|piece| !shaved(piece.middle)).collect();
        let (_, worst) = mean_and_worst_patch(&seen(&shaved, &places, Vec3::NEG_X));
        assert!(worst > 0.9, "{key}: a shaved patch is {worst}");
    }
}
