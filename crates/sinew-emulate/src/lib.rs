//! Emulators of a body with checked error estimates: sampling, simulations, recipes, corrections, prescribed accuracy.
//!
//! A soft bar that bends under its own weight, for any stiffness in a range:
//!
//! ```
//! use sinew_emulate::{Train, TrainingOptions, recipe::Regression};
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//! use sinew_mesh::box_tetrahedra;
//!
//! let body = Scene::new(box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
//!     .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//!
//! // Solves, fits and tests on held-out cases; the record gives the reason for the regression chosen.
//! let emulator = Regression::default().train(&body, &TrainingOptions::default(), &mut ())?;
//! println!("{}", emulator.record.choice.as_ref().ok_or("a regression chooses")?);
//! assert!(emulator.record.warnings.is_empty());
//!
//! // Takes microseconds; extrapolation gives a warning.
//! let prediction = emulator.predict(&[vec![10.0, 12.0], vec![20.0, 12.0]])?;
//! assert!(prediction.warnings[0].is_empty() && !prediction.warnings[1].is_empty());
//!
//! // Error estimate, and a correction by one Newton step.
//! let estimate = emulator.estimate(&prediction, 0)?;
//! assert!(estimate.distance.ok_or("an equilibrium is near")?.mean < 1e-3); // mm
//! let corrected = emulator.correct(&[10.0, 12.0], 1)?;
//! assert!(corrected.steps[0].residual_after < 1e-3 * corrected.steps[0].residual_before);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Design`] samples the box of the parameters; [`simulate()`] solves there, stores, resumes and lists failures.
//! - [`recipe::Taylor`] and [`recipe::Regression`] make a [`Predictor`] of a body ([`Train`]); networks are in `sinew-gnn`.
//! - [`Emulator`] predicts, estimates its error by Newton steps that contract ([`Estimate`], checked on held-out cases:
//!   [`Calibration`]), corrects ([`Correction`]), is stored and loaded, and is evaluated against a [`TestSet`]
//!   ([`Evaluation`]).
//! - [`Answers`]: displacements to a prescribed accuracy, by the method with the fewest expected Newton steps.
//! - [`Emulator::frozen_stiffness`]: predictions of unseen bodies, by quasi-Newton steps from the solution of another body with its stiffness.
//! - [`RunsEmulator`]: Gaussian processes of stored runs of any solver, without a body.
//! - [`TrainingOptions`]: budget, seed, folder of stored and resumed results. [`Observer`] receives progress; a reason to distrust a
//!   result is a [`Warning`] in it.
//!
//! # Equations
//!
//! Taylor expansion of second order about the equilibrium u₀ at the centre of the ranges, in standardised parameters δ; one factorised stiffness gives all
//! coefficients (implicit function theorem; Nocedal & Wright, *Numerical Optimization*, A.2):
//!
//! ```math
//! \hat u(\theta) = u_0 + \sum_i u_i\,\delta_i + \tfrac12\sum_{ij} u_{ij}\,\delta_i\delta_j, \qquad
//! K u_i = -\frac{\partial r}{\partial\delta_i}, \qquad
//! K u_{ij} = -\Bigl(\frac{\partial^2 r}{\partial\delta_i\,\partial\delta_j} + \frac{\partial K}{\partial\delta_i}u_j + \frac{\partial K}{\partial\delta_j}u_i + \frac{\partial K}{\partial u}[u_i]\,u_j\Bigr)
//! ```
//!
//! Regression on orthonormal modes φ of simulations (proper orthogonal decomposition; Hesthaven, Rozza & Stamm, *Certified Reduced Basis Methods*, chapter 3), with leave-one-out
//! errors in closed form (Rasmussen & Williams, *Gaussian Processes for Machine Learning*, 5.4.2):
//!
//! ```math
//! \hat u(\theta) = \bar u + \sum_m a_m(\theta)\,\varphi_m, \qquad a_m(\theta) = \beta_m\cdot p(\theta) + g_m(\theta), \qquad g_m \sim \mathcal{GP}(0, k), \qquad
//! a_i - \hat a_{-i} = \frac{[C^{-1}a]_i}{[C^{-1}]_{ii}}
//! ```
//!
//! Error estimate of a prediction û: Newton steps until simplified ones contract; u⁺ is where they end (Deuflhard, *Newton Methods for Nonlinear Problems*, chapter 2):
//!
//! ```math
//! e \approx \|\hat u - u^+\|, \qquad \|\Delta u_{k+1}\| \le \tfrac14\,\|\Delta u_k\| \ \text{ in the energy norm and in the mean nodal distance}
//! ```

pub mod coordinates;
mod emulator;
mod error;
mod estimate;
mod parameters;
mod predict;
pub mod recipe;
mod refine;
mod runs;
mod sample;
pub mod store;

pub use emulator::{Emulator, Load, Prediction};
pub use error::{Error, Result, Warning};
pub use estimate::evaluate::{
    CaseErrors, Errors, METRICS, Metric, Quantiles, TestSet, median_and_worst,
};
pub use estimate::evaluation::{Corrected, Evaluation, Stage, Times};
pub use estimate::{Distance, Estimate};
pub use predict::regression::{Interpolation, PodRegression, RegressionParts};
pub use predict::{Predictor, central_differences};
pub use recipe::Train;
pub use recipe::options::{Budget, TrainingOptions};
pub use recipe::progress::{Counter, Observer, Progress};
#[cfg(feature = "terminal")]
pub use recipe::terminal::Terminal;
pub use refine::answers::Answers;
pub use refine::plan::{Cost, Method, Plan};
pub use refine::{Answer, Correction};
pub use runs::{Emulated, LeftOut, Output, Predicted, RunsEmulator};
pub use sample::campaign::{Shard, ShardState, merge, simulate_shard};
pub use sample::simulate::{
    Failure, MOST_COMPARED, Simulations, alike, read_simulations, simulate, simulate_by,
};
pub use sample::{Design, is_inside, share_of, split_seed};
pub use sinew_energy::Body;
pub use store::record::{Calibration, Candidate, Choice, CurvePoint, Kept, Record};

/// Parts that recipes outside of this crate are made of, such as those of networks.
pub mod parts {
    pub use crate::estimate::evaluate::{root_mean_square, timed};
    pub use crate::parameters::{not_finite, scaling};
    pub use crate::predict::taylor::{admissible, expand, with_anchors, work};
    pub use crate::recipe::session::{Session, Stream};
    pub use crate::recipe::train_with;
    pub use sinew_num::{dot, norm};
}
