//! Scenes of the tests of elements.

use sinew_energy::{IntoMaterial, Load, Parameter, Sampling, Scene, Support};
use sinew_mesh::{AnyMesh, Facet};

/// A scene whose θ is only what the law reads.
pub(crate) fn scene(
    material: impl IntoMaterial,
    mesh: impl Into<AnyMesh>,
    loads: Vec<Load>,
    supports: Vec<Support>,
) -> Scene {
    let parameter = |name: &&str| Parameter {
        name: name.to_string(),
        unit: "1".into(),
        range: [1.0, 2.0],
        sampling: Sampling::Log,
    };
    let scene = Scene::new(mesh, material);
    Scene {
        name: "elements".into(),
        parameters: scene.material.parameters().iter().map(parameter).collect(),
        loads,
        supports,
        ..scene
    }
}

/// The mesh with its whole boundary as the sets `boundary` of nodes and of facets.
pub(crate) fn with_boundary(mesh: impl Into<AnyMesh>) -> AnyMesh {
    let mut mesh = mesh.into();
    let facets = mesh.boundary_facets();
    let mut nodes: Vec<_> =
        facets.iter().flat_map(|&facet: &Facet| mesh.nodes_of_facet(facet)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    mesh.node_sets_mut().insert("boundary".into(), nodes);
    mesh.facet_sets_mut().insert("boundary".into(), facets);
    mesh
}

/// A support that only keeps nodes in their plane across one axis.
pub(crate) fn roller(nodes: &str, axis: usize) -> Support {
    Support::uniform(nodes, std::array::from_fn(|i| (i == axis).then_some(0.0)))
}

/// The node at a position.
pub(crate) fn node_at(points: &[[f64; 3]], at: [f64; 3]) -> usize {
    let away = |x: &[f64; 3]| (0..3).map(|i| (x[i] - at[i]).abs()).fold(0.0, f64::max);
    points.iter().position(|x| away(x) < 1e-9).expect("a node of the mesh")
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
