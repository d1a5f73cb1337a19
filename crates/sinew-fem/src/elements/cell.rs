//! Kernels of one cell.

use sinew_energy::{Frames, Response};
use sinew_num::Mat3;

/// A stiffness matrix in blocks: entry `[a][i][b][k]` is for components i of node a and k of node b.
pub(crate) type NodalBlocks<const N: usize> = [[[[f64; 3]; N]; 3]; N];

/// Adds the stiffness `V g_aj A_ijkl g_bl` of a quadrature point to that of its cell, without the first
/// node, see [`complete`].
#[inline]
pub(crate) fn add_stiffness<const N: usize>(
    tangent: &[[f64; 9]; 9],
    shape: &[[f64; 3]; N],
    volume: f64,
    blocks: &mut NodalBlocks<N>,
) {
    for a in 1..N {
        let g = shape[a].map(|x| volume * x);
        for i in 0..3 {
            let mut left = [0.0; 9];
            for kl in 0..9 {
                left[kl] = g[0] * tangent[3 * i][kl]
                    + g[1] * tangent[3 * i + 1][kl]
                    + g[2] * tangent[3 * i + 2][kl];
            }
            for b in 1..=a {
                for k in 0..3 {
                    blocks[a][i][b][k] += left[3 * k] * shape[b][0]
                        + left[3 * k + 1] * shape[b][1]
                        + left[3 * k + 2] * shape[b][2];
                }
            }
        }
    }
}

/// Adds the blocks of the first node to the lower half of a cell's stiffness: all shape gradients add up to
/// zero, so they follow from the others.
#[inline]
pub(crate) fn complete<const N: usize>(blocks: &mut NodalBlocks<N>) {
    for a in 1..N {
        for i in 0..3 {
            for k in 0..3 {
                let mut sum = 0.0;
                for b in 1..N {
                    sum += if b <= a { blocks[a][i][b][k] } else { blocks[b][k][a][i] };
                }
                blocks[a][i][0][k] = -sum;
            }
        }
    }
    for i in 0..3 {
        for k in 0..3 {
            blocks[0][i][0][k] = -(1..N).map(|b| blocks[b][k][0][i]).sum::<f64>();
        }
    }
}

/// `(I + H)⁻¹`.
pub(crate) fn inverse(h: &Mat3<f64>) -> Mat3<f64> {
    let f = h.plus_identity();
    let scale = (1.0 + h.volume_change()).recip();
    Mat3::from_fn(|i, j| f.cofactor(j, i) * scale)
}

/// Whether a step is too short to flatten a cell: shorter than the least stretch, for which 2J/|F|² is a bound.
pub(crate) fn is_short(h: &Mat3<f64>, step: &Mat3<f64>, length: f64) -> bool {
    /// Leaves a thousandth of the volume when all three stretches shrink by it.
    const SHORT: f64 = 0.9;
    let f = h.plus_identity();
    let least = 2.0 * f.determinant() / f.squared_norm();
    length * step.squared_norm().sqrt() <= SHORT * least
}

/// The volume ratio J at `h`, the least on the way to `h + length·step`, and that at the end.
///
/// J is a cubic in the part of the way, so it is least at an end or where its derivative vanishes.
pub(crate) fn volume_ratios_along(h: &Mat3<f64>, step: &Mat3<f64>, length: f64) -> [f64; 3] {
    let f = h.plus_identity();
    let (mut linear, mut quadratic) = (0.0, 0.0);
    for i in 0..3 {
        for j in 0..3 {
            linear += f.cofactor(i, j) * step[i][j];
            quadratic += step.cofactor(i, j) * f[i][j];
        }
    }
    let (start, cubic) = (f.determinant(), step.determinant());
    let ratio = |t: f64| start + t * (linear + t * (quadratic + t * cubic));
    let end = ratio(length);
    // Roots of the derivative, in the form that does not cancel; NaN does not count.
    let root = (quadratic * quadratic - 3.0 * cubic * linear).sqrt();
    let half = -(quadratic + root.copysign(quadratic));
    let roots = [half / (3.0 * cubic), linear / half];
    let inside = roots.into_iter().filter(|t| *t > 0.0 && *t < length).map(ratio);
    [start, inside.fold(start.min(end), f64::min), end]
}

/// Adds the energy `p (J − 1)` of a pressure with its derivatives in F.
pub(crate) fn add_pressure(response: &mut Response, h: &Mat3<f64>, pressure: f64) {
    let f = h.plus_identity();
    response.energy += pressure * h.volume_change();
    let (stress, cofactor) = (response.stress, f.cofactors());
    response.stress = Mat3::from_fn(|i, j| stress[i][j] + pressure * cofactor[i][j]);
    f.add_second_of_determinant(pressure, &mut response.tangent);
}

/// `A : dH`.
pub(crate) fn tangent_times(tangent: &[[f64; 9]; 9], dh: &Mat3<f64>) -> Mat3<f64> {
    let (flat, mut product) = (dh.0.as_flattened(), Mat3::ZERO);
    for (entry, row) in product.0.as_flattened_mut().iter_mut().zip(tangent) {
        *entry = row.iter().zip(flat).map(|(a, h)| a * h).sum();
    }
    product
}

/// `A B`.
pub(crate) fn product(a: &Mat3<f64>, b: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
}

/// Rounding errors in energy and nodal forces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rounding {
    /// Sum of the magnitudes of the terms of the energy.
    pub energy: f64,
    /// Rounding errors of the forces, part by part.
    pub forces: Vec<f64>,
}

impl Rounding {
    /// Adds one cell whose nodes move by `motion`: H carries the rounding errors of its terms `u g`, the
    /// stress those of 1 + H times the tangent, to which `common` adds a stiffness shared with other points.
    pub(crate) fn add_cell(
        &mut self,
        shape: &[[f64; 3]],
        volume: f64,
        motion: f64,
        (h, response): (&Mat3<f64>, &Response),
        common: f64,
    ) {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let (slope, strain) = (largest(shape.as_flattened()), largest(h.0.as_flattened()));
        let stiffness = (0..9).map(|i| response.tangent[i][i].abs()).fold(common, f64::max);
        let force = volume * slope * stiffness * (1.0 + slope * motion);
        self.forces.push(force);
        self.energy += volume * stiffness * strain * (1.0 + strain);
    }
}

/// Turns a symmetric matrix over the components of some nodes into their frames; `lower` is its lower half, row by row.
/// Does nothing when none of them has one, so that nobody else pays.
pub(crate) fn turn(frames: &Frames, nodes: &[usize], lower: &mut [f64]) {
    if frames.is_empty() || nodes.iter().all(|&node| frames.get(node).is_none()) {
        return;
    }
    let size = 3 * nodes.len();
    let place = |(row, column): (usize, usize)| {
        row.max(column) * (row.max(column) + 1) / 2 + row.min(column)
    };
    let mut matrix: Vec<f64> =
        (0..size * size).map(|at| lower[place((at / size, at % size))]).collect();
    turn_square(frames, nodes, &mut matrix);
    let half = (0..size).flat_map(|row| row * size..=row * (size + 1));
    lower.iter_mut().zip(half).for_each(|(entry, at)| *entry = matrix[at]);
}

/// Turns a square matrix over the components of some nodes into their frames.
pub(crate) fn turn_square(frames: &Frames, nodes: &[usize], matrix: &mut [f64]) {
    let size = 3 * nodes.len();
    for (a, &node) in nodes.iter().enumerate() {
        let Some(frame) = frames.get(node) else { continue };
        // All rows, then all columns.
        for [own, across] in [[size, 1], [1, size]] {
            for other in 0..size {
                let place = |i: usize| (3 * a + i) * own + other * across;
                let turned = frame.apply(&std::array::from_fn(|i| matrix[place(i)]));
                (0..3).for_each(|i| matrix[place(i)] = turned[i]);
            }
        }
    }
}
