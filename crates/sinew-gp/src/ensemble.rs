//! Several probable parameter vectors: predictions that include what is not known of them.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::GpError;
use crate::model::Model;
use crate::posterior::{Posterior, Prediction};

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

    /// The central interval of a parameter that holds the share `level` of the draws.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn interval(&self, name: &str, level: f64) -> Result<[f64; 2], GpError> {
        let mut values = self.parameter(name)?;
        values.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - level);
        Ok([tail, 1.0 - tail].map(|share| quantile(&values, share)))
    }

    /// Mean and standard deviation of u over the draws and over the process for each of them.
    ///
    /// # Errors
    /// If a feature has no derivative at a point, or a draw's covariance cannot be factorised.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction, GpError> {
        let members: Vec<Prediction> = self
            .draws
            .par_iter()
            .map(|draw| Posterior::new(self.model.clone(), draw)?.predict(points))
            .collect::<Result<_, _>>()?;
        let count = members.len().max(1) as f64;
        let average = |of: &dyn Fn(&Prediction) -> f64| members.iter().map(of).sum::<f64>() / count;
        let mean: Vec<f64> = (0..points.len()).map(|point| average(&|m| m.mean[point])).collect();
        let deviation = (0..points.len())
            .map(|point| {
                let within = average(&|m| m.deviation[point].powi(2));
                let between = average(&|m| (m.mean[point] - mean[point]).powi(2));
                (within + between).sqrt()
            })
            .collect();
        Ok(Prediction { mean, deviation })
    }
}

/// Of ascending values, by linear interpolation.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let position = share.clamp(0.0, 1.0) * last as f64;
    let below = position.floor() as usize;
    let fraction = position - below as f64;
    sorted[below] + fraction * (sorted[(below + 1).min(last)] - sorted[below])
}

#[cfg(test)]
mod tests {
    #[test]
    fn quantiles_interpolate() {
        let sorted = [1.0, 2.0, 4.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| super::quantile(&sorted, q)),
            [1.0, 1.5, 2.0, 3.0, 4.0]
        );
    }
}
