//! Pictures, shadows and grooms as large as a device holds and larger: made, or refused in words that say what to do, and
//! never an error of the GPU. Frames are recorded and not drawn: by then everything was made and bound.

use glam::Affine3A;
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::look::{Antialiasing, Choice, Primitive, Shadowing, Transparency};
use lorelei_shaders::{Gpu, GpuError, ShaderLibrary};

use super::{FrameInput, RenderError, Renderer};
use crate::sample::sample_groom;

const EIGHT_K: [u32; 2] = [7680, 4320];
const FOUR_K: [u32; 2] = [3840, 2160];
const SMALL: [u32; 2] = [64, 48];

fn record(gpu: &Gpu, renderer: &mut Renderer, groom: &Groom, size: [u32; 2]) -> Result<(), RenderError> {
    let camera = Camera { distance: 110.0, ..Camera::default() };
    let world_from_head = Affine3A::IDENTITY;
    let input = FrameInput { camera: &camera, size, world_from_head, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
    gpu.checked(|| {
        renderer.set_groom(groom)?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.render(&mut encoder, &input)?;
        encoder.finish();
        Ok(())
    })?
}

/// That a frame is recorded, or refused by somebody who knows why.
fn check(what: &str, result: &Result<(), RenderError>) {
    match result {
        Ok(())
        | Err(
            RenderError::Size { .. }
            | RenderError::TooManyTiles(_)
            | RenderError::TooManyVertices(_)
            | RenderError::TooManyTriangles(_)
            | RenderError::TooWide(_)
            | RenderError::Strands(_)
            | RenderError::Gpu(GpuError::OutOfMemory),
        ) => {}
        Err(error @ (RenderError::Gpu(_) | RenderError::Shader(_) | RenderError::NoGroom)) => panic!("{what}: {error}"),
    }
}

#[test]
fn large_pictures_are_drawn_by_every_transparency_or_refused() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = sample_groom(40, 8);
    let mut n_refused = 0;
    for (size, antialiasing) in
        [(FOUR_K, Antialiasing::Analytic), (FOUR_K, Antialiasing::Super3), (EIGHT_K, Antialiasing::Super3)]
    {
        for &transparency in Transparency::ALL {
            (groom.look.antialiasing, groom.look.transparency) = (antialiasing, transparency);
            let result = record(&gpu, &mut renderer, &groom, size);
            check(&format!("{size:?}, {antialiasing:?}, {transparency:?}"), &result);
            assert!(antialiasing == Antialiasing::Super3 || result.is_ok(), "{transparency:?} draws at 4K: {result:?}");
            n_refused += u32::from(result.is_err());
        }
    }
    // After a frame that does not fit, one that does is drawn.
    assert!(n_refused > 0);
    groom.look.transparency = Transparency::FrontToBack;
    record(&gpu, &mut renderer, &groom, SMALL).unwrap();
}

#[test]
fn shadows_of_any_size_are_made_to_fit() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    let mut groom = sample_groom(2_000, 8);
    let shadows = &mut groom.look.shadows;
    (shadows.resolution, shadows.n_strands, shadows.n_layers, shadows.n_slices) = (4096, 4_000_000, 15, 256);
    (shadows.n_voxels, shadows.n_steps) = (192, 256);
    for &shadowing in Shadowing::ALL {
        groom.look.shadowing = shadowing;
        record(&gpu, &mut renderer, &groom, SMALL).unwrap_or_else(|why| panic!("{shadowing:?}: {why}"));
    }
}

#[test]
fn as_many_strands_as_a_device_holds_are_drawn_by_every_technique() {
    let gpu = Gpu::headless().unwrap();
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).unwrap();
    // A vertex is 16 bytes.
    let most = (gpu.max_storage_binding() / 16).min(1 << 23) as u32;
    let vertices_per_strand = 128;
    let mut groom = sample_groom(most / vertices_per_strand, vertices_per_strand);
    for (primitive, transparency) in [Primitive::Compute, Primitive::Ribbons, Primitive::Polylines]
        .into_iter()
        .flat_map(|primitive| Transparency::ALL.iter().map(move |&transparency| (primitive, transparency)))
    {
        (groom.look.primitive, groom.look.transparency) = (primitive, transparency);
        let what = format!("{most} vertices, {primitive:?}, {transparency:?}");
        record(&gpu, &mut renderer, &groom, SMALL).unwrap_or_else(|why| panic!("{what}: {why}"));
    }
    for &shadowing in Shadowing::ALL {
        groom.look.shadowing = shadowing;
        record(&gpu, &mut renderer, &groom, SMALL)
            .unwrap_or_else(|why| panic!("{most} vertices, {shadowing:?}: {why}"));
    }
    // One strand more, and they are thinned.
    groom.layers[0].n_strands += 1;
    record(&gpu, &mut renderer, &groom, SMALL).unwrap();
}
