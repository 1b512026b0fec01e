// What the inspector finds under a pixel. Twin of render/src/inspect.rs.
#define_import_path lorelei::inspect_result

// 0: the place on the strand (w: view depth; 0 where there is no strand). 1: the tangent (w: share of the length).
// 2: layer, strand, distance from the pixel's middle in pixels, radius in cm. 3: hair, 4: body, 5: display.
// From 8: radiance by term. From 24: per light optical depth of the hair and what gets past the head. From 40:
// radiance by light.
@group(0) @binding(auto) var<storage, read_write> inspected: array<vec4<f32>>;

const PLACE: u32 = 0u;
const TANGENT: u32 = 1u;
const STRAND: u32 = 2u;
const HAIR: u32 = 3u;
const BODY: u32 = 4u;
const DISPLAY: u32 = 5u;
const DEPTHS: u32 = 24u;
const MOST_LIGHTS: u32 = 16u;
