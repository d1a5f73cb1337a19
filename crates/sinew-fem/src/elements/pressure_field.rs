//! Coupling of displacements and the pressure field of mixed elements.

use crate::elements::Assembly;
use crate::linear::Factor;
use faer::sparse::Triplet;
use sinew_energy::{Body, PressureField};
use sinew_num::Mat3;

/// A pressure field with its derivatives at the assembled state.
pub(crate) struct Coupling<'p> {
    body: &'p Body,
    field: &'p PressureField,
    /// `∂r_p/∂u` of each cell: one row per corner, `3N` columns.
    rows: Vec<f64>,
    /// Longitudinal modulus at each quadrature point \[stress\].
    moduli: Vec<f64>,
    /// Factor of the pressure's mass matrix weighted by the inverse moduli, which approximates the Schur complement.
    schur: Option<Factor>,
}

impl<'p> Coupling<'p> {
    pub(crate) fn new(body: &'p Body, field: &'p PressureField) -> Self {
        let rows = vec![0.0; body.cell_count() * field.corners * 3 * body.nodes_per_cell];
        Self { body, field, rows, moduli: vec![0.0; body.volumes.len()], schur: None }
    }

    /// Values at the quadrature points.
    pub(crate) fn at_points(&self, pressure: &[f64]) -> Vec<f64> {
        (0..self.moduli.len()).map(|point| self.field.at(point, pressure)).collect()
    }

    /// Takes the derivatives at the assembled state; returns the residual of the volume constraint, `∫ N_a (J − 1 −
    /// p/κ) dV`.
    pub(crate) fn assemble(&mut self, assembly: &Assembly, pressure: &[f64]) -> Vec<f64> {
        let Self { body, field, rows, moduli, .. } = self;
        let mut residual = vec![0.0; field.unknowns];
        rows.fill(0.0);
        let width = 3 * body.nodes_per_cell;
        for (point, state) in assembly.points.iter().enumerate() {
            let (cell, corners, shape) = field.of_point(point);
            let volume = body.volumes[point];
            let change = state.h.volume_change() - field.compliance * field.at(point, pressure);
            for (&corner, n) in corners.iter().zip(shape) {
                residual[corner] += volume * n * change;
            }
            let rows = &mut rows[cell * corners.len() * width..][..corners.len() * width];
            let cofactor = state.h.plus_identity().cofactors();
            for (b, g) in body.shape_of_point(point).iter().enumerate() {
                for i in 0..3 {
                    let slope = volume * (0..3).map(|j| cofactor[i][j] * g[j]).sum::<f64>();
                    for (a, n) in shape.iter().enumerate() {
                        rows[a * width + 3 * b + i] += n * slope;
                    }
                }
            }
            moduli[point] = modulus(&cofactor, &state.tangent());
        }
        residual
    }

    /// Adds `Bᵀ pressure` to the forces on all degrees of freedom.
    pub(crate) fn add_forces(&self, pressure: &[f64], forces: &mut [f64]) {
        self.for_rows(|corner, nodes, row| {
            for (entry, column) in row.iter().zip(0..) {
                forces[3 * nodes[column / 3] + column % 3] += entry * pressure[corner];
            }
        });
    }

    /// Adds `B direction` to the changes of volume.
    pub(crate) fn add_volume_changes(&self, direction: &[f64], changes: &mut [f64]) {
        self.for_rows(|corner, nodes, row| {
            let terms = row.iter().zip(0..);
            let terms = terms.map(|(b, c)| b * direction[3 * nodes[c / 3] + c % 3]);
            changes[corner] += terms.sum::<f64>();
        });
    }

    /// Subtracts the changes of volume by the compliance 1/κ.
    pub(crate) fn add_compliance(&self, pressures: &[f64], volumes: &mut [f64]) {
        if self.field.compliance == 0.0 {
            return;
        }
        for (point, volume) in self.body.volumes.iter().enumerate() {
            let (_, corners, shape) = self.field.of_point(point);
            let p = self.field.at(point, pressures);
            for (n, &c) in shape.iter().zip(corners) {
                volumes[c] -= self.field.compliance * volume * n * p;
            }
        }
    }

    /// The derivatives of each corner of each cell, with the nodes of the cell.
    fn for_rows(&self, mut visit: impl FnMut(usize, &[usize], &[f64])) {
        let rows = self.rows.chunks(3 * self.body.nodes_per_cell);
        for (at, (&corner, row)) in self.field.cells.iter().zip(rows).enumerate() {
            visit(corner, self.body.nodes_of_cell(at / self.field.corners), row);
        }
    }

    /// Factorises the pressure's mass matrix over the local moduli.
    pub(crate) fn factorise(&mut self) -> Option<()> {
        let field = self.field;
        let mut triplets = Vec::with_capacity(field.cells.len() * field.corners);
        for (point, (volume, modulus)) in self.body.volumes.iter().zip(&self.moduli).enumerate() {
            let (_, corners, shape) = field.of_point(point);
            let weight = volume * (1.0 / modulus + field.compliance);
            for (&row, n) in corners.iter().zip(shape) {
                for (&column, m) in corners.iter().zip(shape).filter(|(c, _)| **c <= row) {
                    triplets.push(Triplet::new(row, column, weight * n * m));
                }
            }
        }
        self.schur = Some(Factor::alone(field.unknowns, &triplets)?);
        Some(())
    }

    /// Overwrites changes of volume with pressures by the approximate Schur complement.
    pub(crate) fn solve_schur(&self, pressures: &mut [f64]) {
        if let Some(schur) = &self.schur {
            schur.solve(pressures);
            pressures.iter_mut().for_each(|p| *p = -*p);
        }
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
