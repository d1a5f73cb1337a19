//! Arc-length steps near a limit point of a rising load, to see whether the load falls beyond it.

use crate::elements::system::Unknowns;
use crate::linear::vector::norm;
use crate::solve::outlook::LimitPoint;
use crate::solve::path::{Along, Path};
use crate::solve::search::{Equilibrium, Point};

/// Most equilibria that are sought.
const MOST: usize = 6;
/// Iterations at each.
const ITERATIONS: usize = 8;
/// Residual \[relative\] that shows whether the load rises or falls.
const ACCURACY: f64 = 1e-7;
/// Largest distance to the next equilibrium \[relative to the step\]; one farther off is on another branch.
const ASTRAY: f64 = 1.25;
/// A step after a failure, as a multiple of the one before.
const CUT: f64 = 0.5;

impl Path<'_, '_, '_> {
    /// Continues by arc length until the load falls or passes the refused one; true if the path can continue from the
    /// last equilibrium. The first step raises the load by `most` at most, along the secant.
    pub(crate) fn around(&mut self, most: f64) -> bool {
        let [.., before, last] = &self.points[..] else { return false };
        let apart = |a: &Point, b: &Point| norm(&self.way(&a.unknowns, &b.unknowns, 1.0));
        let scale = apart(before, last) / (last.place - before.place);
        if !(scale > 0.0 && scale.is_finite()) {
            self.outlook.turn = LimitPoint::Unclear;
            return false;
        }
        let mut length = 0.0;
        let mut lengths = vec![0.0];
        for pair in self.points.windows(2) {
            length += (apart(&pair[0], &pair[1]) / scale).hypot(pair[1].place - pair[0].place);
            lengths.push(length);
        }
        let last_step = length - lengths[lengths.len() - 2];
        let step = last_step * (most / (last.place - before.place)).min(1.0);
        self.points.iter_mut().zip(lengths).for_each(|(point, at)| point.at = at);
        let start = self.reached().place;
        let per_load = std::mem::replace(&mut self.options.iterations_per_load, ITERATIONS);
        self.along = Along::Arc(scale);
        self.outlook.turn = self.turn(step, scale);
        self.along = Along::Place;
        self.options.iterations_per_load = per_load;
        self.points.iter_mut().for_each(|point| point.at = point.place);
        self.reached().place > start && self.outlook.turn == LimitPoint::Unknown
    }

    fn turn(&mut self, mut step: f64, scale: f64) -> LimitPoint {
        for _ in 0..MOST {
            let last = self.reached().clone();
            let (guess, before) = (self.extrapolated(last.at + step), self.log.iterations.len());
            let found = self.equilibrium(guess, ACCURACY);
            let near = |found: &Equilibrium| self.length_to(&last, found, scale) <= ASTRAY * step;
            let Some(found) = found.filter(near) else {
                step *= CUT;
                continue;
            };
            if found.place <= last.place {
                let unstable = found.negative_pivots > 0 || !self.system.body.has_potential();
                return if unstable { LimitPoint::At(last.place) } else { LimitPoint::Unclear };
            }
            self.push(last.at + self.length_to(&last, &found, scale), &found);
            self.outlook.reach(found.place, &found);
            if self.outlook.refused.is_none() {
                return LimitPoint::Unknown;
            }
            step *= self.growth(&found, before);
        }
        LimitPoint::Unclear
    }

    /// Length of the curve between two equilibria that are near to each other.
    pub(crate) fn length_to(&self, last: &Point, found: &Equilibrium, scale: f64) -> f64 {
        norm(&self.way(&last.unknowns, &found.unknowns, scale)).hypot(found.place - last.place)
    }

    /// Difference of the free displacements of two states \[relative to a scale\].
    pub(crate) fn way(&self, from: &Unknowns, to: &Unknowns, scale: f64) -> Vec<f64> {
        let [from, to] = [from, to].map(|u| self.system.sparsity.gather(&u.displacement));
        to.zip(from).map(|(b, a)| (b - a) / scale).collect()
    }
}
