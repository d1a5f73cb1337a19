//! Neo-Hookean solid with the volume split off.

use super::{named, volume_penalty};
use crate::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;

/// Nearly incompressible neo-Hookean solid, `Ψ = ½μ(Ī₁ − 3) + ½P(J−1)²` with `Ī₁ = J^(−2/3) I₁`, the usual law
/// of Cook's membrane at finite strain (J. C. Simo, F. Armero, Int. J. Numer. Meth. Engng 33, 1992).
///
/// θ = (μ) \[stress\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsochoricNeoHookean {
    /// P, the penalty on changes of volume \[stress\].
    pub bulk_modulus: f64,
}

impl InvariantLaw<0> for IsochoricNeoHookean {
    const NAME: &'static str = "neo-Hookean, isochoric split";
    const PARAMETERS: &'static [&'static str] = &["mu"];

    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("bulk modulus", self.bulk_modulus)]
    }

    #[inline]
    fn density_of<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        invariants: &Invariants<S, 0>,
        guard: &G,
    ) -> S {
        let [shear] = named(parameters);
        let Invariants { volume_change, first, .. } = invariants.isochoric(guard);
        let first = guard.first_invariant(first);
        shear.clone() * first * 0.5 + volume_penalty(volume_change, self.bulk_modulus)
    }
}
