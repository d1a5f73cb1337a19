//! The Holzapfel–Ogden solid behind the thesis' printed ventricle results.

use super::{fung, named};
use crate::{Guard, Invariants, ShapeEnergy};
use sinew_num::Scalar;

/// The Holzapfel–Ogden solid that the thesis' published code computes with, which differs from its eq. (3.5):
/// `Ψ = a/b(e^{b(Ī₁−3)} − 1) + a_f/b_f(e^{b_f(Ī₄−1)²} − 1) + κ(J² − 1 − 2 ln J)`, with κ = 25 kPa in
/// [`super::Compressible`].
///
/// Twice the stiffness of [`super::HolzapfelOgden`], fibres that also resist compression, and a
/// volumetric term that keeps J positive. θ = (a \[stress\], b, a_f \[stress\], b_f); the direction is
/// the fibre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HolzapfelOgdenCompressible;

impl ShapeEnergy<1> for HolzapfelOgdenCompressible {
    const NAME: &'static str = "Holzapfel-Ogden, compressible variant of the thesis' code";
    const PARAMETERS: &'static [&'static str] = &["a", "b", "a_f", "b_f"];

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 1>, guard: &G) -> S {
        let [a, b, a_f, b_f] = named(theta);
        let [[fibre]] = &i.strain;
        let fibre = guard.fibre_invariant(fibre.clone());
        let matrix = fung(a, b, guard.first_invariant(i.first.clone()), guard);
        let fibres = fung(a_f, b_f, fibre.squared(), guard);
        (matrix + fibres) * 2.0
    }
}
