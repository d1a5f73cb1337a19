//! Changes of stress with the parameters.

use sinew_energy::laws::{ActiveTension, Guccione, HolzapfelOgden, NeoHookean};
use sinew_energy::{Guard, Law, Mat3, Scalar};

/// A law by its energy alone, so that its rates are differentiated in the strain.
#[derive(Clone, Debug)]
struct ByStrain<L>(L);

impl<L: Law<D>, const D: usize> Law<D> for ByStrain<L> {
    const NAME: &'static str = L::NAME;
    const PARAMETERS: &'static [&'static str] = L::PARAMETERS;

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        displacement_gradient: &Mat3<S>,
        directions: &[[S; 3]; D],
        guard: &G,
    ) -> S {
        self.0.density(parameters, displacement_gradient, directions, guard)
    }
}

/// Compares the stress rate by invariants with that by the strain; they differ by rounding errors only.
fn check<L: Law<D>, const D: usize>(law: L, parameters: &[f64], frame: [[f64; 3]; D]) {
    let h = Mat3([[0.1, 0.02, -0.05], [0.03, -0.08, 0.04], [0.06, -0.01, 0.07]]);
    let plain = ByStrain(law.clone());
    for index in 0..parameters.len() {
        let rates: Vec<_> =
            (0..parameters.len()).map(|i| f64::from(u8::from(i == index))).collect();
        let found = law.stress_rate(parameters, &rates, &h, &frame);
        let expected = plain.stress_rate(parameters, &rates, &h, &frame);
        let size = expected.squared_norm().sqrt();
        let off = Mat3::from_fn(|i, j| found[i][j] - expected[i][j]).squared_norm().sqrt();
        assert!(size > 0.0 && off <= 1e-13 * size, "{} {index}: {off:e} of {size}", L::NAME);
    }
}

#[test]
fn rates_of_stress_are_the_same_by_invariants_and_by_the_strain() {
    check(NeoHookean, &[3.0, 5.0], []);
    let fibre = [0.6, 0.0, 0.8];
    let active = HolzapfelOgden.nearly_incompressible(25.0).with_active(ActiveTension);
    check(active, &[0.2, 2.0, 2.8, 2.1, 30.0], [fibre]);
    let guccione = Guccione.nearly_incompressible(25.0);
    check(guccione, &[2.0, 8.0, 2.0, 4.0], [fibre, [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]]);
}
