//! A solved θ that others are predicted from.

use super::states::PatientStates;
use sinew_fem::Unload;

/// States at one θ with their slopes.
pub(super) struct Anchor<'p> {
    pub theta: Vec<f64>,
    moved: Vec<Vec<f64>>,
    slopes: Vec<Vec<Vec<f64>>>,
    /// Holds the factor at this θ.
    pub unload: Unload<'p>,
}

impl<'p> Anchor<'p> {
    pub(super) fn new(theta: &[f64], states: PatientStates, unload: Unload<'p>) -> Self {
        Self { theta: theta.to_vec(), moved: states.moved, slopes: states.slopes, unload }
    }

    /// Displacements from the image of all states at another θ to first order, in logarithms of positive entries.
    pub(super) fn predict(&self, theta: &[f64]) -> Vec<Vec<f64>> {
        let ways = self.ways(theta);
        let state = |(moved, slopes): (&Vec<f64>, &Vec<Vec<f64>>)| {
            let mut there = moved.clone();
            for (slope, way) in slopes.iter().zip(&ways) {
                there.iter_mut().zip(slope).for_each(|(u, s)| *u += way * s);
            }
            there
        };
        self.moved.iter().zip(&self.slopes).map(state).collect()
    }

    fn ways(&self, theta: &[f64]) -> Vec<f64> {
        let way = |(&to, &from): (&f64, &f64)| {
            if to > 0.0 && from > 0.0 { from * (to / from).ln() } else { to - from }
        };
        theta.iter().zip(&self.theta).map(way).collect()
    }

    /// Largest distance that this moves a node by from a state here: how far a prediction reaches \[length\].
    pub(super) fn reach(&self, theta: &[f64]) -> f64 {
        let ways = self.ways(theta);
        let moved = |state: &Vec<Vec<f64>>| {
            let count = state.first().map_or(0, Vec::len);
            let at = |dof: usize| state.iter().zip(&ways).map(|(s, way)| way * s[dof]).sum::<f64>();
            (0..count).map(|dof| at(dof).abs()).fold(0.0, f64::max)
        };
        self.slopes.iter().map(moved).fold(0.0, f64::max)
    }
}
