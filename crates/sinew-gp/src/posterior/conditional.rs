//! Posterior of u and of linear functionals of it at given parameters.

use crate::error::{Result, check_lengths};
use crate::evidence::factor::Factor;
use crate::evidence::gram::Scratch;
use crate::evidence::state::{Factored, State};
use crate::model::compile::compile;
use crate::model::data::{Role, check_finite};
use crate::model::spread;
use crate::{Data, Functional, GpError, Model, Noise, Operator};
use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side as Triangle};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_num::dot;
use sinew_sample::standard_normals;
use std::ops::Range;
use std::sync::Arc;

/// The Gaussian process conditioned on the data, at fixed parameters. Standard deviations do not include what is not known of
/// these, and are too narrow by that: those of [`crate::Fit::predict`] and of an [`crate::Ensemble`] do.
#[derive(Debug)]
pub struct Conditional<const D: usize> {
    pub(crate) model: Arc<Model<D>>,
    pub(crate) parameters: Vec<f64>,
    /// K⁻¹ (y − m).
    pub(crate) weights: Vec<f64>,
    factor: Factor,
    pub(crate) jitter: f64,
}

/// A question about an operator at points.
type Asked<const D: usize, T> = fn(&Conditional<D>, &Operator<D>, &[[f64; D]]) -> Result<T>;

/// Share of the variance of measured values below which a posterior that explains no more of it has collapsed.
const COLLAPSE: f64 = 0.1;

/// Values with their standard deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Posterior mean at each point.
    pub mean: Vec<f64>,
    /// Posterior standard deviation at each point.
    pub standard_deviation: Vec<f64>,
}

impl<const D: usize> Conditional<D> {
    /// The process of `model` at `parameters` on their scales.
    ///
    /// # Errors
    /// If their number is wrong or the covariance is not positive definite.
    pub fn new(model: Arc<Model<D>>, parameters: &[f64]) -> Result<Self> {
        instance!(D, Conditional::of, fn(Arc<Model<D>>, &[f64]) -> Result<Conditional<D>>)(
            model, parameters,
        )
    }

    fn of(model: Arc<Model<D>>, parameters: &[f64]) -> Result<Self> {
        let Factored { factor, whitened: mut weights, jitter, .. } =
            State::new(&model, parameters)?.factored()?;
        factor.backward(&mut weights);
        Ok(Self { model, parameters: parameters.to_vec(), weights, factor, jitter })
    }

    /// Mean and standard deviation of u. Points outside the domain are answered too, by continuation:
    /// no condition holds there, and deviations tell less than inside.
    ///
    /// # Errors
    /// If a point is not finite, or a feature has no derivative there.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction> {
        self.predict_operator(&Operator::identity(), points)
    }

    /// Mean of u only, which costs far less.
    ///
    /// # Errors
    /// As [`Conditional::predict`].
    pub fn mean(&self, points: &[[f64; D]]) -> Result<Vec<f64>> {
        self.mean_of(&Operator::identity(), points)
    }

    /// Mean of an operator applied to u, as a flux.
    ///
    /// # Errors
    /// As [`Conditional::predict`]; and if the operator has parameters that the model lacks, or takes
    /// more derivatives than are supported or the kernel's functions have.
    pub fn mean_of(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<Vec<f64>> {
        instance!(D, Conditional::mean_at, Asked<D, Vec<f64>>)(self, operator, points)
    }

    fn mean_at(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<Vec<f64>> {
        self.asked(operator, points, |asked| {
            let mut mean = asked.requested_mean();
            asked.for_requested_rows(0..asked.model.size, |row, covariances| {
                let weight = self.weights[row];
                mean.iter_mut().zip(covariances).for_each(|(m, c)| *m += weight * c);
            });
            mean
        })
    }

    /// Mean and standard deviation of an operator applied to u.
    ///
    /// # Errors
    /// As [`Conditional::mean_of`].
    pub fn predict_operator(&self, operator: &Operator<D>, at: &[[f64; D]]) -> Result<Prediction> {
        instance!(D, Conditional::predicted, Asked<D, Prediction>)(self, operator, at)
    }

    fn predicted(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<Prediction> {
        self.asked(operator, points, |asked| {
            let (mean, whitened) = self.conditioned(asked);
            let left = asked.requested_variances().into_iter().zip(whitened.col_iter());
            let deviation =
                left.map(|(prior, known)| (prior - known.squared_norm_l2()).max(0.0).sqrt());
            Prediction { mean, standard_deviation: deviation.collect() }
        })
    }

    /// Mean and standard deviation of a weighted sum, as an integral.
    ///
    /// # Errors
    /// As [`Conditional::mean_of`]; and if there are not as many weights as points, or some are not
    /// finite.
    pub fn predict_functional(&self, functional: &Functional<D>) -> Result<(f64, f64)> {
        let weights = &functional.weights;
        check_lengths(functional.points.len(), weights.len())?;
        check_finite("weight", weights, 1)?;
        let (mean, covariance) = self.joint(&functional.operator, &functional.points)?;
        let each = weights.iter().enumerate();
        let variance: f64 = each.map(|(j, w)| w * dot(covariance.col_as_slice(j), weights)).sum();
        Ok((dot(&mean, weights), variance.max(0.0).sqrt()))
    }

    /// Functions drawn from the posterior, each by its values at the points.
    ///
    /// # Errors
    /// As [`Conditional::predict`].
    pub fn sample(&self, points: &[[f64; D]], count: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
        let (mean, covariance) = self.joint(&Operator::identity(), points)?;
        drawn(&mean, &covariance, count, seed)
    }

    /// Whether what measured values differ by among themselves is taken for noise.
    pub(crate) fn is_collapsed(&self) -> bool {
        let Ok(state) = State::new(&self.model, &self.parameters) else { return false };
        let (mut left, mut variation) = (0.0, 0.0);
        let sigmas: Vec<f64> = state.sigmas().collect();
        for (group, sigma) in self.model.groups.iter().zip(&state.noise) {
            if group.given.role != Role::Observed || *sigma == 0.0 {
                continue;
            }
            // In units of the noise, so that groups of different units count alike. The posterior mean at an observation
            // is y − σ² α.
            left += group.rows().map(|row| (sigmas[row] * self.weights[row]).powi(2)).sum::<f64>();
            let spread = spread(&group.given.values).unwrap_or_default() / sigma;
            variation += spread * spread * group.given.values.len() as f64;
        }
        left > (1.0 - COLLAPSE) * variation && variation > 0.0
    }

    /// Leave-one-out residual of an observation and its standard deviation: α / (K⁻¹) and (K⁻¹)^−½ at its row (Rasmussen &
    /// Williams 2006, §5.4.2).
    pub(crate) fn left_out(&self, row: usize) -> [f64; 2] {
        let mut column = vec![0.0; self.model.size];
        column[row] = 1.0;
        self.factor.forward(&mut column);
        let precision = column.iter().map(|x| x * x).sum::<f64>();
        [self.weights[row] / precision, precision.sqrt().recip()]
    }

    /// Difference of an exact observation from the posterior mean, for its jitter.
    pub(crate) fn missed(&self, row: usize) -> f64 {
        let entry = |column: usize| self.factor.column(column)[row - column];
        let variance: f64 = (0..=row).map(|column| entry(column).powi(2)).sum();
        self.weights[row] * self.jitter * variance
    }

    /// Standard deviation of an operator before the data, root mean square over points.
    pub(crate) fn prior_spread(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<f64> {
        let sum: f64 =
            self.asked(operator, points, |asked| asked.requested_variances().iter().sum())?;
        Ok((sum / points.len().max(1) as f64).sqrt())
    }

    /// An answer from the model with values of an operator at points as a last group beyond its data.
    fn asked<T>(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
        answer: impl FnOnce(&State<'_, D>) -> T,
    ) -> Result<T> {
        let (model, zeros) = (&self.model, vec![0.0; points.len()]);
        check_finite("point", points.as_flattened(), D)?;
        let mut theta = model.theta.clone();
        let data = Data::new().functional(operator.clone(), points, &zeros, Noise::Known(1.0));
        let last = compile(&model.prior, &data.groups[0], (0, "the prediction"), &mut theta)?;
        if let Some(unknown) = theta.get(model.theta.len()) {
            model.position(unknown.name())?;
        }
        let extended = model.with_group(last);
        Ok(answer(&State::new(&extended, &self.parameters)?))
    }

    /// Posterior mean of what is asked, and L⁻¹ K_* with one column for each point.
    fn conditioned(&self, asked: &State<'_, D>) -> (Vec<f64>, Mat<f64>) {
        let mut mean = asked.requested_mean();
        let mut cross = Mat::<f64>::zeros(self.model.size, mean.len());
        asked.for_requested_rows(0..self.model.size, |row, covariances| {
            covariances.iter().enumerate().for_each(|(column, c)| cross[(row, column)] = *c);
        });
        for (column, mean) in mean.iter_mut().enumerate() {
            *mean += dot(cross.col_as_slice(column), &self.weights);
        }
        solve_lower_triangular_in_place(self.factor.view(), cross.as_mut(), Par::Seq);
        (mean, cross)
    }

    /// Posterior mean and covariance of an operator at points.
    fn joint(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<(Vec<f64>, Mat<f64>)> {
        instance!(D, Conditional::jointly, Asked<D, (Vec<f64>, Mat<f64>)>)(self, operator, points)
    }

    fn jointly(&self, operator: &Operator<D>, points: &[[f64; D]]) -> Result<(Vec<f64>, Mat<f64>)> {
        self.asked(operator, points, |asked| {
            let (mean, whitened) = self.conditioned(asked);
            let mut covariance = whitened.transpose() * &whitened;
            let size = asked.model.size;
            asked.for_requested_rows(size..size + points.len(), |row, prior| {
                for (value, known) in prior.iter().zip(covariance.col_as_slice_mut(row - size)) {
                    *known = value - *known;
                }
            });
            (mean, covariance)
        })
    }
}

/// Conditioning on the request, which is the last group beyond the data.
impl<const D: usize> State<'_, D> {
    /// Prior mean of the request.
    fn requested_mean(&self) -> Vec<f64> {
        self.residual()[self.model.size..].iter().map(|residual| -residual).collect()
    }

    /// Prior covariances of the request with one row after the other.
    fn for_requested_rows(&self, rows: Range<usize>, mut visit: impl FnMut(usize, &[f64])) {
        let (last, mut scratch) = (self.model.groups.len() - 1, Scratch::default());
        let mut covariances = vec![0.0; self.model.groups[last].given.values.len()];
        for row in rows {
            covariances.fill(0.0);
            self.add_covariances([last, 0], row, &mut covariances, &mut scratch);
            visit(row, &covariances);
        }
    }

    /// Prior variances of the request.
    fn requested_variances(&self) -> Vec<f64> {
        let (last, mut scratch) = (self.model.groups.len() - 1, Scratch::default());
        let mut variances = vec![0.0; self.model.groups[last].given.values.len()];
        for (point, own) in variances.chunks_mut(1).enumerate() {
            self.add_covariances([last, point], self.model.size + point, own, &mut scratch);
        }
        variances
    }
}

/// Samples of a normal distribution, by the eigenvectors of its covariance.
fn drawn(mean: &[f64], covariance: &Mat<f64>, count: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
    let size = mean.len();
    let Ok(eigen) = SelfAdjointEigen::new(covariance.as_ref(), Triangle::Lower) else {
        return Err(GpError::NotPositiveDefinite { size, jitter: 0.0 });
    };
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let draw = |_| {
        let mut sample = mean.to_vec();
        for (mode, z) in standard_normals(size, &mut random).into_iter().enumerate() {
            // Rounding makes vanishing variances slightly negative.
            let factor = values[mode].max(0.0).sqrt() * z;
            sample.iter_mut().zip(vectors.col(mode).iter()).for_each(|(s, v)| *s += factor * v);
        }
        sample
    };
    Ok((0..count).map(draw).collect())
}
