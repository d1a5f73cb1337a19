//! Unknown parameters and their priors, in coordinates in which each prior is standard normal.

use statrs::distribution::{ContinuousCDF, Normal};

/// Prior of a positive parameter.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Prior {
    /// Uniform over the logarithm between two ends.
    LogUniform {
        /// Ends, ascending and positive.
        range: [f64; 2],
    },
    /// Normal over the logarithm.
    LogNormal {
        /// Median.
        median: f64,
        /// Standard deviation of the logarithm: 0.1 is about 10 %.
        deviation: f64,
    },
}

/// Largest standard deviation of a logarithm: its 95 % interval spans a factor of 50. Larger ones are per cent.
const WIDEST: f64 = 1.0;

/// A parameter that is not known.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Unknown {
    /// Name.
    pub name: String,
    /// Unit of the values that people read; empty for a ratio.
    pub unit: String,
    /// Size of that unit in the unit of [`crate::Forward`].
    pub size: f64,
    /// Prior, in the unit of [`crate::Forward`].
    pub prior: Prior,
}

impl Unknown {
    /// A parameter in the unit of [`crate::Forward`].
    pub fn new(name: impl Into<String>, unit: impl Into<String>, prior: Prior) -> Self {
        Self { name: name.into(), unit: unit.into(), size: 1.0, prior }
    }

    /// Head of a column: `a [kPa]`.
    pub fn head(&self) -> String {
        match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{} [{unit}]", self.name),
        }
    }

    /// A value in the unit that people read.
    pub fn shown(&self, theta: f64) -> f64 {
        theta / self.size
    }
}

impl Prior {
    /// Logarithm of the parameter at a coordinate that is standard normal a priori, and its derivative.
    pub fn logarithm(&self, y: f64) -> [f64; 2] {
        match *self {
            Self::LogUniform { range } => {
                let [low, high] = range.map(f64::ln);
                let density = (-0.5 * y * y).exp() / std::f64::consts::TAU.sqrt();
                [low + (high - low) * Normal::standard().cdf(y), (high - low) * density]
            }
            Self::LogNormal { median, deviation } => [median.ln() + deviation * y, deviation],
        }
    }

    /// The coordinate of a value; infinite at an end and beyond.
    pub fn coordinate(&self, value: f64) -> f64 {
        match *self {
            Self::LogUniform { range } => {
                let [low, high] = range.map(f64::ln);
                let share = (value.ln() - low) / (high - low);
                Normal::standard().inverse_cdf(share.clamp(0.0, 1.0))
            }
            Self::LogNormal { median, deviation } => (value / median).ln() / deviation,
        }
    }

    /// Mean and standard deviation of the logarithm.
    pub fn moments(&self) -> [f64; 2] {
        match *self {
            Self::LogUniform { range } => {
                let [low, high] = range.map(f64::ln);
                [0.5 * (low + high), (high - low) / 12f64.sqrt()]
            }
            Self::LogNormal { median, deviation } => [median.ln(), deviation],
        }
    }

    /// Fault, in words, of a prior that does not suit a positive parameter.
    pub fn fault(&self) -> Option<String> {
        let usable = |value: f64| value > 0.0 && value.is_finite();
        match *self {
            Self::LogUniform { range: [low, high] }
                if !(usable(low) && usable(high) && low < high) =>
            {
                Some(format!("the range is {low} to {high}; give 0 < low < high"))
            }
            Self::LogNormal { median, .. } if !usable(median) => {
                Some(format!("the median is {median}; give a positive number"))
            }
            Self::LogNormal { deviation, .. } if !usable(deviation) => Some(format!(
                "the standard deviation of the logarithm is {deviation}; give a positive number, such as 0.1 for about 10 %"
            )),
            Self::LogNormal { deviation, .. } if deviation > WIDEST => Some(format!(
                "the standard deviation {deviation} is a fraction: write {} for {deviation} %; a prior wider than {WIDEST} is a range",
                deviation / 100.0
            )),
            _ => None,
        }
    }

    /// Range of a log-uniform prior, 95 % interval of another.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Self::LogUniform { range } => range,
            Self::LogNormal { .. } => [-1.96, 1.96].map(|y| self.logarithm(y)[0].exp()),
        }
    }
}
