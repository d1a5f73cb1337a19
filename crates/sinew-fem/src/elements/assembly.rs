//! One pass over a body: energy, nodal forces and stiffness. Cells and patches go in shares that any thread may compute, and that are added in one order.

use crate::elements::assembled::LARGE;
use crate::elements::{
    Assembly, NodalBlocks, PatchResponse, PointState, PredictedStress, Residual, Rounding, State,
    System, Unknowns, add_pressure, add_stiffness, complete, make_convex, replace_stress, turn,
};
use crate::linear::{Sparsity, norm};
use sinew_energy::{Body, Frames, PressureSurface, Response, SurfaceResponse, with_nodes};
use sinew_num::{Mat3, in_parallel, sum};
use std::ops::Range;

/// Number of roundings in a term of the energy, a dozen, rounded up.
const ENERGY_ROUNDINGS: f64 = 16.0;
/// Quadrature points of a share: a fixed division, so that sums do not depend on the number of threads. The stiffnesses of so many tetrahedra take 40 KB.
const SHARE: usize = 64;
/// Shares that threads compute while those before are added.
const AT_ONCE: usize = 64;

impl System<'_> {
    /// Evaluates the balance and its derivatives under a fraction of the loads; `predicted` as in [`Assembly::assemble`].
    pub(crate) fn assemble(
        &mut self,
        at: &Unknowns,
        theta: &[f64],
        load_factor: f64,
        predicted: Option<&PredictedStress>,
    ) -> Residual {
        let Self { body, sparsity, assembly, .. } = self;
        let displacement = &at.displacement[..];
        let pressure = self.coupling.as_ref().map(|c| c.at_points(&at.pressure));
        let pressure = pressure.unwrap_or_default();
        let state = State { displacement, theta, load_factor, pressure: &pressure };
        assembly.assemble(body, sparsity, state, predicted);
        let first = body.pressures.iter().map(PressureSurface::facets).sum();
        self.followers.assemble(assembly, sparsity, first, state);
        let mut values: Vec<f64> = sparsity.gather(&assembly.gradient).collect();
        let force = norm(&values);
        if let Some(coupling) = &mut self.coupling {
            values.extend(coupling.assemble(assembly, &at.pressure));
        }
        let volume = norm(&values[sparsity.unknowns()..]);
        Residual { values, force, volume }
    }
}

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
        if self.is_of_rounding() {
            self.force_scale += forces_at_rest(body, state.theta);
        }
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

    /// Adds a symmetric matrix over the components of some nodes to the stiffness; `lower` gives an entry
    /// of its lower half by row and column, `places` say where they go.
    pub(crate) fn add_matrix(
        &mut self,
        frames: &Frames,
        nodes: &[usize],
        places: &[u32],
        lower: impl Fn(usize, usize) -> f64,
    ) {
        let rows = 0..3 * nodes.len();
        let entries = rows.flat_map(|row| (0..=row).map(move |column| (row, column)));
        let mut half: Vec<f64> = entries.map(|(row, column)| lower(row, column)).collect();
        turn(frames, nodes, &mut half);
        places.iter().zip(half).for_each(|(&place, entry)| self.matrix[place as usize] += entry);
    }
}

/// Sums over a share.
#[derive(Default)]
pub(crate) struct Share {
    /// Cells, or patches if there are any.
    pub parts: Range<usize>,
    pub energy: f64,
    pub rounding: Rounding,
    /// Least volume ratio J of cells, and the one that has it.
    pub least: Option<(f64, usize)>,
    /// Number of tangents that lost negative eigenvalues.
    pub convex: usize,
    /// Force on each node, cell by cell, or point by point of each patch.
    pub forces: Vec<[f64; 3]>,
    /// Lower halves of the stiffnesses, row by row, along the nodes' frames.
    pub lower: Vec<f64>,
    /// Patches with their points, whose tangents are still those of the law; fewer than `parts` where one has an inverted cell.
    pub patches: Vec<(PatchResponse, Vec<PointState>)>,
}

impl Share {
    /// Empties it for other parts, and keeps its memory.
    fn begin(&mut self, parts: Range<usize>) {
        self.lower.clear();
        self.rounding.forces.clear();
        self.forces.clear();
        self.patches.clear();
        let Self { forces, lower, patches, rounding, .. } = std::mem::take(self);
        let rounding = Rounding { energy: 0.0, ..rounding };
        *self = Self { parts, forces, lower, patches, rounding, ..Self::default() };
    }
}

/// State and stiffness that are asked for.
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub body: &'a Body,
    pub state: State<'a>,
    /// Stress that replaces the present one in the stiffness.
    pub predicted: Option<&'a PredictedStress>,
    pub nearly_incompressible: bool,
    /// Whether tangents lose their negative eigenvalues.
    pub convex: bool,
}

impl Task<'_> {
    /// Computes all shares, and hands them to `add` in their order. Writes the points of cells, but not those of patches.
    pub(crate) fn run(self, points: &mut [PointState], mut add: impl FnMut(&mut Share) + Send) {
        let Self { body, .. } = self;
        let large = body.volumes.len() >= LARGE && rayon::current_num_threads() > 1;
        let (parts, plain) = match body.patches.len() {
            0 => (body.cells.len() / body.nodes_per_cell, true),
            patches => (patches, false),
        };
        let most = (SHARE * parts / body.volumes.len().max(1)).max(1);
        let mut rest = points;
        let own = |first: usize| {
            let parts = first..parts.min(first + most);
            let size = if plain { parts.len() * body.points_per_cell } else { 0 };
            let (own, others) = std::mem::take(&mut rest).split_at_mut(size);
            rest = others;
            (parts, own)
        };
        let mut shares: Vec<_> = (0..parts).step_by(most).map(own).collect();
        let compute = |(parts, points): &mut (Range<usize>, &mut [PointState]),
                       share: &mut Share| {
            share.begin(parts.clone());
            with_nodes!(body.nodes_per_cell, N => match plain {
                true => self.cells::<N>(points, share),
                false => self.patches::<N>(share),
            });
        };
        let (mut next, mut before) = (Vec::new(), Vec::<Share>::new());
        let at_once = if large { AT_ONCE } else { 1 };
        for batch in shares.chunks_mut(at_once) {
            next.resize_with(batch.len(), Share::default);
            let tasks = batch.iter_mut().zip(&mut next);
            let compute = || in_parallel(tasks, |(parts, share)| compute(parts, share));
            let mut add = || before.iter_mut().for_each(&mut add);
            if large {
                rayon::join(compute, add);
            } else {
                compute();
                add();
            }
            std::mem::swap(&mut next, &mut before);
        }
        before.iter_mut().for_each(add);
    }

    /// The tangent that the stiffness is built from.
    fn adapt(self, point: usize, h: &Mat3<f64>, response: &mut Response) -> usize {
        let Response { stress, tangent, .. } = response;
        if let Some(predicted) = self.predicted {
            replace_stress(tangent, h, stress, &predicted[point], self.nearly_incompressible);
        }
        usize::from(self.convex && make_convex(tangent))
    }

    fn cells<const N: usize>(self, points: &mut [PointState], share: &mut Share) {
        let Self { body, state: State { displacement, theta, pressure, .. }, .. } = self;
        let parameters = body.law_parameters(theta);
        let shapes = body.shape_gradients.as_chunks::<N>().0;
        let cells = &body.cells.as_chunks::<N>().0[share.parts.clone()];
        share.forces.reserve(cells.len() * N);
        share.lower.reserve(cells.len() * 3 * N * (3 * N + 1) / 2);
        let of_cells = points.chunks_mut(body.points_per_cell);
        for ((cell, nodes), points) in share.parts.clone().zip(cells).zip(of_cells) {
            let motion = motion_of(nodes, displacement);
            let mut blocks: NodalBlocks<N> = [[[[0.0; 3]; N]; 3]; N];
            let mut forces = [[0.0; 3]; N];
            for (point, slot) in (cell * body.points_per_cell..).zip(points) {
                let (shape, volume) = (&shapes[point], body.volumes[point]);
                let h = body.displacement_gradient(point, displacement);
                let mut response = body.material.response(point, parameters, &h);
                if let Some(&pressure) = pressure.get(point) {
                    add_pressure(&mut response, &h, pressure);
                }
                let ratio = 1.0 + h.volume_change();
                if share.least.is_none_or(|(least, _)| ratio < least) {
                    share.least = Some((ratio, cell));
                }
                share.energy += volume * response.energy;
                for (force, g) in forces.iter_mut().zip(shape) {
                    for i in 0..3 {
                        let sum: f64 = (0..3).map(|j| response.stress[i][j] * g[j]).sum();
                        force[i] += volume * sum;
                    }
                }
                share.rounding.add_cell(shape, volume, motion, (&h, &response), 0.0);
                *slot = PointState::new(&h, &response);
                share.convex += self.adapt(point, &h, &mut response);
                add_stiffness(&response.tangent, shape, volume, &mut blocks);
            }
            complete(&mut blocks);
            share.forces.extend(forces);
            let first = share.lower.len();
            for row in 0..3 * N {
                share.lower.extend_from_slice(&blocks[row / 3][row % 3].as_flattened()[..=row]);
            }
            turn(&body.frames, nodes, &mut share.lower[first..]);
        }
    }

    fn patches<const N: usize>(self, share: &mut Share) {
        let Self { body, state: State { displacement, theta, .. }, .. } = self;
        let parameters = body.law_parameters(theta);
        for points in &body.patches[share.parts.clone()] {
            let found = PatchResponse::new(body, points, displacement, parameters);
            let Some((patch, mut responses)) = found else {
                share.energy = f64::INFINITY;
                return;
            };
            share.energy += patch.energy;
            let common = patch.common_stiffness(body, points);
            let of_law =
                responses.iter().map(|(h, response)| PointState::new(h, response)).collect();
            for (&point, (h, response)) in points.iter().zip(&mut responses) {
                let (nodes, shape) = (body.nodes_of_point(point), body.shape_of_point(point));
                let (motion, volume) = (motion_of(nodes, displacement), body.volumes[point]);
                let force = |g: &[f64; 3]| response.stress.apply(g).map(|force| volume * force);
                share.forces.extend(shape.iter().map(force));
                share.rounding.add_cell(shape, volume, motion, (h, response), common);
                share.convex += self.adapt(point, h, response);
            }
            let tangents = responses.iter().map(|(_, response)| response.tangent);
            let mut lower = patch.stiffness::<N>(body, points, tangents);
            turn(&body.frames, &patch.nodes, &mut lower);
            share.lower.append(&mut lower);
            share.patches.push((patch, of_law));
        }
    }
}

/// Largest displacement component of some nodes.
fn motion_of(nodes: &[usize], displacement: &[f64]) -> f64 {
    let components = nodes.iter().flat_map(|&node| &displacement[3 * node..3 * node + 3]);
    components.fold(0.0, |m: f64, u| m.max(u.abs()))
}
