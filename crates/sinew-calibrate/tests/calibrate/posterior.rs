//! Posteriors of a sphere with an exponential law, whose pressure and volume are a formula, against brute force, and hard cases.

mod bodies;
mod verdict;

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Datum, Forward, ForwardError, Identified, Kind, Observed,
    Posterior, Prior, Problem, Solves, Unknown, Verdict, calibrate, check_identifiability,
};
use sinew_emulate::{Observer, Progress};
use sinew_sample::{quantile, standard_normals};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// Volume in the image \[mL\] and pressure there \[kPa\].
const IMAGE: [f64; 2] = [120.0, 1.0];
/// Pressures of the volumes \[kPa\]; those of the strains are the same.
const PRESSURES: [f64; 5] = [0.0, 0.5, 1.0, 2.0, 3.0];

/// Cavity with p = a (exp(b (V/V₀ − 1)) − 1), of which the image shows the volume at one pressure. Observables: volumes at
/// [`PRESSURES`], then Green–Lagrange strains from the image.
struct Sphere;

impl Forward for Sphere {
    fn parameters(&self) -> usize {
        2
    }

    fn observables(&self) -> usize {
        2 * PRESSURES.len()
    }

    fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
        // Values with derivatives in a and b.
        let (a, b) = (theta[0], theta[1]);
        let stretch = |p: f64| {
            let logarithm = (p / a).ln_1p();
            [1.0 + logarithm / b, -p / (a * (a + p)) / b, -logarithm / (b * b)]
        };
        let image = stretch(IMAGE[1]);
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for p in PRESSURES {
            let now = stretch(p);
            let volume = IMAGE[0] * now[0] / image[0];
            values.push(volume);
            jacobian
                .push([1, 2].map(|i| volume * (now[i] / now[0] - image[i] / image[0])).to_vec());
        }
        for at in 0..PRESSURES.len() {
            let ratio = values[at] / IMAGE[0];
            values.push(0.5 * (ratio.powf(2.0 / 3.0) - 1.0));
            let slope = ratio.powf(-1.0 / 3.0) / (3.0 * IMAGE[0]);
            jacobian.push(jacobian[at].iter().map(|x| slope * x).collect());
        }
        Ok(Observed { values, jacobian })
    }
}

fn unknowns() -> Vec<Unknown> {
    let prior = |low, high| Prior::LogUniform { range: [low, high] };
    vec![Unknown::new("a", "kPa", prior(0.1, 1.0)), Unknown::new("b", "", prior(2.0, 12.0))]
}

fn truth() -> Vec<f64> {
    vec![0.25, 5.0]
}

fn volume(at: usize, value: f64, deviation: f64) -> Datum {
    Datum {
        name: format!("volume at {} kPa", PRESSURES[at]),
        kind: "volume".into(),
        observable: at,
        value,
        deviation,
        is_share: false,
        unit: "mL".into(),
        size: 1.0,
    }
}

fn strain(at: usize, number: usize, value: f64, deviation: f64) -> Datum {
    Datum {
        name: format!("strain {number} at {} kPa", PRESSURES[at]),
        kind: "strain".into(),
        observable: PRESSURES.len() + at,
        value,
        deviation,
        is_share: false,
        unit: String::new(),
        size: 1.0,
    }
}

/// Volumes at three pressures and 24 strains with noise, whose standard deviation is `factor` times the stated one.
fn data(seed: u64, factor: f64) -> Vec<Datum> {
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let noise = standard_normals(27, &mut ChaCha8Rng::seed_from_u64(seed));
    let volumes = [1, 3, 4].into_iter().zip(&noise).map(|(at, z)| {
        let deviation = 0.02 * exact[at];
        volume(at, exact[at] + factor * z * deviation, deviation)
    });
    let strains = noise[3..].iter().enumerate().map(|(number, z)| {
        let at = if number < 12 { 3 } else { 4 };
        strain(at, number, exact[5 + at] + factor * z * 0.02, 0.02)
    });
    volumes.chain(strains).collect()
}

fn run_with(
    data: Vec<Datum>,
    kinds: Vec<Kind>,
    options: &CalibrateOptions,
) -> Result<Posterior, CalibrateError> {
    let problem = Problem::new(unknowns(), data, kinds)?;
    calibrate(&problem, &mut Solves::new(&Sphere), options)
}

fn run(data: Vec<Datum>) -> Posterior {
    run_with(data, Vec::new(), &CalibrateOptions::default()).unwrap()
}

/// Marginals of the logarithms on a grid, by brute force: cells and their probability, for each parameter.
fn grid(data: &[Datum], cells: usize) -> [Vec<f64>; 2] {
    let ends = [[0.1f64, 1.0], [2.0, 12.0]].map(|range| range.map(f64::ln));
    let at = |parameter: usize, cell: f64| {
        let [low, high] = ends[parameter];
        (low + (high - low) * (cell + 0.5) / cells as f64).exp()
    };
    let mut found = [vec![0.0; cells], vec![0.0; cells]];
    for i in 0..cells {
        for j in 0..cells {
            let theta = [at(0, i as f64), at(1, j as f64)];
            let seen = Sphere.observe(&theta, false).unwrap().values;
            let misfit = |d: &Datum| ((d.value - seen[d.observable]) / d.deviation).powi(2);
            let likelihood = (-0.5 * data.iter().map(misfit).sum::<f64>() + 10.0).exp();
            found[0][i] += likelihood;
            found[1][j] += likelihood;
        }
    }
    for marginal in &mut found {
        let sum: f64 = marginal.iter().sum();
        marginal.iter_mut().for_each(|x| *x /= sum);
    }
    found
}

/// Mean and standard deviation in cells.
fn moments(marginal: &[f64]) -> [f64; 2] {
    let mean: f64 = marginal.iter().enumerate().map(|(i, p)| i as f64 * p).sum();
    let square: f64 = marginal.iter().enumerate().map(|(i, p)| (i as f64 - mean).powi(2) * p).sum();
    [mean, square.sqrt()]
}

/// Total variation of the draws from the grid's marginal over twelve bins, and the errors of mean and standard deviation, both in
/// standard deviations, given the data of seed 3.
fn distances(posterior: &Posterior, parameter: usize) -> [f64; 3] {
    const CELLS: usize = 1200;
    static EXACT: OnceLock<[Vec<f64>; 2]> = OnceLock::new();
    let exact = &EXACT.get_or_init(|| grid(&data(3, 1.0), CELLS))[parameter];
    let [low, high] = posterior.problem.unknowns[parameter].prior.range().map(f64::ln);
    let mut draws = vec![0.0; CELLS];
    let all = posterior.draws.parameter(parameter).concat();
    for theta in &all {
        let cell = ((theta.ln() - low) / (high - low) * CELLS as f64) as usize;
        draws[cell.min(CELLS - 1)] += 1.0 / all.len() as f64;
    }
    let [mean, deviation] = moments(exact);
    let [own_mean, own_deviation] = moments(&draws);
    // Bins of equal probability.
    let (mut sum, mut bins) = (0.0, vec![[0.0, 0.0]; 12]);
    for (p, q) in exact.iter().zip(&draws) {
        let bin = ((sum + 0.5 * p) * 12.0) as usize;
        sum += p;
        bins[bin.min(11)][0] += p;
        bins[bin.min(11)][1] += q;
    }
    let variation = 0.5 * bins.iter().map(|[p, q]| (p - q).abs()).sum::<f64>();
    [variation, (own_mean - mean).abs() / deviation, (own_deviation / deviation - 1.0).abs()]
}

#[test]
fn the_posterior_is_that_of_a_grid() {
    // 2400 draws: the total variation of so many over twelve bins is .02.
    let options = CalibrateOptions { draws: 2400, steps: 4000, ..CalibrateOptions::default() };
    let posterior = run_with(data(3, 1.0), Vec::new(), &options).unwrap();
    let [r_hat, bulk, tail] = posterior.coordinates.mixing();
    assert!(r_hat < 1.01 && bulk > 400.0 && tail > 400.0, "{r_hat} {bulk} {tail}");
    for parameter in 0..2 {
        let [variation, mean, deviation] = distances(&posterior, parameter);
        assert!(
            variation <= 0.05 && mean <= 0.1 && deviation <= 0.05,
            "{variation} {mean} {deviation}"
        );
    }
    let correction = &posterior.correction;
    assert!(correction.k_hat <= 0.5 && correction.acceptance > 0.9, "{correction:?}");
    assert!(posterior.predictive.in_words().is_empty(), "{:?}", posterior.predictive);
}

#[test]
fn a_bad_emulator_is_seen_and_corrected_or_refused() {
    let bad = CalibrateOptions {
        starts: 1,
        design: 4,
        degree: 1,
        draws: 2400,
        steps: 4000,
        ..CalibrateOptions::default()
    };
    match run_with(data(3, 1.0), Vec::new(), &bad) {
        Err(CalibrateError::Unconfirmed(reached)) => {
            assert!(reached.k_hat > 0.5 || reached.share < 0.5, "{reached:?}");
        }
        Err(other) => panic!("{other}"),
        Ok(posterior) => {
            assert!(posterior.correction.largest_error > 0.1, "{:?}", posterior.correction);
            for parameter in 0..2 {
                let [variation, mean, deviation] = distances(&posterior, parameter);
                assert!(
                    variation <= 0.06 && mean <= 0.1 && deviation <= 0.07,
                    "{variation} {mean} {deviation}"
                );
            }
        }
    }
}

#[test]
fn standard_deviations_that_are_too_small_are_named_where_there_is_no_posterior() {
    // A hundred times below the noise of the data.
    let mut tiny = data(3, 1.0);
    tiny.iter_mut().for_each(|datum| datum.deviation *= 0.01);
    let few = CalibrateOptions { design: 4, rounds: 1, degree: 1, ..CalibrateOptions::default() };
    let said = match run_with(tiny, Vec::new(), &few) {
        Ok(posterior) => posterior.predictive.in_words().pop().unwrap_or_default(),
        Err(error) => error.to_string(),
    };
    assert!(said.contains("standard deviation"), "{said}");
    assert!(said.contains("too small") || said.contains("at its standard deviation"), "{said}");
}

#[test]
fn a_volume_at_the_pressure_of_the_image_returns_the_prior() {
    let posterior = run(vec![volume(2, 121.0, 2.0)]);
    for parameter in 0..2 {
        assert_eq!(posterior.identified(parameter), Identified::No);
        let shares: Vec<f64> = posterior.coordinates.parameter(parameter).concat();
        // Quantiles of a standard normal prior within four standard errors of 480 draws.
        assert!(
            (quantile(&shares, 0.025) + 1.96).abs() < 0.5 && quantile(&shares, 0.5).abs() < 0.25
        );
    }
    let said = posterior.identifiability.in_words();
    assert!(said[0].contains("identify none of the 2 directions"), "{said:?}");
    assert!(said.iter().any(|s| s.starts_with("a by itself is not identified")), "{said:?}");
    // After sampling the draws say it.
    let said = posterior.identifiability.directions_in_words();
    assert!(!said.iter().any(|s| s.contains("by itself")) && said.len() == 3, "{said:?}");
}

#[test]
fn volumes_alone_are_wide_and_it_is_said_in_words() {
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let posterior = run([1, 3, 4].map(|at| volume(at, exact[at], 0.03 * exact[at])).to_vec());
    let said = posterior.identifiability.in_words();
    assert!(said[0].contains("identify 1 of 2 directions"), "{said:?}");
    assert!(said.iter().any(|s| s.contains("not identified") || s.contains("weakly")), "{said:?}");
    assert!((0..2).any(|at| posterior.identified(at) != Identified::Yes));
}

#[test]
fn a_volume_that_falls_while_pressure_rises_is_named() {
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let falling = [(1, exact[1]), (3, exact[4]), (4, 0.97 * exact[3])];
    let posterior = run(falling.map(|(at, value)| volume(at, value, 0.015 * value)).to_vec());
    let named: Vec<_> = posterior.predictive.contradicting().map(|d| d.name.as_str()).collect();
    assert!(named.contains(&"volume at 3 kPa"), "{:?}", posterior.predictive);
    let said = posterior.predictive.in_words();
    assert!(said[0].contains("contradicts the other data"), "{said:?}");
}

#[test]
fn noise_that_is_wrong_by_two_is_flagged_and_inferred_noise_holds() {
    let small = run(data(5, 2.0));
    assert!(small.predictive.p_overall < 0.01, "{}", small.predictive.p_overall);
    assert!(small.predictive.in_words().iter().any(|s| s.contains("larger than the stated noise")));
    let factor = small.predictive.misfit;
    assert!((1.6..2.5).contains(&factor), "{factor}");
    let said = small.predictive.in_words().pop().unwrap();
    assert!(said.contains(&format!("by a factor of {factor:.1}")), "{said}");
    // Three times: a datum is out of reach, for that reason.
    let plain = CalibrateOptions::default();
    let error = run_with(data(5, 3.0), Vec::new(), &plain).unwrap_err().to_string();
    assert!(
        error.contains("times the stated noise: the standard deviations are too small"),
        "{error}"
    );
    let large = run(data(5, 0.5));
    assert!(large.predictive.p_overall > 0.99, "{}", large.predictive.p_overall);
    let inferred = |name: &str| Kind { name: name.into(), inferred: true, bias: 0.0 };
    let options = CalibrateOptions::default();
    let kinds = vec![inferred("strain"), inferred("volume")];
    let posterior = run_with(data(5, 2.0), kinds, &options).unwrap();
    assert!(posterior.predictive.p_overall > 0.01, "{}", posterior.predictive.p_overall);
    assert_eq!(posterior.heads()[2], "noise factor of strain");
    let [low, _, high] = posterior.summary(2).quantiles;
    assert!(low < 2.0 && 2.0 < high && low > 1.1, "{low} {high}");
    assert!(posterior.coordinates.mixing()[0] < 1.02);
}

#[test]
fn a_volume_below_every_reachable_one_says_the_smallest() {
    let mut low = data(3, 1.0);
    low.truncate(2);
    low.push(volume(4, 60.0, 1.0));
    let error = run_with(low, Vec::new(), &CalibrateOptions::default()).unwrap_err().to_string();
    assert!(error.contains("volume at 3 kPa is 60") && error.contains("the smallest"), "{error}");
}

#[test]
fn a_parameter_at_its_bound_stays_inside() {
    let exact = Sphere.observe(&[0.1, 5.0], false).unwrap().values;
    let data = (0..5).map(|at| volume(at, exact[at], 0.005 * exact[at])).collect::<Vec<_>>();
    let posterior = run(data);
    let a = posterior.draws.parameter(0).concat();
    assert!(a.iter().all(|a| (0.1..=1.0).contains(a)));
    // The bound itself is the likeliest value.
    assert!(quantile(&a, 0.1) < 0.12, "{}", quantile(&a, 0.1));
    assert!(posterior.correction.k_hat <= 0.5);
}

#[test]
fn bad_data_are_refused_in_words() {
    let refused = |data| Problem::new(unknowns(), data, Vec::new()).unwrap_err().to_string();
    assert!(
        refused(vec![volume(1, f64::NAN, 1.0)]).contains("volume at 0.5 kPa: the value is NaN")
    );
    assert!(refused(vec![volume(1, 100.0, 0.0)]).contains("standard deviation is 0"));
    assert!(refused(Vec::new()).contains("no data"));
    let wrong = Unknown::new("a", "", Prior::LogUniform { range: [1.0, 1.0] });
    let error = Problem::new(vec![wrong], data(1, 1.0), Vec::new()).unwrap_err().to_string();
    assert!(error.contains("0 < low < high"), "{error}");
}

#[test]
fn threads_and_the_order_of_data_change_nothing() {
    let on = |threads: usize, data: Vec<Datum>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(data)).draws
    };
    let mut backwards = data(3, 1.0);
    backwards.reverse();
    assert_eq!(on(1, data(3, 1.0)), on(2, backwards));
}

#[test]
fn a_run_that_was_killed_goes_on_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solves.csv");
    let problem = Problem::new(unknowns(), data(3, 1.0), Vec::new()).unwrap();
    let options = CalibrateOptions::default();
    let solves = |resume| Solves::new(&Sphere).kept_in(&path, "sphere", resume);
    let whole = calibrate(&problem, &mut solves(false).unwrap(), &options).unwrap();
    // Killed in the middle of a line.
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() / 3]).unwrap();
    let again = calibrate(&problem, &mut solves(true).unwrap(), &options).unwrap();
    assert_eq!((&whole.draws, whole.correction.solves), (&again.draws, again.correction.solves));
    // A digit in each line is another: these are solved again. So are lines that are not text.
    let text = std::fs::read_to_string(&path).unwrap();
    let damaged: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(at, line)| match at {
            0 => line.to_string(),
            _ => line.replacen('3', "4", 1),
        })
        .collect();
    let damaged = [damaged.join("\n").as_bytes(), b"\n\xff\xfe;0\n"].concat();
    std::fs::write(&path, damaged).unwrap();
    let again = calibrate(&problem, &mut solves(true).unwrap(), &options).unwrap();
    assert_eq!((whole.draws, whole.correction.solves), (again.draws, again.correction.solves));
    // Two runs do not share a file.
    let first = solves(true).unwrap();
    for resume in [true, false] {
        let error = solves(resume).err().unwrap().to_string();
        assert!(error.contains("another run keeps its solves here"), "{error}");
    }
    drop(first);
    let other = Solves::new(&Sphere).kept_in(&path, "cube", true);
    assert!(other.err().unwrap().to_string().contains("another patient"));
}

/// Breaks after the first solves.
struct Impatient;
impl Observer for Impatient {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        if progress.fraction > 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn an_observer_ends_a_calibration() {
    let problem = Problem::new(unknowns(), data(3, 1.0), Vec::new()).unwrap();
    let mut impatient = Impatient;
    let mut solves = Solves::new(&Sphere);
    solves.observer = Some(&mut impatient);
    let error = calibrate(&problem, &mut solves, &CalibrateOptions::default()).unwrap_err();
    assert!(matches!(error, CalibrateError::NoPosterior(_)), "{error}");
    assert!(error.to_string().starts_with("interrupted during "), "{error}");
}

#[test]
fn likelihoods_of_the_data_are_those_of_their_errors() {
    let posterior = run(data(3, 1.0));
    let found = posterior.log_likelihood();
    let (y, seen) = (&posterior.coordinates.draws[1][7], &posterior.observed.draws[1][7]);
    for (datum, found) in posterior.problem.data.iter().zip(&found[1][7]) {
        let misfit = (datum.value - seen[datum.observable]) / datum.deviation;
        let density =
            -0.5 * misfit * misfit - (datum.deviation * std::f64::consts::TAU.sqrt()).ln();
        assert!((density - found).abs() < 1e-12 * density.abs().max(1.0), "{}", datum.name);
    }
    // Independent errors: they add up to the likelihood, but for a constant.
    let sum = |chain: usize, draw: usize| -> f64 {
        let y = &posterior.coordinates.draws[chain][draw];
        let observed = Observed {
            values: posterior.observed.draws[chain][draw].clone(),
            jacobian: Vec::new(),
        };
        let prior = -0.5 * y.iter().map(|y| y * y).sum::<f64>();
        posterior.problem.log_posterior(y, &observed)
            - prior
            - found[chain][draw].iter().sum::<f64>()
    };
    assert!((sum(1, 7) - sum(0, 3)).abs() < 1e-9, "{y:?}");
    // An error of 3 that two volumes share: each given the other is normal, by the formula for two variables.
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let pair = [3, 4].map(|at| volume(at, exact[at] + 1.0, 2.0)).to_vec();
    let bias = Kind { name: "volume".into(), inferred: false, bias: 3.0 };
    let posterior = run_with(pair, vec![bias], &CalibrateOptions::default()).unwrap();
    let found = &posterior.log_likelihood()[0][0];
    let misfit = |at: usize| {
        let datum = &posterior.problem.data[at];
        datum.value - posterior.observed.draws[0][0][datum.observable]
    };
    // Variances 4 + 9, covariance 9.
    let variance: f64 = 13.0 - 81.0 / 13.0;
    let given = misfit(0) - 9.0 / 13.0 * misfit(1);
    let density = -0.5 * (given * given / variance + (std::f64::consts::TAU * variance).ln());
    assert!((found[0] - density).abs() < 1e-9, "{} {density}", found[0]);
}
