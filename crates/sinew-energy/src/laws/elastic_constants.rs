//! Elastic constants of isotropic solids.

use crate::law::POSITIVE;
use crate::{Guard, Law, Response};
use sinew_num::{Mat3, Scalar};
use std::ops::RangeInclusive;

/// Lamé's parameters `[μ, λ]` \[stress\] from Young's modulus `E` \[stress\] and Poisson's ratio `ν`,
/// thesis eq. (3.2): `λ = Eν/((1+ν)(1−2ν))`, `μ = E/(2(1+ν))`.
pub fn lame_from_young_poisson<S: Scalar>(young: S, poisson: S) -> [S; 2] {
    let shear = young / ((poisson.clone() + 1.0) * 2.0);
    let lame = shear.clone() * poisson.clone() * 2.0 / (poisson * -2.0 + 1.0);
    [shear, lame]
}

/// Bounds of (μ, λ): a shear modulus is positive, and λ may vanish.
pub(super) fn lame_bounds(index: usize) -> RangeInclusive<f64> {
    let least = if index == 0 { *POSITIVE.start() } else { 0.0 };
    least..=*POSITIVE.end()
}

/// An isotropic law in Young's modulus and Poisson's ratio: θ = (E \[stress\], ν).
///
/// The law inside must read Lamé's parameters (μ, λ), such as [`super::NeoHookean`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByYoungPoisson<L>(pub L);

impl<L: Law<0>> Law<0> for ByYoungPoisson<L> {
    const NAME: &'static str = L::NAME;
    const PARAMETERS: &'static [&'static str] = &["E", "nu"];

    fn bounds(index: usize) -> RangeInclusive<f64> {
        match index {
            0 => POSITIVE,
            // Open ends: at ½ the solid is incompressible and λ infinite; below 0 λ is negative.
            _ => 0.0..=0.5 - f64::EPSILON,
        }
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.0.constants()
    }

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        h: &Mat3<S>,
        directions: &[[S; 3]; 0],
        guard: &G,
    ) -> S {
        self.0.density(&lame(parameters), h, directions, guard)
    }

    fn energy<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
        guard: &G,
    ) -> f64 {
        self.0.energy(&lame(parameters), h, directions, guard)
    }

    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        self.0.stress(&lame(parameters), h, directions, guard)
    }

    fn response(&self, parameters: &[f64], h: &Mat3<f64>, directions: &[[f64; 3]; 0]) -> Response {
        self.0.response(&lame(parameters), h, directions)
    }
}

fn lame<S: Scalar>(parameters: &[S]) -> [S; 2] {
    let [young, poisson] = super::named(parameters);
    lame_from_young_poisson(young.clone(), poisson.clone())
}
