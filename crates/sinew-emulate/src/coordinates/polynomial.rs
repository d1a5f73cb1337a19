//! A polynomial in the parameters through simulations.

use crate::coordinates::principal::NO_DIRECTIONS;
use crate::coordinates::{Number, Result, require_count};
use nalgebra::{DMatrix, DVector};
use sinew_num::Slope;

/// Terms of a polynomial: the parameters, and then their products `p_i p_j` with `j ≥ i`, those with the first, with the second and so
/// on.
pub(crate) fn terms<S: Number>(parameters: &[S]) -> Vec<S> {
    let with = |i: usize| parameters[i..].iter().map(move |b| parameters[i].clone() * b.clone());
    let products = (0..parameters.len()).flat_map(with);
    parameters.iter().cloned().chain(products).collect()
}

/// The logarithm of an amplitude is at most about this: displacements between a twentieth and twenty times those at the centre.
const MOST: f64 = 3.0;

/// The terms times an amplitude `a = exp(s)`, `s = MOST tanh(Σ rateₖ termₖ / MOST)`, and after them `1 − a`; without rates the terms alone.
fn with_amplitude<S: Number>(mut terms: Vec<S>, rates: &[f64]) -> Vec<S> {
    let sum = rates.iter().zip(&terms).map(|(rate, term)| term.clone() * *rate);
    if let Some(sum) = sum.reduce(|sum, term| sum + term) {
        let amplitude = sum.chain(|sum| {
            let bounded = (sum / MOST).tanh();
            let amplitude = (MOST * bounded).exp();
            [amplitude, amplitude * (1.0 - bounded * bounded)]
        });
        terms.iter_mut().for_each(|term| *term = term.clone() * amplitude.clone());
        terms.push(amplitude * -1.0 + 1.0);
    }
    terms
}

/// Outputs of a Taylor polynomial at standardised parameters, or their derivatives along a direction of these. `slopes` are the
/// outputs per unit of each term, `rates` those of the logarithm of an amplitude. Empty without slopes.
pub(crate) fn expansion(
    (slopes, rates): (&[Vec<f64>], &[f64]),
    parameters: &[f64],
    along: Option<&[f64]>,
) -> Vec<f64> {
    let terms: Vec<f64> = match along {
        None => with_amplitude(terms(parameters), rates),
        Some(direction) => {
            let pairs = parameters.iter().zip(direction);
            let duals =
                pairs.map(|(&value, &slope)| Slope { value, gradient: [slope], hessian: [] });
            let terms = with_amplitude(terms(&duals.collect::<Vec<_>>()), rates);
            terms.into_iter().map(|term| term.gradient[0]).collect()
        }
    };
    let mut outputs = vec![0.0; slopes.first().map_or(0, Vec::len)];
    // A polynomial of first order has slopes of its first terms alone.
    for (slope, term) in slopes.iter().zip(terms) {
        outputs.iter_mut().zip(slope).for_each(|(y, slope)| *y += term * slope);
    }
    outputs
}

/// Number of terms up to second order.
pub fn all_terms(parameters: usize) -> usize {
    parameters + parameters * (parameters + 1) / 2
}

/// Requires no terms, those of first order in so many parameters, or those of second order.
pub fn check_terms(found: usize, parameters: usize) -> Result<()> {
    match found {
        0 => Ok(()),
        all if all == all_terms(parameters) => Ok(()),
        _ => require_count("parameters of the expansion", found, parameters),
    }
}

/// Least squares through values at parameters.
pub(crate) struct Polynomial {
    pub constant: DVector<f64>,
    /// Coefficients of the terms, as many as the order has.
    pub terms: Vec<DVector<f64>>,
    /// Residuals of the values, a row for each of them.
    pub residual: DMatrix<f64>,
}

impl Polynomial {
    /// Polynomial of the order, zero, one or two, that predicts each row of `values` best from all others.
    pub(crate) fn fit(values: &DMatrix<f64>, parameters: &[Vec<f64>]) -> Result<Self> {
        let count = parameters.first().map_or(0, Vec::len);
        let rows: Vec<Vec<f64>> = parameters.iter().map(|p| terms(p)).collect();
        // A value for each coefficient, and one to judge them by.
        let orders = [0, count, all_terms(count)].into_iter().filter(|n| n + 1 < values.nrows());
        let fits = orders.filter_map(|order| Self::of_order(values, &rows, order));
        let best = fits.min_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(best.ok_or(NO_DIRECTIONS)?.1)
    }

    /// Leave-one-out sum of squares and the polynomial; `None` if the parameters do not determine all terms.
    fn of_order(values: &DMatrix<f64>, rows: &[Vec<f64>], order: usize) -> Option<(f64, Self)> {
        let entry = |i: usize, j: usize| if j == 0 { 1.0 } else { rows[i][j - 1] };
        let (basis, triangle) = DMatrix::from_fn(rows.len(), order + 1, entry).qr().unpack();
        let projected = basis.tr_mul(values);
        let coefficients = triangle.solve_upper_triangular(&projected)?;
        let residual = values - &basis * &projected;
        let missed = residual.row_iter().zip(basis.row_iter()).map(|(missed, basis)| {
            let own = 1.0 - basis.norm_squared();
            missed.norm_squared() / (own * own)
        });
        let missed: f64 = missed.sum();
        let column = |row: usize| coefficients.row(row).transpose();
        let terms = (1..=order).map(column).collect();
        missed.is_finite().then(|| (missed, Self { constant: column(0), terms, residual }))
    }
}
