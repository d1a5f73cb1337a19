//! Loss of displacement by one linear problem in enriched cells.

use super::enriched::{Enriched, Modes};
use crate::elements::{PredictedStress, State, System, Unknowns, inadmissible, inverse, place};
use crate::linear::systems::CORRECTION;
use crate::linear::{add, dot};
use crate::{Method, Result, SolveError};
use sinew_energy::{Body, Response, with_nodes};
use sinew_num::Mat3;

/// Part of the energy of the modes that the last steps of the conjugate gradients may add; the larger one before a direction of negative
/// curvature.
const ACCURACY: f64 = 0.005;
const ROUGH: f64 = 0.05;
/// Number of these steps.
const LAST: usize = 3;
/// Most steps; a body that takes more loses most of its displacement, and its estimate is a lower bound.
const MOST_STEPS: usize = 100;

/// Tangent at a point.
type Tangent = [[f64; 9]; 9];

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
        let (own, _) = self.respond(&rate, &motion, false)?;
        let pressures: Vec<f64> =
            self.assembly.points.iter().map(|own| mean_stress(&own.h, &own.stress)).collect();
        let smooth = smoothed(body, &pressures);
        let parameters = body.law_parameters(theta);
        // A body with averaged volume ratios has those of its scaled gradients here, without patches.
        let point = |(point, h): (usize, Mat3<f64>)| {
            let Response { stress, mut tangent, .. } =
                body.material.response(point, parameters, &h);
            let more = smooth[point] - mean_stress(&h, &stress);
            h.plus_identity().add_second_of_determinant(more, &mut tangent);
            (h, tangent)
        };
        let gradients = body.law_gradients(displacement);
        let gradients = gradients.ok_or_else(|| inadmissible(body, displacement))?;
        let points = gradients.into_iter().enumerate().map(point);
        let (gradients, tangents): (Vec<Mat3<f64>>, Vec<Tangent>) = points.unzip();
        match body.patches.is_empty() {
            true => {
                let stress = self.stress_with(&pressures, &smooth);
                self.assembly.nearly_incompressible = true;
                self.assemble(&at, theta, load_factor, Some(&stress));
            }
            false => self.remove_patches(&tangents),
        }
        let (linear, stable) = self.respond(&rate, &motion, true)?;
        let enriched = Enriched::new(body, tangents);
        let mut residual = enriched.couple(&linear);
        if tension.iter().any(|&t| t != 0.0) {
            let rates = body.law_parameters(&tension);
            let stress = |point: usize| {
                body.material.stress_rate(point, parameters, rates, &gradients[point])
            };
            enriched.add_stresses(stress, &mut residual);
        }
        residual.as_flattened_mut().iter_mut().for_each(|force| *force = -*force);
        enriched.add_loads(displacement, theta, &mut residual);
        let mut better = linear.clone();
        let definite = stable && self.relax_modes(&enriched, residual, &mut better);
        let linear = if body.patches.is_empty() { linear } else { own.clone() };
        Ok(Responses { own, linear, better, definite })
    }

    /// Response of all nodes to a rate of the unbalanced forces by the assembled stiffness, and whether this is positive definite; it is
    /// factorised for more responses.
    fn respond(&mut self, rate: &[f64], motion: &[f64], more: bool) -> Result<(Vec<f64>, bool)> {
        let mut change: Vec<f64> = rate.iter().map(|r| -r).collect();
        let iterates = !more && self.method == Method::Aggregation;
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

    /// Replaces the stiffness of the patches by that of their cells.
    fn remove_patches(&mut self, tangents: &[Tangent]) {
        let body = self.body;
        for (index, of_patch) in body.patches.iter().enumerate() {
            let patch = &self.assembly.patches[index];
            let (at, alone) = (of_patch.iter(), patch.without_mean());
            let present = at.clone().map(|&point| self.assembly.points[point].tangent());
            let own = at.map(|&point| tangents[point]);
            let (before, after) = with_nodes!(body.nodes_per_cell, N => (
                patch.stiffness::<N>(body, of_patch, present),
                alone.stiffness::<N>(body, of_patch, own),
            ));
            let change = |row: usize, column: usize| {
                let at = row * (row + 1) / 2 + column;
                after[at] - before[at]
            };
            let places = self.sparsity.cells.of(index);
            self.assembly.add_matrix(&self.sparsity.frames, &alone.nodes, places, change);
        }
    }

    /// Conjugate gradients on the modes, with the nodes eliminated by the factor (Saad, 9.2); moves the nodes along. False where the
    /// curvature is not positive before that.
    fn relax_modes(
        &self,
        enriched: &Enriched<'_>,
        mut residual: Modes,
        displacement: &mut [f64],
    ) -> bool {
        let product = |a: &Modes, b: &Modes| dot(a.as_flattened(), b.as_flattened());
        let mut direction = enriched.precondition(&residual);
        let mut size = product(&residual, &direction);
        let (mut energy, mut last, mut settled) = (0.0, [f64::INFINITY; LAST], None);
        for step in 0..MOST_STEPS {
            if size == 0.0 {
                return true;
            }
            let (forces, mut image) = enriched.multiply(&direction);
            let mut change: Vec<f64> = self.sparsity.gather(&forces).collect();
            self.back_substitute(&mut change, CORRECTION);
            let nodal = self.sparsity.scattered(change);
            add(image.as_flattened_mut(), -1.0, enriched.couple(&nodal).as_flattened());
            let curvature = product(&direction, &image);
            // Written so that a NaN is no minimum.
            let convex = curvature > 0.0;
            if !convex {
                settled.iter().for_each(|before: &Vec<f64>| displacement.copy_from_slice(before));
                return settled.is_some();
            }
            let length = size / curvature;
            add(displacement, -length, &nodal);
            add(residual.as_flattened_mut(), -length, image.as_flattened());
            energy += length * size;
            last[step % LAST] = length * size;
            let added = last.iter().sum::<f64>() / energy;
            if added <= ACCURACY {
                return true;
            }
            if added <= ROUGH {
                settled = Some(displacement.to_vec());
            }
            let mut next = enriched.precondition(&residual);
            let before = size;
            size = product(&residual, &next);
            add(next.as_flattened_mut(), size / before, direction.as_flattened());
            direction = next;
        }
        true
    }
}

/// Mean Cauchy stress `P : F / 3J`.
fn mean_stress(h: &Mat3<f64>, stress: &Mat3<f64>) -> f64 {
    let f = h.plus_identity();
    dot(stress.0.as_flattened(), f.0.as_flattened()) / (3.0 * (1.0 + h.volume_change()))
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
