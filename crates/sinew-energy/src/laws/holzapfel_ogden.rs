//! Transversely isotropic Holzapfel–Ogden solid.

use super::{fung, named};
use crate::{Guard, Invariants, ShapeEnergy};
use sinew_num::Scalar;

/// Transversely isotropic Holzapfel–Ogden solid, after
/// Holzapfel & Ogden, Phil. Trans. R. Soc. A 367 (2009):
/// `Ψ = a/(2b)(e^{b(Ī₁−3)} − 1) + a_f/(2b_f)(e^{b_f(max(Ī₄,1)−1)²} − 1)`;
/// with [`super::Penalty`] thesis eq. (3.5).
///
/// θ = (a \[stress\], b, a_f \[stress\], b_f); the direction is the fibre. Fibres carry tension only:
/// at Ī₄ = 1 the stress is continuous and the tangent jumps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HolzapfelOgden;

impl ShapeEnergy<1> for HolzapfelOgden {
    const NAME: &'static str = "Holzapfel-Ogden, transversely isotropic, thesis (3.5)";
    const PARAMETERS: &'static [&'static str] = &["a", "b", "a_f", "b_f"];

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 1>, guard: &G) -> S {
        let [a, b, a_f, b_f] = named(theta);
        let [[fibre]] = &i.strain;
        let fibre = guard.fibre_invariant(fibre.clone()).at_least(0.0);
        fung(a, b, guard.first_invariant(i.first.clone()), guard)
            + fung(a_f, b_f, fibre.squared(), guard)
    }
}
