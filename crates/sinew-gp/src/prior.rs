//! Gaussian-process priors for a problem, with or without its boundary conditions.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::constraint::{constraints, unconstrained};
use crate::data::{Group, Noise, Role};
use crate::domain::{Domain, Side};
use crate::error::GpError;
use crate::field::Field;
use crate::kernel::Kernel;
use crate::operator::{Derivative, Operator};
use crate::problem::Problem;
use crate::structure::{AxisStructure, Functional};

/// One summand σ² φ(x) φ(x′) k(x, x′) of a prior's covariance.
#[derive(Debug)]
pub(crate) struct Part<const D: usize> {
    pub factor: Field<D>,
    pub axes: Vec<usize>,
    pub kernel: Box<dyn Kernel<D>>,
}

/// A Gaussian-process prior over solutions: three ways to account for boundary conditions behind
/// one interface.
#[derive(Debug)]
pub struct Prior<const D: usize> {
    pub(crate) domain: Domain<D>,
    pub(crate) equation: Operator<D>,
    pub(crate) mean: Field<D>,
    pub(crate) parts: Vec<Part<D>>,
    pub(crate) boundary: Vec<Group<D>>,
}

impl<const D: usize> Prior<D> {
    /// A prior all of whose functions satisfy the conditions exactly (HCGP, Definition 4.4.1 and
    /// §4.7). Traces on faces that the conditions leave free get `kernel` on the face's axes.
    ///
    /// # Errors
    /// If conditions conflict at a corner, or the kernel is too rough for the equation.
    pub fn constrained(problem: &Problem<D>, kernel: &dyn Kernel<D>) -> Result<Self, GpError> {
        let built = constraints(problem)?;
        check_smoothness(kernel, problem.equation())?;
        let part = |feature: crate::constraint::Feature<D>| Part {
            factor: feature.factor,
            kernel: kernel.on_axes(&feature.axes),
            axes: feature.axes,
        };
        Ok(Self {
            domain: problem.domain().clone(),
            equation: problem.equation().clone(),
            mean: built.mean,
            parts: built.features.into_iter().map(part).collect(),
            boundary: Vec::new(),
        })
    }

    /// A prior that ignores the conditions (UCGP).
    ///
    /// # Errors
    /// If the kernel is too rough for the equation.
    pub fn unconstrained(problem: &Problem<D>, kernel: &dyn Kernel<D>) -> Result<Self, GpError> {
        check_smoothness(kernel, problem.equation())?;
        let part = |feature: crate::constraint::Feature<D>| Part {
            factor: feature.factor,
            kernel: kernel.on_axes(&feature.axes),
            axes: feature.axes,
        };
        let free = unconstrained();
        Ok(Self {
            domain: problem.domain().clone(),
            equation: problem.equation().clone(),
            mean: free.mean,
            parts: free.features.into_iter().map(part).collect(),
            boundary: Vec::new(),
        })
    }

    /// The unconstrained prior with about `points` pseudo-observations of the conditions, spread
    /// at random over the faces (PCGP), of periodic axes by the jumps from their lower to their
    /// upper end. Their noise is learned, as in §4.8.2.
    ///
    /// # Errors
    /// As [`Prior::unconstrained`].
    pub fn penalised(
        problem: &Problem<D>,
        kernel: &dyn Kernel<D>,
        points: usize,
        seed: u64,
    ) -> Result<Self, GpError> {
        let mut prior = Self::unconstrained(problem, kernel)?;
        prior.boundary = pseudo_observations(problem, points, seed)?;
        Ok(prior)
    }
}

fn check_smoothness<const D: usize>(
    kernel: &dyn Kernel<D>,
    operator: &Operator<D>,
) -> Result<(), GpError> {
    match kernel.smoothness() {
        Some(has) if has < operator.order() => {
            Err(GpError::TooRough { kernel: kernel.name(), has, needs: operator.order() })
        }
        _ => Ok(()),
    }
}

/// The conditions of all faces as observations, about `points` in all.
fn pseudo_observations<const D: usize>(
    problem: &Problem<D>,
    points: usize,
    seed: u64,
) -> Result<Vec<Group<D>>, GpError> {
    let domain = problem.domain();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut conditions: Vec<(usize, Functional, Field<D>)> = Vec::new();
    for axis in 0..D {
        let ends = [domain.lower()[axis], domain.upper()[axis]];
        let structure = AxisStructure::new(ends, &problem.faces[axis], problem.periodic[axis]);
        conditions
            .extend(structure.lifts.into_iter().map(|lift| (axis, lift.functional, lift.data)));
    }
    let edges = domain.cross_section().filter(|_| problem.boundary.is_some());
    let share = |number: usize, of: usize| (points * (number + 1)) / of - (points * number) / of;
    let all = conditions.len() + usize::from(edges.is_some());
    let mut groups = Vec::new();
    for (number, (axis, functional, data)) in conditions.into_iter().enumerate() {
        let places = domain.sample(share(number, all), random.random())?;
        let at = |side: Side| {
            let mut places = places.clone();
            places.iter_mut().for_each(|point| point[axis] = domain.end(axis, side));
            places
        };
        let group = match functional {
            Functional::End { side, value, slope } => {
                let operator = match (value, slope) {
                    (value, 0.0) => value * Derivative::identity(),
                    (0.0, slope) => slope * Derivative::along(axis),
                    (a, b) => a * Derivative::identity() + b * Derivative::along(axis),
                };
                pseudo(operator, at(side), &data)
            }
            Functional::Jump { order } => {
                let mut derivative = Derivative::identity();
                derivative.orders[axis] = order;
                let jump = pseudo(derivative.into(), at(Side::Upper), &data);
                Group { opposite: Some(at(Side::Lower)), ..jump }
            }
        };
        groups.push(group);
    }
    if let Some((polygon, data)) = edges.zip(problem.boundary.as_ref()) {
        let mut places = domain.sample(share(all - 1, all), random.random())?;
        for point in &mut places {
            let edge = random.random_range(0..polygon.corners().len());
            let on_edge = polygon.on_edge(edge, random.random_range(0.0..1.0));
            (point[0], point[1]) = (on_edge[0], on_edge[1]);
        }
        groups.push(pseudo(Operator::identity(), places, data));
    }
    Ok(groups)
}

fn pseudo<const D: usize>(
    operator: Operator<D>,
    points: Vec<[f64; D]>,
    data: &Field<D>,
) -> Group<D> {
    let values = points.iter().map(|point| data.value(*point)).collect();
    Group {
        operator: Some(operator),
        points,
        opposite: None,
        values,
        noise: Noise::Learned,
        role: Role::Imposed,
    }
}
