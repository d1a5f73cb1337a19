//! Laws that benchmarks of the literature prescribe and no scene of ours uses.

use sinew_energy::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;

/// `Ψ = ½μ(J^(−2/3) I₁ − 3) + ½κ(J − 1)²`, the law of Cook's membrane at finite strain; θ = (μ) \[stress\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IsochoricNeoHookean {
    /// κ \[stress\].
    pub bulk_modulus: f64,
}

impl InvariantLaw<0> for IsochoricNeoHookean {
    const NAME: &'static str = "isochoric neo-Hookean";
    const PARAMETERS: &'static [&'static str] = &["mu"];

    fn density_of<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        invariants: &Invariants<S, 0>,
        guard: &G,
    ) -> S {
        let Invariants { volume_change, first, .. } = invariants.isochoric(guard);
        let stretch = guard.first_invariant(first);
        parameters[0].clone() * stretch * 0.5 + volume_change.squared() * (0.5 * self.bulk_modulus)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_energy::conformance::{Claims, check_law};

    #[test]
    fn the_law_conforms() {
        let law = IsochoricNeoHookean { bulk_modulus: 30.0 };
        assert_eq!(check_law(&law, &[2.0], &[], Claims::default(), 5), Ok(()));
    }
}
