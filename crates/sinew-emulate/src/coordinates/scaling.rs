//! Normalisation of parameters and displacements.

use crate::coordinates::error::require_parameter;
use crate::coordinates::{
    CoordinateError, Result, require_count, require_finite, require_positive,
};
use crate::sample::{WIDTH, is_inside, share_of};
use serde::{Deserialize, Serialize};
use sinew_energy::{Parameter, Sampling};
use sinew_num::dot;

/// Maps parameters θ to network inputs of zero mean and unit variance over the box of their ranges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Range>")]
pub struct ParameterScaling(Vec<Range>);

/// One parameter's trained range, as it is stored.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Range {
    lower: f64,
    upper: f64,
    scale: Sampling,
}

impl ParameterScaling {
    /// Scaling by the ranges of the parameters, in their order in θ.
    ///
    /// # Errors
    /// An empty or not finite range, or a log scale with a bound that is not positive.
    pub fn new(parameters: &[Parameter]) -> Result<Self> {
        let range =
            |p: &Parameter| Range { lower: p.range[0], upper: p.range[1], scale: p.sampling };
        parameters.iter().map(range).collect::<Vec<_>>().try_into()
    }

    /// Every parameter on the log scale between `lower` and `upper`.
    ///
    /// # Errors
    /// As [`ParameterScaling::new`].
    pub fn logarithmic(lower: &[f64], upper: &[f64]) -> Result<Self> {
        require_count("upper bounds of the parameters", upper.len(), lower.len())?;
        let range = |(&lower, &upper)| Range { lower, upper, scale: Sampling::Log };
        lower.iter().zip(upper).map(range).collect::<Vec<_>>().try_into()
    }

    /// Number of parameters.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Network inputs of one parameter set.
    ///
    /// # Errors
    /// A wrong number of parameters, one that is not finite, or one that is not positive on a log scale.
    pub fn standardise(&self, theta: &[f64]) -> Result<Vec<f64>> {
        require_count("parameters", theta.len(), self.0.len())?;
        require_finite("parameters", theta)?;
        let input = |(parameter, (&value, range)): (usize, (&f64, &Range))| {
            range.require_positive(parameter, value)?;
            Ok(WIDTH * (share_of(&range.parameter(), value) - 0.5))
        };
        theta.iter().zip(&self.0).enumerate().map(input).collect()
    }

    /// The parameters of some network inputs.
    ///
    /// # Errors
    /// A wrong number of inputs.
    pub fn unstandardise(&self, inputs: &[f64]) -> Result<Vec<f64>> {
        require_count("standardised parameters", inputs.len(), self.0.len())?;
        let pairs = inputs.iter().zip(&self.0);
        Ok(pairs.map(|(input, range)| range.parameter().at_share(0.5 + input / WIDTH)).collect())
    }

    /// Requires that the parameters of a sample lie in their ranges.
    ///
    /// # Errors
    /// As [`ParameterScaling::standardise`], and the first parameter outside.
    pub fn require_inside(&self, sample: usize, theta: &[f64]) -> Result<()> {
        self.standardise(theta)?;
        for (parameter, (&value, range)) in theta.iter().zip(&self.0).enumerate() {
            let Range { lower, upper, .. } = *range;
            require_parameter(is_inside(&range.parameter(), value), || {
                format!(
                    "parameter {parameter} of sample {sample} is {value}, outside its range [{lower}, {upper}]; check the units, or widen the range"
                )
            })?;
        }
        Ok(())
    }

    /// Derivative of every network input with respect to its parameter, at `theta`.
    pub fn slopes(&self, theta: &[f64]) -> Vec<f64> {
        let slope = |(value, &Range { lower, upper, scale }): (&f64, &Range)| match scale {
            Sampling::Linear => WIDTH / (upper - lower),
            Sampling::Log => WIDTH / (value * (upper / lower).ln()),
        };
        theta.iter().zip(&self.0).map(slope).collect()
    }
}

impl TryFrom<Vec<Range>> for ParameterScaling {
    type Error = CoordinateError;

    fn try_from(ranges: Vec<Range>) -> Result<Self> {
        for (parameter, range) in ranges.iter().enumerate() {
            let Range { lower, upper, .. } = *range;
            require_finite("parameter range", &[lower, upper])?;
            range.require_positive(parameter, lower)?;
            require_parameter(lower < upper, || {
                format!(
                    "parameter {parameter} ranges from {lower} to {upper}; the upper bound must exceed the lower one"
                )
            })?;
        }
        Ok(Self(ranges))
    }
}

impl Range {
    fn parameter(self) -> Parameter {
        let Self { lower, upper, scale: sampling } = self;
        Parameter { sampling, ..Parameter::linear("", "", lower..=upper) }
    }

    /// Requires a value that its scale has a place for.
    fn require_positive(&self, parameter: usize, value: f64) -> Result<()> {
        let has_place = self.scale == Sampling::Linear || value > 0.0;
        require_parameter(has_place, || {
            format!(
                "parameter {parameter} is {value}, but its scale is logarithmic; give a positive value or choose the linear scale"
            )
        })
    }
}

/// Maps network outputs to displacements, `u = mean + scale · output`: per component, or per
/// degree of freedom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutputScale {
    /// Displacement of a zero output, for every component or, node by node, every degree of freedom \[length\].
    pub mean: Vec<f64>,
    /// Displacement of a unit output, as many as means \[length\].
    pub scale: Vec<f64>,
}

/// Smallest scale of a component relative to the largest. A component that hardly moves, as in a plane problem, would
/// otherwise be fitted to its noise.
const SMALLEST_RELATIVE_SCALE: f64 = 1e-3;

impl OutputScale {
    /// Mean and standard deviation per component of training displacements, each flattened node by node; with as many `dimensions`
    /// as a displacement has numbers per degree of freedom, so that a network learns only how each node departs from its mean.
    ///
    /// # Errors
    /// No displacement, a length that is no multiple of `dimensions`, or values that are not finite.
    pub fn standardising<'a>(
        dimensions: usize,
        displacements: impl IntoIterator<Item = &'a [f64]>,
    ) -> Result<Self> {
        Self::from_statistics(dimensions, displacements, mean_and_deviation)
    }

    /// Zero mean and the root mean square per component, for instance of one linear solve: what is
    /// known before physics-informed training.
    ///
    /// # Errors
    /// As [`OutputScale::standardising`].
    pub fn root_mean_square<'a>(
        dimensions: usize,
        displacements: impl IntoIterator<Item = &'a [f64]>,
    ) -> Result<Self> {
        Self::from_statistics(dimensions, displacements, |values| {
            (0.0, (dot(values, values) / values.len() as f64).sqrt())
        })
    }

    fn from_statistics<'a>(
        dimensions: usize,
        displacements: impl IntoIterator<Item = &'a [f64]>,
        statistics: impl Fn(&[f64]) -> (f64, f64),
    ) -> Result<Self> {
        require_positive("the scale of no displacement", dimensions as f64)?;
        let mut components: Vec<Vec<f64>> = vec![Vec::new(); dimensions];
        for displacement in displacements {
            let beyond = displacement.len() % dimensions;
            require_count("displacement values beyond whole nodes", beyond, 0)?;
            require_finite("displacements", displacement)?;
            for (at, component) in components.iter_mut().enumerate() {
                component.extend(displacement.iter().skip(at).step_by(dimensions));
            }
        }
        let (mean, scale): (Vec<f64>, Vec<f64>) = components.iter().map(|c| statistics(c)).unzip();
        let largest = scale.iter().copied().fold(0.0, f64::max);
        require_positive("the scale of the displacements", largest)?;
        let scale = scale.into_iter().map(|s| s.max(SMALLEST_RELATIVE_SCALE * largest)).collect();
        Ok(Self { mean, scale })
    }

    /// Requires a mean and a positive scale for every component or every degree of freedom.
    ///
    /// # Errors
    /// A wrong count or a scale that is not positive.
    pub fn check(&self, dimensions: usize, degrees_of_freedom: usize) -> Result<()> {
        if self.scale.len() != dimensions {
            require_count("output scales", self.scale.len(), degrees_of_freedom)?;
        }
        require_count("output means", self.mean.len(), self.scale.len())?;
        require_finite("output means", &self.mean)?;
        let what = "the scale of a displacement component";
        self.scale.iter().try_for_each(|&scale| require_positive(what, scale))
    }

    /// Length by which nodal distances are made dimensionless: root mean square of the scales \[length\].
    pub fn length(&self) -> f64 {
        (dot(&self.scale, &self.scale) / self.scale.len().max(1) as f64).sqrt()
    }
}

fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    (mean, variance.sqrt())
}
