//! Calibrations for people: progress, pressure–volume curve, sentences, report.

mod curve;
mod page;

use crate::patient::{Prepared, Reported};
pub use curve::Curve;
pub use page::{report, too_stiff};
use sinew_calibrate::{Forward, Identified, Posterior, Solves};
use sinew_emulate::{Observer, Progress};
use sinew_report::format::digits;
use sinew_sample::{ArvizDict, quantile};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Solves whose progress an observer is told, and which end when it breaks.
pub fn observed<'f>(forward: &'f dyn Forward, observer: &'f mut dyn Observer) -> Solves<'f> {
    let stopped = Arc::new(AtomicBool::new(false));
    let stop = stopped.clone();
    let mut current = String::new();
    let (mut first, mut clock) = (0, Instant::now());
    let told = move |stage: &str, done: usize, of: usize| {
        // A stage ends when the next one begins.
        if current != stage {
            if !current.is_empty() {
                observer.finished(&current, "done", clock.elapsed().as_secs_f64());
            }
            current = stage.to_string();
            (first, clock) = (done, Instant::now());
        }
        let pace = clock.elapsed().as_secs_f64() / (done - first.min(done)) as f64;
        let progress = Progress {
            stage,
            fraction: done as f64 / of.max(1) as f64,
            seconds_left: pace * (of - done) as f64,
            message: "",
        };
        if observer.progress(&progress).is_break() {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let mut solves = Solves::new(forward, Box::new(told));
    solves.stopped = stopped;
    solves
}

/// Groups of draws for arviz, in the units that people read: parameters, volumes in all states, data.
pub fn arviz(prepared: &Prepared, posterior: &Posterior) -> ArvizDict {
    let reported = prepared.reported.iter();
    let further: Vec<_> = reported
        .map(|seen| (format!("{} [{}]", seen.name, seen.unit), seen.observable, seen.size))
        .collect();
    posterior.to_arviz(&further)
}

/// The result in lines.
pub fn in_words(prepared: &Prepared, posterior: &Posterior) -> Vec<String> {
    let mut lines = vec![verdict(prepared, posterior)];
    lines.extend(volumes_in_words(prepared, posterior).iter().map(|line| format!("  {line}")));
    let count = posterior.problem.unknowns.len();
    lines.extend((0..count).map(|at| format!("  {}", parameter_in_words(posterior, at))));
    lines.push(format!("  {LINEARISED}"));
    let identified = posterior.identifiability.directions_in_words();
    lines.extend(identified.iter().map(|line| format!("    {line}")));
    let doubts = posterior.predictive.in_words();
    lines.extend(doubts.iter().map(|line| format!("  warning: {line}")));
    let found = &posterior.correction;
    let [r_hat, bulk, tail] = posterior.coordinates.mixing();
    lines.push(format!(
        "  R̂ {r_hat:.3}, {bulk:.0} effective draws in the bulk and {tail:.0} in the tails, {} solves, {:.1} s",
        found.solves, found.seconds
    ));
    lines
}

/// Head of sentences about directions, which rest on no draws.
const LINEARISED: &str = "Linearised at the most likely parameters, before sampling:";

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
        let draws = posterior.observed.parameter(seen.observable).concat();
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
