//! Compressible neo-Hookean solid.

use super::named;
use crate::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;
use std::ops::RangeInclusive;

/// Compressible neo-Hookean solid, thesis eq. (3.1):
/// `Ψ = ½λ(ln J)² − μ ln J + ½μ(I₁ − 3)`; θ = (μ, λ) \[stress\].
///
/// [`super::ByYoungPoisson`] takes Young's modulus and Poisson's ratio instead. Of the data sets published with the thesis
/// those of beams list (μ, λ) as here, those of the liver (λ, μ), those of the cube (E, ν).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

impl InvariantLaw<0> for NeoHookean {
    const NAME: &'static str = "neo-Hookean, thesis (3.1)";
    const PARAMETERS: &'static [&'static str] = &["mu", "lambda"];

    fn bounds(index: usize) -> RangeInclusive<f64> {
        super::lame_bounds(index)
    }

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 0>, guard: &G) -> S {
        let [shear, lame] = named(theta);
        let log_j = guard.volume_change(i.volume_change.clone()).ln_1p();
        let stretch = guard.first_invariant(i.first.clone());
        lame.clone() * log_j.clone().squared() * 0.5 + shear.clone() * (stretch * 0.5 - log_j)
    }
}
