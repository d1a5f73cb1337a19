//! Designs of the parameter sets of simulations.

pub(crate) mod block;
pub(crate) mod campaign;
pub(crate) mod simulate;

use crate::{Error, Result};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use sinew_energy::{Parameter, Sampling};

/// Distribution of samples over the box that the parameters' ranges span, each on the scale of its
/// [`Sampling`].
///
/// ```
/// use sinew_emulate::Design;
/// use sinew_energy::Parameter;
///
/// let stiffness = Parameter::log("mu", "kPa", 1.0..=100.0);
/// let thetas = Design::LatinHypercube.sample(&[stiffness], 10, 1)?;
/// let below = thetas.iter().filter(|theta| theta[0] < 10.0).count();
/// assert_eq!(below, 5); // half of the logarithmic range
/// # Ok::<(), sinew_emulate::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// Every range is cut into as many slices as there are samples, and each slice holds one sample (McKay et al.
    /// 1979, thesis §3.3.1).
    #[doc(alias = "LHS")]
    #[default]
    LatinHypercube,
    /// Sobol's sequence with Owen's scrambling (Burley 2020): more even than a hypercube, and the first samples are
    /// themselves a design.
    Sobol,
    /// Independent and uniform: what errors are tested with.
    Uniform,
}

/// Seed of one seed stream, derived from `seed`.
pub fn split_seed(seed: u64, stream: u64) -> u64 {
    // The golden ratio in 64 bits: neighbouring seeds do not share streams.
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ stream
}

/// Samples and parameters that Sobol's sequence is tabulated for.
const SOBOL_LIMITS: [usize; 2] = [1 << 16, sobol_burley::NUM_DIMENSIONS as usize];

impl Design {
    /// `count` values of θ. Same seed, same values.
    ///
    /// # Errors
    /// A range that is empty, or not positive on a logarithmic scale; more than Sobol's sequence is tabulated for.
    pub fn sample(
        self,
        parameters: &[Parameter],
        count: usize,
        seed: u64,
    ) -> Result<Vec<Vec<f64>>> {
        parameters.iter().try_for_each(check)?;
        let shares = match self {
            Self::LatinHypercube => latin_hypercube(count, parameters.len(), seed),
            Self::Sobol => sobol(count, parameters.len(), seed)?,
            Self::Uniform => uniform(count, parameters.len(), seed),
        };
        let theta = |shares: Vec<f64>| {
            parameters.iter().zip(shares).map(|(p, share)| p.at_share(share)).collect()
        };
        Ok(shares.into_iter().map(theta).collect())
    }
}

/// The share of a parameter's range at which a value lies, on the scale of its sampling: within 0 and 1 inside, the inverse of [`Parameter::at_share`]. NaN where
/// the scale has no such value.
pub fn share_of(parameter: &Parameter, value: f64) -> f64 {
    let [low, high] = parameter.range;
    match parameter.sampling {
        Sampling::Log => (value / low).ln() / (high / low).ln(),
        Sampling::Linear => (value - low) / (high - low),
    }
}

/// Width √12 of the uniform distribution of variance one.
pub(crate) const WIDTH: f64 = 3.464_101_615_137_754_6;
/// Share within which a value counts as inside its range: rounding of a bound that went through a logarithm or a text file.
const SLACK: f64 = 1e-9;

/// Whether a value is inside its range, but for rounding.
pub fn is_inside(parameter: &Parameter, value: f64) -> bool {
    let [low, high] = parameter.range;
    (low..=high).contains(&value) || (-SLACK..=1.0 + SLACK).contains(&share_of(parameter, value))
}

fn check(parameter: &Parameter) -> Result<()> {
    let [low, high] = parameter.range;
    let positive = parameter.sampling == Sampling::Linear || low > 0.0;
    match low.is_finite() && high.is_finite() && low < high && positive {
        true => Ok(()),
        false => Err(Error::Samples(format!(
            "parameter {} ranges from {low} to {high}: give a smaller and a larger finite value, both positive where samples are uniform in the logarithm",
            parameter.name
        ))),
    }
}

fn latin_hypercube(count: usize, axes: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut points = vec![vec![0.0; axes]; count];
    for axis in 0..axes {
        let mut slices: Vec<usize> = (0..count).collect();
        slices.shuffle(&mut rng);
        for (point, slice) in points.iter_mut().zip(slices) {
            point[axis] = (slice as f64 + rng.random::<f64>()) / count as f64;
        }
    }
    points
}

fn uniform(count: usize, axes: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| (0..axes).map(|_| rng.random()).collect()).collect()
}

fn sobol(count: usize, axes: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
    let [most, most_axes] = SOBOL_LIMITS;
    if count > most || axes > most_axes {
        return Err(Error::Samples(format!(
            "Sobol's sequence is tabulated for {most} samples of {most_axes} parameters; {count} of {axes} are too many, use a Latin hypercube"
        )));
    }
    let seed = (seed ^ (seed >> 32)) as u32;
    let at = |index: usize, axis: usize| {
        f64::from(sobol_burley::sample(index as u32, axis as u32, seed))
    };
    Ok((0..count).map(|index| (0..axes).map(|axis| at(index, axis)).collect()).collect())
}
