//! Volume ratios and shapes of cells, and the worst of them.

use crate::{CellValue, SolveError};
use nalgebra::{Matrix3, Vector3};
use sinew_energy::Body;
pub(crate) use sinew_energy::metrics::volume_ratios;

/// Number of the worst cells that are named.
pub(crate) const MOST_WORST: usize = 5;

/// The cells of least value, at most `count`, worst first.
pub(crate) fn least(values: &[f64], count: usize) -> Vec<CellValue> {
    // A J that overflows is no number.
    let mut order: Vec<_> = (0..values.len()).filter(|&cell| !values[cell].is_nan()).collect();
    let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]).then(a.cmp(b));
    if count < order.len() {
        order.select_nth_unstable_by(count, by_value);
        order.truncate(count);
    }
    order.sort_unstable_by(by_value);
    order.into_iter().map(|cell| CellValue { cell, value: values[cell] }).collect()
}

/// The cell of largest value.
pub(crate) fn largest(values: &[f64]) -> CellValue {
    let best = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    CellValue { cell: best, value: values.get(best).copied().unwrap_or(f64::NAN) }
}

/// The least (largest) of each cell's values at its quadrature points.
pub(crate) fn per_cell(
    points: &[f64],
    points_per_cell: usize,
    pick: fn(f64, f64) -> f64,
) -> Vec<f64> {
    let of_cell = |values: &[f64]| values.iter().copied().reduce(pick).unwrap_or(f64::NAN);
    points.chunks(points_per_cell).map(of_cell).collect()
}

/// Error of a displacement whose energy is not finite, with the cell of least J.
pub(crate) fn inadmissible(body: &Body, displacement: &[f64]) -> SolveError {
    let ratios = per_cell(&volume_ratios(body, displacement), body.points_per_cell, f64::min);
    SolveError::Inadmissible { cell: least(&ratios, 1).first().map_or(0, |worst| worst.cell) }
}

/// Largest principal stretch, the root of the largest eigenvalue of C = FᵀF, at each quadrature point.
pub(crate) fn largest_stretches(potential: &Body, displacement: &[f64]) -> Vec<f64> {
    let stretch = |p| {
        let h = potential.displacement_gradient(p, displacement);
        let f = Matrix3::identity() + Matrix3::from_fn(|i, j| h[i][j]);
        (f.transpose() * f).symmetric_eigenvalues().max().sqrt()
    };
    (0..potential.volumes.len()).map(stretch).collect()
}

/// The mean ratio of each cell's corners at reference positions plus `displacement`, from 1 (equal edges and
/// angles) to 0 (flat or turned inside out), after A. Liu and B. Joe, BIT 34 (1994): `12 (3V)^(2/3) / Σ l²` of
/// tetrahedra, `4√3 A / Σ l²` of triangles, the least of `3 det^(2/3) / Σ l²` over the corners of hexahedra.
pub(crate) fn mean_ratios(potential: &Body, displacement: &[f64]) -> Vec<f64> {
    let place = |node: usize| {
        Vector3::from_fn(|i, _| potential.positions[node][i] + displacement[3 * node + i])
    };
    let ratio = |nodes: &[usize]| {
        let places: Vec<_> =
            nodes[..potential.element().corners].iter().map(|&n| place(n)).collect();
        mean_ratio(&places)
    };
    potential.cell_nodes().map(ratio).collect()
}

/// Neighbours of each corner of a hexahedron, right-handed.
const HEXAHEDRON: [[usize; 3]; 8] =
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];

fn mean_ratio(corners: &[Vector3<f64>]) -> f64 {
    match corners {
        [a, b, c] => {
            let twice = (b - a).cross(&(c - a)).z.max(0.0);
            2.0 * 3f64.sqrt() * twice / squared_edges(corners)
        }
        [a, b, c, d] => {
            let six = (b - a).cross(&(c - a)).dot(&(d - a)).max(0.0);
            12.0 * (0.5 * six).cbrt().powi(2) / squared_edges(corners)
        }
        _ => {
            let at = |(corner, [i, j, k]): (usize, [usize; 3])| {
                let [u, v, w] = [i, j, k].map(|other| corners[other] - corners[corner]);
                let squares = u.norm_squared() + v.norm_squared() + w.norm_squared();
                3.0 * u.cross(&v).dot(&w).max(0.0).cbrt().powi(2) / squares
            };
            HEXAHEDRON.into_iter().enumerate().map(at).fold(f64::INFINITY, f64::min)
        }
    }
}

/// Sum of the squared distances of all pairs: the edges of a simplex.
fn squared_edges(corners: &[Vector3<f64>]) -> f64 {
    let pairs =
        corners.iter().enumerate().flat_map(|(i, a)| corners[..i].iter().map(move |b| a - b));
    pairs.map(|edge| edge.norm_squared()).sum()
}
