//! Local axes of nodes with supports that are not along the coordinate axes.

use sinew_num::{Mat3, dot3};
use std::collections::BTreeMap;

/// Component of a unit vector that is a rounding error in the axes of a frame.
const ROUNDING: f64 = 1e-12;

/// Orthonormal frames of the nodes whose supports are not along the coordinate axes, one axis per row.
///
/// Displacements and forces are Cartesian everywhere; only the entries of
/// [`crate::BodyArrays::prescribed`] that belong to such a node are along the axes of its frame. A body
/// without such supports has none, which costs nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frames {
    of_node: BTreeMap<usize, Mat3<f64>>,
}

impl Frames {
    /// Whether all nodes have the coordinate axes.
    pub fn is_empty(&self) -> bool {
        self.of_node.is_empty()
    }

    /// The frame of a node, if it has one of its own.
    #[inline]
    pub fn get(&self, node: usize) -> Option<&Mat3<f64>> {
        self.of_node.get(&node)
    }

    /// The nodes with a frame of their own, ascending.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.of_node.keys().copied()
    }

    /// The axis that a degree of freedom `3 × node + component` is along.
    pub fn axis(&self, degree_of_freedom: usize) -> [f64; 3] {
        let component = degree_of_freedom % 3;
        let own = self.get(degree_of_freedom / 3).map(|frame| frame[component]);
        own.unwrap_or(Mat3::IDENTITY[component])
    }

    /// A degree of freedom of a Cartesian vector over all nodes.
    #[inline]
    pub fn component(&self, degree_of_freedom: usize, vector: &[f64]) -> f64 {
        let node = degree_of_freedom / 3;
        match self.get(node) {
            None => vector[degree_of_freedom],
            Some(frame) => {
                let axis = &frame[degree_of_freedom % 3];
                (0..3).map(|i| axis[i] * vector[3 * node + i]).sum()
            }
        }
    }

    /// Adds to a degree of freedom of a Cartesian vector over all nodes.
    #[inline]
    pub fn add(&self, degree_of_freedom: usize, value: f64, vector: &mut [f64]) {
        let node = degree_of_freedom / 3;
        match self.get(node) {
            None => vector[degree_of_freedom] += value,
            Some(frame) => {
                let axis = &frame[degree_of_freedom % 3];
                (0..3).for_each(|i| vector[3 * node + i] += value * axis[i]);
            }
        }
    }

    /// Sets the frame of a node: three orthonormal axes, one per row, unchecked. The coordinate axes are not stored.
    pub fn insert(&mut self, node: usize, axes: Mat3<f64>) {
        if axes == Mat3::IDENTITY {
            self.of_node.remove(&node);
        } else {
            self.of_node.insert(node, axes);
        }
    }
}

/// Prescribed degrees of freedom, and the frames of nodes that they are along.
pub(crate) struct Held {
    pub prescribed: Vec<Option<f64>>,
    pub frames: Frames,
}

impl Held {
    /// Displacement of a node along a direction \[length\], if the prescribed degrees of freedom determine it.
    pub(crate) fn along(&self, node: usize, direction: &[f64; 3]) -> Option<f64> {
        let of = |dof: usize| {
            let share = dot3(&self.frames.axis(dof), direction);
            let none = || (share.abs() <= ROUNDING).then_some(0.0);
            self.prescribed[dof].map_or_else(none, |u| Some(share * u))
        };
        (3 * node..3 * node + 3).map(of).sum()
    }
}
