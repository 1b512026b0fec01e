// What the inspected place of a strand shows, with whatever terms and lights this kernel was linked and bound with.
#import lorelei::inspect_result::{inspected, PLACE, TANGENT, STRAND, DEPTHS, MOST_LIGHTS}
#import lorelei::shade_layers::{fibres}
#import lorelei::shade_lights::{scene}
#import lorelei::shade_point::{NO_OFFSET, shade_point}
#import lorelei::shadow::{hair_depth, head_visibility}

struct InspectTerm {
    // Where in `inspected` the answer goes.
    at: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(auto) var<uniform> inspect_term: InspectTerm;
// See strands.wgsl.
@group(0) @binding(auto) var<storage, read> seeds: array<vec2<u32>>;

@compute @workgroup_size(1)
fn shade_term() {
    let place = inspected[PLACE];
    if place.w <= 0.0 {
        return;
    }
    let layer = bitcast<u32>(inspected[STRAND].x);
    let strand = bitcast<u32>(inspected[STRAND].y);
    let seed = seeds[fibres[layer].first_strand + strand];
    let tangent = inspected[TANGENT];
    let l = shade_point(fibres[layer].fibre, seed, tangent.w, place.xyz, tangent.xyz, NO_OFFSET);
    inspected[inspect_term.at] = vec4<f32>(l, 1.0);
}

@compute @workgroup_size(1)
fn light_depths() {
    let place = inspected[PLACE];
    if place.w <= 0.0 {
        return;
    }
    for (var light_idx = 0u; light_idx < min(scene.n_lights, MOST_LIGHTS); light_idx++) {
        inspected[DEPTHS + light_idx] =
            vec4<f32>(hair_depth(light_idx, place.xyz), head_visibility(light_idx, place.xyz), 0.0, 1.0);
    }
}
