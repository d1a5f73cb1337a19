//! Mean and features of a prior that satisfies boundary conditions.

mod corners;

use crate::prior::structure::{AxisStructure, Factor, Lift};
use crate::{Domain, Field, Polygon, Problem, Result, Series, constant, field};
use corners::check_corners;

/// Mean and features such that every function m + Σ φ zₚ satisfies all conditions, whatever the zₚ.
#[derive(Clone, Debug)]
pub struct Constraints<const D: usize> {
    /// A function that satisfies the conditions (Algorithm 3, and its like for other conditions).
    pub mean: Field<D>,
    /// Summands of the kernel.
    pub features: Vec<Feature<D>>,
}

/// A summand φ(x) φ(x′) k(x, x′) of a constrained kernel.
#[derive(Clone, Debug)]
pub struct Feature<const D: usize> {
    /// The factor φ, of size one.
    pub factor: Field<D>,
    /// The axes that k depends on; none for a constant that is integrated out (4.54).
    pub axes: Vec<usize>,
}

impl<const D: usize> Feature<D> {
    /// Feature with a kernel on all axes.
    fn everywhere(factor: Field<D>) -> Self {
        Self { factor, axes: (0..D).collect() }
    }

    /// Feature with one more factor.
    fn times(&self, axis: usize, own: &Factor<D>) -> Self {
        let axes = self.axes.iter().copied().filter(|d| *d != axis || own.free).collect();
        Self { factor: self.factor.product(&own.field), axes }
    }
}

/// No conditions at all: zero mean and one kernel on all axes.
pub(crate) fn unconstrained<const D: usize>() -> Constraints<D> {
    Constraints { mean: constant(0.0), features: vec![Feature::everywhere(constant(1.0))] }
}

/// The constrained mean and features of a problem (§4.4, §4.7).
///
/// # Errors
/// If conditions of two faces conflict where these meet.
pub fn constraints<const D: usize>(problem: &Problem<D>) -> Result<Constraints<D>> {
    instance!(D, Constraints::built_in, fn(&Problem<D>) -> Result<Constraints<D>>)(problem)
}

impl<const D: usize> Constraints<D> {
    fn built_in(problem: &Problem<D>) -> Result<Self> {
        let structures: [AxisStructure<D>; D] =
            std::array::from_fn(|axis| AxisStructure::new(problem, axis));
        check_corners(problem, &structures)?;
        let mean = mean(problem, &structures);
        let features = features(problem.domain(), &structures, planes(problem))?;
        Ok(Self { mean, features })
    }
}

/// Features in the plane of a polygon whose edges hold values: R-functions that vanish there in the first power of the distance, and at
/// corners in the second.
fn planes<const D: usize>(problem: &Problem<D>) -> Vec<Feature<D>> {
    let Some((polygon, _)) = problem.domain().cross_section().zip(problem.boundary.as_ref()) else {
        return vec![Feature::everywhere(constant(1.0))];
    };
    let of = |function: fn(&Polygon, &Series, &Series) -> Series| {
        let polygon = polygon.clone();
        Feature::everywhere(field(move |x: [Series; D]| function(&polygon, &x[0], &x[1])))
    };
    vec![of(Polygon::conjunction), of(Polygon::product)]
}

/// Axis by axis, the part of the conditions that the mean so far misses is added (Algorithm 3).
fn mean<const D: usize>(problem: &Problem<D>, structures: &[AxisStructure<D>; D]) -> Field<D> {
    let mut mean = problem.boundary.clone().unwrap_or_else(|| constant(0.0));
    // What misses a condition with a factor that varies is weighed by that factor: there last.
    let (even, uneven): (Vec<usize>, Vec<usize>) =
        (0..D).partition(|axis| !structures[*axis].varies(problem.domain()));
    for axis in even.into_iter().chain(uneven) {
        // A zero mean misses nothing of a homogeneous condition.
        let misses = |lift: &&Lift<D>| !(mean.is_zero() && lift.data.is_zero());
        let lifts: Vec<Lift<D>> = structures[axis].lifts.iter().filter(misses).cloned().collect();
        if lifts.is_empty() {
            continue;
        }
        let before = mean;
        mean = field(move |x: [Series; D]| {
            lifts.iter().fold(before.at(x.clone()), |sum, lift| {
                let missed = lift.data.at(lift.moved(&x, lift.side())) - lift.apply(&before, &x);
                sum + lift.shape.at(&x[axis]) * missed
            })
        });
    }
    mean
}

/// All products of a feature in the plane of a polygon and one factor for each axis: its bubble, with the kernel acting along
/// the axis, or one of its traces.
fn features<const D: usize>(
    domain: &Domain<D>,
    structures: &[AxisStructure<D>; D],
    planes: Vec<Feature<D>>,
) -> Result<Vec<Feature<D>>> {
    let mut products: Vec<(Feature<D>, bool)> =
        planes.into_iter().map(|plane| (plane, false)).collect();
    for (axis, structure) in structures.iter().enumerate() {
        let times = |(product, varies): (Feature<D>, bool)| {
            let each = structure.factors.iter();
            each.map(move |factor| (product.times(axis, factor), varies || factor.varies))
        };
        products = products.into_iter().flat_map(times).collect();
    }
    let scaled = |(feature, varies)| if varies { normalised(domain, feature) } else { Ok(feature) };
    products.into_iter().map(scaled).collect()
}

/// Scaled to size one, by sampling.
fn normalised<const D: usize>(domain: &Domain<D>, feature: Feature<D>) -> Result<Feature<D>> {
    let factor = feature.factor.clone();
    // Ends of the axes too, where traces are largest.
    let places = domain.sample(200, 0)?.into_iter().chain(domain.grid(5));
    let size = |at: [f64; D]| factor.value(at).abs();
    let most = places.map(size).filter(|size| size.is_finite()).fold(0.0, f64::max);
    let scale = if most > 0.0 { 1.0 / most } else { 1.0 };
    let factor = field(move |x: [Series; D]| factor.at(x) * scale);
    Ok(Feature { factor, ..feature })
}
