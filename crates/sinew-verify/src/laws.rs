//! Laws that benchmarks of the literature prescribe and no scene of ours uses.

use sinew_energy::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;

/// `Ψ = ½C(e^Q − 1) + ½κ(J − 1)²` with Guccione's Q of the whole strain E, as S. Land et al. (2015) define it: the thesis'
/// [`sinew_energy::laws::Guccione`] takes the isochoric part, which differs where elements are not exactly
/// incompressible. θ = (C \[stress\], b_f, b_t, b_fs); the directions are an orthonormal frame from the fibre on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LandGuccione {
    /// κ \[stress\].
    pub bulk_modulus: f64,
}

impl InvariantLaw<3> for LandGuccione {
    const NAME: &'static str = "Guccione of the whole strain";
    const PARAMETERS: &'static [&'static str] = &["C", "b_f", "b_t", "b_fs"];

    fn density_of<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        invariants: &Invariants<S, 3>,
        guard: &G,
    ) -> S {
        let volume_change = guard.volume_change(invariants.volume_change.clone());
        let weight = |p: usize, q: usize| match (p, q) {
            (0, 0) => parameters[1].clone(),
            (0, _) | (_, 0) => parameters[3].clone(),
            _ => parameters[2].clone(),
        };
        // The invariants hold C − I = 2E.
        let term =
            |k: usize| weight(k / 3, k % 3) * invariants.strain[k / 3][k % 3].clone().squared();
        let exponent = (1..9).fold(term(0), |sum, k| sum + term(k)) * 0.25;
        parameters[0].clone() * guard.exponent(exponent).exp_m1() * 0.5
            + volume_change.squared() * (0.5 * self.bulk_modulus)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_energy::conformance::{Claims, check_law};
    use sinew_energy::laws::Guccione;
    use sinew_energy::{Exact, Law};
    use sinew_num::Mat3;

    const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn both_laws_of_guccione_agree_where_the_volume_is_kept() {
        let theta = [2.0, 8.0, 2.0, 4.0];
        let laws = (LandGuccione { bulk_modulus: 5.0 }, Guccione { bulk_modulus: 9.0 });
        check_law(&laws.0, &theta, &AXES, Claims::default(), 5).unwrap();
        // Two shears in a row: J = 1.
        let h = Mat3([[0.0, 0.3, 0.0], [0.2, 0.06, 0.0], [0.0, 0.1, 0.0]]);
        let energies =
            [laws.0.energy(&theta, &h, &AXES, &Exact), laws.1.energy(&theta, &h, &AXES, &Exact)];
        assert!((energies[0] / energies[1] - 1.0).abs() < 1e-12, "{energies:?}");
    }
}
