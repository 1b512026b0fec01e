// Room for the fragments of a texel of a deep shadow map. Where all of them together are more than were guessed, each list
// keeps its share of them, and those that are kept stand for the others.
#define_import_path lorelei::shadow_room
#import lorelei::shadow_map::{shadow_params}

// Words that are taken, fragments in all, texels with any.
const TAKEN: u32 = 0u;
const WANTED: u32 = 1u;
const LISTS: u32 = 2u;

// Of `wanted` fragments of a texel, those that are kept.
fn room_of(wanted: u32, n_wanted: u32, n_lists: u32) -> u32 {
    let room = shadow_params.n_fragments;
    if n_wanted <= room {
        return wanted;
    }
    // One at least: lists that are rounded up take no more than a word each beyond their share. Floats round by 1e-7.
    let spare = f32(room - min(n_lists, room)) * 0.9999;
    return min(wanted, u32(ceil(f32(wanted) * spare / f32(n_wanted))));
}
