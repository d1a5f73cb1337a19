//! Several probable parameter vectors: predictions that include what is not known of them.

use crate::{Conditional, Fit, Functional, Model, Operator, Prediction, Result, Warning};
use sinew_num::try_in_parallel;
use sinew_sample::{quantile, split_seed};
use std::sync::Arc;

/// Draws from the posterior of all parameters of a model.
#[derive(Clone, Debug)]
pub struct Ensemble<const D: usize> {
    model: Arc<Model<D>>,
    /// Parameter vectors, on their scales, equally probable.
    pub draws: Vec<Vec<f64>>,
    /// Shape of the tail of the importance weights, for draws by [`crate::laplace`]: above 0.4 their averages cannot be trusted,
    /// and [`crate::nuts`] is the one to ask.
    pub k_hat: Option<f64>,
    /// Warnings about the draws; empty if no fault was found. [`crate::Fit::warnings`] are about the fit.
    pub warnings: Vec<Warning>,
    /// Positions of parameters that the data do not tell.
    unidentified: Vec<usize>,
}

impl<const D: usize> Ensemble<D> {
    /// Draws about a fit, with what they leave in doubt: the shape of their weights' tail, or a parameter of the equation, its R̂
    /// and effective draws.
    pub(crate) fn checked(
        fit: &Fit<D>,
        draws: Vec<Vec<f64>>,
        k_hat: Option<f64>,
        worst: Option<(usize, f64, f64)>,
    ) -> Result<Self> {
        fit.withheld().map_or(Ok(()), Err)?;
        let (model, unidentified) = (fit.model().clone(), Vec::new());
        let mut ensemble = Self { model, draws, k_hat, warnings: Vec::new(), unidentified };
        let heavy = k_hat.filter(|k_hat| *k_hat > TRUSTED);
        ensemble.warnings.extend(heavy.map(|k_hat| Warning::HeavyWeights { k_hat }));
        if let Some((parameter, r_hat, effective)) = worst {
            let parameter = fit.model().parameters()[parameter].name.clone();
            ensemble.warnings.push(Warning::NotMixed { parameter, r_hat, effective });
        }
        if ensemble.draws.is_empty() {
            return Ok(ensemble);
        }
        let (model, silent) = (fit.model(), fit.silent()?);
        ensemble.unidentified = silent.to_vec();
        for k in model.theta_range().filter(|k| !silent.contains(k)) {
            if model.is_wide(k, ensemble.draws.iter().map(|draw| (draw[k], 1.0))) {
                ensemble.unidentified.push(k);
                ensemble.warnings.push(model.unidentified(k));
                continue;
            }
            let name = &model.parameters()[k].name;
            let mode = fit.parameter(name)?;
            let [lower, upper] = ensemble.interval(name, NEARLY_ALL)?;
            if !(lower..=upper).contains(&mode) {
                let parameter = name.clone();
                ensemble.warnings.push(Warning::ModeApart { parameter, mode, lower, upper });
            }
        }
        Ok(ensemble)
    }

    /// Drawn values of a parameter by name, in its own unit.
    ///
    /// # Errors
    /// If no entry has that name.
    pub fn parameter(&self, name: &str) -> Result<Vec<f64>> {
        let position = self.model.position(name)?;
        let parameter = &self.model.parameters()[position];
        Ok(self.draws.iter().map(|draw| parameter.from_scale(draw[position])).collect())
    }

    /// Whether the data tell a parameter of the equation: its draws are not about as wide as its prior, and the probability of the data
    /// depends on it.
    ///
    /// # Errors
    /// If no entry has that name.
    pub fn identifies(&self, name: &str) -> Result<bool> {
        Ok(!self.unidentified.contains(&self.model.position(name)?))
    }

    /// The central interval of a parameter, in its own unit, that holds the share `level` of the draws: 0.95 for 95 %; of the prior,
    /// where the data do not tell it ([`Ensemble::identifies`]).
    /// Draws never reach a parameter's bounds: an end nearer to one than a tenth of the interval is that bound (where a
    /// normal density would have fallen to a sixteenth).
    ///
    /// # Errors
    /// If no entry has that name, there are no draws, or `level` does not lie between 0 and 1.
    pub fn interval(&self, name: &str, level: f64) -> Result<[f64; 2]> {
        const NEAR: f64 = 0.1;
        check_share(level)?;
        let parameter = &self.model.parameters()[self.model.position(name)?];
        let tails = [0.5 * (1.0 - level), 0.5 * (1.0 + level)];
        let [low, high] = parameter.bounds.map(|bound| parameter.to_scale(bound));
        let mut ends = match self.identifies(name)? {
            true => [self.quantile(name, tails[0])?, self.quantile(name, tails[1])?],
            false => tails.map(|tail| parameter.from_scale(low + tail * (high - low))),
        };
        let [lower, upper] = ends.map(|end| parameter.to_scale(end));
        for (end, bound) in ends.iter_mut().zip(parameter.bounds) {
            let distance = (parameter.to_scale(*end) - parameter.to_scale(bound)).abs();
            if distance < NEAR * (upper - lower) {
                *end = bound;
            }
        }
        Ok(ends)
    }

    /// Median of a parameter over the draws, in its own unit.
    ///
    /// # Errors
    /// If no entry has that name, or there are no draws.
    pub fn median(&self, name: &str) -> Result<f64> {
        self.quantile(name, 0.5)
    }

    /// The value of a parameter, in its own unit, below which a share of the draws lies: 0.5 for the median.
    ///
    /// # Errors
    /// As [`Ensemble::interval`].
    pub fn quantile(&self, name: &str, share: f64) -> Result<f64> {
        check_share(share)?;
        let values = self.parameter(name)?;
        ensure!(!values.is_empty(), "{NO_DRAWS}");
        Ok(quantile(&values, share))
    }

    /// Mean and standard deviation of u over the draws and over the process for each of them.
    ///
    /// # Errors
    /// If a feature has no derivative at a point, a draw's covariance cannot be factorised, or
    /// there are no draws.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction> {
        self.predict_operator(&Operator::identity(), points)
    }

    /// Mean and standard deviation of an operator applied to u, each draw with the operator's
    /// parameters as drawn: of a flux −D ∂u/∂x, what is not known of D counts too.
    ///
    /// # Errors
    /// As [`Ensemble::predict`]; and if the operator has parameters that the model lacks.
    pub fn predict_operator(&self, operator: &Operator<D>, at: &[[f64; D]]) -> Result<Prediction> {
        self.mixture(|conditional| conditional.predict_operator(operator, at))
    }

    /// Functions u drawn from the posterior, each by its values at the points and with parameters of its own.
    ///
    /// # Errors
    /// As [`Ensemble::predict`].
    pub fn sample(&self, points: &[[f64; D]], count: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
        ensure!(!self.draws.is_empty(), "{NO_DRAWS}");
        // Evenly over the draws, each with its own stream.
        let one = |number: usize| {
            let draw = &self.draws[number * self.draws.len() / count];
            let conditional = Conditional::new(self.model.clone(), draw)?;
            Ok(conditional.sample(points, 1, split_seed(seed, number as u64))?.remove(0))
        };
        try_in_parallel(0..count, one)
    }

    /// Mean and standard deviation of a weighted sum, as an integral; parameters as in
    /// [`Ensemble::predict_operator`].
    ///
    /// # Errors
    /// As [`Ensemble::predict_operator`].
    pub fn predict_functional(&self, functional: &Functional<D>) -> Result<(f64, f64)> {
        let sum = self.mixture(|conditional| {
            let (mean, deviation) = conditional.predict_functional(functional)?;
            Ok(Prediction { mean: vec![mean], standard_deviation: vec![deviation] })
        })?;
        Ok((sum.mean[0], sum.standard_deviation[0]))
    }

    /// All draws' predictions as one: the variance within them on average, and that between them.
    fn mixture(
        &self,
        predict: impl Fn(&Conditional<D>) -> Result<Prediction> + Sync,
    ) -> Result<Prediction> {
        let of = |draw: &Vec<f64>| predict(&Conditional::new(self.model.clone(), draw)?);
        let members = try_in_parallel(&self.draws, of)?;
        ensure!(!members.is_empty(), "{NO_DRAWS}");
        let values = members[0].mean.len();
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

/// Level of the interval that the most probable value is looked for in.
const NEARLY_ALL: f64 = 0.99;
/// Shape of the tail of importance weights up to which averages over them are trusted: their variance is finite up to 0.5 (Vehtari et
/// al. 2024), of which some hundred weights leave an uncertainty of a tenth.
pub(crate) const TRUSTED: f64 = 0.4;

fn check_share(share: f64) -> Result<()> {
    ensure!(
        (0.0..=1.0).contains(&share),
        "a level or share of {share}; give a number between 0 and 1, as 0.95"
    );
    Ok(())
}

const NO_DRAWS: &str = "the ensemble has no draws; keep at least one";
