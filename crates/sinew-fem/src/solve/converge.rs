//! Quasi-Newton iteration to a relative error, estimated from its contraction, without a factorisation.

use crate::elements::supports::place;
use crate::linear::vector::norm;
use crate::solve::frozen_tangent::{BALANCED, Memory, NOISE, Potential};
use crate::{SolveError, Solver};
use sinew_energy::Body;
use sinew_energy::metrics::mean_and_largest;

/// Contraction ratio of the steps that would follow, at least.
const CONTRACTS: f64 = 0.5;
/// Least ratio of an estimate to the one before that counts: a single one may be small by chance.
const LEAST: f64 = 0.5;
/// Steps that are required where none contracted at a neighbour, and steps whose largest ratio counts.
const SEEN: usize = 2;
/// Longest first step \[relative to the displacement\]: from farther off, small steps may end where a soft mode still misses much.
const FARTHEST: f64 = 0.1;
/// Safety factor on the series of steps that would follow: compliant modes contract more slowly than those that
/// dominate a step. The error is at most twelve times an estimate with the ratio [`CONTRACTS`]; it was at most 5.5 times in 5700 states on
/// thirteen bodies.
const SAFETY: f64 = 6.0;

/// Last displacement of a quasi-Newton iteration, from [`Solver::converge`].
#[derive(Clone, Debug, PartialEq)]
pub struct Converged {
    /// Displacement, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Estimated mean nodal distance to the equilibrium, relative to the mean nodal displacement; infinite where the steps did not contract
    /// enough.
    pub error: f64,
    /// Quasi-Newton steps: a gradient and two or three back-substitutions each.
    pub steps: usize,
}

impl Solver<'_> {
    /// Quasi-Newton steps at θ from a displacement \[length\], with the last factorised stiffness, until the estimated
    /// error is below `accuracy` \[relative to the mean nodal displacement\]; where `most` steps do not reach it,
    /// [`Converged::error`] is infinite.
    ///
    /// The next step is computed but not taken. Its length without the scale of the last step, or that of the frozen stiffness alone if
    /// it is longer, bounds the error with its contraction ratio (P. Deuflhard, Newton Methods for Nonlinear Problems, 2011,
    /// section 2.1). Use the stiffness of a neighbouring equilibrium, from [`Solver::error_estimate`] or [`Solver::solve`]. The error is
    /// infinite also where the energy is above that of the body at rest.
    ///
    /// ```
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Solver};
    /// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let mut solver = Solver::new(&beam)?;
    /// let near = solver.solve(&[55.0, 85.0], &Options::default())?.displacement;
    /// let found = solver.converge(&near, &[50.0, 90.0], 1e-4, 8)?;
    /// assert!(found.error <= 1e-4 && found.steps <= 4); // no factorisation
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Singular`] where nothing was factorised.
    #[doc(alias("L-BFGS", "quasi-Newton"))]
    pub fn converge(
        &self,
        from: &[f64],
        theta: &[f64],
        accuracy: f64,
        most: usize,
    ) -> Result<Converged, SolveError> {
        self.converged(from, theta, (accuracy, most), SEEN)
    }

    /// [`Solver::converge`] where steps with the same stiffness contracted at a neighbouring θ. An accurate prediction
    /// is returned unchanged after one computed step, with an assumed contraction ratio of one half.
    ///
    /// # Errors
    /// As for [`Solver::converge`].
    pub fn converge_near(
        &self,
        from: &[f64],
        theta: &[f64],
        accuracy: f64,
        most: usize,
    ) -> Result<Converged, SolveError> {
        self.converged(from, theta, (accuracy, most), 0)
    }

    fn converged(
        &self,
        from: &[f64],
        theta: &[f64],
        (accuracy, most): (f64, usize),
        seen: usize,
    ) -> Result<Converged, SolveError> {
        let (body, system) = (self.body(), &self.system);
        self.check(from, theta)?;
        let potential = Potential { body, theta, frames: &body.frames };
        let mut first = from.to_vec();
        place(body, 1.0, &mut first);
        let mut at = system.at(first, potential);
        let mean = |free: &[f64]| {
            let mut step = vec![0.0; from.len()];
            system.sparsity.scatter_along(potential.frames, free.iter().copied(), &mut step);
            mean_and_largest(&step)[0]
        };
        let (mut memory, mut lengths) = (Memory::default(), Vec::new());
        for steps in 0..=most {
            if !(at.energy.is_finite() && at.slope.iter().all(|g| g.is_finite())) {
                break;
            }
            let direction = memory.direction(system, &at, potential.frames);
            if !direction.iter().all(|d| d.is_finite()) {
                return Err(SolveError::Singular);
            }
            let [frozen, updated] = memory.estimates();
            lengths.push(mean(&frozen).max(mean(&updated)));
            let balanced = norm(&at.slope) <= BALANCED * at.force_scale(potential);
            let [size, _] = mean_and_largest(&at.displacement);
            let error = if balanced { 0.0 } else { left_open(&lengths, seen) / size };
            if error <= accuracy {
                let error = if below_rest(body, theta, at.energy) { error } else { f64::INFINITY };
                return Ok(Converged { displacement: at.displacement, error, steps });
            }
            let first = memory.pairs.is_empty();
            if first && lengths[0] > FARTHEST * size {
                break;
            }
            let Some(next) = system.step_along(&at, &direction, potential, first) else { break };
            at = next;
        }
        let (displacement, steps) = (at.displacement, lengths.len().saturating_sub(1));
        Ok(Converged { displacement, error: f64::INFINITY, steps })
    }
}

/// Whether an energy is at most that of the body at rest, where supports leave it at rest.
fn below_rest(body: &Body, theta: &[f64], energy: f64) -> bool {
    let rest = body.prescribed.iter().all(|u| u.is_none_or(|u| u == 0.0));
    !rest || energy <= body.value(&vec![0.0; 3 * body.nodes], theta) + NOISE * energy.abs()
}

/// Length of the series that continues the last estimate, from at least `seen` steps before it; infinite where one of the last two
/// steps lengthened it.
fn left_open(lengths: &[f64], seen: usize) -> f64 {
    let tail = &lengths[lengths.len().saturating_sub(SEEN + 1)..];
    let ratio = tail.windows(2).map(|pair| pair[1] / pair[0]).fold(CONTRACTS, f64::max);
    let [.., last] = tail else { return f64::INFINITY };
    let before = tail.iter().rev().nth(1).map_or(0.0, |before| LEAST * before);
    let known = lengths.len() > seen && ratio < 1.0;
    if known { SAFETY * last.max(before) / (1.0 - ratio) } else { f64::INFINITY }
}
