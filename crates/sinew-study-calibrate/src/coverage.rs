//! How often intervals hold the truth of synthetic patients.

use crate::options::Options;
use crate::patients::{self, NAMES, Synthetic};
use anyhow::{Result, anyhow};
use sinew_calibrate::{Correction, Forward, Solves, calibrate};
use sinew_report::{Block, Cell, Chart, Section, Series, Style};
use sinew_sample::{RankEcdf, quantile, split_seed};

/// Layers, cells around and along of the meshes.
const CELLS: [usize; 3] = [2, 12, 6];
const QUICK_CELLS: [usize; 3] = [2, 8, 5];
const QUICK_PATIENTS: usize = 3;
/// Intervals whose coverage is counted.
const LEVELS: [f64; 3] = [0.5, 0.8, 0.95];
/// Points at which rank ECDFs are held against their bands.
const POINTS: usize = 20;
/// Volumes beside the parameters.
const VOLUMES: [&str; 2] = ["volume of endo at rest", "volume of endo at top"];

/// One patient's ranks of the truth, by quantity.
struct Outcome {
    ranks: Vec<f64>,
    correction: Correction,
    mixing: [f64; 3],
}

pub(crate) fn section(options: &Options) -> Result<Section> {
    let (patients, cells) = match options.quick {
        true => (QUICK_PATIENTS, QUICK_CELLS),
        false => (options.patients, CELLS),
    };
    let (mut outcomes, mut refused, mut without_rest) = (Vec::new(), Vec::new(), 0);
    for number in 0..patients {
        let (patient, failed) = patients::random(options.seed, number as u64, cells)?;
        without_rest += failed;
        match one(options, &patient, number as u64)? {
            Ok(outcome) => {
                let c = &outcome.correction;
                println!(
                    "patient {number}: {} solves, {} rounds, {:.0} s, k̂ {:.2}, accepted {:.3}, R̂ {:.3}, ESS {:.0} and {:.0}, ranks {:.2?}",
                    c.solves,
                    c.rounds,
                    c.seconds,
                    c.k_hat,
                    c.acceptance,
                    outcome.mixing[0],
                    outcome.mixing[1],
                    outcome.mixing[2],
                    outcome.ranks
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

/// The outcome of a patient, or why there is none.
fn one(options: &Options, patient: &Synthetic, number: u64) -> Result<Result<Outcome, String>> {
    let prepared = patient.file.prepare()?;
    let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
    let mut settings = patient.file.options();
    settings.seed = split_seed(options.seed, number);
    let mut solves = Solves::new(&model, Box::new(|_, _, _| ()));
    let posterior = match calibrate(&prepared.problem, &mut solves, &settings) {
        Ok(posterior) => posterior,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let truth = model.observe(&patient.theta, false)?.values;
    let rank = |draws: Vec<f64>, truth: f64| {
        draws.iter().filter(|draw| **draw < truth).count() as f64 / draws.len() as f64
    };
    let mut ranks: Vec<f64> = (0..NAMES.len())
        .map(|at| rank(posterior.draws.parameter(at).concat(), patient.theta[at]))
        .collect();
    for name in VOLUMES {
        let seen = prepared.reported.iter().find(|seen| seen.name == name);
        let at = seen.ok_or_else(|| anyhow!("no {name}"))?.observable;
        ranks.push(rank(posterior.observable(at).concat(), truth[at]));
    }
    let mixing = posterior.mixing();
    Ok(Ok(Outcome { ranks, correction: posterior.correction, mixing }))
}

fn written(outcomes: &[Outcome], refused: Vec<String>, title: String) -> Section {
    let names = NAMES.into_iter().chain(VOLUMES);
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut charts = Vec::new();
    let mut pooled = [0.0; 3];
    let inside = |rank: f64, level: f64| (rank - 0.5).abs() <= 0.5 * level;
    let held = |ranks: &[f64], level: f64| {
        ranks.iter().filter(|rank| inside(**rank, level)).count() as f64 / ranks.len() as f64
    };
    let mut count = 0.0;
    for (at, name) in names.enumerate() {
        let ranks: Vec<f64> = outcomes.iter().map(|outcome| outcome.ranks[at]).collect();
        let ecdf = RankEcdf::new(&ranks, POINTS, 0.95);
        let shares = LEVELS.map(|level| held(&ranks, level));
        (0..3).for_each(|i| pooled[i] += shares[i]);
        count += 1.0;
        println!(
            "{name}: 50/80/95 % intervals hold {shares:.2?}, rank ECDF inside its band: {}",
            ecdf.inside()
        );
        let mut row = vec![Cell::from(name)];
        row.extend(shares.map(Cell::from));
        row.push(Cell::from(if ecdf.inside() { "inside" } else { "outside" }));
        rows.push(row);
        charts.push(chart(name, &ecdf));
    }
    let pooled = pooled.map(|sum| sum / count);
    let mut row = vec![Cell::from("pooled")];
    row.extend(pooled.map(Cell::from));
    row.push(Cell::default());
    rows.push(row);
    println!("pooled: {pooled:.3?}");
    let median =
        |of: &dyn Fn(&Outcome) -> f64| quantile(&outcomes.iter().map(of).collect::<Vec<_>>(), 0.5);
    let facts = [
        ("median solves", median(&|o| o.correction.solves as f64)),
        ("median time [s]", median(&|o| o.correction.seconds)),
        ("median k̂", median(&|o| o.correction.k_hat)),
        ("median acceptance", median(&|o| o.correction.acceptance)),
        ("median R̂", median(&|o| o.mixing[0])),
        ("median bulk ESS", median(&|o| o.mixing[1])),
        ("median tail ESS", median(&|o| o.mixing[2])),
    ];
    facts.iter().for_each(|(name, value)| println!("{name}: {value:.3}"));
    let facts = facts.map(|(name, value)| (name.to_string(), format!("{value:.3}")));
    let head = ["quantity", "50 %", "80 %", "95 %", "rank ECDF in its 95 % band"];
    let blocks = vec![
        Block::Text(title),
        Block::List(refused),
        Block::Facts(facts.to_vec()),
        Block::Listing {
            title: "Share of intervals that hold the truth".into(),
            head: head.map(String::from).to_vec(),
            rows,
        },
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
