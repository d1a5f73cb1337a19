//! Gaussian-process priors for a problem, with or without its boundary conditions.

use crate::constraint::{Constraints, Feature, constraints, edge_lifts, unconstrained};
use crate::data::{Group, Noise, Role};
use crate::domain::{Domain, Side};
use crate::error::GpError;
use crate::field::Field;
use crate::kernel::{Kernel, unusable};
use crate::operator::{Derivative, Operator};
use crate::problem::Problem;
use crate::structure::{AxisStructure, Lift};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// One summand σ² φ(x) φ(x′) k(x, x′) of a prior's covariance.
#[derive(Clone, Debug)]
pub(crate) struct Part<const D: usize> {
    pub feature: Feature<D>,
    pub kernel: Arc<dyn Kernel<D>>,
}

impl<const D: usize> Part<D> {
    /// A point as the kernel takes it: along a direction, the position is its first coordinate.
    pub(crate) fn seen(&self, mut point: [f64; D]) -> [f64; D] {
        if let Some([tx, ty]) = self.feature.direction {
            (point[0], point[1]) = (tx * point[0] + ty * point[1], 0.0);
        }
        point
    }

    /// A derivative of the latent function in these coordinates, and what it is multiplied by.
    pub(crate) fn turned(&self, mut orders: [usize; D]) -> ([usize; D], f64) {
        let Some([tx, ty]) = self.feature.direction else { return (orders, 1.0) };
        let factor = tx.powi(orders[0] as i32) * ty.powi(orders[1] as i32);
        (orders[0], orders[1]) = (orders[0] + orders[1], 0);
        (orders, factor)
    }
}

/// A Gaussian-process prior over solutions: three ways to account for boundary conditions behind
/// one interface.
#[derive(Clone, Debug)]
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
    /// If conditions conflict at a corner; if the kernel is too rough for the equation, is along an axis that there is not, or
    /// has a hyperparameter without a range.
    pub fn constrained(problem: &Problem<D>, kernel: &dyn Kernel<D>) -> Result<Self, GpError> {
        Self::of(problem, constraints(problem)?, kernel)
    }

    /// A prior that ignores the conditions (UCGP).
    ///
    /// # Errors
    /// If the kernel is too rough for the equation, is along an axis that there is not, or has a hyperparameter without a range.
    pub fn unconstrained(problem: &Problem<D>, kernel: &dyn Kernel<D>) -> Result<Self, GpError> {
        Self::of(problem, unconstrained(), kernel)
    }

    fn of(
        problem: &Problem<D>,
        Constraints { mean, features }: Constraints<D>,
        kernel: &dyn Kernel<D>,
    ) -> Result<Self, GpError> {
        check_declarations(kernel)?;
        check_smoothness(kernel, problem.equation())?;
        check_mean(problem.domain(), &mean)?;
        let (domain, equation) = (problem.domain().clone(), problem.equation().clone());
        let part = |feature: Feature<D>| Part { kernel: feature.kernel(kernel).into(), feature };
        let parts = features.into_iter().map(part).collect();
        Ok(Self { domain, equation, mean, parts, boundary: Vec::new() })
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

/// Refuses conditions whose formulas are undefined in the domain: places enough to find any that are on a hundredth of it.
fn check_mean<const D: usize>(domain: &Domain<D>, mean: &Field<D>) -> Result<(), GpError> {
    const PLACES: usize = 300;
    if mean.is_zero() {
        return Ok(());
    }
    let undefined = |x: &[f64; D]| !mean.value(*x).is_finite();
    match domain.sample(PLACES, 0)?.iter().find(|x| undefined(x)) {
        Some(x) => Err(GpError::Singular(format!(
            "the conditions' formulas have no finite value at {}; conditions are continued into the domain, so give formulas that are defined all over it",
            crate::error::place(x)
        ))),
        None => Ok(()),
    }
}

/// Refuses kernels whose hyperparameters have no range to be adjusted in, and those along axes that there are not, of which a
/// restriction to the domain's would leave a constant.
fn check_declarations<const D: usize>(kernel: &dyn Kernel<D>) -> Result<(), GpError> {
    let declared = kernel.hyperparameters();
    let all: Vec<usize> = (0..D).collect();
    let fault = match declared.iter().find_map(|h| Some((h.name, unusable::<D>(h)?))) {
        Some((name, problem)) => {
            format!("hyperparameter {name} of the {} kernel: {problem}", kernel.name())
        }
        None if kernel.on_axes(&all).hyperparameters().len() < declared.len() => {
            format!("the {} kernel: its axis is not one of the domain's", kernel.name())
        }
        None => return Ok(()),
    };
    Err(GpError::Kernel(fault))
}

/// Refuses kernels whose functions lack the derivatives that an operator takes.
pub(crate) fn check_smoothness<const D: usize>(
    kernel: &dyn Kernel<D>,
    operator: &Operator<D>,
) -> Result<(), GpError> {
    let needs = operator.order();
    match kernel.smoothness().filter(|has| *has < needs) {
        Some(has) => Err(GpError::Kernel(format!(
            "the {} kernel has {has} derivatives, the operator takes {needs}; use a smoother kernel",
            kernel.name()
        ))),
        None => Ok(()),
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
    let structures = (0..D).map(|axis| AxisStructure::new(problem, axis));
    let conditions: Vec<Lift<D>> = structures.flat_map(|structure| structure.lifts).collect();
    let polygon = domain.cross_section();
    let numbers = 0..polygon.map_or(0, |polygon| polygon.corners().len());
    let edges: Vec<_> = numbers
        .flat_map(|edge| edge_lifts(problem, edge).into_iter().map(move |lift| (edge, lift)))
        .collect();
    let (faces, all) = (conditions.len(), conditions.len() + edges.len());
    let share = |number: usize| (points * (number + 1)) / all - (points * number) / all;
    let mut groups = Vec::new();
    for (number, lift) in conditions.iter().enumerate() {
        let places = domain.sample(share(number), random.random())?;
        groups.push(pseudo_at_face(domain, lift, &places));
    }
    for (number, ((edge, lift), polygon)) in
        edges.into_iter().zip(polygon.into_iter().cycle()).enumerate()
    {
        let mut places = domain.sample(share(faces + number), random.random())?;
        for point in &mut places {
            (point[0], point[1]) = polygon.on_edge(edge, random.random_range(0.0..1.0)).into();
        }
        let [nx, ny] = lift.outwards().map(|n| n * lift.slope);
        let slope = nx * Derivative::along(0) + ny * Derivative::along(1);
        let value = lift.value.clone();
        let operator = match (value.is_zero(), lift.slope == 0.0) {
            (true, _) => slope,
            (false, true) => value * Derivative::identity(),
            (false, false) => value * Derivative::identity() + slope,
        };
        groups.push(pseudo(operator, places, &lift.data));
    }
    Ok(groups)
}

/// A condition at an end of an axis, or between both, at the projections of `places`.
fn pseudo_at_face<const D: usize>(
    domain: &Domain<D>,
    lift: &Lift<D>,
    places: &[[f64; D]],
) -> Group<D> {
    let at = |side: Side| {
        let mut places = places.to_vec();
        places.iter_mut().for_each(|point| point[lift.axis] = domain.end(lift.axis, side));
        places
    };
    let group = pseudo(lift.operator(), at(lift.at.unwrap_or(Side::Upper)), &lift.data);
    match lift.at {
        Some(_) => group,
        None => Group { further: vec![(-1.0, at(Side::Lower))], ..group },
    }
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
        further: Vec::new(),
        values,
        noise: Noise::Learned,
        role: Role::Imposed,
        averages: None,
    }
}
