//! Numbering of the unknowns and where element matrices go in the stiffness matrix.

use crate::linear::{compressed, fill_reducing_order};
use faer::sparse::SymbolicSparseColMat;
use sinew_energy::{Body, Frames, PressureSurface};
use sinew_num::{ascending, in_parallel};
use std::ops::Range;

/// Marks a degree of freedom that is prescribed, so no unknown.
const PRESCRIBED: u32 = u32::MAX;
/// Nodes or matrices of a task.
const TASK: usize = 512;

/// The sparsity of the stiffness matrix, ordered for little fill.
///
/// Nodes are ordered by [`fill_reducing_order`]; the free components of a node follow each other, so dense
/// kernels find blocks. The matrix is kept as its lower half.
#[derive(Debug)]
pub(crate) struct Sparsity {
    /// Degree of freedom `3 × node + component` of each unknown.
    pub degree_of_freedom: Vec<usize>,
    /// Frames of the nodes whose degrees of freedom are not along the coordinate axes.
    pub frames: Frames,
    /// The lower half, compressed by columns.
    pub pattern: SymbolicSparseColMat<usize>,
    /// Places of the matrices of cells, or of patches if there are any.
    pub cells: Slots,
    /// Places of the matrices of the facets of all pressures, one after the other, those without a potential last.
    pub facets: Slots,
    /// Places of the matrices of springs.
    pub springs: Slots,
    /// Nodes of each patch, ascending.
    pub patches: Vec<Vec<usize>>,
    /// Unknown of each degree of freedom.
    unknown: Vec<u32>,
}

/// Places of small matrices among the values of the stiffness matrix.
#[derive(Debug, Default)]
pub(crate) struct Slots {
    /// First place of each matrix, and the end of the last.
    starts: Vec<usize>,
    /// Place in the values of each entry, row by row of the lower half, matrix by matrix. Entries of
    /// prescribed degrees of freedom go to one slot behind the last value.
    places: Vec<u32>,
}

impl Slots {
    /// The places of one matrix.
    #[inline]
    pub(crate) fn of(&self, matrix: usize) -> &[u32] {
        self.range(matrix..matrix + 1)
    }

    /// The places of successive matrices.
    #[inline]
    pub(crate) fn range(&self, matrices: Range<usize>) -> &[u32] {
        &self.places[self.starts[matrices.start]..self.starts[matrices.end]]
    }
}

impl Sparsity {
    pub(crate) fn new(body: &Body) -> Self {
        let of_patches = body.patches.iter();
        let patches: Vec<_> = of_patches.map(|points| patch_nodes_of(body, points)).collect();
        // The nodes of a lid's rim depend on each other.
        let lids = body.pressures.iter().flat_map(|surface| &surface.lids);
        let lids = lids.map(|lid| &lid.nodes[..]);
        let matrices: Vec<_> = match patches.is_empty() {
            true => body.cell_nodes().collect(),
            false => patches.iter().map(|nodes| &nodes[..]).collect(),
        };
        let neighbours = neighbours(body.nodes, matrices.iter().copied().chain(lids));
        let free = |node: usize| (0..3).filter(move |i| body.prescribed[3 * node + i].is_none());
        let kept = (0..body.nodes).filter(|&node| free(node).next().is_some()).collect();
        let order = fill_reducing_order(&neighbours, kept, &body.positions);

        let mut unknown = vec![PRESCRIBED; body.prescribed.len()];
        let mut degree_of_freedom = Vec::new();
        for &node in &order {
            for component in free(node) {
                unknown[3 * node + component] = degree_of_freedom.len() as u32;
                degree_of_freedom.push(3 * node + component);
            }
        }

        let columns_of = |nodes: &[usize]| {
            let (mut rows, mut ends) = (Vec::new(), Vec::new());
            for &node in nodes {
                let unknowns = |node: usize| unknown[3 * node..3 * node + 3].iter().copied();
                let present = |&row: &u32| row != PRESCRIBED;
                let own: Vec<_> = unknowns(node).filter(present).collect();
                let last = own.last().copied().unwrap_or(0);
                let others = neighbours[node].iter().flat_map(|&other| unknowns(other));
                let below = others.filter(|row| present(row) && *row > last);
                let mut below: Vec<_> = below.map(|row| row as usize).collect();
                below.sort_unstable();
                for at in 0..own.len() {
                    rows.extend(own[at..].iter().map(|&row| row as usize));
                    rows.extend(&below);
                    ends.push(rows.len());
                }
            }
            (rows, ends)
        };
        let (starts, rows) = compressed(in_parallel(order.chunks(TASK), columns_of));
        let size = degree_of_freedom.len();
        let pattern = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        let mut sparsity = Self {
            degree_of_freedom,
            frames: body.frames.clone(),
            pattern,
            cells: Slots::default(),
            facets: Slots::default(),
            springs: Slots::default(),
            patches: Vec::new(),
            unknown,
        };
        let surfaces = body.pressures.iter().chain(&body.followers);
        let facets: Vec<_> = facets_of(surfaces).map(|(_, _, nodes)| nodes).collect();
        let springs: Vec<_> = body.springs.iter().map(|spring| &spring.nodes[..]).collect();
        sparsity.facets = sparsity.slots(&facets);
        sparsity.springs = sparsity.slots(&springs);
        sparsity.cells = sparsity.slots(&matrices);
        sparsity.patches = patches;
        sparsity
    }

    /// Places in the values of small matrices, whose rows are the three components of each of
    /// the nodes listed for them.
    fn slots(&self, matrices: &[&[usize]]) -> Slots {
        let mut starts = vec![0];
        for nodes in matrices {
            let size = 3 * nodes.len();
            starts.push(starts[starts.len() - 1] + size * (size + 1) / 2);
        }
        let mut places = vec![0; starts[matrices.len()]];
        let (mut tasks, mut rest) = (Vec::new(), &mut places[..]);
        for (task, matrices) in matrices.chunks(TASK).enumerate() {
            let first = TASK * task;
            let size = starts[first + matrices.len()] - starts[first];
            let (own, others) = rest.split_at_mut(size);
            tasks.push((matrices, own));
            rest = others;
        }
        in_parallel(tasks, |(matrices, places): (&[&[usize]], &mut [u32])| {
            let mut slots = places.iter_mut();
            matrices.iter().for_each(|nodes| self.put_places(nodes, &mut slots));
        });
        Slots { starts, places }
    }

    /// Writes the places of one small matrix.
    fn put_places<'p>(&self, nodes: &[usize], places: &mut impl Iterator<Item = &'p mut u32>) {
        let starts = self.pattern.col_ptr();
        let dofs = nodes.iter().flat_map(|node| 3 * node..3 * node + 3);
        let unknowns: Vec<_> = dofs.map(|dof| self.unknown(dof)).collect();
        for (row, a) in unknowns.iter().enumerate() {
            let mut last = None;
            for ((column, b), slot) in unknowns[..=row].iter().enumerate().zip(&mut *places) {
                let of_one_node = column % 3 > 0 && column / 3 < row / 3;
                let place = a.zip(*b).map_or(self.entries(), |(a, b)| match last {
                    // The columns of one node hold the same rows below it.
                    Some((before, place)) if of_one_node && a > b => {
                        place - starts[before] - 1 + starts[b]
                    }
                    Some((_, place)) if of_one_node => place + 1,
                    _ => self.slot(a, b),
                });
                *slot = place as u32;
                last = b.map(|b| (b, place));
            }
        }
    }

    /// Place of the entry of two unknowns among the values of the lower half.
    pub(crate) fn slot(&self, a: usize, b: usize) -> usize {
        let (row, column) = (a.max(b), a.min(b));
        let start = self.pattern.col_ptr()[column];
        let rows = &self.pattern.row_idx()[start..self.pattern.col_ptr()[column + 1]];
        start + rows.partition_point(|&other| other < row)
    }

    /// Number of unknowns.
    pub(crate) fn unknowns(&self) -> usize {
        self.degree_of_freedom.len()
    }

    /// The unknown of a degree of freedom, if it is not prescribed.
    pub(crate) fn unknown(&self, degree_of_freedom: usize) -> Option<usize> {
        let unknown = self.unknown[degree_of_freedom];
        (unknown != PRESCRIBED).then_some(unknown as usize)
    }

    /// The unknowns' part of a Cartesian vector over all degrees of freedom.
    pub(crate) fn gather(&self, vector: &[f64]) -> impl Iterator<Item = f64> {
        self.gather_along(&self.frames, vector)
    }

    /// [`Self::gather`] for a body whose unknowns are along other axes.
    pub(crate) fn gather_along(&self, frames: &Frames, from: &[f64]) -> impl Iterator<Item = f64> {
        self.degree_of_freedom.iter().map(|&dof| frames.component(dof, from))
    }

    /// Adds values of the unknowns to a Cartesian vector over all degrees of freedom.
    pub(crate) fn scatter(&self, values: impl IntoIterator<Item = f64>, vector: &mut [f64]) {
        self.scatter_along(&self.frames, values, vector);
    }

    /// Values of the unknowns over all degrees of freedom, zero at prescribed ones.
    pub(crate) fn scattered(&self, values: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut vector = vec![0.0; self.unknown.len()];
        self.scatter(values, &mut vector);
        vector
    }

    /// [`Self::scatter`] for a body whose unknowns are along other axes.
    pub(crate) fn scatter_along(
        &self,
        frames: &Frames,
        values: impl IntoIterator<Item = f64>,
        vector: &mut [f64],
    ) {
        let unknowns = self.degree_of_freedom.iter().zip(values);
        unknowns.for_each(|(&dof, value)| frames.add(dof, value, vector));
    }

    /// The matrix with a lower half by columns, and an upper one by rows in the same places, times a vector.
    pub(crate) fn multiply(&self, [lower, upper]: [&[f64]; 2], from: &[f64], to: &mut [f64]) {
        to.fill(0.0);
        let (starts, rows) = (self.pattern.col_ptr(), self.pattern.row_idx());
        for column in 0..self.unknowns() {
            // The diagonal comes first in each column.
            let start = starts[column];
            let mut sum = lower[start] * from[column];
            let below = start + 1..starts[column + 1];
            let halves = lower[below.clone()].iter().zip(&upper[below.clone()]);
            for (&row, (lower, upper)) in rows[below].iter().zip(halves) {
                to[row] += lower * from[column];
                sum += upper * from[row];
            }
            to[column] += sum;
        }
    }

    /// Mean absolute diagonal of the matrix with the given lower half.
    pub(crate) fn mean_diagonal(&self, matrix: &[f64]) -> f64 {
        let diagonal = &self.pattern.col_ptr()[..self.unknowns()];
        diagonal.iter().map(|&slot| matrix[slot].abs()).sum::<f64>() / diagonal.len() as f64
    }

    /// Number of stored entries of the lower half.
    pub(crate) fn entries(&self) -> usize {
        self.pattern.row_idx().len()
    }
}

/// Nodes of a patch of quadrature points, ascending.
pub(crate) fn patch_nodes_of(body: &Body, points: &[usize]) -> Vec<usize> {
    ascending(points.iter().flat_map(|&point| body.nodes_of_point(point)).copied())
}

/// The facets of surfaces, one after the other: surface, number on it, and nodes.
pub(crate) fn facets_of<'s>(
    surfaces: impl IntoIterator<Item = &'s PressureSurface>,
) -> impl Iterator<Item = (&'s PressureSurface, usize, &'s [usize])> {
    let of_surface = |surface: &'s PressureSurface| {
        (0..surface.facets()).map(move |facet| (surface, facet, surface.facet_nodes(facet)))
    };
    surfaces.into_iter().flat_map(of_surface)
}

/// Nodes that share a cell, or a rim, with each node, ascending, without the node itself.
fn neighbours<'n>(nodes: usize, cells: impl Iterator<Item = &'n [usize]>) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); nodes];
    for cell in cells {
        for &a in cell {
            neighbours[a].extend(cell.iter().filter(|&&b| b != a));
        }
    }
    in_parallel(neighbours.chunks_mut(TASK), |lists| {
        lists.iter_mut().for_each(|list| *list = ascending(std::mem::take(list)));
    });
    neighbours
}
