// Slot `radiance`: shaded where a strand touches a pixel.
// slot: radiance
#define_import_path lorelei::radiance_fragment
#import lorelei::shade_layers::{fibres, layer_of_vertex}
#import lorelei::shade_lights::{scene}
#import lorelei::shade_point::{shade_point}
#import lorelei::strands::{vertices, seeds}

struct SegmentRadiance {
    vertex: u32,
}

fn segment_radiance(vertex: u32) -> SegmentRadiance {
    return SegmentRadiance(vertex);
}

fn fibre_radiance(segment: SegmentRadiance, t: f32, across: f32) -> vec4<f32> {
    let vertex = segment.vertex;
    let layer = layer_of_vertex(vertex);
    let n = fibres[layer].vertices_per_strand;
    let idx = vertex - fibres[layer].first_vertex;
    let along = idx % n;
    // Compute the tangent between those of the two vertices, each along its neighbours.
    let a = vertices[vertex].xyz;
    let b = vertices[vertex + 1u].xyz;
    let before = vertices[vertex - min(along, 1u)].xyz;
    let after = vertices[vertex + 1u + min(n - 2u - along, 1u)].xyz;
    let direction = mix(normalize(b - before), normalize(after - a), t);
    let tangent = direction * inverseSqrt(max(dot(direction, direction), 1e-12));
    let seed = seeds[fibres[layer].first_strand + idx / n];
    let share = (f32(along) + t) / f32(n - 1u);
    let l = shade_point(fibres[layer].fibre, seed, share, mix(a, b, t), tangent, across);
    return vec4<f32>(min(l, vec3<f32>(60000.0)), scene.opacity);
}
