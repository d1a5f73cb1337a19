//! From boundary conditions to the mean and the features of a prior that satisfies them.

use sinew_num::Series;

use crate::domain::{Domain, Side};
use crate::error::GpError;
use crate::field::{Field, field};
use crate::problem::Problem;
use crate::structure::{AxisStructure, Bubble, Lift, Shape};

/// A summand φ(x) φ(x′) k(x, x′) of a constrained kernel.
#[derive(Clone, Debug)]
pub struct Feature<const D: usize> {
    /// The factor φ, of size one.
    pub factor: Field<D>,
    /// The axes that k depends on; none for a constant that is integrated out (4.54).
    pub axes: Vec<usize>,
}

/// Mean and features such that every function m + Σ φ zₚ satisfies all conditions, whatever the zₚ.
#[derive(Clone, Debug)]
pub struct Constraints<const D: usize> {
    /// A function that satisfies the conditions (Algorithm 3, and its like for other conditions).
    pub mean: Field<D>,
    /// Summands of the kernel.
    pub features: Vec<Feature<D>>,
}

/// One factor of a feature.
#[derive(Clone, Debug)]
enum Factor {
    Bubble(usize, Bubble),
    Trace(usize, Shape),
}

/// No conditions at all: zero mean and one kernel on all axes.
pub(crate) fn unconstrained<const D: usize>() -> Constraints<D> {
    let feature = Feature { factor: crate::field::constant(1.0), axes: (0..D).collect() };
    Constraints { mean: Field::zero(), features: vec![feature] }
}

/// The constrained mean and features of a problem (§4.4, §4.7).
///
/// # Errors
/// If conditions of two faces conflict where these meet.
pub fn constraints<const D: usize>(problem: &Problem<D>) -> Result<Constraints<D>, GpError> {
    let structures: [AxisStructure<D>; D] = std::array::from_fn(|axis| {
        AxisStructure::new(
            ends(problem.domain(), axis),
            &problem.faces[axis],
            problem.periodic[axis],
        )
    });
    check_corners(problem, &structures)?;
    Ok(Constraints { mean: mean(problem, &structures), features: features(problem, &structures) })
}

fn ends<const D: usize>(domain: &Domain<D>, axis: usize) -> [f64; 2] {
    Side::BOTH.map(|side| domain.end(axis, side))
}

/// Axis by axis, the part of the conditions that the mean so far misses is added (Algorithm 3).
fn mean<const D: usize>(problem: &Problem<D>, structures: &[AxisStructure<D>; D]) -> Field<D> {
    let mut mean = problem.boundary.clone().unwrap_or_else(Field::zero);
    for (axis, structure) in structures.iter().enumerate() {
        let ends = ends(problem.domain(), axis);
        // A zero mean misses nothing of a homogeneous condition.
        let lifts: Vec<Lift<D>> = structure
            .lifts
            .iter()
            .filter(|lift| !(mean.is_zero() && lift.data.is_zero()))
            .cloned()
            .collect();
        if lifts.is_empty() {
            continue;
        }
        let before = mean;
        mean = field(move |x: [Series; D]| {
            lifts.iter().fold(before.at(x.clone()), |sum, lift| {
                let mut face = x.clone();
                face[axis] = x[axis].constant(ends[lift.functional.side().index()]);
                let missed = lift.data.at(face) - lift.functional.apply(&before, axis, ends, &x);
                sum + lift.shape.at(&x[axis]) * missed
            })
        });
    }
    mean
}

/// All products of one factor per axis: its bubble, with the kernel acting along the axis, or one of its traces.
fn features<const D: usize>(
    problem: &Problem<D>,
    structures: &[AxisStructure<D>; D],
) -> Vec<Feature<D>> {
    let mut products: Vec<Vec<Factor>> = vec![Vec::new()];
    for (axis, structure) in structures.iter().enumerate() {
        let bubble = Factor::Bubble(axis, structure.bubble.clone());
        let traces = structure.traces.iter().map(|shape| Factor::Trace(axis, shape.clone()));
        let choices: Vec<Factor> = std::iter::once(bubble).chain(traces).collect();
        products = products
            .iter()
            .flat_map(|product| {
                choices
                    .iter()
                    .map(|choice| [product.as_slice(), std::slice::from_ref(choice)].concat())
            })
            .collect();
    }
    let polygon = problem.boundary.as_ref().and(problem.domain().cross_section()).cloned();
    products
        .into_iter()
        .map(|factors| {
            let axes = factors
                .iter()
                .filter_map(|factor| match factor {
                    Factor::Bubble(axis, _) => Some(*axis),
                    Factor::Trace(..) => None,
                })
                .collect();
            let polygon = polygon.clone();
            let factor = field(move |x: [Series; D]| {
                let start = match &polygon {
                    Some(polygon) => polygon.feature(&x[0], &x[1]),
                    None => x[0].constant(1.0),
                };
                factors.iter().fold(start, |product, factor| match factor {
                    Factor::Bubble(_, bubble) if bubble.is_constant() => product,
                    Factor::Bubble(axis, bubble) => product * bubble.at(&x[*axis]),
                    Factor::Trace(axis, shape) => product * shape.at(&x[*axis]),
                })
            });
            Feature { factor, axes }
        })
        .collect()
}

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Fractions along the remaining axes where corners are compared.
const CORNER_SAMPLES: [f64; 5] = [0.5, 0.11, 0.83, 0.0, 1.0];

fn check_corners<const D: usize>(
    problem: &Problem<D>,
    structures: &[AxisStructure<D>; D],
) -> Result<(), GpError> {
    for first in 0..D {
        for second in first + 1..D {
            for a in &structures[first].lifts {
                for b in &structures[second].lifts {
                    check_corner(problem, (first, a), (second, b))?;
                }
            }
        }
    }
    let Some((value, polygon)) = problem.boundary.as_ref().zip(problem.domain().cross_section())
    else {
        return Ok(());
    };
    for axis in 2..D {
        for lift in &structures[axis].lifts {
            for edge in 0..polygon.corners().len() {
                for fraction in [0.0, 0.29, 0.71] {
                    let [x, y] = polygon.on_edge(edge, fraction);
                    let mut point = middle(problem.domain());
                    (point[0], point[1]) = (x, y);
                    check_edge(problem, point, (axis, lift), value)?;
                }
            }
        }
    }
    Ok(())
}

fn middle<const D: usize>(domain: &Domain<D>) -> [f64; D] {
    std::array::from_fn(|d| 0.5 * (domain.lower()[d] + domain.upper()[d]))
}

/// Whether the functional of one face, applied to the data of the other, gives what the other's
/// functional makes of the first's data.
fn check_corner<const D: usize>(
    problem: &Problem<D>,
    (first, a): (usize, &Lift<D>),
    (second, b): (usize, &Lift<D>),
) -> Result<(), GpError> {
    let domain = problem.domain();
    for fraction in CORNER_SAMPLES {
        let mut point: [f64; D] =
            std::array::from_fn(|d| domain.lower()[d] + fraction * domain.extents()[d]);
        point[first] = domain.end(first, a.functional.side());
        point[second] = domain.end(second, b.functional.side());
        // ∂ along `second` of the first face's data, against ∂ along `first` of the second's.
        let x = Series::plain(point);
        let implied = b.functional.apply(&a.data, second, ends(domain, second), &x).value();
        let asked = a.functional.apply(&b.data, first, ends(domain, first), &x).value();
        let size = magnitude(&a.data, domain) + magnitude(&b.data, domain);
        if differ(implied, asked, size) {
            let corner = format!(
                "{}, {}",
                domain.face(first, a.functional.side()),
                domain.face(second, b.functional.side())
            );
            return Err(GpError::ConflictingCorner { corner, first: implied, second: asked });
        }
    }
    Ok(())
}

/// Largest value found on a coarse grid: what rounding at a corner is relative to.
fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> f64 {
    if data.is_zero() {
        return 0.0;
    }
    // Off the middle, where sines vanish.
    const FRACTIONS: [f64; 4] = [0.0, 0.37, 0.71, 1.0];
    (0..4_usize.pow(D as u32))
        .map(|number| {
            let fraction = |d: usize| FRACTIONS[number / 4_usize.pow(d as u32) % 4];
            let point =
                std::array::from_fn(|d| domain.lower()[d] + fraction(d) * domain.extents()[d]);
            data.value(point).abs()
        })
        .fold(0.0, f64::max)
}

fn differ(a: f64, b: f64, scale: f64) -> bool {
    // A value that is not a number differs from everything.
    let close =
        (a - b).abs() <= CORNER_TOLERANCE * (a.abs() + b.abs() + scale).max(f64::MIN_POSITIVE);
    !(close || a == b)
}

/// The condition of a face against the values on the polygon's boundary.
fn check_edge<const D: usize>(
    problem: &Problem<D>,
    mut point: [f64; D],
    (axis, lift): (usize, &Lift<D>),
    boundary: &Field<D>,
) -> Result<(), GpError> {
    let domain = problem.domain();
    point[axis] = domain.end(axis, lift.functional.side());
    let implied =
        lift.functional.apply(boundary, axis, ends(domain, axis), &Series::plain(point)).value();
    let asked = lift.data.value(point);
    if differ(implied, asked, magnitude(boundary, domain) + magnitude(&lift.data, domain)) {
        let face = domain.face(axis, lift.functional.side());
        let corner = format!("{face}, polygon edge at ({}, {})", point[0], point[1]);
        return Err(GpError::ConflictingCorner { corner, first: implied, second: asked });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::condition::{Condition, Periodicity};
    use crate::field::constant;
    use crate::operator::Derivative;

    /// A smooth function without symmetries, standing for the latent functions of a prior.
    fn wild<const D: usize>(number: usize, axes: &[usize]) -> Field<D> {
        let axes = axes.to_vec();
        field(move |x: [Series; D]| {
            axes.iter().fold(x[0].constant(1.3), |sum, d| {
                sum * 0.7 + (&x[*d] * (1.7 + 0.3 * (*d + number) as f64) + 0.4).sin()
            })
        })
    }

    /// Mean and features, each times a function of its axes.
    fn draw<const D: usize>(problem: &Problem<D>) -> Field<D> {
        let Constraints { mean, features } = constraints(problem).unwrap();
        field(move |x: [Series; D]| {
            features.iter().enumerate().fold(mean.at(x.clone()), |sum, (number, feature)| {
                let latent = wild(number, &feature.axes).at(x.clone());
                sum + feature.factor.at(x.clone()) * latent
            })
        })
    }

    /// How far a drawn function misses the conditions, over points of all faces.
    fn miss<const D: usize>(problem: &Problem<D>) -> f64 {
        let drawn = draw(problem);
        let mut most = 0.0_f64;
        for axis in 0..D {
            let ends = ends(problem.domain(), axis);
            let structure = AxisStructure::new(ends, &problem.faces[axis], problem.periodic[axis]);
            for point in problem.domain().sample(20, 5).unwrap() {
                for lift in &structure.lifts {
                    let x = Series::plain(point);
                    let value = lift.functional.apply(&drawn, axis, ends, &x).value();
                    let mut point = point;
                    point[axis] = problem.domain().end(axis, lift.functional.side());
                    most = most.max((value - lift.data.value(point)).abs());
                }
            }
        }
        most
    }

    /// Conditions hold up to rounding.
    const TOLERANCE: f64 = 1e-9;

    fn square(names: [&str; 2]) -> Domain<2> {
        Domain::cuboid([(names[0], [0.0, PI]), (names[1], [0.0, 1.0])]).unwrap()
    }

    #[test]
    fn wave_with_insulated_ends_has_the_features_of_4_71() {
        let domain = square(["x", "t"]);
        let [dx, dt] = domain.derivatives();
        let problem = Problem::new(domain, dt * dt - dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, Condition::Neumann(constant(0.0))))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Neumann(constant(0.0))))
            .and_then(|p| {
                let value = field(|[x, _]| x.cos());
                let slope = field(|[x, _]| x.cos().squared());
                p.condition("t", Side::Lower, Condition::Cauchy { value, slope })
            })
            .unwrap();
        let built = constraints(&problem).unwrap();
        let axes: Vec<_> = built.features.iter().map(|f| f.axes.clone()).collect();
        assert_eq!(axes, [vec![0, 1], vec![1], vec![1]]);
        let x: f64 = 0.7;
        let expected = x.cos() + 0.4 * x.cos().powi(2);
        assert!((built.mean.value([x, 0.4]) - expected).abs() < 1e-14);
        assert!(miss(&problem) < TOLERANCE);
    }

    #[test]
    fn every_kind_of_condition_holds_for_whatever_is_drawn() {
        // A reference function's own values and slopes make compatible data on all faces.
        let u = || field(|[x, y]: [Series; 2]| (&x * 1.3 + 0.2).sin() * (&y * -0.8).exp() + x * y);
        let slope = |axis: usize| {
            field(move |x: [Series; 2]| {
                let u = |[x, y]: [Series; 2]| (&x * 1.3 + 0.2).sin() * (&y * -0.8).exp() + x * y;
                let mut lifted = x.each_ref().map(|c| c.lifted(1));
                let value = x[axis].value();
                lifted[axis] = lifted[axis].shifted_last_variable(value);
                u(lifted).last_derivative(1)
            })
        };
        let kinds = |axis: usize| {
            vec![
                None,
                Some(Condition::Dirichlet(u())),
                Some(Condition::Neumann(slope(axis))),
                Some(Condition::Cauchy { value: u(), slope: slope(axis) }),
                Some(Condition::Robin {
                    value_factor: 2.0,
                    slope_factor: -0.5,
                    data: field(move |x: [Series; 2]| {
                        u().at(x.clone()) * 2.0 - slope(axis).at(x) * 0.5
                    }),
                }),
            ]
        };
        for lower in 0..5 {
            for upper in 0..5 {
                for other in 0..5 {
                    let domain = square(["x", "y"]);
                    let mut problem = Problem::new(domain, Derivative::along(0)).unwrap();
                    for (axis, side, kind) in [
                        ("x", Side::Lower, lower),
                        ("x", Side::Upper, upper),
                        ("y", Side::Lower, other),
                    ] {
                        let axis_number = usize::from(axis == "y");
                        if let Some(condition) = kinds(axis_number)[kind].clone() {
                            problem = problem.condition(axis, side, condition).unwrap();
                        }
                    }
                    let missed = miss(&problem);
                    assert!(missed < TOLERANCE, "{lower} {upper} {other}: {missed:e}");
                }
            }
        }
    }

    #[test]
    fn periodic_axes_join() {
        for periodicity in [Periodicity::Value, Periodicity::ValueAndSlope] {
            let problem = Problem::new(square(["x", "t"]), Derivative::along(1))
                .and_then(|p| p.periodic("x", periodicity))
                .and_then(|p| {
                    let start = Condition::Dirichlet(field(|[x, _]| (x * 2.0).sin()));
                    p.condition("t", Side::Lower, start)
                })
                .unwrap();
            assert!(miss(&problem) < TOLERANCE);
        }
    }

    #[test]
    fn conflicts_are_named_by_their_corner() {
        let problem = Problem::new(square(["x", "t"]), Derivative::along(1))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Dirichlet(constant(1.0))))
            .and_then(|p| {
                p.condition("t", Side::Lower, Condition::Dirichlet(field(|[x, _]| x.sin())))
            })
            .unwrap();
        let error = constraints(&problem).unwrap_err();
        assert!(error.to_string().contains(&format!("corner x = {PI}, t = 0")), "{error}");
        let twice = problem.condition("x", Side::Upper, Condition::Neumann(constant(0.0)));
        assert!(matches!(twice, Err(GpError::OverDetermined { .. })));
    }

    #[test]
    fn a_polygon_in_time_keeps_its_edges_and_its_start() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let domain = Domain::prism(["x", "y"], &corners, ("t", [0.0, 1.0])).unwrap();
        let edge = || field(|[x, y, t]: [Series; 3]| x * 0.5 + y + t);
        let problem = |start| {
            Problem::new(domain.clone(), Derivative::along(2))
                .and_then(|p| p.boundary(edge()))
                .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(start)))
        };
        let good = problem(field(|[x, y, _]: [Series; 3]| x * 0.5 + y)).unwrap();
        let drawn = draw(&good);
        let polygon = Domain::cross_section(&domain).unwrap();
        for number in 0..6 {
            let [x, y] = polygon.on_edge(number, 0.37);
            let missed = drawn.value([x, y, 0.6]) - edge().value([x, y, 0.6]);
            assert!(missed.abs() < TOLERANCE, "edge {number}: {missed:e}");
        }
        assert!(miss(&good) < TOLERANCE);
        let bad = problem(constant(0.0)).unwrap();
        assert!(matches!(constraints(&bad), Err(GpError::ConflictingCorner { .. })));
        let face = bad.condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)));
        assert!(matches!(face, Err(GpError::PolygonFace { .. })));
    }
}
