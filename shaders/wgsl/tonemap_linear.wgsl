// Slot `tonemap`: clipped, and encoded for an sRGB display (IEC 61966-2-1). Twin of render/src/tonemap.rs.
// slot: tonemap
#define_import_path lorelei::tonemap_linear

fn display(colour: vec3<f32>) -> vec3<f32> {
    let light = saturate(colour);
    let power = 1.055 * pow(max(light, vec3<f32>(1e-10)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(power, 12.92 * light, light <= vec3<f32>(0.0031308));
}
