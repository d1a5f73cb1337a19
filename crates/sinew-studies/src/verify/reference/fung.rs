//! Homogeneous states of exponential laws with fibres along the first axis and sheets along the second.

use super::root;
use anyhow::Result;

type Matrix = nalgebra::Matrix3<f64>;

/// Exponential laws by their isochoric part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fung {
    /// Transversely isotropic Holzapfel–Ogden: a, b, a_f, b_f.
    HolzapfelOgden([f64; 4]),
    /// Orthotropic Holzapfel–Ogden (2009): a, b, a_f, b_f, a_s, b_s, a_fs, b_fs.
    HolzapfelOgden2009([f64; 8]),
    /// Guccione: C, b_f, b_t, b_fs.
    Guccione([f64; 4]),
    /// The variant of the thesis' code: a, b, a_f, b_f; doubled, and fibres that bear compression.
    ThesisCode([f64; 4]),
    /// The limit without exponential: isochoric neo-Hookean with shear modulus μ.
    NeoHookean([f64; 1]),
}

/// Axes along which a block is stretched; its other faces are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Biaxial {
    /// Along one axis (0: fibres).
    Along(usize),
    /// Alike along the first two axes.
    InPlane,
}

/// A stretched block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretched {
    /// Stretches along the three axes.
    pub stretches: [f64; 3],
    /// Cauchy stresses along them \[stress\].
    pub stress: [f64; 3],
}

/// Lateral stretches looked at; wider ones overflow the exponentials.
const WIDEST: [f64; 2] = [0.5, 2.0];

impl Fung {
    /// `F (2∂W/∂C) Fᵀ` without regard to changes of volume.
    fn extra_stress(&self, f: &Matrix) -> Matrix {
        f * self.second_piola(&(f.transpose() * f)) * f.transpose()
    }

    /// `2∂W/∂C`.
    fn second_piola(&self, c: &Matrix) -> Matrix {
        let excess = c[(0, 0)] + c[(1, 1)] + c[(2, 2)] - 3.0;
        let fibre = |a: f64, b: f64, strain: f64| 2.0 * a * strain * (b * strain * strain).exp();
        let mut s = Matrix::zeros();
        match *self {
            Self::NeoHookean([shear]) => (0..3).for_each(|i| s[(i, i)] = shear),
            Self::HolzapfelOgden([a, b, a_f, b_f]) => {
                (0..3).for_each(|i| s[(i, i)] = a * (b * excess).exp());
                s[(0, 0)] += fibre(a_f, b_f, (c[(0, 0)] - 1.0).max(0.0));
            }
            Self::ThesisCode([a, b, a_f, b_f]) => {
                (0..3).for_each(|i| s[(i, i)] = 2.0 * a * (b * excess).exp());
                s[(0, 0)] += 2.0 * fibre(a_f, b_f, c[(0, 0)] - 1.0);
            }
            Self::HolzapfelOgden2009([a, b, a_f, b_f, a_s, b_s, a_fs, b_fs]) => {
                (0..3).for_each(|i| s[(i, i)] = a * (b * excess).exp());
                s[(0, 0)] += fibre(a_f, b_f, (c[(0, 0)] - 1.0).max(0.0));
                s[(1, 1)] += fibre(a_s, b_s, (c[(1, 1)] - 1.0).max(0.0));
                // ∂I₈/∂C = ½(f⊗s + s⊗f): half of it on each side.
                let across = 0.5 * fibre(a_fs, b_fs, c[(0, 1)]);
                s[(0, 1)] += across;
                s[(1, 0)] += across;
            }
            Self::Guccione([scale, b_f, b_t, b_fs]) => {
                let weight = |i: usize, j: usize| match (i, j) {
                    (0, 0) => b_f,
                    (0, _) | (_, 0) => b_fs,
                    _ => b_t,
                };
                let strain =
                    |i: usize, j: usize| 0.5 * (c[(i, j)] - if i == j { 1.0 } else { 0.0 });
                let each = (0..9).map(|k| weight(k / 3, k % 3) * strain(k / 3, k % 3).powi(2));
                let factor = scale * each.sum::<f64>().exp();
                s = Matrix::from_fn(|i, j| factor * weight(i, j) * strain(i, j));
            }
        }
        s
    }

    /// Cauchy stress of the nearly incompressible law: the deviator of the isochoric part over J, and the
    /// volumetric part `bulk (J − 1)`, or `2 bulk (J − 1/J)` in the variant of the thesis' code.
    fn stress(&self, f: &Matrix, bulk: f64) -> Matrix {
        let volume = f.determinant();
        let extra = self.extra_stress(&(f / volume.cbrt()));
        let mean = extra.trace() / 3.0;
        let volumetric = match self {
            Self::ThesisCode(_) => 2.0 * bulk * (volume - 1.0 / volume),
            _ => bulk * (volume - 1.0),
        };
        extra / volume + Matrix::from_diagonal_element(volumetric - mean / volume)
    }

    /// Shear stress \[stress\] when planes with normal `normal` slide along `along` by `amount`:
    /// `F = I + γ e_along ⊗ e_normal`. Volume is kept, so no bulk modulus enters.
    pub fn shear_stress(&self, normal: usize, along: usize, amount: f64) -> f64 {
        let mut f = Matrix::identity();
        f[(along, normal)] = amount;
        self.extra_stress(&f)[(normal, along)]
    }

    /// A stretched block of the incompressible solid.
    ///
    /// # Errors
    /// No lateral stretch between ½ and 2 that frees the faces.
    pub fn incompressible(&self, load: Biaxial, stretch: f64) -> Result<Stretched> {
        let extra = |stretches: [f64; 3]| {
            let block = Matrix::from_diagonal(&stretches.into());
            <[f64; 3]>::from(self.extra_stress(&block).diagonal())
        };
        let (stretches, free) = match load {
            Biaxial::InPlane => ([stretch, stretch, stretch.powi(-2)], 2),
            Biaxial::Along(axis) => {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let block = |across: f64| along(axis, stretch, [across, 1.0 / (stretch * across)]);
                let gap = |across: f64| {
                    let stress = extra(block(across));
                    stress[first] - stress[second]
                };
                (block(root(gap, WIDEST)?), second)
            }
        };
        let stress = extra(stretches);
        Ok(Stretched { stretches, stress: stress.map(|s| s - stress[free]) })
    }

    /// A stretched block of the solid with a bulk modulus \[stress\].
    ///
    /// # Errors
    /// No lateral stretch between ½ and 2 that frees the faces.
    pub fn nearly_incompressible(
        &self,
        bulk: f64,
        load: Biaxial,
        stretch: f64,
    ) -> Result<Stretched> {
        let stress = |stretches: [f64; 3]| {
            let block = Matrix::from_diagonal(&stretches.into());
            <[f64; 3]>::from(self.stress(&block, bulk).diagonal())
        };
        let stretches = match load {
            Biaxial::InPlane => {
                let block = |across: f64| [stretch, stretch, across];
                block(root(|across| stress(block(across))[2], WIDEST)?)
            }
            Biaxial::Along(axis) => {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let block = |a: f64, b: f64| along(axis, stretch, [a, b]);
                let other = |a: f64| root(|b| stress(block(a, b))[second], WIDEST);
                let pull = |a: f64| other(a).map_or(f64::NAN, |b| stress(block(a, b))[first]);
                // Away from the incompressible width no other width frees both pairs of faces.
                let width = self.incompressible(load, stretch)?.stretches[first];
                let a = root(pull, [0.8 * width, 1.25 * width])?;
                block(a, other(a)?)
            }
        };
        Ok(Stretched { stretches, stress: stress(stretches) })
    }
}

/// Stretches of a block along an axis and those that follow it.
fn along(axis: usize, stretch: f64, [first, second]: [f64; 2]) -> [f64; 3] {
    let mut stretches = [stretch; 3];
    (stretches[(axis + 1) % 3], stretches[(axis + 2) % 3]) = (first, second);
    stretches
}
