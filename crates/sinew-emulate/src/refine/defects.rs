//! Errors of predictions at answered parameter sets, interpolated at others.

use crate::Body;
use crate::sample::share_of;
use nalgebra::{DMatrix, DVector};

/// Errors that an interpolation is made of, the nearest ones: its matrix is factorised for each prediction.
const NEAREST: usize = 50;
/// Variance of the errors' noise \[relative to the mean variance\].
const NUGGET: f64 = 1e-4;

/// Error of a prediction that has been answered.
pub(crate) struct Defect {
    /// Parameters as places in their ranges, from −1 to 1.
    pub place: Vec<f64>,
    /// Answer less prediction, node by node \[length\].
    pub field: Vec<f64>,
}

/// Parameters as places in their ranges, from −1 to 1.
pub(crate) fn place(body: &Body, theta: &[f64]) -> Vec<f64> {
    let values = body.parameters.iter().zip(theta);
    values.map(|(parameter, &value)| 2.0 * share_of(parameter, value) - 1.0).collect()
}

/// A prediction with the simple kriging of the `defects` at its place added (Rasmussen & Williams, 2006, section 2.2). Their covariance
/// `exp(x·y)` is that of polynomials whose coefficients of order n have the variance 1/n!. Far outside of the ranges it overflows, and the
/// prediction stays as it is.
pub(crate) fn corrected<'a>(
    prediction: &[f64],
    at: &[f64],
    defects: impl Iterator<Item = &'a Defect>,
) -> Vec<f64> {
    let distance = |defect: &Defect| -> f64 {
        defect.place.iter().zip(at).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let mut near: Vec<_> = defects.map(|defect| (distance(defect), defect)).collect();
    near.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    near.truncate(NEAREST);
    let covariance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().exp();
    let place = |i: usize| &near[i].1.place[..];
    let mut matrix =
        DMatrix::from_fn(near.len(), near.len(), |i, j| covariance(place(i), place(j)));
    let noise = NUGGET * matrix.trace() / near.len() as f64;
    (0..near.len()).for_each(|i| matrix[(i, i)] += noise);
    let right = DVector::from_fn(near.len(), |i, _| covariance(place(i), at));
    let mut sum = prediction.to_vec();
    let weights = matrix.cholesky().map(|factor| factor.solve(&right));
    for (weight, (_, defect)) in weights.iter().flatten().zip(&near) {
        sum.iter_mut().zip(&defect.field).for_each(|(u, d)| *u += weight * d);
    }
    if is_finite(&sum) { sum } else { prediction.to_vec() }
}

pub(crate) fn is_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}
