//! Active tension along the fibre.

use crate::{ActiveStress, Invariants};
use sinew_num::Scalar;

/// A tension `T_a` in θ that the material makes along its fibres: the Cauchy stress `T_a/J f⊗f` with `f = F f₀`,
/// by the energy `½T_a (I₄ − 1)`, after S. Land et al., Proc. R. Soc. A 471 (2015), problem 3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActiveTension;

macro_rules! along_the_fibre {
    ($($directions:literal),*) => {
        $(impl ActiveStress<$directions> for ActiveTension {
            const PARAMETERS: &'static [&'static str] = &["T_a"];

            #[inline]
            fn density_of<S: Scalar>(&self, parameters: &[S], i: &Invariants<S, $directions>) -> S {
                parameters[0].clone() * i.strain[0][0].clone() * 0.5
            }
        })*
    };
}
along_the_fibre!(1, 2, 3);
