//! Neo-Hookean solid with the volume split off.

use super::named;
use crate::{Guard, Invariants, ShapeEnergy};
use sinew_num::Scalar;

/// Nearly incompressible neo-Hookean solid, `Ψ = ½μ(Ī₁ − 3) + ½P(J−1)²` with `Ī₁ = J^(−2/3) I₁`, the usual law
/// of Cook's membrane at finite strain (J. C. Simo, F. Armero, Int. J. Numer. Meth. Engng 33, 1992).
///
/// θ = (μ) \[stress\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookeanShape;

impl ShapeEnergy<0> for NeoHookeanShape {
    const NAME: &'static str = "neo-Hookean, isochoric split";
    const PARAMETERS: &'static [&'static str] = &["mu"];

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 0>, guard: &G) -> S {
        let [shear] = named(theta);
        shear.clone() * guard.first_invariant(i.first.clone()) * 0.5
    }
}
