//! Sensitivity of the positions at rest to θ.

use super::error::UnloadError;
use super::newton::Search;
use super::state::{Level, Trial};

/// Residual of the linear systems \[relative\].
const ACCURACY: f64 = 1e-13;

impl Search<'_> {
    /// Change of the positions at rest along directions in θ, at a motion that is balanced.
    pub(super) fn sensitivity(
        &mut self,
        motion: &[f64],
        theta: &[f64],
        directions: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, UnloadError> {
        let level = Level { factor: 1.0, theta: theta.to_vec() };
        let trial = Trial::new(&self.image, motion.to_vec(), &level);
        let trial = trial.ok_or(UnloadError::Singular)?;
        let tangent = self.image.tangent(&trial, &level, None).ok_or(UnloadError::Singular)?;
        if !self.factor.factorise(&self.image.system.sparsity, &tangent.entries) {
            return Err(UnloadError::Singular);
        }
        let system = self.image.system_of(&trial.rest)?;
        let column = |direction: &Vec<f64>| {
            let mut right = system.rate_by_theta(&trial.displacement, theta, 1.0, direction);
            right.iter_mut().for_each(|r| *r = -*r);
            let change = self.linear(&tangent.entries, &right, ACCURACY);
            let change = change.ok_or(UnloadError::Singular)?;
            let mut slope = vec![0.0; trial.motion.len()];
            self.image.system.sparsity.scatter(change, &mut slope);
            Ok(slope)
        };
        directions.iter().map(column).collect()
    }
}
