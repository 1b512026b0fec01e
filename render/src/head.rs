//! The head: normals and depth through the graphics pipeline, four samples a pixel so that its outline is smooth; then
//! skin and the depth that hair is compared with, once a pixel, in compute.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, Mat4, Vec3};
use lorelei_core::look::{Look, Shadowing};
use lorelei_core::maps::uvs::scalp_uvs;
use lorelei_core::mesh::{SCALP_GROUP, TriMesh};
use lorelei_shaders::{Draw, DrawDescriptor, Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::frame::{COLOUR, DEPTH, N_SAMPLES, Targets};
use crate::overlay::{Overlay, OverlayTexture};
use crate::scene::SceneBuffers;
use crate::shadow::Shadow;
use crate::slot;

/// Twin of `HeadLook` in head.wgsl.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct HeadLook {
    world_from_head: [[f32; 4]; 4],
    albedo: [f32; 3],
    gloss: f32,
    softness: f32,
    roots: f32,
    overlay: f32,
    supersampling: u32,
}

struct Mesh {
    positions: wgpu::Buffer,
    normals: wgpu::Buffer,
    indices: wgpu::Buffer,
    scalp: wgpu::Buffer,
    map_places: wgpu::Buffer,
    n_indices: u32,
}

/// The head pass.
pub(crate) struct HeadPass {
    draw: Hot<Draw>,
    shade: HashMap<Shadowing, Hot<Kernel>>,
    look: wgpu::Buffer,
    mesh: Option<Mesh>,
    overlay: OverlayTexture,
}

/// What the pass needs of the frame.
pub(crate) struct HeadInput<'a> {
    pub look: &'a Look,
    pub world_from_head: Affine3A,
    pub is_shown: bool,
    /// Hair is drawn: its roots darken the scalp.
    pub has_hair: bool,
    pub view: &'a wgpu::Buffer,
    pub tile_backs: &'a wgpu::Buffer,
    /// Pixels of the rasteriser for one of the head, along a side.
    pub supersampling: u32,
    pub targets: &'a Targets,
    pub scene: &'a SceneBuffers,
    pub shadow: &'a Shadow,
}

impl HeadPass {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            draw: Hot::new(library, |library| make_draw(gpu, library))?,
            shade: HashMap::new(),
            look: gpu.buffer("head.look", size_of::<HeadLook>() as u64, BufferUsages::UNIFORM),
            mesh: None,
            overlay: OverlayTexture::new(gpu),
        })
    }

    /// Show a painted map on the scalp, or skin.
    pub fn set_overlay(&mut self, gpu: &Gpu, overlay: Option<&Overlay>) -> usize {
        self.overlay.set(gpu, overlay)
    }

    pub fn overlay(&self) -> Option<&Overlay> {
        self.overlay.shown()
    }

    pub fn set_mesh(&mut self, gpu: &Gpu, mesh: Option<&TriMesh>) {
        self.mesh = mesh.filter(|mesh| !mesh.triangles.is_empty()).map(|mesh| {
            let normals = mesh.vertex_normals();
            Mesh {
                positions: gpu.buffer_of("head.positions", &mesh.positions, BufferUsages::STORAGE),
                normals: gpu.buffer_of("head.normals", &normals, BufferUsages::STORAGE),
                indices: gpu.buffer_of("head.indices", &mesh.triangles, BufferUsages::STORAGE),
                scalp: gpu.buffer_of("head.scalp", &scalp_of(mesh), BufferUsages::STORAGE),
                map_places: gpu.buffer_of("head.map_places", &map_places_of(mesh), BufferUsages::STORAGE),
                n_indices: 3 * mesh.triangles.len() as u32,
            }
        });
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.shade.values().find_map(Hot::error).or(self.draw.error())
    }

    /// Draw head colour and depth into the targets; both are cleared where there is no head.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &HeadInput<'_>,
    ) -> Result<(), ShaderError> {
        let shadowing = input.look.shadowing;
        let make_shade =
            |library: &ShaderLibrary| library.kernel(gpu, "head_shade", "shade_head", &[], &slot::shadowing(shadowing));
        if let Some(kernel) = self.shade.get_mut(&shadowing) {
            kernel.refresh(library, make_shade);
        } else {
            self.shade.insert(shadowing, Hot::new(library, make_shade)?);
        }
        self.draw.refresh(library, |library| make_draw(gpu, library));
        let uniform = HeadLook {
            world_from_head: Mat4::from(input.world_from_head).to_cols_array_2d(),
            albedo: input.look.skin_colour,
            gloss: input.look.skin_gloss,
            softness: input.look.skin_softness,
            roots: if input.has_hair { input.look.root_shadow } else { 0.0 },
            overlay: self.overlay.shown().map_or(0.0, |overlay| 255.0 / f32::from(overlay.full_texel.max(1))),
            supersampling: input.supersampling,
        };
        gpu.queue.write_buffer(&self.look, 0, bytemuck::bytes_of(&uniform));

        let targets = input.targets;
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("head"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &targets.head_samples,
                    depth_slice: None,
                    resolve_target: Some(&targets.head_normal),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &targets.head_depth_samples,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            if let (true, Some(mesh)) = (input.is_shown, &self.mesh) {
                let bindings = self.draw.bind(
                    gpu,
                    &[
                        ("view", input.view.as_entire_binding()),
                        ("head_look", self.look.as_entire_binding()),
                        ("head_positions", mesh.positions.as_entire_binding()),
                        ("head_normals", mesh.normals.as_entire_binding()),
                        ("head_indices", mesh.indices.as_entire_binding()),
                        ("head_scalp", mesh.scalp.as_entire_binding()),
                        ("head_map_places", mesh.map_places.as_entire_binding()),
                        ("head_overlay", wgpu::BindingResource::TextureView(&self.overlay.view)),
                    ],
                )?;
                self.draw.draw(&mut pass, &bindings, mesh.n_indices);
            }
        }
        encoder.clear_buffer(input.tile_backs, 0, None);
        let kernel = &self.shade[&shadowing];
        let mut resources = vec![
            ("view", input.view.as_entire_binding()),
            ("head_look", self.look.as_entire_binding()),
            ("head_samples", wgpu::BindingResource::TextureView(&targets.head_depth_samples)),
            ("head_normal", wgpu::BindingResource::TextureView(&targets.head_normal)),
            ("head_depth", wgpu::BindingResource::TextureView(&targets.head_depth)),
            ("head_colour", wgpu::BindingResource::TextureView(&targets.head_colour)),
            ("tile_backs", input.tile_backs.as_entire_binding()),
        ];
        resources.extend(input.scene.resources());
        resources.extend(input.shadow.resources());
        let bindings = kernel.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("head.shade"), timestamp_writes: None });
        let [width, height] = targets.size;
        kernel.dispatch(&mut pass, &bindings, [width.div_ceil(8), height.div_ceil(8), 1]);
        Ok(())
    }
}

/// Centimetres from the hairline over which skin becomes scalp.
const HAIRLINE: (f32, f32) = (0.2, 1.4);

/// Each vertex' place in a painted map and whether it is on the part that maps are of.
fn map_places_of(mesh: &TriMesh) -> Vec<[f32; 3]> {
    let mut places: Vec<[f32; 3]> = scalp_uvs(mesh).iter().map(|&[u, v]| [u, v, 0.0]).collect();
    for v in mesh.scalp_triangles().into_iter().flat_map(|t| mesh.triangles[t as usize]) {
        places[v as usize][2] = 1.0;
    }
    places
}

/// How much each vertex is scalp, 0-1: 0 everywhere where the mesh names no scalp.
fn scalp_of(mesh: &TriMesh) -> Vec<f32> {
    let mut scalp = vec![0.0; mesh.positions.len()];
    let Some(group) = mesh.group(SCALP_GROUP) else { return scalp };
    let mut in_group = vec![false; mesh.triangles.len()];
    group.triangles.iter().for_each(|&t| in_group[t as usize] = true);
    // Charts do not share vertices: scalp and skin meet at places, not at indices.
    let place = |v: u32| mesh.positions[v as usize].to_array().map(f32::to_bits);
    let skin: HashSet<[u32; 3]> = mesh
        .triangles
        .iter()
        .zip(&in_group)
        .filter(|(_, is_scalp)| !**is_scalp)
        .flat_map(|(t, _)| t.map(place))
        .collect();
    let inner: HashSet<u32> = group.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    let hairline: Vec<Vec3> =
        inner.iter().filter(|&&v| skin.contains(&place(v))).map(|&v| mesh.positions[v as usize]).collect();
    for &v in &inner {
        let p = mesh.positions[v as usize];
        let nearest = hairline.iter().map(|q| q.distance_squared(p)).fold(f32::INFINITY, f32::min).sqrt();
        let x = ((nearest - HAIRLINE.0) / (HAIRLINE.1 - HAIRLINE.0)).clamp(0.0, 1.0);
        scalp[v as usize] = x * x * (3.0 - 2.0 * x);
    }
    scalp
}

fn make_draw(gpu: &Gpu, library: &ShaderLibrary) -> Result<Draw, ShaderError> {
    library.draw(
        gpu,
        "head",
        &DrawDescriptor {
            vertex: "vertex",
            fragment: Some("fragment"),
            targets: &[Some(COLOUR.into())],
            depth: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: N_SAMPLES, ..wgpu::MultisampleState::default() },
            ..DrawDescriptor::default()
        },
    )
}
