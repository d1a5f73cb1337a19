//! The size of a pressure, and the thesis' formula for one.

use crate::SurfaceResponse;
use sinew_num::{add3, cross, dot3, sub3};

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

/// A flat triangle under the thesis' pressure of size one: the potential `−∫ t₀·u dA` with `t₀ = −cof(F)N`, thesis eqs. (3.14)–(3.16). On linear
/// tetrahedra `cof(F)N dA` is the area vector of the deformed facet, so that it is `n·Σu / 6`.
pub(crate) struct ThesisTriangle {
    /// Edges of the deformed triangle, each opposite to its corner.
    edges: [[f64; 3]; 3],
    /// Twice its area vector.
    normal: [f64; 3],
    /// Sum of the corners' displacements.
    motion: [f64; 3],
}

impl ThesisTriangle {
    /// A triangle by its reference positions and displacements.
    pub(crate) fn new(positions: &[[f64; 3]; 3], u: &[[f64; 3]; 3]) -> Self {
        let corner = |a: usize| add3(&positions[a % 3], &u[a % 3]);
        let edges = [0, 1, 2].map(|a| sub3(&corner(a + 2), &corner(a + 1)));
        let normal = cross(&edges[1], &edges[2]);
        Self { edges, normal, motion: add3(&add3(&u[0], &u[1]), &u[2]) }
    }

    pub(crate) fn energy(&self) -> f64 {
        dot3(&self.motion, &self.normal) / 6.0
    }

    /// Gradient of the energy and, if the response has one, its Hessian.
    pub(crate) fn respond(&self, response: &mut SurfaceResponse) {
        let Self { edges, normal, motion } = self;
        let columns = if response.has_hessian() { 3 } else { 0 };
        for a in 0..3 {
            let force = add3(normal, &cross(motion, &edges[a]));
            (0..3).for_each(|i| response.gradient[3 * a + i] = force[i] / 6.0);
            for b in 0..columns {
                let turn = [0.0, -1.0, 1.0][(3 + b - a) % 3];
                let axis = |i: usize| (edges[b][i] - edges[a][i] + turn * motion[i]) / 6.0;
                response.add_cross(a, b, std::array::from_fn(axis));
            }
        }
    }
}
