//! Parameters that the data determine, linearised at the mode before sampling.

use crate::predictive::UNLIKELY;
use crate::{Mode, Problem};
use nalgebra::{DMatrix, SymmetricEigen};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Ratio of posterior to prior standard deviation, above which the data do not determine a parameter.
const UNIDENTIFIED: f64 = 0.9;
/// Ratio of posterior to prior standard deviation, up to which the data determine a parameter.
const IDENTIFIED: f64 = 0.5;
/// Slope of a logarithm by its coordinate in the middle of a range, over that at an end, at most: far beyond any mode's.
const STEEPEST: f64 = 1e6;
/// Component of a unit direction above which its parameter is named.
const NAMED: f64 = 0.3;

/// Information of data about parameters whose priors are standard normal: eigenvalues of Jᵀ Σ⁻¹ J.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Identifiability {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Eigenvalues, descending: prior over posterior variance minus one.
    pub spectrum: Vec<f64>,
    /// Unit directions of the eigenvalues.
    pub directions: Vec<Vec<f64>>,
    /// Posterior over prior standard deviation of each parameter.
    pub contraction: Vec<f64>,
}

/// Verdict of data on a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[doc(alias = "Decided")]
pub enum Identified {
    /// The posterior has at most half the prior's standard deviation.
    Yes,
    /// Between half and nine tenths.
    Weakly,
    /// The prior is returned.
    No,
}

/// Answer to whether a model calibrates data, before sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The misfits are those of the stated noise, and the data identify a direction of the parameters.
    Calibrates,
    /// The misfits are larger than the stated noise, or the data tell nothing about the parameters.
    DoesNot,
    /// The data tell too little of the parameters or of the fit.
    CannotTell,
}

impl Identified {
    /// Verdict at a ratio of posterior and prior standard deviation.
    pub fn of(contraction: f64) -> Self {
        match contraction {
            c if c <= IDENTIFIED => Self::Yes,
            c if c < UNIDENTIFIED => Self::Weakly,
            _ => Self::No,
        }
    }

    /// The verdict in words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Yes => "identified by the data",
            Self::Weakly => "weakly identified",
            Self::No => "not identified by these data: the prior is returned",
        }
    }
}

impl Identifiability {
    /// Identifiability from the information at a mode, along the logarithms of the parameters: near an end of a range these move far less
    /// with the coordinates of the problem.
    pub fn new(problem: &Problem, mode: &Mode) -> Self {
        let count = problem.unknowns.len();
        let slope = |at: usize, y: f64| problem.unknowns[at].prior.logarithm(y)[1];
        let scale = |at: usize| (slope(at, 0.0) / slope(at, mode.y[at])).min(STEEPEST);
        let scaled = |i, j| scale(i) * scale(j) * mode.information[(i, j)];
        let eigen = SymmetricEigen::new(DMatrix::from_fn(count, count, scaled));
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let spectrum: Vec<f64> = order.iter().map(|&at| eigen.eigenvalues[at].max(0.0)).collect();
        let direction = |&at: &usize| -> Vec<f64> {
            let column = eigen.eigenvectors.column(at);
            // The sign is that of the largest entry.
            let sign = column[column.iamax()].signum();
            column.iter().map(|x| sign * x).collect()
        };
        let directions: Vec<Vec<f64>> = order.iter().map(direction).collect();
        let variance = |parameter: usize| -> f64 {
            let pairs = spectrum.iter().zip(&directions);
            pairs.map(|(value, direction)| direction[parameter].powi(2) / (1.0 + value)).sum()
        };
        let contraction = (0..count).map(|at| variance(at).sqrt()).collect();
        let names = problem.unknowns.iter().map(|unknown| unknown.name.clone()).collect();
        Self { names, spectrum, directions, contraction }
    }

    /// Probability, by the stated noise, of squared misfits at a mode whose sum is larger, and the degrees of freedom that the parameters leave.
    pub(crate) fn fit(problem: &Problem, mode: &Mode) -> [f64; 2] {
        let spectrum = mode.information.symmetric_eigenvalues();
        let fitted: f64 =
            spectrum.iter().map(|value| value.max(0.0) / (1.0 + value.max(0.0))).sum();
        let left = problem.data.len() as f64 - fitted;
        let squares = problem.squares(&mode.y, &mode.observed.values);
        [ChiSquared::new(left).map_or(1.0, |chi| chi.sf(squares)), left]
    }

    /// Verdict at the mode of [`check_identifiability`](crate::check_identifiability), and a sentence with the number that decides.
    pub fn verdict(&self, problem: &Problem, mode: &Mode) -> (Verdict, String) {
        let [p, left] = Self::fit(problem, mode);
        let (identified, count, best) =
            (self.identified(), self.names.len(), narrowing(self.spectrum[0]));
        let stated = (0..problem.data.len()).any(|datum| problem.factor_of(datum).is_none());
        let left = if stated { left } else { 0.0 };
        let as_large = |p: String| {
            format!(
                "misfits as large have a probability of {p} by the stated noise (at least {UNLIKELY})"
            )
        };
        let (verdict, reason) = if p < UNLIKELY {
            (Verdict::DoesNot, as_large(format!("{p:.1e}")))
        } else if identified == 0 {
            let verdict = if best >= UNIDENTIFIED { Verdict::DoesNot } else { Verdict::CannotTell };
            let along = "along the best identified direction of the parameters,";
            let left = "of the prior's standard deviation is left";
            (verdict, format!("{along} {best:.2} {left} (at most {IDENTIFIED})"))
        } else if left < 1.0 {
            let reason = "parameters and inferred noise leave the misfits";
            (Verdict::CannotTell, format!("{reason} {left:.2} degrees of freedom (at least 1)"))
        } else {
            let directions = format!("{identified} of {count} directions of the parameters");
            let large = as_large(format!("{p:.2}"));
            (Verdict::Calibrates, format!("{large}, and {directions} are identified"))
        };
        let head = match verdict {
            Verdict::Calibrates => "the model calibrates these data",
            Verdict::DoesNot => "the model does not calibrate these data",
            Verdict::CannotTell => "cannot tell whether the model calibrates these data",
        };
        (verdict, format!("{head}: {reason}"))
    }

    /// Number of directions whose posterior is at most half as wide as the prior.
    pub fn identified(&self) -> usize {
        self.spectrum.iter().filter(|value| narrowing(**value) <= IDENTIFIED).count()
    }

    /// Sentences about directions and parameters, for use before sampling: of single parameters the draws say more.
    pub fn in_words(&self) -> Vec<String> {
        let mut said = self.directions_in_words();
        for (name, contraction) in self.names.iter().zip(&self.contraction) {
            if Identified::of(*contraction) == Identified::No {
                said.push(format!("{name} by itself is {}.", Identified::No.in_words()));
            }
        }
        said
    }

    /// Sentences about directions, linearised at the mode.
    pub fn directions_in_words(&self) -> Vec<String> {
        let count = self.names.len();
        let which = match self.identified() {
            0 => format!("none of the {count}"),
            identified if identified == count => format!("all {count}"),
            identified => format!("{identified} of {count}"),
        };
        let mut said = vec![format!("The data identify {which} directions of the parameters.")];
        for (value, direction) in self.spectrum.iter().zip(&self.directions) {
            let narrowed = narrowing(*value);
            let verdict = match Identified::of(narrowed) {
                Identified::Yes => "identified",
                Identified::Weakly => "weakly identified",
                Identified::No => "not identified",
            };
            let direction = self.direction_in_words(direction);
            said.push(format!(
                "{direction} {verdict}: {narrowed:.2} of the prior's standard deviation is left."
            ));
        }
        said
    }

    /// The parameters that make up a direction.
    fn direction_in_words(&self, direction: &[f64]) -> String {
        let mut named: Vec<usize> = (0..direction.len()).collect();
        named.sort_by(|&a, &b| direction[b].abs().total_cmp(&direction[a].abs()));
        let first = self.names[named[0]].as_str();
        let others = named[1..].iter().filter(|&&at| direction[at].abs() >= NAMED);
        let part = |&at: &usize| {
            let way = if direction[at] > 0.0 { "up" } else { "down" };
            format!("{} {way}", self.names[at])
        };
        let parts: Vec<String> = others.map(part).collect();
        match parts.is_empty() {
            true => format!("{first} alone is"),
            false => format!("The direction {first} up, {} is", parts.join(", ")),
        }
    }
}

/// Posterior over prior standard deviation along a direction.
fn narrowing(eigenvalue: f64) -> f64 {
    (1.0 + eigenvalue).sqrt().recip()
}
