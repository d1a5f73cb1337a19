//! A smooth function that comes near the values on a polygon's edges, so that little is left to be blended.
//!
//! Blends of functions given edge by edge have second derivatives that jump at every corner, and vary on the scale of the
//! edges: with collocation at a hundred points that left errors of a tenth. Harmonic polynomials and the singular harmonic
//! functions of the corners come near any data on the boundary (Fox, Henrici & Moler 1967, *Approximations and bounds for
//! eigenvalues of elliptic operators*); fitted to the values by least squares they leave a remainder that is blended. The
//! values hold exactly whatever the fit is worth.

use super::wedges::{Held, Wedge};
use crate::edge::Edge;
use crate::field::{Field, field};
use crate::polygon::Polygon;
use crate::series::Series;
use nalgebra::{DMatrix, DVector};

/// Highest degree of a harmonic polynomial.
const DEGREE: usize = 12;
/// Places on each edge, denser at its ends.
const PLACES: usize = 40;
/// Singular values, in units of the largest, below which directions are left out.
const RANK: f64 = 1e-10;

/// Harmonic polynomials, Re and Im of ((x + iy − c)/R)ⁿ, and the singular functions of the corners.
#[derive(Clone, Debug)]
struct Basis {
    centre: [f64; 2],
    size: f64,
    singular: Vec<(Wedge, (usize, f64))>,
}

impl Basis {
    fn new(polygon: &Polygon) -> Self {
        let [[left, right], [bottom, top]] = polygon.extents();
        let singular = (0..polygon.edges().len()).flat_map(|own| {
            let wedge = Wedge::new(polygon, own);
            wedge.exponents(false).into_iter().map(move |order| (wedge.clone(), order))
        });
        Self {
            centre: [0.5 * (left + right), 0.5 * (bottom + top)],
            size: 0.5 * (right - left).hypot(top - bottom),
            singular: singular.collect(),
        }
    }

    /// All functions at a point; singular ones vanish at their corner.
    fn functions(&self, x: &Series, y: &Series) -> Vec<Series> {
        let (a, b) = ((x - self.centre[0]) / self.size, (y - self.centre[1]) / self.size);
        let mut all = vec![x.constant(1.0)];
        let mut power = (x.constant(1.0), x.constant(0.0));
        for _ in 0..DEGREE {
            let (re, im) = power;
            power = (&re * &a - &im * &b, &re * &b + &im * &a);
            all.extend([power.0.clone(), power.1.clone()]);
        }
        all.extend(self.singular.iter().map(|(wedge, order)| {
            let around = wedge.around(*order, [Held::Value; 2], x, y);
            around.unwrap_or_else(|| x.constant(0.0))
        }));
        all
    }
}

/// Harmonic, and near the values given edge by edge; none where these are zero, or may vary with further coordinates.
pub(super) fn extension<const D: usize>(polygon: &Polygon, given: &[Field<D>]) -> Option<Field<D>> {
    if D > 2 || given.iter().all(Field::is_zero) {
        return None;
    }
    let basis = Basis::new(polygon);
    let (mut entries, mut right) = (Vec::new(), Vec::new());
    for (edge, value) in given.iter().enumerate() {
        for k in 0..PLACES {
            let fraction =
                0.5 - 0.5 * ((k as f64 + 0.5) / PLACES as f64 * std::f64::consts::PI).cos();
            let mut at = [0.0; D];
            (at[0], at[1]) = polygon.on_edge(edge, fraction).into();
            let functions = basis.functions(&Series::number(at[0]), &Series::number(at[1]));
            entries.extend(functions.iter().map(Series::value));
            right.push(value.value(at));
        }
    }
    if entries.iter().chain(&right).any(|entry| !entry.is_finite()) {
        return None;
    }
    let matrix = DMatrix::from_row_slice(right.len(), entries.len() / right.len(), &entries);
    let svd = matrix.svd(true, true);
    let cut = RANK * svd.singular_values.max();
    let coefficients = svd.solve(&DVector::from_vec(right), cut).ok()?;
    Some(field(move |x: [Series; D]| {
        let terms = basis.functions(&x[0], &x[1]).into_iter().zip(coefficients.iter());
        terms.fold(x[0].constant(0.0), |sum, (function, c)| sum + function * *c)
    }))
}

/// Coefficients of Hestenes' extension f(−s) = Σ c f(s/k), k = 1 … 3, twice differentiable at 0 (Hestenes 1941).
const HESTENES: [f64; 3] = [6.0, -32.0, 27.0];

/// A function of the position along an edge alone, that of `function` on it. Beyond its ends it is continued by what it is on
/// the edge, and fades within a length of it.
pub(super) fn along_edge<const D: usize>(edge: &Edge, function: Field<D>) -> Field<D> {
    let edge = edge.clone();
    field(move |x: [Series; D]| {
        let s = edge.fraction(&x[0], &x[1]);
        let on = |s: Series| -> Series {
            let mut at = x.clone();
            for d in 0..2 {
                at[d] = &s * (edge.length * edge.tangent[d]) + edge.start[d];
            }
            function.at(at)
        };
        let beyond = |past: Series, inwards: &dyn Fn(Series) -> Series| {
            if past.value() >= 1.0 {
                return x[0].constant(0.0);
            }
            let fading = (past.constant(1.0) - past.powi(4)).powi(4);
            let terms = HESTENES.iter().enumerate();
            let sum = terms.fold(x[0].constant(0.0), |sum, (k, c)| {
                sum + on(inwards(&past / (k as f64 + 1.0))) * *c
            });
            sum * fading
        };
        match s.value() {
            value if value < 0.0 => beyond(-s, &|s| s),
            value if value > 1.0 => beyond(s - 1.0, &|s| s * -1.0 + 1.0),
            _ => on(s),
        }
    })
}
