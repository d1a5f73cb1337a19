//! Solids of three parts.

use sinew_energy::laws::NeoHookeanShape;
use sinew_energy::{ActiveStress, Exact, Invariants, Law};
use sinew_num::{Mat3, Scalar};

/// Holds no value, and yet is a stress.
#[derive(Clone, Debug)]
struct Swelling;

impl ActiveStress<0> for Swelling {
    const PARAMETERS: &'static [&'static str] = &[];

    fn density_of<S: Scalar>(&self, _: &[S], invariants: &Invariants<S, 0>) -> S {
        invariants.volume_change.clone() * -3.0
    }
}

#[test]
fn an_active_stress_without_values_of_its_own_counts() {
    let passive = NeoHookeanShape.nearly_incompressible(25.0);
    let active = passive.with_active(Swelling);
    let (energy, stress) = active.stress(&[2.0], &Mat3::ZERO, &[], &Exact);
    assert_eq!((energy, stress), (0.0, Mat3::from_fn(|i, j| if i == j { -3.0 } else { 0.0 })));
    assert_eq!(passive.stress(&[2.0], &Mat3::ZERO, &[], &Exact).1, Mat3::ZERO);
}
