//! Solving on a coarse mesh first.

use super::prolongation::Prolongation;
use sinew::Body;
use sinew_fem::{Options, Solution, SolveError, Solver};

/// Parts of the coarse displacement, tried until none of the cells is inverted.
const PARTS: [f64; 4] = [1.0, 0.9, 0.7, 0.4];

/// Displacement \[length\] of the equilibrium of `coarse` at the nodes of `fine`, the same body on a finer mesh: a fast
/// approximation, and a good mean function for a regression of fine solutions.
pub(super) fn coarse_displacement(
    coarse: &Body,
    fine: &Body,
    theta: &[f64],
) -> Result<Vec<f64>, SolveError> {
    let solved = Solver::new(coarse)?.solve(theta, &Options::default())?;
    let prolongation = Prolongation::new(&coarse.positions, &fine.positions);
    let mut displacement = prolongation.vectors(&solved.displacement);
    place(fine, &mut displacement);
    Ok(displacement)
}

/// The equilibrium of `fine` for θ, started from that of `coarse`, the same body on a coarser mesh (nested iteration). Under
/// large displacements most iterations only approach the equilibrium; a coarse mesh does this as well. Without a coarse
/// equilibrium the search starts from rest.
pub(super) fn solve_nested(
    coarse: &Body,
    fine: &Body,
    theta: &[f64],
) -> Result<Solution, SolveError> {
    let (mut solver, options) = (Solver::new(fine)?, Options::default());
    let found = match coarse_displacement(coarse, fine, theta) {
        Ok(found) => found,
        Err(SolveError::NotConverged(_)) => return solver.solve(theta, &options),
        Err(other) => return Err(other),
    };
    let of_part = |part: f64| {
        let mut guess: Vec<f64> = found.iter().map(|u| part * u).collect();
        place(fine, &mut guess);
        guess
    };
    match PARTS.map(of_part).into_iter().find(|guess| fine.value(guess, theta).is_finite()) {
        Some(guess) => solver.solve_from(&guess, theta, &options),
        None => solver.solve(theta, &options),
    }
}

/// Sets prescribed degrees of freedom.
fn place(body: &Body, displacement: &mut [f64]) {
    for (dof, target) in body.prescribed.iter().enumerate() {
        let Some(target) = target else { continue };
        let off = target - body.frames.component(dof, displacement);
        body.frames.add(dof, off, displacement);
    }
}
