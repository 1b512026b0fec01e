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
#import lorelei::environment::{environment_through}
#import lorelei::shadow::{hair_depth, head_visibility}
#import lorelei::shade_lights::{scene, arriving}

// An offset across the fibre that means "averaged over its width": the far field.
const NO_OFFSET: f32 = 2.0;

// Radiance towards the eye. `t` is the share of the strand's length from the root, `tangent` points to the tip and has
// unit length. `h` is the place across the fibre as the eye sees it, -1 to 1 in radii, growing along
// cross(tangent, to_eye) (to the right of a strand that runs up the picture), or NO_OFFSET.
fn shade_point(
    base: Fibre,
    strand_seed: u32,
    t: f32,
    position: vec3<f32>,
    tangent: vec3<f32>,
    h: f32,
) -> vec3<f32> {
    let to_eye = normalize(scene.eye - position);
    let fibre = vary(base, strand_seed, t);
    let heap = volume(fibre);

    var l = vec3<f32>(0.0);
    var ambient = vec3<f32>(0.0);
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
        let open = environment_through(heap, tau, lit);
        ambient += open;
        openest = max(openest, open);
    }
    if scene.n_lights == 0u {
        openest = environment_through(heap, 0.0, 1.0);
    }
    return l + (ambient + openest) / f32(scene.n_lights + 1u) * scene.environment;
}
