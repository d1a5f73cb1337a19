//! Loss of displacement by one linear problem in enriched cells.

use super::enriched::{Enriched, Modes};
use crate::elements::{
    PointState, PredictedStress, State, System, Unknowns, inadmissible, inverse, mean_stress, place,
};
use crate::linear::systems::CORRECTION;
use crate::linear::{End, add, conjugate_gradients, dot};
use crate::{Method, Result, SolveError};
use sinew_energy::{Body, with_nodes};
use sinew_num::{Mat3, on_ready_threads};

/// Error of a response by conjugate gradients on nodes and modes \[relative, in the energy norm\].
const NEARLY: f64 = 0.1;
/// Most steps; a body that takes more loses most of its displacement, and its estimate is a lower bound.
const MOST_STEPS: usize = 200;

/// Change of the displacement with all loads, \[length\] per load factor.
struct Responses {
    /// Response by the stiffness at the displacement.
    own: Vec<f64>,
    /// Response by the same cells with the smooth mean stresses of the enriched ones; averaged cells keep their own.
    linear: Vec<f64>,
    /// Response by enriched cells.
    better: Vec<f64>,
    /// Whether the stiffness of the enriched cells is positive definite.
    definite: bool,
}

impl Responses {
    /// Ratio m of the response of enriched cells to that of linear ones; 1 without loads, none where the stiffness gives no answer.
    fn ratio(&self) -> Option<f64> {
        let size = dot(&self.linear, &self.linear);
        let ratio = if size == 0.0 { 1.0 } else { dot(&self.linear, &self.better) / size };
        (self.definite && ratio > 0.0 && ratio.is_finite()).then_some(ratio)
    }
}

impl System<'_> {
    /// Loss relative to the displacement of cells that do not lock, at an equilibrium.
    ///
    /// The responses of linear and enriched cells to the loads have the ratio m. If the displacement grows as the load to the power s there, it
    /// is m^s times as large in enriched cells. Towards this larger displacement s falls, and m with it: s^(3/2) stands for both
    /// (docs/design.md, "Elements"). A body that softens under its load does so in both responses, so that s is at most 1. Where the stresses of
    /// linear cells make the stiffness of the enriched ones indefinite, m is that at rest.
    pub(crate) fn loss(&mut self, displacement: &[f64], theta: &[f64]) -> Result<f64> {
        let state = State::whole(displacement, theta);
        let found = self.responses(state)?;
        let size = dot(displacement, displacement);
        let power = if size > 0.0 { dot(displacement, &found.own) / size } else { 1.0 };
        let ratio = match found.ratio().filter(|_| size > 0.0) {
            Some(ratio) => ratio,
            None => {
                let rest = vec![0.0; displacement.len()];
                self.responses(State { displacement: &rest, load_factor: 0.0, ..state })?
                    .ratio()
                    .unwrap_or(f64::INFINITY)
            }
        };
        let loss = 1.0 - ratio.powf(-power.clamp(0.0, 1.0).powf(1.5));
        Ok(loss.max(0.0))
    }

    /// Responses at a displacement; the stiffness has a fraction of the loads.
    fn responses(&mut self, state: State<'_>) -> Result<Responses> {
        let (body, State { displacement, theta, load_factor, .. }) = (self.body, state);
        let at = Unknowns::of(displacement);
        self.assemble(&at, theta, load_factor, None);
        self.assembly.check()?;
        let mut motion = vec![0.0; displacement.len()];
        place(body, 1.0, &mut motion);
        // Active stress counts as a load, the rest of θ does not.
        let mut tension = vec![0.0; theta.len()];
        self.stressing_entries(theta).into_iter().for_each(|at| tension[at] = theta[at]);
        let mut rate = self.load_derivative(displacement, theta);
        let more = self.response_to_supports(state, &motion).into_iter();
        let more = more.zip(self.rate_by_theta(state, &tension));
        rate.iter_mut().zip(more).for_each(|(rate, (moved, tension))| *rate += moved + tension);
        let (own, _) = self.respond(&rate, &motion)?;
        let pressures: Vec<f64> =
            self.assembly.points.iter().map(|own| mean_stress(&own.h, &own.stress)).collect();
        let smooth = smoothed(body, &pressures);
        let parameters = body.law_parameters(theta);
        if body.patches.is_empty() {
            let stress = self.stress_with(&pressures, &smooth);
            self.assembly.nearly_incompressible = true;
            self.assemble(&at, theta, load_factor, Some(&stress));
            let points = self.assembly.points.iter_mut().zip(&smooth);
            points.for_each(|(point, &smooth)| point.set_mean_stress(smooth));
        } else {
            // A body with averaged volume ratios has the tangents of its scaled gradients here, without patches.
            let gradients = body.law_gradients(displacement);
            let gradients = gradients.ok_or_else(|| inadmissible(body, displacement))?;
            self.remove_patches(|point| {
                let h = &gradients[point];
                let mut own = PointState::new(h, &body.material.response(point, parameters, h));
                own.set_mean_stress(smooth[point]);
                own
            });
        }
        let (linear, stable) = self.respond(&rate, &motion)?;
        let enriched = Enriched::new(body, &self.assembly.points);
        let (_, mut residual) = enriched.multiply(&linear, &enriched.zeros());
        if tension.iter().any(|&t| t != 0.0) {
            let rates = body.law_parameters(&tension);
            let gradient = |point: usize| &self.assembly.points[point].h;
            let stress =
                |point| body.material.stress_rate(point, parameters, rates, gradient(point));
            enriched.add_stresses(stress, &mut residual);
        }
        residual.as_flattened_mut().iter_mut().for_each(|force| *force = -*force);
        enriched.add_loads(displacement, theta, &mut residual);
        let mut better = linear.clone();
        let definite = stable && self.relax(&enriched, &residual, &mut better);
        let linear = if body.patches.is_empty() { linear } else { own.clone() };
        Ok(Responses { own, linear, better, definite })
    }

    /// Response of all nodes to a rate of the unbalanced forces by the assembled stiffness, and whether this is positive definite.
    fn respond(&mut self, rate: &[f64], motion: &[f64]) -> Result<(Vec<f64>, bool)> {
        let mut change: Vec<f64> = rate.iter().map(|r| -r).collect();
        let iterates = self.method == Method::Aggregation;
        let iterated = iterates.then(|| self.iterate(&change, CORRECTION, 1)).flatten();
        let shift = match iterated {
            Some((iterated, shift)) => {
                change = iterated;
                shift
            }
            None => {
                let (shift, _) = self.factorise(true).ok_or(SolveError::Singular)?;
                self.back_substitute(&mut change, CORRECTION);
                shift
            }
        };
        if change.iter().any(|x| !x.is_finite()) {
            return Err(SolveError::Singular);
        }
        let mut response = motion.to_vec();
        self.sparsity.scatter(change, &mut response);
        Ok((response, shift == 0.0))
    }

    /// Second Piola–Kirchhoff stress with other mean stresses.
    fn stress_with(&self, pressures: &[f64], others: &[f64]) -> PredictedStress {
        let points = self.assembly.displacement_gradients().zip(self.assembly.stress());
        let stress = |(point, (h, own)): (usize, (&Mat3<f64>, Mat3<f64>))| {
            let more = (others[point] - pressures[point]) * (1.0 + h.volume_change());
            let inverse = inverse(h);
            let compliance =
                |i: usize, k: usize| (0..3).map(move |l| inverse[i][l] * inverse[k][l]);
            Mat3::from_fn(|i, k| own[i][k] + more * compliance(i, k).sum::<f64>())
        };
        points.enumerate().map(stress).collect()
    }

    /// Replaces points and stiffness of the patches by those of their cells.
    fn remove_patches(&mut self, point: impl Fn(usize) -> PointState) {
        let body = self.body;
        for (index, of_patch) in body.patches.iter().enumerate() {
            let patch = &self.assembly.patches[index];
            let alone = patch.without_mean();
            let points = &mut self.assembly.points;
            let (before, after) = with_nodes!(body.nodes_per_cell, N => {
                let tangents = |points: &[PointState]| {
                    of_patch.iter().map(|&at| points[at].tangent()).collect::<Vec<_>>()
                };
                let before = patch.stiffness::<N>(body, of_patch, tangents(points).into_iter());
                of_patch.iter().for_each(|&at| points[at] = point(at));
                (before, alone.stiffness::<N>(body, of_patch, tangents(points).into_iter()))
            });
            let change = |row: usize, column: usize| {
                let at = row * (row + 1) / 2 + column;
                after[at] - before[at]
            };
            let places = self.sparsity.cells.of(index);
            self.assembly.add_matrix(&self.sparsity.frames, &alone.nodes, places, change);
        }
    }

    /// Conjugate gradients on nodes and modes together: the factor or a V-cycle preconditions the nodes, their diagonal blocks the modes. Moves the nodes;
    /// false where the curvature is not positive.
    fn relax(&self, enriched: &Enriched<'_>, residual: &Modes, displacement: &mut [f64]) -> bool {
        let nodes = self.sparsity.unknowns();
        let mut right = vec![0.0; nodes];
        right.extend(residual.as_flattened());
        let apply = |from: &[f64], to: &mut [f64]| {
            let (of_nodes, of_modes) = from.split_at(nodes);
            let displacement = self.sparsity.scattered(of_nodes.iter().copied());
            let (forces, own) = enriched.multiply(&displacement, of_modes.as_chunks().0);
            let (on_nodes, on_modes) = to.split_at_mut(nodes);
            self.sparsity.multiply([&self.assembly.matrix; 2], of_nodes, on_nodes);
            on_nodes.iter_mut().zip(self.sparsity.gather(&forces)).for_each(|(to, f)| *to += f);
            on_modes.copy_from_slice(own.as_flattened());
        };
        let mut cycle = self.aggregation.cycle();
        let precondition = |from: &[f64], to: &mut [f64]| {
            let (of_nodes, of_modes) = from.split_at(nodes);
            to[..nodes].copy_from_slice(of_nodes);
            match self.iterates {
                true => cycle(&mut to[..nodes]),
                false => self.factor.solve(&mut to[..nodes]),
            }
            let modes = enriched.precondition(of_modes.as_chunks().0);
            to[nodes..].copy_from_slice(modes.as_flattened());
        };
        let (change, _, end) = on_ready_threads(|| {
            conjugate_gradients(apply, precondition, &right, NEARLY, MOST_STEPS)
        });
        add(displacement, 1.0, &self.sparsity.scattered(change[..nodes].iter().copied()));
        // Numbers that are not finite leave no change.
        end == End::Converged || end == End::Failed && change.iter().any(|&x| x != 0.0)
    }
}

/// Values at the points of mean values at the nodes: the mean stresses of cells that lock alternate from cell to cell.
fn smoothed(body: &Body, values: &[f64]) -> Vec<f64> {
    let mut nodal = vec![[0.0; 2]; body.nodes];
    for (point, (value, volume)) in values.iter().zip(&body.volumes).enumerate() {
        for &node in body.nodes_of_point(point) {
            nodal[node][0] += volume * value;
            nodal[node][1] += volume;
        }
    }
    let mean = |point: usize| {
        let nodes = body.nodes_of_point(point);
        nodes.iter().map(|&node| nodal[node][0] / nodal[node][1]).sum::<f64>() / nodes.len() as f64
    };
    (0..values.len()).map(mean).collect()
}
