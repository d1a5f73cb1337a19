//! Result of a calibration in sentences.

use crate::patient::{Prepared, Reported};
use sinew_calibrate::{Identified, Posterior};
use sinew_report::format::digits;
use sinew_sample::quantile;

/// Head of sentences about directions, which rest on no draws.
pub(super) const LINEARISED: &str = "Linearised at the most likely parameters, before sampling:";

/// A parameter in a line: its interval if the data determine it, else a note that they do not.
pub fn parameter_in_words(posterior: &Posterior, parameter: usize) -> String {
    let unknown = &posterior.problem.unknowns[parameter];
    let left = posterior.contraction(parameter);
    let head = format!("{}: ", unknown.name);
    let verdict = posterior.identified(parameter);
    if verdict == Identified::No {
        return head
            + &format!("{} ({left:.2} of its standard deviation is left)", verdict.in_words());
    }
    let [low, middle, high] = posterior.summary(parameter).quantiles.map(|q| digits(q, 3));
    let unit = if unknown.unit.is_empty() { String::new() } else { format!(" {}", unknown.unit) };
    head + &format!(
        "{middle}{unit}, 95 % interval {low} to {high}{unit}; {} ({left:.2} of the prior's standard deviation is left)",
        verdict.in_words()
    )
}

/// Volumes that were not measured, in a line each.
pub fn volumes_in_words(prepared: &Prepared, posterior: &Posterior) -> Vec<String> {
    let unmeasured = prepared.reported.iter().filter(|seen| {
        posterior.problem.data.iter().all(|datum| datum.observable != seen.observable)
    });
    let line = |seen: &Reported| {
        let draws = posterior.observable(seen.observable).concat();
        let [low, middle, high] =
            [0.025, 0.5, 0.975].map(|share| digits(quantile(&draws, share) / seen.size, 4));
        let unit = seen.unit;
        format!("{}: {middle} {unit}, 95 % interval {low} to {high} {unit}", seen.name)
    };
    unmeasured.map(line).collect()
}

/// The result in a sentence.
pub fn verdict(prepared: &Prepared, posterior: &Posterior) -> String {
    let identified = (0..posterior.problem.unknowns.len())
        .filter(|&at| posterior.identified(at) == Identified::Yes)
        .map(|at| posterior.problem.unknowns[at].name.as_str());
    let identified: Vec<&str> = identified.collect();
    let of_parameters = match identified.is_empty() {
        true => "the data identify no parameter by itself".to_string(),
        false => format!("the data identify {}", identified.join(", ")),
    };
    let doubts = posterior.predictive.in_words();
    // The last is that of the noise, if there is one.
    let fit = match &doubts[..] {
        [] => "all data fit".to_string(),
        [doubt] => doubt.trim_end_matches('.').to_string(),
        [first, .., last] => format!("{first} {}", last.trim_end_matches('.')),
    };
    let volume = volumes_in_words(prepared, posterior).into_iter().next();
    let volume = volume.map_or(String::new(), |line| format!("{line}; "));
    format!(
        "{volume}{of_parameters}; {fit}; the solver confirms this posterior (k̂ {:.2}, {:.0} % of its corrections accepted).",
        posterior.correction.k_hat,
        100.0 * posterior.correction.acceptance
    )
}
