// Slot `sim_air`: the same wind everywhere. Twin of Air::Uniform in sim/src/air.rs.
// slot: sim_air
#define_import_path lorelei::sim_air_uniform

// xyz velocity, cm/s.
@group(0) @binding(auto) var<uniform> air: vec4<f32>;

fn air_velocity(p: vec3<f32>) -> vec3<f32> {
    return air.xyz;
}
