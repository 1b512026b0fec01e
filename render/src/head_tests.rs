//! The head's pixels against rays through them, in f64.

use glam::{Affine3A, DVec2, DVec3, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Head};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Gpu, ShaderLibrary};

use crate::{FrameInput, Renderer};

const SIZE: [u32; 2] = [120, 90];
/// Twins of `SAMPLES_X` and `SAMPLES_Y` in head_surface.wgsl.
const SAMPLES: [(f64, f64); 4] = [(-0.125, -0.375), (0.375, -0.125), (-0.375, 0.125), (0.125, 0.375)];

/// A ball with small triangles at its poles and large ones between.
fn ball(radius: f32, n: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    for i in 0..=n {
        let polar = std::f32::consts::PI * i as f32 / n as f32;
        for j in 0..n {
            let around = std::f32::consts::TAU * j as f32 / n as f32;
            let normal = Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
            mesh.positions.push(radius * normal);
        }
    }
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b] = [i * n + j, i * n + (j + 1) % n];
        mesh.triangles.extend([[a, a + n, b], [b, a + n, b + n]]);
    }
    mesh
}

/// Depth and covered share of each pixel.
fn drawn(mesh: &TriMesh, camera: &Camera) -> Vec<[f32; 2]> {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let groom = Groom { head: Some(Head::new("mesh", mesh.clone())), ..Groom::default() };
    renderer.set_groom(&groom).unwrap();
    let input = FrameInput {
        camera,
        size: SIZE,
        world_from_head: Affine3A::IDENTITY,
        moved: &[],
        moved_stamp: 0,
        lod_scale: 1.0,
    };
    renderer.render_pixels(&input).unwrap();
    let texture = renderer.targets.head_depth.texture().clone();
    bytemuck::pod_collect_to_vec(&renderer.read_texture(&texture, 8).unwrap())
}

/// Distance along a ray to a triangle (Moeller and Trumbore 1997).
fn hit(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let from_a = origin - a;
    let u = from_a.dot(p) / determinant;
    let q = from_a.cross(ab);
    let v = direction.dot(q) / determinant;
    (determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(q) / determinant)
}

fn exact(mesh: &TriMesh, camera: &Camera) -> Vec<[f32; 2]> {
    let world_from_view = camera.view_from_world().inverse().as_dmat4();
    let near = f64::from(camera.near_far().0);
    let [width, height] = SIZE.map(f64::from);
    let pixels_per_tangent = 0.5 * height / (0.5 * f64::from(camera.fov_y_deg).to_radians()).tan();
    let corners: Vec<[DVec3; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize].as_dvec3())).collect();
    let depth_at = |place: DVec2| {
        let off = (place - 0.5 * DVec2::new(width, height)) / pixels_per_tangent;
        // A step of 1 along the ray is a step of 1 in depth.
        let direction = world_from_view.transform_vector3(DVec3::new(off.x, -off.y, -1.0));
        let hits = corners.iter().filter_map(|corners| hit(world_from_view.w_axis.truncate(), direction, *corners));
        hits.filter(|depth| *depth >= near).min_by(f64::total_cmp)
    };
    let pixel = |place: DVec2| {
        let depths: Vec<f64> = SAMPLES.iter().filter_map(|&(x, y)| depth_at(place + DVec2::new(x, y))).collect();
        let n = depths.len() as f64;
        [if n > 0.0 { (depths.iter().sum::<f64>() / n) as f32 } else { 1e30 }, 0.25 * n as f32]
    };
    (0..SIZE[1])
        .flat_map(|y| (0..SIZE[0]).map(move |x| DVec2::new(f64::from(x), f64::from(y)) + 0.5))
        .map(pixel)
        .collect()
}

fn compare(what: &str, mesh: &TriMesh, camera: &Camera) {
    let (got, wanted) = (drawn(mesh, camera), exact(mesh, camera));
    let mut n_apart = 0;
    let mut worst: f32 = 0.0;
    for (got, wanted) in got.iter().zip(&wanted) {
        if got[1] == wanted[1] {
            worst = worst.max((got[0] / wanted[0] - 1.0).abs());
        } else {
            n_apart += 1;
        }
    }
    let n_covered = wanted.iter().filter(|pixel| pixel[1] > 0.0).count();
    println!("{what}: {n_covered} pixels, {n_apart} with another outline, depth apart {worst:e}");
    assert!(n_covered > 500, "{what}");
    assert!(n_apart * 500 <= n_covered, "{what}: {n_apart} of {n_covered}");
    assert!(worst < 1e-3, "{what}: {worst}");
}

#[test]
fn every_sample_sees_the_nearest_triangle() {
    let mesh = ball(9.0, 28);
    let camera = Camera { target: Vec3::new(1.0, 0.5, 0.0), distance: 40.0, ..Camera::default() };
    compare("a ball", &mesh, &camera);
    let near = Camera { azimuth_deg: 70.0, elevation_deg: 35.0, distance: 12.0, ..camera };
    compare("a ball that fills the picture", &mesh, &near);
    // Triangles all around: some lie behind the eye, some reach through its plane.
    let inside = Camera { distance: 5.0, ..camera };
    compare("a ball from within", &mesh, &inside);
    compare("a ball of large triangles from within", &ball(9.0, 6), &inside);
}

/// More large triangles than the lists of the tiles have room for.
#[test]
fn tiles_whose_lists_are_full_are_drawn_all_the_same() {
    let mut mesh = TriMesh::default();
    for k in 0..600_u32 {
        let z = 0.01 * f32::from(((k * 367) % 600) as u16);
        let turn = 0.1 * k as f32;
        let corner = |third: f32| {
            let angle = turn + third * std::f32::consts::TAU / 3.0;
            Vec3::new(60.0 * angle.cos(), 60.0 * angle.sin(), z)
        };
        mesh.positions.extend([corner(0.0), corner(1.0), corner(2.0)]);
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    compare("a pile", &mesh, &Camera { target: Vec3::ZERO, distance: 70.0, ..Camera::default() });
}
