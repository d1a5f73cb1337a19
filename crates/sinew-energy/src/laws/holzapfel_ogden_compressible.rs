//! The Holzapfel–Ogden solid behind the thesis' printed ventricle results.

use super::{fung, named};
use crate::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;

/// The Holzapfel–Ogden solid that the thesis' published code computes with, which differs from its eq. (3.5):
/// `Ψ = a/b(e^{b(Ī₁−3)} − 1) + a_f/b_f(e^{b_f(Ī₄−1)²} − 1) + κ(J² − 1 − 2 ln J)`.
///
/// Twice the stiffness of [`super::HolzapfelOgden`], fibres that also resist compression, and a
/// volumetric term that keeps J positive. θ = (a \[stress\], b, a_f \[stress\], b_f); the direction is
/// the fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelOgdenCompressible {
    /// κ \[stress\].
    pub bulk_modulus: f64,
}

impl HolzapfelOgdenCompressible {
    /// κ = 25 kPa, the value of the thesis' code.
    pub const THESIS_KPA: Self = Self { bulk_modulus: 25.0 };
}

impl InvariantLaw<1> for HolzapfelOgdenCompressible {
    const NAME: &'static str = "Holzapfel-Ogden, compressible variant of the thesis' code";
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
        let fibre = guard.fibre_invariant(fibre);
        let matrix = fung(a, b, guard.first_invariant(first), guard);
        let fibres = fung(a_f, b_f, fibre.squared(), guard);
        // J² − 1 − 2 ln J with J² − 1 = (J − 1)(J + 1).
        let squared = volume_change.clone() * (volume_change.clone() + 2.0);
        let volume = squared - volume_change.ln_1p() * 2.0;
        (matrix + fibres) * 2.0 + volume * self.bulk_modulus
    }
}
