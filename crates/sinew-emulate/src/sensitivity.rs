//! How an emulator's displacements change with its parameters.

use crate::emulator::Model;
use crate::evaluate::TestSet;
use crate::parameters::check_length;
use crate::{Emulator, Result};
use sinew_fem::Options;

/// Step of central differences through a regression, as a share of a parameter's range: its coefficients are smooth, and
/// half of the digits of a double is left.
const STEP: f64 = 1e-5;
/// Share of the displacement that a parameter must move over its range to count as one that moves the body at all.
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
        let regressed = match &self.model {
            Model::Network(network) => {
                let found = network.fixed.sensitivity(&[theta.to_vec()])?.derivative;
                let length = found.len() / theta.len();
                return Ok(found.chunks(length).map(<[f64]>::to_vec).collect());
            }
            Model::Regressed(regressed) => regressed,
        };
        let derivative = |p: usize| -> Result<Vec<f64>> {
            let [low, high] = self.body.parameters[p].range;
            let step = STEP * (high - low);
            let at = |sign: f64| {
                let mut moved = theta.to_vec();
                moved[p] += sign * step;
                regressed.predict(self.body, &moved)
            };
            let (ahead, behind) = (at(1.0)?, at(-1.0)?);
            Ok(ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect())
        };
        (0..theta.len()).map(derivative).collect()
    }

    /// Median over the first cases of `‖∂û/∂θ − ∂u/∂θ‖ / ‖∂u/∂θ‖` [%] for every parameter, the true derivative by the implicit
    /// function theorem. A parameter that moves the body by less than a thousandth over its range is measured against that.
    pub(crate) fn sensitivity_errors(&self, test: &TestSet<'_>) -> Result<Vec<f64>> {
        let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut errors = vec![Vec::new(); self.body.parameters.len()];
        for (theta, field) in test.thetas.iter().zip(&test.fields).take(CASES) {
            let truth = self.with_solver(|solver| {
                let solution = solver.solve_from(field, theta, &Options::default())?;
                Ok(solver.sensitivity(&solution)?)
            })?;
            for (p, (own, truth)) in self.sensitivity(theta)?.iter().zip(&truth).enumerate() {
                let apart: Vec<f64> = own.iter().zip(truth).map(|(a, b)| a - b).collect();
                let [low, high] = self.body.parameters[p].range;
                let least = LEAST_MOTION * norm(field) / (high - low);
                let size = norm(truth).max(least);
                errors[p].push(if size > 0.0 { 100.0 * norm(&apart) / size } else { 0.0 });
            }
        }
        Ok(errors.iter().map(|errors| crate::timing::median(errors)).collect())
    }
}
