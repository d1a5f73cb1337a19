//! Manufactured solutions: orders of convergence.

use crate::verify::case::{Band, Case, Cost, Effort, Formulation, Label, Rows};
use crate::verify::integrate::points;
use crate::verify::solve::{equilibrium, scene, with_moved_boundary};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{FacetRule, Load, Support};
use sinew_mesh::{AnyMesh, Mesh, TetMesh, box_hexahedra, box_tetrahedra};
use sinew_num::{Jet, Mat3, Scalar, Slope};
use std::f64::consts::PI;

/// μ and λ \[stress\].
const THETA: [f64; 2] = [1.0, 2.0];
/// Distance of a measured order from the theoretical one; meshes this coarse are not in the limit yet.
const ORDER: Band = Band::below(0.2);

/// Pressures reach their order from above: 3.1, then 2.4 on the meshes of this case.
const PRESSURE_ORDER: Band = Band::below(0.5);

/// A compressible body under the body force that bends it into a given shape.
struct Compressible;
/// An incompressible body, with a given pressure besides.
struct Incompressible;

/// The exact solution over any number type.
trait Exact {
    fn displacement<S: Scalar>(x: [S; 3]) -> [S; 3];
    /// The field of pressure; 0 without one.
    fn pressure<S: Scalar>(x: [S; 3]) -> S;
}

impl Exact for Compressible {
    fn displacement<S: Scalar>([x, y, z]: [S; 3]) -> [S; 3] {
        [
            (x.clone().exp() * y.clone().squared() + x.clone() * z.clone().squared()) * 0.1,
            ((x.clone() * 2.0).tanh() * z.clone() + y.clone() * y.clone().squared()) * 0.15,
            (x.squared() * y.squared() + (-z.clone()).exp() * z) * 0.2,
        ]
    }

    fn pressure<S: Scalar>([x, ..]: [S; 3]) -> S {
        x.constant(0.0)
    }
}

impl Exact for Incompressible {
    /// Two shears in a row, which keep the volume.
    fn displacement<S: Scalar>([x, y, z]: [S; 3]) -> [S; 3] {
        let first = (y * 2.0).tanh() * 0.25 + z.clone().squared() * 0.2;
        let moved = x + first.clone();
        let second = (moved.clone().squared() + (z.clone() * moved).exp()) * 0.15;
        [first, second, z.constant(0.0)]
    }

    fn pressure<S: Scalar>([x, y, z]: [S; 3]) -> S {
        (x.exp() * y - z.squared()) * 0.5
    }
}

pub(super) const COMPRESSIBLE: Case = Case {
    name: "manufactured",
    title: "Orders of convergence in L² and H¹, compressible neo-Hookean body on distorted meshes",
    provenance: "A smooth displacement; its body force −Div P by Taylor arithmetic on the closed form of P, integrated by \
         code of this crate. Orders in L²/H¹: 2/1 for linear, 3/2 for quadratic elements.",
    run: run_compressible,
};

fn run_compressible(effort: Effort, rows: &mut Rows) -> Result<()> {
    let tets = |cells| distorted(box_tetrahedra([1.0; 3], [cells; 3]));
    let hexes = |cells| distorted(box_hexahedra([1.0; 3], [cells; 3]));
    let (linear, quadratic) = ([(2.0, ORDER), (1.0, ORDER)], [(3.0, ORDER), (2.0, ORDER)]);
    let levels = effort.levels(3, &[4, 8, 16, 24]);
    ladder(rows, Formulation::P1, &linear, levels, |cells| solve(tets(cells)))?;
    let levels = effort.levels(2, &[2, 4, 8]);
    ladder(rows, Formulation::P2, &quadratic, levels, |cells| solve(tets(cells).quadratic()))?;
    let levels = effort.levels(2, &[4, 8, 16]);
    ladder(rows, Formulation::Q1, &linear, levels, |cells| solve(hexes(cells)))
}

pub(super) const INCOMPRESSIBLE: Case = Case {
    name: "manufactured-mixed",
    title: "Orders of convergence of displacement and pressure, incompressible neo-Hookean body, mixed elements",
    provenance: "Two shears in a row, which keep the volume, and a smooth pressure; body force and traction by Taylor \
         arithmetic. Orders: 3 (displacement in L²), 2 (its gradient), 2 (pressure in L²).",
    run: run_incompressible,
};

fn run_incompressible(effort: Effort, rows: &mut Rows) -> Result<()> {
    // The two meshes of a quick run are too coarse to tell the order of the pressure.
    let orders = effort.levels(2, &[(3.0, ORDER), (2.0, ORDER), (2.0, PRESSURE_ORDER)]);
    ladder(rows, Formulation::Mixed, orders, effort.levels(2, &[2, 4, 8]), |cells| {
        solve_mixed(distorted(box_tetrahedra([1.0; 3], [cells; 3])).quadratic())
    })
}

/// The cube under a smooth map that keeps its sides, so that refinement halves every cell.
fn distorted<const N: usize>(mut mesh: Mesh<N>) -> Mesh<N> {
    mesh.map_points(|x| {
        let bump = x.map(|x| (PI * x).sin()).iter().product::<f64>();
        [x[0] + 0.10 * bump, x[1] - 0.08 * bump, x[2] + 0.06 * bump]
    });
    mesh
}

/// Quantities of the errors, in the order in which they are given.
const QUANTITIES: [&str; 3] = ["displacement in L²", "displacement in H¹", "pressure in L²"];

/// Solves on meshes of rising fineness; errors on each, and between the last two the orders that are given.
fn ladder<const M: usize>(
    rows: &mut Rows,
    formulation: Formulation,
    orders: &[(f64, Band)],
    levels: &[usize],
    solve: impl Fn(usize) -> Result<([f64; M], Cost)>,
) -> Result<()> {
    let mut before = None;
    for &cells in levels {
        let (errors, cost) = solve(cells)?;
        for (name, error) in QUANTITIES.iter().zip(errors) {
            let quantity = format!("relative error of {name}");
            let label = Label::new(formulation, format!("{cells}³ cubes"), quantity);
            // Less than the cell's size over the cube's is expected from any element.
            rows.absolute(label, [error, 0.0], Band::below(1.0 / cells as f64), cost)?;
        }
        let Some((coarse, from)) = before.replace((errors, cells)) else { continue };
        if levels.last() != Some(&cells) {
            continue;
        }
        let refinement = (cells as f64 / from as f64).ln();
        for (index, (name, &(order, band))) in QUANTITIES.iter().zip(orders).enumerate() {
            let setup = format!("{from}³ to {cells}³ cubes");
            let label = Label::new(formulation, setup, format!("order of {name}"));
            let measured = (coarse[index] / errors[index]).ln() / refinement;
            rows.absolute(label, [measured, order], band, cost)?;
        }
    }
    Ok(())
}

/// Relative errors in L² and H¹ of the compressible body.
fn solve<const N: usize>(mesh: Mesh<N>) -> Result<([f64; 2], Cost)>
where
    AnyMesh: From<Mesh<N>>,
{
    let exact = |x: [f64; 3]| Compressible::displacement(x);
    let mut forces = vec![[0.0; 3]; mesh.points.len()];
    add_body_force::<Compressible, N>(&mesh, &mut forces);
    let loads = vec![Load::NodalForces(forces)];
    let (held, supports) = with_moved_boundary(mesh.clone(), exact);
    let body = scene(held, NeoHookean, &THETA, loads, supports).lower()?;
    let (solution, cost) = equilibrium(&body, &THETA)?;
    Ok((displacement_errors::<Compressible, N>(&mesh, &solution.displacement), cost))
}

/// Relative errors in L² and H¹ and of the pressure in L² of the incompressible body.
fn solve_mixed(mesh: Mesh<10>) -> Result<([f64; 3], Cost)> {
    let mesh = &mesh;
    let exact = |x: [f64; 3]| Incompressible::displacement(x);
    let held: Vec<_> = ["x_min", "y_min", "y_max", "z_min", "z_max"]
        .map(|side| Support::moved(side, mesh, exact))
        .into();
    let mut forces = vec![[0.0; 3]; mesh.points.len()];
    add_body_force::<Incompressible, 10>(mesh, &mut forces);
    add_traction::<Incompressible>(mesh, &mut forces);
    let loads = vec![Load::NodalForces(forces)];
    let body = scene(mesh.clone(), NeoHookean, &THETA, loads, held).mixed().lower()?;
    let (solution, cost) = equilibrium(&body, &THETA)?;
    let [value, slope] = displacement_errors::<Incompressible, 10>(mesh, &solution.displacement);
    let mut at_node = vec![0.0; mesh.points.len()];
    let nodes = body.pressure_field.iter().flat_map(|field| &field.nodes);
    nodes.zip(&solution.pressure).for_each(|(&node, &p)| at_node[node] = p);
    Ok(([value, slope, pressure_error(mesh, &at_node)], cost))
}

/// Corners and reference points of a linear mesh with the same corners, for pressures.
fn pressure_error(mesh: &Mesh<10>, at_node: &[f64]) -> f64 {
    let corners: TetMesh = TetMesh {
        points: mesh.points.clone(),
        cells: mesh.cells.iter().map(|c| [c[0], c[1], c[2], c[3]]).collect(),
        ..TetMesh::default()
    };
    let (mut off, mut size) = (0.0, 0.0);
    for point in points(&corners, Mesh::<10>::FINE_QUADRATURE) {
        let exact: f64 = Incompressible::pressure(point.at);
        let found: f64 = (0..4).map(|a| point.shape[a] * at_node[point.nodes[a]]).sum();
        off += point.volume * (found - exact).powi(2);
        size += point.volume * exact.powi(2);
    }
    (off / size).sqrt()
}

fn displacement_errors<E: Exact, const N: usize>(mesh: &Mesh<N>, displacement: &[f64]) -> [f64; 2] {
    let mut sums = [[0.0; 2]; 2];
    for point in points(mesh, fine_rule::<N>()) {
        let (u, h) = (point.value(displacement), point.slope(displacement));
        let exact = taylor::<E>(point.at);
        for i in 0..3 {
            sums[0][0] += point.volume * (u[i] - exact[i].value).powi(2);
            sums[0][1] += point.volume * exact[i].value.powi(2);
            for j in 0..3 {
                sums[1][0] += point.volume * (h[i][j] - exact[i].gradient[j]).powi(2);
                sums[1][1] += point.volume * exact[i].gradient[j].powi(2);
            }
        }
    }
    sums.map(|[off, size]: [f64; 2]| (off / size).sqrt())
}

/// A rule that is fine enough for squares of the error.
fn fine_rule<const N: usize>() -> &'static [sinew_mesh::QuadraturePoint] {
    if N == 4 { Mesh::<10>::FINE_QUADRATURE } else { Mesh::<N>::FINE_QUADRATURE }
}

fn taylor<E: Exact>(at: [f64; 3]) -> [Jet<3>; 3] {
    E::displacement(std::array::from_fn(|i| Jet::variable(at[i], i)))
}

/// First Piola–Kirchhoff stress with its derivatives in X:
/// `P = μF + (λ ln J − μ)F⁻ᵀ + p cof F`.
fn stress<E: Exact>(at: [f64; 3]) -> [[Slope<3>; 3]; 3] {
    let [shear, lame] = THETA;
    let u = taylor::<E>(at);
    let f = Mat3::from_fn(|i, j| Slope::<3> {
        value: u[i].gradient[j] + if i == j { 1.0 } else { 0.0 },
        gradient: u[i].hessian[j],
        hessian: [],
    });
    let volume = f.determinant();
    let pressure = E::pressure(std::array::from_fn(|i| Slope::variable(at[i], i)));
    let spherical = (volume.ln() * lame - shear) / volume + pressure;
    std::array::from_fn(|i| {
        std::array::from_fn(|j| f.at(i, j) * shear + f.cofactor(i, j) * spherical)
    })
}

/// Adds the nodal forces of `−Div P`.
fn add_body_force<E: Exact, const N: usize>(mesh: &Mesh<N>, force: &mut [[f64; 3]]) {
    for point in points(mesh, fine_rule::<N>()) {
        let stress = stress::<E>(point.at);
        for i in 0..3 {
            let density: f64 = -(0..3).map(|j| stress[i][j].gradient[j]).sum::<f64>();
            for (&node, shape) in point.nodes.iter().zip(&point.shape) {
                force[node][i] += point.volume * shape * density;
            }
        }
    }
}

/// Adds the nodal forces of `PN` on the side x = 1.
fn add_traction<E: Exact>(mesh: &Mesh<10>, force: &mut [[f64; 3]]) {
    let rule = FacetRule::of_cells::<10>();
    for facet in &mesh.facet_sets["x_max"] {
        let nodes: Vec<_> = sinew_mesh::QuadraticTetMesh::ELEMENT.facets[facet.opposite]
            .iter()
            .map(|&a| mesh.cells[facet.cell][a])
            .collect();
        for point in &rule.points {
            let sum = |weights: &[f64], i: usize| -> f64 {
                nodes.iter().zip(weights).map(|(&node, w)| w * mesh.points[node][i]).sum()
            };
            let [along, across] = [0, 1].map(|k| [1, 2].map(|i| sum(&point.slope[k], i)));
            let area = point.weight * (along[0] * across[1] - along[1] * across[0]);
            let at = std::array::from_fn(|i| sum(&point.shape, i));
            let stress = stress::<E>(at);
            for (&node, shape) in nodes.iter().zip(&point.shape) {
                (0..3).for_each(|i| force[node][i] += area * shape * stress[i][0].value);
            }
        }
    }
}
