//! Hashed alpha is stable (Wyman and McGuire 2017): what is kept of a strand stays kept when it moves, and as much of it is
//! kept as its alpha says.

use glam::{Affine3A, Vec3};
use lorelei_core::camera::Camera;
use lorelei_core::hash::{combine, random};
use lorelei_core::look::{Shadowing, Transparency};
use lorelei_shaders::{Gpu, Kernel, Link, ShaderLibrary};
use wgpu::BufferUsages;

use crate::FrameInput;
use crate::renderer::Renderer;
use crate::sample::sample_groom;
use crate::view::View;

/// Asks the slot `keep` about fragments.
const ASK: &str = "
#import lorelei::fragment::{Fragment}
#import lorelei::keep::{keep}

struct Asked { pixel: vec2<u32>, seed: u32, along: f32, depth: f32, alpha: f32 }

@group(0) @binding(auto) var<storage, read> asked: array<Asked>;
@group(0) @binding(auto) var<storage, read_write> kept: array<u32>;

@compute @workgroup_size(64)
fn ask(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&asked) { return; }
    var fragment: Fragment;
    fragment.pixel = asked[id.x].pixel;
    fragment.seed = asked[id.x].seed;
    fragment.along = asked[id.x].along;
    fragment.depth = asked[id.x].depth;
    fragment.alpha = asked[id.x].alpha;
    fragment.mask = 1u;
    kept[id.x] = keep(fragment);
}
";

/// A threshold that belongs to the pixel.
const SCREEN: &str = "// slot: keep
#define_import_path lorelei::keep_screen
#import lorelei::fragment::{Fragment}
#import lorelei::hash::{combine, unit}

fn keep(fragment: Fragment) -> u32 {
    return select(0u, fragment.mask, fragment.alpha > unit(combine(fragment.pixel.x, fragment.pixel.y)));
}
";

/// A place on a strand as the camera sees it; twin of `Asked`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Asked {
    pixel: [u32; 2],
    seed: u32,
    along: f32,
    depth: f32,
    alpha: f32,
}

const N: u32 = 20_000;

/// Places on strands, with any alpha.
fn places() -> Vec<Asked> {
    let place = |k: u32| Asked {
        pixel: [(1920.0 * random(k, 1)) as u32, (1080.0 * random(k, 2)) as u32],
        seed: combine(k / 8, 3),
        along: 12.0 * random(k, 4),
        depth: 80.0 + 60.0 * random(k, 5),
        alpha: random(k, 6),
    };
    (0..N).map(place).collect()
}

struct Keeper {
    gpu: Gpu,
    kernel: Kernel,
    frame: wgpu::Buffer,
}

impl Keeper {
    fn new(keep: &str) -> Self {
        let gpu = Gpu::headless().unwrap();
        let library = ShaderLibrary::embedded().with_file("ask", ASK).with_file("keep_screen", SCREEN);
        let kernel = library.kernel(&gpu, "ask", "ask", &[], &[Link::Slot("keep", keep)]).unwrap();
        let view = View::new(&Camera::default(), [1920, 1080]);
        let mut frame = bytemuck::bytes_of(&view).to_vec();
        frame.resize(256, 0);
        let frame = gpu.buffer_of("test.raster", &frame, BufferUsages::UNIFORM);
        Self { gpu, kernel, frame }
    }

    fn kept(&self, asked: &[Asked]) -> Vec<bool> {
        let asked_buffer = self.gpu.buffer_of("test.asked", asked, BufferUsages::STORAGE);
        let kept = self.gpu.buffer("test.kept", 4 * u64::from(N), BufferUsages::STORAGE);
        let resources = [
            ("raster", self.frame.as_entire_binding()),
            ("asked", asked_buffer.as_entire_binding()),
            ("kept", kept.as_entire_binding()),
        ];
        let bindings = self.kernel.bind_used(&self.gpu, &resources).unwrap();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.kernel.dispatch_items(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
            &bindings,
            N,
        );
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.read_buffer::<u32>(&kept).unwrap().iter().map(|kept| *kept != 0).collect()
    }

    /// Share of the places that are kept before a motion or after it, and not both times.
    fn changed(&self, motion: fn(Asked) -> Asked) -> f64 {
        let before = places();
        let after: Vec<Asked> = before.iter().copied().map(motion).collect();
        let (before, after) = (self.kept(&before), self.kept(&after));
        before.iter().zip(&after).filter(|(before, after)| before != after).count() as f64 / f64::from(N)
    }
}

#[test]
fn what_is_kept_of_a_strand_stays_kept_when_it_moves() {
    let (hashed, on_screen) = (Keeper::new("keep_hashed"), Keeper::new("keep_screen"));
    fn aside(place: Asked) -> Asked {
        Asked { pixel: [place.pixel[0] + 1, place.pixel[1]], ..place }
    }
    fn nearer(place: Asked) -> Asked {
        Asked { depth: 0.99 * place.depth, ..aside(place) }
    }
    fn much_nearer(place: Asked) -> Asked {
        Asked { depth: 0.9 * place.depth, ..aside(place) }
    }
    // A threshold that is drawn anew changes the decision of 2 a (1 - a) of the places: a third, over all alphas.
    for (what, motion, most) in [
        ("a pixel aside", aside as fn(Asked) -> Asked, 0.0),
        ("and a hundredth nearer", nearer, 0.012),
        ("and a tenth nearer", much_nearer, 0.1),
    ] {
        let (sticks, swims) = (hashed.changed(motion), on_screen.changed(motion));
        println!("{what}: {sticks:.4} change, {swims:.4} where thresholds belong to pixels");
        assert!(sticks <= most, "{what}: {sticks}");
        assert!(swims > 0.3, "{what}: {swims}");
    }
}

#[test]
fn as_much_of_hair_is_kept_as_its_alpha_says_at_every_distance() {
    let hashed = Keeper::new("keep_hashed");
    for alpha in [0.1, 0.5, 0.9] {
        // Over an octave: cells of two sizes are mixed in every way.
        for depth in [70.0, 85.0, 100.0, 120.0, 139.0] {
            let asked: Vec<Asked> = places().into_iter().map(|place| Asked { depth, alpha, ..place }).collect();
            let share = hashed.kept(&asked).iter().filter(|kept| **kept).count() as f64 / f64::from(N);
            assert!((share - f64::from(alpha)).abs() < 0.02, "{alpha} at {depth} cm: {share}");
        }
    }
}

#[test]
fn hashed_hair_that_is_carried_about_before_the_camera_keeps_its_pattern() {
    let mut groom = sample_groom(2_000, 16);
    groom.head = None;
    groom.look.shadowing = Shadowing::Off;
    groom.look.transparency = Transparency::Hashed;
    let mut renderer = Renderer::new(&Gpu::headless().unwrap(), ShaderLibrary::embedded()).unwrap();
    renderer.set_groom(&groom).unwrap();
    let mut covered = |turn_deg: f32, step: Vec3, beside: f32| {
        let target = Vec3::new(beside, -6.0, 0.0);
        let camera = Camera { target: target + step, distance: 110.0, azimuth_deg: turn_deg, ..Camera::default() };
        let world_from_head = Affine3A::from_translation(step) * Affine3A::from_rotation_y(turn_deg.to_radians());
        let input = FrameInput {
            camera: &camera,
            size: [160, 160],
            world_from_head,
            moved: &[],
            moved_stamp: u64::from(turn_deg.to_bits()) + u64::from(step.x.to_bits()),
            lod_scale: 1.0,
        };
        renderer.render_pixels(&input).unwrap();
        renderer.read_hair().unwrap().iter().map(|pixel| pixel[3] > 0.5).collect::<Vec<bool>>()
    };
    let still = covered(0.0, Vec3::ZERO, 0.0);
    let apart = |other: &[bool]| {
        let n_covered = still.iter().filter(|covered| **covered).count() as f64;
        still.iter().zip(other).filter(|(a, b)| a != b).count() as f64 / n_covered
    };
    let moved = apart(&covered(0.0, Vec3::new(31.0, 7.0, -11.0), 0.0));
    let turned = apart(&covered(25.0, Vec3::ZERO, 0.0));
    // Another picture of the same hair: the pattern and the camera no longer agree.
    let beside = apart(&covered(0.0, Vec3::ZERO, 1.3));
    println!("carried aside: {moved:.4}, turned: {turned:.4} of the covered pixels; seen from beside: {beside:.4}");
    assert!(moved < 0.02 && turned < 0.02 && beside > 0.1, "{moved}, {turned}, {beside}");
}
