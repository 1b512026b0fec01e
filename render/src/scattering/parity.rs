//! The WGSL twins against the functions here, on random fibres and directions.

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Choice, Fresnel, Look, Offsets, Scattering};
use lorelei_shaders::{Gpu, ShaderLibrary};
use wgpu::BufferUsages;

use super::tables::{Baked, FibreTables, Recipe};
use super::{
    Directions, Fibre, NO_OFFSET, chiang, deon, kajiya_kay, kajiya_kay_1989, marschner, marschner_2003,
    multiple::{multiple, spread, through},
    volume::volume,
};
use crate::slot;

const SCATTER: &str = "
#import lorelei::scatter_fibre::{Fibre, directions, vary}
#import lorelei::scatter_volume::{volume}
#import lorelei::scattering::{scatter}
#import lorelei::scatter_tables::{set_footprint}
#import lorelei::multiple::{multiple, spread, through}
struct Case {
    fibre: Fibre, tangent: vec3<f32>, seed: u32, to_light: vec3<f32>, t: f32, to_eye: vec3<f32>, tau: f32, h: f32,
    dyed: f32,
}
@group(0) @binding(auto) var<storage, read> cases: array<Case>;
@group(0) @binding(auto) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cases) { return; }
    let c = cases[id.x];
    let fibre = vary(c.fibre, c.seed, c.t, c.dyed);
    let d = directions(c.tangent, c.to_light, c.to_eye, c.h);
    set_footprint(0.0);
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
    h: f32,
    dyed: f32,
    pad: [f32; 2],
}

/// Random fibres and directions. `same_table`: with what tables are baked from as in `material`.
fn cases(n: usize, look: &Look, material: &HairMaterial, same_table: bool) -> Vec<Case> {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..n)
        .map(|_| {
            let mut varied = HairMaterial {
                eumelanin: 3.0 * random() * random(),
                pheomelanin: random(),
                beta_m_deg: 4.0 + 16.0 * random(),
                beta_n: 0.1 + 0.8 * random(),
                tilt_deg: 5.0 * random(),
                index_of_refraction: 1.4 + 0.4 * random(),
                roughness_variation: 0.3 * random(),
                tilt_variation_deg: 4.0 * random(),
                dye: random(),
                dye_from: random(),
                dye_to: random(),
                ..material.clone()
            };
            if same_table {
                (varied.beta_n, varied.index_of_refraction) = (material.beta_n, material.index_of_refraction);
            }
            let mut direction =
                || Vec3::new(random() - 0.5, random() - 0.5, random() - 0.5).normalize_or(Vec3::X).to_array();
            let (tangent, to_light, to_eye) = (direction(), direction(), direction());
            let mut fibre = Fibre::new(&varied, look);
            if look.scattering == Scattering::Marschner2003Nalu {
                let Fibre { beta, alpha, sigma_a, .. } = Fibre::new(material, look);
                (fibre.beta, fibre.alpha, fibre.baked_sigma_a) = (beta, alpha, sigma_a);
            }
            let h = if random() < 0.5 { NO_OFFSET } else { 2.0 * random() - 1.0 };
            let seed = (random() * 4e9) as u32;
            Case {
                fibre,
                tangent,
                seed,
                to_light,
                t: random(),
                to_eye,
                tau: 4.0 * random(),
                h,
                dyed: random(),
                pad: [0.0; 2],
            }
        })
        .collect()
}

/// What the CPU says of a scattering model.
pub(super) fn on_cpu(scattering: Scattering, baked: &Baked, fibre: &Fibre, d: &Directions) -> Vec3 {
    match scattering {
        Scattering::KajiyaKay => kajiya_kay::scatter(fibre, d),
        Scattering::KajiyaKay1989 => kajiya_kay_1989::scatter(fibre, d),
        Scattering::KajiyaKayHalf => kajiya_kay_1989::scatter_half(fibre, d),
        Scattering::Marschner => marschner::scatter(fibre, d),
        Scattering::Marschner2003 => marschner_2003::scatter(fibre, &baked.azimuthal, d),
        Scattering::Marschner2003Nalu => {
            let m = baked.longitudinal.as_ref().unwrap();
            marschner_2003::scatter_nalu(fibre, m, &baked.azimuthal, d)
        }
        Scattering::Deon => deon::scatter(fibre, &baked.azimuthal, d),
        Scattering::Chiang => chiang::scatter(fibre, &baked.azimuthal, d),
    }
}

#[test]
fn wgsl_twins_agree_with_the_cpu() {
    let gpu = Gpu::headless().unwrap();
    let library = ShaderLibrary::embedded().with_file("scatter_test", SCATTER);
    let material = HairMaterial { eumelanin: 0.4, ..HairMaterial::default() };
    for &scattering in Scattering::ALL {
        for (fresnel, offsets) in
            [(Fresnel::Exact, Offsets::Fitted), (Fresnel::Schlick, Offsets::Tafuri), (Fresnel::Exact, Offsets::Karis)]
        {
            if offsets != Offsets::Fitted && scattering != Scattering::Marschner {
                continue;
            }
            let look = Look { scattering, fresnel, offsets, ..Look::default() };
            let recipe = Recipe::of(&material, &look);
            let cases = cases(1500, &look, &material, recipe != Recipe::Nothing);
            let mut tables = FibreTables::new(&gpu);
            tables.prepare(&gpu, std::slice::from_ref(&recipe), true);
            let baked = Baked::new(&recipe);

            let case_buffer = gpu.buffer_of("test.cases", &cases, BufferUsages::STORAGE);
            let answers = gpu.buffer("test.answers", 32 * cases.len() as u64, BufferUsages::STORAGE);
            let mut links = slot::lobes(&look).to_vec();
            links.extend([slot::scattering(scattering), slot::multiple_scattering(look.multiple_scattering)]);
            let kernel = library.kernel(&gpu, "scatter_test", "main", &[], &links).unwrap();
            let mut resources =
                vec![("cases", case_buffer.as_entire_binding()), ("answers", answers.as_entire_binding())];
            resources.extend(tables.resources());
            let bindings = kernel.bind_used(&gpu, &resources).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                kernel.dispatch_items(&mut pass, &bindings, cases.len() as u32);
            }
            gpu.queue.submit([encoder.finish()]);
            let answers: Vec<[f32; 4]> = gpu.read_buffer(&answers).unwrap();
            let mut worst: f32 = 0.0;
            for (i, case) in cases.iter().enumerate() {
                let fibre = case.fibre.vary(case.seed, case.t, case.dyed);
                let [tangent, to_light, to_eye] = [case.tangent, case.to_light, case.to_eye].map(Vec3::from_array);
                let d = Directions { h: case.h, ..Directions::new(tangent, to_light, to_eye) };
                let expected = [
                    on_cpu(scattering, &baked, &spread(&fibre, case.tau), &d)
                        * through(&fibre, &volume(&fibre), case.tau),
                    multiple(&fibre, &volume(&fibre), tangent, to_light, to_eye, case.tau),
                ];
                for (answer, expected) in answers[2 * i..2 * i + 2].iter().zip(expected) {
                    let difference = (Vec3::from_slice(&answer[..3]) - expected).abs();
                    // 1e-4: a lobe's tail that no picture shows.
                    worst = worst.max((difference / (expected + 1e-4)).max_element());
                }
            }
            println!("{scattering:?} {fresnel:?} {offsets:?}: worst relative difference {worst:.1e}");
            // Steep Gaussians multiply the rounding of an angle by up to 100; measured 2e-4 on llvmpipe. Tables are of
            // half floats, whose smallest step is 6e-8: a lobe's tail times a peak of M.
            let most = if recipe == Recipe::Nothing { 2e-3 } else { 2e-2 };
            assert!(worst < most, "{scattering:?}: {worst}");
        }
    }
}
