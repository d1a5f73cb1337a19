//! What the data say of u and of linear functionals of it.

use crate::coefficients::{PartCoefficients, PointCoefficients};
use crate::compile::check_roughness;
use crate::data::{Role, check_finite, check_places};
use crate::error::{GpError, check_lengths};
use crate::factor::Factor;
use crate::functional::Functional;
use crate::gram::{PairPlan, Scratch, Side};
use crate::model::{Model, spread};
use crate::operator::Operator;
use crate::state::{Factored, State, combine};
use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side as Triangle};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_sample::standard_normals;
use std::sync::Arc;

/// The Gaussian process conditioned on the data, at fixed parameters.
#[derive(Debug)]
pub struct Posterior<const D: usize> {
    pub(crate) model: Arc<Model<D>>,
    pub(crate) parameters: Vec<f64>,
    /// K⁻¹ (y − m).
    pub(crate) weights: Vec<f64>,
    factor: Factor,
    pub(crate) jitter: f64,
}

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

/// An operator compiled at test points.
struct Query<const D: usize> {
    points: PointCoefficients<D>,
    /// a_β of each part.
    coefficients: Vec<Vec<f64>>,
    mean: Vec<f64>,
    /// Plan of the points of each part with each other.
    own: Vec<PairPlan<D>>,
}

impl<const D: usize> Query<D> {
    fn side(&self, part: usize) -> Side<'_, D> {
        Side { axes: &self.points.parts[part].axes, coefficients: &self.coefficients[part] }
    }
}

impl<const D: usize> Posterior<D> {
    /// Posterior of `model` at `parameters` on their scales.
    ///
    /// # Errors
    /// If their number is wrong or the covariance is not positive definite.
    pub fn new(model: Arc<Model<D>>, parameters: &[f64]) -> Result<Self, GpError> {
        let Factored { factor, whitened: mut weights, jitter } =
            State::new(&model, parameters)?.factored()?;
        factor.backward(&mut weights);
        Ok(Self { model, parameters: parameters.to_vec(), weights, factor, jitter })
    }

    /// Relative jitter that the factorisation needed.
    pub fn jitter(&self) -> f64 {
        self.jitter
    }

    /// Mean and standard deviation of u. Points outside the domain are answered too, by continuation:
    /// no condition holds there, and deviations tell less than inside.
    ///
    /// # Errors
    /// If a point is not finite, or a feature has no derivative there.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction, GpError> {
        self.predict_operator(&Operator::identity(), points)
    }

    /// Mean of u only, which costs far less.
    ///
    /// # Errors
    /// As [`Posterior::predict`].
    pub fn mean(&self, points: &[[f64; D]]) -> Result<Vec<f64>, GpError> {
        self.mean_of(&Operator::identity(), points)
    }

    /// Mean of an operator applied to u, as a flux.
    ///
    /// # Errors
    /// As [`Posterior::predict`]; and if the operator has parameters that the model lacks, or takes
    /// more derivatives than are supported or the kernel's functions have.
    pub fn mean_of(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Vec<f64>, GpError> {
        let state = State::new(&self.model, &self.parameters)?;
        let query = self.query(&state, operator, points)?;
        let mut mean = query.mean.clone();
        self.for_columns(&state, &query, |column, covariances| {
            let weight = self.weights[column];
            mean.iter_mut().zip(covariances).for_each(|(m, c)| *m += weight * c);
        });
        Ok(mean)
    }

    /// Mean and standard deviation of an operator applied to u.
    ///
    /// # Errors
    /// As [`Posterior::mean_of`].
    pub fn predict_operator(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Prediction, GpError> {
        let state = State::new(&self.model, &self.parameters)?;
        let query = self.query(&state, operator, points)?;
        let (mean, whitened) = self.conditioned(&state, &query);
        let known = |point: usize| whitened.col(point).iter().map(|w| w * w).sum::<f64>();
        let left = Self::variances(&state, &query).into_iter().enumerate();
        let deviation = left.map(|(point, prior)| (prior - known(point)).max(0.0).sqrt());
        Ok(Prediction { mean, standard_deviation: deviation.collect() })
    }

    /// Mean and standard deviation of a weighted sum, as an integral.
    ///
    /// # Errors
    /// As [`Posterior::mean_of`]; and if there are not as many weights as points, or some are not
    /// finite.
    pub fn predict_functional(&self, functional: &Functional<D>) -> Result<(f64, f64), GpError> {
        let weights = &functional.weights;
        check_lengths(functional.points.len(), weights.len())?;
        check_finite("weight", weights.iter().enumerate())?;
        let (mean, covariance) = self.joint(&functional.operator, &functional.points)?;
        let value = mean.iter().zip(weights).map(|(m, w)| m * w).sum();
        let variance: f64 = (0..weights.len())
            .flat_map(|i| (0..weights.len()).map(move |j| (i, j)))
            .map(|(i, j)| weights[i] * covariance[(i, j)] * weights[j])
            .sum();
        Ok((value, variance.max(0.0).sqrt()))
    }

    /// Functions drawn from the posterior, each by its values at the points.
    ///
    /// # Errors
    /// As [`Posterior::predict`].
    pub fn sample(
        &self,
        points: &[[f64; D]],
        count: usize,
        seed: u64,
    ) -> Result<Vec<Vec<f64>>, GpError> {
        self.sample_operator(&Operator::identity(), points, count, seed)
    }

    /// Operator applied to functions drawn from the posterior, as samples of a flux along a wall.
    ///
    /// # Errors
    /// As [`Posterior::mean_of`].
    pub fn sample_operator(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
        count: usize,
        seed: u64,
    ) -> Result<Vec<Vec<f64>>, GpError> {
        let (mean, covariance) = self.joint(operator, points)?;
        let size = points.len();
        let Ok(eigen) = SelfAdjointEigen::new(covariance.as_ref(), Triangle::Lower) else {
            return Err(GpError::NotPositiveDefinite { size, jitter: 0.0 });
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| {
            let mut sample = mean.clone();
            for (mode, z) in standard_normals(size, &mut random).into_iter().enumerate() {
                // Rounding makes vanishing variances slightly negative.
                let factor = values[mode].max(0.0).sqrt() * z;
                sample.iter_mut().zip(vectors.col(mode).iter()).for_each(|(s, v)| *s += factor * v);
            }
            sample
        };
        Ok((0..count).map(draw).collect())
    }

    /// Whether what measured values differ by among themselves is taken for noise.
    pub(crate) fn is_collapsed(&self) -> bool {
        let Ok(state) = State::new(&self.model, &self.parameters) else { return false };
        let (mut left, mut variation) = (0.0, 0.0);
        let sigmas: Vec<f64> = state.sigmas().collect();
        for (group, sigma) in self.model.groups.iter().zip(&state.noise) {
            if group.role != Role::Observed || *sigma == 0.0 {
                continue;
            }
            // In units of the noise, so that groups of different units count alike. The posterior mean at an observation
            // is y − σ² α.
            left += group.rows().map(|row| (sigmas[row] * self.weights[row]).powi(2)).sum::<f64>();
            let spread = spread(&group.values).unwrap_or_default() / sigma;
            variation += spread * spread * group.values.len() as f64;
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

    /// Standard deviation of an operator before the data, root mean square over points.
    pub(crate) fn prior_deviation(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<f64, GpError> {
        let state = State::new(&self.model, &self.parameters)?;
        let query = self.query(&state, operator, points)?;
        let sum: f64 = Self::variances(&state, &query).iter().sum();
        Ok((sum / points.len().max(1) as f64).sqrt())
    }

    fn query(
        &self,
        state: &State<'_, D>,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Query<D>, GpError> {
        check_roughness(&self.model.prior, operator)?;
        check_places(points)?;
        let mut theta = self.model.theta.clone();
        let places = (points, "the prediction");
        let built = PointCoefficients::new(&self.model.prior, operator, places, &mut theta)?;
        if let Some(unknown) = theta.get(self.model.theta.len()) {
            self.model.position(unknown.name())?;
        }
        let monomials = built.factors(&state.theta);
        let mut mean = vec![0.0; points.len()];
        built.add_mean(&monomials, 1.0, &mut mean);
        let parts = || built.parts.iter().enumerate();
        let of = |(part, p): (usize, &PartCoefficients<D>)| {
            combine(state.kernels[part].0, &monomials, &p.arrays)
        };
        let coefficients = parts().map(of).collect();
        let own = parts().map(|(part, p)| self.plan(part, &p.orders, &p.orders)).collect();
        Ok(Query { coefficients, mean, own, points: built })
    }

    /// Covariances of the query with one observation after the other.
    fn for_columns(
        &self,
        state: &State<'_, D>,
        query: &Query<D>,
        mut visit: impl FnMut(usize, &[f64]),
    ) {
        let mut scratch = Scratch::default();
        let mut covariances = vec![0.0; query.points.count];
        for (number, group) in self.model.groups.iter().enumerate() {
            let legs = |part| state.legs_of(number).map(move |leg| (part, leg));
            let pairs = (0..query.points.parts.len()).flat_map(legs);
            let plans: Vec<_> = pairs
                .map(|(part, leg)| {
                    let second = &state.legs[leg].1.parts[part].orders;
                    (part, leg, self.plan(part, &query.points.parts[part].orders, second))
                })
                .collect();
            for own in 0..group.values.len() {
                covariances.fill(0.0);
                for (part, leg, plan) in &plans {
                    let second = state.side(*part, *leg);
                    let block = state.between(*part, plan, query.side(*part), second);
                    block.add_column(0, own, &mut covariances, &mut scratch);
                }
                visit(group.offset + own, &covariances);
            }
        }
    }

    fn plan(&self, part: usize, first: &[[usize; D]], second: &[[usize; D]]) -> PairPlan<D> {
        PairPlan::new(&*self.model.prior.parts[part].kernel, first, second)
    }

    /// Posterior mean, and L⁻¹ K_* with one column for each point.
    fn conditioned(&self, state: &State<'_, D>, query: &Query<D>) -> (Vec<f64>, Mat<f64>) {
        let mut cross = Mat::<f64>::zeros(self.model.size, query.points.count);
        self.for_columns(state, query, |row, covariances| {
            for (column, covariance) in covariances.iter().enumerate() {
                cross[(row, column)] = *covariance;
            }
        });
        let mut mean = query.mean.clone();
        for (column, mean) in mean.iter_mut().enumerate() {
            *mean += cross.col(column).iter().zip(&self.weights).map(|(c, w)| c * w).sum::<f64>();
        }
        solve_lower_triangular_in_place(self.factor.view(), cross.as_mut(), Par::Seq);
        (mean, cross)
    }

    /// Prior variances at the query's points.
    fn variances(state: &State<'_, D>, query: &Query<D>) -> Vec<f64> {
        let mut scratch = Scratch::default();
        let mut variances = vec![0.0; query.points.count];
        for (point, own) in variances.chunks_mut(1).enumerate() {
            Self::add_own(state, query, (point, point), own, &mut scratch);
        }
        variances
    }

    /// Prior covariances of the query's points from `first` on with point `column`.
    fn add_own(
        state: &State<'_, D>,
        query: &Query<D>,
        (first, column): (usize, usize),
        out: &mut [f64],
        scratch: &mut Scratch,
    ) {
        for (part, plan) in query.own.iter().enumerate() {
            let block = state.between(part, plan, query.side(part), query.side(part));
            block.add_column(first, column, out, scratch);
        }
    }

    /// Posterior mean and covariance of an operator at points.
    fn joint(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<(Vec<f64>, Mat<f64>), GpError> {
        let state = State::new(&self.model, &self.parameters)?;
        let query = self.query(&state, operator, points)?;
        let (mean, whitened) = self.conditioned(&state, &query);
        let mut covariance = whitened.transpose() * &whitened;
        let mut scratch = Scratch::default();
        let mut prior = vec![0.0; points.len()];
        for column in 0..points.len() {
            prior.fill(0.0);
            Self::add_own(&state, &query, (0, column), &mut prior, &mut scratch);
            for (row, value) in prior.iter().enumerate() {
                covariance[(row, column)] = value - covariance[(row, column)];
            }
        }
        Ok((mean, covariance))
    }
}
