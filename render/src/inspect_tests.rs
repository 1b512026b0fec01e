//! What the inspector tells is what the frame was made of.

use glam::{Affine3A, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::look::{Scattering, set};
use lorelei_shaders::{Gpu, ShaderLibrary};

use super::*;
use crate::sample::sample_groom;
use crate::{FrameInput, Pixels, Renderer};

const SIZE: [u32; 2] = [96, 96];

fn largest(rgb: [f32; 3]) -> f32 {
    rgb.into_iter().fold(0.0, f32::max)
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    (Vec3::from_array(a) - Vec3::from_array(b)).abs().max_element()
}

fn sum<'a>(parts: impl Iterator<Item = &'a [f32; 3]>) -> [f32; 3] {
    parts.fold(Vec3::ZERO, |sum, part| sum + Vec3::from_array(*part)).to_array()
}

/// A pixel that hair hides almost wholly.
fn covered_pixel(renderer: &mut Renderer, pixels: &Pixels) -> Inspection {
    let middle = SIZE[0] / 2;
    for y in 0..pixels.size[1] {
        let found = renderer.inspect([middle, y]).unwrap().unwrap();
        if found.hair[3] > 0.9 && found.strand.is_some() {
            return found;
        }
    }
    panic!("no pixel of the middle column is covered by hair");
}

#[test]
fn terms_and_lamps_add_up_to_what_the_frame_was_shaded_with() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = sample_groom(4_000, 16);
    groom.layers[0].radius_um = 300.0;
    set(&mut groom.look.slots(), "shadowing.resolution", "256").unwrap();
    for scattering in [Scattering::Marschner, Scattering::KajiyaKay] {
        groom.look.scattering = scattering;
        renderer.set_groom(&groom).unwrap();
        let camera = Camera { target: Vec3::new(0.0, -2.0, 0.0), distance: 80.0, ..Camera::default() };
        let world_from_head = Affine3A::IDENTITY;
        let input =
            FrameInput { camera: &camera, size: SIZE, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
        let pixels = renderer.render_pixels(&input).unwrap();
        let found = covered_pixel(&mut renderer, &pixels);
        let at = 4 * (found.pixel[1] * SIZE[0] + found.pixel[0]) as usize;
        for channel in 0..3 {
            let shown = f32::from(pixels.rgba[at + channel]) / 255.0;
            assert!((shown - found.display[channel]).abs() < 0.01, "{found:?}");
        }
        let strand = found.strand.unwrap();
        let total = strand.radiance;
        assert!(largest(total) > 0.01, "{strand:?}");
        let terms = sum(strand.terms.iter().map(|(_, rgb)| rgb));
        assert!(apart(terms, total) < 0.01 * largest(total), "{scattering:?}: {:?} of {total:?}", strand.terms);
        let lobes = strand.terms.iter().filter(|(name, _)| name.ends_with("lobe")).count();
        assert_eq!(lobes > 0, scattering == Scattering::Marschner, "{:?}", strand.terms);
        // Lamps light the hair past what shadows it; the rest is the environment.
        let environment = strand.terms.iter().find(|(name, _)| *name == "Environment").unwrap().1;
        let lamps = sum(strand.lights.iter().map(|light| &light.radiance).chain([&environment]));
        assert!(apart(lamps, total) < 0.01 * largest(total), "{:?} of {total:?}", strand.lights);
        assert!(strand.lights.iter().all(|light| light.hair_depth >= 0.0 && (0.0..=1.0).contains(&light.past_head)));
        // The vertices around the place were shaded alike.
        let strands = renderer.generator.strands();
        let packed: Vec<[u16; 4]> = gpu.read_buffer(renderer.shade.radiance()).unwrap();
        let layer = strands.layers[0];
        let last = layer.vertices_per_strand - 1;
        let segment = ((strand.along * last as f32) as u32).min(last - 1);
        let vertex = (layer.first_vertex + strand.strand_idx * layer.vertices_per_strand + segment) as usize;
        let radiance =
            |vertex: usize| Vec3::from_array([0, 1, 2].map(|c| half::f16::from_bits(packed[vertex][c]).to_f32()));
        let (a, b) = (radiance(vertex), radiance(vertex + 1));
        let slack = 0.15 * a.max(b).max_element();
        let total = Vec3::from_array(total);
        assert!(
            total.cmpge(a.min(b) - slack).all() && total.cmple(a.max(b) + slack).all(),
            "{total} between {a} and {b}"
        );
    }
}

#[test]
fn beside_the_hair_there_is_no_strand() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    assert_eq!(renderer.inspect([0, 0]).unwrap(), None);
    renderer.set_groom(&sample_groom(200, 8)).unwrap();
    let camera = Camera { distance: 120.0, ..Camera::default() };
    let world_from_head = Affine3A::IDENTITY;
    let input = FrameInput { camera: &camera, size: SIZE, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
    renderer.render_pixels(&input).unwrap();
    let corner = renderer.inspect([0, 0]).unwrap().unwrap();
    assert_eq!((corner.strand, corner.hair), (None, [0.0; 4]));
    assert_eq!(renderer.inspect(SIZE).unwrap(), None);
}
