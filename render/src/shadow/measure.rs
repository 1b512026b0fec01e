//! What each shadow technique gets wrong, and what it costs: transmittance at fragments against [`super::exact`], times
//! of its passes and of its look-ups, and bytes.

use glam::{Affine3A, DVec3, Vec3, Vec4};
use lorelei_core::groom::Groom;
use lorelei_core::light::Light;
use lorelei_core::lod::LodBlend;
use lorelei_core::look::{ShadowParams, Shadowing};
use lorelei_shaders::{Gpu, Kernel, ShaderLibrary};
use rayon::prelude::*;
use wgpu::BufferUsages;

use super::exact::{ExactShadow, Occluders};
use super::{Shadow, ShadowInput};
use crate::generate::{StrandGenerator, StrandPose};
use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::overlay::Veil;
use crate::profile::Profile;
use crate::renderer::RenderError;
use crate::scene::{Ball, SceneLights};
use crate::slot;

/// Radius of the disc through which a fragment sees the light, centimetres: the blur that a lamp of the studio's size
/// (tangent 0.06) gives an occluder 1.6 cm away, and about two texels of a map of 1024.
pub const FOOTPRINT_CM: f64 = 0.1;
/// Look-ups that are timed.
const N_TIMED: usize = 1 << 20;
/// Straight strands that stray before the hair, and how far before its ball's middle, as a share of the radius.
const N_STRAYS: u32 = 400;
const STRAY_DISTANCE: f32 = 0.85;

/// Hair under one light, with the exact answers at some of its fragments.
pub struct ShadowScene {
    strands: StrandBuffers,
    lights: SceneLights,
    ball: Ball,
    groom: Groom,
    /// Places of the fragments that the head does not hide from the light.
    probes: Vec<Vec3>,
    /// Share of the light that is left there.
    exact: Vec<f64>,
    timed: Vec<[f32; 4]>,
}

/// What one technique does on a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowScore {
    /// Side of the map, texels: what fits the GPU.
    pub resolution: u32,
    pub n_bytes: u64,
    /// Milliseconds of all passes, median; `None`: the GPU has no timestamps.
    pub build_ms: Option<f64>,
    /// Milliseconds of a million look-ups at hair.
    pub look_up_ms: Option<f64>,
    /// Of the share of the light that is left, 0-1.
    pub mean_error: f64,
    pub error_99: f64,
    /// Mean of what is too bright (positive) or too dark.
    pub bias: f64,
    /// Mean error where at least nine tenths of the light are left: the front of the hair.
    pub lit_error: f64,
}

impl ShadowScene {
    /// About `n_probes` fragments of a groom's strands, evenly taken. With `strays` there are strands before the hair that
    /// fall from no head.
    pub fn new(
        gpu: &Gpu,
        library: &ShaderLibrary,
        groom: &Groom,
        light: &Light,
        strays: bool,
        n_probes: usize,
    ) -> Result<Self, RenderError> {
        let ball = Ball::of_groom(groom);
        let lights = SceneLights::new(std::slice::from_ref(light));
        let (mut vertices, mut layers) = strands_of(gpu, library, groom)?;
        let n_hair: u32 = layers.iter().map(|layer| layer.n_strands).sum();
        if strays {
            let first_vertex = vertices.len() as u32;
            vertices.extend(stray_strands(ball, light.direction_to(ball.centre)));
            let stray = DrawnLayer { first_vertex, first_strand: n_hair, n_strands: N_STRAYS, ..DrawnLayer::default() };
            layers.push(DrawnLayer { vertices_per_strand: 2, ..stray });
        }
        let bytes: Vec<[f32; 4]> = vertices.iter().map(Vec4::to_array).collect();
        let n_strands = layers.iter().map(|layer| layer.n_strands).sum();
        let strands = StrandBuffers {
            vertices: gpu.buffer_of("measure.vertices", &bytes, BufferUsages::STORAGE),
            seeds: gpu.buffer_of("measure.seeds", &[[0_u32; 2]], BufferUsages::STORAGE),
            n_vertices: vertices.len() as u32,
            n_strands,
            widest: vertices.iter().map(|v| v.w).fold(0.0, f32::max),
            generation: 1,
            layers,
        };
        let mut scene = Self {
            strands,
            lights,
            ball,
            groom: groom.clone(),
            probes: Vec::new(),
            exact: Vec::new(),
            timed: bytes.iter().take(N_TIMED).map(|&[x, y, z, _]| [x, y, z, 0.0]).collect(),
        };
        scene.ask_exact(gpu, library, &vertices, n_probes)?;
        Ok(scene)
    }

    fn ask_exact(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        vertices: &[Vec4],
        n_probes: usize,
    ) -> Result<(), RenderError> {
        // Strays come last, and have two vertices.
        let is_hair = |layer: &&Occluders<'_>| layer.vertices_per_strand > 2;
        let layers: Vec<Occluders<'_>> = (self.strands.layers.iter())
            .map(|layer| Occluders {
                vertices: &vertices[layer.first_vertex as usize..]
                    [..(layer.n_strands * layer.vertices_per_strand) as usize],
                vertices_per_strand: layer.vertices_per_strand as usize,
            })
            .collect();
        let mut all: Vec<(Vec3, u32)> = Vec::new();
        let mut first_strand = 0;
        for layer in layers.iter().filter(is_hair) {
            let strand_of = |k: usize| first_strand + (k / layer.vertices_per_strand) as u32;
            all.extend(layer.vertices.iter().enumerate().map(|(k, v)| (v.truncate(), strand_of(k))));
            first_strand += (layer.vertices.len() / layer.vertices_per_strand) as u32;
        }
        // A stride that no number of vertices a strand divides takes all parts of the strands alike.
        let stride = (all.len() / n_probes.max(1)).max(1) | 1;
        let all: Vec<(Vec3, u32)> = all.into_iter().step_by(stride).collect();
        self.probes = all.iter().map(|probe| probe.0).collect();
        let params = ShadowParams { resolution: 1024, ..ShadowParams::default() };
        let answers = self.run(gpu, library, Shadowing::ShadowMap, &params, 1)?.answers;
        let lit: Vec<(Vec3, u32)> =
            all.into_iter().zip(&answers).filter(|(_, answer)| answer[1] > 0.99).map(|(probe, _)| probe).collect();
        let middle = self.ball.centre.as_dvec3();
        let exact = ExactShadow::new(&layers, &self.lights.lights[0], middle, FOOTPRINT_CM);
        let left = |&(place, strand_idx): &(Vec3, u32)| -> f64 {
            (-exact.optical_depth(DVec3::from(place), Some(strand_idx), FOOTPRINT_CM)).exp()
        };
        self.exact = lit.par_iter().map(left).collect();
        self.probes = lit.into_iter().map(|probe| probe.0).collect();
        Ok(())
    }

    pub fn n_probes(&self) -> usize {
        self.probes.len()
    }

    pub fn n_strands(&self) -> u32 {
        self.strands.n_strands
    }

    /// Mean of the light that is left at the fragments.
    pub fn mean_left(&self) -> f64 {
        self.exact.iter().sum::<f64>() / self.exact.len().max(1) as f64
    }

    pub fn score(
        &self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        shadowing: Shadowing,
        params: &ShadowParams,
        n_rounds: usize,
    ) -> Result<ShadowScore, RenderError> {
        let run = self.run(gpu, library, shadowing, params, n_rounds)?;
        let errors: Vec<f64> =
            run.answers.iter().zip(&self.exact).map(|(answer, exact)| f64::from(-answer[0]).exp() - exact).collect();
        let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        let n = sizes.len().max(1) as f64;
        let lit: Vec<f64> = sizes.iter().zip(&self.exact).filter(|(_, e)| **e >= 0.9).map(|(size, _)| *size).collect();
        let mean_error = sizes.iter().sum::<f64>() / n;
        sizes.sort_by(f64::total_cmp);
        Ok(ShadowScore {
            resolution: run.resolution,
            n_bytes: run.n_bytes,
            build_ms: median(&run.build_ms),
            look_up_ms: median(&run.look_up_ms).map(|ms| ms * 1e6 / self.timed.len() as f64),
            mean_error,
            error_99: sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(0.0),
            bias: errors.iter().sum::<f64>() / n,
            lit_error: lit.iter().sum::<f64>() / lit.len().max(1) as f64,
        })
    }

    fn run(
        &self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        shadowing: Shadowing,
        params: &ShadowParams,
        n_rounds: usize,
    ) -> Result<Run, RenderError> {
        let mut shadow = Shadow::new(gpu);
        shadow.set_head(gpu, self.groom.head.as_ref().map(|head| &*head.mesh));
        let input = ShadowInput {
            shadowing,
            params,
            lights: &self.lights,
            ball: self.ball,
            world_from_head: Affine3A::IDENTITY,
            head_casts: self.groom.head.is_some(),
        };
        shadow.prepare(gpu, library, &self.strands, &input)?;
        let links = slot::shadowing(shadowing);
        let probe = library.kernel(gpu, "shadow_probe", "probe", &[], &links)?;
        let probe_hair = library.kernel(gpu, "shadow_probe", "probe_hair", &[], &links)?;
        let places: Vec<[f32; 4]> = self.probes.iter().map(|p| p.extend(0.0).to_array()).collect();
        let asked = Probe::new(gpu, &probe, &shadow, &places)?;
        let timed = Probe::new(gpu, &probe_hair, &shadow, &self.timed)?;
        let mut profile = Profile::new(gpu)?;
        let mut run = Run {
            answers: Vec::new(),
            resolution: shadow.resolution(),
            n_bytes: shadow.n_bytes(),
            build_ms: Vec::new(),
            look_up_ms: Vec::new(),
        };
        for _ in 0..n_rounds.max(1) {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            profile.pass("build", &mut encoder, |encoder| shadow.record(encoder, &input));
            profile.pass("look up", &mut encoder, |encoder| timed.record(encoder, &probe_hair));
            asked.record(&mut encoder, &probe);
            profile.resolve(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            profile.collect(gpu);
            gpu.wait()?;
            profile.collect(gpu);
            let time = |label: &str| profile.times().iter().find(|(name, _)| name == label).map(|(_, ms)| *ms);
            run.build_ms.extend(time("build"));
            run.look_up_ms.extend(time("look up"));
        }
        run.answers = gpu.read_buffer(&asked.answers)?;
        run.answers.truncate(places.len());
        Ok(run)
    }
}

struct Run {
    answers: Vec<[f32; 4]>,
    resolution: u32,
    n_bytes: u64,
    build_ms: Vec<f64>,
    look_up_ms: Vec<f64>,
}

/// Questions at places, bound.
struct Probe {
    bindings: lorelei_shaders::Bindings,
    answers: wgpu::Buffer,
    n: u32,
}

impl Probe {
    fn new(gpu: &Gpu, kernel: &Kernel, shadow: &Shadow, places: &[[f32; 4]]) -> Result<Self, RenderError> {
        let buffer = gpu.buffer_of("measure.places", places, BufferUsages::STORAGE);
        let answers = gpu.buffer("measure.answers", buffer.size(), BufferUsages::STORAGE);
        let mut resources = shadow.resources();
        resources.push(("probe_places", buffer.as_entire_binding()));
        resources.push(("probe_answers", answers.as_entire_binding()));
        Ok(Self { bindings: kernel.bind_used(gpu, &resources)?, answers, n: places.len() as u32 })
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder, kernel: &Kernel) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        kernel.dispatch_items(&mut pass, &self.bindings, self.n);
    }
}

fn median(times: &[f64]) -> Option<f64> {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

/// The strands of a groom as they are drawn at rest.
fn strands_of(gpu: &Gpu, library: &ShaderLibrary, groom: &Groom) -> Result<(Vec<Vec4>, Vec<DrawnLayer>), RenderError> {
    let mut generator = StrandGenerator::new(gpu);
    generator.set_groom(gpu, groom)?;
    let pose = StrandPose {
        world_from_head: Affine3A::IDENTITY,
        moved: &[],
        lod: 1.0,
        blend: LodBlend::default(),
        veil: Veil::Full,
    };
    let prepared = generator.prepare(gpu, library, &pose)?;
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        generator.record(&mut pass, &prepared);
    }
    gpu.queue.submit([encoder.finish()]);
    let strands = generator.strands();
    let vertices: Vec<[f32; 4]> = gpu.read_buffer(&strands.vertices)?;
    Ok((vertices.into_iter().map(Vec4::from_array).collect(), strands.layers.clone()))
}

/// Straight strands across the light's way, before all hair.
fn stray_strands(ball: Ball, to_light: Vec3) -> Vec<Vec4> {
    let (right, up) = to_light.any_orthonormal_pair();
    let middle = ball.centre + STRAY_DISTANCE * ball.radius * to_light;
    let at = |share: f32, angle: f32| {
        let (sin, cos) = angle.sin_cos();
        (middle + share * ball.radius * (cos * right + sin * up)).extend(0.004)
    };
    // Chords whose ends go around at different speeds: they cover the disc.
    let strand = |k: u32| {
        let angle = 2.399_963 * k as f32;
        [at(0.8, angle), at(0.8, angle + 1.0 + 4.3 * k as f32 / N_STRAYS as f32)]
    };
    (0..N_STRAYS).flat_map(strand).collect()
}
