//! Parameters that a fit adjusts.

/// One number that a fit adjusts, within bounds, from a start drawn at random.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParameter {
    /// Name: of the equation's parameter, or as `amplitude 1`, `lengthscale x 1`, `noise 2`.
    pub name: String,
    /// Whether it is positive and adjusted on a logarithmic scale.
    pub logarithmic: bool,
    /// Lower and upper bound, in its own unit.
    pub bounds: [f64; 2],
    /// Range in which restarts begin, in its own unit.
    pub start: [f64; 2],
    /// Prior density of the parameter, that of a hyperparameter a hyperprior.
    pub hyperprior: Hyperprior,
}

/// Prior density of a parameter on the scale that it is adjusted on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hyperprior {
    /// Uniform within the bounds.
    Flat,
    /// Normal in the logarithm. Amplitudes and lengthscales are believed to be the size of the
    /// data and of the domain, give or take a factor e: without that unit information has
    /// many maxima at odd lengthscales that fit noise (on Wave-BVP-1 it more than halves the
    /// errors of u and θ; where data abound it makes no difference).
    LogNormal {
        /// Median, in the parameter's own unit.
        median: f64,
        /// Standard deviation of the logarithm.
        standard_deviation: f64,
    },
    /// Gamma with mean 1, of this shape: of the weights of [`crate::Noise::StudentT`], with half its degrees of freedom.
    Gamma {
        /// Shape.
        shape: f64,
    },
}

impl Hyperprior {
    /// Normal in the logarithm.
    pub(crate) fn about(median: f64, standard_deviation: f64) -> Self {
        Self::LogNormal { median, standard_deviation }
    }

    /// Logarithm of the density up to a constant, and its derivative.
    pub(crate) fn log_density(self, coordinate: f64) -> (f64, f64) {
        match self {
            Self::Flat => (0.0, 0.0),
            Self::Gamma { shape } => {
                let rate = shape * coordinate.exp();
                (shape * coordinate - rate, shape - rate)
            }
            Self::LogNormal { median, standard_deviation: deviation } => {
                let z = (coordinate - median.ln()) / deviation;
                (-0.5 * z * z, -z / deviation)
            }
        }
    }
}

impl FreeParameter {
    /// Converts a value from its own unit to the scale that it is adjusted on.
    pub fn to_scale(&self, value: f64) -> f64 {
        if self.logarithmic { value.ln() } else { value }
    }

    /// Back to its own unit.
    pub fn from_scale(&self, coordinate: f64) -> f64 {
        if self.logarithmic { coordinate.exp() } else { coordinate }
    }
}
