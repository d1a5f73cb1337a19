//! Calibrations for people: progress, pressure–volume curve, sentences, report.

mod check;
mod folder;
mod page;

use crate::case::stress_in_kpa;
use crate::patient::Prepared;
pub use check::{ahead_in_words, setting_in_words};
pub use folder::{SOLVES, kept, remove_results, written};
pub use page::{report, too_stiff};
use sinew_calibrate::{Forward as _, Identified, Klotz, Observable, Posterior};
use sinew_num::in_parallel;
use sinew_report::format::digits;
use sinew_sample::{ArvizDict, quantile};
use std::fmt::Write;

/// Groups of draws for arviz, in the units that people read: parameters, volumes in all states, data.
pub fn arviz(prepared: &Prepared, posterior: &Posterior) -> ArvizDict {
    let volume = |&at: &usize| (format!("{} [mL]", prepared.observables[at]), at, MILLILITRE);
    posterior.to_arviz(&prepared.reported.iter().map(volume).collect::<Vec<_>>())
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
    let (name, left) = (&unknown.name, posterior.contraction(parameter));
    let identified = posterior.identified(parameter);
    let verdict = identified.in_words();
    if identified == Identified::No {
        return format!("{name}: {verdict} ({left:.2} of its standard deviation is left)");
    }
    let [low, middle, high] = posterior.summary(parameter).quantiles.map(|q| digits(q, 3));
    let unit = if unknown.unit.is_empty() { String::new() } else { format!(" {}", unknown.unit) };
    format!(
        "{name}: {middle}{unit}, 95 % interval {low} to {high}{unit}; {verdict} ({left:.2} of the prior's standard deviation is left)"
    )
}

/// Volumes that were not measured, in a line each.
pub fn volumes_in_words(prepared: &Prepared, posterior: &Posterior) -> Vec<String> {
    let is_measured =
        |at: &usize| posterior.problem.data.iter().any(|datum| datum.observable == *at);
    let line = |&at: &usize| {
        let draws = posterior.observed.parameter(at).concat();
        let [low, middle, high] = quantiles(&draws).map(|volume| digits(volume, 4));
        let name = &prepared.observables[at];
        format!("{name}: {middle} mL, 95 % interval {low} to {high} mL")
    };
    prepared.reported.iter().filter(|at| !is_measured(at)).map(line).collect()
}

/// Quantiles of volumes \[mm³\]: 2.5 %, 50 % and 97.5 % \[mL\].
fn quantiles(volumes: &[f64]) -> [f64; 3] {
    [0.025, 0.5, 0.975].map(|share| quantile(volumes, share) / MILLILITRE)
}

/// The result in a sentence.
pub fn verdict(prepared: &Prepared, posterior: &Posterior) -> String {
    let unknowns = posterior.problem.unknowns.iter().enumerate();
    let identified = unknowns.filter(|(at, _)| posterior.identified(*at) == Identified::Yes);
    let identified: Vec<&str> = identified.map(|(_, unknown)| unknown.name.as_str()).collect();
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

/// Pressures of the curve \[mmHg\].
const PRESSURES: [f64; 10] = [2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0, 23.0, 26.0, 30.0];
/// Draws that the curve is solved for, which give its band.
const CURVE_DRAWS: usize = 48;
/// Part of the draws that have an equilibrium at each pressure of the curve. Those that have none are the softest, so that a band of the others
/// would be too narrow and too low.
const SOLVED: f64 = 0.95;
/// One millilitre in mm³.
const MILLILITRE: f64 = 1e3;

/// Volumes of a cavity over pressures, with bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Facet set of the cavity.
    pub cavity: String,
    /// Pressures \[mmHg\], from 0.
    pub pressures: Vec<f64>,
    /// 2.5 %, 50 % and 97.5 % quantile of the volume at each \[mL\].
    pub volumes: Vec<[f64; 3]>,
    /// Curve of other hearts through the data, where it makes sense.
    pub klotz: Option<Klotz>,
    /// Draws that were solved.
    pub draws: usize,
    /// Why the curve ends before the last pressure, if it does.
    pub end: Option<String>,
}

/// Volumes of a cavity at one draw by pressure \[mm³\], as far as it has equilibria, and why it has no more.
type Reached = (Vec<f64>, Option<String>);

impl Curve {
    /// Solves for the volumes of a cavity at some draws of the posterior, up to the pressure at which draws begin to lack an equilibrium.
    ///
    /// # Errors
    /// A cavity whose pressure is not a parameter, and draws that cannot be solved.
    pub fn new(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Result<Self, String> {
        let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
        let patient = prepared.curve(cavity, &PRESSURES.map(|p| p * kpa))?;
        let cavities = &mut prepared.body.cavities.iter();
        let place = cavities.position(|other| other.name == cavity).unwrap_or_default();
        let chains = posterior.draws.draws.len().max(1);
        let thin = posterior.draws.thinned(CURVE_DRAWS.div_ceil(chains));
        let places = prepared.curve_parameters();
        let thetas: Vec<Vec<f64>> =
            thin.pooled().map(|draw| places.iter().map(|&at| draw[at]).collect()).collect();
        if let Some(middle) = thetas.get(thetas.len() / 2) {
            patient.expect_among(std::slice::from_ref(middle));
        }
        let solve = |theta: &Vec<f64>| match patient.states_reached(theta) {
            Ok((states, end)) => {
                let volume = |u: &Vec<f64>| prepared.body.cavity_volumes(u)[place];
                // The image and the body at rest come before.
                let volumes = states.moved.iter().skip(2).map(volume).collect();
                (volumes, end.map(|why| why.to_string()))
            }
            Err(why) => (Vec::new(), Some(why.to_string())),
        };
        let found = in_parallel(&thetas, solve);
        if found.is_empty() {
            return Err(format!("{cavity}: no draws of the posterior"));
        }
        let (reached, end) = end(&found);
        if let (0, Some(end)) = (reached, &end) {
            return Err(format!("{cavity}: {end}"));
        }
        let observed = &mut prepared.observables.iter();
        let rest = observed.position(|seen| *seen == Observable::volume(cavity, "rest"));
        let rest = rest.map(|at| quantiles(&posterior.observed.parameter(at).concat()));
        let at = |p: usize| {
            quantiles(&found.iter().filter_map(|(v, _)| v.get(p).copied()).collect::<Vec<_>>())
        };
        let pressures =
            rest.iter().map(|_| 0.0).chain(PRESSURES.into_iter().take(reached)).collect();
        let volumes = rest.into_iter().chain((0..reached).map(at)).collect();
        let data = measured(prepared, posterior, cavity);
        let klotz = data.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
        let klotz = klotz.and_then(|[volume, pressure]| Klotz::through(*pressure, *volume));
        let draws = found.len();
        Ok(Self { cavity: cavity.into(), pressures, volumes, klotz, draws, end })
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let mut text = String::from(
            "pressure [mmHg],volume 2.5 % [mL],volume 50 % [mL],volume 97.5 % [mL],Klotz [mL]\n",
        );
        for (pressure, [low, middle, high]) in self.pressures.iter().zip(&self.volumes) {
            let klotz = self.klotz.map_or(String::new(), |k| k.volume(*pressure).to_string());
            let _ = writeln!(text, "{pressure},{low},{middle},{high},{klotz}");
        }
        text
    }
}

/// Number of pressures at which enough draws have an equilibrium, and why the curve ends before the last.
fn end(found: &[Reached]) -> (usize, Option<String>) {
    let all = found.len();
    let without = |p: usize| found.iter().filter(move |(volumes, _)| volumes.len() <= p);
    let enough = |p: &usize| (all - without(*p).count()) as f64 >= SOLVED * all as f64;
    let reached = (0..PRESSURES.len()).take_while(enough).count();
    let end = PRESSURES.get(reached).map(|beyond| {
        let count = without(reached).count();
        let why = without(reached).find_map(|(_, why)| why.as_deref()).unwrap_or_default();
        format!(
            "the curve ends before {beyond} mmHg, where {count} of {all} draws have no equilibrium, the first: {why}"
        )
    });
    (reached, end)
}

/// Measured volumes of a cavity with their pressures \[mL, mmHg\].
fn measured(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Vec<[f64; 2]> {
    let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
    let parameter = prepared.pressures.iter().find(|(facets, _)| facets == cavity);
    let pair = |datum: &sinew_calibrate::Datum| {
        let state = datum.name.strip_prefix(&format!("volume of {cavity} at "))?;
        let pressure = prepared.phases.get(state)?.get(&parameter?.1)?;
        Some([datum.value / MILLILITRE, pressure / kpa])
    };
    posterior.problem.data.iter().filter_map(pair).collect()
}
