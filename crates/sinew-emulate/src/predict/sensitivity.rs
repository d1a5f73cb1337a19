//! Sensitivity of an emulator's displacements to the parameters.

use crate::estimate::evaluate::TestSet;
use crate::parameters::check_length;
use crate::{Emulator, Result};
use sinew_fem::Options;
use sinew_num::norm;

/// Least denominator of a sensitivity error: this share of the displacement over the parameter's range.
const LEAST_MOTION: f64 = 1e-3;
/// Cases behind a median.
const CASES: usize = 10;

impl Emulator<'_> {
    /// `∂û/∂θ` at θ: for every parameter a field, node by node [length per unit of the parameter]. Exact for a network, in
    /// forward mode through its decoders; by central differences for a regression.
    ///
    /// # Errors
    /// As [`Emulator::predict`].
    pub fn sensitivity(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        check_length(self.body, theta)?;
        self.predictor.sensitivity(self.body, theta)
    }

    /// Median over the first cases of `‖∂û/∂θ − ∂u/∂θ‖ / ‖∂u/∂θ‖` [%] for every parameter, the true derivative by the implicit
    /// function theorem. The denominator is at least a thousandth of `‖u‖` over the parameter's range.
    pub(crate) fn sensitivity_errors(&self, test: &TestSet<'_>) -> Result<Vec<f64>> {
        let mut errors = vec![Vec::new(); self.body.parameters.len()];
        for (theta, field) in test.thetas.iter().zip(&test.fields).take(CASES) {
            let truth = self.solvers.with(|solver| {
                let solution = solver.solve_from(field, theta, &Options::default())?;
                solver.sensitivity(&solution)
            })?;
            for (p, (own, truth)) in self.sensitivity(theta)?.iter().zip(&truth).enumerate() {
                let apart: Vec<f64> = own.iter().zip(truth).map(|(a, b)| a - b).collect();
                let [low, high] = self.body.parameters[p].range;
                let least = LEAST_MOTION * norm(field) / (high - low);
                let size = norm(truth).max(least);
                errors[p].push(if size > 0.0 { 100.0 * norm(&apart) / size } else { 0.0 });
            }
        }
        Ok(errors.iter().map(|errors| crate::estimate::timing::median(errors)).collect())
    }
}
