//! Random numbers that belong to things: a strand's number depends on its id and on what it is for, never
//! on the order in which strands are made. Twins of the functions in generate.wgsl, bit for bit.

/// PCG output permutation as a hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
pub fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A hash of two numbers; the order matters.
pub fn combine(a: u32, b: u32) -> u32 {
    pcg(a ^ pcg(b).wrapping_add(0x9E37_79B9))
}

/// A number in [0, 1) from the upper 24 bits.
pub fn unit(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The random number, in [0, 1), of `seed` for a purpose.
pub fn random(seed: u32, purpose: u32) -> f32 {
    unit(combine(seed, purpose))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even_and_neighbours_unrelated() {
        let n = 100_000;
        let mut bins = [0_u32; 16];
        let mut product = 0.0;
        for i in 0..n {
            let a = random(i, 1);
            bins[(a * 16.0) as usize] += 1;
            product += f64::from(a - 0.5) * f64::from(random(i + 1, 1) - 0.5);
        }
        // Six standard deviations of a binomial; and of the mean product, which is 1/12/sqrt(n).
        let sd = (f64::from(n) / 16.0 * (15.0 / 16.0)).sqrt();
        assert!(bins.iter().all(|&b| (f64::from(b) - f64::from(n) / 16.0).abs() < 6.0 * sd), "{bins:?}");
        assert!((product / f64::from(n)).abs() < 6.0 / 12.0 / f64::from(n).sqrt());
    }
}
