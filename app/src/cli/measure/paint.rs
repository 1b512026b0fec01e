//! What a stroke of paint costs: the texels, the edit with its inverse, the strands that density chooses, and undo.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use lorelei_core::binding::{bind_layer, rebind_layer};
use lorelei_core::brush::Falloff;
use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, StrandCount};
use lorelei_core::history::{History, Merge};
use lorelei_core::io::Watch;
use lorelei_core::maps::atlas::ScalpAtlas;
use lorelei_core::maps::paint::{Dab, PaintMode, Place, Stroke};
use lorelei_core::maps::{MapKind, ScalpMap};

use super::{Line, median_ms};
use crate::cli::CliError;

/// Texels along a side of the map that is painted.
const SIDE: u32 = 1024;
const RADIUS_CM: f32 = 3.0;
const N_EVENTS: usize = 61;

/// A stroke with a 3 cm brush over the crown of the default groom, on both sides of the head, into a map of
/// 1024 x 1024 texels.
pub fn paint(lines: &mut Vec<Line>) -> Result<(), CliError> {
    let mut groom: Groom = lorelei_assets::default_groom();
    groom.layers.truncate(1);
    groom.layers[0].count = StrandCount::WhereFull;
    let full = Arc::new(ScalpMap::filled(SIDE, SIDE, 255));
    groom.layers[0].maps.insert(MapKind::Density, Arc::clone(&full));
    let head = groom.head.clone().ok_or_else(|| CliError::Failed("the default groom has no head".to_owned()))?;
    let start = Instant::now();
    let atlas = Arc::new(ScalpAtlas::new(&head.mesh, SIDE, SIDE));
    let ms = start.elapsed().as_secs_f64() * 1e3;
    let n = atlas.n_texels();
    lines.push(Line { what: "paint: prepare, once a map's size", n, ms, note: "texels on the scalp".to_owned() });

    let mut stroke =
        Stroke::new(atlas, ScalpMap::clone(&full), &MapKind::Density, Falloff::Smooth, PaintMode::Paint, 0.0);
    let mut history = History::default();
    let (_, top) = head.mesh.bounds().unwrap_or_default();
    let mut failed = None;
    let (mut event, mut worst) = (0, 0.0_f64);
    let ms = median_ms(N_EVENTS, || {
        let start = Instant::now();
        // From the forehead's edge over the crown.
        let along = event as f32 / N_EVENTS as f32;
        event += 1;
        let tiles = stroke.go_on(&Dab {
            place: Place::Surface { centre: Vec3::new(3.0, top.y - 1.0, 6.0 - 12.0 * along), radius: RADIUS_CM },
            strength: 0.5,
            eye: None,
            is_symmetric: true,
        });
        let edit = Edit::PaintTiles { layer_idx: 0, kind: MapKind::Density, tiles };
        failed = history.apply(&mut groom, "paint", edit, Merge::Stroke(1)).err().or(failed.take());
        worst = worst.max(start.elapsed().as_secs_f64() * 1e3);
    });
    if let Some(why) = failed {
        return Err(CliError::failed(why));
    }
    let n = (SIDE * SIDE) as usize;
    let note = format!("worst {worst:.2}; {} bytes of undo for the stroke, the map is {n}", history.n_bytes());
    lines.push(Line { what: "paint: an event, its edit and its inverse", n, ms, note });

    let known = bind_layer(&groom.layers[0], Some(&head));
    let ms = median_ms(5, || drop(rebind_layer(&groom.layers[0], Some(&head), Some(&known), Watch::default())));
    let n = known.n_strands();
    lines.push(Line { what: "paint: strands chosen by another density", n, ms, note: "all cores".to_owned() });
    Ok(())
}
