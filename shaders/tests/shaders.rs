//! Every shader links in every combination, kernels bind by name and run, and faults say where they are.

// Of the tests across crates, which know this crate and which it cannot know.
#[path = "../../tests/src/covering.rs"]
mod covering;

use covering::covering;
use lorelei_shaders::{Draw, DrawDescriptor, Gpu, Hot, Kernel, Link, ShaderError, ShaderLibrary, grid_1d};

/// Scales numbers by an override and by whatever stands in for the slot `factor`.
const SCALE: &str = "
#import lorelei::factor::{factor}
#import lorelei::offset::{offset_of, extra}

override SCALE: f32 = 1.0;

struct Params { n: u32, bias: f32 }

@group(0) @binding(auto) var<uniform> params: Params;
@group(0) @binding(auto) var<storage, read> numbers: array<f32>;
@group(0) @binding(auto) var<storage, read_write> results: array<f32>;
@group(0) @binding(auto) var<storage, read_write> unused_here: array<f32>;

@compute @workgroup_size(#{WIDTH})
fn scale(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.x + id.y * groups.x * #{WIDTH}u;
    if i >= params.n { return; }
    results[i] = numbers[i] * SCALE * factor() + params.bias + offset_of(i);
}

@compute @workgroup_size(1)
fn other() { unused_here[0] = 1.0; }
";
const OFFSET: &str = "
#define_import_path lorelei::offset
@group(0) @binding(auto) var<storage, read> offsets: array<f32>;
const extra: f32 = 0.5;
fn offset_of(i: u32) -> f32 { return offsets[i]; }
";
const TWO: &str = "// slot: factor\n#define_import_path lorelei::factor_two\nfn factor() -> f32 { return 2.0; }\n";
const TEN: &str = "// slot: factor\n#define_import_path lorelei::factor_ten\nfn factor() -> f32 { return 10.0; }\n";

const WIDTH: Link<'_> = Link::DefU32("WIDTH", 64);

fn samples() -> ShaderLibrary {
    ShaderLibrary::from_sources(&[("scale", SCALE), ("offset", OFFSET), ("factor_two", TWO), ("factor_ten", TEN)])
}

fn run_scale(gpu: &Gpu, kernel: &Kernel) -> Vec<f32> {
    let storage = wgpu::BufferUsages::STORAGE;
    let n = 100_u32;
    let numbers: Vec<f32> = (0..n).map(|i| i as f32).collect();
    let offsets: Vec<f32> = (0..n).map(|i| i as f32 * 1000.0).collect();
    let params = gpu.buffer_of("params", &[n, 7.0_f32.to_bits()], wgpu::BufferUsages::UNIFORM);
    let numbers = gpu.buffer_of("numbers", &numbers, storage);
    let offsets = gpu.buffer_of("offsets", &offsets, storage);
    let results = gpu.buffer("results", 400, storage);
    let bindings = kernel
        .bind(
            gpu,
            &[
                ("results", results.as_entire_binding()),
                ("numbers", numbers.as_entire_binding()),
                ("params", params.as_entire_binding()),
                ("offsets", offsets.as_entire_binding()),
            ],
        )
        .unwrap();
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        kernel.dispatch_items(&mut pass, &bindings, n);
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.read_buffer(&results).unwrap()
}

#[test]
fn a_kernel_runs_with_slot_and_override_and_is_bound_by_name() {
    let gpu = Gpu::headless().unwrap();
    for (stem, factor) in [("factor_two", 2.0), ("factor_ten", 10.0)] {
        for (scale, width) in [(3.0, 32), (0.5, 64)] {
            let links = [Link::Slot("factor", stem), Link::DefU32("WIDTH", width)];
            let kernel = samples().kernel(&gpu, "scale", "scale", &[("SCALE", scale)], &links).unwrap();
            assert_eq!(kernel.workgroup_size(), [width, 1, 1]);
            let results = run_scale(&gpu, &kernel);
            for (i, &result) in results.iter().take(100).enumerate() {
                let x = i as f32;
                assert_eq!(result, x * scale as f32 * factor + 7.0 + x * 1000.0);
            }
        }
    }
}

#[test]
fn binding_says_which_name_is_missing_or_unknown() {
    let gpu = Gpu::headless().unwrap();
    let kernel = samples().kernel(&gpu, "scale", "other", &[], &[Link::Slot("factor", "factor_two"), WIDTH]).unwrap();
    assert_eq!(kernel.names().collect::<Vec<_>>(), ["unused_here"]);
    let buffer = gpu.buffer("b", 16, wgpu::BufferUsages::STORAGE);
    let missing = kernel.bind(&gpu, &[]).unwrap_err();
    assert!(matches!(&missing, ShaderError::Unbound { name, .. } if name == "unused_here"), "{missing}");
    let resources = [("unused_here", buffer.as_entire_binding()), ("numbres", buffer.as_entire_binding())];
    let unknown = kernel.bind(&gpu, &resources).unwrap_err();
    assert!(matches!(&unknown, ShaderError::UnknownBinding { name, .. } if name == "numbres"), "{unknown}");
    kernel.bind_used(&gpu, &resources).unwrap();
}

#[test]
fn faults_say_file_and_line() {
    let gpu = Gpu::headless().unwrap();
    let line_of = |library: &ShaderLibrary| match library.validate("top", &[]).unwrap_err() {
        ShaderError::Source { file, line, message } => (file, line, message),
        error => panic!("{error}"),
    };
    let top = "#import lorelei::part::{two}\n@compute @workgroup_size(1)\nfn main() { var x = two(); }\n";
    let part = "#define_import_path lorelei::part\n\nfn two() -> f32 {\n    return 2.0;\n}\n";
    ShaderLibrary::from_sources(&[("top", top), ("part", part)]).validate("top", &[]).unwrap();

    // A word that is no WGSL in the imported file, a wrong type there, an unknown name in the importing file.
    let (file, line, message) =
        line_of(&ShaderLibrary::from_sources(&[("top", top), ("part", &part.replace("return 2.0;", "retrun 2.0;"))]));
    assert_eq!((file.as_str(), line), ("part", 4), "{message}");
    let (file, line, message) =
        line_of(&ShaderLibrary::from_sources(&[("top", top), ("part", &part.replace("2.0", "vec2<f32>(1.0)"))]));
    assert_eq!((file.as_str(), line), ("part", 3), "{message}");
    let (file, line, message) =
        line_of(&ShaderLibrary::from_sources(&[("top", &top.replace("two()", "thre()")), ("part", part)]));
    assert_eq!((file.as_str(), line), ("top", 3), "{message}");
    assert!(message.contains("thre"), "{message}");

    let library = samples();
    let no_slot = library.validate("scale", &[WIDTH]).unwrap_err();
    assert!(matches!(&no_slot, ShaderError::NoImport { import, .. } if import.contains("factor")), "{no_slot}");
    let slot = [Link::Slot("factor", "factor_two"), WIDTH];
    let no_entry = library.kernel(&gpu, "scale", "scael", &[], &slot).unwrap_err();
    assert!(no_entry.to_string().contains("scale, other"), "{no_entry}");
    let no_override = library.kernel(&gpu, "scale", "scale", &[("SCLAE", 1.0)], &slot).unwrap_err();
    assert!(no_override.to_string().contains("SCLAE"), "{no_override}");
    assert!(matches!(library.validate("nothing", &[]).unwrap_err(), ShaderError::NoFile { .. }));
}

#[test]
fn a_bad_edit_keeps_the_last_good_shader_and_a_good_one_replaces_it() {
    let gpu = Gpu::headless().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("factor_two.wgsl");
    for (stem, text) in [("scale", SCALE), ("offset", OFFSET), ("factor_two", TWO)] {
        std::fs::write(folder.path().join(format!("{stem}.wgsl")), text).unwrap();
    }
    let library = ShaderLibrary::watching(folder.path()).unwrap();
    let make = |library: &ShaderLibrary| {
        library.kernel(&gpu, "scale", "scale", &[], &[Link::Slot("factor", "factor_two"), WIDTH])
    };
    let mut kernel = Hot::new(&library, make).unwrap();
    // File systems stamp as coarsely as a few milliseconds, so each edit gets a time of its own.
    let mut seconds = 0;
    let mut edit = |text: &str| {
        std::fs::write(&path, text).unwrap();
        seconds += 10;
        let stamp = std::time::SystemTime::now() + std::time::Duration::from_secs(seconds);
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(stamp).unwrap();
    };
    assert!(!library.poll().unwrap());
    assert!(!kernel.refresh(&library, make));
    assert_eq!(run_scale(&gpu, &kernel)[3], 3.0 * 2.0 + 7.0 + 3000.0);

    edit(&TWO.replace("2.0", "oops"));
    assert!(library.poll().unwrap());
    assert!(!kernel.refresh(&library, make));
    assert!(matches!(kernel.error(), Some(ShaderError::Source { file, line: 3, .. }) if file == "factor_two"));
    assert_eq!(run_scale(&gpu, &kernel)[3], 3.0 * 2.0 + 7.0 + 3000.0);

    edit(&TWO.replace("2.0", "5.0"));
    assert!(library.poll().unwrap());
    assert!(kernel.refresh(&library, make));
    assert_eq!(kernel.error(), None);
    assert_eq!(run_scale(&gpu, &kernel)[3], 3.0 * 5.0 + 7.0 + 3000.0);
}

#[test]
fn every_module_links_with_every_pair_of_choices_of_two_slots() {
    let library = ShaderLibrary::embedded();
    assert!(!library.files().is_empty());
    for file in library.files() {
        let slots = library.slots_of(&file).unwrap();
        let choices: Vec<Vec<String>> = slots.iter().map(|slot| library.files_for_slot(slot)).collect();
        for (slot, choices) in slots.iter().zip(&choices) {
            assert!(!choices.is_empty(), "{file}.wgsl imports `{slot}`: no such file, and none says `// slot: {slot}`");
        }
        let n_choices: Vec<usize> = choices.iter().map(Vec::len).collect();
        for row in covering(&n_choices) {
            let links: Vec<Link<'_>> = (slots.iter().zip(&choices).zip(&row))
                .map(|((slot, choices), &choice)| Link::Slot(slot, &choices[choice]))
                .collect();
            if let Err(error) = library.validate(&file, &links) {
                panic!("{file} with {links:?}: {error}");
            }
        }
    }
}

#[test]
fn a_draw_is_bound_by_name_and_draws() {
    let gpu = Gpu::headless().unwrap();
    let source = "
        @group(0) @binding(auto) var<storage, read> corners: array<vec2<f32>>;
        @group(0) @binding(auto) var<uniform> colour: vec4<f32>;
        @vertex fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
            return vec4<f32>(corners[i], 0.0, 1.0);
        }
        @fragment fn fragment() -> @location(0) vec4<f32> { return colour; }";
    let library = ShaderLibrary::from_sources(&[("fill", source)]);
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let draw: Draw = library
        .draw(
            &gpu,
            "fill",
            &DrawDescriptor {
                vertex: "vertex",
                fragment: Some("fragment"),
                targets: &[Some(format.into())],
                ..DrawDescriptor::default()
            },
        )
        .unwrap();
    // Left half of the picture: clip x from -1 to 0.
    let corners = [[-1.0_f32, -1.0], [0.0, -1.0], [-1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [0.0, 1.0]];
    let corners = gpu.buffer_of("corners", &corners, wgpu::BufferUsages::STORAGE);
    let colour = gpu.buffer_of("colour", &[1.0_f32, 0.0, 0.0, 1.0], wgpu::BufferUsages::UNIFORM);
    let bindings =
        draw.bind(&gpu, &[("corners", corners.as_entire_binding()), ("colour", colour.as_entire_binding())]).unwrap();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("test"),
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let pixels = gpu.buffer("pixels", 64 * 64 * 4, wgpu::BufferUsages::COPY_DST);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLUE), store: wgpu::StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        draw.draw(&mut pass, &bindings, 6);
    }
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &pixels,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let pixels: Vec<[u8; 4]> = gpu.read_buffer(&pixels).unwrap();
    assert_eq!(pixels.iter().filter(|&&pixel| pixel == [255, 0, 0, 255]).count(), 32 * 64);
    assert_eq!(pixels.iter().filter(|&&pixel| pixel == [0, 0, 255, 255]).count(), 32 * 64);
}

#[test]
fn an_uncaught_fault_is_an_error_and_not_a_panic() {
    let gpu = Gpu::headless().unwrap();
    gpu.take_error().unwrap();
    // A buffer larger than any device allows.
    let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("too large"),
        size: !15,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    gpu.take_error().unwrap_err();
    gpu.take_error().unwrap();
}

#[test]
fn a_grid_covers_its_items_within_the_limit() {
    for n_items in [0, 1, 64, 65, 65_535 * 64, 65_535 * 64 + 1, u32::MAX / 2] {
        let [x, y, z] = grid_1d(n_items, 64);
        assert!(x <= 65_535 && y <= 65_535 && z == 1);
        assert!(u64::from(x) * u64::from(y) * 64 >= u64::from(n_items));
    }
}
