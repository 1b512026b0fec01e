//! Whole looks: every pair of choices of two slots in one picture at least, drawn without an error, finite, with the hair
//! that there is, and the same again.

use std::fmt::Write as _;

use glam::{Affine3A, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::look::{Choice, FalseColour, HeadShading, Transparency};
use lorelei_render::{FrameInput, Pixels, RenderError, Renderer};
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_tests::covering::covering;
use lorelei_tests::golden::cases::slots;
use lorelei_tests::golden::groom::groom;

/// No multiple of a tile, of a workgroup or of a row's alignment.
const SIZE: [u32; 2] = [45, 37];

/// The groom of the golden images with few strands, and with every technique as coarse as it goes.
fn small_groom() -> Groom {
    let mut groom = groom();
    groom.layers[0].n_strands = 300;
    groom.layers[0].vertices_per_strand = 8;
    groom.layers[0].radius_um = 900.0;
    let shadows = &mut groom.look.shadows;
    (shadows.resolution, shadows.n_strands, shadows.n_voxels, shadows.n_steps) = (128, 1_000, 16, 8);
    groom.look.drawing.n_layers = 6;
    groom
}

/// The groom with a choice in each slot.
fn with_choices(base: &Groom, row: &[usize]) -> Groom {
    let mut groom = base.clone();
    let Groom { look, layers, .. } = &mut groom;
    for (slot, &choice_idx) in slots(look, &mut layers[0].material).iter_mut().zip(row) {
        slot.choice.set_index(choice_idx);
    }
    groom
}

/// What repeats a look: the choices that are not as in a new groom, as `lorelei render` takes them.
fn as_options(base: &Groom, row: &[usize]) -> String {
    let (mut now, mut before) = (with_choices(base, row), base.clone());
    let before = slots(&mut before.look, &mut before.layers[0].material)
        .iter()
        .map(|slot| slot.chosen().name)
        .collect::<Vec<_>>();
    let mut text = String::from("--set");
    for (slot, before) in slots(&mut now.look, &mut now.layers[0].material).iter().zip(before) {
        if slot.chosen().name != before {
            write!(text, " {}={}", slot.key, slot.chosen().name).unwrap();
        }
    }
    text
}

/// Rows of choices with every pair. Where false colours are shown, pairs of two other slots are not seen: they are all
/// in rows with light.
fn rows(base: &Groom) -> Vec<Vec<usize>> {
    let mut groom = base.clone();
    let slots = slots(&mut groom.look, &mut groom.layers[0].material);
    let mut n_choices: Vec<usize> = slots.iter().map(|slot| slot.choice.infos().len()).collect();
    let view = slots.iter().position(|slot| slot.key == "view").unwrap();
    let n_views = std::mem::replace(&mut n_choices[view], 1);
    let mut rows = covering(&n_choices);
    let n_most = n_choices.iter().copied().max().unwrap_or(1);
    for view_idx in 1..n_views {
        // Turned from view to view, so that the rows are not the same looks again.
        rows.extend((0..n_most).map(|k| {
            let choice = |(slot, &n): (usize, &usize)| if slot == view { view_idx } else { (k + slot * view_idx) % n };
            n_choices.iter().enumerate().map(choice).collect::<Vec<usize>>()
        }));
    }
    rows
}

fn input(camera: &Camera, size: [u32; 2]) -> FrameInput<'_> {
    FrameInput { camera, size, world_from_head: Affine3A::IDENTITY, moved: &[], moved_stamp: 0, lod_scale: 1.0 }
}

fn camera() -> Camera {
    Camera { target: Vec3::new(0.0, 1.0, 0.0), distance: 80.0, ..Camera::default() }
}

/// What a look promises about the share of the picture that hair covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Coverage {
    /// As the reference's, whatever draws it.
    Right,
    /// What lies behind the last layer is left out.
    Short,
    /// Strands are drawn opaque or not at all: wider or thinner than they are.
    Off,
}

fn promised(transparency: Transparency) -> Coverage {
    match transparency {
        Transparency::FrontToBack
        | Transparency::Stochastic
        | Transparency::WeightedAverage
        | Transparency::Sorted
        | Transparency::HalfAngle
        | Transparency::Occupancy
        | Transparency::KNearest => Coverage::Right,
        Transparency::DepthPeeling => Coverage::Short,
        Transparency::Opaque
        | Transparency::AlphaTest
        | Transparency::Hashed
        | Transparency::AlphaToCoverage
        | Transparency::ThreeSubsets => Coverage::Off,
    }
}

/// A picture of a groom, and the share of it that hair covers; or what is wrong with it.
fn drawn(gpu: &Gpu, renderer: &mut Renderer, groom: &Groom) -> Result<(Pixels, f64), String> {
    let camera = camera();
    let pixels = gpu.checked(|| -> Result<Pixels, RenderError> {
        renderer.set_groom(groom)?;
        renderer.forget();
        renderer.render_pixels(&input(&camera, SIZE))
    });
    let pixels = pixels.map_err(|why| why.to_string())?.map_err(|why| why.to_string())?;
    gpu.take_error().map_err(|why| why.to_string())?;
    let hair = renderer.read_hair().map_err(|why| why.to_string())?;
    let is_light = |pixel: &[f64; 4]| pixel.iter().all(|value| value.is_finite() && *value >= 0.0) && pixel[3] < 1.001;
    if let Some(at) = hair.iter().position(|pixel| !is_light(pixel)) {
        return Err(format!("pixel {at} of the hair is {:?}", hair[at]));
    }
    // A body without hair is what is shown there.
    let has_nothing = groom.look.view == FalseColour::Normals && groom.look.head == HeadShading::Hidden;
    if !has_nothing && pixels.rgba.chunks_exact(4).all(|pixel| *pixel == pixels.rgba[..4]) {
        return Err("the picture is empty".to_owned());
    }
    Ok((pixels, hair.iter().map(|pixel| pixel[3]).sum::<f64>() / hair.len() as f64))
}

/// What is wrong with one look: all but the first is asked of a picture that was drawn.
fn fault(gpu: &Gpu, renderer: &mut Renderer, groom: &Groom, reference: f64) -> Option<String> {
    let first = drawn(gpu, renderer, groom);
    let (first, coverage) = match first {
        Ok(drawn) => drawn,
        Err(why) => return Some(why),
    };
    let within = match promised(groom.look.transparency) {
        Coverage::Right => 0.75..1.25,
        Coverage::Short => 0.4..1.25,
        Coverage::Off => 0.15..2.5,
    };
    if !within.contains(&(coverage / reference)) {
        return Some(format!("hair covers {coverage:.4} of the picture, and {reference:.4} of it is right"));
    }
    // Chance comes from a seed everywhere, so that even what is noisy is the same picture again.
    match drawn(gpu, renderer, groom) {
        Ok((again, _)) => (again != first).then(|| "another picture the second time".to_owned()),
        Err(why) => Some(format!("the second time: {why}")),
    }
}

#[test]
fn every_two_choices_of_the_look_draw_a_picture_together() {
    let gpu = Gpu::headless().unwrap();
    let base = small_groom();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut coverage_with = |head: HeadShading| {
        let mut groom = base.clone();
        groom.look.head = head;
        drawn(&gpu, &mut renderer, &groom).unwrap().1
    };
    let references = HeadShading::ALL.iter().map(|&head| (head, coverage_with(head))).collect::<Vec<_>>();
    assert!(references.iter().all(|(_, coverage)| (0.05..0.5).contains(coverage)), "{references:?}");
    let rows = rows(&base);
    let mut wrong = Vec::new();
    for row in &rows {
        let groom = with_choices(&base, row);
        let reference = references.iter().find(|(head, _)| *head == groom.look.head).unwrap().1;
        if let Some(why) = fault(&gpu, &mut renderer, &groom, reference) {
            wrong.push(format!("{}\n    {why}", as_options(&base, row)));
        }
    }
    assert!(wrong.is_empty(), "{} of {} looks:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}
