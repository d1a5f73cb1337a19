//! Random numbers that are the same on every machine.

/// The generator SplitMix64 (G. L. Steele, D. Lea & C. H. Flood, OOPSLA 2014) from a seed.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// The next number, uniform in [−1, 1).
    pub fn number(&mut self) -> f64 {
        // The 53 bits that a number between 0 and 1 can hold.
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
