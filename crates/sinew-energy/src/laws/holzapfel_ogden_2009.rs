//! The full, orthotropic Holzapfel–Ogden solid.

use super::{fung, named};
use crate::{Guard, Invariants, ShapeEnergy};
use sinew_num::Scalar;

/// Nearly incompressible, orthotropic Holzapfel–Ogden solid, Holzapfel & Ogden, Phil. Trans. R. Soc. A 367
/// (2009), eq. (5.38): `Ψ = a/(2b)(e^{b(Ī₁−3)} − 1) + Σ_{i=f,s} a_i/(2b_i)(e^{b_i(max(Ī₄ᵢ,1)−1)²} − 1)
/// + a_fs/(2b_fs)(e^{b_fs Ī₈²} − 1) + ½P(J−1)²` with `Ī₈ = f₀·C̄s₀`.
///
/// θ = (a, b, a_f, b_f, a_s, b_s, a_fs, b_fs), the a's \[stress\]; the directions are fibre and sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HolzapfelOgden2009;

impl ShapeEnergy<2> for HolzapfelOgden2009 {
    const NAME: &'static str = "Holzapfel-Ogden, orthotropic, 2009";
    const PARAMETERS: &'static [&'static str] =
        &["a", "b", "a_f", "b_f", "a_s", "b_s", "a_fs", "b_fs"];

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 2>, guard: &G) -> S {
        let [a, b, a_f, b_f, a_s, b_s, a_fs, b_fs] = named(theta);
        let [[fibre, shear], [_, sheet]] = &i.strain;
        let [fibre, sheet] = [fibre, sheet].map(|e| guard.fibre_invariant(e.clone()).at_least(0.0));
        fung(a, b, guard.first_invariant(i.first.clone()), guard)
            + fung(a_f, b_f, fibre.squared(), guard)
            + fung(a_s, b_s, sheet.squared(), guard)
            + fung(a_fs, b_fs, shear.clone().squared(), guard)
    }
}
