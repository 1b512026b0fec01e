//! False colours reach the display as the CPU names them.

use std::sync::Arc;

use glam::Affine3A;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Layer, Source};
use lorelei_core::light::Light;
use lorelei_core::look::view::part_colour;
use lorelei_core::look::{Background, LayerSpacing, ShadowParams, Transparency};
use lorelei_core::strands::Strands;

use super::*;
use crate::scene::Ball;
use crate::{FrameInput, Renderer};

const SIZE: [u32; 2] = [128, 64];

/// Two straight strands of 8 mm width along x, one above the other, in layers of their own.
fn groom() -> Groom {
    let layer = |y: f32| {
        let mut strands = Strands::default();
        strands.push(&(0..8).map(|k| Vec3::new(k as f32 * 2.0 - 7.0, y, 0.0)).collect::<Vec<_>>());
        Layer { radius_um: 4000.0, tip_radius: 1.0, ..Layer::from_strands("hair", strands) }
    };
    let mut groom = Groom { layers: vec![layer(2.0), layer(-2.0)], ..Groom::default() };
    groom.look.background = Background::Plain;
    groom
}

/// Display colours of the middles of the two strands, 0-1.
fn shown(groom: &Groom, renderer: &mut Renderer) -> [[f32; 3]; 2] {
    renderer.set_groom(groom).unwrap();
    let camera = Camera { azimuth_deg: 0.0, elevation_deg: 0.0, distance: 30.0, ..Camera::default() };
    let world_from_head = Affine3A::IDENTITY;
    let input = FrameInput { camera: &camera, size: SIZE, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
    let pixels = renderer.render_pixels(&input).unwrap();
    [2.0, -2.0].map(|y: f32| {
        let per_cm = 0.5 * SIZE[1] as f32 / (30.0 * 12f32.to_radians().tan());
        let row = (0.5 * SIZE[1] as f32 - y * per_cm) as u32;
        let at = 4 * (row * SIZE[0] + SIZE[0] / 2) as usize;
        [0, 1, 2].map(|channel| f32::from(pixels.rgba[at + channel]) / 255.0)
    })
}

fn is_near(a: [f32; 3], b: [f32; 3]) -> bool {
    // Half floats of light, eight bits, and the dither between them.
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.012)
}

#[test]
fn every_view_of_strands_shows_the_colours_that_the_cpu_names() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = groom();
    // Lamps and exposure have no say in false colours.
    groom.look.exposure = 2.0;
    groom.look.white_balance.temperature_k = 3000.0;
    groom.look.shadowing = Shadowing::Off;
    renderer.set_groom(&groom).unwrap();
    let bindings: Vec<Arc<LayerBinding>> =
        (0..2).map(|layer_idx| Arc::clone(renderer.mirror().binding(layer_idx).unwrap())).collect();
    for view in [
        FalseColour::RootUv,
        FalseColour::Strand,
        FalseColour::Group,
        FalseColour::Guides,
        FalseColour::Lod,
        FalseColour::Clump,
    ] {
        groom.look.view = view;
        for (layer_idx, got) in shown(&groom, &mut renderer).into_iter().enumerate() {
            let expected = strand_colours(view, &bindings[layer_idx], layer_idx).unwrap()[0];
            assert!(is_near(got, expected), "{view:?} of layer {layer_idx}: {got:?} for {expected:?}");
        }
    }
    groom.look.view = FalseColour::Tangent;
    let [got, _] = shown(&groom, &mut renderer);
    assert!(is_near(got, direction_colour(Vec3::X)), "a strand along x: {got:?}");
    groom.look.view = FalseColour::Transmittance;
    let [got, _] = shown(&groom, &mut renderer);
    assert!(is_near(got, ramp(1.0)), "all light arrives where nothing casts a shadow: {got:?}");
    groom.look.view = FalseColour::Coverage;
    let [got, _] = shown(&groom, &mut renderer);
    assert!(is_near(got, ramp(1.0)), "a strand wider than a pixel hides it: {got:?}");
    groom.look.view = FalseColour::Normals;
    let [got, _] = shown(&groom, &mut renderer);
    let background = [groom.look.background_grey; 3];
    assert!(is_near(got, background), "without a head there are no normals, and no hair: {got:?}");
}

#[test]
fn strands_that_lie_over_each_other_are_counted() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = groom();
    let Source::Strands(one) = groom.layers[0].source.clone() else { panic!("it was made of strands") };
    let mut five = Strands::default();
    for depth in 0..5 {
        let points: Vec<Vec3> = one.points.iter().map(|&p| p - 0.2 * Vec3::Z * depth as f32).collect();
        five.push(&points);
    }
    groom.layers[0].source = Source::Strands(Arc::new(five));
    groom.look.view_params.most = 10.0;
    for view in [FalseColour::Overdraw, FalseColour::Depth] {
        groom.look.view = view;
        let [five, one] = shown(&groom, &mut renderer);
        assert!(is_near(five, ramp(0.5)), "{view:?}: five of ten are {five:?}");
        assert!(is_near(one, ramp(0.1)), "{view:?}: one of ten is {one:?}");
    }
}

#[test]
fn layers_of_every_shadow_technique_are_told_apart() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = groom();
    // The lamp is behind; each strand that is seen has another 2.5 cm behind it.
    for layer in &mut groom.layers {
        let Source::Strands(one) = layer.source.clone() else { panic!("it was made of strands") };
        let mut two = (*one).clone();
        two.push(&one.points.iter().map(|&p| p - 2.5 * Vec3::Z).collect::<Vec<_>>());
        layer.source = Source::Strands(Arc::new(two));
    }
    groom.lights = vec![Light::directional("rim", 180.0, 0.0, 1.0, [1.0; 3])];
    groom.look.view = FalseColour::ShadowLayer;
    groom.look.shadows = ShadowParams {
        n_layers: 5,
        layer_size: 1.0,
        layer_spacing: LayerSpacing::Constant,
        n_slices: 8,
        resolution: 256,
        ..ShadowParams::default()
    };
    let ball = Ball::of_groom(&groom);
    let slice = ((ball.radius - ball.centre.z) / (2.0 * ball.radius) * 8.0) as u32;
    // From the lamp, the strands are 2.5 cm behind the front; and the last of two.
    for (shadowing, part) in [
        (Shadowing::DeepOpacity, Some((2, 5))),
        (Shadowing::OpacityMaps, Some((slice, 8))),
        (Shadowing::Clusters, Some((3, 4))),
        (Shadowing::Occupancy, Some((3, 4))),
        (Shadowing::Off, None),
        (Shadowing::ShadowMap, None),
        (Shadowing::DeepShadow, None),
        (Shadowing::Voxels, None),
    ] {
        groom.look.shadowing = shadowing;
        groom.look.view_params.layer = 0;
        let [got, _] = shown(&groom, &mut renderer);
        let expected = part.map_or(NO_COLOUR, |(part, n)| part_colour(part, n));
        assert!(is_near(got, expected), "{shadowing:?}: {got:?} for {expected:?}");
        let Some((part, _)) = part else { continue };
        // Strands as wide as these let hardly anything through.
        groom.look.view_params.layer = part + 1;
        let [got, _] = shown(&groom, &mut renderer);
        let apart = got.iter().zip(ramp(1.0)).map(|(got, expected)| (got - expected).abs()).fold(0.0, f32::max);
        assert!(apart < 0.05, "{shadowing:?}, its own layer alone: {got:?}");
        groom.look.view_params.layer = part;
        let [got, _] = shown(&groom, &mut renderer);
        assert!(is_near(got, NO_COLOUR), "{shadowing:?}, another layer alone: {got:?}");
    }
    // Two strands are two slices.
    groom.look.transparency = Transparency::HalfAngle;
    groom.look.view_params.layer = 0;
    groom.layers.truncate(1);
    groom.look.drawing.n_slices = 2;
    let [got, _] = shown(&groom, &mut renderer);
    assert!(is_near(got, part_colour(1, 2)), "half-angle: {got:?}");
}
