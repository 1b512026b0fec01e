// The tables of scattering: textures with mip maps, made by render/src/scattering/tables.rs. Twin of the lookups in
// render/src/scattering/{table,azimuthal}.rs.
#define_import_path lorelei::scatter_tables
#import lorelei::scatter_fibre::{Fibre}

// Four layers a material: R, TT, TRT, the rest.
@group(0) @binding(auto) var fibre_azimuthal: texture_2d_array<f32>;
// One layer a material: M_R, M_TT, M_TRT, cos(theta_d).
@group(0) @binding(auto) var fibre_longitudinal: texture_2d_array<f32>;
@group(0) @binding(auto) var table_sampler: sampler;

// Angle over which a lookup is to be averaged, radians: how much the fibre turns within what is shaded at once. The
// caller of `shade_point` may set it; it chooses the mip map.
var<private> footprint: f32 = 0.0;

const PI: f32 = 3.14159265358979324;

fn set_footprint(angle: f32) {
    footprint = angle;
}

// The place of `x`, 0-1, on an axis whose ends are the first and the last texel's centre.
fn axis(x: f32, n: f32) -> f32 {
    return (clamp(x, 0.0, 1.0) * (n - 1.0) + 0.5) / n;
}

fn look_up(layer: u32, x: f32, y: f32) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(fibre_azimuthal));
    let lod = log2(max(footprint * size.x / PI, 1.0));
    let uv = vec2<f32>(axis(x, size.x), axis(y, size.y));
    return textureSampleLevel(fibre_azimuthal, table_sampler, uv, layer, lod);
}

fn look_up_longitudinal(layer: u32, x: f32, y: f32) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(fibre_longitudinal));
    let lod = log2(max(footprint * size.x * 0.5, 1.0));
    let uv = vec2<f32>(axis(x, size.x), axis(y, size.y));
    return textureSampleLevel(fibre_longitudinal, table_sampler, uv, layer, lod);
}

// The light has gone one of two lengths: those of the Gaussian quadrature with this mean, deviation and skewness.
fn absorbed(texel: vec4<f32>, sigma_a: vec3<f32>) -> vec3<f32> {
    let half = 0.5 * texel.w;
    let root = sqrt(1.0 + half * half);
    let far_share = 0.5 - 0.5 * half / root;
    let near = exp(-sigma_a * max(texel.y + texel.z * (half - root), 0.0));
    let far = exp(-sigma_a * (texel.y + texel.z * (half + root)));
    return texel.x * ((1.0 - far_share) * near + far_share * far);
}

// N_p from the table of angles.
fn azimuthal(fibre: Fibre, p: u32, cos_phi: f32, cos_theta: f32) -> vec3<f32> {
    let x = acos(clamp(cos_phi, -1.0, 1.0)) / PI;
    let y = acos(clamp(cos_theta, 0.0, 1.0)) / (0.5 * PI);
    return absorbed(look_up(fibre.table + p, x, y), fibre.sigma_a);
}
