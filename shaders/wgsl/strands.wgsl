// Vertices and seeds of all drawn strands.
#define_import_path lorelei::strands

// World position and radius, centimetres.
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// A random number of each strand.
// Of each strand its seed, and the bits of the share of its material's dye that it takes.
@group(0) @binding(auto) var<storage, read> seeds: array<vec2<u32>>;

// A place across a fibre that means "averaged over its width".
const NO_OFFSET: f32 = 2.0;

// Half width in pixels from which a pixel has a place of its own across a fibre. With fewer than four of them side by side,
// whether one lies on a lobe's peak changes along the fibre: it glitters where its average does not.
const NEAR: f32 = 2.0;

// The place across a fibre, -1 to 1, of a pixel that lies so many pixels from its middle.
fn offset_of(across: f32, half_width: f32) -> f32 {
    return select(NO_OFFSET, clamp(across / max(half_width, 1e-6), -1.0, 1.0), half_width >= NEAR);
}
