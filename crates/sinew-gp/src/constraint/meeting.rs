//! A corner between two edges: what their conditions say of value and gradient there.

use super::agreement::{agree, diagonal, magnitude};
use super::imposed::{Imposed, along};
use crate::domain::Domain;
use crate::error::Result;
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
    /// Order of the derivative of the data that is asked for, and its direction.
    derivative: (usize, [f64; 2]),
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
    /// Corner from what the conditions impose, each with the tangent of its edge.
    pub(super) fn new(
        place: [f64; 2],
        size: f64,
        all: impl Iterator<Item = (Imposed<D>, [f64; 2])>,
    ) -> Self {
        // Factors do not depend on further coordinates.
        let at: [f64; D] = std::array::from_fn(|d| if d < 2 { place[d] } else { 0.0 });
        let mut rows = Vec::new();
        for (Imposed { value, order, direction, data }, [tx, ty]) in all {
            let mut add = |coefficients: [f64; 3], scale: f64, derivative| {
                let length = coefficients.iter().map(|c| c * c).sum::<f64>().sqrt();
                let (coefficients, factor) = (coefficients.map(|c| c / length), scale / length);
                rows.push(Row { coefficients, factor, data: data.clone(), derivative });
            };
            if order == 0 {
                add([1.0, 0.0, 0.0], 1.0, (0, [tx, ty]));
                add([0.0, tx, ty], size, (1, [tx, ty]));
            } else {
                let [nx, ny] = [direction[0] / size, direction[1] / size];
                add([value.value(at), nx, ny], 1.0, (0, [tx, ty]));
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
            let (order, direction) = &row.derivative;
            along(&row.data, direction, *order, &at) * row.factor
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

    pub(super) fn check(&self, domain: &Domain<D>) -> Result<()> {
        let size: f64 = self.rows.iter().map(|r| r.factor * magnitude(&r.data, domain)).sum();
        for x in diagonal(domain).map(Series::plain) {
            let jet = self.jet(&x).map(|number| number.value());
            let solution = [jet[0], jet[1] * self.size, jet[2] * self.size];
            for (row, asked) in self.rows.iter().zip(self.data(&x)) {
                let implied: f64 = row.coefficients.iter().zip(solution).map(|(c, s)| c * s).sum();
                let [x, y] = self.place;
                let [first, second] = domain.names().first_chunk().expect("two axes");
                let values = [implied, asked.value()].map(|value| value / row.factor);
                let corner = || format!("{first} = {x}, {second} = {y}");
                agree(corner, values, size / row.factor)?;
            }
        }
        Ok(())
    }
}
