//! Hair against hair: a grid of how much hair there is and how fast it goes. Twin of `volume_hair.wgsl`: same names, same
//! order.
//!
//! Hair that touches hair neither passes through it nor slides along it freely. Strand against strand is a million pairs;
//! a grid asks only how crowded a place is (Bertails et al. 2005, McAdams et al. 2009, and the course on real-time hair
//! of SIGGRAPH 2010). Before the steps of a frame every guide vertex is counted into eight cells, for as much hair as its
//! guide stands for (hairs.rs), the counts are blurred, and
//!
//! - a vertex that is more crowded than it rests is driven down the gradient of the density, by as much more as it is
//!   crowded;
//! - its velocity goes some way towards that of the hair around it.
//!
//! **More crowded than it rests.** Each vertex knows its own density at rest. A lock that swings away keeps it and is left
//! alone; locks that fall together do not. The density of the resting groom at the same place of the head was rejected:
//! where no hair rests, a lock would be driven apart by itself.
//!
//! **A push is a force.** Moving places without a velocity was tried: the strands' own springs take the place back within
//! the frame, and hair that lies still on others quivers (measured: 16 to 80 cm/s in hair that hangs from a bowed
//! head). A force finds its balance with them, and is the same at any frame rate.
//!
//! **The same every time.** Counts are whole numbers, added in any order to the same sum.

mod gpu;
mod hairs;

use glam::{IVec3, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::simulation::{Moved, SimulationSettings, Volume};

use crate::bounded;
use crate::pose::{Pose, rotate};
use crate::rest::Rest;
use crate::rod::N_PINNED;

pub use gpu::{GpuVolume, VolumeLayer};
pub(crate) use hairs::shares_of;

/// Counts of a centimetre of hair.
const SCALE: f32 = 4096.0;
/// Room around the groom at rest, as a share of its longest side: hair swings.
const ROOM: f32 = 0.35;
/// Standard gravity, cm/s2.
const GRAVITY: f32 = 981.0;
/// Hair that is crowded this many times more than at rest is driven no harder.
const MOST_CROWDED: f32 = 3.0;
/// Density below which nothing is crowded, centimetres of guides in a cell.
const SPARSE: f32 = 0.05;

/// Where the grid is and what it does in a frame. Layout of `VolumeParams` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct VolumeParams {
    /// World from head, at the last step.
    pub rotation: [f32; 4],
    pub translation: [f32; 4],
    /// First node, head space.
    pub min: [f32; 3],
    /// cm.
    pub cell: f32,
    pub n: [u32; 3],
    pub n_vertices: u32,
    /// Vertices of a guide.
    pub per_guide: u32,
    /// Numbers of four that a vertex's state has; the first is its place, the second where it was a step ago.
    pub stride: u32,
    /// How much more crowded than at rest is let be, as a share.
    pub tolerance: f32,
    /// Way in a step that a frame adds to a vertex twice as crowded as at rest, cm.
    pub push: f32,
    /// Share of the difference to the hair around that a frame takes away.
    pub blend: f32,
    /// Guides whose vertices lie side by side: see [`Lanes`](crate::lanes::Lanes).
    pub lanes: u32,
    pub pad: [u32; 2],
}

/// What a vertex stands for. Layout of `Crowd` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Crowd {
    /// Centimetres of hair.
    pub hair: f32,
    /// Density where it rests.
    pub rest_density: f32,
}

/// The grid around a groom, and every layer's vertices.
#[derive(Debug, Clone)]
pub struct VolumeGrid {
    min: Vec3,
    cell: f32,
    n: [u32; 3],
    /// Of every layer.
    pub crowds: Vec<Vec<Crowd>>,
    /// Hair and its way in a step, summed, in cells x fastest.
    counts: Vec<[i32; 4]>,
    /// The counts blurred, in centimetres.
    field: Vec<Vec4>,
}

impl VolumeGrid {
    /// For guides at rest; `None` where nothing is asked for, or where there is no hair.
    pub fn new(rests: &[&Rest], settings: &SimulationSettings) -> Option<Self> {
        let n_longest = match settings.volume {
            Volume::Off => return None,
            Volume::Density | Volume::DensityVelocity => settings.volume_cells.clamp(8, 96),
        };
        let places = || rests.iter().flat_map(|rest| &rest.vertices).map(|v| v.xyz());
        let (low, high) =
            places().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let size = high - low;
        if !(size.is_finite() && size.max_element() > 1e-3 && size.max_element() < 1e6) {
            return None;
        }
        let room = ROOM * size.max_element();
        let (low, size) = (low - room, size + 2.0 * room);
        let cell = size.max_element() / (n_longest - 1) as f32;
        let n = (size / cell).ceil().as_uvec3() + 1;
        let n = n.min(glam::UVec3::splat(n_longest + 1)).to_array();
        let n_cells = n.iter().product::<u32>() as usize;
        let (counts, field) = (vec![[0; 4]; n_cells], vec![Vec4::ZERO; n_cells]);
        let mut grid = Self {
            min: low,
            cell,
            n,
            crowds: rests.iter().map(|rest| hair_of(rest, settings.moved)).collect(),
            counts,
            field,
        };
        let at_rest = grid.params(Pose::IDENTITY, settings, [1, 2], [0.0; 2]);
        for (layer_idx, rest) in rests.iter().enumerate() {
            // At rest there are places and no velocities.
            let state: Vec<Vec4> = rest.vertices.iter().flat_map(|&place| [place, place]).collect();
            grid.splat(&at_rest, layer_idx, &state);
        }
        grid.blur();
        for (layer_idx, rest) in rests.iter().enumerate() {
            for (idx, v) in rest.vertices.iter().enumerate() {
                grid.crowds[layer_idx][idx].rest_density = grid.sample(v.xyz()).0.x;
            }
        }
        Some(grid)
    }

    /// Whether other settings need another grid.
    pub fn is_other(a: &SimulationSettings, b: &SimulationSettings) -> bool {
        a.volume != b.volume || a.moved != b.moved || a.volume_cells != b.volume_cells
    }

    /// Numbers of a frame that takes so long; `per_guide`: vertices of a guide of the
    /// layer that they are for, `stride`: numbers of four that its state has for a vertex.
    pub fn params(
        &self,
        pose: Pose,
        settings: &SimulationSettings,
        [per_guide, stride]: [u32; 2],
        [step_secs, frame_secs]: [f32; 2],
    ) -> VolumeParams {
        let default = SimulationSettings::default();
        let share = |rate: f32, default: f32| 1.0 - (-bounded(rate, default, 0.0, 1e3) * frame_secs).exp();
        VolumeParams {
            rotation: pose.rotation.to_array(),
            translation: pose.translation.extend(0.0).to_array(),
            min: self.min.to_array(),
            cell: self.cell,
            n: self.n,
            n_vertices: 0,
            per_guide,
            stride,
            lanes: 1,
            pad: [0; 2],
            tolerance: bounded(settings.volume_tolerance, default.volume_tolerance, 0.01, 10.0),
            push: GRAVITY * bounded(settings.volume_push, default.volume_push, 0.0, 100.0) * step_secs * frame_secs,
            blend: match settings.volume {
                Volume::Off | Volume::Density => 0.0,
                Volume::DensityVelocity => share(settings.volume_rub, default.volume_rub),
            },
        }
    }

    /// Forget the hair of the frame before.
    pub fn clear(&mut self) {
        self.counts.fill([0; 4]);
    }

    /// Count a layer's vertices: eight cells each.
    pub fn splat(&mut self, p: &VolumeParams, layer_idx: usize, state: &[Vec4]) {
        let pose = pose_of(p);
        for (idx, vertex) in state.chunks_exact(p.stride as usize).enumerate() {
            let at = (pose.apply_inverse(vertex[0].xyz()) - self.min) / self.cell;
            let Some((corner, t)) = self.locate(at) else { continue };
            let way = vertex[0].xyz() - vertex[1].xyz();
            for i in 0..8 {
                let (offset, weight) = corner_of(i, t);
                let hair = self.crowds[layer_idx][idx].hair * weight * SCALE;
                let cell = self.index(corner + offset);
                for (count, amount) in
                    self.counts[cell].iter_mut().zip([hair, hair * way.x, hair * way.y, hair * way.z])
                {
                    *count = count.wrapping_add((amount + 0.5).floor() as i32);
                }
            }
        }
    }

    /// Binomial weights over 27 cells.
    pub fn blur(&mut self) {
        let n = IVec3::from_array(self.n.map(|n| n as i32));
        for z in 0..n.z {
            for y in 0..n.y {
                for x in 0..n.x {
                    let mut sum = Vec4::ZERO;
                    for i in 0..27 {
                        let step = IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
                        let place = IVec3::new(x, y, z) + step;
                        if place.cmpge(IVec3::ZERO).all() && place.cmplt(n).all() {
                            let weight = 1.0 / (8 << step.abs().element_sum()) as f32;
                            let count = self.counts[self.index(place)].map(|count| count as f32);
                            sum += weight * Vec4::from_array(count);
                        }
                    }
                    let cell = self.index(IVec3::new(x, y, z));
                    self.field[cell] = sum / SCALE;
                }
            }
        }
    }

    /// Drive a layer's vertices out of the crowd, and along with it.
    pub fn push(&self, p: &VolumeParams, layer_idx: usize, state: &mut [Vec4]) {
        let pose = pose_of(p);
        for (idx, vertex) in state.chunks_exact_mut(p.stride as usize).enumerate() {
            if idx % p.per_guide.max(1) as usize >= N_PINNED {
                let crowd = self.crowds[layer_idx][idx];
                let before = self.pushed(p, pose, crowd, vertex[0].xyz(), vertex[1].xyz());
                vertex[1] = before.extend(vertex[1].w);
            }
        }
    }

    /// Where a vertex would have been a step before, had it the velocity that the crowd gives it.
    fn pushed(&self, p: &VolumeParams, pose: Pose, crowd: Crowd, x: Vec3, prev: Vec3) -> Vec3 {
        let (here, gradient) = self.sample(pose.apply_inverse(x));
        let mut added = Vec3::ZERO;
        let let_be = crowd.rest_density * (1.0 + p.tolerance) + SPARSE;
        let steep = gradient.length();
        if here.x > let_be && steep > 1e-6 {
            let crowded = ((here.x - let_be) / let_be).min(MOST_CROWDED);
            added = rotate(pose.rotation, gradient) * (-p.push * crowded / steep);
        }
        if p.blend > 0.0 && here.x > SPARSE {
            added += p.blend * (here.yzw() / here.x - (x - prev));
        }
        prev - added
    }

    /// The field and the gradient of the density (per centimetre) at a place in head space; zero outside.
    fn sample(&self, p: Vec3) -> (Vec4, Vec3) {
        let at = (p - self.min) / self.cell;
        let Some((corner, t)) = self.locate(at) else { return (Vec4::ZERO, Vec3::ZERO) };
        let (mut field, mut gradient) = (Vec4::ZERO, Vec3::ZERO);
        for i in 0..8 {
            let (offset, weight) = corner_of(i, t);
            let value = self.field[self.index(corner + offset)];
            field += weight * value;
            let side = 2.0 * offset.as_vec3() - 1.0;
            let share = (1.0 - offset.as_vec3()) + side * t;
            gradient += value.x * side * Vec3::new(share.y * share.z, share.x * share.z, share.x * share.y);
        }
        (field, gradient / self.cell)
    }

    /// The cell and the place in it of a place in cells; `None` outside, and for what is no number.
    fn locate(&self, at: Vec3) -> Option<(IVec3, Vec3)> {
        let last = IVec3::from_array(self.n.map(|n| n as i32 - 1)).as_vec3();
        if !(at.cmpge(Vec3::ZERO).all() && at.cmplt(last).all()) {
            return None;
        }
        let corner = at.floor();
        Some((corner.as_ivec3(), at - corner))
    }

    fn index(&self, cell: IVec3) -> usize {
        (cell.x + self.n[0] as i32 * (cell.y + self.n[1] as i32 * cell.z)) as usize
    }

    /// Cells that hold hair at rest-like amounts, times their volume, cm3: how much room the hair takes.
    pub fn occupied_cm3(&self) -> f32 {
        self.field.iter().filter(|cell| cell.x > SPARSE).count() as f32 * self.cell.powi(3)
    }
}

/// Half of the edges at every vertex, of as many hairs as the guide stands for; a strand stands for itself.
fn hair_of(rest: &Rest, moved: Moved) -> Vec<Crowd> {
    let shares = match moved {
        Moved::Guides | Moved::Mesh | Moved::Rope => shares_of(rest),
        Moved::Strands => vec![1.0; rest.n_guides()],
    };
    let n = rest.n_vertices as usize;
    let edge = |a: usize, b: usize| 0.5 * rest.vertices[a].xyz().distance(rest.vertices[b].xyz());
    (0..rest.vertices.len())
        .map(|idx| {
            let below = if idx % n > 0 { edge(idx - 1, idx) } else { 0.0 };
            let above = if idx % n + 1 < n { edge(idx, idx + 1) } else { 0.0 };
            // Whoever asks for a metre of hair a vertex has broken numbers.
            Crowd { hair: (shares[idx / n] * (below + above)).min(100.0), rest_density: 0.0 }
        })
        .collect()
}

fn pose_of(p: &VolumeParams) -> Pose {
    let [x, y, z, _] = p.translation;
    Pose { rotation: glam::Quat::from_array(p.rotation), translation: Vec3::new(x, y, z) }
}

/// Corner `i` of a cell and its weight at the place `t` in it.
fn corner_of(i: i32, t: Vec3) -> (IVec3, f32) {
    let offset = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
    let share = (1.0 - offset.as_vec3()) + (2.0 * offset.as_vec3() - 1.0) * t;
    (offset, share.x * share.y * share.z)
}
