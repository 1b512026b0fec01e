//! The embedded hairstyles: hair meshes authored by code on the baked head.
//!
//! Each style is a grid of root faces with its own rules for how a path grows from each corner: `roots.rs`
//! lays grids out, `gather.rs` leads hair to where it is held, one file a style says the rest. A style is
//! three or four layers: the hair itself, fly-aways that ignore its locks, and fine baby hairs along the
//! hairline.

mod bob;
mod braid;
mod bun;
mod crop;
mod curls;
mod gather;
mod knot;
mod long;
mod ponytail;
mod roots;

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::groom::{Groom, Layer, Source, StrandCount};
use lorelei_core::grow::{Growth, grow};
use lorelei_core::hair_mesh::HairMesh;
use lorelei_core::maps::{MapKind, Maps, ScalpMap};
use lorelei_core::mesh::TriMesh;
use lorelei_core::simulation::{HairKind, Moved, Pearl, SimulationSettings};
use lorelei_core::style::{StyleKind, StyleOp};

use super::sdf;
use roots::{Layout, Root, RootGrid, ScalpChart};

/// Strands of a whole style.
const N_STRANDS: u32 = 100_000;
const N_FLY_AWAYS: u32 = 1_800;
const N_BABY_HAIRS: u32 = 2_600;

/// What styles are authored on.
struct Studio {
    chart: ScalpChart,
    body: DistanceField,
    baby: Arc<ScalpMap>,
    fly_away: Arc<ScalpMap>,
}

/// How a style is made.
type Make = fn(&Studio) -> Result<Groom, String>;

/// All styles as (key, groom without its head).
/// Only those of `keys`, where it names any.
pub fn all(head: &TriMesh, keys: &[String]) -> Result<Vec<(&'static str, Groom)>, String> {
    let chart = ScalpChart::new(head).ok_or("the head has no scalp")?;
    let body = DistanceField::from_mesh(head, 112).map_err(|error| error.to_string())?;
    let (baby, fly_away) = (Arc::new(chart.baby_density()), Arc::new(chart.fly_away_density()));
    let studio = Studio { chart, body, baby, fly_away };
    let styles: [(&str, Make); 8] = [
        ("long", long::groom),
        ("bob", bob::groom),
        ("curls", curls::groom),
        ("crop", crop::groom),
        ("ponytail", ponytail::groom),
        ("bun", bun::groom),
        ("braid", braid::groom),
        ("knot", knot::groom),
    ];
    let is_wanted = |key: &str| keys.is_empty() || keys.iter().any(|wanted| wanted == key);
    let wanted = styles.into_iter().filter(|(key, _)| is_wanted(key));
    wanted.map(|(key, make)| Ok((key, moving(key, make(&studio)?)))).collect()
}

/// The style with what it is like when it moves: the kind of its hair, and how far from the root it is tied. A braid is a rope
/// below the nape, as thick as it is: guides know nothing of the strands that they are plaited with.
fn moving(key: &str, mut groom: Groom) -> Groom {
    let (kind, tied) = match key {
        "curls" => (HairKind::TightCurls, 0.0),
        "bob" => (HairKind::ThickWavy, 0.0),
        "ponytail" => (HairKind::FineStraight, 0.45),
        "bun" | "knot" => (HairKind::Tied, 1.0),
        "braid" => (HairKind::Tied, 0.3),
        _ => (HairKind::FineStraight, 0.0),
    };
    groom.simulation.take(kind);
    if key == "braid" {
        let SimulationSettings { moved, pearl, pearl_radius, .. } = &mut groom.simulation;
        (*moved, *pearl, *pearl_radius) = (Moved::Rope, Pearl::Growing, 1.6);
    }
    for layer in &mut groom.layers {
        layer.tied = tied;
    }
    groom
}

impl Studio {
    /// A hair mesh from a rule that says how each corner's path grows, and what becomes of it then.
    fn hair_mesh(
        &self,
        grid: &RootGrid,
        layers_at: &[f32],
        rule: impl Fn(&Root) -> (Vec3, Growth),
        after: impl Fn(&Root, &mut Vec<Vec3>),
    ) -> Result<HairMesh, String> {
        let mut paths: Vec<Vec<Vec3>> = grid
            .roots
            .iter()
            .map(|root| {
                let (flow, growth) = rule(root);
                let mut path = grow(&self.body, root.position, root.normal, flow, &growth);
                after(root, &mut path);
                path
            })
            .collect();
        let faces = part_at_shoulders(&mut paths, &grid.faces);
        HairMesh::from_paths(&paths, &faces, layers_at).map_err(|error| error.to_string())
    }

    /// Keep a path out of the body: no point nearer than `clearance`, which is reached over 3 cm.
    fn clear(&self, path: &mut [Vec3], clearance: f32) {
        let mut length = 0.0;
        for k in 1..path.len() {
            length += path[k].distance(path[k - 1]);
            let wanted = clearance * (length / 3.0).min(1.0);
            for _ in 0..3 {
                let distance = self.body.sample(path[k]);
                if distance < wanted {
                    let out = self.body.gradient(path[k]).normalize_or(Vec3::Y);
                    path[k] += (wanted - distance) * out;
                }
            }
        }
    }

    fn main_layer(&self, layout: &Layout, mesh: HairMesh) -> Layer {
        Layer {
            n_strands: N_STRANDS - N_FLY_AWAYS - N_BABY_HAIRS,
            maps: density(Arc::new(self.chart.hair_density(layout))),
            count: StrandCount::Total,
            seed: 1,
            ..Layer::new("Hair", Source::HairMesh(Arc::new(mesh)))
        }
    }

    /// Hair that is gathered, with the stack of combed hair: fine clumps within a few broad ones, a little
    /// unrest, no two ways of the same length.
    fn gathered_layer(&self, mesh: HairMesh, n_vertices: u32) -> Layer {
        Layer {
            n_strands: N_STRANDS - N_FLY_AWAYS - N_BABY_HAIRS,
            count: StrandCount::Total,
            maps: density(Arc::new(self.chart.combed_density())),
            seed: 1,
            vertices_per_strand: n_vertices,
            radius_um: 44.0,
            tip_radius: 0.3,
            style: vec![
                StyleOp {
                    strength: 0.35,
                    ramp: 0.6,
                    ..op(StyleKind::Clump { strands_per_clump: 260.0, flare: 0.3, stray: 0.6 })
                },
                StyleOp {
                    strength: 0.6,
                    ramp: 0.4,
                    ..op(StyleKind::Clump { strands_per_clump: 36.0, flare: 0.3, stray: 0.7 })
                },
                StyleOp {
                    ramp: 0.3,
                    ..op(StyleKind::Frizz { amplitude: 0.16, wavelength: 6.0, strands_per_clump: 260.0 })
                },
                StyleOp {
                    ramp: 0.3,
                    ..op(StyleKind::Frizz { amplitude: 0.06, wavelength: 3.2, strands_per_clump: 36.0 })
                },
                StyleOp {
                    ramp: 0.2,
                    ..op(StyleKind::Frizz { amplitude: 0.035, wavelength: 2.4, strands_per_clump: 1.0 })
                },
            ],
            ..Layer::new("Hair", Source::HairMesh(Arc::new(mesh)))
        }
    }

    /// A style of its hair, fly-aways that stray as `strays` says, and baby hairs of a length in centimetres.
    fn style(
        &self,
        name: &str,
        grid: &RootGrid,
        main: Layer,
        strays: Strays,
        baby_hairs_cm: f32,
    ) -> Result<Groom, String> {
        let fly_aways = fly_aways(self, &main, strays);
        let baby_hairs = self.baby_hairs(grid, &main, baby_hairs_cm)?;
        Ok(Groom { name: name.to_owned(), layers: vec![main, fly_aways, baby_hairs], ..Groom::default() })
    }

    /// Short fine hairs along the hairline, lying along the flow.
    fn baby_hairs(&self, grid: &RootGrid, main: &Layer, length: f32) -> Result<Layer, String> {
        let growth = Growth { length, lift: 0.22, fall: 0.02, weight: 0.0, clearance: 0.12, clear_over: 1.0 };
        let mesh = self.hair_mesh(
            grid,
            &[0.35, 0.7, 1.0],
            |root| (root.flow, Growth { length: length * (0.8 + 0.4 * root.along), ..growth }),
            |_, _| {},
        )?;
        Ok(Layer {
            name: "Baby hairs".to_owned(),
            source: Source::HairMesh(Arc::new(mesh)),
            n_strands: N_BABY_HAIRS,
            vertices_per_strand: 10,
            seed: 3,
            radius_um: 0.55 * main.radius_um,
            tip_radius: 0.2,
            maps: density(Arc::clone(&self.baby)),
            count: StrandCount::Total,
            style: vec![
                op(StyleKind::Length { variation: 0.7, strands_per_clump: 1.0 }),
                op(StyleKind::Clump { strands_per_clump: 12.0, flare: 0.2, stray: 0.6 }),
                op(StyleKind::Frizz { amplitude: 0.16, wavelength: 1.6, strands_per_clump: 1.0 }),
                op(StyleKind::Deviate { share: 0.3, amplitude: 0.35, lift: 0.1, whole: 0.0 }),
            ],
            ..main.clone()
        })
    }
}

/// Height at which hair that the shoulder parts begins to open and is open, centimetres.
const SPLITS_AT: (f32, f32) = (-7.0, -17.0);

/// On which side of the shoulder a path hangs; `None` where it ends above.
fn before_shoulder(path: &[Vec3]) -> Option<bool> {
    // The ridge of the shoulders is at z = -5.6, about 18.5 cm under the eyes.
    path.last().filter(|tip| tip.y < -18.0).map(|tip| tip.z > -5.6)
}

/// Strands are blended from their face's corners: where some hang before the shoulder and some behind it,
/// they would run through it. There the face's corners all go one way: those that do not get a second
/// path, their own down to the neck and their neighbour's from there, so that hair opens over the shoulder
/// and nowhere higher.
fn part_at_shoulders(paths: &mut Vec<Vec<Vec3>>, faces: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let side: Vec<Option<bool>> = paths.iter().map(|path| before_shoulder(path)).collect();
    let mut second: HashMap<u32, u32> = HashMap::new();
    let mut parted = faces.to_vec();
    for (face, parted) in faces.iter().zip(&mut parted) {
        // Corners are (row, row + 1) of one column, then (row + 1, row) of the next.
        let Some(way) = face.iter().find_map(|&v| side[v as usize]) else { continue };
        let goes = |i: usize| side[face[i] as usize].is_none_or(|s| s == way);
        let Some(leader) = (0..4).find(|&i| side[face[i] as usize] == Some(way)) else { continue };
        for i in (0..4).filter(|&i| !goes(i)) {
            let beside = 3 - i;
            let model = face[if goes(beside) { beside } else { leader }] as usize;
            parted[i] = *second.entry(face[i]).or_insert_with(|| {
                let own = &paths[face[i] as usize];
                let (n_own, n_model) = (own.len() - 1, paths[model].len() - 1);
                let path = (0..=n_own).map(|k| {
                    let p = own[k];
                    // The neighbour at the same share of its length.
                    let at = k as f32 / n_own as f32 * n_model as f32;
                    let beside =
                        paths[model][at as usize].lerp(paths[model][(at as usize + 1).min(n_model)], at.fract());
                    p.lerp(beside, sdf::smoothstep(SPLITS_AT.0, SPLITS_AT.1, p.y.min(beside.y)))
                });
                let path = path.collect();
                paths.push(path);
                paths.len() as u32 - 1
            });
        }
    }
    parted
}

/// How fly-aways leave their locks: how far, in centimetres, and what else they do.
struct Strays {
    amplitude: f32,
    extra: Vec<StyleOp>,
}

impl Strays {
    fn by(amplitude: f32) -> Self {
        Self { amplitude, extra: Vec::new() }
    }
}

/// Hairs that left their locks: the main layer's paths, each its own way.
fn fly_aways(studio: &Studio, main: &Layer, Strays { amplitude, extra }: Strays) -> Layer {
    let mut style = vec![
        op(StyleKind::Length { variation: 0.45, strands_per_clump: 1.0 }),
        op(StyleKind::Frizz { amplitude: 0.22 * amplitude, wavelength: 5.0, strands_per_clump: 1.0 }),
        StyleOp { ramp: 1.3, ..op(StyleKind::Deviate { share: 1.0, amplitude, lift: 0.5, whole: 0.0 }) },
    ];
    style.extend(extra);
    Layer {
        name: "Fly-aways".to_owned(),
        n_strands: N_FLY_AWAYS,
        seed: 2,
        radius_um: 0.85 * main.radius_um,
        maps: density(Arc::clone(&studio.fly_away)),
        count: StrandCount::Total,
        style,
        ..main.clone()
    }
}

fn density(map: Arc<ScalpMap>) -> Maps {
    Maps::from([(MapKind::Density, map)])
}

fn op(kind: StyleKind) -> StyleOp {
    StyleOp::new(kind)
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}
