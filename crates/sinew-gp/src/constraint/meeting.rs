//! A corner between two edges: what their conditions say of value and gradient there.

use super::agreement::{conflict, differ, magnitude};
use super::lift::{EdgeLift, along};
use crate::domain::Domain;
use crate::error::GpError;
use crate::field::Field;
use crate::series::Series;
use nalgebra::DMatrix;

/// Value and gradient at a corner.
pub(super) type Jet = [Series; 3];

/// One row of a corner's equations a · (u, size ∇u) = right-hand side, of unit length.
#[derive(Clone, Debug)]
struct Row<const D: usize> {
    coefficients: [f64; 3],
    factor: f64,
    data: Field<D>,
    /// `None` for the data itself, else its derivative along this direction.
    derivative: Option<[f64; 2]>,
}

/// A corner between two edges with conditions.
#[derive(Clone, Debug)]
pub(super) struct Corner<const D: usize> {
    place: [f64; 2],
    rows: Vec<Row<D>>,
    /// Pseudo-inverse of the equations: 3 × rows.
    inverse: DMatrix<f64>,
    /// Null space of the equations in (u, size ∇u).
    pub free: Vec<[f64; 3]>,
    pub size: f64,
}

/// Singular values below it count as zero.
const RANK_TOLERANCE: f64 = 1e-8;

impl<const D: usize> Corner<D> {
    pub(super) fn new(
        place: [f64; 2],
        size: f64,
        lifts: impl Iterator<Item = EdgeLift<D>>,
    ) -> Self {
        // Factors do not depend on further coordinates.
        let at: [f64; D] = std::array::from_fn(|d| if d < 2 { place[d] } else { 0.0 });
        let mut rows = Vec::new();
        for lift in lifts {
            let [nx, ny] = lift.outwards().map(|n| n * lift.slope / size);
            let value = lift.value.value(at);
            let mut add = |coefficients: [f64; 3], scale: f64, derivative| {
                let length = coefficients.iter().map(|c| c * c).sum::<f64>().sqrt();
                rows.push(Row {
                    coefficients: coefficients.map(|c| c / length),
                    factor: scale / length,
                    data: lift.data.clone(),
                    derivative,
                });
            };
            add([value, nx, ny], 1.0, None);
            if lift.slope == 0.0 {
                let tangent = lift.edge.tangent;
                add([0.0, value * tangent[0], value * tangent[1]], size, Some(tangent));
            }
        }
        // Zero rows make it at least square, so that all right singular vectors are there.
        let matrix = DMatrix::from_fn(rows.len().max(3), 3, |i, j| {
            rows.get(i).map_or(0.0, |row: &Row<D>| row.coefficients[j])
        });
        let svd = matrix.svd(true, true);
        let none = |mode: &usize| svd.singular_values[*mode] <= RANK_TOLERANCE;
        let right = svd.v_t.as_ref().expect("both factors were asked for");
        let free =
            (0..3).filter(none).map(|mode| std::array::from_fn(|i| right[(mode, i)])).collect();
        let inverse = svd.pseudo_inverse(RANK_TOLERANCE).expect("the tolerance is positive");
        Self { place, rows, inverse, free, size }
    }

    /// The rows' right-hand sides, with the other coordinates from `x`.
    fn data(&self, x: &[Series; D]) -> Vec<Series> {
        let mut at = x.clone();
        at[0] = x[0].constant(self.place[0]);
        at[1] = x[1].constant(self.place[1]);
        let data = |row: &Row<D>| {
            let data = match row.derivative {
                None => row.data.at(at.clone()),
                Some(direction) => along(&row.data, direction, &at),
            };
            data * row.factor
        };
        self.rows.iter().map(data).collect()
    }

    /// The least jet that the conditions imply.
    pub(super) fn jet(&self, x: &[Series; D]) -> Jet {
        let data = self.data(x);
        std::array::from_fn(|i| {
            let scale = if i == 0 { 1.0 } else { 1.0 / self.size };
            data.iter().enumerate().fold(x[0].constant(0.0), |sum, (j, value)| {
                sum + value * (scale * self.inverse[(i, j)])
            })
        })
    }

    pub(super) fn check(&self, domain: &Domain<D>) -> Result<(), GpError> {
        let size: f64 = self.rows.iter().map(|r| r.factor * magnitude(&r.data, domain)).sum();
        for fraction in [0.5, 0.11, 0.83, 0.0, 1.0] {
            let x = Series::plain(std::array::from_fn(|d| {
                domain.lower()[d] + fraction * domain.extents()[d]
            }));
            let asked: Vec<f64> = self.data(&x).iter().map(Series::value).collect();
            let jet = self.jet(&x).map(|number| number.value());
            let solution = [jet[0], jet[1] * self.size, jet[2] * self.size];
            for (row, asked) in self.rows.iter().zip(&asked) {
                let implied: f64 = row.coefficients.iter().zip(solution).map(|(c, s)| c * s).sum();
                if differ(implied, *asked, size) {
                    let [x, y] = self.place;
                    let [first, second] = domain.names().first_chunk().expect("two axes");
                    let corner = format!("{first} = {x}, {second} = {y}");
                    return Err(conflict(&corner, implied / row.factor, asked / row.factor));
                }
            }
        }
        Ok(())
    }
}
