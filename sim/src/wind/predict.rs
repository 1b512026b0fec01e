//! The air of the next frame but for its pressure. Twin of `wind_predict.wgsl`: same names, same order.
//!
//! **Path.** Back along the velocity by the midpoint rule; what comes from outside the box is free air. Beyond the box the path
//! goes on as at its boundary: with the speed of the free air there, a stream that nothing drives any more would be thought to
//! have stood still, and blow for ever (measured: 11,000 cm/s four seconds after a fan of 5,000 was off; now 8).
//!
//! **Fans.** Air goes farther in a step than a fan is thick, so what has come through its disc on the way has its speed. Its
//! body alone left a stream of 800 cm/s between 620 and 790 along its axis, by where whole steps ended.
//!
//! **Eddies.** Confinement (Fedkiw et al. 2001) of the last frame's velocity: eps h (N x omega), here with the rate eps in
//! 1/s, so that it acts the same in finer grids.
//!
//! **Hair** loses to the air what the air loses to hair: a strand takes up the air's speed at the rate `drag`, so air with
//! m grams of hair in a cm3 takes up the hair's at `drag` m / rho. Rejected: the drag of single hairs on the air (White
//! 1991, "Viscous fluid flow", equation 3-227). It is 40 times `drag`, for hair goes in locks, whose hairs stand in each
//! other's lee: 1.5/s is what a lock of half a centimetre has in 300 cm/s. So hair took 40 times as much from the air as
//! was given to it, and stood still in the calm that it made.
//!
//! **All pulls implicit**: v' = (v + k u) / (1 + k), with the same 1 / (1 + k) in front of the pressure's push.

use glam::{IVec3, UVec3, Vec2, Vec3, Vec4, Vec4Swizzles};

use super::air::trilinear;
use super::free::FreeAir;
use super::grid::{GridParams, MAX_SPEED};
use crate::contact::Obstacles;
use crate::pose::Pose;

/// Rate at which the air in a source's body takes up its speed, 1/s.
const DRIVE: f32 = 3000.0;
/// Loss at the boundary of air that is drawn in, in units of its pressure of speed over a cell: air from rest has none to bring
/// along. Without, a draught through the box feeds itself for ever (measured: 100 cm/s
/// after five seconds of calm, and no slower in the end; now 7).
const IN_LOSS: f32 = 2.0;
/// Eddies that turn slower than this are driven less, 1/s: air slower than about 15 cm/s is smoothed by the grid less than it is
/// driven, and would never come to rest.
const CALM_CURL: f32 = 20.0;
/// Fastest head, cm/s.
const FASTEST_HEAD: f32 = 1000.0;
/// Slits narrower than this share of a face are closed.
const LEAST_OPEN: f32 = 0.02;

/// What a step reads.
pub struct Before<'a> {
    pub grid: &'a GridParams,
    pub free: &'a FreeAir,
    pub obstacles: Obstacles<'a>,
    pub pose: Pose,
    pub pose_before: Pose,
    /// Speeds through the lower faces, as the last frame left them.
    pub faces: &'a [Vec4],
    /// Velocity in the middle of every cell, of the last frame.
    pub air: &'a [Vec4],
    /// Mass and momentum of hair, four numbers a cell.
    pub hair_cells: &'a [i32],
    /// Rotation of the air and its size (w).
    pub curls: &'a [Vec4],
}

fn unit(axis: usize) -> Vec3 {
    Vec3::AXES[axis]
}

fn step_of(axis: usize) -> UVec3 {
    UVec3::AXES[axis]
}

impl Before<'_> {
    /// Velocity in the last frame at a place; beyond the box that at its boundary, for what was drawn in goes on so.
    fn air_before(&self, p: Vec3) -> Vec3 {
        let g = (p - self.grid.min_before) / self.grid.cell;
        trilinear(self.air, self.grid.n, g.clamp(Vec3::ZERO, Vec3::splat(self.grid.n as f32))).xyz()
    }

    fn is_inside(&self, g: Vec3) -> bool {
        g.cmpge(Vec3::ZERO).all() && g.cmple(Vec3::splat(self.grid.n as f32)).all()
    }

    /// Speed along an axis in the last frame at a place, from the faces.
    fn face_before(&self, p: Vec3, axis: usize) -> f32 {
        let g = (p - self.grid.min_before) / self.grid.cell;
        if !self.is_inside(g) {
            return self.free.free_air(p)[axis];
        }
        let along = unit(axis);
        let highest = Vec3::splat(self.grid.n as f32 - 1.0) + along;
        let inside = (g - 0.5 * (1.0 - along)).clamp(Vec3::ZERO, highest);
        let corner = inside.as_uvec3().min(UVec3::splat(self.grid.n - 2) + step_of(axis));
        let t = inside - corner.as_vec3();
        let at = self.grid.entry(corner);
        let row = self.grid.n as usize + 1;
        let z = at + row * row;
        let face = |at: usize| self.faces[at][axis];
        let y0 = mix(mix(face(at), face(at + 1), t.x), mix(face(at + row), face(at + row + 1), t.x), t.y);
        let y1 = mix(mix(face(z), face(z + 1), t.x), mix(face(z + row), face(z + row + 1), t.x), t.y);
        mix(y0, y1, t.z)
    }

    /// Speed along an axis of the air that arrives at a place: back along the path by the midpoint rule. What has come through
    /// a fan on its way has the fan's speed.
    fn carried(&self, p: Vec3, axis: usize) -> f32 {
        let halfway = p - 0.5 * self.grid.dt_secs * self.air_before(p);
        let came_from = p - self.grid.dt_secs * self.air_before(halfway);
        let mut v = self.face_before(came_from, axis);
        for source in self.free.blowing() {
            let blown = self.free.blown_through(source, came_from, p, self.grid.cell);
            v += blown.w * (blown[axis] - v);
        }
        v
    }

    fn clamped(&self, c: IVec3) -> usize {
        self.grid.entry(c.clamp(IVec3::ZERO, IVec3::splat(self.grid.n as i32 - 1)).as_uvec3())
    }

    fn air_in(&self, c: IVec3) -> Vec3 {
        self.air[self.clamped(c)].xyz()
    }

    /// How the air of the last frame turns in a cell.
    fn curl(&self, c: IVec3) -> Vec3 {
        let dx = self.air_in(c + IVec3::X) - self.air_in(c - IVec3::X);
        let dy = self.air_in(c + IVec3::Y) - self.air_in(c - IVec3::Y);
        let dz = self.air_in(c + IVec3::Z) - self.air_in(c - IVec3::Z);
        Vec3::new(dy.z - dz.y, dz.x - dx.z, dx.y - dy.x) / (2.0 * self.grid.cell)
    }

    fn curl_size(&self, c: IVec3) -> f32 {
        self.curls[self.clamped(c)].w
    }

    /// Acceleration that drives eddies in a cell, cm/s2.
    fn confinement(&self, c: IVec3) -> Vec3 {
        let at = c.clamp(IVec3::ZERO, IVec3::splat(self.grid.n as i32 - 1));
        let slope = |axis: IVec3| self.curl_size(at + axis) - self.curl_size(at - axis);
        let uphill = Vec3::new(slope(IVec3::X), slope(IVec3::Y), slope(IVec3::Z));
        let steep = uphill.length();
        if steep < 1e-6 {
            return Vec3::ZERO;
        }
        let omega = self.curls[self.clamped(at)];
        let rate = self.grid.vorticity * omega.w / (omega.w + CALM_CURL);
        rate * self.grid.cell * (uphill / steep).cross(omega.xyz())
    }

    /// How open a place of the size of a cell is: 0 in the head, 1 outside.
    fn open_at(&self, p: Vec3) -> f32 {
        if self.grid.obstacle == 0 {
            return 1.0;
        }
        let in_head = self.pose.apply_inverse(p);
        let mut distance = self.obstacles.field.map_or(1e9, |field| field.sample(in_head));
        for capsule in self.obstacles.capsules {
            distance = distance.min(capsule.distance(if capsule.on_head == 1 { in_head } else { p }));
        }
        let open = (0.5 + distance / self.grid.cell).clamp(0.0, 1.0);
        if open < LEAST_OPEN { 0.0 } else { open }
    }

    /// Velocity of the head at a place.
    fn head_velocity(&self, p: Vec3) -> Vec3 {
        let before = self.pose_before.apply(self.pose.apply_inverse(p));
        ((p - before) / self.grid.dt_secs).clamp(Vec3::splat(-FASTEST_HEAD), Vec3::splat(FASTEST_HEAD))
    }

    /// Hair in a cell, in units of mass (x) and of momentum along an axis (y).
    fn hair_in(&self, c: IVec3, axis: usize) -> Vec2 {
        if c.cmplt(IVec3::ZERO).any() || c.cmpge(IVec3::splat(self.grid.n as i32)).any() {
            return Vec2::ZERO;
        }
        let at = 4 * self.grid.entry(c.as_uvec3());
        Vec2::new(self.hair_cells[at] as f32, self.hair_cells[at + 1 + axis] as f32)
    }

    /// Through a lower face: the speed before the pressure (x), and what a difference of pressure does to it (y).
    fn predict_face(&self, c: UVec3, axis: usize) -> Vec2 {
        let grid = self.grid;
        let p = grid.min + grid.cell * (c.as_vec3() + 0.5 * (1.0 - unit(axis)));
        let above = c.as_ivec3();
        let below = above - step_of(axis).as_ivec3();
        let mut v = self.carried(p, axis);
        if grid.vorticity > 0.0 {
            v += 0.5 * grid.dt_secs * (self.confinement(below)[axis] + self.confinement(above)[axis]);
        }
        // Compute what hair and sources make of it in a step, as if they pulled with the speed at its end.
        let mut pulled = v;
        let mut pull = 1.0;
        let hair = self.hair_in(below, axis) + self.hair_in(above, axis);
        if hair.x > 0.0 && grid.hair_drag > 0.0 {
            let density = 0.5 * hair.x / (grid.mass_unit * grid.cell * grid.cell * grid.cell);
            let hair_speed = (hair.y / grid.momentum_unit) / (hair.x / grid.mass_unit);
            let k = grid.dt_secs * grid.hair_drag * density;
            pulled += k * hair_speed;
            pull += k;
        }
        for source in self.free.blowing() {
            let driven = self.free.body(source, p, grid.cell);
            if driven.w > 0.0 {
                let k = grid.dt_secs * DRIVE * driven.w;
                pulled += k * driven[axis];
                pull += k;
            }
        }
        let inwards = f32::from(c[axis] == 0) - f32::from(c[axis] == grid.n);
        let mut outside = Vec3::ZERO;
        if inwards != 0.0 {
            outside = self.free.free_air(p).clamp(Vec3::splat(-MAX_SPEED), Vec3::splat(MAX_SPEED));
            // Air that is drawn in faster than it blows outside loses the pressure that it took to draw it.
            let excess = (inwards * (self.face_before(p, axis) - outside[axis])).max(0.0);
            let k = IN_LOSS * grid.dt_secs / grid.cell * excess;
            pulled += k * outside[axis];
            pull += k;
        }
        let open = self.open_at(p);
        let mut speed = open * pulled / pull;
        if open < 1.0 {
            speed += (1.0 - open) * self.head_velocity(p)[axis];
        }
        if speed.is_nan() || speed.abs() > MAX_SPEED {
            speed = open * self.free.steady[axis].clamp(-MAX_SPEED, MAX_SPEED);
        }
        let mut push = open / pull;
        if inwards != 0.0 {
            // Outside there is no pressure, from the face on: half a cell away. Where wind comes in it is what it is.
            let held = (2.0 * inwards * outside[axis] / outside.length().max(1e-3)).clamp(0.0, 1.0);
            speed += open * held * (outside[axis] - speed);
            push *= 2.0 * (1.0 - held);
        }
        Vec2::new(speed, push)
    }

    /// Of a cell: how the air turns in it, and how fast (w).
    pub fn turn(&self, c: UVec3) -> Vec4 {
        let omega = self.curl(c.as_ivec3());
        omega.extend(omega.length())
    }

    /// Of a cell's lower faces: speeds before the pressure, and how open the cell is (w); what a difference of pressure
    /// does to them.
    pub fn predict(&self, c: UVec3) -> (Vec4, Vec4) {
        let (mut speeds, mut open) = (Vec4::ZERO, Vec4::ZERO);
        for axis in 0..3 {
            // The other two axes end a cell earlier.
            if c.cmplt(UVec3::splat(self.grid.n) + step_of(axis)).all() {
                let face = self.predict_face(c, axis);
                speeds[axis] = face.x;
                open[axis] = face.y;
            }
        }
        speeds.w = self.open_at(self.grid.min + self.grid.cell * (c.as_vec3() + 0.5));
        (speeds, open)
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

#[cfg(test)]
mod tests {
    use super::super::grid::{AirBox, WindFrame};
    use super::super::hair::{HairParams, splat};
    use super::*;
    use crate::laws::wind::windy;

    #[test]
    fn what_the_air_loses_is_what_hair_is_given() {
        let (mut settings, blows) = (windy(200.0, 16), 200.0);
        settings.air.vorticity = 0.0;
        let ends = [Vec3::splat(-12.5), Vec3::splat(12.5)];
        let mut air_box = AirBox::around(ends.into_iter(), &settings, Pose::IDENTITY);
        // A lock of 3 g that is held.
        let lock: Vec<Vec4> = (0..40).map(|k| Vec4::new(0.3, 0.1 * k as f32, -0.4, 0.0)).collect();
        let windage = vec![3.0 / 40.0; 40];
        let grid = air_box.advance(&settings, &WindFrame::first(Pose::IDENTITY), 3.0);
        let mut hair_cells = vec![0; 4 * grid.n_entries()];
        let params = HairParams::new(1, 40, None);
        (0..40).for_each(|item| splat(&grid, &params, item, &lock, &windage, &mut lock.clone(), &mut hair_cells));
        let air = vec![Vec4::new(blows, 0.0, 0.0, 1.0); grid.n_entries()];
        let before = Before {
            grid: &grid,
            free: &FreeAir::new(&settings, 0.0),
            obstacles: Obstacles::new(None, &[], &settings),
            pose: Pose::IDENTITY,
            pose_before: Pose::IDENTITY,
            faces: &air,
            air: &air,
            hair_cells: &hair_cells,
            curls: &[],
        };
        let cell_of = grid.entries();
        let predicted: Vec<Vec4> = (0..grid.n_entries()).map(|at| before.predict(cell_of(at)).0).collect();
        let is_cell = |at: usize| cell_of(at).cmplt(UVec3::splat(grid.n)).all();
        let lost: f32 = (0..predicted.len()).filter(|&at| is_cell(at)).map(|at| blows - predicted[at].x).sum();
        let lost = 1.2e-3 * grid.cell.powi(3) * lost;
        let mut middles = predicted.clone();
        (0..middles.len())
            .filter(|&at| is_cell(at))
            .for_each(|at| middles[at].x = 0.5 * (predicted[at].x + predicted[at + 1].x));
        let in_air = |p: &Vec4| trilinear(&middles, grid.n, (p.xyz() - grid.min) / grid.cell).x;
        let given: f32 = lock.iter().map(|p| 3.0 / 40.0 * grid.dt_secs * settings.drag * in_air(p)).sum();
        assert!(lost > 1.0 && (given / lost - 1.0).abs() < 0.1, "{lost} lost, {given} given, g cm/s");
    }
}
