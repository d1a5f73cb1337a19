//! A patch of quadrature points with one volume ratio: its derivatives.

use crate::elements::{NodalBlocks, add_stiffness, complete, inverse, tangent_times};
use crate::linear::patch_nodes_of;
use sinew_energy::{Body, Response};
use sinew_num::Mat3;

/// Energy of a patch with its derivatives.
///
/// With β = d ln J̄ and the change dF at a point, the second variation of the energy is
/// `Σ V dF:M:dF + 2 β Σ V m:dF + c β²`. M belongs to the points, the rest are vectors over the degrees of
/// freedom of the patch.
#[derive(Clone, Debug)]
pub(crate) struct PatchResponse {
    pub energy: f64,
    /// Nodes of the patch, ascending.
    pub nodes: Vec<usize>,
    /// `∂ ln J̄/∂u`.
    mean: Vec<f64>,
    /// `Σ V Gᵀ m`.
    mixed: Vec<f64>,
    /// c.
    square: f64,
    /// m and `∂ ln J̄/∂F` over the volume at each point.
    rates: Vec<[Mat3<f64>; 2]>,
}

/// Displacement gradient, stress and M at a point.
type PatchPoint = (Mat3<f64>, Response);

impl PatchResponse {
    /// Also the displacement gradient, stress and M at each point. `None` where a cell is inverted or an energy overflows.
    pub(crate) fn new(
        body: &Body,
        points: &[usize],
        displacement: &[f64],
        parameters: &[f64],
    ) -> Option<(Self, Vec<PatchPoint>)> {
        let kinematics = body.patch_kinematics(points, displacement)?;
        let volumes: Vec<_> = points.iter().map(|&point| body.volumes[point]).collect();
        let at_points = || points.iter().zip(&kinematics.scaled);
        let scaled: Vec<_> =
            at_points().map(|(&point, h)| body.material.response(point, parameters, h)).collect();
        let energy = scaled.iter().zip(&volumes).map(|(r, v)| v * r.energy).sum();
        let mut stresses: Vec<_> = scaled.iter().map(|r| r.stress).collect();
        let (thirds, common) = kinematics.thirds(&volumes, &stresses);
        kinematics.work_conjugate(&volumes, &mut stresses);

        let nodes = patch_nodes_of(body, points);
        // Adds `weight × Gᵀ values` to a vector over the patch.
        let add = |vector: &mut [f64], point: usize, values: &Mat3<f64>, weight: f64| {
            for (node, g) in body.nodes_of_point(point).iter().zip(body.shape_of_point(point)) {
                let local = nodes.partition_point(|n| n < node);
                let product = values.apply(g);
                (0..3).for_each(|i| vector[3 * local + i] += weight * product[i]);
            }
        };
        let (mut mean, mut mixed) = (vec![0.0; 3 * nodes.len()], vec![0.0; 3 * nodes.len()]);
        let room = points.len();
        let (mut responses, mut rates) = (Vec::with_capacity(room), Vec::with_capacity(room));
        let mut square = 0.0;
        for (at, &point) in points.iter().enumerate() {
            let (h, volume, third) = (kinematics.gradients[at], volumes[at], thirds[at]);
            let terms = Terms::new(&h, &kinematics.scaled[at], kinematics.scales[at], &scaled[at]);
            let ratio = volume / (kinematics.volume * kinematics.mean);
            add(&mut mean, point, &terms.cofactor, ratio);
            let own = terms.mixed(third);
            add(&mut mixed, point, &own, volume);
            rates.push([own, Mat3::from_fn(|i, j| terms.cofactor[i][j] * ratio / volume)]);
            square += volume * (terms.square - 2.0 / 3.0 * third);
            let (stress, tangent) = (stresses[at], terms.tangent(third, common));
            responses.push((h, Response { energy: scaled[at].energy, stress, tangent }));
        }
        Some((Self { energy, nodes, mean, mixed, square, rates }, responses))
    }

    /// The stiffness against changes of the mean volume \[stress\]: the bulk modulus, for small strain.
    pub(crate) fn common_stiffness(&self, body: &Body, points: &[usize]) -> f64 {
        self.square.abs() / points.iter().map(|&point| body.volumes[point]).sum::<f64>()
    }

    /// Lower half of the second derivative, row by row in the order of the patch's nodes, from M at the points.
    pub(crate) fn stiffness<const N: usize>(
        &self,
        body: &Body,
        points: &[usize],
        mut tangents: impl Iterator<Item = [[f64; 9]; 9]>,
    ) -> Vec<f64> {
        let mut lower = Vec::with_capacity(self.mean.len() * (self.mean.len() + 1) / 2);
        for row in 0..self.mean.len() {
            let (own, mixed) = (self.mean[row], self.mixed[row] + self.square * self.mean[row]);
            let columns = self.mean[..=row].iter().zip(&self.mixed[..=row]);
            lower.extend(columns.map(|(mean, other)| own * other + mixed * mean));
        }
        let shapes = body.shape_gradients.as_chunks::<N>().0;
        let cell = |point: &usize| point / body.points_per_cell;
        for of_cell in points.chunk_by(|a, b| cell(a) == cell(b)) {
            let mut blocks: NodalBlocks<N> = [[[[0.0; 3]; N]; 3]; N];
            for (&point, tangent) in of_cell.iter().zip(&mut tangents) {
                let volume = body.volumes[point];
                add_stiffness(&tangent, &shapes[point], volume, &mut blocks);
            }
            complete(&mut blocks);
            let nodes = &body.cells.as_chunks::<N>().0[cell(&of_cell[0])];
            let local = nodes.map(|node| self.nodes.partition_point(|&n| n < node));
            for a in 0..N {
                for i in 0..3 {
                    for (slot, value) in
                        blocks[a][i].as_flattened()[..=3 * a + i].iter().enumerate()
                    {
                        let [one, other] = [3 * local[a] + i, 3 * local[slot / 3] + slot % 3];
                        let (row, column) = (one.max(other), one.min(other));
                        lower[row * (row + 1) / 2 + column] += value;
                    }
                }
            }
        }
        lower
    }

    /// The patch without the terms of the mean volume.
    pub(crate) fn without_mean(&self) -> Self {
        let zeros = vec![0.0; self.mean.len()];
        Self { mean: zeros.clone(), mixed: zeros, ..self.clone() }
    }

    fn degree_of_freedom(&self, slot: usize) -> usize {
        3 * self.nodes[slot / 3] + slot % 3
    }

    /// Products of `mean` and `mixed` with a change of all degrees of freedom.
    fn along(&self, direction: &[f64]) -> (f64, f64) {
        let product = |vector: &[f64]| -> f64 {
            let terms = vector.iter().enumerate();
            terms.map(|(slot, v)| v * direction[self.degree_of_freedom(slot)]).sum()
        };
        (product(&self.mean), product(&self.mixed))
    }

    /// First-order change of the stress at each point beyond M with a change of all degrees of freedom.
    pub(crate) fn common_stress(&self, direction: &[f64]) -> impl Iterator<Item = Mat3<f64>> {
        let (mean, mixed) = self.along(direction);
        self.rates.iter().map(move |[own, common]| {
            Mat3::from_fn(|i, j| mean * own[i][j] + (mixed + self.square * mean) * common[i][j])
        })
    }

    /// Adds the terms of J̄ in the second derivative times `direction` to `forces`.
    pub(crate) fn add_common_product(&self, direction: &[f64], forces: &mut [f64]) {
        let (mean, mixed) = self.along(direction);
        for slot in 0..self.mean.len() {
            forces[self.degree_of_freedom(slot)] +=
                self.mean[slot] * (mixed + self.square * mean) + self.mixed[slot] * mean;
        }
    }
}

/// Terms of the second derivatives at one point.
struct Terms<'r> {
    /// `(J̄/J)^(1/3)`.
    scale: f64,
    /// `∂ ln J/∂F`.
    slope: Mat3<f64>,
    /// cof F.
    cofactor: Mat3<f64>,
    /// Deformation gradient F.
    f: Mat3<f64>,
    response: &'r Response,
    /// `Â : F̄`.
    along: Mat3<f64>,
    /// `F̄ : Â : F̄ / 9`, the part of c from the tangent.
    square: f64,
}

impl<'r> Terms<'r> {
    fn new(h: &Mat3<f64>, scaled: &Mat3<f64>, scale: f64, response: &'r Response) -> Self {
        let (f, f_bar) = (h.plus_identity(), scaled.plus_identity());
        let flat = f_bar.0.as_flattened();
        let along = tangent_times(&response.tangent, &f_bar);
        let square = along.0.as_flattened().iter().zip(flat).map(|(a, f)| a * f).sum::<f64>() / 9.0;
        let inverse = inverse(h);
        let slope = Mat3::from_fn(|i, j| inverse[j][i]);
        Self { scale, slope, cofactor: f.cofactors(), f, response, along, square }
    }

    /// m: the derivative along F of the stress' work on a change of J̄.
    fn mixed(&self, third: f64) -> Mat3<f64> {
        let full = 9.0 * self.square;
        Mat3::from_fn(|i, j| {
            let along = self.scale * self.along[i][j] - full / 3.0 * self.slope[i][j];
            along / 3.0 + self.scale / 3.0 * self.response.stress[i][j]
                - third / 3.0 * self.slope[i][j]
        })
    }

    /// M, with the part of d²J̄ that belongs to the point, weighted by `common`.
    fn tangent(&self, third: f64, common: f64) -> [[f64; 9]; 9] {
        let (e, stress) = (self.scale, &self.response.stress);
        let mut tangent = [[0.0; 9]; 9];
        for row in 0..9 {
            let (i, j) = (row / 3, row % 3);
            let t_row = self.slope[i][j];
            for column in 0..9 {
                let (k, l) = (column / 3, column % 3);
                let t_column = self.slope[k][l];
                tangent[row][column] = e * e * self.response.tangent[row][column]
                    - e / 3.0 * (self.along[i][j] * t_column + t_row * self.along[k][l])
                    + self.square * t_row * t_column
                    - e / 3.0 * (stress[i][j] * t_column + t_row * stress[k][l])
                    + third / 3.0 * t_row * t_column
                    + third * self.slope[k][j] * self.slope[i][l];
            }
        }
        self.f.add_second_of_determinant(common, &mut tangent);
        tangent
    }
}
