//! Solution of a scene, with its cost.

use crate::verify::case::{Cost, Formulation};
use anyhow::Result;
use sinew_energy::{
    Body, IntoMaterial, Load, Magnitude, Parameter, Prescribed, Scene, SceneError, Support,
};
use sinew_fem::{Options, Solution, Solver};
use sinew_mesh::AnyMesh;
use std::collections::BTreeSet;
use std::time::Instant;

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

/// A follower pressure \[stress\] on a side.
pub(crate) fn pressed(side: &str, pressure: f64) -> Vec<Load> {
    vec![Load::Pressure { facets: side.into(), magnitude: Magnitude::Fixed(pressure) }]
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

/// An equilibrium of a body and its cost.
pub(crate) struct Found {
    pub body: Body,
    pub solution: Solution,
    pub cost: Cost,
}

impl Found {
    fn new(body: Body, theta: &[f64]) -> Result<Self> {
        let (solution, cost) = equilibrium(&body, theta)?;
        Ok(Self { body, solution, cost })
    }

    /// Displacement at a point: the mean over the nodes that are nearest to it, which on symmetric meshes is that of
    /// the point between them.
    pub(crate) fn at(&self, point: [f64; 3]) -> [f64; 3] {
        let points = &self.body.positions;
        let distance = |node: usize| {
            let x = points[node];
            (0..3).map(|i| (x[i] - point[i]).powi(2)).sum::<f64>().sqrt()
        };
        let nearest = (0..points.len()).map(distance).fold(f64::INFINITY, f64::min);
        let tie = |&node: &usize| distance(node) <= nearest + TIE;
        let nodes: Vec<_> = (0..points.len()).filter(tie).collect();
        let sum =
            |i: usize| nodes.iter().map(|&n| self.solution.displacement[3 * n + i]).sum::<f64>();
        std::array::from_fn(|i| sum(i) / nodes.len() as f64)
    }
}

/// The equilibrium of displacements alone.
pub(crate) fn displaced(scene: Scene, formulation: Formulation, theta: &[f64]) -> Result<Found> {
    Found::new(lower(&scene, formulation)?, theta)
}

/// The equilibrium of quadratic displacements and linear pressures, incompressible for `compliance` 0, else
/// with the further bulk modulus `1/compliance`.
pub(crate) fn mixed(scene: Scene, compliance: f64, theta: &[f64]) -> Result<Found> {
    Found::new(scene.mixed().lower()?.with_compliance(compliance)?, theta)
}

/// The mesh with its boundary as a node set, and the support that moves it.
pub(crate) fn with_moved_boundary(
    mesh: impl Into<AnyMesh>,
    motion: impl Fn([f64; 3]) -> [f64; 3],
) -> (AnyMesh, Vec<Support>) {
    const BOUNDARY: &str = "boundary";
    let mut mesh = mesh.into();
    let facets = mesh.boundary_facets().into_iter();
    let nodes: BTreeSet<usize> = facets.flat_map(|facet| mesh.nodes_of_facet(facet)).collect();
    let moved = nodes.iter().map(|&node| motion(mesh.points()[node]).map(Some));
    let displacement = Prescribed::PerNode(moved.collect());
    mesh.node_sets_mut().insert(BOUNDARY.into(), nodes.into_iter().collect());
    (mesh, vec![Support { nodes: BOUNDARY.into(), displacement }])
}

/// Distances \[length\] that count as equal.
const TIE: f64 = 1e-9;
