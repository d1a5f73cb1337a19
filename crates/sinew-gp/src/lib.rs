//! Gaussian processes that satisfy boundary conditions exactly and learn PDE parameters.

mod coefficients;
mod condition;
mod constraint;
mod data;
mod domain;
mod error;
mod evidence;
mod field;
mod fit;
mod functional;
mod gram;
mod kernel;
mod model;
mod operator;
mod optimise;
mod polygon;
mod posterior;
mod prior;
mod problem;
mod simd;
mod structure;

pub use condition::{Condition, Periodicity};
pub use constraint::{Constraints, Feature, constraints};
pub use data::{Data, Noise};
pub use domain::{Domain, Side};
pub use error::GpError;
pub use evidence::{Evaluation, Evidence};
pub use field::{Field, constant, field};
pub use fit::{Fit, FitOptions, Outcome, Restart};
pub use functional::Functional;
pub use kernel::{
    Hyperparameter, Kernel, KernelFault, Linear, MOST_PAIRS, Matern, Measure, Orders, Pairs,
    Periodic, Product, RationalQuadratic, Scaled, Smoothness, SquaredExponential, Sum,
    check_kernel,
};
pub use model::{Belief, FreeParameter, Model};
pub use operator::{Derivative, MOST_DERIVATIVES, Operator, Parameter, Term};
pub use polygon::Polygon;
pub use posterior::{Posterior, Prediction};
pub use prior::Prior;
pub use problem::Problem;
/// The number type of formulas in the coordinates.
pub use sinew_num::Series;
