//! The WGSL twins against the functions here, on random fibres and directions.

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::Look;
use lorelei_shaders::{Gpu, Link, ShaderLibrary};
use wgpu::BufferUsages;

use super::{
    Directions, Fibre, kajiya_kay, marschner,
    multiple::{multiple, spread, through},
    volume::volume,
};

const SCATTER: &str = "
#import lorelei::scatter_fibre::{Fibre, directions, vary}
#import lorelei::scatter_volume::{volume}
#import lorelei::scattering::{scatter}
#import lorelei::multiple::{multiple, spread, through}
struct Case { fibre: Fibre, tangent: vec3<f32>, seed: u32, to_light: vec3<f32>, t: f32, to_eye: vec3<f32>, tau: f32 }
@group(0) @binding(auto) var<storage, read> cases: array<Case>;
@group(0) @binding(auto) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cases) { return; }
    let c = cases[id.x];
    let fibre = vary(c.fibre, c.seed, c.t);
    let d = directions(c.tangent, c.to_light, c.to_eye, 2.0);
    answers[2u * id.x] = vec4<f32>(scatter(spread(fibre, c.tau), d) * through(fibre, volume(fibre), c.tau), 0.0);
    answers[2u * id.x + 1u] = vec4<f32>(multiple(fibre, volume(fibre), c.tangent, c.to_light, c.to_eye, c.tau), 0.0);
}";

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Case {
    fibre: Fibre,
    tangent: [f32; 3],
    seed: u32,
    to_light: [f32; 3],
    t: f32,
    to_eye: [f32; 3],
    tau: f32,
}

fn cases(n: usize) -> Vec<Case> {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..n)
        .map(|_| {
            let material = HairMaterial {
                eumelanin: 3.0 * random() * random(),
                pheomelanin: random(),
                beta_m_deg: 4.0 + 16.0 * random(),
                beta_n: 0.1 + 0.8 * random(),
                tilt_deg: 5.0 * random(),
                index_of_refraction: 1.4 + 0.4 * random(),
                ..HairMaterial::default()
            };
            let mut direction =
                || Vec3::new(random() - 0.5, random() - 0.5, random() - 0.5).normalize_or(Vec3::X).to_array();
            let (tangent, to_light, to_eye) = (direction(), direction(), direction());
            let fibre = Fibre::new(&material, &Look::default());
            Case { fibre, tangent, seed: (random() * 4e9) as u32, to_light, t: random(), to_eye, tau: 4.0 * random() }
        })
        .collect()
}

#[test]
fn wgsl_twins_agree_with_the_cpu() {
    let gpu = Gpu::headless().unwrap();
    let library = ShaderLibrary::from_sources(&[
        ("scatter_fibre", include_str!("../../../shaders/wgsl/scatter_fibre.wgsl")),
        ("scatter_volume", include_str!("../../../shaders/wgsl/scatter_volume.wgsl")),
        ("scatter_marschner", include_str!("../../../shaders/wgsl/scatter_marschner.wgsl")),
        ("scatter_r", include_str!("../../../shaders/wgsl/scatter_r.wgsl")),
        ("scatter_tt", include_str!("../../../shaders/wgsl/scatter_tt.wgsl")),
        ("scatter_trt", include_str!("../../../shaders/wgsl/scatter_trt.wgsl")),
        ("scatter_kajiya_kay", include_str!("../../../shaders/wgsl/scatter_kajiya_kay.wgsl")),
        ("scatter_multiple_fake_normal", include_str!("../../../shaders/wgsl/scatter_multiple_fake_normal.wgsl")),
        ("scatter_test", SCATTER),
    ]);
    let cases = cases(2000);
    let n = cases.len();
    let case_buffer = gpu.buffer_of("test.cases", &cases, BufferUsages::STORAGE);
    let answers = gpu.buffer("test.answers", 32 * n as u64, BufferUsages::STORAGE);
    for (file, scatter) in [
        ("scatter_marschner", marschner::scatter as fn(&Fibre, &Directions) -> Vec3),
        ("scatter_kajiya_kay", kajiya_kay::scatter),
    ] {
        let links = [
            Link::Slot("scattering", file),
            Link::Slot("lobe_r", "scatter_r"),
            Link::Slot("lobe_tt", "scatter_tt"),
            Link::Slot("lobe_trt", "scatter_trt"),
            Link::Slot("multiple", "scatter_multiple_fake_normal"),
        ];
        let kernel = library.kernel(&gpu, "scatter_test", "main", &[], &links).unwrap();
        let bindings = kernel
            .bind(&gpu, &[("cases", case_buffer.as_entire_binding()), ("answers", answers.as_entire_binding())])
            .unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            kernel.dispatch_items(&mut pass, &bindings, n as u32);
        }
        gpu.queue.submit([encoder.finish()]);
        let answers: Vec<[f32; 4]> = gpu.read_buffer(&answers).unwrap();
        let mut worst: f32 = 0.0;
        for (i, case) in cases.iter().enumerate() {
            let fibre = case.fibre.vary(case.seed, case.t);
            let [tangent, to_light, to_eye] = [case.tangent, case.to_light, case.to_eye].map(Vec3::from_array);
            let d = Directions::new(tangent, to_light, to_eye);
            let expected = [
                scatter(&spread(&fibre, case.tau), &d) * through(&fibre, &volume(&fibre), case.tau),
                multiple(&fibre, &volume(&fibre), tangent, to_light, to_eye, case.tau),
            ];
            for (answer, expected) in answers[2 * i..2 * i + 2].iter().zip(expected) {
                let difference = (Vec3::from_slice(&answer[..3]) - expected).abs();
                // 1e-4: a lobe's tail that no picture shows.
                worst = worst.max((difference / (expected + 1e-4)).max_element());
            }
        }
        println!("{file}: worst relative difference {worst:.1e}");
        // Steep Gaussians multiply the rounding of an angle by up to 100; measured 2e-4 on llvmpipe.
        assert!(worst < 2e-3, "{file}: {worst}");
    }
}
