//! Following an equilibrium along a line in loads and parameters: place by place, by the volume that a pressure sweeps, or by the
//! length of the curve.

use crate::assembly::PredictedStress;
use crate::control::{Control, Plane};
use crate::line::Line;
use crate::newton::{Equilibrium, Goal, Start};
use crate::supports::place as place_supports;
use crate::system::{System, Unknowns};
use crate::vector::dot;
use crate::watch::Log;
use crate::{Options, SolveError};
use sinew_energy::PressureSurface;
use sinew_num::Mat3;

/// The first load step changes no displacement gradient by more than this, by the linear model of the body at rest.
const FIRST_GRADIENT: f64 = 0.25;
/// A body that does not minimise a potential starts in steps where the linear model foresees that the whole load changes a
/// displacement gradient by more than this: beams under a loose pressure wasted five iterations on the attempt.
const FAR: f64 = 2.5;
/// A step after a failure, and the least after a success, as a part of the one before.
const CUT: f64 = 0.5;
/// The same after a failure before anything was reached: what holds is looked for by orders of magnitude.
const SCAN: f64 = 0.2;
/// Equilibria that the next one is extrapolated from, without a field of pressure and with one. Those on the way are
/// rough, pressures more than displacements, and a curve through more of them goes astray: four take a third more
/// iterations on beams that roll up, three half as many again in incompressible bodies.
const POINTS: [usize; 2] = [3, 2];
/// Unbalanced forces \[relative to loads and reactions\] that a step should begin with. They grow with the step
/// to the power of the [`POINTS`], as the error of what is extrapolated; 0.1–0.3 take about as many iterations.
const BEGIN: f64 = 0.2;
/// Those of its second iteration, where that allows longer steps: bodies with a stiff response to changes of volume begin far from balance, and
/// are near to it at once. They grow with the step to twice that power, as errors of Newton's method. The softest inflated ventricle of
/// the hard cases takes 298 iterations, with a tenth of this 320.
const SECOND: f64 = 1e-2;
/// Below this part of the load, what holds is looked for to as many digits as it has: it is refused anyway.
const FAR_BELOW: f64 = 1e-2;
/// Nothing is looked for below this part of the load.
const LEAST_LOAD: f64 = 1e-12;

/// Resistance to changes of volume from one softer body to the next: from a hundredth a handful of iterations lead on, and fewer
/// bodies are tried than by tenths.
const SOFTER: f64 = 1e-2;
/// So many are tried: materials whose volume responds ten thousand times as stiffly as their shape.
const MOST_RUNGS: i32 = 2;

/// Its load steps get this part of all iterations.
const DETOUR: usize = 2;

/// What grows along a path.
pub(crate) enum Along {
    /// The place on the line.
    Place,
    /// The volume that a surface sweeps.
    Volume(PressureSurface),
    /// The length of the curve, in which displacements count relative to this \[length\].
    Arc(f64),
}

/// A point of a path.
#[derive(Clone)]
pub(crate) struct Point {
    /// Place, volume or length of the curve.
    pub at: f64,
    /// Place on the line.
    pub place: f64,
    pub unknowns: Unknowns,
    /// Stress at each quadrature point: on the way to another load it is smoother than what displacements that
    /// turn are extrapolated to.
    pub stress: Option<PredictedStress>,
}

/// A path of equilibria along a line.
pub(crate) struct Path<'s, 'p> {
    pub system: &'s mut System<'p>,
    pub line: Line,
    pub options: Options,
    pub along: Along,
    /// The last ones that were reached.
    pub points: Vec<Point>,
}

impl<'s, 'p> Path<'s, 'p> {
    /// The path of rising loads from the body at rest.
    pub(crate) fn to_load(system: &'s mut System<'p>, theta: &[f64], options: &Options) -> Self {
        Self::from_rest(system, Line::of_loads(theta), options)
    }

    /// A path from the body at rest, where its line has no loads.
    pub(crate) fn from_rest(system: &'s mut System<'p>, line: Line, options: &Options) -> Self {
        let rest = Point { at: 0.0, place: 0.0, unknowns: system.rest(), stress: None };
        Self { system, line, options: *options, along: Along::Place, points: vec![rest] }
    }

    /// The equilibrium under the whole load with the number of load steps: at once from where it should be, or else by
    /// steps from rest.
    ///
    /// # Errors
    /// [`SolveError::NotConverged`].
    pub(crate) fn run(
        mut self,
        from: Unknowns,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), SolveError> {
        let steps_allowed = self.options.least_load_step <= self.options.first_load_step;
        let balance = !self.system.has_potential() && steps_allowed;
        if !(balance && from == self.system.rest() && self.first_step() < FIRST_GRADIENT / FAR) {
            let whole = Point { at: 1.0, place: 1.0, unknowns: from, stress: None };
            if let Some(found) = self.equilibrium(whole, self.accuracy(), history) {
                return Ok((found, 1));
            }
            let tried = history.iterations.clone();
            if let Some(found) = self.by_softer_volume(history) {
                return Ok(found);
            }
            history.iterations = tried;
            if history.iterations.len() >= self.options.iterations || !steps_allowed {
                return Err(self.failure(history));
            }
        }
        self.release_stresses();
        let step = self.first_step();
        self.follow(1.0, step, history)
    }

    /// What stresses the body at rest grows with the loads.
    fn release_stresses(&mut self) {
        let [start, end] = &mut self.line.thetas;
        self.system.stressing_entries(end).into_iter().for_each(|entry| start[entry] = 0.0);
    }

    /// The equilibrium at another place or volume, with the number of steps that lead there.
    ///
    /// # Errors
    /// [`SolveError::NotConverged`].
    pub(crate) fn follow(
        &mut self,
        goal: f64,
        mut step: f64,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), SolveError> {
        let start = self.reached().at;
        if let [.., before, last] = &self.points[..] {
            let most = self.options.load_step_growth.max(CUT) * (last.at - before.at).abs();
            step = step.clamp(-most, most);
        }
        let mut steps = 0;
        let mut linear_iterations = 0;
        while !self.is_stuck(step, goal - start, history) {
            let reached = self.reached().at;
            let last = (goal - reached).abs() <= step.abs() * (1.0 + 1e-9);
            let target = if last { goal } else { reached + step };
            // A rough minimum may lie beyond the last that there is; down to rounding errors two iterations of each step find nothing more.
            let accuracy = match (last, self.system.has_potential()) {
                (true, _) => self.accuracy(),
                (false, true) => self.options.accuracy,
                (false, false) => self.options.accuracy_on_the_way,
            };
            let before = history.iterations.len();
            let guess = self.extrapolated(target);
            let Some(mut found) = self.equilibrium(guess, accuracy, history) else {
                step *= if reached == start { SCAN } else { CUT };
                continue;
            };
            steps += 1;
            linear_iterations += found.linear_iterations;
            self.push(target, &found);
            if last {
                found.linear_iterations = linear_iterations;
                return Ok((found, steps));
            }
            let left = history.iterations[before..].iter().map(|iteration| iteration.residual);
            step *= self.growth(&found, left);
        }
        Err(self.failure(history))
    }

    /// Goes on from an equilibrium.
    pub(crate) fn push(&mut self, at: f64, found: &Equilibrium) {
        let stress = Some(self.system.assembly.stress());
        let Equilibrium { unknowns, place, .. } = found;
        // One that was come to again takes the place of the first: curves go through points at different places.
        self.points.retain(|point| point.at != at);
        self.points.push(Point { at, place: *place, unknowns: unknowns.clone(), stress });
        self.points.drain(..self.points.len().saturating_sub(self.most_points()));
    }

    /// The next step as a multiple of the one that led to an equilibrium, with the unbalanced forces of its iterations.
    pub(crate) fn growth(&self, found: &Equilibrium, mut left: impl Iterator<Item = f64>) -> f64 {
        let scale = found.force_scale.max(f64::MIN_POSITIVE);
        let mut change = |goal: f64, power: f64| {
            let began = left.next().unwrap_or(f64::MAX) / scale;
            (goal / began).powf(1.0 / (power * self.most_points() as f64))
        };
        let (first, second) = (change(BEGIN, 1.0), change(SECOND, 2.0));
        first.max(second).clamp(CUT, self.options.load_step_growth.max(CUT))
    }

    pub(crate) fn reached(&self) -> &Point {
        &self.points[self.points.len() - 1]
    }

    fn most_points(&self) -> usize {
        POINTS[usize::from(self.system.coupling.is_some())]
    }

    /// Unbalanced forces and volumes \[relative\] of the equilibria that are asked for: a potential's are down to what
    /// rounding errors amount to.
    fn accuracy(&self) -> f64 {
        let minimised = self.system.has_potential() && matches!(self.along, Along::Place);
        if minimised { 0.0 } else { self.options.accuracy }
    }

    /// Whether steps have become too short, or iterations run out.
    fn is_stuck(&self, step: f64, whole: f64, history: &Log<'_>) -> bool {
        let part = if whole == 0.0 { 1.0 } else { (step / whole).abs() };
        let reached = match self.along {
            Along::Place => self.reached().at,
            Along::Volume(_) | Along::Arc(_) => 1.0,
        };
        let coarse = if reached < FAR_BELOW { FAR_BELOW } else { 0.0 };
        let least = self.options.least_load_step.max(coarse) * reached;
        // Written so that a NaN is stuck as well.
        let going = part >= least && part >= LEAST_LOAD;
        !going || history.iterations.len() >= self.options.iterations
    }

    pub(crate) fn equilibrium(
        &mut self,
        guess: Point,
        accuracy: f64,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let control = match &self.along {
            Along::Place => None,
            Along::Volume(surface) => Some(Control::Volume(surface.clone(), guess.at)),
            Along::Arc(scale) => Some(Control::Plane(self.plane(&guess, *scale))),
        };
        self.meeting(control.as_ref(), guess, accuracy, history)
    }

    /// The equilibrium near a point that meets a control, or at its place.
    pub(crate) fn meeting(
        &mut self,
        control: Option<&Control>,
        guess: Point,
        accuracy: f64,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let goal = Goal { line: &self.line, control, accuracy };
        let Point { unknowns, place, stress, .. } = guess;
        self.system.equilibrium(Start { unknowns, place, stress }, goal, &self.options, history)
    }

    /// The plane through a point across the way to it from the last one.
    fn plane(&self, to: &Point, scale: f64) -> Plane {
        let [from, to] = [self.reached(), to].map(|point| {
            let free = self.system.sparsity.gather(&point.unknowns.displacement);
            (free.map(|u| u / scale).collect::<Vec<_>>(), point.place)
        });
        let way: Vec<f64> = to.0.iter().zip(&from.0).map(|(b, a)| b - a).collect();
        let onward = to.1 - from.1;
        let length = dot(&way, &way).sqrt().hypot(onward);
        let distance = (dot(&way, &to.0) + onward * to.1) / length;
        let slope = way.iter().map(|w| w / (scale * length)).collect();
        Plane { normal: (slope, onward / length), distance }
    }

    /// Part of the load that changes no displacement gradient by more than [`FIRST_GRADIENT`].
    pub(crate) fn first_step(&mut self) -> f64 {
        let most = self.options.first_load_step;
        let Ok(motion) = self.system.linear_response(&self.line.thetas[1]) else { return most };
        let body = self.system.body;
        let size = |h: Mat3<f64>| h.squared_norm().sqrt();
        let gradients = (0..body.volumes.len()).map(|p| body.displacement_gradient(p, &motion));
        let largest = gradients.map(size).fold(0.0, f64::max) * self.line.load_factors[1].abs();
        let step = (FIRST_GRADIENT / largest).min(most);
        if step > LEAST_LOAD { step } else { most }
    }

    /// The equilibrium under the whole load by way of bodies that resist changes of volume less, with the number of those and of their
    /// load steps: a penalty on them that is large beside the rest keeps steps short, which a step from the equilibrium of a hundredth of
    /// it need not be.
    fn by_softer_volume(&mut self, history: &mut Log<'_>) -> Option<(Equilibrium, usize)> {
        if !self.system.has_potential() {
            return None;
        }
        let mut rungs = 1..=MOST_RUNGS;
        let reached =
            rungs.find_map(|rung| Some((rung, self.softened(SOFTER.powi(rung), None, history)?)));
        let (rung, mut unknowns, mut steps) = match reached {
            Some((rung, unknowns)) => (rung, unknowns, 2),
            // The softest has no equilibrium near; the first may be reached by load steps, which its softness allows to be longer.
            None => {
                let (unknowns, steps) = self.softened_by_steps(history)?;
                (1, unknowns, 1 + steps)
            }
        };
        for rung in (1..rung).rev() {
            unknowns = self.softened(SOFTER.powi(rung), Some(unknowns), history)?;
            steps += 1;
        }
        let whole = Point { at: 1.0, place: 1.0, unknowns, stress: None };
        Some((self.equilibrium(whole, self.accuracy(), history)?, steps))
    }

    /// The equilibrium of a body that resists changes of volume so many times as much, from another or from rest.
    fn softened(
        &self,
        factor: f64,
        from: Option<Unknowns>,
        history: &mut Log<'_>,
    ) -> Option<Unknowns> {
        let body = self.system.body.with_softer_volume(factor)?;
        let mut system = System::new(&body).ok()?;
        let unknowns = from.unwrap_or_else(|| system.rest());
        let start = Start { unknowns, place: 1.0, stress: None };
        let goal = Goal { line: &self.line, control: None, accuracy: 0.0 };
        system.equilibrium(start, goal, &self.options, history).map(|found| found.unknowns)
    }

    /// That of a hundredth of the resistance by load steps, of which it takes a part of all iterations at most.
    fn softened_by_steps(&self, history: &mut Log<'_>) -> Option<(Unknowns, usize)> {
        if self.options.least_load_step > self.options.first_load_step {
            return None;
        }
        let body = self.system.body.with_softer_volume(SOFTER)?;
        let mut system = System::new(&body).ok()?;
        let most = history.iterations.len() + self.options.iterations / DETOUR;
        let options = Options { iterations: most.min(self.options.iterations), ..self.options };
        let mut path = Path::from_rest(&mut system, self.line.clone(), &options);
        path.release_stresses();
        let step = path.first_step();
        let (found, steps) = path.follow(1.0, step, history).ok()?;
        Some((found.unknowns, steps))
    }

    /// What is returned where a path ends: the last equilibrium, as accurate as any.
    fn failure(&mut self, history: &mut Log<'_>) -> SolveError {
        let worst_cells = self.system.assembly.worst_cells(self.system.body.points_per_cell);
        // A rough equilibrium that none is near was beyond the last.
        while let Some(point) = self.points.pop() {
            let ((load_factor, _), rest) = (self.line.at(point.place), point.at == 0.0);
            let found = self.equilibrium(point.clone(), self.accuracy(), &mut Log::default());
            let displacement = match found {
                Some(found) => found.unknowns.displacement,
                None if rest => point.unknowns.displacement,
                None => continue,
            };
            return history.failure(load_factor, displacement, worst_cells);
        }
        let rest = self.system.rest().displacement;
        history.failure(0.0, rest, worst_cells)
    }

    /// The point on the curve through the last ones, which are at different places.
    pub(crate) fn extrapolated(&mut self, at: f64) -> Point {
        let points = &self.points;
        let weights = points.iter().map(|point| {
            let others = points.iter().map(|other| other.at).filter(|&other| other != point.at);
            others.map(|other| (at - other) / (point.at - other)).product::<f64>()
        });
        let terms: Vec<_> = weights.zip(points).collect();
        let of = |part: fn(&Point) -> &Vec<f64>| combined(&terms, part);
        let (mut displacement, pressure) =
            (of(|p| &p.unknowns.displacement), of(|p| &p.unknowns.pressure));
        let place = match self.along {
            Along::Place => at,
            _ => terms.iter().map(|(weight, p)| weight * p.place).sum(),
        };
        let (load_factor, _) = self.line.at(place);
        let earlier: Vec<_> =
            terms.iter().map(|(weight, p)| (*weight, &p.unknowns.displacement[..])).collect();
        self.system.turn_along(&earlier, load_factor, &mut displacement);
        // Weights sum up to one but for rounding, which is no motion of a support.
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

/// A weighted sum of a part of some points.
fn combined(terms: &[(f64, &Point)], part: fn(&Point) -> &Vec<f64>) -> Vec<f64> {
    let mut sum = vec![0.0; terms.first().map_or(0, |(_, point)| part(point).len())];
    for (weight, point) in terms {
        sum.iter_mut().zip(part(point)).for_each(|(s, v)| *s += weight * v);
    }
    sum
}
