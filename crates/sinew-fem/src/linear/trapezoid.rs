//! Lower trapezoids of dense matrices, kept without the zeros above the diagonal.

use faer::{MatMut, MatRef};
use std::ops::Range;

/// Columns of a panel. From 64 to 192 the time is the same within 5 %.
pub(super) const PANEL: usize = 128;

/// The first columns of a lower triangular matrix, panel by panel: a panel holds [`PANEL`] columns from its
/// first diagonal entry down, column by column, one panel after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Trapezoid {
    pub rows: usize,
    pub columns: usize,
}

/// A panel of a trapezoid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// First row and first column.
    pub first: usize,
    pub rows: usize,
    pub columns: usize,
    /// Place of the first entry.
    pub start: usize,
}

impl Trapezoid {
    pub fn panels(self) -> impl Iterator<Item = Panel> + Clone {
        (0..self.columns.div_ceil(PANEL)).map(move |index| self.panel(index))
    }

    pub fn panel(self, index: usize) -> Panel {
        let first = index * PANEL;
        // The panels before are full: their rows shrink by PANEL each.
        let skipped = PANEL * PANEL * (index * index.saturating_sub(1) / 2);
        Panel {
            first,
            rows: self.rows - first,
            columns: PANEL.min(self.columns - first),
            start: first * self.rows - skipped,
        }
    }

    /// Number of entries.
    pub fn len(self) -> usize {
        self.columns.checked_sub(1).map_or(0, |last| self.panel(last / PANEL).range().end)
    }

    /// Place of a column's diagonal entry; those below follow it.
    #[inline]
    pub fn column(self, column: usize) -> usize {
        let panel = self.panel(column / PANEL);
        let inside = column - panel.first;
        panel.start + inside * panel.rows + inside
    }
}

impl Panel {
    pub fn range(self) -> Range<usize> {
        self.start..self.start + self.rows * self.columns
    }

    pub fn of(self, entries: &[f64]) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&entries[self.range()], self.rows, self.columns)
    }

    /// The panel as a matrix of its entries, which `entries` holds alone.
    pub fn alone(self, entries: &mut [f64]) -> MatMut<'_, f64> {
        MatMut::from_column_major_slice_mut(entries, self.rows, self.columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_follow_each_other_and_columns_lie_in_them() {
        for (rows, columns) in
            [(0, 0), (5, 0), (7, 7), (PANEL, PANEL), (3 * PANEL + 5, 2 * PANEL + 1)]
        {
            let shape = Trapezoid { rows, columns };
            let mut end = 0;
            for panel in shape.panels() {
                assert_eq!(panel.start, end);
                end = panel.range().end;
                for column in panel.first..panel.first + panel.columns {
                    let inside = column - panel.first;
                    assert_eq!(shape.column(column), panel.start + inside * (panel.rows + 1));
                }
            }
            assert_eq!(shape.len(), end);
        }
    }
}
