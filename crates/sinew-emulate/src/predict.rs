//! Predictors: displacements of one body at parameter sets, by any method.

pub(crate) mod regressed;
pub(crate) mod regression;
pub(crate) mod taylor;

use crate::parameters::check_length;
use crate::{Body, PodRegression, Result};
use sinew_energy::Sampling;
use std::fmt::Debug;
use std::path::Path;

/// Step of differences of fourth order, as a share of a parameter's range: predictors are smooth over it, and rounding errors, amplified by a
/// regression to 1e-9, are divided by it.
const STEP: f64 = 2e-3;

/// Displacements of one body at parameter sets: a Taylor expansion, a regression, a network, or a method of your own.
///
/// [`Emulator::new`](crate::Emulator::new) makes it an emulator, which estimates its errors and corrects them.
///
/// ```
/// use sinew_emulate::{Body, Emulator, Error, Predictor, Record};
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use std::path::Path;
///
/// /// The displacement of one parameter set, in inverse proportion to the first parameter.
/// #[derive(Debug)]
/// struct Proportional(Vec<f64>, f64);
///
/// impl Predictor for Proportional {
///     fn kind(&self) -> &'static str { "proportional" }
///     fn predict(&self, _: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>, Error> {
///         Ok(thetas.iter().flat_map(|theta| self.0.iter().map(|u| u * self.1 / theta[0])).collect())
///     }
///     fn save(&self, _: &Path) -> Result<(), Error> { Ok(()) }
/// }
///
/// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
///     .support(Support::clamped("x_min"))
///     .lower()?
///     .with_known(&[("lambda", 80.0)])?;
/// let solved = sinew_fem::Solver::new(&beam)?.solve(&[70.0], &sinew_fem::Options::default())?;
/// let predictor = Proportional(solved.displacement, 70.0);
/// let emulator = Emulator::new(&beam, Box::new(predictor), Record::new("proportional"));
/// let answer = emulator.answer(&[72.0], 1e-4)?;
/// assert!(answer.is_within(1e-4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "surrogate")]
pub trait Predictor: Debug + Send + Sync {
    /// Kind by which a stored one is known: the folder of its files within the emulator's.
    fn kind(&self) -> &'static str;

    /// Displacements at each of `thetas`, set by set, node by node \[length\].
    ///
    /// # Errors
    /// θ outside the domain of the predictor.
    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>>;

    /// Predicts as for an unseen body: a network passes messages again, which is less accurate than trained node embeddings. Other predictors
    /// predict as in [`Predictor::predict`].
    ///
    /// # Errors
    /// As [`Predictor::predict`].
    fn predict_in_full(&self, body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>> {
        self.predict(body, thetas)
    }

    /// Cost of a prediction in Newton steps of the body, read by [`Plan`](crate::Plan); 0 unless the predictor takes steps
    /// itself.
    fn newton_steps(&self) -> f64 {
        0.0
    }

    /// `∂û/∂θ` at θ: a field for every parameter, node by node [length per unit of the parameter], by differences of
    /// fourth order unless overridden.
    ///
    /// # Errors
    /// As [`Predictor::predict`].
    fn sensitivity(&self, body: &Body, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        check_length(body, theta)?;
        central_differences(body, theta, |theta| self.predict(body, &[theta]))
    }

    /// The regression that predicts alone, without an expansion or network beside it; `None` for other predictors.
    fn regression(&self) -> Option<&PodRegression> {
        None
    }

    /// Writes its files into a folder of its own.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn save(&self, folder: &Path) -> Result<()>;
}

/// Derivatives of a field by each parameter [per unit of the parameter], by central differences of fourth order over small parts of the ranges.
///
/// # Errors
/// Those of `at`.
pub fn central_differences<E>(
    body: &Body,
    theta: &[f64],
    at: impl Fn(Vec<f64>) -> Result<Vec<f64>, E>,
) -> Result<Vec<Vec<f64>>, E> {
    let derivative = |(index, parameter): (usize, &sinew_energy::Parameter)| {
        let [low, high] = parameter.range;
        let value = theta[index];
        let moved = |by: f64| {
            let mut theta = theta.to_vec();
            theta[index] = match parameter.sampling {
                Sampling::Linear => value + by * (high - low),
                Sampling::Log => value * (by * (high / low).ln()).exp(),
            };
            at(theta)
        };
        let change = match parameter.sampling {
            Sampling::Linear => high - low,
            Sampling::Log => value * (high / low).ln(),
        };
        let mut slope: Vec<f64> = Vec::new();
        for (by, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let field = moved(by * STEP)?;
            slope.resize(field.len(), 0.0);
            let factor = weight / (12.0 * STEP * change);
            slope.iter_mut().zip(field).for_each(|(sum, u)| *sum += factor * u);
        }
        Ok(slope)
    };
    body.parameters.iter().enumerate().map(derivative).collect()
}
