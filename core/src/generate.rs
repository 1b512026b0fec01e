//! Strands from guides, on the CPU: the reference that `generate.wgsl` repeats with the same names.
//!
//! A strand is the Catmull-Rom curve through its blended guides, cut to its length, drawn into its
//! clumps, displaced around its path by the other operators, kept out of the head, and given a width. All
//! is evaluated directly: a strand reads the paths of its clumps' middle strands at its own parameter, so
//! no strand waits for another. One strand is one thread's work on the GPU, because the twist-free frame
//! and the arc length are carried from vertex to vertex.

use glam::{Affine3A, Vec3};
use rayon::prelude::*;

use crate::binding::LayerBinding;
use crate::curve::catmull_rom_weights;
use crate::distance_field::DistanceField;
use crate::groom::Layer;
use crate::hash::{combine, random, unit};
use crate::strands::Strands;
use crate::style::{StyleKind, StyleOp, envelope};

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'a> {
    pub world_from_head: Affine3A,
    /// The head's, in head space.
    pub field: Option<&'a DistanceField>,
    /// Level of detail: share of the strands that are drawn, 0-1.
    pub lod: f32,
}

impl Default for Pose<'_> {
    fn default() -> Self {
        Self { world_from_head: Affine3A::IDENTITY, field: None, lod: 1.0 }
    }
}

/// Clump operators that take part; more in one stack are left out.
pub const MOST_CLUMP_OPS: usize = 3;
/// Operators that displace a strand and take part; more in one stack are left out.
pub const MOST_DISPLACING_OPS: usize = 12;
/// Distance from the head below which strands are pushed out, in centimetres; half to one and a half of
/// it from strand to strand, so that pushed hair is no sheet.
pub const KEEP_OUT: f32 = 0.3;
/// Arc length over which a strand grows out of the scalp to that distance, in centimetres.
pub const GROW_OUT: f32 = 2.0;
/// Share of a strand, at its tip, over which it tapers (look.md: the last tenth).
pub const TAPER: f32 = 0.1;
/// Strands at the end of the order of detail that are getting thinner, as a share of those drawn.
pub const LOD_FADE: f32 = 0.1;

/// How many strands of a layer are drawn at a level of detail, and how wide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lod {
    pub n_drawn: u32,
    /// Strand `s` has this much of its width: `scale * clamp((end - s) / fade, 0, 1)`.
    pub scale: f32,
    pub end: f32,
    pub fade: f32,
}

impl Lod {
    /// Continuous in `lod`: strands thin out before they vanish, and the others widen so that the sum of
    /// the widths stays.
    pub fn new(n_strands: usize, lod: f32) -> Self {
        let n = n_strands as f32;
        let full = (lod.clamp(0.0, 1.0) * n).max(n.min(1.0));
        let fade = LOD_FADE * full;
        let end = full + fade;
        // The integral over the strands of clamp((end - s) / fade, 0, 1).
        let cropped = (end - n).max(0.0);
        let sum = full + (fade * fade - cropped * cropped) / (2.0 * fade).max(1e-6);
        Self { n_drawn: (end.ceil() as u32).min(n_strands as u32), scale: n / sum.max(1e-3), end, fade: fade.max(1e-6) }
    }

    /// Width of strand `strand_idx` as a share of its width at level of detail 1.
    pub fn width(&self, strand_idx: usize) -> f32 {
        self.scale * ((self.end - strand_idx as f32) / self.fade).clamp(0.0, 1.0)
    }
}

/// Make the strands of a layer from the guides' present places (world space, laid out as
/// `binding.guides.positions`).
pub fn generate(binding: &LayerBinding, layer: &Layer, guide_positions: &[Vec3], pose: &Pose<'_>) -> Strands {
    assert_eq!(guide_positions.len(), binding.guides.positions.len(), "as many guide vertices as were bound");
    let n_vertices = layer.vertices_per_strand.clamp(4, 128) as usize;
    let lod = Lod::new(binding.n_strands(), pose.lod);
    let n_drawn = lod.n_drawn as usize;
    let generator = Generator { binding, style: &layer.style, guide_positions, pose, n_vertices };
    let mut points = vec![Vec3::ZERO; n_drawn * n_vertices];
    points.par_chunks_exact_mut(n_vertices).enumerate().for_each(|(strand_idx, out)| generator.strand(strand_idx, out));
    let radii_um = (0..n_drawn)
        .flat_map(|strand_idx| {
            let scale = binding.radius_scales.get(strand_idx).copied().unwrap_or(1.0) * lod.width(strand_idx);
            (0..n_vertices)
                .map(move |v| layer.radius_um * scale * taper(v as f32 / (n_vertices - 1) as f32, layer.tip_radius))
        })
        .collect();
    Strands {
        points,
        offsets: (0..=n_drawn as u32).map(|s| s * n_vertices as u32).collect(),
        ids: binding.ids[..n_drawn].to_vec(),
        radii_um,
        root_uvs: binding.root_uvs.get(..n_drawn).unwrap_or_default().to_vec(),
        ..Strands::default()
    }
}

/// Radius at parameter `t` as a share of the root's.
pub fn taper(t: f32, tip_radius: f32) -> f32 {
    let x = ((t - (1.0 - TAPER)) / TAPER).clamp(0.0, 1.0);
    1.0 + x * (tip_radius - 1.0)
}

// What a random number is for: the second argument of `random`, plus the operator's seed.
const FOR_LENGTH: u32 = 1;
const FOR_STRAY: u32 = 2;
const FOR_LOOSE_CLUMP: u32 = 3;
const FOR_PHASE: u32 = 4;
const FOR_PERIOD: u32 = 5;
const FOR_SIDE: u32 = 6;
const FOR_SIZE: u32 = 7;
const FOR_NOISE: u32 = 8;
const FOR_SHARE: u32 = 9;
const FOR_START: u32 = 10;
const FOR_KEEP_OUT: u32 = 11;

struct Generator<'a> {
    binding: &'a LayerBinding,
    style: &'a [StyleOp],
    guide_positions: &'a [Vec3],
    pose: &'a Pose<'a>,
    n_vertices: usize,
}

/// A clump operator of a strand: the path it is drawn to, and how strongly.
#[derive(Clone, Copy, Default)]
struct Pull {
    middle: usize,
    strength: f32,
    from: f32,
    ramp: f32,
    flare: f32,
    /// How much of the pull the strand itself follows.
    follow: f32,
}

impl Pull {
    /// Strength at the guides' parameter `t`, without the strand's own stray.
    fn at(&self, t: f32) -> f32 {
        let x = ((t - 0.6) / 0.4).clamp(0.0, 1.0);
        envelope(self.strength, self.from, self.ramp, t) * (1.0 - self.flare * x * x)
    }
}

/// A strand's own numbers in one operator.
#[derive(Clone, Copy, Default)]
struct Shape<'a> {
    op: Option<&'a StyleOp>,
    seed: u32,
    numbers: [f32; 4],
    away: f32,
}

/// Displacement across the strand (right, up) and away from the head (z), in centimetres.
fn displacement(shapes: &[Shape<'_>], t: f32, arc_length: f32) -> Vec3 {
    let mut offset = Vec3::ZERO;
    for Shape { op, seed, numbers: [a, phase, x, y], away } in shapes {
        let Some(op) = op else { continue };
        match op.kind {
            StyleKind::Length { .. } | StyleKind::Clump { .. } => {}
            StyleKind::Wave { .. } => {
                let size = op.envelope(t) * smoothstep(0.0, 0.5 * a, arc_length);
                offset += size * sin_turns(phase + arc_length / a) * Vec3::new(*x, *y, 0.0);
            }
            StyleKind::Curl { loosen, .. } => {
                let turns = phase + x * arc_length / (a * (1.0 + 0.5 * loosen * t));
                let size = y * (1.0 + loosen * t) * op.envelope(t) * smoothstep(0.0, *a, arc_length);
                offset += size * Vec3::new(sin_turns(turns + 0.25), sin_turns(turns), 0.0);
            }
            StyleKind::Frizz { .. } => {
                let along = arc_length / a;
                let size = x * op.envelope(t) * smoothstep(0.0, 1.0, along);
                offset += size * Vec3::new(noise(*seed, along), noise(combine(*seed, 1), along), 0.0);
            }
            StyleKind::Deviate { .. } => {
                offset += envelope(op.strength, *a, op.ramp, t) * Vec3::new(*x, *y, *away);
            }
        }
    }
    offset
}

fn purpose(purpose: u32, op: &StyleOp) -> u32 {
    combine(op.seed, purpose)
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

impl Generator<'_> {
    fn active(&self) -> impl Iterator<Item = &StyleOp> {
        self.style.iter().filter(|op| op.on && op.strength != 0.0)
    }

    /// Hash that all strands of the operator's clump share.
    fn clump_seed(&self, strand_idx: usize, op: &StyleOp) -> u32 {
        let clumps = &self.binding.clumps;
        self.binding.seeds[clumps.middle(strand_idx, clumps.size_idx(op.kind))]
    }

    /// Share of the strand's length that is left.
    fn cut(&self, strand_idx: usize) -> f32 {
        let mut cut = 1.0;
        for op in self.active() {
            if let StyleKind::Length { variation, .. } = op.kind {
                let h = random(self.clump_seed(strand_idx, op), purpose(FOR_LENGTH, op));
                cut *= 1.0 - op.strength * variation.clamp(0.0, 0.98) * h;
            }
        }
        cut
    }

    fn pulls(&self, strand_idx: usize) -> ([Pull; MOST_CLUMP_OPS], usize) {
        let clumps = &self.binding.clumps;
        let mut pulls = [Pull::default(); MOST_CLUMP_OPS];
        let mut n_pulls = 0;
        for op in self.active() {
            let StyleKind::Clump { flare, stray, .. } = op.kind else { continue };
            if n_pulls == MOST_CLUMP_OPS {
                break;
            }
            let middle = clumps.middle(strand_idx, clumps.size_idx(op.kind));
            let stray_h = random(self.binding.seeds[strand_idx], purpose(FOR_STRAY, op));
            let loose_h = random(self.binding.seeds[middle], purpose(FOR_LOOSE_CLUMP, op));
            pulls[n_pulls] = Pull {
                middle,
                strength: op.strength * (1.0 - 0.5 * stray * loose_h),
                from: op.from,
                ramp: op.ramp,
                flare,
                // Most follow closely, a few hardly.
                follow: 1.0 - stray * stray_h * stray_h,
            };
            n_pulls += 1;
        }
        (pulls, n_pulls)
    }

    /// Control point `i` of a strand, -1 and n_vertices being the mirrored ends. World space.
    fn control(&self, strand_idx: usize, i: i32) -> Vec3 {
        let last = self.binding.guides.n_vertices as i32 - 1;
        if i < 0 {
            return 2.0 * self.control(strand_idx, 0) - self.control(strand_idx, 1);
        }
        if i > last {
            return 2.0 * self.control(strand_idx, last) - self.control(strand_idx, last - 1);
        }
        let mut p = Vec3::ZERO;
        for influence in self.binding.influences(strand_idx) {
            let at = influence.guide_idx * self.binding.guides.n_vertices + i as u32;
            p += influence.weight * self.guide_positions[at as usize];
        }
        let left = 1.0 - smoothstep(0.0, 1.0, i as f32 / last as f32) * (1.0 - self.binding.offset_at_tip);
        p + left * self.pose.world_from_head.transform_vector3(self.binding.root_offsets[strand_idx])
    }

    /// A strand's path before any style, at the guides' parameter `t`, 0 root to 1 tip.
    fn path(&self, strand_idx: usize, t: f32) -> Vec3 {
        let n_segments = self.binding.guides.n_vertices as i32 - 1;
        let u = t * n_segments as f32;
        let segment = (u as i32).min(n_segments - 1);
        let w = catmull_rom_weights(u - segment as f32);
        w[0] * self.control(strand_idx, segment - 1)
            + w[1] * self.control(strand_idx, segment)
            + w[2] * self.control(strand_idx, segment + 1)
            + w[3] * self.control(strand_idx, segment + 2)
    }

    /// The strand's path drawn into its clumps: each clump's middle is itself drawn by the clumps before.
    fn clumped(&self, strand_idx: usize, pulls: &[Pull], t: f32) -> Vec3 {
        let mut p = self.path(strand_idx, t);
        let mut middles = [Vec3::ZERO; MOST_CLUMP_OPS];
        for (middle, pull) in middles.iter_mut().zip(pulls) {
            *middle = self.path(pull.middle, t);
        }
        for (j, pull) in pulls.iter().enumerate() {
            let strength = pull.at(t);
            let middle = middles[j];
            for finer in &mut middles[j + 1..] {
                *finer += strength * (middle - *finer);
            }
            p += strength * pull.follow * (middle - p);
        }
        p
    }

    fn strand(&self, strand_idx: usize, out: &mut [Vec3]) {
        let world_from_head = &self.pose.world_from_head;
        let seed = self.binding.seeds[strand_idx];
        let cut = self.cut(strand_idx);
        let (pulls, n_pulls) = self.pulls(strand_idx);
        let pulls = &pulls[..n_pulls];
        let last = self.n_vertices - 1;
        let (shapes, n_shapes) = self.shapes(strand_idx);
        let shapes = &shapes[..n_shapes];
        let base_at = |v: usize| self.clumped(strand_idx, pulls, cut * v as f32 / last as f32);

        let normal_in_head = self.binding.root_normals[strand_idx];
        let outwards = world_from_head.transform_vector3(normal_in_head);
        let side = world_from_head.transform_vector3(any_tangent(normal_in_head));
        let (mut before, mut base) = (base_at(0), base_at(0));
        let mut tangent = outwards;
        let mut right = side;
        let mut arc_length = 0.0;
        for v in 0..=last {
            let after = if v < last { base_at(v + 1) } else { base };
            arc_length += base.distance(before);
            let new_tangent = (after - before).normalize_or(tangent);
            right = transport(right, tangent, new_tangent);
            tangent = new_tangent;
            let up = tangent.cross(right);
            let t = v as f32 / last as f32;
            let offset = displacement(shapes, t, arc_length);
            let p = base + offset.x * right + offset.y * up + offset.z * outwards;
            out[v] = if v == 0 { p } else { self.keep_out(p, arc_length, seed) };
            (before, base) = (base, after);
        }
    }

    /// The strand's own numbers in every operator that displaces it.
    fn shapes(&self, strand_idx: usize) -> ([Shape<'_>; MOST_DISPLACING_OPS], usize) {
        let seed = self.binding.seeds[strand_idx];
        let mut shapes = [Shape::default(); MOST_DISPLACING_OPS];
        let mut n_shapes = 0;
        for op in self.active() {
            if n_shapes == MOST_DISPLACING_OPS {
                break;
            }
            let clump = self.clump_seed(strand_idx, op);
            let of_clump = |name: u32| random(clump, purpose(name, op));
            let of_strand = |name: u32| random(seed, purpose(name, op));
            let numbers = match op.kind {
                StyleKind::Length { .. } | StyleKind::Clump { .. } => continue,
                StyleKind::Wave { amplitude, wavelength, .. } => {
                    // Mostly to the sides, as hair lies on hair.
                    let (sin, cos) = ((of_clump(FOR_SIDE) - 0.5) * 2.0).sin_cos();
                    let size = amplitude * (0.7 + 0.6 * of_clump(FOR_SIZE));
                    let period = wavelength.max(0.05) * (0.85 + 0.3 * of_clump(FOR_PERIOD));
                    [period, of_clump(FOR_PHASE), size * cos, size * sin]
                }
                StyleKind::Curl { radius, pitch, .. } => {
                    let hand = if of_clump(FOR_SIDE) < 0.5 { -1.0 } else { 1.0 };
                    let period = pitch.max(0.05) * (0.85 + 0.3 * of_clump(FOR_PERIOD));
                    [period, of_clump(FOR_PHASE), hand, radius * (0.8 + 0.4 * of_clump(FOR_SIZE))]
                }
                StyleKind::Frizz { amplitude, wavelength, .. } => [wavelength.max(0.05), 0.0, amplitude, 0.0],
                StyleKind::Deviate { share, amplitude, lift } => {
                    if of_strand(FOR_SHARE) >= share {
                        continue;
                    }
                    // Each leaves the others at its own place.
                    let from = op.from + 0.7 * (1.0 - op.from) * of_strand(FOR_START);
                    let size = amplitude * (0.3 + 0.7 * of_strand(FOR_SIZE));
                    let around = size * (1.0 - lift.abs());
                    let turns = of_strand(FOR_SIDE);
                    shapes[n_shapes].away = size * lift;
                    [from, 0.0, around * sin_turns(turns + 0.25), around * sin_turns(turns)]
                }
            };
            let shape = &mut shapes[n_shapes];
            (shape.op, shape.numbers) = (Some(op), numbers);
            shape.seed = combine(clump, purpose(FOR_NOISE, op));
            n_shapes += 1;
        }
        (shapes, n_shapes)
    }

    /// Push a vertex out of the head. Distances below the margin are squeezed between the skin and the
    /// margin, in their order: what lies deeper stays deeper, and nothing is flattened.
    fn keep_out(&self, p: Vec3, arc_length: f32, seed: u32) -> Vec3 {
        let Some(field) = self.pose.field else { return p };
        let in_head = self.pose.world_from_head.inverse().transform_point3(p);
        let margin = KEEP_OUT * (0.5 + random(seed, FOR_KEEP_OUT)) * smoothstep(0.0, GROW_OUT, arc_length) + 1e-3;
        let distance = field.sample(in_head);
        if distance >= margin {
            return p;
        }
        let wanted = margin * (distance / margin - 1.0).exp();
        let out = field.gradient(in_head).normalize_or(Vec3::ZERO);
        self.pose.world_from_head.transform_point3(in_head + (wanted - distance) * out)
    }
}

/// A unit vector across `normal`: X turned by the shortest way that takes Y to `normal`. No scalp faces
/// straight down, where this way is not unique.
fn any_tangent(normal: Vec3) -> Vec3 {
    let across = Vec3::X - normal.x / (1.0 + normal.y).max(1e-3) * (Vec3::Y + normal);
    across.normalize_or(Vec3::X)
}

/// Carry a vector across a strand from one tangent to the next by the shortest rotation: no twist.
fn transport(right: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let carried = right - right.dot(to) / (1.0 + from.dot(to)).max(1e-3) * (from + to);
    (carried - carried.dot(to) * to).normalize_or(right)
}

/// Sine of so many turns; reduced first, so that single precision is the same everywhere.
fn sin_turns(turns: f32) -> f32 {
    let x = turns - turns.floor() - 0.5;
    -(std::f32::consts::TAU * x).sin()
}

/// Smooth noise in about [-1, 1] over one dimension: two octaves of gradient noise.
fn noise(seed: u32, x: f32) -> f32 {
    gradient_noise(seed, x) + 0.5 * gradient_noise(combine(seed, 2), 2.0 * x + 0.37)
}

fn gradient_noise(seed: u32, x: f32) -> f32 {
    let cell = x.floor();
    let f = x - cell;
    let gradient = |cell: i32| 2.0 * unit(combine(seed, cell as u32)) - 1.0;
    let (a, b) = (gradient(cell as i32) * f, gradient(cell as i32 + 1) * (f - 1.0));
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    2.0 * (a + fade * (b - a))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::binding::bind_layer;
    use crate::curve::catmull_rom;
    use crate::groom::{Head, ScalpMap, Source};
    use crate::hair_mesh::tests::straight_grid;
    use crate::hair_mesh::{HairMesh, Weld};
    use crate::mean_value::mean_value_weights;
    use crate::mesh::TriMesh;
    use crate::mesh_query::tests::sphere;
    use crate::strands::polyline_length;

    fn layer(mesh: HairMesh, n_strands: u32) -> Layer {
        Layer { n_strands, vertices_per_strand: 24, ..Layer::new("test", Source::HairMesh(Arc::new(mesh))) }
    }

    fn make(layer: &Layer, pose: &Pose<'_>) -> (LayerBinding, Strands) {
        let binding = bind_layer(layer, None);
        let strands = generate(&binding, layer, &binding.guides.positions, pose);
        (binding, strands)
    }

    /// A grid that leans, bends and spreads more from layer to layer.
    fn bent_grid() -> HairMesh {
        let mut mesh = straight_grid(3, 0);
        let all: Vec<usize> = (0..9).collect();
        for k in 0..5 {
            let turn = glam::Quat::from_rotation_z(-0.35 * k as f32);
            mesh.extrude(&all, Weld::Neighbours, |v| v.position * Vec3::new(1.1, 1.0, 1.0) + turn * Vec3::Y * 2.0)
                .unwrap();
        }
        mesh
    }

    #[test]
    fn a_straight_hair_mesh_gives_straight_parallel_strands() {
        let (_, strands) = make(&layer(straight_grid(3, 4), 300), &Pose::default());
        for strand in strands.iter() {
            for (v, p) in strand.iter().enumerate() {
                let expected = strand[0] + Vec3::Y * (4.0 * v as f32 / 23.0);
                assert!(p.distance(expected) < 1e-4, "{p} {expected}");
            }
        }
        // Weights sum to 1, and roots are on their face.
        let (binding, _) = make(&layer(bent_grid(), 300), &Pose::default());
        for strand_idx in 0..300 {
            let sum: f32 = binding.influences(strand_idx).iter().map(|i| i.weight).sum();
            assert!((sum - 1.0).abs() < 1e-5);
            assert!(binding.root_offsets[strand_idx].length() < 1e-4);
        }
    }

    #[test]
    fn strands_are_traced_as_the_paper_says() {
        // Yuksel et al. 2009, 3.1: weights of the root in its face, applied in every layer, then the spline.
        let mesh = bent_grid();
        let (binding, strands) = make(&layer(mesh.clone(), 200), &Pose::default());
        let surface = crate::roots::RootSurface::of_hair_mesh(&mesh);
        let roots = surface.sequence(200, 0);
        for (strand_idx, root) in roots.iter().enumerate() {
            let bundle = root.face as usize;
            let corners: Vec<Vec3> = (0..4).map(|c| mesh.corner_positions(bundle, c).next().unwrap()).collect();
            let weights = mean_value_weights(&corners, root.position);
            let control: Vec<Vec3> = (0..mesh.layers.len())
                .map(|k| (0..4).map(|c| weights[c] * mesh.corner_positions(bundle, c).nth(k).unwrap()).sum())
                .collect();
            assert_eq!(binding.ids[strand_idx], strand_idx as u32);
            let length = polyline_length(&control);
            for p in strands.strand(strand_idx) {
                let on_curve = (0..=1000).map(|k| catmull_rom(&control, 5.0 * k as f32 / 1000.0));
                let nearest = on_curve.map(|q| q.distance(*p)).fold(f32::MAX, f32::min);
                // The guides' samples meet the paper's curve at every layer; in between, the curve through the
                // samples leaves the curve through the layers by less than this share of the length.
                assert!(nearest < 2e-3 * length, "{nearest} of {length}");
            }
        }
    }

    #[test]
    fn strands_at_corners_run_along_their_edges() {
        let mesh = bent_grid();
        let mut binding = bind_layer(&layer(mesh.clone(), 16), None);
        let chains = mesh.chains();
        for corner in 0..4 {
            binding.influences[corner] =
                crate::guides::Influence { guide_idx: chains.of_bundle[4][corner], weight: 1.0 };
            binding.influence_offsets[corner + 1] = corner as u32 + 1;
            binding.root_offsets[corner] = Vec3::ZERO;
        }
        let layer = Layer { vertices_per_strand: 16, ..layer(mesh.clone(), 16) };
        let strands = generate(&binding, &layer, &binding.guides.positions, &Pose { lod: 0.25, ..Pose::default() });
        assert!((4..=5).contains(&strands.n_strands()));
        for corner in 0..4 {
            for p in mesh.corner_positions(4, corner) {
                let nearest = strands.strand(corner).iter().map(|q| q.distance(p)).fold(f32::MAX, f32::min);
                assert!(nearest < 1e-4, "{nearest}");
            }
        }
    }

    fn styled(kind: StyleKind) -> Layer {
        Layer { style: vec![StyleOp::new(kind)], ..layer(bent_grid(), 2000) }
    }

    #[test]
    fn every_style_kind_does_what_it_says() {
        let (_, plain) = make(&layer(bent_grid(), 2000), &Pose::default());
        for kind in StyleKind::DEFAULTS {
            let styled = styled(kind);
            let (binding, strands) = make(&styled, &Pose::default());
            assert!(strands.points.iter().all(|p| p.is_finite()));
            assert!(strands != plain, "{} does nothing", kind.label());
            let off = Layer { style: vec![StyleOp { strength: 0.0, ..StyleOp::new(kind) }], ..styled.clone() };
            assert!(make(&off, &Pose::default()).1 == plain, "{} at strength 0 does something", kind.label());
            let mut n_moved = 0;
            for strand_idx in 0..2000 {
                let (a, b) = (plain.strand(strand_idx), strands.strand(strand_idx));
                assert!(a[0].distance(b[0]) < 1e-5, "{} moves the root", kind.label());
                n_moved += usize::from(a[23].distance(b[23]) > 1e-3);
                let shift = a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                match kind {
                    StyleKind::Length { variation, .. } => {
                        let ratio = polyline_length(b) / polyline_length(a);
                        assert!((1.0 - variation - 0.05..=1.001).contains(&ratio), "{ratio}");
                    }
                    StyleKind::Clump { .. } => {
                        let middle = binding.clumps.middle(strand_idx, Some(0));
                        let apart =
                            |strands: &Strands| strands.strand(strand_idx)[18].distance(strands.strand(middle)[18]);
                        assert!(apart(&strands) <= apart(&plain) + 1e-4);
                    }
                    StyleKind::Wave { amplitude, .. } => assert!(shift <= 1.31 * amplitude),
                    StyleKind::Curl { radius, loosen, .. } => assert!(shift <= 1.21 * radius * (1.0 + loosen)),
                    StyleKind::Frizz { amplitude, .. } => assert!(shift <= 3.0 * amplitude),
                    StyleKind::Deviate { amplitude, .. } => assert!(shift <= 1.01 * amplitude),
                }
            }
            let expected = match kind {
                StyleKind::Deviate { share, .. } => 2000.0 * share,
                // The middles stay where they are.
                StyleKind::Length { .. }
                | StyleKind::Clump { .. }
                | StyleKind::Wave { .. }
                | StyleKind::Curl { .. }
                | StyleKind::Frizz { .. } => 1950.0,
            };
            assert!((n_moved as f32 - expected).abs() < 4.0 * expected.sqrt(), "{}: {n_moved}", kind.label());
        }
    }

    #[test]
    fn moving_one_vertex_a_little_moves_no_strand_much() {
        let mut style: Vec<StyleOp> = StyleKind::DEFAULTS.into_iter().map(StyleOp::new).collect();
        style.insert(0, StyleOp::new(StyleKind::Clump { strands_per_clump: 300.0, flare: 0.0, stray: 0.2 }));
        let styled = Layer { style, ..layer(bent_grid(), 2000) };
        let (_, before) = make(&styled, &Pose::default());
        for (layer_idx, vertex) in [(1, 5), (3, 6), (5, 9)] {
            let mut mesh = bent_grid();
            mesh.layers[layer_idx].positions[vertex] += Vec3::new(0.05, -0.06, 0.06);
            let moved = Layer { source: Source::HairMesh(Arc::new(mesh)), ..styled.clone() };
            let (_, after) = make(&moved, &Pose::default());
            let far = before.points.iter().zip(&after.points).map(|(a, b)| a.distance(*b));
            let mut far: Vec<f32> = far.collect();
            far.sort_by(f32::total_cmp);
            // A strand whose nearest middle changes jumps to its neighbour clump; that is one in thousands.
            let most = far[far.len() * 995 / 1000];
            assert!(most < 3.0 * 0.1, "1 mm became {most} cm");
        }
    }

    #[test]
    fn covered_area_stays_over_levels_of_detail_and_nothing_pops() {
        let (binding, full) = make(&layer(bent_grid(), 3000), &Pose::default());
        let layer = layer(bent_grid(), 3000);
        let area = |strands: &Strands| -> f32 {
            (0..strands.n_strands())
                .map(|s| polyline_length(strands.strand(s)) * strands.radii_um[strands.range(s).start])
                .sum()
        };
        let at = |lod| generate(&binding, &layer, &binding.guides.positions, &Pose { lod, ..Pose::default() });
        for step in 1..=20 {
            let lod = 0.05 * step as f32;
            let ratio = area(&at(lod)) / area(&full);
            assert!((ratio - 1.0).abs() < 0.03, "{ratio} at {lod}");
        }
        for lod in [0.1, 0.3337, 0.8, 0.999] {
            let (a, b) = (at(lod), at(lod + 1e-3));
            for s in 0..b.n_strands() {
                let width = |strands: &Strands| strands.radii_um.get(s * 24).copied().unwrap_or(0.0);
                // The detail grows by a share of itself; no width changes by more than a dozen such shares.
                assert!(
                    (width(&a) - width(&b)).abs() < 12.0 * (1e-3 / lod) * layer.radius_um / lod,
                    "{s} {} {}",
                    width(&a),
                    width(&b)
                );
            }
        }
        assert_eq!(at(1.0).radii_um[0], layer.radius_um);
        assert!(at(0.0).n_strands() <= 2);
    }

    #[test]
    fn strands_stay_out_of_the_head_in_their_order_and_turn_with_it() {
        let head = Head::new("ball", sphere(Vec3::ZERO, 8.0, 64));
        let field = DistanceField::from_mesh(&head.mesh, 64).unwrap();
        // A patch on top that lies over the ball and sinks into it.
        let mut mesh = straight_grid(4, 0);
        mesh.move_vertices(0, |_, p| 8.0 * ((p - Vec3::new(2.0, 0.0, 2.0)) * 0.7 + Vec3::Y * 6.0).normalize());
        let all: Vec<usize> = (0..16).collect();
        for k in 1..6 {
            let deep = 8.2 - 0.4 * k as f32;
            mesh.extrude(&all, Weld::Neighbours, |v| {
                (glam::Quat::from_rotation_x(0.3) * v.position).normalize() * deep
            })
            .unwrap();
        }
        let layer = Layer { vertices_per_strand: 32, ..layer(mesh, 1000) };
        let binding = bind_layer(&layer, Some(&head));
        let rest = Pose { field: Some(&field), ..Pose::default() };
        let free = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
        let kept = generate(&binding, &layer, &binding.guides.positions, &rest);
        let n_inside = |strands: &Strands| strands.points.iter().filter(|p| p.length() < 7.95).count();
        assert!(n_inside(&free) > free.n_points() / 3);
        assert_eq!(n_inside(&kept), 0);
        assert!(binding.roots.iter().all(|root| (root.length() - 8.0).abs() < 0.02));
        assert!((0..1000).all(|s| kept.strand(s)[0].distance(binding.roots[s]) < 1e-4));

        let world_from_head =
            Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(1.0), Vec3::new(3.0, 1.0, 2.0));
        let guides: Vec<Vec3> = binding.guides.positions.iter().map(|p| world_from_head.transform_point3(*p)).collect();
        let turned = generate(&binding, &layer, &guides, &Pose { world_from_head, ..rest });
        for (a, b) in kept.points.iter().zip(&turned.points) {
            assert!(world_from_head.transform_point3(*a).distance(*b) < 1e-3);
        }
    }

    #[test]
    fn a_painted_map_places_every_strand_where_it_is_painted() {
        let mut ball = sphere(Vec3::ZERO, 8.0, 64);
        ball.uvs = ball.positions.iter().map(|p| [0.5 + p.x / 16.0, 0.5 + p.z / 16.0]).collect();
        let head = Head::new("ball", ball);
        let mut mesh = straight_grid(4, 0);
        mesh.move_vertices(0, |_, p| 8.0 * ((p - Vec3::new(2.0, 0.0, 2.0)) * 0.7 + Vec3::Y * 2.0).normalize());
        mesh.extrude(&(0..16).collect::<Vec<_>>(), Weld::Neighbours, |v| 1.3 * v.position).unwrap();
        // A strip one twentieth of the ball wide.
        let texels = (0..40 * 40).map(|i| if i % 40 == 22 || i % 40 == 23 { 255 } else { 0 }).collect();
        let map = ScalpMap { width: 40, height: 40, texels };
        let layer = Layer { density: Some(Arc::new(map)), ..layer(mesh, 3000) };
        let binding = bind_layer(&layer, Some(&head));
        assert_eq!(binding.n_strands(), 3000);
        for uv in &binding.root_uvs {
            assert!((21.5 / 40.0..24.5 / 40.0).contains(&uv[0]), "{uv:?}");
        }
        let empty = ScalpMap { width: 1, height: 1, texels: vec![0] };
        assert_eq!(bind_layer(&Layer { density: Some(Arc::new(empty)), ..layer }, Some(&head)).n_strands(), 0);
    }

    #[test]
    fn guides_and_imported_strands_make_strands_too() {
        let head = Head::new("ball", sphere(Vec3::ZERO, 8.0, 48));
        let mut guides = Strands::default();
        for i in 0..60 {
            let (sin, cos) = (i as f32 * 2.4).sin_cos();
            let r = 0.35 * (i as f32).sqrt();
            let out = Vec3::new(r * cos, 6.0, r * sin).normalize();
            guides.push(&[0, 1, 2, 3, 4].map(|k| out * (8.0 + 1.5 * k as f32) - Vec3::Y * 0.2 * (k * k) as f32));
        }
        guides.ids = (100..160).collect();
        for head in [None, Some(&head)] {
            let layer = Layer { n_strands: 2000, ..Layer::new("guides", Source::Guides(Arc::new(guides.clone()))) };
            let binding = bind_layer(&layer, head);
            assert_eq!((binding.n_strands(), binding.guides.n_guides()), (2000, 60));
            let strands = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
            for s in 0..2000 {
                let root = strands.strand(s)[0];
                assert!((root.length() - 8.0).abs() < 0.5, "{root}");
                let nearest = guides.iter().map(|g| g[0].distance(root)).fold(f32::MAX, f32::min);
                assert!(nearest < 1.5, "{nearest}");
                let length = polyline_length(strands.strand(s));
                assert!((2.5..8.0).contains(&length), "{length}");
            }
        }
        let layer = Layer { vertices_per_strand: 5, ..Layer::from_strands("strands", guides.clone()) };
        let binding = bind_layer(&layer, Some(&head));
        let strands = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
        for s in 0..60 {
            let original = guides.strand(binding.ids[s] as usize - 100);
            assert!(strands.strand(s).iter().zip(original).all(|(a, b)| a.distance(*b) < 1e-4));
        }
        for source in
            [Source::Guides(Arc::default()), Source::Strands(Arc::default()), Source::HairMesh(Arc::default())]
        {
            let layer = Layer::new("nothing", source);
            let binding = bind_layer(&layer, None);
            assert_eq!(generate(&binding, &layer, &binding.guides.positions, &Pose::default()).n_strands(), 0);
        }
        let no_triangles = Head::new("empty", TriMesh::default());
        assert_eq!(bind_layer(&layer, Some(&no_triangles)).n_strands(), 60);
    }
}
