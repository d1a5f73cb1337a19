//! Solution of a scene, with its cost.

use crate::verify::case::{Cost, Formulation};
use anyhow::Result;
use sinew_energy::{
    Body, FiniteElement, Law, Load, Nodes, Parameter, Scene, SceneError, Support, TaylorHoodElement,
};
use sinew_fem::{Options, Solution, Solver};
use sinew_mesh::{Mesh, boundary_facets};
use std::time::Instant;

/// Node set of the whole boundary, made by [`with_boundary`].
pub(crate) const BOUNDARY: &str = "boundary";

/// A scene of an isotropic law; give `directions` to others. No load reads θ.
pub(crate) fn scene<L: Law<D>, const D: usize, const N: usize>(
    mesh: Mesh<N>,
    law: L,
    theta: &[f64],
    loads: Vec<Load>,
    supports: Vec<Support>,
) -> Scene<L, D, N> {
    let parameter = |(name, &value): (&&str, &f64)| Parameter::linear(*name, "1", value..=value);
    let parameters = L::PARAMETERS.iter().zip(theta).map(parameter).collect();
    Scene { parameters, loads, supports, ..Scene::new(mesh, law) }
}

/// Equal directions in every cell.
pub(crate) fn with_directions<L: Law<D>, const D: usize, const N: usize>(
    scene: Scene<L, D, N>,
    directions: [[f64; 3]; D],
) -> Scene<L, D, N> {
    Scene { directions: vec![directions; scene.mesh.cells.len()], ..scene }
}

/// An equilibrium; the time covers preparation and solve.
pub(crate) fn equilibrium(body: &Body, theta: &[f64]) -> Result<(Solution, Cost)> {
    let start = Instant::now();
    let mut solver = Solver::new(body)?;
    let solution = solver.solve(theta, &Options::default())?;
    Ok((solution, Cost::since(start, solver.unknowns() + solver.pressures())))
}

/// The potential of displacements alone, with averaged volume ratios where the formulation has them.
pub(crate) fn lower<L: Law<D>, const D: usize, const N: usize>(
    scene: &Scene<L, D, N>,
    formulation: Formulation,
) -> Result<Body, SceneError>
where
    Nodes<N>: FiniteElement<N>,
{
    match formulation {
        Formulation::FBar | Formulation::Q1FBar => scene.clone().averaged().lower(),
        _ => scene.lower(),
    }
}

/// The displacement of a mesh and its cost.
pub(crate) struct Found<const N: usize> {
    pub mesh: Mesh<N>,
    /// Displacement node by node.
    pub displacement: Vec<f64>,
    /// Cost.
    pub cost: Cost,
}

impl<const N: usize> Found<N> {
    /// Displacement at a point: the mean over the nodes that are nearest to it, which on symmetric meshes is that of
    /// the point between them.
    pub(crate) fn at(&self, point: [f64; 3]) -> [f64; 3] {
        displacement_at(&self.mesh, &self.displacement, point)
    }
}

/// The equilibrium of displacements alone.
pub(crate) fn displaced<L: Law<D>, const D: usize, const N: usize>(
    scene: Scene<L, D, N>,
    formulation: Formulation,
    theta: &[f64],
) -> Result<Found<N>>
where
    Nodes<N>: FiniteElement<N>,
{
    let (solution, cost) = equilibrium(&lower(&scene, formulation)?, theta)?;
    Ok(Found { mesh: scene.mesh, displacement: solution.displacement, cost })
}

/// The equilibrium of quadratic displacements and linear pressures, incompressible for `compliance` 0, else
/// with the further bulk modulus `1/compliance`.
pub(crate) fn mixed<L: Law<D>, const D: usize, const N: usize>(
    scene: Scene<L, D, N>,
    compliance: f64,
    theta: &[f64],
) -> Result<Found<N>>
where
    Nodes<N>: TaylorHoodElement<N>,
{
    let scene = scene.mixed();
    let body = scene.lower()?.with_compliance(compliance)?;
    let (solution, cost) = equilibrium(&body, theta)?;
    Ok(Found { mesh: scene.mesh, displacement: solution.displacement, cost })
}

/// The mesh with the node set [`BOUNDARY`].
pub(crate) fn with_boundary<const N: usize>(mut mesh: Mesh<N>) -> Mesh<N> {
    let nodes = mesh.nodes_of_facets(&boundary_facets(&mesh));
    mesh.node_sets.insert(BOUNDARY.into(), nodes);
    mesh
}

/// Value at a point, as [`Found::at`].
pub(crate) fn displacement_at<const N: usize>(
    mesh: &Mesh<N>,
    displacement: &[f64],
    point: [f64; 3],
) -> [f64; 3] {
    let distance = |node: usize| {
        let x = mesh.points[node];
        (0..3).map(|i| (x[i] - point[i]).powi(2)).sum::<f64>().sqrt()
    };
    let nearest = (0..mesh.points.len()).map(distance).fold(f64::INFINITY, f64::min);
    let tie = |&node: &usize| distance(node) <= nearest + TIE;
    let nodes: Vec<_> = (0..mesh.points.len()).filter(tie).collect();
    std::array::from_fn(|i| {
        nodes.iter().map(|&n| displacement[3 * n + i]).sum::<f64>() / nodes.len() as f64
    })
}

/// Distances \[length\] that count as equal.
const TIE: f64 = 1e-9;
