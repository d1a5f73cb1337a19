//! Restarted GMRES for systems whose matrix is not symmetric positive definite.

use crate::linear::vector::{dot, norm};

/// Krylov vectors that are kept before a restart.
const RESTART: usize = 80;

/// Least new part of an image \[relative to the image\]; below it the system is singular to rounding errors.
const SINGULAR: f64 = 1e-14;

/// Outcome of an iterative solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinearOutcome {
    /// Matrix–vector products.
    pub iterations: usize,
    /// Norm of the residual relative to that of the right-hand side.
    pub relative_residual: f64,
}

/// Solves `A x = b` by GMRES with right preconditioning (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7,
/// 1986), from x = 0. The monitored residual is the true one, whatever the preconditioner.
///
/// `apply(x, y)` writes A x to y; `precondition(x, y)` an approximation of A⁻¹ x.
pub(crate) fn gmres(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    right: &[f64],
    solution: &mut [f64],
    tolerance: f64,
    most_iterations: usize,
) -> LinearOutcome {
    let size = right.len();
    solution.fill(0.0);
    let scale = norm(right);
    let mut outcome = LinearOutcome { iterations: 0, relative_residual: 0.0 };
    if scale == 0.0 {
        return outcome;
    }
    let mut residual = right.to_vec();
    let mut scratch = vec![0.0; size];
    loop {
        let start = norm(&residual);
        outcome.relative_residual = start / scale;
        // Written so that a NaN ends the iteration as well.
        let going = outcome.relative_residual > tolerance && start.is_finite();
        if !going || outcome.iterations >= most_iterations {
            return outcome;
        }
        let mut cycle = Cycle::new(&residual, start);
        while cycle.triangle.len() < RESTART && outcome.iterations < most_iterations {
            precondition(cycle.last(), &mut scratch);
            let mut next = vec![0.0; size];
            apply(&scratch, &mut next);
            outcome.iterations += 1;
            match cycle.add(next) {
                Some(left) if left > tolerance * scale => {}
                _ => break,
            }
        }
        let Cycle { basis, triangle, reduced, .. } = cycle;
        if triangle.is_empty() {
            return outcome;
        }
        let weights = back_substitute(&triangle, &reduced);
        let mut correction = vec![0.0; size];
        for (vector, weight) in basis.iter().zip(&weights) {
            correction.iter_mut().zip(vector).for_each(|(c, v)| *c += weight * v);
        }
        precondition(&correction, &mut scratch);
        solution.iter_mut().zip(&scratch).for_each(|(x, d)| *x += d);
        apply(solution, &mut scratch);
        residual.iter_mut().zip(right).zip(&scratch).for_each(|((r, b), ax)| *r = b - ax);
        if norm(&residual) > 0.5 * start && triangle.len() < RESTART {
            // Rounding errors: the true residual no longer follows the predicted one, so further iterations gain nothing.
            outcome.relative_residual = norm(&residual) / scale;
            return outcome;
        }
    }
}

/// The Krylov space between two restarts: an orthonormal basis, and the least-squares problem in it.
struct Cycle {
    basis: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    reduced: Vec<f64>,
}

impl Cycle {
    fn new(residual: &[f64], length: f64) -> Self {
        let basis = vec![residual.iter().map(|r| r / length).collect()];
        Self { basis, triangle: Vec::new(), rotations: Vec::new(), reduced: vec![length] }
    }

    fn last(&self) -> &[f64] {
        &self.basis[self.basis.len() - 1]
    }

    /// Adds the image of the last vector; returns the norm of the residual. `None` where it is not a new direction.
    fn add(&mut self, mut next: Vec<f64>) -> Option<f64> {
        let (image, last) = (norm(&next), self.basis.len() - 1);
        let mut column = vec![0.0; self.basis.len()];
        // Twice: modified Gram–Schmidt alone loses orthogonality on ill-conditioned systems.
        for _ in 0..2 {
            for (vector, entry) in self.basis.iter().zip(&mut column) {
                let along = dot(vector, &next);
                next.iter_mut().zip(vector).for_each(|(n, v)| *n -= along * v);
                *entry += along;
            }
        }
        let length = norm(&next);
        for (k, [c, s]) in self.rotations.iter().enumerate() {
            let (a, b) = (column[k], column[k + 1]);
            (column[k], column[k + 1]) = (c * a + s * b, c * b - s * a);
        }
        let diagonal = column[last].hypot(length);
        // Written so that a NaN ends the iteration as well.
        let independent = diagonal > SINGULAR * image && diagonal.is_finite();
        if !independent {
            return None;
        }
        let [c, s] = [column[last] / diagonal, length / diagonal];
        column[last] = diagonal;
        self.rotations.push([c, s]);
        self.reduced.push(-s * self.reduced[last]);
        self.reduced[last] *= c;
        self.triangle.push(column);
        self.basis.push(next.iter().map(|x| x / length).collect());
        Some(if length == 0.0 { 0.0 } else { self.reduced[last + 1].abs() })
    }
}

/// Solves the triangular system whose columns are given.
fn back_substitute(triangle: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let size = triangle.len();
    let mut solution = right[..size].to_vec();
    for row in (0..size).rev() {
        for column in row + 1..size {
            solution[row] -= triangle[column][row] * solution[column];
        }
        solution[row] /= triangle[row][row];
    }
    solution
}
