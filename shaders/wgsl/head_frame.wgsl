// What the head's passes know about the frame and the mesh. Twin of render/src/head.rs.
#define_import_path lorelei::head_frame
#import lorelei::camera::{View}

struct HeadLook {
    world_from_head: mat4x4<f32>,
    albedo: vec3<f32>,
    // Weight of the surface's reflection: 1 is skin's.
    gloss: f32,
    // How far around the border of a light red light creeps, as a cosine.
    softness: f32,
    // How much of the light that scalp would send back hair roots and their shadows keep.
    roots: f32,
    // How many times a painted map's texels are scaled up to be shown; 0: none is shown.
    overlay: f32,
    // Pixels of the rasteriser for one of the head, along a side.
    supersampling: u32,
    // 0 where no head is shown.
    n_triangles: u32,
    // Entries of tiles' lists that there is room for.
    n_entries: u32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> head_look: HeadLook;

// Tiles of the picture, along its sides.
fn n_head_tiles(tile: f32) -> vec2<u32> {
    return (view.size + u32(tile) - 1u) / u32(tile);
}
