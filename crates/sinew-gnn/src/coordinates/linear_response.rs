//! One linear solve without a factorisation.

use sinew_energy::Stiffness;

use super::Motions;
use crate::data::Dirichlet;
use crate::error::{Error, Result, require_count, require_finite};

/// Energy of what the iteration would still change, relative to the response's own, at which it ends.
const ACCURACY: f64 = 1e-16;
/// Iterations after which a response counts as not found: several times as many as the worst body needed.
const MOST_ITERATIONS: usize = 5000;

impl Motions {
    /// The displacement u with `K u = f` where nothing is held, zero where it is \[length\]: conjugate gradients that these
    /// motions precondition, in time and memory proportional to the body.
    ///
    /// A typical energy for training without simulations is `½ f·u`, and a typical [size](Motions::scaled)
    /// of the outputs is `√(f·u / unknowns)`.
    ///
    /// # Errors
    /// Arrays that do not fit each other, forces that are not finite, a body that can move freely.
    pub fn linear_response(
        &self,
        stiffness: &Stiffness,
        dirichlet: &Dirichlet,
        forces: &[f64],
    ) -> Result<Vec<f64>> {
        let size = 3 * self.tree().positions.len();
        require_count("nodes of the stiffness", 3 * stiffness.nodes(), size)?;
        require_count("prescribed entries", dirichlet.prescribed.len(), size)?;
        require_count("forces", forces.len(), size)?;
        require_finite("forces", forces)?;
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
        Err(Error::NoLinearResponse { iterations: MOST_ITERATIONS, left: (decrease / first).sqrt() })
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
