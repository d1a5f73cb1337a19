//! Solved θ that others are predicted from.

use crate::patient::parts::PatientStates;
use crate::polynomial::equations;
use nalgebra::{Cholesky, DMatrix, DVector};
use sinew_fem::Unload;
use sinew_num::monomials;

/// Highest degree of the polynomial through states.
const HIGHEST: usize = 4;
/// Least number of equations per coefficient.
const EQUATIONS_PER_COEFFICIENT: f64 = 1.5;
/// Ridge penalty per equation, against rounding errors only.
const RIDGE: f64 = 1e-13;
/// Largest sum of squares of the weights of a prediction: at most 1 at solved θ, and fast growing beyond their cloud.
const MOST_LEVERAGE: f64 = 4.0;

/// States at one θ with their slopes.
pub(super) struct Solved {
    pub theta: Vec<f64>,
    pub moved: Vec<Vec<f64>>,
    pub slopes: Vec<Vec<Vec<f64>>>,
}

impl Solved {
    pub(super) fn new(theta: &[f64], states: PatientStates) -> Self {
        Self { theta: theta.to_vec(), moved: states.moved, slopes: states.slopes }
    }

    /// Changes of the logarithms of θ; entries that are not positive change relative to those here.
    fn ways(&self, theta: &[f64]) -> Vec<f64> {
        let way = |(&to, &from): (&f64, &f64)| {
            if to > 0.0 { (to / from).ln() } else { to / from - 1.0 }
        };
        theta.iter().zip(&self.theta).map(way).collect()
    }

    /// Largest distance that the expansion to first order moves a node by \[length\].
    fn reach(&self, theta: &[f64]) -> f64 {
        let ways = self.scaled(&self.ways(theta));
        let moved = |state: &Vec<Vec<f64>>| {
            let count = state.first().map_or(0, Vec::len);
            let at = |dof: usize| state.iter().zip(&ways).map(|(s, way)| way * s[dof]).sum::<f64>();
            (0..count).map(|dof| at(dof).abs()).fold(0.0, f64::max)
        };
        self.slopes.iter().map(moved).fold(0.0, f64::max)
    }

    /// Weights of derivatives in θ, from those of derivatives in its logarithm.
    fn scaled(&self, weights: &[f64]) -> Vec<f64> {
        weights.iter().zip(&self.theta).map(|(weight, theta)| weight * theta).collect()
    }

    /// Adds the states times a weight, and their slopes times others.
    fn add_to(&self, states: &mut [Vec<f64>], weight: f64, of_slopes: &[f64]) {
        for (state, (moved, slopes)) in states.iter_mut().zip(self.moved.iter().zip(&self.slopes)) {
            let terms =
                std::iter::once((weight, moved)).chain(of_slopes.iter().copied().zip(slopes));
            for (weight, from) in terms {
                state.iter_mut().zip(from).for_each(|(u, v)| *u += weight * v);
            }
        }
    }
}

/// Solved θ, the centre first.
pub(super) struct Anchor<'p> {
    pub solved: Vec<Solved>,
    fit: Option<Fit>,
    /// Holds the factor at the centre.
    pub unload: Unload<'p>,
}

impl<'p> Anchor<'p> {
    pub(super) fn new(solved: Vec<Solved>, unload: Unload<'p>) -> Self {
        Self { fit: Fit::new(&solved), solved, unload }
    }

    /// Displacements from the image of all states at another θ: by a polynomial through the solved ones within their cloud, else to first
    /// order from the nearest.
    pub(super) fn predict(&self, theta: &[f64]) -> Vec<Vec<f64>> {
        let mut states: Vec<_> = self.solved[0].moved.iter().map(|u| vec![0.0; u.len()]).collect();
        match self.weights(theta) {
            Some((weights, lengths)) => {
                let of_each = weights.as_slice().chunks(1 + lengths.len());
                for (solved, weights) in self.solved.iter().zip(of_each) {
                    let of_slopes: Vec<f64> =
                        weights[1..].iter().zip(lengths).map(|(w, length)| w * length).collect();
                    solved.add_to(&mut states, weights[0], &solved.scaled(&of_slopes));
                }
            }
            None => {
                let nearest = self.nearest(theta).0;
                nearest.add_to(&mut states, 1.0, &nearest.scaled(&nearest.ways(theta)));
            }
        }
        states
    }

    /// Largest motion of a node by the first-order expansion from the nearest solved θ \[length\], 0 within the cloud.
    pub(super) fn reach(&self, theta: &[f64]) -> f64 {
        if self.weights(theta).is_some() { 0.0 } else { self.nearest(theta).1 }
    }

    /// Displacements of all states with their slopes at a θ that was solved.
    pub(super) fn at(&self, theta: &[f64]) -> Option<&Solved> {
        self.solved.iter().find(|solved| solved.theta == theta)
    }

    fn nearest(&self, theta: &[f64]) -> (&Solved, f64) {
        let all = self.solved.iter().map(|solved| (solved, solved.reach(theta)));
        let least = all.min_by(|a, b| a.1.total_cmp(&b.1));
        least.unwrap_or((&self.solved[0], f64::INFINITY))
    }

    /// Weights of the equations within the cloud of solved θ, and the lengths that scale derivatives.
    fn weights(&self, theta: &[f64]) -> Option<(DVector<f64>, &[f64])> {
        let fit = self.fit.as_ref()?;
        let x = over(&self.solved[0].ways(theta), &fit.lengths);
        let row = equations(&x, &[], &fit.exponents).remove(0);
        let weights = &fit.weights * DVector::from_vec(row);
        (weights.norm_squared() <= MOST_LEVERAGE).then_some((weights, &fit.lengths[..]))
    }
}

/// A polynomial by least squares, as the weights that it gives to the equations.
struct Fit {
    /// Root mean squares of the logarithms about the centre.
    lengths: Vec<f64>,
    exponents: Vec<Vec<i32>>,
    /// One row per equation, one column per monomial.
    weights: DMatrix<f64>,
}

impl Fit {
    /// `None` where there are too few solved θ for more than an expansion to first order.
    fn new(solved: &[Solved]) -> Option<Self> {
        let (centre, count) = (solved.first()?, solved.len() as f64);
        let parameters = centre.theta.len();
        let most = count * (1 + parameters) as f64 / EQUATIONS_PER_COEFFICIENT;
        let mut degrees = (2..=HIGHEST).rev().map(|degree| monomials(parameters, degree));
        let exponents = degrees.find(|exponents| exponents.len() as f64 <= most)?;
        let ways: Vec<_> = solved.iter().map(|other| centre.ways(&other.theta)).collect();
        let square = |at: usize| ways.iter().map(|way| way[at] * way[at]).sum::<f64>();
        let length = |at: usize| (square(at) / count).sqrt().max(1e-9);
        let lengths: Vec<f64> = (0..parameters).map(length).collect();
        let ones = vec![1.0; parameters];
        let rows = ways.iter().flat_map(|way| equations(&over(way, &lengths), &ones, &exponents));
        let rows: Vec<_> = rows.collect();
        let matrix = DMatrix::from_fn(rows.len(), exponents.len(), |i, j| rows[i][j]);
        let mut normal = matrix.tr_mul(&matrix);
        (0..normal.nrows()).for_each(|at| normal[(at, at)] += RIDGE * rows.len() as f64);
        let weights = Cholesky::new(normal)?.solve(&matrix.transpose()).transpose();
        Some(Self { lengths, exponents, weights })
    }
}

/// Quotients, entry by entry.
fn over(ways: &[f64], lengths: &[f64]) -> Vec<f64> {
    ways.iter().zip(lengths).map(|(way, length)| way / length).collect()
}
