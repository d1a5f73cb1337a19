//! Outputs that go through several solved states.

use crate::anchors::Anchors;
use crate::dirichlet::Dirichlet;
use crate::error::{Result, require_count};
use crate::motions::{Anchor, Motions};
use crate::polynomial::{all_terms, terms};
use crate::split::pseudo_inverse;
use nalgebra::{DMatrix, SMatrix, SVector};
use sinew_energy::Body;

/// Deviations of the parameters over which outputs at an anchor are differentiated: half of the digits of a second difference are left.
const STEP: f64 = 1e-3;

impl Motions {
    /// Outputs that go through all of these states with their first and second derivatives: what the outputs leave of them is interpolated by
    /// [`Anchors`], as displacements of nodes within their clusters, so that it turns with these.
    ///
    /// # Errors
    /// Another body than the motions', states that do not belong to it, states at the same parameters.
    pub fn through(self, states: &[Anchor], body: &Body) -> Result<Self> {
        let dirichlet = Dirichlet::of_body(body);
        let table = dirichlet.projectors(3);
        let free: Vec<_> =
            table.chunks_exact(9).map(SMatrix::<f64, 3, 3>::from_row_slice).collect();
        let count = states.first().map_or(0, |state| state.at.len());
        let mut curvature = DMatrix::zeros(count, count);
        let mut fields = Vec::with_capacity(states.len());
        for state in states {
            require_count("parameters of an anchor", state.at.len(), count)?;
            require_count("changes at an anchor", state.changes.len(), 1 + all_terms(count))?;
            for change in &state.changes {
                require_count("entries of a change", change.len(), 3 * body.nodes)?;
            }
            curvature += curvature_of(&state.changes[1 + count..], count);
            fields.push(self.remainder(state, &free)?);
        }
        let at: Vec<_> = states.iter().map(|state| state.at.clone()).collect();
        let (anchors, fields) = Anchors::through(&at, &fields, &curvature)?;
        let clusters = vec![0.0; 6 * self.tree().centres.len()];
        let slopes = fields.into_iter().map(|field| [&clusters[..], &field[..]].concat());
        Ok(self.with_terms(anchors, slopes.collect()))
    }

    /// Outputs of nodes that are missing at a state, and their first and second derivatives.
    fn remainder(&self, state: &Anchor, free: &[SMatrix<f64, 3, 3>]) -> Result<Vec<Vec<f64>>> {
        let count = state.at.len();
        let missing = |axes: &[usize], sign: f64| -> Result<Vec<f64>> {
            let mut away = vec![0.0; count];
            axes.iter().for_each(|&p| away[p] = sign * STEP);
            let mut target = state.changes[0].clone();
            for (change, term) in state.changes[1..].iter().zip(terms(&away)) {
                target.iter_mut().zip(change).for_each(|(u, change)| *u += term * change);
            }
            let at: Vec<f64> = state.at.iter().zip(&away).map(|(x, away)| x + away).collect();
            self.missing(&at, &target, free)
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

    /// Outputs of nodes that bring what outputs follow at standardised parameters to a displacement, clusters being where they are.
    fn missing(
        &self,
        parameters: &[f64],
        target: &[f64],
        free: &[SMatrix<f64, 3, 3>],
    ) -> Result<Vec<f64>> {
        let (tree, outputs) = (self.tree(), self.outputs_at(parameters)?);
        let (clusters, nodes) = outputs.split_at(6 * tree.centres.len());
        // A node's displacement is linear in its outputs: four of them tell how.
        let base = tree.moved(clusters, nodes);
        let columns: [Vec<f64>; 3] = std::array::from_fn(|k| {
            let unit = nodes.iter().enumerate().map(|(i, y)| y + f64::from(i % 3 == k));
            tree.moved(clusters, &unit.collect::<Vec<_>>())
        });
        let of_node = |node: usize| {
            let map =
                SMatrix::<f64, 3, 3>::from_fn(|i, k| columns[k][3 * node + i] - base[3 * node + i]);
            let lacks = SVector::<f64, 3>::from_fn(|i, _| {
                target[3 * node + i] - self.origin()[3 * node + i] - base[3 * node + i]
            });
            let (map, lacks) = (free[node] * map, free[node] * lacks);
            // Supports leave a map of lower rank.
            let whole = free[node] == SMatrix::<f64, 3, 3>::identity();
            let y = match map.try_inverse().filter(|_| whole) {
                Some(inverse) => inverse * lacks,
                None => pseudo_inverse(map.transpose() * map) * map.transpose() * lacks,
            };
            [y[0], y[1], y[2]]
        };
        Ok((0..free.len()).flat_map(of_node).collect())
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
