//! A hand in the viewport that holds hair: which hair it took hold of, and where it pulls it to.
//!
//! A press takes the vertex that is seen nearest to the pointer, of what the solver moves; the head hides what is behind it.
//! From then on the hand goes in the plane of the picture through where that vertex was. The pull acts while time passes.

use glam::{Affine3A, Mat4, Vec2, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::camera::Camera;
use lorelei_core::distance_field::DistanceField;
use lorelei_shaders::{Gpu, GpuError};
use lorelei_sim::{GpuSolver, Pull};

/// How far from the pointer hair is taken hold of, in halves of the picture's height.
const GRASP: f32 = 0.12;
/// A vertex so much farther from the eye counts as if it were a whole [`GRASP`] farther from the pointer, cm.
const GRASP_DEPTH: f32 = 12.0;
/// What is deeper than this in the head hides what is behind, cm.
const HIDES: f32 = 0.3;

/// What a person does with the hand: not in the document, never undone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Counts presses: another number takes hold anew.
    pub n_grabs: u64,
    /// Where the pointer is: the picture's middle is 0, and 1 its right and its upper side.
    pub at: Vec2,
    /// How far around what is held hair follows, cm.
    pub radius: f32,
    /// Force over the mass of a strand and the way to the hand, 1/s2.
    pub strength: f32,
}

/// Who looks: a picture's camera, and its width over its height.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    pub camera: Camera,
    pub aspect: f32,
}

impl Sight {
    /// The place that is seen at `at`, as far from the eye as `depth`.
    fn place(&self, at: Vec2, depth: f32) -> Vec3 {
        let half_height = depth * (0.5 * self.camera.fov_y_deg.to_radians()).tan();
        let in_view = Vec3::new(at.x * self.aspect * half_height, at.y * half_height, -depth);
        self.camera.view_from_world().inverse().transform_point3(in_view)
    }
}

/// Where a place is seen: as [`Hand::at`], and how far from the eye. `None` behind it.
fn seen(clip_from_world: &Mat4, p: Vec3) -> Option<(Vec2, f32)> {
    let clip = *clip_from_world * p.extend(1.0);
    (clip.w > 1e-3).then(|| (clip.xy() / clip.w, clip.w))
}

/// A vertex of what a solver moves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grabbed {
    layer_idx: usize,
    vertex_idx: usize,
    pull: Pull,
    /// From the eye, cm.
    depth: f32,
    /// From the place under the pointer to the vertex, when it was taken hold of.
    aside: Vec3,
    /// Where it was in the last picture.
    at: Vec3,
}

/// Held hair, for whoever draws it. World.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Where the held vertex is.
    pub at: Vec3,
    pub hand: Vec3,
}

/// The hand's hold.
#[derive(Debug, Default)]
pub struct Hold {
    /// The last press that was answered.
    n_grabs: u64,
    grabbed: Option<Grabbed>,
    /// The held vertex on its way to the CPU.
    staging: Option<wgpu::Buffer>,
}

impl Hold {
    /// Whether a press is still to be answered with [`Hold::grab`].
    pub fn wants_grab(&self, hand: Option<&Hand>) -> bool {
        hand.is_some_and(|hand| hand.n_grabs != self.n_grabs)
    }

    /// Take hold of what is under the pointer, if anything is. Waits for the GPU.
    pub fn grab(
        &mut self,
        hand: &Hand,
        solver: &GpuSolver,
        field: Option<&DistanceField>,
        world_from_head: &Affine3A,
        sight: &Sight,
    ) -> Result<(), GpuError> {
        self.n_grabs = hand.n_grabs;
        self.grabbed = None;
        let layers: Vec<(Vec<Vec4>, u32)> = (0..solver.n_layers())
            .map(|layer_idx| Ok((solver.read_curves(layer_idx)?, solver.curves(layer_idx).n_vertices)))
            .collect::<Result<_, GpuError>>()?;
        let Some((layer_idx, vertex_idx, at)) = pick(&layers, hand.at, field, world_from_head, sight) else {
            return Ok(());
        };
        let Some(pull) = Pull::of_vertex(solver.curves(layer_idx), vertex_idx) else { return Ok(()) };
        let clip_from_world = sight.camera.clip_from_world(sight.aspect);
        let depth = seen(&clip_from_world, at).map_or(1.0, |(_, depth)| depth);
        let aside = at - sight.place(hand.at, depth);
        self.grabbed = Some(Grabbed { layer_idx, vertex_idx, pull, depth, aside, at });
        Ok(())
    }

    /// Go where the pointer is, or let go.
    pub fn follow(&mut self, hand: Option<&Hand>, sight: &Sight) {
        let Some(hand) = hand.filter(|hand| hand.n_grabs == self.n_grabs) else {
            self.grabbed = None;
            return;
        };
        if let Some(grabbed) = &mut self.grabbed {
            grabbed.pull.hand = sight.place(hand.at, grabbed.depth) + grabbed.aside;
            (grabbed.pull.radius, grabbed.pull.strength) = (hand.radius, hand.strength);
        }
    }

    /// Let go of what is not there any more; the press stays answered.
    pub fn drop_hair(&mut self) {
        self.grabbed = None;
    }

    pub fn pull(&self) -> Option<Pull> {
        self.grabbed.map(|grabbed| grabbed.pull)
    }

    pub fn held(&self) -> Option<Held> {
        self.grabbed.map(|grabbed| Held { at: grabbed.at, hand: grabbed.pull.hand })
    }

    /// Let the held vertex be brought to the CPU.
    pub fn record(&mut self, gpu: &Gpu, solver: &GpuSolver, encoder: &mut wgpu::CommandEncoder) {
        let Some(grabbed) = &self.grabbed else { return };
        let is_there = grabbed.layer_idx < solver.n_layers()
            && grabbed.vertex_idx < solver.curves(grabbed.layer_idx).positions.len();
        if !is_there {
            self.grabbed = None;
            return;
        }
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stage.held"),
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let curves = solver.curves_buffer(grabbed.layer_idx);
        encoder.copy_buffer_to_buffer(curves, 16 * grabbed.vertex_idx as u64, &staging, 0, 16);
        self.staging = Some(staging);
    }

    /// Keep where it was; the commands were submitted, and are done.
    pub fn collect(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let Some(staging) = self.staging.take() else { return Ok(()) };
        let at: Vec4 = gpu.read_mapped(&staging, |bytes| bytemuck::pod_read_unaligned(&bytes[..16]))?;
        if let Some(grabbed) = &mut self.grabbed {
            grabbed.at = at.xyz();
        }
        Ok(())
    }
}

/// The vertex that a press at `at` takes hold of: its layer, its index, and where it is. What goes with the head cannot be
/// held.
fn pick(
    layers: &[(Vec<Vec4>, u32)],
    at: Vec2,
    field: Option<&DistanceField>,
    world_from_head: &Affine3A,
    sight: &Sight,
) -> Option<(usize, usize, Vec3)> {
    let clip_from_world = sight.camera.clip_from_world(sight.aspect);
    let mut candidates = Vec::new();
    for (layer_idx, (positions, n_vertices)) in layers.iter().enumerate() {
        let n_vertices = (*n_vertices).max(1) as usize;
        for (vertex_idx, p) in positions.iter().enumerate().filter(|(idx, _)| idx % n_vertices >= 2) {
            let Some((there, depth)) = seen(&clip_from_world, p.xyz()) else { continue };
            let away = ((there - at) * Vec2::new(sight.aspect, 1.0)).length();
            if away < GRASP {
                candidates.push((away / GRASP + depth / GRASP_DEPTH, layer_idx, vertex_idx, p.xyz()));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let head_from_world = world_from_head.inverse();
    let eye = head_from_world.transform_point3(sight.camera.eye());
    let is_seen = |p: Vec3| field.is_none_or(|field| !hides(field, eye, head_from_world.transform_point3(p)));
    let found = candidates.into_iter().find(|(_, _, _, p)| is_seen(*p))?;
    Some((found.1, found.2, found.3))
}

/// Whether the head is between the eye and a place; all in head space.
fn hides(field: &DistanceField, eye: Vec3, p: Vec3) -> bool {
    let way = eye.distance(p);
    let toward = (p - eye) / way.max(1e-6);
    let mut t = 0.0;
    for _ in 0..256 {
        // Hair that lies on the skin is not hidden by it.
        if t >= way - 1.0 {
            return false;
        }
        let distance = field.sample(eye + t * toward);
        if distance < -HIDES {
            return true;
        }
        t += distance.max(0.5 * HIDES);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight() -> Sight {
        Sight { camera: Camera { azimuth_deg: 0.0, elevation_deg: 0.0, ..Camera::default() }, aspect: 1.5 }
    }

    /// The distance to a ball of 9 cm.
    fn ball() -> DistanceField {
        let (n, cell, min) = (24_u32, 1.0, Vec3::splat(-11.5));
        let node = |i: u32| min + cell * glam::UVec3::new(i % n, i / n % n, i / (n * n)).as_vec3();
        DistanceField { min, cell, n: [n; 3], values: (0..n * n * n).map(|i| node(i).length() - 9.0).collect() }
    }

    #[test]
    fn a_place_is_found_again_where_it_is_seen() {
        let sight = Sight { camera: Camera::default(), aspect: 1.7 };
        let p = Vec3::new(3.0, -4.0, 5.0);
        let (at, depth) = seen(&sight.camera.clip_from_world(sight.aspect), p).unwrap();
        assert!(sight.place(at, depth).distance(p) < 1e-3);
    }

    #[test]
    fn the_hair_in_front_is_taken_and_none_through_the_head_nor_far_from_the_pointer() {
        let sight = sight();
        let strand = |z: f32| (0..4).map(move |k| Vec4::new(0.0, 3.0 - k as f32, z, 0.0));
        let layers = [(strand(-14.0).collect(), 4), (strand(12.0).chain(strand(10.0)).collect(), 4)];
        let (front, _) = seen(&sight.camera.clip_from_world(1.5), Vec3::new(0.0, 1.0, 12.0)).unwrap();
        let taken = |layers: &[(Vec<Vec4>, u32)], at, field: Option<&DistanceField>| {
            pick(layers, at, field, &Affine3A::IDENTITY, &sight).map(|(layer, vertex, _)| (layer, vertex))
        };
        assert_eq!(taken(&layers, front, Some(&ball())), Some((1, 2)));
        assert_eq!(taken(&layers[..1], front, Some(&ball())), None, "the head is in front");
        assert_eq!(taken(&layers[..1], front, None), Some((0, 2)));
        assert_eq!(taken(&layers, front + Vec2::new(0.3, 0.0), None), None);
        assert_eq!(taken(&[], front, None), None);
        // The vertices at the root go with the head.
        let (root, _) = seen(&sight.camera.clip_from_world(1.5), Vec3::new(0.0, 3.0, 12.0)).unwrap();
        assert_eq!(taken(&layers, root, None), Some((1, 2)));
        let not_finite = [(vec![Vec4::NAN; 8], 4)];
        assert_eq!(taken(&not_finite, front, None), None);
    }
}
