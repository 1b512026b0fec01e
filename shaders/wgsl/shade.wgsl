// Outgoing radiance of every strand vertex. Twin of render/src/shade.rs, `shade_vertex`.
//
// Per vertex and not per pixel: a vertex is shaded once for all the pixels and lights that see it, and the
// rasteriser interpolates. 002 and 000 (line 776) say that it does not show where vertices are close.
#import lorelei::scatter_fibre::{Fibre, directions, vary}
#import lorelei::scatter_volume::{volume}
#import lorelei::scattering::{scatter}
#import lorelei::multiple::{multiple, spread, through}
#import lorelei::environment::{environment_through}
#import lorelei::shadow::{hair_depth, head_visibility}
#import lorelei::shade_lights::{scene, arriving}

struct ShadeLayer {
    fibre: Fibre,
    first_vertex: u32,
    first_strand: u32,
    n_vertices: u32,
    vertices_per_strand: u32,
}

@group(0) @binding(auto) var<uniform> shade_layer: ShadeLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> seeds: array<u32>;
// Four half floats: linear radiance, and the fibre's opacity.
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= shade_layer.n_vertices {
        return;
    }
    let strand = item / shade_layer.vertices_per_strand;
    let along = item % shade_layer.vertices_per_strand;
    let vertex = shade_layer.first_vertex + item;
    let position = vertices[vertex].xyz;
    let before = vertices[vertex - min(along, 1u)].xyz;
    let after = vertices[vertex + min(shade_layer.vertices_per_strand - 1u - along, 1u)].xyz;
    let along_strand = after - before;
    let tangent = along_strand * inverseSqrt(max(dot(along_strand, along_strand), 1e-12));
    let to_eye = normalize(scene.eye - position);

    let t = f32(along) / f32(shade_layer.vertices_per_strand - 1u);
    let fibre = vary(shade_layer.fibre, seeds[shade_layer.first_strand + strand], t);
    let heap = volume(fibre);

    var l = vec3<f32>(0.0);
    var ambient = vec3<f32>(0.0);
    // The direction that is open the widest counts twice: lights are few and the environment has no gaps.
    var openest = vec3<f32>(0.0);
    for (var light_idx = 0u; light_idx < scene.n_lights; light_idx++) {
        let light = arriving(light_idx, position);
        let tau = hair_depth(light_idx, position);
        let lit = head_visibility(light_idx, position);
        let d = directions(tangent, light.to_light, to_eye);
        let single = scatter(spread(fibre, tau), d) * through(fibre, heap, tau);
        let many = multiple(fibre, heap, tangent, light.to_light, to_eye, tau);
        l += (single + many) * lit * light.irradiance;
        let open = environment_through(heap, tau, lit);
        ambient += open;
        openest = max(openest, open);
    }
    if scene.n_lights == 0u {
        openest = environment_through(heap, 0.0, 1.0);
    }
    l += (ambient + openest) / f32(scene.n_lights + 1u) * scene.environment;

    // Half floats end at 65,504.
    let clipped = min(l, vec3<f32>(60000.0));
    radiance[vertex] = vec2<u32>(pack2x16float(clipped.xy), pack2x16float(vec2<f32>(clipped.z, 1.0)));
}
