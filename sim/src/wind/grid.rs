//! Where the grid of air is and where its numbers lie. Twin of `wind_grid.wgsl`.

use glam::{Quat, UVec3, Vec3, Vec4};
use lorelei_core::look::Switch;
use lorelei_core::simulation::SimulationSettings;

use crate::bounded;
use crate::pose::Pose;

/// No air is faster, cm/s.
pub(super) const MAX_SPEED: f32 = 10_000.0;
/// Shortest and longest step of the air: a long frame's air stands still for the rest of it.
const LONGEST_STEP_SECS: f32 = 1.0 / 15.0;
/// Side of the box over the longest side of what is in it: room for the air to go around.
pub(crate) const ROOM: f32 = 1.6;
/// Sides of the box, centimetres: of a head at least.
const SMALLEST_BOX: f32 = 20.0;
const LARGEST_BOX: f32 = 400.0;
/// The box follows once it is this many cells behind.
const BEHIND: f32 = 1.0;
/// Density of air at 20 degrees, g/cm3.
const AIR_DENSITY: f32 = 1.2e-3;
/// The sum of one frame's hair fits 31 bits this many times over.
const UNITS: f32 = 1_073_741_824.0;
/// Fastest hair that the grid knows, cm/s.
const FASTEST_HAIR: f32 = 2000.0;

/// Layout of `Pose` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct GridPose {
    rotation: Vec4,
    translation: Vec4,
}

impl From<Pose> for GridPose {
    fn from(pose: Pose) -> Self {
        Self { rotation: Vec4::from_array(pose.rotation.to_array()), translation: pose.translation.extend(0.0) }
    }
}

/// Layout of `Grid` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct GridParams {
    /// Lower corner now, world, cm.
    pub min: Vec3,
    pub cell: f32,
    /// Lower corner at the step before.
    pub min_before: Vec3,
    pub dt_secs: f32,
    /// Cells along a side.
    pub n: u32,
    pub obstacle: u32,
    /// Rate at which a gram of hair in a cubic centimetre of air slows it, cm3/(g s).
    pub hair_drag: f32,
    /// 1/s.
    pub vorticity: f32,
    /// Fixed-point units of a gram of hair, and of one times cm/s.
    pub mass_unit: f32,
    pub momentum_unit: f32,
    pub pad: [f32; 2],
    pub world_from_head: GridPose,
    pub world_from_head_before: GridPose,
}

impl GridParams {
    /// Entries of every buffer of the finest level: the upper faces of the last cells have a place too.
    pub fn n_entries(&self) -> usize {
        (self.n as usize + 1).pow(3)
    }

    /// Of a cell, or of the faces below it.
    pub fn entry(&self, c: UVec3) -> usize {
        let side = self.n + 1;
        (c.x + side * (c.y + side * c.z)) as usize
    }

    /// All entries in order.
    pub(super) fn entries(&self) -> impl Fn(usize) -> UVec3 + Sync + use<> {
        let side = self.n as usize + 1;
        move |at| UVec3::new((at % side) as u32, (at / side % side) as u32, (at / (side * side)) as u32)
    }
}

/// Where the head goes in a frame, and how long that takes.
#[derive(Debug, Clone, Copy)]
pub struct WindFrame {
    /// The head at the end of the frame.
    pub pose: Pose,
    /// The head was put there, it did not go.
    pub jumped: bool,
    /// Time at the end of the frame.
    pub t_secs: f64,
    pub frame_secs: f32,
}

impl WindFrame {
    /// Before the first frame.
    pub(super) fn first(pose: Pose) -> Self {
        Self { pose, jumped: true, t_secs: 0.0, frame_secs: 1.0 / 60.0 }
    }
}

/// The box of air and what moves it.
#[derive(Debug, Clone, PartialEq)]
pub struct AirBox {
    /// Middle of what is in it, head space.
    middle: Vec3,
    pub n: u32,
    pub cell: f32,
    /// Lower corner, world.
    pub min: Vec3,
    pose: Pose,
}

impl AirBox {
    /// Around points (head space) that are at rest in a pose.
    pub fn around(points: impl Iterator<Item = Vec3>, settings: &SimulationSettings, pose: Pose) -> Self {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in points.filter(|p| p.is_finite() && p.abs().max_element() < 1e5) {
            low = low.min(p);
            high = high.max(p);
        }
        if !low.is_finite() {
            (low, high) = (Vec3::splat(-10.0), Vec3::splat(10.0));
        }
        let n = settings.air.n_cells();
        let cell = (ROOM * (high - low).max_element()).clamp(SMALLEST_BOX, LARGEST_BOX) / n as f32;
        let middle = 0.5 * (low + high);
        let mut air_box = Self { middle, n, cell, min: Vec3::ZERO, pose };
        air_box.min = air_box.wanted_min(pose);
        air_box
    }

    /// Go on by a frame, with so many grams of hair on all of the head.
    pub fn advance(&mut self, settings: &SimulationSettings, frame: &WindFrame, hair_g: f32) -> GridParams {
        let pose = frame.pose;
        let min_before = self.min;
        let behind = (self.wanted_min(pose) - self.min) / self.cell;
        if behind.abs().max_element() > BEHIND {
            self.min += self.cell * behind.round();
        }
        let before = if frame.jumped { pose } else { self.pose };
        self.pose = pose;
        let air = &settings.air;
        let drag = bounded(settings.drag, SimulationSettings::default().drag, 0.0, 1e3);
        let hair_g = if hair_g.is_finite() { hair_g.max(1e-3) } else { 1.0 };
        GridParams {
            min: self.min,
            cell: self.cell,
            min_before,
            dt_secs: bounded(frame.frame_secs, 1.0 / 60.0, 1e-4, LONGEST_STEP_SECS),
            n: self.n,
            obstacle: u32::from(air.obstacle == Switch::On),
            hair_drag: bounded(air.hair_drag, 1.0, 0.0, 100.0) * drag / AIR_DENSITY,
            vorticity: bounded(air.vorticity, 0.0, 0.0, 100.0),
            mass_unit: UNITS / hair_g,
            momentum_unit: UNITS / (hair_g * FASTEST_HAIR),
            pad: [0.0; 2],
            world_from_head: pose.into(),
            world_from_head_before: before.into(),
        }
    }

    /// The poses of the head that [`AirBox::advance`] last went to.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Where it is, in three vectors.
    pub(super) fn to_vectors(&self) -> Vec<Vec4> {
        let pose = GridPose::from(self.pose);
        vec![self.min.extend(self.n as f32), pose.rotation, pose.translation]
    }

    /// Go where [`AirBox::to_vectors`] was; false where that had other cells.
    pub(super) fn set_vectors(&mut self, vectors: &[Vec4]) -> bool {
        let &[min, rotation, translation] = vectors else { return false };
        if min.w != self.n as f32 {
            return false;
        }
        self.min = min.truncate();
        self.pose = Pose { rotation: Quat::from_vec4(rotation), translation: translation.truncate() };
        true
    }

    fn wanted_min(&self, pose: Pose) -> Vec3 {
        pose.apply(self.middle) - 0.5 * self.n as f32 * self.cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_follows_by_whole_cells() {
        let settings = SimulationSettings::default();
        let mut air_box = AirBox::around([Vec3::ZERO, Vec3::splat(20.0)].into_iter(), &settings, Pose::IDENTITY);
        let start = air_box.min;
        assert!((air_box.cell - 1.0).abs() < 1e-4 && start.distance(Vec3::splat(-6.0)) < 1e-3);
        for i in 0..100 {
            let pose = Pose { rotation: Quat::IDENTITY, translation: Vec3::X * (0.37 * i as f32) };
            let frame = WindFrame { pose, ..WindFrame::first(pose) };
            let grid = air_box.advance(&settings, &frame, 1e6);
            let moved = (grid.min - start) / grid.cell;
            assert!((moved - moved.round()).length() < 1e-3 && (moved.x - 0.37 * i as f32).abs() < 1.6, "{moved}");
        }
    }
}
