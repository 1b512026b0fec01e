//! What the style stack does to a strand: its cut, the pulls of its clumps and wisps, the turns of its path,
//! and the displacements around it. Each is the strand's own numbers first, drawn once, and then a formula along
//! the strand.

use glam::Vec3;

use super::plan::Step;
use super::{Generator, StrandPath};
use crate::hash::{combine, random, unit};
use crate::style::{Blend, Envelope, MOST_CLUMP_OPS, StyleKind};

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
pub(super) const FOR_KEEP_OUT: u32 = 11;
const FOR_FUZZ: u32 = 12;

/// Arc length over which a strand of a wisp wanders once about its place, in centimetres: about the distance over
/// which neighbouring hairs of a lock part and meet again.
const WISP_FEATURE: f32 = 3.0;
/// Roots nearer to a parting than this are on neither side fully, in centimetres.
const PART_EDGE: f32 = 0.1;

/// A clump or wisp of a strand: the path it is drawn to, and how strongly.
pub(super) struct Pull<'a> {
    middle: StrandPath,
    envelope: Envelope<'a>,
    flare: f32,
    /// Share of the strand over which it goes from its root to its wisp; 0 for a clump.
    gather: f32,
    /// How much of the pull the strand itself follows.
    follow: f32,
    /// Whether its middle was drawn by the clumps before.
    is_nested: bool,
}

impl Pull<'_> {
    /// Strength at the guides' parameter `t`, without the strand's own stray.
    fn at(&self, t: f32) -> f32 {
        if self.gather > 0.0 {
            return self.envelope.strength * smoothstep(0.0, self.gather, t);
        }
        let x = ((t - 0.6) / 0.4).clamp(0.0, 1.0);
        self.envelope.at(t) * (1.0 - self.flare * x * x)
    }
}

/// A strand's own numbers in one operator.
pub(super) struct Shape<'a> {
    step: &'a Step,
    envelope: Envelope<'a>,
    seed: u32,
    numbers: [f32; 4],
    away: f32,
}

impl Shape<'_> {
    /// Whether it turns the path.
    pub(super) fn turns(&self) -> bool {
        matches!(self.step.kind, StyleKind::Bend { .. } | StyleKind::Part { .. })
    }
}

/// Displacement across the strand (right, up) and away from the head (z), in centimetres.
pub(super) fn displacement(shapes: &[Shape<'_>], t: f32, arc_length: f32) -> Vec3 {
    let mut offset = Vec3::ZERO;
    for Shape { step, envelope, seed, numbers: [a, phase, x, y], away } in shapes {
        let weight = envelope.at(t);
        // The displacement at full strength, and how it swings about 0 where it does so.
        let (full, swing) = match step.kind {
            StyleKind::Length { .. } | StyleKind::Clump { .. } | StyleKind::Bend { .. } | StyleKind::Part { .. } => {
                continue;
            }
            StyleKind::Smooth { .. } => {
                offset *= 1.0 - weight.clamp(0.0, 1.0);
                continue;
            }
            StyleKind::Wave { .. } => {
                let swing = smoothstep(0.0, 0.5 * a, arc_length) * sin_turns(phase + arc_length / a);
                (swing * Vec3::new(*x, *y, 0.0), swing)
            }
            StyleKind::Curl { loosen, .. } => {
                let turns = phase + x * arc_length / (a * (1.0 + 0.5 * loosen * t));
                let grown = smoothstep(0.0, *a, arc_length);
                let size = y * (1.0 + loosen * t) * grown;
                (size * Vec3::new(sin_turns(turns + 0.25), sin_turns(turns), 0.0), grown * sin_turns(turns))
            }
            StyleKind::Frizz { .. } => {
                let along = arc_length / a;
                let grown = smoothstep(0.0, 1.0, along);
                let swing = noise(*seed, along);
                (x * grown * Vec3::new(swing, noise(combine(*seed, 1), along), 0.0), grown * swing)
            }
            StyleKind::Deviate { .. } => (Vec3::new(*x, *y, *away), 0.0),
            StyleKind::Wisp { radius, gather, fuzz, twist, .. } => {
                let along = arc_length / WISP_FEATURE;
                let wander = fuzz * radius * Vec3::new(noise(*seed, along), noise(combine(*seed, 1), along), 0.0);
                let (sin, cos) = (sin_turns(away * twist * t), sin_turns(away * twist * t + 0.25));
                let about = Vec3::new(cos * x - sin * y, sin * x + cos * y, 0.0);
                (smoothstep(0.0, gather, t) * (about + wander), 0.0)
            }
        };
        match step.blend {
            Blend::Add => offset += weight * full,
            Blend::Replace => offset += weight * (full - offset),
            Blend::Modulate => offset *= 1.0 + weight * swing,
        }
    }
    offset
}

/// Turn a segment of the path, as the bends and partings say at parameter `t`; its length stays.
pub(super) fn turned(shapes: &[Shape<'_>], delta: Vec3, t: f32) -> Vec3 {
    let length = delta.length();
    let mut along = delta.normalize_or(Vec3::ZERO);
    for shape in shapes.iter().filter(|shape| shape.turns()) {
        let [x, y, z, _] = shape.numbers;
        let weight = shape.envelope.at(t).clamp(0.0, 1.0);
        along = (along + weight * (Vec3::new(x, y, z) - along)).normalize_or(along);
    }
    length * along
}

/// The strand's path drawn into its clumps, at the share `t` of its length and the parameter `u` of its guides: each
/// clump's middle is itself drawn by the clumps before.
pub(super) fn clumped(path: &StrandPath, pulls: &[Pull<'_>], t: f32, u: f32) -> Vec3 {
    let mut p = path.at(u);
    let mut middles = [Vec3::ZERO; MOST_CLUMP_OPS];
    for (middle, pull) in middles.iter_mut().zip(pulls) {
        *middle = pull.middle.at(u);
    }
    for (j, pull) in pulls.iter().enumerate() {
        let strength = pull.at(t);
        let middle = middles[j];
        for (finer, of_finer) in middles[j + 1..].iter_mut().zip(&pulls[j + 1..]) {
            if of_finer.is_nested {
                *finer += strength * (middle - *finer);
            }
        }
        p += strength * pull.follow * (middle - p);
    }
    p
}

fn purpose(purpose: u32, step: &Step) -> u32 {
    combine(step.seed, purpose)
}

pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

impl Generator<'_> {
    /// The strand whose numbers count for an operator: before a wisp that is the wisp's middle.
    fn bearer(&self, strand_idx: usize, step: &Step) -> usize {
        if step.per_wisp { self.wisp_middle(strand_idx) } else { strand_idx }
    }

    /// The strand whose path the wisp is; a strand without one is its own.
    pub(super) fn wisp_middle(&self, strand_idx: usize) -> usize {
        self.binding.clumps.middle(strand_idx, self.plan.wisp_size_idx())
    }

    /// Hash that all strands of the operator's clump share.
    fn clump_seed(&self, strand_idx: usize, step: &Step) -> u32 {
        self.binding.seeds[self.binding.clumps.middle(self.bearer(strand_idx, step), step.size_idx)]
    }

    /// How strong an operator is on a strand: painted maps say where it acts.
    pub(super) fn strength(&self, strand_idx: usize, step: &Step) -> f32 {
        let share = |map_idx: &Option<usize>| self.binding.map_value(strand_idx, *map_idx, 1.0).min(1.0);
        step.strength * step.maps.iter().map(share).product::<f32>()
    }

    /// Share of the strand's length that is left.
    pub(super) fn cut(&self, strand_idx: usize) -> f32 {
        let mut of_ops = 1.0;
        let painted = self.binding.map_value(strand_idx, self.plan.length_map, 1.0).min(1.0);
        for step in &self.plan.steps {
            let strength = self.strength(strand_idx, step);
            match step.kind {
                StyleKind::Length { variation, .. } => {
                    let h = random(self.clump_seed(strand_idx, step), purpose(FOR_LENGTH, step));
                    let kept = 1.0 - strength * variation.clamp(0.0, 0.98) * h;
                    of_ops = if step.blend == Blend::Replace { kept } else { of_ops * kept };
                }
                StyleKind::Wisp { length_variation, .. } => {
                    let h = random(self.binding.seeds[strand_idx], purpose(FOR_LENGTH, step));
                    of_ops *= 1.0 - strength * length_variation.clamp(0.0, 0.98) * h;
                }
                StyleKind::Clump { .. }
                | StyleKind::Wave { .. }
                | StyleKind::Curl { .. }
                | StyleKind::Frizz { .. }
                | StyleKind::Deviate { .. }
                | StyleKind::Bend { .. }
                | StyleKind::Smooth { .. }
                | StyleKind::Part { .. } => {}
            }
        }
        painted * of_ops
    }

    pub(super) fn pulls(&self, strand_idx: usize) -> Vec<Pull<'_>> {
        let clumps = &self.binding.clumps;
        let mut pulls = Vec::new();
        for step in &self.plan.steps {
            let bearer = self.bearer(strand_idx, step);
            let middle = clumps.middle(bearer, step.size_idx);
            let strength = self.strength(strand_idx, step);
            let mut pull = Pull {
                middle: StrandPath::default(),
                envelope: step.envelope(strength),
                flare: 0.0,
                gather: 0.0,
                follow: 1.0,
                is_nested: step.blend != Blend::Replace,
            };
            match step.kind {
                StyleKind::Clump { flare, stray, .. } => {
                    let stray_h = random(self.binding.seeds[bearer], purpose(FOR_STRAY, step));
                    let loose_h = random(self.binding.seeds[middle], purpose(FOR_LOOSE_CLUMP, step));
                    pull.envelope.strength = strength * (1.0 - 0.5 * stray * loose_h);
                    pull.flare = flare;
                    // Most follow closely, a few hardly.
                    pull.follow = 1.0 - stray * stray_h * stray_h;
                }
                StyleKind::Wisp { gather, .. } => pull.gather = gather.max(1e-3),
                StyleKind::Length { .. }
                | StyleKind::Wave { .. }
                | StyleKind::Curl { .. }
                | StyleKind::Frizz { .. }
                | StyleKind::Deviate { .. }
                | StyleKind::Bend { .. }
                | StyleKind::Smooth { .. }
                | StyleKind::Part { .. } => continue,
            }
            pull.middle = self.path_of(middle);
            pulls.push(pull);
        }
        pulls
    }

    /// The strand's own numbers in every operator that turns or displaces it. `root` is its root and `outwards` the
    /// scalp's normal there, `side` and `up` the frame that it starts with; world space.
    pub(super) fn shapes(&self, strand_idx: usize, root: Vec3, frame: &RootFrame) -> Vec<Shape<'_>> {
        let mut shapes = Vec::new();
        for step in &self.plan.steps {
            let bearer = self.bearer(strand_idx, step);
            let seed = self.binding.seeds[bearer];
            let clump = self.clump_seed(strand_idx, step);
            let of_clump = |name: u32| random(clump, purpose(name, step));
            let of_strand = |name: u32| random(seed, purpose(name, step));
            let mut envelope = step.envelope(self.strength(strand_idx, step));
            let mut away = 0.0;
            let mut noise_seed = clump;
            let numbers = match step.kind {
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
                StyleKind::Deviate { share, amplitude, lift, whole } => {
                    if of_strand(FOR_SHARE) >= share {
                        continue;
                    }
                    // Each leaves the others at its own place.
                    let late = 0.7 * (1.0 - whole) * (1.0 - step.from);
                    envelope.from = step.from + late * of_strand(FOR_START);
                    let size = amplitude * (0.3 + 0.7 * of_strand(FOR_SIZE));
                    let around = size * (1.0 - lift.abs());
                    let turns = of_strand(FOR_SIDE);
                    away = size * lift;
                    [0.0, 0.0, around * sin_turns(turns + 0.25), around * sin_turns(turns)]
                }
                StyleKind::Wisp { radius, fuzz, .. } => {
                    let middle = self.binding.clumps.middle(bearer, step.size_idx);
                    // To the side of the wisp on which the strand grows, so that strands do not cross; evenly over
                    // the wisp's disc, and some far out of it.
                    let from_middle = root - self.root_of(middle);
                    let (x, y) = (from_middle.dot(frame.side), from_middle.dot(frame.up));
                    let apart = (x * x + y * y).sqrt().max(1e-6);
                    let out = of_strand(FOR_FUZZ);
                    let size = radius * of_strand(FOR_SIZE).sqrt() * (1.0 + 2.0 * fuzz * out * out * out * out);
                    noise_seed = seed;
                    // Strands twist about alike, not exactly.
                    away = 0.7 + 0.6 * of_strand(FOR_PERIOD);
                    [0.0, 0.0, size * x / apart, size * y / apart]
                }
                StyleKind::Smooth { .. } => [0.0; 4],
                StyleKind::Bend { gravity, variation, .. } => {
                    let (_, [x, y, z, ..]) = step.numbers();
                    let on_head = self.pose.world_from_head.transform_vector3(Vec3::new(x, y, z));
                    let towards = (on_head + gravity * (Vec3::NEG_Y - on_head)).normalize_or(on_head);
                    envelope.strength *= 1.0 - variation * of_clump(FOR_SIZE);
                    [towards.x, towards.y, towards.z, 0.0]
                }
                StyleKind::Part { offset, width, .. } => {
                    let (_, [x, y, z, ..]) = step.numbers();
                    let normal = Vec3::new(x, y, z);
                    let distance = self.pose.world_from_head.inverse().transform_point3(root).dot(normal) - offset;
                    let side = if distance < 0.0 { -1.0 } else { 1.0 };
                    let away_from_line = self.pose.world_from_head.transform_vector3(side * normal);
                    // Along the scalp.
                    let towards = away_from_line - away_from_line.dot(frame.outwards) * frame.outwards;
                    let towards = towards.normalize_or(away_from_line);
                    envelope.strength *= smoothstep(0.0, PART_EDGE, distance.abs())
                        * (1.0 - smoothstep(0.0, 1.0, distance.abs() / width.max(0.01)));
                    [towards.x, towards.y, towards.z, 0.0]
                }
            };
            shapes.push(Shape { step, envelope, seed: combine(noise_seed, purpose(FOR_NOISE, step)), numbers, away });
        }
        shapes
    }
}

/// The frame that a strand starts with, world space: unit vectors.
pub(super) struct RootFrame {
    pub(super) outwards: Vec3,
    pub(super) side: Vec3,
    pub(super) up: Vec3,
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
