//! The total potential energy of a body in plain arrays.

use crate::{
    Exact, Frames, Guard, Law, Magnitude, PressureLoad, PressureSurface, Spring, ThetaError,
};
use sinew_num::Mat3;

/// Total potential energy Π(u; θ) of a mesh, thesis eqs. (3.15)–(3.16), integrated by quadrature.
///
/// What Newton's method and the physics-informed objective both read. Everything is lowered to plain
/// arrays; a load that a scene does not list is an empty array. Displacements are flat,
/// `[u_x, u_y, u_z]` node by node. `N` nodes make a cell, see [`crate::Nodes`]; linear tetrahedra
/// (`N = 4`, the default) have one quadrature point each, which is exact for them.
#[derive(Clone, Debug)]
pub struct TotalPotential<L, const D: usize, G = Exact, const N: usize = 4> {
    /// The strain-energy law.
    pub law: L,
    /// What keeps the energy finite: nothing for a solver, barriers for training.
    pub guard: G,
    /// Number of nodes.
    pub nodes: usize,
    /// Reference positions of the nodes \[length\].
    pub positions: Vec<[f64; 3]>,
    /// Nodes of each cell.
    pub cells: Vec<[usize; N]>,
    /// Quadrature points of a cell. The next three arrays have one entry per point, cell by cell.
    pub points_per_cell: usize,
    /// Gradients `∂N_a/∂X_j` of the shape functions at each point [1/length].
    pub shape_gradients: Vec<[[f64; 3]; N]>,
    /// Reference volume that each point stands for \[length³\].
    pub volumes: Vec<f64>,
    /// Material directions at each point; takes no storage for isotropic laws.
    pub directions: Vec<[[f64; 3]; D]>,
    /// Quadrature points that share one volume ratio, see [`crate::Scene::lower_averaged`]: all of them in
    /// patches, or none.
    pub patches: Vec<Vec<usize>>,
    /// Dead loads lumped to the nodes [stress·length²], `3 × nodes`.
    pub nodal_force: Vec<f64>,
    /// Elastic supports lumped to the nodes.
    pub springs: Vec<Spring>,
    /// Pressures on flat triangles.
    pub pressures: Vec<PressureLoad>,
    /// Pressures on the facets of other elements.
    pub surfaces: Vec<PressureSurface>,
    /// Prescribed displacement of each degree of freedom \[length\], `None` where it is free; `3 × nodes`.
    /// Degrees of freedom are along the coordinate axes, or the axes of the node's frame if it has one.
    pub prescribed: Vec<Option<f64>>,
    /// Frames of the nodes that supports hold along other directions than the coordinate axes.
    pub frames: Frames,
}

impl<L: Law<D>, G: Guard, const D: usize, const N: usize> TotalPotential<L, D, G, N> {
    /// Nodes of the cell that a quadrature point belongs to.
    #[inline]
    pub fn nodes_of_point(&self, point: usize) -> &[usize; N] {
        &self.cells[if self.points_per_cell == 1 { point } else { point / self.points_per_cell }]
    }

    /// Displacement gradient H = ∂u/∂X at one quadrature point; for linear tetrahedra, of one cell.
    #[inline]
    pub fn displacement_gradient(&self, point: usize, displacement: &[f64]) -> Mat3<f64> {
        let (u, _) = displacement.as_chunks::<3>();
        let (nodes, shape) = (self.nodes_of_point(point), &self.shape_gradients[point]);
        let origin = u[nodes[0]];
        // The shape functions' gradients sum to zero, so only differences of u enter.
        let mut h = Mat3::ZERO;
        for a in 1..N {
            let (v, g) = (&u[nodes[a]], &shape[a]);
            for i in 0..3 {
                for j in 0..3 {
                    h.0[i][j] += (v[i] - origin[i]) * g[j];
                }
            }
        }
        h
    }

    /// Π(u; θ) [stress·length³]; +∞ where a cell is inverted or an energy overflows.
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let parameters = Self::law_parameters(theta);
        let mut total = self.load_value(displacement, theta);
        total += self.springs.iter().map(|spring| spring.value(displacement)).sum::<f64>();
        if !self.patches.is_empty() {
            return total + self.patches_value(displacement, theta);
        }
        for point in 0..self.volumes.len() {
            let h = self.displacement_gradient(point, displacement);
            total += self.volumes[point]
                * self.law.energy(parameters, &h, &self.directions[point], &self.guard);
            if total == f64::INFINITY {
                break;
            }
        }
        total
    }

    /// Potential of the loads alone, dead and pressures [stress·length³].
    pub fn load_value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let mut total = -dot(&self.nodal_force, displacement);
        for pressure in &self.pressures {
            total += pressure.value(displacement, theta);
        }
        for surface in &self.surfaces {
            total += surface.value(displacement, theta);
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
        total += if self.patches.is_empty() {
            self.points_value_and_add_gradient(displacement, theta, gradient)
        } else {
            self.patches_value_and_add_gradient(displacement, theta, gradient)
        };
        for spring in &self.springs {
            total += spring.value_and_add_gradient(displacement, gradient);
        }
        for pressure in &self.pressures {
            total += pressure.value_and_add_gradient(displacement, theta, gradient);
        }
        for surface in &self.surfaces {
            total += surface.value_and_add_gradient(displacement, theta, gradient);
        }
        total
    }

    /// Energy of all points; its derivative is added to `gradient`.
    fn points_value_and_add_gradient(
        &self,
        displacement: &[f64],
        theta: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let parameters = Self::law_parameters(theta);
        let mut total = 0.0;
        let (rows, _) = gradient.as_chunks_mut::<3>();
        for (point, &volume) in self.volumes.iter().enumerate() {
            let nodes = self.nodes_of_point(point);
            let h = self.displacement_gradient(point, displacement);
            let (energy, stress) =
                self.law.stress(parameters, &h, &self.directions[point], &self.guard);
            total += volume * energy;
            let mut sum = [0.0; 3];
            for (&node, shape) in nodes.iter().zip(&self.shape_gradients[point]).skip(1) {
                for i in 0..3 {
                    let force =
                        stress[i][0] * shape[0] + stress[i][1] * shape[1] + stress[i][2] * shape[2];
                    rows[node][i] += volume * force;
                    sum[i] += volume * force;
                }
            }
            (0..3).for_each(|i| rows[nodes[0]][i] -= sum[i]);
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
        let of_pressures = self.pressures.iter().map(|pressure| pressure.magnitude);
        let of_surfaces = self.surfaces.iter().map(|surface| surface.magnitude);
        theta_len::<L, D>(of_pressures.chain(of_surfaces))
    }

    /// Checks that θ has the right length, is finite and gives every parameter a value that makes sense.
    ///
    /// # Errors
    /// The first entry that does not.
    pub fn check_theta(&self, theta: &[f64]) -> Result<(), ThetaError> {
        check_theta::<L, D>(theta, self.theta_len())
    }

    /// Indices `3 × node + component` that no support prescribes, ascending; components of the node's frame, if
    /// it is in [`TotalPotential::frames`].
    pub fn free_degrees_of_freedom(&self) -> Vec<usize> {
        (0..self.prescribed.len()).filter(|&i| self.prescribed[i].is_none()).collect()
    }

    /// The same potential under another guard, such as [`crate::Barriers`] for training.
    pub fn with_guard<H: Guard>(self, guard: H) -> TotalPotential<L, D, H, N> {
        TotalPotential {
            law: self.law,
            guard,
            nodes: self.nodes,
            positions: self.positions,
            cells: self.cells,
            points_per_cell: self.points_per_cell,
            shape_gradients: self.shape_gradients,
            volumes: self.volumes,
            directions: self.directions,
            patches: self.patches,
            nodal_force: self.nodal_force,
            springs: self.springs,
            pressures: self.pressures,
            surfaces: self.surfaces,
            prescribed: self.prescribed,
            frames: self.frames,
        }
    }
}

/// Number of entries of θ that a law and loads of these sizes read.
pub(crate) fn theta_len<L: Law<D>, const D: usize>(
    loads: impl Iterator<Item = Magnitude>,
) -> usize {
    let ends = loads.map(|magnitude| match magnitude {
        Magnitude::Fixed(_) => 0,
        Magnitude::Theta(index) => index + 1,
    });
    ends.fold(L::PARAMETERS.len(), usize::max)
}

/// Checks θ against the bounds of a law and the number of entries that are read.
pub(crate) fn check_theta<L: Law<D>, const D: usize>(
    theta: &[f64],
    needed: usize,
) -> Result<(), ThetaError> {
    let given = theta.len();
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
