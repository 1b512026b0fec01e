//! `lorelei measure transparency`: how far each way of drawing is from the exact picture, and what it costs.

use std::fmt::Write;
use std::time::{Duration, Instant};

use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::look::{Antialiasing, Choice, Primitive, Transparency};
use lorelei_render::Renderer;
use lorelei_render::reference::Apart;
use lorelei_shaders::{Gpu, ShaderLibrary};
use serde_json::json;

use super::super::scene::set_strand_count;
use super::super::{CliError, print_line};
use super::frames::{self, Parts};
use super::{MeasureArguments, page};

const PAGE: &str = "docs/looks/drawing-table.md";
/// Embedded styles: falling hair, curls, and hair laid over hair.
const GROOMS: [&str; 3] = ["long", "curls", "braid"];
const OPACITIES: [f32; 3] = [0.1, 0.3, 1.0];
/// Frames of which the quickest counts, and how long they are drawn at least: a GPU that waited for the exact picture
/// takes a while to come back to its speed.
const N_FRAMES: u32 = 5;
const LONG_ENOUGH: Duration = Duration::from_millis(400);
/// One way of drawing one groom.
struct Row {
    groom: &'static str,
    n_strands: u32,
    opacity: f32,
    primitive: Primitive,
    antialiasing: Antialiasing,
    transparency: Transparency,
    apart: Apart,
    /// `None` where the device tells no times.
    gpu_ms: Option<f64>,
    n_bytes: u64,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let mut rows = Vec::new();
    for name in GROOMS {
        let mut groom = lorelei_assets::hairstyle(name)
            .ok_or_else(|| CliError::Failed(format!("there is no embedded style `{name}`")))?;
        if let Some(n_strands) = arguments.strands {
            set_strand_count(&mut groom, n_strands);
        }
        measure(&gpu, name, &mut groom, arguments.size, &mut rows)?;
    }
    let table = table(&gpu.adapter_info.name, arguments.size, &rows)?;
    if let Some(path) = &arguments.write {
        page::write(path, PAGE, &table)?;
    }
    if !arguments.json {
        return print_line(&table);
    }
    let rows: Vec<serde_json::Value> = rows.iter().map(Row::to_json).collect();
    let all = json!({"adapter": gpu.adapter_info.name, "size": arguments.size, "rows": rows});
    print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?)
}

fn measure(gpu: &Gpu, name: &'static str, groom: &mut Groom, side: u32, rows: &mut Vec<Row>) -> Result<(), CliError> {
    let mut camera = Camera { azimuth_deg: 35.0, elevation_deg: 5.0, ..Camera::default() };
    camera.frame(crate::stage::bounds_of(groom), 1.0);
    let mut renderer = Renderer::new(gpu, ShaderLibrary::embedded()).map_err(CliError::failed)?;
    for opacity in OPACITIES {
        groom.look.drawing.opacity = opacity;
        (groom.look.primitive, groom.look.antialiasing) = (Primitive::Compute, Antialiasing::Analytic);
        groom.look.transparency = Transparency::FrontToBack;
        draw(gpu, &mut renderer, groom, &camera, side, 1, Duration::ZERO)?;
        let exact = renderer.exact_hair(&camera).map_err(CliError::failed)?;
        for (primitive, antialiasing, transparency) in ways(opacity) {
            groom.look.primitive = primitive;
            groom.look.antialiasing = antialiasing;
            groom.look.transparency = transparency;
            let gpu_ms = draw(gpu, &mut renderer, groom, &camera, side, N_FRAMES, LONG_ENOUGH)?;
            let apart = Apart::between(&renderer.read_hair().map_err(CliError::failed)?, &exact);
            let statistics = renderer.statistics();
            rows.push(Row {
                groom: name,
                n_strands: statistics.n_strands,
                opacity,
                primitive,
                antialiasing,
                transparency,
                apart,
                gpu_ms,
                n_bytes: statistics.n_drawing_bytes,
            });
        }
    }
    Ok(())
}

/// Every transparency; of opaque fibres the other primitives and every antialiasing, too.
fn ways(opacity: f32) -> Vec<(Primitive, Antialiasing, Transparency)> {
    let (compute, analytic) = (Primitive::Compute, Antialiasing::Analytic);
    let mut ways: Vec<_> = Transparency::ALL.iter().map(|&choice| (compute, analytic, choice)).collect();
    if opacity == 1.0 {
        let others = Primitive::ALL.iter().filter(|&&primitive| primitive != compute);
        ways.extend(others.map(|&primitive| (primitive, analytic, Transparency::Sorted)));
        let others = Antialiasing::ALL.iter().filter(|&&antialiasing| antialiasing != analytic);
        ways.extend(others.map(|&antialiasing| (compute, antialiasing, Transparency::FrontToBack)));
    }
    ways
}

/// Draw some frames; the fewest milliseconds that the GPU took from strands to pixels.
fn draw(
    gpu: &Gpu,
    renderer: &mut Renderer,
    groom: &Groom,
    camera: &Camera,
    side: u32,
    n_frames: u32,
    at_least: Duration,
) -> Result<Option<f64>, CliError> {
    renderer.set_groom(groom).map_err(CliError::failed)?;
    let mut fewest: Option<f64> = None;
    let begin = Instant::now();
    let mut n_drawn = 0;
    while n_drawn < n_frames || begin.elapsed() < at_least {
        n_drawn += 1;
        frames::draw(gpu, renderer, camera, [side, side]).map_err(CliError::failed)?;
        let times = renderer.pass_times();
        let ms = Parts::of(&times).draw;
        if !times.is_empty() {
            fewest = Some(fewest.map_or(ms, |fewest| fewest.min(ms)));
        }
    }
    Ok(fewest)
}

impl Row {
    fn to_json(&self) -> serde_json::Value {
        json!({
            "groom": self.groom,
            "strands": self.n_strands,
            "opacity": self.opacity,
            "primitive": self.primitive.info().name,
            "antialiasing": self.antialiasing.info().name,
            "choice": self.transparency.info().name,
            "rmse": self.apart.rmse,
            "p99": self.apart.p99,
            "coverage": self.apart.coverage,
            "gpu_ms": self.gpu_ms,
            "bytes": self.n_bytes,
        })
    }

    /// What the row is about, but for groom and opacity.
    fn way(&self) -> (Primitive, Antialiasing, Transparency) {
        (self.primitive, self.antialiasing, self.transparency)
    }

    fn label(&self) -> String {
        let of_primitive = match self.primitive {
            Primitive::Compute => String::new(),
            Primitive::Polylines | Primitive::Ribbons => format!(", {}", self.primitive.info().label.to_lowercase()),
        };
        match self.antialiasing {
            Antialiasing::Analytic => format!("{}{of_primitive}", self.transparency.info().label),
            _ => format!("{}, {}", self.transparency.info().label, self.antialiasing.info().label),
        }
    }
}

/// The table as Markdown: a line for each way, error at each opacity as the mean over the grooms.
fn table(adapter: &str, side: u32, rows: &[Row]) -> Result<String, CliError> {
    let mut text = String::new();
    let failed = |why: std::fmt::Error| CliError::Failed(why.to_string());
    let grooms: Vec<String> = GROOMS
        .iter()
        .filter_map(|name| rows.iter().find(|row| row.groom == *name))
        .map(|row| format!("{} ({} strands)", row.groom, row.n_strands))
        .collect();
    writeln!(text, "{adapter}, {side} x {side} pixels, the mean over {}.\n", grooms.join(", ")).map_err(failed)?;
    writeln!(text, "| | opacity 0.1 | 0.3 | 1.0 | ms | MiB |\n|---|---|---|---|---|---|").map_err(failed)?;
    let mut seen = Vec::new();
    for row in rows {
        if seen.contains(&row.way()) {
            continue;
        }
        seen.push(row.way());
        let alike: Vec<&Row> = rows.iter().filter(|other| other.way() == row.way()).collect();
        let mean = |opacity: f32, of: &dyn Fn(&Row) -> f64| {
            let values: Vec<f64> = alike.iter().filter(|row| row.opacity == opacity).map(|row| of(row)).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        write!(text, "| {} |", row.label()).map_err(failed)?;
        for opacity in OPACITIES {
            let (rmse, p99) = (mean(opacity, &|row| row.apart.rmse), mean(opacity, &|row| row.apart.p99));
            match rmse.zip(p99) {
                Some((rmse, p99)) => write!(text, " {rmse:.4} ({p99:.3}) |").map_err(failed)?,
                None => write!(text, " |").map_err(failed)?,
            }
        }
        let ms = mean(1.0, &|row| row.gpu_ms.unwrap_or(f64::NAN)).unwrap_or(f64::NAN);
        let mebibytes = mean(1.0, &|row| row.n_bytes as f64 / f64::from(1 << 20)).unwrap_or(f64::NAN);
        writeln!(text, " {ms:.2} | {mebibytes:.0} |").map_err(failed)?;
    }
    Ok(text)
}
