//! Scenes that the tests share.
#![allow(dead_code, reason = "each test file uses a part")]

pub(crate) mod organ;
pub(crate) mod ventricle;

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Law, Load, Parameter, Sampling, Scene, Support};
use sinew_fem::{Solution, reactions};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// Gravity on tissue of 1 g/cm³, downwards [kPa/mm].
pub(crate) const GRAVITY: f64 = -9.8e-3;

pub(crate) fn parameters(names: &[&str]) -> Vec<Parameter> {
    let parameter = |name: &&str| Parameter {
        name: name.to_string(),
        unit: "kPa".into(),
        range: [1.0, 2.0],
        sampling: Sampling::Log,
    };
    names.iter().map(parameter).collect()
}

/// A scene of an isotropic law, lowered.
pub(crate) fn lower<L: Law<0>>(
    law: L,
    mesh: TetMesh,
    loads: Vec<Load>,
    supports: Vec<Support>,
) -> Body {
    Scene {
        name: "test".into(),
        parameters: parameters(L::PARAMETERS),
        loads,
        supports,
        ..Scene::new(mesh, law)
    }
    .lower()
    .expect("the scenes of the tests are well formed")
}

/// The thesis' OnceClampedBeam.
pub(crate) fn once() -> Body {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    lower(NeoHookean, mesh, gravity(1.0), vec![Support::clamped("x_min")])
}

/// The thesis' TwiceClampedBeam.
pub(crate) fn twice() -> Body {
    let mesh = box_tetrahedra([150.0, 10.0, 2.0], [12, 4, 5]);
    let supports = vec![Support::clamped("x_min"), Support::clamped("x_max")];
    lower(NeoHookean, mesh, gravity(1.0), supports)
}

pub(crate) fn gravity(factor: f64) -> Vec<Load> {
    vec![Load::BodyForce([0.0, 0.0, factor * GRAVITY])]
}

/// Relative difference in the largest norm.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs())) / largest
}

/// Forces of the supports at a solution, for each of [`sinew_fem::held_sets`].
pub(crate) fn forces_of_supports(body: &Body, solution: &Solution) -> Vec<[f64; 3]> {
    let Solution { displacement, pressure, theta, .. } = solution;
    reactions(body, displacement, pressure, theta).unwrap()
}

/// Integral of the outward normal over a displaced set of facets with straight edges.
pub(crate) fn vector_area(body: &Body, facets: &str, displacement: &[f64]) -> [f64; 3] {
    let place = |node: usize, i: usize| body.positions[node][i] + displacement[3 * node + i];
    let mut area = [0.0; 3];
    for &facet in &body.mesh.facet_sets()[facets] {
        let nodes = body.mesh.nodes_of_facet(facet);
        for (&a, &b) in nodes.iter().zip(nodes.iter().cycle().skip(1)) {
            for i in 0..3 {
                let [j, k] = [(i + 1) % 3, (i + 2) % 3];
                area[i] += 0.5 * (place(a, j) * place(b, k) - place(a, k) * place(b, j));
            }
        }
    }
    area
}
