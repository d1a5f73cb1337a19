//! Displacements beyond those of linear cells: a quadratic mode for each edge of a simplex, and three incompatible modes for
//! each hexahedron.

use crate::elements::{PointState, at_points, tangent_times};
use crate::linear::add;
use nalgebra::{Matrix3, Vector3};
use sinew_energy::{Body, BodyArrays, SurfaceResponse};
use sinew_mesh::{TriangleMesh, edges};
use sinew_num::Mat3;

/// Most modes of one cell, and most nodes.
const MOST_MODES: usize = 6;
const MOST_NODES: usize = 8;
/// Coordinate of Gauss' points of a hexahedron.
const GAUSS: f64 = 0.577_350_269_189_625_8;
/// Cells whose forces are computed before they are added.
const AT_ONCE: usize = 1 << 16;

/// A vector for each mode.
pub(super) type Modes = Vec<[f64; 3]>;
/// Gradients of the modes of a cell at a point [1/length].
type Gradients = [[f64; 3]; MOST_MODES];

/// Forces of a cell.
#[derive(Clone, Default)]
struct Forces {
    nodes: [[f64; 3]; MOST_NODES],
    modes: [[f64; 3]; MOST_MODES],
}

/// Cells with their modes and tangents.
///
/// Simplices have the mode `4 λ_i λ_j` on the edge of corners i and j, that of the hierarchical quadratic element (Zienkiewicz, Taylor & Zhu,
/// *The Finite Element Method: Its Basis and Fundamentals*, 4.9), and hexahedra `1 − ξ_r²` (R. L. Taylor, P. J. Beresford & E. L. Wilson,
/// Int. J. Numer. Meth. Engng 10, 1976).
pub(super) struct Enriched<'a> {
    body: &'a Body,
    /// The quadrature points of the body with their tangents.
    points: &'a [PointState],
    per_cell: usize,
    /// Edges of simplices as [`sinew_mesh::edges`] has them.
    edges: Vec<[usize; 2]>,
    /// Modes of the cells, one cell after the other.
    modes: Vec<usize>,
    /// Gradients at the points of hexahedra.
    gradients: Vec<Gradients>,
    /// Barycentric coordinates of the points of simplices.
    weights: [f64; 2],
    /// Projection of each mode on the directions that supports leave free.
    free: Vec<Matrix3<f64>>,
    /// Inverse of the diagonal block of each mode.
    inverse: Vec<Matrix3<f64>>,
}

impl<'a> Enriched<'a> {
    pub(super) fn new(body: &'a Body, points: &'a [PointState]) -> Self {
        let (edges, modes, gradients, free) = match body.element().corners {
            8 => of_hexahedra(body),
            _ => of_simplices(body),
        };
        let (per_cell, inverse) = (modes.len() / body.cell_count(), Vec::new());
        let n = body.element().corners as f64;
        let step = (n + 1.0).sqrt().recip();
        let weights = [(1.0 - step) / n, (1.0 - step) / n + step];
        let mut enriched =
            Self { body, points, per_cell, edges, modes, gradients, weights, free, inverse };
        enriched.invert_diagonal();
        enriched
    }

    /// Calls `visit` with each point of a cell: as many as corners. Gives the body's point, its tangent, the gradients of the modes and the volume.
    fn for_points(
        &self,
        cell: usize,
        mut visit: impl FnMut(usize, &[[f64; 9]; 9], &Gradients, f64),
    ) {
        let Self { body, points, gradients, .. } = self;
        let (corners, own) = (body.element().corners, body.points_per_cell);
        let share = own as f64 / corners as f64;
        let mut tangent = points[cell * own].tangent();
        for at in 0..corners {
            let point = cell * own + at.min(own - 1);
            if own > 1 && at > 0 {
                tangent = points[point].tangent();
            }
            let volume = share * body.volumes[point];
            match gradients.get(cell * corners + at) {
                Some(gradients) => visit(point, &tangent, gradients, volume),
                None => visit(point, &tangent, &self.of_simplex(cell, at), volume),
            }
        }
    }

    /// Gradients of the modes of a simplex at a point of degree 2, where one barycentric coordinate is `high` and the others are `low`.
    fn of_simplex(&self, cell: usize, at: usize) -> Gradients {
        let (element, g) = (self.body.element(), self.body.shape_of_point(cell));
        let [low, high] = self.weights;
        let weight = |corner| if corner == at { 4.0 * high } else { 4.0 * low };
        let mut gradients = [[0.0; 3]; MOST_MODES];
        for (gradient, edge) in gradients.iter_mut().zip(element.edges) {
            let [a, b] = [edge[0], edge[1]];
            *gradient = [0, 1, 2].map(|j| weight(a) * g[b][j] + weight(b) * g[a][j]);
        }
        gradients
    }

    /// No displacement of any mode.
    pub(super) fn zeros(&self) -> Modes {
        vec![[0.0; 3]; self.free.len()]
    }

    fn modes_of(&self, cell: usize) -> &[usize] {
        &self.modes[self.per_cell * cell..self.per_cell * (cell + 1)]
    }

    /// Hands what is computed for each cell, on all threads, to `add` in their order.
    fn for_cells<T: Clone + Default + Send>(
        &self,
        of_cell: impl Fn(usize) -> T + Sync,
        mut add: impl FnMut(usize, T),
    ) {
        let count = self.body.cell_count();
        for first in (0..count).step_by(AT_ONCE) {
            let values = at_points(AT_ONCE.min(count - first), |at| of_cell(first + at));
            (first..).zip(values).for_each(|(cell, value)| add(cell, value));
        }
    }

    fn invert_diagonal(&mut self) {
        let mut blocks = vec![Matrix3::zeros(); self.free.len()];
        let of_cell = |cell: usize| {
            let mut of_modes = [Matrix3::zeros(); MOST_MODES];
            self.for_points(cell, |_, tangent, gradients, volume| {
                for (block, g) in of_modes[..self.per_cell].iter_mut().zip(gradients) {
                    for (row, entries) in tangent.iter().enumerate() {
                        let factor = volume * g[row % 3];
                        for k in 0..3 {
                            let sum: f64 = (0..3).map(|l| entries[3 * k + l] * g[l]).sum();
                            block[(row / 3, k)] += factor * sum;
                        }
                    }
                }
            });
            of_modes
        };
        self.for_cells(of_cell, |cell, of_modes| {
            self.modes_of(cell).iter().zip(of_modes).for_each(|(&mode, own)| blocks[mode] += own);
        });
        let inverse = |(block, free): (&Matrix3<f64>, &Matrix3<f64>)| {
            let held = (Matrix3::identity() - free) * block.trace();
            let inverse = (free * block * free + held).try_inverse().unwrap_or_default();
            free * inverse * free
        };
        self.inverse = blocks.iter().zip(&self.free).map(inverse).collect();
    }

    /// Residual of the modes times the inverse of their diagonal blocks.
    pub(super) fn precondition(&self, residual: &[[f64; 3]]) -> Modes {
        let pairs = residual.iter().zip(&self.inverse);
        pairs.map(|(&r, inverse)| (inverse * Vector3::from(r)).into()).collect()
    }

    /// Forces on the nodes and on the modes of a stress for each of them at each point of each cell, by the tangent, the modes and their gradients.
    fn forces(
        &self,
        stresses: impl Fn(usize, &[[f64; 9]; 9], &[usize], &Gradients) -> [Mat3<f64>; 2] + Sync,
    ) -> (Vec<f64>, Modes) {
        let mut nodal = vec![0.0; self.body.prescribed.len()];
        let mut own = self.zeros();
        let of_cell = |cell: usize| {
            let mut forces = Forces::default();
            self.for_points(cell, |point, tangent, gradients, volume| {
                let [on_nodes, on_modes] = stresses(point, tangent, self.modes_of(cell), gradients);
                for (to, g) in forces.nodes.iter_mut().zip(self.body.shape_of_point(point)) {
                    add_force(to, volume, &on_nodes, g);
                }
                for (to, g) in forces.modes.iter_mut().zip(gradients) {
                    add_force(to, volume, &on_modes, g);
                }
            });
            forces
        };
        self.for_cells(of_cell, |cell, forces| {
            let nodes = self.body.nodes_of_point(cell * self.body.points_per_cell);
            let of_nodes = nodes.iter().zip(&forces.nodes);
            of_nodes.for_each(|(&node, force)| add(&mut nodal[3 * node..], 1.0, force));
            let of_modes = self.modes_of(cell).iter().zip(&forces.modes);
            of_modes.for_each(|(&mode, force)| add(&mut own[mode], 1.0, force));
        });
        self.project(&mut own);
        (nodal, own)
    }

    /// Forces of the modes on the nodes, and of a displacement of the nodes and the modes on the modes.
    pub(super) fn multiply(&self, displacement: &[f64], values: &[[f64; 3]]) -> (Vec<f64>, Modes) {
        self.forces(|point, tangent, modes, gradients| {
            let mut h = Mat3::ZERO;
            for (&mode, g) in modes.iter().zip(gradients) {
                for i in 0..3 {
                    for j in 0..3 {
                        h.0[i][j] += values[mode][i] * g[j];
                    }
                }
            }
            let of_modes = tangent_times(tangent, &h);
            let of_nodes = self.body.displacement_gradient(point, displacement);
            add(h.0.as_flattened_mut(), 1.0, of_nodes.0.as_flattened());
            [of_modes, tangent_times(tangent, &h)]
        })
    }

    /// Adds the forces of stresses on the modes.
    pub(super) fn add_stresses(
        &self,
        stress: impl Fn(usize) -> Mat3<f64> + Sync,
        forces: &mut Modes,
    ) {
        let (_, more) = self.forces(|point, _, _, _| [Mat3::ZERO, stress(point)]);
        add(forces.as_flattened_mut(), 1.0, more.as_flattened());
    }

    /// Adds the loads on the modes of simplices.
    pub(super) fn add_loads(&self, displacement: &[f64], theta: &[f64], forces: &mut Modes) {
        let BodyArrays { reference_loads, positions, pressures, followers, .. } = &**self.body;
        if self.edges.is_empty() {
            return;
        }
        // ∫ 4 λ_i λ_j over the volume of the cell.
        let corners = self.body.element().corners as f64;
        let share = 4.0 / (corners * (corners + 1.0));
        for (cell, volume) in self.body.volumes.iter().enumerate() {
            let force = reference_loads.body_force.map(|b| share * volume * b);
            self.modes_of(cell).iter().for_each(|&mode| add(&mut forces[mode], 1.0, &force));
        }
        for surface in &reference_loads.surfaces {
            for facet in surface.facets() {
                let area = surface.rule.area(facet, positions);
                self.add_facet(facet, &surface.traction.map(|t| area * t), forces);
            }
        }
        let mut response = SurfaceResponse::default();
        for surface in pressures.iter().chain(followers) {
            let pressure = surface.magnitude.value(theta);
            // The forces of lids on edges of the rim change the estimate by 2 %.
            for (facet, nodes) in surface.nodes.chunks(surface.rule.nodes).enumerate() {
                surface.facet_force(facet, displacement, &mut response);
                let mut force = [0.0; 3];
                let (nodal, _) = response.gradient.as_chunks::<3>();
                nodal.iter().for_each(|part| add(&mut force, -pressure, part));
                self.add_facet(nodes, &force, forces);
            }
        }
        self.project(forces);
    }

    /// Adds a uniform load on a facet: a third of it to each edge of a triangle, two thirds to a segment.
    fn add_facet(&self, nodes: &[usize], force: &[f64; 3], forces: &mut Modes) {
        let share = if nodes.len() == 2 { 2.0 / 3.0 } else { 1.0 / 3.0 };
        for (at, &a) in nodes.iter().enumerate() {
            for &b in &nodes[..at] {
                if let Ok(mode) = self.edges.binary_search(&descending(a, b)) {
                    add(&mut forces[mode], share, force);
                }
            }
        }
    }

    fn project(&self, forces: &mut Modes) {
        let pairs = forces.iter_mut().zip(&self.free);
        pairs.for_each(|(force, free)| *force = (free * Vector3::from(*force)).into());
    }
}

fn add_force(to: &mut [f64; 3], volume: f64, Mat3(stress): &Mat3<f64>, g: &[f64; 3]) {
    for (to, row) in to.iter_mut().zip(stress) {
        *to += volume * (row[0] * g[0] + row[1] * g[1] + row[2] * g[2]);
    }
}

/// Edges, modes of the cells, gradients of those of hexahedra and free directions, as [`Enriched`] has them.
type Parts = (Vec<[usize; 2]>, Vec<usize>, Vec<Gradients>, Vec<Matrix3<f64>>);

/// An edge with the larger node first.
fn descending(a: usize, b: usize) -> [usize; 2] {
    [a.max(b), a.min(b)]
}

fn of_hexahedra(body: &Body) -> Parts {
    let corners = body.element().nodes;
    let sign = |corner: usize, r: usize| 2.0 * corners[corner][r] - 1.0;
    let mut gradients = Vec::with_capacity(body.volumes.len());
    for cell in 0..body.cell_count() {
        let points = 8 * cell..8 * cell + 8;
        // ∇ξ_r in the middle of the cell.
        let middle = [0, 1, 2].map(|r| {
            let slope = |j: usize| {
                let at = |point| body.shape_of_point(point).iter().enumerate();
                let sum = points.clone().flat_map(at).map(|(a, g)| sign(a, r) * g[j]);
                sum.sum::<f64>() / 8.0
            };
            [slope(0), slope(1), slope(2)]
        });
        let volume: f64 = body.volumes[points.clone()].iter().sum();
        for (corner, point) in points.enumerate() {
            // The factor lets a constant stress do no work on the modes.
            let ratio = volume / (8.0 * body.volumes[point]);
            let mut of_point = [[0.0; 3]; MOST_MODES];
            for r in 0..3 {
                of_point[r] = middle[r].map(|x| -2.0 * ratio * GAUSS * sign(corner, r) * x);
            }
            gradients.push(of_point);
        }
    }
    let count = 3 * body.cell_count();
    (Vec::new(), (0..count).collect(), gradients, vec![Matrix3::identity(); count])
}

fn of_simplices(body: &Body) -> Parts {
    let of_cell = body.element().edges;
    let (all, mut modes) = (body.mesh.edges(), Vec::new());
    for nodes in body.cell_nodes() {
        let ends = of_cell.iter().map(|edge| descending(nodes[edge[0]], nodes[edge[1]]));
        modes.extend(ends.map(|ends| all.partition_point(|other| *other < ends)));
    }
    let free = free_directions(body, &all);
    (all, modes, Vec::new(), free)
}

/// Projection on the directions that supports leave free in the middle of each edge: those along which not both ends are held.
fn free_directions(body: &Body, all: &[[usize; 2]]) -> Vec<Matrix3<f64>> {
    /// Cosine of the largest angle between axes of both ends, 8°.
    const SAME_AXIS: f64 = 0.99;
    let (triangles, _) = body.mesh.boundary_triangles();
    let outside = edges(&TriangleMesh { cells: triangles, ..TriangleMesh::default() });
    let axes = |node: usize| {
        let held = (3 * node..3 * node + 3).filter(|&dof| body.prescribed[dof].is_some());
        held.map(|dof| Vector3::from(body.frames.axis(dof)))
    };
    let plane = body.element().dimension == 2;
    let project = |edge: &[usize; 2]| {
        let mut free = Matrix3::identity();
        if !plane && outside.binary_search(edge).is_err() {
            return free;
        }
        for axis in axes(edge[0]) {
            if axes(edge[1]).any(|other| axis.dot(&other).abs() > SAME_AXIS) {
                free -= axis * axis.transpose();
            }
        }
        free
    };
    all.iter().map(project).collect()
}
