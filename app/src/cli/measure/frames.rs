//! `lorelei measure frames`: what a frame of the default groom takes on the GPU, part by part, for several strand counts and
//! picture sizes.

use std::fmt::Write;
use std::time::{Duration, Instant};

use glam::Affine3A;
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::look::Primitive;
use lorelei_render::sort::Sort;
use lorelei_render::{DRAWING_PASSES, FrameInput, RenderError, Renderer};
use lorelei_shaders::{Gpu, ShaderLibrary};
use serde_json::{Value, json};

use super::super::scene::set_strand_count;
use super::super::{CliError, print_line};
use super::{MeasureArguments, page};

const PAGE: &str = "docs/frames-table.md";
const STRANDS: [u32; 3] = [20_000, 100_000, 500_000];
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// A software driver is told the first of each alone: it takes seconds a frame, and only ratios mean anything.
const N_ON_SOFTWARE: usize = 1;
/// Frames of which the median counts, and for how long others are drawn before: a GPU that waited takes a while to come back
/// to its speed, and pipelines and buffers are made.
const N_FRAMES: usize = 15;
const WARM_UP: Duration = Duration::from_millis(700);

/// Milliseconds of a frame's parts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Parts {
    generate: f64,
    shadow: f64,
    shade: f64,
    head: f64,
    /// Strands into pixels.
    pub draw: f64,
    /// The picture.
    resolve: f64,
}

impl Parts {
    pub fn of(passes: &[(String, f64)]) -> Self {
        let mut parts = Self::default();
        for (pass, ms) in passes {
            let part = match pass.split('.').next().unwrap_or_default() {
                _ if DRAWING_PASSES.iter().any(|start| pass.starts_with(start)) => &mut parts.draw,
                "generate" => &mut parts.generate,
                "shadow" => &mut parts.shadow,
                "shade" | "view" => &mut parts.shade,
                "head" => &mut parts.head,
                _ => &mut parts.resolve,
            };
            *part += ms;
        }
        parts
    }

    fn all(&self) -> [f64; 6] {
        [self.generate, self.shadow, self.shade, self.head, self.draw, self.resolve]
    }

    fn sum(&self) -> f64 {
        self.all().iter().sum()
    }
}

/// One groom in one size under so many lights.
struct Row {
    n_strands: u32,
    n_vertices: u32,
    size: [u32; 2],
    n_lights: usize,
    /// Everything made again; then while only the camera moves.
    whole: Parts,
    orbit: Parts,
    /// Strands into pixels through the graphics pipeline, as sorted ribbons.
    ribbons: Option<f64>,
    n_bytes: u64,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let is_software = gpu.adapter_info.device_type == wgpu::DeviceType::Cpu;
    let n = |all: usize| if is_software { N_ON_SOFTWARE } else { all };
    let counts = arguments.strands.map_or_else(|| STRANDS[..n(STRANDS.len())].to_vec(), |n_strands| vec![n_strands]);
    let (mut rows, mut notes) = (Vec::new(), Vec::new());
    for n_strands in counts {
        let mut groom = lorelei_assets::default_groom();
        set_strand_count(&mut groom, n_strands);
        let rig = groom.lights.clone();
        let mut renderer = Renderer::new(&gpu, ShaderLibrary::embedded()).map_err(CliError::failed)?;
        // What cannot be drawn on this GPU is told, and the rest goes on.
        match renderer.set_groom(&groom) {
            Ok(warnings) => notes.extend(warnings),
            Err(why) => {
                notes.push(format!("{n_strands} strands: {why}"));
                continue;
            }
        }
        for &size in &SIZES[..n(SIZES.len())] {
            for n_lights in [1, rig.len()] {
                groom.lights = rig[..n_lights].to_vec();
                match measure(&gpu, &mut renderer, &mut groom, size, is_software) {
                    Ok(row) => rows.push(row),
                    Err(why) => notes.push(format!("{n_strands} strands at {} x {}: {why}", size[0], size[1])),
                }
            }
        }
    }
    if rows.is_empty() {
        return Err(CliError::Failed(notes.join("\n")));
    }
    let (n_items, sort_ms) = sort(&gpu).map_err(CliError::failed)?;
    notes.push(format!("Segments by depth: {n_items} keys of 32 bits with a value each, stable: {sort_ms:.2} ms."));
    let table = table(&gpu.adapter_info.name, is_software, &rows, &notes).map_err(CliError::failed)?;
    if let Some(path) = &arguments.write {
        page::write(path, PAGE, &table)?;
    }
    if !arguments.json {
        return print_line(&table);
    }
    let rows: Vec<Value> = rows.iter().map(Row::to_json).collect();
    let all = json!({"adapter": gpu.adapter_info.name, "rows": rows, "notes": notes});
    print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?)
}

fn measure(
    gpu: &Gpu,
    renderer: &mut Renderer,
    groom: &mut Groom,
    size: [u32; 2],
    is_software: bool,
) -> Result<Row, RenderError> {
    let mut camera = Camera { azimuth_deg: 35.0, elevation_deg: 5.0, ..Camera::default() };
    camera.frame(crate::stage::bounds_of(groom), size[0] as f32 / size[1] as f32);
    groom.look.primitive = Primitive::Compute;
    renderer.set_groom(groom)?;
    let whole = median(gpu, renderer, &camera, size, is_software, true)?;
    let orbit = median(gpu, renderer, &camera, size, is_software, false)?;
    let statistics = renderer.statistics();
    groom.look.primitive = Primitive::Ribbons;
    renderer.set_groom(groom)?;
    // Ribbons want room for the order of all segments; the tiles' lists are there already.
    let ribbons = median(gpu, renderer, &camera, size, is_software, false).ok().map(|parts| parts.draw);
    groom.look.primitive = Primitive::Compute;
    Ok(Row {
        n_strands: statistics.n_strands,
        n_vertices: statistics.n_vertices,
        size,
        n_lights: groom.lights.len(),
        whole,
        orbit,
        ribbons,
        n_bytes: statistics.n_bytes,
    })
}

/// The median of each part over some frames; `again`: with everything made again.
fn median(
    gpu: &Gpu,
    renderer: &mut Renderer,
    camera: &Camera,
    size: [u32; 2],
    is_software: bool,
    again: bool,
) -> Result<Parts, RenderError> {
    let (n_frames, warm_up) = if is_software { (3, Duration::ZERO) } else { (N_FRAMES, WARM_UP) };
    let mut all: Vec<Parts> = Vec::new();
    let begin = Instant::now();
    let mut n_drawn = 0;
    while all.len() < n_frames {
        let is_warm = n_drawn >= 2 && begin.elapsed() >= warm_up;
        n_drawn += 1;
        let turned = Camera { azimuth_deg: camera.azimuth_deg + 0.1 * (n_drawn % 20) as f32, ..*camera };
        if again {
            renderer.forget();
        }
        draw(gpu, renderer, &turned, size)?;
        if is_warm {
            all.push(Parts::of(&renderer.pass_times()));
        }
    }
    let middle = |of: &dyn Fn(&Parts) -> f64| {
        let mut times: Vec<f64> = all.iter().map(of).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    Ok(Parts {
        generate: middle(&|parts| parts.generate),
        shadow: middle(&|parts| parts.shadow),
        shade: middle(&|parts| parts.shade),
        head: middle(&|parts| parts.head),
        draw: middle(&|parts| parts.draw),
        resolve: middle(&|parts| parts.resolve),
    })
}

/// A frame to its end; the picture stays on the GPU, which would rest while it is read.
pub(super) fn draw(gpu: &Gpu, renderer: &mut Renderer, camera: &Camera, size: [u32; 2]) -> Result<(), RenderError> {
    let input =
        FrameInput { camera, size, world_from_head: Affine3A::IDENTITY, moved: &[], moved_stamp: 0, lod_scale: 1.0 };
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    renderer.render(&mut encoder, &input)?;
    gpu.queue.submit([encoder.finish()]);
    renderer.collect_times();
    gpu.wait()?;
    renderer.collect_times();
    Ok(())
}

/// The fewest milliseconds that the radix sort of transparency takes for four million keys in no order, on the clock of the
/// CPU, less those of an empty submission.
fn sort(gpu: &Gpu) -> Result<(u32, f64), RenderError> {
    let n_items = (1 << 22).min(gpu.max_storage_binding() / 4) as u32;
    let mut sort = Sort::new(gpu, &ShaderLibrary::embedded())?;
    sort.prepare(gpu, &ShaderLibrary::embedded(), n_items)?;
    let mut state = 1_u32;
    let keys: Vec<u32> = (0..n_items)
        .map(|_| {
            // Marsaglia 2003, xorshift.
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state
        })
        .collect();
    let timed = |record: &dyn Fn(&mut wgpu::CommandEncoder)| -> Result<f64, RenderError> {
        let mut fewest = f64::INFINITY;
        for _ in 0..10 {
            gpu.queue.write_buffer(sort.keys(), 0, bytemuck::cast_slice(&keys));
            gpu.queue.submit([]);
            gpu.wait()?;
            let begin = Instant::now();
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()?;
            fewest = fewest.min(begin.elapsed().as_secs_f64() * 1e3);
        }
        Ok(fewest)
    };
    let empty = timed(&|_| {})?;
    Ok((n_items, (timed(&|encoder| sort.record(encoder))? - empty).max(0.0)))
}

impl Row {
    fn to_json(&self) -> Value {
        let of = |parts: &Parts| {
            let [generate, shadow, shade, head, draw, resolve] = parts.all();
            json!({"generate": generate, "shadow": shadow, "shade": shade, "head": head, "draw": draw,
                "resolve": resolve, "sum": parts.sum()})
        };
        json!({
            "strands": self.n_strands,
            "vertices": self.n_vertices,
            "size": self.size,
            "lights": self.n_lights,
            "gpu_ms": of(&self.whole),
            "orbit_gpu_ms": of(&self.orbit),
            "ribbons_gpu_ms": self.ribbons,
            "bytes": self.n_bytes,
        })
    }
}

fn table(adapter: &str, is_software: bool, rows: &[Row], notes: &[String]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let unit = if is_software { "multiples of strands into pixels" } else { "ms" };
    writeln!(text, "{adapter}, the default groom; GPU timestamps, medians, {unit}.\n")?;
    writeln!(
        text,
        "| strands | picture | lights | generate | shadows | shade | head | strands into pixels | picture | all | only the camera moves | ribbons / compute | MiB |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|---|---|---|---|---|")?;
    for row in rows {
        let per = if is_software { 1.0 / row.whole.draw.max(1e-9) } else { 1.0 };
        write!(text, "| {} | {} x {} | {} ", row.n_strands, row.size[0], row.size[1], row.n_lights)?;
        for ms in row.whole.all().into_iter().chain([row.whole.sum(), row.orbit.sum()]) {
            write!(text, "| {:.2} ", per * ms)?;
        }
        let ratio = row.ribbons.map_or("-".to_owned(), |ms| format!("{:.1}", ms / row.orbit.draw.max(1e-9)));
        writeln!(text, "| {ratio} | {} |", row.n_bytes >> 20)?;
    }
    for note in notes {
        writeln!(text, "\n{note}")?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pass_belongs_to_a_part() {
        let passes =
            ["generate", "shadow.head", "shadow.hair", "shade", "head.surface", "raster.fine", "resolve", "sliced"];
        let times: Vec<(String, f64)> =
            passes.iter().zip(1..).map(|(pass, k)| (pass.to_string(), f64::from(k))).collect();
        assert_eq!(Parts::of(&times).all(), [1.0, 5.0, 4.0, 5.0, 6.0 + 8.0, 7.0]);
        assert_eq!(Parts::of(&times).sum(), 36.0);
    }
}
