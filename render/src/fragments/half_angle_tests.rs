//! Slices of hair: the light that they leave against the exact reference, their order against sorted segments, and every
//! number of lights.

use glam::{Affine3A, DVec3, Vec4};
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::light::{Light, LightKind};
use lorelei_core::look::view::ramp;
use lorelei_core::look::{Environment, Shadowing, Transparency};

use super::*;
use crate::renderer::Renderer;
use crate::sample::sample_groom;
use crate::shadow::exact::{ExactShadow, Occluders};
use crate::{FrameInput, Pixels};

const SIZE: [u32; 2] = [160, 160];

fn groom() -> Groom {
    let mut groom = sample_groom(6_000, 16);
    groom.layers[0].radius_um = 50.0;
    groom.look.transparency = Transparency::HalfAngle;
    groom
}

fn camera() -> Camera {
    Camera { target: Vec3::new(0.0, -6.0, 0.0), distance: 110.0, ..Camera::default() }
}

fn render(renderer: &mut Renderer, groom: &Groom) -> Pixels {
    renderer.set_groom(groom).unwrap();
    let camera = camera();
    let world_from_head = Affine3A::IDENTITY;
    let input = FrameInput { camera: &camera, size: SIZE, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
    renderer.render_pixels(&input).unwrap()
}

fn renderer() -> Renderer {
    Renderer::new(&Gpu::headless().unwrap(), ShaderLibrary::embedded()).unwrap()
}

fn key(azimuth_deg: f32) -> Light {
    Light::directional("key", azimuth_deg, 30.0, 1.0, [1.0; 3])
}

/// The share that a linear colour of the ramp stands for: its green grows all the way.
fn share_of(green: f64) -> f64 {
    let encoded = if green <= 0.003_130_8 { 12.92 * green } else { 1.055 * green.powf(1.0 / 2.4) - 0.055 };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if f64::from(ramp(middle as f32)[1]) < encoded { low = middle } else { high = middle }
    }
    low
}

/// Half float from its bits; the numbers here are not negative.
fn half(bits: u32) -> f64 {
    let (exponent, mantissa) = ((bits >> 10 & 31) as i32, f64::from(bits & 1023));
    if exponent == 0 { mantissa * 2f64.powi(-24) } else { (1.0 + mantissa / 1024.0) * 2f64.powi(exponent - 15) }
}

#[test]
fn the_light_that_slices_leave_is_the_exact_one_the_nearer_the_more_there_are() {
    let mut renderer = renderer();
    let mut groom = groom();
    groom.head = None;
    groom.look.view = FalseColour::Transmittance;
    groom.look.view_params.light = 1;
    // A light before the hair, one behind it (the slices go the other way), and one at a place.
    let lamp = Light { kind: LightKind::Point { position: Vec3::new(80.0, 60.0, 120.0) }, ..key(0.0) };
    for light in [key(40.0), key(150.0), lamp] {
        groom.lights = vec![light];
        let (mut errors, mut biases) = (Vec::new(), Vec::new());
        let mut exact: Vec<(usize, f64)> = Vec::new();
        for n_slices in [16, 64, 256] {
            groom.look.drawing.n_slices = n_slices;
            render(&mut renderer, &groom);
            let strands = renderer.generator.strands();
            let n = strands.n_vertices as usize;
            if exact.is_empty() {
                let vertices: Vec<[f32; 4]> = renderer.gpu.read_buffer(&strands.vertices).unwrap();
                let vertices: Vec<Vec4> = vertices[..n].iter().map(|v| Vec4::from_array(*v)).collect();
                let n_per_strand = strands.layers[0].vertices_per_strand as usize;
                let occluders = Occluders { vertices: &vertices, vertices_per_strand: n_per_strand };
                let lights = SceneLights::new(&groom.lights);
                let middle = Ball::of_groom(&groom).centre.as_dvec3();
                let shadow = ExactShadow::new(&[occluders], &lights.lights[0], middle, 0.1);
                // A stride that takes all parts of the strands alike.
                exact = (0..n)
                    .step_by(37)
                    .map(|at| {
                        let strand_idx = (at / n_per_strand) as u32;
                        let place = DVec3::from(vertices[at].truncate());
                        (at, (-shadow.optical_depth(place, Some(strand_idx), 0.1)).exp())
                    })
                    .collect();
            }
            let painted: Vec<[u32; 2]> = renderer.gpu.read_buffer(renderer.shade.radiance()).unwrap();
            let apart = |&(at, exact): &(usize, f64)| share_of(half(painted[at][0] >> 16)) - exact;
            errors.push(exact.iter().map(|of| apart(of).abs()).sum::<f64>() / exact.len() as f64);
            biases.push(exact.iter().map(apart).sum::<f64>() / exact.len() as f64);
        }
        let mean = exact.iter().map(|(_, left)| left).sum::<f64>() / exact.len() as f64;
        println!(
            "{:?}: {mean:.3} of the light is left; off by {errors:.4?}, {biases:.4?} too bright",
            groom.lights[0].kind
        );
        assert!((0.05..0.9).contains(&mean), "{mean}");
        // Hair of a slice does not shadow itself: too bright, and less so the thinner the slices. What is left in the end is
        // a strand's own shadow on itself, which the exact answer leaves out.
        assert!(errors[1] < 0.8 * errors[0] && errors[2] < 0.8 * errors[0], "{errors:?}");
        assert!(biases[1] < biases[0] && biases[2] < biases[1], "{biases:?}");
        assert!(errors[0] < 0.1 && errors[2] < 0.06, "{errors:?}");
    }
}

fn rmse(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let squares: f64 = a.iter().zip(b).flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).powi(2))).sum();
    (squares / (4 * a.len()) as f64).sqrt()
}

#[test]
fn slices_blend_as_sorted_segments_do_whichever_way_they_go() {
    let mut renderer = renderer();
    let mut groom = groom();
    // Colours that do not come from the slices: what is left is their order.
    groom.look.view = FalseColour::Strand;
    for lights in [vec![], vec![key(0.0)], vec![key(60.0)], vec![key(140.0)], vec![key(180.0)]] {
        groom.lights = lights;
        let mut hair = [Transparency::HalfAngle, Transparency::Sorted, Transparency::WeightedAverage].map(|choice| {
            groom.look.transparency = choice;
            render(&mut renderer, &groom);
            renderer.read_hair().unwrap()
        });
        let [sliced, sorted, unordered] = &mut hair;
        let (apart, without_order) = (rmse(sliced, sorted), rmse(unordered, sorted));
        println!("{:?}: {apart:.5}, without any order {without_order:.5}", groom.lights.first().map(|l| &l.kind));
        // Segments are sorted by their middles: along a slanted vector they come in another order now and then.
        assert!(apart < 0.3 * without_order, "{apart} of {without_order}");
    }
}

#[test]
fn any_number_of_lights_draws_at_either_rate_beside_any_sort_of_shadow() {
    let mut renderer = renderer();
    let mut groom = sample_groom(3_000, 8);
    groom.layers[0].radius_um = 150.0;
    groom.look.transparency = Transparency::HalfAngle;
    groom.look.drawing.n_slices = 16;
    let rect = Light::rect_from_watts("soft", Vec3::new(60.0, 40.0, 90.0), Vec3::ZERO, 40.0, 40.0);
    let off = Light { on: false, ..key(10.0) };
    let shadowless = Light { casts_shadow: false, ..key(20.0) };
    let settings: [Vec<Light>; 5] = [
        vec![],
        vec![off, shadowless.clone()],
        vec![key(40.0)],
        vec![shadowless, rect.clone()],
        vec![rect, key(170.0)],
    ];
    let draws = |renderer: &mut Renderer, groom: &Groom| {
        render(renderer, groom);
        let covered = renderer.read_hair().unwrap().iter().filter(|pixel| pixel[3] > 0.5).count();
        assert!(covered > 500, "{covered}");
    };
    for lights in settings {
        groom.lights = lights;
        draws(&mut renderer, &groom);
    }
    groom.look.shading_rate = ShadingRate::PerFragment;
    for lights in [vec![], vec![key(40.0)]] {
        groom.lights = lights;
        draws(&mut renderer, &groom);
    }
    (groom.look.shading_rate, groom.look.primitive) = (ShadingRate::PerVertex, Primitive::Polylines);
    draws(&mut renderer, &groom);
    // Maps, a grid, and nothing.
    for shadowing in [Shadowing::Occupancy, Shadowing::Voxels, Shadowing::Off] {
        groom.look.shadowing = shadowing;
        draws(&mut renderer, &groom);
    }
    renderer.gpu.take_error().unwrap();
}

#[test]
fn a_light_shines_through_slices_by_its_number_and_the_next_where_it_cannot() {
    let rect = Light::rect_from_watts("soft", Vec3::new(60.0, 40.0, 90.0), Vec3::ZERO, 40.0, 40.0);
    let off = Light { on: false, ..key(10.0) };
    let shadowless = Light { casts_shadow: false, ..key(20.0) };
    let lights = SceneLights::new(&[shadowless, rect, off, key(0.0)]);
    assert_eq!(lights.of_light, [0, 1, 1, 1, 1, 3]);
    assert_eq!([1, 2, 3, 4, 9].map(|number| light_of_slices(&lights, number)), [1..5, 1..5, 5..6, 5..6, 1..5]);
    assert_eq!(light_of_slices(&SceneLights::default(), 1), 0..0);
}

#[test]
fn the_light_of_the_slices_is_lost_in_them_and_that_of_others_in_their_shadow_maps() {
    let mut renderer = renderer();
    let mut groom = groom();
    groom.head = None;
    groom.look.environment = Environment::Off;
    groom.lights = vec![key(40.0)];
    let mut light = |change: &dyn Fn(&mut Groom)| {
        change(&mut groom);
        render(&mut renderer, &groom);
        renderer.read_hair().unwrap().iter().map(|pixel| pixel[1]).sum::<f64>()
    };
    let sliced = light(&|_| {});
    let mapped = light(&|groom| groom.look.transparency = Transparency::Sorted);
    let unshadowed = light(&|groom| groom.look.shadowing = Shadowing::Off);
    let sliced_beside_off = light(&|groom| groom.look.transparency = Transparency::HalfAngle);
    println!("slices {sliced:.1} and {sliced_beside_off:.1}, maps {mapped:.1}, without shadows {unshadowed:.1}");
    // The slices' own shadow, whatever the others have.
    assert!((sliced / sliced_beside_off - 1.0).abs() < 0.01);
    assert!((sliced / mapped - 1.0).abs() < 0.35 && sliced < 0.9 * unshadowed);
}
