//! Displacements beyond those of linear cells: a quadratic mode for each edge of a simplex, and three incompatible modes for
//! each hexahedron.

use crate::elements::tangent_times;
use crate::linear::add;
use nalgebra::{Matrix3, Vector3};
use sinew_energy::{Body, BodyArrays, SurfaceResponse};
use sinew_mesh::{TriangleMesh, edges};
use sinew_num::Mat3;

/// Most modes of one cell.
const MOST_MODES: usize = 6;
/// Coordinate of Gauss' points of a hexahedron.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// A vector for each mode.
pub(super) type Modes = Vec<[f64; 3]>;

/// Cells with their modes and tangents.
///
/// Simplices have the mode `4 λ_i λ_j` on the edge of corners i and j, that of the hierarchical quadratic element (Zienkiewicz, Taylor & Zhu,
/// *The Finite Element Method: Its Basis and Fundamentals*, 4.9), and hexahedra `1 − ξ_r²` (R. L. Taylor, P. J. Beresford & E. L. Wilson,
/// Int. J. Numer. Meth. Engng 10, 1976).
pub(super) struct Enriched<'b> {
    body: &'b Body,
    per_cell: usize,
    /// Edges of simplices as [`sinew_mesh::edges`] has them.
    edges: Vec<[usize; 2]>,
    /// Modes of the cells, one cell after the other.
    modes: Vec<usize>,
    /// Gradients of the modes of a cell at its points [1/length]; as many points as corners.
    gradients: Vec<[[f64; 3]; MOST_MODES]>,
    /// Tangent at each quadrature point of the body.
    tangents: Vec<[[f64; 9]; 9]>,
    /// Projection of each mode on the directions that supports leave free.
    free: Vec<Matrix3<f64>>,
    /// Inverse of the diagonal block of each mode.
    inverse: Vec<Matrix3<f64>>,
}

impl<'b> Enriched<'b> {
    pub(super) fn new(body: &'b Body, tangents: Vec<[[f64; 9]; 9]>) -> Self {
        let (edges, modes, gradients, free) = match body.element().corners {
            8 => of_hexahedra(body),
            _ => of_simplices(body),
        };
        let (per_cell, inverse) = (modes.len() / body.cell_count(), Vec::new());
        let mut enriched =
            Self { body, per_cell, edges, modes, gradients, tangents, free, inverse };
        enriched.invert_diagonal();
        enriched
    }

    /// Calls `visit` with each point: the body's, the modes of its cell, their gradients and its volume.
    fn for_points(&self, mut visit: impl FnMut(usize, &[usize], &[[f64; 3]; MOST_MODES], f64)) {
        let corners = self.body.element().corners;
        let own = self.body.points_per_cell;
        let share = own as f64 / corners as f64;
        for (cell, modes) in self.modes.chunks_exact(self.per_cell).enumerate() {
            for at in 0..corners {
                let point = cell * own + at.min(own - 1);
                let gradients = &self.gradients[cell * corners + at];
                visit(point, modes, gradients, share * self.body.volumes[point]);
            }
        }
    }

    fn invert_diagonal(&mut self) {
        let mut blocks = vec![Matrix3::zeros(); self.free.len()];
        self.for_points(|point, modes, gradients, volume| {
            let tangent = &self.tangents[point];
            for (&mode, g) in modes.iter().zip(gradients) {
                for k in 0..3 {
                    let mut h = Mat3::ZERO;
                    h.0[k] = *g;
                    let force = tangent_times(tangent, &h).apply(g);
                    (0..3).for_each(|i| blocks[mode][(i, k)] += volume * force[i]);
                }
            }
        });
        let inverse = |(block, free): (&Matrix3<f64>, &Matrix3<f64>)| {
            let held = (Matrix3::identity() - free) * block.trace();
            let inverse = (free * block * free + held).try_inverse().unwrap_or_default();
            free * inverse * free
        };
        self.inverse = blocks.iter().zip(&self.free).map(inverse).collect();
    }

    /// Residual of the modes times the inverse of their diagonal blocks.
    pub(super) fn precondition(&self, residual: &Modes) -> Modes {
        let pairs = residual.iter().zip(&self.inverse);
        pairs.map(|(&r, inverse)| (inverse * Vector3::from(r)).into()).collect()
    }

    /// Forces on the modes of a displacement of the nodes.
    pub(super) fn couple(&self, displacement: &[f64]) -> Modes {
        let mut forces = vec![[0.0; 3]; self.free.len()];
        // A simplex has one stress for all its points.
        let mut last = (usize::MAX, Mat3::ZERO);
        self.for_points(|point, modes, gradients, volume| {
            if last.0 != point {
                let h = self.body.displacement_gradient(point, displacement);
                last = (point, tangent_times(&self.tangents[point], &h));
            }
            add_forces(&last.1, volume, modes, gradients, &mut forces);
        });
        self.project(&mut forces);
        forces
    }

    /// Forces of the modes on the nodes and on themselves.
    pub(super) fn multiply(&self, values: &Modes) -> (Vec<f64>, Modes) {
        let mut nodal = vec![0.0; self.body.prescribed.len()];
        let mut own = vec![[0.0; 3]; self.free.len()];
        self.for_points(|point, modes, gradients, volume| {
            let mut h = Mat3::ZERO;
            for (&mode, g) in modes.iter().zip(gradients) {
                for i in 0..3 {
                    (0..3).for_each(|j| h.0[i][j] += values[mode][i] * g[j]);
                }
            }
            let stress = tangent_times(&self.tangents[point], &h);
            add_forces(&stress, volume, modes, gradients, &mut own);
            let share = volume / self.body.volumes[point];
            let stress = Mat3::from_fn(|i, j| share * stress[i][j]);
            self.body.add_forces(point, &stress, &mut nodal);
        });
        self.project(&mut own);
        (nodal, own)
    }

    /// Adds the forces of stresses on the modes.
    pub(super) fn add_stresses(&self, stress: impl Fn(usize) -> Mat3<f64>, forces: &mut Modes) {
        self.for_points(|point, modes, gradients, volume| {
            add_forces(&stress(point), volume, modes, gradients, forces);
        });
        self.project(forces);
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
        self.for_points(|_, modes, _, volume| {
            let force = reference_loads.body_force.map(|b| share * volume * b);
            modes.iter().for_each(|&mode| add(&mut forces[mode], 1.0, &force));
        });
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

/// Edges, modes of the cells, gradients at their points and free directions, as [`Enriched`] has them.
type Parts = (Vec<[usize; 2]>, Vec<usize>, Vec<[[f64; 3]; MOST_MODES]>, Vec<Matrix3<f64>>);

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
    let (of_cell, corners) = (body.element().edges, body.element().corners);
    let (all, mut modes) = (body.mesh.edges(), Vec::new());
    for nodes in body.cell_nodes() {
        let ends = of_cell.iter().map(|edge| descending(nodes[edge[0]], nodes[edge[1]]));
        modes.extend(ends.map(|ends| all.partition_point(|other| *other < ends)));
    }
    // Points of degree 2: λ is `high` at one corner and `low` at the others.
    let n = corners as f64;
    let step = (n + 1.0).sqrt().recip();
    let low = (1.0 - step) / n;
    let mut gradients = Vec::with_capacity(corners * body.cell_count());
    for cell in 0..body.cell_count() {
        let g = body.shape_of_point(cell);
        for point in 0..corners {
            let weight = |corner| 4.0 * if corner == point { low + step } else { low };
            let mut of_point = [[0.0; 3]; MOST_MODES];
            for (mode, edge) in of_cell.iter().enumerate() {
                let [a, b] = [edge[0], edge[1]];
                of_point[mode] = [0, 1, 2].map(|j| weight(a) * g[b][j] + weight(b) * g[a][j]);
            }
            gradients.push(of_point);
        }
    }
    let free = free_directions(body, &all);
    (all, modes, gradients, free)
}

fn add_forces(
    stress: &Mat3<f64>,
    volume: f64,
    modes: &[usize],
    gradients: &[[f64; 3]; MOST_MODES],
    forces: &mut Modes,
) {
    for (&mode, g) in modes.iter().zip(gradients) {
        add(&mut forces[mode], volume, &stress.apply(g));
    }
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
