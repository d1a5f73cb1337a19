//! Active tension along the fibre.

use crate::{ActiveStress, Invariants};
use sinew_num::Scalar;

/// A tension `T_a` in θ that the material makes along its fibres: the Cauchy stress `T_a/J f⊗f` with `f = F f₀`,
/// by the energy `½T_a (I₄ − 1)`, after S. Land et al., Proc. R. Soc. A 471 (2015), problem 3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActiveTension;

impl<const D: usize> ActiveStress<D> for ActiveTension {
    const PARAMETERS: &'static [&'static str] = &["T_a"];

    #[inline]
    fn density_of<S: Scalar>(&self, parameters: &[S], i: &Invariants<S, D>) -> S {
        const { assert!(D > 0, "a tension acts along the fibre of a law that reads one") };
        parameters[0].clone() * i.strain[0][0].clone() * 0.5
    }
}
