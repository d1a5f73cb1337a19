//! Measured values with their errors.

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

/// Standard deviation of the logarithm of an inferred factor of standard deviations: a factor 2 is one standard deviation.
pub(crate) const FACTOR_DEVIATION: f64 = std::f64::consts::LN_2;
