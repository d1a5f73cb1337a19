//! Linear isotropic elasticity.

use super::named;
use crate::law::{response_by_jets, stress_by_slopes};
use crate::{Guard, Law, Response};
use sinew_num::{Mat3, Scalar};
use std::ops::RangeInclusive;

/// Linear isotropic elasticity, thesis eq. (2.37): `Ψ = ½λ(tr ε)² + μ ε:ε` with `ε = sym ∇u`;
/// θ = (μ, λ) \[stress\].
///
/// For small displacements only: it is not objective, and does not notice inverted cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearElastic;

impl Law<0> for LinearElastic {
    const NAME: &'static str = "linear isotropic elasticity, thesis (2.37)";
    const PARAMETERS: &'static [&'static str] = &["mu", "lambda"];

    fn bounds(index: usize) -> RangeInclusive<f64> {
        super::lame_bounds(index)
    }

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        h: &Mat3<S>,
        _directions: &[[S; 3]; 0],
        _guard: &G,
    ) -> S {
        let [shear, lame] = named(parameters);
        let twice = |i, j| (h.at(i, j) + h.at(j, i)).squared();
        let diagonal = h.at(0, 0).squared() + h.at(1, 1).squared() + h.at(2, 2).squared();
        let squared = diagonal + (twice(0, 1) + twice(0, 2) + twice(1, 2)) * 0.5;
        lame.clone() * h.trace().squared() * 0.5 + shear.clone() * squared
    }

    fn energy<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
        guard: &G,
    ) -> f64 {
        let energy = self.density(parameters, h, directions, guard);
        crate::law::finite_or_infinite(energy)
    }

    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        h: &Mat3<f64>,
        directions: &[[f64; 3]; 0],
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        stress_by_slopes(self, parameters, h, directions, guard)
    }

    fn response(&self, parameters: &[f64], h: &Mat3<f64>, directions: &[[f64; 3]; 0]) -> Response {
        response_by_jets(self, parameters, h, directions)
    }
}
