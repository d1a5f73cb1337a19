//! The directions in which simulations differ, and a polynomial in the parameters through them.

use crate::coordinates::{
    CoordinateError, Number, Result, ensure, packed, require_count, require_finite,
};
use crate::predict::regression::principal;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sinew_num::Slope;
use std::sync::Arc;

/// Displacements as `u = origin + U (s/s₁)^p s₁ Uᵀ · output` with the principal directions U and deviations s of simulations:
/// simulated displacements vary in few directions, and nothing else is predicted, strains included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct PrincipalDirections {
    origin: Arc<[f64]>,
    /// Applied to a row of outputs one after the other, each from the right.
    factors: Vec<Factor>,
    /// Outputs per unit of each standardised parameter, and of each product of two; none where outputs are the network's alone.
    slopes: Arc<[Vec<f64>]>,
}

/// A matrix, row by row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Factor {
    columns: usize,
    #[serde(with = "packed")]
    entries: Arc<[f32]>,
}

/// Sums of a product that run beside one another, so that it is vectorised.
const LANES: usize = 8;

impl Factor {
    fn new(columns: usize, entries: impl Iterator<Item = f64>) -> Self {
        Self { columns, entries: entries.map(|entry| entry as f32).collect() }
    }

    /// Product of a row with the matrix.
    fn after(&self, row: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.columns];
        for (value, entries) in row.iter().zip(self.entries.chunks_exact(self.columns)) {
            for (sum, entry) in product.iter_mut().zip(entries) {
                *sum += value * f64::from(*entry);
            }
        }
        product
    }

    /// Product of a row with the transpose of the matrix.
    fn before(&self, row: &[f64]) -> Vec<f64> {
        let (parts, rest) = row.as_chunks::<LANES>();
        let rows = self.entries.chunks_exact(self.columns).map(|entries| {
            let (of_parts, of_rest) = entries.as_chunks::<LANES>();
            let mut sums = [0.0; LANES];
            for (values, entries) in parts.iter().zip(of_parts) {
                for lane in 0..LANES {
                    sums[lane] += values[lane] * f64::from(entries[lane]);
                }
            }
            let rest = rest.iter().zip(of_rest).map(|(value, entry)| value * f64::from(*entry));
            sums.iter().sum::<f64>() + rest.sum::<f64>()
        });
        rows.collect()
    }
}

/// Directions in which simulations vary less than this part of the largest variation are left out: single
/// precision holds no more.
const SMALLEST_DEVIATION: f64 = 1e-7;
pub(crate) const NO_DIRECTIONS: CoordinateError =
    CoordinateError::None("directions need two simulations that differ");

impl PrincipalDirections {
    /// Coordinates about simulated displacements, with the map `U (s/s₁)^p s₁ Uᵀ` of their principal directions U and deviations s, the
    /// largest being s₁ \[length\]. A power p of one is the root of the covariance: outputs of size one then spread as the
    /// simulations do. Smaller powers let the network see the small deviations larger.
    ///
    /// U and s are those of the residuals of a polynomial in the standardised parameters. Its order, zero (the mean) to
    /// two, has the lowest leave-one-out error. A network learns the residuals.
    ///
    /// # Errors
    /// Fewer than two fields, of different lengths, not finite, or all the same; parameters that do not belong to the fields.
    #[doc(alias = "following")]
    pub fn about_trend<'a>(
        fields: impl IntoIterator<Item = &'a [f64]>,
        parameters: &[Vec<f64>],
        power: f64,
    ) -> Result<Self> {
        let fields: Vec<&[f64]> = fields.into_iter().collect();
        let (count, size) = (fields.len(), fields.first().map_or(0, |field| field.len()));
        ensure(count >= 2 && size > 0, NO_DIRECTIONS)?;
        for field in &fields {
            require_count("values of a simulated displacement", field.len(), size)?;
            require_finite("a simulated displacement", field)?;
        }
        require_count("parameters of simulations", parameters.len(), count)?;
        let width = parameters[0].len();
        for parameters in parameters {
            require_count("parameters of a simulation", parameters.len(), width)?;
            require_finite("parameters of a simulation", parameters)?;
        }
        let mean = |i: usize| fields.iter().map(|field| field[i]).sum::<f64>() / count as f64;
        let mean: Vec<f64> = (0..size).map(mean).collect();
        let spread = DMatrix::from_fn(size, count, |i, j| fields[j][i] - mean[i]);
        let (modes, deviations) = principal(&spread).ok_or(NO_DIRECTIONS)?;
        ensure(deviations[0] != 0.0, NO_DIRECTIONS)?;
        // All that follows happens in the space of the simulations.
        let floor = SMALLEST_DEVIATION * deviations[0];
        let kept = deviations.iter().take_while(|&&deviation| deviation > floor).count();
        let modes = modes.columns(0, kept).into_owned();
        let polynomial = Polynomial::fit(&modes.tr_mul(&spread).transpose(), parameters)?;
        let (turn, left) = principal(&polynomial.residual.transpose()).ok_or(NO_DIRECTIONS)?;
        let start = &modes * &polynomial.constant;
        let modes = modes * &turn;
        let root = (count as f64).sqrt();
        let largest = left[0].max(floor) / root;
        let scales = left.map(|s| largest * (s.max(floor) / root / largest).powf(power));
        let down = (0..size).flat_map(|i| (0..kept).map(move |j| (i, j)));
        let up = (0..kept).flat_map(|j| (0..size).map(move |i| (i, j)));
        let factors = vec![
            Factor::new(kept, down.map(|(i, j)| modes[(i, j)] * scales[j])),
            Factor::new(size, up.map(|(i, j)| modes[(i, j)])),
        ];
        let output = |term: &DVector<f64>| -> Vec<f64> {
            let components = turn.tr_mul(term).component_div(&scales);
            (&modes * components).iter().copied().collect()
        };
        let origin = mean.iter().zip(start.iter()).map(|(mean, start)| mean + start).collect();
        Self::from_parts(origin, factors, polynomial.terms.iter().map(output).collect())
    }

    fn from_parts(origin: Vec<f64>, factors: Vec<Factor>, slopes: Vec<Vec<f64>>) -> Result<Self> {
        require_finite("the origin of the outputs", &origin)?;
        let mut size = origin.len();
        for factor in &factors {
            let Factor { columns, entries } = factor;
            require_finite("the output map", entries)?;
            require_count("entries of the output map", entries.len(), size * columns)?;
            size = *columns;
        }
        require_count("columns of the output map", size, origin.len())?;
        Ok(Self { origin: origin.into(), factors, slopes: slopes.into() })
    }

    /// Displacement of a zero output \[length\].
    pub fn origin(&self) -> &[f64] {
        &self.origin
    }

    /// Outputs per unit of each standardised parameter, and then of each product of two; none where outputs do not follow.
    pub fn slopes(&self) -> &[Vec<f64>] {
        &self.slopes
    }

    /// Change of the displacement by outputs, node by node.
    pub fn moved(&self, outputs: &[f64]) -> Vec<f64> {
        self.factors.iter().fold(outputs.to_vec(), |row, factor| factor.after(&row))
    }

    /// Cotangent of the outputs, from that of the displacement.
    pub fn pull_back(&self, cotangent: &[f64]) -> Vec<f64> {
        self.factors.iter().rev().fold(cotangent.to_vec(), |row, factor| factor.before(&row))
    }
}

/// Stored form of a basis: little-endian bytes of the matrices in base64.
#[derive(Serialize, Deserialize)]
struct Packed {
    origin: Vec<f64>,
    factors: Vec<Factor>,
    slopes: Vec<String>,
}

impl From<PrincipalDirections> for Packed {
    fn from(PrincipalDirections { origin, factors, slopes }: PrincipalDirections) -> Self {
        let slopes = slopes.iter().map(|slope| packed::doubles(slope)).collect();
        Self { origin: origin.to_vec(), factors, slopes }
    }
}

impl TryFrom<Packed> for PrincipalDirections {
    type Error = String;

    fn try_from(packed: Packed) -> Result<Self, String> {
        let Packed { origin, factors, slopes } = packed;
        let slopes = slopes.iter().map(|slope| packed::read_doubles(slope, origin.len()));
        let slopes = slopes.collect::<Result<_, _>>()?;
        Self::from_parts(origin, factors, slopes).map_err(|error| error.to_string())
    }
}

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
