//! Gaussian processes that satisfy boundary conditions exactly and learn PDE parameters.
//!
//! Describe a domain, a linear equation and its boundary conditions. The crate builds a prior whose
//! functions all satisfy the conditions. From noisy data it infers the solution and the
//! equation's parameters, with credible intervals.
//!
//! ```
//! use std::f64::consts::PI;
//! use sinew_gp::{
//!     Condition, Data, Domain, Evidence, FitOptions, Functional, Model, Noise, Parameter, Prior,
//!     Problem, Side, constant, field, squared_exponential,
//! };
//!
//! // u_t = κ u_xx on a rod of length π, kept at zero at both ends, warm in the middle at first.
//! let rod = Domain::cuboid([("x", [0.0, PI]), ("t", [0.0, 1.0])])?;
//! let [dx, dt] = rod.derivatives();
//! let diffusivity = Parameter::new("diffusivity", [0.05, 20.0])?;
//! let problem = Problem::new(rod.clone(), dt - &diffusivity * dx * dx)?
//!     .condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)))?
//!     .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
//!     .condition("t", Side::Lower, Condition::Dirichlet(field(|[x, _]| x.sin())))?;
//!
//! // A dozen measured temperatures, and the equation at two dozen points. The truth is κ = 0.7.
//! let exact = |[x, t]: [f64; 2]| x.sin() * (-0.7 * t).exp();
//! let places = rod.sample(12, 1)?;
//! let measured: Vec<f64> = places.iter().enumerate()
//!     .map(|(k, place)| exact(*place) + 0.01 * (2.4 * k as f64).sin())
//!     .collect();
//! let data = Data::new()
//!     .values(&places, &measured, Noise::Learned)
//!     .equation(&rod.sample(24, 2)?, &[0.0; 24], Noise::Exact);
//!
//! let prior = Prior::constrained(&problem, &squared_exponential())?;
//! let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
//! assert!((fit.parameter("diffusivity")? - 0.7).abs() < 0.05);
//!
//! let at_the_end = fit.predict(&[[1.5, 1.0], [0.0, 0.5]])?;
//! assert!((at_the_end.mean[0] - exact([1.5, 1.0])).abs() < 0.02);
//! assert_eq!(at_the_end.standard_deviation[1], 0.0); // on the boundary nothing is uncertain
//!
//! // Total heat flux through the right end: −∫ κ u_x dt.
//! let flux = Functional::face_integral(&rod, ("x", Side::Upper), -(&diffusivity * dx), 8)?;
//! let (heat, deviation) = fit.ensemble()?.predict_functional(&flux)?;
//! assert!((heat - (1.0 - (-0.7_f64).exp())).abs() < 0.02);
//! # Ok::<(), sinew_gp::GpError>(())
//! ```
//!
//! - [`Prior::constrained`], [`Prior::penalised`] and [`Prior::unconstrained`]: conditions built
//!   in, as pseudo-observations, or ignored (HCGP, PCGP and UCGP in Chapter 4 of the thesis);
//! - [`Model::fit`], [`laplace`] and [`nuts`]: the most probable parameters, and ensembles of
//!   posterior draws for credible intervals; [`Evidence`] names the density;
//! - [`Data::averaged`]: hundreds of thousands of values;
//! - [`Fit::warnings`]: parameters at bounds or not identified, and other faults of a fit;
//! - [`Formula`] and [`check_kernel`]: your own kernel from its formula, and whether it is one;
//! - [`SemiLinear`]: equations with a nonlinear term, by the Gauss–Newton method.
//!
//! Everything is in double precision.
//!
//! # Equations
//!
//! Prior whose every function satisfies the boundary conditions (HCGP; thesis, Definition 4.4.1): m satisfies them, φₚ vanish where they are imposed, zₚ are free:
//!
//! ```math
//! u = m + \sum_p \varphi_p z_p, \quad z_p \sim \mathcal{GP}(0,\sigma_p^2 k), \qquad
//! \operatorname{cov}\bigl(u(x),u(x')\bigr) = \sum_p \sigma_p^2\,\varphi_p(x)\,\varphi_p(x')\,k(x,x')
//! ```
//!
//! Measured values and values of the right-hand side of L u = f are jointly normal (thesis (4.18); Rasmussen & Williams, *Gaussian Processes for Machine Learning*, 9.4); the data covariance C contains the noise:
//!
//! ```math
//! \begin{gathered}
//! \operatorname{cov}(f,u') = L_x k(x,x'), \qquad \operatorname{cov}(f,f') = L_x L_{x'} k(x,x'), \\
//! \ln p(y) = -\tfrac12 (y-m)^{\mathsf T} C^{-1}(y-m) - \tfrac12\ln\det C - \tfrac n2 \ln 2\pi
//! \end{gathered}
//! ```
//!
//! Evidence of [`Evidence::Joint`] and [`Evidence::UnitInformation`]; the second counts all n_f imposed values as one observation:
//!
//! ```math
//! \ln p(y_u, y_f), \qquad \ln p(y_u \mid y_f) + \tfrac1{n_f}\ln p(y_f)
//! ```
//!
//! Posterior of any linear functional A u (Rasmussen & Williams, 2.2), averaged by [`laplace`] and [`nuts`] over draws of the parameters:
//!
//! ```math
//! \mathbb E[A u] = A m + A k_{\cdot y}\,C^{-1}(y-m), \qquad \operatorname{var}[A u] = A A' k - A k_{\cdot y}\,C^{-1} (A k_{\cdot y})^{\mathsf T}
//! ```

#[macro_use]
mod error;
#[macro_use]
mod instances;
mod evidence;
mod fit;
mod kernel;
mod model;
mod posterior;
mod prior;
mod problem;
mod semilinear;
mod series;

pub use error::GpError;
pub use evidence::{Evaluation, Evidence};
pub use fit::warning::Warning;
pub use fit::{Fit, FitOptions, Outcome, Restart};
pub use kernel::{
    Formula, Hyperparameter, Measure, Smoothness, check_kernel, linear, matern, periodic,
    rational_quadratic, squared_exponential,
};
pub use model::Model;
pub use model::data::{Data, Noise};
pub use model::parameter::{FreeParameter, Hyperprior};
pub use posterior::conditional::{Conditional, Prediction};
pub use posterior::ensemble::Ensemble;
pub use posterior::laplace::{NutsOptions, ensemble, laplace, nuts};
pub use prior::Prior;
pub use prior::constraint::{Constraints, Feature, constraints};
pub use problem::domain::{Domain, Polygon, Side};
pub use problem::field::{Field, constant, field};
pub use problem::operator::{Derivative, Functional, MOST_DERIVATIVES, Operator, Parameter, Term};
pub use problem::{Condition, Periodicity, Problem};
pub use semilinear::{SemiLinear, Solution};
pub use series::Series;

use error::Result;
