//! 3×3 matrices over any [`Scalar`].

use crate::{Scalar, dot3};

/// A 3×3 matrix, `m[i][j]` in row `i` and column `j`.
///
/// The displacement gradient H = ∂u/∂X has `m[i][j] = ∂u_i/∂X_j`. The invariants below are
/// written in H rather than in F = I + H, so that single precision keeps its digits at small strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mat3<S>(pub [[S; 3]; 3]);

impl<S> std::ops::Index<usize> for Mat3<S> {
    type Output = [S; 3];
    fn index(&self, row: usize) -> &[S; 3] {
        &self.0[row]
    }
}

impl<S: Scalar> Mat3<S> {
    /// The matrix with entries `entry(i, j)`.
    pub fn from_fn(mut entry: impl FnMut(usize, usize) -> S) -> Self {
        // Written out: `std::array::from_fn` is six functions for each closure, and a seventh of the LLVM input of `sinew-energy`.
        let mut row = |i| [entry(i, 0), entry(i, 1), entry(i, 2)];
        Self([row(0), row(1), row(2)])
    }

    /// Entry in row `i` and column `j`.
    pub fn at(&self, i: usize, j: usize) -> S {
        self.0[i][j].clone()
    }

    /// Trace.
    pub fn trace(&self) -> S {
        self.at(0, 0) + self.at(1, 1) + self.at(2, 2)
    }

    /// Sum of the squares of all entries, `H : H`.
    pub fn squared_norm(&self) -> S {
        let row = |i| self.at(i, 0).squared() + self.at(i, 1).squared() + self.at(i, 2).squared();
        row(0) + row(1) + row(2)
    }

    /// Minor that leaves out row `i` and column `j`, with its sign: entry of the cofactor matrix.
    pub fn cofactor(&self, i: usize, j: usize) -> S {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (p, q) = ((j + 1) % 3, (j + 2) % 3);
        self.at(r, p) * self.at(s, q) - self.at(r, q) * self.at(s, p)
    }

    /// Determinant.
    pub fn determinant(&self) -> S {
        self.at(0, 0) * self.cofactor(0, 0)
            + self.at(0, 1) * self.cofactor(0, 1)
            + self.at(0, 2) * self.cofactor(0, 2)
    }

    /// Matrix–vector product.
    pub fn apply(&self, v: &[S; 3]) -> [S; 3] {
        let row = |i| dot3(&self[i], v);
        [row(0), row(1), row(2)]
    }

    /// `det(I + H) − 1`, expanded so that nothing cancels at small H.
    pub fn volume_change(&self) -> S {
        let second = self.cofactor(0, 0) + self.cofactor(1, 1) + self.cofactor(2, 2);
        self.trace() + second + self.determinant()
    }

    /// `I₁ − 3 = tr((I + H)ᵀ(I + H)) − 3`, expanded so that nothing cancels at small H.
    pub fn first_invariant_minus_three(&self) -> S {
        self.trace() * 2.0 + self.squared_norm()
    }

    /// `C − I = H + Hᵀ + HᵀH` between directions `a` and `b`: `a·(C − I)b`.
    pub fn strain_between(&self, a: &[S; 3], b: &[S; 3]) -> S {
        let (ha, hb) = (self.apply(a), self.apply(b));
        dot3(a, &hb) + dot3(&ha, b) + dot3(&ha, &hb)
    }
}

impl Mat3<f64> {
    /// The zero matrix.
    pub const ZERO: Self = Self([[0.0; 3]; 3]);
    /// The unit matrix.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// F = I + H.
    #[inline]
    pub fn plus_identity(&self) -> Self {
        Self::from_fn(|i, j| self[i][j] + if i == j { 1.0 } else { 0.0 })
    }

    /// The cofactor matrix, `∂det/∂F` at F.
    #[inline]
    pub fn cofactors(&self) -> Self {
        Self::from_fn(|i, j| self.cofactor(i, j))
    }

    /// Adds `weight ∂²det/∂F_ij∂F_kl = weight ε_ikm ε_jln F_mn` at F to row `3i + j` and column `3k + l` of a tangent.
    #[inline]
    pub fn add_second_of_determinant(&self, weight: f64, tangent: &mut [[f64; 9]; 9]) {
        let others = |i: usize| [((i + 1) % 3, (i + 2) % 3, 1.0), ((i + 2) % 3, (i + 1) % 3, -1.0)];
        for (i, j) in (0..9).map(|row| (row / 3, row % 3)) {
            for (k, m, first) in others(i) {
                for (l, n, second) in others(j) {
                    tangent[3 * i + j][3 * k + l] += first * second * weight * self[m][n];
                }
            }
        }
    }

    /// The nine entries row by row as variables of a [`crate::Jet`] or any other number type.
    pub fn seeded<S: Scalar>(&self, variable: impl Fn(f64, usize) -> S) -> Mat3<S> {
        Mat3::from_fn(|i, j| variable(self[i][j], 3 * i + j))
    }
}
