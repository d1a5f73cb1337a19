//! Preconditioned conjugate gradients that notice negative curvature.

use rayon::prelude::*;
use sinew_num::sum;

/// Components of a task: a fixed division, so that products do not depend on the number of threads.
const SHARE: usize = 4096;

/// End of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The residual is below the tolerance.
    Converged,
    /// The matrix has a direction of negative or no curvature.
    NegativeCurvature,
    /// The iterations ran out, or a number is not finite.
    Failed,
}

/// Solves `A x = b` with a symmetric matrix from x = 0 (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952): the solution, the iterations and their
/// end.
///
/// They end when the residual is `tolerance` times the right-hand side, both in the norm of the preconditioner, which is close to the error in the energy norm. In
/// the Euclidean norm smooth errors do not show.
/// `apply(x, y)` writes A x to y; `precondition(x, y)` a symmetric positive definite approximation of A⁻¹ x.
pub(crate) fn conjugate_gradients(
    apply: impl Fn(&[f64], &mut [f64]),
    precondition: impl Fn(&[f64], &mut [f64]),
    right: &[f64],
    tolerance: f64,
    most: usize,
) -> (Vec<f64>, usize, End) {
    let (mut solution, mut residual) = (vec![0.0; right.len()], right.to_vec());
    let (mut direction, mut image) = (solution.clone(), solution.clone());
    let (mut first, mut slope) = (None, f64::INFINITY);
    for iterations in 0..=most {
        precondition(&residual, &mut image);
        let next = dot(&residual, &image);
        if next == 0.0 || (0.0..=tolerance * tolerance * *first.get_or_insert(next)).contains(&next)
        {
            return (solution, iterations, End::Converged);
        }
        let turn = next / slope;
        update(&mut direction, &image, |p, z| *p = z + turn * *p);
        slope = next;
        apply(&direction, &mut image);
        let curvature = dot(&direction, &image);
        if !(slope.is_finite() && curvature.is_finite()) {
            break;
        }
        if slope <= 0.0 || curvature <= 0.0 {
            return (solution, iterations, End::NegativeCurvature);
        }
        let length = slope / curvature;
        update(&mut solution, &direction, |x, p| *x += length * p);
        update(&mut residual, &image, |r, q| *r -= length * q);
    }
    (solution, most, End::Failed)
}

fn update(to: &mut [f64], from: &[f64], change: impl Fn(&mut f64, f64) + Sync) {
    let pairs = to.par_iter_mut().zip(from).with_min_len(SHARE);
    pairs.for_each(|(to, &from)| change(to, from));
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let shares = a.par_chunks(SHARE).zip(b.par_chunks(SHARE));
    sum(&shares.map(|(a, b)| sinew_num::dot(a, b)).collect::<Vec<_>>())
}
