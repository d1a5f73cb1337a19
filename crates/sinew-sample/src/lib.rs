//! Chains of a posterior and whether they can be trusted.
//!
//! A [`LogDensity`] with its gradient is sampled by [`nuts`], whitened about a mode ([`Laplace`]). [`r_hat`], [`ess_bulk`],
//! [`ess_tail`] and [`psis`] judge the chains, with the numbers that `arviz` gives. [`write_csv`] and [`ArvizDict`] write them
//! for other programs.
//!
//! ```
//! use sinew_sample::{Laplace, LogDensity, NutsOptions, ess_bulk, nuts, r_hat};
//!
//! /// A normal density with standard deviations 1 and 10.
//! struct Normal;
//! impl LogDensity for Normal {
//!     fn dimension(&self) -> usize {
//!         2
//!     }
//!     fn value_and_gradient(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
//!         gradient.copy_from_slice(&[-x[0], -x[1] / 100.0]);
//!         -0.5 * (x[0] * x[0] + x[1] * x[1] / 100.0)
//!     }
//! }
//!
//! let about = Laplace::at(&Normal, &[0.0, 0.0])?;
//! let chains = nuts(&Normal, &about, &NutsOptions::default())?;
//! let second = chains.parameter(1);
//! assert!(r_hat(&second) < 1.01 && ess_bulk(&second) > 400.0);
//! let pooled = second.concat();
//! let square = pooled.iter().map(|x| x * x).sum::<f64>() / pooled.len() as f64;
//! assert!((square.sqrt() - 10.0).abs() < 0.6);
//! # Ok::<(), sinew_sample::SampleError>(())
//! ```

mod chains;
mod error;
mod laplace;
mod nuts;
mod pareto;
mod seed;
mod write;

pub use chains::{Chains, Summary, ess_bulk, ess_tail, quantile, r_hat};
pub use error::SampleError;
pub use laplace::{Laplace, LogDensity};
pub use nuts::{NutsOptions, nuts, nuts_from};
pub use pareto::{Smoothed, effective_share, psis};
pub use seed::{split_seed, standard_normals};
pub use write::{ArvizDict, write_csv};
