// Slot `shadow_sink`: the front of the hair.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_front
#import lorelei::shadow_map::{front_bits}

@group(0) @binding(auto) var<storage, read_write> shadow_front: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    atomicMax(&shadow_front[at], front_bits(depth));
}
