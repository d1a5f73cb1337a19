//! A patient before anything is sampled, in lines.

use crate::case::stress_in_kpa;
use crate::patient::Prepared;
use sinew_calibrate::{Identifiability, Mode, noise_in_words};
use sinew_report::format::{digits, trimmed};

/// Misfit \[standard deviations\] from which on a datum is marked.
const DOUBTFUL: f64 = 3.0;

/// Phases, cavities, segments and data as they were read.
pub fn setting_in_words(prepared: &Prepared) -> Vec<String> {
    let body = &prepared.body;
    let mmhg = stress_in_kpa("mmHg").unwrap_or(1.0);
    let mut lines = vec![format!("{} nodes, {} cells", body.nodes, body.cell_count())];
    let at_image = body.cavity_volumes(&vec![0.0; 3 * body.nodes]);
    for (cavity, volume) in body.cavities.iter().zip(at_image) {
        let volume = digits(volume / 1e3, 4);
        lines.push(format!("volume of {} in the image: {volume} mL", cavity.name));
    }
    for (phase, values) in &prepared.phases {
        let said = values.iter().map(|(name, kpa)| {
            format!("{name} = {} kPa = {} mmHg", trimmed(*kpa, 4), trimmed(kpa / mmhg, 4))
        });
        lines.push(format!("phase {phase}: {}", said.collect::<Vec<_>>().join(", ")));
    }
    if let Some(segments) = &prepared.segments {
        let names = segments.names().join(", ");
        lines.push(format!("segments: {names}; strains are ½ (λ² − 1) of lines of stretch λ"));
    }
    for unknown in &prepared.problem.unknowns {
        let [low, high] = unknown.prior.range().map(|end| trimmed(unknown.shown(end), 4));
        lines.push(format!("unknown: {} from {low} to {high}", unknown.head()));
    }
    lines
}

/// Most likely parameters, data beside what the body does there, and which parameters the data determine.
pub fn ahead_in_words(prepared: &Prepared, mode: &Mode, seen: &Identifiability) -> Vec<String> {
    let mut lines = vec![String::new(), "most likely parameters:".into()];
    for (unknown, theta) in prepared.problem.unknowns.iter().zip(&mode.theta) {
        let [low, high] = unknown.prior.range();
        let share = (theta / low).ln() / (high / low).ln();
        let end = match share {
            s if s < 0.02 => ", at the lower end of its range",
            s if s > 0.98 => ", at the upper end of its range",
            _ => "",
        };
        let value = digits(unknown.shown(*theta), 3);
        lines.push(format!("  {} = {value}{end}", unknown.head()));
    }
    lines.push("data beside what the body does there:".into());
    for (datum, misfit) in prepared.problem.data.iter().zip(&mode.misfits) {
        let numbers = [datum.value, datum.error(), mode.observed.values[datum.observable]];
        let [value, error, model] = numbers.map(|number| digits(number / datum.size, 4));
        let (name, error) = (&datum.name, format!("{error} {}", datum.unit));
        let mark = if misfit.abs() > DOUBTFUL { "  <- look at value, unit and phase" } else { "" };
        lines.push(format!(
            "  {name}: measured {value} ± {}, computed {model}, {misfit:+.1} sd{mark}",
            error.trim_end()
        ));
    }
    lines.extend(noise_in_words(&mode.misfits).map(|doubt| format!("  warning: {doubt}")));
    lines.push("before anything is sampled:".into());
    lines.extend(seen.in_words().iter().map(|line| format!("  {line}")));
    lines
}
