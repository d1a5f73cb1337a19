//! Coverage of intervals, over many sets of data.
//!
//! `cargo xtask coverage [SETS|FIRST..END] [--only NAME,…] [--evidence joint|unit] [--points N]`, or
//! `cargo run --example coverage -p sinew-gp -- 100`
//!
//! Each set has its own places, errors of 2.5 % of the solution's spread whose level is learned, and collocation points. Intervals
//! and bands are those that a fit answers with (`Fit::interval`, `Fit::predict`). For every parameter of every problem: the share of
//! 95 % intervals that hold it; the share of u that lies in its band; the share of estimates inside their own intervals, before
//! `Fit::interval` includes them; the width of intervals over that of least squares with the solution known for every parameter (the
//! bound of Cramér and Rao); the estimates' error over that bound; how many intervals miss, and how many of these carry a
//! warning; sets drawn by NUTS; sets without an interval, because the equation is not resolved; seconds. Each miss is named on the
//! terminal as it is found.

mod conditions;
mod doubtful;
pub(crate) mod problems;

use nalgebra::DMatrix;
use problems::Case;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use sinew_gp::{
    Conditional, Data, Evidence, Fit, FitOptions, GpError, Model, Noise, Prior, squared_exponential,
};
use std::process::ExitCode;
use std::time::Instant;

/// Errors of measurements, in units of the solution's standard deviation.
const ERROR: f64 = 0.025;
/// Quantiles of the normal distribution that hold 95 %.
const TWO_SIDED: f64 = 1.96;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Results of one data set.
struct Outcome {
    evidence: Evidence,
    /// Interval of each parameter.
    parameters: Vec<Held>,
    /// Share of u in its band.
    u: f64,
    warned: bool,
    by_nuts: bool,
    fit_seconds: f64,
    interval_seconds: f64,
}

/// Interval of one parameter beside its true value.
struct Held {
    interval: [f64; 2],
    truth: bool,
    estimate: bool,
    /// Width of the interval and error of the estimate, in units of the bound of Cramér and Rao.
    width: f64,
    off: f64,
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
        let prior = Prior::constrained(&case.problem, &squared_exponential())?;
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
    let prior = Prior::constrained(&case.problem, &squared_exponential())?;
    let model = Model::new(prior, data, options.evidence)?;
    // Points that are asked for stay as many.
    let most_points = if options.points.is_some() { 0 } else { FitOptions::default().most_points };
    let fit = model.fit(&FitOptions { seed, most_points, ..FitOptions::default() })?;
    let fit_seconds = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let ensemble = match fit.ensemble() {
        Err(GpError::Unresolved { .. }) => return Ok(None),
        made => made?,
    };
    let interval_seconds = start.elapsed().as_secs_f64();
    let outcome = Outcome {
        evidence: fit.model().evidence(),
        parameters: held(case, &fit, &bound)?,
        u: band(case, &fit)?,
        warned: !fit.warnings()?.is_empty() || !ensemble.warnings.is_empty(),
        by_nuts: ensemble.k_hat.is_none(),
        fit_seconds,
        interval_seconds,
    };
    for (k, missed) in outcome.parameters.iter().enumerate().filter(|(_, held)| !held.truth) {
        let ((name, truth), [lower, upper]) = (case.truth[k], missed.interval);
        let warned = if outcome.warned { "warned" } else { "no warning" };
        eprintln!(
            "{} set {seed}: {name} = {truth} outside of {lower:.5} to {upper:.5}, {:.2} of Cramér–Rao ({warned}); least squares with the solution known is off by {:.1} of its deviations",
            case.name, missed.width, bound[k][1]
        );
    }
    Ok(Some(outcome))
}

/// Intervals of all parameters.
fn held<const D: usize>(
    case: &Case<D>,
    fit: &Fit<D>,
    bound: &[[f64; 2]],
) -> Result<Vec<Held>, GpError> {
    let one = |((name, truth), [bound, _]): (&(&str, f64), &[f64; 2])| {
        let (interval, estimate) = (fit.interval(name, 0.95)?, fit.parameter(name)?);
        let within = |[lower, upper]: [f64; 2], value: f64| lower <= value && value <= upper;
        Ok(Held {
            interval,
            truth: within(interval, *truth),
            estimate: within(fit.ensemble()?.interval(name, 0.95)?, estimate),
            width: (interval[1] / interval[0]).ln() / (2.0 * TWO_SIDED * bound),
            off: ((estimate / truth).ln() / bound).abs(),
        })
    };
    case.truth.iter().zip(bound).map(one).collect()
}

/// Share of the solution in its 95 % band, over fifty places.
fn band<const D: usize>(case: &Case<D>, fit: &Fit<D>) -> Result<f64, GpError> {
    let inside = case.problem.domain().sample(50, 99)?;
    let band = fit.predict(&inside)?;
    let each = band.mean.iter().zip(&band.standard_deviation).zip(&inside);
    let holds = |((mean, deviation), x): &((&f64, &f64), &[f64; D])| {
        (**mean - case.solution.value(**x)).abs() <= TWO_SIDED * **deviation
    };
    Ok(each.filter(holds).count() as f64 / inside.len() as f64)
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
    let count = outcomes.len() as f64;
    let middle = |of: &dyn Fn(&Outcome) -> f64| median(outcomes.iter().map(of).collect());
    let share = |of: &dyn Fn(&Outcome) -> f64| 100.0 * outcomes.iter().map(of).sum::<f64>() / count;
    let one = |b: bool| f64::from(u8::from(b));
    let row = |(k, (name, _)): (usize, &(&str, f64))| {
        let missed = || outcomes.iter().filter(|o| !o.parameters[k].truth);
        format!(
            "| {} {name} | {:?} | {:.0} | {:.0} | {:.0} | {:.2} | {:.2} | {} ({}) | {} | {withheld} | {:.2} | {:.2} |",
            case.name,
            outcomes[0].evidence,
            share(&|o| one(o.parameters[k].truth)),
            share(&|o| o.u),
            share(&|o| one(o.parameters[k].estimate)),
            middle(&|o| o.parameters[k].width),
            middle(&|o| o.parameters[k].off) / 0.6745,
            missed().count(),
            missed().filter(|o| o.warned).count(),
            outcomes.iter().filter(|o| o.by_nuts).count(),
            middle(&|o| o.fit_seconds),
            middle(&|o| o.interval_seconds),
        )
    };
    Ok(case.truth.iter().enumerate().map(row).collect())
}

/// Options of the command line.
pub(crate) struct Options {
    sets: std::ops::Range<u64>,
    only: Vec<String>,
    evidence: Evidence,
    points: Option<usize>,
}

impl Options {
    pub(crate) fn of_sets(sets: std::ops::Range<u64>) -> Self {
        Self { sets, only: Vec::new(), evidence: Evidence::Auto, points: None }
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

const USAGE: &str = "Coverage of 95 % intervals on twenty problems

Usage: coverage [SETS|FIRST..END] [--only NAME,…] [--evidence joint|unit] [--points N]";

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
    println!("95 % intervals over {} sets", options.sets.clone().count());
    println!(
        "| problem, parameter | evidence | θ held [%] | u held [%] | own [%] | width over Cramér–Rao | error over Cramér–Rao | misses (warned) | by NUTS | withheld | fit [s] | interval [s] |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
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
    study(doubtful::layer(), options)?;
    study(doubtful::three(), options)?;
    study(doubtful::screened(), options)
}
