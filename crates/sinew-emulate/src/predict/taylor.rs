//! Taylor expansion of second order about the solution at the centre of the parameters' ranges.

mod anchors;
mod derivatives;

pub use anchors::with_anchors;
pub use derivatives::{admissible, expand, work};

use crate::coordinates::{Motions, halves};
use crate::{Body, Design, Observer, Result, parameters};
use serde::{Deserialize, Serialize};
use sinew_fem::{Options, Solver};

/// Displacements by the Taylor expansion of second order about one solution: derivatives by the implicit function theorem, second order
/// with the stiffness of that solution, both in rigid motions of the body's clusters, so that rotations do not stretch. It may go through further solutions
/// (anchors), with their derivatives.
#[doc(alias = "series")]
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TaylorExpansion(Motions);

/// Short name of the recipe, and what it makes.
pub(crate) const KEY: &str = "taylor";
pub(crate) fn about(anchors: usize) -> String {
    match anchors {
        1 => "Taylor expansion of second order about one solution".into(),
        _ => format!("Taylor expansion of second order about {anchors} solutions"),
    }
}

/// Parameter sets that parts of the orders are tried at.
const TRIED: usize = 16;

impl TaylorExpansion {
    /// Solves once, at the centre of the parameters' ranges, and for each further anchor.
    pub(crate) fn of(
        body: &Body,
        anchors: usize,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let mut solver = Solver::new(body)?;
        let solved = solver.solve(&body.centre(), &Options::default())?;
        let Self(motions) = Self::about_solved(&mut solver, &solved.displacement, seed)?;
        Ok(Self(with_anchors(&mut solver, motions, anchors, seed, observer)?))
    }

    /// Expansion about the solution at the centre of the parameters' ranges.
    pub(crate) fn about_solved(solver: &mut Solver<'_>, solved: &[f64], seed: u64) -> Result<Self> {
        let body = solver.body();
        let tried = Design::LatinHypercube.sample(&body.parameters, TRIED, seed)?;
        let motions = Motions::about(solved, &halves(&body.positions), body, &body.centre())?;
        Ok(Self(expand(solver, motions, &tried)?.0))
    }

    /// Solutions that it goes through.
    pub(crate) fn anchors(&self) -> usize {
        self.0.anchors().map_or(1, |anchors| anchors.count())
    }

    /// Displacement at θ, node by node \[length\].
    ///
    /// # Errors
    /// θ of the wrong length, or not positive where samples are uniform in the logarithm.
    pub fn at(&self, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
        Ok(self.0.expansion_at(&parameters::scaling(body)?.standardise(theta)?, body)?)
    }
}
