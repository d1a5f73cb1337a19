//! The residual of a balance of forces, and the derivatives that its linear systems are made of.

use super::System;
use crate::assembly::PredictedStress;
use crate::cells::CellValue;
use crate::state::State;
use crate::vector::{Norm, norm};
use sinew_energy::SurfaceResponse;
use sinew_num::Mat3;

/// Unknowns at one load: displacement of all nodes and the field of pressure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unknowns {
    pub displacement: Vec<f64>,
    pub pressure: Vec<f64>,
}

/// What is left of forces and of changes of volume.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// Unbalanced forces of the free degrees of freedom, then of the pressures.
    pub values: Vec<f64>,
    /// Norm of the forces.
    pub force: f64,
    /// Norm of the changes of volume.
    pub volume: f64,
}

impl System<'_> {
    /// Evaluates the balance and its derivatives under a fraction of the loads; `predicted` as in [`Assembly::assemble`].
    pub(super) fn assemble(
        &mut self,
        at: &Unknowns,
        theta: &[f64],
        load_factor: f64,
        predicted: Option<&PredictedStress>,
    ) -> Residual {
        let potential = &self.body.body;
        let pressure = self.pressure_at_points(&at.pressure);
        let displacement = &at.displacement[..];
        let state = State { displacement, theta, load_factor, pressure: &pressure };
        self.assembly.assemble(potential, &self.sparsity, state, predicted);
        self.add_followers(displacement, theta, load_factor);
        let mut values: Vec<f64> = self.sparsity.gather(&self.assembly.gradient).collect();
        let force = norm(&values);
        values.extend(self.volume_residual(&at.pressure));
        let volume = norm(&values[self.sparsity.unknowns()..]);
        self.couple();
        Residual { values, force, volume }
    }

    /// Reference volume of the body.
    pub(super) fn volume(&self) -> f64 {
        self.body.body.volumes.iter().sum()
    }

    /// What is unbalanced where assembled last: forces relative to loads and reactions, or volumes relative to the
    /// body's, whichever is larger. `None` where something overflows.
    pub(super) fn size(&self, residual: &Residual) -> Option<f64> {
        let forces = residual.force / self.assembly.force_scale.max(f64::MIN_POSITIVE);
        let volumes = residual.volume / self.volume();
        let finite = forces.is_finite() && volumes.is_finite() && self.assembly.is_finite();
        finite.then_some(forces.max(volumes))
    }

    /// The cells of least J where assembled last.
    pub(super) fn worst_cells(&self) -> Vec<CellValue> {
        self.assembly.worst_cells(self.body.body.points_per_cell)
    }

    /// Adds the loose followers: their forces, and the symmetric part of their tangent.
    fn add_followers(&mut self, displacement: &[f64], theta: &[f64], load_factor: f64) {
        self.followers.clear();
        let mut place = self.body.body.surfaces.iter().map(|s| s.facets()).sum::<usize>();
        let mut loads = Norm::default();
        for surface in &self.body.followers {
            let magnitude = load_factor * surface.magnitude.value(theta);
            for facet in 0..surface.facets() {
                let mut response = SurfaceResponse::default();
                surface.facet_force(facet, displacement, &mut response);
                let size = response.gradient.len();
                let mut symmetric = response.clone();
                for row in 0..size {
                    for column in 0..size {
                        let [entry, mirrored] =
                            [row * size + column, column * size + row].map(|i| response.hessian[i]);
                        symmetric.hessian[row * size + column] = 0.5 * (entry + mirrored);
                    }
                }
                let nodes = surface.facet_nodes(facet);
                let assembly = &mut self.assembly;
                loads.add(assembly.add_facet(nodes, &self.sparsity, place, magnitude, &symmetric));
                for (entry, symmetric) in response.hessian.iter_mut().zip(&symmetric.hessian) {
                    *entry = magnitude * (*entry - symmetric);
                }
                self.followers.push(response);
                place += 1;
            }
        }
        self.assembly.force_scale = self.assembly.force_scale.hypot(loads.value());
    }

    /// Adds the skew part of the tangent of the loose followers times `direction` to `forces`.
    pub(super) fn add_skew(&self, direction: &[f64], forces: &mut [f64]) {
        let mut responses = self.followers.iter();
        for surface in &self.body.followers {
            for (facet, response) in (0..surface.facets()).zip(&mut responses) {
                let nodes = surface.facet_nodes(facet);
                crate::assembly::add_product(nodes, 1.0, response, direction, forces);
            }
        }
    }

    /// Derivative of the balance in the load factor.
    pub(super) fn load_derivative(&self, displacement: &[f64], theta: &[f64]) -> Vec<f64> {
        let potential = &self.body.body;
        let mut forces: Vec<_> = potential.nodal_force.iter().map(|f| -f).collect();
        for pressure in &potential.pressures {
            pressure.value_and_add_gradient(displacement, theta, &mut forces);
        }
        for surface in &potential.surfaces {
            surface.value_and_add_gradient(displacement, theta, &mut forces);
        }
        let mut response = SurfaceResponse::default();
        for surface in &self.body.followers {
            let magnitude = surface.magnitude.value(theta);
            for facet in 0..surface.facets() {
                surface.facet_force(facet, displacement, &mut response);
                for (slot, force) in response.gradient.iter().enumerate() {
                    let node = surface.facet_nodes(facet)[slot / 3];
                    forces[3 * node + slot % 3] += magnitude * force;
                }
            }
        }
        let free = self.sparsity.gather(&forces);
        let pressures = self.body.pressure_field.as_ref().map_or(0, |field| field.unknowns);
        free.chain(std::iter::repeat_n(0.0, pressures)).collect()
    }

    /// Values of the field of pressure at the quadrature points.
    fn pressure_at_points(&self, pressure: &[f64]) -> Vec<f64> {
        let Some(field) = &self.body.pressure_field else { return Vec::new() };
        let cells = field.cells.chunks(field.corners);
        let at_points = cells.flat_map(|cell| {
            field.shape.iter().map(move |shape| {
                shape.iter().zip(cell).map(|(n, &corner)| n * pressure[corner]).sum()
            })
        });
        at_points.collect()
    }

    /// `∫ N_a (J − 1 − p/κ) dV` for each pressure unknown.
    fn volume_residual(&self, pressure: &[f64]) -> Vec<f64> {
        let Some(field) = &self.body.pressure_field else { return Vec::new() };
        let at_points = self.pressure_at_points(pressure);
        let mut residual = vec![0.0; field.unknowns];
        let potential = &self.body.body;
        for (point, h) in self.assembly.displacement_gradients().enumerate() {
            let (cell, local) = (point / field.shape.len(), point % field.shape.len());
            let change = h.volume_change() - field.compliance * at_points[point];
            for (a, n) in field.shape[local].iter().enumerate() {
                residual[field.cells[cell * field.corners + a]] +=
                    potential.volumes[point] * n * change;
            }
        }
        residual
    }

    /// Fills the coupling of volume and displacement, and the moduli that scale its Schur complement.
    fn couple(&mut self) {
        let Some(field) = &self.body.pressure_field else { return };
        let potential = &self.body.body;
        self.coupling.fill(0.0);
        let width = 3 * potential.nodes_per_cell;
        let stride = field.corners * width;
        for (point, (h, response)) in self.assembly.responses().enumerate() {
            let (cell, local) = (point / field.shape.len(), point % field.shape.len());
            let rows = &mut self.coupling[cell * stride..(cell + 1) * stride];
            let f = Mat3::from_fn(|i, j| h[i][j] + if i == j { 1.0 } else { 0.0 });
            let cofactor = Mat3::from_fn(|i, j| f.cofactor(i, j));
            for (b, g) in potential.shape_of_point(point).iter().enumerate() {
                for i in 0..3 {
                    let slope = potential.volumes[point]
                        * (0..3).map(|j| cofactor[i][j] * g[j]).sum::<f64>();
                    for (a, n) in field.shape[local].iter().enumerate() {
                        rows[a * width + 3 * b + i] += n * slope;
                    }
                }
            }
            self.moduli[point] = modulus(&cofactor, &response.tangent);
        }
    }

    /// Adds `Bᵀ pressure` to the forces on all degrees of freedom.
    pub(super) fn add_pressure_forces(&self, pressure: &[f64], forces: &mut [f64]) {
        self.for_coupling(|corners, nodes, rows| {
            for (row, &corner) in rows.chunks(3 * nodes.len()).zip(corners) {
                for (entry, column) in row.iter().zip(0..) {
                    let dof = 3 * nodes[column / 3] + column % 3;
                    forces[dof] += entry * pressure[corner];
                }
            }
        });
    }

    /// Adds `B direction` to the changes of volume.
    pub(super) fn add_volume_changes(&self, direction: &[f64], changes: &mut [f64]) {
        self.for_coupling(|corners, nodes, rows| {
            for (row, &corner) in rows.chunks(3 * nodes.len()).zip(corners) {
                let terms = row.iter().zip(0..);
                changes[corner] +=
                    terms.map(|(b, c)| b * direction[3 * nodes[c / 3] + c % 3]).sum::<f64>();
            }
        });
    }

    fn for_coupling(&self, mut visit: impl FnMut(&[usize], &[usize], &[f64])) {
        let Some(field) = &self.body.pressure_field else { return };
        let body = &self.body.body;
        let rows = self.coupling.chunks(field.corners * 3 * body.nodes_per_cell);
        let cells = field.cells.chunks(field.corners).zip(body.cell_nodes());
        cells.zip(rows).for_each(|((corners, nodes), rows)| visit(corners, nodes, rows));
    }
}

/// Longitudinal modulus `K + 4/3 μ` of a tangent: what a local pressure works against.
fn modulus(cofactor: &Mat3<f64>, tangent: &[[f64; 9]; 9]) -> f64 {
    let c = cofactor.0.as_flattened();
    let size: f64 = c.iter().map(|x| x * x).sum();
    let along: f64 = (0..9).map(|r| c[r] * (0..9).map(|k| tangent[r][k] * c[k]).sum::<f64>()).sum();
    let bulk = (along / (3.0 * size)).max(0.0);
    let trace: f64 = (0..9).map(|i| tangent[i][i]).sum();
    // Isotropic: along = 3K, trace = 3K + 10μ.
    let shear = ((trace - 3.0 * bulk) / 10.0).max(0.0);
    bulk + 4.0 / 3.0 * shear
}
