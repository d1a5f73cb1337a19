//! The likelihood of data with correlated errors, and the posterior over an emulator.

use crate::polynomial::Polynomial;
use crate::problem::FACTOR_DEVIATION;
use crate::{Datum, Observed, Problem};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use sinew_sample::LogDensity;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Covariance of the errors of all data, in units of their given standard deviations, factorised.
#[derive(Clone)]
pub(crate) struct Noise {
    pub factor: Cholesky<f64, Dyn>,
    log_determinant: f64,
}

impl Noise {
    /// Noise from the logarithms of the factors of inferred kinds, and the covariance that an emulator adds.
    pub(crate) fn new(problem: &Problem, factors: &[f64], emulator: Option<&DMatrix<f64>>) -> Self {
        let count = problem.data.len();
        let mut covariance = emulator.cloned().unwrap_or_else(|| DMatrix::zeros(count, count));
        for at in 0..count {
            covariance[(at, at)] += (2.0 * problem.log_factor(at, factors)).exp();
        }
        for kind in problem.kinds.iter().filter(|kind| kind.bias > 0.0) {
            let share = |d: &Datum| if d.kind == kind.name { kind.bias / d.error() } else { 0.0 };
            let shares = DVector::from_iterator(count, problem.data.iter().map(share));
            covariance += &shares * shares.transpose();
        }
        Self::of(covariance).expect("positive variances on the diagonal")
    }

    /// Noise of a covariance, if it is positive definite.
    pub(crate) fn of(covariance: DMatrix<f64>) -> Option<Self> {
        let factor = Cholesky::new(covariance)?;
        let log_determinant = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        Some(Self { factor, log_determinant })
    }

    /// Logarithm of the likelihood of r, up to a constant, and Σ⁻¹ r.
    pub(crate) fn log_likelihood(&self, residual: &DVector<f64>) -> (f64, DVector<f64>) {
        let solved = self.factor.solve(residual);
        (-0.5 * (self.log_determinant + residual.dot(&solved)), solved)
    }

    /// Logarithm of the density of each datum, given the others.
    pub(crate) fn one_by_one(&self, residual: &DVector<f64>) -> Vec<f64> {
        let precision = self.factor.inverse();
        let solved = &precision * residual;
        let of = |(own, solved): (&f64, &f64)| 0.5 * ((own / TAU).ln() - solved.powi(2) / own);
        precision.diagonal().iter().zip(&solved).map(of).collect()
    }
}

impl Problem {
    /// Logarithm of the likelihood of observables at coordinates, up to a constant.
    pub(crate) fn log_likelihood(&self, y: &[f64], observed: &Observed) -> f64 {
        self.noise(y).log_likelihood(&self.residual(&observed.values)).0
    }

    /// Noise of the data at coordinates.
    pub(crate) fn noise(&self, y: &[f64]) -> Noise {
        Noise::new(self, &self.log_factors(y), None)
    }

    /// Misfits of observables over their given standard deviations.
    pub(crate) fn residual(&self, observed: &[f64]) -> DVector<f64> {
        &self.measured - self.scaled(observed)
    }

    /// Sum of squared misfits by the noise at coordinates.
    pub(crate) fn squares(&self, y: &[f64], observed: &[f64]) -> f64 {
        let residual = self.residual(observed);
        residual.dot(&self.noise(y).factor.solve(&residual))
    }

    /// Logarithm of the density of each datum, in its own unit, given the parameters and, where errors are shared, the other data.
    pub(crate) fn log_likelihoods(&self, y: &[f64], observed: &[f64]) -> Vec<f64> {
        let found = self.noise(y).one_by_one(&self.residual(observed));
        let unit = |datum: &Datum| (datum.slope(datum.value) * datum.size).ln();
        found.iter().zip(&self.data).map(|(found, datum)| found + unit(datum)).collect()
    }

    /// Logarithm of the posterior density of coordinates with the observables that a model has there, up to a constant.
    pub fn log_posterior(&self, y: &[f64], observed: &Observed) -> f64 {
        self.log_likelihood(y, observed) - 0.5 * y.iter().map(|y| y * y).sum::<f64>()
    }
}

/// Posterior over an emulator: coordinates of the parameters, then logarithms of factors of noise over their prior's standard
/// deviation.
pub(crate) struct Target<'a> {
    pub problem: &'a Problem,
    pub emulator: &'a Polynomial,
    /// Noise, where no factor is inferred.
    fixed: Option<Noise>,
    /// Power of the likelihood: below 1 it has wider tails.
    power: f64,
}

impl<'a> Target<'a> {
    pub(crate) fn new(problem: &'a Problem, emulator: &'a Polynomial, power: f64) -> Self {
        let none = problem.inferred() == 0;
        let fixed = none.then(|| Noise::new(problem, &[], Some(&emulator.leave_one_out)));
        Self { problem, emulator, fixed, power }
    }

    /// Emulated observables of the data in standard deviations.
    pub(crate) fn predicted(&self, y: &[f64]) -> DVector<f64> {
        self.emulator.at(&self.problem.standardised(y)).0
    }

    /// Logarithm of the emulator's likelihood.
    pub(crate) fn log_likelihood(&self, y: &[f64]) -> f64 {
        let residual = &self.problem.measured - self.predicted(y);
        self.power * self.noise(y).log_likelihood(&residual).0
    }

    fn noise(&self, y: &[f64]) -> Cow<'_, Noise> {
        let (factors, error) = (self.problem.log_factors(y), &self.emulator.leave_one_out);
        let own = || Cow::Owned(Noise::new(self.problem, &factors, Some(error)));
        self.fixed.as_ref().map_or_else(own, Cow::Borrowed)
    }
}

impl LogDensity for Target<'_> {
    fn dimension(&self) -> usize {
        self.problem.dimension()
    }

    fn value_and_gradient(&self, y: &[f64], gradient: &mut [f64]) -> f64 {
        let problem = self.problem;
        let (values, slopes) = self.emulator.at(&problem.standardised(y));
        let residual = &problem.measured - values;
        let noise = self.noise(y);
        let (log_likelihood, solved) = noise.log_likelihood(&residual);
        let pulled = slopes.tr_mul(&solved);
        for (at, unknown) in problem.unknowns.iter().enumerate() {
            let [_, deviation] = unknown.prior.moments();
            gradient[at] = pulled[at] * unknown.prior.logarithm(y[at])[1] / deviation;
        }
        if problem.inferred() > 0 {
            // In the coordinates of the factors: −½ tr(Σ⁻¹ Σ') + ½ αᵀ Σ' α with α = Σ⁻¹ r.
            // The diagonal of Σ⁻¹ = L⁻ᵀ L⁻¹ holds the squared norms of the columns of L⁻¹.
            let mut inverse = DMatrix::identity(solved.len(), solved.len());
            noise.factor.l_dirty().solve_lower_triangular_mut(&mut inverse);
            let factors = problem.log_factors(y);
            let of_noise = &mut gradient[problem.unknowns.len()..];
            of_noise.fill(0.0);
            for at in 0..problem.data.len() {
                let Some(place) = problem.factor_of(at) else { continue };
                let variance = (2.0 * problem.log_factor(at, &factors)).exp();
                let slope =
                    variance * (solved[at] * solved[at] - inverse.column(at).norm_squared());
                of_noise[place] += FACTOR_DEVIATION * slope;
            }
        }
        gradient.iter_mut().zip(y).for_each(|(slope, y)| *slope = self.power * *slope - y);
        let prior: f64 = y.iter().map(|y| y * y).sum();
        self.power * log_likelihood - 0.5 * prior
    }
}
