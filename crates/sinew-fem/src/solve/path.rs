//! Continuation of an equilibrium along a line in loads and parameters, by load or arc length.

use crate::elements::{PredictedStress, System, Unknowns, place as place_supports};
use crate::linear::systems::CORRECTION;
use crate::linear::{MOST_SINGLE, difference, dot};
use crate::solve::{Equilibrium, Goal, Line, Log, Outlook, Plane, Point, far_turn};
use crate::{Advice, Options, SolveError};
use sinew_num::Mat3;

/// The first load step changes no displacement gradient by more than this, by the linear model of the body at rest.
pub(crate) const FIRST_GRADIENT: f64 = 0.25;
/// Largest first load step [part of the load]. Slender bodies start with less, by the linear model at rest.
pub(crate) const FIRST_STEP: f64 = 0.25;
/// Factor of a step after a failure, and the least and the largest factor after a success.
const CUT: f64 = 0.5;
const GROWTH: f64 = 2.0;
/// Factor of a step after a failure of the first one: it finds the order of magnitude of the load quickly.
const SCAN: f64 = 0.2;
/// Equilibria that the next one is extrapolated from, without a field of pressure and with one. Intermediate equilibria
/// are rough, pressures more than displacements, and higher polynomials amplify it: cubic extrapolation takes a third
/// more iterations on beams that roll up, quadratic half as many again in incompressible bodies.
const POINTS: [usize; 2] = [3, 2];
/// Residual of intermediate equilibria without a potential \[relative to loads and reactions\].
pub(crate) const ON_THE_WAY: f64 = 1e-2;
/// Residual \[relative to loads and reactions\] that a step should begin with. It grows as the extrapolation error, the
/// step to the power of [`POINTS`]; 0.1–0.3 take about as many iterations.
const BEGIN: f64 = 0.2;
/// Residual that the second iteration should begin with, if this allows longer steps: nearly incompressible bodies
/// begin far from equilibrium but are near after one iteration. It grows with twice that power (Newton's method). The
/// softest inflated ventricle of the hard cases takes 298 iterations, and 320 with a tenth of this.
const SECOND: f64 = 1e-2;
/// Part of the load below which the largest bearable load is sought to two digits only: the solve fails anyway.
const FAR_BELOW: f64 = 1e-2;
/// Smallest part of the load that is tried.
const LEAST_LOAD: f64 = 1e-12;

/// Successive steps with an indefinite stiffness that end a search at an intermediate load; a shorter load step costs
/// less. Searches that succeed take fewer.
const MOST_INDEFINITE: usize = 8;

/// A path of equilibria along a line.
pub(crate) struct Path<'s, 'p, 'w> {
    pub system: &'s mut System<'p>,
    pub line: Line,
    pub options: Options,
    /// Scale of displacements \[length\] in the arc length that grows along the path; `None` where the place on the line does.
    pub scale: Option<f64>,
    /// The last ones that were reached.
    pub points: Vec<Point>,
    /// Extrapolation to larger loads.
    pub outlook: Outlook,
    pub log: Log<'w>,
}

impl<'s, 'p, 'w> Path<'s, 'p, 'w> {
    /// A path from the body at rest, where its line has no loads.
    pub(crate) fn from_rest(system: &'s mut System<'p>, line: Line, options: &Options) -> Self {
        let rest = Point { at: 0.0, place: 0.0, unknowns: system.rest(), stress: None };
        let (scale, outlook) = (None, Outlook::from(&rest.unknowns.displacement));
        let (options, points, log) = (*options, vec![rest], Log::default());
        Self { system, line, options, scale, points, outlook, log }
    }

    /// Lets the stress at rest, such as active stress, grow with the loads.
    pub(crate) fn release_stresses(&mut self) {
        let [start, end] = &mut self.line.thetas;
        self.system.stressing_entries(end).into_iter().for_each(|entry| start[entry] = 0.0);
    }

    /// The equilibrium at the end of the line with the number of steps that lead there, or the reason for its absence, where that is known.
    pub(crate) fn steps(&mut self, mut step: f64) -> Result<(Equilibrium, usize), Option<Advice>> {
        let start = self.reached().at;
        if let [.., before, last] = &self.points[..] {
            step = step.min(GROWTH * (last.at - before.at));
        }
        let mut steps = 0;
        let mut linear_iterations = 0;
        while !self.is_stuck((step / (1.0 - start)).abs()) {
            let reached = self.reached().at;
            // Arc length may have passed the end, from where steps go back.
            let ends = (1.0 - reached).abs() <= step.abs() * (1.0 + 1e-9);
            let wanted = if ends { 1.0 } else { reached + step.copysign(1.0 - reached) };
            if reached < 1.0 && self.outlook.is_near() && self.around(step.abs()) {
                continue;
            }
            let target = self.outlook.target(wanted, 1.0);
            let last = target == 1.0;
            // A rough minimum may lie beyond the limit point; accuracy to rounding errors costs two more iterations a
            // step for nothing.
            let accuracy = match (last, self.system.body.has_potential()) {
                (true, _) => self.accuracy(),
                (false, true) => self.options.accuracy,
                (false, false) => ON_THE_WAY,
            };
            let before = self.log.iterations.len();
            let guess = self.extrapolated(target);
            let Some(mut found) = self.equilibrium(guess, accuracy) else {
                if let Some(advice) = self.refused() {
                    return Err(Some(advice));
                }
                self.outlook.refuse(target);
                // A search that ran out of iterations is no evidence.
                let searched = self.log.iterations.len() < self.options.iterations;
                if let (Some(limit), true) = (self.outlook.ends(), searched) {
                    return Err(Some(Advice::LimitPoint { limit, refused: target }));
                }
                step = (target - reached) * if reached == start { SCAN } else { CUT };
                continue;
            };
            steps += 1;
            linear_iterations += found.linear_iterations;
            self.push(target, &found);
            self.outlook.reach(target, &found);
            if last {
                found.linear_iterations = linear_iterations;
                found.jumped = self.outlook.jumped;
                return Ok((found, steps));
            }
            step = (target - reached) * self.growth(before);
        }
        Err(None)
    }

    /// Goes on from an equilibrium.
    pub(crate) fn push(&mut self, at: f64, found: &Equilibrium) {
        let stress = Some(self.system.assembly.stress());
        let Equilibrium { unknowns, place, .. } = found;
        // Extrapolation needs points at different places, so a repeated one replaces the first.
        self.points.retain(|point| point.at != at);
        self.points.push(Point { at, place: *place, unknowns: unknowns.clone(), stress });
        self.points.drain(..self.points.len().saturating_sub(self.most_points()));
    }

    /// The next step as a multiple of the one that led to the assembled equilibrium, by the unbalanced forces of the
    /// iterations since it began.
    pub(crate) fn growth(&self, before: usize) -> f64 {
        let scale = self.system.assembly.force_scale.max(f64::MIN_POSITIVE);
        let mut left = self.log.iterations[before..].iter().map(|iteration| iteration.residual);
        let mut change = |goal: f64, power: f64| {
            let began = left.next().unwrap_or(f64::MAX) / scale;
            (goal / began).powf(1.0 / (power * self.most_points() as f64))
        };
        let (first, second) = (change(BEGIN, 1.0), change(SECOND, 2.0));
        first.max(second).clamp(CUT, GROWTH)
    }

    pub(crate) fn reached(&self) -> &Point {
        &self.points[self.points.len() - 1]
    }

    fn most_points(&self) -> usize {
        POINTS[usize::from(self.system.coupling.is_some())]
    }

    /// Relative residual of the final equilibria; 0 for minima of a potential, which are solved to rounding errors.
    pub(crate) fn accuracy(&self) -> f64 {
        let Options { minimum_accuracy, accuracy, .. } = self.options;
        if self.system.body.has_potential() { minimum_accuracy } else { accuracy }
    }

    /// The reason of the last failure, if it is the size of a factor.
    pub(crate) fn refused(&self) -> Option<Advice> {
        let gigabytes = |entries: usize| (entries * size_of::<f64>()) as f64 / 1e9;
        let System { factor, sparsity, refused, .. } = &*self.system;
        refused.then(|| Advice::FactorTooLarge {
            unknowns: sparsity.unknowns(),
            gigabytes: gigabytes(factor.entries()),
            most: gigabytes(MOST_SINGLE),
        })
    }

    /// Whether a step, as a part of the whole way, has become too short, or iterations run out.
    fn is_stuck(&self, part: f64) -> bool {
        let reached = self.reached().at;
        let coarse = if reached < FAR_BELOW { FAR_BELOW } else { 0.0 };
        let least = self.options.least_load_step.max(coarse) * reached;
        // Written so that a NaN is stuck as well.
        let going = part >= least && part >= LEAST_LOAD;
        !going || self.log.iterations.len() >= self.options.iterations
    }

    pub(crate) fn equilibrium(&mut self, guess: Point, accuracy: f64) -> Option<Equilibrium> {
        let plane = self.scale.map(|scale| self.plane(&guess, scale));
        self.meeting(plane.as_ref(), guess, accuracy)
    }

    /// The equilibrium near a point that lies on a plane, or at its place.
    pub(crate) fn meeting(
        &mut self,
        plane: Option<&Plane>,
        guess: Point,
        accuracy: f64,
    ) -> Option<Equilibrium> {
        let goal = Goal { line: &self.line, plane, accuracy, most_indefinite: MOST_INDEFINITE };
        self.system.equilibrium(guess, goal, &self.options, &mut self.log)
    }

    /// The plane through a point across the way to it from the last one.
    fn plane(&self, to: &Point, scale: f64) -> Plane {
        let [from, to] = [self.reached(), to].map(|point| {
            let free = self.system.sparsity.gather(&point.unknowns.displacement);
            (free.map(|u| u / scale).collect::<Vec<_>>(), point.place)
        });
        let way = difference(&to.0, &from.0);
        let onward = to.1 - from.1;
        let length = dot(&way, &way).sqrt().hypot(onward);
        let distance = (dot(&way, &to.0) + onward * to.1) / length;
        let slope = way.iter().map(|w| w / (scale * length)).collect();
        Plane { normal: (slope, onward / length), distance }
    }

    /// Part of the load that changes no displacement gradient by more than [`FIRST_GRADIENT`].
    pub(crate) fn first_step(&mut self) -> f64 {
        let motion = self.system.linear_response(&self.line.thetas[1], CORRECTION);
        let Ok(motion) = motion else { return FIRST_STEP };
        let largest = self.system.largest_gradient(&motion) * self.line.load_factors[1].abs();
        let step = (FIRST_GRADIENT / largest).min(FIRST_STEP);
        if step > LEAST_LOAD { step } else { FIRST_STEP }
    }

    /// Error with the last equilibrium of a path, solved to full accuracy, and with the given advice or that of the
    /// last iterations.
    pub(crate) fn failure(&mut self, advice: Option<Advice>) -> SolveError {
        let turned = far_turn(self.system.body).map(|degrees| Advice::Turned { degrees });
        let advice = turned.or(advice);
        let worst_cells = self.system.assembly.worst_cells(self.system.body.points_per_cell);
        let mut log = std::mem::take(&mut self.log);
        let (mut load_factor, mut reached) = (0.0, self.system.rest());
        // A rough equilibrium with no accurate one nearby was beyond the limit point.
        while let Some(point) = self.points.pop() {
            self.log = Log::default();
            let found = self.equilibrium(point.clone(), self.accuracy());
            if found.is_some() || point.at == 0.0 {
                (load_factor, _) = self.line.at(point.place);
                reached = found.map_or(point.unknowns, |found| found.unknowns);
                break;
            }
        }
        let failure = log.failure(load_factor, reached.displacement, worst_cells, advice);
        SolveError::NotConverged(failure)
    }

    /// Polynomial extrapolation of the last points.
    pub(crate) fn extrapolated(&mut self, at: f64) -> Point {
        let points = &self.points;
        let weights = points.iter().map(|point| {
            let others = points.iter().map(|other| other.at).filter(|&other| other != point.at);
            others.map(|other| (at - other) / (point.at - other)).product::<f64>()
        });
        let terms: Vec<_> = weights.zip(points).collect();
        let of = |part: fn(&Point) -> &Vec<f64>| {
            let mut sum = vec![0.0; terms.first().map_or(0, |(_, point)| part(point).len())];
            for (weight, point) in &terms {
                sum.iter_mut().zip(part(point)).for_each(|(s, v)| *s += weight * v);
            }
            sum
        };
        let (mut displacement, pressure) =
            (of(|p| &p.unknowns.displacement), of(|p| &p.unknowns.pressure));
        let place = match self.scale {
            None => at,
            _ => terms.iter().map(|(weight, p)| weight * p.place).sum(),
        };
        let (load_factor, _) = self.line.at(place);
        let earlier: Vec<_> =
            terms.iter().map(|(weight, p)| (*weight, &p.unknowns.displacement[..])).collect();
        self.system.turn_along(&earlier, load_factor, &mut displacement);
        // The weights sum to one only to rounding, which must not move supports.
        place_supports(self.system.body, load_factor, &mut displacement);
        // The body at rest bears none.
        let mut stress: Option<PredictedStress> = None;
        for (weight, point) in terms {
            let Some(of_point) = &point.stress else { continue };
            let sum = stress.get_or_insert_with(|| vec![Mat3::ZERO; of_point.len()]);
            for (sum, s) in sum.iter_mut().zip(of_point) {
                *sum = Mat3::from_fn(|i, j| sum[i][j] + weight * s[i][j]);
            }
        }
        Point { at, place, unknowns: Unknowns { displacement, pressure }, stress }
    }
}
