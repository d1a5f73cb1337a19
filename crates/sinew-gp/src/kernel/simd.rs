//! The exponential for vector instructions.

/// exp(x) for x ≤ 0 without branches, so that loops over it use vector instructions; within two
/// units in the last place, and 0 below −708.
#[inline(always)]
pub(crate) fn exp_of_negative(x: f64) -> f64 {
    const LOG2_E: f64 = std::f64::consts::LOG2_E;
    // ln 2 in two parts, the first with trailing zeros so that its multiples are exact.
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    // Adding it rounds to a whole number, left in the low bits.
    const SHIFTER: f64 = 6_755_399_441_055_744.0;
    // Coefficients 1/k! of the exponential: the remainder on |r| ≤ ln(2)/2 is below 1e-17.
    const TAYLOR: [f64; 14] = {
        let (mut taylor, mut factorial, mut k) = ([1.0; 14], 1.0, 1);
        while k < 14 {
            factorial *= k as f64;
            taylor[k] = 1.0 / factorial;
            k += 1;
        }
        taylor
    };
    let clamped = if x < -708.0 { -708.0 } else { x };
    let shifted = clamped * LOG2_E + SHIFTER;
    let whole = shifted - SHIFTER;
    let r = (clamped - whole * LN2_HIGH) - whole * LN2_LOW;
    let mut sum = TAYLOR[13];
    for coefficient in TAYLOR[..13].iter().rev() {
        sum = sum * r + coefficient;
    }
    let exponent = shifted.to_bits().wrapping_sub(SHIFTER.to_bits());
    let power = f64::from_bits(exponent.wrapping_add(1023) << 52);
    if x < -708.0 { 0.0 } else { sum * power }
}

/// Σ term over lanes in eight partial sums: what vector instructions add at once.
#[inline(always)]
pub(crate) fn lane_sum(count: usize, term: impl Fn(usize) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let whole = count / 8 * 8;
    for start in (0..whole).step_by(8) {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += term(start + k);
        }
    }
    (whole..count).for_each(|lane| sums[0] += term(lane));
    sums.iter().sum()
}
