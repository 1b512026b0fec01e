// Slot `tonemap`: AgX (Troy Sobotka 2022, the view transform of Blender 4).
//
// The primaries are drawn in towards white, so that no channel can run away from the others; then a curve over 16.5
// stops of log2 light; then the primaries are drawn out again. Matrices and the sixth-degree fit of the curve (error
// below 0.4 % of full scale): B. Wrensch, "Minimal AgX Implementation", 2023. Twin of render/src/tonemap.rs.
// slot: tonemap
#define_import_path lorelei::tonemap_agx

const INSET: mat3x3<f32> = mat3x3<f32>(
    0.842479062253094, 0.0423282422610123, 0.0423756549057051,
    0.0784335999999992, 0.878468636469772, 0.0784336,
    0.0792237451477643, 0.0791661274605434, 0.879142973793104,
);
const OUTSET: mat3x3<f32> = mat3x3<f32>(
    1.19687900512017, -0.0528968517574562, -0.0529716355144438,
    -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
    -0.0990297440797205, -0.0989611768448433, 1.15107367264116,
);
// Stops of black and white: 10 below and 6.5 above middle grey 0.18.
const MIN_EV: f32 = -12.47393;
const MAX_EV: f32 = 4.026069;

fn contrast(x: vec3<f32>) -> vec3<f32> {
    let x2 = x * x;
    let x4 = x2 * x2;
    return 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
}

// Linear scene light to values encoded for an sRGB display.
fn display(colour: vec3<f32>) -> vec3<f32> {
    let light = max(INSET * max(colour, vec3<f32>(0.0)), vec3<f32>(1e-10));
    let stops = clamp((log2(light) - MIN_EV) / (MAX_EV - MIN_EV), vec3<f32>(0.0), vec3<f32>(1.0));
    return saturate(OUTSET * contrast(stops));
}
