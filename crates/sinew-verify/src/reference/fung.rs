//! Homogeneous states of exponential laws with fibres along the first axis and sheets along the second.

use super::{NoSignChange, root};

type Matrix = [[f64; 3]; 3];

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

/// How a block is stretched; its other faces are free.
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
        let c = product(&transposed(f), f);
        product(&product(f, &self.second_piola(&c)), &transposed(f))
    }

    /// `2∂W/∂C`.
    fn second_piola(&self, c: &Matrix) -> Matrix {
        let excess = c[0][0] + c[1][1] + c[2][2] - 3.0;
        let fibre = |a: f64, b: f64, strain: f64| 2.0 * a * strain * (b * strain * strain).exp();
        let mut s = [[0.0; 3]; 3];
        match *self {
            Self::NeoHookean([shear]) => (0..3).for_each(|i| s[i][i] = shear),
            Self::HolzapfelOgden([a, b, a_f, b_f]) => {
                (0..3).for_each(|i| s[i][i] = a * (b * excess).exp());
                s[0][0] += fibre(a_f, b_f, (c[0][0] - 1.0).max(0.0));
            }
            Self::ThesisCode([a, b, a_f, b_f]) => {
                (0..3).for_each(|i| s[i][i] = 2.0 * a * (b * excess).exp());
                s[0][0] += 2.0 * fibre(a_f, b_f, c[0][0] - 1.0);
            }
            Self::HolzapfelOgden2009([a, b, a_f, b_f, a_s, b_s, a_fs, b_fs]) => {
                (0..3).for_each(|i| s[i][i] = a * (b * excess).exp());
                s[0][0] += fibre(a_f, b_f, (c[0][0] - 1.0).max(0.0));
                s[1][1] += fibre(a_s, b_s, (c[1][1] - 1.0).max(0.0));
                // ∂I₈/∂C = ½(f⊗s + s⊗f): half of it on each side.
                let across = 0.5 * fibre(a_fs, b_fs, c[0][1]);
                s[0][1] += across;
                s[1][0] += across;
            }
            Self::Guccione([scale, b_f, b_t, b_fs]) => {
                let weight = |i: usize, j: usize| match (i, j) {
                    (0, 0) => b_f,
                    (0, _) | (_, 0) => b_fs,
                    _ => b_t,
                };
                let strain = |i: usize, j: usize| 0.5 * (c[i][j] - if i == j { 1.0 } else { 0.0 });
                let each = (0..9).map(|k| weight(k / 3, k % 3) * strain(k / 3, k % 3).powi(2));
                let factor = scale * each.sum::<f64>().exp();
                s = from_fn(|i, j| factor * weight(i, j) * strain(i, j));
            }
        }
        s
    }

    /// Cauchy stress of the nearly incompressible law: the deviator of the isochoric part over J, and the
    /// volumetric part `bulk (J − 1)`, or `2 bulk (J − 1/J)` in the variant of the thesis' code.
    fn stress(&self, f: &Matrix, bulk: f64) -> Matrix {
        let volume = determinant(f);
        let isochoric = from_fn(|i, j| f[i][j] / volume.cbrt());
        let extra = self.extra_stress(&isochoric);
        let mean = (extra[0][0] + extra[1][1] + extra[2][2]) / 3.0;
        let volumetric = match self {
            Self::ThesisCode(_) => 2.0 * bulk * (volume - 1.0 / volume),
            _ => bulk * (volume - 1.0),
        };
        from_fn(|i, j| {
            let spherical = if i == j { volumetric - mean / volume } else { 0.0 };
            extra[i][j] / volume + spherical
        })
    }

    /// Shear stress \[stress\] when planes with normal `normal` slide along `along` by `amount`:
    /// `F = I + γ e_along ⊗ e_normal`. Volume is kept, so no bulk modulus enters.
    pub fn shear_stress(&self, normal: usize, along: usize, amount: f64) -> f64 {
        let mut f = IDENTITY;
        f[along][normal] = amount;
        self.extra_stress(&f)[normal][along]
    }

    /// A stretched block of the incompressible solid.
    ///
    /// # Errors
    /// [`NoSignChange`] when no lateral stretch between ½ and 2 frees the faces.
    pub fn incompressible(&self, load: Biaxial, stretch: f64) -> Result<Stretched, NoSignChange> {
        let extra = |stretches: [f64; 3]| {
            let stress = self.extra_stress(&diagonal(stretches));
            [stress[0][0], stress[1][1], stress[2][2]]
        };
        let (stretches, free) = match load {
            Biaxial::InPlane => ([stretch, stretch, stretch.powi(-2)], 2),
            Biaxial::Along(axis) => {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let block = |across: f64| {
                    let mut stretches = [stretch; 3];
                    (stretches[first], stretches[second]) = (across, 1.0 / (stretch * across));
                    stretches
                };
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
    /// [`NoSignChange`] when no lateral stretch between ½ and 2 frees the faces.
    pub fn nearly_incompressible(
        &self,
        bulk: f64,
        load: Biaxial,
        stretch: f64,
    ) -> Result<Stretched, NoSignChange> {
        let stress = |stretches: [f64; 3]| {
            let stress = self.stress(&diagonal(stretches), bulk);
            [stress[0][0], stress[1][1], stress[2][2]]
        };
        let stretches = match load {
            Biaxial::InPlane => {
                let block = |across: f64| [stretch, stretch, across];
                block(root(|across| stress(block(across))[2], WIDEST)?)
            }
            Biaxial::Along(axis) => {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let block = |a: f64, b: f64| {
                    let mut stretches = [stretch; 3];
                    (stretches[first], stretches[second]) = (a, b);
                    stretches
                };
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

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn from_fn(entry: impl Fn(usize, usize) -> f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

fn diagonal(entries: [f64; 3]) -> Matrix {
    from_fn(|i, j| if i == j { entries[i] } else { 0.0 })
}

fn transposed(m: &Matrix) -> Matrix {
    from_fn(|i, j| m[j][i])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    from_fn(|i, j| (0..3).map(|k| a[i][k] * b[k][j]).sum())
}

fn determinant(m: &Matrix) -> f64 {
    let minor = |i: usize, j: usize, k: usize, l: usize| m[i][k] * m[j][l] - m[i][l] * m[j][k];
    m[0][0] * minor(1, 2, 1, 2) - m[0][1] * minor(1, 2, 0, 2) + m[0][2] * minor(1, 2, 0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables have twelve decimals.
    const TABLE: f64 = 2e-12;
    /// Tables of ten decimals (eight for the largest laws).
    const SHORT_TABLE: f64 = 1e-10;
    const HO: Fung = Fung::HolzapfelOgden([0.18, 2.6, 3.34, 2.73]);
    const HO_2009: Fung =
        Fung::HolzapfelOgden2009([0.059, 8.023, 18.472, 16.026, 2.481, 11.120, 0.216, 11.436]);
    const GUCCIONE: Fung = Fung::Guccione([2.0, 8.0, 2.0, 4.0]);

    #[test]
    fn stretched_holzapfel_ogden_blocks_agree_with_the_tabulated_ones() {
        let stress = |load, stretch| HO.incompressible(load, stretch).unwrap().stress;
        let along = [
            (0.85, -0.099422758186),
            (1.1, 1.972833267352),
            (1.2, 7.324166805605),
            (1.3, 28.875292217105),
        ];
        for (stretch, expected) in along {
            assert!((stress(Biaxial::Along(0), stretch)[0] - expected).abs() < TABLE * 30.0);
        }
        let across = [
            (0.85, -0.151323186669),
            (1.1, 0.058281370379),
            (1.2, 0.144100993377),
            (1.3, 0.300188620774),
        ];
        for (stretch, expected) in across {
            assert!((stress(Biaxial::Along(1), stretch)[1] - expected).abs() < TABLE);
        }
        let fibre = HO.incompressible(Biaxial::Along(1), 0.85).unwrap().stretches[0];
        assert!((fibre - 1.006138052908).abs() < TABLE);
        for (stretch, ff, ss) in
            [(1.1, 2.038543218079, 0.123991321105), (1.2, 7.622213144560, 0.442147332331)]
        {
            let found = stress(Biaxial::InPlane, stretch);
            assert!((found[0] - ff).abs() < 5.0 * TABLE && (found[1] - ss).abs() < TABLE);
        }
    }

    #[test]
    fn stretched_guccione_blocks_agree_with_the_tabulated_ones() {
        let block = |load, stretch| GUCCIONE.incompressible(load, stretch).unwrap();
        let along = [
            (0.9, -1.608516532484),
            (1.1, 2.420690731985),
            (1.2, 8.096521024812),
            (1.3, 26.467349507659),
        ];
        for (stretch, expected) in along {
            let found = block(Biaxial::Along(0), stretch).stress[0];
            assert!((found - expected).abs() < 30.0 * TABLE);
        }
        for (stretch, expected, fibre) in
            [(1.1, 0.784449588832, 0.983759939970), (1.2, 1.904770497323, 0.973816575207)]
        {
            let found = block(Biaxial::Along(1), stretch);
            assert!((found.stress[1] - expected).abs() < TABLE, "{found:?}");
            assert!((found.stretches[0] - fibre).abs() < TABLE, "{found:?}");
        }
        for (stretch, ff, ss) in
            [(1.1, 2.895076283352, 1.105064298440), (1.2, 10.330466112587, 3.277466777113)]
        {
            let found = block(Biaxial::InPlane, stretch).stress;
            assert!((found[0] - ff).abs() < 10.0 * TABLE && (found[1] - ss).abs() < 5.0 * TABLE);
        }
    }

    #[test]
    fn shear_stresses_agree_with_the_tabulated_ones() {
        let check = |law: Fung, normal, along, table: [f64; 5], tolerance: f64| {
            for (step, expected) in table.into_iter().enumerate() {
                let found = law.shear_stress(normal, along, 0.1 * (step + 1) as f64);
                assert!((found - expected).abs() < tolerance, "{normal}{along} {found} {expected}");
            }
        };
        let fs = [0.0251559610, 0.0936195528, 0.2526295267, 0.5676111290, 1.1627469998];
        let rest = [0.0184741371, 0.0399456164, 0.0682368026, 0.1091437826, 0.1723986746];
        for (normal, along) in [(0, 1), (0, 2)] {
            check(HO, normal, along, fs, SHORT_TABLE);
        }
        for (normal, along) in [(1, 0), (1, 2), (2, 0), (2, 1)] {
            check(HO, normal, along, rest, SHORT_TABLE);
        }
        let table = [
            (0, 1, [0.06761308, 0.38775052, 1.35356250, 4.18736266, 14.67663487]),
            (0, 2, [0.04339612, 0.31949349, 1.17219133, 3.64888410, 12.79267487]),
            (1, 0, [0.03557735, 0.12493069, 0.36441145, 1.04582357, 3.34599469]),
            (1, 2, [0.01136038, 0.05667366, 0.18304028, 0.50734501, 1.46203469]),
            (2, 0, [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
            (2, 1, [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
        ];
        for (normal, along, values) in table {
            check(HO_2009, normal, along, values, 100.0 * SHORT_TABLE);
        }
        let fs = [0.4163254035, 0.9389598958, 1.7229466528, 3.0612868471, 5.6047378723];
        let sf = [0.4101414453, 0.8846697000, 1.5074032104, 2.4103324171, 3.8273789292];
        let sn = [0.2040403355, 0.4333238025, 0.7184939976, 1.1030471140, 1.6559809484];
        check(GUCCIONE, 0, 1, fs, SHORT_TABLE);
        check(GUCCIONE, 1, 0, sf, SHORT_TABLE);
        check(GUCCIONE, 1, 2, sn, SHORT_TABLE);
    }

    #[test]
    fn a_stiff_bulk_is_almost_incompressible() {
        for law in [HO, GUCCIONE] {
            for load in [Biaxial::Along(0), Biaxial::Along(1), Biaxial::InPlane] {
                let limit = law.incompressible(load, 1.2).unwrap();
                let found = law.nearly_incompressible(1e7, load, 1.2).unwrap();
                for i in 0..3 {
                    assert!((found.stretches[i] - limit.stretches[i]).abs() < 1e-5, "{found:?}");
                    assert!((found.stress[i] - limit.stress[i]).abs() < 1e-3, "{found:?}");
                }
            }
        }
    }
}
