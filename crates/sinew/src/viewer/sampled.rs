//! Predictions at parameter sets, how far regressions are from them, and why there may be no page of them.

use super::compact::Compact;
use crate::Emulator;
use rayon::prelude::*;
use sinew_emulate::{Counter, Error as EmulatorError, Observer, RegressionError};

/// Predictions that regressions of the page are fitted to.
pub(super) const PREDICTIONS: usize = 500;
/// Predictions between two signs of progress.
pub(super) const AT_ONCE: usize = 20;

/// Parameter sets with their predictions.
pub(super) struct Sampled {
    /// θ, set by set.
    pub(super) thetas: Vec<Vec<f64>>,
    /// Displacements, or other values of these, set by set.
    pub(super) fields: Vec<Vec<f64>>,
}

/// Predictions with signs of progress.
pub(super) fn predicted(
    emulator: &Emulator<'_>,
    thetas: &[Vec<f64>],
    observer: &mut dyn Observer,
) -> Result<Vec<Vec<f64>>, EmulatorError> {
    let stage = "predict for the page";
    let mut counter = Counter::new(observer, stage, 0, thetas.len());
    let mut fields = Vec::with_capacity(thetas.len());
    for some in thetas.chunks(AT_ONCE) {
        fields.extend(emulator.predict(some)?.fields());
        if counter.step(some.len(), "").is_break() {
            return Err(EmulatorError::Interrupted { stage: stage.into() });
        }
    }
    Ok(fields)
}

/// Mean relative distance of a regression from values of predictions.
pub(super) fn relative(
    shown: &Compact,
    checked: &Sampled,
    values: impl Fn(&Vec<f64>) -> Vec<f64> + Sync,
) -> Result<f64, RegressionError> {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let pairs = checked.thetas.par_iter().zip(&checked.fields);
    let each: Vec<f64> = pairs
        .map(|(theta, field)| {
            let (own, truth) = (shown.at(theta)?, values(field));
            let apart = norm(&mut own.iter().zip(&truth).map(|(a, b)| a - b));
            Ok(apart / norm(&mut truth.iter().copied()).max(f64::MIN_POSITIVE))
        })
        .collect::<Result<_, RegressionError>>()?;
    Ok(each.iter().sum::<f64>() / each.len().max(1) as f64)
}

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
