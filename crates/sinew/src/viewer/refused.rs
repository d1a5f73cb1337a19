//! Errors of a page of an emulator.

use sinew_emulate::{Error as EmulatorError, RegressionError};

/// Predictions that regressions of the page are fitted to.
pub(super) const PREDICTIONS: usize = 500;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ViewerError {
    /// The emulator cannot be asked, or has no error that it was measured by.
    #[error(transparent)]
    Emulator(#[from] EmulatorError),
    /// The predictions, or what is shown of them, cannot be regressed.
    #[error(transparent)]
    Regression(#[from] RegressionError),
    /// A body without a surface in three dimensions.
    #[error("the body has no surface to be shown; a page needs a mesh of tetrahedra or hexahedra")]
    NoSurface,
    /// An emulator that was not measured on held-out cases.
    #[error(
        "the emulator was not measured on held-out cases, so the error that a page adds cannot be judged; train it by a recipe"
    )]
    NotMeasured,
    /// A regression of the predictions that adds too much to their error.
    #[error(
        "a page cannot hold this emulator: a regression of {PREDICTIONS} of its predictions is {added:.1e} of the displacement off \
         them, more than a third of the emulator's own error of {own:.1e}; export one of the recipe regression, or train over \
         smaller ranges"
    )]
    Distilled { added: f64, own: f64 },
}
