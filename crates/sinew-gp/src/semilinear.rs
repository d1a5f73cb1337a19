//! Equations with a nonlinear term, by the Gauss–Newton method.
//!
//! L u + g(D₁u, …, D_M u) = f is linearised about the posterior mean: with vᵢ = Dᵢu there,
//! L + Σ ∂ᵢg(v) Dᵢ is a linear operator and f − g(v) + Σ ∂ᵢg(v) vᵢ its right-hand side. Each step is
//! a fit of the linear kind, so hard conditions, noisy data and unknown parameters of L carry over
//! (Chen, Hosseini, Owhadi & Stuart 2021 for the forward problem). Parameters inside g are linearised about their last
//! estimate with it, products with u included, so that they are parameters of the linear operator.

mod tangent;

use crate::error::{Result, place};
use crate::fit::ROUNDS;
use crate::fit::resolve::{Candidate, PLACES, RESOLVED, RESOLVED_ALONE, spread_out};
use crate::model::data::{NO_DATA, Role, check, largest};
use crate::model::{FIRST_POINTS, POINTS_SEED};
use crate::{
    Conditional, Data, Derivative, Domain, Evidence, Fit, FitOptions, Formula, GpError, Model,
    Parameter, Prior, Problem, Series, Warning,
};
use std::sync::Arc;

/// Function of the arguments, the term's parameters, and the place.
type Term<const D: usize, const M: usize> =
    dyn Fn([Series; M], &[Series], [f64; D]) -> Series + Send + Sync;

/// A problem whose equation has a nonlinear term in M derivatives of u.
#[doc(alias = "Gauss-Newton")]
#[derive(Clone)]
pub struct SemiLinear<const D: usize, const M: usize> {
    problem: Problem<D>,
    arguments: [Derivative<D>; M],
    /// Unknowns inside the term.
    parameters: Vec<Parameter>,
    term: Arc<Term<D, M>>,
}

/// Result of the linearisations of an equation.
#[derive(Clone, Debug)]
pub struct Solution<const D: usize> {
    /// The fit of the last linearisation.
    pub fit: Fit<D>,
    /// Steps taken.
    pub steps: usize,
    /// Largest change of the term's first argument in the last step, at the collocation points and
    /// relative to its largest magnitude.
    pub change: f64,
}

impl<const D: usize> Solution<D> {
    /// Whether the last step changed next to nothing. If not, the steps did not suffice, or the
    /// equation has no solution, or none within their reach: [`SemiLinear::solve_from`] a solution
    /// of an easier one.
    pub fn has_converged(&self) -> bool {
        self.change < CONVERGED
    }
}

/// Data and options of a solution.
struct Task<'a, const D: usize> {
    kernel: &'a Formula<D>,
    data: &'a Data<D>,
    options: &'a FitOptions,
    steps: usize,
}

/// Relative change of u below which steps end: far below what collocation resolves, and above what
/// the end of a fit leaves open when parameters of L are unknown.
const CONVERGED: f64 = 1e-6;
/// Relative change from which on fits start from the parameters before only.
const NEARLY: f64 = 1e-3;

impl<const D: usize, const M: usize> SemiLinear<D, M> {
    /// L u + `term`(`arguments` of u) = f, with L the equation of `problem`. Convergence is judged by
    /// the first argument.
    ///
    /// ```
    /// use sinew_gp::{Derivative, Domain, Problem, SemiLinear};
    ///
    /// // Burgers: u_t + u u_x − 0.1 u_xx = 0
    /// let domain = Domain::cuboid([("x", [-1.0, 1.0]), ("t", [0.0, 1.0])])?;
    /// let [dx, dt] = domain.derivatives();
    /// let viscous = Problem::new(domain, dt - 0.1 * (dx * dx))?;
    /// let burgers = SemiLinear::new(viscous, [Derivative::identity(), dx], |[u, slope]| u * slope);
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    pub fn new(
        problem: Problem<D>,
        arguments: [Derivative<D>; M],
        term: impl Fn([Series; M]) -> Series + Send + Sync + 'static,
    ) -> Self {
        Self::with_coordinates(problem, arguments, [], move |arguments, [], _| term(arguments))
    }

    /// [`SemiLinear::new`] with a term that depends on unknown parameters and on the place, too: a reaction g(x) u², or a source that is
    /// nonlinear in a parameter. The parameters are sought along with those of L, from the middle of their bounds.
    ///
    /// ```
    /// use sinew_gp::{Derivative, Domain, Parameter, Problem, SemiLinear};
    ///
    /// // Growth with saturation: u_t − r u (1 − u/c) = 0
    /// let domain = Domain::interval("t", [0.0, 5.0])?;
    /// let [dt] = domain.derivatives();
    /// let (rate, capacity) = (Parameter::new("r", [0.1, 10.0])?, Parameter::new("c", [0.5, 50.0])?);
    /// let growth = SemiLinear::with_coordinates(
    ///     Problem::new(domain, dt)?,
    ///     [Derivative::identity()],
    ///     [rate, capacity],
    ///     |[u], [r, c], _| -(r * &u * (1.0 - &u / c)),
    /// );
    ///
    /// // Absorbed light heats a rod: −u″ − exp(−a x) = 0 with an unknown a.
    /// let domain = Domain::interval("x", [0.0, 1.0])?;
    /// let [dx] = domain.derivatives();
    /// let absorption = Parameter::new("a", [0.1, 10.0])?;
    /// let heated = SemiLinear::with_coordinates(
    ///     Problem::new(domain, -(dx * dx))?,
    ///     [Derivative::identity()],
    ///     [absorption],
    ///     |_, [a], [x]| -(a * -x).exp(),
    /// );
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    pub fn with_coordinates<const P: usize>(
        problem: Problem<D>,
        arguments: [Derivative<D>; M],
        parameters: [Parameter; P],
        term: impl Fn([Series; M], [Series; P], [f64; D]) -> Series + Send + Sync + 'static,
    ) -> Self {
        const { assert!(M > 0, "a nonlinear term has at least one argument") };
        let term = move |arguments: [Series; M], parameters: &[Series], x: [f64; D]| {
            let known = std::array::from_fn(|k| parameters[k].clone());
            term(arguments, known, x)
        };
        Self { problem, arguments, parameters: parameters.to_vec(), term: Arc::new(term) }
    }

    /// Values of the term's parameters in a fit; in the middle of their bounds where it has none.
    fn theta(&self, fit: Option<&Fit<D>>) -> Vec<f64> {
        let of = |parameter: &Parameter| {
            let known = fit.and_then(|fit| fit.parameter(parameter.name()).ok());
            known.unwrap_or_else(|| parameter.middle())
        };
        self.parameters.iter().map(of).collect()
    }

    /// Solves by at most `steps` linearisations (one at least), starting from the mean of the
    /// constrained prior. Ask [`Solution::has_converged`] whether they were enough.
    ///
    /// `data` holds f at collocation points, or everywhere, and, for inverse problems, measured values; with these,
    /// [`Evidence::UnitInformation`] is maximised.
    /// Fits start as in `options`, and near the end from the parameters before.
    ///
    /// # Errors
    /// If a fit fails, data are not finite, the term has no finite value or slope where a step leads,
    /// or there are no collocation points.
    pub fn solve(
        &self,
        kernel: &Formula<D>,
        data: &Data<D>,
        options: &FitOptions,
        steps: usize,
    ) -> Result<Solution<D>> {
        self.solved(None, &Task { kernel, data, options, steps })
    }

    /// [`SemiLinear::solve`] from a solution on other data or of another equation: fewer points, or
    /// a coefficient at which the problem is easier.
    ///
    /// # Errors
    /// As [`SemiLinear::solve`].
    pub fn solve_from(
        &self,
        start: &Solution<D>,
        kernel: &Formula<D>,
        data: &Data<D>,
        options: &FitOptions,
        steps: usize,
    ) -> Result<Solution<D>> {
        self.solved(Some(start), &Task { kernel, data, options, steps })
    }

    /// Solves from a solution or the prior mean, at the points of the data; or an equation that holds everywhere at as many as it takes.
    fn solved(&self, start: Option<&Solution<D>>, task: &Task<'_, D>) -> Result<Solution<D>> {
        let (domain, options) = (self.problem.domain(), task.options);
        let Some(source) = &task.data.everywhere else { return self.iterate(start, task) };
        let mut at = domain.sample(FIRST_POINTS * D, POINTS_SEED)?;
        let solve = |start: Option<&Solution<D>>, at: &[[f64; D]]| {
            self.iterate(start, &Task { data: &task.data.placed(source, at), ..*task })
        };
        let mut solution = solve(start, &at)?;
        let aim = if solution.fit.model().theta.is_empty() { RESOLVED_ALONE } else { RESOLVED };
        for round in 0.. {
            let places = domain.sample(PLACES, round)?;
            let [linear, rest] = self.parts(&solution, &places)?;
            let f: Vec<f64> = places.iter().map(|x| source.value(*x)).collect();
            let off = |k: usize| linear[k] + rest[k] - f[k];
            let size = |of: &dyn Fn(usize) -> f64| (0..PLACES).map(|k| of(k).powi(2)).sum::<f64>();
            let term = size(&|k| linear[k]).max(size(&|k| rest[k])).max(size(&|k| f[k]));
            if size(&off) <= aim * aim * term {
                break;
            }
            let each = places.iter().enumerate();
            let each = each.map(|(k, at)| Candidate { at: *at, value: f[k], residual: off(k) });
            let more = options.most_points.saturating_sub(at.len()).min(at.len() / 2);
            let chosen = match round < ROUNDS && solution.has_converged() {
                true => spread_out(each.collect(), &at, more, domain),
                false => Vec::new(),
            };
            if chosen.is_empty() {
                let warning = Warning::of_points(at.len(), options.most_points);
                solution.fit.unsettled.get_or_insert(warning);
                break;
            }
            at.extend(chosen.iter().map(|candidate| candidate.at));
            solution = solve(Some(&solution), &at)?;
        }
        Ok(solution)
    }

    /// L u + g(u) at points, to be compared with f there: where they differ most, the next
    /// collocation point belongs.
    ///
    /// # Errors
    /// If a feature has no derivative at a point, or the term no finite value there.
    pub fn left_hand_side(&self, solution: &Solution<D>, points: &[[f64; D]]) -> Result<Vec<f64>> {
        let [linear, rest] = self.parts(solution, points)?;
        Ok(linear.iter().zip(rest).map(|(linear, rest)| linear + rest).collect())
    }

    /// L u and g(u) at points.
    fn parts(&self, solution: &Solution<D>, points: &[[f64; D]]) -> Result<[Vec<f64>; 2]> {
        let conditional = solution.fit.conditional()?;
        let linear = conditional.mean_of(self.problem.equation(), points)?;
        let arguments = self.means(&conditional, points)?;
        let theta: Vec<_> =
            self.theta(Some(&solution.fit)).into_iter().map(Series::number).collect();
        let term = |(index, x): (usize, &[f64; D])| {
            let v = at_point(&arguments, index);
            let value = (self.term)(Series::plain(v), &theta, *x).value();
            if value.is_finite() { Ok(value) } else { Err(singular_term(index, &v)) }
        };
        let rest = points.iter().enumerate().map(term).collect::<Result<_, _>>()?;
        Ok([linear, rest])
    }

    fn iterate(&self, start: Option<&Solution<D>>, task: &Task<'_, D>) -> Result<Solution<D>> {
        let points = &collocation(task.data, self.problem.domain())?[..];
        let start = start.map(|start| &start.fit);
        let mut values = match start {
            Some(start) => self.means(&start.conditional()?, points)?,
            None => {
                let mean = Prior::constrained(&self.problem, task.kernel)?.mean;
                let at = |orders: [usize; D], x: &[f64; D]| {
                    mean.at(Series::variables(*x, orders)).derivative(&orders)
                };
                let of = |own: Derivative<D>| points.iter().map(|x| at(own.orders, x)).collect();
                self.arguments.map(of).to_vec()
            }
        };
        let (mut change, mut taken) = (f64::INFINITY, 0);
        let mut parameters = start.map(|fit| fit.outcome().parameters.clone());
        let mut theta = self.theta(start);
        loop {
            let model = self.linearised(task, points, &values, &theta)?;
            // Parameters of a start on other data may be of another number.
            let count = model.parameters().len();
            let mut starts = Vec::from_iter(parameters.filter(|known| known.len() == count));
            // The first linearisations are far from the last: what fits them best may be elsewhere.
            if change > NEARLY || starts.is_empty() {
                starts.extend(model.random_starts(task.options));
            }
            let fit = model.fit_from(starts, task.options.iterations)?;
            let updated = self.means(&fit.conditional()?, points)?;
            let now = self.theta(Some(&fit));
            let each = theta.iter().zip(&now).map(|(old, new)| relative_change(&[*old], &[*new]));
            change = each.fold(relative_change(&values[0], &updated[0]), f64::max);
            taken += 1;
            if change < CONVERGED || taken >= task.steps {
                let mut solution = Solution { fit, steps: taken, change };
                if !solution.has_converged() {
                    solution.fit.unsettled = Some(Warning::NotConverged { steps: taken, change });
                }
                return Ok(solution);
            }
            (values, theta) = (updated, now);
            parameters = Some(fit.outcome().parameters.clone());
        }
    }

    /// Posterior means of all arguments, one after the other.
    fn means(&self, conditional: &Conditional<D>, points: &[[f64; D]]) -> Result<Vec<Vec<f64>>> {
        let of = |argument: &Derivative<D>| conditional.mean_of(&(*argument).into(), points);
        self.arguments.iter().map(of).collect()
    }

    fn linearised(
        &self,
        task: &Task<'_, D>,
        points: &[[f64; D]],
        values: &[Vec<f64>],
        theta: &[f64],
    ) -> Result<Model<D>> {
        let (equation, shifts) = self.tangent(points, values, theta)?;
        let problem = Problem { equation, ..self.problem.clone() };
        let mut groups = task.data.groups.clone();
        let imposed = groups.iter_mut().filter(|group| group.operator.is_none());
        let values = imposed.flat_map(|group| &mut group.values);
        values.zip(shifts).for_each(|(f, shift)| *f += shift);
        let data = Data { groups, everywhere: None };
        // What the equation says of itself depends on the linearisation: with measured values, how well it predicts these
        // counts before all.
        let measured = data.groups.iter().any(|group| group.role == Role::Observed);
        let evidence = if measured { Evidence::UnitInformation } else { Evidence::Joint };
        Model::new(Prior::constrained(&problem, task.kernel)?, data, evidence)
    }
}

/// A nonlinear term that is not finite where u may be, at a point of those given.
fn singular_term(index: usize, arguments: &[f64]) -> GpError {
    let arguments = place(arguments);
    GpError::Invalid(format!(
        "the nonlinear term has no finite value or derivative near {arguments}, its arguments at point {index}; start from a solution that is better known, or define the term there"
    ))
}

/// The points at which f is given, of sound data.
fn collocation<const D: usize>(data: &Data<D>, domain: &Domain<D>) -> Result<Vec<[f64; D]>> {
    check(&data.groups, domain)?;
    let imposed = data.groups.iter().filter(|group| group.operator.is_none());
    let points: Vec<[f64; D]> = imposed.flat_map(|group| group.points().iter().copied()).collect();
    ensure!(!points.is_empty(), "{NO_DATA}");
    Ok(points)
}

/// Arguments at one of the points.
fn at_point<const M: usize>(values: &[Vec<f64>], index: usize) -> [f64; M] {
    std::array::from_fn(|k| values[k][index])
}

/// Largest change relative to the largest magnitude.
fn relative_change(old: &[f64], new: &[f64]) -> f64 {
    let change = old.iter().zip(new).map(|(old, new)| (old - new).abs()).fold(0.0, f64::max);
    change / largest(new).max(f64::MIN_POSITIVE)
}
