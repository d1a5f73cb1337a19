//! The laws, one file each.

mod elastic_constants;
mod guccione;
mod holzapfel_ogden;
mod holzapfel_ogden_2009;
mod holzapfel_ogden_compressible;
mod isochoric_neo_hookean;
mod linear_elastic;
mod neo_hookean;
mod plane_stress;

use crate::Guard;
use sinew_num::Scalar;

use elastic_constants::lame_bounds;
pub use elastic_constants::{ByYoungPoisson, lame_from_young_poisson, young_poisson_from_lame};
pub use guccione::Guccione;
pub use holzapfel_ogden::HolzapfelOgden;
pub use holzapfel_ogden_2009::HolzapfelOgden2009;
pub use holzapfel_ogden_compressible::HolzapfelOgdenCompressible;
pub use isochoric_neo_hookean::IsochoricNeoHookean;
pub use linear_elastic::LinearElastic;
pub use neo_hookean::NeoHookean;
pub use plane_stress::PlaneStress;

/// `a/(2b) (e^{b x} − 1)` with a guarded exponent.
fn fung<S: Scalar, G: Guard>(a: &S, b: &S, x: S, guard: &G) -> S {
    let exponent = guard.exponent(b.clone() * x);
    a.clone() / b.clone() * exponent.exp_m1() * 0.5
}

/// `½P(J − 1)²`.
fn volume_penalty<S: Scalar>(volume_change: S, bulk_modulus: f64) -> S {
    volume_change.squared() * (0.5 * bulk_modulus)
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
