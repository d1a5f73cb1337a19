//! Smoothed aggregation: a hierarchy of ever coarser systems that preconditions a stiffness matrix.

use super::blocks::{Block, BlockMatrix, ROWS, add_product, definite_inverse, single, times};
use crate::linear::aggregation::pattern::{MODES, groups, tentative};
use crate::linear::{Factor, largest, update};
use faer::sparse::Triplet;
use sinew_num::{fill, in_parallel, in_tasks};

/// Systems with up to this many block rows are factorised.
const COARSEST: usize = 600;
/// Most levels between the finest and the coarsest: each has about a tenth of the rows of the one before.
const MOST_LEVELS: usize = 12;
/// Coupling that counts as strong on the finest level; half as much on each coarser one (Vaněk et al., section 5).
const STRONG: f64 = 0.08;
/// Most groups \[relative to the rows\]: beyond it, as after a large shift, any coupling is strong.
const SLOW: f64 = 0.15;
/// Polynomial degree of the smoother.
const SMOOTHING: usize = 2;
/// Iterations for the largest eigenvalue, and how much it is raised because they come from below.
const POWER_ITERATIONS: usize = 15;
const RAISE: f32 = 1.1;

/// A preconditioner by smoothed aggregation (P. Vaněk, J. Mandel, M. Brezina, Computing 56, 1996) with the
/// rigid motions as near null space: a symmetric V-cycle in single precision.
pub(super) struct Multigrid {
    finest: Level<3>,
    coarser: Vec<Level<MODES>>,
    coarsest: Factor,
}

/// A system, its smoother, and the transfer to the next coarser one.
struct Level<const B: usize> {
    matrix: BlockMatrix<f32, B, B>,
    inverse_diagonal: Vec<Block<f32, B, B>>,
    largest_eigenvalue: f32,
    prolongation: BlockMatrix<f32, B, MODES>,
    restriction: BlockMatrix<f32, MODES, B>,
}

/// A coarser system, and the modes on it.
struct Coarse {
    matrix: BlockMatrix<f64, MODES, MODES>,
    modes: Vec<Block<f64, MODES, MODES>>,
}

impl Multigrid {
    /// Builds the hierarchy of a matrix of nodes from their rigid motions; `None` where the matrix proves not to be positive definite.
    pub(super) fn new(
        matrix: &BlockMatrix<f64, 3, 3>,
        modes: &[Block<f64, 3, MODES>],
    ) -> Option<Self> {
        let mut strong = STRONG;
        let (finest, mut coarse) = Level::new(matrix, modes, strong)?;
        let mut coarser = Vec::new();
        while coarse.matrix.height() > COARSEST {
            if coarser.len() == MOST_LEVELS {
                return None;
            }
            strong *= 0.5;
            let (level, next) = Level::new(&coarse.matrix, &coarse.modes, strong)?;
            coarser.push(level);
            coarse = next;
        }
        Some(Self { finest, coarser, coarsest: factor(&coarse.matrix)? })
    }

    /// A V-cycle, in single precision.
    pub(super) fn preconditioner(&self) -> impl FnMut(&[f64], &mut [f64]) + '_ {
        let mut vectors = self.vectors();
        move |from, to| {
            // Single precision holds no small residuals.
            let size = largest(from);
            let scaled = vectors.finest.residual.as_flattened_mut();
            update(scaled, from, |to, x| *to = (x / size) as f32);
            self.apply(&mut vectors);
            update(to, vectors.finest.solution.as_flattened(), |to, x| *to = size * f64::from(x));
        }
    }

    /// The vectors of a V-cycle.
    fn vectors(&self) -> Vectors {
        let coarser = self.coarser.iter().map(|level| level.restriction.height());
        let heights = [self.finest.restriction.height()].into_iter().chain(coarser);
        Vectors {
            finest: LevelVectors::new(self.finest.matrix.height()),
            coarser: heights.map(LevelVectors::new).collect(),
        }
    }

    /// Replaces the solution of the finest level by an approximate one for its residual.
    fn apply(&self, vectors: &mut Vectors) {
        let Vectors { finest, coarser } = vectors;
        self.finest.cycle(finest, coarser, |coarser| self.solve_coarser(0, coarser));
    }

    fn solve_coarser(&self, level: usize, vectors: &mut [LevelVectors<MODES>]) {
        let Some((own, coarser)) = vectors.split_first_mut() else { return };
        if let Some(system) = self.coarser.get(level) {
            return system.cycle(own, coarser, |rest| self.solve_coarser(level + 1, rest));
        }
        let mut solution: Vec<f64> =
            own.residual.as_flattened().iter().map(|&x| x.into()).collect();
        self.coarsest.solve(&mut solution);
        let components = own.solution.as_flattened_mut().iter_mut().zip(solution);
        components.for_each(|(to, x)| *to = x as f32);
    }
}

/// The vectors of a V-cycle: memory that all cycles of a system use.
struct Vectors {
    finest: LevelVectors<3>,
    coarser: Vec<LevelVectors<MODES>>,
}

/// The vectors of a level.
struct LevelVectors<const B: usize> {
    solution: Vec<[f32; B]>,
    /// Right-hand side minus the matrix times the solution, but for the last step.
    residual: Vec<[f32; B]>,
    step: Vec<[f32; B]>,
}

impl<const B: usize> LevelVectors<B> {
    fn new(height: usize) -> Self {
        let zeros = vec![[0.0; B]; height];
        Self { solution: zeros.clone(), residual: zeros.clone(), step: zeros }
    }
}

impl<const B: usize> Level<B> {
    fn new(
        matrix: &BlockMatrix<f64, B, B>,
        modes: &[Block<f64, B, MODES>],
        strong: f64,
    ) -> Option<(Self, Coarse)> {
        let inverse = |row: usize| {
            let (_, block) = matrix.row(row).find(|&(column, _)| column == row)?;
            definite_inverse(block)
        };
        let inverse_diagonal = in_tasks(matrix.height(), ROWS, inverse);
        let inverse_diagonal: Vec<_> = inverse_diagonal.into_iter().collect::<Option<_>>()?;
        let (mut group, mut count) = groups(matrix, strong);
        if count as f64 > SLOW * matrix.height() as f64 {
            (group, count) = groups(matrix, 0.0);
        }
        let single_inverse: Vec<_> = inverse_diagonal.iter().map(single).collect();
        let single_matrix = matrix.rounded();
        let largest_eigenvalue = RAISE * largest_eigenvalue(&single_matrix, &single_inverse)?;
        // P = (1 − ω D⁻¹ A) P̂ with ω = 4/3 of the largest eigenvalue's inverse.
        let (tentative, modes) = tentative(&group, count, modes);
        let mut prolongation = matrix.product(&tentative);
        let damping = -4.0 / 3.0 / f64::from(largest_eigenvalue);
        prolongation.change_rows(
            || (),
            |(), row, columns, blocks| {
                let inverse = inverse_diagonal[row].map(|row| row.map(|x| damping * x));
                for (&column, slot) in columns.iter().zip(blocks) {
                    let inside = column == group[row];
                    let mut block = if inside { tentative.blocks[row] } else { [[0.0; MODES]; B] };
                    add_product(&inverse, slot, &mut block);
                    *slot = block;
                }
            },
        );
        let restriction = prolongation.transposed();
        let mut coarse = restriction.product(&matrix.product(&prolongation));
        fill_empty_modes(&mut coarse);
        let level = Self {
            matrix: single_matrix,
            inverse_diagonal: single_inverse,
            largest_eigenvalue,
            prolongation: prolongation.rounded(),
            restriction: restriction.rounded(),
        };
        Some((level, Coarse { matrix: coarse, modes }))
    }

    /// A V-cycle from zero; `solve` solves the coarse system.
    fn cycle(
        &self,
        own: &mut LevelVectors<B>,
        coarser: &mut [LevelVectors<MODES>],
        solve: impl FnOnce(&mut [LevelVectors<MODES>]),
    ) {
        self.smooth(own, true);
        self.matrix.subtract_product(&own.step, &mut own.residual);
        self.restriction.multiply(&own.residual, &mut coarser[0].residual);
        solve(coarser);
        self.prolongation.multiply(&coarser[0].solution, &mut own.step);
        let solution = own.solution.as_flattened_mut();
        update(solution, own.step.as_flattened(), |to, step| *to += step);
        self.matrix.subtract_product(&own.step, &mut own.residual);
        self.smooth(own, false);
    }

    /// Smooths the error by a Chebyshev polynomial of the fourth kind in `D⁻¹ A` (J. Lottes, Numer. Linear
    /// Algebra Appl. 30, 2023): it needs no smallest eigenvalue. The residual does not yet know the last step.
    fn smooth(&self, vectors: &mut LevelVectors<B>, from_zero: bool) {
        let LevelVectors { solution, residual, step } = vectors;
        for degree in 1..=SMOOTHING {
            if degree > 1 {
                self.matrix.subtract_product(step, residual);
            }
            let k = degree as f32;
            let keep = if degree == 1 { 0.0 } else { (2.0 * k - 3.0) / (2.0 * k + 1.0) };
            let gain = (8.0 * k - 4.0) / (2.0 * k + 1.0) / self.largest_eigenvalue;
            let solution_before = if from_zero && degree == 1 { 0.0 } else { 1.0 };
            let rows = step.chunks_mut(ROWS).zip(solution.chunks_mut(ROWS)).enumerate();
            in_parallel(rows, |(chunk, (step, solution))| {
                let rows = step.iter_mut().zip(solution).zip(ROWS * chunk..);
                for ((step, solution), row) in rows {
                    let correction = times(&self.inverse_diagonal[row], &residual[row]);
                    for i in 0..B {
                        step[i] = keep * step[i] + gain * correction[i];
                        solution[i] = solution_before * solution[i] + step[i];
                    }
                }
            });
        }
    }
}

/// Largest eigenvalue of `D⁻¹ A`, from below, by power iteration from a scattered start. `None` where it exceeds the number of blocks of
/// every row, the bound of a positive definite matrix.
fn largest_eigenvalue<const B: usize>(
    matrix: &BlockMatrix<f32, B, B>,
    inverse_diagonal: &[Block<f32, B, B>],
) -> Option<f32> {
    let scattered = |i: usize| ((i * 7919 + 13) % 101) as f32 / 50.0 - 1.0;
    let mut vector: Vec<[f32; B]> =
        (0..matrix.height()).map(|row| std::array::from_fn(|i| scattered(B * row + i))).collect();
    let norm = |vector: &[[f32; B]]| {
        vector.as_flattened().iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt() as f32
    };
    let (mut eigenvalue, mut next) = (1.0, vector.clone());
    for _ in 0..POWER_ITERATIONS {
        let scale = 1.0 / norm(&vector);
        vector.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
        matrix.multiply(&vector, &mut next);
        fill(&mut vector, ROWS, |row| times(&inverse_diagonal[row], &next[row]));
        eigenvalue = norm(&vector);
    }
    let widest = matrix.starts.windows(2).map(|pair| pair[1] - pair[0]).max()?;
    (eigenvalue <= widest as f32).then_some(eigenvalue)
}

/// Gives coarse functions that are zero, since their group has fewer motions, a diagonal of 1.
fn fill_empty_modes(matrix: &mut BlockMatrix<f64, MODES, MODES>) {
    for row in 0..matrix.height() {
        for slot in matrix.starts[row]..matrix.starts[row + 1] {
            if matrix.columns[slot] as usize == row {
                let block = &mut matrix.blocks[slot];
                for i in 0..MODES {
                    if block[i][i] == 0.0 {
                        block[i][i] = 1.0;
                    }
                }
            }
        }
    }
}

/// The factor of the coarsest system; `None` where it is not positive definite.
fn factor(matrix: &BlockMatrix<f64, MODES, MODES>) -> Option<Factor> {
    let mut half = Vec::new();
    for row in 0..matrix.height() {
        for (column, block) in matrix.row(row).filter(|&(column, _)| column <= row) {
            for (i, entries) in block.iter().enumerate() {
                let (row, first) = (MODES * row + i, MODES * column);
                let lower = entries.iter().enumerate().filter(|&(j, _)| first + j <= row);
                half.extend(lower.map(|(j, &entry)| Triplet::new(row, first + j, entry)));
            }
        }
    }
    Factor::alone(MODES * matrix.height(), &half)
}
