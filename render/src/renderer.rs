//! The renderer: a groom in, a picture out. The frame is recorded top-down in [`Renderer::render`].

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use lorelei_core::groom::{Groom, HairMaterial, Layer, Source};
use lorelei_core::io::Watch;
use lorelei_core::light::Light;
use lorelei_core::lod::LodBlend;
use lorelei_core::look::{HeadShading, Look, Primitive, ShadowParams, Shadowing};
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::bound::Bound;
use crate::environment::{EnvironmentPicture, EnvironmentUniform};
use crate::false_colour::{FalseColourInput, FalseColourPass, drawn_look};
use crate::fragments::{Blended, FragmentInput, Fragments, HalfAngle, Resources, Slicing, TooWide, Way, way};
use crate::frame::{FrameInput, Targets};
use crate::generate::{StrandGenerator, StrandPose};
use crate::head::{HeadInput, HeadPass, TooManyTriangles};
use crate::inspect::{InspectError, InspectInput, Inspection, Inspector};
use crate::mirror::{DrawnLayer, Mirror, MirrorError};
use crate::overlay::{Overlay, Veil};
use crate::profile::Profile;
use crate::raster::{Raster, RasterInput, Threads, TooManyTiles, TooManyVertices};
use crate::resolve::{Downsample, ResolveInput, ResolvePass};
use crate::scene::{Ball, SceneBuffers, SceneLights};
use crate::shade::{Shade, ShadeInput};
use crate::shadow::{Shadow, ShadowInput};
use crate::slot;
use crate::view::View;

/// Why a frame cannot be rendered. The document is never touched by it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Strands(#[from] MirrorError),
    #[error(transparent)]
    TooManyVertices(#[from] TooManyVertices),
    #[error(transparent)]
    TooManyTiles(#[from] TooManyTiles),
    #[error(transparent)]
    TooManyTriangles(#[from] TooManyTriangles),
    #[error(transparent)]
    TooWide(#[from] TooWide),
    #[error("a picture of {width} x {height} pixels cannot be made on this GPU; each side must be from 1 to {most}")]
    Size { width: u32, height: u32, most: u32 },
    #[error("there is no groom to render yet")]
    NoGroom,
}

/// A picture as bytes, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    pub size: [u32; 2],
    /// RGBA, encoded for an sRGB display; alpha is straight.
    pub rgba: Vec<u8>,
}

/// What a frame was made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameStatistics {
    pub n_strands: u32,
    pub n_vertices: u32,
    /// GPU memory of buffers and textures that this renderer holds, bytes.
    pub n_bytes: u64,
    /// That of them which turns strands into pixels as the look has it.
    pub n_drawing_bytes: u64,
    /// That of them which shadows are looked up in.
    pub n_shadow_bytes: u64,
}

/// What strands are made from: while it is the same they are not made again.
#[derive(Debug, Clone, PartialEq)]
struct HairKey {
    n_changes: u64,
    shaders: u64,
    buffers: u64,
    world_from_head: Affine3A,
    moved_stamp: u64,
    lod: f32,
    blend: LodBlend,
    veil: Veil,
}

/// What shadows are made from besides strands.
#[derive(Debug, Clone, PartialEq)]
struct ShadowKey {
    shadowing: Shadowing,
    params: ShadowParams,
    lights: SceneLights,
    head_casts: bool,
}

/// Renders one groom on one GPU.
pub struct Renderer {
    pub(crate) gpu: Gpu,
    library: ShaderLibrary,
    groom: Option<Groom>,
    /// Times that strands or the head changed.
    n_changes: u64,
    /// What the strands and shadows of the last frame were made from.
    made_from: Option<(HairKey, ShadowKey)>,
    ball: Ball,
    pub(crate) generator: StrandGenerator,
    scene: SceneBuffers,
    environment: EnvironmentPicture,
    /// What the last recorded frame was lit by.
    surroundings: EnvironmentUniform,
    shadow: Shadow,
    pub(crate) shade: Shade,
    head: HeadPass,
    /// The threads that suit the device where the look lets them.
    threads: Threads,
    raster: Raster,
    blended: Blended,
    half_angle: HalfAngle,
    fragments: Fragments,
    downsample: Downsample,
    resolve: ResolvePass,
    false_colours: FalseColourPass,
    inspector: Inspector,
    /// Of the last recorded frame.
    eye: Option<Vec3>,
    profile: Profile,
    view: wgpu::Buffer,
    pub(crate) targets: Targets,
}

impl Renderer {
    pub fn new(gpu: &Gpu, library: ShaderLibrary) -> Result<Self, RenderError> {
        Self::with_threads(gpu, library, Threads::for_gpu(gpu))
    }

    fn with_threads(gpu: &Gpu, library: ShaderLibrary, threads: Threads) -> Result<Self, RenderError> {
        Ok(Self {
            groom: None,
            n_changes: 0,
            made_from: None,
            ball: Ball { centre: Vec3::ZERO, radius: 1.0 },
            generator: StrandGenerator::new(gpu),
            scene: SceneBuffers::new(gpu),
            environment: EnvironmentPicture::new(gpu),
            surroundings: EnvironmentUniform::dark(),
            shadow: Shadow::new(gpu),
            shade: Shade::new(gpu),
            head: HeadPass::new(gpu, &library)?,
            raster: Raster::new(gpu, &library)?,
            threads,
            blended: Blended::new(gpu, &library)?,
            half_angle: HalfAngle::default(),
            fragments: Fragments::new(gpu, &library)?,
            downsample: Downsample::new(gpu, &library)?,
            resolve: ResolvePass::new(gpu),
            false_colours: FalseColourPass::new(gpu),
            inspector: Inspector::default(),
            eye: None,
            profile: Profile::new(gpu)?,
            view: gpu.buffer("frame.view", size_of::<View>() as u64, BufferUsages::UNIFORM),
            targets: Targets::new(gpu, [8, 8], 1)?,
            gpu: gpu.clone(),
            library,
        })
    }

    /// Take over what changed in the groom; what is the same is not sent again. Returns warnings for the user.
    pub fn set_groom(&mut self, groom: &Groom) -> Result<Vec<String>, RenderError> {
        let bound = self.mirror().bound().update(groom, Watch::default()).unwrap_or_default();
        self.set_bound(groom, bound)
    }

    /// As [`Renderer::set_groom`], where the strands were bound already: [`Bound::update`] of this very groom.
    pub fn set_bound(&mut self, groom: &Groom, bound: Bound) -> Result<Vec<String>, RenderError> {
        let head_of = |groom: &Groom| groom.head.as_ref().map(|head| Arc::as_ptr(&head.mesh));
        let is_new_head = self.groom.as_ref().is_none_or(|old| head_of(old) != head_of(groom));
        let is_new_shape = self.groom.as_ref().is_none_or(|old| {
            old.layers.len() != groom.layers.len() || old.layers.iter().zip(&groom.layers).any(|(a, b)| differ(a, b))
        });
        if let Some(head) = groom.head.as_ref().filter(|_| is_new_head) {
            HeadPass::check(&self.gpu, &head.mesh)?;
        }
        let warnings = self.generator.set_bound(&self.gpu, groom, bound)?;
        if is_new_head {
            let mesh = groom.head.as_ref().map(|head| &*head.mesh);
            self.gpu.checked(|| {
                self.head.set_mesh(&self.gpu, mesh);
                self.shadow.set_head(&self.gpu, mesh);
            })?;
        }
        if is_new_head || is_new_shape {
            self.n_changes += 1;
            self.ball = Ball::of_groom(groom);
        }
        self.groom = Some(groom.clone());
        self.gpu.take_error()?;
        Ok(warnings)
    }

    /// Draw the next frames with another look: a coarser one while something moves.
    pub fn set_look(&mut self, look: &Look) {
        if let Some(groom) = &mut self.groom {
            groom.look.clone_from(look);
        }
    }

    /// Light the next frames with other lamps: one of them alone.
    pub fn set_lights(&mut self, lights: &[Light]) {
        if let Some(groom) = &mut self.groom
            && groom.lights != lights
        {
            groom.lights = lights.to_vec();
        }
    }

    /// Show a painted map on the scalp from the next frame on, or skin.
    pub fn set_overlay(&mut self, overlay: Option<&Overlay>) {
        self.head.set_overlay(&self.gpu, overlay);
    }

    /// Make everything again in the next frame, as if it had changed: for measurements.
    pub fn forget(&mut self) {
        self.made_from = None;
    }

    /// Record a frame. Strands and shadows of the last one stay where nothing that they depend on has changed. Submit the encoder before the next call.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, input: &FrameInput<'_>) -> Result<(), RenderError> {
        self.gpu.take_error()?;
        self.profile.collect(&self.gpu);
        let groom = self.groom.take().ok_or(RenderError::NoGroom)?;
        let result = self.record(encoder, input, &groom);
        self.groom = Some(groom);
        self.profile.resolve(encoder);
        result
    }

    /// The frame, top-down.
    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        input: &FrameInput<'_>,
        groom: &Groom,
    ) -> Result<(), RenderError> {
        let Self { gpu, library, profile, .. } = self;
        let (gpu, library) = (&*gpu, &*library);
        let look = &*drawn_look(&groom.look);
        let is_head_shown = match look.head {
            HeadShading::Skin => true,
            HeadShading::Hidden => false,
        };

        // Everything is made to fit before anything is recorded.
        let most = gpu.device.limits().max_texture_dimension_2d;
        let supersampling = slot::supersampling(look.antialiasing);
        if input.size.iter().any(|&side| side == 0 || side > most / supersampling) {
            let [width, height] = input.size;
            return Err(RenderError::Size { width, height, most: most / supersampling });
        }
        if (self.targets.size, self.targets.supersampling) != (input.size, supersampling) {
            self.targets = Targets::new(gpu, input.size, supersampling)?;
        }
        let view = View::new(input.camera, input.size);
        self.eye = Some(input.camera.eye());
        gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        let lod = (look.lod * input.lod_scale).clamp(0.0, 1.0);
        let veil = self.head.overlay().map_or(Veil::Full, |overlay| overlay.veil);
        let blend = groom.lod.drawn(self.ball.share_of_picture(input.camera));
        let pose = StrandPose { world_from_head: input.world_from_head, moved: input.moved, lod, blend, veil };
        let prepared = self.generator.prepare(gpu, library, &pose)?;
        let strands = self.generator.strands();
        let lights = SceneLights::new(&groom.lights).with_probes(look);
        let surroundings = self.environment.update(gpu, look, || groom.surroundings());
        let scene_is_new = self.scene.update(gpu, &lights, &surroundings, look, input.camera.eye());
        self.surroundings = surroundings;
        let shadow_input = ShadowInput {
            shadowing: look.shadowing,
            params: &look.shadows,
            lights: &lights,
            ball: self.ball,
            world_from_head: input.world_from_head,
            head_casts: is_head_shown && groom.head.is_some(),
        };
        self.shadow.prepare(gpu, library, strands, &shadow_input)?;
        let fallback = HairMaterial::default();
        let material_of =
            |layer: u32| groom.layers.get(layer as usize).map_or(&fallback, |layer: &Layer| &layer.material);
        let shade_input = ShadeInput {
            strands,
            look,
            scene: &self.scene,
            scene_is_new,
            shadow: &self.shadow,
            waits: input.lod_scale >= 1.0,
        };
        self.shade.prepare(gpu, library, &shade_input, material_of)?;
        let fine_size = input.size.map(|side| side * supersampling);
        let fine_view = View::new(input.camera, fine_size);
        let raster_input = RasterInput {
            view: fine_view,
            ball: self.ball,
            exposure: look.exposure.exp2(),
            supersampling,
            threads: self.threads.for_look(look),
            fills_tiles: matches!(drawn_as(look), (Way::InOrder, Primitive::Compute)),
        };
        self.raster.prepare(gpu, library, strands, &raster_input)?;

        let hair_key = HairKey {
            n_changes: self.n_changes,
            shaders: library.generation(),
            buffers: strands.generation,
            world_from_head: input.world_from_head,
            moved_stamp: input.moved_stamp,
            lod,
            blend,
            veil,
        };
        let shadow_key = ShadowKey {
            shadowing: look.shadowing,
            params: look.shadows.clone(),
            lights: lights.clone(),
            head_casts: shadow_input.head_casts,
        };
        let made_from = self.made_from.take();
        let has_strands = made_from.as_ref().is_some_and(|(hair, _)| *hair == hair_key);
        let has_shadows = has_strands && made_from.is_some_and(|(_, shadow)| shadow == shadow_key);

        // Strands, and the light that reaches them.
        profile.pass("generate", encoder, |encoder| {
            if has_strands {
                return;
            }
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("generate"), timestamp_writes: None });
            self.generator.record(&mut pass, &prepared);
        });
        profile.pass("shadow.head", encoder, |encoder| {
            if !has_shadows {
                self.shadow.record_head(encoder, &shadow_input);
            }
        });
        profile.pass("shadow.hair", encoder, |encoder| {
            if !has_shadows {
                self.shadow.record_hair(encoder, &shadow_input);
            }
        });
        let false_colours = FalseColourInput {
            look,
            mirror: self.generator.mirror(),
            radiance: self.shade.radiance(),
            view: &self.view,
            targets: &self.targets,
            scene: &self.scene,
            shadow: &self.shadow,
        };
        if look.view.is_light() {
            profile.pass("shade", encoder, |encoder| self.shade.record(encoder, strands));
        } else {
            let paint = &mut self.false_colours;
            profile.pass("view", encoder, |encoder| paint.record_paint(gpu, library, encoder, &false_colours))?;
        }

        // The head, and the depth that hair is hidden by.
        let head_input = HeadInput {
            look,
            world_from_head: input.world_from_head,
            is_shown: is_head_shown,
            has_hair: strands.layers.iter().any(|layer| layer.n_strands > 0),
            view: &self.view,
            tile_backs: &self.raster.segments.tile_backs,
            supersampling,
            targets: &self.targets,
            scene: &self.scene,
            shadow: &self.shadow,
        };
        self.head.record(gpu, library, encoder, profile, &head_input)?;

        if !look.view.is_light() {
            let count = &mut self.false_colours;
            profile.pass("view.count", encoder, |encoder| count.record_count(gpu, library, encoder, &false_colours))?;
        }

        // Strands into pixels.
        let targets = &self.targets;
        let mut resources: Resources<'_> = vec![
            ("vertices", strands.vertices.as_entire_binding()),
            ("seeds", strands.seeds.as_entire_binding()),
            ("radiance", self.shade.radiance().as_entire_binding()),
            ("head_depth", wgpu::BindingResource::TextureView(&targets.head_depth)),
        ];
        let frame = self.raster.segments.clone();
        resources.extend(frame.frame_resources());
        resources.extend(self.shade.resources());
        resources.extend(self.scene.resources());
        resources.extend(self.shadow.resources());
        let fragments = FragmentInput {
            look,
            resources: &resources,
            n_items: frame.n_items,
            hair: targets.drawn_hair(),
            size: fine_size,
        };
        targets.clear_hair(encoder);
        let drawn = drawn_as(look);
        if !matches!(drawn.0, Way::Passes(_)) {
            self.fragments.release();
        }
        if drawn.0 != Way::Sliced {
            self.half_angle.release();
        }
        match drawn {
            (Way::InOrder, Primitive::Compute) => {
                profile.pass("raster.count", encoder, |encoder| self.raster.record_count(gpu, encoder, strands))?;
                self.raster.record_tiles(gpu, library, encoder, &fragments, profile)?;
            }
            (Way::InOrder, Primitive::Ribbons | Primitive::Polylines) | (Way::Blended, _) => {
                profile.pass("blended", encoder, |encoder| self.blended.record(gpu, library, encoder, &fragments))?;
            }
            (Way::Sliced, _) => profile.pass("sliced", encoder, |encoder| {
                let slicing = Slicing {
                    lights: &lights,
                    ball: self.ball,
                    world_from_head: input.world_from_head,
                    to_eye: (input.camera.eye() - input.camera.target).normalize_or(Vec3::Z),
                    n_segments: strands.layers.iter().map(DrawnLayer::n_segments).sum(),
                };
                self.half_angle.record(gpu, library, encoder, &fragments, &slicing)
            })?,
            (Way::Passes(technique), _) => profile.pass("fragments", encoder, |encoder| {
                self.fragments.record(gpu, library, encoder, &technique, &fragments)
            })?,
        }
        profile.pass("downsample", encoder, |encoder| {
            let [frame, _] = frame.frame_resources();
            self.downsample.record(gpu, library, encoder, frame, targets)
        })?;

        // The picture.
        profile.pass("resolve", encoder, |encoder| {
            let input = ResolveInput {
                look,
                view: &self.view,
                targets: &self.targets,
                false_colours: &self.false_colours,
                environment: &self.environment,
            };
            self.resolve.record(gpu, library, encoder, &input)
        })?;
        self.made_from = Some((hair_key, shadow_key));
        Ok(())
    }

    /// `Rgba8Unorm` with values encoded for an sRGB display, premultiplied after encoding; another texture whenever the
    /// size changes.
    pub fn output(&self) -> &wgpu::Texture {
        &self.targets.output
    }

    /// Render, submit, wait and read back: for pictures without a window.
    pub fn render_pixels(&mut self, input: &FrameInput<'_>) -> Result<Pixels, RenderError> {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.render(&mut encoder, input)?;
        self.gpu.queue.submit([encoder.finish()]);
        self.profile.collect(&self.gpu);
        let pixels = self.read_pixels()?;
        self.profile.collect(&self.gpu);
        Ok(pixels)
    }

    /// The picture of the last submitted frame.
    pub fn read_pixels(&self) -> Result<Pixels, RenderError> {
        self.read_pixels_of(&self.targets.output)
    }

    /// As [`Renderer::read_pixels`], of another picture like [`Renderer::output`] on the same GPU.
    pub fn read_pixels_of(&self, picture: &wgpu::Texture) -> Result<Pixels, RenderError> {
        let bytes = self.read_texture(picture, 4)?;
        let mut rgba = bytes;
        for pixel in rgba.chunks_exact_mut(4) {
            let alpha = f32::from(pixel[3]);
            if pixel[3] != 0 && pixel[3] != 255 {
                for channel in &mut pixel[..3] {
                    *channel = (f32::from(*channel) * 255.0 / alpha).round().min(255.0) as u8;
                }
            }
        }
        Ok(Pixels { size: [picture.width(), picture.height()], rgba })
    }

    pub(crate) fn read_texture(&self, texture: &wgpu::Texture, bytes_per_pixel: u32) -> Result<Vec<u8>, GpuError> {
        let (width, height) = (texture.width(), texture.height());
        let row = width * bytes_per_pixel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = self.gpu.checked(|| {
            let staging = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame.read"),
                size: u64::from(padded) * u64::from(height),
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &staging,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(padded),
                        rows_per_image: None,
                    },
                },
                texture.size(),
            );
            self.gpu.queue.submit([encoder.finish()]);
            staging
        })?;
        self.gpu.read_mapped(&staging, |bytes| {
            bytes.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect()
        })
    }

    /// What is under a pixel of the last submitted frame. Waits for the GPU.
    pub fn inspect(&mut self, pixel: [u32; 2]) -> Result<Option<Inspection>, InspectError> {
        let (Some(groom), Some(eye)) = (&self.groom, self.eye) else { return Ok(None) };
        if pixel[0] >= self.targets.size[0] || pixel[1] >= self.targets.size[1] {
            return Ok(None);
        }
        let input = InspectInput {
            pixel,
            look: &groom.look,
            lights: &SceneLights::new(&groom.lights).with_probes(&groom.look),
            surroundings: &self.surroundings,
            eye,
            strands: self.generator.strands(),
            shade: &self.shade,
            shadow: &self.shadow,
            view: &self.view,
            targets: &self.targets,
        };
        let mut inspection = self.inspector.inspect(&self.gpu, &self.library, &input)?;
        if let Some(strand) = &mut inspection.strand
            && let Some(binding) = self.generator.mirror().binding(strand.layer_idx as usize)
        {
            strand.id = binding.ids.get(strand.strand_idx as usize).copied().unwrap_or(strand.strand_idx);
        }
        Ok(Some(inspection))
    }

    /// Take in the GPU times that have come back. [`Renderer::render`] does it too; call it after a submission and again
    /// after waiting for it, where the times of that very frame are wanted.
    pub fn collect_times(&mut self) {
        self.profile.collect(&self.gpu);
    }

    /// GPU milliseconds of each pass, of the latest frame whose times have come back. Empty where the GPU has no
    /// timestamps.
    pub fn pass_times(&self) -> Vec<(String, f64)> {
        self.profile.times().to_vec()
    }

    /// What the last recorded frame was made of.
    pub fn statistics(&self) -> FrameStatistics {
        let strands = self.generator.strands();
        let [width, height] = self.targets.size.map(u64::from);
        // Normals, colour and depth of the head, hair (8 each) and the picture (4).
        let targets = width * height * 36;
        let n_fine = u64::from(self.targets.supersampling).pow(2);
        let n_drawing_bytes = if n_fine > 1 { width * height * 8 * n_fine } else { 0 }
            + match self.groom.as_ref().map(|groom| drawn_as(&groom.look)) {
                Some((Way::InOrder, Primitive::Compute)) | None => self.raster.n_bytes(),
                Some((Way::InOrder | Way::Blended, _)) => self.blended.n_bytes(),
                Some((Way::Sliced, _)) => self.half_angle.n_bytes(),
                Some((Way::Passes(_), _)) => self.fragments.n_bytes(),
            };
        FrameStatistics {
            n_drawing_bytes,
            n_shadow_bytes: self.shadow.n_bytes(),
            n_strands: strands.layers.iter().map(|layer| layer.n_strands).sum(),
            n_vertices: strands.layers.iter().map(|layer| layer.n_strands * layer.vertices_per_strand).sum(),
            n_bytes: targets
                + self.generator.mirror().n_bytes()
                + self.generator.n_bytes()
                + self.shade.radiance().size()
                + self.head.n_bytes()
                + self.shadow.n_bytes()
                + self.raster.n_bytes()
                + self.blended.n_bytes()
                + self.half_angle.n_bytes()
                + self.fragments.n_bytes()
                + self.false_colours.n_bytes(),
        }
    }

    /// The groom on the GPU: guides, distance field, strands.
    pub fn mirror(&self) -> &Mirror {
        self.generator.mirror()
    }

    /// Entries of the last submitted frame's tile lists and how many there is room for. Where the first is larger, the
    /// picture lacks what did not fit. Waits for the GPU.
    pub fn n_tile_entries(&self) -> Result<(u64, u64), GpuError> {
        match self.groom.as_ref().map(|groom| drawn_as(&groom.look)) {
            Some((Way::InOrder, Primitive::Compute)) => self.raster.n_entries(&self.gpu),
            _ => Ok((0, 0)),
        }
    }

    /// The shader sources; poll them once a frame while developing.
    pub fn library(&self) -> &ShaderLibrary {
        &self.library
    }

    /// Why the last edit of a shader file is not in use.
    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.generator
            .shader_error()
            .or(self.shadow.shader_error())
            .or(self.shade.shader_error())
            .or(self.head.shader_error())
            .or(self.raster.shader_error())
            .or(self.blended.shader_error())
            .or(self.half_angle.shader_error())
            .or(self.fragments.shader_error())
            .or(self.downsample.shader_error())
            .or(self.resolve.shader_error())
            .or(self.false_colours.shader_error())
    }
}

/// How a look turns strands into pixels.
fn drawn_as(look: &Look) -> (Way, Primitive) {
    (way(look.transparency, look.antialiasing, &look.drawing), look.primitive)
}

/// Whether two layers are drawn differently.
fn differ(a: &Layer, b: &Layer) -> bool {
    let without_source = |layer: &Layer| Layer { source: Source::Strands(Arc::default()), ..layer.clone() };
    !a.source.is_same(&b.source) || without_source(a) != without_source(b)
}

#[cfg(test)]
#[path = "limits_tests.rs"]
mod limits;
#[cfg(test)]
#[path = "renderer_tests.rs"]
mod tests;
