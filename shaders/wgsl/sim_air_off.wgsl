// Slot `sim_air`: air that does not move. Twin of Air::Still in sim/src/air.rs.
// slot: sim_air
#define_import_path lorelei::sim_air_off

fn air_velocity(p: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}
