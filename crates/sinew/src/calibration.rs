//! What a calibration found: pressure–volume curve, sentences, page.

mod run;

pub use run::{arviz, in_words, observed};

use crate::case::stress_in_kpa;
use crate::comparison::triangles;
use crate::patient::Prepared;
use rayon::prelude::*;
use sinew_calibrate::{Forward, Identified, Klotz, Posterior};
use sinew_fem::Unloaded;
use sinew_report::format::{digits, seconds, trimmed};
use sinew_report::{
    Block, Cell, Chart, Provenance, Report, Section, Series, Style, Surfaces, density,
};
use sinew_sample::quantile;
use std::fmt::Write;

/// Pressures of the curve \[mmHg\].
const PRESSURES: [f64; 10] = [2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0, 23.0, 26.0, 30.0];
/// Draws that the curve is solved for, which give its band.
const CURVE_DRAWS: usize = 48;
/// One millilitre in mm³.
const MILLILITRE: f64 = 1e3;
/// Draws in a plot of two parameters.
const MOST_POINTS: usize = 150;
/// Parameters at most for a plot of each pair.
const MOST_PAIRED: usize = 5;

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
}

impl Curve {
    /// Solves for the volumes of a cavity at some draws of the posterior.
    ///
    /// # Errors
    /// A cavity whose pressure is not a parameter, and draws that cannot be solved.
    pub fn new(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Result<Self, String> {
        let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
        let patient = prepared.curve(cavity, &PRESSURES.map(|p| p * kpa))?;
        let chains = posterior.draws.draws.len().max(1);
        let thin = posterior.draws.thinned(CURVE_DRAWS.div_ceil(chains));
        let places = prepared.curve_parameters();
        let thetas: Vec<Vec<f64>> =
            thin.pooled().map(|draw| places.iter().map(|&at| draw[at]).collect()).collect();
        if let Some(middle) = thetas.get(thetas.len() / 2) {
            patient.expect_near(middle);
        }
        let solve = |theta: &Vec<f64>| patient.observe(theta, false).ok().map(|seen| seen.values);
        let found: Vec<Vec<f64>> = thetas.par_iter().filter_map(solve).collect();
        if found.is_empty() {
            return Err(format!("the curve of {cavity} has no equilibrium at any draw"));
        }
        let quantiles = |volumes: Vec<f64>| {
            [0.025, 0.5, 0.975].map(|share| quantile(&volumes, share) / MILLILITRE)
        };
        let name = format!("volume of {cavity} at rest");
        let rest = prepared.reported.iter().find(|seen| seen.name == name);
        let rest = rest.map(|seen| quantiles(posterior.observable(seen.observable).concat()));
        let at = |p: usize| quantiles(found.iter().map(|volumes| volumes[p]).collect());
        let (mut pressures, mut volumes) = (Vec::new(), Vec::new());
        if let Some(rest) = rest {
            pressures.push(0.0);
            volumes.push(rest);
        }
        pressures.extend(PRESSURES);
        volumes.extend((0..PRESSURES.len()).map(at));
        let data = measured(prepared, posterior, cavity);
        let klotz = data.iter().max_by(|a, b| a[0].total_cmp(&b[0]));
        let klotz = klotz.and_then(|[pressure, volume]| Klotz::through(*pressure, *volume));
        Ok(Self { cavity: cavity.into(), pressures, volumes, klotz, draws: found.len() })
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let mut text = String::from(
            "pressure [mmHg],volume 2.5 % [mL],volume 50 % [mL],volume 97.5 % [mL],Klotz [mL]\n",
        );
        for (pressure, [low, middle, high]) in self.pressures.iter().zip(&self.volumes) {
            let klotz = self.klotz.map_or(String::new(), |k| inverse(&k, *pressure).to_string());
            let _ = writeln!(text, "{pressure},{low},{middle},{high},{klotz}");
        }
        text
    }
}

/// Volume of Klotz's curve at a pressure; the unloaded one at 0.
fn inverse(klotz: &Klotz, pressure: f64) -> f64 {
    match pressure > 0.0 {
        true => (pressure / klotz.alpha).powf(1.0 / klotz.beta),
        false => klotz.unloaded,
    }
}

/// Measured volumes of a cavity with their pressures \[mmHg, mL\].
fn measured(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Vec<[f64; 2]> {
    let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
    let parameter = prepared.pressures.iter().find(|(facets, _)| facets == cavity);
    let pair = |datum: &sinew_calibrate::Datum| {
        let state = datum.name.strip_prefix(&format!("volume of {cavity} at "))?;
        let pressure = prepared.phases.get(state)?.get(&parameter?.1)?;
        Some([pressure / kpa, datum.value / MILLILITRE])
    };
    posterior.problem.data.iter().filter_map(pair).collect()
}

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
    let line = |seen: &crate::patient::Reported| {
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
    let fit = match doubts.first() {
        None => "all data fit".to_string(),
        Some(doubt) => doubt.trim_end_matches('.').to_string(),
    };
    let volume = volumes_in_words(prepared, posterior).into_iter().next();
    let volume = volume.map_or(String::new(), |line| format!("{line}; "));
    format!(
        "{volume}{of_parameters}; {fit}; the solver confirms this posterior (k̂ {:.2}, {:.0} % of its corrections accepted).",
        posterior.correction.k_hat,
        100.0 * posterior.correction.acceptance
    )
}

/// The page.
pub fn report(
    title: &str,
    prepared: &Prepared,
    posterior: &Posterior,
    curves: &[Curve],
    rest: Option<&Unloaded>,
    provenance: Provenance,
) -> Report {
    let about = format!(
        "{} nodes, {} data, {} unknown parameters",
        prepared.body.nodes,
        posterior.problem.data.len(),
        posterior.problem.unknowns.len()
    );
    let mut report = Report::new(title, about, provenance);
    report.headline = verdict(prepared, posterior);
    report.notes.extend(posterior.predictive.in_words());
    let mut curve =
        Section { name: "curve".into(), title: "Pressure and volume".into(), blocks: Vec::new() };
    curve.blocks.push(Block::List(volumes_in_words(prepared, posterior)));
    curve.blocks.extend(curves.iter().map(|curve| curve_block(curve, prepared, posterior)));
    curve.blocks.extend(rest.and_then(|rest| shapes(prepared, rest)));
    let sections = [
        curve,
        parameters(posterior),
        identifiability(posterior),
        data(posterior),
        correction(posterior),
    ];
    report.sections.extend(sections);
    report
}

/// The body at rest beside that of the image.
fn shapes(prepared: &Prepared, unloaded: &Unloaded) -> Option<Block> {
    let (image, rest) = (&prepared.body, &unloaded.rest.body);
    let mut surfaces = Surfaces::new(&triangles(&image.mesh), &rest.positions).ok()?;
    surfaces.quantity = "distance from the place at rest".into();
    (surfaces.unit, surfaces.length, surfaces.linear) = ("mm".into(), "mm".into(), true);
    let moved = unloaded.motion.as_chunks::<3>().0.iter();
    let moved: Vec<f64> = moved.map(|w| w.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
    let still = vec![0.0; moved.len()];
    surfaces.push("most likely parameters", "at rest", &rest.positions, &still).ok()?;
    surfaces.push("the mesh", "in the image", &image.positions, &moved).ok()?;
    Some(Block::Surfaces(surfaces))
}

fn curve_block(curve: &Curve, prepared: &Prepared, posterior: &Posterior) -> Block {
    let middle = curve.pressures.iter().zip(&curve.volumes).map(|(p, v)| [*p, v[1]]);
    let band = curve.volumes.iter().map(|[low, _, high]| [*low, *high]).collect();
    let own = Series { band, ..Series::new("posterior, 95 % band", Style::Line, middle) };
    let axes = ["pressure [mmHg]", "volume [mL]"];
    let mut chart = Chart::new(format!("Cavity {}", curve.cavity), axes, [false; 2]).with(own);
    if let Some(klotz) = curve.klotz {
        let points = curve.pressures.iter().map(|p| [*p, inverse(&klotz, *p)]);
        chart = chart.with(Series::new(
            "Klotz et al. 2006, through the last datum",
            Style::Line,
            points,
        ));
    }
    let measured = measured(prepared, posterior, &curve.cavity);
    chart = chart.with(Series::new("measured", Style::Points, measured));
    let caption =
        format!("Volumes over pressures, solved at {} draws of the posterior.", curve.draws);
    Block::charts("Pressure–volume curve", caption, [chart])
}

fn parameters(posterior: &Posterior) -> Section {
    let count = posterior.problem.unknowns.len();
    let lines = (0..count).map(|at| parameter_in_words(posterior, at)).collect();
    let prior: Vec<Vec<f64>> = (0..count).map(|at| prior_draws(posterior, at)).collect();
    let chart = |at: usize| {
        let head = posterior.problem.unknowns[at].head();
        let draws = posterior.shown(at).concat();
        Chart::new(&head, [&head, "density per decade"], [true, false])
            .with(Series::new("prior", Style::Area, density(&prior[at])))
            .with(Series::new("posterior", Style::Area, density(&draws)))
    };
    let mut blocks =
        vec![Block::List(lines), Block::charts("Prior and posterior", "", (0..count).map(chart))];
    if (2..=MOST_PAIRED).contains(&count) {
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        let charts = pairs.map(|(a, b)| pair(posterior, &prior, a, b));
        blocks.push(Block::charts("Pairs of parameters", "Draws of prior and posterior.", charts));
    }
    Section { name: "parameters".into(), title: "Parameters".into(), blocks }
}

fn pair(posterior: &Posterior, prior: &[Vec<f64>], a: usize, b: usize) -> Chart {
    let [x, y] = [a, b].map(|at| posterior.problem.unknowns[at].head());
    let [u, v] = [a, b].map(|at| posterior.shown(at).concat());
    // Few enough points to be distinguished.
    let points = |u: &[f64], v: &[f64]| {
        let every = u.len().div_ceil(MOST_POINTS).max(1);
        u.iter().zip(v).step_by(every).map(|(u, v)| [*u, *v]).collect::<Vec<_>>()
    };
    Chart::new(format!("{x} and {y}"), [&x, &y], [true, true])
        .with(Series::new("prior", Style::Points, points(&prior[a], &prior[b])))
        .with(Series::new("posterior", Style::Points, points(&u, &v)))
}

/// Quantiles of the prior at equal shares, in an order that does not pair them with those of other parameters.
fn prior_draws(posterior: &Posterior, parameter: usize) -> Vec<f64> {
    use rand::SeedableRng;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(parameter as u64);
    let unknown = &posterior.problem.unknowns[parameter];
    let normals = sinew_sample::standard_normals(posterior.draws.pooled().count(), &mut random);
    normals.into_iter().map(|y| unknown.shown(unknown.prior.logarithm(y)[0].exp())).collect()
}

fn identifiability(posterior: &Posterior) -> Section {
    let found = &posterior.identifiability;
    let head = std::iter::once("eigenvalue".to_string()).chain(found.names.iter().cloned());
    let row = |(value, direction): (&f64, &Vec<f64>)| {
        std::iter::once(*value).chain(direction.iter().copied()).map(Cell::from).collect()
    };
    let blocks = vec![
        Block::List(found.in_words()),
        Block::Listing {
            title: "Spectrum of the information of the data, priors being standard normal".into(),
            head: head.collect(),
            rows: found.spectrum.iter().zip(&found.directions).map(row).collect(),
        },
    ];
    Section { name: "identifiability".into(), title: "Identified by the data".into(), blocks }
}

fn data(posterior: &Posterior) -> Section {
    let checks = &posterior.predictive.data;
    let points = checks.iter().enumerate().map(|(at, c)| [at as f64 + 1.0, c.residual]);
    let hints = checks.iter().map(|check| check.name.clone()).collect();
    let series = Series { hints, ..Series::new("residual", Style::Points, points) };
    let axes = ["datum", "measured − predicted [standard deviations]"];
    let chart = Chart::new("Residuals", axes, [false; 2]).with(series);
    let row = |check: &sinew_calibrate::DatumCheck| {
        let datum = posterior.problem.data.iter().find(|d| d.name == check.name);
        let (size, unit) = datum.map_or((1.0, ""), |d| (d.size, d.unit.as_str()));
        vec![
            Cell::from(check.name.as_str()),
            Cell::from(check.value / size),
            Cell::from(check.predicted / size),
            Cell::from(check.deviation / size),
            Cell::from(unit),
            Cell::from(check.residual),
            Cell::from(check.p),
            Cell::from(check.p_left_out),
        ]
    };
    let head = [
        "datum",
        "measured",
        "predicted",
        "sd of the prediction",
        "unit",
        "residual [sd]",
        "p",
        "p, left out",
    ];
    let mut blocks = vec![Block::Text(format!(
        "Probability of misfits in all that are larger than these: {}.",
        trimmed(posterior.predictive.p_overall, 3)
    ))];
    blocks.push(Block::charts("Residual of each datum", "", [chart]));
    blocks.push(Block::Listing {
        title: "Each datum".into(),
        head: head.map(String::from).to_vec(),
        rows: checks.iter().map(row).collect(),
    });
    Section { name: "data".into(), title: "Data and predictions".into(), blocks }
}

fn correction(posterior: &Posterior) -> Section {
    let found = &posterior.correction;
    let [r_hat, bulk, tail] = posterior.mixing();
    let facts = [
        ("Pareto k̂", format!("{:.2}", found.k_hat)),
        ("effective share", format!("{:.3}", found.share)),
        (
            "largest error of the emulator",
            format!("{:.3} sd of {}", found.largest_error, found.worst_datum),
        ),
        ("acceptance", format!("{:.3}", found.acceptance)),
        ("rounds", found.rounds.to_string()),
        ("solves", format!("{}, {} without an answer", found.solves, found.failed)),
        ("time", seconds(found.seconds)),
        ("R̂", format!("{r_hat:.4}")),
        ("effective draws", format!("{bulk:.0} in the bulk, {tail:.0} in the tails")),
    ];
    let blocks = vec![
        Block::Text(
            "A polynomial through solves with their derivatives is sampled by NUTS; its draws are corrected by one sweep of \
             independence Metropolis with the solver's likelihood, which makes them draws of the solver's posterior."
                .into(),
        ),
        Block::Facts(facts.map(|(name, value)| (name.to_string(), value)).to_vec()),
    ];
    Section { name: "correction".into(), title: "Correction by the solver".into(), blocks }
}
