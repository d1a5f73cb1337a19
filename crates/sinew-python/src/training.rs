//! Options of a training.

use sinew::case::Training;

/// A training by the case's own keys, those in `given` replaced; a budget replaces the case's, whichever kind it is.
///
/// # Errors
/// Text that names other keys than `[training]` of a case file.
pub(crate) fn replaced(own: Training, given: &str) -> Result<Training, String> {
    let keys: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(given).map_err(|error| error.to_string())?;
    let named = keys.contains_key("recipe");
    let given: Training =
        serde_json::from_value(keys.into()).map_err(|error| format!("train: {error}"))?;
    if given.minutes.is_some() && given.steps.is_some() {
        return Err("train: give minutes or steps, not both".into());
    }
    let given = Training { recipe: if named { given.recipe } else { own.recipe }, ..given };
    match given.objection() {
        Some((key, reason)) => Err(format!("train: {key}: {reason}")),
        None => Ok(given.or(own)),
    }
}
