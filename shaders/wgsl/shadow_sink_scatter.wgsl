// Slot `shadow_sink`: each fragment into its texel's list.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_scatter
#import lorelei::shadow_map::{shadow_params}
#import lorelei::shadow_fragments::{MOST_OPACITY, step_of, pack}

@group(0) @binding(auto) var<storage, read> shadow_offsets: array<u32>;
@group(0) @binding(auto) var<storage, read_write> shadow_counts: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> shadow_fragments: array<u32>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let to = shadow_offsets[at] + atomicAdd(&shadow_counts[at], 1u);
    if to < shadow_params.n_fragments {
        shadow_fragments[to] = pack(u32(step_of(light_idx, depth)), opacity / MOST_OPACITY);
    }
}
