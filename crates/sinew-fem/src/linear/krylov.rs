//! Krylov iterations: preconditioned conjugate gradients that notice negative curvature, and GMRES.

use crate::linear::{add, difference, dot, norm, relative};
use sinew_num::{in_parallel, sum};

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

/// A solution, the iterations that lead to it, and their end.
pub(crate) type Iterated = (Vec<f64>, usize, End);

/// Solves `A x = b` with a symmetric matrix from x = 0 (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952).
///
/// They end when the residual is `tolerance` times the right-hand side, both in the norm of the preconditioner, which is close to the error in the energy norm. In
/// the Euclidean norm smooth errors do not show.
/// `apply(x, y)` writes A x to y; `precondition(x, y)` a symmetric positive definite approximation of A⁻¹ x.
pub(crate) fn conjugate_gradients(
    apply: impl Fn(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    right: &[f64],
    tolerance: f64,
    most: usize,
) -> Iterated {
    let (mut solution, mut residual) = (vec![0.0; right.len()], right.to_vec());
    let (mut direction, mut image) = (solution.clone(), solution.clone());
    let (mut first, mut slope) = (None, f64::INFINITY);
    for iterations in 0..=most {
        precondition(&residual, &mut image);
        let next = inner_product(&residual, &image);
        if next == 0.0 || (0.0..=tolerance * tolerance * *first.get_or_insert(next)).contains(&next)
        {
            return (solution, iterations, End::Converged);
        }
        let turn = next / slope;
        update(&mut direction, &image, |p, z| *p = z + turn * *p);
        slope = next;
        apply(&direction, &mut image);
        let curvature = inner_product(&direction, &image);
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

/// Calls `change` with each component of two vectors.
pub(crate) fn update<T: Send, F: Copy + Sync>(
    to: &mut [T],
    from: &[F],
    change: impl Fn(&mut T, F) + Sync,
) {
    in_parallel(to.chunks_mut(SHARE).zip(from.chunks(SHARE)), |(to, from)| {
        to.iter_mut().zip(from).for_each(|(to, &from)| change(to, from));
    });
}

/// Largest magnitude of a component, more than zero.
pub(crate) fn largest(vector: &[f64]) -> f64 {
    let of_share =
        |share: &[f64]| share.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    in_parallel(vector.chunks(SHARE), of_share).into_iter().fold(f64::MIN_POSITIVE, f64::max)
}

fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    let shares = a.chunks(SHARE).zip(b.chunks(SHARE));
    sum(&in_parallel(shares, |(a, b)| sinew_num::dot(a, b)))
}

/// Directions that are kept before a restart, each with its image.
const RESTART: usize = 80;
/// Least new part of an image \[relative to the image\]; below it the system is singular to rounding errors.
const SINGULAR: f64 = 1e-14;
/// Largest part of the residual that a step leaves for the next to start from the residual. A step that hardly reduces it would be made again; the next one
/// starts from its image.
const FALLING: f64 = 0.9;

/// Outcome of an iterative solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinearOutcome {
    /// Matrix–vector products.
    pub iterations: usize,
    /// Norm of the residual relative to that of the right-hand side.
    pub relative_residual: f64,
}

/// Solves `A x = b` by GMRES with right preconditioning (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7,
/// 1986), from x = 0, by directions with orthonormal images (generalised conjugate residuals; S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J.
/// Numer. Anal. 20, 1983). The residual that is returned is the true one, whatever the preconditioner.
///
/// `apply(x, y)` writes A x to y; `precondition(x, y)` an approximation of A⁻¹ x.
pub(crate) fn gmres(
    mut apply: impl FnMut(&[f64], &mut [f64]),
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    right: &[f64],
    solution: &mut [f64],
    tolerance: f64,
    most_iterations: usize,
) -> LinearOutcome {
    let zeros = vec![0.0; right.len()];
    solution.fill(0.0);
    let (scale, mut iterations) = (norm(right), 0);
    let (mut residual, mut start) = (right.to_vec(), f64::INFINITY);
    let mut restarts = true;
    loop {
        let before = std::mem::replace(&mut start, norm(&residual));
        let relative_residual = relative(start, scale);
        // Rounding errors: the true residual no longer follows the predicted one, so further iterations gain nothing.
        let stuck = start > 0.5 * before && !restarts;
        // Written so that a NaN ends the iteration as well.
        let going = relative_residual > tolerance && start.is_finite();
        if stuck || !going || iterations >= most_iterations {
            return LinearOutcome { iterations, relative_residual };
        }
        let mut space: Vec<[Vec<f64>; 2]> = Vec::new();
        let (mut left, mut falls) = (start, true);
        while space.len() < RESTART && iterations < most_iterations && left > tolerance * scale {
            let last = space.last().filter(|_| !falls).map_or(&residual, |[_, image]| image);
            let [mut direction, mut image] = [zeros.clone(), zeros.clone()];
            precondition(last, &mut direction);
            apply(&direction, &mut image);
            iterations += 1;
            let whole = norm(&image);
            // Twice: modified Gram–Schmidt alone loses orthogonality on ill-conditioned systems.
            for [other, of_other] in space.iter().chain(&space) {
                let along = -dot(of_other, &image);
                add(&mut image, along, of_other);
                add(&mut direction, along, other);
            }
            let length = norm(&image);
            // Written so that a NaN ends the iteration as well.
            let independent = length > SINGULAR * whole && length.is_finite();
            if !independent {
                break;
            }
            let along = dot(&image, &residual) / length;
            image.iter_mut().chain(&mut direction).for_each(|x| *x /= length);
            add(solution, along, &direction);
            add(&mut residual, -along, &image);
            let next = norm(&residual);
            (left, falls) = (next, next <= FALLING * left);
            space.push([direction, image]);
        }
        restarts = space.len() == RESTART;
        let mut image = zeros.clone();
        apply(solution, &mut image);
        residual = difference(right, &image);
    }
}
