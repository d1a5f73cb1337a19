//! Strain of a segment.

use super::{Quantity, States};
use sinew_energy::Body;
use sinew_num::dot3;

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
