//! Scenes that the cases start from.

pub(crate) use crate::support::{gravity, lower, once, parameters, twice};
use sinew_energy::{IntoMaterial, Law, Load, Scene, Support};
use sinew_mesh::{AnyMesh, TetMesh, box_tetrahedra};

/// A scene without loads, clamped at `x_min`.
pub(crate) fn scene(material: impl IntoMaterial, mesh: impl Into<AnyMesh>) -> Scene {
    let scene = Scene::new(mesh, material);
    Scene {
        name: "hard case".into(),
        parameters: parameters(scene.material.parameters()),
        supports: vec![Support::clamped("x_min")],
        ..scene
    }
}

/// Equal directions in every cell.
pub(crate) fn with_directions<L: Law<D>, const D: usize>(
    law: L,
    mesh: TetMesh,
    directions: [[f64; 3]; D],
) -> Scene {
    let directions = vec![directions; mesh.cells.len()];
    scene(law.along(directions), mesh)
}

/// A cube of edge 1 with `cells` grid cells along each edge.
pub(crate) fn cube(cells: usize) -> TetMesh {
    box_tetrahedra([1.0; 3], [cells; 3])
}

/// A cube whose inner nodes are moved about by up to a twentieth of its edge, deterministically.
pub(crate) fn distorted_cube(cells: usize) -> TetMesh {
    let mut mesh = cube(cells);
    let boundary: Vec<_> = mesh.node_sets.values().flatten().copied().collect();
    for node in (0..mesh.points.len()).filter(|node| !boundary.contains(node)) {
        for (i, x) in mesh.points[node].iter_mut().enumerate() {
            *x += 0.05 * (((node * 37 + i * 101) % 17) as f64 / 8.5 - 1.0);
        }
    }
    mesh.node_sets.insert("boundary".into(), boundary);
    mesh
}

/// One tetrahedron at the origin with edges of length 1 along the axes; `base` is its side x = 0.
pub(crate) fn one_tetrahedron() -> TetMesh {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut mesh = TetMesh::new(points, vec![[0, 1, 2, 3]]).unwrap();
    mesh.node_sets.insert("base".into(), vec![0, 2, 3]);
    mesh.node_sets.insert("tip".into(), vec![1]);
    mesh
}

/// Held against motion along one axis.
pub(crate) fn roller(set: &str, axis: usize) -> Support {
    Support::uniform(set, std::array::from_fn(|i| (i == axis).then_some(0.0)))
}

/// Three sides that slide in their planes: the body is held and deforms as it likes.
pub(crate) fn corner_rollers() -> Vec<Support> {
    vec![roller("x_min", 0), roller("y_min", 1), roller("z_min", 2)]
}

/// A bar between rollers whose far end is moved along x by `motion` \[length\].
pub(crate) fn pulled(motion: f64) -> Vec<Support> {
    let mut supports = corner_rollers();
    supports.push(Support::uniform("x_max", [Some(motion), None, None]));
    supports
}

/// A dead traction on a side.
pub(crate) fn traction(side: &str, value: [f64; 3]) -> Load {
    Load::Traction { facets: side.into(), value }
}

/// A turn about the x axis through (y, z) = `centre`, as a motion.
pub(crate) fn turn_about_x(angle: f64, centre: [f64; 2]) -> impl Fn([f64; 3]) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    move |[_, y, z]| {
        let (y, z) = (y - centre[0], z - centre[1]);
        [0.0, cosine * y - sine * z - y, sine * y + cosine * z - z]
    }
}
