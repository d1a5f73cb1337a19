//! Synthetic patients, and coverage of intervals for them.

use super::ecdf::RankEcdf;
use super::options::{Options, listing, row};
use crate::program;
use anyhow::{Result, anyhow};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use sinew::{PatientFile, Prepared};
use sinew_calibrate::{Correction, Forward, Patient, Posterior, Solves, calibrate};
use sinew_report::{Block, Chart, Section, Series, Style};
use sinew_sample::{quantile, split_seed};

const QUICK_PATIENTS: usize = 3;
/// Draws of each patient's posterior.
const DRAWS: usize = 240;
/// Intervals whose coverage is counted.
const LEVELS: [f64; 3] = [0.5, 0.8, 0.95];
/// Points at which rank ECDFs are held against their bands.
const POINTS: usize = 20;
/// Volumes beside the parameters.
const VOLUMES: [&str; 2] = ["volume of endo at rest", "volume of endo at top"];

/// One patient's ranks of the truth, by quantity.
#[derive(Serialize, Deserialize)]
struct Outcome {
    ranks: Vec<f64>,
    correction: Correction,
    mixing: [f64; 3],
}

pub(super) fn section(options: &Options) -> Result<Section> {
    let patients = if options.quick { QUICK_PATIENTS } else { options.patients };
    let (mut outcomes, mut refused, mut without_rest) = (Vec::new(), Vec::new(), 0);
    for number in 0..patients {
        let file = options.out.join(format!("patients/{number}.json"));
        let (failed, found) = program::kept(&file, options.resume, || {
            let (patient, failed) = random(options.seed, number as u64)?;
            Ok((failed, one(options, &patient, number as u64)?))
        })?;
        without_rest += failed;
        match found {
            Ok(outcome) => {
                let Outcome { ranks, correction: c, mixing } = &outcome;
                println!(
                    "patient {number}: {} solves, {} rounds, {:.0} s, k̂ {:.2}, accepted {:.3}, R̂ and ESS {mixing:.3?}, ranks {ranks:.2?}",
                    c.solves, c.rounds, c.seconds, c.k_hat, c.acceptance,
                );
                outcomes.push(outcome);
            }
            Err(reason) => {
                println!("patient {number} refused: {reason}");
                refused.push(format!("patient {number}: {reason}"));
            }
        }
    }
    let title = format!(
        "{} of {patients} patients answered, {without_rest} draws of shape and parameters had no body at rest",
        outcomes.len()
    );
    Ok(written(&outcomes, refused, title))
}

/// The outcome of a patient, or the reason for its absence.
fn one(options: &Options, patient: &Synthetic, number: u64) -> Result<Result<Outcome, String>> {
    let prepared = patient.file.prepare()?;
    let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
    let truth = model.observe(&patient.theta, false)?.values;
    let found = calibrated(options, (&prepared, &model), (patient, &truth), number)?;
    Ok(found.map(|(posterior, quantities)| Outcome {
        ranks: ranks(&quantities),
        mixing: posterior.coordinates.mixing(),
        correction: posterior.correction,
    }))
}

/// Draws of a quantity with its true value.
type Quantity = (Vec<f64>, f64);

/// The posterior of a patient by a model and draws of all quantities, or the reason for its absence.
fn calibrated(
    options: &Options,
    (prepared, model): (&Prepared, &Patient<'_>),
    (patient, observed): (&Synthetic, &[f64]),
    number: u64,
) -> Result<Result<(Posterior, Vec<Quantity>), String>> {
    let mut settings = patient.file.options();
    settings.seed = split_seed(options.seed, number);
    settings.draws = DRAWS;
    let mut solves = Solves::new(model);
    let posterior = match calibrate(&prepared.problem, &mut solves, &settings) {
        Ok(posterior) => posterior,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let quantities = quantities(prepared, &posterior, &patient.theta, observed)?;
    Ok(Ok((posterior, quantities)))
}

/// Draws of the parameters and of [`VOLUMES`], each with its true value.
fn quantities(
    prepared: &Prepared,
    posterior: &Posterior,
    theta: &[f64],
    observed: &[f64],
) -> Result<Vec<Quantity>> {
    let parameters = (0..NAMES.len()).map(|at| (posterior.draws.parameter(at).concat(), theta[at]));
    let mut all: Vec<_> = parameters.collect();
    for name in VOLUMES {
        let seen = prepared.observables.iter().position(|seen| seen.to_string() == name);
        let at = seen.ok_or_else(|| anyhow!("no {name}"))?;
        all.push((posterior.observed.parameter(at).concat(), observed[at]));
    }
    Ok(all)
}

/// Share of the draws of each quantity below the truth.
fn ranks(quantities: &[Quantity]) -> Vec<f64> {
    let rank = |(draws, truth): &Quantity| {
        draws.iter().filter(|draw| *draw < truth).count() as f64 / draws.len() as f64
    };
    quantities.iter().map(rank).collect()
}

/// Share of intervals of a probability that hold the truth, by its ranks.
fn held(ranks: &[f64], level: f64) -> f64 {
    let inside = ranks.iter().filter(|rank| (**rank - 0.5).abs() <= 0.5 * level);
    inside.count() as f64 / ranks.len() as f64
}

type Number = fn(&Outcome) -> f64;

fn written(outcomes: &[Outcome], refused: Vec<String>, title: String) -> Section {
    const HEAD: [&str; 4] = ["50 %", "80 %", "95 %", "inside its band"];
    let held = |ranks: &[f64]| LEVELS.map(|level| held(ranks, level));
    let (mut rows, mut charts, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (at, name) in NAMES.into_iter().chain(VOLUMES).enumerate() {
        let ranks: Vec<f64> = outcomes.iter().map(|outcome| outcome.ranks[at]).collect();
        let ecdf = RankEcdf::new(&ranks, POINTS, 0.95);
        let [half, most, nearly] = held(&ranks);
        rows.push(row(name, &HEAD, &[half, most, nearly, f64::from(u8::from(ecdf.inside()))]));
        charts.push(chart(name, &ecdf));
        all.extend(ranks);
    }
    rows.push(row("pooled", &HEAD, &held(&all)));
    let of: [(&str, Number); 7] = [
        ("median solves", |o| o.correction.solves as f64),
        ("median time [s]", |o| o.correction.seconds),
        ("median k̂", |o| o.correction.k_hat),
        ("median acceptance", |o| o.correction.acceptance),
        ("median R̂", |o| o.mixing[0]),
        ("median bulk ESS", |o| o.mixing[1]),
        ("median tail ESS", |o| o.mixing[2]),
    ];
    let median =
        |of: fn(&Outcome) -> f64| quantile(&outcomes.iter().map(of).collect::<Vec<_>>(), 0.5);
    let facts = of.map(|(name, of)| (name.to_string(), format!("{:.3}", median(of)))).to_vec();
    let said: Vec<_> = facts.iter().map(|(name, value)| format!("{name} {value}")).collect();
    println!("{title}; {}", said.join(", "));
    let blocks = vec![
        Block::Text(title),
        Block::List(refused),
        Block::Facts(facts),
        listing("Share of intervals that hold the truth", "quantity", &HEAD, rows),
        Block::charts(
            "Rank ECDFs",
            "Share of the truth's ranks up to a point, with 95 % bands (Säilynoja 2022).",
            charts,
        ),
    ];
    Section { name: "coverage".into(), title: "Coverage".into(), blocks }
}

fn chart(name: &str, ecdf: &RankEcdf) -> Chart {
    let count = ecdf.band.count as f64;
    let share = |counts: &[u64]| counts.iter().map(|c| *c as f64 / count).collect::<Vec<_>>();
    let [lower, upper] = [&ecdf.band.lower, &ecdf.band.upper].map(|counts| share(counts));
    let points = ecdf.band.points.iter().zip(share(&ecdf.counts)).map(|(x, y)| [*x, y]);
    let band = lower.into_iter().zip(upper).map(|(low, high)| [low, high]).collect();
    let series = Series { band, ..Series::new("ranks", Style::Line, points) };
    Chart::new(name, ["rank of the truth", "share"], [false; 2]).with(series)
}

/// Parameters whose truth is drawn from their prior.
const NAMES: [&str; 4] = ["a", "b", "a_f", "b_f"];
/// Ranges of the priors.
const RANGES: [[f64; 2]; 4] = [[0.1, 0.4], [1.0, 4.0], [1.5, 5.0], [1.0, 4.5]];
/// Cells through the wall, around and along of the patients' meshes.
const CELLS: [usize; 3] = [2, 8, 5];
/// Seed stream of shapes and parameters.
const SHAPES: u64 = 0x5348;

/// A patient file with data.
pub(super) struct Synthetic {
    pub file: PatientFile,
    pub theta: Vec<f64>,
}

/// A patient of a random shape in the image; θ is drawn from the prior, independent of it. Draws without a body at rest are
/// made again, which the count of them tells.
pub(super) fn random(seed: u64, number: u64) -> Result<(Synthetic, usize)> {
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(split_seed(seed, SHAPES), number));
    let mut failed = 0;
    loop {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let (radius, wall) = (between(18.0, 26.0), between(8.0, 12.0));
        let (long, base) = (radius * between(2.2, 2.8), between(10.0, 18.0));
        let theta: Vec<f64> =
            RANGES.iter().map(|[low, high]| low * (high / low).powf(between(0.0, 1.0))).collect();
        let blank = PatientFile::parse(
            &text([radius, radius + wall], [long, long + wall], base, CELLS, &RANGES),
            "synthetic",
        )?;
        match blank.synthesise(&theta, split_seed(seed, number)) {
            Ok(text) => {
                let file = PatientFile::parse(&text, "synthetic")?;
                return Ok((Synthetic { file, theta }, failed));
            }
            Err(error) if failed > 20 => return Err(error.into()),
            Err(_) => failed += 1,
        }
    }
}

/// The file: volumes at three pressures (3 %) and strains of 24 segments (± .02).
fn text(
    short: [f64; 2],
    long: [f64; 2],
    base: f64,
    cells: [usize; 3],
    ranges: &[[f64; 2]; 4],
) -> String {
    let parameter = |(name, range): (&&str, &[f64; 2])| format!("{name} = {range:?}\n");
    let parameters: String = NAMES.iter().zip(ranges).map(parameter).collect();
    format!(
        include_str!("patient.toml.in"),
        short = short,
        long = long,
        base = base,
        cells = cells,
        parameters = parameters
    )
}
