//! Newton's method at one load, for minima of a potential and for balances of forces without one.
//!
//! Three measures save iterations on slender bodies, where a linear step bends and thereby stretches the body (gravity
//! beam of the thesis over its range: 6–7 iterations instead of 10–13):
//!
//! - The geometric stiffness is built from the predicted stress, see [`crate::elements::predicted`].
//! - A full step may raise the energy if the next one lowers it again (watchdog; R. M. Chamberlain et al., Math.
//!   Programming Study 16, 1982). If not, the search returns and takes the longest of the steps 1, ½, ¼, … that lowers
//!   the energy enough.
//! - A step that raises the energy turns no cell by more than half a radian, and raises it within bounds.
//!
//! Where there is a potential, the tangents in an indefinite stiffness lose their negative eigenvalues (projected Newton), and a shift follows if that is not enough, so that
//! steps descend. Small bodies, and nearly incompressible ones without patches, take shifts alone. Steps after a slow one are doubled while the energy falls. Without a
//! potential, steps use the unsymmetric or indefinite stiffness itself; only the volume of the cells limits their length.

use crate::elements::{
    PredictedStress, Residual, State, System, bulk_to_shear, is_nearly_incompressible, place,
};
use crate::linear::{MOST_COUNTED, MOST_SHIFTS, MOST_SINGLE, Shifted, dot};
use crate::solve::{Equilibrium, Goal, Line, Log, Plane, Point, Search};
use crate::{Iteration, Method, Options};

/// Residual \[relative to forces and volume\] that is accepted once it stops falling: with a potential, and without,
/// where linear systems are solved by iteration.
const STALLED: [f64; 2] = [1e-9, 1e-7];
/// Steps without progress before a residual counts as stalled.
const MOST_STALLS: usize = 2;
/// Growth of the residual that ends a search without a potential: at the final load, and at earlier ones, where a
/// shorter load step costs less.
const MOST_GROWTH: [f64; 2] = [2e3, 10.0];
/// Residual \[relative to the forces\] below which the plain Newton step to an unstable equilibrium is tried.
const NEAR_EQUILIBRIUM: f64 = 1e-6;
/// Reduction of the residual that accepts this step.
const CONVERGING: f64 = 0.25;
/// Least share of the residual that a slow step leaves. Beyond the equilibrium of an exponential law, a Newton step divides it by e only. Doubled
/// steps and projected tangents take 14 steps instead of 21 to the softest ventricle of 4164 nodes.
const SLOW: f64 = 0.2;
/// Multiple of the limit of iterations that a search for a minimum may take while it converges, and full steps in a row that show this.
const EXTENSION: usize = 2;
const FULL_STEPS: usize = 2;

/// Residual \[relative to the forces\] of the displacements that follow supports: the steps after them correct it.
const SUPPORTS: f64 = 1e-4;

/// Shift \[relative to the mean diagonal\] that is reported where projected tangents needed none.
const PROJECTED: f64 = 1e-6;
/// Unknowns below which eigenvalues of tangents take longer than the steps they save: a beam of 176 nodes would take 1.7 times as long.
const FEW: usize = 3_000;

/// Relative accuracy from which an equilibrium counts as intermediate.
const ROUGH: f64 = 1e-6;

impl System<'_> {
    /// Searches for the equilibrium at a place of a line, or where a constraint is met.
    ///
    /// `None` when there is no progress; `history` tells.
    pub(crate) fn equilibrium(
        &mut self,
        start: Point,
        goal: Goal<'_>,
        options: &Options,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let (load_factor, theta) = goal.line.at(start.place);
        self.assembly.nearly_incompressible = is_nearly_incompressible(self.body, &theta);
        let mut search = Search {
            goal,
            place: start.place,
            load_factor,
            theta,
            at: start.unknowns,
            predicted: start.stress,
            watchdog: None,
            rises: 0,
            negative_pivots: None,
            last_residual: 0.0,
            stale: true,
            linear_iterations: 0,
            jumped: false,
            by_place: Vec::new(),
        };
        let ratio = bulk_to_shear(self.body, &search.theta);
        let (factor, sparsity) = (&self.factor, &*self.sparsity);
        (self.method, self.factor.rough) =
            options.method.chosen(self.body.has_potential(), ratio, factor, sparsity);
        self.aggregation.clear();
        self.refused = false;
        self.move_supports(&mut search, history)?;
        let (mut least, mut stalls, mut indefinite, mut full) = (f64::INFINITY, 0, 0, 0);
        for count in 0..EXTENSION * options.iterations_per_load {
            let late = count >= options.iterations_per_load && full < FULL_STEPS;
            if late || history.iterations.len() >= options.iterations {
                return None;
            }
            let residual = self.assemble_at(&search);
            self.record(&search, &residual, history);
            let gap =
                goal.plane.map(|plane| plane.gap(self, &search.at.displacement, search.place));
            let size = self.size(&residual)?.max(gap.map_or(0.0, f64::abs));
            stalls = if size > 0.5 * least { stalls + 1 } else { 0 };
            least = least.min(size);
            let floor = STALLED[usize::from(!self.body.has_potential())];
            let stalled = stalls >= MOST_STALLS && size <= floor;
            // At least one step: repeated extrapolation drifts away from equilibrium.
            if search.negative_pivots.is_some()
                && (stalled || self.is_balanced(&search, &residual, size))
            {
                return Some(self.found(search, residual));
            }
            let growth = MOST_GROWTH[usize::from(goal.accuracy >= ROUGH)];
            if !self.body.has_potential() && size > growth * least.max(1e-3) {
                return None;
            }
            let record = history.iterations.last_mut()?;
            if self.body.has_potential() && gap.is_none() {
                if self.descend(&mut search, residual.force, record).is_none() {
                    let balanced = self.assembly.is_nearly_balanced(residual.force);
                    let known = search.negative_pivots.is_some() && balanced;
                    return known.then(|| self.found(search, residual));
                }
                search.stale = record.shift > 0.0 || record.step < 1.0;
                indefinite = if record.shift > 0.0 { indefinite + 1 } else { 0 };
                full = if record.shift > 0.0 || record.step < 1.0 { 0 } else { full + 1 };
                search.jumped |= indefinite > 0;
                if indefinite >= goal.most_indefinite {
                    return None;
                }
            } else {
                self.balance_step(&mut search, &residual, gap, record)?;
            }
        }
        None
    }

    fn assemble_at(&mut self, search: &Search<'_>) -> Residual {
        let Search { at, load_factor, predicted, theta, .. } = search;
        self.assemble(at, theta, *load_factor, predicted.as_ref())
    }

    /// Whether the residual is at the rounding error or below the required accuracy.
    fn is_balanced(&self, search: &Search<'_>, residual: &Residual, size: f64) -> bool {
        let accuracy = search.goal.accuracy;
        let floor = residual.force <= self.assembly.tolerance()
            && (self.coupling.is_none() || residual.volume <= accuracy * self.volume());
        size <= accuracy || (floor && search.goal.plane.is_none())
    }

    /// Reports an equilibrium with the negative pivots of the true stiffness, without predicted stress. Conjugate gradients that met no negative
    /// curvature are enough for an intermediate one.
    fn found(&mut self, search: Search<'_>, residual: Residual) -> Equilibrium {
        let mut negative_pivots = search.negative_pivots.unwrap_or(0);
        let on_the_way = search.goal.plane.is_none() && search.place < 1.0;
        let uncounted = self.iterates && !(on_the_way && search.goal.accuracy >= ROUGH);
        if (negative_pivots > 0 || uncounted) && self.body.has_potential() {
            self.assemble(&search.at, &search.theta, search.load_factor, None);
            negative_pivots = self.negative_eigenvalues().unwrap_or(1);
        }
        let Search { at: unknowns, place, jumped, by_place, .. } = search;
        Equilibrium {
            unknowns,
            place,
            residual,
            negative_pivots,
            linear_iterations: search.linear_iterations + self.aggregation.iterations,
            jumped,
            by_place,
        }
    }

    fn record(&self, search: &Search<'_>, residual: &Residual, history: &mut Log<'_>) {
        let assembly = &self.assembly;
        let enough = search.goal.accuracy * assembly.force_scale;
        // The difference of two numbers that overflow is not a number.
        let overflowed = |x: f64| if x.is_nan() { f64::INFINITY } else { x };
        let iteration = Iteration {
            load_factor: search.load_factor,
            residual: overflowed(residual.force),
            tolerance: assembly.tolerance().max(enough),
            energy: overflowed(assembly.energy),
            least_volume_ratio: assembly.least_volume_ratio,
            worst_cell: assembly.worst_cell,
            step: 0.0,
            shift: 0.0,
        };
        history.record(iteration, &search.at.displacement, &assembly.gradient);
    }

    /// Moves prescribed degrees of freedom to their targets, and the free ones by the linear model.
    fn move_supports(&mut self, search: &mut Search<'_>, history: &mut Log<'_>) -> Option<()> {
        let mut motion = search.at.displacement.clone();
        place(self.body, search.load_factor, &mut motion);
        motion.iter_mut().zip(&search.at.displacement).for_each(|(m, u)| *m -= u);
        if motion.iter().all(|&m| m == 0.0) {
            return Some(());
        }
        let mut residual = self.assemble_at(search);
        self.record(search, &residual, history);
        let moved = self.response_to_supports(search.state(), &motion);
        residual.values.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
        let free = self.sparsity.unknowns();
        let right: Vec<f64> = residual.values.iter().map(|r| -r).collect();
        let iterated = self.iterated(&right, SUPPORTS);
        let (change, shift) = match iterated {
            Some(iterated) => iterated,
            None if self.refused => return None,
            None => {
                let (shift, _) = self.factorise(self.body.has_potential())?;
                let shifted = if self.body.has_potential() { 0.0 } else { shift };
                let (change, outcome) = self.solve(&residual.values, shifted).ok()?;
                search.linear_iterations += outcome.iterations;
                (change, shift)
            }
        };
        self.sparsity.scatter(change.iter().copied(), &mut motion);
        let flat_between = self.passes_flat(&search.theta, &motion, 1.0);
        search.predicted = self.predict_stress(&motion);
        search.at.displacement.iter_mut().zip(&motion).for_each(|(u, m)| *u += m);
        search.at.pressure.iter_mut().zip(&change[free..]).for_each(|(p, c)| *p += c);
        place(self.body, search.load_factor, &mut search.at.displacement);
        let last = history.iterations.last_mut()?;
        (last.step, last.shift) = (1.0, shift);
        if search.state().energy(self.body).is_finite() && !flat_between {
            return Some(());
        }
        // Records the inadmissible state, which explains the failure.
        let residual = self.assemble_at(search);
        self.record(search, &residual, history);
        None
    }

    /// Stress after a step by the linear model; `None` with a pressure field, whose change it would miss.
    pub(crate) fn predict_stress(&self, step: &[f64]) -> Option<PredictedStress> {
        self.coupling.is_none().then(|| self.assembly.predict_stress(self.body, step))
    }

    /// One step from the assembled state towards lower energy.
    fn descend(
        &mut self,
        search: &mut Search<'_>,
        residual: f64,
        record: &mut Iteration,
    ) -> Option<()> {
        let right: Vec<f64> = self.sparsity.gather(&self.assembly.gradient).map(|g| -g).collect();
        let slow = !search.stale && (SLOW..1.0).contains(&(residual / search.last_residual));
        let forcing = search.forcing_term(residual, self.assembly.tolerance());
        if search.stale {
            self.aggregation.drop_hierarchy();
        }
        let mut iterated = self.iterated_projected(search, &right, forcing);
        let (shift, negative) = match &iterated {
            Some((_, shift)) => (*shift, usize::from(*shift > 0.0)),
            None if self.refused => return None,
            None => self.factorised_projected(search)?,
        };
        search.negative_pivots = Some(negative);
        let countable = iterated.is_none() || self.factor.entries() <= MOST_COUNTED;
        let near = residual <= NEAR_EQUILIBRIUM * self.assembly.force_scale;
        if negative > 0 && near && countable {
            if self.step_to_saddle(search, residual) {
                record.step = 1.0;
                return Some(());
            }
            iterated = None;
        }
        let direction = match iterated {
            Some((change, _)) => self.sparsity.scattered(change),
            None => self.newton_step(&self.assembly.gradient),
        };
        let promised = -dot(&self.assembly.gradient, &direction);
        record.shift = shift;
        if !promised.is_finite() {
            return None;
        }
        record.step = self.line_search(search, &direction, promised, [shift > 0.0, slow])?;
        Some(())
    }

    /// [`System::iterated`] for the stiffness, or for that of projected tangents where it is indefinite.
    fn iterated_projected(
        &mut self,
        search: &Search<'_>,
        right: &[f64],
        tolerance: f64,
    ) -> Shifted {
        if self.method != Method::Aggregation {
            return None;
        }
        if let Some(plain) = self.iterate(right, tolerance, 1) {
            return Some(plain);
        }
        if self.project_tangents(search) {
            self.aggregation.drop_hierarchy();
        }
        let Some((change, shift)) = self.iterated(right, tolerance) else {
            // A factor that follows is one of the stiffness itself.
            self.assemble_at(search);
            return None;
        };
        Some((change, shift.max(PROJECTED)))
    }

    /// Factor of the stiffness: the shift and the number of negative pivots, as by [`System::factorise`]. Where it is indefinite, tangents are projected, but for
    /// small bodies, and for nearly incompressible ones without patches.
    fn factorised_projected(&mut self, search: &Search<'_>) -> Option<(f64, usize)> {
        // Without the negative part of the pressure, cells are no longer incompressible.
        let stiff = self.assembly.nearly_incompressible && self.body.patches.is_empty();
        if stiff || self.sparsity.unknowns() < FEW {
            return self.factorise(true);
        }
        self.iterates = false;
        if self.factor.definite(&self.sparsity, &self.assembly.matrix) {
            return Some((0.0, 0));
        }
        let projected = self.project_tangents(search);
        let (sparsity, matrix) = (&*self.sparsity, &mut self.assembly.matrix);
        if projected && self.factor.definite(sparsity, matrix) {
            return Some((PROJECTED, 1));
        }
        Some((self.factor.shifted(sparsity, matrix)?.max(PROJECTED), 1))
    }

    /// Assembles the stiffness by tangents without their negative eigenvalues; whether there were any.
    fn project_tangents(&mut self, search: &Search<'_>) -> bool {
        self.assembly.convex = Some(0);
        self.assemble_at(search);
        self.assembly.convex.take() > Some(0)
    }

    /// [`System::iterate`] where that is the method of the search, which goes on with factors if it fails and they are not too large.
    fn iterated(&mut self, right: &[f64], tolerance: f64) -> Shifted {
        if self.method != Method::Aggregation {
            return None;
        }
        let iterated = self.iterate(right, tolerance, MOST_SHIFTS);
        if iterated.is_none() {
            self.refused = self.factor.entries() > MOST_SINGLE;
            if !self.refused {
                self.method = Method::Factor;
            }
            self.aggregation.clear();
        }
        iterated
    }

    /// Takes the plain Newton step where the stiffness is indefinite, if that converges.
    fn step_to_saddle(&mut self, search: &mut Search<'_>, residual: f64) -> bool {
        search.predicted = None;
        self.assemble_at(search);
        self.iterates = false;
        if self.factor.indefinite(&self.sparsity, &self.assembly.matrix).is_some() {
            let before = search.at.displacement.clone();
            self.add_newton_step(&self.assembly.gradient, &mut search.at.displacement);
            let after = self.assemble_at(search);
            if self.assembly.energy.is_finite() && after.force <= CONVERGING * residual {
                return true;
            }
            search.at.displacement = before;
            self.assemble_at(search);
        }
        // Descend instead, with the factor that the caller expects.
        self.factor.shifted(&self.sparsity, &mut self.assembly.matrix);
        false
    }

    /// One Newton step from the assembled state for the balance and its constraint.
    fn balance_step(
        &mut self,
        search: &mut Search<'_>,
        residual: &Residual,
        gap: Option<f64>,
        record: &mut Iteration,
    ) -> Option<()> {
        let (shift, negative) = self.factorise(false)?;
        search.negative_pivots = Some(negative);
        record.shift = shift;
        let (mut change, outcome) = self.solve(&residual.values, shift).ok()?;
        search.linear_iterations += outcome.iterations;
        let mut motion = vec![0.0; search.at.displacement.len()];
        let mut onward = 0.0;
        let plane = search.goal.plane.zip(gap);
        if let Some((Plane { normal: (slope, rate_of_plane), .. }, gap)) = plane {
            let (rate, supports) = self.rate_along(search.goal.line, search.state());
            let (by_place, outcome) = self.solve(&rate, shift).ok()?;
            search.linear_iterations += outcome.iterations;
            onward = (gap - dot(slope, &change)) / (dot(slope, &by_place) + rate_of_plane);
            if !onward.is_finite() {
                return None;
            }
            change.iter_mut().zip(&by_place).for_each(|(c, p)| *c += onward * p);
            motion.iter_mut().zip(&supports).for_each(|(m, s)| *m += onward * s);
            search.by_place = by_place;
        }
        self.sparsity.scatter(change.iter().copied(), &mut motion);
        let pressures = &change[self.sparsity.unknowns()..];
        let length = self.take(search, &motion, pressures)?;
        record.step = length;
        search.predicted = match plane {
            None => {
                motion.iter_mut().for_each(|m| *m *= length);
                self.predict_stress(&motion)
            }
            Some(_) => {
                search.place += length * onward;
                (search.load_factor, search.theta) = search.goal.line.at(search.place);
                place(self.body, search.load_factor, &mut search.at.displacement);
                None
            }
        };
        Some(())
    }

    /// Derivative of the balance in the place on the line, with the motion of the supports.
    pub(crate) fn rate_along(&self, line: &Line, state: State<'_>) -> (Vec<f64>, Vec<f64>) {
        let mut rate = self.rate_on(line, state);
        let (more_load, _) = line.rates();
        let mut motion = vec![0.0; state.displacement.len()];
        place(self.body, more_load, &mut motion);
        if motion.iter().any(|&m| m != 0.0) {
            let moved = self.response_to_supports(state, &motion);
            rate.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
        }
        (rate, motion)
    }

    /// Derivative of the balance in the place on a line, without the motion of supports.
    pub(crate) fn rate_on(&self, line: &Line, state: State<'_>) -> Vec<f64> {
        let (more_load, direction) = line.rates();
        let mut rate = self.load_derivative(state.displacement, state.theta);
        rate.iter_mut().for_each(|r| *r *= more_load);
        if direction.iter().any(|&d| d != 0.0) {
            let more = self.rate_by_theta(state, &direction);
            rate.iter_mut().zip(more).for_each(|(r, m)| *r += m);
        }
        rate
    }

    /// Change of the balance at the assembled state with a motion of the supports.
    pub(crate) fn response_to_supports(&self, state: State<'_>, motion: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; motion.len()];
        self.assembly.add_stiffness_times(self.body, state, motion, &mut forces);
        self.followers.add_skew(motion, &mut forces);
        let mut response: Vec<f64> = self.sparsity.gather(&forces).collect();
        let free = response.len();
        response.resize(free + self.pressures(), 0.0);
        if let Some(coupling) = &self.coupling {
            coupling.add_volume_changes(motion, &mut response[free..]);
        }
        response
    }
}
