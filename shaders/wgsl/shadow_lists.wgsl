// Deep shadow maps (Lokovic and Veach 2000) between the two draws: room for each texel's list; and after them: the lists
// sorted, and made into polylines of transmittance over depth, in place.
#import lorelei::shadow_map::{shadow_params}
#import lorelei::shadow_fragments::{MOST_OPACITY, pack, packed_step, packed_value}
#import lorelei::shadow_room::{TAKEN, WANTED, LISTS, room_of}

// Fragments of each texel.
@group(0) @binding(auto) var<storage, read> shadow_wanted: array<u32>;
// Of those, the ones that have come; in the end, nodes.
@group(0) @binding(auto) var<storage, read_write> shadow_counts: array<u32>;
@group(0) @binding(auto) var<storage, read_write> shadow_offsets: array<u32>;
// See shadow_room.wgsl.
@group(0) @binding(auto) var<storage, read_write> shadow_taken: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> shadow_fragments: array<u32>;

// Texels of a thread: one atomic for so many lists, and no barriers.
const N_PER_THREAD: u32 = 16u;

fn n_texels() -> u32 {
    return shadow_params.resolution * shadow_params.resolution * shadow_params.n_lights;
}

@compute @workgroup_size(64)
fn total(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let first = N_PER_THREAD * (id.x + id.y * n_groups.x * 64u);
    let last = min(first + N_PER_THREAD, n_texels());
    var n = 0u;
    var n_lists = 0u;
    for (var at = first; at < last; at++) {
        n += shadow_wanted[at];
        n_lists += u32(shadow_wanted[at] > 0u);
    }
    if n > 0u {
        atomicAdd(&shadow_taken[WANTED], n);
        atomicAdd(&shadow_taken[LISTS], n_lists);
    }
}

// Fragments of a texel that are kept.
fn kept_of(at: u32) -> u32 {
    return room_of(shadow_wanted[at], atomicLoad(&shadow_taken[WANTED]), atomicLoad(&shadow_taken[LISTS]));
}

@compute @workgroup_size(64)
fn allocate(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let first = N_PER_THREAD * (id.x + id.y * n_groups.x * 64u);
    let last = min(first + N_PER_THREAD, n_texels());
    var n = 0u;
    for (var at = first; at < last; at++) {
        n += kept_of(at);
    }
    if n == 0u {
        return;
    }
    var offset = atomicAdd(&shadow_taken[TAKEN], n);
    for (var at = first; at < last; at++) {
        shadow_offsets[at] = offset;
        offset += kept_of(at);
    }
}

// Shell sort with Ciura's gaps (2001): in place, and lists are some ten to some hundred long.
fn sort(first: u32, n: u32) {
    var gaps = array<u32, 8>(701u, 301u, 132u, 57u, 23u, 10u, 4u, 1u);
    for (var g = 0u; g < 8u; g++) {
        let gap = gaps[g];
        for (var i = gap; i < n; i++) {
            let word = shadow_fragments[first + i];
            var j = i;
            while j >= gap && shadow_fragments[first + j - gap] > word {
                shadow_fragments[first + j] = shadow_fragments[first + j - gap];
                j -= gap;
            }
            shadow_fragments[first + j] = word;
        }
    }
}

// Lokovic and Veach's greedy compression (their section 3.2): a line goes on as long as some slope keeps it within the
// tolerance of all points passed; then a node is set where the last one was. The points are the transmittance in the
// middle of each fragment, so that a fragment shadows itself by half; no line rises, since light never does. There are never more nodes than fragments read.
// Twin of render/src/shadow/deep_shadow.rs, `compress`.
fn compress(first: u32, n: u32) -> u32 {
    let tolerance = shadow_params.tolerance;
    var tau = 0.0;
    var n_nodes = 0u;
    // The node that the line starts from, and the last point.
    var from_step = 0u;
    var from_light = 1.0;
    var last_step = 0u;
    var least = -1e30;
    var most = 1e30;
    var i = 0u;
    while i < n {
        let step = packed_step(shadow_fragments[first + i]);
        var opacity = 0.0;
        // What cannot be told apart by depth is one.
        while i < n && packed_step(shadow_fragments[first + i]) == step {
            opacity += packed_value(shadow_fragments[first + i]) * MOST_OPACITY;
            i++;
        }
        let light = exp(-shadow_params.density * (tau + select(0.5 * opacity, opacity, i == n)));
        tau += opacity;
        if n_nodes == 0u {
            from_step = step;
            from_light = light;
            shadow_fragments[first] = pack(step, light);
            n_nodes = 1u;
        } else {
            let run = f32(step - from_step);
            let lower = (light - tolerance - from_light) / run;
            let upper = (light + tolerance - from_light) / run;
            if max(least, lower) > min(most, upper) {
                from_light += min(0.5 * (least + most), 0.0) * f32(last_step - from_step);
                from_step = last_step;
                shadow_fragments[first + n_nodes] = pack(from_step, from_light);
                n_nodes++;
                least = (light - tolerance - from_light) / f32(step - from_step);
                most = (light + tolerance - from_light) / f32(step - from_step);
            } else {
                least = max(least, lower);
                most = min(most, upper);
            }
        }
        last_step = step;
    }
    if last_step > from_step {
        from_light += min(0.5 * (least + most), 0.0) * f32(last_step - from_step);
        shadow_fragments[first + n_nodes] = pack(last_step, from_light);
        n_nodes++;
    }
    return n_nodes;
}

@compute @workgroup_size(64)
fn finish(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let at = id.x + id.y * n_groups.x * 64u;
    if at >= n_texels() || shadow_counts[at] == 0u {
        return;
    }
    let first = shadow_offsets[at];
    let n = min(shadow_counts[at], kept_of(at));
    sort(first, n);
    shadow_counts[at] = compress(first, n);
}
