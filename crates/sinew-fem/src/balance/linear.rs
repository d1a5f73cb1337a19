//! The linear systems of a balance of forces.

use super::gmres::{LinearOutcome, gmres};
use super::{BalanceSolver, System};
use crate::SolveError;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, Side};

/// Residual of a linear system relative to its right-hand side: Newton's method stays quadratic down to it.
const LINEAR_TOLERANCE: f64 = 1e-9;
/// Most iterations of one linear system.
const MOST_LINEAR_ITERATIONS: usize = 400;

/// Factors that precondition the linear systems at one state.
pub(super) struct Preconditioner {
    /// Of the pressure's mass matrix over the local modulus, if there is a field.
    schur: Option<Llt<usize, f64>>,
    /// Negative pivots of the symmetric part of the stiffness.
    pub negative_pivots: usize,
    /// Shift that made it definite where its factorisation failed.
    pub shift: f64,
}

impl BalanceSolver<'_> {
    /// Factorises what was assembled last.
    pub(super) fn precondition(&mut self) -> Result<Preconditioner, SolveError> {
        let (mut shift, mut negative_pivots) = (0.0, 0);
        let System { sparsity, assembly, .. } = &mut self.system;
        if !self.factor.positive_definite(sparsity, &assembly.matrix) {
            match self.factor.indefinite(sparsity, &assembly.matrix) {
                Some(count) => negative_pivots = count,
                None => {
                    let found = self.factor.shifted(sparsity, &mut assembly.matrix);
                    (shift, negative_pivots) = (found.ok_or(SolveError::Singular)?, 1);
                }
            }
        }
        Ok(Preconditioner { schur: self.system.schur_factor()?, negative_pivots, shift })
    }

    /// Solves for a change of the unknowns (free displacements, then pressures).
    pub(super) fn solve_linear(
        &mut self,
        preconditioner: &Preconditioner,
        right: &[f64],
    ) -> (Vec<f64>, LinearOutcome) {
        let Self { system, factor } = self;
        let free = system.sparsity.unknowns();
        let mut change = vec![0.0; right.len()];
        let precondition = |from: &[f64], to: &mut [f64]| {
            to.copy_from_slice(from);
            let (forces, pressures) = to.split_at_mut(free);
            if let Some(schur) = &preconditioner.schur {
                let size = pressures.len();
                schur.solve_in_place(MatMut::from_column_major_slice_mut(pressures, size, 1));
                pressures.iter_mut().for_each(|p| *p = -*p);
                let mut full = vec![0.0; system.body.body.prescribed.len()];
                system.add_pressure_forces(pressures, &mut full);
                let gathered = system.sparsity.gather(&full);
                forces.iter_mut().zip(gathered).for_each(|(force, more)| *force -= more);
            }
            factor.solve(forces);
        };
        let outcome = gmres(
            |from, to| system.apply(from, to),
            precondition,
            right,
            &mut change,
            LINEAR_TOLERANCE,
            MOST_LINEAR_ITERATIONS,
        );
        (change, outcome)
    }
}

impl System<'_> {
    fn schur_factor(&self) -> Result<Option<Llt<usize, f64>>, SolveError> {
        let Some(field) = &self.body.pressure_field else { return Ok(None) };
        let mut triplets = Vec::with_capacity(field.cells.len() * field.corners);
        for (cell, corners) in field.cells.chunks(field.corners).enumerate() {
            for (a, &row) in corners.iter().enumerate() {
                for (b, &column) in corners.iter().enumerate().filter(|(_, c)| **c <= row) {
                    let first = cell * field.shape.len();
                    let terms = field.shape.iter().enumerate().map(|(q, n)| {
                        let volume = self.body.body.volumes[first + q];
                        volume * n[a] * n[b] * (1.0 / self.moduli[first + q] + field.compliance)
                    });
                    triplets.push(Triplet::new(row, column, terms.sum::<f64>()));
                }
            }
        }
        let size = field.unknowns;
        let memory = || SolveError::OutOfMemory { unknowns: size };
        let matrix =
            SparseColMat::try_new_from_triplets(size, size, &triplets).map_err(|_| memory())?;
        let symbolic =
            SymbolicLlt::try_new(matrix.symbolic(), Side::Lower).map_err(|_| memory())?;
        let factor = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower);
        Ok(Some(factor.map_err(|_| SolveError::Singular)?))
    }

    /// The derivative of the balance times a change of the unknowns.
    fn apply(&self, from: &[f64], to: &mut [f64]) {
        let free = self.sparsity.unknowns();
        let (displacements, pressures) = from.split_at(free);
        let (forces, volumes) = to.split_at_mut(free);
        self.sparsity.multiply(&self.assembly.matrix, displacements, forces);
        if self.followers.is_empty() && self.body.pressure_field.is_none() {
            return;
        }
        let mut direction = vec![0.0; self.body.body.prescribed.len()];
        self.sparsity.scatter(displacements.iter().copied(), &mut direction);
        let mut full = vec![0.0; direction.len()];
        self.add_skew(&direction, &mut full);
        self.add_pressure_forces(pressures, &mut full);
        let gathered = self.sparsity.gather(&full);
        forces.iter_mut().zip(gathered).for_each(|(force, more)| *force += more);
        volumes.fill(0.0);
        self.add_volume_changes(&direction, volumes);
        self.add_compliance(pressures, volumes);
    }

    fn add_compliance(&self, pressures: &[f64], volumes: &mut [f64]) {
        let Some(field) = &self.body.pressure_field else { return };
        if field.compliance == 0.0 {
            return;
        }
        for (cell, corners) in field.cells.chunks(field.corners).enumerate() {
            for (q, n) in field.shape.iter().enumerate() {
                let weight = self.body.body.volumes[cell * field.shape.len() + q];
                let p: f64 = n.iter().zip(corners).map(|(n, &c)| n * pressures[c]).sum();
                for (n, &c) in n.iter().zip(corners) {
                    volumes[c] -= field.compliance * weight * n * p;
                }
            }
        }
    }
}
