//! Nearly incompressible bodies, reached through ones with a smaller bulk modulus.

use crate::Options;
use crate::elements::system::Unknowns;
use crate::solve::path::Path;
use crate::solve::search::{Equilibrium, Goal, Point};
use sinew_energy::Body;

/// Factor of the bulk modulus from one softer body to the next: a hundredth needs a handful of iterations, and fewer
/// bodies than a tenth.
const SOFTER: f64 = 1e-2;
/// Number of softer bodies, enough for K/μ = 1e4.
const MOST_RUNGS: i32 = 2;

/// The load steps of a softer body get one half of all iterations.
const DETOUR: usize = 2;

impl Path<'_, '_, '_> {
    /// The body with a softer volumetric energy, if its law has one and the body a potential.
    pub(crate) fn softer_volume(&self) -> Option<Body> {
        self.system.body.has_potential().then(|| self.system.body.with_softer_volume(SOFTER))?
    }

    /// The equilibrium under the whole load, reached through bodies with a smaller bulk modulus, and the number of
    /// solves and load steps. A large bulk modulus shortens Newton steps from rest, but not those from the equilibrium
    /// of a softer body.
    pub(crate) fn by_softer_volume(&mut self) -> Option<(Equilibrium, usize)> {
        self.softer_volume()?;
        let mut rungs = 1..=MOST_RUNGS;
        let reached = rungs.find_map(|rung| Some((rung, self.softened(SOFTER.powi(rung), None)?)));
        let (rung, mut unknowns, mut steps) = match reached {
            Some((rung, unknowns)) => (rung, unknowns, 2),
            // None was found at once: the least softened body may be reached by load steps, longer than those of the
            // stiff body.
            None => {
                let (unknowns, steps) = self.softened_by_steps()?;
                (1, unknowns, 1 + steps)
            }
        };
        for rung in (1..rung).rev() {
            unknowns = self.softened(SOFTER.powi(rung), Some(unknowns))?;
            steps += 1;
        }
        Some((self.at_once(&unknowns, usize::MAX)?, steps))
    }

    /// The equilibrium of the body with a scaled bulk modulus, from a given state or from rest.
    fn softened(&mut self, factor: f64, from: Option<Unknowns>) -> Option<Unknowns> {
        let body = self.system.body.with_softer_volume(factor)?;
        let mut system = self.system.like(&body).ok()?;
        let start = Point::at_end(from.unwrap_or_else(|| system.rest()));
        let goal =
            Goal { line: &self.line, plane: None, accuracy: 0.0, most_indefinite: usize::MAX };
        system.equilibrium(start, goal, &self.options, &mut self.log).map(|found| found.unknowns)
    }

    /// Equilibrium with a hundredth of the bulk modulus by load increments, in at most half of all iterations.
    fn softened_by_steps(&mut self) -> Option<(Unknowns, usize)> {
        if self.options.least_load_step > self.options.first_load_step {
            return None;
        }
        let body = self.system.body.with_softer_volume(SOFTER)?;
        let mut system = self.system.like(&body).ok()?;
        let most = self.log.iterations.len() + self.options.iterations / DETOUR;
        let options = Options { iterations: most.min(self.options.iterations), ..self.options };
        let mut path = Path::from_rest(&mut system, self.line.clone(), &options);
        path.log = std::mem::take(&mut self.log);
        path.release_stresses();
        let step = path.first_step();
        let found = path.steps(step);
        self.log = path.log;
        found.ok().map(|(found, steps)| (found.unknowns, steps))
    }
}
