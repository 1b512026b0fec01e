// Slot `sim_air`: wind that nothing stands in the way of. Twin of Air::Uniform in sim/src/air.rs.
// slot: sim_air
#define_import_path lorelei::sim_air_uniform

#import lorelei::wind_free::free_air

fn air_velocity(p: vec3<f32>) -> vec3<f32> {
    return free_air(p);
}
