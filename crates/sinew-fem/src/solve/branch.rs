//! Whether a solution is on the curve of equilibria that leads from rest to the whole load, by a few of its points and their tangents.

use crate::elements::{State, Unknowns, place as place_supports};
use crate::linear::difference;
use crate::linear::systems::CORRECTION;
use crate::solve::{ON_THE_WAY, Path, Point};

/// Largest difference of a change of displacement gradients from that by the mean of both tangents \[relative to the largest change\]. On curves of
/// ventricles 0.2 to 0.35 of it between loads of 0, 0.3 and 1. Between branches, those of a column or a dome, more than half.
const SMOOTH: f64 = 0.35;
/// Place of a point between two others \[relative to their distance\]: soft tissue stiffens, so that curves bend most near rest.
const BETWEEN: f64 = 0.3;
/// Times that a part of the curve is divided.
const DIVISIONS: usize = 2;

/// A stable equilibrium with its derivative in the place on the line.
struct Node {
    place: f64,
    displacement: Vec<f64>,
    tangent: Vec<f64>,
}

impl Path<'_, '_, '_> {
    /// Whether stable equilibria, each with the tangents that its neighbours lead one to expect, connect a solution with rest: then it is that of a rising load.
    pub(crate) fn leads_to(&mut self, end: Unknowns) -> bool {
        self.release_stresses();
        let rest = self.system.rest();
        let ends = self.node(0.0, rest).zip(self.node(1.0, end));
        ends.is_some_and(|(rest, end)| self.is_smooth([&rest, &end], DIVISIONS))
    }

    /// A point of the curve; `None` where it is not stable.
    fn node(&mut self, place: f64, unknowns: Unknowns) -> Option<Node> {
        let (system, (load_factor, theta)) = (&mut *self.system, self.line.at(place));
        system.assemble(&unknowns, &theta, load_factor, None);
        let Unknowns { displacement, .. } = unknowns;
        let state = State { load_factor, ..State::whole(&displacement, &theta) };
        let (rate, mut tangent) = system.rate_along(&self.line, state);
        let change = system.definite_response(&rate, CORRECTION)?;
        system.sparsity.scatter(change, &mut tangent);
        Some(Node { place, displacement, tangent })
    }

    /// Whether two points are connected by a smooth curve, or both with points between them.
    fn is_smooth(&mut self, [a, b]: [&Node; 2], divisions: usize) -> bool {
        let distance = b.place - a.place;
        let change = difference(&b.displacement, &a.displacement);
        let mean = a.tangent.iter().zip(&b.tangent).map(|(a, b)| 0.5 * distance * (a + b));
        let off: Vec<f64> = change.iter().zip(mean).map(|(u, mean)| u - mean).collect();
        let [off, most] = [&off, &change].map(|u| self.system.largest_gradient(u));
        if off <= SMOOTH * most || divisions == 0 {
            return off <= SMOOTH * most;
        }
        // Hermite's interpolation.
        let (s, rest) = (BETWEEN, 1.0 - BETWEEN);
        let place = a.place + s * distance;
        let along = |i: usize| {
            let slopes = s * rest * rest * a.tangent[i] - s * s * rest * b.tangent[i];
            a.displacement[i] + s * s * (3.0 - 2.0 * s) * change[i] + distance * slopes
        };
        let mut unknowns = self.system.rest();
        unknowns.displacement = (0..change.len()).map(along).collect();
        place_supports(self.system.body, self.line.at(place).0, &mut unknowns.displacement);
        let guess = Point { at: place, place, unknowns, stress: None };
        let found = self.equilibrium(guess, ON_THE_WAY).filter(|found| found.negative_pivots == 0);
        let between = found.and_then(|found| self.node(place, found.unknowns));
        between.is_some_and(|between| {
            self.is_smooth([a, &between], divisions - 1)
                && self.is_smooth([&between, b], divisions - 1)
        })
    }
}
