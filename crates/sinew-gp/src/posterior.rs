//! Posterior of u and of the parameters: at one set of parameters, over draws of them, and the answer in short.

pub(crate) mod conditional;
pub(crate) mod ensemble;
pub(crate) mod laplace;
pub(crate) mod space;

use crate::{Ensemble, Fit, Prediction, Result, Warning, ensemble};
use std::fmt;

/// Draws and seed of a fit's own ensemble.
const DRAWS: usize = 300;
const SEED: u64 = 0x1eaf;

impl<const D: usize> Fit<D> {
    /// The fit's own ensemble of 300 draws, made when it is first asked for ([`crate::ensemble`]).
    ///
    /// # Errors
    /// As [`crate::ensemble`].
    pub fn ensemble(&self) -> Result<&Ensemble<D>> {
        let made = self.ensemble.get_or_init(|| ensemble(self, DRAWS, SEED));
        made.as_ref().map_err(Clone::clone)
    }

    /// The central interval of a parameter that holds the share `level` of the fit's own ensemble, and the most probable value.
    ///
    /// # Errors
    /// As [`Ensemble::interval`] and [`Fit::ensemble`].
    pub fn interval(&self, name: &str, level: f64) -> Result<[f64; 2]> {
        let ([lower, upper], found) =
            (self.ensemble()?.interval(name, level)?, self.parameter(name)?);
        Ok([lower.min(found), upper.max(found)])
    }

    /// Posterior mean and standard deviation of u, marginalised over parameters, lengthscales and noise. [`Fit::conditional`] takes these as known.
    ///
    /// # Errors
    /// As [`Ensemble::predict`] and [`Fit::ensemble`].
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction> {
        self.ensemble()?.predict(points)
    }

    /// A parameter with its interval, in words.
    fn told(&self, name: &str) -> Result<String> {
        let told = match self.ensemble()?.identifies(name)? {
            true => format!("{:.4e}, 95 %", self.parameter(name)?),
            false => "unidentified, 95 % of its prior".into(),
        };
        let [lower, upper] = self.interval(name, 0.95)?;
        Ok(format!("{name} {told} between {lower:.4e} and {upper:.4e}"))
    }
}

/// Parameters of the equation and levels of noise with 95 % intervals, then all warnings.
impl<const D: usize> fmt::Display for Fit<D> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = self.model();
        let learned = model.groups.iter().filter_map(|group| group.learned);
        for position in model.theta_range().chain(learned) {
            let name = &model.parameters()[position].name;
            let told = self.told(name).unwrap_or_else(|error| format!("{name}: {error}"));
            writeln!(formatter, "{told}")?;
        }
        let of_fit = match self.warnings() {
            Ok(warnings) => warnings.iter().map(Warning::to_string).collect(),
            Err(error) => vec![error.to_string()],
        };
        let of_draws = self.ensemble().into_iter().flat_map(|ensemble| &ensemble.warnings);
        let mut warnings = of_fit.into_iter().chain(of_draws.map(Warning::to_string));
        warnings.try_for_each(|warning| writeln!(formatter, "warning: {warning}"))
    }
}
