//! Quadratic cells and distorted ones.

use crate::distort::Distort as _;
use sinew_mesh::{
    Field, Mesh, boundary_facets, box_hexahedra, box_tetrahedra, rectangle_triangles,
};

#[test]
fn middle_nodes_are_shared_and_in_place() {
    let linear = box_tetrahedra([2.0, 3.0, 1.0], [2, 2, 3]);
    let mesh = linear.quadratic();
    assert_eq!(mesh.check(), Ok(()));
    // The middles of Kuhn's tetrahedra are the nodes of the grid with half the step.
    assert_eq!(mesh.points.len(), 5 * 5 * 7);
    assert_eq!(mesh.points[..linear.points.len()], linear.points);
    for cell in 0..mesh.cells.len() {
        assert!((mesh.cell_volume(cell) - linear.cell_volume(cell)).abs() < 1e-14);
    }
    for (side, on_side) in [("x_min", 0), ("y_max", 1), ("z_min", 2)] {
        let level = if side.ends_with("max") { 3.0 } else { 0.0 };
        let expected = (0..mesh.points.len()).filter(|&n| mesh.points[n][on_side] == level);
        assert_eq!(mesh.node_sets[side], expected.collect::<Vec<_>>(), "{side}");
        assert_eq!(mesh.nodes_of_facets(&mesh.facet_sets[side]), mesh.node_sets[side]);
    }
}

#[test]
fn sets_and_fields_are_lifted() {
    let mut linear = rectangle_triangles([2.0, 1.0], [2, 1]);
    // An edge along the boundary, one across the inside, and the corners of a cell.
    linear.node_sets.insert("edge".into(), vec![0, 1]);
    linear.node_sets.insert("across".into(), vec![1, 4]);
    linear.node_sets.insert("cell".into(), vec![0, 1, 4]);
    linear.point_fields.insert("x".into(), Field::scalars(vec![0.0, 1.0, 2.0, 0.0, 1.0, 2.0]));
    linear.point_fields.insert("mark".into(), Field::labels(vec![1, 1, 0, 0, 0, 0]));
    let mesh = linear.quadratic();
    assert_eq!(mesh.check(), Ok(()));
    assert_eq!(["edge", "across", "cell"].map(|set| mesh.node_sets[set].len()), [3, 2, 6]);
    let x = mesh.point_fields["x"].to_f64();
    assert!(x.iter().zip(&mesh.points).all(|(x, point)| *x == point[0]));
    assert_eq!(mesh.nodes_where_nonzero("mark").unwrap(), mesh.node_sets["edge"]);
}

#[test]
fn curved_cells_have_their_exact_volume() {
    // x ↦ x + x²/4 on the unit square and box: area and volume 5/4.
    let bend = |[x, y, z]: [f64; 3]| [x + 0.25 * x * x, y + 0.1 * x * x, z];
    let mut plate = rectangle_triangles([1.0, 1.0], [2, 2]).quadratic();
    plate.map_points(bend);
    let area: f64 = (0..plate.cells.len()).map(|cell| plate.cell_volume(cell)).sum();
    assert!((area - 1.25).abs() < 1e-14);
    let mut block = box_tetrahedra([1.0; 3], [1; 3]).quadratic();
    block.map_points(bend);
    let volume: f64 = (0..block.cells.len()).map(|cell| block.cell_volume(cell)).sum();
    assert!((volume - 1.25).abs() < 1e-14);
}

/// Inner nodes move, the boundary and the volume stay, and no cell folds.
fn assert_distorts<const N: usize>(mesh: &Mesh<N>) {
    let distorted = mesh.distorted(3, 0.4);
    assert_eq!(distorted.check(), Ok(()));
    let boundary = mesh.nodes_of_facets(&boundary_facets(mesh));
    for node in 0..mesh.points.len() {
        let outside = boundary.binary_search(&node).is_ok();
        assert_eq!(outside, mesh.points[node] == distorted.points[node], "{node}");
    }
    let volume = |mesh: &Mesh<N>| -> f64 {
        let cells = 0..mesh.cells.len();
        let at_nodes =
            |cell: usize| Mesh::<N>::ELEMENT.nodes.iter().map(move |&at| mesh.jacobian(cell, at));
        assert!(cells.clone().flat_map(at_nodes).all(|jacobian| jacobian > 0.0));
        cells.map(|cell| mesh.cell_volume(cell)).sum()
    };
    assert!((volume(&distorted) / volume(mesh) - 1.0).abs() < 1e-13);
}

#[test]
fn every_kind_of_cell_is_distorted() {
    assert_distorts(&box_tetrahedra([2.0, 1.0, 1.0], [4, 3, 3]));
    assert_distorts(&box_tetrahedra([2.0, 1.0, 1.0], [3, 2, 2]).quadratic());
    assert_distorts(&box_hexahedra([2.0, 1.0, 1.0], [4, 3, 3]));
    assert_distorts(&rectangle_triangles([2.0, 1.0], [4, 3]));
    assert_distorts(&rectangle_triangles([2.0, 1.0], [3, 3]).quadratic());
}

#[test]
fn wild_moves_are_shortened() {
    let mesh = box_tetrahedra([1.0; 3], [4; 3]).distorted(1, 5.0);
    assert!((0..mesh.cells.len()).all(|cell| mesh.cell_volume(cell) > 0.0));
}
