//! A calibration while it runs, and its result for people and for arviz.

use super::words::{LINEARISED, parameter_in_words, verdict, volumes_in_words};
use crate::patient::Prepared;
use sinew_calibrate::{Forward, Posterior, Solves};
use sinew_emulate::{Observer, Progress};
use sinew_sample::ArvizDict;
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
    Solves::new(forward, Box::new(told)).until(stopped)
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
    let [r_hat, bulk, tail] = posterior.mixing();
    lines.push(format!(
        "  R̂ {r_hat:.3}, {bulk:.0} effective draws in the bulk and {tail:.0} in the tails, {} solves, {:.1} s",
        found.solves, found.seconds
    ));
    lines
}
