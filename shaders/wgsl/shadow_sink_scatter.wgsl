// Slot `shadow_sink`: each fragment into its texel's list. Where there is no room for all, those that come first stand for
// the others: strands come in an order that spreads them over the head.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_scatter
#import lorelei::shadow_fragments::{MOST_OPACITY, step_of, pack}
#import lorelei::shadow_room::{WANTED, LISTS, room_of}

@group(0) @binding(auto) var<storage, read> shadow_wanted: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_offsets: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_taken: array<u32>;
@group(0) @binding(auto) var<storage, read_write> shadow_counts: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> shadow_fragments: array<u32>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let wanted = shadow_wanted[at];
    let room = room_of(wanted, shadow_taken[WANTED], shadow_taken[LISTS]);
    let idx = atomicAdd(&shadow_counts[at], 1u);
    if idx < room {
        let weight = f32(wanted) / f32(room);
        shadow_fragments[shadow_offsets[at] + idx] = pack(u32(step_of(light_idx, depth)), weight * opacity / MOST_OPACITY);
    }
}
