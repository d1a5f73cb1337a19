//! Guccione's solid.

use super::named;
use crate::{Guard, Invariants, ShapeEnergy};
use sinew_num::Scalar;

/// Nearly incompressible, transversely isotropic Guccione solid, thesis eq. (3.6), after Guccione,
/// McCulloch & Waldman, J. Biomech. Eng. 113 (1991): `Ψ = ½C(e^Q − 1) + ½P(J−1)²` with
/// `Q = b_f Ē₁₁² + b_t(Ē₂₂² + Ē₃₃² + 2Ē₂₃²) + 2b_fs(Ē₁₂² + Ē₁₃²)`, `Ē = ½(C̄ − I)`.
///
/// θ = (C \[stress\], b_f, b_t, b_fs). The directions are an orthonormal frame that starts with the
/// fibre; [`Guccione::frame`] makes one from the fibre; any such frame gives the same energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guccione;

impl Guccione {
    /// An orthonormal right-handed frame whose first vector is the unit vector `fibre`,
    /// after Duff et al., J. Comput. Graph. Tech. 6 (2017): no branch, no square root.
    pub fn frame(fibre: [f64; 3]) -> [[f64; 3]; 3] {
        let [x, y, z] = fibre;
        let sign = 1f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        let second = [1.0 + sign * x * x * a, sign * b, -sign * x];
        let third = [b, sign + y * y * a, -y];
        [fibre, second, third]
    }
}

impl ShapeEnergy<3> for Guccione {
    const NAME: &'static str = "Guccione, thesis (3.6)";
    const PARAMETERS: &'static [&'static str] = &["C", "b_f", "b_t", "b_fs"];

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 3>, guard: &G) -> S {
        let [c, b_f, b_t, b_fs] = named(theta);
        let square = |p: usize, q: usize| i.strain[p][q].clone().squared();
        let along = b_f.clone() * square(0, 0);
        let across = b_t.clone() * (square(1, 1) + square(2, 2) + square(1, 2) * 2.0);
        let shear = b_fs.clone() * (square(0, 1) + square(0, 2)) * 2.0;
        // A quarter, because Ē is half of C̄ − I.
        let exponent = guard.exponent((along + across + shear) * 0.25);
        c.clone() * exponent.exp_m1() * 0.5
    }
}
