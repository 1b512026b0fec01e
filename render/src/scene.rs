//! The lights as the GPU sees them, and where the scene's middle is. Twin of `shade_lights.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::light::{INTENSITY_DISTANCE, Light, LightKind};
use lorelei_core::look::{Environment, Look};
use lorelei_shaders::Gpu;

use crate::environment::{EnvironmentUniform, probe_directions};

/// A light without extent. A rectangle is several of them.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SceneLight {
    /// w 0: unit vector to a light at infinity; w 1: its place, centimetres.
    pub place: [f32; 4],
    /// Irradiance of a surface facing it; of a light with a place: at 1 cm.
    pub irradiance: [f32; 3],
    /// 1: emits by the cosine to `axis`.
    pub is_flat: f32,
    pub axis: [f32; 3],
    /// Radius of a disc that emits as this does, for the softness of shadows: centimetres, or for a light at infinity
    /// the tangent of its angular radius.
    pub radius: f32,
}

/// Twin of `Scene`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct SceneUniform {
    pub eye: [f32; 3],
    pub n_lights: u32,
    pub environment: [f32; 3],
    /// 0-1: of a fibre itself, times the share of a pixel that it covers.
    pub opacity: f32,
    pub n_probes: u32,
    pub pad: [u32; 3],
    pub around: EnvironmentUniform,
}

/// Points that stand for a side of a rectangular light: 2 x 2 of them are enough for highlights, and their four shadow
/// maps overlap into a soft one.
const RECT_SIDE_SAMPLES: u32 = 2;

/// Angular radius (tangent) of directional lights: a studio's soft box, not the sun.
const DIRECTIONAL_RADIUS: f32 = 0.06;
/// Radius of point lights, centimetres.
const POINT_RADIUS: f32 = 3.0;
/// Angular radius (tangent) of a probe: it stands for a quarter of the sphere.
const PROBE_RADIUS: f32 = 0.4;

/// The scene's lights this frame, with whether each casts a shadow.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SceneLights {
    pub lights: Vec<SceneLight>,
    pub casts_shadow: Vec<bool>,
    /// Which of the groom's lights each is of; probes are of none and have no entry.
    pub of_light: Vec<u32>,
    /// The last ones: they shine on nothing, and where they are hidden from, the environment is.
    pub n_probes: usize,
}

impl SceneLights {
    pub fn new(lights: &[Light]) -> Self {
        let mut scene = Self::default();
        for (light_idx, light) in lights.iter().enumerate().filter(|(_, light)| light.on) {
            let e = Vec3::from_array(light.colour) * light.intensity * std::f32::consts::PI;
            let mut push = |place: Vec3, w: f32, irradiance: Vec3, axis: Option<Vec3>, radius: f32| {
                scene.lights.push(SceneLight {
                    place: place.extend(w).to_array(),
                    irradiance: irradiance.to_array(),
                    is_flat: if axis.is_some() { 1.0 } else { 0.0 },
                    axis: axis.unwrap_or_default().to_array(),
                    radius,
                });
                scene.casts_shadow.push(light.casts_shadow);
                scene.of_light.push(light_idx as u32);
            };
            let at_1_cm = e * INTENSITY_DISTANCE * INTENSITY_DISTANCE;
            match light.kind {
                LightKind::Directional { .. } => push(light.direction_to(Vec3::ZERO), 0.0, e, None, DIRECTIONAL_RADIUS),
                LightKind::Point { position } => push(position, 1.0, at_1_cm, None, POINT_RADIUS),
                LightKind::Rect { position, target, size } => {
                    let axis = (target - position).normalize_or(Vec3::NEG_Y);
                    let (side, up) = axis.any_orthonormal_pair();
                    let n = RECT_SIDE_SAMPLES;
                    // The disc of a sample's share of the square.
                    let radius = size / n as f32 / std::f32::consts::PI.sqrt();
                    let at = |k: u32| ((k as f32 + 0.5) / n as f32 - 0.5) * size;
                    for k in 0..n * n {
                        let place = position + side * at(k % n) + up * at(k / n);
                        push(place, 1.0, at_1_cm / (n * n) as f32, Some(axis), radius);
                    }
                }
            }
        }
        scene
    }

    /// The same with the probes that the look's environment asks for, behind the lamps.
    pub fn with_probes(mut self, look: &Look) -> Self {
        if look.environment.is_pictured() {
            for direction in probe_directions() {
                self.lights.push(SceneLight {
                    place: direction.extend(0.0).to_array(),
                    irradiance: [0.0; 3],
                    is_flat: 0.0,
                    axis: [0.0; 3],
                    radius: PROBE_RADIUS,
                });
                self.casts_shadow.push(true);
                self.n_probes += 1;
            }
        }
        self
    }

    /// Those that shine, or may.
    pub fn n_lamps(&self) -> usize {
        self.lights.len() - self.n_probes
    }
}

/// The scene's buffers, bound by whatever shades: hair and head.
#[derive(Debug)]
pub struct SceneBuffers {
    scene: wgpu::Buffer,
    lights: wgpu::Buffer,
    n_lights_allocated: usize,
}

impl SceneBuffers {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            scene: gpu.buffer("scene", size_of::<SceneUniform>() as u64, wgpu::BufferUsages::UNIFORM),
            lights: lights_buffer(gpu, 4),
            n_lights_allocated: 4,
        }
    }

    /// Send this frame's lights. True where a buffer is another one: bind again.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        lights: &SceneLights,
        surroundings: &EnvironmentUniform,
        look: &Look,
        eye: Vec3,
    ) -> bool {
        let is_new = lights.lights.len() > self.n_lights_allocated;
        if is_new {
            self.n_lights_allocated = lights.lights.len().next_power_of_two();
            self.lights = lights_buffer(gpu, self.n_lights_allocated);
        }
        let environment = match look.environment {
            Environment::Constant => Vec3::from_array(look.environment_colour) * look.environment_intensity,
            Environment::Karis | Environment::Harmonics | Environment::Off => Vec3::ZERO,
        };
        let uniform = SceneUniform {
            eye: eye.to_array(),
            n_lights: lights.n_lamps() as u32,
            environment: environment.to_array(),
            opacity: look.drawing.opacity,
            n_probes: lights.n_probes as u32,
            pad: [0; 3],
            around: *surroundings,
        };
        gpu.queue.write_buffer(&self.scene, 0, bytemuck::bytes_of(&uniform));
        gpu.queue.write_buffer(&self.lights, 0, bytemuck::cast_slice(&lights.lights));
        is_new
    }

    /// By the names of `shade_lights.wgsl`.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 2] {
        [("scene", self.scene.as_entire_binding()), ("scene_lights", self.lights.as_entire_binding())]
    }
}

fn lights_buffer(gpu: &Gpu, n_lights: usize) -> wgpu::Buffer {
    gpu.buffer("scene.lights", (n_lights * size_of::<SceneLight>()) as u64, wgpu::BufferUsages::STORAGE)
}

/// A ball around everything that casts or receives shadows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Head space, centimetres.
    pub centre: Vec3,
    pub radius: f32,
}

impl Ball {
    /// Height in the picture as a share of the picture's.
    pub fn share_of_picture(&self, camera: &Camera) -> f32 {
        let distance = camera.eye().distance(self.centre).max(1e-3);
        self.radius / (distance * (0.5 * camera.fov_y_deg.to_radians()).tan())
    }

    /// Around the head and the hair at rest, with room for hair that swings.
    pub fn of_groom(groom: &Groom) -> Self {
        let mut bounds = groom.head.as_ref().and_then(|head| head.mesh.bounds());
        let mut grow = |other: Option<(Vec3, Vec3)>| {
            let Some((lo, hi)) = other else { return };
            bounds = Some(bounds.map_or((lo, hi), |(a, b)| (a.min(lo), b.max(hi))));
        };
        for layer in groom.layers.iter().filter(|layer| layer.visible) {
            match &layer.source {
                Source::HairMesh(mesh) => {
                    for layer in &mesh.layers {
                        for &p in &layer.positions {
                            grow(Some((p, p)));
                        }
                    }
                }
                Source::Guides(strands) | Source::Strands(strands) => grow(strands.bounds()),
            }
        }
        let Some((lo, hi)) = bounds else { return Self { centre: Vec3::ZERO, radius: 1.0 } };
        // Hair that swings leaves its box at rest by some centimetres; beyond the ball it only loses its shadow.
        Self { centre: 0.5 * (lo + hi), radius: 0.5 * lo.distance(hi) + 3.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_the_power_of_a_point_on_its_axis() {
        let rect = Light::rect_from_watts("key", Vec3::new(0.0, 0.0, 100.0), Vec3::ZERO, 1.0, 25.0);
        let scene = SceneLights::new(std::slice::from_ref(&rect));
        assert_eq!(scene.lights.len(), 4);
        let e: f32 = scene
            .lights
            .iter()
            .map(|light| {
                let to_light = Vec3::from_slice(&light.place[..3]);
                light.irradiance[0] * -to_light.normalize().dot(Vec3::from_array(light.axis))
                    / to_light.length_squared()
            })
            .sum();
        assert!((e / (std::f32::consts::PI * rect.intensity) - 1.0).abs() < 1e-3, "{e}");
    }

    #[test]
    fn a_light_that_is_off_is_not_there() {
        let mut light = Light::directional("key", 0.0, 0.0, 1.0, [1.0; 3]);
        assert_eq!(SceneLights::new(std::slice::from_ref(&light)).lights[0].place, [0.0, 0.0, 1.0, 0.0]);
        light.on = false;
        assert!(SceneLights::new(&[light]).lights.is_empty());
    }
}
