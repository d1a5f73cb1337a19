//! Mean and features of a prior that satisfies boundary conditions.

use crate::prior::structure::{AxisStructure, Factor, Lift};
use crate::{Domain, Field, Polygon, Problem, Result, Series, constant, field};

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
    let axes: Vec<_> = (0..D).map(|axis| AxisStructure::new(problem, axis)).collect();
    check_corners(problem.domain(), &axes)?;
    Ok(Constraints { mean: mean(problem, &axes), features: features(problem, &axes)? })
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
fn mean<const D: usize>(problem: &Problem<D>, axes: &[AxisStructure<D>]) -> Field<D> {
    let mut mean = problem.boundary.clone().unwrap_or_else(|| constant(0.0));
    // What misses a condition with a factor that varies is weighed by that factor: there last.
    let (even, uneven): (Vec<usize>, Vec<usize>) =
        (0..D).partition(|axis| !axes[*axis].varies(problem.domain()));
    for axis in even.into_iter().chain(uneven) {
        // A zero mean misses nothing of a homogeneous condition.
        let misses = |lift: &&Lift<D>| !(mean.is_zero() && lift.data.is_zero());
        let lifts: Vec<Lift<D>> = axes[axis].lifts.iter().filter(misses).cloned().collect();
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
    problem: &Problem<D>,
    axes: &[AxisStructure<D>],
) -> Result<Vec<Feature<D>>> {
    let mut products: Vec<_> = planes(problem).into_iter().map(|plane| (plane, false)).collect();
    for (axis, structure) in axes.iter().enumerate() {
        let times = |(product, varies): (Feature<D>, bool)| {
            let each = structure.factors.iter();
            each.map(move |factor| (product.times(axis, factor), varies || factor.varies))
        };
        products = products.into_iter().flat_map(times).collect();
    }
    let scaled = |(feature, varies)| match varies {
        true => normalised(problem.domain(), feature),
        false => Ok(feature),
    };
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

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Compares all faces two by two.
fn check_corners<const D: usize>(domain: &Domain<D>, axes: &[AxisStructure<D>]) -> Result<()> {
    let varies = |axis: &usize| axes[*axis].varies(domain);
    let varying: Vec<_> = (0..D).filter(varies).map(|axis| &domain.names()[axis]).collect();
    ensure!(
        varying.len() < 2,
        "factors of Robin conditions vary on faces of both {} and {}; impose those of one axis at points by `Data::imposed`",
        varying[0],
        varying[1]
    );
    for (number, axis) in axes.iter().enumerate() {
        for a in &axis.lifts {
            for b in axes[number + 1..].iter().flat_map(|other| &other.lifts) {
                check_corner(domain, a, b)?;
            }
        }
    }
    Ok(())
}

/// Whether the functional of one face, applied to the data of the other, gives what the other's
/// functional makes of the first's data; at places along the diagonal of the domain.
fn check_corner<const D: usize>(domain: &Domain<D>, a: &Lift<D>, b: &Lift<D>) -> Result<()> {
    let size = magnitude(&a.data, domain)? + magnitude(&b.data, domain)?;
    for share in [0.5, 0.11, 0.83, 0.0, 1.0] {
        let mut point: [f64; D] = domain.ends.map(|[lower, upper]| lower + share * (upper - lower));
        (point[a.axis], point[b.axis]) = (a.end(), b.end());
        let x = Series::plain(point);
        for (own, other) in [(a, b), (b, a)] {
            ensure!(
                other.lets_pass(&own.value, &x),
                "the factor of the Robin condition on {} varies where it meets {}, on which a slope is held; give a factor without slope there, or impose one of the two at points by `Data::imposed`",
                own.face(domain),
                other.face(domain)
            );
        }
        // ∂ along the second axis of the first face's data, against ∂ along the first of the second's.
        let [implied, asked] = [b.apply(&a.data, &x).value(), a.apply(&b.data, &x).value()];
        let scale = (implied.abs() + asked.abs() + size).max(f64::MIN_POSITIVE);
        // NaN differs from everything.
        ensure!(
            (implied - asked).abs() <= CORNER_TOLERANCE * scale || implied == asked,
            "conditions conflict at the corner {}, {}: {implied} from one face, {asked} from the other",
            a.face(domain),
            b.face(domain)
        );
    }
    Ok(())
}

/// Largest value found: what rounding at a corner is relative to.
fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> Result<f64> {
    const PLACES: usize = 64;
    let places = domain.sample(PLACES, 0)?.into_iter();
    Ok(places.map(|x| data.value(x).abs()).fold(0.0, f64::max))
}
