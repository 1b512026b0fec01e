//! GPU time of each pass for the sample groom, as a table; and the picture, as a PPM file.
//!
//! `frame_times [STRANDS] [VERTICES] [WIDTH] [HEIGHT] [compute|ribbons] [FRAMES] [PICTURE.ppm]`

use std::collections::BTreeMap;
use std::time::Instant;

use glam::{Affine3A, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::look::Primitive;
use lorelei_render::sample::sample_groom;
use lorelei_render::{FrameInput, Renderer};
use lorelei_shaders::{Gpu, ShaderLibrary};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u32| arguments.get(at).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (n_strands, vertices_per_strand) = (number(0, 100_000), number(1, 33));
    let size = [number(2, 1920), number(3, 1080)];
    let mut groom = sample_groom(n_strands, vertices_per_strand);
    if arguments.get(4).is_some_and(|name| name == "ribbons") {
        groom.look.primitive = Primitive::Ribbons;
    }
    let n_frames = number(5, 20);
    let started = Instant::now();
    let gpu = Gpu::headless()?;
    println!("{}", gpu.adapter_info.name);
    let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded())?;
    println!("pipelines after {:.2} s", started.elapsed().as_secs_f64());
    renderer.set_groom(&groom)?;
    println!("groom after {:.2} s", started.elapsed().as_secs_f64());
    let camera = Camera { target: Vec3::new(0.0, -6.0, 0.0), distance: 95.0, ..Camera::default() };
    let input = FrameInput {
        camera: &camera,
        size,
        world_from_head: Affine3A::IDENTITY,
        guides: &[],
        guides_stamp: 0,
        lod_scale: 1.0,
    };
    let mut times: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut frames = Vec::new();
    renderer.render_pixels(&input)?;
    println!("first frame after {:.2} s", started.elapsed().as_secs_f64());
    // Frame upon frame without reading back: a GPU that waits for the CPU lowers its clock.
    for _ in 0..n_frames {
        let frame = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.render(&mut encoder, &input)?;
        gpu.queue.submit([encoder.finish()]);
        frames.push(frame.elapsed().as_secs_f64() * 1e3);
        if frames.len() % 2 == 0 {
            gpu.wait()?;
        }
        for (label, ms) in renderer.pass_times() {
            times.entry(label).or_default().push(ms);
        }
    }
    let pixels = renderer.render_pixels(&input)?;
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    for (label, values) in &mut times {
        println!("{label:20} {:9.3} ms", median(values));
    }
    println!("{:20} {:9.3} ms on the CPU", "recording", median(&mut frames));
    let statistics = renderer.statistics();
    let (listed, room) = renderer.n_tile_entries()?;
    println!("{statistics:?}; {listed} list entries of {room}");
    if let Some(path) = arguments.get(6) {
        let mut file = format!("P6 {} {} 255\n", size[0], size[1]).into_bytes();
        file.extend(pixels.rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]));
        std::fs::write(path, file)?;
    }
    Ok(())
}
