//! Curves of equilibria along lines in loads and parameters, by arc-length continuation, through limit points
//! (E. Riks, Int. J. Solids Struct. 15, 1979).
//!
//! The arc length combines the place on the line with the displacements, scaled by their rate at the start. The
//! predictor extrapolates the last equilibria, or follows the tangent where the two disagree. The corrector searches on
//! the plane through the predictor, normal to the step.

use crate::elements::{Unknowns, place};
use crate::linear::{dot, norm};
use crate::solve::{Equilibrium, FIRST_STEP, Line, Path, Plane, Point};
use crate::{Options, Result, Solution, SolveError, Solver};
use std::time::Instant;

/// Largest distance to the next equilibrium \[relative to the step\]; one farther off is on another branch.
const ASTRAY: f64 = 2.0;
/// Least cosine between the tangent and the extrapolated step.
const ALIGNED: f64 = 0.7;
/// A step after a failure, as a part of the one before.
const CUT: f64 = 0.5;

/// The curve of equilibria along a [`Line`]: an iterator over them in order, from that at the line's start to that at its end.
///
/// Beyond a limit point the place decreases. The curve ends at the end of the line, which it may never reach: take as
/// many points as needed. It also ends after an error, [`SolveError::CurveEnded`] with the last equilibrium.
#[doc(alias("arc length", "Riks", "continuation"))]
#[must_use = "an iterator does nothing until it is asked"]
pub struct Curve<'s, 'p> {
    path: Path<'s, 'p, 'static>,
    stage: Stage,
    /// Change of the unknowns from place to place at the last equilibrium, and whether places rise along the curve there.
    tangent: (Vec<f64>, bool),
    step: f64,
    least: f64,
    longest: f64,
}

/// An equilibrium on a [`Curve`].
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePoint {
    /// Place on the line, 1 at its end.
    pub place: f64,
    /// Length of the curve up to here.
    pub length: f64,
    /// The equilibrium.
    pub solution: Solution,
}

/// Next step of the continuation.
enum Stage {
    /// The equilibrium at the line's start.
    Start,
    /// Another one along the curve.
    Along,
    End,
}

impl<'p> Solver<'p> {
    /// The equilibria along a line in loads and parameters, through limit points.
    ///
    /// An arch that snaps through under its weight, half of it between two plates:
    ///
    /// ```
    /// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Line, Options, Solver};
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let mut mesh = box_tetrahedra([50.0, 4.0, 4.0], [8, 1, 1]).quadratic();
    /// mesh.map_points(|[x, y, z]| [x, y, z + 8.0 * (std::f64::consts::PI * x / 100.0).sin()]);
    /// let arch = Scene::new(mesh, NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    ///     .support(Support::clamped("x_min"))
    ///     .support(Support::uniform("x_max", [Some(0.0), None, None])) // the crown
    ///     .support(Support::uniform("y_min", [None, Some(0.0), None]))
    ///     .support(Support::uniform("y_max", [None, Some(0.0), None]))
    ///     .lower()?;
    /// let mut solver = Solver::new(&arch)?;
    /// let points = solver.follow(&Line::of_loads(&[75.0, 75.0]), &Options::default())?;
    /// let points = points.collect::<Result<Vec<_>, _>>()?;
    /// // Loads rise to a limit point, fall along states that are not stable, and rise again.
    /// let falling = points.windows(2).filter(|pair| pair[1].place < pair[0].place).count();
    /// let unstable = points.iter().filter(|point| !point.solution.is_stable()).count();
    /// assert!(falling > 0 && unstable > 0 && points[points.len() - 1].place == 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A line whose ends are not of the body or are the same.
    pub fn follow<'s>(&'s mut self, line: &Line, options: &Options) -> Result<Curve<'s, 'p>> {
        line.check(&self.system)?;
        let path = Path::from_rest(&mut self.system, line.clone(), options);
        let (stage, tangent, longest) = (Stage::Start, (Vec::new(), true), f64::INFINITY);
        Ok(Curve { path, stage, tangent, step: FIRST_STEP, least: 0.0, longest })
    }
}

impl Curve<'_, '_> {
    /// Bounds the arc length between two equilibria, for a smooth plot. The whole line is about 1.4 long where the body
    /// responds linearly.
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn with_longest_step(self, longest: f64) -> Result<Self> {
        if longest > 0.0 {
            return Ok(Self { step: self.step.min(longest), longest, ..self });
        }
        Err(SolveError::Line { problem: "its longest step is not positive" })
    }

    /// The equilibrium at the line's start.
    fn start(&mut self) -> Result<Equilibrium> {
        let path = &mut self.path;
        let (load, theta) = path.line.at(0.0);
        let rest = path.system.rest();
        let line = Line { load_factors: [0.0, load], thetas: [theta.clone(), theta] };
        let mut risen = Path::from_rest(path.system, line, &path.options);
        let (found, _) = risen.run(rest)?;
        path.log = risen.log;
        let unknowns = found.unknowns;
        if load == 0.0 {
            self.step = self.step.min(path.first_step());
        }
        self.least = path.options.least_load_step * self.step;
        let start = Point { at: 0.0, place: 0.0, unknowns, stress: None };
        let found = self.at_place(start).ok_or_else(|| self.lost())?;
        let free = self.path.system.sparsity.unknowns();
        let scale = norm(&found.by_place[..free]);
        self.path.scale = Some(if scale > 0.0 { scale } else { 1.0 });
        self.path.points.clear();
        self.path.push(0.0, &found);
        self.tangent = (found.by_place.clone(), true);
        Ok(found)
    }

    /// The next equilibrium.
    fn next_one(&mut self) -> Result<Equilibrium> {
        let most = self.path.options.iterations;
        while self.step >= self.least && self.path.log.iterations.len() < most {
            let before = self.path.log.iterations.len();
            let last = self.path.reached().clone();
            let (guess, farthest) = (self.guess(&last), ASTRAY * self.step);
            let found = self.path.along(guess, self.path.options.accuracy, farthest);
            let admissible = |(found, _): &(Equilibrium, f64)| {
                let (_, theta) = self.path.line.at(found.place);
                self.path.system.body.check_theta(&theta).is_ok()
            };
            let Some((found, moved)) = found.filter(admissible) else {
                self.step *= CUT;
                continue;
            };
            if last.place < 1.0 && found.place >= 1.0 {
                let end = self.at_place(between(&last, &found));
                if let Some(end) = end.filter(|end| self.path.length_to(end) <= farthest) {
                    self.stage = Stage::End;
                    self.path.push(last.at + self.path.length_to(&end), &end);
                    return Ok(end);
                }
                self.step *= CUT;
                continue;
            }
            let way = self.path.way(&last.unknowns, &found.unknowns);
            self.path.push(last.at + moved, &found);
            let rising = dot(&way, &self.scaled(&found.by_place)) + found.place - last.place > 0.0;
            self.tangent = (found.by_place.clone(), rising);
            let growth = self.path.growth(before);
            self.step = (moved * growth).min(self.longest);
            return Ok(found);
        }
        Err(self.lost())
    }

    /// The equilibrium at the place of a point, whether it is stable or not.
    fn at_place(&mut self, guess: Point) -> Option<Equilibrium> {
        let normal = (vec![0.0; self.path.system.sparsity.unknowns()], 1.0);
        let plane = Plane { normal, distance: guess.place };
        self.path.meeting(Some(&plane), guess, self.path.options.accuracy)
    }

    /// Predictor of the next equilibrium.
    fn guess(&mut self, last: &Point) -> Point {
        let (by_place, rising) = &self.tangent;
        let slope = self.scaled(by_place);
        let length = norm(&slope).hypot(1.0);
        let onward = self.step / if *rising { length } else { -length };
        if self.path.points.len() > 1 {
            let guess = self.path.extrapolated(last.at + self.step);
            let way = self.path.way(&last.unknowns, &guess.unknowns);
            let ahead = guess.place - last.place;
            let along = (dot(&way, &slope) + ahead) * onward.signum();
            if along > ALIGNED * length * norm(&way).hypot(ahead) {
                return guess;
            }
        }
        let system = &*self.path.system;
        let mut unknowns = last.unknowns.clone();
        let (free, pressures) = by_place.split_at(slope.len());
        system.sparsity.scatter(free.iter().map(|b| onward * b), &mut unknowns.displacement);
        unknowns.pressure.iter_mut().zip(pressures).for_each(|(p, b)| *p += onward * b);
        let at = last.place + onward;
        place(system.body, self.path.line.at(at).0, &mut unknowns.displacement);
        Point { at: last.at + self.step, place: at, unknowns, stress: None }
    }

    /// Free displacements of a change of the unknowns, scaled for the arc length.
    fn scaled(&self, change: &[f64]) -> Vec<f64> {
        let (free, scale) = (self.path.system.sparsity.unknowns(), self.path.scale);
        change.iter().take(free).map(|c| c / scale.unwrap_or(1.0)).collect()
    }

    /// Error of a curve that was lost after the last equilibrium.
    fn lost(&mut self) -> SolveError {
        let Path { system, line, .. } = &self.path;
        let worst_cells = system.assembly.worst_cells(system.body.points_per_cell);
        // Before the start was found, the point is the body at rest.
        let place = self.path.scale.map(|_| self.path.reached().place);
        let displacement = self.path.reached().unknowns.displacement.clone();
        let load_factor = place.map_or(0.0, |place| line.at(place).0);
        let failure = self.path.log.failure(load_factor, displacement, worst_cells, None);
        let Some(place) = place else { return SolveError::NotConverged(failure) };
        SolveError::CurveEnded { place, theta: self.path.line.at(place).1, failure }
    }
}

impl Iterator for Curve<'_, '_> {
    type Item = Result<CurvePoint>;

    fn next(&mut self) -> Option<Self::Item> {
        let start = Instant::now();
        let found = match std::mem::replace(&mut self.stage, Stage::Along) {
            Stage::Start => self.start(),
            Stage::Along => self.next_one(),
            Stage::End => {
                self.stage = Stage::End;
                return None;
            }
        };
        let point = found.map(|found| {
            let place = found.place;
            let (at, history) = (self.path.line.at(place), self.path.log.take());
            let length = self.path.reached().at;
            let solution = Solution::new(self.path.system, (found, 1), at, history, start);
            CurvePoint { place, length, solution }
        });
        if point.is_err() {
            self.stage = Stage::End;
        }
        Some(point)
    }
}

/// Linear interpolation at the end of the line.
fn between(from: &Point, to: &Equilibrium) -> Point {
    let part = (1.0 - from.place) / (to.place - from.place);
    let between = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + part * (b - a)).collect();
    let unknowns = Unknowns {
        displacement: between(&from.unknowns.displacement, &to.unknowns.displacement),
        pressure: between(&from.unknowns.pressure, &to.unknowns.pressure),
    };
    Point::at_end(unknowns)
}
