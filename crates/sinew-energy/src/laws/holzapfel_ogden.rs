//! Transversely isotropic Holzapfel–Ogden solid.

use super::{fung, named, volume_penalty};
use crate::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;

/// Nearly incompressible, transversely isotropic Holzapfel–Ogden solid, thesis eq. (3.5), after
/// Holzapfel & Ogden, Phil. Trans. R. Soc. A 367 (2009):
/// `Ψ = a/(2b)(e^{b(Ī₁−3)} − 1) + a_f/(2b_f)(e^{b_f(max(Ī₄,1)−1)²} − 1) + ½P(J−1)²`.
///
/// θ = (a \[stress\], b, a_f \[stress\], b_f); the direction is the fibre. Fibres carry tension only:
/// at Ī₄ = 1 the stress is continuous and the tangent jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelOgden {
    /// P, the penalty on changes of volume \[stress\].
    pub bulk_modulus: f64,
}

impl InvariantLaw<1> for HolzapfelOgden {
    const NAME: &'static str = "Holzapfel-Ogden, transversely isotropic, thesis (3.5)";
    const PARAMETERS: &'static [&'static str] = &["a", "b", "a_f", "b_f"];

    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("bulk modulus", self.bulk_modulus)]
    }

    #[inline]
    fn density_of<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        invariants: &Invariants<S, 1>,
        guard: &G,
    ) -> S {
        let [a, b, a_f, b_f] = named(parameters);
        let Invariants { volume_change, first, strain: [[fibre]] } = invariants.isochoric(guard);
        let fibre = guard.fibre_invariant(fibre).at_least(0.0);
        fung(a, b, guard.first_invariant(first), guard)
            + fung(a_f, b_f, fibre.squared(), guard)
            + volume_penalty(volume_change, self.bulk_modulus)
    }
}
