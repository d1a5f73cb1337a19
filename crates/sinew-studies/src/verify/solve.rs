//! Solution of a scene, with its cost.

use crate::verify::case::{Cost, Formulation};
use anyhow::Result;
use sinew_energy::{
    Body, IntoMaterial, Law, Load, Material, Parameter, Scene, SceneError, Support,
};
use sinew_fem::{Options, Solution, Solver};
use sinew_mesh::{AnyMesh, Mesh, boundary_facets};
use std::sync::Arc;
use std::time::Instant;

/// Node set of the whole boundary, made by [`with_boundary`].
pub(crate) const BOUNDARY: &str = "boundary";

/// A scene in which no load reads θ.
pub(crate) fn scene(
    mesh: impl Into<AnyMesh>,
    material: impl IntoMaterial,
    theta: &[f64],
    loads: Vec<Load>,
    supports: Vec<Support>,
) -> Scene {
    let parameter = |(name, &value): (&&str, &f64)| Parameter::linear(*name, "1", value..=value);
    let scene = Scene::new(mesh, material);
    let parameters = scene.material.parameters().iter().zip(theta).map(parameter).collect();
    Scene { parameters, loads, supports, ..scene }
}

/// A law with equal directions in every cell.
pub(crate) fn along<L: Law<D>, const D: usize>(
    mesh: &AnyMesh,
    law: L,
    directions: [[f64; 3]; D],
) -> Arc<dyn Material> {
    law.along(vec![directions; mesh.cell_count()])
}

/// An equilibrium; the time covers preparation and solve.
pub(crate) fn equilibrium(body: &Body, theta: &[f64]) -> Result<(Solution, Cost)> {
    let start = Instant::now();
    let mut solver = Solver::new(body)?;
    let solution = solver.solve(theta, &Options::default())?;
    Ok((solution, Cost::since(start, solver.unknowns() + solver.pressures())))
}

/// The potential of displacements alone, with averaged volume ratios where the formulation has them.
pub(crate) fn lower(scene: &Scene, formulation: Formulation) -> Result<Body, SceneError> {
    match formulation {
        Formulation::FBar | Formulation::Q1FBar => scene.clone().averaged().lower(),
        _ => scene.lower(),
    }
}

/// The displacement of a mesh and its cost.
pub(crate) struct Found {
    pub mesh: AnyMesh,
    /// Displacement node by node.
    pub displacement: Vec<f64>,
    /// Cost.
    pub cost: Cost,
}

impl Found {
    /// Displacement at a point: the mean over the nodes that are nearest to it, which on symmetric meshes is that of
    /// the point between them.
    pub(crate) fn at(&self, point: [f64; 3]) -> [f64; 3] {
        displacement_at(&self.mesh, &self.displacement, point)
    }
}

/// The equilibrium of displacements alone.
pub(crate) fn displaced(scene: Scene, formulation: Formulation, theta: &[f64]) -> Result<Found> {
    let (solution, cost) = equilibrium(&lower(&scene, formulation)?, theta)?;
    Ok(Found { mesh: scene.mesh, displacement: solution.displacement, cost })
}

/// The equilibrium of quadratic displacements and linear pressures, incompressible for `compliance` 0, else
/// with the further bulk modulus `1/compliance`.
pub(crate) fn mixed(scene: Scene, compliance: f64, theta: &[f64]) -> Result<Found> {
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
pub(crate) fn displacement_at(mesh: &AnyMesh, displacement: &[f64], point: [f64; 3]) -> [f64; 3] {
    let points = mesh.points();
    let distance = |node: usize| {
        let x = points[node];
        (0..3).map(|i| (x[i] - point[i]).powi(2)).sum::<f64>().sqrt()
    };
    let nearest = (0..points.len()).map(distance).fold(f64::INFINITY, f64::min);
    let tie = |&node: &usize| distance(node) <= nearest + TIE;
    let nodes: Vec<_> = (0..points.len()).filter(tie).collect();
    std::array::from_fn(|i| {
        nodes.iter().map(|&n| displacement[3 * n + i]).sum::<f64>() / nodes.len() as f64
    })
}

/// Distances \[length\] that count as equal.
const TIE: f64 = 1e-9;
