//! Tens of thousands of values: the posterior by those few observations that tell all the others.
//!
//! Smooth processes leave next to nothing of most observations once some hundreds are known. An incomplete Cholesky
//! factorisation with pivots (Fine & Scheinberg 2001) of the prior covariance, in units of the noise, chooses these; the
//! posterior that follows from all values through them (Titsias 2009) lies within a known distance of the exact one, in the
//! sense of Kullback and Leibler: the difference between an upper and a lower bound of the evidence (Titsias 2014).

use crate::compile::Compiled;
use crate::data::unplaced;
use crate::error::GpError;
use crate::fit::Fit;
use crate::model::Model;
use crate::posterior::{Posterior, Whitening};
use crate::state::{FIRST_JITTER, State};
use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side as Triangle};
use std::sync::Arc;

/// How far the choice of observations goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReducedOptions {
    /// Observations chosen at most.
    pub most: usize,
    /// Divergence from the exact posterior \[nats\] at which the choice ends; it ends earlier where rounding leaves nothing to
    /// choose.
    pub divergence: f64,
}

impl Default for ReducedOptions {
    fn default() -> Self {
        Self { most: 600, divergence: 0.05 }
    }
}

/// A posterior of many observations through few.
#[derive(Debug)]
pub struct Reduced<const D: usize> {
    /// It predicts as any other.
    pub posterior: Posterior<D>,
    /// Observations that were chosen.
    pub chosen: usize,
    /// Upper bound of the Kullback–Leibler divergence from the exact posterior at the same parameters \[nats\]. At
    /// 0.01, bands and means differ by less than a tenth of a standard deviation.
    pub divergence: f64,
}

/// The incomplete factor: K ≈ G Gᵀ in units of the noise.
struct Incomplete {
    /// Columns of G.
    columns: Vec<Vec<f64>>,
    pivots: Vec<usize>,
    /// Diagonal of what is left.
    left: Vec<f64>,
    /// Standard deviations of the noise, jitter included.
    noise: Vec<f64>,
}

impl<const D: usize> Model<D> {
    /// The posterior at the parameters of `fit`, made for a model with the same prior and groups of fewer values (see
    /// [`crate::Data::thinned`]). Takes O(N M²) for N observations, of which M are chosen, and 8 N M bytes.
    ///
    /// ```
    /// use sinew_gp::{
    ///     Condition, Data, Domain, Evidence, FitOptions, Model, Noise, Prior, Problem, ReducedOptions, Side,
    ///     SquaredExponential, constant,
    /// };
    ///
    /// let string = Domain::interval("x", [0.0, 1.0])?;
    /// let [dx] = string.derivatives();
    /// let held = || Condition::Dirichlet(constant(0.0));
    /// let problem = Problem::new(string.clone(), -(dx * dx))?
    ///     .condition("x", Side::Lower, held())?
    ///     .condition("x", Side::Upper, held())?;
    /// let places = string.sample(3000, 1)?;
    /// let values: Vec<f64> = places.iter().enumerate()
    ///     .map(|(k, [x])| x * (1.0 - x) + 0.02 * (k as f64).sin())
    ///     .collect();
    /// let data = Data::new().values(&places, &values, Noise::Learned);
    /// let prior = || Prior::constrained(&problem, &SquaredExponential::new());
    ///
    /// let few = Model::new(prior()?, data.thinned(200, 1), Evidence::Auto)?;
    /// let fit = few.fit(&FitOptions::default())?;
    /// let all = Model::new(prior()?, data, Evidence::Auto)?.reduced(&fit, &ReducedOptions::default())?;
    /// // Six tell what 3000 do; the rest is below rounding, which the bound counts too.
    /// assert!(all.chosen < 20 && all.divergence < 0.05);
    /// let middle = all.posterior.predict(&[[0.5]])?;
    /// assert!((middle.mean[0] - 0.25).abs() < 0.004);
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    ///
    /// # Errors
    /// If the parameters are not those of this model, its covariance has no factor, or an equation holds everywhere;
    /// [`GpError::NotReduced`] where the bound stays above what was asked for.
    pub fn reduced(self, fit: &Fit<D>, options: &ReducedOptions) -> Result<Reduced<D>, GpError> {
        if self.source.is_some() {
            return Err(unplaced());
        }
        let names = |model: &Self| -> Vec<String> {
            model.parameters.iter().map(|p| p.name.clone()).collect()
        };
        if names(&self) != names(fit.model()) {
            return Err(GpError::Request(format!(
                "the fit has the parameters {}, the model {}; fit the same prior and groups with fewer values",
                names(fit.model()).join(", "),
                names(&self).join(", ")
            )));
        }
        let parameters = fit.outcome().parameters.clone();
        let state = State::new(&self, &parameters)?;
        let residual = state.residual();
        let Incomplete { columns, pivots, left, noise } = state.incomplete(options);
        let scaled: Vec<f64> = residual.iter().zip(&noise).map(|(r, n)| r / n).collect();
        let exact: Vec<bool> = state.sigmas().map(|sigma| sigma == 0.0).collect();
        drop(state);
        let count = pivots.len();
        let factor = Mat::from_fn(self.size, count, |i, j| columns[j][i]);
        drop(columns);
        let divergence = divergence(&factor, &scaled, &left, &exact)?;
        let asked = options.divergence;
        // The choice ends by an estimate of the bound.
        if divergence > SLACK * asked {
            let rounding = count < options.most.min(self.size);
            return Err(GpError::NotReduced { chosen: count, divergence, asked, rounding });
        }

        // GᵀG = V Λ Vᵀ, so that the posterior of the chosen ones needs no difference of like matrices.
        let eigen = decomposed(&(factor.transpose() * &factor))?;
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let right = vectors.transpose() * (factor.transpose() * column(&scaled));
        // L⁻¹ N^−½ of the chosen rows.
        let mut whitened =
            Mat::from_fn(count, count, |i, j| if i == j { 1.0 / noise[pivots[j]] } else { 0.0 });
        let lower =
            Mat::from_fn(count, count, |i, j| if j <= i { factor[(pivots[i], j)] } else { 0.0 });
        solve_lower_triangular_in_place(lower.as_ref(), whitened.as_mut(), Par::Seq);
        let turned = vectors.transpose() * &whitened;
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|position| pivots[*position]);
        let value = |k: usize| values[k].max(0.0);
        let weights = order.iter().map(|j| {
            (0..count).map(|k| turned[(k, *j)] * right[(k, 0)] / (1.0 + value(k))).sum::<f64>()
        });
        let matrix = Mat::from_fn(count, count, |k, j| {
            (value(k) / (1.0 + value(k))).sqrt() * turned[(k, order[j])]
        });
        let weights = weights.collect();
        let rows: Vec<usize> = order.iter().map(|j| pivots[*j]).collect();
        let posterior = Posterior {
            model: Arc::new(self.of_rows(&rows)),
            parameters,
            weights,
            whitening: Whitening::Matrix(matrix),
            jitter: FIRST_JITTER,
        };
        Ok(Reduced { posterior, chosen: count, divergence })
    }

    /// The model of some observations, given in ascending order.
    fn of_rows(mut self, rows: &[usize]) -> Self {
        let mut offset = 0;
        self.imposed = rows.iter().filter(|row| **row < self.imposed).count();
        for group in &mut self.groups {
            let all = group.rows();
            let own: Vec<usize> =
                rows.iter().filter(|row| all.contains(row)).map(|row| row - all.start).collect();
            *group = Compiled {
                legs: group.legs.iter().map(|leg| leg.of_points(&own)).collect(),
                values: own.iter().map(|k| group.values[*k]).collect(),
                points: own.iter().map(|k| group.points[*k]).collect(),
                averages: None,
                places: own.iter().filter_map(|k| group.places.get(*k).copied()).collect(),
                offset,
                ..*group
            };
            offset += own.len();
        }
        self.size = rows.len();
        self
    }
}

impl<const D: usize> State<'_, D> {
    /// Pivot by pivot, the observation of which the others tell least.
    fn incomplete(&self, options: &ReducedOptions) -> Incomplete {
        let size = self.model.size;
        let diagonal = self.diagonal();
        let noisy = |(s, d): (f64, &f64)| (s * s + FIRST_JITTER * d).sqrt();
        let noise: Vec<f64> = self.sigmas().zip(&diagonal).map(noisy).collect();
        let mut left: Vec<f64> = diagonal.iter().zip(&noise).map(|(d, n)| d / (n * n)).collect();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut pivots: Vec<usize> = Vec::new();
        // The bound below is about ½ t (1 + N) for a trace t.
        let enough = 2.0 * options.divergence / (1.0 + size as f64);
        while pivots.len() < options.most.min(size) {
            let largest = (0..size).max_by(|a, b| left[*a].total_cmp(&left[*b]));
            let Some(pivot) = largest.filter(|pivot| left[*pivot] > 0.0) else { break };
            if left.iter().sum::<f64>() <= enough
                || left[pivot] < ROUNDING * diagonal[pivot] / noise[pivot].powi(2)
            {
                break;
            }
            let mut own = self.column(pivot);
            own.iter_mut().zip(&noise).for_each(|(k, n)| *k /= n * noise[pivot]);
            for column in &columns {
                let factor = column[pivot];
                own.iter_mut().zip(column).for_each(|(k, g)| *k -= factor * g);
            }
            let root = left[pivot].sqrt();
            own.iter_mut().for_each(|k| *k /= root);
            left.iter_mut().zip(&own).for_each(|(left, g)| *left = (*left - g * g).max(0.0));
            // What is known is known, whatever rounding leaves.
            pivots.push(pivot);
            pivots.iter().for_each(|known| left[*known] = 0.0);
            columns.push(own);
        }
        // Above the diagonal the factor is zero but for rounding.
        for (number, column) in columns.iter_mut().enumerate() {
            pivots[..number].iter().for_each(|known| column[*known] = 0.0);
        }
        Incomplete { columns, pivots, left, noise }
    }
}

/// Factor that the bound may exceed what was asked for by.
const SLACK: f64 = 1.5;
/// Remainder of a variance, relative to it, that rounding cannot tell from zero.
const ROUNDING: f64 = 1e-14;

/// Upper bound of the divergence: ½ t + ½ rᵀ((Q + 1)⁻¹ − (Q + C)⁻¹) r with the trace t of what is left of K − Q, and C = 1 plus
/// twice the trace over exact, or over noisy observations: no more than twice its diagonal blocks is left.
fn divergence(
    factor: &Mat<f64>,
    residual: &[f64],
    left: &[f64],
    exact: &[bool],
) -> Result<f64, GpError> {
    let trace = |class: bool| -> f64 {
        left.iter().zip(exact).filter(|(_, own)| **own == class).map(|(left, _)| left).sum()
    };
    let traces = [trace(false), trace(true)];
    let misfit = |noise: [f64; 2]| -> Result<f64, GpError> {
        let scale = |row: usize| noise[usize::from(exact[row])].sqrt().recip();
        let scaled = Mat::from_fn(factor.nrows(), factor.ncols(), |i, j| scale(i) * factor[(i, j)]);
        let right: Vec<f64> = residual.iter().enumerate().map(|(i, r)| scale(i) * r).collect();
        let eigen = decomposed(&(scaled.transpose() * &scaled))?;
        let along = eigen.U().transpose() * (scaled.transpose() * column(&right));
        let square: f64 = right.iter().map(|r| r * r).sum();
        let values = eigen.S().column_vector();
        let told: f64 =
            (0..along.nrows()).map(|k| along[(k, 0)].powi(2) / (1.0 + values[k].max(0.0))).sum();
        Ok(square - told)
    };
    let sum: f64 = traces.iter().sum();
    let looser = misfit(traces.map(|trace| 1.0 + 2.0 * trace))?;
    Ok(0.5 * sum + 0.5 * (misfit([1.0, 1.0])? - looser).max(0.0))
}

fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

fn decomposed(matrix: &Mat<f64>) -> Result<SelfAdjointEigen<f64>, GpError> {
    SelfAdjointEigen::new(matrix.as_ref(), Triangle::Lower)
        .map_err(|_| GpError::NotPositiveDefinite { size: matrix.nrows(), jitter: FIRST_JITTER })
}
