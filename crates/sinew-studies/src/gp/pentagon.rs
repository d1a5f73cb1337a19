//! A reference for Poisson's equation on the regular pentagon, with a bound of its error.
//!
//! u = h − |x|² with a harmonic h that equals |x|² on the boundary, from two families with the
//! pentagon's symmetry: Re z^{5n} about the centre, and the singular functions
//! r^{5k/3} sin(5kφ/3) about the corners, whose angle is 3π/5 (method of particular solutions,
//! Fox, Henrici & Moler 1967). What it misses on the boundary bounds the error everywhere, by the
//! maximum principle.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Functions of each family.
const CENTRED: usize = 8;
const PER_CORNER: usize = 16;
/// Points on half an edge, the rest of the boundary following by symmetry; denser at the corner.
const BOUNDARY_POINTS: usize = 120;
/// Inner angle of the pentagon.
const ANGLE: f64 = 3.0 * PI / 5.0;

/// −Δu = 4 on the pentagon with corners on the unit circle, one at the top; u = 0 on its boundary.
pub(crate) struct Pentagon {
    coefficients: DVector<f64>,
    /// Largest |u| on the boundary, and so the largest error anywhere.
    pub bound: f64,
}

/// The corners, counterclockwise from the top one.
pub(crate) fn corners() -> [[f64; 2]; 5] {
    std::array::from_fn(|k| {
        let angle = PI / 2.0 + 2.0 * PI * k as f64 / 5.0;
        [angle.cos(), angle.sin()]
    })
}

/// All harmonic functions at a point.
fn harmonics([x, y]: [f64; 2]) -> Vec<f64> {
    // Turned by a right angle, so that a corner lies on the axis from which angles are measured.
    let (radius, angle) = (x.hypot(y), (-x).atan2(y));
    let mut values: Vec<f64> =
        (0..CENTRED).map(|n| radius.powi(5 * n as i32) * (5.0 * n as f64 * angle).cos()).collect();
    for k in 1..=PER_CORNER {
        // Functions of even k are odd about the corner's axis, which the solution is not.
        let power = (2 * k - 1) as f64 * PI / ANGLE;
        let sum: f64 = corners()
            .iter()
            .map(|[cx, cy]| {
                let (dx, dy) = (x - cx, y - cy);
                // Angle from the corner's axis, which points to the centre.
                let (along, across) = (-(dx * cx + dy * cy), dx * cy - dy * cx);
                let phi = across.atan2(along);
                dx.hypot(dy).powf(power) * (power * phi).cos()
            })
            .sum();
        // To size one, so that no column drowns in the others.
        values.push(sum / 5.0 / (1.9_f64).powf(power));
    }
    values
}

impl Pentagon {
    /// Coefficients by least squares on the boundary.
    pub(crate) fn solve() -> Self {
        let [a, b, ..] = corners();
        let point = |number: usize, of: usize| {
            // Squares of equal steps: dense at the corner a, up to the middle of the edge.
            let share = 0.5 * ((number as f64 + 0.5) / of as f64).powi(2);
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        };
        let points: Vec<[f64; 2]> =
            (0..BOUNDARY_POINTS).map(|k| point(k, BOUNDARY_POINTS)).collect();
        let rows: Vec<Vec<f64>> = points.iter().map(|p| harmonics(*p)).collect();
        let matrix = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        let data = DVector::from_iterator(points.len(), points.iter().map(|[x, y]| x * x + y * y));
        // Directions below this share of the largest are rounding.
        const RANK_TOLERANCE: f64 = 1e-13;
        let svd = matrix.svd(true, true);
        let cut = RANK_TOLERANCE * svd.singular_values.max();
        let coefficients = svd.solve(&data, cut).expect("both factors were asked for");
        let mut solution = Self { coefficients, bound: 0.0 };
        let between = 7 * BOUNDARY_POINTS;
        solution.bound =
            (0..between).map(|k| solution.value(point(k, between)).abs()).fold(0.0, f64::max);
        solution
    }

    pub(crate) fn value(&self, [x, y]: [f64; 2]) -> f64 {
        let harmonic: f64 =
            harmonics([x, y]).iter().zip(self.coefficients.iter()).map(|(h, c)| h * c).sum();
        harmonic - x * x - y * y
    }
}
