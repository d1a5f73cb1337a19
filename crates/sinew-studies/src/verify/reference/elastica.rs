//! The elastica: large bending of a thin cantilever.

use super::{integrate, root};
use anyhow::Result;
use std::f64::consts::FRAC_PI_2;

/// A cantilever that neither stretches nor shears, under a dead load across it: Euler's `EIθ″ = −Q cos θ` with
/// the load Q beyond each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elastica {
    /// A force at the tip; the number is `PL²/EI`.
    TipLoad(f64),
    /// A uniform load per length; the number is `qL³/EI`.
    UniformLoad(f64),
}

impl Elastica {
    /// Distance of the tip from the clamp along the straight beam and its deflection, both over the length, by shooting from the
    /// tip, where the curvature is zero.
    ///
    /// # Errors
    /// Loads that are not positive.
    pub fn tip(self) -> Result<[f64; 2]> {
        let at_clamp = |angle: f64| {
            let start = [angle, 0.0, 0.0, 0.0];
            integrate(|s, y| self.slope(s, y), [0.0, 1.0], start).unwrap_or([f64::NAN; 4])
        };
        let angle = root(|angle| at_clamp(angle)[0], [0.0, FRAC_PI_2])?;
        let [_, _, along, across] = at_clamp(angle);
        Ok([along, across])
    }

    /// Slopes of angle, curvature and position over the distance from the tip.
    fn slope(self, s: f64, &[angle, curvature, _, _]: &[f64; 4]) -> [f64; 4] {
        let load = match self {
            Self::TipLoad(load) => load,
            Self::UniformLoad(load) => load * s,
        };
        [curvature, -load * angle.cos(), angle.cos(), angle.sin()]
    }
}
