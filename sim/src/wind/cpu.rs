//! The grid of air on the CPU: what the GPU is tested against. Cannot fail.

use std::sync::Arc;

use glam::{UVec3, Vec3, Vec4};
use lorelei_core::simulation::SimulationSettings;
use rayon::prelude::*;

use super::air::{AirGrid, AirGridParams};
use super::free::FreeAir;
use super::grid::{AirBox, GridParams, WindFrame};
use super::hair::{HairParams, splat};
use super::predict::Before;
use super::pressure::Pressure;
use crate::contact::Obstacles;
use crate::pose::Pose;

/// A layer of hair as the grid sees it.
#[derive(Debug, Clone, Copy)]
pub struct HairLayer<'a> {
    pub n_vertices: u32,
    /// World, vertex `k` of guide `g` at `g * n_vertices + k`.
    pub positions: &'a [Vec4],
    /// Mass at each vertex of which the wind takes hold, g.
    pub windage: &'a [f32],
    /// Of all of them.
    pub g: f32,
}

impl HairLayer<'_> {
    /// Guides of the layer; 0 where they have no edge.
    pub fn n_guides(&self) -> u32 {
        if self.n_vertices < 2 { 0 } else { self.positions.len() as u32 / self.n_vertices }
    }
}

/// The air around a groom.
#[derive(Clone)]
pub struct CpuWind {
    air_box: AirBox,
    grid: GridParams,
    free: FreeAir,
    faces: Vec<Vec4>,
    air: Vec<Vec4>,
    curls: Vec<Vec4>,
    hair_cells: Vec<i32>,
    positions_before: Vec<Vec<Vec4>>,
    pressure: Pressure,
    is_new: bool,
}

impl CpuWind {
    /// Around points (head space), in the free air of the time 0.
    pub fn new(points: impl Iterator<Item = Vec3>, settings: &SimulationSettings, pose: Pose) -> Self {
        let mut air_box = AirBox::around(points, settings, pose);
        let grid = air_box.advance(settings, &WindFrame::first(pose), 1.0);
        let free = FreeAir::new(settings, 0.0);
        let mut wind = Self {
            grid,
            free,
            faces: Vec::new(),
            air: Vec::new(),
            curls: vec![Vec4::ZERO; grid.n_entries()],
            hair_cells: vec![0; 4 * grid.n_entries()],
            positions_before: Vec::new(),
            pressure: Pressure::new(grid.n),
            is_new: true,
            air_box,
        };
        wind.fill(|_| free.steady);
        wind
    }

    /// Let every place have a velocity (world), whatever its divergence.
    pub fn fill(&mut self, velocity: impl Fn(Vec3) -> Vec3) {
        let (grid, cell_of) = (self.grid, self.grid.entries());
        let at = |entry: usize, offset: Vec3| velocity(grid.min + grid.cell * (cell_of(entry).as_vec3() + offset));
        self.faces = (0..grid.n_entries())
            .map(|entry| {
                let axes = [0, 1, 2].map(|axis| at(entry, 0.5 * (1.0 - Vec3::AXES[axis]))[axis]);
                Vec3::from_array(axes).extend(0.0)
            })
            .collect();
        self.air = (0..grid.n_entries()).map(|entry| at(entry, Vec3::splat(0.5)).extend(1.0)).collect();
    }

    /// Let a frame pass.
    pub fn advance(
        &mut self,
        settings: &SimulationSettings,
        obstacles: Obstacles<'_>,
        layers: &[HairLayer<'_>],
        frame: &WindFrame,
    ) {
        let &WindFrame { pose, jumped, t_secs, frame_secs } = frame;
        if frame_secs.is_nan() || frame_secs <= 0.0 {
            return;
        }
        let pose_before = if jumped { pose } else { self.air_box.pose() };
        let hair_g = layers.iter().map(|layer| layer.g).sum();
        self.grid = self.air_box.advance(settings, frame, hair_g);
        self.free = FreeAir::new(settings, t_secs);
        let grid = self.grid;
        self.hair_cells.fill(0);
        let dt_secs = (!self.is_new && !jumped).then_some(frame_secs);
        self.positions_before.resize(layers.len(), Vec::new());
        for (layer, before) in layers.iter().zip(&mut self.positions_before) {
            if layer.n_guides() > 0 {
                before.resize(layer.positions.len(), Vec4::ZERO);
                let hair = HairParams::new(layer.n_guides(), layer.n_vertices, dt_secs);
                for item in 0..hair.n_taken * hair.n_vertices {
                    splat(&grid, &hair, item, layer.positions, layer.windage, before, &mut self.hair_cells);
                }
            }
        }
        self.is_new = false;
        let mut before = Before {
            grid: &grid,
            free: &self.free,
            obstacles,
            pose,
            pose_before,
            faces: &self.faces,
            air: &self.air,
            hair_cells: &self.hair_cells,
            curls: &[],
        };
        let cell_of = grid.entries();
        let is_cell = |c: UVec3| c.cmplt(UVec3::splat(grid.n)).all();
        if grid.vorticity > 0.0 {
            self.curls.par_iter_mut().enumerate().for_each(|(at, curl)| {
                if is_cell(cell_of(at)) {
                    *curl = before.turn(cell_of(at));
                }
            });
        }
        before.curls = &self.curls;
        let (predicted, openness): (Vec<Vec4>, Vec<Vec4>) =
            (0..grid.n_entries()).into_par_iter().map(|at| before.predict(cell_of(at))).unzip();
        self.pressure.begin(&grid, &predicted, &openness);
        self.pressure.solve(settings.air.n_cycles);
        let projected: Vec<_> = (0..grid.n_entries())
            .into_par_iter()
            .map(|at| self.pressure.project(&grid, &predicted, cell_of(at)))
            .collect();
        for (at, (low, middle)) in projected.into_iter().enumerate() {
            self.faces[at] = low;
            if let Some(middle) = middle {
                self.air[at] = middle;
            }
        }
    }

    /// Everything that the next frame depends on.
    pub(crate) fn read_state(&self) -> Vec<Vec<Vec4>> {
        let pressure = self
            .pressure
            .pressure
            .chunks(4)
            .map(|four| Vec4::from_array(std::array::from_fn(|i| four.get(i).copied().unwrap_or_default())));
        let mut state = vec![self.air_box.to_vectors(), self.faces.clone(), self.air.clone(), pressure.collect()];
        state.extend(self.positions_before.iter().cloned());
        state
    }

    /// Go on from a state; one of other cells is left alone.
    pub(crate) fn write_state(&mut self, state: &[Vec<Vec4>]) {
        let [air_box, faces, air, pressure, positions_before @ ..] = state else { return };
        let fits = faces.len() == self.faces.len()
            && air.len() == self.air.len()
            && pressure.len() == self.pressure.pressure.len().div_ceil(4);
        if !fits || !self.air_box.set_vectors(air_box) {
            return;
        }
        self.faces.clone_from(faces);
        self.air.clone_from(air);
        let numbers = pressure.iter().flat_map(Vec4::to_array);
        self.pressure.pressure.iter_mut().zip(numbers).for_each(|(own, kept)| *own = kept);
        self.positions_before = positions_before.to_vec();
        self.is_new = positions_before.is_empty();
    }

    pub fn grid(&self) -> &GridParams {
        &self.grid
    }

    /// Speeds through the lower faces of every entry.
    pub fn faces(&self) -> &[Vec4] {
        &self.faces
    }

    /// Hair in every cell: mass, then momentum, in fixed point.
    pub fn hair_cells(&self) -> &[i32] {
        &self.hair_cells
    }

    /// What strands and drawings ask.
    pub fn air(&self) -> AirGrid {
        let params = AirGridParams { min: self.grid.min, cell: self.grid.cell, n: self.grid.n, pad: [0; 3] };
        AirGrid { params, air: Arc::new(self.air.clone()), free: Arc::new(self.free) }
    }
}

/// Root mean square over all cells of the divergence of speeds through faces, times the cell's size: cm/s.
pub fn divergence_rms(grid: &GridParams, faces: &[Vec4]) -> f32 {
    let row = grid.n as usize + 1;
    let cell_of = grid.entries();
    let mut squared = 0.0_f64;
    for at in (0..faces.len()).filter(|&at| cell_of(at).cmplt(UVec3::splat(grid.n)).all()) {
        let upper = Vec3::new(faces[at + 1].x, faces[at + row].y, faces[at + row * row].z);
        let divergence = (upper - faces[at].truncate()).element_sum();
        squared += f64::from(divergence).powi(2);
    }
    (squared / f64::from(grid.n).powi(3)).sqrt() as f32
}
