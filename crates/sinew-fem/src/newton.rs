//! Newton's method at one load.
//!
//! Three things make it take few iterations on slender bodies, where a linear step bends and thereby stretches
//! the body (measured over the thesis' range on its gravity beam: 6–7 iterations, 10–13 without):
//!
//! - The geometric stiffness is built from the stress that the linear model foresaw for the step, not from the
//!   one that the stretching caused (the mixed-integration-point idea of D. Magisano, L. Leonetti, G. Garcea,
//!   Int. J. Numer. Meth. Engng 109, 2017). Both agree at the solution, so convergence stays quadratic.
//! - A full step may raise the energy as long as the next one lowers it again (the watchdog technique of
//!   R. M. Chamberlain et al., Math. Programming Study 16, 1982). If it does not, the search goes back and
//!   takes the longest of the steps 1, ½, ¼, … that lowers the energy enough.
//! - A step that raises the energy turns no cell by more than [`MOST_ROTATION`], and raises it by no more than
//!   [`MOST_RISE`].

use crate::assembly::PredictedStress;
use crate::cell::{is_short, volume_ratios_along};
use crate::linear_solver::Solved;
use crate::state::State;
use crate::supports::place;
use crate::vector::{dot, norm};
use crate::watch::Log;
use crate::{Iteration, Options, Solver};

use sinew_num::Mat3;

/// The energy must fall by this part of what the slope promises (Armijo's condition, the usual value).
const SUFFICIENT: f64 = 1e-4;
/// Largest rotation \[rad\] of a cell in a step that raises the energy. Measured over the range of both beams:
/// 0.45–0.55 need 6–7 iterations everywhere, 0.4 and 0.7 up to 14 at some θ.
const MOST_ROTATION: f64 = 0.5;
/// Steps in a row that may raise the energy.
const MOST_RISES: usize = 2;
/// How much such a step may raise the energy, as a multiple of what the slope promises to lower it by. From 20
/// on nothing changes on beams, linear or quadratic, where less costs iterations. Without a bound a first step
/// into the exponential of a fibre law ends at 1e113 times the energy, and most iterations lead back.
const MOST_RISE: f64 = 20.0;
/// A step must not squeeze a cell to this part of its volume before and after the step.
const FLAT: f64 = 1e-3;
/// Steps shorter than this end the line search: the direction is no descent.
const SHORTEST_STEP: f64 = 1e-8;
/// Steps out of an indefinite stiffness are doubled up to this while the energy falls.
const LONGEST_STEP: f64 = 64.0;
/// Iterations of one load step; beyond, smaller load steps are cheaper.
const MOST_ITERATIONS: usize = 40;
/// A residual this small \[relative to the forces\] is at the floor when it stops falling.
const STALLED: f64 = 1e-9;
/// Steps without progress before a residual counts as stalled.
const MOST_STALLS: usize = 2;
/// Close to an unstable equilibrium \[residual relative to the forces\] the plain Newton step is tried too.
const NEAR_EQUILIBRIUM: f64 = 1e-6;
/// Residual of a Newton step's linear system relative to its right-hand side, where it is solved by iteration: the last
/// step then ends as near to the floor as an exact one.
const STEP_ACCURACY: f64 = 1e-6;
/// That step is taken when it lowers the residual to this part.
const CONVERGING: f64 = 0.25;

/// An equilibrium at one load, before it is reported.
pub(crate) struct Equilibrium {
    pub displacement: Vec<f64>,
    pub negative_pivots: usize,
}

/// A point that the search may return to.
struct Watch {
    displacement: Vec<f64>,
    energy: f64,
}

/// The state of one search.
struct Search<'a> {
    theta: &'a [f64],
    load_factor: f64,
    displacement: Vec<f64>,
    predicted: Option<PredictedStress>,
    watch: Option<Watch>,
    /// Steps that have raised the energy since it was lowest.
    rises: usize,
    negative_pivots: Option<usize>,
}

impl Search<'_> {
    /// Whether a full step may still raise the energy.
    fn relaxed(&self) -> bool {
        self.rises < MOST_RISES
    }

    fn state(&self) -> State<'_> {
        let Self { theta, load_factor, .. } = *self;
        State { displacement: &self.displacement, theta, load_factor, pressure: &[] }
    }

    /// Moves on to `trial`, which has the energy `reached`, from a state with `energy`.
    fn accept(&mut self, lowered: bool, reached: f64, energy: f64, trial: Vec<f64>) {
        let left = std::mem::replace(&mut self.displacement, trial);
        if !lowered {
            self.rises += 1;
            self.watch.get_or_insert(Watch { displacement: left, energy });
        } else if self.watch.as_ref().is_some_and(|watch| reached < watch.energy) {
            self.rises = 0;
            self.watch = None;
        }
    }
}

impl Solver<'_> {
    /// Searches the equilibrium under a fraction of all loads and prescribed motion.
    ///
    /// `None` when there is no progress; `history` tells.
    pub(crate) fn equilibrium(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        load_factor: f64,
        options: &Options,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let mut search = Search {
            theta,
            load_factor,
            displacement: initial.to_vec(),
            predicted: None,
            watch: None,
            rises: 0,
            negative_pivots: None,
        };
        self.move_supports(&mut search, history)?;
        let (mut least, mut stalls) = (f64::INFINITY, 0);
        for _ in 0..MOST_ITERATIONS {
            if history.iterations.len() >= options.iterations {
                return None;
            }
            self.assemble(&search);
            let residual = self.residual();
            self.record(&search, residual, history);
            if !(residual.is_finite() && self.assembly.is_finite()) {
                return None;
            }
            stalls = if residual > 0.5 * least { stalls + 1 } else { 0 };
            least = least.min(residual);
            let floor = residual <= self.assembly.tolerance();
            let stalled = stalls >= MOST_STALLS && residual <= STALLED * self.assembly.force_scale;
            if (floor || stalled) && search.negative_pivots.is_some() {
                let negative_pivots = match search.negative_pivots {
                    Some(0) | None if self.system.is_certain() => 0,
                    _ => self.negative_pivots(&search),
                };
                return Some(Equilibrium { displacement: search.displacement, negative_pivots });
            }
            self.step(&mut search, residual, history.iterations.last_mut()?)?;
        }
        None
    }

    fn assemble(&mut self, search: &Search) {
        let state = search.state();
        let predicted = search.predicted.as_ref();
        self.assembly.assemble(self.potential, &self.sparsity, state, predicted);
        self.system.place(&self.potential.positions, state.displacement, &self.sparsity.frames);
    }

    fn residual(&self) -> f64 {
        norm(&self.sparsity.gather(&self.assembly.gradient).collect::<Vec<_>>())
    }

    fn record(&self, search: &Search, residual: f64, history: &mut Log<'_>) {
        let iteration = Iteration {
            load_factor: search.load_factor,
            residual,
            tolerance: self.assembly.tolerance(),
            energy: self.assembly.energy,
            least_volume_ratio: self.assembly.least_volume_ratio,
            worst_cell: self.assembly.worst_cell,
            step: 0.0,
            shift: 0.0,
        };
        history.record(iteration, &search.displacement, &self.assembly.gradient);
    }

    /// Moves prescribed degrees of freedom where they belong, and the free ones along by the linear model.
    fn move_supports(&mut self, search: &mut Search, history: &mut Log<'_>) -> Option<()> {
        let mut motion = search.displacement.clone();
        place(self.potential, search.load_factor, &mut motion);
        motion.iter_mut().zip(&search.displacement).for_each(|(m, u)| *m -= u);
        if motion.iter().all(|&m| m == 0.0) {
            return Some(());
        }
        self.assemble(search);
        let residual = self.residual();
        self.record(search, residual, history);
        let state = search.state();
        let mut forces = self.assembly.gradient.clone();
        self.assembly.add_stiffness_times(self.potential, state, &motion, &mut forces);
        let (shift, _) = self.factorise()?;
        let (shift, _) = self.add_descent(&forces, &mut motion, (shift, 0))?;
        let predicted = self.assembly.predict_stress(self.potential, &motion);
        let flat_between = self.passes_flat(search.theta, &motion, 1.0);
        search.displacement.iter_mut().zip(&motion).for_each(|(u, m)| *u += m);
        place(self.potential, search.load_factor, &mut search.displacement);
        search.predicted = Some(predicted);
        let last = history.iterations.last_mut()?;
        (last.step, last.shift) = (1.0, shift);
        if search.state().energy(self.potential).is_finite() && !flat_between {
            return Some(());
        }
        // The state that could not be reached tells why.
        self.assemble(search);
        self.record(search, self.residual(), history);
        None
    }

    /// Adds `−K⁻¹ forces` to the free degrees of freedom, with the last factor.
    pub(crate) fn add_newton_step(
        &mut self,
        forces: &[f64],
        displacement: &mut [f64],
        accuracy: f64,
    ) -> Solved {
        let mut right: Vec<_> = self.sparsity.gather(forces).map(|f| -f).collect();
        let solved = self.system.solve(&mut right, accuracy);
        if solved == Solved::Done {
            self.sparsity.scatter(right, displacement);
        }
        solved
    }

    /// Adds `−K⁻¹ forces` to the free degrees of freedom, with more shift if iteration finds that the stiffness
    /// needs it; `found` are shift and negative pivots so far.
    fn add_descent(
        &mut self,
        forces: &[f64],
        displacement: &mut [f64],
        mut found: (f64, usize),
    ) -> Option<(f64, usize)> {
        loop {
            match self.add_newton_step(forces, displacement, STEP_ACCURACY) {
                Solved::Done => return Some(found),
                Solved::Indefinite => {
                    let matrix = &mut self.assembly.matrix;
                    let shift = self.system.shifted(&self.sparsity, matrix, found.0)?;
                    found = (shift, found.1.max(1));
                }
                Solved::TooSlow => {
                    self.system.factorise_instead(&self.sparsity).ok()?;
                    found = self.factorise()?;
                }
            }
        }
    }

    /// Factorises the stiffness, shifted if need be: the shift and the number of negative pivots.
    fn factorise(&mut self) -> Option<(f64, usize)> {
        if self.system.positive_definite(&self.sparsity, &self.assembly.matrix) {
            return Some((0.0, 0));
        }
        let negative = self.system.indefinite(&self.sparsity, &self.assembly.matrix).unwrap_or(1);
        let shift = self.system.shifted(&self.sparsity, &mut self.assembly.matrix, 0.0)?;
        Some((shift, negative.max(1)))
    }

    /// Negative pivots of the stiffness itself, without a predicted stress.
    fn negative_pivots(&mut self, search: &Search) -> usize {
        self.assembly.assemble(self.potential, &self.sparsity, search.state(), None);
        self.system.place(&self.potential.positions, &search.displacement, &self.sparsity.frames);
        if self.system.surely_positive_definite(&self.sparsity, &self.assembly.matrix) {
            return 0;
        }
        let negative = self.system.indefinite(&self.sparsity, &self.assembly.matrix);
        negative.unwrap_or(1).max(1)
    }

    /// One Newton step from the assembled state.
    fn step(&mut self, search: &mut Search, residual: f64, record: &mut Iteration) -> Option<()> {
        let (shift, negative) = self.factorise()?;
        search.negative_pivots = Some(negative);
        if negative > 0
            && residual <= NEAR_EQUILIBRIUM * self.assembly.force_scale
            && self.step_to_saddle(search, residual)
        {
            record.step = 1.0;
            return Some(());
        }
        let gradient = std::mem::take(&mut self.assembly.gradient);
        let mut direction = vec![0.0; gradient.len()];
        let found = self.add_descent(&gradient, &mut direction, (shift, negative));
        let promised = -dot(&gradient, &direction);
        self.assembly.gradient = gradient;
        let (shift, negative) = found?;
        search.negative_pivots = Some(negative);
        record.shift = shift;
        if !promised.is_finite() {
            return None;
        }
        record.step = self.line_search(search, &direction, promised, shift > 0.0)?;
        Some(())
    }

    /// Takes a step along `direction`: the length, 0 when the search went back instead.
    ///
    /// Descent out of a shifted stiffness is shorter than need be, so such a step may be `stretched`.
    fn line_search(
        &self,
        search: &mut Search,
        direction: &[f64],
        promised: f64,
        stretched: bool,
    ) -> Option<f64> {
        let (energy, noise) = (self.assembly.energy, self.assembly.energy_noise);
        let reach = |search: &Search, length: f64| {
            let moved = search.displacement.iter().zip(direction).map(|(u, d)| u + length * d);
            let trial: Vec<_> = moved.collect();
            let mut reached =
                State { displacement: &trial, ..search.state() }.energy(self.potential);
            if reached.is_finite() && self.passes_flat(search.theta, direction, length) {
                reached = f64::INFINITY;
            }
            (reached, trial)
        };
        let mut length = 1.0;
        while length >= SHORTEST_STEP {
            let (mut reached, mut trial) = reach(search, length);
            let lowered = reached <= energy - SUFFICIENT * length * promised + noise;
            while lowered && stretched && length < LONGEST_STEP {
                let (farther, next) = reach(search, 2.0 * length);
                if farther >= reached - noise {
                    break;
                }
                (length, reached, trial) = (2.0 * length, farther, next);
            }
            if !lowered && search.relaxed() && length == 1.0 {
                let rotation = self.largest_rotation(direction);
                if rotation > MOST_ROTATION {
                    length = MOST_ROTATION / rotation;
                    continue;
                }
            }
            let bearable = reached.is_finite() && reached - energy <= MOST_RISE * promised;
            if lowered || (bearable && search.relaxed()) {
                search.accept(lowered, reached, energy, trial);
                let step: Vec<_> = direction.iter().map(|d| length * d).collect();
                search.predicted = Some(self.assembly.predict_stress(self.potential, &step));
                return Some(length);
            }
            if let Some(watch) = search.watch.take() {
                // The step after the last rise of the energy must lower it, or the rises were a mistake.
                search.rises = MOST_RISES;
                search.displacement = watch.displacement;
                search.predicted = None;
                return Some(0.0);
            }
            length *= 0.5;
        }
        None
    }

    /// Whether a cell is as good as flat somewhere on the way from the assembled state along `direction`. A step
    /// through flat can lead out again: a bar that is drawn thin at once may come out turned inside.
    pub(crate) fn passes_flat(&self, theta: &[f64], direction: &[f64], length: f64) -> bool {
        let passes = |(point, h): (usize, &Mat3<f64>)| {
            let step = self.potential.displacement_gradient(point, direction);
            let flattens = || {
                let [start, least, end] = volume_ratios_along(h, &step, length);
                least <= FLAT * start.min(end)
            };
            !is_short(h, &step, length) && flattens()
        };
        self.assembly.displacement_gradients().enumerate().any(passes)
            && self.minds_turned_cells(theta)
    }

    /// Whether the law forbids cells that are turned over; linear elasticity does not.
    fn minds_turned_cells(&self, theta: &[f64]) -> bool {
        let parameters = self.potential.law_parameters(theta);
        let mirrored = Mat3::from_fn(|i, j| if (i, j) == (0, 0) { -2.0 } else { 0.0 });
        self.potential.material.energy(0, parameters, &mirrored, None) == f64::INFINITY
    }

    /// Largest rotation \[rad\] of a cell along `direction`, to first order.
    fn largest_rotation(&self, direction: &[f64]) -> f64 {
        let rotation = |point| {
            let h = self.potential.displacement_gradient(point, direction);
            let twice = [h[0][1] - h[1][0], h[0][2] - h[2][0], h[1][2] - h[2][1]];
            0.5 * twice.iter().map(|w| w * w).sum::<f64>().sqrt()
        };
        (0..self.potential.volumes.len()).map(rotation).fold(0.0, f64::max)
    }

    /// Takes the plain Newton step where the stiffness is indefinite, if that converges.
    fn step_to_saddle(&mut self, search: &mut Search, residual: f64) -> bool {
        search.predicted = None;
        self.assemble(search);
        // Conjugate gradients cannot solve with an indefinite matrix.
        if !self.system.is_certain() && self.system.factorise_instead(&self.sparsity).is_err() {
            return false;
        }
        if self.system.indefinite(&self.sparsity, &self.assembly.matrix).is_none() {
            return false;
        }
        let before = search.displacement.clone();
        let gradient = std::mem::take(&mut self.assembly.gradient);
        self.add_newton_step(&gradient, &mut search.displacement, STEP_ACCURACY);
        self.assembly.gradient = gradient;
        self.assemble(search);
        if self.assembly.energy.is_finite() && self.residual() <= CONVERGING * residual {
            return true;
        }
        search.displacement = before;
        self.assemble(search);
        // Descend instead, with the factor that the caller expects.
        self.system.shifted(&self.sparsity, &mut self.assembly.matrix, 0.0);
        false
    }
}
