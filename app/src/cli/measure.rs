//! `lorelei measure`: what this machine needs for the studio's work, and what techniques get wrong, without a window.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::builder::{OsStringValueParser, TypedValueParser};
use glam::Vec3;
use lorelei_core::binding::bind_layer;
use lorelei_core::brush::Brush;
use lorelei_core::camera::Camera;
use lorelei_core::distance_field::{COLLISION_RESOLUTION, DistanceField};
use lorelei_core::edit::Edit;
use lorelei_core::generate::{Pose, generate};
use lorelei_core::groom::{Groom, HairMaterial, Layer, Source};
use lorelei_core::hair_mesh::{Accuracy, Along, HairMesh, MeshOp, Relaxer, VertexId, Weld};
use lorelei_core::history::{History, Merge};
use lorelei_core::look::{Choice, Look, Scattering};
use lorelei_core::sculpt::compose::Composed;
use lorelei_core::sculpt::{
    Composite, LiveStroke, Sculpt, SculptBase, SculptBrush, SculptLayer, Stroke, StrokePoint, StrokeView, join_changes,
};
use lorelei_render::scattering::tables::{Baked, Recipe};
use serde_json::{Value, json};

use super::{CliError, print_line};

mod frames;
mod laws;
mod movement;
mod page;
mod paint;
mod shadowing;
mod transparency;

#[derive(Debug, clap::Args)]
pub struct MeasureArguments {
    /// What to measure.
    #[arg(value_enum)]
    what: What,
    /// As JSON: an array of objects, of `grooming` and `scattering` {what, n, ms, note}; of `transparency` one object {adapter,
    /// size, rows: [{groom, strands, opacity, primitive, antialiasing, choice, rmse, p99, coverage, gpu_ms, bytes}]}; of `frames`
    /// {adapter, rows: [{strands, vertices, size, lights, gpu_ms, orbit_gpu_ms, ribbons_gpu_ms, bytes}], notes}; of `movement`
    /// {adapter, threads, rows: [{what, strands, vertices, steps, solver, gpu_ms, cpu_ms, thread_ms}], beside: [{strands, what,
    /// gpu_ms, plain_ms}]}; of `laws` {device, rows: [{law, scene, of, value, unit, relation, bound, holds}]}.
    #[arg(long)]
    pub(super) json: bool,
    /// Put the table into a page, between its marks. Without FILE: the page in the project's docs/.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "", value_parser = path_or_none())]
    pub(super) write: Option<PathBuf>,
    /// Strands of each groom. Of `shadowing` (20,000 without it), `transparency` (as many as the groom has), `frames`, and
    /// `movement` (of 32 vertices, instead of its own).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub(super) strands: Option<u32>,
    /// Only this technique, by its name in `lorelei looks`. Of `shadowing`, and of `movement`: only this law.
    #[arg(long, value_name = "NAME")]
    pub(super) only: Option<String>,
    /// Side of the picture in pixels. Of `transparency`.
    #[arg(long, value_name = "N", default_value_t = 640, value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub(super) size: u32,
    /// The solvers of the graphics device, or their twins. Of `laws`.
    #[arg(long, value_enum, default_value = "cpu")]
    on: laws::Device,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum What {
    /// A frame of the default groom on the GPU, part by part, for 20,000 to 500,000 strands at 1080p and 4K.
    Frames,
    /// Relaxing, tracing, moving vertices, strokes, painting and undo.
    Grooming,
    /// What must hold of hair that moves and of the air, under each solver: values, bounds, and which are broken.
    Laws,
    /// Steps of the strand solvers on the GPU and on the CPU.
    Movement,
    /// Baking the tables of every model of scattering that has some.
    Scattering,
    /// Transmittance of every shadow technique against the exact one, GPU times and bytes.
    Shadowing,
    /// Every transparency and antialiasing against the exact picture, GPU times and bytes.
    Transparency,
}

/// A path, which may be empty: clap's own parser of paths takes none that is.
fn path_or_none() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().map(PathBuf::from)
}

/// One line of the table.
struct Line {
    what: &'static str,
    /// Vertices, strands or texels.
    n: usize,
    ms: f64,
    note: String,
}

const N_ROUNDS: usize = 7;

pub fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let lines = match arguments.what {
        What::Grooming => grooming()?,
        What::Scattering => scattering(),
        What::Frames => return frames::run(arguments),
        What::Laws => return laws::run(arguments),
        What::Movement => return movement::run(arguments),
        What::Shadowing => return shadowing::run(arguments),
        What::Transparency => return transparency::run(arguments),
    };
    if arguments.json {
        let all: Vec<Value> = lines
            .iter()
            .map(|line| json!({"what": line.what, "n": line.n, "ms": line.ms, "note": line.note}))
            .collect();
        return print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?);
    }
    print_line(&format!("{:<44} {:>9} {:>10}", "", "n", "ms"))?;
    for Line { what, n, ms, note } in lines {
        print_line(&format!("{what:<44} {n:>9} {ms:>10.3}  {note}"))?;
    }
    Ok(())
}

fn scattering() -> Vec<Line> {
    let mut lines = Vec::new();
    for &scattering in Scattering::ALL {
        let recipe = Recipe::of(&HairMaterial::default(), &Look { scattering, ..Look::default() });
        if recipe == Recipe::Nothing {
            continue;
        }
        let baked = Baked::new(&recipe);
        let n = baked.azimuthal.iter().chain(&baked.longitudinal).map(|table| table.texels.len()).sum();
        let note = format!("{} cores", std::thread::available_parallelism().map_or(1, usize::from));
        let ms = median_ms(N_ROUNDS, || {
            std::hint::black_box(Baked::new(&recipe));
        });
        lines.push(Line { what: scattering.info().label, n, ms, note });
    }
    lines
}

fn grooming() -> Result<Vec<Line>, CliError> {
    let mut lines = Vec::new();
    for n_vertices in [1_000, 10_000, 100_000] {
        relax(n_vertices, &mut lines)?;
    }
    trace(&mut lines)?;
    sculpt(&mut lines)?;
    paint::paint(&mut lines)?;
    Ok(lines)
}

/// Median of a few runs, milliseconds.
fn median_ms(n_rounds: usize, mut work: impl FnMut()) -> f64 {
    let mut all: Vec<f64> = (0..n_rounds)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// A square of quads with nine layers above, of about so many vertices.
fn block(n_vertices: usize) -> Result<HairMesh, CliError> {
    let side = ((n_vertices as f64 / 10.0).sqrt().round() as u32).max(2);
    let positions = (0..side * side).map(|i| Vec3::new((i % side) as f32, 0.0, (i / side) as f32)).collect();
    let faces = (0..(side - 1) * (side - 1))
        .map(|i| i % (side - 1) + side * (i / (side - 1)))
        .map(|corner| vec![corner, corner + side, corner + side + 1, corner + 1])
        .collect();
    let mut mesh = HairMesh::from_polygons(positions, faces).map_err(CliError::failed)?;
    let bundles = (0..mesh.n_bundles()).collect();
    let along = Along::Direction(Vec3::Y);
    mesh.apply(&MeshOp::Extrude { bundles, along, length_cm: 9.0, n_layers: 9, weld: Weld::Neighbours })
        .map_err(CliError::failed)?;
    Ok(mesh)
}

fn relax(n_vertices: usize, lines: &mut Vec<Line>) -> Result<(), CliError> {
    let rest = block(n_vertices)?;
    let n = rest.n_vertices();
    let start = Instant::now();
    let relaxer = Relaxer::new(&rest);
    let ms = start.elapsed().as_secs_f64() * 1e3;
    lines.push(Line { what: "relax: prepare, once a topology", n, ms, note: String::new() });
    // The hair at the middle of a wall is bent to and fro; the inside starts from where it is. (A straight hair
    // leaned over asks nothing of its neighbours.)
    let mut mesh = rest.clone();
    let on_wall = (n_vertices as f64 / 10.0).sqrt() as u32 / 2;
    let chain = mesh.chains().chains.into_iter().find(|chain| chain[0] == on_wall).unwrap_or_default();
    let mut turn = 0.0_f32;
    let mut n_iterations = 0;
    let ms = median_ms(2 * N_ROUNDS, || {
        turn += 0.7;
        for (layer, &vertex) in chain.iter().enumerate().skip(1) {
            mesh.layers[layer].positions[vertex as usize].z = -0.05 * (layer * layer) as f32 * (1.0 + turn.sin());
        }
        n_iterations = relaxer.relax(&mut mesh, Accuracy::Drag).n_iterations;
    });
    let note = format!("{n_iterations} iterations; one core");
    lines.push(Line { what: "relax: a frame of a drag", n, ms, note });
    Ok(())
}

/// Strokes over the default groom: what a frame costs on the CPU, whatever the strands. `RAYON_NUM_THREADS=1` measures
/// one core.
fn sculpt(lines: &mut Vec<Line>) -> Result<(), CliError> {
    let mut groom: Groom = lorelei_assets::default_groom();
    groom.layers.truncate(1);
    let n = groom.layers[0].n_strands as usize;
    let head = groom.head.clone();
    let field = head.as_ref().and_then(|head| DistanceField::from_mesh(&head.mesh, COLLISION_RESOLUTION).ok());
    let start = Instant::now();
    let base = SculptBase::prepare(&groom.layers[0], head.as_ref(), Some(field.map(Arc::new)));
    let roots = Arc::clone(&base.roots);
    let ms = start.elapsed().as_secs_f64() * 1e3;
    lines.push(Line {
        what: "sculpt: prepare, once a layer",
        n: roots.positions.len(),
        ms,
        note: "all cores".to_owned(),
    });
    let mut history = History::default();
    let begin = vec![
        Edit::SetSculptRoots { layer_idx: 0, roots },
        Edit::AddSculpt { layer_idx: 0, sculpt_idx: 0, sculpt: Box::new(SculptLayer::new("measured")) },
    ];
    history.apply(&mut groom, "begin", Edit::Batch(begin), Merge::New).map_err(CliError::failed)?;
    let start = Instant::now();
    let mut binding = bind_layer(&Layer { sculpt: Sculpt::default(), ..groom.layers[0].clone() }, head.as_ref());
    let without = start.elapsed();
    let start = Instant::now();
    binding.resculpt(&groom.layers[0], head.as_ref());
    let ms = start.elapsed().as_secs_f64() * 1e3;
    let note = format!("all cores; {:.0} ms for all else that strands hang on", without.as_secs_f64() * 1e3);
    lines.push(Line { what: "sculpt: strands to guides, once a layer", n, ms, note });
    let base = Arc::new(base);
    let of_brushes: Result<Vec<_>, CliError> =
        SculptBrush::ALL.iter().map(|&kind| Ok((kind, stroke_of(kind, &base, &groom)?))).collect();
    let of_brushes = of_brushes?;
    let line = |what, (kind, stroke): &(SculptBrush, StrokeCost)| Line {
        what,
        n,
        ms: stroke.frame_ms,
        note: format!(
            "{}: up to {} guides touched, {:.0} KiB sent, {:.1} ms at the press; brush, edit, undo and what is sent",
            kind.info().label,
            stroke.n_touched,
            stroke.sent_bytes as f64 / 1024.0,
            stroke.begin_ms,
        ),
    };
    let comb = of_brushes.iter().filter(|(kind, _)| *kind == SculptBrush::Comb);
    lines.extend(comb.map(|comb| line("sculpt: a frame of a stroke", comb)));
    let costliest = of_brushes.iter().max_by(|a, b| a.1.frame_ms.total_cmp(&b.1.frame_ms));
    lines.extend(costliest.map(|costliest| line("sculpt: of the costliest brush", costliest)));
    Ok(())
}

/// What a stroke takes on the CPU.
struct StrokeCost {
    begin_ms: f64,
    /// Median of a frame with two places of the pointer.
    frame_ms: f64,
    /// Most guides that a frame touched, and bytes that it sends to the GPU.
    n_touched: usize,
    sent_bytes: usize,
}

/// A stroke with a large brush over the side of the hair, from the front to the back.
fn stroke_of(kind: SculptBrush, base: &Arc<SculptBase>, groom: &Groom) -> Result<StrokeCost, CliError> {
    let (mut groom, mut history) = (groom.clone(), History::default());
    let view = StrokeView { camera: Camera { azimuth_deg: 90.0, ..Camera::default() }, ..StrokeView::default() };
    let brush = Brush { radius_cm: 4.0, ..Brush::default() };
    let stroke = Stroke { kind, brush, view, ..Stroke::default() };
    let start = Instant::now();
    let mut live = LiveStroke::begin(Arc::clone(base), &groom.layers[0], 0, &stroke);
    let begin_ms = start.elapsed().as_secs_f64() * 1e3;
    let mut before = Composite::default();
    let (mut x, mut n_touched, mut n_sent, mut failed) = (500.0, 0, 0, None);
    let frame_ms = median_ms(41, || {
        // A fast hand: 12 points of the window a frame.
        x += 6.0;
        let mut changes = live.extend(StrokePoint::new(x, 330.0));
        x += 6.0;
        let mut later = live.extend(StrokePoint::new(x, 330.0));
        join_changes(&mut later, &changes);
        changes = later;
        n_touched = changes.len().max(n_touched);
        let edit = Edit::Sculpt { layer_idx: 0, sculpt_idx: 0, changes };
        failed = history.apply(&mut groom, "brush", edit, Merge::Stroke(1)).err().or(failed.take());
        let after = Composite::of(&groom.layers[0]);
        // The first frame sends all guides, once.
        if !before.guides.is_empty() {
            n_sent = after.changed_since(&before).iter().map(std::ops::Range::len).sum::<usize>().max(n_sent);
        }
        before = after;
    });
    match failed {
        Some(why) => Err(CliError::failed(why)),
        None => Ok(StrokeCost { begin_ms, frame_ms, n_touched, sent_bytes: n_sent * size_of::<Composed>() }),
    }
}

fn trace(lines: &mut Vec<Line>) -> Result<(), CliError> {
    let mut groom: Groom = lorelei_assets::default_groom();
    groom.layers.truncate(1);
    let layer: &Layer = &groom.layers[0];
    let n = layer.n_strands as usize;
    let start = Instant::now();
    let binding = bind_layer(layer, groom.head.as_ref());
    let ms = start.elapsed().as_secs_f64() * 1e3;
    lines.push(Line { what: "strands: roots, weights and clumps", n, ms, note: "all cores".to_owned() });
    let pose = Pose::default();
    let ms = median_ms(3, || drop(generate(&binding, layer, &binding.guides.positions, &pose)));
    lines.push(Line { what: "strands: traced and styled on the CPU", n, ms, note: "all cores".to_owned() });
    let Source::HairMesh(mesh) = &layer.source else {
        return Err(CliError::Failed("the default groom is not made of a hair mesh".to_owned()));
    };
    let moved = HairMesh::clone(mesh);
    let ms = median_ms(N_ROUNDS, || drop(binding.moved(&moved)));
    lines.push(Line { what: "a vertex moved: what the strands hang on", n, ms, note: String::new() });

    let mut longer = HairMesh::clone(mesh);
    let bundles = (0..longer.n_bundles()).step_by(3).filter(|&bundle| longer.tip_layer(bundle).is_some()).collect();
    let along = Along::Direction(Vec3::NEG_Y);
    longer
        .apply(&MeshOp::Extrude { bundles, along, length_cm: 1.0, n_layers: 1, weld: Weld::Neighbours })
        .map_err(CliError::failed)?;
    let ms = median_ms(N_ROUNDS, || drop(binding.regrown(mesh, &longer)));
    lines.push(Line { what: "a third extruded: what the strands hang on", n, ms, note: String::new() });

    let mut history = History::default();
    let n_vertices = mesh.n_vertices();
    let id = VertexId { layer: 3, vertex: 0 };
    let place = mesh.position(id).unwrap_or_default();
    let mut x = 0.0;
    let mut failed = None;
    let ms = median_ms(101, || {
        x += 0.01;
        let moves = vec![(id, place + Vec3::X * x)];
        let edit = Edit::MoveVertices { layer_idx: 0, moves };
        failed = history.apply(&mut groom, "move", edit, Merge::New).err().or(failed.take());
    });
    if let Some(why) = failed {
        return Err(CliError::failed(why));
    }
    let note = format!("{} bytes of undo for 101 steps", history.n_bytes());
    lines.push(Line { what: "edit: a vertex moved, with its inverse", n: n_vertices, ms, note });
    Ok(())
}
