//! Seeds and normal variates.

use rand::{Rng, RngExt};

/// A seed that derives from another: the seed of one stream.
pub fn split_seed(seed: u64, stream: u64) -> u64 {
    // The golden ratio in 64 bits: neighbouring seeds do not share streams.
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ stream
}

/// Independent standard normal variates, by the polar form of Box and Muller (1958).
pub fn standard_normals(count: usize, random: &mut impl Rng) -> Vec<f64> {
    let mut normal = || {
        let uniform: f64 = 1.0 - random.random::<f64>();
        let angle = std::f64::consts::TAU * random.random::<f64>();
        (-2.0 * uniform.ln()).sqrt() * angle.cos()
    };
    (0..count).map(|_| normal()).collect()
}
