//! How the positions at rest move with θ.

use super::state::{Level, Trial};
use super::{Unload, UnloadError, Unloaded};
use crate::SolveError;

/// Residual of the linear systems \[relative\].
const ACCURACY: f64 = 1e-13;

impl Unload<'_> {
    /// Derivative ∂X/∂θ of the positions at rest: one vector like [`Unloaded::motion`] per entry of θ.
    ///
    /// By the implicit function theorem, with exact derivatives throughout and one factorisation for all entries.
    ///
    /// # Errors
    /// The body of another image, or [`UnloadError::Singular`].
    pub fn sensitivity(&mut self, unloaded: &Unloaded) -> Result<Vec<Vec<f64>>, UnloadError> {
        let theta = &unloaded.theta;
        self.image.system.check_theta(theta).map_err(SolveError::from)?;
        crate::check::check_displacement(self.image.system.body, &unloaded.motion)?;
        let level = Level { factor: 1.0, theta: theta.clone() };
        let trial = Trial::new(&self.image, unloaded.motion.clone(), &level);
        let trial = trial.ok_or(UnloadError::Singular)?;
        let tangent = self.image.tangent(&trial, &level, None).ok_or(UnloadError::Singular)?;
        if !self.factor.factorise(&self.image.system.sparsity, &tangent.entries) {
            return Err(UnloadError::Singular);
        }
        let balance = (!self.image.system.has_potential()).then_some(&trial.rest);
        let system = self.image.system.like(&trial.rest.body, balance)?;
        let column = |index: usize| {
            let unit: Vec<_> = (0..theta.len()).map(|i| f64::from(u8::from(i == index))).collect();
            let mut right = system.rate_by_theta(&trial.displacement, theta, 1.0, &unit);
            right.iter_mut().for_each(|r| *r = -*r);
            let change = self.linear(&tangent.entries, &right, ACCURACY);
            let change = change.ok_or(UnloadError::Singular)?;
            let mut slope = vec![0.0; trial.motion.len()];
            self.image.system.sparsity.scatter(change, &mut slope);
            Ok(slope)
        };
        (0..theta.len()).map(column).collect()
    }
}
