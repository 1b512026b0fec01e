// The air where nothing stands in its way: steady wind, eddies and the streams of sources. Twin of sim/src/wind/free.rs,
// function by function; that file says where the formulas come from.
#define_import_path lorelei::wind_free

struct FreeSource {
    place: vec3<f32>,
    // 0 a fan, 1 a vortex.
    kind: u32,
    // Unit vector.
    direction: vec3<f32>,
    radius: f32,
    // Where its eddies have drifted to, in periods.
    drift: vec3<f32>,
    // Periods of its eddies in a centimetre.
    per_period: f32,
    // cm/s, gusts included.
    speed: f32,
    falloff: f32,
    // Root mean square of the eddies as a share of the speed.
    rough: f32,
}

struct Mode {
    // Waves in a period along each axis (whole numbers), w the phase in turns.
    waves: vec4<f32>,
    amplitude: vec4<f32>,
}

struct FreeAir {
    // cm/s, gusts included.
    steady: vec3<f32>,
    n_sources: u32,
    drift: vec3<f32>,
    per_period: f32,
    // Root mean square of the eddies, cm/s.
    rough: f32,
    sources: array<FreeSource, 8>,
    modes: array<Mode, 12>,
}

@group(0) @binding(auto) var<storage, read> free: FreeAir;

const TAU = 6.28318530718;
const FAN = 0u;
const CORE = 12.0;
const LN_2 = 0.69314718;

// Eddies of unit root mean square, divergence-free; `at` in periods.
fn eddies(at: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var m = 0u; m < 12u; m++) {
        let turns = fract(dot(free.modes[m].waves.xyz, at) + free.modes[m].waves.w);
        sum += cos(TAU * turns) * free.modes[m].amplitude.xyz;
    }
    return sum;
}

// The stream of a source at a place, without its eddies.
fn stream(source_idx: u32, p: vec3<f32>) -> vec3<f32> {
    let place = free.sources[source_idx].place;
    let direction = free.sources[source_idx].direction;
    let radius = free.sources[source_idx].radius;
    let speed = free.sources[source_idx].speed;
    let from_place = p - place;
    let along = dot(from_place, direction);
    let aside = from_place - along * direction;
    let r2 = dot(aside, aside);
    if free.sources[source_idx].kind == FAN {
        if along < 0.0 {
            return vec3<f32>(0.0);
        }
        let widened = max(1.0, free.sources[source_idx].falloff * along / (CORE * radius));
        let b = radius * widened;
        let s = r2 / (b * b);
        let far = clamp(along / (CORE * radius), 0.0, 1.0);
        let profile = exp(-LN_2 * min(s * (s + (1.0 - s) * far), 80.0));
        return speed / widened * profile * direction;
    }
    let core = 0.5 * radius;
    let s = r2 / (core * core);
    let flat = along / radius;
    let swirl = exp(0.5 * (1.0 - min(s, 80.0)) - min(flat * flat, 80.0));
    return speed / core * swirl * cross(direction, aside);
}

// What a fan blows through its disc, so far from the axis.
fn outlet(source_idx: u32, aside: f32) -> vec3<f32> {
    let s = aside * aside / (free.sources[source_idx].radius * free.sources[source_idx].radius);
    return free.sources[source_idx].speed * exp(-LN_2 * min(s * s, 80.0)) * free.sources[source_idx].direction;
}

// A stream at a place with the eddies of its source.
fn roughened(source_idx: u32, v: vec3<f32>, p: vec3<f32>) -> vec3<f32> {
    let rough = free.sources[source_idx].rough;
    if rough <= 0.0 {
        return v;
    }
    return v + rough * length(v) * eddies(p * free.sources[source_idx].per_period + free.sources[source_idx].drift);
}

// Velocity of the air at a place, world, cm/s.
fn free_air(p: vec3<f32>) -> vec3<f32> {
    var v = free.steady;
    if free.rough > 0.0 {
        v += free.rough * eddies(p * free.per_period + free.drift);
    }
    for (var source_idx = 0u; source_idx < free.n_sources; source_idx++) {
        v += roughened(source_idx, stream(source_idx, p), p);
    }
    return v;
}

// What a source's body makes of the air in it: a velocity, and in w how much of the place is in it (0-1).
fn body(source_idx: u32, p: vec3<f32>, cell: f32) -> vec4<f32> {
    let direction = free.sources[source_idx].direction;
    let radius = free.sources[source_idx].radius;
    let from_place = p - free.sources[source_idx].place;
    let along = dot(from_place, direction);
    let aside = length(from_place - along * direction);
    if free.sources[source_idx].kind == FAN {
        let half_thick = max(0.75 * cell, 0.15 * radius);
        let share = clamp(0.5 + (half_thick - abs(along)) / cell, 0.0, 1.0)
            * clamp(0.5 + (radius - aside) / cell, 0.0, 1.0);
        if share <= 0.0 {
            return vec4<f32>(0.0);
        }
        return vec4<f32>(roughened(source_idx, outlet(source_idx, aside), p - along * direction), share);
    }
    let share = clamp(0.5 + (radius - max(aside, abs(along))) / cell, 0.0, 1.0);
    if share <= 0.0 {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(roughened(source_idx, stream(source_idx, p), p), share);
}

// What a fan makes of the air that goes from a place to another in a step: a velocity, and in w how much of the air goes
// through it (0-1).
fn blown_through(source_idx: u32, before: vec3<f32>, now: vec3<f32>, cell: f32) -> vec4<f32> {
    let place = free.sources[source_idx].place;
    let direction = free.sources[source_idx].direction;
    let far = dot(now - place, direction);
    let behind = dot(place - before, direction);
    if free.sources[source_idx].kind != FAN || far <= 0.0 || behind <= 0.0 {
        return vec4<f32>(0.0);
    }
    let through = before + behind / (behind + far) * (now - before);
    let aside = distance(through, place);
    let share = clamp(0.5 + (free.sources[source_idx].radius - aside) / cell, 0.0, 1.0);
    if share <= 0.0 {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(roughened(source_idx, outlet(source_idx, aside), through), share);
}
