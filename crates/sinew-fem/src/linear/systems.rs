//! The linear systems of Newton's method: by back-substitution or conjugate gradients for a body with a potential, else by GMRES
//! preconditioned by the factor; the choice of the method.

use crate::elements::{System, load_gradient};
use crate::linear::{
    End, Factor, Iterated, LinearOutcome, MOST_ITERATIONS, MOST_SHIFTS, Shifted, Sparsity, gmres,
};
use crate::{Result, SolveError};
use sinew_num::on_ready_threads;

/// Residual of a linear system relative to its right-hand side: Newton's method stays quadratic down to it, and a step
/// that reaches equilibrium meets the accuracy in volume.
pub(crate) const TOLERANCE: f64 = 1e-10;
/// Residual for second-order corrections and error estimates, relative likewise: with 0.1 a beam with λ = 100 μ takes 27 steps instead of 10.
pub(crate) const CORRECTION: f64 = 1e-2;
/// Residual where conjugate gradients look for negative curvature, relative likewise: they find both ends of the spectrum long before.
const PROBE: f64 = 1e-6;
/// Most iterations of one linear system.
const MOST_GMRES: usize = 400;

impl System<'_> {
    /// Factorises the stiffness that was assembled last: the shift of its diagonal [relative to the mean] and the number
    /// of its negative pivots, at least one of them where they are not counted. An indefinite one is shifted, without a count, if
    /// `definite`, or if its factorisation fails.
    ///
    /// The factor of a large body is in single precision. Where even that is too large, conjugate gradients look for negative curvature, and solve later systems.
    pub(crate) fn factorise(&mut self, definite: bool) -> Option<(f64, usize)> {
        let (sparsity, matrix) = (&*self.sparsity, &mut self.assembly.matrix);
        if let Some(coupling) = &mut self.coupling {
            coupling.factorise()?;
        }
        if self.method == Method::Aggregation {
            if self.factor.entries() > MOST_SINGLE {
                let shift = self.probe()?;
                return Some((shift, usize::from(shift > 0.0)));
            }
            self.aggregation.drop_hierarchy();
            self.iterates = false;
            if self.factor.definite_in_single(sparsity, matrix) {
                return Some((0.0, 0));
            }
        }
        self.iterates = false;
        if self.factor.definite(sparsity, matrix) {
            return Some((0.0, 0));
        }
        let counted = if definite { None } else { self.factor.indefinite(sparsity, matrix) };
        if let Some(negative) = counted {
            return Some((0.0, negative));
        }
        Some((self.factor.shifted(sparsity, matrix)?, 1))
    }

    /// Number of negative eigenvalues of the stiffness that was assembled last, and at least one where they cannot be counted; the factor
    /// is then that of [`System::factorise`] with `definite`. Conjugate gradients find one, where a factor is too large to count at every solution.
    pub(crate) fn negative_eigenvalues(&mut self) -> Option<usize> {
        if self.method == Method::Aggregation {
            return match self.factor.entries() > MOST_COUNTED {
                true => self.probe().map(|shift| usize::from(shift > 0.0)),
                false => self.factorise(false).map(|(_, negative)| negative),
            };
        }
        let (sparsity, matrix) = (&*self.sparsity, &mut self.assembly.matrix);
        if self.factor.positive_definite(sparsity, matrix) {
            return Some(0);
        }
        let negative = self.factor.indefinite(sparsity, matrix);
        self.factor.shifted(sparsity, matrix);
        Some(negative.unwrap_or(1).max(1))
    }

    /// Least shift \[relative to the mean diagonal\] of the stiffness that was assembled last for which conjugate gradients meet no negative curvature.
    fn probe(&mut self) -> Option<f64> {
        // Parts in all directions and no symmetry of the body.
        let scattered = |i: usize| ((i * 7919) % 1009) as f64 - 503.7;
        let right: Vec<f64> = (0..self.sparsity.unknowns()).map(scattered).collect();
        self.aggregation.drop_hierarchy();
        self.iterate(&right, PROBE, MOST_SHIFTS).map(|(_, shift)| shift)
    }

    /// Solves with the stiffness that was assembled last plus the least shift that makes it positive definite, by conjugate gradients to a residual of
    /// `tolerance` times the right-hand side: the solution and the shift \[relative to the mean diagonal\]. `None` where they do not converge.
    pub(crate) fn iterate(&mut self, right: &[f64], tolerance: f64, shifts: usize) -> Shifted {
        let positions = self.body.positions.as_flattened().iter();
        let positions: Vec<f64> =
            positions.zip(&self.assembly.displacement).map(|(x, u)| x + u).collect();
        let matrix = (&*self.sparsity, &self.assembly.matrix[..]);
        self.iterates = true;
        let aggregation = &mut self.aggregation;
        on_ready_threads(|| aggregation.solve_shifted(matrix, &positions, right, tolerance, shifts))
    }

    /// Change of the free displacements that balances forces, by the stiffness that was assembled last; `None` where that is not positive definite.
    /// Conjugate gradients leave a residual of `tolerance` times the forces.
    pub(crate) fn definite_response(&mut self, forces: &[f64], tolerance: f64) -> Option<Vec<f64>> {
        if self.method == Method::Aggregation {
            let right: Vec<f64> = forces.iter().map(|f| -f).collect();
            self.aggregation.drop_hierarchy();
            return self.iterate(&right, tolerance, 1).map(|(change, _)| change);
        }
        self.iterates = false;
        let definite = self.factor.definite(&self.sparsity, &self.assembly.matrix);
        let solved = definite.then(|| self.solve(forces, 0.0).ok()).flatten();
        solved.map(|(change, _)| change)
    }

    /// Solves with the stiffness and the shift of the last [`System::iterate`].
    fn iterate_again(&self, right: &[f64], tolerance: f64) -> Iterated {
        let aggregation = &self.aggregation;
        on_ready_threads(|| aggregation.solve(right, tolerance, MOST_ITERATIONS))
    }

    /// Overwrites forces with the change of the free displacements by the stiffness that was factorised last. Conjugate gradients leave a residual of
    /// `tolerance` times the forces, and NaN where they do not converge.
    pub(crate) fn back_substitute(&self, forces: &mut [f64], tolerance: f64) {
        if self.iterates {
            match self.iterate_again(forces, tolerance) {
                (change, _, End::Converged) => forces.copy_from_slice(&change),
                _ => forces.fill(f64::NAN),
            }
        } else {
            self.factor.solve(forces);
        }
    }

    /// Solves for a change of the unknowns (free displacements, then pressures) by the whole derivative of the balance;
    /// `shift` is that of the factor. Also returns the outcome of the iteration; Newton steps may be inexact.
    pub(crate) fn solve(&self, forces: &[f64], shift: f64) -> Result<(Vec<f64>, LinearOutcome)> {
        let mut right: Vec<f64> = forces.iter().map(|f| -f).collect();
        if self.iterates {
            let (change, iterations, end) = self.iterate_again(&right, TOLERANCE);
            let solved = end == End::Converged;
            let outcome = LinearOutcome { iterations, relative_residual: TOLERANCE };
            return if solved { Ok((change, outcome)) } else { Err(SolveError::Singular) };
        }
        if self.body.has_potential() && shift == 0.0 && self.factor.is_double() {
            self.factor.solve(&mut right);
            return Ok((right, LinearOutcome { iterations: 0, relative_residual: 0.0 }));
        }
        let free = self.sparsity.unknowns();
        let mut change = vec![0.0; right.len()];
        let precondition = |from: &[f64], to: &mut [f64]| {
            to.copy_from_slice(from);
            let (forces, pressures) = to.split_at_mut(free);
            if let Some(coupling) = &self.coupling {
                coupling.solve_schur(pressures);
                let mut full = vec![0.0; self.body.prescribed.len()];
                coupling.add_forces(pressures, &mut full);
                let gathered = self.sparsity.gather(&full);
                forces.iter_mut().zip(gathered).for_each(|(force, more)| *force -= more);
            }
            self.factor.solve(forces);
        };
        let apply = |from: &[f64], to: &mut [f64]| self.apply(from, to);
        let outcome = gmres(apply, precondition, &right, &mut change, TOLERANCE, MOST_GMRES);
        let solved = change.iter().all(|c| c.is_finite());
        if solved { Ok((change, outcome)) } else { Err(SolveError::Singular) }
    }

    /// Adds `−K⁻¹ forces` to the free degrees of freedom, with the last factor.
    pub(crate) fn add_newton_step(&self, forces: &[f64], displacement: &mut [f64]) {
        let mut right: Vec<_> = self.sparsity.gather(forces).map(|f| -f).collect();
        self.back_substitute(&mut right, CORRECTION);
        self.sparsity.scatter(right, displacement);
    }

    /// `−K⁻¹ forces`, zero at prescribed degrees of freedom.
    pub(crate) fn newton_step(&self, forces: &[f64]) -> Vec<f64> {
        let mut step = vec![0.0; forces.len()];
        self.add_newton_step(forces, &mut step);
        step
    }

    /// Derivative of the balance in the load factor.
    pub(crate) fn load_derivative(&self, displacement: &[f64], theta: &[f64]) -> Vec<f64> {
        let mut forces = load_gradient(self.body, displacement, theta);
        self.followers.add_forces(displacement, theta, &mut forces);
        let free = self.sparsity.gather(&forces);
        free.chain(std::iter::repeat_n(0.0, self.pressures())).collect()
    }
}

/// Method for the linear systems of a body with a potential, while Newton's method searches for its minimum.
///
/// Both meet the same accuracy of equilibria. A factor tells whether each stiffness is positive definite. Negative eigenvalues are
/// counted at the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// [`Method::Aggregation`] for compact bodies from some 9000 nodes on: 20 000 unknowns, and a factor of more than 400 entries per unknown. Slender
    /// bodies, whose factors are cheap, take [`Method::Factor`]. So do those whose K/μ at rest makes conjugate gradients dearer than a factor, in single precision.
    #[default]
    Automatic,
    /// A sparse Cholesky factor of each stiffness.
    Factor,
    /// Conjugate gradients preconditioned by smoothed aggregation, no more accurate than each Newton step needs (Eisenstat–Walker). A search whose systems
    /// take too many iterations goes on with factors of up to 4 GB, and fails where they take more ([`crate::Advice::FactorTooLarge`]). Bodies without a potential
    /// are always factorised.
    #[doc(alias("algebraic multigrid", "AMG", "conjugate gradients"))]
    Aggregation,
}

/// Most unknowns where a factor is faster, and its most entries \[per unknown\] there. Seconds by factors and by aggregation: 4.2 and 10.4 for a slender beam of 19 649
/// nodes and 228 entries per unknown, 3.0 and 3.6 for a beam of 10 332 and 558, 5.0 and 2.7 for a ventricle of 9005 and 415.
const SMALL: usize = 20_000;
const SPARSE: usize = 400;
/// Operations of a factor \[per stored entry of the stiffness\] from which on aggregation is faster, as a multiple of K/μ at rest: with 28 231 nodes both take as long at 1600.
const OPERATIONS: f64 = 20.0;
/// Most entries of a factor that is taken unasked: 2 GB in single, 4 in double precision.
pub(crate) const MOST_SINGLE: usize = 500_000_000;
/// Most entries of one that is computed at every solution: with 100 000 nodes it would take a quarter of the time and half as much memory again.
pub(crate) const MOST_COUNTED: usize = 250_000_000;

impl Method {
    /// The method for a body, and whether factors are in single precision.
    pub(crate) fn chosen(
        self,
        has_potential: bool,
        bulk_to_shear: Option<f64>,
        factor: &Factor,
        sparsity: &Sparsity,
    ) -> (Self, bool) {
        let unknowns = sparsity.unknowns();
        let large = unknowns > SMALL && factor.entries() > SPARSE * unknowns;
        let worth = |ratio| ratio * OPERATIONS * sparsity.entries() as f64 <= factor.operations();
        match self {
            _ if !has_potential => (Self::Factor, false),
            Self::Automatic if large && bulk_to_shear.is_none_or(worth) => {
                (Self::Aggregation, false)
            }
            Self::Automatic => (Self::Factor, large),
            forced => (forced, false),
        }
    }
}
