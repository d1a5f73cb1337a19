//! Stiffness systems solved by iteration: memory grows with the body, not with the fill of a factor.

use super::aggregates::MODES;
use super::blocks::{Block, BlockMatrix};
use super::conjugate_gradients::{End, Outcome, conjugate_gradients};
use super::multigrid::Multigrid;

/// A hierarchy of an earlier matrix is given up after this many times the iterations that it took on its own. Large
/// rotations make it useless at once (30 000 unknowns of a beam: 106 iterations instead of 10), while those of the last
/// Newton steps are as good as new.
const WORN: usize = 2;

/// Conjugate gradients with smoothed aggregation, for a stiffness matrix whose lower half is given by columns.
#[derive(Clone)]
pub(crate) struct Iterative {
    /// Three times the place of its node plus its component, for each unknown.
    component: Vec<u32>,
    /// Where each entry of the lower half goes in the flat entries of the blocks.
    places: Vec<u32>,
    /// Where the transposed block of each block is.
    mirror: Vec<u32>,
    matrix: BlockMatrix<f64, 3, 3>,
    /// Node of each block row.
    nodes: Vec<usize>,
    modes: Vec<Block<f64, 3, MODES>>,
    multigrid: Option<Multigrid>,
    /// Whether the hierarchy is that of an earlier matrix.
    stale: bool,
    /// Iterations of the first solve with the hierarchy and its own matrix.
    own_iterations: Option<usize>,
}

impl Iterative {
    /// Prepares for matrices of one pattern. Unknown `i` is degree of freedom `3 × node + component`
    /// `degrees_of_freedom[i]`; those of a node follow each other.
    pub fn new(degrees_of_freedom: &[usize], starts: &[usize], rows: &[usize]) -> Self {
        let mut nodes: Vec<usize> = Vec::new();
        let mut component = Vec::with_capacity(degrees_of_freedom.len());
        for &dof in degrees_of_freedom {
            if nodes.last() != Some(&(dof / 3)) {
                nodes.push(dof / 3);
            }
            component.push((3 * (nodes.len() - 1) + dof % 3) as u32);
        }
        let mut result = Self {
            component,
            places: Vec::new(),
            mirror: Vec::new(),
            matrix: empty(nodes.len()),
            modes: Vec::new(),
            nodes,
            multigrid: None,
            stale: false,
            own_iterations: None,
        };
        result.find_pattern(starts, rows);
        result
    }

    /// Finds the pattern of blocks.
    fn find_pattern(&mut self, starts: &[usize], rows: &[usize]) {
        let node = |unknown: usize| self.component[unknown] as usize / 3;
        let size = self.matrix.width;
        let mut columns: Vec<Vec<u32>> = vec![Vec::new(); size];
        for column in 0..starts.len() - 1 {
            // Unknowns of a node have the same rows below; the first one shows them all.
            let first = column == 0 || node(column - 1) != node(column);
            for &row in rows[starts[column]..starts[column + 1]].iter().filter(|_| first) {
                let (a, b) = (node(row), node(column));
                if columns[b].last() != Some(&(a as u32)) {
                    columns[b].push(a as u32);
                    if a != b {
                        columns[a].push(b as u32);
                    }
                }
            }
        }
        columns.iter_mut().for_each(|list| list.sort_unstable());
        let mut block_starts = vec![0];
        columns
            .iter()
            .for_each(|l| block_starts.push(block_starts[block_starts.len() - 1] + l.len()));
        let find = |row: usize, column: usize| {
            block_starts[row] + columns[row].partition_point(|&c| (c as usize) < column)
        };
        self.mirror = (0..size)
            .flat_map(|row| columns[row].iter().map(move |&column| (row, column as usize)))
            .map(|(row, column)| find(column, row) as u32)
            .collect();
        self.places = Vec::with_capacity(rows.len());
        for column in 0..starts.len() - 1 {
            let mut last = (usize::MAX, 0);
            for &row in &rows[starts[column]..starts[column + 1]] {
                if last.0 != node(row) {
                    last = (node(row), find(node(row), node(column)));
                }
                let inside = 3 * (self.component[row] % 3) + self.component[column] % 3;
                self.places.push(9 * last.1 as u32 + inside);
            }
        }
        self.matrix.blocks = vec![[[0.0; 3]; 3]; self.mirror.len()];
        self.matrix.columns = columns.concat();
        self.matrix.starts = block_starts;
    }

    /// Takes the values of a matrix; false where it is found not to be positive definite.
    pub fn set(&mut self, values: &[f64]) -> bool {
        self.matrix.blocks.fill([[0.0; 3]; 3]);
        for row in 0..self.matrix.height() {
            // Prescribed components of a node are decoupled.
            let at = self.matrix.starts[row]
                + self.matrix.row(row).position(|(c, _)| c == row).unwrap_or(0);
            (0..3).for_each(|i| self.matrix.blocks[at][i][i] = 1.0);
        }
        let flat = self.matrix.blocks.as_flattened_mut().as_flattened_mut();
        for (&place, &value) in self.places.iter().zip(values) {
            let (block, inside) = (place as usize / 9, place as usize % 9);
            flat[place as usize] = value;
            flat[9 * self.mirror[block] as usize + 3 * (inside % 3) + inside / 3] = value;
        }
        self.stale = self.multigrid.is_some();
        if !self.stale {
            self.build();
        }
        self.multigrid.is_some()
    }

    /// Takes the values of a matrix and builds its own hierarchy; false where it is found not to be positive
    /// definite.
    pub fn renew(&mut self, values: &[f64]) -> bool {
        self.multigrid = None;
        self.set(values)
    }

    /// Says where the nodes are and which axis each degree of freedom is along: the rigid motions there are nearly
    /// free of energy.
    pub fn place(
        &mut self,
        positions: impl Fn(usize) -> [f64; 3],
        axes: impl Fn(usize) -> [f64; 3],
    ) {
        let positions: Vec<_> = self.nodes.iter().map(|&node| positions(node)).collect();
        let axis = |at: usize| axes(3 * self.nodes[at / 3] + at % 3);
        self.modes = rigid_modes(&self.component, &positions, axis);
    }

    fn build(&mut self) {
        self.multigrid = None;
        self.multigrid = Multigrid::new(&self.matrix, &self.modes).ok();
        self.own_iterations = None;
        self.stale = false;
    }

    /// Solves with the last matrix, in place. A hierarchy of an earlier matrix that is too bad is built anew.
    pub fn solve(&mut self, right: &mut [f64], tolerance: f64, most_iterations: usize) -> Outcome {
        if self.stale {
            let own = self.own_iterations.unwrap_or(most_iterations);
            let most = [own, WORN * own].map(|most| most.min(most_iterations));
            let mut trial = right.to_vec();
            let outcome = self.try_solve(&mut trial, tolerance, most);
            if outcome.end != End::Exhausted {
                right.copy_from_slice(&trial);
                return outcome;
            }
            self.build();
        }
        let outcome = self.try_solve(right, tolerance, [most_iterations; 2]);
        self.own_iterations.get_or_insert(outcome.iterations.max(1));
        outcome
    }

    fn try_solve(
        &mut self,
        right: &mut [f64],
        tolerance: f64,
        most_iterations: [usize; 2],
    ) -> Outcome {
        let Self { component, matrix, multigrid: Some(multigrid), .. } = self else {
            return Outcome { iterations: 0, relative_residual: 1.0, end: End::NegativeCurvature };
        };
        // A power of two, so that nothing but overflow changes.
        let largest = right.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let unit = if largest > 0.0 { largest.log2().floor().exp2() } else { 1.0 };
        let mut spread = vec![0.0; 3 * matrix.height()];
        component.iter().zip(&*right).for_each(|(&at, &value)| spread[at as usize] = value / unit);
        let mut solution = vec![0.0; spread.len()];
        let outcome = conjugate_gradients(
            |x, y| matrix.multiply(x.as_chunks().0, y.as_chunks_mut().0),
            |x, y| multigrid.apply(x.as_chunks().0, y.as_chunks_mut().0),
            &spread,
            &mut solution,
            tolerance,
            most_iterations,
        );
        component.iter().zip(right).for_each(|(&at, value)| *value = unit * solution[at as usize]);
        outcome
    }

    /// Iterations of the first solve with the hierarchy and its own matrix.
    pub fn iterations(&self) -> Option<usize> {
        self.own_iterations
    }

    /// Stored bytes.
    pub fn bytes(&self) -> usize {
        80 * self.mirror.len()
            + 4 * self.places.len()
            + self.multigrid.as_ref().map_or(0, Multigrid::bytes)
    }
}

fn empty(size: usize) -> BlockMatrix<f64, 3, 3> {
    BlockMatrix { width: size, starts: vec![0; size + 1], columns: Vec::new(), blocks: Vec::new() }
}

/// Translations, and rotations about the nodes' centre in units of their distance from it; zero where a node's
/// component is no unknown.
fn rigid_modes(
    component: &[u32],
    positions: &[[f64; 3]],
    axis: impl Fn(usize) -> [f64; 3],
) -> Vec<Block<f64, 3, MODES>> {
    let count = positions.len().max(1) as f64;
    let centre: [f64; 3] =
        std::array::from_fn(|i| positions.iter().map(|x| x[i]).sum::<f64>() / count);
    let arm = |x: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|i| x[i] - centre[i]) };
    let squared = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
    let size = (positions.iter().map(|x| squared(arm(x))).sum::<f64>() / count).sqrt();
    let unit = if size > 0.0 { 1.0 / size } else { 1.0 };
    let mut modes = vec![[[0.0; MODES]; 3]; positions.len()];
    for &at in component {
        let (place, i) = (at as usize / 3, at as usize % 3);
        let [x, y, z] = arm(&positions[place]).map(|x| x * unit);
        let [a, b, c] = axis(at as usize);
        modes[place][i] = [a, b, c, y * c - z * b, z * a - x * c, x * b - y * a];
    }
    modes
}
