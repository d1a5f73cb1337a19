//! Calibration of a body from an image, pressures and a few measurements: unloaded body and posterior of its parameters.
//!
//! The physics is a [`Forward`] model: [`Patient`] unloads a body from its image and loads it again in phases. The statistics use
//! this model only. [`Problem`] holds unknown parameters and data, [`Solves`] counts and stores solves. [`calibrate`] returns a
//! [`Posterior`] that the solver confirms, or an error.
//!
//! ```
//! use sinew_calibrate::{
//!     CalibrateOptions, Datum, Forward, ForwardError, Observed, Prior, Problem, Solves, Unknown, calibrate,
//! };
//!
//! /// A spring of stiffness k under a known force.
//! struct Spring;
//! impl Forward for Spring {
//!     fn parameters(&self) -> usize {
//!         1
//!     }
//!     fn observables(&self) -> usize {
//!         1
//!     }
//!     fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
//!         let elongation = 10.0 / theta[0];
//!         Ok(Observed { values: vec![elongation], jacobian: vec![vec![-elongation / theta[0]]] })
//!     }
//! }
//!
//! let stiffness = Unknown::new("k", "N/mm", Prior::LogUniform { range: [0.5, 50.0] });
//! let datum = Datum::new("elongation", "length", 0, 2.0, 0.1);
//! let problem = Problem::new(vec![stiffness], vec![datum], Vec::new())?;
//! let mut solves = Solves::new(&Spring);
//! let posterior = calibrate(&problem, &mut solves, &CalibrateOptions::default())?;
//! let stiffness = posterior.summary(0);
//! assert!((stiffness.mean - 5.0).abs() < 0.1 && (stiffness.deviation - 0.25).abs() < 0.05);
//! # Ok::<(), sinew_calibrate::CalibrateError>(())
//! ```

mod calibrate;
mod error;
mod fault;
mod identifiability;
mod klotz;
mod likelihood;
mod mode;
mod observable;
mod observables;
mod patient;
mod polynomial;
mod posterior;
mod predictive;
mod problem;
mod setting;
mod solves;
mod surrogate;
mod wall;

pub use calibrate::{CalibrateOptions, calibrate, check_identifiability};
pub use error::PatientError;
pub use fault::{CalibrateError, Correction, noise_in_words};
pub use identifiability::{Identifiability, Identified, Verdict};
pub use klotz::Klotz;
pub use mode::Mode;
pub use observable::{Direction, Forward, ForwardError, Observable, Observed};
pub use patient::{Patient, PatientBuilder, PatientStates, StateError};
pub use posterior::Posterior;
pub use predictive::{DatumCheck, Predictive};
pub use problem::{Datum, Kind, Prior, Problem, Unknown};
pub use setting::Setting;
pub use solves::{Answer, Solves};
pub use surrogate::Surrogate;
pub use wall::{Segments, WallCoordinates};
