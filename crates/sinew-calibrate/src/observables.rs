//! Observables as functions of the places of the nodes.

use crate::error::{PatientError, Result, length_of, require};
use sinew_energy::{Body, Cavity};
use sinew_num::{dot3, norm, sub3};

/// Displacements from the image of all states, each `3 × nodes` \[length\].
pub(crate) type States = [Vec<f64>];

/// An observable whose nodes, cells and states are known.
pub(crate) trait Quantity: Send + Sync {
    /// The value; NaN where a state is degenerate.
    fn value(&self, states: &States) -> f64;

    /// Derivatives in the places of the nodes, for each state that the value depends on.
    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)>;
}

/// Volume of a cavity in a state.
pub(crate) struct CavityVolume {
    pub cavity: Cavity,
    pub state: usize,
    /// Places of the nodes in the image.
    pub image: Vec<[f64; 3]>,
}

impl Quantity for CavityVolume {
    fn value(&self, states: &States) -> f64 {
        self.cavity.volume(&self.image, &states[self.state])
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        vec![(self.state, self.cavity.volume_gradient(&self.image, &states[self.state]))]
    }
}

/// Strain ½(|F e|² − 1) from one state to another, averaged over quadrature points by their volume in the image.
///
/// With A = ∂x/∂x₀, x₀ the image, a line of tissue that is e₀ there has the length |A e₀| in a state, so
/// that |F e|² is the ratio of its squares in both states.
pub(crate) struct SegmentStrain {
    states: [usize; 2],
    points: Vec<Line>,
}

/// A line of tissue at a quadrature point.
struct Line {
    /// Share of the segment's volume.
    weight: f64,
    /// Direction in the image.
    direction: [f64; 3],
    /// Nodes of the cell with the slopes of their shape functions along the direction [1/length].
    slopes: Vec<(usize, f64)>,
}

impl Line {
    /// The line in a state, of length 1 in the image.
    fn moved(&self, state: &[f64]) -> [f64; 3] {
        self.slopes.iter().fold(self.direction, |sum, &(node, slope)| {
            std::array::from_fn(|i| sum[i] + slope * state[3 * node + i])
        })
    }
}

impl SegmentStrain {
    /// Strain of a segment from quadrature points of the image with a unit direction at each.
    pub(crate) fn new(image: &Body, points: &[(usize, [f64; 3])], [from, to]: [usize; 2]) -> Self {
        let whole: f64 = points.iter().map(|&(point, _)| image.volumes[point]).sum();
        let line = |&(point, direction): &(usize, [f64; 3])| {
            let slopes = image.shape_of_point(point).iter().map(|g| dot3(g, &direction));
            let nodes = image.nodes_of_point(point).iter().copied();
            let weight = image.volumes[point] / whole;
            Line { weight, direction, slopes: nodes.zip(slopes).collect() }
        };
        Self { states: [from, to], points: points.iter().map(line).collect() }
    }
}

impl Quantity for SegmentStrain {
    fn value(&self, states: &States) -> f64 {
        let [from, to] = self.states.map(|state| &states[state]);
        let strain = |line: &Line| {
            let [above, below] = [to, from].map(|state| line.moved(state));
            let ratio = dot3(&above, &above) / dot3(&below, &below);
            0.5 * line.weight * (ratio - 1.0)
        };
        self.points.iter().map(strain).sum()
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        let [from, to] = self.states.map(|state| &states[state]);
        let mut gradients = [vec![0.0; from.len()], vec![0.0; to.len()]];
        for line in &self.points {
            let (before, after) = (line.moved(from), line.moved(to));
            let (below, above) = (dot3(&before, &before), dot3(&after, &after));
            for &(node, slope) in &line.slopes {
                for i in 0..3 {
                    let weight = line.weight * slope / below;
                    gradients[0][3 * node + i] -= weight * above / below * before[i];
                    gradients[1][3 * node + i] += weight * after[i];
                }
            }
        }
        self.states.into_iter().zip(gradients).collect()
    }
}

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
