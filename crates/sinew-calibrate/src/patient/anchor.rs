//! A solved θ that others are predicted from.

use super::states::PatientStates;

/// States at one θ with their slopes.
pub(super) struct Anchor {
    theta: Vec<f64>,
    moved: Vec<Vec<f64>>,
    slopes: Vec<Vec<Vec<f64>>>,
}

impl Anchor {
    pub(super) fn new(theta: &[f64], states: PatientStates) -> Self {
        Self { theta: theta.to_vec(), moved: states.moved, slopes: states.slopes }
    }

    /// Displacements from the image of all states at another θ to first order, in logarithms of positive entries.
    pub(super) fn predict(&self, theta: &[f64]) -> Vec<Vec<f64>> {
        let way = |(&to, &from): (&f64, &f64)| {
            if to > 0.0 && from > 0.0 { from * (to / from).ln() } else { to - from }
        };
        let ways: Vec<f64> = theta.iter().zip(&self.theta).map(way).collect();
        let state = |(moved, slopes): (&Vec<f64>, &Vec<Vec<f64>>)| {
            let mut there = moved.clone();
            for (slope, way) in slopes.iter().zip(&ways) {
                there.iter_mut().zip(slope).for_each(|(u, s)| *u += way * s);
            }
            there
        };
        self.moved.iter().zip(&self.slopes).map(state).collect()
    }
}
