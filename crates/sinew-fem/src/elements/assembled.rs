//! Energy, forces and stiffness of a body as they were assembled at one displacement, and how far rounding errors reach.

use crate::elements::{PatchResponse, State, tangent_times, worst_cells};
use crate::linear::{Sparsity, dot, facets_of};
use crate::{CellValue, Result, SolveError};
use sinew_energy::{Body, Response, SurfaceResponse};
use sinew_num::{Mat3, in_tasks};

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

/// Residual at equilibrium as a multiple of the estimated rounding error: measured residuals are 0.9–1.6 of it.
const FLOOR_FACTOR: f64 = 4.0;
/// Largest residual of rounding errors \[relative to that multiple\]. The rounding error in the displacement of a node acts in all of its cells at once, some 20
/// tetrahedra, whose forces the estimate adds up as if they were independent: at most √20 times as much.
const COHERENT: f64 = 4.0;
/// Largest residual of an equilibrium \[relative to loads and reactions\], whatever the rounding errors are.
const MOST_LEFT: f64 = 1e-6;
/// Least strain of a body that is not at rest.
const STRAINED: f64 = 1e-6;

/// Least number of quadrature points whose work is divided.
pub(super) const LARGE: usize = 16_384;
/// Points of one task.
const TASK: usize = 512;

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

    /// Whether the forces may be rounding errors alone.
    pub(super) fn is_of_rounding(&self) -> bool {
        FLOOR_FACTOR * self.floor > MOST_LEFT * self.force_scale
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

/// A value of each of `count` quadrature points, on all threads where they are many.
pub(crate) fn at_points<T: Clone + Default + Send>(
    count: usize,
    value: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    if count < LARGE { (0..count).map(value).collect() } else { in_tasks(count, TASK, value) }
}

/// State of a quadrature point. Large bodies have millions: half of the symmetric tangent is stored, without the energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointState {
    /// Displacement gradient H.
    pub h: Mat3<f64>,
    /// First Piola–Kirchhoff stress.
    pub stress: Mat3<f64>,
    /// Lower half of the tangent, row by row.
    lower: [f64; 45],
}

impl PointState {
    /// A point that nothing was computed for.
    pub(crate) const EMPTY: Self = Self { h: Mat3::ZERO, stress: Mat3::ZERO, lower: [0.0; 45] };

    /// Row and column of each entry of the lower half.
    const ENTRIES: [[usize; 2]; 45] = {
        let (mut entries, mut at) = ([[0; 2]; 45], 0);
        while at < 44 {
            let [row, column] = entries[at];
            at += 1;
            entries[at] = if column < row { [row, column + 1] } else { [row + 1, 0] };
        }
        entries
    };

    #[inline]
    pub(crate) fn new(h: &Mat3<f64>, Response { stress, tangent, .. }: &Response) -> Self {
        let lower = Self::ENTRIES.map(|[row, column]| tangent[row][column]);
        Self { h: *h, stress: *stress, lower }
    }

    /// Tangent ∂P/∂H.
    pub(crate) fn tangent(&self) -> [[f64; 9]; 9] {
        let mut tangent = [[0.0; 9]; 9];
        for ([row, column], entry) in Self::ENTRIES.into_iter().zip(self.lower) {
            (tangent[row][column], tangent[column][row]) = (entry, entry);
        }
        tangent
    }

    /// Replaces the mean Cauchy stress in the tangent.
    pub(crate) fn set_mean_stress(&mut self, mean: f64) {
        let (mut tangent, more) = (self.tangent(), mean - mean_stress(&self.h, &self.stress));
        self.h.plus_identity().add_second_of_determinant(more, &mut tangent);
        self.lower = Self::ENTRIES.map(|[row, column]| tangent[row][column]);
    }
}

/// Mean Cauchy stress `P : F / 3J`.
pub(crate) fn mean_stress(h: &Mat3<f64>, stress: &Mat3<f64>) -> f64 {
    let f = h.plus_identity();
    dot(stress.0.as_flattened(), f.0.as_flattened()) / (3.0 * (1.0 + h.volume_change()))
}
