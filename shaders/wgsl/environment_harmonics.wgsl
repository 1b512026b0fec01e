// The environment as real spherical harmonics of four bands, their pole up. Twin of render/src/environment/harmonics.rs.
#define_import_path lorelei::environment_harmonics
#import lorelei::shade_lights::{scene}

// Radiance from a direction (unit length).
fn radiance_from(d: vec3<f32>) -> vec3<f32> {
    let x = d.z;
    let y = d.x;
    let z = d.y;
    var l = 0.28209479 * scene.around[0].xyz;
    l += 0.48860251 * (y * scene.around[1].xyz + z * scene.around[2].xyz
        + x * scene.around[3].xyz);
    l += 1.09254843 * (x * y * scene.around[4].xyz + y * z * scene.around[5].xyz
        + x * z * scene.around[7].xyz);
    l += 0.31539157 * (3.0 * z * z - 1.0) * scene.around[6].xyz;
    l += 0.54627422 * (x * x - y * y) * scene.around[8].xyz;
    l += 0.59004359 * y * (3.0 * x * x - y * y) * scene.around[9].xyz;
    l += 2.89061144 * x * y * z * scene.around[10].xyz;
    l += 0.45704580 * (5.0 * z * z - 1.0) * (y * scene.around[11].xyz
        + x * scene.around[13].xyz);
    l += 0.37317633 * z * (5.0 * z * z - 3.0) * scene.around[12].xyz;
    l += 1.44530572 * z * (x * x - y * y) * scene.around[14].xyz;
    l += 0.59004359 * x * (x * x - 3.0 * y * y) * scene.around[15].xyz;
    return max(l, vec3<f32>(0.0));
}

// Irradiance over pi of a surface with a unit normal.
fn irradiance_at(n: vec3<f32>) -> vec3<f32> {
    let x = n.z;
    let y = n.x;
    let z = n.y;
    var e = 0.28209479 * scene.around_irradiance[0].xyz;
    e += 0.48860251 * (y * scene.around_irradiance[1].xyz + z * scene.around_irradiance[2].xyz
        + x * scene.around_irradiance[3].xyz);
    e += 1.09254843 * (x * y * scene.around_irradiance[4].xyz + y * z * scene.around_irradiance[5].xyz
        + x * z * scene.around_irradiance[7].xyz);
    e += 0.31539157 * (3.0 * z * z - 1.0) * scene.around_irradiance[6].xyz;
    e += 0.54627422 * (x * x - y * y) * scene.around_irradiance[8].xyz;
    return max(e, vec3<f32>(0.0));
}
