//! Coverage of intervals, over many sets of data.
//!
//! `cargo xtask coverage [SETS|FIRST..END] [--only NAME,…] [--evidence joint|unit] [--points N] [--laplace]`, or
//! `cargo run --example coverage -p sinew-gp -- 100`
//!
//! Each set has its own places, errors of 2.5 % of the solution's spread whose level is learned, and collocation points. For every
//! problem: the share of 95 % intervals of all parameters that hold them, by NUTS and by Laplace; the share of u that lies
//! in its band; the share of estimates inside their own intervals; the width of intervals over that of least squares with
//! the solution known for every parameter (the bound of Cramér and Rao); the estimates' error over that bound; seconds. Of the
//! intervals that a fit answers with by itself (Laplace's where k̂ trusts it, else those of NUTS): how many miss, and how many of
//! these carry a warning; how often the width of Laplace over that of NUTS is outside of 0.7 to 1.4, and how often that is warned
//! of; sets without an interval, because the equation is not resolved. Each miss is named on the terminal as it is found.

mod conditions;
mod doubtful;
pub(crate) mod problems;

use nalgebra::DMatrix;
use problems::Case;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sinew_gp::{
    Conditional, Data, Ensemble, Evidence, FitOptions, GpError, Model, Noise, NutsOptions, Prior,
    SquaredExponential, laplace, nuts,
};
use std::process::ExitCode;
use std::time::Instant;

/// Errors of measurements, in units of the solution's standard deviation.
const ERROR: f64 = 0.025;
/// Quantiles of the normal distribution that hold 95 %.
const TWO_SIDED: f64 = 1.96;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Result of one ensemble.
#[derive(Clone, Default)]
struct Held {
    warned: bool,
    interval: Vec<[f64; 2]>,
    theta: Vec<bool>,
    estimate: Vec<bool>,
    width: Vec<f64>,
    u: f64,
    seconds: f64,
}

/// Results of one data set: by NUTS, by Laplace, and as the fit chooses.
struct Outcome {
    ensembles: [Held; 3],
    /// Errors of estimates in units of the Cramér–Rao deviation.
    off: Vec<f64>,
    fit_seconds: f64,
    evidence: Evidence,
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (2.0 * std::f64::consts::PI * random.random::<f64>()).cos()
}

fn deviation<const D: usize>(case: &Case<D>) -> f64 {
    let values: Vec<f64> =
        case.problem.domain().grid(21).into_iter().map(|x| case.solution.value(x)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Solutions at parameters next to the true ones, by many collocation points.
struct Neighbours<const D: usize> {
    /// Steps of each parameter: a step up and a step down of its logarithm.
    moved: Vec<[Conditional<D>; 2]>,
}

impl<const D: usize> Neighbours<D> {
    const STEP: f64 = 0.02;

    fn new(case: &Case<D>) -> Result<Self, GpError> {
        let domain = case.problem.domain();
        let at = domain.sample([0, 40, 300, 500][D], 77)?;
        let f: Vec<f64> = at.iter().map(|x| case.load(*x)).collect();
        let prior = Prior::constrained(&case.problem, &SquaredExponential::new())?;
        let data = (case.given)(case, Data::new().equation(&at, &f, Noise::Exact))?;
        let model = std::sync::Arc::new(Model::new(prior, data, Evidence::Joint)?);
        let solve = |theta: &[f64]| {
            let value = |p: &sinew_gp::FreeParameter| {
                let known = case.truth.iter().position(|(name, _)| *name == p.name);
                p.to_scale(known.map_or(0.5 * (p.start[0] * p.start[1]).sqrt(), |k| theta[k]))
            };
            let parameters: Vec<f64> = model.parameters().iter().map(value).collect();
            Conditional::new(model.clone(), &parameters)
        };
        let truth: Vec<f64> = case.truth.iter().map(|(_, value)| *value).collect();
        let (grid, exact) = (domain.sample(50, 99)?, solve(&truth)?);
        let off = exact
            .mean(&grid)?
            .iter()
            .zip(&grid)
            .fold(0.0, |most: f64, (u, x)| most.max((u - case.solution.value(*x)).abs()));
        assert!(off < 0.05 * deviation(case), "{}: solutions off by {off:e}", case.name);
        let moved = |k: usize, sign: f64| {
            let mut theta = truth.clone();
            theta[k] *= (sign * Self::STEP).exp();
            solve(&theta)
        };
        let both = |k: usize| Ok([moved(k, 1.0)?, moved(k, -1.0)?]);
        Ok(Self { moved: (0..truth.len()).map(both).collect::<Result<_, GpError>>()? })
    }

    /// Derivatives of u in the logarithms of the parameters.
    fn slopes(&self, places: &[[f64; D]]) -> Result<Vec<Vec<f64>>, GpError> {
        let slope = |[up, down]: &[Conditional<D>; 2]| {
            let (up, down) = (up.mean(places)?, down.mean(places)?);
            Ok(up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * Self::STEP)).collect())
        };
        self.moved.iter().map(slope).collect()
    }
}

/// Standard deviations of the parameters' logarithms below which no unbiased estimate is; and the errors of least squares with the
/// solution known for every parameter, in units of these, for errors of the values.
fn cramer_rao(slopes: &[Vec<f64>], errors: &[f64], sigma: f64) -> Result<Vec<[f64; 2]>, Failure> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let count = slopes.len();
    let information = DMatrix::from_fn(count, count, |i, j| product(&slopes[i], &slopes[j]));
    let inverse = information.try_inverse().ok_or("parameters that values cannot tell apart")?;
    let bound = |k: usize| sigma * inverse[(k, k)].sqrt();
    let off = |k: usize| {
        (0..count).map(|j| inverse[(k, j)] * product(&slopes[j], errors)).sum::<f64>() / bound(k)
    };
    Ok((0..count).map(|k| [bound(k), off(k)]).collect())
}

fn run<const D: usize>(
    case: &Case<D>,
    neighbours: &Neighbours<D>,
    options: &Options,
    seed: u64,
) -> Result<Option<Outcome>, Failure> {
    let domain = case.problem.domain();
    let sigma = ERROR * deviation(case);
    // Places are drawn with `seed` itself.
    let mut random = ChaCha8Rng::seed_from_u64(seed + 20_000);
    let places = domain.sample(case.counts[0], seed)?;
    let y: Vec<f64> =
        places.iter().map(|x| case.solution.value(*x) + sigma * normal(&mut random)).collect();
    let at = domain.sample(options.points.unwrap_or(case.counts[1]), seed + 10_000)?;
    let f: Vec<f64> = at.iter().map(|x| case.load(*x)).collect();
    let errors: Vec<f64> =
        places.iter().zip(&y).map(|(x, y)| y - case.solution.value(*x)).collect();
    let bound = cramer_rao(&neighbours.slopes(&places)?, &errors, sigma)?;

    let start = Instant::now();
    let data = Data::new().values(&places, &y, Noise::Learned).equation(&at, &f, Noise::Exact);
    let data = (case.given)(case, data)?;
    let prior = Prior::constrained(&case.problem, &SquaredExponential::new())?;
    let model = Model::new(prior, data, options.evidence)?;
    // Points that are asked for stay as many.
    let most_points = if options.points.is_some() { 0 } else { FitOptions::default().most_points };
    let fit = model.fit(&FitOptions { seed, most_points, ..FitOptions::default() })?;
    let fit_seconds = start.elapsed().as_secs_f64();

    let inside = domain.sample(50, 99)?;
    let spoken = !fit.warnings()?.is_empty();
    let judge = |ensemble: &Ensemble<D>, seconds: f64| -> Result<Held, GpError> {
        let warned = spoken || !ensemble.warnings().is_empty();
        let mut held = Held { seconds, warned, ..Held::default() };
        for ((name, truth), [bound, _]) in case.truth.iter().zip(&bound) {
            let [lower, upper] = ensemble.interval(name, 0.95)?;
            let estimate = fit.parameter(name)?;
            held.interval.push([lower, upper]);
            held.theta.push(lower <= *truth && *truth <= upper);
            held.estimate.push(lower <= estimate && estimate <= upper);
            held.width.push((upper / lower).ln() / (2.0 * TWO_SIDED * bound));
        }
        let band = ensemble.predict(&inside)?;
        let holds = |k: &usize| {
            (band.mean[*k] - case.solution.value(inside[*k])).abs()
                <= TWO_SIDED * band.standard_deviation[*k]
        };
        held.u = (0..inside.len()).filter(holds).count() as f64 / inside.len() as f64;
        Ok(held)
    };
    let start = Instant::now();
    let defaults = NutsOptions::default();
    // Enough to go on, where Laplace alone is asked for.
    let of = |count: usize| if options.laplace { 2 } else { count };
    let nuts_options = NutsOptions { seed, draws: of(defaults.draws), warmup: of(defaults.warmup) };
    let sampled = match nuts(&fit, &nuts_options) {
        Err(GpError::Unresolved { .. }) => return Ok(None),
        sampled => judge(&sampled?, start.elapsed().as_secs_f64())?,
    };
    let start = Instant::now();
    let weighed = laplace(&fit, 300, seed)?;
    let trusted = options.laplace || weighed.k_hat.is_none_or(|k_hat| k_hat <= 0.4);
    let weighed = judge(&weighed, start.elapsed().as_secs_f64())?;
    let chosen = if trusted { weighed.clone() } else { sampled.clone() };
    for (k, (name, truth)) in case.truth.iter().enumerate().filter(|(k, _)| !chosen.theta[*k]) {
        let [lower, upper] = chosen.interval[k];
        let warned = if chosen.warned { "warned" } else { "no warning" };
        eprintln!(
            "{} set {seed}: {name} = {truth} outside of {lower:.5} to {upper:.5}, {:.2} of Cramér–Rao ({warned}); least squares with the solution known is off by {:.1} of its deviations",
            case.name, chosen.width[k], bound[k][1]
        );
    }
    let errors =
        case.truth.iter().zip(&bound).map(|((name, truth), [bound, _])| {
            Ok(((fit.parameter(name)? / truth).ln() / bound).abs())
        });
    let off = errors.collect::<Result<_, GpError>>()?;
    let evidence = fit.model().evidence();
    Ok(Some(Outcome { ensembles: [sampled, weighed, chosen], off, fit_seconds, evidence }))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn study<const D: usize>(case: Result<Case<D>, GpError>, options: &Options) -> Result<(), Failure> {
    let case = case?;
    if !options.only.is_empty() && !options.only.iter().any(|name| name == case.name) {
        return Ok(());
    }
    rows(&case, options)?.iter().for_each(|row| println!("{row}"));
    Ok(())
}

/// One row of the table for every parameter of a problem.
pub(crate) fn rows<const D: usize>(
    case: &Case<D>,
    options: &Options,
) -> Result<Vec<String>, Failure> {
    let neighbours = Neighbours::new(case)?;
    let all: Vec<Option<Outcome>> = options
        .sets
        .clone()
        .into_par_iter()
        .map(|seed| run(case, &neighbours, options, seed))
        .collect::<Result<_, _>>()?;
    let outcomes: Vec<Outcome> = all.into_iter().flatten().collect();
    let withheld = options.sets.clone().count() - outcomes.len();
    if outcomes.is_empty() {
        return Ok(vec![format!("| {} | no interval in {withheld} sets |", case.name)]);
    }
    let row = |(k, (name, _)): (usize, &(&str, f64))| {
        let ways = [0, 1].map(|which| match which == 0 && options.laplace {
            true => "| – | – | – | – | – ".to_owned(),
            false => summary(&outcomes, which, k),
        });
        let of = |o: &Outcome| {
            let [sampled, weighed, chosen] = &o.ensembles;
            let ratio = weighed.width[k] / sampled.width[k];
            let apart = !options.laplace && !(0.7..=1.4).contains(&ratio);
            [(!chosen.theta[k], chosen.warned), (apart, weighed.warned)]
        };
        let [misses, apart] = [0, 1].map(|which| {
            let found: Vec<bool> =
                outcomes.iter().map(|o| of(o)[which]).filter(|f| f.0).map(|f| f.1).collect();
            format!("{} ({})", found.len(), found.iter().filter(|warned| **warned).count())
        });
        format!(
            "| {} {name} | {:?} {}| {:.2} | {:.2} | {misses} | {apart} | {withheld} |",
            case.name,
            outcomes[0].evidence,
            ways.concat(),
            median(outcomes.iter().map(|o| o.off[k]).collect()) / 0.6745,
            median(outcomes.iter().map(|o| o.fit_seconds).collect()),
        )
    };
    Ok(case.truth.iter().enumerate().map(row).collect())
}

/// Columns of one way of drawing, for the parameter of number `k`.
fn summary(outcomes: &[Outcome], which: usize, k: usize) -> String {
    let each = || outcomes.iter().map(|o| &o.ensembles[which]);
    let count = outcomes.len() as f64;
    let share = |of: &dyn Fn(&Held) -> f64| 100.0 * each().map(of).sum::<f64>() / count;
    let one = |b: bool| f64::from(u8::from(b));
    format!(
        "| {:.0} | {:.1} | {:.0} | {:.2} | {:.2} ",
        share(&|h| one(h.theta[k])),
        share(&|h| h.u),
        share(&|h| one(h.estimate[k])),
        median(each().map(|h| h.width[k]).collect()),
        median(each().map(|h| h.seconds).collect()),
    )
}

/// Options of the command line.
pub(crate) struct Options {
    sets: std::ops::Range<u64>,
    only: Vec<String>,
    evidence: Evidence,
    points: Option<usize>,
    laplace: bool,
}

impl Options {
    pub(crate) fn of_sets(sets: std::ops::Range<u64>) -> Self {
        Self { sets, only: Vec::new(), evidence: Evidence::Auto, points: None, laplace: false }
    }
}

fn options() -> Result<Options, Failure> {
    let mut options = Options::of_sets(0..4);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match (word.as_str(), words.size_hint()) {
            ("--only", _) => {
                let names = words.next().ok_or("--only needs names")?;
                options.only = names.split(',').map(str::to_string).collect();
            }
            ("--evidence", _) => {
                options.evidence = match words.next().as_deref() {
                    Some("joint") => Evidence::Joint,
                    Some("unit") => Evidence::UnitInformation,
                    other => {
                        let other = other.unwrap_or("nothing");
                        return Err(format!("evidence {other}: joint or unit").into());
                    }
                };
            }
            ("--points", _) => options.points = Some(words.next().ok_or("how many?")?.parse()?),
            ("--laplace", _) => options.laplace = true,
            (sets, _) => {
                let number = |word: &str| -> Result<u64, Failure> {
                    word.parse().map_err(|_| format!("{sets} is no number of sets").into())
                };
                options.sets = match sets.split_once("..") {
                    Some((first, end)) => number(first)?..number(end)?,
                    None => 0..number(sets)?,
                };
            }
        }
    }
    Ok(options)
}

const USAGE: &str = "Coverage of 95 % intervals on twenty-one problems

Usage: coverage [SETS|FIRST..END] [--only NAME,…] [--evidence joint|unit] [--points N] [--laplace]";

fn main() -> ExitCode {
    if std::env::args().any(|word| word == "--help") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match options().and_then(|options| all_problems(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("error: {reason}\n\n{USAGE}");
            ExitCode::FAILURE
        }
    }
}

fn all_problems(options: &Options) -> Result<(), Failure> {
    println!(
        "95 % intervals over {} sets: θ and u held [%], estimates inside their own [%], width over Cramér–Rao, seconds; error over Cramér–Rao",
        options.sets.clone().count()
    );
    println!(
        "| problem, parameter | evidence | NUTS: θ | u | own | width | s | Laplace: θ | u | own | width | s | error | fit s | misses (warned) | Laplace apart (warned) | withheld |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    study(problems::slab(), options)?;
    study(problems::cooling(), options)?;
    study(problems::ring(), options)?;
    study(problems::sprung_string(), options)?;
    study(problems::dispersion(), options)?;
    study(problems::plate(), options)?;
    study(problems::beam(), options)?;
    study(problems::graded_rod(), options)?;
    study(problems::reaction(), options)?;
    study(problems::triangle(), options)?;
    study(problems::insulated(), options)?;
    study(conditions::half_wall(), options)?;
    study(conditions::gangway(), options)?;
    study(conditions::window(), options)?;
    study(conditions::film(), options)?;
    study(conditions::lamp(), options)?;
    study(conditions::tube(), options)?;
    study(conditions::notch(), options)?;
    study(doubtful::layer(), options)?;
    study(doubtful::three(), options)?;
    study(doubtful::screened(), options)
}
