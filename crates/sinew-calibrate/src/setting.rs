//! Values of the entries of a body's θ in a state, as functions of the parameters.

/// Value of a load or of a law's parameter in one state: a number times parameters.
///
/// ```
/// use sinew_calibrate::Setting;
///
/// let known = Setting::from(8.0);
/// // A pressure that was measured as 8, with a factor common to all and one of its own.
/// let uncertain = Setting::from(8.0).times("common").times("own");
/// assert_eq!((known.parameters.len(), uncertain.parameters.len()), (0, 2));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The number, in the unit of the scene.
    pub factor: f64,
    /// Names of the parameters that it is multiplied by.
    pub parameters: Vec<String>,
}

impl From<f64> for Setting {
    fn from(factor: f64) -> Self {
        Self { factor, parameters: Vec::new() }
    }
}

impl Setting {
    /// The value of a parameter.
    pub fn parameter(name: impl Into<String>) -> Self {
        Self::from(1.0).times(name)
    }

    /// The value times a parameter.
    pub fn times(mut self, name: impl Into<String>) -> Self {
        self.parameters.push(name.into());
        self
    }
}

/// A setting whose parameters are places in θ of the patient.
pub(crate) struct Entry {
    pub factor: f64,
    pub parameters: Vec<usize>,
}

impl Entry {
    pub(crate) fn value(&self, theta: &[f64]) -> f64 {
        self.parameters.iter().fold(self.factor, |value, &at| value * theta[at])
    }

    /// Derivative in one parameter.
    pub(crate) fn slope(&self, theta: &[f64], parameter: usize) -> f64 {
        let without = |skipped: usize| {
            let others = self.parameters.iter().enumerate().filter(|(place, _)| *place != skipped);
            others.fold(self.factor, |value, (_, &at)| value * theta[at])
        };
        let own = self.parameters.iter().enumerate().filter(|(_, at)| **at == parameter);
        own.map(|(place, _)| without(place)).sum()
    }
}
