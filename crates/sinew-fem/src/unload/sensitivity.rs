//! How the positions at rest move with θ.

use super::error::UnloadError;
use super::newton::Search;
use super::state::{Level, Trial};

/// Residual of the linear systems \[relative\].
const ACCURACY: f64 = 1e-13;

impl Search<'_> {
    /// Derivative of the positions at rest in each entry of θ, at a motion that is balanced.
    pub(super) fn sensitivity(
        &mut self,
        motion: &[f64],
        theta: &[f64],
    ) -> Result<Vec<Vec<f64>>, UnloadError> {
        let level = Level { factor: 1.0, theta: theta.to_vec() };
        let trial = Trial::new(&self.image, motion.to_vec(), &level);
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
