//! Negative powers of the stiffness, in which energies are round.

use crate::state::State;
use crate::{SolveError, Solver};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par};

/// Most unknowns: the dense matrices are then of 0.3 GB each.
const MOST_UNKNOWNS: usize = 6000;

/// Smallest eigenvalue that is used, relative to the largest: rounding makes up what is below.
const SMALLEST_EIGENVALUE: f64 = 1e-9;

impl Solver<'_> {
    /// `|K|^(−power)` with the stiffness `K = ∂²Π/∂u²` at `displacement`: a symmetric matrix over all degrees
    /// of freedom, row by row, zero in the rows and columns of prescribed ones.
    ///
    /// With `power` ½, displacements `u = |K|^(−½) z` have the energy `½ zᵀz` to second order: soft
    /// and stiff motions weigh the same in `z`, whatever the condition number of `K`. Negative eigenvalues
    /// (an unstable state) enter by their magnitude.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, an energy that is not finite there, or
    /// [`SolveError::TooLargeForDense`].
    pub fn inverse_stiffness_power(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        power: f64,
    ) -> Result<Vec<f64>, SolveError> {
        self.potential.check_theta(theta)?;
        self.check_displacement(displacement)?;
        let unknowns = self.unknowns();
        if unknowns > MOST_UNKNOWNS {
            return Err(SolveError::TooLargeForDense { unknowns, most: MOST_UNKNOWNS });
        }
        let state = State { displacement, theta, load_factor: 1.0, pressure: &[] };
        self.assembly.assemble(self.potential, &self.sparsity, state, None);
        if !self.assembly.energy.is_finite() {
            return Err(SolveError::Inadmissible { cell: self.assembly.worst_cell });
        }
        let (vectors, values) = self.eigenvectors()?;
        let floor = SMALLEST_EIGENVALUE * values.iter().fold(0.0, |most, v| v.abs().max(most));
        let scale: Vec<f64> = values.iter().map(|v| v.abs().max(floor).powf(-power)).collect();
        let scaled = Mat::from_fn(unknowns, unknowns, |i, j| vectors[(i, j)] * scale[j]);
        let mut root = Mat::zeros(unknowns, unknowns);
        faer::linalg::matmul::matmul(
            root.as_mut(),
            faer::Accum::Replace,
            scaled.as_ref(),
            vectors.transpose(),
            1.0,
            Par::Seq,
        );
        // From unknowns to all degrees of freedom: each column, and then each row.
        let size = displacement.len();
        let spread_column = |j: usize| {
            let mut column = vec![0.0; size];
            self.sparsity.scatter(root.col(j).iter().copied(), &mut column);
            column
        };
        let columns: Vec<_> = (0..unknowns).map(spread_column).collect();
        let mut spread = vec![0.0; size * size];
        for (i, row) in spread.chunks_mut(size).enumerate() {
            self.sparsity.scatter(columns.iter().map(|column| column[i]), row);
        }
        Ok(spread)
    }

    /// Eigenvectors, one per column, and eigenvalues of the assembled stiffness. One thread: the same
    /// numbers on every machine of a kind.
    fn eigenvectors(&self) -> Result<(Mat<f64>, Vec<f64>), SolveError> {
        let unknowns = self.unknowns();
        let mut dense = Mat::zeros(unknowns, unknowns);
        let mut at = 0;
        for column in 0..unknowns {
            for &row in self.sparsity.pattern.row_idx_of_col_raw(column) {
                dense[(row, column)] = self.assembly.matrix[at];
                at += 1;
            }
        }
        let mut values = Diag::zeros(unknowns);
        let mut vectors = Mat::zeros(unknowns, unknowns);
        let scratch = self_adjoint_evd_scratch::<f64>(
            unknowns,
            ComputeEigenvectors::Yes,
            Par::Seq,
            Default::default(),
        );
        let mut memory =
            MemBuffer::try_new(scratch).map_err(|_| SolveError::OutOfMemory { unknowns })?;
        self_adjoint_evd(
            dense.as_ref(),
            values.as_mut(),
            Some(vectors.as_mut()),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|_| SolveError::Singular)?;
        let values = values.column_vector().iter().copied().collect();
        Ok((vectors, values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_energy::laws::NeoHookean;
    use sinew_energy::{Load, Parameter, Sampling, Scene, Support, Units};
    use sinew_mesh::box_tetrahedra;

    #[test]
    fn energy_is_round_in_the_coordinates_of_the_root() {
        let stiffness = |name: &str| Parameter {
            name: name.into(),
            unit: "kPa".into(),
            range: [50.0, 100.0],
            sampling: Sampling::Log,
        };
        let scene = Scene {
            name: "strip".into(),
            units: Units::mm_kpa(),
            mesh: box_tetrahedra([20.0, 2.0, 1.0], [6, 1, 1]),
            law: NeoHookean,
            directions: Vec::new(),
            parameters: vec![stiffness("mu"), stiffness("lambda")],
            loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
            supports: vec![Support::clamped("x_min")],
        };
        let potential = scene.lower().unwrap();
        let theta = [70.0, 60.0];
        let mut solver = Solver::new(&potential).unwrap();
        let size = potential.prescribed.len();
        let rest = vec![0.0; size];
        let root = solver.inverse_stiffness_power(&rest, &theta, 0.5).unwrap();
        // A small z in any direction costs ½ z·z: along x, y and z of a node, and all at once.
        const SMALL: f64 = 1e-5;
        let base = potential.value(&rest, &theta);
        let free = potential.free_degrees_of_freedom();
        let all: Vec<f64> = (0..size).map(|i| ((i * 7919) % 13) as f64 / 6.0 - 1.0).collect();
        let single = |index: usize| (0..size).map(|i| f64::from(u8::from(i == index))).collect();
        for direction in [all, single(free[4]), single(free[20])] {
            let z: Vec<f64> = (0..size)
                .map(|i| if free.contains(&i) { SMALL * direction[i] } else { 0.0 })
                .collect();
            let moved = |sign: f64| -> Vec<f64> {
                (0..size)
                    .map(|i| sign * (0..size).map(|j| root[i * size + j] * z[j]).sum::<f64>())
                    .collect()
            };
            let both = potential.value(&moved(1.0), &theta) + potential.value(&moved(-1.0), &theta);
            let energy = 0.5 * both - base;
            let round: f64 = 0.5 * z.iter().map(|x| x * x).sum::<f64>();
            assert!((energy / round - 1.0).abs() < 1e-4, "{energy:e} against {round:e}");
        }
    }
}
