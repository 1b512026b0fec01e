// Slot `shadow_sink`: the front and the back of the hair.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_range
#import lorelei::shadow_map::{front_bits}

@group(0) @binding(auto) var<storage, read_write> shadow_front: array<atomic<u32>>;
// Bits of the farthest depth.
@group(0) @binding(auto) var<storage, read_write> shadow_back: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    atomicMax(&shadow_front[at], front_bits(depth));
    atomicMax(&shadow_back[at], bitcast<u32>(max(depth, 0.0)));
}
