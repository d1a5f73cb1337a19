//! The softest motion of a body at an equilibrium.

use crate::linear::vector::{dot, norm};
use crate::{Solution, SolveError, Solver};

/// Iterations of the inverse power method; about ten leave three digits where the two lowest eigenvalues are apart.
const ITERATIONS: usize = 60;
/// Change of the eigenvalue \[relative to itself\] that ends them.
const ENOUGH: f64 = 1e-6;

/// The motion that a body resists least, such as the shape it buckles into.
#[doc(alias("buckling", "bifurcation"))]
#[derive(Clone, Debug, PartialEq)]
pub struct SoftestMode {
    /// Direction, one row per node as in a displacement; its largest component is 1.
    pub direction: Vec<f64>,
    /// Stiffness along it \[stress·length\], the lowest eigenvalue of the free degrees of freedom's stiffness; below zero
    /// where the equilibrium is unstable.
    pub stiffness: f64,
}

impl Solver<'_> {
    /// The lowest eigenvalue of the stiffness at an equilibrium with its direction, by inverse iteration.
    ///
    /// At an unstable equilibrium, such as a straight column beyond Euler's load, the residual is zero, so that
    /// Newton's method stays there. Displace it a little along the softest mode and solve again:
    ///
    /// ```
    /// # use sinew_energy::{Parameter, Scene, Support, laws::NeoHookean};
    /// # use sinew_mesh::box_tetrahedra;
    /// use sinew_fem::{Options, Solver};
    /// // A column shortened by 10 %, three times beyond what it bears straight.
    /// let column = Scene::new(box_tetrahedra([100.0, 4.0, 4.0], [20, 1, 1]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .support(Support::clamped("x_min"))
    ///     .support(Support::uniform("x_max", [Some(-10.0), Some(0.0), Some(0.0)]))
    ///     .lower()?;
    /// let (mut solver, options) = (Solver::new(&column)?, Options::default());
    /// let straight = solver.solve(&[75.0, 75.0], &options)?;
    /// assert!(!straight.is_stable());
    /// let mode = solver.softest_mode(&straight)?;
    /// assert!(mode.stiffness < 0.0);
    /// let nudged = straight.displacement.iter().zip(&mode.direction).map(|(u, d)| u + 2.0 * d); // mm
    /// let bowed = solver.solve_from(&nudged.collect::<Vec<_>>(), &[75.0, 75.0], &options)?;
    /// assert!(bowed.is_stable() && bowed.energy < straight.energy);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A solution of another body, or [`SolveError::Singular`].
    pub fn softest_mode(&mut self, solution: &Solution) -> Result<SoftestMode, SolveError> {
        let Solution { displacement, theta, load_factor, .. } = solution;
        self.visit(displacement, (theta, *load_factor), None)?;
        let system = &mut self.system;
        system.factorise(true).ok_or(SolveError::Singular)?;
        let size = system.sparsity.unknowns();
        // A start vector with parts in all directions and no symmetry of the body.
        let mut mode: Vec<f64> = (0..size).map(|i| ((i * 7919) % 1009) as f64 - 503.7).collect();
        let (mut image, mut stiffness, mut last) = (vec![0.0; size], 0.0, f64::INFINITY);
        for _ in 0..ITERATIONS {
            system.back_substitute(&mut mode);
            let length = norm(&mode);
            mode.iter_mut().for_each(|x| *x /= length);
            system.sparsity.multiply([&system.assembly.matrix; 2], &mode, &mut image);
            stiffness = dot(&mode, &image);
            if (stiffness - last).abs() <= ENOUGH * stiffness.abs() {
                break;
            }
            last = stiffness;
        }
        if !stiffness.is_finite() {
            return Err(SolveError::Singular);
        }
        let mut direction = vec![0.0; displacement.len()];
        system.sparsity.scatter(mode, &mut direction);
        let largest =
            direction.iter().fold(0.0, |m: f64, d| if d.abs() > m.abs() { *d } else { m });
        direction.iter_mut().for_each(|d| *d /= largest);
        Ok(SoftestMode { direction, stiffness })
    }
}
