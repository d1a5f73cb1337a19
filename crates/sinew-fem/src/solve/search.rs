//! Lines in loads and parameters, the state of a search for an equilibrium on one, the constraint of one whose place on its line is unknown,
//! and the result of a solve.

use crate::elements::{PredictedStress, Residual, State, System, Unknowns};
use crate::linear::dot;
use crate::{History, Result, SolveError};
use sinew_energy::metrics::mean_and_largest;
use std::time::Instant;

/// Goal of a search: an equilibrium at one place of a line in loads and parameters, or wherever on it something else is met.
#[derive(Clone, Copy)]
pub(crate) struct Goal<'a> {
    pub line: &'a Line,
    /// Constraint where the place is unknown.
    pub plane: Option<&'a Plane>,
    /// Unbalanced forces and volumes \[relative\] that are enough without a potential, or on the way to another load.
    pub accuracy: f64,
    /// Steps in a row with an indefinite stiffness that end the search for a minimum.
    pub most_indefinite: usize,
}

/// A point of a path: an equilibrium, or the start of a search for one.
#[derive(Clone)]
pub(crate) struct Point {
    /// Place or length of the curve.
    pub at: f64,
    /// Place on the line.
    pub place: f64,
    pub unknowns: Unknowns,
    /// Stress at each quadrature point, which the geometric stiffness is built from at first, if that of the start is not to be trusted:
    /// it extrapolates more smoothly than rotating displacements.
    pub stress: Option<PredictedStress>,
}

impl Point {
    /// Start of a search under the whole load.
    pub(crate) fn at_end(unknowns: Unknowns) -> Self {
        Self { at: 1.0, place: 1.0, unknowns, stress: None }
    }
}

/// An equilibrium at one load, before it is reported.
#[derive(Clone, Debug)]
pub(crate) struct Equilibrium {
    pub unknowns: Unknowns,
    /// Place on the line.
    pub place: f64,
    pub residual: Residual,
    pub negative_pivots: usize,
    pub linear_iterations: usize,
    /// Whether the search for a minimum met an indefinite stiffness.
    pub jumped: bool,
    /// Change of the unknowns (free displacements, then pressures) from place to place, where one was controlled.
    pub by_place: Vec<f64>,
}

/// A point that the search may return to.
pub(crate) struct Watchdog {
    pub displacement: Vec<f64>,
    pub energy: f64,
}

/// The state of one search.
pub(crate) struct Search<'a> {
    pub goal: Goal<'a>,
    pub place: f64,
    /// Loads and parameters there.
    pub load_factor: f64,
    pub theta: Vec<f64>,
    pub at: Unknowns,
    pub predicted: Option<PredictedStress>,
    pub watchdog: Option<Watchdog>,
    /// Steps that have raised the energy since it was lowest.
    pub rises: usize,
    pub negative_pivots: Option<usize>,
    /// Residual of the step before \[stress·length²\], 0 at first.
    pub last_residual: f64,
    /// Whether the last step was shorter than a full one, or of a shifted stiffness: the next stiffness is unlike it.
    pub stale: bool,
    pub linear_iterations: usize,
    pub jumped: bool,
    pub by_place: Vec<f64>,
}

/// Largest residual of an inexact step \[relative to the forces\], and that after a shifted or shortened step, where accuracy saves none. A ventricle of 28 231 nodes
/// takes 21 steps with 0.1, 14 with 0.03 and with 0.01.
const LARGEST_FORCING: f64 = 0.03;
const STALE_FORCING: f64 = 0.1;
/// Least one: a step this accurate reaches rounding errors.
const LEAST_FORCING: f64 = 1e-8;
/// Constant of the forcing terms.
const FORCING: f64 = 0.9;
/// Residual after a step from which a little more accuracy makes it the last one \[relative to the tolerance of equilibrium\].
const NEARLY: f64 = 10.0;
/// Accuracy of the last step \[relative to the tolerance of equilibrium\].
const LAST_STEP: f64 = 0.1;

impl Search<'_> {
    /// Residual of an inexact step \[relative to the forces\], so small that steps converge quadratically (S. C. Eisenstat, H. F. Walker, SIAM J. Sci. Comput. 17, 1996),
    /// but no smaller than equilibrium needs.
    pub(crate) fn forcing_term(&mut self, residual: f64, tolerance: f64) -> f64 {
        let ratio = residual / std::mem::replace(&mut self.last_residual, residual);
        let largest = if self.stale { STALE_FORCING } else { LARGEST_FORCING };
        let forcing = (FORCING * ratio * ratio).min(largest);
        let last = forcing * residual <= NEARLY * tolerance;
        let needed = if last { LAST_STEP * tolerance / residual } else { forcing };
        needed.clamp(LEAST_FORCING, largest)
    }

    pub(crate) fn state(&self) -> State<'_> {
        let Self { at: Unknowns { displacement, .. }, theta, load_factor, .. } = self;
        State { displacement, theta, load_factor: *load_factor, pressure: &[] }
    }
}

/// A plane across a curve of equilibria.
pub(crate) struct Plane {
    /// Derivatives of the distance along the curve in the free displacements [1/length] and in the place.
    pub normal: (Vec<f64>, f64),
    /// Distance of the plane along them.
    pub distance: f64,
}

impl Plane {
    /// Distance from a displacement and a place to the plane.
    pub(crate) fn gap(&self, system: &System<'_>, displacement: &[f64], place: f64) -> f64 {
        let (slope, by_place) = &self.normal;
        let free: Vec<f64> = system.sparsity.gather(displacement).collect();
        self.distance - dot(slope, &free) - by_place * place
    }
}

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
        let problem = match (finite, moves) {
            (false, _) => "a fraction of the loads is not finite",
            (_, false) => "its ends are the same",
            _ => return Ok(()),
        };
        Err(SolveError::Line { problem })
    }
}

/// An equilibrium of a body.
///
/// Where there is no potential ([`Solution::has_potential`]), `energy` leaves out loose followers and the field of pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// The field of pressure at [`sinew_energy::PressureField::nodes`] \[stress\], compression negative; empty without one.
    pub pressure: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Whether the equilibrium is a stationary point of that energy.
    pub has_potential: bool,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Fraction of all loads and prescribed motions; 1 except along a [`crate::Curve`].
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Error that the iteration leaves: mean nodal length of the Newton step that would follow \[length\]; `None` without a potential, or where conjugate gradients do not tell it.
    pub iteration_error: Option<f64>,
    /// Norm of the residual of the volume constraint \[length³\].
    pub volume_residual: f64,
    /// Norm of the loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// Number of negative eigenvalues of the symmetric part of the last stiffness of the displacements: 0 for a stable equilibrium of a potential.
    pub negative_pivots: usize,
    /// Whether a factor counted them. Where it would take more than 1 GB, 0 says that conjugate gradients met no negative curvature.
    pub counted: bool,
    /// Number of load steps, 1 if the whole load was applied at once; includes those of the softer body that lead to
    /// a nearly incompressible one.
    pub load_steps: usize,
    /// Whether the search met an indefinite stiffness. By load steps, the body has snapped to another branch of
    /// equilibria. Otherwise the search may have passed the equilibrium of a rising load: see
    /// [`crate::Solver::under_rising_load`].
    pub jumped: bool,
    /// Iterations of all linear systems; 0 where factors solve them.
    pub linear_iterations: usize,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl Solution {
    /// Solution of the equilibrium found last.
    pub(crate) fn new(
        system: &System<'_>,
        (found, load_steps): (Equilibrium, usize),
        (load_factor, theta): (f64, Vec<f64>),
        history: History,
        start: Instant,
    ) -> Self {
        let iteration_error = system
            .body
            .has_potential()
            .then(|| mean_and_largest(&system.newton_step(&system.assembly.gradient))[0]);
        let iteration_error = iteration_error.filter(|error| error.is_finite());
        Self {
            displacement: found.unknowns.displacement,
            pressure: found.unknowns.pressure,
            // The sum over all cells in one order, the same as every reader of the potential gets.
            energy: system.assembly.energy,
            has_potential: system.body.has_potential(),
            theta,
            load_factor,
            residual: found.residual.force,
            iteration_error,
            volume_residual: found.residual.volume,
            force_scale: system.assembly.force_scale,
            least_volume_ratio: system.assembly.least_volume_ratio,
            negative_pivots: found.negative_pivots,
            counted: !system.iterates,
            load_steps,
            jumped: found.jumped,
            linear_iterations: found.linear_iterations,
            history,
            seconds: start.elapsed().as_secs_f64(),
        }
    }

    /// Whether the equilibrium is a minimum of the potential: small disturbances die out.
    pub fn is_stable(&self) -> bool {
        self.negative_pivots == 0
    }

    /// Number of Newton iterations.
    pub fn iterations(&self) -> usize {
        self.history.steps()
    }
}
