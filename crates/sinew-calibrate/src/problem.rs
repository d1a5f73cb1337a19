//! Measured values; unknowns with their priors, in coordinates in which each prior is standard normal; a calibration in one canonical order.

use crate::fault::Result;
use crate::polynomial::Sample;
use crate::{CalibrateError, Observed};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

/// Standard deviation of the logarithm of an inferred factor of standard deviations: a factor 2 is one standard deviation.
pub(crate) const FACTOR_DEVIATION: f64 = std::f64::consts::LN_2;

/// Largest standard deviation of a logarithm: its 95 % interval spans a factor of 50. Larger ones are per cent.
const WIDEST: f64 = 1.0;

/// Unknown parameters and data. Data are sorted by kind, name (segment 2 before segment 10) and value, so that results do not depend on the order in which
/// they are given.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Parameters in the order of [`crate::Forward`].
    pub unknowns: Vec<Unknown>,
    /// Data in canonical order.
    pub data: Vec<Datum>,
    /// Kinds in the order of their names.
    pub kinds: Vec<Kind>,
    /// Values of the data over their standard deviations.
    pub(crate) measured: DVector<f64>,
}

impl Problem {
    /// Checks parameters, data and kinds; kinds that are not given have independent errors of known size.
    ///
    /// # Errors
    /// Ranges that are empty or not positive; values that are not finite; standard deviations that are not positive; no data.
    pub fn new(unknowns: Vec<Unknown>, mut data: Vec<Datum>, mut kinds: Vec<Kind>) -> Result<Self> {
        let require = |makes_sense: bool, reason: String| match makes_sense {
            true => Ok(()),
            false => Err(CalibrateError::Input(reason)),
        };
        let nothing = "nothing is unknown; give at least one parameter a range";
        require(!unknowns.is_empty(), nothing.into())?;
        require(!data.is_empty(), "there are no data; add a [[data]] with a value".into())?;
        for unknown in &unknowns {
            if let Some(fault) = unknown.prior.fault() {
                let reason = format!("the prior of {}: {fault}", unknown.name);
                return Err(CalibrateError::Input(reason));
            }
        }
        for Datum { name, value, deviation, is_share, .. } in &data {
            let advice = "give a finite number or leave the datum out";
            require(value.is_finite(), format!("{name}: the value is {value}; {advice}"))?;
            let advice = "and a share of it is no standard deviation; give a number";
            let is_share_of_none = *is_share && *value <= 0.0;
            require(!is_share_of_none, format!("{name}: the value is {value}, {advice}"))?;
            let reason =
                format!("{name}: the standard deviation is {deviation}; give a positive number");
            require(deviation.is_finite() && *deviation > 0.0, reason)?;
        }
        for Kind { name, bias, .. } in &kinds {
            let reason = format!("{name}: the bias is {bias}; give 0 or more");
            require(bias.is_finite() && *bias >= 0.0, reason)?;
        }
        data.sort_by(|a, b| {
            let names = by_numbers(&a.name).cmp(&by_numbers(&b.name)).then(a.name.cmp(&b.name));
            a.kind.cmp(&b.kind).then(names).then(a.value.total_cmp(&b.value))
        });
        kinds.sort_by(|a, b| a.name.cmp(&b.name));
        let measured = DVector::from_iterator(data.len(), data.iter().map(|d| d.scaled(d.value)));
        Ok(Self { unknowns, data, kinds, measured })
    }

    /// Coordinates of the posterior: parameters, then factors of noise.
    pub fn dimension(&self) -> usize {
        self.unknowns.len() + self.inferred()
    }

    /// Kinds whose noise is inferred.
    pub(crate) fn inferred(&self) -> usize {
        self.inferred_kinds().count()
    }

    /// Names of the kinds whose noise is inferred.
    pub fn inferred_kinds(&self) -> impl Iterator<Item = &str> {
        self.kinds.iter().filter(|kind| kind.inferred).map(|kind| kind.name.as_str())
    }

    /// Place among the inferred factors of a datum's noise.
    pub(crate) fn factor_of(&self, datum: usize) -> Option<usize> {
        self.inferred_kinds().position(|name| name == self.data[datum].kind)
    }

    /// Logarithms of the factors of noise at coordinates.
    pub(crate) fn log_factors(&self, y: &[f64]) -> Vec<f64> {
        y[self.unknowns.len()..].iter().map(|y| FACTOR_DEVIATION * y).collect()
    }

    /// Logarithm of the factor of a datum's standard deviation.
    pub(crate) fn log_factor(&self, datum: usize, factors: &[f64]) -> f64 {
        self.factor_of(datum).map_or(0.0, |place| factors[place])
    }

    /// θ at coordinates.
    pub fn theta(&self, y: &[f64]) -> Vec<f64> {
        let pairs = self.unknowns.iter().zip(y);
        pairs.map(|(unknown, y)| unknown.prior.logarithm(*y)[0].exp()).collect()
    }

    /// Logarithms of the parameters, with mean 0 and standard deviation 1 a priori, at coordinates.
    pub(crate) fn standardised(&self, y: &[f64]) -> Vec<f64> {
        let of = |(unknown, y): (&Unknown, &f64)| {
            let [mean, deviation] = unknown.prior.moments();
            (unknown.prior.logarithm(*y)[0] - mean) / deviation
        };
        self.unknowns.iter().zip(y).map(of).collect()
    }

    /// Observables of the data over their standard deviations.
    pub(crate) fn scaled(&self, observed: &[f64]) -> DVector<f64> {
        let values = self.data.iter().map(|d| d.scaled(observed[d.observable]));
        DVector::from_iterator(self.data.len(), values)
    }

    /// Derivatives of the scaled observables in the coordinates at y; none without derivatives.
    pub(crate) fn jacobian(
        &self,
        theta: &[f64],
        y: &[f64],
        observed: &Observed,
    ) -> Option<DMatrix<f64>> {
        if observed.jacobian.is_empty() {
            return None;
        }
        let slope = |at: usize| theta[at] * self.unknowns[at].prior.logarithm(y[at])[1];
        let slope: Vec<f64> = (0..self.unknowns.len()).map(slope).collect();
        Some(DMatrix::from_fn(self.data.len(), self.unknowns.len(), |row, at| {
            let datum = &self.data[row];
            let value = observed.values[datum.observable];
            observed.jacobian[datum.observable][at] * datum.slope(value) * slope[at]
        }))
    }

    /// Sample of the regression at θ.
    pub(crate) fn sample(&self, theta: &[f64], observed: &Observed, weight: f64) -> Sample {
        let moments: Vec<_> = self.unknowns.iter().map(|u| u.prior.moments()).collect();
        let x =
            theta.iter().zip(&moments).map(|(t, [mean, deviation])| (t.ln() - mean) / deviation);
        let row = |datum: &Datum| {
            let row = &observed.jacobian[datum.observable];
            let slope = datum.slope(observed.values[datum.observable]);
            (0..theta.len()).map(|at| row[at] * theta[at] * moments[at][1] * slope).collect()
        };
        let told = self.data.iter().filter(|_| !observed.jacobian.is_empty());
        let slopes = told.map(row).collect();
        let values = self.scaled(&observed.values).as_slice().to_vec();
        Sample { x: x.collect(), values, slopes, weight }
    }
}

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

/// A measured value of one observable.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Datum {
    /// Name, such as `volume of endo at ed`.
    pub name: String,
    /// Kind of measurement, which shares noise and bias, such as `volume`.
    pub kind: String,
    /// Place among the observables of [`crate::Forward`].
    pub observable: usize,
    /// Value, in the unit of the observable.
    pub value: f64,
    /// Standard deviation of its error, in the unit of the observable; of the logarithm for a share.
    pub deviation: f64,
    /// Whether the error is a share of the exact value, such as 3 %: its logarithm is normal, and values are positive. A share of the
    /// measured value would take values that were measured too low for better known ones.
    pub is_share: bool,
    /// Unit of the values that people read; empty for a ratio.
    pub unit: String,
    /// Size of that unit in the unit of the observable.
    pub size: f64,
}

impl Datum {
    /// A datum whose value and standard deviation are in the unit of the observable, which is not named.
    pub fn new(
        name: impl Into<String>,
        kind: impl Into<String>,
        observable: usize,
        value: f64,
        deviation: f64,
    ) -> Self {
        let (name, kind, unit) = (name.into(), kind.into(), String::new());
        Self { name, kind, observable, value, deviation, is_share: false, unit, size: 1.0 }
    }

    /// Standard deviation in the unit of the observable, at the measured value.
    pub fn error(&self) -> f64 {
        if self.is_share { self.deviation * self.value } else { self.deviation }
    }

    /// A value with `z` standard deviations of error.
    pub fn with_error(&self, exact: f64, z: f64) -> f64 {
        let error = z * self.deviation;
        if self.is_share { exact * error.exp() } else { exact + error }
    }

    /// A value on the scale where errors have standard deviation 1; a share of what is not positive is out of reach.
    pub(crate) fn scaled(&self, value: f64) -> f64 {
        let value = if self.is_share { value.max(f64::MIN_POSITIVE).ln() } else { value };
        value / self.deviation
    }

    /// Derivative of [`Datum::scaled`].
    pub(crate) fn slope(&self, value: f64) -> f64 {
        match self.is_share {
            true if value > 0.0 => 1.0 / (value * self.deviation),
            true => 0.0,
            false => 1.0 / self.deviation,
        }
    }
}

/// Errors that a kind of measurement has beyond the given standard deviations.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Kind {
    /// Name.
    pub name: String,
    /// Whether its standard deviations are inferred: times one factor, log-normal about 1.
    pub inferred: bool,
    /// Standard deviation of an error that all its data share, in the unit of its observables; 0 for none.
    pub bias: f64,
}

/// Parts of a name for sorting: text, and the number behind it.
fn by_numbers(name: &str) -> Vec<(&str, u64)> {
    let (mut rest, mut parts) = (name, Vec::new());
    while !rest.is_empty() {
        let (text, tail) =
            rest.split_at(rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len()));
        let digits = tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len());
        parts.push((text, tail[..digits].parse().unwrap_or(0)));
        rest = &tail[digits..];
    }
    parts
}
