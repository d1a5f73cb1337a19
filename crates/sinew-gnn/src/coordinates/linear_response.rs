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
        let response_to_forces = self.solve(&stiffness, &dirichlet, &forces)?;
        add(1.0, &response_to_forces, &mut response);
        Ok(response)
    }

    /// The displacement u with `K u = f` where nothing is held, zero where it is.
    fn solve(
        &self,
        stiffness: &Stiffness,
        dirichlet: &Dirichlet,
        forces: &[f64],
    ) -> Result<Vec<f64>> {
        let size = forces.len();
        let projectors = dirichlet.projectors(3);
        let project = |vector: &[f64]| project(&projectors, vector);
        let precondition = |r: &[f64]| project(&self.tree().spread(&self.tree().gather(r)));
        let mut residual = project(forces);
        let mut response = vec![0.0; size];
        let mut direction = precondition(&residual);
        let mut decrease = dot(&residual, &direction);
        let first = decrease;
        for _ in 0..MOST_ITERATIONS {
            if decrease <= ACCURACY * first {
                return Ok(response);
            }
            let mut image = vec![0.0; size];
            stiffness.apply(&direction, &mut image);
            let image = project(&image);
            let step = decrease / dot(&direction, &image);
            add(step, &direction, &mut response);
            add(-step, &image, &mut residual);
            let next = precondition(&residual);
            let before = std::mem::replace(&mut decrease, dot(&residual, &next));
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + decrease / before * *d);
        }
        Err(Error::NoLinearResponse {
            iterations: MOST_ITERATIONS,
            left: (decrease / first).sqrt(),
        })
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
