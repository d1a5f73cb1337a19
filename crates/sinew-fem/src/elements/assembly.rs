//! Energy, nodal forces and stiffness of a body.

use crate::elements::{
    PatchResponse, PointState, PredictedStress, Rounding, State, Task, tangent_times, worst_cells,
};
use crate::linear::{Sparsity, facets_of, norm};
use crate::{CellValue, Result, SolveError};
use sinew_energy::{Body, SurfaceResponse};
use sinew_num::{Mat3, sum};

/// Π and its derivatives at one displacement, with bounds of their rounding errors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Assembly {
    /// Π \[stress·length³\]; +∞ where a cell is inverted.
    pub energy: f64,
    /// Bound on the rounding error in Π \[stress·length³\].
    pub energy_noise: f64,
    /// Derivative of Π in every degree of freedom; at prescribed ones it is the reaction.
    pub gradient: Vec<f64>,
    /// Displacement of the last assembly \[length\].
    pub displacement: Vec<f64>,
    /// Norm of loads and reactions \[stress·length²\], plus that of the stress at rest where they are only rounding
    /// errors.
    pub force_scale: f64,
    /// Estimate of the rounding error in the norm of the gradient \[stress·length²\].
    pub floor: f64,
    /// Lower half of the second derivative, with one more slot for entries of prescribed degrees of freedom.
    pub matrix: Vec<f64>,
    /// Least volume ratio J.
    pub least_volume_ratio: f64,
    /// The cell that has it.
    pub worst_cell: usize,
    /// Displacement gradient, stress and tangent at each quadrature point.
    pub(crate) points: Vec<PointState>,
    /// Shared quantities of the points of each patch, if there are patches.
    pub(crate) patches: Vec<PatchResponse>,
    /// Whether the bulk modulus acts as a constraint on J.
    pub(crate) nearly_incompressible: bool,
    /// Number of tangents that lost negative eigenvalues, where they shall.
    pub(crate) convex: Option<usize>,
}

/// Number of roundings in a term of the energy, a dozen, rounded up.
const ENERGY_ROUNDINGS: f64 = 16.0;
/// Residual at equilibrium as a multiple of the estimated rounding error: measured residuals are 0.9–1.6 of it.
const FLOOR_FACTOR: f64 = 4.0;
/// Largest residual of rounding errors \[relative to that multiple\]. The rounding error in the displacement of a node acts in all of its cells at once, some 20
/// tetrahedra, whose forces the estimate adds up as if they were independent: at most √20 times as much.
const COHERENT: f64 = 4.0;
/// Largest residual of an equilibrium \[relative to loads and reactions\], whatever the rounding errors are.
const MOST_LEFT: f64 = 1e-6;
/// Least strain of a body that is not at rest.
const STRAINED: f64 = 1e-6;

/// Norm of the nodal forces of the stress at rest \[stress·length²\]: the force scale of a muscle that contracts
/// freely, where loads and reactions are zero. Only active stress gives forces at rest.
fn forces_at_rest(body: &Body, theta: &[f64]) -> f64 {
    let parameters = body.law_parameters(theta);
    let law = |point: usize, _: &Mat3<f64>| {
        Some(body.material.stress(point, parameters, &Mat3::ZERO, None))
    };
    let (rest, mut forces) = (vec![0.0; 3 * body.nodes], vec![0.0; 3 * body.nodes]);
    body.add_stress_forces(&rest, law, &mut forces);
    norm(&forces)
}

impl Assembly {
    pub(crate) fn new(sparsity: &Sparsity, body: &Body) -> Self {
        let zeros = vec![0.0; body.prescribed.len()];
        Self {
            gradient: zeros.clone(),
            displacement: zeros,
            matrix: vec![0.0; sparsity.entries() + 1],
            least_volume_ratio: 1.0,
            points: vec![PointState::EMPTY; body.volumes.len()],
            ..Self::default()
        }
    }

    /// Evaluates everything at `displacement`, under the fraction `load_factor` of the loads.
    ///
    /// `predicted` replaces the stress in the stiffness, see [`crate::elements::predicted`].
    pub(crate) fn assemble(
        &mut self,
        body: &Body,
        sparsity: &Sparsity,
        state: State,
        predicted: Option<&PredictedStress>,
    ) {
        let State { displacement, load_factor, .. } = state;
        self.displacement.copy_from_slice(displacement);
        self.matrix.fill(0.0);
        let work: f64 = displacement.iter().zip(&body.nodal_force).map(|(u, f)| u * f).sum();
        self.energy = -load_factor * work;
        let mut rounding = Rounding { energy: self.energy.abs(), ..Rounding::default() };
        self.gradient.iter_mut().zip(&body.nodal_force).for_each(|(g, f)| *g = -load_factor * f);
        let mut loads = norm(&self.gradient);
        let (mut first_facet, mut response) = (0, SurfaceResponse::default());
        for surface in &body.pressures {
            let magnitude = load_factor * surface.magnitude.value(state.theta);
            for facet in 0..surface.facets() {
                surface.facet_response(facet, displacement, &mut response);
                let energy = magnitude * response.energy;
                self.energy += energy;
                rounding.energy += energy.abs();
                let (nodes, place) = (surface.facet_nodes(facet), first_facet + facet);
                let force = self.add_facet(nodes, sparsity, place, magnitude, &response);
                loads = loads.hypot(force);
            }
            first_facet += surface.facets();
        }
        for (index, spring) in body.springs.iter().enumerate() {
            let energy = spring.value_and_add_gradient(displacement, &mut self.gradient);
            self.energy += energy;
            rounding.energy += energy;
            let (places, size) = (sparsity.springs.of(index), 3 * spring.nodes.len());
            let entry = |row: usize, column: usize| spring.stiffness[row * size + column];
            self.add_matrix(&sparsity.frames, &spring.nodes, places, entry);
        }
        self.add_shares(body, sparsity, (state, predicted), &mut rounding);
        self.floor = f64::EPSILON * norm(&rounding.forces);
        self.energy_noise = ENERGY_ROUNDINGS * f64::EPSILON * rounding.energy;
        let held = body.prescribed.iter().enumerate().filter(|(_, p)| p.is_some());
        let reactions = held.map(|(dof, _)| sparsity.frames.component(dof, &self.gradient));
        self.force_scale = loads + reactions.fold(0.0, f64::hypot);
        if FLOOR_FACTOR * self.floor > MOST_LEFT * self.force_scale {
            self.force_scale += forces_at_rest(body, state.theta);
        }
    }

    /// Whether energy, force scale and rounding errors are finite.
    pub(crate) fn is_finite(&self) -> bool {
        [self.energy, self.energy_noise, self.floor, self.force_scale].iter().all(|x| x.is_finite())
    }

    /// Requires that these are.
    pub(crate) fn check(&self) -> Result<()> {
        let cell = self.worst_cell;
        if self.is_finite() { Ok(()) } else { Err(SolveError::Inadmissible { cell }) }
    }

    /// Residual at which an equilibrium is reached \[stress·length²\]: the rounding error, but at most [`MOST_LEFT`] of
    /// the forces in a strained body. Forces on a body at rest may be rounding errors only.
    pub(crate) fn tolerance(&self) -> f64 {
        let (floor, most) = (FLOOR_FACTOR * self.floor, MOST_LEFT * self.force_scale);
        if floor <= most || !self.is_strained() { floor } else { most }
    }

    /// Whether a residual may consist of rounding errors alone: that of a search that can go no further.
    pub(crate) fn is_nearly_balanced(&self, force: f64) -> bool {
        force <= (COHERENT * self.tolerance()).min(MOST_LEFT * self.force_scale)
    }

    fn is_strained(&self) -> bool {
        let strained = |h: &Mat3<f64>| {
            let twice = |i: usize, j: usize| {
                h[i][j] + h[j][i] + (0..3).map(|k| h[k][i] * h[k][j]).sum::<f64>()
            };
            (0..9).any(|entry| twice(entry / 3, entry % 3).abs() > 2.0 * STRAINED)
        };
        self.displacement_gradients().any(strained)
    }

    /// Adds cells or patches, share by share.
    fn add_shares(
        &mut self,
        body: &Body,
        sparsity: &Sparsity,
        (state, predicted): (State, Option<&PredictedStress>),
        rounding: &mut Rounding,
    ) {
        let Self { points, gradient, matrix, patches, .. } = self;
        let (mut least, mut energies, mut convex) = ((f64::INFINITY, 0), vec![], 0);
        patches.clear();
        // Gradients of all points first: a patch with an inverted cell ends the assembly, and its cell must be among
        // the worst.
        let (count, patched) = (points.len(), !body.patches.is_empty());
        let averaged = if patched { count } else { 0 };
        for (point, PointState { h, .. }) in points[..averaged].iter_mut().enumerate() {
            *h = body.displacement_gradient(point, state.displacement);
            let ratio = 1.0 + h.volume_change();
            if ratio < least.0 {
                least = (ratio, point / body.points_per_cell);
            }
        }
        let (of_cells, of_patches) = points.split_at_mut(count - averaged);
        let task = Task {
            body,
            state,
            predicted,
            nearly_incompressible: self.nearly_incompressible,
            convex: self.convex.is_some(),
        };
        task.run(of_cells, |share| {
            energies.push(share.energy);
            rounding.energy += share.rounding.energy;
            rounding.forces.push(norm(&share.rounding.forces));
            least = share.least.filter(|of_share| of_share.0 < least.0).unwrap_or(least);
            convex += share.convex;
            let (parts, size) = (share.parts.clone(), body.nodes_per_cell);
            let nodes: Vec<usize> = match body.patches.get(parts.clone()) {
                Some(of_share) => {
                    let points = of_share.iter().flatten();
                    points.flat_map(|&point| body.nodes_of_point(point)).copied().collect()
                }
                None => body.cells[parts.start * size..parts.end * size].to_vec(),
            };
            let (rows, _) = gradient.as_chunks_mut::<3>();
            for (node, force) in nodes.into_iter().zip(&share.forces) {
                (0..3).for_each(|i| rows[node][i] += force[i]);
            }
            for (&place, value) in sparsity.cells.range(parts.clone()).iter().zip(&share.lower) {
                matrix[place as usize] += value;
            }
            // None after an inverted cell.
            if patched && patches.len() == parts.start {
                for (of_patch, (patch, of_law)) in
                    body.patches[parts].iter().zip(share.patches.drain(..))
                {
                    of_patch.iter().zip(of_law).for_each(|(&point, law)| of_patches[point] = law);
                    patches.push(patch);
                }
            }
        });
        self.energy += sum(&energies);
        (self.least_volume_ratio, self.worst_cell) = least;
        self.convex = self.convex.map(|_| convex);
    }

    /// Adds forces and the lower half of their derivative on one facet, counted over all pressures; returns the forces'
    /// norm.
    pub(crate) fn add_facet(
        &mut self,
        nodes: &[usize],
        sparsity: &Sparsity,
        facet: usize,
        magnitude: f64,
        SurfaceResponse { gradient, hessian, .. }: &SurfaceResponse,
    ) -> f64 {
        for (row, g) in gradient.iter().enumerate() {
            self.gradient[3 * nodes[row / 3] + row % 3] += magnitude * g;
        }
        let entry = |row: usize, column: usize| magnitude * hessian[row * gradient.len() + column];
        self.add_matrix(&sparsity.frames, nodes, sparsity.facets.of(facet), entry);
        magnitude.abs() * norm(gradient)
    }

    /// Adds the second derivative of Π times `direction` to `forces`, in all degrees of freedom.
    pub(crate) fn add_stiffness_times(
        &self,
        body: &Body,
        state: State,
        direction: &[f64],
        forces: &mut [f64],
    ) {
        for (cell, nodes) in body.cell_nodes().enumerate() {
            if nodes.iter().all(|&node| direction[3 * node..3 * node + 3] == [0.0; 3]) {
                continue;
            }
            let first = cell * body.points_per_cell;
            for point in first..first + body.points_per_cell {
                let dh = body.displacement_gradient(point, direction);
                let stress = tangent_times(&self.points[point].tangent(), &dh);
                body.add_forces(point, &stress, forces);
            }
        }
        self.patches.iter().for_each(|patch| patch.add_common_product(direction, forces));
        for spring in &body.springs {
            spring.value_and_add_gradient(direction, forces);
        }
        let mut response = SurfaceResponse::default();
        for (surface, facet, nodes) in facets_of(&body.pressures) {
            let magnitude = state.load_factor * surface.magnitude.value(state.theta);
            surface.facet_response(facet, state.displacement, &mut response);
            add_product(nodes, magnitude, &response.hessian, direction, forces);
        }
    }

    /// Displacement gradient at each quadrature point in the assembled state.
    pub(crate) fn displacement_gradients(&self) -> impl Iterator<Item = &Mat3<f64>> {
        self.points.iter().map(|point| &point.h)
    }

    /// The cells of least J in the assembled state.
    pub(crate) fn worst_cells(&self, points_per_cell: usize) -> Vec<CellValue> {
        let ratios: Vec<_> =
            self.displacement_gradients().map(|h| 1.0 + h.volume_change()).collect();
        worst_cells(&ratios, points_per_cell)
    }
}

/// Adds the derivative of the forces on a facet times `direction` to `forces`.
pub(crate) fn add_product(
    nodes: &[usize],
    magnitude: f64,
    hessian: &[f64],
    direction: &[f64],
    forces: &mut [f64],
) {
    let place = |local: usize| 3 * nodes[local / 3] + local % 3;
    for (row, entries) in hessian.chunks(3 * nodes.len()).enumerate() {
        let sum: f64 = entries.iter().enumerate().map(|(c, k)| k * direction[place(c)]).sum();
        forces[place(row)] += magnitude * sum;
    }
}
