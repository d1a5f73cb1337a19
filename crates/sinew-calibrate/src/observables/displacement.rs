//! Displacement of a point of the wall.

use super::{Quantity, States};
use crate::error::{PatientError, Result, length_of, require};
use sinew_energy::Body;
use sinew_num::{dot3, norm, sub3};

/// A point is in a cell if none of its corners' shares is below this: points on a facet must be found from either side.
const INSIDE: f64 = -1e-9;

/// Displacement of a point from one state to another along a unit vector.
pub(crate) struct PointDisplacement {
    states: [usize; 2],
    direction: [f64; 3],
    /// Corners of the cell around the point, with their shares.
    shares: Vec<(usize, f64)>,
}

impl PointDisplacement {
    /// # Errors
    /// A body of other cells than tetrahedra, a point outside of them, and a direction without length.
    pub(crate) fn new(
        image: &Body,
        point: [f64; 3],
        direction: [f64; 3],
        [from, to]: [usize; 2],
    ) -> Result<Self> {
        let length = length_of(direction)?;
        require(image.nodes_per_cell == 4, || {
            format!(
                "points are found in linear tetrahedra, not in {} cells; give the displacement of a body of those",
                image.element().name
            )
        })?;
        let shares = (0..image.cell_count()).find_map(|cell| shares(image, cell, point));
        let shares = shares.ok_or_else(|| outside(image, point))?;
        Ok(Self { states: [from, to], direction: direction.map(|x| x / length), shares })
    }

    fn along(&self, state: &[f64]) -> f64 {
        let at = |&(node, share): &(usize, f64)| {
            share * (0..3).map(|i| self.direction[i] * state[3 * node + i]).sum::<f64>()
        };
        self.shares.iter().map(at).sum()
    }
}

/// Shares of the corners of a cell that a point is in.
fn shares(image: &Body, cell: usize, point: [f64; 3]) -> Option<Vec<(usize, f64)>> {
    let nodes = image.nodes_of_cell(cell);
    let from_first = sub3(&point, &image.positions[nodes[0]]);
    let gradients = image.shape_of_point(cell * image.points_per_cell).iter();
    let mut shares: Vec<f64> = gradients.map(|gradient| dot3(gradient, &from_first)).collect();
    shares[0] += 1.0;
    let inside = shares.iter().all(|share| *share >= INSIDE);
    inside.then(|| nodes.iter().copied().zip(shares).collect())
}

fn outside(image: &Body, point: [f64; 3]) -> PatientError {
    let distance = |x: &[f64; 3]| norm(&sub3(x, &point));
    let distances = image.positions.iter().map(distance).zip(0..);
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    let ((distance, node), [x, y, z]) = (nearest.unwrap_or((f64::INFINITY, 0)), point);
    PatientError::Input(format!(
        "({x}, {y}, {z}) is in no cell of the image; the nearest node is {node}, {distance:.4} away: check units and frame of the coordinates"
    ))
}

impl Quantity for PointDisplacement {
    fn value(&self, states: &States) -> f64 {
        let [from, to] = self.states.map(|state| self.along(&states[state]));
        to - from
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        let gradient = |(state, sign): (usize, f64)| {
            let mut gradient = vec![0.0; states[state].len()];
            for &(node, share) in &self.shares {
                (0..3).for_each(|i| gradient[3 * node + i] += sign * share * self.direction[i]);
            }
            (state, gradient)
        };
        self.states.into_iter().zip([-1.0, 1.0]).map(gradient).collect()
    }
}
