//! Volume ratios of cells, and the worst of them.

use crate::{CellValue, SolveError};
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
