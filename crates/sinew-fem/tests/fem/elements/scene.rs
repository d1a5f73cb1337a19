//! Scenes of the tests of elements.

use sinew_energy::{Law, Load, Parameter, Sampling, Scene, Support};
use sinew_mesh::{Mesh, boundary_facets};

/// A scene without directions; θ is only what the law reads.
pub(crate) fn scene<L: Law<D>, const D: usize, const N: usize>(
    law: L,
    mesh: Mesh<N>,
    loads: Vec<Load>,
    supports: Vec<Support>,
) -> Scene<L, D, N> {
    let parameter = |name: &&str| Parameter {
        name: name.to_string(),
        unit: "1".into(),
        range: [1.0, 2.0],
        sampling: Sampling::Log,
    };
    Scene {
        name: "elements".into(),
        parameters: L::PARAMETERS.iter().map(parameter).collect(),
        loads,
        supports,
        ..Scene::new(mesh, law)
    }
}

/// The mesh with its whole boundary as the sets `boundary` of nodes and of facets.
pub(crate) fn with_boundary<const N: usize>(mut mesh: Mesh<N>) -> Mesh<N> {
    let facets = boundary_facets(&mesh);
    mesh.node_sets.insert("boundary".into(), mesh.nodes_of_facets(&facets));
    mesh.facet_sets.insert("boundary".into(), facets);
    mesh
}

/// A support that only keeps nodes in their plane across one axis.
pub(crate) fn roller(nodes: &str, axis: usize) -> Support {
    Support::uniform(nodes, std::array::from_fn(|i| (i == axis).then_some(0.0)))
}

/// The node at a position.
pub(crate) fn node_at<const N: usize>(mesh: &Mesh<N>, at: [f64; 3]) -> usize {
    let away = |x: &[f64; 3]| (0..3).map(|i| (x[i] - at[i]).abs()).fold(0.0, f64::max);
    mesh.points.iter().position(|x| away(x) < 1e-9).expect("a node of the mesh")
}

/// Numbers between −size and size that follow no pattern of the mesh.
pub(crate) fn wobble(count: usize, size: f64) -> Vec<f64> {
    (0..count).map(|i| size * (1.3 * i as f64 + 0.4).sin()).collect()
}

/// Largest difference.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
