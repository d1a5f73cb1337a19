//! Lines in loads and parameters that equilibria are followed along.

use crate::elements::System;
use crate::{Result, SolveError};

/// A line in loads and parameters: at place s fraction and θ are `(1 − s) · start + s · end`, beyond 1 as well.
///
/// ```
/// use sinew_fem::Line;
/// // All loads from zero, at one θ; and one θ to another under the whole load.
/// let loading = Line::of_loads(&[75.0, 75.0]);
/// let softening = Line::of_theta([&[75.0, 75.0], &[50.0, 75.0]]);
/// assert_eq!(loading.at(0.5), (0.5, vec![75.0, 75.0]));
/// assert_eq!(softening.at(0.2), (1.0, vec![70.0, 75.0]));
/// ```
#[doc(alias("arc length", "continuation"))]
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Fractions of all loads and prescribed motions at start and end.
    pub load_factors: [f64; 2],
    /// Parameters of law and loads there.
    pub thetas: [Vec<f64>; 2],
}

impl Line {
    /// All loads and prescribed motions from zero to the whole.
    pub fn of_loads(theta: &[f64]) -> Self {
        Self { load_factors: [0.0, 1.0], thetas: [theta.to_vec(), theta.to_vec()] }
    }

    /// Line from one θ to another under the whole load.
    pub fn of_theta(ends: [&[f64]; 2]) -> Self {
        Self { load_factors: [1.0; 2], thetas: ends.map(<[f64]>::to_vec) }
    }

    /// Fraction of the loads and θ at a place.
    pub fn at(&self, place: f64) -> (f64, Vec<f64>) {
        let between = |a: f64, b: f64| if a == b { a } else { a + place * (b - a) };
        let [from, to] = &self.thetas;
        let theta = from.iter().zip(to).map(|(&a, &b)| between(a, b)).collect();
        (between(self.load_factors[0], self.load_factors[1]), theta)
    }

    /// Increment of both from place to place.
    pub(crate) fn rates(&self) -> (f64, Vec<f64>) {
        let [from, to] = &self.thetas;
        let rates = from.iter().zip(to).map(|(a, b)| b - a).collect();
        (self.load_factors[1] - self.load_factors[0], rates)
    }

    /// Checks that both ends belong to the body.
    pub(crate) fn check(&self, system: &System<'_>) -> Result<()> {
        self.thetas.iter().try_for_each(|theta| system.body.check_theta(theta))?;
        let finite = self.load_factors.iter().all(|load| load.is_finite());
        let moves =
            self.load_factors[0] != self.load_factors[1] || self.thetas[0] != self.thetas[1];
        match (finite, moves) {
            (false, _) => {
                Err(SolveError::Line { problem: "a fraction of the loads is not finite" })
            }
            (_, false) => Err(SolveError::Line { problem: "its ends are the same" }),
            _ => Ok(()),
        }
    }
}
