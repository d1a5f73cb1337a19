//! Equilibria of hyperelastic bodies: Newton's method on the total potential energy of a tetrahedral mesh.
//!
//! A beam that bends under its own weight:
//!
//! ```
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//! use sinew_fem::{Options, Solver, reactions};
//! use sinew_mesh::box_tetrahedra;
//!
//! let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
//!     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"));
//! let potential = scene.lower()?;
//! let mut solver = Solver::new(&potential)?;
//! let solution = solver.solve(&[75.0, 75.0], &Options::default())?;
//!
//! let tip = scene.mesh.node_sets()["x_max"][0];
//! assert!((solution.displacement[3 * tip + 2] + 36.081).abs() < 1e-3); // mm, downwards
//! assert!((solution.energy + 766.970_681).abs() < 1e-6); // FEniCS on the same mesh [kPa mm³]
//! assert!(solution.is_stable() && solution.iterations() < 10);
//! let clamp = reactions(&potential, &solution.displacement, &solution.pressure, &solution.theta)?[0];
//! assert!((clamp[2] - 98.0).abs() < 1e-6); // its weight [kPa mm²]
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Solver`] keeps sparsity, ordering and symbolic factorisation of one body; [`Solver::solve`] and
//!   [`Solver::solve_from`] give a [`Solution`] with its [`History`], or a [`SolveError`] that advises.
//! - If there are several stable equilibria, [`Solver::solve`] finds one of them in few iterations;
//!   [`LoadSteps::Always`] finds that of a rising load. [`Solver::under_rising_load`] compares both; [`Solution::jumped`]
//!   marks a solution that may be on another branch.
//! - [`Solver::refine`] solves to a prescribed accuracy by quasi-Newton steps with a neighbour's stiffness. Their contraction bounds the error.
//! - [`sweep`] solves for many θ on all cores, each from its neighbour; [`resume_sweep`] can be stopped and resumed.
//! - [`Solution::is_stable`] tells an unstable equilibrium, such as a straight column beyond Euler's load: [`Solver::solve_from`] a nearby displacement finds a stable one.
//! - [`Solver::follow`] traces the curve of equilibria along a [`Line`] in loads and parameters, through limit
//!   points.
//! - [`Solver::trace`] gives the equilibria at parameters in their order, each from the one before.
//! - [`FrozenStiffness`] lowers the potential energy at many θ, and of other bodies, by the same steps with one factorised stiffness.
//! - [`Solver::sensitivity`] gives ∂u/∂θ, [`Solver::adjoint_sensitivity`] the derivative of one quantity.
//! - Solver, sweep and [`reactions`] take a body without a potential, too, whose equilibria are not minima, such as incompressible bodies by the
//!   mixed elements of Taylor and Hood and pressures on surfaces with a loose rim.
//! - [`Solver::solve_watched`] hands out each iteration; [`reactions`] gives the forces of supports, [`locking`] estimates the locking of elements. A solve
//!   that fails returns [`NotConverged`]: its best state, history, worst cells and advice. Iterations and reactions at work:
//!   `cargo run -p sinew-fem --example watch_iterations`.
//! - [`Unload`] finds the reference configuration of a body whose mesh shows a loaded state, with verdicts and ∂X/∂θ.
//! - [`fibres`] assigns rule-based muscle fibres to ventricles.
//!
//! # Equations
//!
//! Newton's method with a line search on the potential energy; σ ≥ 0 is the least shift that makes the stiffness positive definite, D its mean diagonal, c = 1e-4
//! (Nocedal & Wright, *Numerical Optimization*, 3.1 and 3.4; a watchdog, 15.6, allows two steps that raise the energy):
//!
//! ```math
//! (K + \sigma D)\,\Delta u = -r(u), \qquad u \leftarrow u + \alpha\,\Delta u, \qquad \Pi(u+\alpha\,\Delta u) \le \Pi(u) + c\,\alpha\, r\cdot\Delta u
//! ```
//!
//! Quasi-Newton (L-BFGS) update about a frozen stiffness K₀, from steps s and changes y of the residual (Nocedal & Wright, 7.2):
//!
//! ```math
//! H_{k+1} = \bigl(I - \rho_k s_k y_k^{\mathsf T}\bigr)\,H_k\,\bigl(I - \rho_k y_k s_k^{\mathsf T}\bigr) + \rho_k s_k s_k^{\mathsf T}, \quad
//! \rho_k = \frac{1}{y_k\cdot s_k}, \quad H_0 = \gamma K_0^{-1}, \quad \gamma = \frac{s\cdot y}{y\cdot K_0^{-1} y}
//! ```
//!
//! Arc-length continuation along a [`Line`] with place λ; the constraint plane through the predictor (û, λ̂) is normal to its direction (n, ν), and ℓ scales lengths (Bonet & Wood, 9.6):
//!
//! ```math
//! r(u;\lambda) = 0, \qquad \ell^{-2}\, n\cdot(u-\hat u) + \nu\,(\lambda-\hat\lambda) = 0
//! ```
//!
//! Sensitivities by the implicit function theorem, and the adjoint of a quantity q(u) (Nocedal & Wright, A.2):
//!
//! ```math
//! K\,\frac{\partial u}{\partial\theta_j} = -\frac{\partial r}{\partial\theta_j}, \qquad K z = \frac{\partial q}{\partial u}, \qquad \frac{\mathrm dq}{\mathrm d\theta_j} = -z\cdot\frac{\partial r}{\partial\theta_j}
//! ```
//!
//! Error of an iterate by [`Solver::refine`], in the mean nodal length, from the longer of two steps and its contraction ratio κ (Deuflhard, *Newton Methods for Nonlinear Problems*, 2.1). The scale γ of the quasi-Newton step is the largest of all steps', one at least, lest soft modes hide behind stiff ones:
//!
//! ```math
//! \|u - u^*\| \lesssim \frac{6}{1-\kappa}\,m, \qquad m = \max\bigl(\|\gamma K_0^{-1} r\|,\ \|H r\|\bigr), \qquad \kappa = \max\bigl(\tfrac12,\ m/m_{\text{before}}\bigr) < 1
//! ```

mod diagnose;
mod elements;
mod error;
pub mod fibres;
mod linear;
mod solve;
mod unload;

pub use diagnose::error_estimate::{Distance, ErrorEstimate, NotNearEquilibrium};
pub use diagnose::locking::{
    FormulationDifference, LARGEST_BULK_TO_SHEAR, LockingWarning, compare_formulations, locking,
    locking_at_centre,
};
pub use diagnose::stress::{
    CellStress, Fibre, cell_stresses, energy_and_reactions, held_sets, mixed_stresses,
    principal_stretches, principal_values, reactions,
};
pub use error::{Advice, CellValue, NotConverged, RigidMode, SolveError};
pub use linear::systems::Method;
pub use solve::continuation::{Curve, CurvePoint};
pub use solve::frozen_stiffness::FrozenStiffness;
pub use solve::history::{History, Iteration, Progress};
pub use solve::newton_step::NewtonStep;
pub use solve::options::{LoadSteps, Options};
pub use solve::refine::{Pairs, Refined, Stop};
pub use solve::search::{Line, Solution};
pub use solve::sensitivity::Stiffness;
pub use solve::solver::{Solver, SolverPool};
pub use solve::sweep::{CHAIN, Earlier, Trace, TraceEnd, neighbours, resume_sweep, sweep};
pub use unload::{Loading, Unload, UnloadError, UnloadOptions, Unloaded};

pub(crate) use error::Result;
