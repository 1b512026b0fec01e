// Hair over head over background, exposed, balanced and tonemapped.
#import lorelei::camera::{View}
#import lorelei::tonemap::{display}
#import lorelei::background::{background}
#import lorelei::behind::{Behind}
#import lorelei::view_picture::{over_body}

struct ResolveLook {
    // Exposure and white balance, linear Rec. 709.
    picture_from_scene: mat3x3<f32>,
    grey: f32,
    // Of the environment's picture: radians about the vertical, and scale.
    turn: f32,
    gain: f32,
    pad: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> resolve_look: ResolveLook;
@group(0) @binding(auto) var hair: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;
// Encoded for an sRGB display, premultiplied after encoding, as window systems blend.
@group(0) @binding(auto) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size) {
        return;
    }
    let front = textureLoad(hair, id.xy, 0);
    let over = over_body(id.xy, front, textureLoad(head_colour, id.xy, 0));
    let place = (vec2<f32>(id.xy) + 0.5) / vec2<f32>(view.size);
    // The rows of the view's rotation are its axes.
    let off = (vec2<f32>(id.xy) + 0.5 - 0.5 * vec2<f32>(view.size)) / view.pixels_per_tangent;
    let rotation = transpose(mat3x3<f32>(view.view_from_world[0].xyz, view.view_from_world[1].xyz, view.view_from_world[2].xyz));
    let ray = normalize(rotation * vec3<f32>(off.x, -off.y, -1.0));
    let look = resolve_look;
    let behind = background(Behind(place, ray, look.grey, look.turn, look.gain, look.picture_from_scene));
    let scene = display(resolve_look.picture_from_scene * (over.xyz / max(over.w, 1e-4)));
    let alpha = saturate(over.w);
    // Interleaved gradient noise (Jimenez 2014) below one step of eight bits: no bands in the gradient.
    let noise = fract(52.9829189 * fract(dot(vec2<f32>(id.xy), vec2<f32>(0.06711056, 0.00583715)))) - 0.5;
    let mixed = vec4<f32>(scene * alpha, alpha) + (1.0 - alpha) * behind;
    textureStore(picture, id.xy, vec4<f32>(mixed.xyz + noise * mixed.w / 255.0, mixed.w));
}
