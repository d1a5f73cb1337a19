//! Cells and patches in shares: energies, forces and stiffnesses that any thread may compute, and that are added in one order.

use crate::elements::{
    NodalBlocks, PatchResponse, Rounding, State, add_pressure, add_stiffness, complete, inverse,
    make_convex, product, turn,
};
use crate::linear::dot;
use sinew_energy::{Body, Response, with_nodes};
use sinew_num::{Mat3, in_parallel, in_tasks};
use std::ops::Range;

/// Quadrature points of a share: a fixed division, so that sums do not depend on the number of threads. The stiffnesses of so many tetrahedra take 40 KB.
const SHARE: usize = 64;
/// Shares that threads compute while those before are added.
const AT_ONCE: usize = 64;
/// Least number of quadrature points whose work is divided.
const LARGE: usize = 16_384;
/// Points of one task.
const TASK: usize = 512;

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

/// Second Piola–Kirchhoff stress at each quadrature point as Newton's linear model foresees it.
pub(crate) type PredictedStress = Vec<Mat3<f64>>;

/// `S : C / 3`: pJ for the stress `p J C⁻¹` of a pressure p.
pub(crate) fn third(f: &Mat3<f64>, stress: impl Fn(usize, usize) -> f64) -> f64 {
    let strain = |j: usize, l: usize| (0..3).map(|k| f[k][j] * f[k][l]).sum::<f64>();
    (0..9).map(|at| stress(at / 3, at % 3) * strain(at / 3, at % 3)).sum::<f64>() / 3.0
}

/// Puts the predicted stress into the geometric part `δ_ik S_jl` of a tangent. In a nearly incompressible body its pressure enters as `p ∂²J/∂F²`,
/// because the actual pressure contains the error in J times the bulk modulus.
pub(crate) fn replace_stress(
    tangent: &mut [[f64; 9]; 9],
    h: &Mat3<f64>,
    stress: &Mat3<f64>,
    with: &Mat3<f64>,
    nearly_incompressible: bool,
) {
    let (f, inverse) = (h.plus_identity(), inverse(h));
    let present = product(&inverse, stress);
    let change = Mat3::from_fn(|j, l| {
        0.5 * (with[j][l] + with[l][j]) - 0.5 * (present[j][l] + present[l][j])
    });
    let mut pressure = 0.0;
    if nearly_incompressible {
        pressure = third(&f, |j, l| change[j][l]);
        f.add_second_of_determinant(pressure / (1.0 + h.volume_change()), tangent);
    }
    for j in 0..3 {
        for l in 0..3 {
            let of_pressure = (0..3).map(|k| inverse[j][k] * inverse[l][k]).sum::<f64>();
            for i in 0..3 {
                tangent[3 * i + j][3 * i + l] += change[j][l] - pressure * of_pressure;
            }
        }
    }
}
