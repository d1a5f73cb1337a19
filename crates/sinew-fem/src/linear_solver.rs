//! How the linear systems of Newton's method are solved: by a factor or by iteration.

use crate::SolveError;
use crate::factor::{Factor, least_shift};
use crate::linear::conjugate_gradients::End;
use crate::linear::iterative::Iterative;
use crate::sparsity::Sparsity;
use sinew_energy::Frames;

/// Unknowns from which on [`LinearSolver::Automatic`] iterates.
const ITERATIVE_FROM: usize = 200_000;
/// Most iterations of one system: beyond, a factor is cheaper where it fits in memory.
const MOST_ITERATIONS: usize = 400;
/// Accuracy of the solve that looks for negative curvature at an equilibrium. Conjugate gradients find the
/// ends of the spectrum long before.
const PROBE_ACCURACY: f64 = 1e-6;

/// How a [`Solver`](crate::Solver) solves its linear systems.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearSolver {
    /// Directly below 200 000 unknowns, iteratively from there on.
    #[default]
    Automatic,
    /// By a Cholesky factor: as fast for nearly incompressible bodies as for others, and it counts negative
    /// eigenvalues; its memory grows faster than the body.
    Direct,
    /// By conjugate gradients with smoothed aggregation as preconditioner: memory grows with the body. An
    /// indefinite stiffness is found, but its negative eigenvalues are not counted; systems that converge too
    /// slowly are factorised after all.
    Iterative,
}

/// How the solution of one system ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Solved {
    /// As accurately as asked for.
    Done,
    /// The matrix turned out not to be positive definite.
    Indefinite,
    /// The iteration is too slow, or overflows where a factor need not.
    TooSlow,
}

/// Solves systems with the stiffness of one body.
pub(crate) enum LinearSystem {
    Direct(Factor),
    Iterative(Box<Iterative>),
}

impl LinearSystem {
    /// Prepares for a sparsity.
    pub fn new(choice: LinearSolver, sparsity: &Sparsity) -> Result<Self, SolveError> {
        let iterate = match choice {
            LinearSolver::Automatic => sparsity.unknowns() >= ITERATIVE_FROM,
            LinearSolver::Direct => false,
            LinearSolver::Iterative => true,
        };
        if !iterate {
            return Factor::new(sparsity).map(Self::Direct);
        }
        let (starts, rows) = (sparsity.pattern.col_ptr(), sparsity.pattern.row_idx());
        let iterative = Iterative::new(&sparsity.degree_of_freedom, starts, rows);
        Ok(Self::Iterative(Box::new(iterative)))
    }

    /// Another one for the same sparsity: its own numbers, the same analysis.
    pub fn fresh(&self) -> Result<Self, SolveError> {
        match self {
            Self::Direct(factor) => factor.fresh().map(Self::Direct),
            Self::Iterative(iterative) => Ok(Self::Iterative(iterative.clone())),
        }
    }

    /// Stored bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Direct(factor) => 8 * factor.entries(),
            Self::Iterative(iterative) => iterative.bytes(),
        }
    }

    /// Says where the nodes are when the next matrix comes, and which axes their unknowns are along.
    pub fn place(&mut self, positions: &[[f64; 3]], displacement: &[f64], frames: &Frames) {
        if let Self::Iterative(iterative) = self {
            let moved = displacement.as_chunks::<3>().0;
            let position =
                |node: usize| std::array::from_fn(|i| positions[node][i] + moved[node][i]);
            iterative.place(position, |dof| frames.axis(dof));
        }
    }

    /// Iterations of a system with the last hierarchy, `None` where there is a factor.
    pub fn iterations(&self) -> Option<usize> {
        match self {
            Self::Direct(_) => None,
            Self::Iterative(iterative) => iterative.iterations(),
        }
    }

    /// Takes a matrix; false where it is found not to be positive definite. Iteration may find that only
    /// while it solves.
    pub fn positive_definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        match self {
            Self::Direct(factor) => factor.positive_definite(sparsity, matrix),
            Self::Iterative(iterative) => iterative.set(&matrix[..sparsity.entries()]),
        }
    }

    /// Whether [`Self::positive_definite`] is certain.
    pub fn is_certain(&self) -> bool {
        matches!(self, Self::Direct(_))
    }

    /// Takes a matrix, and looks for negative curvature of it.
    pub fn surely_positive_definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        if let Self::Iterative(iterative) = self {
            let set = iterative.renew(&matrix[..sparsity.entries()]);
            let mut right: Vec<_> = (0..sparsity.unknowns()).map(scattered).collect();
            let end = set.then(|| iterative.solve(&mut right, PROBE_ACCURACY, MOST_ITERATIONS).end);
            match end {
                Some(End::Converged) => return true,
                Some(End::Exhausted | End::NotFinite)
                    if self.factorise_instead(sparsity).is_ok() => {}
                _ => return false,
            }
        }
        self.positive_definite(sparsity, matrix)
    }

    /// Takes a matrix with negative eigenvalues and counts them. `None` where one vanishes, or where they
    /// cannot be counted.
    pub fn indefinite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> Option<usize> {
        match self {
            Self::Direct(factor) => factor.indefinite(sparsity, matrix),
            Self::Iterative(_) => None,
        }
    }

    /// Takes the matrix plus the least multiple of its mean diagonal, above `above`, that was found to make
    /// it positive definite; returns the multiple.
    pub fn shifted(&mut self, sparsity: &Sparsity, matrix: &mut [f64], above: f64) -> Option<f64> {
        least_shift(sparsity, matrix, above, |matrix| self.positive_definite(sparsity, matrix))
    }

    /// Overwrites a right-hand side with the solution of the last system; iteration ends at a residual of
    /// `accuracy` times the right-hand side.
    pub fn solve(&mut self, right: &mut [f64], accuracy: f64) -> Solved {
        match self {
            Self::Direct(factor) => {
                factor.solve(right);
                Solved::Done
            }
            Self::Iterative(iterative) => {
                match iterative.solve(right, accuracy, MOST_ITERATIONS).end {
                    End::Converged => Solved::Done,
                    End::NegativeCurvature => Solved::Indefinite,
                    End::Exhausted | End::NotFinite => Solved::TooSlow,
                }
            }
        }
    }

    /// Changes over to a factor for good.
    pub fn factorise_instead(&mut self, sparsity: &Sparsity) -> Result<(), SolveError> {
        *self = Self::Direct(Factor::new(sparsity)?);
        Ok(())
    }
}

/// Numbers between −1 and 1 without a pattern that a body could share.
fn scattered(index: usize) -> f64 {
    let mixed = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
