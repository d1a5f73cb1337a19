//! Smoothed aggregation: a hierarchy of ever coarser systems that preconditions a stiffness matrix.

use super::aggregates::{MODES, aggregates, tentative};
use super::blocks::{Block, BlockMatrix, definite_inverse, times};
use super::cholesky::Cholesky;
use super::ordering::fill_reducing_order;
use crate::vector::norm;
use rayon::prelude::*;

/// Systems with up to this many block rows are solved directly.
const COARSEST: usize = 600;
/// Most levels: each has about a tenth of the rows of the one before.
const MOST_LEVELS: usize = 12;
/// Coupling that counts as strong on the finest level; half as much on each coarser one (Vaněk et al., §5).
const STRONG: f64 = 0.08;
/// A coarser level with more groups than this part of the rows is not worth it: any coupling is strong then.
const SLOW: f64 = 0.4;
/// Polynomial degree of the smoother.
const SMOOTHING: usize = 2;
/// Iterations for the largest eigenvalue, and how much it is raised because they come from below.
const POWER_ITERATIONS: usize = 15;
const RAISE: f64 = 1.1;

/// A matrix that is not positive definite on some level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Indefinite;

/// A preconditioner by smoothed aggregation (P. Vaněk, J. Mandel, M. Brezina, Computing 56, 1996) with the
/// rigid motions as near null space: a symmetric V-cycle.
#[derive(Clone)]
pub(super) struct Multigrid {
    finest: Level<3>,
    coarser: Vec<Level<MODES>>,
    coarsest: Coarsest,
}

/// A system, how it is smoothed, and how it reaches the next coarser one. Matrices are rounded to single
/// precision: they only precondition, and reading them is what takes the time.
#[derive(Clone)]
struct Level<const B: usize> {
    matrix: BlockMatrix<f32, B, B>,
    inverse_diagonal: Vec<Block<f64, B, B>>,
    largest_eigenvalue: f64,
    prolongation: BlockMatrix<f32, B, MODES>,
    restriction: BlockMatrix<f32, MODES, B>,
    residual: Vec<[f64; B]>,
    step: Vec<[f64; B]>,
}

#[derive(Clone)]
struct Coarsest {
    /// Block row of each place in the order of elimination.
    order: Vec<usize>,
    factor: Cholesky,
    local: Vec<f64>,
}

/// A coarser system, and the modes on it.
struct Coarse {
    matrix: BlockMatrix<f64, MODES, MODES>,
    modes: Vec<Block<f64, MODES, MODES>>,
}

impl Multigrid {
    /// Builds the hierarchy of a matrix of nodes; `modes` has the rigid motions of each node.
    pub fn new(
        matrix: &BlockMatrix<f64, 3, 3>,
        modes: &[Block<f64, 3, MODES>],
    ) -> Result<Self, Indefinite> {
        let (finest, mut coarse) = Level::new(matrix, modes, STRONG)?;
        let mut coarser = Vec::new();
        let mut strong = STRONG;
        while coarse.matrix.height() > COARSEST && coarser.len() < MOST_LEVELS {
            strong *= 0.5;
            let (level, next) = Level::new(&coarse.matrix, &coarse.modes, strong)?;
            coarser.push(level);
            coarse = next;
        }
        let coarsest = Coarsest::new(&coarse.matrix)?;
        Ok(Self { finest, coarser, coarsest })
    }

    /// Stored bytes.
    pub fn bytes(&self) -> usize {
        let coarser: usize = self.coarser.iter().map(Level::bytes).sum();
        self.finest.bytes() + coarser + 8 * self.coarsest.factor.entries()
    }

    /// Overwrites `solution` with an approximate solution for `right`.
    pub fn apply(&mut self, right: &[[f64; 3]], solution: &mut [[f64; 3]]) {
        let Self { finest, coarser, coarsest } = self;
        finest.cycle(right, solution, |right, solution| {
            coarse_cycle(coarser, coarsest, right, solution);
        });
    }
}

fn coarse_cycle(
    levels: &mut [Level<MODES>],
    coarsest: &mut Coarsest,
    right: &[[f64; MODES]],
    solution: &mut [[f64; MODES]],
) {
    match levels.split_first_mut() {
        None => coarsest.solve(right, solution),
        Some((level, coarser)) => level.cycle(right, solution, |right, solution| {
            coarse_cycle(coarser, coarsest, right, solution);
        }),
    }
}

impl<const B: usize> Level<B> {
    fn new(
        matrix: &BlockMatrix<f64, B, B>,
        modes: &[Block<f64, B, MODES>],
        strong: f64,
    ) -> Result<(Self, Coarse), Indefinite> {
        let diagonal = |row: usize| {
            let own = matrix.row(row).find(|&(column, _)| column == row);
            own.and_then(|(_, block)| definite_inverse(block)).ok_or(Indefinite)
        };
        let inverse_diagonal: Vec<_> =
            (0..matrix.height()).map(diagonal).collect::<Result<_, _>>()?;
        let largest_eigenvalue = RAISE * largest_eigenvalue(matrix, &inverse_diagonal);
        let (mut group, mut count) = aggregates(matrix, strong);
        if count as f64 > SLOW * matrix.height() as f64 {
            (group, count) = aggregates(matrix, 0.0);
        }
        let (tentative, coarse_modes) = tentative(&group, count, modes);
        // P = (1 − ω D⁻¹ A) P̂ with ω = 4/3 of the largest eigenvalue's inverse.
        let mut prolongation = matrix.product(&tentative);
        let damping = 4.0 / 3.0 / largest_eigenvalue;
        for row in 0..matrix.height() {
            for at in prolongation.starts[row]..prolongation.starts[row + 1] {
                let own = prolongation.columns[at] == group[row];
                let block = &mut prolongation.blocks[at];
                let smooth = product(&inverse_diagonal[row], block);
                for i in 0..B {
                    for j in 0..MODES {
                        let plain = if own { tentative.blocks[row][i][j] } else { 0.0 };
                        block[i][j] = plain - damping * smooth[i][j];
                    }
                }
            }
        }
        let restriction = prolongation.transposed();
        let mut coarse = restriction.product(&matrix.product(&prolongation));
        fill_empty_modes(&mut coarse);
        let level = Self {
            matrix: matrix.rounded(),
            inverse_diagonal,
            largest_eigenvalue,
            prolongation: prolongation.rounded(),
            restriction: restriction.rounded(),
            residual: vec![[0.0; B]; matrix.height()],
            step: vec![[0.0; B]; matrix.height()],
        };
        Ok((level, Coarse { matrix: coarse, modes: coarse_modes }))
    }

    fn bytes(&self) -> usize {
        let single = 4 * B * B * self.matrix.blocks.len();
        single + 8 * B * MODES * self.prolongation.blocks.len() + 8 * B * (B + 2) * self.step.len()
    }

    /// A V-cycle from zero; `coarser` solves the coarse system.
    fn cycle(
        &mut self,
        right: &[[f64; B]],
        solution: &mut [[f64; B]],
        coarser: impl FnOnce(&[[f64; MODES]], &mut [[f64; MODES]]),
    ) {
        solution.fill([0.0; B]);
        self.residual.copy_from_slice(right);
        self.smooth(solution);
        let mut coarse_right = vec![[0.0; MODES]; self.prolongation.width];
        let mut coarse_solution = coarse_right.clone();
        self.restriction.multiply(&self.residual, &mut coarse_right);
        coarser(&coarse_right, &mut coarse_solution);
        self.step.fill([0.0; B]);
        self.prolongation.add_product(&coarse_solution, &mut self.step);
        add(&self.step, solution);
        self.matrix.subtract_product(&self.step, &mut self.residual);
        self.smooth(solution);
    }

    /// Smooths the error by a Chebyshev polynomial of the fourth kind in `D⁻¹ A` (J. Lottes, Numer. Linear
    /// Algebra Appl. 30, 2023): it needs no smallest eigenvalue. Keeps the residual up to date.
    fn smooth(&mut self, solution: &mut [[f64; B]]) {
        for degree in 1..=SMOOTHING {
            let k = degree as f64;
            let keep = if degree == 1 { 0.0 } else { (2.0 * k - 3.0) / (2.0 * k + 1.0) };
            let go = (8.0 * k - 4.0) / (2.0 * k + 1.0) / self.largest_eigenvalue;
            let rows = self.step.par_iter_mut().zip(&self.residual).zip(&self.inverse_diagonal);
            rows.with_min_len(512).for_each(|((step, residual), inverse)| {
                let correction = times(inverse, residual);
                for i in 0..B {
                    step[i] = keep * step[i] + go * correction[i];
                }
            });
            add(&self.step, solution);
            self.matrix.subtract_product(&self.step, &mut self.residual);
        }
    }
}

fn add<const B: usize>(from: &[[f64; B]], to: &mut [[f64; B]]) {
    to.as_flattened_mut().iter_mut().zip(from.as_flattened()).for_each(|(a, b)| *a += b);
}

fn product<const B: usize>(
    left: &Block<f64, B, B>,
    right: &Block<f64, B, MODES>,
) -> Block<f64, B, MODES> {
    let mut result = [[0.0; MODES]; B];
    for i in 0..B {
        for k in 0..B {
            for j in 0..MODES {
                result[i][j] += left[i][k] * right[k][j];
            }
        }
    }
    result
}

/// Largest eigenvalue of `D⁻¹ A`, from below, by power iteration from a scattered start.
fn largest_eigenvalue<const B: usize>(
    matrix: &BlockMatrix<f64, B, B>,
    inverse_diagonal: &[Block<f64, B, B>],
) -> f64 {
    let size = matrix.height();
    let scattered = |i: usize| ((i * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
    let mut vector: Vec<[f64; B]> =
        (0..size).map(|row| std::array::from_fn(|i| scattered(B * row + i))).collect();
    let mut next = vec![[0.0; B]; size];
    let mut eigenvalue = 1.0;
    for _ in 0..POWER_ITERATIONS {
        let length = norm(vector.as_flattened());
        vector.as_flattened_mut().iter_mut().for_each(|x| *x /= length);
        matrix.multiply(&vector, &mut next);
        for ((x, y), inverse) in vector.iter_mut().zip(&next).zip(inverse_diagonal) {
            *x = times(inverse, y);
        }
        eigenvalue = norm(vector.as_flattened());
    }
    eigenvalue
}

/// Gives coarse functions that are zero, since their group has fewer motions, a diagonal of 1.
fn fill_empty_modes(matrix: &mut BlockMatrix<f64, MODES, MODES>) {
    for row in 0..matrix.height() {
        for at in matrix.starts[row]..matrix.starts[row + 1] {
            if matrix.columns[at] as usize == row {
                for i in 0..MODES {
                    let entry = &mut matrix.blocks[at][i][i];
                    if *entry == 0.0 {
                        *entry = 1.0;
                    }
                }
            }
        }
    }
}

impl Coarsest {
    fn new(matrix: &BlockMatrix<f64, MODES, MODES>) -> Result<Self, Indefinite> {
        let size = matrix.height();
        let (mut starts, mut neighbours) = (vec![0], Vec::new());
        for row in 0..size {
            neighbours.extend(matrix.row(row).map(|(column, _)| column).filter(|&c| c != row));
            starts.push(neighbours.len());
        }
        let order = fill_reducing_order(&starts, &neighbours);
        let mut place = vec![0; size];
        order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for &row in &order {
            let mut below: Vec<_> = matrix
                .row(row)
                .filter(|&(column, _)| place[column] >= place[row])
                .map(|(column, block)| (place[column], block))
                .collect();
            below.sort_unstable_by_key(|&(at, _)| at);
            for i in 0..MODES {
                for &(at, block) in &below {
                    let first = if at == place[row] { i } else { 0 };
                    for j in first..MODES {
                        rows.push(MODES * at + j);
                        values.push(block[i][j]);
                    }
                }
                starts.push(rows.len());
            }
        }
        let mut factor = Cholesky::new(&starts, &rows).ok_or(Indefinite)?;
        if !factor.factorise(&values) {
            return Err(Indefinite);
        }
        Ok(Self { order, factor, local: vec![0.0; MODES * size] })
    }

    fn solve(&mut self, right: &[[f64; MODES]], solution: &mut [[f64; MODES]]) {
        let (local, _) = self.local.as_chunks_mut::<MODES>();
        local.iter_mut().zip(&self.order).for_each(|(x, &row)| *x = right[row]);
        self.factor.solve(&mut self.local);
        let (local, _) = self.local.as_chunks::<MODES>();
        local.iter().zip(&self.order).for_each(|(x, &row)| solution[row] = *x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::blocks::tests::elastic_grid;
    use super::*;

    #[test]
    fn a_cycle_is_symmetric_and_definite() {
        let (matrix, modes) = elastic_grid([14, 14, 14]);
        let mut multigrid = Multigrid::new(&matrix, &modes).unwrap();
        assert!(!multigrid.coarser.is_empty() || multigrid.coarsest.order.len() < matrix.height());
        let size = matrix.height();
        let vector = |salt: usize| -> Vec<[f64; 3]> {
            (0..size)
                .map(|i| std::array::from_fn(|j| ((i * 7 + j * 5 + salt) % 13) as f64 - 6.0))
                .collect()
        };
        let (a, b) = (vector(1), vector(4));
        let (mut of_a, mut of_b) = (a.clone(), a.clone());
        multigrid.apply(&a, &mut of_a);
        multigrid.apply(&b, &mut of_b);
        let dot = |x: &[[f64; 3]], y: &[[f64; 3]]| -> f64 {
            x.as_flattened().iter().zip(y.as_flattened()).map(|(x, y)| x * y).sum()
        };
        // Matrices in single precision, sums in double.
        assert!((dot(&a, &of_b) - dot(&b, &of_a)).abs() < 1e-6 * dot(&a, &of_a));
        assert!(dot(&a, &of_a) > 0.0 && dot(&b, &of_b) > 0.0);
    }

    #[test]
    fn an_indefinite_matrix_is_refused_on_the_coarsest_level() {
        // Each node alone is stable; the translation of all is not.
        let (mut matrix, modes) = elastic_grid([6, 6, 6]);
        for row in 0..matrix.height() {
            for at in matrix.starts[row]..matrix.starts[row + 1] {
                if matrix.columns[at] as usize == row {
                    (0..3).for_each(|i| {
                        matrix.blocks[at][i][i] -= 2.0 * super::super::blocks::tests::HELD
                    });
                }
            }
        }
        assert!(Multigrid::new(&matrix, &modes).is_err());
    }
}
