// Strands from guides: the twin of core/src/generate/, function by function.
//
// One thread makes one strand from root to tip. It carries the twist-free frame, the arc length and, for its own
// path and for its clumps' middles, the four blended control points around the present parameter: each control
// point is blended once, not once for every vertex that it shapes.
//
// On a GPU with many threads control points are blended before, one thread each (MAKES_PATHS), and strands only read them
// (READS_PATHS): a clump's middle is then blended once and not by each of its strands.

#import lorelei::hash::{combine, random, unit}

struct Params {
    // Rows of the rotation (and scale) and the translation.
    world_from_head: mat3x4<f32>,
    head_from_world: mat3x4<f32>,
    // The identity where the guides are in world space already.
    world_from_guides: mat3x4<f32>,
    field_min: vec3<f32>,
    field_cell: f32,
    // Nodes of the head's distance field; x is 0 where there is none.
    field_n: vec3<u32>,
    n_drawn: u32,
    n_vertices: u32,
    guide_vertices: u32,
    first_vertex: u32,
    n_ops: u32,
    n_sizes: u32,
    // Centimetres at the root.
    radius: f32,
    tip_radius: f32,
    offset_at_tip: f32,
    lod_scale: f32,
    lod_end: f32,
    lod_fade: f32,
    // Index of the operator that irons the path; NONE where there is none.
    smooth_op: u32,
    // Which of a strand's clump middles its wisp is around; NONE where strands are on their own.
    wisp_size: u32,
    n_maps: u32,
    // Which painted map says how long and how wide a strand is; NONE where none was painted.
    length_map: u32,
    width_map: u32,
    // Painted maps of the two levels of detail that are blended, and the share of the second.
    lod_density_from: u32,
    lod_density_to: u32,
    lod_thickness_from: u32,
    lod_thickness_to: u32,
    lod_between: f32,
    // Sculpt guides; 0 where nothing is sculpted.
    n_sculpt: u32,
    // Strands whose control points are blended before: all of the layer's, as any may be a clump's middle.
    n_paths: u32,
    pad2: u32,
}

struct Strand {
    root_offset: vec3<f32>,
    seed: u32,
    root_normal: vec3<f32>,
    radius_scale: f32,
    first_influence: u32,
    n_influences: u32,
    // Where the parameters of its guides' vertices begin.
    first_knot: u32,
    pad: u32,
}

struct Influence {
    guide_idx: u32,
    weight: f32,
}

// Where a strand goes with one guide: twin of Hit in core/src/generate/single_guide.rs.
struct Hit {
    first: f32,
    amount: f32,
    guide_idx: u32,
    pad: u32,
}

struct Op {
    kind: u32,
    // Which of a strand's clump middles; NONE is the strand itself.
    size_idx: u32,
    seed: u32,
    // A blend, and PER_WISP.
    flags: u32,
    strength: f32,
    at: f32,
    ramp: f32,
    // Where its drawn curve begins in `curves`; NONE where the ramp counts.
    table: u32,
    a: f32,
    b: f32,
    c: f32,
    d: f32,
    e: f32,
    f: f32,
    // Painted maps that scale its strength; NONE.
    map_0: u32,
    map_1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> guides: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> strands: array<Strand>;
@group(0) @binding(3) var<storage, read> influences: array<Influence>;
@group(0) @binding(4) var<storage, read> middles: array<u32>;
@group(0) @binding(5) var<storage, read> ops: array<Op>;
@group(0) @binding(6) var<storage, read> field: array<f32>;
@group(0) @binding(7) var<storage, read_write> vertices: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> knots: array<f32>;
@group(0) @binding(9) var<storage, read> curves: array<f32>;
@group(0) @binding(10) var<storage, read> map_values: array<f32>;
// SCULPT_POINTS for every sculpt guide: an offset, and in w of the first three the guide's length, cut and keep.
// Then two for every strand: its three guides, and their weights.
@group(0) @binding(11) var<storage, read> sculpt: array<vec4<f32>>;

#ifdef MAKES_PATHS
// Control points of the paths, world space: `guide_vertices` for every strand.
@group(0) @binding(12) var<storage, read_write> paths: array<vec4<f32>>;
#endif
#ifdef READS_PATHS
@group(0) @binding(12) var<storage, read> paths: array<vec4<f32>>;
#endif

#ifdef FINDS_HITS
@group(0) @binding(13) var<storage, read_write> hits: array<Hit>;
@group(0) @binding(14) var<storage, read> rest_guides: array<vec4<f32>>;
#endif
#ifdef READS_HITS
@group(0) @binding(13) var<storage, read> hits: array<Hit>;
// At rest, head space.
@group(0) @binding(14) var<storage, read> rest_guides: array<vec4<f32>>;
#endif

// LodBlend: how many times wider a strand gets, at most, where a painted map took its neighbours away.
const MOST_WIDER: f32 = 4.0;
const NONE: u32 = 0xFFFFFFFFu;

// 0: a kernel for styles of lengths, clumps, waves, curls, frizz and deviations alone, without drawn curves, painted
// maps, wisps or blends. Software drivers compute both sides of every branch, and so would pay for all of it.
override FULL: u32 = 1u;

// Those up to WISP cut or pull a strand, those from WISP turn or displace it.
const LENGTH: u32 = 0u;
const CLUMP: u32 = 1u;
const WISP: u32 = 2u;
const WAVE: u32 = 3u;
const CURL: u32 = 4u;
const FRIZZ: u32 = 5u;
const DEVIATE: u32 = 6u;
const SMOOTH: u32 = 7u;
const BEND: u32 = 8u;
const PART: u32 = 9u;

// Flags of an operator.
const BLEND: u32 = 3u;
const ADD: u32 = 0u;
const REPLACE: u32 = 1u;
const MODULATE: u32 = 2u;
const PER_WISP: u32 = 4u;

// Samples of a drawn curve.
const N_TABLE: u32 = 33u;
const WISP_FEATURE: f32 = 3.0;
const PART_EDGE: f32 = 0.1;

const BLENDING_ZONE: f32 = 4.0;
const TOUCHING: f32 = 0.01;
const FULL_DEPTH: f32 = 0.2;

const KEEP_OUT: f32 = 0.3;
const GROW_OUT: f32 = 2.0;
const TAPER: f32 = 0.1;
const TAU: f32 = 6.283185307179586;

const FOR_LENGTH: u32 = 1u;
const FOR_STRAY: u32 = 2u;
const FOR_LOOSE_CLUMP: u32 = 3u;
const FOR_PHASE: u32 = 4u;
const FOR_PERIOD: u32 = 5u;
const FOR_SIDE: u32 = 6u;
const FOR_SIZE: u32 = 7u;
const FOR_NOISE: u32 = 8u;
const FOR_SHARE: u32 = 9u;
const FOR_START: u32 = 10u;
const FOR_KEEP_OUT: u32 = 11u;
const FOR_FUZZ: u32 = 12u;
const FOR_KEEP: u32 = 64u;

const SCULPT_POINTS: u32 = 16u;
const SLID: f32 = 1e-5;

// A path with its four control points around the present segment.
struct Curve {
    // Influence; or control point, where those are blended already.
    first: u32,
    n_influences: u32,
#ifdef READS_HITS
    hit: Hit,
#endif
    // How strongly it is ironed.
    ironing: f32,
    // Root offset in world space.
    offset: vec3<f32>,
    p0: vec3<f32>,
    p1: vec3<f32>,
    p2: vec3<f32>,
    p3: vec3<f32>,
}

// What brushes did to a strand, with the four offsets around the present part of its path; the root's frame.
struct Sculpted {
    guides: vec3<u32>,
    weights: vec3<f32>,
    length: f32,
    cut: f32,
    keep: f32,
    segment: u32,
    p0: vec3<f32>,
    p1: vec3<f32>,
    p2: vec3<f32>,
    p3: vec3<f32>,
}

struct Pull {
    strength: f32,
    at: f32,
    ramp: f32,
    table: u32,
    flare: f32,
    gather: f32,
    follow: f32,
    // 1 where its middle was drawn by the clumps before, else 0.
    nested: f32,
}

// A strand's own numbers in one operator.
struct Shape {
    op: u32,
    seed: u32,
    strength: f32,
    at: f32,
    away: f32,
    numbers: vec4<f32>,
}

// The frame that a strand starts with, and its root; world space.
struct RootFrame {
    root: vec3<f32>,
    outwards: vec3<f32>,
    side: vec3<f32>,
    up: vec3<f32>,
}

const MOST_DISPLACING_OPS: u32 = 12u;

fn rotate(m: mat3x4<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(m[0].xyz, v), dot(m[1].xyz, v), dot(m[2].xyz, v));
}

fn move_point(m: mat3x4<f32>, p: vec3<f32>) -> vec3<f32> {
    return rotate(m, p) + vec3<f32>(m[0].w, m[1].w, m[2].w);
}

fn normalize_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    return select(other, v * inverseSqrt(squared), squared > 1e-24);
}

fn smooth_step(low: f32, high: f32, at: f32) -> f32 {
    let x = clamp((at - low) / (high - low), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

fn table_at(table: u32, x: f32) -> f32 {
    let at = clamp(x, 0.0, 1.0) * f32(N_TABLE - 1u);
    let sample = min(u32(at), N_TABLE - 2u);
    let low = curves[table + sample];
    return low + (at - f32(sample)) * (curves[table + sample + 1u] - low);
}

fn envelope(strength: f32, at: f32, ramp: f32, table: u32, t: f32) -> f32 {
    if t < at {
        return 0.0;
    }
    if FULL != 0u && table != NONE {
        return strength * table_at(table, (t - at) / max(1.0 - at, 1e-4));
    }
    if ramp <= 0.0 {
        return strength;
    }
    let x = clamp((t - at) / max(1.0 - at, 1e-4), 0.0, 1.0);
    return strength * select(0.0, pow(max(x, 1e-20), ramp), x > 0.0);
}

fn pull_at(pull: Pull, t: f32) -> f32 {
    if FULL != 0u && pull.gather > 0.0 {
        return pull.strength * smooth_step(0.0, pull.gather, t);
    }
    let x = clamp((t - 0.6) / 0.4, 0.0, 1.0);
    return envelope(pull.strength, pull.at, pull.ramp, pull.table, t) * (1.0 - pull.flare * x * x);
}

fn purpose(name: u32, op_seed: u32) -> u32 {
    return combine(op_seed, name);
}

fn middle_of(strand_idx: u32, size_idx: u32) -> u32 {
    if size_idx == NONE {
        return strand_idx;
    }
    return middles[strand_idx * params.n_sizes + size_idx];
}

// A strand whose numbers count for an operator: before a wisp that is the wisp's middle.
fn bearer_of(strand_idx: u32, flags: u32) -> u32 {
    if FULL != 0u && (flags & PER_WISP) != 0u {
        return middle_of(strand_idx, params.wisp_size);
    }
    return strand_idx;
}

// What a painted map says at a strand's root.
fn map_value(strand_idx: u32, map_idx: u32) -> f32 {
    if FULL == 0u || map_idx == NONE {
        return 1.0;
    }
    return map_values[strand_idx * params.n_maps + map_idx];
}

// What the maps of the levels of detail say of a strand: the share of its neighbours that is left, and how many times
// wider it is. Twin of LodBlend::painted.
fn lod_painted(strand_idx: u32) -> vec2<f32> {
    let between = params.lod_between;
    let kept = map_value(strand_idx, params.lod_density_from) * (1.0 - between)
        + map_value(strand_idx, params.lod_density_to) * between;
    let thickness = map_value(strand_idx, params.lod_thickness_from) * (1.0 - between)
        + map_value(strand_idx, params.lod_thickness_to) * between;
    return vec2<f32>(kept, thickness * min(1.0 / max(kept, 1e-3), MOST_WIDER));
}

// How strong an operator is on a strand: painted maps say where it acts.
fn strength_of(strand_idx: u32, i: u32) -> f32 {
    if FULL == 0u {
        return ops[i].strength;
    }
    let share = min(map_value(strand_idx, ops[i].map_0), 1.0) * min(map_value(strand_idx, ops[i].map_1), 1.0);
    return ops[i].strength * share;
}

// How far control point i goes with the one guide.
fn share_of(hit: Hit, i: u32) -> f32 {
    return hit.amount * clamp((f32(i) - hit.first) / BLENDING_ZONE + 1.0, 0.0, 1.0);
}

fn blended(curve: ptr<function, Curve>, i: u32) -> vec3<f32> {
    var p = vec3<f32>(0.0);
    let first = (*curve).first;
    for (var k = first; k < first + (*curve).n_influences; k++) {
        let influence = influences[k];
        p += influence.weight * guides[influence.guide_idx * params.guide_vertices + i].xyz;
    }
#ifdef READS_HITS
    let share = share_of((*curve).hit, i);
    if share > 0.0 {
        // Where the strand rests beside its strongest guide, and that guide now.
        let of_guide = (*curve).hit.guide_idx * params.guide_vertices + i;
        var beside = -rest_guides[of_guide].xyz;
        for (var k = first; k < first + (*curve).n_influences; k++) {
            let influence = influences[k];
            beside += influence.weight * rest_guides[influence.guide_idx * params.guide_vertices + i].xyz;
        }
        p += share * (guides[of_guide].xyz + rotate(params.world_from_head, beside) - p);
    }
#endif
    return p;
}

#ifdef IRONS
// A mean with falling weights over the neighbours; beyond its ends the chain is mirrored in them.
fn ironed(curve: ptr<function, Curve>, i: u32, p: vec3<f32>) -> vec3<f32> {
    let op = ops[params.smooth_op];
    let last = params.guide_vertices - 1u;
    let strength = clamp(envelope((*curve).ironing, op.at, op.ramp, op.table, f32(i) / f32(last)), 0.0, 1.0);
    let reach = op.a * f32(last);
    var sum = p;
    var total = 1.0;
    for (var k = 1u; k <= last && f32(k) < reach; k++) {
        let weight = 1.0 - f32(k) / reach;
        if k <= i {
            sum += weight * blended(curve, i - k);
        } else {
            sum += weight * (2.0 * blended(curve, 0u) - blended(curve, k - i));
        }
        if i + k <= last {
            sum += weight * blended(curve, i + k);
        } else {
            sum += weight * (2.0 * blended(curve, last) - blended(curve, 2u * last - i - k));
        }
        total += 2.0 * weight;
    }
    return p + strength * (sum / total - p);
}
#endif

// Control point i of a path.
fn control(curve: ptr<function, Curve>, i: u32) -> vec3<f32> {
#ifdef READS_PATHS
    return paths[(*curve).first + i].xyz;
#else
    var p = blended(curve, i);
#ifdef IRONS
    p = ironed(curve, i, p);
#endif
    let x = f32(i) / f32(params.guide_vertices - 1u);
    let left = 1.0 - smooth_step(0.0, 1.0, x) * (1.0 - params.offset_at_tip);
    return move_point(params.world_from_guides, p) + left * (*curve).offset;
#endif
}

// Whose path a curve is.
fn find(curve: ptr<function, Curve>, strand_idx: u32) {
#ifdef READS_PATHS
    (*curve).first = strand_idx * params.guide_vertices;
#else
    (*curve).first = strands[strand_idx].first_influence;
    (*curve).n_influences = strands[strand_idx].n_influences;
    if FULL != 0u && params.smooth_op != NONE {
        (*curve).ironing = strength_of(strand_idx, params.smooth_op);
    }
    (*curve).offset = rotate(params.world_from_head, strands[strand_idx].root_offset);
#ifdef READS_HITS
    (*curve).hit = hits[strand_idx];
#endif
#endif
}

// Set a curve to its first segment.
fn begin(curve: ptr<function, Curve>, strand_idx: u32) {
    find(curve, strand_idx);
    (*curve).p1 = control(curve, 0u);
    (*curve).p2 = control(curve, 1u);
    (*curve).p0 = 2.0 * (*curve).p1 - (*curve).p2;
    if params.guide_vertices > 2u {
        (*curve).p3 = control(curve, 2u);
    } else {
        (*curve).p3 = 2.0 * (*curve).p2 - (*curve).p1;
    }
}

// Where a strand grows, world space.
fn root_of(strand_idx: u32) -> vec3<f32> {
    var curve: Curve;
    find(&curve, strand_idx);
    return control(&curve, 0u);
}

// Go on to a segment, the next one.
fn advance(curve: ptr<function, Curve>, segment: u32) {
    (*curve).p0 = (*curve).p1;
    (*curve).p1 = (*curve).p2;
    (*curve).p2 = (*curve).p3;
    if segment + 2u < params.guide_vertices {
        (*curve).p3 = control(curve, segment + 2u);
    } else {
        (*curve).p3 = 2.0 * (*curve).p2 - (*curve).p1;
    }
}

fn catmull_rom_weights(x: f32) -> vec4<f32> {
    let x2 = x * x;
    let x3 = x2 * x;
    return vec4<f32>(
        0.5 * (-x + 2.0 * x2 - x3),
        0.5 * (2.0 - 5.0 * x2 + 3.0 * x3),
        0.5 * (x + 4.0 * x2 - 3.0 * x3),
        0.5 * (x3 - x2),
    );
}

fn path(curve: ptr<function, Curve>, w: vec4<f32>) -> vec3<f32> {
    return w.x * (*curve).p0 + w.y * (*curve).p1 + w.z * (*curve).p2 + w.w * (*curve).p3;
}

// A unit vector across the normal: X turned by the shortest way that takes Y to the normal.
fn any_tangent(normal: vec3<f32>) -> vec3<f32> {
    let across = vec3<f32>(1.0, 0.0, 0.0) - normal.x / max(1.0 + normal.y, 1e-3) * (vec3<f32>(0.0, 1.0, 0.0) + normal);
    return normalize_or(across, vec3<f32>(1.0, 0.0, 0.0));
}

// One plus the cosine of a turn back, 154 degrees: about which axis a strand turns beyond it is rounding more and more.
const TURNED_BACK: f32 = 0.1;

// Carry a vector across a strand from one tangent to the next by the shortest rotation: no twist. Where the strand turns
// back the rotation fades out, and the vector stays what it was as far as it lies across the strand.
fn transport(right: vec3<f32>, before: vec3<f32>, to: vec3<f32>) -> vec3<f32> {
    let carried = right - dot(right, to) / max(1.0 + dot(before, to), TURNED_BACK) * (before + to);
    return normalize_or(carried - dot(carried, to) * to, right);
}

fn sin_turns(turns: f32) -> f32 {
    let x = turns - floor(turns) - 0.5;
    return -sin(TAU * x);
}

fn gradient(seed: u32, cell: i32) -> f32 {
    return 2.0 * unit(combine(seed, bitcast<u32>(cell))) - 1.0;
}

fn gradient_noise(seed: u32, x: f32) -> f32 {
    let cell = floor(x);
    let f = x - cell;
    let a = gradient(seed, i32(cell)) * f;
    let b = gradient(seed, i32(cell) + 1) * (f - 1.0);
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    return 2.0 * (a + fade * (b - a));
}

fn noise(seed: u32, x: f32) -> f32 {
    return gradient_noise(seed, x) + 0.5 * gradient_noise(combine(seed, 2u), 2.0 * x + 0.37);
}

// The strand's own numbers in one operator that turns or displaces it; false where it does not.
fn shape_of(strand_idx: u32, i: u32, frame: RootFrame, shape: ptr<function, Shape>) -> bool {
    let op = ops[i];
    let bearer = bearer_of(strand_idx, op.flags);
    let seed = strands[bearer].seed;
    let middle = middle_of(bearer, op.size_idx);
    let clump = strands[middle].seed;
    (*shape).op = i;
    (*shape).strength = strength_of(strand_idx, i);
    (*shape).at = op.at;
    (*shape).away = 0.0;
    (*shape).seed = combine(clump, purpose(FOR_NOISE, op.seed));
    switch op.kind {
        case WAVE: {
            let angle = (random(clump, purpose(FOR_SIDE, op.seed)) - 0.5) * 2.0;
            let size = op.a * (0.7 + 0.6 * random(clump, purpose(FOR_SIZE, op.seed)));
            let period = max(op.b, 0.05) * (0.85 + 0.3 * random(clump, purpose(FOR_PERIOD, op.seed)));
            let phase = random(clump, purpose(FOR_PHASE, op.seed));
            (*shape).numbers = vec4<f32>(period, phase, size * cos(angle), size * sin(angle));
            return true;
        }
        case CURL: {
            let hand = select(1.0, -1.0, random(clump, purpose(FOR_SIDE, op.seed)) < 0.5);
            let period = max(op.b, 0.05) * (0.85 + 0.3 * random(clump, purpose(FOR_PERIOD, op.seed)));
            let phase = random(clump, purpose(FOR_PHASE, op.seed));
            let size = op.a * (0.8 + 0.4 * random(clump, purpose(FOR_SIZE, op.seed)));
            (*shape).numbers = vec4<f32>(period, phase, hand, size);
            return true;
        }
        case FRIZZ: {
            (*shape).numbers = vec4<f32>(max(op.b, 0.05), 0.0, op.a, 0.0);
            return true;
        }
        case DEVIATE: {
            if random(seed, purpose(FOR_SHARE, op.seed)) >= op.a {
                return false;
            }
            let late = 0.7 * (1.0 - op.d) * (1.0 - op.at);
            (*shape).at = op.at + late * random(seed, purpose(FOR_START, op.seed));
            let size = op.b * (0.3 + 0.7 * random(seed, purpose(FOR_SIZE, op.seed)));
            let around = size * (1.0 - abs(op.c));
            let turns = random(seed, purpose(FOR_SIDE, op.seed));
            (*shape).away = size * op.c;
            (*shape).numbers = vec4<f32>(0.0, 0.0, around * sin_turns(turns + 0.25), around * sin_turns(turns));
            return true;
        }
        case WISP: {
            if FULL == 0u {
                return false;
            }
            let from_middle = frame.root - root_of(middle);
            let x = dot(from_middle, frame.side);
            let y = dot(from_middle, frame.up);
            let apart = max(sqrt(x * x + y * y), 1e-6);
            let far = random(seed, purpose(FOR_FUZZ, op.seed));
            let size = op.a * sqrt(random(seed, purpose(FOR_SIZE, op.seed))) * (1.0 + 2.0 * op.c * far * far * far * far);
            (*shape).seed = combine(seed, purpose(FOR_NOISE, op.seed));
            (*shape).away = 0.7 + 0.6 * random(seed, purpose(FOR_PERIOD, op.seed));
            (*shape).numbers = vec4<f32>(0.0, 0.0, size * x / apart, size * y / apart);
            return true;
        }
        case SMOOTH: {
            (*shape).numbers = vec4<f32>(0.0);
            return true;
        }
        case BEND: {
            if FULL == 0u {
                return false;
            }
            let on_head = rotate(params.world_from_head, vec3<f32>(op.a, op.b, op.c));
            let towards = normalize_or(on_head + op.d * (vec3<f32>(0.0, -1.0, 0.0) - on_head), on_head);
            (*shape).strength *= 1.0 - op.e * random(clump, purpose(FOR_SIZE, op.seed));
            (*shape).numbers = vec4<f32>(towards, 0.0);
            return true;
        }
        case PART: {
            if FULL == 0u {
                return false;
            }
            let normal = vec3<f32>(op.a, op.b, op.c);
            let distance = dot(move_point(params.head_from_world, frame.root), normal) - op.d;
            let away_from_line = rotate(params.world_from_head, select(1.0, -1.0, distance < 0.0) * normal);
            let along = away_from_line - dot(away_from_line, frame.outwards) * frame.outwards;
            (*shape).strength *= smooth_step(0.0, PART_EDGE, abs(distance))
                * (1.0 - smooth_step(0.0, 1.0, abs(distance) / max(op.e, 0.01)));
            (*shape).numbers = vec4<f32>(normalize_or(along, away_from_line), 0.0);
            return true;
        }
        default: {
            return false;
        }
    }
}

// The displacement across the strand (right, up) and away from the head (z) so far, and one operator's.
fn displaced(offset: vec3<f32>, shape: Shape, t: f32, arc_length: f32) -> vec3<f32> {
    let op = ops[shape.op];
    if op.kind >= BEND {
        return offset;
    }
    let weight = envelope(shape.strength, shape.at, op.ramp, op.table, t);
    let a = shape.numbers.x;
    let phase = shape.numbers.y;
    var full = vec3<f32>(0.0);
    var swing = 0.0;
    switch op.kind {
        case SMOOTH: {
            return (1.0 - clamp(weight, 0.0, 1.0)) * offset;
        }
        case WAVE: {
            swing = smooth_step(0.0, 0.5 * a, arc_length) * sin_turns(phase + arc_length / a);
            full = swing * vec3<f32>(shape.numbers.zw, 0.0);
        }
        case CURL: {
            let turns = phase + shape.numbers.z * arc_length / (a * (1.0 + 0.5 * op.c * t));
            let grown = smooth_step(0.0, a, arc_length);
            let size = shape.numbers.w * (1.0 + op.c * t) * grown;
            let sine = sin_turns(turns);
            full = size * vec3<f32>(sin_turns(turns + 0.25), sine, 0.0);
            swing = grown * sine;
        }
        case FRIZZ: {
            let along = arc_length / a;
            let grown = smooth_step(0.0, 1.0, along);
            swing = grown * noise(shape.seed, along);
            full = shape.numbers.z * vec3<f32>(swing, grown * noise(combine(shape.seed, 1u), along), 0.0);
        }
        case WISP: {
            if FULL == 0u {
                return offset;
            }
            let along = arc_length / WISP_FEATURE;
            let wander = op.c * op.a * vec2<f32>(noise(shape.seed, along), noise(combine(shape.seed, 1u), along));
            let turns = shape.away * op.d * t;
            let s = sin_turns(turns);
            let c = sin_turns(turns + 0.25);
            let place = shape.numbers.zw;
            let about = vec2<f32>(c * place.x - s * place.y, s * place.x + c * place.y);
            full = vec3<f32>(smooth_step(0.0, max(op.b, 1e-3), t) * (about + wander), 0.0);
        }
        default: {
            full = vec3<f32>(shape.numbers.zw, shape.away);
        }
    }
    if FULL == 0u {
        return offset + weight * full;
    }
    switch op.flags & BLEND {
        case REPLACE: {
            return offset + weight * (full - offset);
        }
        case MODULATE: {
            return (1.0 + weight * swing) * offset;
        }
        default: {
            return offset + weight * full;
        }
    }
}

// Turn a direction of the path as one bend or parting says.
fn turned(along: vec3<f32>, shape: Shape, t: f32) -> vec3<f32> {
    let op = ops[shape.op];
    if op.kind < BEND {
        return along;
    }
    let weight = clamp(envelope(shape.strength, shape.at, op.ramp, op.table, t), 0.0, 1.0);
    return normalize_or(along + weight * (shape.numbers.xyz - along), along);
}

fn sculpt_blend(s: ptr<function, Sculpted>, point: u32) -> vec4<f32> {
    return (*s).weights.x * sculpt[(*s).guides.x * SCULPT_POINTS + point]
        + (*s).weights.y * sculpt[(*s).guides.y * SCULPT_POINTS + point]
        + (*s).weights.z * sculpt[(*s).guides.z * SCULPT_POINTS + point];
}

// A strand's blend of guides, set to its first part; false where no guide is near.
fn sculpt_begin(s: ptr<function, Sculpted>, strand_idx: u32) -> bool {
    let at = params.n_sculpt * SCULPT_POINTS + 2u * strand_idx;
    (*s).guides = bitcast<vec3<u32>>(sculpt[at].xyz);
    (*s).weights = sculpt[at + 1u].xyz;
    if (*s).weights.x <= 0.0 && (*s).weights.y <= 0.0 && (*s).weights.z <= 0.0 {
        return false;
    }
    let first = sculpt_blend(s, 0u);
    let second = sculpt_blend(s, 1u);
    let third = sculpt_blend(s, 2u);
    (*s).length = first.w;
    (*s).cut = second.w;
    (*s).keep = third.w;
    (*s).segment = 0u;
    (*s).p1 = first.xyz;
    (*s).p2 = second.xyz;
    (*s).p3 = third.xyz;
    (*s).p0 = 2.0 * first.xyz - second.xyz;
    return true;
}

// Displacement at parameter t of the path, not before the last one asked for; the root's frame.
fn sculpt_offset(s: ptr<function, Sculpted>, t: f32) -> vec3<f32> {
    let u = t * f32(SCULPT_POINTS - 1u);
    let wanted = min(u32(u), SCULPT_POINTS - 2u);
    while (*s).segment < wanted {
        (*s).segment++;
        (*s).p0 = (*s).p1;
        (*s).p1 = (*s).p2;
        (*s).p2 = (*s).p3;
        if (*s).segment + 2u < SCULPT_POINTS {
            (*s).p3 = sculpt_blend(s, (*s).segment + 2u).xyz;
        } else {
            (*s).p3 = 2.0 * (*s).p2 - (*s).p1;
        }
    }
    let w = catmull_rom_weights(u - f32((*s).segment));
    return w.x * (*s).p0 + w.y * (*s).p1 + w.z * (*s).p2 + w.w * (*s).p3;
}

// Gradient in cells and, in w, the distance, at a node's coordinates inside the field.
fn sample_field(inside: vec3<f32>) -> vec4<f32> {
    let base = min(vec3<u32>(inside), params.field_n - 2u);
    let t = inside - vec3<f32>(base);
    let at = field_index(base);
    let dy = params.field_n.x;
    let dz = params.field_n.x * params.field_n.y;
    let c0 = vec4<f32>(field[at], field[at + 1u], field[at + dy], field[at + dy + 1u]);
    let c1 = vec4<f32>(field[at + dz], field[at + dz + 1u], field[at + dz + dy], field[at + dz + dy + 1u]);
    let y0 = mix(mix(c0.x, c0.y, t.x), mix(c0.z, c0.w, t.x), t.y);
    let y1 = mix(mix(c1.x, c1.y, t.x), mix(c1.z, c1.w, t.x), t.y);
    let gradient = vec3<f32>(
        mix(mix(c0.y - c0.x, c0.w - c0.z, t.y), mix(c1.y - c1.x, c1.w - c1.z, t.y), t.z),
        mix(mix(c0.z - c0.x, c0.w - c0.y, t.x), mix(c1.z - c1.x, c1.w - c1.y, t.x), t.z),
        mix(mix(c1.x - c0.x, c1.y - c0.y, t.x), mix(c1.z - c0.z, c1.w - c0.w, t.x), t.y),
    );
    return vec4<f32>(gradient, mix(y0, y1, t.z));
}

// A root that was slid along the scalp, on it again.
fn onto_scalp(p: vec3<f32>) -> vec3<f32> {
    if params.field_n.x == 0u {
        return p;
    }
    let in_head = move_point(params.head_from_world, p);
    let in_cells = (in_head - params.field_min) / params.field_cell;
    let inside = clamp(in_cells, vec3<f32>(0.0), vec3<f32>(params.field_n - 1u));
    let sample = sample_field(inside);
    let distance = sample.w + length(in_cells - inside) * params.field_cell;
    return move_point(params.world_from_head, in_head - distance * normalize_or(sample.xyz, vec3<f32>(0.0)));
}

fn field_index(node: vec3<u32>) -> u32 {
    return node.x + params.field_n.x * (node.y + params.field_n.y * node.z);
}

// Push a vertex out of the head, squeezing the distances below the margin in their order.
fn keep_out(p: vec3<f32>, arc_length: f32, seed: u32) -> vec3<f32> {
#ifdef FREE
    return p;
#else
    if params.field_n.x == 0u {
        return p;
    }
    let in_head = move_point(params.head_from_world, p);
    let margin = KEEP_OUT * (0.5 + random(seed, FOR_KEEP_OUT)) * smooth_step(0.0, GROW_OUT, arc_length) + 1e-3;
    let in_cells = (in_head - params.field_min) / params.field_cell;
    let inside = clamp(in_cells, vec3<f32>(0.0), vec3<f32>(params.field_n - 1u));
    let outside = length(in_cells - inside) * params.field_cell;
    if outside >= margin {
        return p;
    }
    let sample = sample_field(inside);
    let distance = sample.w + outside;
    if distance >= margin {
        return p;
    }
    let wanted = margin * exp(distance / margin - 1.0);
    let out = normalize_or(sample.xyz, vec3<f32>(0.0));
    return move_point(params.world_from_head, in_head + (wanted - distance) * out);
#endif
}

#ifdef FINDS_HITS
// Distance from the head, head space.
fn field_distance(p: vec3<f32>) -> f32 {
    let in_cells = (p - params.field_min) / params.field_cell;
    let inside = clamp(in_cells, vec3<f32>(0.0), vec3<f32>(params.field_n - 1u));
    return sample_field(inside).w + length(in_cells - inside) * params.field_cell;
}

// The first control point of a strand that is deeper in the head than it rests.
@compute @workgroup_size(64)
fn find_hits(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let strand_idx = id.x + id.y * n_groups.x * 64u;
    if strand_idx >= params.n_paths {
        return;
    }
    let n = params.guide_vertices;
    let strand = strands[strand_idx];
    var strongest = Hit(0.0, 0.0, 0u, 0u);
    var most = -1e30;
    for (var k = strand.first_influence; k < strand.first_influence + strand.n_influences; k++) {
        if influences[k].weight > most {
            most = influences[k].weight;
            strongest.guide_idx = influences[k].guide_idx;
        }
    }
    var deepest = 0.0;
    var before = 0.0;
    var is_hit = false;
    for (var i = 0u; i < n; i++) {
        let left = 1.0 - smooth_step(0.0, 1.0, f32(i) / f32(n - 1u)) * (1.0 - params.offset_at_tip);
        let offset = left * strand.root_offset;
        var p = vec3<f32>(0.0);
        var at_rest = vec3<f32>(0.0);
        for (var k = strand.first_influence; k < strand.first_influence + strand.n_influences; k++) {
            let influence = influences[k];
            p += influence.weight * guides[influence.guide_idx * n + i].xyz;
            at_rest += influence.weight * rest_guides[influence.guide_idx * n + i].xyz;
        }
        var clearance = field_distance(move_point(params.head_from_world, p) + offset);
        if clearance < 0.0 {
            clearance -= min(field_distance(at_rest + offset), 0.0);
        }
        clearance += TOUCHING;
        if clearance < 0.0 {
            if !is_hit {
                is_hit = true;
                let above = select(1.0, before / (before - clearance), before > 0.0);
                strongest.first = f32(i) - 1.0 + above;
            }
            deepest = max(deepest, -clearance);
        }
        before = clearance;
    }
    strongest.amount = smooth_step(0.0, FULL_DEPTH, deepest);
    hits[strand_idx] = strongest;
}
#endif

#ifdef MAKES_PATHS
@compute @workgroup_size(64)
fn make_paths(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    let strand_idx = item / params.guide_vertices;
    if strand_idx >= params.n_paths {
        return;
    }
    var curve: Curve;
    find(&curve, strand_idx);
    paths[item] = vec4<f32>(control(&curve, item % params.guide_vertices), 0.0);
}
#endif

@compute @workgroup_size(64)
fn generate(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let strand_idx = id.x + id.y * n_groups.x * 64u;
    if strand_idx >= params.n_drawn {
        return;
    }
    let seed = strands[strand_idx].seed;

    // The strand's length and its pulls.
    var cut = 1.0;
    let painted = min(map_value(strand_idx, params.length_map), 1.0);
    var n_pulls = 0u;
    var pull_0: Pull;
    var pull_1: Pull;
    var pull_2: Pull;
    var middle_0: Curve;
    var middle_1: Curve;
    var middle_2: Curve;
    for (var i = 0u; i < params.n_ops; i++) {
        let op = ops[i];
        if op.kind > WISP {
            continue;
        }
        let bearer = bearer_of(strand_idx, op.flags);
        let middle = middle_of(bearer, op.size_idx);
        let strength = strength_of(strand_idx, i);
        if op.kind == LENGTH {
            let kept = 1.0 - strength * clamp(op.a, 0.0, 0.98) * random(strands[middle].seed, purpose(FOR_LENGTH, op.seed));
            cut = select(cut * kept, kept, (op.flags & BLEND) == REPLACE);
            continue;
        }
        var pull: Pull;
        if FULL != 0u && op.kind == WISP {
            cut *= 1.0 - strength * clamp(op.e, 0.0, 0.98) * random(seed, purpose(FOR_LENGTH, op.seed));
            pull = Pull(strength, 0.0, 0.0, NONE, 0.0, max(op.b, 1e-3), 1.0, 1.0);
        } else {
            let stray = random(strands[bearer].seed, purpose(FOR_STRAY, op.seed));
            let loose = random(strands[middle].seed, purpose(FOR_LOOSE_CLUMP, op.seed));
            let nested = select(1.0, 0.0, (op.flags & BLEND) == REPLACE);
            let follow = 1.0 - op.b * stray * stray;
            pull = Pull(strength * (1.0 - 0.5 * op.b * loose), op.at, op.ramp, op.table, op.a, 0.0, follow, nested);
        }
        if n_pulls == 0u {
            pull_0 = pull;
            begin(&middle_0, middle);
        } else if n_pulls == 1u {
            pull_1 = pull;
            begin(&middle_1, middle);
        } else if n_pulls == 2u {
            pull_2 = pull;
            begin(&middle_2, middle);
        }
        n_pulls = min(n_pulls + 1u, 3u);
    }
    cut *= painted;
    var own: Curve;
    begin(&own, strand_idx);
    let out_at = params.first_vertex + strand_idx * params.n_vertices;
    var sculpted: Sculpted;
    var is_sculpted = false;
    if FULL != 0u && params.n_sculpt > 0u {
        is_sculpted = sculpt_begin(&sculpted, strand_idx);
    }
    if is_sculpted {
        if random(seed, FOR_KEEP) >= sculpted.keep {
            for (var v = 0u; v < params.n_vertices; v++) {
                vertices[out_at + v] = vec4<f32>(own.p1, 0.0);
            }
            return;
        }
        cut *= sculpted.cut;
    }
    // The strands of a wisp share its frame.
    let normal_in_head = strands[middle_of(strand_idx, params.wisp_size)].root_normal;
    let outwards = rotate(params.world_from_head, normal_in_head);
    var right = rotate(params.world_from_head, any_tangent(normal_in_head));
    let frame = RootFrame(own.p1, outwards, right, cross(outwards, right));
    var shapes: array<Shape, MOST_DISPLACING_OPS>;
    var n_shapes = 0u;
    var n_turns = 0u;
    for (var i = 0u; i < params.n_ops && n_shapes < MOST_DISPLACING_OPS; i++) {
        var shape: Shape;
        if shape_of(strand_idx, i, frame, &shape) {
            shapes[n_shapes] = shape;
            n_shapes++;
            n_turns += select(0u, 1u, ops[i].kind >= BEND);
        }
    }

    var tangent = outwards;
    var before = vec3<f32>(0.0);
    var base = vec3<f32>(0.0);
    // The path before it is turned.
    var clumped = vec3<f32>(0.0);
    var arc_length = 0.0;
    var segment = 0u;
    let last = params.n_vertices - 1u;
    let n_segments = params.guide_vertices - 1u;
    let first_knot = strands[strand_idx].first_knot;
    let of_lod = lod_painted(strand_idx);
    let left = f32(strand_idx) / max(of_lod.x, 1e-6);
    let width = params.lod_scale * clamp((params.lod_end - left) / params.lod_fade, 0.0, 1.0) * of_lod.y;
    let radius =
        params.radius * strands[strand_idx].radius_scale * width * map_value(strand_idx, params.width_map);
    let root_normal = strands[strand_idx].root_normal;
    let root_side = any_tangent(root_normal);
    // Where the style and where brushes put the vertex before, and where it came to be.
    var styled_before = vec3<f32>(0.0);
    var displaced_before = vec3<f32>(0.0);
    var placed = vec3<f32>(0.0);

    // Vertex v is finished when the path at v + 1 is known.
    for (var v = 0u; v <= last + 1u; v++) {
        var after = base;
        if v <= last {
            let t = cut * f32(v) / f32(last);
            while segment + 1u < n_segments && t >= knots[first_knot + segment + 1u] {
                segment++;
                advance(&own, segment);
                if n_pulls > 0u {
                    advance(&middle_0, segment);
                }
                if n_pulls > 1u {
                    advance(&middle_1, segment);
                }
                if n_pulls > 2u {
                    advance(&middle_2, segment);
                }
            }
            let below = knots[first_knot + segment];
            let above = knots[first_knot + segment + 1u];
            let w = catmull_rom_weights(clamp((t - below) / max(above - below, 1e-6), 0.0, 1.0));
            after = path(&own, w);
            if n_pulls > 0u {
                let m_0 = path(&middle_0, w);
                let s_0 = pull_at(pull_0, t);
                after += s_0 * pull_0.follow * (m_0 - after);
                if n_pulls > 1u {
                    var m_1 = path(&middle_1, w);
                    let s_1 = pull_at(pull_1, t);
                    m_1 += pull_1.nested * s_0 * (m_0 - m_1);
                    after += s_1 * pull_1.follow * (m_1 - after);
                    if n_pulls > 2u {
                        var m_2 = path(&middle_2, w);
                        m_2 += pull_2.nested * s_0 * (m_0 - m_2);
                        m_2 += pull_2.nested * s_1 * (m_1 - m_2);
                        after += pull_at(pull_2, t) * pull_2.follow * (m_2 - after);
                    }
                }
            }
        }
        if v == 0u {
            before = after;
            base = after;
            clumped = after;
            continue;
        }
        if FULL != 0u && n_turns > 0u && v <= last {
            let next = after;
            let delta = next - clumped;
            var along = normalize_or(delta, vec3<f32>(0.0));
            for (var i = 0u; i < n_shapes; i++) {
                along = turned(along, shapes[i], f32(v) / f32(last));
            }
            after = base + length(delta) * along;
            clumped = next;
        }
        let vertex = v - 1u;
        arc_length += distance(base, before);
        let new_tangent = normalize_or(after - before, tangent);
        right = transport(right, tangent, new_tangent);
        tangent = new_tangent;
        let up = cross(tangent, right);
        let t = f32(vertex) / f32(last);
        var offset = vec3<f32>(0.0);
        for (var i = 0u; i < n_shapes; i++) {
            offset = displaced(offset, shapes[i], t, arc_length);
        }
        var p = base + offset.x * right + offset.y * up + offset.z * outwards;
        if FULL != 0u && is_sculpted {
            let in_root = sculpt_offset(&sculpted, cut * t);
            let in_head = in_root.x * root_side + in_root.y * cross(root_normal, root_side) + in_root.z * root_normal;
            let styled = p;
            var moved = styled + rotate(params.world_from_head, in_head);
            if vertex == 0u {
                placed = styled;
                if dot(in_root, in_root) > SLID * SLID {
                    placed = onto_scalp(moved);
                }
                moved = placed;
            } else {
                let segment_length = sculpted.length * distance(styled, styled_before);
                placed += segment_length * normalize_or(moved - displaced_before, tangent);
            }
            styled_before = styled;
            displaced_before = moved;
            p = placed;
        }
        if vertex > 0u {
            p = keep_out(p, arc_length, seed);
        }
        let taper = 1.0 + clamp((t - (1.0 - TAPER)) / TAPER, 0.0, 1.0) * (params.tip_radius - 1.0);
        vertices[out_at + vertex] = vec4<f32>(p, radius * taper);
        before = base;
        base = after;
    }
}
