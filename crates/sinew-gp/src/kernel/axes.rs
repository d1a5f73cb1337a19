//! Lengths along axes.

use super::{Hyperparameter, Measure};
use crate::series::Series;

/// One length for each axis.
pub(super) fn lengths<const D: usize>(name: &'static str) -> Vec<Hyperparameter> {
    (0..D).map(|axis| Hyperparameter { name, measure: Measure::Length { axis } }).collect()
}

/// ½ Σ (xᵢ − yᵢ)² / λᵢ².
pub(super) fn half_square<const D: usize>(
    lengthscales: &[Series],
    x: &[Series; D],
    y: &[Series; D],
) -> Series {
    (0..D).fold(x[0].constant(0.0), |sum, d| {
        sum + ((&x[d] - &y[d]) / &lengthscales[d]).squared() * 0.5
    })
}
