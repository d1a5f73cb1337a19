//! Targets of the learning.

use super::simulated::Simulated;
use super::variant::Inputs;
use anyhow::Result;
use sinew_emulate::PodRegression;

/// Largest total degree of the polynomial of sizes; lower ones are tried too.
const DEGREE: usize = 3;

/// Targets: displacements relative to their size over some inputs, or the error of a known approximation relative to the size of that.
///
/// Between soft and stiff tissue displacements differ by orders of magnitude. Their size is the root mean square; its logarithm is a
/// polynomial in the inputs by least squares.
pub(super) struct Targets(Option<(PodRegression, Inputs)>);

impl Targets {
    /// Displacements as they are.
    pub(super) fn absolute() -> Self {
        Self(None)
    }

    /// Displacements relative to the size that bodies with these inputs have.
    pub(super) fn relative<B: Simulated>(training: &[B], over: Inputs) -> Result<Self> {
        let inputs: Vec<_> = training.iter().map(|body| body.inputs(over)).collect();
        let size = |body: &B| {
            let field = body.displacement();
            let square = field.iter().map(|u| u * u).sum::<f64>() / field.len() as f64;
            vec![0.5 * square.ln()]
        };
        let sizes: Vec<_> = training.iter().map(size).collect();
        let parameters = training.first().map_or_else(Vec::new, |body| body.parameters(over));
        let fit = PodRegression::fit_polynomial(&parameters, &inputs, &sizes, DEGREE)?;
        Ok(Self(Some((fit, over))))
    }

    fn size<B: Simulated>(&self, body: &B) -> Result<f64> {
        let Some((sizes, over)) = &self.0 else { return Ok(1.0) };
        Ok(sizes.predict(&body.inputs(*over))?[0].exp())
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
