//! Pressure on a surface as an energy.

use crate::lower::geometry::{add, cross, dot3};
use sinew_num::{Jet, Scalar, Slope};

/// Where the size of a load comes from.
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

/// Which potential stands for the pressure.
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

/// A pressure on facets, lowered to plain arrays. Positive pressure pushes against the solid.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureLoad {
    /// The potential that stands for it.
    pub form: PressureForm,
    /// Pressure \[stress\].
    pub magnitude: Magnitude,
    /// Nodes of each facet, counterclockwise seen from outside the solid.
    pub facets: Vec<[usize; 3]>,
    /// Reference positions of these nodes \[length\], from an origin in the planes that the rim slides in.
    pub positions: Vec<[[f64; 3]; 3]>,
}

/// Energy of one facet under unit pressure with its derivatives in the nine nodal displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetResponse {
    /// Energy per pressure \[length³\].
    pub energy: f64,
    /// First derivatives \[length²\]: component `i` of node `a` at `3a + i`.
    pub gradient: [f64; 9],
    /// Second derivatives \[length\], symmetric, in the same order.
    pub hessian: [[f64; 9]; 9],
}

impl PressureForm {
    /// Energy of one facet per unit pressure \[length³\] from the reference positions and the
    /// displacements of its nodes.
    ///
    /// The follower form is expanded in u, so nothing cancels at small displacement.
    pub(crate) fn facet_energy<S: Scalar>(
        self,
        positions: &[[S; 3]; 3],
        displacement: &[[S; 3]; 3],
    ) -> S {
        let [reference, u] = [positions, displacement];
        let current: [_; 3] = std::array::from_fn(|a| add(&reference[a], &u[a]));
        match self {
            Self::Follower => {
                let first = cross(&reference[1], &u[2]);
                let rest = cross(&u[1], &current[2]);
                let moved = dot3(&reference[0], &add(&first, &rest));
                (moved + dot3(&u[0], &cross(&current[1], &current[2]))) * (1.0 / 6.0)
            }
            Self::Thesis => {
                let [a, b] = [1, 2].map(|corner| {
                    std::array::from_fn(|i| current[corner][i].clone() - current[0][i].clone())
                });
                // Linear tetrahedra: cof(F)N dA is the area vector of the deformed facet.
                dot3(&add(&add(&u[0], &u[1]), &u[2]), &cross(&a, &b)) * (1.0 / 6.0)
            }
        }
    }
}

impl PressureLoad {
    /// Potential of the load [stress·length³].
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let volume: f64 = (0..self.facets.len())
            .map(|f| self.form.facet_energy(&self.positions[f], &self.local(f, displacement)))
            .sum();
        self.magnitude.value(theta) * volume
    }

    /// Potential of the load [stress·length³]; its gradient is added to `gradient` [stress·length²].
    pub fn value_and_add_gradient(
        &self,
        displacement: &[f64],
        theta: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let pressure = self.magnitude.value(theta);
        let mut volume = 0.0;
        for (facet, nodes) in self.facets.iter().enumerate() {
            let (energy, gradient_here) = self.facet_gradient(facet, displacement);
            volume += energy;
            for (slot, derivative) in gradient_here.iter().enumerate() {
                gradient[3 * nodes[slot / 3] + slot % 3] += pressure * derivative;
            }
        }
        pressure * volume
    }

    /// Energy, gradient and Hessian of one facet under unit pressure.
    ///
    /// The follower load's are in closed form, over thirty times faster than the jets.
    pub fn facet_response(&self, facet: usize, displacement: &[f64]) -> FacetResponse {
        match self.form {
            PressureForm::Follower => {
                let (energy, gradient) = self.facet_gradient(facet, displacement);
                let hessian = triple_product_hessian(&self.current(facet, displacement));
                FacetResponse { energy, gradient, hessian }
            }
            PressureForm::Thesis => {
                let u = seeded(&self.local(facet, displacement), Jet::<9>::variable);
                let positions = self.positions[facet].map(|x| x.map(Jet::constant));
                let Jet { value, gradient, hessian } = self.form.facet_energy(&positions, &u);
                FacetResponse { energy: value, gradient, hessian }
            }
        }
    }

    fn facet_gradient(&self, facet: usize, displacement: &[f64]) -> (f64, [f64; 9]) {
        let u = self.local(facet, displacement);
        match self.form {
            PressureForm::Follower => {
                let [a, b, c] = self.current(facet, displacement);
                let normals = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
                let gradient = std::array::from_fn(|slot| normals[slot / 3][slot % 3] / 6.0);
                (self.form.facet_energy(&self.positions[facet], &u), gradient)
            }
            PressureForm::Thesis => {
                let positions = self.positions[facet].map(|x| x.map(Slope::constant));
                let energy = self.form.facet_energy(&positions, &seeded(&u, Slope::<9>::variable));
                (energy.value, energy.gradient)
            }
        }
    }

    fn current(&self, facet: usize, displacement: &[f64]) -> [[f64; 3]; 3] {
        let u = self.local(facet, displacement);
        std::array::from_fn(|a| add(&self.positions[facet][a], &u[a]))
    }

    fn local(&self, facet: usize, displacement: &[f64]) -> [[f64; 3]; 3] {
        self.facets[facet].map(|node| std::array::from_fn(|i| displacement[3 * node + i]))
    }
}

/// Second derivatives of `x₀·(x₁×x₂)/6`: `∂²/∂x_a,i ∂x_b,j = ε_ijk x_c,k / 6` for cyclic a, b, c.
fn triple_product_hessian(corners: &[[f64; 3]; 3]) -> [[f64; 9]; 9] {
    let mut hessian = [[0.0; 9]; 9];
    for a in 0..3 {
        let (b, third) = ((a + 1) % 3, &corners[(a + 2) % 3]);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            for (column, value) in [(3 * b + j, third[k] / 6.0), (3 * b + k, -third[j] / 6.0)] {
                hessian[3 * a + i][column] = value;
                hessian[column][3 * a + i] = value;
            }
        }
    }
    hessian
}

fn seeded<S>(u: &[[f64; 3]; 3], variable: impl Fn(f64, usize) -> S) -> [[S; 3]; 3] {
    std::array::from_fn(|a| std::array::from_fn(|i| variable(u[a][i], 3 * a + i)))
}
