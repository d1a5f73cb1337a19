//! Features as singular as solutions are at the corners of a polygon.
//!
//! Where u = 0 on both edges of a corner of angle α and the equation's leading part is the Laplacian,
//! u is there a function as smooth as its data plus multiples of r^{kλ} sin kλδ with λ = π/α and the
//! angle δ from one edge (Kondrat'ev 1967; Grisvard 1985, *Elliptic problems in nonsmooth domains*).
//! No smooth function times a distance is like that, so a prior needs both summands:
//!
//! - on convex polygons Π dₑ, smooth, and Π dₑ Π q_c, where d d′ q_c = r^λ sin λδ for the edges of corner c (at
//!   right angles, where that is a polynomial, the function with a logarithm that a constant load makes);
//! - elsewhere the polygon's feature, and Σ r^{kλ} sin kλδ (1 − r²/R²)⁶ over the corners, each ending
//!   before it reaches another edge, for the exponents below two.
//!
//! Between an edge with a value and one with a slope the exponents are (k − ½)λ, between two with slopes the functions are
//! r^{kλ} cos kλδ. No function of the plane may multiply these without breaking the slope, so that each has a constant of its own.

use crate::field::{Field, field};
use crate::operator::{Operator, Term};
use crate::polygon::Polygon;
use crate::series::Series;
use std::f64::consts::PI;

/// A corner with its two edges.
#[derive(Clone, Debug)]
pub(super) struct Wedge {
    place: [f64; 2],
    /// Unit vectors along each edge away from the corner, and to the inside.
    legs: [[[f64; 2]; 2]; 2],
    /// Unit vector that halves the angle.
    middle: [f64; 2],
    /// λ = π/α.
    exponent: f64,
    /// Distance to the nearest edge that does not end here, or corner.
    radius: f64,
    /// Three times the greatest distance to another corner.
    far: f64,
}

/// Condition on an edge of a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    Value,
    Slope,
}

/// Distance from an exponent to a whole number below which the singular function is a polynomial.
const WHOLE: f64 = 1e-6;
/// Contact of singular functions with zero where they end: more than equations have derivatives.
const CONTACT: usize = 6;

impl Wedge {
    pub(super) fn new(polygon: &Polygon, own: usize) -> Self {
        let (edges, count) = (polygon.edges(), polygon.edges().len());
        let other = (own + count - 1) % count;
        let (before, after) = (&edges[other], &edges[own]);
        let ([ax, ay], [bx, by]) = (before.tangent, after.tangent);
        let angle = PI - (ax * by - ay * bx).atan2(ax * bx + ay * by);
        let place = after.start;
        let radius = (edges.iter().enumerate())
            .filter(|(number, _)| *number != own && *number != other)
            .map(|(_, edge)| edge.distance(place))
            .fold(before.length.min(after.length), f64::min);
        let legs = [[after.tangent, after.normal], [[-ax, -ay], before.normal]];
        let (sin, cos) = (0.5 * angle).sin_cos();
        let middle = [bx * cos - by * sin, bx * sin + by * cos];
        let far = edges.iter().map(|edge| {
            let [x, y] = edge.start;
            3.0 * (x - place[0]).hypot(y - place[1])
        });
        Self { place, legs, middle, exponent: PI / angle, radius, far: far.fold(0.0, f64::max) }
    }

    /// Whether r^λ sin λδ is a polynomial.
    fn is_whole(&self) -> bool {
        (self.exponent - self.exponent.round()).abs() < WHOLE
    }

    /// Whether solutions have a logarithm in the second power of r, whatever they are driven by.
    fn is_right(&self) -> bool {
        (self.exponent - 2.0).abs() < WHOLE
    }

    /// r², the angle from the nearer edge, and whether that is the second one; nothing at the corner.
    fn polar(&self, x: &Series, y: &Series) -> Option<(Series, Series, bool)> {
        let (x, y) = (x - self.place[0], y - self.place[1]);
        let square = x.squared() + y.squared();
        if square.value() == 0.0 {
            return None;
        }
        let swapped = self.middle[0] * y.value() > self.middle[1] * x.value();
        let [[tx, ty], [nx, ny]] = self.legs[usize::from(swapped)];
        let (along, across) = (&x * tx + &y * ty, &x * nx + &y * ny);
        let start = across.value().atan2(along.value());
        let radius = square.sqrt();
        // δ + sin(δ* − δ) cubes the error, which begins with first powers: enough for 27th ones.
        let angle = (0..3).fold(square.constant(start), |angle, _| {
            &angle + (&across * angle.cos() - &along * angle.sin()) / &radius
        });
        Some((square, angle, swapped))
    }

    /// q with d d′ q = r^λ sin λδ, smooth on the edges; nothing at the corner, where it is infinite.
    ///
    /// At right angles that is a polynomial, and r² (ln(r/R) sin 2δ + δ cos 2δ + ½π sin² δ) takes its place: its
    /// Laplacian is constant, and it vanishes on both edges. R is so large that q has no zeros.
    fn quotient(&self, x: &Series, y: &Series) -> Option<Series> {
        let (square, angle, _) = self.polar(x, y)?;
        if self.is_right() {
            let (sine, cosine) = (angle.sin(), angle.cos());
            let turned = (&angle * 2.0).cos() / cardinal_sine(&angle) + sine * (0.5 * PI);
            return Some((square / (self.far * self.far)).ln() * -1.0 - turned / cosine);
        }
        let exponent = self.exponent;
        let ratio = cardinal_sine(&(&angle * exponent)) / cardinal_sine(&angle) * exponent;
        let scaled = (square / (self.radius * self.radius)).powf(0.5 * exponent - 1.0);
        Some(scaled * ratio / (angle * -1.0 + PI / exponent).sin())
    }

    /// Exponents below two, but whole ones, of the k-th singular functions.
    pub(super) fn exponents(&self, mixed: bool) -> Vec<(usize, f64)> {
        let shift = if mixed { 0.5 } else { 0.0 };
        let exponent = |k: usize| (k, (k as f64 - shift) * self.exponent);
        let rough = |(_, exponent): &(usize, f64)| {
            *exponent < 2.0 - WHOLE && (exponent - exponent.round()).abs() > WHOLE
        };
        (1..=4).map(exponent).filter(rough).collect()
    }

    /// The k-th singular function between edges that hold the value (sine) or the slope, first the one that begins here;
    /// nothing at the corner.
    pub(super) fn around(
        &self,
        (k, exponent): (usize, f64),
        held: [Held; 2],
        x: &Series,
        y: &Series,
    ) -> Option<Series> {
        let (square, angle, swapped) = self.polar(x, y)?;
        let square = square / (self.radius * self.radius);
        let near = held[usize::from(swapped)];
        // Seen from the other edge: sin(kπ − μδ), cos(kπ − μδ) or sin((k − ½)π − μδ).
        let odd = match held {
            [Held::Value, Held::Value] => swapped && k.is_multiple_of(2),
            [Held::Slope, Held::Slope] => swapped && !k.is_multiple_of(2),
            _ => near == Held::Slope && k.is_multiple_of(2),
        };
        let sign = if odd { -1.0 } else { 1.0 };
        let around = match near {
            Held::Value => (angle * exponent).sin(),
            Held::Slope => (angle * exponent).cos(),
        };
        Some(square.powf(0.5 * exponent) * around * sign)
    }

    /// Singular function that ends at the radius along rays from the corner, so that slopes across its edges stay zero.
    fn singular(&self, order: (usize, f64), held: [Held; 2], x: &Series, y: &Series) -> Series {
        let square = (x - self.place[0]).squared() + (y - self.place[1]).squared();
        let square = square / (self.radius * self.radius);
        if square.value() >= 1.0 {
            return x.constant(0.0);
        }
        match self.around(order, held, x, y) {
            Some(around) => around * (square.constant(1.0) - square).powi(CONTACT),
            // Value zero, without derivatives.
            None => (x - self.place[0]).squared().sqrt(),
        }
    }
}

/// sin u / u for |u| up to about two.
fn cardinal_sine(u: &Series) -> Series {
    const TERMS: usize = 16;
    let square = u.squared();
    (1..=TERMS).rev().fold(u.constant(1.0), |sum, k| {
        let factor = (2 * k * (2 * k + 1)) as f64;
        sum * &square / -factor + 1.0
    })
}

/// Factors in the plane for u = 0 on all edges, if the polygon adapts them to the corners of `equation`.
pub(super) fn adapted<const D: usize>(
    polygon: &Polygon,
    equation: &Operator<D>,
) -> Option<Vec<Field<D>>> {
    if !led_by_laplacian(equation) {
        return None;
    }
    let owned = polygon.clone();
    let mut factors = vec![field(move |x: [Series; D]| owned.feature(&x[0], &x[1]))];
    let count = polygon.edges().len();
    let wedges: Vec<Wedge> = (0..count).map(|own| Wedge::new(polygon, own)).collect();
    match polygon.is_convex() {
        true => factors.extend(convex(polygon, wedges)),
        false => factors.extend(notched(polygon, &wedges)),
    }
    Some(factors)
}

/// Singular functions for what is held on each edge, one by one; corners next to other edges have none.
pub(super) fn singular<const D: usize>(
    polygon: &Polygon,
    equation: &Operator<D>,
    held: &[Option<Held>],
) -> Vec<Field<D>> {
    if !led_by_laplacian(equation) {
        return Vec::new();
    }
    let mut factors = Vec::new();
    for own in 0..held.len() {
        let before = held[(own + held.len() - 1) % held.len()];
        let (Some(first), Some(second)) = (held[own], before) else { continue };
        let wedge = Wedge::new(polygon, own);
        for order in wedge.exponents(first != second) {
            let wedge = wedge.clone();
            factors.push(normalised(polygon, move |x: &[Series; D]| {
                wedge.singular(order, [first, second], &x[0], &x[1])
            }));
        }
    }
    factors
}

/// The feature times the quotients of all corners, where these add anything.
fn convex<const D: usize>(polygon: &Polygon, wedges: Vec<Wedge>) -> Option<Field<D>> {
    if wedges.iter().all(|wedge| wedge.is_whole() && !wedge.is_right()) {
        return None;
    }
    let owned = polygon.clone();
    let singular = move |x: &[Series; D]| {
        let feature = owned.feature(&x[0], &x[1]);
        let quotients = wedges.iter().map(|wedge| wedge.quotient(&x[0], &x[1]));
        match quotients.collect::<Option<Vec<Series>>>() {
            Some(quotients) => quotients.iter().fold(feature, |product, q| product * q),
            // At a corner: the value is zero, derivatives do not exist.
            None => feature.squared().sqrt(),
        }
    };
    Some(normalised(polygon, singular))
}

/// Sums over the corners of the k-th singular functions.
fn notched<const D: usize>(polygon: &Polygon, wedges: &[Wedge]) -> Vec<Field<D>> {
    let of = |k: usize| {
        let order = |wedge: &Wedge| wedge.exponents(false).into_iter().find(|(own, _)| *own == k);
        let rough = wedges.iter().filter_map(|wedge| Some((wedge.clone(), order(wedge)?)));
        let rough: Vec<_> = rough.collect();
        (!rough.is_empty()).then(|| {
            normalised(polygon, move |x: &[Series; D]| {
                rough.iter().fold(x[0].constant(0.0), |sum, (wedge, order)| {
                    sum + wedge.singular(*order, [Held::Value; 2], &x[0], &x[1])
                })
            })
        })
    };
    (1..=3).filter_map(of).collect()
}

/// Scaled to size one in the plane, where further coordinates are zero.
pub(super) fn normalised<const D: usize>(
    polygon: &Polygon,
    factor: impl Fn(&[Series; D]) -> Series + Send + Sync + 'static,
) -> Field<D> {
    let most = polygon.largest(|x, y| {
        let mut at: [Series; D] = std::array::from_fn(|_| x.constant(0.0));
        (at[0], at[1]) = (x.clone(), y.clone());
        factor(&at).value().abs()
    });
    field(move |x: [Series; D]| factor(&x) / most)
}

/// Whether the terms of highest order in the plane are multiples of ∂²/∂x² + ∂²/∂y².
fn led_by_laplacian<const D: usize>(equation: &Operator<D>) -> bool {
    let order = |term: &Term<D>| term.derivative.orders[0] + term.derivative.orders[1];
    let rest = |term: &Term<D>| term.derivative.orders[2..].to_vec();
    if equation.terms().iter().map(order).max() != Some(2) {
        return false;
    }
    let leading: Vec<&Term<D>> = equation.terms().iter().filter(|term| order(term) == 2).collect();
    let balanced = |term: &&Term<D>| {
        let alike = leading
            .iter()
            .filter(|other| other.parameters == term.parameters && rest(other) == rest(term));
        let sums = alike.fold([0.0, 0.0], |[difference, size], other| {
            let sign = if other.derivative.orders[0] == 2 { 1.0 } else { -1.0 };
            [difference + sign * other.scale, size + other.scale.abs()]
        });
        sums[0].abs() <= 1e-12 * sums[1]
    };
    leading.iter().all(|term| term.function.is_none() && term.derivative.orders[0] != 1)
        && leading.iter().all(balanced)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;

    fn pentagon() -> Polygon {
        let corner = |k: usize| PI * (0.5 + 0.4 * k as f64);
        let corners: Vec<[f64; 2]> = (0..5).map(|k| [corner(k).cos(), corner(k).sin()]).collect();
        Polygon::new(&corners).unwrap()
    }

    #[test]
    fn singular_functions_are_harmonic_and_vanish_on_both_edges() {
        let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let (convex, notched) = (pentagon(), Polygon::new(&notched).unwrap());
        for (polygon, own, inside) in [
            (&convex, 0, [0.1, 0.55]),
            (&convex, 2, [-0.3, -0.4]),
            (&notched, 3, [0.7, 0.9]),
            (&notched, 3, [0.9, 0.5]),
            (&notched, 3, [1.3, 0.9]),
            (&notched, 3, [0.9, 1.3]),
        ] {
            let wedge = Wedge::new(polygon, own);
            let [x, y] = Series::variables(inside, [2, 2]);
            let (square, angle, _) = wedge.polar(&x, &y).unwrap();
            let exponent = wedge.exponent;
            let function = square.powf(0.5 * exponent) * (angle * exponent).sin();
            let laplacian = function.derivative(&[2, 0]) + function.derivative(&[0, 2]);
            let size = function.derivative(&[2, 0]).abs();
            assert!(function.value() > 0.0);
            assert!(laplacian.abs() < 1e-12 * size, "{laplacian:e} of {size}");
            if polygon.is_convex() {
                let edges = polygon.edges();
                let count = edges.len();
                let heights =
                    edges[own].height(&x, &y) * edges[(own + count - 1) % count].height(&x, &y);
                let again = wedge.quotient(&x, &y).unwrap() * heights;
                let ratio =
                    |orders: &[usize]| again.derivative(orders) / function.derivative(orders);
                assert!((ratio(&[1, 1]) / ratio(&[0, 0]) - 1.0).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn at_right_angles_the_laplacian_is_constant() {
        let polygon = Polygon::new(&[[0.0, 0.0], [2.0, 0.5], [1.75, 1.5], [-0.25, 1.0]]).unwrap();
        let wedge = Wedge::new(&polygon, 1);
        assert!(wedge.is_right());
        let edges = polygon.edges();
        for inside in [[1.7, 0.8], [1.8, 0.6], [1.4, 0.9], [0.3, 0.6]] {
            let [x, y] = Series::variables(inside, [2, 2]);
            let quotient = wedge.quotient(&x, &y).unwrap();
            let function = &quotient * edges[0].height(&x, &y) * edges[1].height(&x, &y);
            let laplacian = function.derivative(&[2, 0]) + function.derivative(&[0, 2]);
            // Half of that of r² (ln(r/R) sin 2δ + δ cos 2δ + ½π sin² δ), and downwards.
            assert!((laplacian + PI).abs() < 1e-11, "{laplacian} at {inside:?}");
            assert!(quotient.value() > 0.0);
        }
    }

    #[test]
    fn features_vanish_on_the_boundary_with_all_derivatives_along_it() {
        let notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        // Of the exponents of the notch, 2/3 and 4/3 are below two.
        for (corners, features) in [(pentagon().corners(), 2), (&notched[..], 3)] {
            let domain = Domain::polygon(["x", "y"], corners).unwrap();
            let [dx, dy] = domain.derivatives();
            let polygon = domain.cross_section().unwrap();
            let factors = adapted::<2>(polygon, &(dx * dx + dy * dy)).unwrap();
            assert_eq!(factors.len(), features);
            for factor in &factors {
                for edge in 0..corners.len() {
                    let value = factor.at(Series::variables(polygon.on_edge(edge, 0.3), [2, 2]));
                    assert!(value.value().abs() < 1e-15, "{} on {edge}", value.value());
                    assert!(value.derivative(&[2, 0]).is_finite());
                    let corner = factor.value(polygon.corners()[edge]);
                    assert!(corner.abs() < 1e-15, "{corner} at {edge}");
                }
            }
        }
    }

    #[test]
    fn only_equations_led_by_the_laplacian_are_adapted_to() {
        let domain = Domain::polygon(["x", "y"], pentagon().corners()).unwrap();
        let [dx, dy] = domain.derivatives();
        assert!(led_by_laplacian(&(-2.0 * (dx * dx) - 2.0 * (dy * dy) + 3.0 * dx)));
        assert!(!led_by_laplacian(&(-2.0 * (dx * dx) - dy * dy)));
        assert!(!led_by_laplacian(&(dx * dx + dy * dy + dx * dy)));
        assert!(!led_by_laplacian(&(dx * dx * dx * dx + dy * dy)));
        assert!(!led_by_laplacian(&(dx + dy)));
    }
}
