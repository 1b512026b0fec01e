//! `lorelei measure shadowing`: every shadow technique in several sizes, on grooms under a parallel and a point light, and
//! behind stray strands: error against the exact transmittance, GPU times, bytes.

use std::fmt::Write as _;

use glam::Vec3;
use lorelei_core::groom::Groom;
use lorelei_core::light::{Light, LightKind};
use lorelei_core::look::{BeyondLast, Choice, LayerSpacing, ShadowParams, Shadowing};
use lorelei_render::shadow::measure::{FOOTPRINT_CM, ShadowScene, ShadowScore};
use lorelei_shaders::{Gpu, ShaderLibrary};
use serde_json::{Value, json};

use super::{MeasureArguments, page};
use crate::cli::{CliError, print_line};
use crate::stage::shader_library;

/// The page of the project that the table stands in.
const PAGE: &str = "docs/looks/shadowing-table.md";
/// Of each groom, unless another number is asked for.
const N_STRANDS: u32 = 20_000;

const N_PROBES: usize = 20_000;
const N_ROUNDS: usize = 5;

/// A technique with its numbers, and what of them the table says.
struct Case {
    name: &'static str,
    size: String,
    shadowing: Shadowing,
    params: ShadowParams,
}

/// Hair under a light.
struct Place {
    name: String,
    scene: ShadowScene,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let library = shader_library().map_err(CliError::failed)?;
    let wanted = |case: &Case| arguments.only.as_ref().is_none_or(|name| case.shadowing.info().name == name);
    let cases: Vec<Case> = cases().into_iter().filter(wanted).collect();
    if cases.is_empty() {
        return Err(CliError::Failed("there is no technique of that name; `lorelei looks` lists them".to_owned()));
    }
    let places = places(&gpu, &library, arguments.strands.unwrap_or(N_STRANDS))?;
    let mut rows: Vec<(Case, Vec<ShadowScore>)> = Vec::new();
    for case in cases {
        let mut scores = Vec::new();
        for place in &places {
            let score = place.scene.score(&gpu, &library, case.shadowing, &case.params, N_ROUNDS);
            scores.push(score.map_err(CliError::failed)?);
        }
        eprintln!("{} {}: {}", case.name, case.size, texts(&scores));
        rows.push((case, scores));
    }
    if arguments.json {
        let all: Vec<Value> = rows.iter().flat_map(|(case, scores)| json_of(case, scores, &places)).collect();
        print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?)?;
    }
    let table = table(&gpu, &rows, &places);
    if let Some(path) = &arguments.write {
        page::write(path, PAGE, &table)?;
    } else if !arguments.json {
        print_line(&table)?;
    }
    Ok(())
}

fn texts(scores: &[ShadowScore]) -> String {
    scores.iter().map(|score| format!("{:.4}/{:.3}", score.mean_error, score.error_99)).collect::<Vec<_>>().join(" ")
}

/// Two grooms, two kinds of light, and stray strands.
fn places(gpu: &Gpu, library: &ShaderLibrary, n_strands: u32) -> Result<Vec<Place>, CliError> {
    let key = Light::directional("key", 40.0, 40.0, 1.0, [1.0; 3]);
    let lamp = Light { kind: LightKind::Point { position: Vec3::new(50.0, 200.0, 60.0) }, ..key.clone() };
    let groom = |style: &str| -> Result<Groom, CliError> {
        let mut groom = lorelei_assets::hairstyle(style)
            .ok_or_else(|| CliError::Failed(format!("the hairstyle {style} is not there")))?;
        let n_all: u32 = groom.layers.iter().map(|layer| layer.n_strands).sum();
        let share = f64::from(n_strands) / f64::from(n_all.max(1));
        for layer in &mut groom.layers {
            let n = (f64::from(layer.n_strands) * share).ceil();
            // Fewer strands of the same area.
            layer.radius_um *= (f64::from(layer.n_strands) / n) as f32;
            layer.n_strands = n as u32;
        }
        Ok(groom)
    };
    let wanted = [
        ("long", "parallel", &key, false),
        ("long", "point", &lamp, false),
        ("curls", "parallel", &key, false),
        ("long", "parallel, strays", &key, true),
    ];
    let mut places = Vec::new();
    for (style, name, light, strays) in wanted {
        let scene =
            ShadowScene::new(gpu, library, &groom(style)?, light, strays, N_PROBES).map_err(CliError::failed)?;
        places.push(Place { name: format!("{style}, {name}"), scene });
    }
    Ok(places)
}

/// The footprint of a look-up is about the same in all: four texels of 512, and of 1024 a window of three taps or the
/// filter.
fn cases() -> Vec<Case> {
    let coarse = ShadowParams { resolution: 512, filter_radius: 0.0, n_strands: 4_000_000, ..ShadowParams::default() };
    let fine = ShadowParams { resolution: 1024, filter_radius: 1.5, n_taps: 3, ..coarse.clone() };
    let filtered = ShadowParams { n_taps: 1, ..fine.clone() };
    let mut cases = Vec::new();
    let mut add = |name: &'static str, size: String, shadowing: Shadowing, params: ShadowParams| {
        cases.push(Case { name, size, shadowing, params });
    };
    add("Off", String::new(), Shadowing::Off, coarse.clone());
    for (resolution, n_pcf_taps) in [(512, 3), (1024, 3), (1024, 7)] {
        let params = ShadowParams { resolution, n_pcf_taps, ..coarse.clone() };
        add("Shadow map", format!("{resolution}, {n_pcf_taps} x {n_pcf_taps} taps"), Shadowing::ShadowMap, params);
    }
    for falloff in [0.5, 1.0, 2.0, 4.0] {
        let params = ShadowParams { falloff, bias: 0.0, ..fine.clone() };
        add("Exponential falloff", format!("1024, {falloff} per cm"), Shadowing::Exponential, params);
    }
    for n_slices in [4, 8, 16, 32, 64, 128, 256] {
        let params = ShadowParams { n_slices, ..coarse.clone() };
        add("Opacity shadow maps", format!("512, {n_slices} slices"), Shadowing::OpacityMaps, params);
    }
    for n_rounds in [1, 2, 4] {
        let params = ShadowParams { n_rounds, ..coarse.clone() };
        add("Density clustering", format!("512, {n_rounds} rounds"), Shadowing::Clusters, params);
    }
    for (n_layers, layer_size) in [(3, 0.15), (3, 0.5), (6, 0.15), (7, 0.25), (15, 0.05), (15, 0.15)] {
        let params = ShadowParams { n_layers, layer_size, ..coarse.clone() };
        let size = format!("512, {n_layers} layers from {layer_size} cm");
        add("Deep opacity maps", size, Shadowing::DeepOpacity, params);
    }
    let params = ShadowParams { resolution: 1024, ..filtered.clone() };
    add("Deep opacity maps", "1024 filtered, 6 layers from 0.15 cm".to_owned(), Shadowing::DeepOpacity, params.clone());
    let few = ShadowParams { n_strands: 5_000, ..params };
    add("Deep opacity maps", "the same, a quarter of the strands cast".to_owned(), Shadowing::DeepOpacity, few);
    for (layer_spacing, name) in [
        (LayerSpacing::Constant, "constant"),
        (LayerSpacing::Fibonacci, "Fibonacci"),
        (LayerSpacing::PowerOfTwo, "powers of two"),
    ] {
        let params = ShadowParams { layer_spacing, ..coarse.clone() };
        add("Deep opacity maps", format!("512, 6 layers from 0.15 cm, {name}"), Shadowing::DeepOpacity, params);
    }
    for (beyond_last, name) in [(BeyondLast::Ignore, "ignored"), (BeyondLast::Grow, "the last grows")] {
        let params = ShadowParams { beyond_last, n_layers: 3, ..coarse.clone() };
        add("Deep opacity maps", format!("512, 3 layers from 0.15 cm, beyond {name}"), Shadowing::DeepOpacity, params);
    }
    let still = ShadowParams { jitter: 0.0, ..coarse.clone() };
    add("Occupancy maps", "512, no jitter".to_owned(), Shadowing::Occupancy, still);
    add("Occupancy maps", "512".to_owned(), Shadowing::Occupancy, coarse.clone());
    add(
        "Occupancy maps",
        "1024, 3 x 3 taps".to_owned(),
        Shadowing::Occupancy,
        ShadowParams { jitter: 0.0, ..fine.clone() },
    );
    for tolerance in [0.005, 0.02, 0.1] {
        let params = ShadowParams { tolerance, ..coarse.clone() };
        add("Deep shadow maps", format!("512, within {tolerance}"), Shadowing::DeepShadow, params);
    }
    add("Deep shadow maps", "1024, 3 x 3 taps, within 0.02".to_owned(), Shadowing::DeepShadow, fine);
    for (n_voxels, n_steps) in [(48, 32), (96, 16), (96, 32), (96, 128), (160, 64)] {
        let params = ShadowParams { n_voxels, n_steps, ..coarse.clone() };
        add("Voxels", format!("{n_voxels}, {n_steps} steps"), Shadowing::Voxels, params);
    }
    cases
}

fn json_of(case: &Case, scores: &[ShadowScore], places: &[Place]) -> Vec<Value> {
    let one = |(score, place): (&ShadowScore, &Place)| {
        json!({
            "technique": case.name, "size": case.size, "scene": place.name, "resolution": score.resolution,
            "bytes": score.n_bytes, "build_ms": score.build_ms, "look_up_ms": score.look_up_ms,
            "mean_error": score.mean_error, "error_99": score.error_99, "bias": score.bias,
            "lit_error": score.lit_error,
        })
    };
    scores.iter().zip(places).map(one).collect()
}

fn table(gpu: &Gpu, rows: &[(Case, Vec<ShadowScore>)], places: &[Place]) -> String {
    let mut text = format!(
        "{}, {}. Errors of the share of the light that is left, times 1000: mean, 99th percentile, and mean at the lit front. \
         Seen through a disc of {FOOTPRINT_CM} cm.\n\n",
        gpu.adapter_info.name, gpu.adapter_info.driver_info
    );
    for place in places {
        let scene = &place.scene;
        let _ = writeln!(
            text,
            "- {}: {} strands, {} fragments, {:.2} of the light left on the average",
            place.name,
            scene.n_strands(),
            scene.n_probes(),
            scene.mean_left()
        );
    }
    text.push_str("\n| technique | size | MiB | build ms | look-up ms a million |");
    for place in places {
        let _ = write!(text, " {} |", place.name);
    }
    text.push_str("\n|---|---|---|---|---|");
    text.push_str(&"---|".repeat(places.len()));
    text.push('\n');
    for (case, scores) in rows {
        let first = &scores[0];
        let ms = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| format!("{ms:.2}"));
        let mib = first.n_bytes as f64 / f64::from(1 << 20);
        let _ = write!(
            text,
            "| {} | {} | {mib:.1} | {} | {} |",
            case.name,
            case.size,
            ms(first.build_ms),
            ms(first.look_up_ms)
        );
        for score in scores {
            let [mean, most, lit] = [score.mean_error, score.error_99, score.lit_error].map(|error| 1e3 * error);
            let _ = write!(text, " {mean:.0} / {most:.0} / {lit:.0} |");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_technique_is_measured() {
        let cases = cases();
        assert!(Shadowing::ALL.iter().all(|choice| cases.iter().any(|case| case.shadowing == *choice)));
    }
}
