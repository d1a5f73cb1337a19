//! Options of a training.

use sinew::case::Training;

/// A training by the case's own keys, those in `given` replaced; a budget replaces the case's, whichever kind it is.
///
/// # Errors
/// Text that names other keys than `[training]` of a case file.
pub(crate) fn replaced(own: Training, given: &str) -> Result<Training, String> {
    let keys: serde_json::Value = serde_json::from_str(given).map_err(|error| error.to_string())?;
    let given: Training =
        serde_json::from_value(keys).map_err(|error| format!("train: {error}"))?;
    let given = Training { recipe: given.recipe.or(own.recipe), ..given };
    match given.objection() {
        Some((key, reason)) => Err(format!("train: {key}: {reason}")),
        None => Ok(given.or(own)),
    }
}
