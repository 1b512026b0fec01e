// Slot `shadow_sink`: how many fragments a texel has.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_count

@group(0) @binding(auto) var<storage, read_write> shadow_wanted: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    atomicAdd(&shadow_wanted[at], 1u);
}
