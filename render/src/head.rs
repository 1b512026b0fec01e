//! The head, by compute: its triangles into lists of tiles, four samples a pixel of what is nearest, so that its outline is
//! smooth; then skin, once a pixel.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, Mat4, Vec3};
use lorelei_core::look::{Environment, Look, Shadowing};
use lorelei_core::maps::uvs::scalp_uvs;
use lorelei_core::mesh::{SCALP_GROUP, TriMesh};
use lorelei_shaders::{Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::frame::Targets;
use crate::overlay::{Overlay, OverlayTexture};
use crate::profile::Profile;
use crate::raster::{TILE, fit};
use crate::scene::SceneBuffers;
use crate::shadow::Shadow;
use crate::slot;

/// Twin of `HeadLook` in head_frame.wgsl.
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
    n_triangles: u32,
    n_entries: u32,
    pad: [u32; 2],
}

/// Twin of what head_surface.wgsl says of `head_vertices`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct HeadVertex {
    position: [f32; 3],
    scalp: f32,
    normal: [f32; 3],
    is_painted: f32,
    map_place: [f32; 2],
    pad: [f32; 2],
}

/// Bytes of a `Triangle` of triangle.wgsl.
const TRIANGLE_SIZE: u64 = 48;

struct Mesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    triangles: wgpu::Buffer,
    n_triangles: u32,
}

/// The passes before light.
struct Surface {
    bin: Kernel,
    surface: Kernel,
}

impl Surface {
    fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            bin: library.kernel(gpu, "head_bin", "bin", &[], &[])?,
            surface: library.kernel(gpu, "head_surface", "surface", &[], &[])?,
        })
    }
}

/// The head pass.
pub(crate) struct HeadPass {
    surface: Hot<Surface>,
    shade: HashMap<(Shadowing, Environment), Hot<Kernel>>,
    look: wgpu::Buffer,
    mesh: Option<Mesh>,
    lists: wgpu::Buffer,
    entries: wgpu::Buffer,
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

/// A head that cannot be drawn on this GPU.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("a head of {n_triangles} triangles is too much for this GPU, which draws {most}; take a coarser mesh")]
pub struct TooManyTriangles {
    pub n_triangles: usize,
    pub most: u64,
}

impl HeadPass {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            surface: Hot::new(library, |library| Surface::new(gpu, library))?,
            shade: HashMap::new(),
            look: gpu.buffer("head.look", size_of::<HeadLook>() as u64, BufferUsages::UNIFORM),
            mesh: None,
            lists: gpu.buffer("head.lists", 0, BufferUsages::STORAGE),
            entries: gpu.buffer("head.entries", 0, BufferUsages::STORAGE),
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

    /// Whether a mesh can be drawn; [`HeadPass::set_mesh`] takes no other.
    pub fn check(gpu: &Gpu, mesh: &TriMesh) -> Result<(), TooManyTriangles> {
        let most = gpu.max_storage_binding() / TRIANGLE_SIZE;
        let n_triangles = mesh.triangles.len().max(mesh.positions.len());
        if n_triangles as u64 > most { Err(TooManyTriangles { n_triangles, most }) } else { Ok(()) }
    }

    pub fn set_mesh(&mut self, gpu: &Gpu, mesh: Option<&TriMesh>) {
        self.mesh = mesh.filter(|mesh| !mesh.triangles.is_empty()).map(|mesh| {
            let n_triangles = mesh.triangles.len() as u32;
            Mesh {
                vertices: gpu.buffer_of("head.vertices", &vertices_of(mesh), BufferUsages::STORAGE),
                indices: gpu.buffer_of("head.indices", &mesh.triangles, BufferUsages::STORAGE),
                triangles: gpu.buffer("head.triangles", u64::from(n_triangles) * TRIANGLE_SIZE, BufferUsages::STORAGE),
                n_triangles,
            }
        });
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.shade.values().find_map(Hot::error).or(self.surface.error())
    }

    /// Bytes of all buffers.
    pub fn n_bytes(&self) -> u64 {
        let mesh = self.mesh.iter().flat_map(|mesh| [&mesh.vertices, &mesh.indices, &mesh.triangles]);
        mesh.chain([&self.lists, &self.entries]).map(wgpu::Buffer::size).sum()
    }

    /// Draw head colour and depth into the targets; both are empty where there is no head.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        profile: &mut Profile,
        input: &HeadInput<'_>,
    ) -> Result<(), ShaderError> {
        self.prepare(gpu, input);
        profile.pass("head.surface", encoder, |encoder| self.record_surface(gpu, library, encoder, input))?;
        profile.pass("head.shade", encoder, |encoder| self.record_shade(gpu, library, encoder, input))
    }

    /// Make the lists fit the picture and send the frame's numbers.
    fn prepare(&mut self, gpu: &Gpu, input: &HeadInput<'_>) {
        let n_tiles: u64 = input.targets.size.iter().map(|side| u64::from(side.div_ceil(TILE))).product();
        let n_triangles = if input.is_shown { self.mesh.as_ref().map_or(0, |mesh| mesh.n_triangles) } else { 0 };
        // A closed head has two to four sheets over a pixel, and small triangles touch a tile or two. A tile whose list
        // finds no room is drawn from all triangles.
        let n_entries = (16 * n_tiles + 4 * u64::from(n_triangles)).min(gpu.max_storage_binding() / 8);
        fit(gpu, &mut self.lists, 4 * (1 + 2 * n_tiles));
        fit(gpu, &mut self.entries, 8 * n_entries);
        let uniform = HeadLook {
            world_from_head: Mat4::from(input.world_from_head).to_cols_array_2d(),
            albedo: input.look.skin_colour,
            gloss: input.look.skin_gloss,
            softness: input.look.skin_softness,
            roots: if input.has_hair { input.look.root_shadow } else { 0.0 },
            overlay: self.overlay.shown().map_or(0.0, |overlay| 255.0 / f32::from(overlay.full_texel.max(1))),
            supersampling: input.supersampling,
            n_triangles,
            n_entries: n_entries as u32,
            pad: [0; 2],
        };
        gpu.queue.write_buffer(&self.look, 0, bytemuck::bytes_of(&uniform));
    }

    /// Normals and depth, and what hair is hidden by.
    fn record_surface(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &HeadInput<'_>,
    ) -> Result<(), ShaderError> {
        self.surface.refresh(library, |library| Surface::new(gpu, library));
        encoder.clear_buffer(input.tile_backs, 0, None);
        encoder.clear_buffer(&self.lists, 0, None);
        let targets = input.targets;
        let mut resources = vec![
            ("view", input.view.as_entire_binding()),
            ("head_look", self.look.as_entire_binding()),
            ("head_lists", self.lists.as_entire_binding()),
            ("head_entries", self.entries.as_entire_binding()),
            ("head_overlay", wgpu::BindingResource::TextureView(&self.overlay.view)),
            ("head_normal", wgpu::BindingResource::TextureView(&targets.head_normal)),
            ("head_depth", wgpu::BindingResource::TextureView(&targets.head_depth)),
            ("tile_backs", input.tile_backs.as_entire_binding()),
        ];
        // Something is bound where there is no mesh.
        let of_mesh =
            self.mesh.as_ref().map_or([&self.lists; 3], |mesh| [&mesh.vertices, &mesh.indices, &mesh.triangles]);
        for (name, buffer) in ["head_vertices", "head_indices", "head_triangles"].into_iter().zip(of_mesh) {
            resources.push((name, buffer.as_entire_binding()));
        }
        let Surface { bin, surface } = &*self.surface;
        let filled = match &self.mesh {
            Some(mesh) if input.is_shown => Some((bin.bind_used(gpu, &resources)?, mesh.n_triangles)),
            Some(_) | None => None,
        };
        let drawn = surface.bind_used(gpu, &resources)?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("head"), timestamp_writes: None });
        if let Some((bindings, n_triangles)) = &filled {
            bin.dispatch_items(&mut pass, bindings, *n_triangles);
        }
        surface.dispatch(&mut pass, &drawn, groups_of(targets));
        Ok(())
    }

    /// Light on what was drawn.
    fn record_shade(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &HeadInput<'_>,
    ) -> Result<(), ShaderError> {
        let targets = input.targets;
        let choices = (input.look.shadowing, input.look.environment);
        let make_shade = |library: &ShaderLibrary| {
            let mut links = slot::shadowing(choices.0);
            links.push(slot::ambient(choices.1));
            library.kernel(gpu, "head_shade", "shade_head", &[], &links)
        };
        Hot::have(&mut self.shade, library, &choices, make_shade)?;
        let kernel = &self.shade[&choices];
        let mut resources = vec![
            ("view", input.view.as_entire_binding()),
            ("head_look", self.look.as_entire_binding()),
            ("head_normal", wgpu::BindingResource::TextureView(&targets.head_normal)),
            ("head_depth", wgpu::BindingResource::TextureView(&targets.head_depth)),
            ("head_colour", wgpu::BindingResource::TextureView(&targets.head_colour)),
        ];
        resources.extend(input.scene.resources());
        resources.extend(input.shadow.resources());
        let bindings = kernel.bind_used(gpu, &resources)?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("head.shade"), timestamp_writes: None });
        kernel.dispatch(&mut pass, &bindings, groups_of(targets));
        Ok(())
    }
}

/// A group of threads for each tile of the picture.
fn groups_of(targets: &Targets) -> [u32; 3] {
    let [width, height] = targets.size;
    [width.div_ceil(TILE), height.div_ceil(TILE), 1]
}

fn vertices_of(mesh: &TriMesh) -> Vec<HeadVertex> {
    let (normals, scalp, places) = (mesh.vertex_normals(), scalp_of(mesh), map_places_of(mesh));
    (mesh.positions.iter().zip(normals.iter()).zip(scalp).zip(places))
        .map(|(((position, normal), scalp), [u, v, is_painted])| HeadVertex {
            position: position.to_array(),
            scalp,
            normal: normal.to_array(),
            is_painted,
            map_place: [u, v],
            pad: [0.0; 2],
        })
        .collect()
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

#[cfg(test)]
#[path = "head_tests.rs"]
mod tests;
