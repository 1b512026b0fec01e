//! From linear scene light to display values on the CPU: the twins of `tonemap_agx.wgsl` and `tonemap_linear.wgsl`.

use glam::{Mat3, Vec3};
use lorelei_core::look::Tonemapping;

/// AgX draws the primaries in towards white before its curve (B. Wrensch, "Minimal AgX Implementation", 2023).
const INSET: Mat3 = Mat3::from_cols(
    Vec3::new(0.842_479_06, 0.042_328_224, 0.042_375_654),
    Vec3::new(0.078_433_6, 0.878_468_6, 0.078_433_6),
    Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
);
/// And out again after it.
const OUTSET: Mat3 = Mat3::from_cols(
    Vec3::new(1.196_879, -0.052_896_854, -0.052_971_635),
    Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
    Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
);
/// Stops of black and white: 10 below and 6.5 above middle grey 0.18.
const MIN_EV: f32 = -12.473_93;
const MAX_EV: f32 = 4.026_069;

/// Linear Rec. 709 light to values encoded for an sRGB display, 0-1.
pub fn display(tonemapping: Tonemapping, colour: Vec3) -> Vec3 {
    match tonemapping {
        Tonemapping::Agx => agx(colour),
        Tonemapping::Linear => linear(colour),
    }
}

fn agx(colour: Vec3) -> Vec3 {
    let light = (INSET * colour.max(Vec3::ZERO)).max(Vec3::splat(1e-10));
    let stops = ((light.map(f32::log2) - MIN_EV) / (MAX_EV - MIN_EV)).clamp(Vec3::ZERO, Vec3::ONE);
    (OUTSET * contrast(stops)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// AgX's curve as Wrensch's polynomial of the sixth degree.
fn contrast(x: Vec3) -> Vec3 {
    let x2 = x * x;
    let x4 = x2 * x2;
    15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232
}

/// Clipped, and encoded for an sRGB display (IEC 61966-2-1).
fn linear(colour: Vec3) -> Vec3 {
    colour
        .clamp(Vec3::ZERO, Vec3::ONE)
        .map(|light| if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 })
}

#[cfg(test)]
mod tests {
    use lorelei_core::look::Choice;
    use lorelei_shaders::{Gpu, ShaderLibrary};
    use wgpu::BufferUsages;

    use super::*;
    use crate::slot;

    const TONEMAP: &str = "
#import lorelei::tonemap::{display}
@group(0) @binding(auto) var<storage, read> colours: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&colours) { return; }
    answers[id.x] = vec4<f32>(display(colours[id.x].xyz), 0.0);
}";

    /// Greys over 30 stops, colours with one channel far ahead, and what must not be: light below zero.
    fn colours() -> Vec<[f32; 4]> {
        let mut colours = vec![[-1.0, 0.0, 2.0, 0.0], [0.0; 4]];
        for step in 0..300 {
            let light = f32::exp2(0.1 * step as f32 - 18.0);
            for tint in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.1, 0.4, 1.0], [0.9, 0.02, 0.5]] {
                colours.push([light * tint[0], light * tint[1], light * tint[2], 0.0]);
            }
        }
        colours
    }

    #[test]
    fn wgsl_twins_agree_with_the_cpu() {
        let gpu = Gpu::headless().unwrap();
        let library = ShaderLibrary::from_sources(&[
            ("tonemap_agx", include_str!("../../shaders/wgsl/tonemap_agx.wgsl")),
            ("tonemap_linear", include_str!("../../shaders/wgsl/tonemap_linear.wgsl")),
            ("tonemap_test", TONEMAP),
        ]);
        let colours = colours();
        let given = gpu.buffer_of("test.colours", &colours, BufferUsages::STORAGE);
        let answers = gpu.buffer("test.answers", 16 * colours.len() as u64, BufferUsages::STORAGE);
        for &tonemapping in Tonemapping::ALL {
            let kernel = library.kernel(&gpu, "tonemap_test", "main", &[], &[slot::tonemapping(tonemapping)]).unwrap();
            let bindings = kernel
                .bind(&gpu, &[("colours", given.as_entire_binding()), ("answers", answers.as_entire_binding())])
                .unwrap();
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                kernel.dispatch_items(&mut pass, &bindings, colours.len() as u32);
            }
            gpu.queue.submit([encoder.finish()]);
            let answers: Vec<[f32; 4]> = gpu.read_buffer(&answers).unwrap();
            let worst = colours.iter().zip(&answers).fold(0.0, |worst: f32, (colour, answer)| {
                let expected = display(tonemapping, Vec3::from_slice(&colour[..3]));
                worst.max((Vec3::from_slice(&answer[..3]) - expected).abs().max_element())
            });
            println!("{tonemapping:?}: worst difference {worst:.1e}");
            // A quarter of a step of eight bits: no picture shows it.
            assert!(worst < 1e-3, "{tonemapping:?}: {worst}");
        }
    }

    #[test]
    fn agx_keeps_greys_grey_and_in_order_and_puts_middle_grey_where_a_display_has_it() {
        let mut before = -1.0;
        for step in 0..=165 {
            let value = agx(Vec3::splat(0.18 * f32::exp2(0.1 * step as f32 - 10.0)));
            assert!(value.max_element() - value.min_element() < 2e-3, "{value}");
            // The fit dips by its own error at the black end.
            assert!(value.x > before - 4e-3, "{value} after {before}");
            before = value.x;
        }
        assert!(before > 0.99, "white is {before}");
        // The pivot of AgX's curve: middle grey at half of the display's values.
        let middle = agx(Vec3::splat(0.18)).x;
        assert!((middle - 0.5).abs() < 5e-3, "{middle}");
    }
}
