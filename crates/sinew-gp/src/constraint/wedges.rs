//! Features as singular as solutions are at the corners of a convex polygon.
//!
//! Where u = 0 on both edges of a corner of angle α and the equation's leading part is the Laplacian,
//! u is there a function as smooth as its data plus multiples of r^{kλ} sin kλδ with λ = π/α and the
//! angle δ from one edge (Kondrat'ev 1967; Grisvard 1985, *Elliptic problems in nonsmooth domains*).
//! No smooth function times a distance is like that, so a prior needs both summands: Π dₑ, smooth, and Π dₑ Π q_c, where
//! d d′ q_c = r^λ sin λδ for the edges of corner c (at right angles, where that is a polynomial, the function with a logarithm
//! that a constant load makes).

use crate::field::{Field, field};
use crate::operator::{Operator, Term};
use crate::polygon::Polygon;
use crate::series::Series;
use std::f64::consts::PI;

/// A corner with its two edges.
#[derive(Clone, Debug)]
struct Wedge {
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

/// Distance from an exponent to a whole number below which the singular function is a polynomial.
const WHOLE: f64 = 1e-6;
impl Wedge {
    fn new(polygon: &Polygon, own: usize) -> Self {
        let (corners, normals) = (polygon.corners(), &polygon.normals);
        let count = corners.len();
        let before = (own + count - 1) % count;
        let [[ax, ay], [bx, by]] = [before, own].map(|edge| [normals[edge][1], -normals[edge][0]]);
        let angle = PI - (ax * by - ay * bx).atan2(ax * bx + ay * by);
        let place = corners[own];
        let legs = [[[bx, by], normals[own]], [[-ax, -ay], normals[before]]];
        let (sin, cos) = (0.5 * angle).sin_cos();
        let middle = [bx * cos - by * sin, bx * sin + by * cos];
        let length = |edge: usize| {
            let ([ax, ay], [bx, by]) = (corners[edge], corners[(edge + 1) % count]);
            (bx - ax).hypot(by - ay)
        };
        let distance = |edge: usize| {
            let ([nx, ny], [sx, sy]) = (normals[edge], corners[edge]);
            let (x, y) = (place[0] - sx, place[1] - sy);
            let along = (x * ny - y * nx).clamp(0.0, length(edge));
            (x - along * ny).hypot(y + along * nx)
        };
        let others = (0..count).filter(|edge| *edge != own && *edge != before);
        let nearest = length(before).min(length(own));
        let radius = others.map(distance).fold(nearest, f64::min);
        let far = corners.iter().map(|[x, y]| 3.0 * (x - place[0]).hypot(y - place[1]));
        let far = far.fold(0.0, f64::max);
        Self { place, legs, middle, exponent: PI / angle, radius, far }
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

/// Factors in the plane for u = 0 on all edges.
pub(super) fn planes<const D: usize>(polygon: &Polygon, equation: &Operator<D>) -> Vec<Field<D>> {
    let owned = polygon.clone();
    if !led_by_laplacian(equation) {
        return vec![field(move |x: [Series; D]| owned.conjunction(&x[0], &x[1]))];
    }
    let smooth = field(move |x: [Series; D]| owned.product(&x[0], &x[1]));
    let wedges = (0..polygon.corners().len()).map(|own| Wedge::new(polygon, own)).collect();
    std::iter::once(smooth).chain(singular(polygon, wedges)).collect()
}

/// The product times the quotients of all corners, where these add anything; scaled to size one in the plane.
fn singular<const D: usize>(polygon: &Polygon, wedges: Vec<Wedge>) -> Option<Field<D>> {
    if wedges.iter().all(|wedge| wedge.is_whole() && !wedge.is_right()) {
        return None;
    }
    let owned = polygon.clone();
    let singular = move |x: &Series, y: &Series| {
        let feature = owned.product(x, y);
        let quotients = wedges.iter().map(|wedge| wedge.quotient(x, y));
        match quotients.collect::<Option<Vec<Series>>>() {
            Some(quotients) => quotients.iter().fold(feature, |product, q| product * q),
            // At a corner: the value is zero, derivatives do not exist.
            None => feature.squared().sqrt(),
        }
    };
    let most = polygon.largest(|x, y| singular(x, y).value().abs());
    Some(field(move |x: [Series; D]| singular(&x[0], &x[1]) / most))
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
        let polygon = pentagon();
        for (own, inside) in [(0, [0.1, 0.55]), (2, [-0.3, -0.4])] {
            let wedge = Wedge::new(&polygon, own);
            let [x, y] = Series::variables(inside, [2, 2]);
            let (square, angle, _) = wedge.polar(&x, &y).unwrap();
            let exponent = wedge.exponent;
            let function = square.powf(0.5 * exponent) * (angle * exponent).sin();
            let laplacian = function.derivative(&[2, 0]) + function.derivative(&[0, 2]);
            let size = function.derivative(&[2, 0]).abs();
            assert!(function.value() > 0.0);
            assert!(laplacian.abs() < 1e-12 * size, "{laplacian:e} of {size}");
            let heights: Vec<Series> = polygon.distances(&x, &y).collect();
            let count = heights.len();
            let heights = &heights[own] * &heights[(own + count - 1) % count];
            let again = wedge.quotient(&x, &y).unwrap() * heights;
            let ratio = |orders: &[usize]| again.derivative(orders) / function.derivative(orders);
            assert!((ratio(&[1, 1]) / ratio(&[0, 0]) - 1.0).abs() < 1e-11);
        }
    }

    #[test]
    fn at_right_angles_the_laplacian_is_constant() {
        let polygon = Polygon::new(&[[0.0, 0.0], [2.0, 0.5], [1.75, 1.5], [-0.25, 1.0]]).unwrap();
        let wedge = Wedge::new(&polygon, 1);
        assert!(wedge.is_right());
        for inside in [[1.7, 0.8], [1.8, 0.6], [1.4, 0.9], [0.3, 0.6]] {
            let [x, y] = Series::variables(inside, [2, 2]);
            let quotient = wedge.quotient(&x, &y).unwrap();
            let heights = polygon.distances(&x, &y).take(2);
            let function = heights.fold(quotient.clone(), |product, height| product * height);
            let laplacian = function.derivative(&[2, 0]) + function.derivative(&[0, 2]);
            // Half of that of r² (ln(r/R) sin 2δ + δ cos 2δ + ½π sin² δ), and downwards.
            assert!((laplacian + PI).abs() < 1e-11, "{laplacian} at {inside:?}");
            assert!(quotient.value() > 0.0);
        }
    }

    #[test]
    fn features_vanish_on_the_boundary_with_all_derivatives_along_it() {
        let polygon = pentagon();
        let [dx, dy] = [0, 1].map(crate::Derivative::<2>::along);
        let factors = planes(&polygon, &(dx * dx + dy * dy));
        assert_eq!(factors.len(), 2);
        assert_eq!(planes(&polygon, &(dx * dx + 2.0 * (dy * dy))).len(), 1);
        for (factor, edge) in factors.iter().flat_map(|factor| (0..5).map(move |e| (factor, e))) {
            let value = factor.at(Series::variables(polygon.on_edge(edge, 0.3), [2, 2]));
            assert!(value.value().abs() < 1e-15, "{} on {edge}", value.value());
            assert!(value.derivative(&[2, 0]).is_finite());
            let corner = factor.value(polygon.corners()[edge]);
            assert!(corner.abs() < 1e-15, "{corner} at {edge}");
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
