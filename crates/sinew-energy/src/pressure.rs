//! The size of a pressure, and its energy on flat triangles in closed form.

use crate::SurfaceResponse;
use sinew_num::{Mat3, Scalar, Taylor, add3, cross, dot3};

/// Vectors at the corners of a triangle.
type Corners<S> = [[S; 3]; 3];

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

/// Potential of the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PressureForm {
    /// `p (V(u) − V(0))` with the volume V that the surface encloses, counted along the outward
    /// normal of the solid: the potential of a true follower load, provided that the rim of the
    /// surface is held.
    Follower,
    /// `−∫ t₀·u dA` with `t₀ = −p cof(F)N`, thesis eqs. (3.14)–(3.16): the thesis' formula.
    ///
    /// It is the potential of no pressure. Its derivative equals the follower load at u = 0 only,
    /// and on an inflated ventricle the load comes out about 1.3 times too large.
    Thesis,
}

impl PressureForm {
    /// Energy of one facet per unit pressure \[length³\] from the reference positions and the
    /// displacements of its nodes.
    ///
    /// The follower form is expanded in u, so nothing cancels at small displacement.
    pub(crate) fn facet_energy<S: Scalar>(self, reference: &Corners<S>, u: &Corners<S>) -> S {
        let current: [_; 3] = std::array::from_fn(|a| add3(&reference[a], &u[a]));
        match self {
            Self::Follower => {
                let first = cross(&reference[1], &u[2]);
                let rest = cross(&u[1], &current[2]);
                let moved = dot3(&reference[0], &add3(&first, &rest));
                (moved + dot3(&u[0], &cross(&current[1], &current[2]))) * (1.0 / 6.0)
            }
            Self::Thesis => {
                let [a, b] = [1, 2].map(|corner| {
                    std::array::from_fn(|i| current[corner][i].clone() - current[0][i].clone())
                });
                // Linear tetrahedra: cof(F)N dA is the area vector of the deformed facet.
                dot3(&add3(&add3(&u[0], &u[1]), &u[2]), &cross(&a, &b)) * (1.0 / 6.0)
            }
        }
    }

    /// Gradient and, if the response has one, Hessian of the energy of one facet under unit pressure.
    ///
    /// The follower load's are in closed form, over thirty times faster than the jets.
    pub(crate) fn respond(
        self,
        positions: &Corners<f64>,
        u: &Corners<f64>,
        response: &mut SurfaceResponse,
    ) {
        match self {
            Self::Follower => {
                let corners = std::array::from_fn(|a| add3(&positions[a], &u[a]));
                let [a, b, c] = &corners;
                let normals = [cross(b, c), cross(c, a), cross(a, b)];
                let areas = normals.as_flattened().iter().map(|n| n / 6.0);
                response.gradient.iter_mut().zip(areas).for_each(|(g, area)| *g = area);
                // Of x₀·(x₁×x₂)/6: `∂²/∂x_a,i ∂x_b,j = ε_ijk x_c,k / 6` for cyclic a, b, c.
                if response.has_hessian() {
                    for a in 0..3 {
                        let (b, axis) = ((a + 1) % 3, corners[(a + 2) % 3].map(|x| x / 6.0));
                        response.add_cross(a, b, axis.map(|x| -x));
                        response.add_cross(b, a, axis);
                    }
                }
            }
            Self::Thesis if response.has_hessian() => {
                self.differentiate::<9>(positions, u, response)
            }
            Self::Thesis => self.differentiate::<0>(positions, u, response),
        }
    }

    /// Gradient and `M` rows of the Hessian of the energy of one facet.
    fn differentiate<const M: usize>(
        self,
        positions: &Corners<f64>,
        u: &Corners<f64>,
        response: &mut SurfaceResponse,
    ) {
        let positions = positions.map(|x| x.map(Taylor::constant));
        let u = Mat3(*u).seeded(Taylor::variable);
        let energy: Taylor<9, M> = self.facet_energy(&positions, &u.0);
        response.gradient.copy_from_slice(&energy.gradient);
        response.hessian.copy_from_slice(energy.hessian.as_flattened());
    }
}
