//! The total potential energy of a body in plain arrays.

use crate::{Exact, Guard, Law};
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
    /// Reference volume of each tetrahedron [length³].
    pub volumes: Vec<f64>,
    /// Material directions of each tetrahedron; takes no storage for isotropic laws.
    pub directions: Vec<[[f64; 3]; D]>,
    /// Dead loads lumped to the nodes [stress·length²], `3 × nodes`.
    pub nodal_force: Vec<f64>,
    /// Prescribed displacement of each degree of freedom [length], `None` where it is free; `3 × nodes`.
    pub prescribed: Vec<Option<f64>>,
}

impl<L: Law<D>, G: Guard, const D: usize> TotalPotential<L, D, G> {
    /// Displacement gradient H = ∂u/∂X of one cell.
    pub fn displacement_gradient(&self, cell: usize, displacement: &[f64]) -> Mat3<f64> {
        let mut h = Mat3::ZERO;
        for (&node, gradient) in self.cells[cell].iter().zip(&self.shape_gradients[cell]) {
            for i in 0..3 {
                let u = displacement[3 * node + i];
                for j in 0..3 {
                    h.0[i][j] += u * gradient[j];
                }
            }
        }
        h
    }

    /// Π(u; θ) [stress·length³]; +∞ where a cell is inverted or an energy overflows.
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let mut total = -dot(&self.nodal_force, displacement);
        for cell in 0..self.cells.len() {
            let h = self.displacement_gradient(cell, displacement);
            total += self.volumes[cell]
                * self.law.energy(theta, &h, &self.directions[cell], &self.guard);
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
        let mut total = -dot(&self.nodal_force, displacement);
        gradient.iter_mut().zip(&self.nodal_force).for_each(|(g, f)| *g = -f);
        for (cell, nodes) in self.cells.iter().enumerate() {
            let h = self.displacement_gradient(cell, displacement);
            let (energy, stress) = self.law.stress(theta, &h, &self.directions[cell], &self.guard);
            let volume = self.volumes[cell];
            total += volume * energy;
            for (&node, shape) in nodes.iter().zip(&self.shape_gradients[cell]) {
                for i in 0..3 {
                    let force: f64 = (0..3).map(|j| stress[i][j] * shape[j]).sum();
                    gradient[3 * node + i] += volume * force;
                }
            }
        }
        total
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
