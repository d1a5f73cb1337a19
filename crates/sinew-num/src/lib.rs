//! Numbers that a formula of mechanics is evaluated over.
//!
//! A strain-energy law is written once, over the trait [`Scalar`]. Evaluated over `f64` it
//! gives the energy, over a [`Jet`] also stress and tangent, over a tensor type of another crate the energy of many
//! elements at once. Beside them, loops for the vector
//! instructions at hand ([`vectorised!`]), products of vectors, exponents of polynomials, connected components, ordered sets, random numbers,
//! and, with the feature `threads`, parallel loops and a way to keep the threads of short parallel
//! parts awake.
//!
//! ```
//! use sinew_num::{Jet, Scalar};
//!
//! // One formula, several number types.
//! fn energy<S: Scalar>(stretch: S) -> S {
//!     (stretch.clone() * stretch.clone() - 1.0) * 0.5 - stretch.ln()
//! }
//!
//! assert_eq!(energy(1.0), 0.0);
//! let jet = energy(Jet::<1>::variable(2.0, 0));
//! assert_eq!(jet.gradient[0], 2.0 - 1.0 / 2.0);    // d/ds  = s − 1/s
//! assert_eq!(jet.hessian[0][0], 1.0 + 1.0 / 4.0);  // d²/ds² = 1 + 1/s²
//! ```

mod connectivity;
mod mat3;
mod monomials;
#[cfg(feature = "threads")]
mod parallel;
mod random;
#[cfg(feature = "threads")]
mod ready;
mod scalar;
mod simd;
mod taylor;
mod vector;

pub use connectivity::{ascending, cells_of_nodes, connected_cells, connected_components};
pub use mat3::Mat3;
pub use monomials::monomials;
#[cfg(feature = "threads")]
pub use parallel::{fill, in_parallel, in_tasks, try_in_parallel};
pub use random::SplitMix64;
#[cfg(feature = "threads")]
pub use ready::on_ready_threads;
pub use scalar::Scalar;
pub use simd::{Instructions, instructions};
pub use taylor::{Jet, Slope, Taylor};
pub use vector::{add3, cross, difference, dot, dot3, norm, sub3, sum};
