//! The whole frame against the exact picture, and what must not go wrong around it.

use glam::{Affine3A, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::lod::LodChoice;
use lorelei_core::look::{
    Antialiasing, Background, Choice, HeadShading, Primitive, ShadingRate, Shadowing, Transparency,
};
use lorelei_shaders::{Gpu, ShaderLibrary};

use super::{FrameInput, Pixels, RenderError, Renderer, Threads};
use crate::profile::DRAWING_PASSES;
use crate::sample::sample_groom;

const SIZE: [u32; 2] = [256, 256];

fn camera() -> Camera {
    Camera { target: Vec3::new(0.0, -6.0, 0.0), distance: 110.0, ..Camera::default() }
}

fn input(camera: &Camera) -> FrameInput<'_> {
    FrameInput { camera, size: SIZE, world_from_head: Affine3A::IDENTITY, moved: &[], moved_stamp: 0, lod_scale: 1.0 }
}

/// What the rasteriser's threads can be on this device.
fn every_threads(gpu: &Gpu) -> Vec<Threads> {
    let mut all = vec![Threads::Segments];
    if gpu.has(wgpu::Features::SUBGROUP) && gpu.adapter_info.subgroup_min_size >= 8 {
        all.push(Threads::Lanes);
    }
    all
}

fn renderer(groom: &Groom) -> Renderer {
    let gpu = Gpu::headless().unwrap();
    renderer_with(&gpu, groom, Threads::for_gpu(&gpu))
}

fn renderer_with(gpu: &Gpu, groom: &Groom, threads: Threads) -> Renderer {
    let mut renderer = Renderer::with_threads(gpu, ShaderLibrary::embedded(), threads).unwrap();
    assert_eq!(renderer.set_groom(groom).unwrap(), Vec::<String>::new());
    renderer
}

/// The hair of the last frame, premultiplied.
fn hair(renderer: &Renderer) -> Vec<[f64; 4]> {
    renderer.read_hair().unwrap()
}

/// The same hair by the exact reference, from the vertices and radiances that the GPU drew.
fn exact_hair(renderer: &Renderer, camera: &Camera) -> Vec<[f64; 4]> {
    renderer.exact_hair(camera).unwrap()
}

/// Root mean square difference over all channels, and sums of alpha.
fn difference(got: &[[f64; 4]], exact: &[[f64; 4]]) -> (f64, f64) {
    let squares: f64 = got.iter().zip(exact).flat_map(|(got, exact)| (0..4).map(|c| (got[c] - exact[c]).powi(2))).sum();
    let covered = |picture: &[[f64; 4]]| picture.iter().map(|pixel| pixel[3]).sum::<f64>();
    ((squares / (4 * exact.len()) as f64).sqrt(), covered(got) / covered(exact))
}

#[test]
fn every_primitive_draws_the_exact_picture() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    // Radii from thinner than a pixel (0.05 of one) to wider than one.
    for (n_strands, radius_um) in [(4_000, 40.0), (4_000, 300.0), (300, 1_500.0)] {
        let mut groom = sample_groom(n_strands, 16);
        groom.layers[0].radius_um = radius_um;
        for threads in every_threads(&gpu) {
            let mut renderer = renderer_with(&gpu, &groom, threads);
            for (primitive, most_rmse) in
                [(Primitive::Compute, 0.02), (Primitive::Ribbons, 0.03), (Primitive::Polylines, 0.03)]
            {
                groom.look.primitive = primitive;
                renderer.set_groom(&groom).unwrap();
                renderer.render_pixels(&input(&camera)).unwrap();
                let (listed, room) = renderer.n_tile_entries().unwrap();
                assert!(listed <= room && (listed > 0) == (primitive == Primitive::Compute));
                let (rmse, coverage) = difference(&hair(&renderer), &exact_hair(&renderer, &camera));
                let what = format!("{n_strands} strands of {radius_um} um, {primitive:?}, {threads:?}");
                println!("{what}: rmse {rmse:.5}, coverage {coverage:.4}");
                // A line is never wider than a pixel.
                if primitive == Primitive::Polylines && radius_um > 1_000.0 {
                    continue;
                }
                assert!(rmse < most_rmse, "{what}: {rmse}");
                assert!((coverage - 1.0).abs() < 0.03, "{what}: {coverage}");
            }
        }
    }
}

/// Hair of one colour and width, seen so that many strands share a pixel.
fn heap() -> Groom {
    let mut groom = sample_groom(3_000, 12);
    groom.layers[0].radius_um = 200.0;
    groom
}

/// The hair of a look, and how far it is from the exact picture of the same vertices.
fn drawn(renderer: &mut Renderer, groom: &Groom, camera: &Camera) -> (Vec<[f64; 4]>, f64, f64) {
    renderer.set_groom(groom).unwrap();
    renderer.render_pixels(&input(camera)).unwrap();
    let hair = hair(renderer);
    let (rmse, coverage) = difference(&hair, &exact_hair(renderer, camera));
    (hair, rmse, coverage)
}

#[test]
fn every_transparency_is_as_near_the_exact_picture_as_it_promises() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    let mut groom = heap();
    let mut renderer = renderer_with(&gpu, &groom, Threads::for_gpu(&gpu));
    for primitive in [Primitive::Compute, Primitive::Ribbons] {
        for &transparency in Transparency::ALL {
            groom.look.primitive = primitive;
            groom.look.transparency = transparency;
            let (_, rmse, coverage) = drawn(&mut renderer, &groom, &camera);
            let times = renderer.pass_times();
            let is_drawing = |pass: &str| DRAWING_PASSES.iter().any(|start| pass.starts_with(start));
            let told = times.iter().any(|(pass, _)| pass != "downsample" && is_drawing(pass));
            assert!(told || times.is_empty(), "{transparency:?}: nobody knows what it costs: {times:?}");
            println!("{primitive:?} {transparency:?}: rmse {rmse:.4}, coverage {coverage:.3}");
            // Measured, and a third more.
            let most = match transparency {
                Transparency::FrontToBack | Transparency::Sorted | Transparency::HalfAngle => 0.0083,
                Transparency::Occupancy | Transparency::KNearest => 0.0107,
                Transparency::WeightedAverage | Transparency::DepthPeeling => 0.0130,
                Transparency::Stochastic => 0.053,
                Transparency::ThreeSubsets => 0.092,
                Transparency::AlphaTest | Transparency::Hashed => 0.146,
                Transparency::Opaque => 0.166,
                Transparency::AlphaToCoverage => 0.27,
            };
            assert!(rmse < most, "{primitive:?}, {transparency:?}: {rmse}");
            // What blends covers as much as it should; so does noise, on average.
            let is_unbiased = match transparency {
                Transparency::FrontToBack
                | Transparency::Sorted
                | Transparency::HalfAngle
                | Transparency::Occupancy
                | Transparency::KNearest
                | Transparency::WeightedAverage
                | Transparency::Stochastic
                | Transparency::Hashed => true,
                Transparency::Opaque
                | Transparency::AlphaTest
                | Transparency::AlphaToCoverage
                | Transparency::ThreeSubsets
                | Transparency::DepthPeeling => false,
            };
            assert!(!is_unbiased || (coverage - 1.0).abs() < 0.02, "{primitive:?}, {transparency:?}: {coverage}");
        }
    }
}

#[test]
fn peeling_enough_layers_is_exact_and_goes_on_no_longer_than_it_must() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    let mut groom = heap();
    groom.look.drawing.opacity = 0.3;
    groom.look.primitive = Primitive::Ribbons;
    let mut renderer = renderer_with(&gpu, &groom, Threads::for_gpu(&gpu));
    let (sorted, ..) = drawn(&mut renderer, &groom, &camera);
    groom.look.transparency = Transparency::DepthPeeling;
    let mut last = f64::INFINITY;
    for n_layers in [4, 16, 256] {
        groom.look.drawing.n_layers = n_layers;
        let (peeled, ..) = drawn(&mut renderer, &groom, &camera);
        let (rmse, _) = difference(&peeled, &sorted);
        println!("{n_layers} layers: {rmse:.5} from blending in order");
        assert!(rmse < 0.5 * last, "{n_layers}");
        last = rmse;
    }
    assert!(last < 0.002, "{last}");
}

#[test]
fn the_mean_of_many_seeds_of_stochastic_transparency_is_the_exact_composite() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    let mut groom = heap();
    let mut renderer = renderer_with(&gpu, &groom, Threads::for_gpu(&gpu));
    let size = [48, 48];
    let small = FrameInput { size, ..input(&camera) };
    let mut picture = |look: &dyn Fn(&mut Groom)| {
        look(&mut groom);
        renderer.set_groom(&groom).unwrap();
        renderer.render_pixels(&small).unwrap();
        hair(&renderer)
    };
    // The same fragments, composited one by one.
    let exact = picture(&|groom| {
        groom.look.transparency = Transparency::DepthPeeling;
        groom.look.drawing.n_layers = 256;
    });
    let mut mean = vec![[0.0; 4]; exact.len()];
    let mut first = 0.0;
    let n_seeds = 256;
    for seed in 0..n_seeds {
        let noisy = picture(&|groom| {
            groom.look.transparency = Transparency::Stochastic;
            groom.look.drawing.n_samples = 4;
            groom.look.drawing.seed = seed;
        });
        if seed == 0 {
            first = difference(&noisy, &exact).0;
        }
        for (mean, noisy) in mean.iter_mut().zip(&noisy) {
            for channel in 0..4 {
                mean[channel] += noisy[channel] / f64::from(n_seeds);
            }
        }
    }
    let (last, coverage) = difference(&mean, &exact);
    println!("one seed: {first:.5}; the mean of {n_seeds}: {last:.5}, coverage {coverage:.4}");
    // The square root of 256 is 16; colours have nine bits.
    assert!(last < first / 12.0 && (coverage - 1.0).abs() < 0.003, "{first}, {last}, {coverage}");
}

#[test]
fn the_better_the_antialiasing_the_nearer_the_exact_picture() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    let mut groom = heap();
    let mut renderer = renderer_with(&gpu, &groom, Threads::for_gpu(&gpu));
    let mut errors = Vec::new();
    for &antialiasing in Antialiasing::ALL {
        groom.look.antialiasing = antialiasing;
        let (_, rmse, coverage) = drawn(&mut renderer, &groom, &camera);
        println!("{antialiasing:?}: rmse {rmse:.4}, coverage {coverage:.3}");
        // Rounded to quarters, strands of a pixel that lie over each other are rounded alike.
        let most = if antialiasing == Antialiasing::AlphaToCoverage { 0.1 } else { 0.01 };
        assert!((coverage - 1.0).abs() < most, "{antialiasing:?}: {coverage}");
        errors.push((antialiasing, rmse));
    }
    let of = |antialiasing| errors.iter().find(|(choice, _)| *choice == antialiasing).unwrap().1;
    assert!(of(Antialiasing::None) > 1.3 * of(Antialiasing::Msaa4));
    assert!(of(Antialiasing::Msaa4) > 2.0 * of(Antialiasing::Analytic));
    assert!(of(Antialiasing::AlphaToCoverage) > 2.0 * of(Antialiasing::Analytic));
}

#[test]
fn the_compute_rasteriser_is_as_supersampled_ribbons_at_any_width() {
    /// Pixels drawn for one, along a side.
    const N: usize = 8;
    const SIDE: usize = 96;
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    for (n_strands, radius_um) in [(4_000, 40.0), (2_000, 200.0), (300, 1_500.0)] {
        let mut groom = sample_groom(n_strands, 12);
        groom.layers[0].radius_um = radius_um;
        for threads in every_threads(&gpu) {
            let mut renderer = renderer_with(&gpu, &groom, threads);
            let mut picture = |side: usize, groom: &Groom| {
                renderer.set_groom(groom).unwrap();
                renderer.render_pixels(&FrameInput { size: [side as u32; 2], ..input(&camera) }).unwrap();
                hair(&renderer)
            };
            groom.look.primitive = Primitive::Compute;
            groom.look.antialiasing = Antialiasing::Analytic;
            let compute = picture(SIDE, &groom);
            // Strips that cover a sample or do not, blended in order.
            groom.look.primitive = Primitive::Ribbons;
            groom.look.antialiasing = Antialiasing::None;
            let fine = picture(SIDE * N, &groom);
            let mut mean = vec![[0.0; 4]; SIDE * SIDE];
            for (at, pixel) in fine.iter().enumerate() {
                let (x, y) = (at % (SIDE * N) / N, at / (SIDE * N) / N);
                for channel in 0..4 {
                    mean[y * SIDE + x][channel] += pixel[channel] / (N * N) as f64;
                }
            }
            let (rmse, coverage) = difference(&compute, &mean);
            println!("{radius_um} um, {threads:?}: rmse {rmse:.4}, coverage {coverage:.3}");
            // 64 samples of a strand are off by their noise; strands side by side in a pixel are taken to lie over each
            // other by chance.
            assert!(rmse < 0.04 && (coverage - 1.0).abs() < 0.03, "{radius_um} um, {threads:?}: {rmse}, {coverage}");
        }
    }
}

#[test]
fn shading_a_fragment_is_shading_between_its_vertices_where_these_are_close() {
    let gpu = Gpu::headless().unwrap();
    let camera = camera();
    let mut groom = sample_groom(1_500, 24);
    let mut renderer = renderer_with(&gpu, &groom, Threads::for_gpu(&gpu));
    let (vertex, ..) = drawn(&mut renderer, &groom, &camera);
    for primitive in [Primitive::Compute, Primitive::Ribbons] {
        groom.look.primitive = primitive;
        groom.look.shading_rate = ShadingRate::PerFragment;
        let (fragment, ..) = drawn(&mut renderer, &groom, &camera);
        let (rmse, coverage) = difference(&fragment, &vertex);
        println!("{primitive:?}: {rmse:.5} apart");
        assert!(rmse > 1e-4 && rmse < 0.01 && (coverage - 1.0).abs() < 0.01, "{primitive:?}: {rmse}");
    }
}

#[test]
fn the_default_groom_is_drawn_as_the_exact_picture() {
    let gpu = Gpu::headless().unwrap();
    let groom = lorelei_assets::default_groom();
    assert!(groom.layers.iter().map(|layer| layer.n_strands).sum::<u32>() >= 100_000);
    // Seen so that it fills most of the picture.
    let camera = Camera { target: Vec3::new(0.0, -2.0, 0.0), azimuth_deg: 35.0, distance: 110.0, ..Camera::default() };
    for threads in every_threads(&gpu) {
        let mut renderer = renderer_with(&gpu, &groom, threads);
        renderer.render_pixels(&input(&camera)).unwrap();
        let hair = hair(&renderer);
        assert!(hair.iter().filter(|pixel| pixel[3] > 0.5).count() > 5_000);
        let (rmse, coverage) = difference(&hair, &exact_hair(&renderer, &camera));
        println!("default groom, {threads:?}: rmse {rmse:.5}, coverage {coverage:.4}");
        assert!(rmse < 0.02 && (coverage - 1.0).abs() < 0.01, "{threads:?}: {rmse}, {coverage}");
    }
}

#[test]
fn what_is_kept_from_frame_to_frame_is_what_would_be_made_again() {
    let mut groom = sample_groom(2_000, 16);
    let mut renderer = renderer(&groom);
    let from = |azimuth_deg| Camera { azimuth_deg, ..camera() };
    let is_close = |a: &Pixels, b: &Pixels| a.rgba.iter().zip(&b.rgba).all(|(a, b)| a.abs_diff(*b) <= 1);
    renderer.render_pixels(&input(&from(0.0))).unwrap();
    let kept = renderer.render_pixels(&input(&from(90.0))).unwrap();
    renderer.forget();
    let made_again = renderer.render_pixels(&input(&from(90.0))).unwrap();
    assert!(is_close(&kept, &made_again));
    // Whatever strands and shadows depend on: the picture is that of a renderer that has seen nothing else.
    let turned = Affine3A::from_rotation_y(0.7);
    type Change = (fn(&mut Groom), Affine3A, f32);
    let changes: [Change; 6] = [
        (|_| {}, turned, 1.0),
        (|_| {}, turned, 0.3),
        (|groom| groom.layers[0].radius_um = 200.0, turned, 0.3),
        (|groom| groom.lights[0].intensity *= 0.3, turned, 0.3),
        (|groom| groom.look.shadows.density = 0.2, turned, 0.3),
        (|groom| groom.head = None, turned, 0.3),
    ];
    let mut last = made_again;
    for (nr, (change, world_from_head, lod_scale)) in changes.into_iter().enumerate() {
        change(&mut groom);
        let camera = from(90.0);
        let input = FrameInput { world_from_head, lod_scale, ..input(&camera) };
        renderer.set_groom(&groom).unwrap();
        let next = renderer.render_pixels(&input).unwrap();
        let fresh = self::renderer(&groom).render_pixels(&input).unwrap();
        assert!(is_close(&next, &fresh), "change {nr}");
        assert!(!is_close(&next, &last), "change {nr} shows nothing");
        last = next;
    }
}

fn alpha_of(pixels: &Pixels) -> Vec<u8> {
    pixels.rgba.chunks_exact(4).map(|pixel| pixel[3]).collect()
}

#[test]
fn every_choice_of_drawing_changes_the_picture() {
    let base = sample_groom(3_000, 16);
    let mut renderer = renderer(&base);
    let camera = camera();
    let mut picture = |change: fn(&mut Groom)| {
        let mut groom = base.clone();
        groom.layers[0].radius_um = 100.0;
        change(&mut groom);
        renderer.set_groom(&groom).unwrap();
        renderer.render_pixels(&input(&camera)).unwrap()
    };
    let default = picture(|_| {});
    // Sums in a bucket are rounded in the order in which atomics filled it: one step of 255 at most.
    let again = picture(|_| {});
    let worst = default.rgba.iter().zip(&again.rgba).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(1), "a frame differs from itself by {worst:?}");
    let others = [
        picture(|groom| groom.look.transparency = Transparency::Opaque),
        picture(|groom| groom.look.head = HeadShading::Hidden),
        picture(|groom| groom.look.shadowing = Shadowing::Off),
        picture(|groom| groom.look.exposure = 1.0),
        picture(|groom| groom.look.tonemapping = lorelei_core::look::Tonemapping::Linear),
        picture(|groom| groom.look.background = Background::Plain),
        picture(|groom| groom.look.background = Background::Transparent),
    ];
    for (a, first) in others.iter().enumerate() {
        assert_ne!(*first, default, "choice {a}");
        assert!(others[a + 1..].iter().all(|second| first != second), "choice {a}");
    }
    assert!(alpha_of(&default).iter().all(|&alpha| alpha == 255));
    let cut_out = alpha_of(&others[6]);
    assert!(cut_out.contains(&0) && cut_out.contains(&255) && cut_out.iter().any(|a| (1..255).contains(a)));
}

#[test]
fn what_cannot_be_rendered_is_an_error() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let camera = camera();
    assert_eq!(renderer.render_pixels(&input(&camera)).unwrap_err(), RenderError::NoGroom);
    renderer.set_groom(&Groom::default()).unwrap();
    for size in [[0, 100], [1 << 20, 100]] {
        let error = renderer.render_pixels(&FrameInput { size, ..input(&camera) }).unwrap_err();
        assert!(matches!(error, RenderError::Size { .. }), "{error}");
    }
    // No head, no hair: the background alone, in a size that no tile divides.
    let pixels = renderer.render_pixels(&FrameInput { size: [101, 67], ..input(&camera) }).unwrap();
    assert_eq!(pixels.rgba.len(), 101 * 67 * 4);
}

#[test]
fn a_device_that_is_destroyed_is_an_error_and_not_a_panic() {
    let mut renderer = renderer(&sample_groom(100, 8));
    let camera = camera();
    renderer.render_pixels(&input(&camera)).unwrap();
    renderer.gpu.device.destroy();
    renderer.render_pixels(&input(&camera)).unwrap_err();
}

#[test]
fn neighbouring_levels_of_detail_look_alike() {
    let camera = camera();
    let mut groom = sample_groom(4000, 24);
    let mut renderer = renderer(&groom);
    let mut at = |level: f32| {
        groom.lod.choice = LodChoice::Level(level);
        renderer.set_groom(&groom).unwrap();
        renderer.render_pixels(&input(&camera)).unwrap()
    };
    let mut worst: f64 = 0.0;
    let mut before = at(0.0);
    for step in 1..=30 {
        let now = at(0.1 * step as f32);
        let squared = before.rgba.iter().zip(&now.rgba).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
        worst = worst.max((squared.sum::<f64>() / now.rgba.len() as f64).sqrt() / 255.0);
        before = now;
    }
    println!("a tenth of a level apart, pictures differ by {worst:.4} RMSE at most");
    // A tenth of a level is a second of walking away at the size where it begins.
    assert!(worst < 0.03, "{worst}");
}
