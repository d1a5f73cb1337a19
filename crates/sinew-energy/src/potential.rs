//! The total potential energy of a body in plain arrays.

use crate::{Exact, Guard, Law, Magnitude, PressureLoad, ThetaError};
use sinew_num::Mat3;

/// Total potential energy Π(u; θ) of a tetrahedral mesh, thesis eqs. (3.15)–(3.16), with one
/// quadrature point per tetrahedron (exact for linear tetrahedra).
///
/// What Newton's method and the physics-informed objective both read. Everything is lowered to plain
/// arrays; a load that a scene does not list is an empty array. Displacements are flat,
/// `[u_x, u_y, u_z]` node by node.
#[derive(Clone, Debug)]
pub struct TotalPotential<L, const D: usize, G = Exact> {
    /// The strain-energy law.
    pub law: L,
    /// What keeps the energy finite: nothing for a solver, barriers for training.
    pub guard: G,
    /// Number of nodes.
    pub nodes: usize,
    /// Nodes of each tetrahedron.
    pub cells: Vec<[usize; 4]>,
    /// Gradients `∂N_a/∂X_j` of the four shape functions of each tetrahedron [1/length].
    pub shape_gradients: Vec<[[f64; 3]; 4]>,
    /// Reference volume of each tetrahedron \[length³\].
    pub volumes: Vec<f64>,
    /// Material directions of each tetrahedron; takes no storage for isotropic laws.
    pub directions: Vec<[[f64; 3]; D]>,
    /// Dead loads lumped to the nodes [stress·length²], `3 × nodes`.
    pub nodal_force: Vec<f64>,
    /// Pressures on the surface.
    pub pressures: Vec<PressureLoad>,
    /// Prescribed displacement of each degree of freedom \[length\], `None` where it is free; `3 × nodes`.
    pub prescribed: Vec<Option<f64>>,
}

impl<L: Law<D>, G: Guard, const D: usize> TotalPotential<L, D, G> {
    /// Displacement gradient H = ∂u/∂X of one cell.
    #[inline]
    pub fn displacement_gradient(&self, cell: usize, displacement: &[f64]) -> Mat3<f64> {
        let (u, _) = displacement.as_chunks::<3>();
        let [o, a, b, c] = self.cells[cell].map(|node| u[node]);
        let [_, p, q, r] = &self.shape_gradients[cell];
        // The shape functions' gradients sum to zero, so only differences of u enter.
        Mat3::from_fn(|i, j| (a[i] - o[i]) * p[j] + (b[i] - o[i]) * q[j] + (c[i] - o[i]) * r[j])
    }

    /// Π(u; θ) [stress·length³]; +∞ where a cell is inverted or an energy overflows.
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let parameters = Self::law_parameters(theta);
        let mut total = -dot(&self.nodal_force, displacement);
        for cell in 0..self.cells.len() {
            let h = self.displacement_gradient(cell, displacement);
            total += self.volumes[cell]
                * self.law.energy(parameters, &h, &self.directions[cell], &self.guard);
        }
        for pressure in &self.pressures {
            total += pressure.value(displacement, theta);
        }
        total
    }

    /// Π(u; θ), and its gradient (internal minus external nodal forces) written to `gradient`.
    ///
    /// The gradient covers all degrees of freedom; at prescribed ones it is the reaction force.
    pub fn value_and_gradient(
        &self,
        displacement: &[f64],
        theta: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let parameters = Self::law_parameters(theta);
        let mut total = -dot(&self.nodal_force, displacement);
        gradient.iter_mut().zip(&self.nodal_force).for_each(|(g, f)| *g = -f);
        let (rows, _) = gradient.as_chunks_mut::<3>();
        for (cell, nodes) in self.cells.iter().enumerate() {
            let h = self.displacement_gradient(cell, displacement);
            let (energy, stress) =
                self.law.stress(parameters, &h, &self.directions[cell], &self.guard);
            let volume = self.volumes[cell];
            total += volume * energy;
            let mut sum = [0.0; 3];
            for (&node, shape) in nodes.iter().zip(&self.shape_gradients[cell]).skip(1) {
                for i in 0..3 {
                    let force =
                        stress[i][0] * shape[0] + stress[i][1] * shape[1] + stress[i][2] * shape[2];
                    rows[node][i] += volume * force;
                    sum[i] += volume * force;
                }
            }
            (0..3).for_each(|i| rows[nodes[0]][i] -= sum[i]);
        }
        for pressure in &self.pressures {
            total += pressure.value_and_add_gradient(displacement, theta, gradient);
        }
        total
    }

    /// The part of θ that the law reads.
    ///
    /// # Panics
    /// If θ is too short; [`TotalPotential::check_theta`] tells.
    pub fn law_parameters(theta: &[f64]) -> &[f64] {
        &theta[..L::PARAMETERS.len()]
    }

    /// Number of entries of θ that law and loads read.
    pub fn theta_len(&self) -> usize {
        let loads = self.pressures.iter().map(|pressure| match pressure.magnitude {
            Magnitude::Fixed(_) => 0,
            Magnitude::Theta(index) => index + 1,
        });
        loads.fold(L::PARAMETERS.len(), usize::max)
    }

    /// Checks that θ has the right length, is finite and gives every parameter a value that makes sense.
    ///
    /// # Errors
    /// The first entry that does not.
    pub fn check_theta(&self, theta: &[f64]) -> Result<(), ThetaError> {
        let (given, needed) = (theta.len(), self.theta_len());
        if given != needed {
            return Err(ThetaError::Length { given, needed, names: L::PARAMETERS });
        }
        for (index, &value) in theta.iter().enumerate() {
            let load = (&"a load", f64::MIN..=f64::MAX);
            let (&name, bounds) =
                L::PARAMETERS.get(index).map_or(load, |name| (name, L::bounds(index)));
            if !bounds.contains(&value) {
                let (least, most) = (*bounds.start(), *bounds.end());
                return Err(ThetaError::OutOfBounds { index, name, value, least, most });
            }
        }
        Ok(())
    }

    /// Indices `3 × node + component` that no support prescribes, ascending.
    pub fn free_degrees_of_freedom(&self) -> Vec<usize> {
        (0..self.prescribed.len()).filter(|&i| self.prescribed[i].is_none()).collect()
    }

    /// The same potential under another guard, such as [`crate::Barriers`] for training.
    pub fn with_guard<H: Guard>(self, guard: H) -> TotalPotential<L, D, H> {
        TotalPotential {
            law: self.law,
            guard,
            nodes: self.nodes,
            cells: self.cells,
            shape_gradients: self.shape_gradients,
            volumes: self.volumes,
            directions: self.directions,
            nodal_force: self.nodal_force,
            pressures: self.pressures,
            prescribed: self.prescribed,
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
