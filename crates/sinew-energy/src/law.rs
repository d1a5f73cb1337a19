//! Strain-energy laws.

use crate::material::AtPoints;
use crate::{Exact, Guard, Material};
use sinew_num::{Jet, Mat3, Scalar, Slope, Taylor};
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Positive numbers whose squares neither vanish nor overflow: solvers take norms of forces.
pub(crate) const POSITIVE: RangeInclusive<f64> = 1e-100..=1e100;

/// A strain-energy density Ψ per reference volume that reads `D` material directions.
///
/// A law is one generic function of the displacement gradient H = ∂u/∂X. Isotropic laws
/// implement `Law<0>` and cannot be handed fibres; fibre laws cannot be evaluated without.
///
/// To add an objective law, implement [`crate::InvariantLaw`] instead: this trait, with fast stress and
/// tangent, comes with it. [`crate::conformance::check_law`] tests either.
///
/// # A law of one's own
///
/// The energy is enough; stress and tangent then come by differentiation. Where they take too long they may be written out
/// ([`Law::response`]), and are checked against that: the page "A law of your own" of `docs/book` does so for an exponential law.
///
/// ```
/// use sinew_energy::conformance::{Claims, check_law};
/// use sinew_energy::{Guard, Law, Mat3, Scalar};
///
/// /// `Ψ = c₁(I₁ − 3 − 2 ln J) + c₂(I₁ − 3)² + ½λ(ln J)²`
/// #[derive(Clone, Copy, Debug)]
/// struct Stiffening;
///
/// impl Law<0> for Stiffening {
///     const NAME: &'static str = "neo-Hookean solid that stiffens";
///     const PARAMETERS: &'static [&'static str] = &["c1", "c2", "lambda"];
///
///     fn density<S: Scalar, G: Guard>(&self, theta: &[S], h: &Mat3<S>, _: &[[S; 3]; 0], guard: &G) -> S {
///         let [c1, c2, lambda] = [0, 1, 2].map(|i| theta[i].clone());
///         // From H = F − I, so that small strains keep their digits.
///         let ln_j = guard.volume_change(h.volume_change()).ln_1p();
///         let i1 = guard.first_invariant(h.first_invariant_minus_three());
///         c1 * (i1.clone() - ln_j.clone() * 2.0) + c2 * i1.squared() + lambda * ln_j.squared() * 0.5
///     }
/// }
///
/// let seed = 1;
/// check_law(&Stiffening, &[1.0, 0.5, 2.0], &[], Claims::default(), seed).expect("all derivatives agree");
/// ```
#[doc(alias("constitutive law", "hyperelastic", "UMAT"))]
pub trait Law<const D: usize>: Clone + Debug + Send + Sync + 'static {
    /// Name of the law, with its source.
    const NAME: &'static str;
    /// Names of the material parameters in the order of the slices below.
    const PARAMETERS: &'static [&'static str];

    /// Values of parameter number `index` that make sense; unless a law says otherwise, positive ones whose
    /// squares neither vanish nor overflow, from 1e-100 to 1e100.
    fn bounds(_index: usize) -> RangeInclusive<f64> {
        POSITIVE
    }

    /// Names and values of the constants that the law holds itself; they must be positive and finite.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// The material of the law with its unit directions, told apart by their number in this order: one row per quadrature point of a
    /// [`crate::Body`]; one row per cell, quadrature point or node of a [`crate::Scene`].
    ///
    /// A point beyond the rows is outside the law's domain, where the energy is +∞; the solver tells it as an error.
    ///
    /// ```
    /// use sinew_energy::{Law, laws::NeoHookean};
    /// use sinew_num::Mat3;
    ///
    /// let material = NeoHookean.along(vec![]);
    /// assert_eq!(material.parameters(), ["mu", "lambda"]);
    /// assert_eq!(material.energy(0, &[1.0, 2.0], &Mat3::ZERO, None), 0.0);
    /// ```
    fn along(self, directions: Vec<[[f64; 3]; D]>) -> Arc<dyn Material> {
        Arc::new(AtPoints::new(self, directions))
    }

    /// Law with its volumetric response times a factor, if that is a constant of the law: solvers start nearly
    /// incompressible bodies from the equilibria of softer ones.
    fn with_softer_volume(&self, _factor: f64) -> Option<Self> {
        None
    }

    /// Energy density [stress unit of the parameters].
    ///
    /// `parameters` are in the order of [`Law::PARAMETERS`], `h` is the displacement gradient
    /// `∂u_i/∂X_j`, `directions` are unit vectors in the reference configuration.
    /// With [`Exact`] the caller makes sure that J > 0, see [`Law::energy`].
    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        h: &Mat3<S>,
        directions: &[[S; 3]; D],
        guard: &G,
    ) -> S;

    /// Energy density, +∞ outside the law's domain (J ≤ 0, overflow).
    fn energy<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; D],
        guard: &G,
    ) -> f64 {
        let admissible = guard.volume_change(h.volume_change()) > -1.0;
        if !admissible {
            return f64::INFINITY;
        }
        finite_or_infinite(self.density(parameters, h, directions, guard))
    }

    /// Energy density and first Piola–Kirchhoff stress `P_ij = ∂Ψ/∂H_ij`.
    ///
    /// Outside the domain the energy is +∞ and the stress zero.
    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; D],
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        // Written so that a NaN is inadmissible.
        let admissible = guard.volume_change(h.volume_change()) > -1.0;
        if !admissible {
            return (f64::INFINITY, Mat3::ZERO);
        }
        stress_by_slopes(self, parameters, h, directions, guard)
    }

    /// Energy density, stress and tangent without a guard.
    ///
    /// The default differentiates [`Law::density`] by second-order jets; a law may override it with a
    /// closed form, which [`crate::conformance`] then checks against the jets.
    fn response(&self, parameters: &[f64], h: &Mat3<f64>, directions: &[[f64; 3]; D]) -> Response {
        let admissible = h.volume_change() > -1.0;
        if !admissible {
            return Response::INADMISSIBLE;
        }
        response_by_jets(self, parameters, h, directions)
    }

    /// Change of the stress with the parameters along `rates`, one per parameter: `∂²Ψ/∂H∂θ · rates`. J must be positive.
    fn stress_rate(
        &self,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; D],
    ) -> Mat3<f64> {
        // Jets in the strain and, as the last variable, along the rates.
        let jet: Jet<10> = differentiated(self, parameters, rates, h, directions, &Exact);
        Mat3::from_fn(|i, j| jet.hessian[9][3 * i + j])
    }
}

/// The energy density in the entries of H; if rates of the parameters are given, the last variable runs along them.
fn differentiated<L: Law<D>, G: Guard, const D: usize, const N: usize, const M: usize>(
    law: &L,
    parameters: &[f64],
    rates: &[f64],
    h: &Mat3<f64>,
    directions: &[[f64; 3]; D],
    guard: &G,
) -> Taylor<N, M> {
    let mut moving: Vec<_> = parameters.iter().map(|&p| Taylor::constant(p)).collect();
    moving.iter_mut().zip(rates).for_each(|(p, &rate)| p.gradient[N - 1] = rate);
    let directions = directions.map(|d| d.map(Taylor::constant));
    law.density(&moving, &h.seeded(Taylor::variable), &directions, guard)
}

/// [`Law::stress`] by first-order Taylor numbers whatever the law overrides: the reference of closed
/// forms, and their fallback where a guard is active. J must be positive, or guarded.
pub fn stress_by_slopes<L: Law<D>, G: Guard, const D: usize>(
    law: &L,
    parameters: &[f64],
    h: &Mat3<f64>,
    directions: &[[f64; 3]; D],
    guard: &G,
) -> (f64, Mat3<f64>) {
    let slope: Slope<9> = differentiated(law, parameters, &[], h, directions, guard);
    let overflow = !slope.value.is_finite() || slope.gradient.iter().any(|x| x.is_nan());
    if overflow {
        return (f64::INFINITY, Mat3::ZERO);
    }
    (slope.value, Mat3::from_fn(|i, j| slope.gradient[3 * i + j]))
}

/// [`Law::response`] by second-order jets whatever the law overrides: the reference of closed forms.
pub fn response_by_jets<L: Law<D>, const D: usize>(
    law: &L,
    parameters: &[f64],
    h: &Mat3<f64>,
    directions: &[[f64; 3]; D],
) -> Response {
    let jet: Jet<9> = differentiated(law, parameters, &[], h, directions, &Exact);
    let mut derivatives = jet.gradient.iter().chain(jet.hessian.as_flattened());
    if !jet.value.is_finite() || derivatives.any(|x| x.is_nan()) {
        return Response::INADMISSIBLE;
    }
    Response {
        energy: jet.value,
        stress: Mat3::from_fn(|i, j| jet.gradient[3 * i + j]),
        tangent: jet.hessian,
    }
}

pub(crate) fn finite_or_infinite(energy: f64) -> f64 {
    if energy.is_nan() { f64::INFINITY } else { energy }
}

/// Energy density with its first two derivatives in H = ∂u/∂X.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Ψ; +∞ outside the domain of the law.
    pub energy: f64,
    /// First Piola–Kirchhoff stress `P_ij = ∂Ψ/∂H_ij`.
    pub stress: Mat3<f64>,
    /// Tangent `∂P_ij/∂H_kl` in row `3i + j` and column `3k + l`, symmetric.
    pub tangent: [[f64; 9]; 9],
}

impl Response {
    /// The response outside the domain of a law.
    pub const INADMISSIBLE: Self =
        Self { energy: f64::INFINITY, stress: Mat3::ZERO, tangent: [[0.0; 9]; 9] };
}
