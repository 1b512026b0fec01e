// Triangles into pixels, by compute.
//
// And not through the graphics pipeline: a GPU made for computing has few units that draw (19,000 triangles with four
// samples a pixel took 3.1 ms at 1920x1080 on an H200).
#define_import_path lorelei::triangle

// Three linear functions of a place in the picture, one of each corner: the corner's share of the place over the place's w
// (Olano and Greer 1997: the inverse of the matrix of the corners' homogeneous pixel coordinates). So they add up to 1 / w,
// none is negative inside, and nothing has to be clipped where corners lie behind the eye.
struct Triangle {
    // Per x, per y, and at `origin`; a number of the origin in w.
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
}

// By how much of itself a triangle is larger, so that no light falls between two.
const SEAM: f32 = 1e-5;

// The pixels that may be touched: (low, high); none where a number of `low` is not below that of `high`.
struct Box {
    low: vec2<f32>,
    high: vec2<f32>,
    // Near the triangle, where nothing of its small size is lost.
    origin: vec2<f32>,
}

// Of corners (pixel x * w, pixel y * w, w) in a picture. Those with w up to `near` lie behind the eye.
fn box_of(p: vec3<f32>, q: vec3<f32>, r: vec3<f32>, near: f32, picture: vec2<f32>) -> Box {
    if max(max(p.z, q.z), r.z) <= near {
        return Box(vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0));
    }
    if min(min(p.z, q.z), r.z) <= near {
        return Box(vec2<f32>(0.0), picture, floor(0.5 * picture));
    }
    let on_p = p.xy / p.z;
    let on_q = q.xy / q.z;
    let on_r = r.xy / r.z;
    let low = max(min(min(on_p, on_q), on_r) - 1.0, vec2<f32>(0.0));
    return Box(low, min(max(max(on_p, on_q), on_r) + 1.0, picture), floor(on_p));
}

fn from_origin(corner: vec3<f32>, origin: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(corner.xy - origin * corner.z, corner.z);
}

// All 0, which nothing is inside of, where it is seen from its edge.
fn triangle_of(corner_p: vec3<f32>, corner_q: vec3<f32>, corner_r: vec3<f32>, origin: vec2<f32>) -> Triangle {
    let p = from_origin(corner_p, origin);
    let q = from_origin(corner_q, origin);
    let r = from_origin(corner_r, origin);
    let of_p = cross(q, r);
    let volume = dot(p, of_p);
    let per_volume = select(1.0 / volume, 0.0, abs(volume) < 1e-20);
    return Triangle(
        vec4<f32>(of_p * per_volume, origin.x),
        vec4<f32>(cross(r, p) * per_volume, origin.y),
        vec4<f32>(cross(p, q) * per_volume, 0.0),
    );
}

// The three functions at a place in pixels.
fn shares_at(triangle: Triangle, place: vec2<f32>) -> vec3<f32> {
    let at = vec3<f32>(place - vec2<f32>(triangle.a.w, triangle.b.w), 1.0);
    return vec3<f32>(dot(triangle.a.xyz, at), dot(triangle.b.xyz, at), dot(triangle.c.xyz, at));
}
