//! Several probable parameter vectors: predictions that include what is not known of them.

use crate::error::GpError;
use crate::functional::Functional;
use crate::model::Model;
use crate::operator::Operator;
use crate::posterior::{Posterior, Prediction};
use rayon::prelude::*;
use std::sync::Arc;

/// Draws from the posterior of all parameters of a model.
#[derive(Clone, Debug)]
pub struct Ensemble<const D: usize> {
    model: Arc<Model<D>>,
    /// Parameter vectors, on their scales, equally probable.
    pub draws: Vec<Vec<f64>>,
}

impl<const D: usize> Ensemble<D> {
    pub(crate) fn new(model: Arc<Model<D>>, draws: Vec<Vec<f64>>) -> Self {
        Self { model, draws }
    }

    /// Drawn values of a parameter by name, in its own unit.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn parameter(&self, name: &str) -> Result<Vec<f64>, GpError> {
        let position = self.model.position(name)?;
        let parameter = &self.model.parameters()[position];
        Ok(self.draws.iter().map(|draw| parameter.from_scale(draw[position])).collect())
    }

    /// The central interval of a parameter, in its own unit, that holds the share `level` of the draws: 0.95 for 95 %.
    /// Draws never reach a parameter's bounds: an end nearer to one than a tenth of the interval is that bound (where a
    /// normal density would have fallen to a sixteenth).
    ///
    /// # Errors
    /// If there is none of that name, there are no draws, or `level` does not lie between 0 and 1.
    pub fn interval(&self, name: &str, level: f64) -> Result<[f64; 2], GpError> {
        const NEAR: f64 = 0.1;
        check_share(level)?;
        let parameter = &self.model.parameters()[self.model.position(name)?];
        let tail = 0.5 * (1.0 - level);
        let mut ends = [self.quantile(name, tail)?, self.quantile(name, 1.0 - tail)?];
        let [lower, upper] = ends.map(|end| parameter.to_scale(end));
        for (end, bound) in ends.iter_mut().zip(parameter.bounds) {
            let distance = (parameter.to_scale(*end) - parameter.to_scale(bound)).abs();
            if distance < NEAR * (upper - lower) {
                *end = bound;
            }
        }
        Ok(ends)
    }

    /// Mean of a parameter over the draws, in its own unit.
    ///
    /// # Errors
    /// If there is none of that name, or there are no draws.
    pub fn mean(&self, name: &str) -> Result<f64, GpError> {
        let values = self.parameter(name)?;
        match values.len() {
            0 => Err(no_draws()),
            count => Ok(values.iter().sum::<f64>() / count as f64),
        }
    }

    /// Median of a parameter over the draws, in its own unit.
    ///
    /// # Errors
    /// As [`Ensemble::mean`].
    pub fn median(&self, name: &str) -> Result<f64, GpError> {
        self.quantile(name, 0.5)
    }

    /// The value of a parameter, in its own unit, below which a share of the draws lies: 0.5 for the median.
    ///
    /// # Errors
    /// As [`Ensemble::interval`].
    pub fn quantile(&self, name: &str, share: f64) -> Result<f64, GpError> {
        check_share(share)?;
        let mut values = self.parameter(name)?;
        if values.is_empty() {
            return Err(no_draws());
        }
        values.sort_by(f64::total_cmp);
        Ok(quantile(&values, share))
    }

    /// Mean and standard deviation of u over the draws and over the process for each of them.
    ///
    /// # Errors
    /// If a feature has no derivative at a point, a draw's covariance cannot be factorised, or
    /// there are no draws.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction, GpError> {
        self.predict_operator(&Operator::identity(), points)
    }

    /// Mean and standard deviation of an operator applied to u, each draw with the operator's
    /// parameters as drawn: of a flux −D ∂u/∂x, what is not known of D counts too.
    ///
    /// # Errors
    /// As [`Ensemble::predict`]; and if the operator has parameters that the model lacks.
    pub fn predict_operator(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Prediction, GpError> {
        self.mixture(|posterior| posterior.predict_operator(operator, points))
    }

    /// Mean and standard deviation of a weighted sum, as an integral; parameters as in
    /// [`Ensemble::predict_operator`].
    ///
    /// # Errors
    /// As [`Ensemble::predict_operator`].
    pub fn predict_functional(&self, functional: &Functional<D>) -> Result<(f64, f64), GpError> {
        let sum = self.mixture(|posterior| {
            let (mean, deviation) = posterior.predict_functional(functional)?;
            Ok(Prediction { mean: vec![mean], standard_deviation: vec![deviation] })
        })?;
        Ok((sum.mean[0], sum.standard_deviation[0]))
    }

    /// All draws' predictions as one: the variance within them on average, and that between them.
    fn mixture(
        &self,
        predict: impl Fn(&Posterior<D>) -> Result<Prediction, GpError> + Sync,
    ) -> Result<Prediction, GpError> {
        let members: Vec<Prediction> = self
            .draws
            .par_iter()
            .map(|draw| predict(&Posterior::new(self.model.clone(), draw)?))
            .collect::<Result<_, _>>()?;
        let values = members.first().ok_or_else(no_draws)?.mean.len();
        let count = members.len() as f64;
        let average = |of: &dyn Fn(&Prediction) -> f64| members.iter().map(of).sum::<f64>() / count;
        let mean: Vec<f64> = (0..values).map(|value| average(&|m| m.mean[value])).collect();
        let deviation = |value: usize| {
            let within = average(&|m| m.standard_deviation[value].powi(2));
            let between = average(&|m| (m.mean[value] - mean[value]).powi(2));
            (within + between).sqrt()
        };
        let standard_deviation = (0..values).map(deviation).collect();
        Ok(Prediction { mean, standard_deviation })
    }
}

fn check_share(share: f64) -> Result<(), GpError> {
    match (0.0..=1.0).contains(&share) {
        true => Ok(()),
        false => Err(GpError::Request(format!(
            "a level or share of {share}; give a number between 0 and 1, as 0.95"
        ))),
    }
}

fn no_draws() -> GpError {
    GpError::Request("the ensemble has no draws; keep at least one".into())
}

/// Quantile of ascending values, at least one, by linear interpolation.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len() - 1;
    let position = share.clamp(0.0, 1.0) * last as f64;
    let below = position.floor() as usize;
    let fraction = position - below as f64;
    sorted[below] + fraction * (sorted[(below + 1).min(last)] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Condition, Data, Domain, Evidence, Noise, Parameter, Prior, Problem, Side,
        SquaredExponential, constant,
    };

    #[test]
    fn quantiles_interpolate() {
        let sorted = [1.0, 2.0, 4.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| quantile(&sorted, q)),
            [1.0, 1.5, 2.0, 3.0, 4.0]
        );
    }

    /// D u″ = −1 with u(0) = 0, and an ensemble of two draws whose D are far apart.
    fn spring() -> Result<(Ensemble<1>, Operator<1>, Domain<1>), GpError> {
        let domain = Domain::interval("x", [0.0, 1.0])?;
        let [dx] = domain.derivatives();
        let stiffness = Parameter::new("D", [0.1, 10.0])?;
        let problem = Problem::new(domain.clone(), &stiffness * dx * dx)?.condition(
            "x",
            Side::Lower,
            Condition::Dirichlet(constant(0.0)),
        )?;
        let prior = Prior::constrained(&problem, &SquaredExponential::new())?;
        let data = Data::new().values(&[[0.3], [0.8]], &[0.2, 0.4], Noise::Known(0.01)).equation(
            &[[0.2], [0.6]],
            &[-1.0; 2],
            Noise::Exact,
        );
        let model = Arc::new(Model::new(prior, data, Evidence::Joint)?);
        let position = model.position("D")?;
        let draws = [0.3, 3.0].map(|value| {
            let mut draw = vec![0.0; model.parameters().len()];
            draw[position] = model.parameters()[position].to_scale(value);
            draw
        });
        let ensemble = Ensemble::new(model, draws.to_vec());
        Ok((ensemble, &stiffness * dx, domain))
    }

    #[test]
    fn an_operators_parameters_are_those_of_each_draw() -> Result<(), GpError> {
        let (ensemble, flux, domain) = spring()?;
        let [dx] = domain.derivatives();
        let values = ensemble.parameter("D")?;
        assert!((values[0] - 0.3).abs() < 1e-12 && (values[1] - 3.0).abs() < 1e-12);
        // By hand: the slope under each draw times its D.
        let members: Vec<(f64, f64)> = std::iter::zip(&ensemble.draws, &values)
            .map(|(draw, stiffness)| {
                let posterior = Posterior::new(ensemble.model.clone(), draw)?;
                let slope = posterior.predict_operator(&dx.into(), &[[0.9]])?;
                Ok((stiffness * slope.mean[0], stiffness * slope.standard_deviation[0]))
            })
            .collect::<Result<_, GpError>>()?;
        let [(a, s), (b, t)] = [members[0], members[1]];
        let mean = 0.5 * (a + b);
        let deviation = (0.5 * (s * s + t * t) + 0.25 * (a - b).powi(2)).sqrt();
        assert!((a - b).abs() > 0.1 * deviation, "the draws differ: {members:?}");
        // Rounding of a well-conditioned 4 × 4 solution.
        const TOLERANCE: f64 = 1e-9;
        let found = ensemble.predict_operator(&flux, &[[0.9]])?;
        assert!((found.mean[0] - mean).abs() < TOLERANCE * mean.abs(), "{found:?}, not {mean}");
        assert!(
            (found.standard_deviation[0] - deviation).abs() < TOLERANCE * deviation,
            "{deviation}"
        );
        // A functional of one point is the same thing, and so are weights that cancel.
        let sum =
            Functional { operator: flux, points: vec![[0.9]; 3], weights: vec![1.0, 2.0, -1.0] };
        let (twice, spread) = ensemble.predict_functional(&sum)?;
        assert!((twice - 2.0 * mean).abs() < TOLERANCE * mean.abs(), "{twice}");
        assert!((spread - 2.0 * deviation).abs() < 1e-6 * deviation, "{spread}");
        Ok(())
    }

    #[test]
    fn without_draws_there_is_no_prediction() -> Result<(), GpError> {
        let (mut ensemble, ..) = spring()?;
        for level in [95.0, -0.1, f64::NAN] {
            let refused = ensemble.interval("D", level).unwrap_err().to_string();
            assert!(refused.contains("between 0 and 1"), "{level}: {refused}");
        }
        ensemble.draws.clear();
        assert_eq!(ensemble.predict(&[[0.5]]).unwrap_err(), no_draws());
        assert_eq!(ensemble.interval("D", 0.95).unwrap_err(), no_draws());
        Ok(())
    }
}
