//! Predictor of a path of equilibria: stretches and rotations are extrapolated, because displacements are no polynomial
//! once a body rotates.
//!
//! At each quadrature point F = R U of the last equilibria gives a stretch, extrapolated by components, and a rotation,
//! extrapolated by its vector relative to the last one. The displacement is the one whose gradient is nearest to them,
//! `min Σ V |∇u − (R U − I)|²`: one linear system of the stiffness' sparsity. On beams that roll up under a loose
//! pressure steps are twice as long as with displacements on a polynomial, and take fewer iterations (docs/design.md).
//!
//! Supports that turn far defeat it: load increments lead them along straight lines.

use crate::Method;
use crate::elements::{System, place};
use crate::linear::MOST_SHIFTS;
use nalgebra::{Matrix3, Rotation3, Vector3};
use sinew_energy::Body;
use sinew_num::Mat3;

/// Residual of conjugate gradients for a prediction.
const ACCURACY: f64 = 1e-4;

impl System<'_> {
    /// Overwrites an extrapolated displacement with the one whose gradients are nearest to extrapolated stretches and
    /// rotations; `terms` are the earlier displacements, the last one last, with their weights. Bodies without a
    /// support along some direction, and those with averaged volume ratios, keep the extrapolated one.
    pub(crate) fn turn_along(&mut self, terms: &[(f64, &[f64])], load_factor: f64, u: &mut [f64]) {
        if !self.body.patches.is_empty() || terms.len() < 2 {
            return;
        }
        place(self.body, load_factor, u);
        let mut forces = vec![0.0; u.len()];
        for point in 0..self.body.volumes.len() {
            let gradient = |u: &[f64]| self.body.displacement_gradient(point, u);
            let wanted = extrapolated(terms.iter().map(|&(weight, u)| (weight, gradient(u))));
            let present = gradient(u);
            let off = Mat3::from_fn(|i, j| present[i][j] - wanted[(i, j)]);
            self.body.add_forces(point, &off, &mut forces);
        }
        self.assemble_laplacian();
        if self.method == Method::Aggregation {
            self.aggregation.drop_hierarchy();
            let right: Vec<f64> = self.sparsity.gather(&forces).map(|f| -f).collect();
            if let Some((change, _)) = self.iterate(&right, ACCURACY, MOST_SHIFTS) {
                self.sparsity.scatter(change, u);
            }
        } else if self.factor.positive_definite(&self.sparsity, &self.assembly.matrix) {
            self.add_newton_step(&forces, u);
        }
    }

    /// Assembles `Σ V g_a·g_b` for each component.
    fn assemble_laplacian(&mut self) {
        let Self { body, sparsity, assembly, .. } = self;
        assembly.matrix.fill(0.0);
        let mut products = Vec::new();
        for (cell, nodes) in body.cell_nodes().enumerate() {
            let (count, first) = (nodes.len(), cell * body.points_per_cell);
            products.clear();
            products.resize(count * count, 0.0);
            for point in first..first + body.points_per_cell {
                let (shape, volume) = (body.shape_of_point(point), body.volumes[point]);
                for (at, product) in products.iter_mut().enumerate() {
                    let (g, h) = (&shape[at / count], &shape[at % count]);
                    *product += volume * (g[0] * h[0] + g[1] * h[1] + g[2] * h[2]);
                }
            }
            let entry = |row: usize, column: usize| {
                let same = row % 3 == column % 3;
                if same { products[row / 3 * count + column / 3] } else { 0.0 }
            };
            let places = sparsity.cells.of(cell);
            assembly.add_matrix(&sparsity.frames, nodes, places, entry);
        }
    }
}

/// `R U − I` from weighted displacement gradients, the last one last.
fn extrapolated(gradients: impl DoubleEndedIterator<Item = (f64, Mat3<f64>)>) -> Matrix3<f64> {
    let (mut stretch, mut turn) = (Matrix3::zeros(), Vector3::zeros());
    let mut last: Option<Rotation3<f64>> = None;
    for (weight, h) in gradients.rev() {
        let f = Matrix3::from_fn(|i, j| h[i][j]) + Matrix3::identity();
        let rotation = rotation_of(&f);
        stretch += weight * (rotation.inverse() * f);
        let last = *last.get_or_insert(rotation);
        turn += weight * (rotation * last.inverse()).scaled_axis();
    }
    let last = last.unwrap_or_else(Rotation3::identity);
    Rotation3::new(turn) * last * stretch - Matrix3::identity()
}

/// R of F = R U. With the rotation of nalgebra's singular value decomposition paths of large stretches end early (nine hard cases).
fn rotation_of(f: &Matrix3<f64>) -> Rotation3<f64> {
    // Higham's iteration: the mean with the inverse transpose, quadratic in convergence.
    const MOST: usize = 30;
    let mut r = *f;
    for _ in 0..MOST {
        let Some(inverse) = r.try_inverse() else { return Rotation3::identity() };
        let next = 0.5 * (r + inverse.transpose());
        let change = (next - r).norm();
        r = next;
        if change < 1e-12 {
            break;
        }
    }
    Rotation3::from_matrix_unchecked(r)
}

/// A motion is one of a rigid body when its nodes are no farther off [relative to their distance from the centre]: coordinates of files.
const RIGID: f64 = 1e-4;
/// Rotation above which the failure is attributed to it \[degrees\]: halfway the held part is only half as wide.
const FAR: f64 = 120.0;

/// Angle \[degrees\] by which a prescribed motion turns the nodes that it moves as a rigid body, if it is far.
pub(crate) fn far_turn(body: &Body) -> Option<f64> {
    let held = |node: usize| -> Option<Vector3<f64>> {
        let [x, y, z] = [0, 1, 2].map(|i| body.prescribed[3 * node + i]);
        Some(Vector3::new(x?, y?, z?)).filter(|u| body.frames.get(node).is_none() && u.norm() > 0.0)
    };
    let moved = (0..body.nodes).filter_map(|node| {
        let from = Vector3::from(body.positions[node]);
        Some((from, from + held(node)?))
    });
    let pairs: Vec<_> = moved.collect();
    let mean = |sum: Vector3<f64>| sum / pairs.len() as f64;
    let [from, to] = [mean(pairs.iter().map(|p| p.0).sum()), mean(pairs.iter().map(|p| p.1).sum())];
    let arms = || pairs.iter().map(|(x, y)| (x - from, y - to));
    let products = arms().fold(Matrix3::zeros(), |sum, (x, y)| sum + y * x.transpose());
    let rotation = nearest_rotation(&products)?;
    let size = arms().map(|(x, _)| x.norm()).fold(0.0, f64::max);
    let off = arms().map(|(x, y)| (rotation * x - y).norm()).fold(0.0, f64::max);
    let degrees = rotation.angle().to_degrees();
    (size > 0.0 && off <= RIGID * size && degrees >= FAR).then_some(degrees)
}

/// The rotation R with the largest `tr(Rᵀ M)` (W. Kabsch, Acta Cryst. A 32, 1976).
fn nearest_rotation(products: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let singular = products.iter().all(|x| x.is_finite()).then(|| products.svd(true, true))?;
    let (u, v) = (singular.u?, singular.v_t?);
    // The least singular value comes last; a plane's motion leaves its sign open.
    let sign = if (u * v).determinant() < 0.0 { -1.0 } else { 1.0 };
    let turned = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
    Some(Rotation3::from_matrix_unchecked(turned))
}
