//! Nonlinear equations with their uncertainty: the variational bound of §5.1 of the thesis.
//!
//! The equation takes values of u through d₀ = L u and dᵢ = Dᵢ u at the collocation points. These are
//! normal before the data; after them they are not, and the normal distribution q is sought that
//! maximises the bound E_q ln p(y_u, y_f | u, d) − KL(q ‖ prior) on ln p(y_u, y_f), together with the
//! kernel's and the noises' parameters and, if asked, the equation's (5.4–5.6).
//!
//! q is the prior times one Gaussian site for each point, as is the best of all normal distributions
//! (Opper & Archambeau 2009); sites follow from q by natural gradients (Khan & Lin 2017). Parameters
//! are found for fixed sites, and sites for fixed parameters, by turns: the bound never falls.

use super::bound::Inference;
use super::{SemiLinear, Solution};
use crate::data::Data;
use crate::ensemble::mixture;
use crate::error::GpError;
use crate::kernel::Kernel;
use crate::laplace::laplace;
use crate::model::Model;
use crate::optimise::minimise;
use crate::posterior::{Posterior, Prediction};
use rayon::prelude::*;
use std::sync::Arc;

/// How a variational bound is maximised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VariationalOptions {
    /// Turns of sites and parameters at most.
    pub rounds: usize,
    /// Iterations for the parameters in each turn at most; none leaves them as they start.
    pub iterations: usize,
    /// Whether the equation's parameters move with the others, as in the thesis. Like the joint evidence the
    /// bound then says of them how far u is from draws of the prior, too: where the data hardly
    /// determine them they are biased. Otherwise they stay where the solution by linearisation has
    /// them, which only asks how well the data are predicted.
    pub equation: bool,
    /// Probable values of the equation's parameters that [`Variational::predict`] averages over: as far
    /// from those found as draws by [`laplace`] from the solution by linearisation are from its own.
    /// None takes the parameters for known.
    pub draws: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for VariationalOptions {
    fn default() -> Self {
        Self { rounds: 100, iterations: 20, equation: false, draws: 30, seed: 0 }
    }
}

/// A normal approximation to what the data say of u under a nonlinear equation.
#[derive(Debug)]
pub struct Variational<const D: usize> {
    model: Arc<Model<D>>,
    posterior: Posterior<D>,
    /// For each draw of the equation's parameters.
    members: Vec<Posterior<D>>,
    /// Parameters of kernel, equation and noise, on their scales.
    pub parameters: Vec<f64>,
    /// Lower bound of ln p(y_u, y_f).
    pub bound: f64,
    /// Bound plus logarithm of the prior density of the parameters, after each turn.
    pub trace: Vec<f64>,
    /// Whether the last turn gained next to nothing.
    pub settled: bool,
}

/// Gain of a turn, in units of the evidence's logarithm, below which the bound has settled.
const GAIN: f64 = 1e-4;

impl<const D: usize> Variational<D> {
    /// The model, with all parameters.
    pub fn model(&self) -> &Arc<Model<D>> {
        &self.model
    }

    /// Value of a parameter by name, in its own unit.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn parameter(&self, name: &str) -> Result<f64, GpError> {
        let position = self.model.position(name)?;
        Ok(self.model.parameters()[position].from_scale(self.parameters[position]))
    }

    /// What is known of u at the parameters found: p̂ of (5.6).
    pub fn posterior(&self) -> &Posterior<D> {
        &self.posterior
    }

    /// Mean and standard deviation of u, what is not known of the equation's parameters included.
    ///
    /// # Errors
    /// If a feature has no derivative at a point.
    pub fn predict(&self, points: &[[f64; D]]) -> Result<Prediction, GpError> {
        let members = self.members.par_iter().map(|posterior| posterior.predict(points));
        let members: Vec<Prediction> = members.collect::<Result<_, _>>()?;
        mixture(&members).map_or_else(|| self.posterior.predict(points), Ok)
    }
}

impl<const D: usize, const M: usize> SemiLinear<D, M> {
    /// Maximises the variational bound, from the solution `start` by linearisation.
    ///
    /// The equation in `data` must have a noise, best [`crate::Noise::Learned`]: what is left of it
    /// where q has done its best. (If it held exactly, u would lie on a curved surface, and no normal
    /// distribution but a point does.) Exact values of u are taken to be known to a
    /// hundred-thousandth of their spread.
    ///
    /// ```
    /// use sinew_gp::{
    ///     Condition, Data, Derivative, Domain, FitOptions, Noise, Problem, SemiLinear, Side,
    ///     SquaredExponential, VariationalOptions, constant,
    /// };
    ///
    /// // −u″ + 20 u³ = f, a string on a stiffening bed, under a load known at five places.
    /// let span = Domain::interval("x", [0.0, 1.0])?;
    /// let [dx] = span.derivatives();
    /// let held = || Condition::Dirichlet(constant(0.0));
    /// let string = Problem::new(span, -(dx * dx))?
    ///     .condition("x", Side::Lower, held())?
    ///     .condition("x", Side::Upper, held())?;
    /// let bed = SemiLinear::new(string, [Derivative::identity()], |[u]| u.powi(3) * 20.0);
    /// let at = [[0.1], [0.3], [0.5], [0.7], [0.9]];
    /// let data = Data::new().equation(&at, &[1.0, 4.0, 9.0, 4.0, 1.0], Noise::Known(1.0));
    ///
    /// let kernel = SquaredExponential::new();
    /// let linear = bed.solve(&kernel, &data, &FitOptions::default(), 20)?;
    /// let found = bed.variational(&linear, &kernel, &data, &VariationalOptions::default())?;
    /// let middle = found.posterior().predict(&[[0.5]])?;
    /// // 0.482 by finite differences, the load drawn straight from place to place.
    /// assert!((middle.mean[0] - 0.482).abs() < 2.0 * middle.standard_deviation[0]);
    /// assert!(middle.standard_deviation[0] < 0.05);
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    ///
    /// Parameters inside the term stay where `start` has them.
    ///
    /// # Errors
    /// If the equation is exact, its term is not finite over the spread of u at the start, or it has
    /// parameters that the equation of `start` lacks.
    pub fn variational(
        &self,
        start: &Solution<D>,
        kernel: &dyn Kernel<D>,
        data: &Data<D>,
        options: &VariationalOptions,
    ) -> Result<Variational<D>, GpError> {
        let held = self.held(self.theta(Some(&start.fit)));
        let inference = Inference::new(&held, start, kernel, data)?;
        let model = &inference.model;
        let mut parameters = inference.start(start);
        let mut sites = inference.first_sites(start, &parameters)?;
        let mut bounds = model.scaled_bounds();
        let theta = model.theta_offset..model.theta_offset + model.theta.len();
        // Where the start has the equation's parameters, and other probable values of them.
        let known: Vec<usize> = model.parameters()[theta.clone()]
            .iter()
            .map(|parameter| start.fit.model().position(&parameter.name))
            .collect::<Result<_, _>>()?;
        let draws = match known.is_empty() {
            true => Vec::new(),
            false => laplace(&start.fit, options.draws, options.seed)?.draws,
        };
        let ends = bounds[theta.clone()].to_vec();
        if !options.equation {
            theta.clone().for_each(|position| bounds[position] = [parameters[position]; 2]);
        }
        let mut trace: Vec<f64> = Vec::new();
        let mut settled = false;
        while trace.len() < options.rounds.max(1) && !settled {
            sites = inference.settle(&parameters, sites)?;
            let objective = |x: &[f64]| {
                let e = inference.evaluate(x, &sites)?;
                Some((-e.value, e.gradient.iter().map(|g| -g).collect()))
            };
            let found = minimise(objective, &parameters, &bounds, options.iterations, |_, _| ());
            let found = found.ok_or_else(|| inference.failure(&parameters, &sites))?;
            parameters = found.point;
            settled = trace.last().is_some_and(|before| -found.value - before < GAIN);
            trace.push(-found.value);
        }
        let sites = inference.settle(&parameters, sites)?;
        let (bound, posterior) = inference.posterior(&parameters, &sites)?;
        let members = draws
            .par_iter()
            .map(|draw| {
                let mut moved = parameters.clone();
                for ((position, own), [lower, upper]) in theta.clone().zip(&known).zip(&ends) {
                    let apart = draw[*own] - start.fit.outcome().parameters[*own];
                    moved[position] = (parameters[position] + apart).clamp(*lower, *upper);
                }
                let sites = inference.settle(&moved, sites.clone())?;
                Ok(inference.posterior(&moved, &sites)?.1)
            })
            .collect::<Result<_, GpError>>()?;
        let model = model.clone();
        Ok(Variational { model, posterior, members, parameters, bound, trace, settled })
    }
}
