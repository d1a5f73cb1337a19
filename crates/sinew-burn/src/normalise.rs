//! Layer normalisation of the rows of a tile, and its pull-back.

use crate::simd::{multiply_add, sum_of, vectorised};

/// Partial sums of a row: a divisor of the usual latent width of 40.
const LANES: usize = 8;

/// Gain and offset of a normalisation, and what is added to the variance.
#[derive(Clone, Copy)]
pub(crate) struct Normalisation<'a> {
    pub gain: &'a [f32],
    pub offset: &'a [f32],
    pub epsilon: f32,
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
        let Normalisation { gain, offset, epsilon } = normalisation;
        let width = gain.len();
        let offset = &offset[..width];
        for ((row, normal), inverse) in
            x.chunks_exact_mut(width).zip(normal.chunks_exact_mut(width)).zip(inverse)
        {
            let mean = sum_of::<LANES>(width, |j| row[j]) / width as f32;
            let variance = sum_of::<LANES>(width, |j| (row[j] - mean) * (row[j] - mean)) / width as f32;
            *inverse = 1.0 / (variance + epsilon).sqrt();
            for j in 0..width {
                normal[j] = (row[j] - mean) * *inverse;
                row[j] = multiply_add::<FUSED>(gain[j], normal[j], offset[j]);
            }
        }
    }
}

vectorised! {
    /// From the `cotangent` of the normalised rows that of the rows before, in `output`; adds to
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
        let (gain_gradient, offset_gradient) = (&mut gain_gradient[..width], &mut offset_gradient[..width]);
        let rows = output.chunks_exact_mut(width).zip(normal.chunks_exact(width));
        for ((d, n), (c, inverse)) in rows.zip(cotangent.chunks_exact(width).zip(inverse)) {
            let mean = sum_of::<LANES>(width, |j| c[j] * gain[j]) / width as f32;
            let along = sum_of::<LANES>(width, |j| c[j] * gain[j] * n[j]) / width as f32;
            for j in 0..width {
                d[j] = inverse * (c[j] * gain[j] - mean - n[j] * along);
                gain_gradient[j] = multiply_add::<FUSED>(c[j], n[j], gain_gradient[j]);
                offset_gradient[j] += c[j];
            }
        }
    }
}
