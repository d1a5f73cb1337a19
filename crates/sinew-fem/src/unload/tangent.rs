//! The derivative of the balance of the image in the positions at rest.

use super::lu::Entries;
use crate::linear::Sparsity;
use crate::unload::state::{Image, Level, PointRate, Tensor};
use nalgebra::{Matrix3, Vector3};
use sinew_energy::{Body, ReferenceSurface};
use sinew_num::{Scalar, Slope, cross, dot3, try_in_parallel};

/// Number of cells that are computed on all threads before they are added.
const AT_ONCE: usize = 2048;

/// The derivative, and its product with a motion of the supports.
pub(super) struct Tangent {
    pub entries: Entries,
    /// The derivative times a motion of the supports, Cartesian over all degrees of freedom.
    pub by_motion: Vec<f64>,
}

/// A square matrix over the components of some nodes.
struct Block<'n> {
    nodes: &'n [usize],
    values: Vec<f64>,
}

impl<'n> Block<'n> {
    fn new(nodes: &'n [usize]) -> Self {
        Self { nodes, values: vec![0.0; 9 * nodes.len() * nodes.len()] }
    }

    fn size(&self) -> usize {
        3 * self.nodes.len()
    }

    /// Adds `weight × g_aj T_ijkl g_bl` of the nodes at `local` places.
    fn add_point(&mut self, local: &[usize], shape: &[[f64; 3]], weight: f64, rate: &Tensor) {
        let size = self.size();
        for (&a, g) in local.iter().zip(shape) {
            for i in 0..3 {
                let left: [f64; 9] = std::array::from_fn(|kl| {
                    let column = |j: usize| g[j] * rate[3 * i + j][kl];
                    weight * (column(0) + column(1) + column(2))
                });
                let row = &mut self.values[(3 * a + i) * size..][..size];
                for (&b, g) in local.iter().zip(shape) {
                    for k in 0..3 {
                        row[3 * b + k] +=
                            left[3 * k] * g[0] + left[3 * k + 1] * g[1] + left[3 * k + 2] * g[2];
                    }
                }
            }
        }
    }

    /// Adds `column ⊗ row`.
    fn add_product(&mut self, column: &[f64], row: &[f64]) {
        for (values, c) in self.values.chunks_exact_mut(row.len()).zip(column) {
            values.iter_mut().zip(row).for_each(|(value, r)| *value += c * r);
        }
    }
}

/// Adds `weight × v : ∇` of a matrix v to a vector over the nodes at `local` places.
fn add_gradient(
    to: &mut [f64],
    local: &[usize],
    shape: &[[f64; 3]],
    weight: f64,
    v: &Matrix3<f64>,
) {
    for (&b, &g) in local.iter().zip(shape) {
        let product = weight * v * Vector3::from(g);
        (0..3).for_each(|k| to[3 * b + k] += product[k]);
    }
}

impl Image<'_> {
    /// The derivative at a body at rest with the displacement that leads to the image; `motion` is one of the supports that is still to be
    /// made. `None` where it overflows.
    pub(super) fn tangent(
        &self,
        (rest, displacement): (&Body, &[f64]),
        level: &Level,
        motion: Option<&[f64]>,
    ) -> Option<Tangent> {
        let sparsity = &*self.system.sparsity;
        let by_motion = vec![0.0; displacement.len()];
        let mut tangent = Tangent { entries: Entries::zero(sparsity), by_motion };
        let mut add = |block: Block<'_>, matrix: Option<usize>| {
            let places = matrix.map(|matrix| sparsity.cells.of(matrix));
            tangent.add(sparsity, block, places, motion);
        };
        let (body, carries) = (self.system.body, self.carries());
        let at = At { body, rest, displacement, level, carries };
        let matrices = if body.patches.is_empty() { body.cell_count() } else { body.patches.len() };
        let of_matrix = |index: usize| match sparsity.patches.get(index) {
            Some(nodes) => at.patch(&body.patches[index], nodes),
            None => at.cell(index, body.nodes_of_cell(index)),
        };
        for first in (0..matrices).step_by(AT_ONCE) {
            // On all threads, then added one after the other: numbers do not depend on the count of threads.
            let range = first..matrices.min(first + AT_ONCE);
            let blocks = try_in_parallel(range.clone(), |index| of_matrix(index).ok_or(()));
            for (block, index) in blocks.ok()?.into_iter().zip(range) {
                add(block, Some(index));
            }
        }
        for surface in &body.reference_loads.surfaces {
            for facet in surface.facets() {
                add(at.facet(surface, facet), None);
            }
        }
        Some(tangent)
    }
}

/// The state at which the derivative is taken.
struct At<'a> {
    /// Image.
    body: &'a Body,
    rest: &'a Body,
    displacement: &'a [f64],
    level: &'a Level,
    /// Whether material directions move with the body.
    carries: bool,
}

impl At<'_> {
    fn cell<'n>(&self, cell: usize, nodes: &'n [usize]) -> Option<Block<'n>> {
        let Self { body, rest, displacement, level, carries } = *self;
        let parameters = rest.law_parameters(&level.theta);
        let mut block = Block::new(nodes);
        let local: Vec<_> = (0..nodes.len()).collect();
        let first = cell * body.points_per_cell;
        for point in first..first + body.points_per_cell {
            let h = rest.displacement_gradient(point, displacement);
            let rate = PointRate::new(rest, point, parameters, [&h, &h], carries)?;
            let (shape, volume) = (body.shape_of_point(point), rest.volumes[point]);
            block.add_point(&local, shape, volume, &rate.with_volume(0.0));
            self.add_force(&mut block, &local, point, &rate);
        }
        Some(block)
    }

    /// The body force on a cell grows with its volume at rest.
    fn add_force(&self, block: &mut Block<'_>, local: &[usize], point: usize, rate: &PointRate) {
        let (body, loads) = (self.body, &self.body.reference_loads);
        let weight = self.level.factor * self.rest.volumes[point];
        if loads.body_force == [0.0; 3] {
            return;
        }
        let mut row = vec![0.0; block.size()];
        add_gradient(&mut row, local, body.shape_of_point(point), -weight, &rate.trace);
        let mut column = vec![0.0; block.size()];
        for (&a, n) in local.iter().zip(&loads.shapes[point % body.points_per_cell]) {
            (0..3).for_each(|i| column[3 * a + i] += n * loads.body_force[i]);
        }
        block.add_product(&column, &row);
    }

    /// Points of one mean volume ratio J̄: with F̄ = eˢ F and s = ⅓ ln J̄/J forces are those of `V dev τ̄ + v π I`, where
    /// π = Σ ⅓V tr τ̄ / Σv. What they have in common are β = δ ln J̄ = −Σ V tr D / ΣV and δπ.
    fn patch<'n>(&self, points: &[usize], nodes: &'n [usize]) -> Option<Block<'n>> {
        let Self { body, rest, displacement, level, carries } = *self;
        let parameters = rest.law_parameters(&level.theta);
        let kinematics = rest.patch_kinematics(points, displacement)?;
        let mut block = Block::new(nodes);
        let vector = || vec![0.0; 3 * nodes.len()];
        let (mut by_mean, mut mean) = (vector(), vector());
        let (mut by_pressure, mut pressure, mut slope) = (vector(), vector(), 0.0);
        let now: f64 = points.iter().map(|&point| body.volumes[point]).sum();
        let places = |point: usize| -> Vec<usize> {
            let place = |&node: &usize| nodes.partition_point(|&n| n < node);
            body.nodes_of_point(point).iter().map(place).collect()
        };
        for (at, &point) in points.iter().enumerate() {
            let (h, scaled) = (&kinematics.gradients[at], &kinematics.scaled[at]);
            let rate = PointRate::new(rest, point, parameters, [h, scaled], carries)?;
            let (shape, volume) = (body.shape_of_point(point), rest.volumes[point]);
            let local = places(point);
            let mut whole = rate.with_volume(1.0 / 3.0);
            let third = Matrix3::from_fn(|k, l| {
                [0, 4, 8].map(|row| whole[row][3 * k + l]).iter().sum::<f64>() / 3.0
            });
            for row in [0, 4, 8] {
                let entries = whole[row].iter_mut().enumerate();
                entries.for_each(|(kl, entry)| *entry -= third[(kl / 3, kl % 3)]);
            }
            block.add_point(&local, shape, volume, &whole);
            self.add_force(&mut block, &local, point, &rate);
            add_gradient(&mut mean, &local, shape, -volume / kinematics.volume, &rate.trace);
            add_gradient(&mut pressure, &local, shape, volume / now, &third);
            let trace = rate.by_scale.trace() / 3.0;
            slope += volume * trace / (3.0 * now);
            let deviator = (rate.by_scale - Matrix3::from_diagonal_element(trace)) / 3.0;
            add_gradient(&mut by_mean, &local, shape, volume, &deviator);
            let volume = body.volumes[point];
            add_gradient(&mut by_pressure, &local, shape, volume, &Matrix3::identity());
        }
        pressure.iter_mut().zip(&mean).for_each(|(p, m)| *p += slope * m);
        block.add_product(&by_mean, &mean);
        block.add_product(&by_pressure, &pressure);
        Some(block)
    }

    /// The dead traction and the springs of a facet, whose area and normal change.
    fn facet<'n>(&self, surface: &ReferenceSurface, facet: &'n [usize]) -> Block<'n> {
        let Self { rest, displacement, level, .. } = *self;
        let mut block = Block::new(facet);
        let (size, plane) = (block.size(), surface.rule.dimension == 2);
        for point in &surface.rule.points {
            let [s, t] = surface.rule.tangents(facet, point, &rest.positions);
            let normal = cross(&s, &t);
            if dot3(&normal, &normal) == 0.0 {
                continue;
            }
            let u = std::array::from_fn(|i| {
                let nodes = facet.iter().zip(&point.shape);
                nodes.map(|(&node, n)| n * displacement[3 * node + i]).sum()
            });
            // Force per area of the reference element, with derivatives in both tangents and the displacement.
            let [s, t, u] = [(s, 0), (t, 3), (u, 6)].map(|(vector, first): ([f64; 3], _)| {
                [0, 1, 2].map(|i| Slope::<9>::variable(vector[i], first + i))
            });
            let normal = cross(&s, &t);
            let area = (dot3(&normal, &normal).ln() * 0.5).exp();
            let along = dot3(&normal, &u) / area * (surface.normal - surface.tangential);
            for row in 0..size {
                let (a, i) = (row / 3, row % 3);
                let traction = -level.factor * surface.traction[i];
                let force = area * (u[i] * surface.tangential + traction) + along * normal[i];
                for column in 0..size {
                    let (b, k) = (column / 3, column % 3);
                    let across = if plane { 0.0 } else { point.slope[1][b] };
                    let own = point.shape[b] * force.gradient[6 + k];
                    let moved =
                        point.slope[0][b] * force.gradient[k] + across * force.gradient[3 + k];
                    block.values[row * size + column] +=
                        point.weight * point.shape[a] * (moved - own);
                }
            }
        }
        block
    }
}

impl Tangent {
    fn add(
        &mut self,
        sparsity: &Sparsity,
        mut block: Block<'_>,
        places: Option<&[u32]>,
        motion: Option<&[f64]>,
    ) {
        let size = block.size();
        if let Some(motion) = motion {
            let moved = |local: usize| motion[3 * block.nodes[local / 3] + local % 3];
            let moved: Vec<f64> = (0..size).map(moved).collect();
            for (local, row) in block.values.chunks_exact(size).enumerate() {
                self.by_motion[3 * block.nodes[local / 3] + local % 3] +=
                    row.iter().zip(&moved).map(|(k, m)| k * m).sum::<f64>();
            }
        }
        self.entries.add(sparsity, block.nodes, places, &mut block.values);
    }
}
