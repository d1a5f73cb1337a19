//! Layer normalisation of the rows of a tile, and its pull-back.

use crate::fused::simd::{dot, multiply_add, sum_of, vectorised};

/// Added to every variance.
pub(crate) const VARIANCE_FLOOR: f64 = 1e-6;

/// Gain and offset of a normalisation.
#[derive(Clone, Copy)]
pub(crate) struct Normalisation<'a> {
    pub gain: &'a [f32],
    pub offset: &'a [f32],
}

vectorised! {
    /// Replaces every row of `x` by `gain · n + offset` with `n = (x − mean) / deviation`, and
    /// keeps `n` in `normal` and `1 / deviation` in `inverse`.
    pub(crate) fn normalise<FUSED>(
        normalisation: Normalisation<'_>,
        x: &mut [f32],
        normal: &mut [f32],
        inverse: &mut [f32],
    ) {
        let Normalisation { gain, offset } = normalisation;
        let width = gain.len();
        let offset = &offset[..width];
        for ((row, normal), inverse) in
            x.chunks_exact_mut(width).zip(normal.chunks_exact_mut(width)).zip(inverse)
        {
            let mean = sum_of(row, |x| x) / width as f32;
            let variance = sum_of(row, |x| (x - mean) * (x - mean)) / width as f32;
            *inverse = 1.0 / (variance + VARIANCE_FLOOR as f32).sqrt();
            let (row, normal) = (&mut row[..width], &mut normal[..width]);
            for j in 0..width {
                normal[j] = (row[j] - mean) * *inverse;
                row[j] = multiply_add::<FUSED>(gain[j], normal[j], offset[j]);
            }
        }
    }

    /// Computes the cotangent of the rows before normalisation, in `output`, from the `cotangent` of the normalised rows; adds to
    /// the gradients of gain and offset.
    pub(crate) fn pull_back_normalisation<FUSED>(
        gain: &[f32],
        normal: &[f32],
        inverse: &[f32],
        cotangent: &[f32],
        output: &mut [f32],
        gain_gradient: &mut [f32],
        offset_gradient: &mut [f32],
    ) {
        let width = gain.len();
        let rows = output.chunks_exact_mut(width).zip(normal.chunks_exact(width));
        for ((d, n), (c, inverse)) in rows.zip(cotangent.chunks_exact(width).zip(inverse)) {
            for ((d, c), gain) in d.iter_mut().zip(c).zip(gain) {
                *d = c * gain;
            }
            let mean = sum_of(d, |x| x) / width as f32;
            let along = dot::<FUSED>(d, n) / width as f32;
            for (d, n) in d.iter_mut().zip(n) {
                *d = inverse * (*d - mean - n * along);
            }
            for ((sum, c), n) in gain_gradient.iter_mut().zip(c).zip(n) {
                *sum = multiply_add::<FUSED>(*c, *n, *sum);
            }
            for (sum, c) in offset_gradient.iter_mut().zip(c) {
                *sum += c;
            }
        }
    }
}
