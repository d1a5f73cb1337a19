//! From a body to an emulator that knows its error: sampling, simulations, recipes, error estimates, corrections.
//!
//! A soft bar that bends under its own weight, for any stiffness in a range:
//!
//! ```
//! use sinew_emulate::{Recipe, TrainingOptions};
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
//! // Solves, trains, measures itself on held-out cases, and says why it is what it is.
//! let emulator = Recipe::auto().train(&body, &TrainingOptions::default(), &mut ())?;
//! println!("{}", emulator.record.choice.as_ref().ok_or("auto chooses")?);
//! assert!(emulator.record.warnings.is_empty());
//!
//! // Microseconds; what extrapolates is marked.
//! let prediction = emulator.predict(&[vec![10.0, 12.0], vec![20.0, 12.0]])?;
//! assert!(prediction.warnings[0].is_empty() && !prediction.warnings[1].is_empty());
//!
//! // How far from the truth, and nearer to it.
//! let estimate = emulator.estimate(&prediction, 0)?;
//! assert!(estimate.distance.ok_or("an equilibrium is near")?.mean < 1e-3); // mm
//! let corrected = emulator.correct(&[10.0, 12.0], 1)?;
//! assert!(corrected.steps[0].residual_after < 1e-3 * corrected.steps[0].residual_before);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Design`] samples the box of the parameters; [`simulate()`] solves there, stores, resumes and lists failures.
//! - [`Recipe`]: [`recipe::Regression`] on few simulations, and networks: [`recipe::DataDriven`],
//!   [`recipe::PhysicsInformed`], [`recipe::Hybrid`]; [`recipe::Auto`] chooses by errors on held-out cases.
//! - [`Emulator`] predicts, estimates its error by Newton steps that contract ([`Estimate`], checked on held-out cases:
//!   [`Calibration`]), corrects ([`Correction`]), is stored and loaded, and is evaluated against a [`TestSet`]
//!   ([`Evaluation`]).
//! - [`OneStiffness`] and [`Population`]: bodies that are met, not trained on.
//! - [`TrainingOptions`]: budget, seed, folder for what is kept and resumed. [`Observer`] hears of progress; what makes a
//!   result less trustworthy is a [`Warning`] in it.

mod answer;
mod answers;
mod calibration;
mod campaign;
mod checksums;
mod coordinates;
mod correction;
mod emulator;
mod error;
mod estimate;
mod evaluate;
mod evaluation;
mod graph;
mod identity;
mod network;
mod one_stiffness;
mod options;
mod parameters;
mod plan;
mod population;
mod progress;
mod quantiles;
pub mod recipe;
mod regression;
mod sampling;
mod sensitivity;
mod series;
mod session;
mod shared;
mod simulate;
pub mod store;
#[cfg(feature = "terminal")]
mod terminal;
mod timing;
mod warning;

pub use answer::{Answer, Source};
pub use answers::Answers;
pub use calibration::Calibration;
pub use campaign::{Shard, merge, simulate_shard};
pub use coordinates::Coordinates;
pub use correction::Correction;
pub use emulator::{Emulator, Prediction, Record};
pub use error::{Error, Result};
pub use estimate::{Distance, Estimate};
pub use evaluate::{CaseErrors, Errors, METRICS, Metric, TestSet, median_and_worst};
pub use evaluation::{Corrected, Evaluation, Times};
pub use network::{CurvePoint, Kept, Network};
pub use one_stiffness::OneStiffness;
pub use options::{Budget, TrainingOptions};
pub use plan::{Cost, Method, Plan};
pub use population::{Axes, Draw, Loss, Population, PopulationEmulator, Start, StreamProgress};
pub use progress::{Counter, Observer, Progress};
pub use quantiles::Quantiles;
pub use recipe::Recipe;
pub use regression::{Interpolation, PodRegression, RegressionError};
pub use sampling::{Design, share_of, split_seed};
pub use simulate::{Failure, MOST_COMPARED, Simulations, read_simulations, simulate, simulate_by};
pub use sinew_energy::Body;
pub use sinew_gnn::Backend;
#[cfg(feature = "terminal")]
pub use terminal::Terminal;
pub use warning::Warning;
