//! Equations with a nonlinear term, by Gauss and Newton.
//!
//! L u + g(D₁u, …, D_M u) = f is linearised about the posterior mean: with vᵢ = Dᵢu there,
//! L + Σ ∂ᵢg(v) Dᵢ is a linear operator and f − g(v) + Σ ∂ᵢg(v) vᵢ its right-hand side. Each step is
//! a fit of the linear kind, so hard conditions, noisy data and unknown parameters of L carry over
//! (Chen, Hosseini, Owhadi & Stuart 2021 for the forward problem).

mod bound;
mod expectation;
mod sites;
mod variational;

use std::collections::HashMap;
use std::sync::Arc;

use sinew_num::Series;

use crate::data::{Data, Group, Noise, Role, check, no_data};
use crate::domain::Domain;
use crate::error::{GpError, place};
use crate::evidence::Evidence;
use crate::field::{Field, field};
use crate::fit::{Fit, FitOptions};
use crate::kernel::Kernel;
use crate::model::Model;
use crate::operator::{Derivative, Operator};
use crate::prior::Prior;
use crate::problem::Problem;

pub use variational::{Variational, VariationalOptions};

type Term<const M: usize> = dyn Fn([Series; M]) -> Series + Send + Sync;

/// A problem whose equation has a nonlinear term in M derivatives of u.
#[derive(Clone)]
pub struct SemiLinear<const D: usize, const M: usize> {
    problem: Problem<D>,
    arguments: [Derivative<D>; M],
    term: Arc<Term<M>>,
}

/// Where the linearisations of an equation have led.
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
        const { assert!(M > 0, "a nonlinear term has at least one argument") };
        Self { problem, arguments, term: Arc::new(term) }
    }

    /// Solves by at most `steps` linearisations (one at least), starting from the mean of the
    /// constrained prior. Ask [`Solution::has_converged`] whether they were enough.
    ///
    /// `data` holds f at collocation points and, for inverse problems, measured values; with these,
    /// the conditional evidence is maximised. (From 40 values all over the domain of an Allen–Cahn
    /// front, ten times: the joint evidence left 20 % in ε, and 4 of its Laplace intervals held it;
    /// the conditional one 11 %, and 9.)
    /// Give the equation [`Noise::Learned`] where [`SemiLinear::variational`] is to follow.
    /// Fits start as in `options`, and near the end from the parameters before.
    ///
    /// # Errors
    /// If a fit fails, data are not finite, the term has no finite value or slope where a step leads,
    /// or there are no collocation points.
    pub fn solve(
        &self,
        kernel: &dyn Kernel<D>,
        data: &Data<D>,
        options: &FitOptions,
        steps: usize,
    ) -> Result<Solution<D>, GpError> {
        let points = collocation(data, self.problem.domain())?;
        let values = self.prior_values(kernel, &points)?;
        self.iterate(kernel, (data, &points), options, steps, (values, None))
    }

    /// [`SemiLinear::solve`] from a solution on other data or of another equation: fewer points, or
    /// a coefficient at which the problem is easier.
    ///
    /// # Errors
    /// As [`SemiLinear::solve`].
    pub fn solve_from(
        &self,
        start: &Solution<D>,
        kernel: &dyn Kernel<D>,
        data: &Data<D>,
        options: &FitOptions,
        steps: usize,
    ) -> Result<Solution<D>, GpError> {
        let points = collocation(data, self.problem.domain())?;
        let posterior = start.fit.posterior()?;
        let values = self.evaluate(&points, |operator| posterior.mean_of(operator, &points))?;
        let parameters = start.fit.outcome().parameters.clone();
        self.iterate(kernel, (data, &points), options, steps, (values, Some(parameters)))
    }

    /// L u + g(u) at points, to be compared with f there: where they differ most, the next
    /// collocation point belongs.
    ///
    /// # Errors
    /// If a feature has no derivative at a point, or the term no finite value there.
    pub fn left_hand_side(
        &self,
        solution: &Solution<D>,
        points: &[[f64; D]],
    ) -> Result<Vec<f64>, GpError> {
        let posterior = solution.fit.posterior()?;
        let mut sum = posterior.mean_of(self.problem.equation(), points)?;
        let arguments = self.evaluate(points, |operator| posterior.mean_of(operator, points))?;
        for (index, (sum, v)) in sum.iter_mut().zip(arguments).enumerate() {
            let variables = Series::plain(v);
            *sum += (variables[0].constant(0.0) + (self.term)(variables)).value();
            if !sum.is_finite() {
                return Err(singular_term(index, &v));
            }
        }
        Ok(sum)
    }

    fn iterate(
        &self,
        kernel: &dyn Kernel<D>,
        (data, points): (&Data<D>, &[[f64; D]]),
        options: &FitOptions,
        steps: usize,
        (mut values, mut parameters): (Vec<[f64; M]>, Option<Vec<f64>>),
    ) -> Result<Solution<D>, GpError> {
        let mut change = f64::INFINITY;
        let mut taken = 0;
        loop {
            let model = self.linearised(kernel, data, points, &values)?;
            // Parameters of a start on other data may be of another number.
            let count = model.parameters().len();
            let mut starts: Vec<Vec<f64>> =
                parameters.into_iter().filter(|known| known.len() == count).collect();
            // The first linearisations are far from the last: what fits them best may be elsewhere.
            if change > NEARLY || starts.is_empty() {
                starts.extend(model.random_starts(options));
            }
            let fit = model.fit_from(starts, options.iterations)?;
            let posterior = fit.posterior()?;
            let updated = self.evaluate(points, |operator| posterior.mean_of(operator, points))?;
            change = relative_change(&values, &updated);
            taken += 1;
            if change < CONVERGED || taken >= steps {
                return Ok(Solution { fit, steps: taken, change });
            }
            values = updated;
            parameters = Some(fit.outcome().parameters.clone());
        }
    }

    /// The arguments of the nonlinear term at the prior mean.
    fn prior_values(
        &self,
        kernel: &dyn Kernel<D>,
        points: &[[f64; D]],
    ) -> Result<Vec<[f64; M]>, GpError> {
        let prior = Prior::constrained(&self.problem, kernel)?;
        let degrees: [usize; D] =
            std::array::from_fn(|d| self.arguments.iter().map(|a| a.orders[d]).max().unwrap_or(0));
        Ok(points
            .iter()
            .map(|point| {
                let x = Series::variables(*point, degrees);
                let mean = x[0].constant(0.0) + prior.mean.at(x);
                self.arguments.map(|argument| mean.derivative(&argument.orders))
            })
            .collect())
    }

    /// Values of all arguments at the points, argument by argument from `of`.
    fn evaluate(
        &self,
        points: &[[f64; D]],
        of: impl Fn(&Operator<D>) -> Result<Vec<f64>, GpError>,
    ) -> Result<Vec<[f64; M]>, GpError> {
        let mut values = vec![[0.0; M]; points.len()];
        for (number, argument) in self.arguments.iter().enumerate() {
            for (value, of_argument) in values.iter_mut().zip(of(&(*argument).into())?) {
                value[number] = of_argument;
            }
        }
        Ok(values)
    }

    fn linearised(
        &self,
        kernel: &dyn Kernel<D>,
        data: &Data<D>,
        points: &[[f64; D]],
        values: &[[f64; M]],
    ) -> Result<Model<D>, GpError> {
        let mut coefficients: [HashMap<[u64; D], f64>; M] = std::array::from_fn(|_| HashMap::new());
        let mut shifts = Vec::with_capacity(points.len());
        for (index, (point, v)) in points.iter().zip(values).enumerate() {
            let variables = Series::variables(*v, [1; M]);
            let g = variables[0].constant(0.0) + (self.term)(variables);
            let mut shift = -g.value();
            for (number, map) in coefficients.iter_mut().enumerate() {
                let mut orders = [0; M];
                orders[number] = 1;
                let slope = g.derivative(&orders);
                shift += slope * v[number];
                map.insert(point.map(f64::to_bits), slope);
            }
            // Slopes that are not finite leave no finite shift either.
            if !shift.is_finite() {
                return Err(singular_term(index, v));
            }
            shifts.push(shift);
        }
        let mut equation = self.problem.equation().clone();
        for (map, argument) in coefficients.into_iter().zip(self.arguments) {
            equation = equation + tabulated(map) * argument;
        }
        let problem = self.problem.with_equation(equation)?;
        let mut shifts = shifts.into_iter();
        let groups = data.groups.iter().map(|group| {
            let mut group: Group<D> = group.clone();
            if group.operator.is_none() {
                group.values.iter_mut().zip(&mut shifts).for_each(|(f, shift)| *f += shift);
            }
            group
        });
        let data = Data { groups: groups.collect(), everywhere: None };
        // What the equation says of itself depends on the linearisation: with measured values, only
        // how well it predicts these counts.
        let measured = data.groups.iter().any(|group| group.role == Role::Observed);
        let evidence = if measured { Evidence::Conditional } else { Evidence::Joint };
        Model::new(Prior::constrained(&problem, kernel)?, data, evidence)
    }
}

/// A nonlinear term that is not finite where u may be, at a point of those given.
fn singular_term(index: usize, arguments: &[f64]) -> GpError {
    let arguments = place(arguments);
    GpError::Singular(format!(
        "the nonlinear term has no finite value or derivative near {arguments}, its arguments at point {index}; start from a solution that is better known, or define the term there"
    ))
}

/// Whether the equation holds without noise at some points.
fn is_exact<const D: usize>(data: &Data<D>) -> bool {
    data.groups.iter().any(|group| group.operator.is_none() && group.noise == Noise::Exact)
}

/// The points at which f is given, of sound data.
fn collocation<const D: usize>(
    data: &Data<D>,
    domain: &Domain<D>,
) -> Result<Vec<[f64; D]>, GpError> {
    check(&data.groups, domain)?;
    let imposed = data.groups.iter().filter(|group| group.operator.is_none());
    let points: Vec<[f64; D]> = imposed.flat_map(|group| group.points.iter().copied()).collect();
    if points.is_empty() { Err(no_data()) } else { Ok(points) }
}

/// Largest change of the first argument relative to its largest magnitude.
fn relative_change<const M: usize>(old: &[[f64; M]], new: &[[f64; M]]) -> f64 {
    let size = new.iter().fold(f64::MIN_POSITIVE, |most, v| most.max(v[0].abs()));
    let change = |(old, new): (&[f64; M], &[f64; M])| (old[0] - new[0]).abs();
    old.iter().zip(new).map(change).fold(0.0, f64::max) / size
}

/// A function known at some points only, and not a number elsewhere.
fn tabulated<const D: usize>(values: HashMap<[u64; D], f64>) -> Field<D> {
    field(move |x: [Series; D]| {
        let key = x.each_ref().map(|coordinate| coordinate.value().to_bits());
        x[0].constant(values.get(&key).copied().unwrap_or(f64::NAN))
    })
}
