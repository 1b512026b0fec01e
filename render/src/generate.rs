//! All strand vertices, every frame, on the GPU: one dispatch a layer of `generate.wgsl`.
//!
//! Guides may move every frame without leaving the GPU: the solver's buffer is bound where the mirror's
//! own would be. Keeping last frame's vertices while nothing moves was rejected: making them costs less
//! than finding out.

use std::collections::HashMap;

use glam::Affine3A;
use lorelei_core::generate::Lod;
use lorelei_core::groom::Groom;
use lorelei_core::io::Watch;
use lorelei_core::lod::{LodBlend, MOST_WIDER};
use lorelei_core::maps::MapKind;
use lorelei_core::simulation::Interpolated;
use lorelei_shaders::{Bindings, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::bound::Bound;
use crate::mirror::{DrawnLayer, LayerMirror, Mirror, MirrorError, Sort, StrandBuffers};
use crate::overlay::Veil;
use crate::raster::fit;

/// Makes the strands of a groom.
pub struct StrandGenerator {
    kernels: HashMap<Variant, Hot<Kernel>>,
    /// Control points are blended before strands are made: see generate.wgsl. A CPU gains nothing by it.
    blends_before: bool,
    /// Those control points, of one layer after the other.
    paths: wgpu::Buffer,
    /// Where strands enter the head, of one layer after the other.
    hits: wgpu::Buffer,
    mirror: Mirror,
    params: Vec<wgpu::Buffer>,
}

/// What a kernel of generate.wgsl is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    pass: Pass,
    /// How strands between moved guides are kept out of the head.
    interpolated: Interpolated,
}

/// What of the work a kernel does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Pass {
    /// Where strands enter the head.
    Hits,
    /// Strands that blend their control points themselves.
    Direct(Sort),
    /// Strands from control points that are there; all styles, or those that
    /// [`Plan::is_plain`](lorelei_core::generate::plan::Plan::is_plain) says are plain.
    FromPaths { is_full: bool },
    /// The control points; ironed or as they are.
    Paths { irons: bool },
}

impl Variant {
    fn make(self, library: &ShaderLibrary, gpu: &Gpu) -> Result<Kernel, ShaderError> {
        let (entry, is_full, of_pass): (_, _, &[&str]) = match self.pass {
            Pass::Hits => ("find_hits", true, &["FINDS_HITS"]),
            Pass::Direct(Sort::Plain) => ("generate", false, &[]),
            Pass::Direct(Sort::Full) => ("generate", true, &[]),
            Pass::Direct(Sort::Ironing) => ("generate", true, &["IRONS"]),
            Pass::FromPaths { is_full } => ("generate", is_full, &["READS_PATHS"]),
            Pass::Paths { irons: false } => ("make_paths", true, &["MAKES_PATHS"]),
            Pass::Paths { irons: true } => ("make_paths", true, &["MAKES_PATHS", "IRONS"]),
        };
        let of_choice: &[&str] = match (self.interpolated, self.pass) {
            (Interpolated::SingleGuide, Pass::Direct(_) | Pass::Paths { .. }) => &["READS_HITS"],
            (Interpolated::Free, Pass::Direct(_) | Pass::FromPaths { .. }) => &["FREE"],
            (_, _) => &[],
        };
        let defs: Vec<Link<'_>> = of_pass.iter().chain(of_choice).map(|&name| Link::Def(name)).collect();
        library.kernel(gpu, "generate", entry, &[("FULL", f64::from(u8::from(is_full)))], &defs)
    }
}

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy)]
pub struct StrandPose<'a> {
    pub world_from_head: Affine3A,
    /// Per layer: guide positions in world space, `array<vec4<f32>>`; `None` at rest.
    pub guides: &'a [Option<&'a wgpu::Buffer>],
    /// Level of detail: share of the strands that are drawn, 0-1.
    pub lod: f32,
    /// The levels that are blended; their share of the strands comes on top of `lod`.
    pub blend: LodBlend,
    /// How much of the hair is drawn where a painted map is looked at.
    pub veil: Veil,
}

/// Twin of `Params` in generate.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Params {
    world_from_head: [[f32; 4]; 3],
    head_from_world: [[f32; 4]; 3],
    world_from_guides: [[f32; 4]; 3],
    field_min: [f32; 3],
    field_cell: f32,
    field_n: [u32; 3],
    n_drawn: u32,
    n_vertices: u32,
    guide_vertices: u32,
    first_vertex: u32,
    n_ops: u32,
    n_sizes: u32,
    radius: f32,
    tip_radius: f32,
    offset_at_tip: f32,
    lod_scale: f32,
    lod_end: f32,
    lod_fade: f32,
    smooth_op: u32,
    wisp_size: u32,
    n_maps: u32,
    length_map: u32,
    width_map: u32,
    lod_maps: [u32; 4],
    lod_between: f32,
    n_sculpt: u32,
    n_paths: u32,
    pad: u32,
}

impl StrandGenerator {
    pub fn new(gpu: &Gpu) -> Self {
        Self::blending_before(gpu, gpu.adapter_info.device_type != wgpu::DeviceType::Cpu)
    }

    fn blending_before(gpu: &Gpu, blends_before: bool) -> Self {
        Self {
            kernels: HashMap::new(),
            blends_before,
            paths: gpu.buffer("generate.paths", 0, BufferUsages::STORAGE),
            hits: gpu.buffer("generate.hits", 0, BufferUsages::STORAGE),
            mirror: Mirror::new(gpu),
            params: Vec::new(),
        }
    }

    /// Take over what changed in the groom. Returns what the user should know.
    pub fn set_groom(&mut self, gpu: &Gpu, groom: &Groom) -> Result<Vec<String>, MirrorError> {
        let bound = self.mirror.bound().update(groom, Watch::default()).unwrap_or_default();
        self.mirror.set_bound(gpu, groom, bound)
    }

    /// As [`StrandGenerator::set_groom`], where the strands were bound already.
    pub fn set_bound(&mut self, gpu: &Gpu, groom: &Groom, bound: Bound) -> Result<Vec<String>, MirrorError> {
        self.mirror.set_bound(gpu, groom, bound)
    }

    pub fn mirror(&self) -> &Mirror {
        &self.mirror
    }

    /// The strands as the last recorded frame makes them.
    pub fn strands(&self) -> &StrandBuffers {
        self.mirror.strands()
    }

    /// Why the last edit of the shader is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.values().find_map(Hot::error)
    }

    /// Send this frame's numbers and bind each drawn layer; `record` then dispatches. Call once a frame.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        pose: &StrandPose<'_>,
    ) -> Result<PreparedStrands, MirrorError> {
        let reads_maps = |layer: &LayerMirror| pose.blend.maps(&layer.binding).iter().any(Option::is_some);
        let mut dispatches = Vec::new();
        self.mirror.buffers.layers.clear();
        self.mirror.buffers.widest = 0.0;
        while self.params.len() < self.mirror.layers.len() {
            let size = size_of::<Params>() as u64;
            self.params.push(gpu.buffer("generate.params", size, BufferUsages::UNIFORM));
        }
        let field = self.mirror.field().cloned();
        for (layer_idx, (layer, params_buffer)) in self.mirror.layers.iter().zip(&self.params).enumerate() {
            let Some(place) = layer.place else { continue };
            let moved = pose.guides.get(layer_idx).copied().flatten();
            let world_from_guides = if moved.is_some() { Affine3A::IDENTITY } else { pose.world_from_head };
            let lod = match pose.veil {
                Veil::Full => layer.lod(pose.lod * pose.blend.strands),
                Veil::Thin => Lod { scale: 1.0, ..layer.lod(pose.lod * pose.blend.strands * Veil::THIN) },
                Veil::Hidden => continue,
            };
            let place = DrawnLayer { vertices_per_strand: pose.blend.n_vertices(place.vertices_per_strand), ..place };
            let lod_maps = pose.blend.maps(&layer.binding);
            let params = Params {
                world_from_head: rows(&pose.world_from_head),
                head_from_world: rows(&pose.world_from_head.inverse()),
                world_from_guides: rows(&world_from_guides),
                field_min: field.as_ref().map_or([0.0; 3], |field| field.min.to_array()),
                field_cell: field.as_ref().map_or(1.0, |field| field.cell),
                field_n: field.as_ref().map_or([0; 3], |field| field.n),
                n_drawn: lod.n_drawn,
                n_vertices: place.vertices_per_strand,
                guide_vertices: layer.binding.guides.n_vertices,
                first_vertex: place.first_vertex,
                n_ops: layer.plan.n_ops,
                n_sizes: layer.binding.clumps.sizes.len() as u32,
                radius: layer.layer.radius_um * 1e-4 * pose.blend.thickness,
                tip_radius: layer.layer.tip_radius,
                offset_at_tip: layer.binding.offset_at_tip,
                lod_scale: lod.scale,
                lod_end: lod.end,
                lod_fade: lod.fade,
                smooth_op: layer.plan.smooth_op,
                wisp_size: layer.plan.wisp_size,
                n_maps: layer.binding.maps.len() as u32,
                length_map: layer.plan.length_map,
                width_map: layer.plan.width_map,
                lod_maps: lod_maps.map(|map| map.map_or(u32::MAX, |map| map as u32)),
                lod_between: pose.blend.between,
                n_sculpt: layer.composite.guides.len() as u32,
                n_paths: layer.binding.n_strands() as u32,
                pad: 0,
            };
            let wider = |maps: &[Option<usize>], most: f32| if maps.iter().any(Option::is_some) { most } else { 1.0 };
            let painted =
                wider(&lod_maps[..2], MOST_WIDER) * wider(&lod_maps[2..], MapKind::LodThickness(0).max_value());
            let widest = params.radius * lod.scale * layer.widest_scale * painted;
            self.mirror.buffers.widest = self.mirror.buffers.widest.max(widest);
            gpu.queue.write_buffer(params_buffer, 0, bytemuck::bytes_of(&params));
            // The plain kernel reads no maps.
            let sort = if reads_maps(layer) && layer.sort() == Sort::Plain { Sort::Full } else { layer.sort() };
            let n_points = u64::from(params.n_paths) * u64::from(params.guide_vertices);
            // Where few of the strands are drawn, most of what was blended would be for nothing.
            let is_worth_it = 2 * u64::from(lod.n_drawn) >= u64::from(params.n_paths);
            let from_paths = self.blends_before
                && is_worth_it
                && n_points * 16 <= gpu.max_storage_binding()
                && u32::try_from(n_points).is_ok();
            if from_paths {
                gpu.checked(|| fit(gpu, &mut self.paths, n_points * 16))?;
            }
            let interpolated = if moved.is_some() { self.mirror.interpolated } else { Interpolated::Pushed };
            // Without a head there is nothing to hit.
            let interpolated = if field.is_some() { interpolated } else { Interpolated::Pushed };
            let finds_hits = interpolated == Interpolated::SingleGuide;
            if finds_hits {
                gpu.checked(|| fit(gpu, &mut self.hits, u64::from(params.n_paths) * 16))?;
            }
            let resources = [
                ("params", params_buffer.as_entire_binding()),
                ("guides", moved.unwrap_or(&layer.guides).as_entire_binding()),
                ("strands", layer.strands.as_entire_binding()),
                ("influences", layer.influences.as_entire_binding()),
                ("middles", layer.middles.as_entire_binding()),
                ("ops", layer.ops.as_entire_binding()),
                ("curves", layer.curves.as_entire_binding()),
                ("map_values", layer.map_values.as_entire_binding()),
                ("sculpt", layer.sculpt.as_entire_binding()),
                ("field", self.mirror.field_buffer.as_entire_binding()),
                ("knots", layer.knots.as_entire_binding()),
                ("paths", self.paths.as_entire_binding()),
                ("rest_guides", layer.guides.as_entire_binding()),
                ("hits", self.hits.as_entire_binding()),
                ("vertices", self.mirror.buffers.vertices.as_entire_binding()),
            ];
            let of_hits = (Pass::Hits, params.n_paths);
            let of_paths = (Pass::Paths { irons: sort == Sort::Ironing }, n_points as u32);
            let of_strands = if from_paths {
                (Pass::FromPaths { is_full: sort != Sort::Plain }, lod.n_drawn)
            } else {
                (Pass::Direct(sort), lod.n_drawn)
            };
            let passes = finds_hits.then_some(of_hits).into_iter().chain(from_paths.then_some(of_paths));
            for (pass, n_items) in passes.chain([of_strands]) {
                let variant = Variant { pass, interpolated };
                let make = |library: &ShaderLibrary| variant.make(library, gpu);
                Hot::have(&mut self.kernels, library, &variant, make)?;
                let bindings = self.kernels[&variant].bind_used(gpu, &resources)?;
                dispatches.push(Dispatch { bindings, n_items, variant });
            }
            self.mirror.buffers.layers.push(DrawnLayer { n_strands: lod.n_drawn, ..place });
        }
        Ok(PreparedStrands { dispatches })
    }

    /// Record the dispatches of a prepared frame.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, prepared: &PreparedStrands) {
        for Dispatch { bindings, n_items, variant } in &prepared.dispatches {
            self.kernels[variant].dispatch_items(pass, bindings, *n_items);
        }
    }

    /// Bytes of the control points and of the places where strands enter the head.
    pub fn n_bytes(&self) -> u64 {
        self.paths.size() + self.hits.size()
    }
}

/// A frame's dispatches.
#[derive(Debug)]
pub struct PreparedStrands {
    dispatches: Vec<Dispatch>,
}

/// One of a layer's.
#[derive(Debug)]
struct Dispatch {
    bindings: Bindings,
    n_items: u32,
    variant: Variant,
}

/// The rows of a transform: rotation and scale, then the translation.
fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let m = transform.matrix3;
    let t = transform.translation;
    [0, 1, 2].map(|i| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Quat, Vec3};
    use lorelei_core::binding::LayerBinding;
    use lorelei_core::generate::{Pose, generate};
    use lorelei_core::groom::{Head, Layer, Source};
    use lorelei_core::hair_mesh::{HairMesh, Weld};
    use lorelei_core::lod::LodSettings;
    use lorelei_core::look::Choice;
    use lorelei_core::maps::{MapKind, ScalpMap};
    use lorelei_core::mesh::TriMesh;
    use lorelei_core::sculpt::{SculptGuide, SculptLayer, SculptRoots};
    use lorelei_core::strands::{Strands, polyline_length};
    use lorelei_core::style::{StyleKind, StyleOp};

    use super::*;

    fn ball(radius: f32) -> Head {
        let n = 32_u32;
        let mut mesh = TriMesh::default();
        for i in 0..=n {
            for j in 0..n {
                let (polar, around) =
                    (i as f32 / n as f32 * std::f32::consts::PI, j as f32 / n as f32 * std::f32::consts::TAU);
                let p = Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
                mesh.positions.push(radius * p);
                mesh.uvs.push([0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z]);
                if i < n {
                    let (a, b) = (i * n + j, i * n + (j + 1) % n);
                    mesh.triangles.extend([[a, a + n, b], [b, a + n, b + n]]);
                }
            }
        }
        Head::new("ball", mesh)
    }

    /// A cap of quads on a ball, its layers falling to the sides and partly into the ball.
    fn falling_hair() -> HairMesh {
        let n = 5_u32;
        let side = n + 1;
        let on_ball = |i: u32| Vec3::new((i % side) as f32 - 2.5, 6.0, (i / side) as f32 - 2.5).normalize() * 8.0;
        let positions = (0..side * side).map(on_ball).collect();
        let faces = (0..n * n).map(|i| i % n + side * (i / n)).map(|c| vec![c, c + side, c + side + 1, c + 1]);
        let mut mesh = HairMesh::from_polygons(positions, faces.collect()).unwrap();
        let all: Vec<usize> = (0..mesh.n_bundles()).collect();
        for k in 1..7 {
            mesh.extrude(&all, Weld::Neighbours, |v| {
                v.position + Vec3::new(0.2 * v.position.x, 0.6 - 0.5 * k as f32, 0.25 * v.position.z)
            })
            .unwrap();
        }
        mesh
    }

    fn groom() -> Groom {
        let with_seeds = |kinds: &[StyleKind]| -> Vec<StyleOp> {
            let op = |(seed, kind): (usize, &StyleKind)| StyleOp {
                strength: 0.7,
                from: 0.05,
                seed: seed as u32,
                ..StyleOp::new(*kind)
            };
            kinds.iter().enumerate().map(op).collect()
        };
        let mut style: Vec<StyleOp> = vec![
            StyleOp::new(StyleKind::Clump { strands_per_clump: 300.0, flare: 0.3, stray: 0.2 }),
            StyleOp { ramp: 0.6, ..StyleOp::new(StyleKind::Clump { strands_per_clump: 30.0, flare: 0.1, stray: 0.4 }) },
        ];
        // Without bends: they press this hair deep into the ball, where the distance field's gradient jumps from cell
        // to cell and a difference in the last bit shows.
        style.extend(with_seeds(&StyleKind::DEFAULTS[..6]));
        let hair = Layer {
            n_strands: 1500,
            vertices_per_strand: 24,
            style,
            ..Layer::new("hair", Source::HairMesh(Arc::new(falling_hair())))
        };
        // Every kind once more, with a drawn curve and every way to join the others, around two wisps.
        let mut drawn = with_seeds(&StyleKind::DEFAULTS);
        drawn.push(StyleOp::new(StyleKind::Deviate { share: 0.5, amplitude: 1.0, lift: -0.3, whole: 0.8 }));
        drawn.push(StyleOp::new(StyleKind::Wisp {
            strands_per_clump: 20.0,
            radius: 0.3,
            gather: 0.4,
            fuzz: 0.5,
            twist: -0.7,
            length_variation: 0.2,
        }));
        drawn.push(StyleOp::new(StyleKind::Length { variation: 0.3, strands_per_clump: 1.0 }));
        for (op_idx, op) in drawn.iter_mut().enumerate() {
            op.curve = lorelei_core::style::Profile::of(&[[0.0, 0.3], [0.2 + 0.05 * op_idx as f32, 0.9], [1.0, 0.5]]);
            op.blend = op.kind.blends()[op_idx % op.kind.blends().len()];
        }
        let mask = MapKind::Mask("side".to_owned());
        for op in drawn.iter_mut().step_by(2) {
            op.map = Some(mask.clone());
        }
        // A mask that nobody painted silences what asks for it.
        drawn.push(StyleOp { map: Some(MapKind::Mask("none".to_owned())), ..drawn[4].clone() });
        let painted = |kind: MapKind| {
            let map = ScalpMap::from_fn(64, 64, |x, y| (4 * x).max(2 * y) as u8).expect("sides within the limits");
            (kind, Arc::new(map))
        };
        let lod = [MapKind::LodDensity(1), MapKind::LodThickness(2)];
        let kinds = [mask, MapKind::Length, MapKind::Width, MapKind::Clump, MapKind::Curl].into_iter().chain(lod);
        let maps = kinds.map(painted).collect();
        let wisps = Layer { style: drawn, maps, n_strands: 1200, name: "wisps".to_owned(), ..hair.clone() };
        let mut guides = Strands::default();
        for i in 0..40 {
            let (sin, cos) = (i as f32 * 2.4).sin_cos();
            let out = Vec3::new(0.5 * sin * (i as f32).sqrt(), 4.0, 0.5 * cos * (i as f32).sqrt()).normalize();
            guides.push(&[0, 1, 2, 3].map(|k| out * (8.0 + k as f32) + Vec3::X * 0.2 * (k * k) as f32));
        }
        let fuzz = Layer {
            n_strands: 700,
            vertices_per_strand: 9,
            style: vec![StyleOp::new(StyleKind::Frizz { amplitude: 0.2, wavelength: 1.0, strands_per_clump: 10.0 })],
            ..Layer::new("guides", Source::Guides(Arc::new(guides)))
        };
        Groom { head: Some(ball(8.0)), layers: vec![hair, fuzz, wisps], ..Groom::default() }
    }

    /// Brushed all over, longer here and shorter there, some of it cut and deleted, its roots slid.
    fn sculpt(layer: &mut Layer, head: &Head) {
        layer.sculpt.roots = Arc::new(SculptRoots::of_layer(layer, Some(head)));
        let mut sculpt = SculptLayer::new("by hand");
        let strokes = Arc::make_mut(&mut sculpt.strokes);
        for (id, p) in layer.sculpt.roots.positions.iter().enumerate() {
            let mut guide = SculptGuide { length: 1.0 + 0.1 * p.x, ..SculptGuide::default() };
            guide.cut = if p.z > 1.0 { 0.7 } else { 1.0 };
            guide.keep = (1.0 - 0.3 * p.z).clamp(0.0, 1.0);
            for (k, offset) in guide.offsets.iter_mut().enumerate() {
                let along = k as f32 / 15.0;
                *offset = [along * p.x, 0.5 * along * (3.0 * along + p.z).sin(), along * along];
                if p.x < -0.5 {
                    offset[0] -= 0.4;
                }
            }
            strokes.ids.push(id as u32);
            strokes.guides.push(guide);
        }
        layer.sculpt.layers.push(sculpt);
    }

    fn make(gpu: &Gpu, generator: &mut StrandGenerator, pose: &StrandPose<'_>) -> Vec<[f32; 4]> {
        let library = ShaderLibrary::embedded();
        let prepared = generator.prepare(gpu, &library, pose).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        generator.record(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()), &prepared);
        gpu.queue.submit([encoder.finish()]);
        gpu.read_buffer(&generator.strands().vertices).unwrap()
    }

    #[test]
    fn gpu_strands_are_the_cpus() {
        assert_alike(&groom());
    }

    #[test]
    fn gpu_strands_are_the_cpus_when_they_are_sculpted() {
        let mut groom = groom();
        let head = ball(8.0);
        groom.layers.iter_mut().for_each(|layer| sculpt(layer, &head));
        assert_alike(&groom);
        // And nothing else happened to them.
        groom.layers.iter_mut().for_each(|layer| layer.style.clear());
        assert_alike(&groom);
    }

    #[test]
    fn a_stroke_sends_only_the_guides_that_it_touched() {
        let gpu = Gpu::headless().unwrap();
        let mut groom = groom();
        let head = ball(8.0);
        let mut generator = StrandGenerator::new(&gpu);
        generator.set_groom(&gpu, &groom).unwrap();
        assert!(generator.mirror().layers[0].composite.guides.is_empty());
        sculpt(&mut groom.layers[0], &head);
        generator.set_groom(&gpu, &groom).unwrap();
        let first = generator.mirror().layers[0].sculpt.clone();
        let strokes = Arc::make_mut(&mut groom.layers[0].sculpt.layers[0].strokes);
        strokes.guides[77].offsets[15] = [1.0, 2.0, 3.0];
        generator.set_groom(&gpu, &groom).unwrap();
        let mirror = &generator.mirror().layers[0];
        assert!(mirror.sculpt == first);
        let sent: Vec<[f32; 4]> = gpu.read_buffer(&mirror.sculpt).unwrap();
        assert_eq!(sent[77 * 16 + 15][..3], [1.0, 2.0, 3.0]);
        assert_eq!(sent[..16 * mirror.composite.guides.len()], *mirror.composite.guides.as_flattened());
        groom.layers[0].sculpt.layers[0].on = false;
        generator.set_groom(&gpu, &groom).unwrap();
        assert!(generator.mirror().layers[0].composite.guides.is_empty());
    }

    /// The GPU makes the strands that the CPU makes.
    fn assert_alike(groom: &Groom) {
        let gpu = Gpu::headless().unwrap();
        for blends_before in [false, true] {
            assert_alike_by(&gpu, StrandGenerator::blending_before(&gpu, blends_before), groom);
        }
    }

    fn assert_alike_by(gpu: &Gpu, mut generator: StrandGenerator, groom: &Groom) {
        assert_eq!(generator.set_groom(gpu, groom).unwrap(), Vec::<String>::new());
        let turned = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.4), Vec3::new(3.0, -1.0, 2.0));
        let between = LodSettings::default().blend(1.4);
        for (world_from_head, lod, blend) in [
            (Affine3A::IDENTITY, 1.0, LodBlend::default()),
            (turned, 0.37, LodBlend::default()),
            (turned, 0.0, LodBlend::default()),
            (turned, 0.9, between),
        ] {
            let vertices =
                make(gpu, &mut generator, &StrandPose { world_from_head, guides: &[], lod, blend, veil: Veil::Full });
            let mut worst: f32 = 0.0;
            for (layer_idx, layer) in groom.layers.iter().enumerate() {
                let binding = generator.mirror().binding(layer_idx).unwrap();
                let drawn = generator.strands().layers[layer_idx];
                let guides: Vec<Vec3> =
                    binding.guides.positions.iter().map(|p| world_from_head.transform_point3(*p)).collect();
                let field = generator.mirror().field().map(|field| &**field);
                let pose = Pose { world_from_head, field, lod, blend, interpolated: None };
                let strands = generate(binding, layer, &guides, &pose);
                assert_eq!(drawn.n_strands as usize, strands.n_strands());
                assert_eq!(drawn.material as usize, layer_idx);
                for s in 0..strands.n_strands() {
                    // A deleted strand has none.
                    let length = polyline_length(strands.strand(s)).max(0.1);
                    for (v, p) in strands.strand(s).iter().enumerate() {
                        let at = drawn.first_vertex as usize + s * drawn.vertices_per_strand as usize + v;
                        let [x, y, z, radius] = vertices[at];
                        worst = worst.max(p.distance(Vec3::new(x, y, z)) / length);
                        let radius_um = strands.radii_um[strands.range(s).start + v];
                        assert!((radius * 1e4 - radius_um).abs() <= 1e-3 * radius_um, "{} {radius_um}", radius * 1e4);
                    }
                }
            }
            let before = generator.blends_before;
            eprintln!("lod {lod}, blended before {before}: CPU and GPU differ by {worst} of a strand's length");
            assert!(worst < 1e-4, "{worst}");
        }
    }

    /// Guides that swing into the ball, each in its own way.
    fn swung(binding: &LayerBinding, world_from_head: &Affine3A) -> Vec<Vec3> {
        let n = binding.guides.n_vertices as usize;
        let guides = binding.guides.positions.iter().enumerate();
        guides
            .map(|(at, &p)| {
                let along = (at % n) as f32 / (n - 1) as f32;
                let swing = Vec3::new((at / n) as f32 % 3.0 - 1.0, -0.6, (at / n) as f32 % 2.0 - 0.5);
                world_from_head.transform_point3(p + 5.0 * along * along * swing)
            })
            .collect()
    }

    #[test]
    fn strands_between_moved_guides_are_alike_however_they_are_kept_out() {
        let gpu = Gpu::headless().unwrap();
        let mut groom = groom();
        groom.head = Some(ball(8.0));
        let world_from_head = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.4), Vec3::X);
        let mut kept_out = Vec::new();
        for interpolated in Interpolated::ALL {
            groom.simulation.interpolated = *interpolated;
            for blends_before in [false, true] {
                let mut generator = StrandGenerator::blending_before(&gpu, blends_before);
                generator.set_groom(&gpu, &groom).unwrap();
                let guides: Vec<Vec<Vec3>> =
                    generator.mirror().layers.iter().map(|layer| swung(&layer.binding, &world_from_head)).collect();
                let buffers: Vec<wgpu::Buffer> = guides
                    .iter()
                    .map(|guides| {
                        let vertices: Vec<[f32; 4]> = guides.iter().map(|p| p.extend(0.0).to_array()).collect();
                        gpu.buffer_of("guides", &vertices, BufferUsages::STORAGE)
                    })
                    .collect();
                let moved: Vec<_> = buffers.iter().map(Some).collect();
                let (lod, blend) = (1.0, LodBlend::default());
                let pose = StrandPose { world_from_head, guides: &moved, lod, blend, veil: Veil::Full };
                let vertices = make(&gpu, &mut generator, &pose);
                let mut worst: f32 = 0.0;
                let mut deepest: f32 = 0.0;
                for (layer_idx, layer) in groom.layers.iter().enumerate() {
                    let binding = generator.mirror().binding(layer_idx).unwrap();
                    let drawn = generator.strands().layers[layer_idx];
                    let field = generator.mirror().field().map(|field| &**field);
                    let pose = Pose { world_from_head, field, lod, blend, interpolated: Some(*interpolated) };
                    let strands = generate(binding, layer, &guides[layer_idx], &pose);
                    for s in 0..strands.n_strands() {
                        let length = polyline_length(strands.strand(s)).max(0.1);
                        for (v, p) in strands.strand(s).iter().enumerate() {
                            let at = drawn.first_vertex as usize + s * drawn.vertices_per_strand as usize + v;
                            let [x, y, z, _] = vertices[at];
                            worst = worst.max(p.distance(Vec3::new(x, y, z)) / length);
                            deepest = deepest.max(8.0 - p.distance(Vec3::X));
                        }
                    }
                }
                eprintln!("{interpolated:?}, before {blends_before}: apart {worst} of a length, {deepest} cm deep");
                // With one guide 0.005 was measured: where a strand only just touches, its first hit jumps by a rounding.
                let most = if *interpolated == Interpolated::SingleGuide { 0.02 } else { 2e-4 };
                assert!(worst < most, "{interpolated:?}: {worst}");
                kept_out.push(deepest);
            }
        }
        // The swing goes in; what is pushed out stays out.
        assert!(kept_out[4] > 1.0 && kept_out[..4].iter().all(|&deepest| deepest < 0.1), "{kept_out:?}");
    }

    #[test]
    fn only_what_changed_is_sent() {
        let gpu = Gpu::headless().unwrap();
        let mut groom = groom();
        let mut generator = StrandGenerator::new(&gpu);
        generator.set_groom(&gpu, &groom).unwrap();
        let buffers = |generator: &StrandGenerator| {
            let layer = &generator.mirror().layers[0];
            [&layer.strands, &layer.middles, &layer.ops, &generator.strands().vertices].map(Clone::clone)
        };
        let first = buffers(&generator);
        groom.layers[0].radius_um = 20.0;
        groom.layers[0].material.eumelanin = 5.0;
        generator.set_groom(&gpu, &groom).unwrap();
        assert!(buffers(&generator) == first);
        groom.layers[0].style[2].strength = 0.1;
        generator.set_groom(&gpu, &groom).unwrap();
        let restyled = buffers(&generator);
        assert!(restyled[..2] == first[..2] && restyled[2] != first[2]);
        groom.layers.swap(0, 1);
        generator.set_groom(&gpu, &groom).unwrap();
        assert!(generator.mirror().layers[1].strands == first[0]);
        groom.layers[1].n_strands += 1;
        generator.set_groom(&gpu, &groom).unwrap();
        assert!(generator.mirror().layers[1].strands != first[0]);
        groom.layers[1].visible = false;
        generator.set_groom(&gpu, &groom).unwrap();
        make(
            &gpu,
            &mut generator,
            &StrandPose {
                world_from_head: Affine3A::IDENTITY,
                guides: &[],
                lod: 1.0,
                blend: LodBlend::default(),
                veil: Veil::Full,
            },
        );
        assert_eq!(generator.strands().layers.len(), 2);
        let mut broken = falling_hair();
        broken.layers[1].faces.pop();
        groom.layers[0].source = Source::HairMesh(Arc::new(broken));
        let warnings = generator.set_groom(&gpu, &groom).unwrap();
        assert!(warnings.len() == 1 && warnings[0].contains("layer 1"), "{warnings:?}");
        generator.set_groom(&gpu, &Groom::default()).unwrap();
        assert_eq!(generator.strands().n_strands, 0);
    }

    #[test]
    fn a_groom_too_large_for_the_device_is_thinned_with_a_warning() {
        let gpu = Gpu::headless().unwrap();
        let most = gpu.max_storage_binding() / 16;
        let mut layer =
            Layer { vertices_per_strand: 128, ..Layer::new("large", Source::HairMesh(Arc::new(falling_hair()))) };
        layer.n_strands = (most / 128 + most / 1280) as u32;
        // A device with terabytes has no such limit to test.
        if layer.n_strands > 3_000_000 {
            return;
        }
        let groom = Groom { layers: vec![layer], ..Groom::default() };
        let mut generator = StrandGenerator::new(&gpu);
        let warnings = generator.set_groom(&gpu, &groom).unwrap();
        assert!(
            warnings.len() == 1 && (warnings[0].starts_with("90 %") || warnings[0].starts_with("91 %")),
            "{warnings:?}"
        );
        let lod = generator.mirror().layers[0].lod(1.0);
        let room = generator.mirror().layers[0].place.unwrap().n_strands;
        assert!(lod.n_drawn <= room && lod.n_drawn > room * 9 / 10);
        assert!(lod.scale > 1.05);
    }
}
