// What one place of a fibre shows: single scattering of each light past what shadows it, multiple scattering, and the
// environment. Any kernel may call it: `shade` does so for every vertex, a rasteriser may for every fragment.
//
// It binds whatever the linked slots use (`scene`, `scene_lights`, shadow data) and no strand: where the place is, which
// way the fibre runs there and what it is made of is the caller's to say (see `shade_layers`).
#define_import_path lorelei::shade_point
#import lorelei::scatter_fibre::{Fibre, directions, vary}
#import lorelei::scatter_volume::{volume}
#import lorelei::scattering::{scatter}
#import lorelei::multiple::{multiple, spread, through}
#import lorelei::environment::{SHINES, environment}
#import lorelei::environment_open::{Open, let_in}
#import lorelei::shadow::{hair_depth, head_visibility}
#import lorelei::shade_lights::{scene, arriving}

// An offset across the fibre that means "averaged over its width": the far field.
const NO_OFFSET: f32 = 2.0;

// Radiance towards the eye. `strand` is what `seeds` holds of it, `t` the share of its length from the root; `tangent` points
// to the tip and has unit length. `h` is the place across the fibre as the eye sees it, -1 to 1 in radii, growing along
// cross(tangent, to_eye) (to the right of a strand that runs up the picture), or NO_OFFSET.
fn shade_point(
    base: Fibre,
    strand: vec2<u32>,
    t: f32,
    position: vec3<f32>,
    tangent: vec3<f32>,
    h: f32,
) -> vec3<f32> {
    let to_eye = normalize(scene.eye - position);
    let fibre = vary(base, strand.x, t, bitcast<f32>(strand.y));
    let heap = volume(fibre);

    var l = vec3<f32>(0.0);
    var let_in_sum = vec3<f32>(0.0);
    // The direction that is open the widest counts twice: lights are few and the environment has no gaps.
    var openest = vec3<f32>(0.0);
    for (var light_idx = 0u; light_idx < scene.n_lights; light_idx++) {
        let light = arriving(light_idx, position);
        let tau = hair_depth(light_idx, position);
        let lit = head_visibility(light_idx, position);
        let d = directions(tangent, light.to_light, to_eye, h);
        let single = scatter(spread(fibre, tau), d) * through(fibre, heap, tau);
        let many = multiple(fibre, heap, tangent, light.to_light, to_eye, tau);
        l += (single + many) * lit * light.irradiance;
        if SHINES && scene.n_probes == 0u {
            let open = let_in(heap, tau, lit);
            let_in_sum += open;
            openest = max(openest, open);
        }
    }
    if !SHINES {
        return l;
    }
    var uneven = vec3<f32>(0.0);
    for (var probe_idx = scene.n_lights; probe_idx < scene.n_lights + scene.n_probes; probe_idx++) {
        let open = let_in(heap, hair_depth(probe_idx, position), head_visibility(probe_idx, position));
        let_in_sum += open;
        openest = max(openest, open);
        uneven += open.y * arriving(probe_idx, position).to_light;
    }
    let n_asked = select(scene.n_probes, scene.n_lights, scene.n_probes == 0u);
    if n_asked == 0u {
        openest = let_in(heap, 0.0, 1.0);
    }
    var open: Open;
    open.share = (let_in_sum + openest) / f32(n_asked + 1u);
    // The probes' directions balance: for n of them the least squares of `share` (1 + dot(towards, direction)) are these.
    open.towards = 3.0 / (f32(max(n_asked, 1u)) * max(open.share.y, 1e-4)) * uneven;
    open.towards /= max(length(open.towards), 1.0);
    return l + environment(fibre, heap, tangent, to_eye, open);
}
