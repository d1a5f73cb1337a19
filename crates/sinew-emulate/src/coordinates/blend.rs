//! Motions that go through several solved states.

use crate::coordinates::{Anchor, Anchors, Motions, Result, all_terms, require_count, terms};
use nalgebra::DMatrix;

/// Deviations of the parameters over which the remainder at an anchor is differentiated: half of the digits of a second difference are left.
const STEP: f64 = 1e-3;

impl Motions {
    /// Displacements that go through all of these states with their first and second derivatives: [`Anchors`] interpolate the remainder of the
    /// Taylor expansion and are added after the motions. Rotations that the expansion extrapolates do not turn it.
    ///
    /// # Errors
    /// Another body than the motions', states at the same parameters.
    pub fn through(mut self, states: &[Anchor]) -> Result<Self> {
        let nodes = self.origin().len() / 3;
        let count = states.first().map_or(0, |state| state.at.len());
        let mut curvature = DMatrix::zeros(count, count);
        let mut fields = Vec::with_capacity(states.len());
        for state in states {
            require_count("parameters of an anchor", state.at.len(), count)?;
            require_count("changes at an anchor", state.changes.len(), 1 + all_terms(count))?;
            for change in &state.changes {
                require_count("entries of a change", change.len(), 3 * nodes)?;
            }
            curvature += curvature_of(&state.changes[1 + count..], count);
            fields.push(self.remainder(state)?);
        }
        let at: Vec<_> = states.iter().map(|state| state.at.clone()).collect();
        self.anchors = Some(Anchors::through(&at, &fields, &curvature)?.into());
        Ok(self)
    }

    /// Remainder of the displacement at a state, and its first and second derivatives \[length\].
    fn remainder(&self, state: &Anchor) -> Result<Vec<Vec<f64>>> {
        let count = state.at.len();
        let missing = |axes: &[usize], sign: f64| -> Result<Vec<f64>> {
            let mut away = vec![0.0; count];
            axes.iter().for_each(|&p| away[p] = sign * STEP);
            let mut target = state.changes[0].clone();
            for (change, term) in state.changes[1..].iter().zip(terms(&away)) {
                target.iter_mut().zip(change).for_each(|(u, change)| *u += term * change);
            }
            let at: Vec<f64> = state.at.iter().zip(&away).map(|(x, away)| x + away).collect();
            let expanded = self.expanded(&at)?;
            Ok(target.iter().zip(expanded).map(|(u, expanded)| u - expanded).collect())
        };
        let both = |axes: &[usize]| Ok([missing(axes, 1.0)?, missing(axes, -1.0)?]);
        let here = missing(&[], 0.0)?;
        let alone: Vec<[Vec<f64>; 2]> = (0..count).map(|p| both(&[p])).collect::<Result<_>>()?;
        let combined = |parts: &[(f64, &Vec<f64>)]| -> Vec<f64> {
            let sum = |i: usize| parts.iter().map(|(part, field)| part * field[i]).sum();
            (0..here.len()).map(sum).collect()
        };
        let mut all = vec![here.clone()];
        let half = 0.5 / STEP;
        all.extend(alone.iter().map(|[plus, minus]| combined(&[(half, plus), (-half, minus)])));
        let square = STEP.powi(-2);
        for p in 0..count {
            let [plus, minus] = &alone[p];
            all.push(combined(&[(square, plus), (square, minus), (-2.0 * square, &here)]));
            for q in p + 1..count {
                let ([a, b], [c, d]) = (both(&[p, q])?, &alone[q]);
                let half = 0.5 * square;
                let sums = [(half, &a), (half, &b), (2.0 * half, &here)];
                let less = [plus, minus, c, d].map(|field| (-half, field));
                all.push(combined(&[&sums[..], &less[..]].concat()));
            }
        }
        Ok(all)
    }
}

/// Gram matrix of second derivatives, from the coefficients of a Taylor polynomial.
fn curvature_of(products: &[Vec<f64>], count: usize) -> DMatrix<f64> {
    let second = |p: usize, q: usize| {
        let (low, high) = (p.min(q), p.max(q));
        let twice = if p == q { 2.0 } else { 1.0 };
        (twice, &products[low * count - low * (low + 1) / 2 + high])
    };
    DMatrix::from_fn(count, count, |p, q| {
        let product = |r: usize| {
            let ((a, by_p), (b, by_q)) = (second(p, r), second(q, r));
            a * b * by_p.iter().zip(by_q).map(|(x, y)| x * y).sum::<f64>()
        };
        (0..count).map(product).sum()
    })
}
