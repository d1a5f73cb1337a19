//! Targets of the learning.

use super::simulated::Simulated;
use super::size::SizeRegression;
use super::variant::Inputs;
use anyhow::Result;

/// Targets: displacements relative to their size over some inputs, or the error of a known approximation relative to the size of that.
pub(super) struct Targets(Option<(SizeRegression, Inputs)>);

impl Targets {
    /// Displacements as they are.
    pub(super) fn absolute() -> Self {
        Self(None)
    }

    /// Displacements relative to the size that bodies with these inputs have.
    pub(super) fn relative<B: Simulated>(training: &[B], over: Inputs) -> Result<Self> {
        let inputs: Vec<_> = training.iter().map(|body| body.inputs(over)).collect();
        let fields: Vec<_> = training.iter().map(B::displacement).collect();
        let parameters = training.first().map_or_else(Vec::new, |body| body.parameters(over));
        Ok(Self(Some((SizeRegression::fit(&parameters, &inputs, &fields)?, over))))
    }

    fn size<B: Simulated>(&self, body: &B) -> Result<f64> {
        Ok(self.0.as_ref().map_or(Ok(1.0), |(sizes, over)| sizes.at(&body.inputs(*over)))?)
    }

    /// Target of a method for a body.
    pub(super) fn of<B: Simulated>(&self, body: &B, told: Inputs) -> Result<Vec<f64>> {
        let displacement = body.displacement().iter();
        Ok(match body.known(told) {
            Some((known, size)) => displacement.zip(known).map(|(u, k)| (u - k) / size).collect(),
            None => {
                let size = self.size(body)?;
                displacement.map(|u| u / size).collect()
            }
        })
    }

    /// The displacement of what a method found for a body.
    pub(super) fn displaced<B: Simulated>(
        &self,
        body: &B,
        found: &[f64],
        told: Inputs,
    ) -> Result<Vec<f64>> {
        Ok(match body.known(told) {
            Some((known, size)) => found.iter().zip(known).map(|(f, k)| size * f + k).collect(),
            None => {
                let size = self.size(body)?;
                found.iter().map(|f| size * f).collect()
            }
        })
    }
}
