//! Limit point foreseen from the curve of equilibria: evidence that larger loads have none. Arc-length steps near it show
//! whether the load falls beyond it.

use crate::elements::Unknowns;
use crate::linear::{difference, dot, norm};
use crate::solve::{Equilibrium, Path, Point};

/// Number of equilibria on the parabola.
const POINTS: usize = 3;
/// Part of a foreseen limit load that is reached before arc-length steps begin.
const NEAR: f64 = 0.9;
/// Part of the way to a foreseen limit point that a step takes: less than one, as the estimate is rough.
const ONWARD: f64 = 0.75;
/// Load tried beyond a limit point \[relative to its load\], where the body may have snapped to other equilibria.
const BEYOND: f64 = 1.05;
/// The last equilibria under a rising load, and the least larger load without one.
#[derive(Default)]
pub(crate) struct Outlook {
    /// Places on the line with displacements \[length\], ascending, all on one branch.
    points: Vec<(f64, Vec<f64>)>,
    pub refused: Option<f64>,
    /// Whether a load was refused since the last equilibrium.
    failed: bool,
    /// States found by arc-length continuation.
    pub turn: LimitPoint,
    /// Whether the body has snapped from one branch to another on the way.
    pub jumped: bool,
}

/// Limit point of a curve of equilibria, from which it turns back to smaller loads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum LimitPoint {
    /// Not looked at.
    #[default]
    Unknown,
    /// Looked at without an answer.
    Unclear,
    At(f64),
}

impl Outlook {
    /// Outlook of the body at rest.
    pub(crate) fn from(rest: &[f64]) -> Self {
        Self { points: vec![(0.0, rest.to_vec())], ..Self::default() }
    }

    pub(crate) fn reach(&mut self, place: f64, found: &Equilibrium) {
        if found.jumped {
            // The limit point of the branch left behind no longer counts.
            self.points.clear();
            (self.jumped, self.turn) = (true, LimitPoint::Unknown);
        }
        self.failed = false;
        self.points.push((place, found.unknowns.displacement.clone()));
        self.points.drain(..self.points.len().saturating_sub(POINTS));
        if self.refused.is_some_and(|refused| refused <= place) {
            (self.refused, self.turn) = (None, LimitPoint::Unknown);
        }
        // An equilibrium beyond the limit point is of another branch, or the limit lies farther on.
        if matches!(self.turn, LimitPoint::At(limit) if place > limit) {
            self.turn = LimitPoint::Unknown;
        }
    }

    pub(crate) fn refuse(&mut self, place: f64) {
        self.refused = Some(self.refused.map_or(place, |refused| refused.min(place)));
        self.failed = true;
    }

    /// Place of the foreseen limit point: the maximum of the parabola of places over displacement.
    pub(crate) fn limit(&self) -> Option<f64> {
        let [(a, from), (b, middle), (c, last)] = &self.points[..] else { return None };
        let [from, middle] = [from, middle].map(|to| difference(to, last));
        let length = norm(&middle);
        let [first, second] = [-dot(&from, &middle) / length, -length];
        let [before, after] = [(b - a) / (second - first), (c - b) / -second];
        let curvature = (after - before) / -first;
        let slope = after - curvature * second;
        let bends = first < second && curvature < 0.0 && *a < *b && *b < *c;
        bends.then(|| c + slope.max(0.0).powi(2) / (-4.0 * curvature))
    }

    /// Whether a limit point not yet examined is near: foreseen, or before a load that was refused.
    pub(crate) fn is_near(&self) -> bool {
        let (Some(_), [_, .., (reached, _)]) = (self.refused, &self.points[..]) else {
            return false;
        };
        let foreseen = self.limit().is_some_and(|limit| *reached >= NEAR * limit);
        self.turn == LimitPoint::Unknown && (foreseen || self.failed)
    }

    /// Place of the next equilibrium on the way to `goal`, in place of `target` after a failure.
    pub(crate) fn target(&self, target: f64, goal: f64) -> f64 {
        match (self.turn, self.refused, self.points.last(), self.limit()) {
            (LimitPoint::At(limit), ..) => goal.min(BEYOND * limit),
            (LimitPoint::Unknown, Some(_), Some((reached, _)), Some(limit)) if limit > *reached => {
                target.min(reached + ONWARD * (limit - reached))
            }
            _ => target,
        }
    }

    /// The limit point, if it was passed by arc length.
    pub(crate) fn ends(&self) -> Option<f64> {
        if let LimitPoint::At(limit) = self.turn { Some(limit) } else { None }
    }
}

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
        let apart = |a: &Point, b: &Point| norm(&self.way(&a.unknowns, &b.unknowns));
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
        self.scale = Some(scale);
        self.outlook.turn = self.turn(step);
        self.scale = None;
        self.options.iterations_per_load = per_load;
        self.points.iter_mut().for_each(|point| point.at = point.place);
        self.reached().place > start && self.outlook.turn == LimitPoint::Unknown
    }

    fn turn(&mut self, mut step: f64) -> LimitPoint {
        for _ in 0..MOST {
            let Point { at, place, .. } = *self.reached();
            let (guess, before) = (self.extrapolated(at + step), self.log.iterations.len());
            let Some((found, length)) = self.along(guess, ACCURACY, ASTRAY * step) else {
                step *= CUT;
                continue;
            };
            if found.place <= place {
                let unstable = found.negative_pivots > 0 || !self.system.body.has_potential();
                return if unstable { LimitPoint::At(place) } else { LimitPoint::Unclear };
            }
            self.push(at + length, &found);
            self.outlook.reach(found.place, &found);
            if self.outlook.refused.is_none() {
                return LimitPoint::Unknown;
            }
            step *= self.growth(before);
        }
        LimitPoint::Unclear
    }

    /// The next equilibrium on the curve near a predictor, with its distance from the last one along the curve, if that is at most `farthest`.
    pub(crate) fn along(
        &mut self,
        guess: Point,
        accuracy: f64,
        farthest: f64,
    ) -> Option<(Equilibrium, f64)> {
        let found = self.equilibrium(guess, accuracy)?;
        let length = self.length_to(&found);
        (length <= farthest).then_some((found, length))
    }

    /// Length of the curve from the last equilibrium to one near it.
    pub(crate) fn length_to(&self, found: &Equilibrium) -> f64 {
        let last = self.reached();
        norm(&self.way(&last.unknowns, &found.unknowns)).hypot(found.place - last.place)
    }

    /// Difference of the free displacements of two states \[relative to the scale, if there is one\].
    pub(crate) fn way(&self, from: &Unknowns, to: &Unknowns) -> Vec<f64> {
        let scale = self.scale.unwrap_or(1.0);
        let [from, to] = [from, to].map(|u| self.system.sparsity.gather(&u.displacement));
        to.zip(from).map(|(b, a)| (b - a) / scale).collect()
    }
}
