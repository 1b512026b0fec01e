//! What every technique must do: agree with the exact sum as well as it can, get a slab right, never let a place farther
//! from the light see more of it, and keep lights apart.

use glam::{DVec3, Vec3, Vec4};
use lorelei_core::light::{Light, LightKind};
use lorelei_core::look::{BeyondLast, Choice, ShadowParams, Shadowing};
use lorelei_shaders::{Gpu, ShaderLibrary};

use super::{BALL, N_PER_STRAND, RADIUS, cluster, look_up, look_up_all, look_up_by, strand_buffers};
use crate::mirror::DrawnLayer;
use crate::scene::SceneLights;
use crate::shadow::exact::{ExactShadow, Occluders};
use crate::shadow::plan::SceneSize;
use crate::shadow::{Shadow, ShadowInput, compress, fitting, most_casters};

/// Maps of 0.1 cm a texel, nothing thrown aside.
fn params() -> ShadowParams {
    ShadowParams {
        resolution: 96,
        filter_radius: 0.5,
        n_layers: 7,
        layer_size: 0.25,
        jitter: 0.0,
        falloff: 0.4,
        bias: 0.0,
        n_slices: 64,
        n_voxels: 48,
        n_steps: 48,
        step_jitter: 0.0,
        ..ShadowParams::default()
    }
}

fn key() -> Light {
    Light::directional("key", 30.0, 40.0, 1.0, [1.0; 3])
}

fn lamp() -> Light {
    Light { kind: LightKind::Point { position: Vec3::new(8.0, 6.0, 14.0) }, ..key() }
}

/// Every technique but off.
fn techniques() -> impl Iterator<Item = Shadowing> {
    Shadowing::ALL.iter().copied().filter(|&shadowing| shadowing != Shadowing::Off)
}

/// Mean error of the transmittance, and mean of what is too bright.
fn errors(library: &ShaderLibrary, points: &[Vec3], light: &Light, shadowing: Shadowing) -> [f64; 2] {
    let vertices: Vec<Vec4> = points.iter().map(|p| p.extend(RADIUS)).collect();
    let strands = Occluders { vertices: &vertices, vertices_per_strand: N_PER_STRAND as usize };
    let scene_light = SceneLights::new(std::slice::from_ref(light)).lights[0];
    let exact = ExactShadow::new(&[strands], &scene_light, DVec3::ZERO, 0.1);
    let at: Vec<Vec3> = points.iter().copied().step_by(23).collect();
    let answers = look_up_by(library, points, &at, std::slice::from_ref(light), shadowing, &params(), None).remove(0);
    let mut sums = [0.0; 2];
    for (k, (answer, p)) in answers.iter().zip(&at).enumerate() {
        let strand_idx = Some((23 * k) as u32 / N_PER_STRAND);
        let error = f64::from((-answer[0]).exp()) - (-exact.optical_depth(p.as_dvec3(), strand_idx, 0.1)).exp();
        sums[0] += error.abs() / at.len() as f64;
        sums[1] += error / at.len() as f64;
    }
    sums
}

/// What is wrong with a technique in a cluster of strands under a lamp.
fn errs_too_much(library: &ShaderLibrary, points: &[Vec3], light: &Light, shadowing: Shadowing) -> Option<String> {
    let [error, bias] = errors(library, points, light, shadowing);
    println!("{shadowing:?}: mean error {error:.4}, bias {bias:.4}");
    // Measured values and about a third more; what knows only the front of the hair is far off.
    let (most, most_bias) = match shadowing {
        Shadowing::Off => (0.0, 0.0),
        Shadowing::ShadowMap => (0.32, 0.32),
        Shadowing::Exponential => (0.26, 0.25),
        Shadowing::OpacityMaps | Shadowing::Clusters | Shadowing::DeepShadow => (0.04, 0.015),
        Shadowing::Occupancy => (0.04, 0.02),
        Shadowing::DeepOpacity => (0.045, 0.02),
        Shadowing::Voxels => (0.05, 0.015),
    };
    let is_right = error < most && bias.abs() < most_bias;
    (!is_right).then(|| format!("{shadowing:?}: mean error {error}, bias {bias}"))
}

#[test]
fn every_technique_errs_no_more_than_it_must() {
    let (library, points) = (ShaderLibrary::embedded(), cluster(1500));
    let lights = [key(), lamp()];
    let wrong: Vec<String> = (lights.iter())
        .flat_map(|light| techniques().map(move |shadowing| (light, shadowing)))
        .filter_map(|(light, shadowing)| errs_too_much(&library, &points, light, shadowing))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// One fault for each technique, such as a slip of the pen makes: file, what it says, and what it says instead.
const FAULTS: &[(Shadowing, &str, &str, &str, &str)] = &[
    (
        Shadowing::ShadowMap,
        "shadow_pcf",
        include_str!("../../../../shaders/wgsl/shadow_pcf.wgsl"),
        "depth > hair_front",
        "depth < hair_front",
    ),
    (
        Shadowing::Exponential,
        "shadow_exponential",
        include_str!("../../../../shaders/wgsl/shadow_exponential.wgsl"),
        "shadow_params.falloff * max",
        "max",
    ),
    (
        Shadowing::OpacityMaps,
        "shadow_slices_sum",
        include_str!("../../../../shaders/wgsl/shadow_slices_sum.wgsl"),
        "above = min(near + (two >> 16u), 0xffffu)",
        "above = near",
    ),
    (
        Shadowing::Clusters,
        "shadow_clusters_update",
        include_str!("../../../../shaders/wgsl/shadow_clusters_update.wgsl"),
        "front_depth(front) + mean * width",
        "front_depth(front) + mean",
    ),
    (
        Shadowing::Occupancy,
        "shadow_occupancy",
        include_str!("../../../../shaders/wgsl/shadow_occupancy.wgsl"),
        "k < slab;",
        "k <= slab;",
    ),
    (
        Shadowing::DeepOpacity,
        "shadow_deep_opacity",
        include_str!("../../../../shaders/wgsl/shadow_deep_opacity.wgsl"),
        "select(filtered(at, below), 0.0, below == 0u)",
        "0.0",
    ),
    (
        Shadowing::DeepShadow,
        "shadow_deep_shadow",
        include_str!("../../../../shaders/wgsl/shadow_deep_shadow.wgsl"),
        "light = mix(light, packed_value(next)",
        "light = mix(1.0, packed_value(next)",
    ),
    (
        Shadowing::Voxels,
        "shadow_voxels",
        include_str!("../../../../shaders/wgsl/shadow_voxels.wgsl"),
        "w * (w - along)",
        "w * along",
    ),
];

#[test]
fn a_fault_in_any_technique_is_found_out() {
    let points = cluster(1500);
    for shadowing in techniques() {
        let faults: Vec<_> = FAULTS.iter().filter(|fault| fault.0 == shadowing).collect();
        assert!(!faults.is_empty(), "{shadowing:?} has no fault to be found");
        for (_, file, text, said, instead) in faults {
            assert!(text.contains(said), "{file} does not say `{said}`");
            let library = ShaderLibrary::embedded().with_file(file, &text.replacen(said, instead, 1));
            let wrong =
                errs_too_much(&library, &points, &key(), shadowing).or_else(|| slab_is_off(&library, shadowing));
            assert!(wrong.is_some(), "{shadowing:?}: nobody sees that {file} says `{instead}`");
        }
    }
}

/// Sheets of parallel strands across z, each covering `covered` of what is behind it, 0.1 cm apart from z = 2 down.
fn slab(n_sheets: u32, covered: f32) -> Vec<Vec3> {
    let spacing = 2.0 * RADIUS / covered;
    let n_rows = (6.0 / spacing) as u32;
    let strand = |sheet: u32, row: u32| {
        // Sheets are shifted against each other, so that no texel is empty in all of them.
        let y = spacing * (row as f32 + 0.618_034 * sheet as f32 % 1.0) - 3.0;
        (0..N_PER_STRAND).map(move |k| {
            let x = 6.0 * k as f32 / (N_PER_STRAND - 1) as f32 - 3.0;
            Vec3::new(x, y, 2.0 - 0.1 * sheet as f32)
        })
    };
    (0..n_sheets).flat_map(|sheet| (0..n_rows).flat_map(move |row| strand(sheet, row))).collect()
}

/// What is wrong with a technique at any depth of a slab.
fn slab_is_off(library: &ShaderLibrary, shadowing: Shadowing) -> Option<String> {
    // 40 sheets of 0.1 in 4 cm: one optical depth a centimetre.
    let points = slab(40, 0.1);
    let front = Light::directional("front", 0.0, 0.0, 1.0, [1.0; 3]);
    let depths = [0.5, 1.0, 1.5, 2.0, 3.0];
    let at: Vec<Vec3> = (depths.iter())
        .flat_map(|&depth| (0..16).map(move |k| Vec3::new(0.13 * k as f32 - 1.0, 1.0 - 0.11 * k as f32, 2.05 - depth)))
        .collect();
    let answers = look_up_by(library, &points, &at, &[front], shadowing, &params(), None).remove(0);
    let mut wrong = None;
    for (depth, answers) in depths.iter().zip(answers.chunks(16)) {
        let left = answers.iter().map(|answer| (-answer[0]).exp()).sum::<f32>() / 16.0;
        let exact = match shadowing {
            Shadowing::ShadowMap => 0.0,
            Shadowing::Exponential => (-params().falloff * depth).exp(),
            Shadowing::Off
            | Shadowing::OpacityMaps
            | Shadowing::Clusters
            | Shadowing::DeepOpacity
            | Shadowing::Occupancy
            | Shadowing::DeepShadow
            | Shadowing::Voxels => (-depth).exp(),
        };
        println!("{shadowing:?}: at {depth} cm {left:.3} of {exact:.3}");
        // Half a texel before a place is left out, half a cell of the grid; where the first sheet leaves a texel open,
        // the front is a sheet or two behind; and the filter's front is its neighbours'.
        let tolerance = match shadowing {
            Shadowing::Voxels => 0.12,
            Shadowing::Exponential => 0.08,
            Shadowing::DeepOpacity => 0.075,
            Shadowing::Off
            | Shadowing::ShadowMap
            | Shadowing::OpacityMaps
            | Shadowing::Clusters
            | Shadowing::Occupancy
            | Shadowing::DeepShadow => 0.05,
        };
        if (left - exact).abs() >= tolerance {
            wrong = Some(format!("{shadowing:?}: at {depth} cm {left:.3} of {exact:.3}"));
        }
    }
    wrong
}

#[test]
fn a_slab_holds_back_what_its_area_says() {
    let library = ShaderLibrary::embedded();
    let wrong: Vec<String> = techniques().filter_map(|shadowing| slab_is_off(&library, shadowing)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn nowhere_does_a_place_farther_from_the_light_get_more_of_it() {
    let points = cluster(800);
    let light = key();
    let away = -light.direction_to(Vec3::ZERO);
    let (right, up) = away.any_orthonormal_pair();
    let n = 120;
    let at: Vec<Vec3> = (0..12)
        .flat_map(|ray| {
            let from = (0.5 * ray as f32 - 3.0) * right + (0.37 * ray as f32 - 2.0) * up;
            (0..n).map(move |k| from + (0.075 * k as f32 - 4.4) * away)
        })
        .collect();
    let mut wrong = Vec::new();
    for shadowing in techniques() {
        let answers = look_up(&points, &at, light.clone(), shadowing, &params(), None);
        for ray in answers.chunks(n) {
            for two in ray.windows(2) {
                let left = [(-two[0][0]).exp(), (-two[1][0]).exp()];
                // Steps through the grid begin elsewhere for each place; the filter of deep opacity maps shifts layers by
                // shares of themselves.
                let tolerance = match shadowing {
                    Shadowing::Voxels => 0.03,
                    Shadowing::DeepOpacity => 0.02,
                    Shadowing::Off
                    | Shadowing::ShadowMap
                    | Shadowing::Exponential
                    | Shadowing::OpacityMaps
                    | Shadowing::Clusters
                    | Shadowing::Occupancy
                    | Shadowing::DeepShadow => 1e-4,
                };
                if left[1] > left[0] + tolerance {
                    wrong.push(format!("{shadowing:?}: {left:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn lights_do_not_see_each_others_shadows() {
    let points = cluster(300);
    let at: Vec<Vec3> = points.iter().copied().step_by(29).collect();
    let dark = Light { casts_shadow: false, ..Light::directional("fill", -60.0, 10.0, 1.0, [1.0; 3]) };
    let (key, lamp) = (key(), lamp());
    let params = ShadowParams { resolution: 64, ..params() };
    for shadowing in techniques() {
        let lights = [dark.clone(), lamp.clone(), key.clone()];
        let all = look_up_all(&points, &at, &lights, shadowing, &params, None);
        for (light_idx, light) in lights.iter().enumerate() {
            let alone = look_up(&points, &at, light.clone(), shadowing, &params, None);
            let apart = |(a, b): (&[f32; 4], &[f32; 4])| (a[0] - b[0]).abs().max((a[2] - b[2]).abs());
            let most = all[light_idx].iter().zip(&alone).map(apart).fold(0.0, f32::max);
            // The rounds of a sum in another order.
            assert!(most < 1e-4, "{shadowing:?}, light {light_idx}: apart by {most}");
        }
        assert!(all[0].iter().all(|answer| answer[0] == 0.0), "{shadowing:?}: a light without shadows casts one");
        assert!(all[1] != all[2], "{shadowing:?}");
    }
}

#[test]
fn hair_behind_the_last_layer_is_left_out_or_shadows_itself_or_stretches_it() {
    // Two slabs of one optical depth each: within the layers, and behind the last of them, which ends at 0.6 cm.
    let mut points = slab(5, 0.2);
    points.extend(slab(5, 0.2).into_iter().map(|p| p - Vec3::Z * 3.0));
    let front = Light::directional("front", 0.0, 0.0, 1.0, [1.0; 3]);
    // Between the slabs, and behind both.
    let at = [Vec3::new(0.2, 0.3, 0.0), Vec3::new(0.2, 0.3, -2.5)];
    let tau = |beyond_last| {
        let params = ShadowParams { n_layers: 2, layer_size: 0.2, beyond_last, ..params() };
        let answers = look_up(&points, &at, front.clone(), Shadowing::DeepOpacity, &params, None);
        [answers[0][0], answers[1][0]]
    };
    let near = |tau: [f32; 2], expected: [f32; 2]| tau.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 0.2);
    let (ignore, last, grow) = (tau(BeyondLast::Ignore), tau(BeyondLast::LastLayer), tau(BeyondLast::Grow));
    assert!(near(ignore, [1.0, 1.0]), "{ignore:?}");
    assert!(near(last, [2.0, 2.0]), "{last:?}");
    // The last layer holds 0.6 and the far slab, from 0.2 to 3.4 cm.
    assert!(near([grow[1]; 2], [2.0; 2]) && grow[0] > 1.1 && grow[0] < 1.75, "{grow:?}");
}

#[test]
fn every_technique_fits_the_gpu_with_many_lights_and_the_finest_maps() {
    let gpu = Gpu::headless().unwrap();
    let lights = SceneLights::new(&vec![key(); 12]);
    let layers = [DrawnLayer { n_strands: 1_000_000, vertices_per_strand: 32, ..DrawnLayer::default() }];
    let finest = ShadowParams { resolution: 4096, n_slices: 256, n_layers: 15, n_strands: 4_000_000, ..params() };
    for shadowing in techniques() {
        let input = ShadowInput {
            shadowing,
            params: &finest,
            lights: &lights,
            ball: BALL,
            world_from_head: glam::Affine3A::IDENTITY,
            head_casts: false,
        };
        let n_strands = u64::from(most_casters(&gpu, &input, &layers));
        let scene = SceneSize { n_strands, n_segments: 31 * n_strands };
        let (plan, size) = fitting(&gpu, &input, &finest, &scene).unwrap();
        assert!(plan.largest() <= gpu.max_storage_binding(), "{shadowing:?}: {size:?}");
        assert!((128..=4096).contains(&size.resolution), "{shadowing:?}: {size:?}");
    }
}

#[test]
fn polylines_on_the_gpu_are_those_of_the_cpu() {
    let points = cluster(400);
    let gpu = Gpu::headless().unwrap();
    let library = ShaderLibrary::embedded();
    let strands = strand_buffers(&gpu, &points);
    let lights = SceneLights::new(&[key()]);
    // Nodes of each texel: (step of depth, light left).
    let nodes = |tolerance: f32| {
        let params = ShadowParams { resolution: 32, tolerance, ..params() };
        let mut shadow = Shadow::new(&gpu);
        let input = ShadowInput {
            shadowing: Shadowing::DeepShadow,
            params: &params,
            lights: &lights,
            ball: BALL,
            world_from_head: glam::Affine3A::IDENTITY,
            head_casts: false,
        };
        shadow.prepare(&gpu, &library, &strands, &input).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        shadow.record(&mut encoder, &input);
        gpu.queue.submit([encoder.finish()]);
        let made = shadow.made.as_ref().unwrap();
        let words = |name: &str| {
            let at = made.plan.buffers.iter().position(|words| words.name == name).unwrap();
            gpu.read_buffer::<u32>(&made.buffers[at]).unwrap()
        };
        let (counts, offsets, lists) = (words("shadow_counts"), words("shadow_offsets"), words("shadow_fragments"));
        let unpack = |word: &u32| (word >> 14, (word & 0x3fff) as f32 / 16383.0);
        (0..32 * 32)
            .map(|at: usize| lists[offsets[at] as usize..][..counts[at] as usize].iter().map(unpack).collect())
            .collect::<Vec<Vec<(u32, f32)>>>()
    };
    let (all, few) = (nodes(0.0), nodes(0.03));
    let (mut n_all, mut n_few) = (0, 0);
    for (all, few) in all.iter().zip(&few) {
        let expected = compress(all, 0.03);
        // The points come back rounded: a node may fall on a neighbour, the length differ by one.
        assert!(expected.len().abs_diff(few.len()) <= 1, "{expected:?} {few:?}");
        if expected.len() == few.len() {
            let same = expected.iter().zip(few).filter(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 2e-3).count();
            n_few += same;
            n_all += few.len();
        }
    }
    assert!(n_all > 500 && n_few as f32 > 0.95 * n_all as f32, "{n_few} of {n_all} nodes agree");
}

#[test]
fn deep_shadow_maps_without_room_for_every_fragment_are_grainy_and_not_wrong() {
    // Strands that go to and fro: several times as long as the room is guessed for.
    let ends = cluster(900);
    let points: Vec<Vec3> = ends
        .chunks(N_PER_STRAND as usize)
        .flat_map(|strand| {
            let (a, b) = (strand[0], strand[N_PER_STRAND as usize - 1]);
            (0..N_PER_STRAND).map(move |k| if k % 2 == 0 { a + 0.1 * k as f32 } else { b - 0.1 * k as f32 })
        })
        .collect();
    let n_guessed = 900.0 * f64::from(params().resolution);
    let texels_per_cm = f64::from(params().resolution) / (2.0 * f64::from(BALL.radius));
    let length: f64 = (points.chunks(N_PER_STRAND as usize))
        .flat_map(|strand| strand.windows(2).map(|two| f64::from(two[0].distance(two[1]))))
        .sum();
    assert!(0.6 * length * texels_per_cm > 1.3 * n_guessed, "there is room for {n_guessed} fragments, and no more");
    let scatter = include_str!("../../../../shaders/wgsl/shadow_sink_scatter.wgsl");
    let unweighted = ShaderLibrary::embedded().with_file("shadow_sink_scatter", &scatter.replace("weight * ", ""));
    for light in [key(), lamp()] {
        let [error, bias] = errors(&ShaderLibrary::embedded(), &points, &light, Shadowing::DeepShadow);
        let [_, lost] = errors(&unweighted, &points, &light, Shadowing::DeepShadow);
        println!("mean error {error:.4}, bias {bias:.4}; where what is left out is lost, bias {lost:.4}");
        assert!(error < 0.075 && bias.abs() < 0.03 && lost > bias + 0.03, "mean error {error}, bias {bias}, {lost}");
    }
}
