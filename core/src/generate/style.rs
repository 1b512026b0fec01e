//! What the style stack does to a strand: its cut, the pulls of its clumps, and the displacements around
//! its path. Each is the strand's own numbers first, drawn once, and then a formula along the strand.

use glam::Vec3;

use super::Generator;
use crate::hash::{combine, random, unit};
use crate::style::{MOST_CLUMP_OPS, MOST_DISPLACING_OPS, StyleKind, StyleOp, envelope};

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

/// A clump operator of a strand: the path it is drawn to, and how strongly.
#[derive(Clone, Copy, Default)]
pub(super) struct Pull {
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
pub(super) struct Shape<'a> {
    op: Option<&'a StyleOp>,
    seed: u32,
    numbers: [f32; 4],
    away: f32,
}

/// Displacement across the strand (right, up) and away from the head (z), in centimetres.
pub(super) fn displacement(shapes: &[Shape<'_>], t: f32, arc_length: f32) -> Vec3 {
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

pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

impl Generator<'_> {
    fn active(&self) -> impl Iterator<Item = &StyleOp> {
        self.style.iter().filter(|op| op.is_active())
    }

    /// Hash that all strands of the operator's clump share.
    fn clump_seed(&self, strand_idx: usize, op: &StyleOp) -> u32 {
        let clumps = &self.binding.clumps;
        self.binding.seeds[clumps.middle(strand_idx, clumps.size_idx(op.kind))]
    }

    /// Share of the strand's length that is left.
    pub(super) fn cut(&self, strand_idx: usize) -> f32 {
        let mut cut = 1.0;
        for op in self.active() {
            if let StyleKind::Length { variation, .. } = op.kind {
                let h = random(self.clump_seed(strand_idx, op), purpose(FOR_LENGTH, op));
                cut *= 1.0 - op.strength * variation.clamp(0.0, 0.98) * h;
            }
        }
        cut
    }

    pub(super) fn pulls(&self, strand_idx: usize) -> ([Pull; MOST_CLUMP_OPS], usize) {
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

    /// The strand's path drawn into its clumps: each clump's middle is itself drawn by the clumps before.
    pub(super) fn clumped(&self, strand_idx: usize, pulls: &[Pull], t: f32) -> Vec3 {
        // The middles are read where the strand is, by its own knots.
        let u = self.parameter(strand_idx, t);
        let mut p = self.path(strand_idx, u);
        let mut middles = [Vec3::ZERO; MOST_CLUMP_OPS];
        for (middle, pull) in middles.iter_mut().zip(pulls) {
            *middle = self.path(pull.middle, u);
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

    /// The strand's own numbers in every operator that displaces it.
    pub(super) fn shapes(&self, strand_idx: usize) -> ([Shape<'_>; MOST_DISPLACING_OPS], usize) {
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
