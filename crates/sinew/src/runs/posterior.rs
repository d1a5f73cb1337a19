//! Posterior of the parameters of stored runs, given measured values of their outputs, by the emulator alone.

use crate::case::advise;
use crate::report::format::{digits, digits_beside};
use crate::theta::{heads, values_in_words};
use serde::Deserialize;
use sinew_calibrate::{CalibrateError, Identified, Surrogate};
use sinew_emulate::{Counter, Observer, RunsEmulator};
use sinew_energy::Unit;
use sinew_sample::{ArvizDict, Chains, Laplace, NutsOptions, effective_share, nuts_from, psis};
use statrs::distribution::{ContinuousCDF, Normal};
use std::sync::{Mutex, PoisonError};

/// R̂ above which chains disagree.
const DISAGREE: f64 = 1.05;
/// Misfits at the mode \[standard deviations\] from which on a value is doubtful, and refused.
const DOUBTFUL: f64 = 3.0;
const OUT_OF_REACH: f64 = 5.0;
/// Standard deviation of a measurement over that of the emulator below which chains would follow the surface of the emulator's error alone.
const EXACT: f64 = 1e-3;
/// Effective share of importance weights above which they hardly differ.
const EQUAL: f64 = 0.99;
/// Share of a range next to an end. If more draws are there than in the next such share, by this factor, the posterior goes on beyond it.
const EDGE: f64 = 0.05;
const RISING: f64 = 1.5;
/// Draws of a chain.
const DRAWS: std::ops::RangeInclusive<usize> = 100..=250_000;

/// A measured value of an output.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Name of the output.
    pub output: String,
    /// Value \[unit of the output\].
    pub value: f64,
    /// Standard deviation of its error \[unit of the output\].
    pub sd: f64,
}

/// Draws of parameters given measured values. The prior is uniform over the ranges of the runs, over their logarithm for
/// parameters that are spread over it. The covariance of the emulator's errors is added to the variances of the measurements. No solver confirms it.
///
/// ```
/// use sinew::emulate::{Output, RunsEmulator};
/// use sinew::Parameter;
/// use sinew::runs::{Measured, RunsPosterior};
///
/// let thetas: Vec<Vec<f64>> = (0..20).map(|i| vec![1.0 + 0.1 * i as f64]).collect();
/// let values = thetas.iter().map(|theta| vec![40.0 + 5.0 / theta[0]]).collect();
/// let volume = Output { name: "volume".into(), unit: "ml".into(), values };
/// let stiffness = Parameter::log("k", "kPa", 1.0..=2.9);
/// let emulator = RunsEmulator::fit(vec![stiffness], &thetas, &[volume], None, &mut ())?;
/// let datum = Measured { output: "volume".into(), value: 42.5, sd: 0.05 };
/// let posterior = RunsPosterior::new(&emulator, &[datum], &Default::default(), &mut ())?;
/// assert!((posterior.draws.summary(0).mean - 2.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RunsPosterior {
    /// Parameters by chain and draw.
    pub draws: Chains,
    /// Outputs of the data by chain and draw, each before its standard deviation by the emulator.
    outputs: Chains,
    /// Logarithm of the likelihood of each datum by chain and draw.
    log_likelihoods: Chains,
    /// Logarithm of the weight of each draw in the posterior of an emulator without errors.
    log_weights: Chains,
    /// Parameters in coordinates whose prior is standard normal.
    coordinates: Chains,
    /// Reasons for mistrust.
    pub warnings: Vec<String>,
    /// Standard deviations of the emulator at the mode, by the data.
    errors: Vec<f64>,
    data: Vec<Measured>,
    units: Vec<Unit>,
    heads: Vec<String>,
}

impl RunsPosterior {
    /// Draws by NUTS, from the modes that Levenberg's and Marquardt's method finds. The observer hears of every draw, and may end it.
    ///
    /// # Errors
    /// An output that the emulator does not have, that is there twice or of displacements; a value or standard deviation that is not usable; a
    /// value that the most likely parameters miss by five standard deviations; fewer than 100 draws a chain; chains that disagree; an observer that breaks.
    pub fn new(
        emulator: &RunsEmulator,
        data: &[Measured],
        options: &NutsOptions,
        observer: &mut dyn Observer,
    ) -> Result<Self, CalibrateError> {
        if !DRAWS.contains(&options.draws) {
            let (given, [least, most]) = (options.draws, [DRAWS.start(), DRAWS.end()]);
            let few = format!("{given} draws a chain; give {least} to {most}");
            return Err(CalibrateError::Input(few));
        }
        let target = Target::new(emulator, data).map_err(CalibrateError::Input)?;
        let density = &target.density;
        let modes = density.modes(options.seed);
        let chains = CalibrateError::NoPosterior;
        let nowhere = "the density is not finite anywhere in the prior";
        let (best, precision) = modes.first().ok_or_else(|| chains(nowhere.into()))?;
        let mut warnings = emulator.warnings.clone();
        warnings.extend(target.judge(best).map_err(CalibrateError::Input)?);
        let about = Laplace::from_precision(best, precision.clone())?;
        let starts: Vec<_> = modes.iter().map(|(y, _)| y.clone()).collect();
        let options = NutsOptions { chains: options.chains.max(starts.len()), ..*options };
        let steps = options.chains * (options.warmup + options.draws);
        let counter = Mutex::new(Counter::new(observer, "draw the posterior", 0, steps));
        let told = || counter.lock().unwrap_or_else(PoisonError::into_inner).step(1, "");
        let coordinates = nuts_from(density, &about, &starts, &options, &told)?;
        counter.into_inner().unwrap_or_else(PoisonError::into_inner).finish("done");
        target.agree(&coordinates, &starts).map_err(chains)?;
        warnings.extend(target.ends(&coordinates));
        let values =
            |y: &[f64]| density.at(y).iter().flat_map(|of| [of.value, of.deviation]).collect();
        let left = emulator.left_out();
        let outputs = coordinates.mapped(values);
        let found = outputs.mapped(|outputs| density.log_likelihoods(outputs));
        Ok(Self {
            log_likelihoods: found.mapped(|all| all[..data.len()].to_vec()),
            log_weights: found.mapped(|all| all[data.len()..].to_vec()),
            outputs,
            errors: density.at(best).iter().map(|of| of.deviation).collect(),
            draws: coordinates.mapped(|y| density.theta(y)),
            warnings,
            data: data.to_vec(),
            units: target.places.iter().map(|&place| left[place].unit.as_str().into()).collect(),
            heads: heads(&emulator.parameters),
            coordinates,
        })
    }

    /// Parameters with median and 95 % interval, data beside their predictions, and how the chains mixed.
    pub fn in_words(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (place, head) in self.heads.iter().enumerate() {
            let found = self.draws.summary(place);
            let identified = Identified::of(self.coordinates.summary(place).deviation);
            let [low, median, high] = found.quantiles.map(|value| digits(value, 3));
            lines.push(match identified {
                Identified::No => format!("{head}: {}", identified.in_words()),
                _ => format!("{head}: {median} ({low} to {high}), {}", identified.in_words()),
            });
        }
        for (place, (datum, unit)) in self.data.iter().zip(&self.units).enumerate() {
            let found = self.outputs.summary(2 * place);
            let sd = found.deviation.hypot(self.errors[place]);
            let told = |value, sd| [digits_beside(value, sd, 3), digits(sd, 3)];
            let [[mean, sd], [value, own]] = [told(found.mean, sd), told(datum.value, datum.sd)];
            let (name, unit) = (&datum.output, unit.suffix());
            lines.push(format!("{name}: measured {value} ± {own}{unit}, emulated {mean} ± {sd}"));
        }
        let [r_hat, bulk, tail] = self.coordinates.mixing();
        let ess = bulk.min(tail);
        lines.push(format!("R̂ {r_hat:.3}, {ess:.0} effective draws; no solver has confirmed it"));
        let weights: Vec<f64> = self.log_weights.pooled().map(|weight| weight[0]).collect();
        let share = effective_share(&weights);
        lines.extend((share < EQUAL).then(|| {
            let k_hat = psis(&weights, bulk / weights.len() as f64).k_hat;
            format!("without the error of the emulator the draws have an effective share of {share:.2}, Pareto k̂ {k_hat:.2}")
        }));
        lines
    }

    /// Draws of parameters as columns with names, by chain.
    pub fn columns(&self) -> Vec<(String, Vec<Vec<f64>>)> {
        let heads = self.heads.iter().enumerate();
        heads.map(|(place, head)| (head.clone(), self.draws.parameter(place))).collect()
    }

    /// Groups for `arviz`: parameters and outputs of the posterior, the data, and the likelihood of each given the others,
    /// with errors of measurement and emulator.
    pub fn to_arviz(&self) -> ArvizDict {
        let columns = self.columns().into_iter();
        let mut dict = columns
            .fold(ArvizDict::default(), |dict, (head, draws)| dict.with("posterior", &head, draws));
        for (place, (datum, unit)) in self.data.iter().zip(&self.units).enumerate() {
            let head = unit.head(&datum.output);
            dict = dict.with("posterior", &head, self.outputs.parameter(2 * place));
            dict = dict.with_observed(&head, datum.value);
        }
        let weights = self.log_weights.parameter(0);
        let dict = dict.with("sample_stats", "log_weight_without_emulator_error", weights);
        let labels = self.data.iter().zip(&self.units).map(|(d, unit)| unit.head(&d.output));
        let chains = self.log_likelihoods.draws.clone();
        dict.with_log_likelihood(labels.collect(), chains)
    }
}

/// The posterior density with the names of its data.
struct Target<'a> {
    emulator: &'a RunsEmulator,
    data: &'a [Measured],
    density: Surrogate<'a>,
    /// Places of the data among the outputs.
    places: Vec<usize>,
}

impl<'a> Target<'a> {
    fn new(emulator: &'a RunsEmulator, data: &'a [Measured]) -> Result<Self, String> {
        if emulator.mesh.is_some() {
            return Err("displacements cannot be calibrated; emulate numbers of the runs".into());
        }
        if data.is_empty() {
            return Err("there are no data; add [[data]] with output, value and sd".into());
        }
        let names = || emulator.left_out().iter().map(|left| left.name.as_str());
        for (number, Measured { output, .. }) in data.iter().enumerate() {
            if data[..number].iter().any(|other| other.output == *output) {
                return Err(format!("`{output}` is there twice; give one value with its sd"));
            }
        }
        let place = |datum: &Measured| {
            let Measured { output, value, sd } = datum;
            if !(value.is_finite() && sd.is_finite() && *sd > 0.0) {
                return Err(format!(
                    "{output}: {value} ± {sd}; give a finite value and a positive sd"
                ));
            }
            names().position(|name| name == output).ok_or_else(|| {
                let advice = advise(output, names(), "the outputs are");
                format!("there is no output `{output}`{advice}")
            })
        };
        let places: Vec<usize> = data.iter().map(place).collect::<Result<_, _>>()?;
        let data_at = places.iter().zip(data).map(|(&place, of)| (place, of.value, of.sd));
        let density = Surrogate::new(emulator, data_at.collect());
        Ok(Self { emulator, data, density, places })
    }

    /// Warnings about the data at the mode; refuses a value that it misses.
    fn judge(&self, y: &[f64]) -> Result<Vec<String>, String> {
        let mut warnings = Vec::new();
        for (datum, found) in self.data.iter().zip(self.density.at(y)) {
            let Measured { output, value, sd } = datum;
            let misfit = ((value - found.value) / sd.hypot(found.deviation)).abs();
            let said = format!(
                "{output}: {value} is {misfit:.1} standard deviations from {}, the value at the most likely parameters",
                digits_beside(found.value, *sd, 4)
            );
            if misfit > OUT_OF_REACH {
                let at = values_in_words(&self.emulator.parameters, &self.density.theta(y));
                return Err(format!(
                    "{said} ({at}); look at its unit and at the other data, or add runs"
                ));
            }
            warnings.extend((misfit > DOUBTFUL).then_some(said));
            if *sd < EXACT * found.deviation {
                return Err(format!(
                    "{output}: an sd of {sd:e} is too small beside the error of the emulator, {:.1e}; give at least {EXACT} of that",
                    found.deviation
                ));
            }
            if found.deviation > *sd {
                warnings.push(format!(
                    "the error of the emulator of {output}, {}, exceeds that of the measurement; more runs make the posterior narrower",
                    digits(found.deviation, 2)
                ));
            }
        }
        Ok(warnings)
    }

    /// Requires chains that agree.
    fn agree(&self, coordinates: &Chains, modes: &[Vec<f64>]) -> Result<(), String> {
        let parameters = &self.emulator.parameters;
        for (place, parameter) in parameters.iter().enumerate() {
            let r_hat = coordinates.summary(place).r_hat;
            // A NaN disagrees as well.
            if r_hat <= DISAGREE {
                continue;
            }
            let likely = |y: &Vec<f64>| values_in_words(parameters, &self.density.theta(y));
            let cure = match modes {
                [_] => "draw more".into(),
                _ => {
                    let likely = modes.iter().map(likely).collect::<Vec<_>>().join("; ");
                    format!("likely are {likely}: add data that tell these apart")
                }
            };
            return Err(format!("chains disagree about {}, R̂ {r_hat:.2}; {cure}", parameter.name));
        }
        Ok(())
    }

    /// Warnings about ends of ranges towards which the posterior rises.
    fn ends(&self, coordinates: &Chains) -> Vec<String> {
        let normal = Normal::standard();
        let rises = |place: usize| {
            let shares = coordinates.pooled().map(|y| normal.cdf(y[place]));
            let mut counts = [[0.0; 2]; 2];
            for share in shares {
                for (counts, from_end) in counts.iter_mut().zip([share, 1.0 - share]) {
                    if from_end < 2.0 * EDGE {
                        counts[usize::from(from_end >= EDGE)] += 1.0;
                    }
                }
            }
            let least = EDGE * coordinates.pooled().count() as f64;
            counts.iter().any(|[outer, next]| *outer > least && *outer > RISING * next)
        };
        let names = self.emulator.parameters.iter().map(|parameter| &parameter.name);
        let rising = names.enumerate().filter(|(place, _)| rises(*place));
        rising
            .map(|(_, name)| format!("{name} is most likely at an end of its range in the runs; runs beyond it may be more likely"))
            .collect()
    }
}
