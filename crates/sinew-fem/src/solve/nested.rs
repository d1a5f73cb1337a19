//! Solving on a coarse mesh first.

use crate::elements::supports::place;
use crate::{Options, Solution, SolveError, Solver};
use sinew_energy::Body;
use sinew_mesh::Prolongation;

/// Parts of the coarse displacement, tried until none of the cells is inverted.
const PARTS: [f64; 4] = [1.0, 0.9, 0.7, 0.4];

/// Displacement \[length\] of the equilibrium of `coarse` at the nodes of `fine`, the same body on a finer mesh: a fast
/// approximation, and a good mean function for a regression of fine solutions.
///
/// # Errors
/// As for [`Solver::solve`] of the coarse body.
pub fn coarse_displacement(
    coarse: &Body,
    fine: &Body,
    theta: &[f64],
    options: &Options,
) -> Result<Vec<f64>, SolveError> {
    let solved = Solver::new(coarse)?.solve(theta, options)?;
    let prolongation = Prolongation::new(&coarse.positions, &fine.positions);
    let mut displacement = prolongation.vectors(&solved.displacement);
    place(fine, 1.0, &mut displacement);
    Ok(displacement)
}

impl Solver<'_> {
    /// The equilibrium for θ, started from that of `coarse`, the same body on a coarser mesh (nested iteration). Under
    /// large displacements most iterations only approach the equilibrium; a coarse mesh does this as well.
    ///
    /// ```
    /// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Solver};
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let [coarse, fine] = [[10, 2, 2], [40, 8, 8]].map(|cells| {
    ///     let mesh = box_tetrahedra([10.0, 2.0, 2.0], cells);
    ///     let scene = Scene::new(mesh, NeoHookean)
    ///         .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///         .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///         .load(Load::BodyForce([0.0, 0.0, -0.5]))
    ///         .support(Support::clamped("x_min"));
    ///     scene.lower().expect("a beam")
    /// });
    /// let (mut solver, options) = (Solver::new(&fine)?, Options::default());
    /// let cold = solver.solve(&[60.0, 60.0], &options)?;
    /// let nested = solver.solve_nested(&coarse, &[60.0, 60.0], &options)?;
    /// assert!(nested.history.iterations.len() < cold.history.iterations.len());
    /// let off = nested.displacement.iter().zip(&cold.displacement).map(|(a, b)| (a - b).abs());
    /// assert!(off.fold(0.0, f64::max) < 1e-9);
    /// # Ok::<(), sinew_fem::SolveError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Solver::solve`]. A coarse body that has no equilibrium is no error: then the search starts from rest.
    pub fn solve_nested(
        &mut self,
        coarse: &Body,
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution, SolveError> {
        let found = match coarse_displacement(coarse, self.body(), theta, options) {
            Ok(found) => found,
            Err(SolveError::NotConverged(_)) => return self.solve(theta, options),
            Err(other) => return Err(other),
        };
        match self.admissible(&found, theta) {
            Some(guess) => self.solve_from(&guess, theta, options),
            None => self.solve(theta, options),
        }
    }

    /// Largest part of a displacement, with prescribed motions, that inverts no cell; `None` if all parts do.
    fn admissible(&self, displacement: &[f64], theta: &[f64]) -> Option<Vec<f64>> {
        let of_part = |part: f64| {
            let mut guess: Vec<f64> = displacement.iter().map(|u| part * u).collect();
            place(self.body(), 1.0, &mut guess);
            guess
        };
        PARTS.map(of_part).into_iter().find(|guess| self.body().value(guess, theta).is_finite())
    }
}
