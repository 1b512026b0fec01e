// Random numbers that belong to things: twins of core/src/hash.rs, bit for bit.
#define_import_path lorelei::hash

// PCG output permutation as a hash (Jarzynski and Olano 2020).
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// A hash of two numbers; the order matters.
fn combine(a: u32, b: u32) -> u32 {
    return pcg(a ^ (pcg(b) + 0x9E3779B9u));
}

// A number in [0, 1) from the upper 24 bits.
fn unit(hash: u32) -> f32 {
    return f32(hash >> 8u) * (1.0 / 16777216.0);
}

// The random number, in [0, 1), of a seed for a purpose.
fn random(seed: u32, purpose: u32) -> f32 {
    return unit(combine(seed, purpose));
}
