//! The laws and the parts of solids, one file each.

mod active_tension;
mod compressible;
mod elastic_constants;
mod guccione;
mod holzapfel_ogden;
mod holzapfel_ogden_2009;
mod holzapfel_ogden_compressible;
mod linear_elastic;
mod neo_hookean;
mod neo_hookean_shape;
mod penalty;
mod table;

use crate::{Guard, NearlyIncompressible, Solid};
use sinew_num::Scalar;

pub use active_tension::ActiveTension;
pub use compressible::Compressible;
use elastic_constants::lame_bounds;
pub use elastic_constants::{ByYoungPoisson, lame_from_young_poisson};
pub use guccione::Guccione;
pub use holzapfel_ogden::HolzapfelOgden;
pub use holzapfel_ogden_2009::HolzapfelOgden2009;
pub use holzapfel_ogden_compressible::HolzapfelOgdenCompressible;
pub use linear_elastic::LinearElastic;
pub use neo_hookean::NeoHookean;
pub use neo_hookean_shape::NeoHookeanShape;
pub use penalty::Penalty;
pub use table::{LAWS, LawConstants, NamedLaw, TENSION};

/// Solids of these shape energies in one call.
macro_rules! solids {
    ($($shape:ident),*) => {
        $(impl $shape {
            /// The nearly incompressible solid with the energy `½P(J−1)²`; P in the unit of stress.
            pub const fn nearly_incompressible(self, bulk_modulus: f64) -> NearlyIncompressible<Self> {
                Solid::new(self, Penalty { bulk_modulus })
            }
        })*
    };
}
solids!(Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible, NeoHookeanShape);

/// `a/(2b) (e^{b x} − 1)` with a guarded exponent.
fn fung<S: Scalar, G: Guard>(a: &S, b: &S, x: S, guard: &G) -> S {
    let exponent = guard.exponent(b.clone() * x);
    a.clone() / b.clone() * exponent.exp_m1() * 0.5
}

/// The parameters of a law by name.
///
/// # Panics
/// If the slice has another length; [`crate::Body::check_theta`] tells before any law is called.
fn named<S, const N: usize>(parameters: &[S]) -> &[S; N] {
    parameters.try_into().unwrap_or_else(|_| {
        panic!("the law reads {N} material parameters but was given {}", parameters.len())
    })
}
