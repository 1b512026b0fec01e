//! The maps against an exact sum over all segments, and the laws of their layers.

mod laws;

use glam::{Affine3A, Vec3};
use lorelei_core::light::Light;
use lorelei_core::look::{ShadowParams, Shadowing};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Gpu, ShaderLibrary};
use wgpu::BufferUsages;

use super::{Shadow, ShadowInput, ShadowLight, casters};
use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::scene::{Ball, SceneLights};
use crate::slot;

const BALL: Ball = Ball { centre: Vec3::ZERO, radius: 5.0 };
const RADIUS: f32 = 0.01;
const N_PER_STRAND: u32 = 8;

/// Strands in random directions through a ball of 3.5 cm.
fn cluster(n_strands: u32) -> Vec<Vec3> {
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    let mut points = Vec::new();
    for _ in 0..n_strands {
        let mut inside = || loop {
            let p = Vec3::new(random(), random(), random());
            if p.length() < 1.0 {
                return 3.5 * p;
            }
        };
        let (a, b) = (inside(), inside());
        points.extend((0..N_PER_STRAND).map(|k| a.lerp(b, k as f32 / (N_PER_STRAND - 1) as f32)));
    }
    points
}

fn strand_buffers(gpu: &Gpu, points: &[Vec3]) -> StrandBuffers {
    let vertices: Vec<[f32; 4]> = points.iter().map(|p| p.extend(RADIUS).to_array()).collect();
    let n_strands = points.len() as u32 / N_PER_STRAND;
    StrandBuffers {
        vertices: gpu.buffer_of("test.vertices", &vertices, BufferUsages::STORAGE),
        seeds: gpu.buffer_of("test.seeds", &vec![[0u32; 2]; n_strands as usize], BufferUsages::STORAGE),
        layers: vec![DrawnLayer {
            first_vertex: 0,
            first_strand: 0,
            n_strands,
            vertices_per_strand: N_PER_STRAND,
            material: 0,
        }],
        n_vertices: points.len() as u32,
        n_strands,
        widest: 0.01,
        generation: 1,
    }
}

/// (optical depth, past the head, share of the light) of each light at each position.
fn look_up_all(
    points: &[Vec3],
    at: &[Vec3],
    lights: &[Light],
    shadowing: Shadowing,
    params: &ShadowParams,
    head: Option<&TriMesh>,
) -> Vec<Vec<[f32; 4]>> {
    look_up_by(&ShaderLibrary::embedded(), points, at, lights, shadowing, params, head)
}

/// As [`look_up_all`], with these shaders.
fn look_up_by(
    library: &ShaderLibrary,
    points: &[Vec3],
    at: &[Vec3],
    lights: &[Light],
    shadowing: Shadowing,
    params: &ShadowParams,
    head: Option<&TriMesh>,
) -> Vec<Vec<[f32; 4]>> {
    let gpu = Gpu::headless().unwrap();
    let strands = strand_buffers(&gpu, points);
    let mut shadow = Shadow::new(&gpu);
    shadow.set_head(&gpu, head);
    let lights = SceneLights::new(lights);
    let world_from_head = Affine3A::IDENTITY;
    let input = ShadowInput { shadowing, params, lights: &lights, ball: BALL, world_from_head, head_casts: true };
    shadow.prepare(&gpu, library, &strands, &input).unwrap();
    let kernel = library.kernel(&gpu, "shadow_probe", "probe", &[], &slot::shadowing(shadowing)).unwrap();
    let places: Vec<[f32; 4]> = (0..lights.lights.len())
        .flat_map(|light_idx| at.iter().map(move |p| p.extend(light_idx as f32).to_array()))
        .collect();
    let buffer = gpu.buffer_of("test.places", &places, BufferUsages::STORAGE);
    let answers = gpu.buffer("test.answers", buffer.size(), BufferUsages::STORAGE);
    let mut resources = shadow.resources();
    resources.push(("probe_places", buffer.as_entire_binding()));
    resources.push(("probe_answers", answers.as_entire_binding()));
    let bindings = kernel.bind_used(&gpu, &resources).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    shadow.record(&mut encoder, &input);
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        kernel.dispatch_items(&mut pass, &bindings, places.len() as u32);
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.take_error().unwrap();
    // A small buffer has room to spare.
    let answers: Vec<[f32; 4]> = gpu.read_buffer(&answers).unwrap();
    answers.chunks(at.len()).take(lights.lights.len()).map(<[_]>::to_vec).collect()
}

/// As [`look_up_all`], of one light.
fn look_up(
    points: &[Vec3],
    at: &[Vec3],
    light: Light,
    shadowing: Shadowing,
    params: &ShadowParams,
    head: Option<&TriMesh>,
) -> Vec<[f32; 4]> {
    look_up_all(points, at, &[light], shadowing, params, head).remove(0)
}

/// Optical depth before a point: every bit of fibre nearer to the light, weighted by what the map's texels, filter taps
/// and bilinear look-up amount to, which is nearly a Gaussian.
fn exact_depth(points: &[Vec3], map: &ShadowLight, at: Vec3, sigma_texels: f32) -> f32 {
    let place = map.map_place(at);
    let mut depth = 0.0;
    for strand in points.chunks(N_PER_STRAND as usize) {
        for segment in strand.windows(2) {
            let n = 8;
            let (a, b) = (map.map_place(segment[0]), map.map_place(segment[1]));
            let length = (b - a).truncate().truncate().length();
            for i in 0..n {
                let p = a.lerp(b, (i as f32 + 0.5) / n as f32);
                let d2 = (p - place).truncate().truncate().length_squared() / (sigma_texels * sigma_texels);
                if p.z < place.z && d2 < 16.0 {
                    let weight = (-0.5 * d2).exp() / (std::f32::consts::TAU * sigma_texels * sigma_texels);
                    depth += weight * length / n as f32 * 2.0 * RADIUS * map.texels_per_cm;
                }
            }
        }
    }
    depth
}

#[test]
fn transmittance_agrees_with_an_exact_sum_over_the_segments() {
    let points = cluster(1500);
    let at: Vec<Vec3> = points.iter().copied().step_by(23).collect();
    let params =
        ShadowParams { n_layers: 7, layer_size: 0.25, resolution: 96, filter_radius: 1.5, ..ShadowParams::default() };
    let light = Light::directional("key", 30.0, 40.0, 1.0, [1.0; 3]);
    let answers = look_up(&points, &at, light.clone(), Shadowing::DeepOpacity, &params, None);
    let map =
        ShadowLight::new(&SceneLights::new(&[light]).lights[0], true, BALL, Affine3A::IDENTITY, params.resolution);
    // Variances in texels: a texel 1/12, taps (1/2, 1, 1/2) 1/2, bilinear about 1/6.
    let sigma = (1.0f32 / 12.0 + 0.5 + 1.0 / 6.0).sqrt();
    let (mut error, mut bias, mut darkest) = (0.0, 0.0, 1.0f32);
    for (answer, &p) in answers.iter().zip(&at) {
        let exact = (-exact_depth(&points, &map, p, sigma)).exp();
        error += ((-answer[0]).exp() - exact).abs() / at.len() as f32;
        bias += ((-answer[0]).exp() - exact) / at.len() as f32;
        darkest = darkest.min(exact);
    }
    println!("mean error of the transmittance {error:.4}, bias {bias:.4}, darkest {darkest:.3}");
    assert!(darkest < 0.3, "the cluster is too thin to show anything: {darkest}");
    assert!(error < 0.03, "mean error {error}");
    assert!(bias.abs() < 0.02, "bias {bias}");
}

#[test]
fn without_hair_or_head_everything_arrives_and_off_is_the_same() {
    let points = cluster(400);
    let at: Vec<Vec3> = points.iter().copied().step_by(17).collect();
    let light = Light::directional("key", 0.0, 20.0, 1.0, [1.0; 3]);
    let params = ShadowParams { resolution: 64, ..ShadowParams::default() };
    for answer in look_up(&points, &at, light.clone(), Shadowing::Off, &params, None) {
        assert_eq!(answer, [0.0, 1.0, 1.0, 0.0]);
    }
    // Before the cluster, seen from the light, nothing is lost; outside of the map neither.
    let clear = [light.direction_to(Vec3::ZERO) * 4.5, Vec3::new(50.0, 0.0, 0.0)];
    for answer in look_up(&points, &clear, light, Shadowing::DeepOpacity, &params, None) {
        assert_eq!(&answer[..3], &[0.0, 1.0, 1.0]);
    }
}

#[test]
fn the_head_shadows_what_is_behind_it_under_parallel_and_point_light() {
    // A square of 4 cm across the light's way.
    let head = TriMesh {
        positions: vec![
            Vec3::new(-2.0, -2.0, 0.0),
            Vec3::new(2.0, -2.0, 0.0),
            Vec3::new(2.0, 2.0, 0.0),
            Vec3::new(-2.0, 2.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    };
    let at =
        [Vec3::new(0.3, -0.2, -2.0), Vec3::new(0.3, -0.2, 2.0), Vec3::new(3.4, 0.0, -2.0), Vec3::new(0.0, 1.5, -1.0)];
    let parallel = Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3]);
    let point = Light {
        kind: lorelei_core::light::LightKind::Point { position: Vec3::new(0.0, 0.0, 60.0) },
        ..parallel.clone()
    };
    let params = ShadowParams { resolution: 128, ..ShadowParams::default() };
    for light in [parallel, point] {
        let answers = look_up(&cluster(1), &at, light, Shadowing::DeepOpacity, &params, Some(&head));
        let past: Vec<f32> = answers.iter().map(|answer| answer[1]).collect();
        assert_eq!(past, [0.0, 1.0, 1.0, 0.0]);
    }
}

#[test]
fn hair_behind_the_head_does_not_darken_the_skin_in_front() {
    let side = 3.4;
    let head = TriMesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(side * x, side * y, 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    };
    // A thin veil before the skin, and a thick lock behind the head.
    let row = |from: Vec3| (0..N_PER_STRAND).map(move |k| from + Vec3::X * (0.5 * k as f32));
    let veil: Vec<Vec3> = (0..8).flat_map(|n| row(Vec3::new(-1.75, 0.25 * n as f32 - 1.0, 0.4))).collect();
    let lock = (0..800).flat_map(|n| row(Vec3::new(-1.75, (n % 40) as f32 * 0.05 - 1.0, -1.5 - 0.1 * (n / 40) as f32)));
    let both: Vec<Vec3> = veil.iter().copied().chain(lock).collect();
    let at: Vec<Vec3> = (0..9).map(|n| Vec3::new((n % 3) as f32 - 1.0, 0.6 * ((n / 3) as f32 - 1.0), 0.02)).collect();
    let light = Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3]);
    let params = ShadowParams { n_layers: 2, layer_size: 0.2, resolution: 64, ..ShadowParams::default() };
    let shade = |points: &[Vec3]| {
        look_up(points, &at, light.clone(), Shadowing::DeepOpacity, &params, Some(&head))
            .iter()
            .map(|answer| answer[2])
            .collect::<Vec<f32>>()
    };
    let (alone, with_lock) = (shade(&veil), shade(&both));
    for (alone, with_lock) in alone.iter().zip(&with_lock) {
        assert!(*alone > 0.8, "{alone}");
        assert!((alone - with_lock).abs() < 1e-3, "{alone} {with_lock}");
    }
}

#[test]
fn casters_are_a_share_of_each_layer_and_as_much_wider() {
    let layer = |n_strands| DrawnLayer { n_strands, vertices_per_strand: 8, ..DrawnLayer::default() };
    let layers = [layer(90_000), layer(10_000), layer(0)];
    let few = casters(&layers, 25_000);
    assert_eq!(few.iter().map(|caster| caster.layer.n_strands).collect::<Vec<_>>(), [22_500, 2_500, 0]);
    for (caster, layer) in few.iter().zip(&layers) {
        let width = caster.width_scale * caster.layer.n_strands as f32;
        assert!((width - layer.n_strands as f32).abs() < 0.01);
    }
    assert!(casters(&layers, 1_000_000).iter().all(|caster| caster.width_scale == 1.0 || caster.layer.n_strands == 0));
}
