//! Energy, nodal forces and stiffness of a body.

use crate::diagnose::named::CellValue;
use crate::elements::cell::{NodalBlocks, Rounding, add_pressure, add_stiffness, complete};
use crate::elements::cells::{MOST_WORST, least, per_cell};
use crate::elements::convex::make_convex;
use crate::elements::patch::PatchResponse;
use crate::elements::predicted::{PredictedStress, replace_stress};
use crate::elements::state::State;
use crate::linear::sparsity::Sparsity;
use crate::linear::vector::Norm;
use sinew_energy::with_nodes;
use sinew_energy::{Body, PressureSurface, Response, SurfaceResponse};
use sinew_num::Mat3;

/// Π and its derivatives at one displacement, with bounds of their rounding errors.
#[derive(Clone, Debug)]
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
    points: Vec<(Mat3<f64>, Response)>,
    /// Shared quantities of the points of each patch, if there are patches.
    pub(crate) patches: Vec<PatchResponse>,
    /// Whether the bulk modulus acts as a constraint on J.
    pub(crate) nearly_incompressible: bool,
    /// Number of tangents that lost negative eigenvalues, where they shall.
    pub(crate) convex: Option<usize>,
}

/// Residual at equilibrium as a multiple of the estimated rounding error: measured residuals are 0.9–1.6 of it.
const FLOOR_FACTOR: f64 = 4.0;
/// Largest residual of an equilibrium \[relative to loads and reactions\], whatever the rounding errors are.
const MOST_LEFT: f64 = 1e-6;
/// Least strain of a body that is not at rest.
const STRAINED: f64 = 1e-6;

/// Norm of the nodal forces of the stress at rest \[stress·length²\]: the force scale of a muscle that contracts
/// freely, where loads and reactions are zero. Only active stress gives forces at rest.
fn forces_at_rest(body: &Body, theta: &[f64]) -> f64 {
    let parameters = body.law_parameters(theta);
    let mut forces = vec![[0.0; 3]; body.nodes];
    for (point, volume) in body.volumes.iter().enumerate() {
        let (_, stress) = body.material.stress(point, parameters, &Mat3::ZERO, None);
        for (&node, shape) in body.nodes_of_point(point).iter().zip(body.shape_of_point(point)) {
            let force = stress.apply(shape);
            (0..3).for_each(|i| forces[node][i] += volume * force[i]);
        }
    }
    forces.as_flattened().iter().copied().collect::<Norm>().value()
}

impl Assembly {
    pub(crate) fn new(sparsity: &Sparsity, points: usize, degrees_of_freedom: usize) -> Self {
        Self {
            energy: 0.0,
            energy_noise: 0.0,
            gradient: vec![0.0; degrees_of_freedom],
            displacement: vec![0.0; degrees_of_freedom],
            force_scale: 0.0,
            floor: 0.0,
            matrix: vec![0.0; sparsity.entries() + 1],
            least_volume_ratio: 1.0,
            worst_cell: 0,
            points: vec![(Mat3::ZERO, Response::INADMISSIBLE); points],
            patches: Vec::new(),
            nearly_incompressible: false,
            convex: None,
        }
    }

    /// Evaluates everything at `displacement`, under the fraction `load_factor` of the loads.
    ///
    /// `predicted` replaces the stress in the stiffness, see [`crate::elements::predicted`].
    pub(crate) fn assemble(
        &mut self,
        potential: &Body,
        sparsity: &Sparsity,
        state: State,
        predicted: Option<&PredictedStress>,
    ) {
        let State { displacement, load_factor, .. } = state;
        self.displacement.copy_from_slice(displacement);
        self.matrix.fill(0.0);
        let mut loads = Norm::default();
        let work: f64 = displacement.iter().zip(&potential.nodal_force).map(|(u, f)| u * f).sum();
        self.energy = -load_factor * work;
        let mut rounding = Rounding::default();
        rounding.energy += self.energy.abs();
        for (g, f) in self.gradient.iter_mut().zip(&potential.nodal_force) {
            *g = -load_factor * f;
            loads.add(*g);
        }
        let mut facet = 0;
        for pressure in &potential.pressures {
            loads.add(self.add_pressure(pressure, sparsity, facet, state, &mut rounding));
            facet += pressure.facets();
        }
        for (index, spring) in potential.springs.iter().enumerate() {
            let energy = spring.value_and_add_gradient(displacement, &mut self.gradient);
            self.energy += energy;
            rounding.energy += energy;
            let (places, stiffness) = (sparsity.springs.of(index), &spring.stiffness);
            let entry = |row: usize, column: usize| stiffness[row][column];
            self.add_matrix(&sparsity.frames, &[spring.node], places, 1.0, entry);
        }
        if potential.patches.is_empty() {
            with_nodes!(potential.nodes_per_cell, N => {
                self.add_cells::<N>(potential, sparsity, state, predicted, &mut rounding)
            });
        } else {
            self.add_patches(potential, sparsity, state, predicted, &mut rounding);
        }
        (self.floor, self.energy_noise) = (rounding.force_noise(), rounding.energy_noise());
        let held = potential.prescribed.iter().enumerate().filter(|(_, p)| p.is_some());
        let reactions = held.map(|(dof, _)| sparsity.frames.component(dof, &self.gradient));
        self.force_scale = loads.value() + reactions.collect::<Norm>().value();
        if FLOOR_FACTOR * self.floor > MOST_LEFT * self.force_scale {
            self.force_scale += forces_at_rest(potential, state.theta);
        }
    }

    /// Whether energy, force scale and rounding errors are finite.
    pub(crate) fn is_finite(&self) -> bool {
        [self.energy, self.energy_noise, self.floor, self.force_scale].iter().all(|x| x.is_finite())
    }

    /// Residual at which an equilibrium is reached \[stress·length²\]: the rounding error, but at most [`MOST_LEFT`] of
    /// the forces in a strained body. Forces on a body at rest may be rounding errors only.
    pub(crate) fn tolerance(&self) -> f64 {
        let (floor, most) = (FLOOR_FACTOR * self.floor, MOST_LEFT * self.force_scale);
        if floor <= most || !self.is_strained() { floor } else { most }
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

    fn add_cells<const N: usize>(
        &mut self,
        potential: &Body,
        sparsity: &Sparsity,
        State { displacement, theta, pressure, .. }: State,
        predicted: Option<&PredictedStress>,
        rounding: &mut Rounding,
    ) {
        let parameters = potential.law_parameters(theta);
        self.least_volume_ratio = f64::INFINITY;
        let shapes = potential.shape_gradients.as_chunks::<N>().0;
        for (cell, nodes) in potential.cells.as_chunks::<N>().0.iter().enumerate() {
            let motion = motion_of(nodes, displacement);
            let mut blocks: NodalBlocks<N> = [[[[0.0; 3]; N]; 3]; N];
            let first = cell * potential.points_per_cell;
            for point in first..first + potential.points_per_cell {
                let (shape, volume) = (&shapes[point], potential.volumes[point]);
                let h = potential.displacement_gradient(point, displacement);
                let mut response = potential.material.response(point, parameters, &h);
                if let Some(&pressure) = pressure.get(point) {
                    add_pressure(&mut response, &h, pressure);
                }
                let ratio = 1.0 + h.volume_change();
                if ratio < self.least_volume_ratio {
                    (self.least_volume_ratio, self.worst_cell) = (ratio, cell);
                }
                self.energy += volume * response.energy;
                for (&node, g) in nodes.iter().zip(shape) {
                    for i in 0..3 {
                        let force: f64 = (0..3).map(|j| response.stress[i][j] * g[j]).sum();
                        self.gradient[3 * node + i] += volume * force;
                    }
                }
                rounding.add_cell(shape, volume, motion, (&h, &response), 0.0);
                let mut tangent = response.tangent;
                if let Some(predicted) = predicted {
                    replace_stress(
                        &mut tangent,
                        &h,
                        &response.stress,
                        &predicted[point],
                        self.nearly_incompressible,
                    );
                }
                if let Some(count) = &mut self.convex {
                    *count += usize::from(make_convex(&mut tangent));
                }
                add_stiffness(&tangent, shape, volume, &mut blocks);
                self.points[point] = (h, response);
            }
            complete(&mut blocks);
            let places = sparsity.cells.of(cell);
            let entry =
                |row: usize, column: usize| blocks[row / 3][row % 3][column / 3][column % 3];
            if self.add_turned(&sparsity.frames, nodes, places, 1.0, entry) {
                continue;
            }
            let mut places = places.iter();
            for a in 0..N {
                for i in 0..3 {
                    let row = blocks[a][i].as_flattened();
                    for (value, &place) in row[..=3 * a + i].iter().zip(&mut places) {
                        self.matrix[place as usize] += value;
                    }
                }
            }
        }
    }

    fn add_patches(
        &mut self,
        potential: &Body,
        sparsity: &Sparsity,
        State { displacement, theta, .. }: State,
        predicted: Option<&PredictedStress>,
        rounding: &mut Rounding,
    ) {
        let parameters = potential.law_parameters(theta);
        self.least_volume_ratio = f64::INFINITY;
        self.patches.clear();
        // Gradients of all points first: a patch with an inverted cell ends the assembly, and its cell must be among
        // the worst.
        for (point, (gradient, _)) in self.points.iter_mut().enumerate() {
            *gradient = potential.displacement_gradient(point, displacement);
            let ratio = 1.0 + gradient.volume_change();
            if ratio < self.least_volume_ratio {
                let cell = point / potential.points_per_cell;
                (self.least_volume_ratio, self.worst_cell) = (ratio, cell);
            }
        }
        for (index, points) in potential.patches.iter().enumerate() {
            let Some(mut patch) = PatchResponse::new(potential, points, displacement, parameters)
            else {
                self.energy = f64::INFINITY;
                return;
            };
            self.energy += patch.energy;
            let common = patch.common_stiffness(potential, points);
            for (&point, (h, response)) in points.iter().zip(&patch.points) {
                potential.add_forces(point, &response.stress, &mut self.gradient);
                let motion = motion_of(potential.nodes_of_point(point), displacement);
                let (shape, volume) = (potential.shape_of_point(point), potential.volumes[point]);
                rounding.add_cell(shape, volume, motion, (h, response), common);
                self.points[point] = (*h, *response);
            }
            if let Some(predicted) = predicted {
                for (&point, (h, response)) in points.iter().zip(&mut patch.points) {
                    let stress = response.stress;
                    replace_stress(
                        &mut response.tangent,
                        h,
                        &stress,
                        &predicted[point],
                        self.nearly_incompressible,
                    );
                }
            }
            if let Some(count) = &mut self.convex {
                let points = patch.points.iter_mut();
                *count +=
                    points.filter_map(|(_, r)| make_convex(&mut r.tangent).then_some(())).count();
            }
            let places = sparsity.cells.of(index);
            let lower =
                with_nodes!(potential.nodes_per_cell, N => patch.stiffness::<N>(potential, points));
            let entry = |row: usize, column: usize| lower[row * (row + 1) / 2 + column];
            self.add_matrix(&sparsity.frames, &patch.nodes, places, 1.0, entry);
            self.patches.push(patch);
        }
    }

    /// Adds a pressure; returns the norm of its nodal forces.
    fn add_pressure(
        &mut self,
        surface: &PressureSurface,
        sparsity: &Sparsity,
        first_facet: usize,
        state: State,
        rounding: &mut Rounding,
    ) -> f64 {
        let magnitude = state.load_factor * surface.magnitude.value(state.theta);
        let mut norm = Norm::default();
        let mut response = SurfaceResponse::default();
        for facet in 0..surface.facets() {
            surface.facet_response(facet, state.displacement, &mut response);
            let energy = magnitude * response.energy;
            self.energy += energy;
            rounding.energy += energy.abs();
            let nodes = surface.facet_nodes(facet);
            let derivatives = (&response.gradient[..], &response.hessian[..]);
            norm.add(self.add_facet(nodes, sparsity, first_facet + facet, magnitude, derivatives));
        }
        norm.value()
    }

    /// Adds forces and the lower half of their derivative on one facet, counted over all pressures; returns the forces'
    /// norm.
    pub(crate) fn add_facet(
        &mut self,
        nodes: &[usize],
        sparsity: &Sparsity,
        facet: usize,
        magnitude: f64,
        (gradient, hessian): (&[f64], &[f64]),
    ) -> f64 {
        let mut norm = Norm::default();
        for (row, g) in gradient.iter().enumerate() {
            let force = magnitude * g;
            self.gradient[3 * nodes[row / 3] + row % 3] += force;
            norm.add(force);
        }
        let entry = |row: usize, column: usize| hessian[row * gradient.len() + column];
        self.add_matrix(&sparsity.frames, nodes, sparsity.facets.of(facet), magnitude, entry);
        norm.value()
    }

    /// Adds the second derivative of Π times `direction` to `forces`, in all degrees of freedom.
    pub(crate) fn add_stiffness_times(
        &self,
        potential: &Body,
        state: State,
        direction: &[f64],
        forces: &mut [f64],
    ) {
        for (cell, nodes) in potential.cell_nodes().enumerate() {
            if nodes.iter().all(|&node| direction[3 * node..3 * node + 3] == [0.0; 3]) {
                continue;
            }
            let first = cell * potential.points_per_cell;
            for point in first..first + potential.points_per_cell {
                let dh = potential.displacement_gradient(point, direction);
                let stress = tangent_times(&self.points[point].1.tangent, &dh);
                potential.add_forces(point, &stress, forces);
            }
        }
        self.patches.iter().for_each(|patch| patch.add_common_product(direction, forces));
        for spring in &potential.springs {
            spring.value_and_add_gradient(direction, forces);
        }
        let mut response = SurfaceResponse::default();
        for surface in &potential.pressures {
            let magnitude = state.load_factor * surface.magnitude.value(state.theta);
            for facet in 0..surface.facets() {
                surface.facet_response(facet, state.displacement, &mut response);
                let nodes = surface.facet_nodes(facet);
                add_product(nodes, magnitude, &response.hessian, direction, forces);
            }
        }
    }

    /// Displacement gradient at each quadrature point in the assembled state.
    pub(crate) fn displacement_gradients(&self) -> impl Iterator<Item = &Mat3<f64>> {
        self.points.iter().map(|(h, _)| h)
    }

    /// The cells of least J in the assembled state.
    pub(crate) fn worst_cells(&self, points_per_cell: usize) -> Vec<CellValue> {
        let ratios: Vec<_> =
            self.displacement_gradients().map(|h| 1.0 + h.volume_change()).collect();
        least(&per_cell(&ratios, points_per_cell, f64::min), MOST_WORST)
    }

    /// Displacement gradient and response at each quadrature point in the assembled state.
    pub(crate) fn responses(&self) -> impl Iterator<Item = &(Mat3<f64>, Response)> {
        self.points.iter()
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

/// Largest displacement component of some nodes.
fn motion_of(nodes: &[usize], displacement: &[f64]) -> f64 {
    let components = nodes.iter().flat_map(|&node| &displacement[3 * node..3 * node + 3]);
    components.fold(0.0, |m: f64, u| m.max(u.abs()))
}

/// `A : dH`.
pub(crate) fn tangent_times(tangent: &[[f64; 9]; 9], dh: &Mat3<f64>) -> Mat3<f64> {
    let flat = dh.0.as_flattened();
    Mat3::from_fn(|i, j| tangent[3 * i + j].iter().zip(flat).map(|(a, h)| a * h).sum())
}
