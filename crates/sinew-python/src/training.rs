//! Options of a training.

use sinew::TrainingOptions;
use sinew::case::Training;
use std::path::PathBuf;

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
    let (minutes, steps) = match (given.minutes, given.steps) {
        (None, None) => (own.minutes, own.steps),
        budget => budget,
    };
    Ok(Training {
        recipe: if named { given.recipe } else { own.recipe },
        samples: given.samples.or(own.samples),
        target: given.target.or(own.target),
        minutes,
        steps,
        seed: given.seed.or(own.seed),
        held_out: given.held_out.or(own.held_out),
        anchors: given.anchors.or(own.anchors),
        design: given.design.or(own.design),
        network: given.network.or(own.network),
    })
}

/// Options of a training that is kept in a folder.
pub(crate) fn options(
    training: &Training,
    folder: Option<PathBuf>,
    resume: bool,
    restart: bool,
) -> TrainingOptions {
    TrainingOptions { folder, resume, restart, ..training.options() }
}
