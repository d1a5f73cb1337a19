//! Plane stress.

use super::elastic_constants::at_parameters;
use super::{LinearElastic, named};
use crate::{Guard, Law, Response};
use sinew_num::{Mat3, Scalar};
use std::ops::RangeInclusive;

/// Linear isotropic elasticity of a thin plate whose faces are free of stress, for triangles; θ stays that
/// of the solid, (μ, λ) \[stress\].
///
/// A thin plate contracts freely by `ε₃₃ = −λ/(λ+2μ) (ε₁₁ + ε₂₂)`, which is equivalent to plane strain with `λ* =
/// 2λμ/(λ+2μ)` (S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, 1951, art. 15 and 16). Only linear elasticity
/// reduces in this way.
///
/// ```
/// use sinew_energy::{Exact, Law, laws::{LinearElastic, PlaneStress}};
/// use sinew_num::Mat3;
///
/// // A plate of E = 1 and ν = ⅓ (μ = ⅜, λ = ¾) stretched by ε contracts by ε/3 and bears E ε.
/// let strain = 0.01;
/// let h = Mat3([[strain, 0.0, 0.0], [0.0, -strain / 3.0, 0.0], [0.0; 3]]);
/// let (_, stress) = PlaneStress(LinearElastic).stress(&[0.375, 0.75], &h, &[], &Exact);
/// assert!((stress[0][0] - strain).abs() < 1e-15 && stress[1][1].abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneStress(pub LinearElastic);

/// `[μ, λ*]`.
fn reduced<S: Scalar>(parameters: &[S]) -> [S; 2] {
    let [shear, lame] = named(parameters);
    let twice = shear.clone() * 2.0;
    // λ may be huge or zero: λ* lies between 0 and 2μ.
    let ratio = lame.clone() / (lame.clone() + twice.clone());
    [shear.clone(), twice * ratio]
}

impl Law<0> for PlaneStress {
    const NAME: &'static str = "linear isotropic elasticity in plane stress";
    const PARAMETERS: &'static [&'static str] = LinearElastic::PARAMETERS;
    const PLANE: bool = true;

    fn bounds(index: usize) -> RangeInclusive<f64> {
        LinearElastic::bounds(index)
    }

    at_parameters!(reduced);
}
