//! Potentials in boxes, where they are linear or parabolas.

use nalgebra::Vector3;
use sinew_fem::fibres::{FibreRule, Surfaces, VentricleCoordinates};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// A box as a wall from x = 0 to its other side, with its base on top.
const BOX: Surfaces<'static> =
    Surfaces { endocardium: "x_min", epicardium: "x_max", base: "z_max" };

/// Largest error of the depth, which rises along x from 0 to 1.
fn off(wall: &VentricleCoordinates, mesh: &TetMesh) -> f64 {
    let width = mesh.points.iter().map(|x| x[0]).fold(0.0, f64::max);
    let of = |values: &[f64]| {
        let errors = values.iter().zip(&mesh.points).map(|(value, x)| (value - x[0] / width).abs());
        errors.fold(0.0, f64::max)
    };
    of(&wall.thickness)
}

#[test]
fn linear_potentials_are_exact() {
    let mesh = box_tetrahedra([2.0, 1.0, 3.0], [3, 2, 4]);
    let wall = VentricleCoordinates::new(&mesh, &BOX).unwrap();
    assert!(off(&wall, &mesh) < 1e-13, "{:e}", off(&wall, &mesh));
    // Sheets stand along the gradients of cells, and their means around nodes.
    let rule = FibreRule::new(0.0, 0.0).unwrap();
    let frames = [wall.cell_frames(&rule), wall.node_frames(&rule)];
    for [_, sheet, _] in frames.iter().flatten() {
        assert!((Vector3::from(*sheet) - Vector3::x()).norm() < 1e-12, "{sheet:?}");
    }
}

#[test]
fn linear_potentials_of_many_nodes_are_those_of_few() {
    let mesh = box_tetrahedra([2.0, 1.0, 3.0], [28, 26, 28]);
    // More than 20 000 unknowns.
    let held = mesh.node_sets["x_min"].len() + mesh.node_sets["x_max"].len();
    assert!(mesh.points.len() - held > 20_000);
    let wall = VentricleCoordinates::new(&mesh, &BOX).unwrap();
    assert!(off(&wall, &mesh) < 1e-10, "{:e}", off(&wall, &mesh));
}

/// `−h'' = 1` between two ends of a bar is a parabola, so that the apexes are half-way.
#[test]
fn a_source_bends_the_way_to_the_base() {
    let mut mesh = box_tetrahedra([1.0, 0.25, 0.25], [8, 2, 2]);
    let ends = [&mesh.facet_sets["x_min"][..], &mesh.facet_sets["x_max"]].concat();
    mesh.facet_sets.insert("ends".into(), ends);
    let surfaces = Surfaces { endocardium: "y_min", epicardium: "y_max", base: "ends" };
    let wall = VentricleCoordinates::new(&mesh, &surfaces).unwrap();
    assert_eq!(wall.apexes.map(|node| mesh.points[node][0]), [0.5; 2]);
    assert_eq!(wall.apexes.map(|node| mesh.points[node][1]), [0.0, 0.25]);
}
