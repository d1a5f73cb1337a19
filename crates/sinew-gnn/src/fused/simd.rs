//! Elementary functions written for vector instructions that are chosen at run time.

pub(crate) use sinew_num::{Instructions, instructions, vectorised};

/// `a b + c`, fused where that is one instruction (elsewhere it would be a library call).
#[inline(always)]
pub(crate) fn multiply_add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Adding this to a float of modest size leaves its nearest integer in the low bits.
const ROUNDING: f32 = 12_582_912.0; // 1.5 · 2²³
/// `eˣ − 1` for x in [−87, 88], to about one unit in the last place also near zero; NaN stays NaN.
///
/// x = n ln 2 + r, and eˣ − 1 = 2ⁿ (eʳ − 1) + (2ⁿ − 1). The polynomial of (eʳ − 1 − r) / r² has the least relative error of eʳ − 1 on
/// |r| ≤ ln 2 / 2, which is 1e-8.
#[inline(always)]
pub(crate) fn exp_m1<const FUSED: bool>(x: f32) -> f32 {
    let shifted = multiply_add::<FUSED>(x, std::f32::consts::LOG2_E, ROUNDING);
    let n = shifted - ROUNDING;
    let r = multiply_add::<FUSED>(n, -std::f32::consts::LN_2, x);
    let mut p = 1.388_251_7e-3;
    for coefficient in [8.366_547_5e-3, 4.166_72e-2, 0.166_665_43, 0.499_999_97] {
        p = multiply_add::<FUSED>(p, r, coefficient);
    }
    let q = multiply_add::<FUSED>(p, r * r, r);
    let power = f32::from_bits((shifted.to_bits() << 23).wrapping_add(1.0_f32.to_bits()));
    multiply_add::<FUSED>(power, q, power - 1.0)
}

/// Partial sums that a sum is interleaved in.
const LANES: usize = 8;

/// `Σ a b` in a fixed order that vectorises.
#[inline(always)]
pub(crate) fn dot<const FUSED: bool>(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0; LANES];
    let (mut chunks, mut others) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (a, b) in (&mut chunks).zip(&mut others) {
        for i in 0..LANES {
            lanes[i] = multiply_add::<FUSED>(a[i], b[i], lanes[i]);
        }
    }
    for ((a, b), lane) in chunks.remainder().iter().zip(others.remainder()).zip(&mut lanes) {
        *lane = multiply_add::<FUSED>(*a, *b, *lane);
    }
    total(lanes)
}

/// `Σ f(x)` in a fixed order that vectorises.
#[inline(always)]
pub(crate) fn sum_of(x: &[f32], f: impl Fn(f32) -> f32) -> f32 {
    let mut lanes = [0.0; LANES];
    let mut chunks = x.chunks_exact(LANES);
    for x in &mut chunks {
        for i in 0..LANES {
            lanes[i] += f(x[i]);
        }
    }
    for (x, lane) in chunks.remainder().iter().zip(&mut lanes) {
        *lane += f(*x);
    }
    total(lanes)
}

#[inline(always)]
fn total(lanes: [f32; LANES]) -> f32 {
    let pairs: [f32; LANES / 2] = std::array::from_fn(|i| lanes[i] + lanes[i + LANES / 2]);
    (pairs[0] + pairs[2]) + (pairs[1] + pairs[3])
}
