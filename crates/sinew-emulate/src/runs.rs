//! Emulators of stored runs of any solver: Gaussian processes of numbers or displacements over θ, without a body.

use crate::error::require_usable;
use crate::predict::regression::{
    Conditional, Groups, check_samples, doubts, folds, levels, partitions, points, steps,
};
use crate::store::identity::{Axis, axis};
use crate::store::{check_seal, read_json, seal, write_json};
use crate::{Counter, Design, Error, Observer, PodRegression, Result, Warning};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use sinew_energy::Parameter;
use sinew_mesh::AnyMesh;
use sinew_num::try_in_parallel;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Share of unseen values that intervals are made to hold.
const COVERAGE: f64 = 0.95;
/// Half-width of a 95 % interval of a normal distribution \[standard deviations\].
const NORMAL_WIDTH: f64 = 1.96;
/// Error over deviation that is rounding, and levels that a polynomial meets exactly.
const ROUNDING: f64 = 1e-9;
const FEW_LEVELS: usize = 6;
/// Runs that are learned from at most: time grows with their cube, a prediction with their square.
const MOST_RUNS: usize = 1000;
/// Seed of the order of runs, of the choice among more than [`MOST_RUNS`], and of the places where intervals are compared.
const SEED: u64 = 1;
/// Places of the ranges where intervals are compared.
const PLACES: usize = 256;
const MESH: &str = "mesh.vtu";
/// Stage of a fit, for observers.
const STAGE: &str = "Gaussian processes";

/// Results of stored runs: one number of each, or the displacement of all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name, such as `"volume"`.
    pub name: String,
    /// Unit, `"1"` for numbers without one.
    pub unit: String,
    /// A value for each run: one number, or displacements node by node.
    pub values: Vec<Vec<f64>>,
}

/// Errors of runs that are predicted from the others: each alone among up to fifty runs, a tenth of more at a time, and together where
/// most runs share values of a parameter or are near twins, whichever errors are larger. Length scales and nugget are searched
/// anew where runs are left out alone; groups keep those of all runs. Each run of a group counts as one. Few runs may all lie apart from
/// the places with the largest errors: the error is at least that of normal ones whose 95 % intervals are those of predictions over the ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// Name of the output.
    pub name: String,
    /// Unit of the output.
    pub unit: String,
    /// Number of runs that were learned from.
    pub runs: usize,
    /// Number of parts that were left out in turn.
    pub folds: usize,
    /// Root mean square error, of displacements over nodes \[unit\].
    pub error: f64,
    /// Root mean square of the values about their mean \[unit\].
    pub deviation: f64,
    /// Half-width of a 95 % interval, in standard deviations of the process.
    factor: f64,
    /// Largest half-width over the ranges \[unit\], and the parameters there: where runs are thin.
    #[serde(default)]
    pub widest: (f64, Vec<f64>),
}

impl LeftOut {
    /// R²: one less the share of the variance that is unexplained.
    pub fn r_squared(&self) -> f64 {
        1.0 - (self.error / self.deviation).powi(2)
    }

    /// Summary of an output's errors and the deviations of the process there, a pair for each run, of the groups that were left out.
    fn of(output: &Output, values: &[Vec<f64>], groups: &Groups, errors: &[(f64, f64)]) -> Self {
        let runs = values.len();
        let mean_square = |sum: f64, count| (sum / (count as f64 * nodes(&values[0]))).sqrt();
        let about_mean = |k: usize| {
            let mean = values.iter().map(|value| value[k]).sum::<f64>() / runs as f64;
            values.iter().map(|value| (value[k] - mean).powi(2)).sum::<f64>()
        };
        let mut ratios: Vec<f64> = errors.iter().map(|(error, of)| error.abs() / of).collect();
        ratios.sort_by(f64::total_cmp);
        // The quantile that as many unseen values stay below, were these ratios exchangeable with theirs.
        let rank = (COVERAGE * (ratios.len() + 1) as f64).ceil() as usize;
        // The largest of few is exceeded by more; of a tail as heavy as Cauchy's this brings it to the share.
        let allowance = (1.0 / ((ratios.len() + 1) as f64 * (1.0 - COVERAGE))).max(1.0);
        Self {
            name: output.name.clone(),
            unit: output.unit.clone(),
            runs,
            folds: folds(groups.len()),
            error: mean_square(errors.iter().map(|(error, _)| error * error).sum(), errors.len()),
            deviation: mean_square((0..values[0].len()).map(about_mean).sum(), runs),
            factor: allowance * ratios[rank.min(ratios.len()) - 1],
            widest: Default::default(),
        }
    }

    /// The larger of both errors, and of both widths of intervals.
    fn or_larger(self, other: Self) -> Self {
        let factor = self.factor.max(other.factor);
        Self { factor, ..if other.error > self.error { other } else { self } }
    }

    /// The error and the widest interval over places of the ranges, given by half-width.
    fn over(self, places: Vec<(f64, Vec<f64>)>) -> Self {
        let squares = places.iter().map(|(width, _)| width * width).sum::<f64>();
        let error = self.error.max((squares / places.len() as f64).sqrt() / NORMAL_WIDTH);
        let widest = places.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        Self { error, widest, ..self }
    }
}

/// A predicted output.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// The number, or displacements node by node \[unit of the output\].
    pub values: Vec<f64>,
    /// Half-width of the 95 % interval; of displacements, of their root mean square nodal error \[unit of the output\]. Below 19 runs
    /// the interval is 20/(n + 1) times as wide as the largest of n ratios of error and deviation demands.
    pub half_width: f64,
}

/// An emulated number with the standard deviation of its error, both with derivatives by shares of the ranges of the parameters
/// (0 at the lower end, 1 at the upper one; of the logarithm where runs are spread over it).
#[derive(Clone, Debug, PartialEq)]
pub struct Emulated {
    /// Value \[unit of the output\].
    pub value: f64,
    /// Derivatives of the value.
    pub value_slopes: Vec<f64>,
    /// Standard deviation of its error \[unit of the output\].
    pub deviation: f64,
    /// Derivatives of the standard deviation.
    pub deviation_slopes: Vec<f64>,
}

/// Emulator of stored runs of any solver. Each output is a Gaussian process about a polynomial, with a length scale for each
/// parameter; displacements are decomposed into modes before. It knows no equilibrium, so that its errors are those of
/// runs left out ([`LeftOut`]), and its intervals are as wide as 95 % of these errors demand.
///
/// ```
/// use sinew_emulate::{Output, RunsEmulator};
/// use sinew_energy::Parameter;
///
/// let thetas: Vec<Vec<f64>> = (0..20).map(|i| vec![1.0 + 0.1 * i as f64]).collect();
/// let values = thetas.iter().map(|theta| vec![40.0 + 5.0 / theta[0]]).collect();
/// let volume = Output { name: "volume".into(), unit: "ml".into(), values };
/// let stiffness = Parameter::log("k", "kPa", 1.0..=2.9);
/// let emulator = RunsEmulator::fit(vec![stiffness], &thetas, &[volume], None, &mut ())?;
/// assert!(emulator.left_out()[0].r_squared() > 0.9999);
/// let found = &emulator.predict(&[2.05])?[0];
/// assert!((found.values[0] - (40.0 + 5.0 / 2.05)).abs() < found.half_width.max(1e-9));
/// # Ok::<(), sinew_emulate::Error>(())
/// ```
#[derive(Debug)]
pub struct RunsEmulator {
    /// Parameters, with the ranges of the runs.
    pub parameters: Vec<Parameter>,
    /// Mesh of displacements.
    pub mesh: Option<AnyMesh>,
    /// Effects that the runs do not tell apart, with the runs to add.
    pub warnings: Vec<String>,
    outputs: Vec<(PodRegression, Conditional)>,
    left_out: Vec<LeftOut>,
    /// Correlation of the errors of numbers.
    correlation: Vec<Vec<f64>>,
}

#[derive(Serialize, Deserialize)]
struct Description {
    /// Version of the program, and seed of the order of the runs.
    version: String,
    seed: u64,
    parameters: Vec<Axis>,
    left_out: Vec<LeftOut>,
    /// Version 0.1.0 stored neither of these two.
    #[serde(default)]
    warnings: Vec<String>,
    #[serde(default)]
    correlation: Vec<Vec<f64>>,
}

impl RunsEmulator {
    /// File by which its folder is known.
    pub const FILE: &str = "runs.json";

    /// Fits to `thetas`, one vector of the parameters per run, and outputs; displacements are of a `mesh`. Of more than a thousand
    /// runs a thousand are drawn.
    ///
    /// # Errors
    /// Runs that are too few, differ in length, or hold a value that is not usable; an observer that breaks.
    pub fn fit(
        parameters: Vec<Parameter>,
        thetas: &[Vec<f64>],
        outputs: &[Output],
        mesh: Option<AnyMesh>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let length = mesh.as_ref().map_or(1, |mesh| 3 * mesh.points().len());
        for Output { name, values, .. } in outputs {
            for found in values.iter().map(Vec::len) {
                require_usable(found == length, || {
                    format!("{name} has {found} numbers in a run; give {length}")
                })?;
            }
        }
        // By the numbers of the runs as they were given.
        outputs.iter().try_for_each(|of| check_samples((&parameters, thetas, &of.values)))?;
        // By their places, so that the order of a table changes nothing.
        let rows = points(&parameters, thetas);
        let distances: Vec<f64> = rows.row_iter().map(|row| row.norm()).collect();
        let mut order: Vec<usize> = (0..thetas.len()).collect();
        order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
        order.truncate(MOST_RUNS);
        let drawn = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
            order.iter().map(|&run| rows[run].clone()).collect()
        };
        let thetas = drawn(thetas);
        let points = points(&parameters, &thetas);
        let partitions = partitions(&points);
        let places = Design::LatinHypercube.sample(&parameters, PLACES, SEED)?;
        let count = outputs.len() * steps(&partitions);
        let counter = Mutex::new(Counter::new(observer, STAGE, 0, count));
        let step = || {
            let mut counter = counter.lock().unwrap_or_else(PoisonError::into_inner);
            counter.step(1, "").is_continue().then_some(())
        };
        let fit = |output: &Output| -> Result<_> {
            let values = drawn(&output.values);
            let samples = (&parameters[..], &thetas[..], &values[..]);
            let (regression, errors) = PodRegression::fit_evidence(samples, &partitions, &step)?;
            let conditional = conditional(&regression)?;
            let of = partitions.iter().zip(&errors);
            let left = of.map(|(groups, errors)| LeftOut::of(output, &values, groups, errors));
            let left = left.reduce(LeftOut::or_larger).expect("runs are left out alone");
            let unit = left.factor / nodes(&values[0]).sqrt();
            let width = |at: &Vec<f64>| (unit * regression.deviation(&conditional, at), at.clone());
            let left = left.over(places.iter().map(width).collect());
            require_usable(left.r_squared().is_finite(), || {
                let LeftOut { name, deviation, .. } = &left;
                format!(
                    "the standard deviation of {name} over the runs is {deviation:e}; give values that differ, of order one"
                )
            })?;
            Ok(((regression, conditional), (left, errors.concat())))
        };
        let found = try_in_parallel(outputs, fit);
        let counter = counter.into_inner().unwrap_or_else(PoisonError::into_inner);
        counter.check()?;
        counter.finish("fitted");
        let (outputs, left): (_, Vec<_>) = found?.into_iter().unzip();
        let (left_out, errors): (Vec<_>, Vec<_>) = left.into_iter().unzip();
        let names: Vec<&str> = parameters.iter().map(|parameter| &parameter.name[..]).collect();
        let mut warnings = doubts(&points, &names);
        warnings.extend(met_exactly(&points, &names, &left_out));
        let useless = left_out.iter().filter(|left| left.r_squared() <= 0.0);
        warnings.extend(useless.map(|left| {
            let (name, share) = (&left.name, left.r_squared());
            format!("predictions of {name} are worse than its mean (R² {share:.2}); look for failed runs, other units and parameters that are missing")
        }));
        for concern in &warnings {
            let (stage, concern) = (STAGE.into(), concern.clone());
            observer.warning(&Warning::Training { stage, concern });
        }
        let correlation = correlation(&errors, thetas.len() as f64);
        Ok(Self { parameters, mesh, warnings, outputs, left_out, correlation })
    }

    /// Correlation of the errors of two numbers, by the places of their outputs: that of the errors left out.
    pub fn correlation(&self, one: usize, other: usize) -> f64 {
        match self.correlation.get(one) {
            Some(row) => row[other],
            None => f64::from(u8::from(one == other)),
        }
    }

    /// Modes of displacements with their interpolation over θ; `None` of numbers.
    pub fn regression(&self) -> Option<&PodRegression> {
        self.mesh.as_ref().and_then(|_| self.outputs.first()).map(|(regression, _)| regression)
    }

    /// Errors of runs left out, output by output.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// All outputs at θ.
    ///
    /// # Errors
    /// θ of the wrong length, not finite, or not positive where runs are spread over the logarithm.
    pub fn predict(&self, theta: &[f64]) -> Result<Vec<Predicted>> {
        let predict = |(output, left): (&(PodRegression, Conditional), &LeftOut)| {
            let (regression, conditional) = output;
            let values = regression.predict(theta)?;
            let nodes = nodes(&values);
            let half_width = left.factor * regression.deviation(conditional, theta) / nodes.sqrt();
            Ok(Predicted { values, half_width })
        };
        self.outputs.iter().zip(&self.left_out).map(predict).collect()
    }

    /// Numbers at shares of the ranges of the parameters, by the places of their outputs.
    ///
    /// # Panics
    /// An emulator of displacements, and a place beyond its outputs.
    pub fn at_shares(&self, shares: &[f64], outputs: &[usize]) -> Vec<Emulated> {
        assert!(self.mesh.is_none(), "displacements are no numbers");
        let at = |&place: &usize| {
            let ((regression, conditional), left) = (&self.outputs[place], &self.left_out[place]);
            let [(value, value_slopes), (deviation, slopes)] =
                regression.slopes(conditional, shares);
            let factor = left.factor / NORMAL_WIDTH;
            let deviation_slopes = slopes.iter().map(|slope| factor * slope).collect();
            Emulated { value, value_slopes, deviation: factor * deviation, deviation_slopes }
        };
        outputs.iter().map(at).collect()
    }

    /// Writes a folder that [`RunsEmulator::load`] reads, with checksums of its files.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let description = Description {
            version: env!("CARGO_PKG_VERSION").into(),
            seed: SEED,
            parameters: self.parameters.iter().map(|p| axis(p, p.unit.name())).collect(),
            left_out: self.left_out.clone(),
            warnings: self.warnings.clone(),
            correlation: self.correlation.clone(),
        };
        write_json(&folder.join(Self::FILE), &description)?;
        let mut names = vec![Self::FILE.to_string()];
        for (place, (regression, _)) in self.outputs.iter().enumerate() {
            regression.save(&folder.join(place.to_string()))?;
            names.extend(["regression.json", "modes.npy"].map(|name| format!("{place}/{name}")));
        }
        if let Some(mesh) = &self.mesh {
            mesh.write_vtu(folder.join(MESH)).map_err(|error| Error::Refused(error.to_string()))?;
            names.push(MESH.into());
        }
        seal(folder, names)
    }

    /// Reads what [`RunsEmulator::save`] wrote.
    ///
    /// # Errors
    /// A folder without such an emulator, files that are damaged.
    pub fn load(folder: &Path) -> Result<Self> {
        let Description { parameters, left_out, warnings, correlation, .. } =
            read_json(&folder.join(Self::FILE))?
                .ok_or_else(|| Error::NoEmulator { folder: folder.into() })?;
        let sealed = check_seal(folder)?;
        let parameter = |Axis { name, range: [low, high], unit, logarithmic }| match logarithmic {
            true => Parameter::log(name, unit.as_str(), low..=high),
            false => Parameter::linear(name, unit.as_str(), low..=high),
        };
        let parameters: Vec<Parameter> = parameters.into_iter().map(parameter).collect();
        let output = |place: usize| -> Result<_> {
            let regression = PodRegression::load(&folder.join(place.to_string()), &parameters)?;
            let conditional = conditional(&regression)?;
            Ok((regression, conditional))
        };
        let outputs = try_in_parallel(0..left_out.len(), output)?;
        let read = || sinew_mesh::read(folder.join(MESH)).map(|(mesh, _)| mesh);
        let mesh = sealed.contains_key(MESH).then(read).transpose();
        let mesh = mesh.map_err(|error| Error::Refused(error.to_string()))?;
        Ok(Self { parameters, mesh, warnings, outputs, left_out, correlation })
    }
}

/// Doubts about outputs whose errors are rounding where parameters have few values.
fn met_exactly(points: &DMatrix<f64>, names: &[&str], left_out: &[LeftOut]) -> Vec<String> {
    let few = |d: &usize| levels(points, *d).len() <= FEW_LEVELS;
    let few: Vec<&str> = (0..names.len()).filter(few).map(|d| names[d]).collect();
    let exact = left_out.iter().filter(|left| left.error < ROUNDING * left.deviation);
    let told = |left: &LeftOut| {
        format!(
            "{} is met to rounding, by few values of {}; add runs with others to see its error",
            left.name,
            few.join(", ")
        )
    };
    exact.filter(|_| !few.is_empty()).map(told).collect()
}

/// Correlation of errors over their deviations, by outputs. It is shrunk by `1/n` of n runs, so that it is positive definite. As many outputs as
/// runs or more leave directions without an error: there by the part of the squares that is noise (Schäfer & Strimmer, Stat. Appl. Genet.
/// Mol. Biol. 4, 2005).
fn correlation(errors: &[Vec<(f64, f64)>], runs: f64) -> Vec<Vec<f64>> {
    let ratios = |errors: &Vec<(f64, f64)>| {
        DVector::from_iterator(errors.len(), errors.iter().map(|(error, of)| error / of))
    };
    let ratios: Vec<_> = errors.iter().map(ratios).collect();
    let raw = |[one, other]: [usize; 2]| {
        let [a, b] = [&ratios[one], &ratios[other]];
        a.dot(b) / (a.norm() * b.norm()).max(f64::MIN_POSITIVE)
    };
    let count = errors.len();
    let pairs = (0..count).flat_map(|one| (0..one).map(move |other| raw([one, other]).powi(2)));
    let pairs: Vec<f64> = pairs.collect();
    let noise = pairs.iter().map(|square| (1.0 - square).powi(2) / runs).sum::<f64>();
    let noise = noise / pairs.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let kept = 1.0 - if (count as f64) < runs { 1.0 / runs } else { noise.clamp(1.0 / runs, 1.0) };
    let of = |one, other| if one == other { 1.0 } else { kept * raw([one, other]) };
    (0..count).map(|one| (0..count).map(|other| of(one, other)).collect()).collect()
}

/// Nodes of displacements; 1 of a number.
fn nodes(values: &[f64]) -> f64 {
    (values.len() / 3).max(1) as f64
}

fn conditional(regression: &PodRegression) -> Result<Conditional> {
    let lost =
        "the covariance of the runs cannot be factorised; leave out runs that are nearly the same";
    regression.conditional().ok_or_else(|| Error::Refused(lost.into()))
}
