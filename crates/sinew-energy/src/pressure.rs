//! The size of a pressure, and the thesis' formula for it.

use crate::SurfaceResponse;
use sinew_num::{Jet, Scalar, add3, cross, dot3};

/// Source of a load's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Magnitude {
    /// A fixed size \[stress\].
    Fixed(f64),
    /// Entry of θ with this index; load parameters follow those of the law.
    Theta(usize),
}

impl Magnitude {
    /// The size of the load \[stress\].
    ///
    /// # Panics
    /// If θ is too short; [`crate::Body::check_theta`] tells.
    pub fn value(self, theta: &[f64]) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Theta(index) => theta[index],
        }
    }
}

/// Energy of the thesis' pressure on a flat triangle per unit pressure \[length³\], `−∫ t₀·u dA` with `t₀ = −p cof(F)N`, thesis eqs.
/// (3.14)–(3.16), from the reference positions and the displacements of its nodes.
///
/// It is the potential of no pressure. Its derivative equals the follower load at u = 0 only,
/// and on an inflated ventricle the load comes out about 1.3 times too large.
fn thesis_energy<S: Scalar>(reference: &[[S; 3]; 3], u: &[[S; 3]; 3]) -> S {
    let current: [_; 3] = std::array::from_fn(|a| add3(&reference[a], &u[a]));
    let [a, b] = [1, 2]
        .map(|corner| std::array::from_fn(|i| current[corner][i].clone() - current[0][i].clone()));
    dot3(&add3(&add3(&u[0], &u[1]), &u[2]), &cross(&a, &b)) * (1.0 / 6.0)
}

/// Energy, gradient and Hessian of [`thesis_energy`].
pub(crate) fn thesis_response(
    positions: &[[f64; 3]; 3],
    u: &[[f64; 3]; 3],
    response: &mut SurfaceResponse,
) {
    let seeded = |a: usize| std::array::from_fn(|i| Jet::<9>::variable(u[a][i], 3 * a + i));
    let positions = positions.map(|x| x.map(Jet::constant));
    let jet = thesis_energy(&positions, &std::array::from_fn(seeded));
    response.energy = jet.value;
    response.gradient.copy_from_slice(&jet.gradient);
    response.hessian.copy_from_slice(jet.hessian.as_flattened());
}
