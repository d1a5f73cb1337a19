//! The axes that a kernel depends on.

use crate::series::MOST_VARIABLES;

/// Some axes, or all there are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Axes(Option<Vec<usize>>);

const ALL: [usize; MOST_VARIABLES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10];

impl Axes {
    pub(super) fn only(axes: &[usize]) -> Self {
        Self(Some(axes.to_vec()))
    }

    /// Axes among the first `D`.
    pub(super) fn of<const D: usize>(&self) -> &[usize] {
        self.0.as_deref().unwrap_or(&ALL[..D])
    }

    /// Axes that are among `axes` too.
    pub(super) fn among<const D: usize>(&self, axes: &[usize]) -> Self {
        Self(Some(self.of::<D>().iter().copied().filter(|d| axes.contains(d)).collect()))
    }
}
