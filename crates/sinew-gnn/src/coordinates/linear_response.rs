//! One linear solve without a factorisation.

use sinew_energy::{Body, Stiffness};

use super::Motions;
use super::motions::stiffness;
use crate::data::Dirichlet;
use crate::error::{Error, Result, require_count};

/// Energy of what the iteration would still change, relative to the response's own, at which it ends.
const ACCURACY: f64 = 1e-16;
/// Iterations after which a response counts as not found: several times as many as the worst body needed.
const MOST_ITERATIONS: usize = 5000;

impl Motions {
    /// Response of a body to its loads and supports as if it were linear about rest, at θ \[length\]: conjugate gradients that
    /// these motions precondition, in time and memory proportional to the body.
    ///
    /// # Errors
    /// Another body than the motions', θ that does not suit it, a body that can move freely.
    pub fn linear_response(&self, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
        let size = 3 * body.nodes;
        require_count("nodes of the body", body.nodes, self.tree().positions.len())?;
        let dirichlet = Dirichlet::of_body(body);
        let mut response = dirichlet.held(3);
        let stiffness = stiffness(body, &vec![0.0; size], theta)?;
        let (mut forces, mut of_supports) = (vec![0.0; size], vec![0.0; size]);
        body.value_and_gradient(&vec![0.0; size], theta, &mut forces);
        stiffness.apply(&response, &mut of_supports);
        forces.iter_mut().zip(&of_supports).for_each(|(force, held)| *force = -*force - held);
        let outputs = self.solve(&stiffness, &dirichlet, &forces)?;
        add(1.0, &self.displacement_of(&outputs, &dirichlet), &mut response);
        Ok(response)
    }

    /// Small outputs `Bᵀ w` whose displacement u has `K u = f` where nothing is held: of all that do, those of least squares.
    fn solve(
        &self,
        stiffness: &Stiffness,
        dirichlet: &Dirichlet,
        forces: &[f64],
    ) -> Result<Vec<f64>> {
        let size = forces.len();
        let projectors = dirichlet.projectors(3);
        let project = |vector: &[f64]| project(&projectors, vector);
        let mut residual = project(forces);
        let mut outputs = vec![0.0; self.tree().gather(&residual).len()];
        // The search direction as outputs; what it displaces follows from them.
        let mut direction = outputs.clone();
        let (mut before, mut first) = (f64::INFINITY, 0f64);
        for _ in 0..MOST_ITERATIONS {
            let next = self.tree().gather(&residual);
            let decrease = dot(&next, &next);
            first = first.max(decrease);
            if decrease <= ACCURACY * first {
                return Ok(outputs);
            }
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + decrease / before * *d);
            before = decrease;
            let moved = project(&self.tree().spread(&direction));
            let mut image = vec![0.0; size];
            stiffness.apply(&moved, &mut image);
            let image = project(&image);
            let step = decrease / dot(&moved, &image);
            add(step, &direction, &mut outputs);
            add(-step, &image, &mut residual);
        }
        let left = (before / first).sqrt();
        Err(Error::NoLinearResponse { iterations: MOST_ITERATIONS, left })
    }

    fn displacement_of(&self, outputs: &[f64], dirichlet: &Dirichlet) -> Vec<f64> {
        project(&dirichlet.projectors(3), &self.tree().spread(outputs))
    }
}

fn project(projectors: &[f64], vector: &[f64]) -> Vec<f64> {
    let rows = projectors.chunks_exact(3).enumerate();
    rows.map(|(at, row)| dot(row, &vector[at / 3 * 3..at / 3 * 3 + 3])).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(factor: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}
