//! Reference cells, volumes, orientation and quality.

use nalgebra::Vector3;
use sinew_mesh::{
    Element, Facet, Mesh, SLIVER_ANGLE, TetMesh, TriangleMesh, box_tetrahedra, min_dihedral_angle,
    quality, repair_orientation, volume_ratio,
};

const ALL: [&Element; 5] = [
    Mesh::<3>::ELEMENT,
    Mesh::<4>::ELEMENT,
    Mesh::<6>::ELEMENT,
    Mesh::<8>::ELEMENT,
    Mesh::<10>::ELEMENT,
];

fn at(element: &Element, node: usize) -> Vector3<f64> {
    element.nodes[node].into()
}

#[test]
fn middle_nodes_lie_in_the_middle() {
    for element in ALL {
        assert_eq!(Element::with_nodes(element.nodes.len()), element);
        for edge in element.edges {
            if let [a, b, middle] = **edge {
                let expected = (at(element, a) + at(element, b)) / 2.0;
                assert_eq!(at(element, middle), expected, "{}", element.name);
            }
        }
        for facet in element.facets {
            let corners = &facet[..element.facet_corners];
            for (k, &middle) in facet[element.facet_corners..].iter().enumerate() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                assert_eq!(at(element, middle), (at(element, a) + at(element, b)) / 2.0);
            }
        }
    }
}

/// Repairs a reference cell that a mirror turned inside out.
fn assert_keeps_its_edges_and_facets<const N: usize>() {
    let element = Mesh::<N>::ELEMENT;
    let mirrored =
        |&[x, y, z]: &[f64; 3]| if element.dimension == 3 { [x, y, -z] } else { [y, x, z] };
    let points = element.nodes.iter().map(mirrored).collect();
    let mut mesh =
        Mesh::<N> { points, cells: vec![std::array::from_fn(|node| node)], ..Mesh::default() };
    let facets = (0..element.facets.len()).map(|opposite| Facet { cell: 0, opposite });
    mesh.facet_sets = facets.map(|facet| (facet.opposite.to_string(), vec![facet])).collect();
    let before = mesh.clone();
    assert_eq!((repair_orientation(&mut mesh), mesh.check()), (1, Ok(())));
    let edges = |mesh: &Mesh<N>| -> Vec<Vec<usize>> {
        let of_cell = |edge: &&[usize]| {
            let mut nodes: Vec<_> = edge.iter().map(|&node| mesh.cells[0][node]).collect();
            nodes.sort_unstable();
            nodes
        };
        let mut edges: Vec<_> = element.edges.iter().map(of_cell).collect();
        edges.sort_unstable();
        edges
    };
    assert_eq!(edges(&mesh), edges(&before), "{}", element.name);
    for (name, facets) in &before.facet_sets {
        let nodes = mesh.nodes_of_facets(&mesh.facet_sets[name]);
        assert_eq!(nodes, before.nodes_of_facets(facets), "{} {name}", element.name);
    }
}

#[test]
fn mirrored_cells_keep_their_edges_and_facets() {
    assert_keeps_its_edges_and_facets::<3>();
    assert_keeps_its_edges_and_facets::<4>();
    assert_keeps_its_edges_and_facets::<6>();
    assert_keeps_its_edges_and_facets::<8>();
    assert_keeps_its_edges_and_facets::<10>();
}

#[test]
fn facets_face_outwards() {
    for element in ALL {
        let corners = (0..element.corners).map(|node| at(element, node));
        let centre = corners.sum::<Vector3<f64>>() / element.corners as f64;
        for (k, facet) in element.facets.iter().enumerate() {
            let along = at(element, facet[1]) - at(element, facet[0]);
            let normal = match element.dimension {
                3 => along.cross(&(at(element, facet[2]) - at(element, facet[1]))),
                _ => along.cross(&Vector3::z()),
            };
            assert!(normal.dot(&(at(element, facet[0]) - centre)) > 0.0, "{} {k}", element.name);
            let simplex = element.corners == element.dimension + 1;
            assert!(!simplex || !facet.contains(&k), "{} {k}", element.name);
        }
    }
}

fn corner_tet(cell: [usize; 4]) -> TetMesh {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    TetMesh { points, cells: vec![cell], ..TetMesh::default() }
}

#[test]
fn signed_volume() {
    assert_eq!(corner_tet([0, 1, 2, 3]).cell_volume(0), 1.0 / 6.0);
    assert_eq!(corner_tet([0, 2, 1, 3]).cell_volume(0), -1.0 / 6.0);
}

#[test]
fn repair_counts_and_keeps_facets() {
    let mut mesh = corner_tet([0, 2, 1, 3]);
    mesh.facet_sets.insert("slanted".into(), vec![Facet { cell: 0, opposite: 0 }]);
    mesh.facet_sets.insert("x".into(), vec![Facet { cell: 0, opposite: 2 }]);
    assert_eq!(repair_orientation(&mut mesh), 1);
    assert_eq!(mesh.cells, [[0, 1, 2, 3]]);
    assert_eq!(mesh.facet_sets["slanted"], [Facet { cell: 0, opposite: 0 }]);
    assert_eq!(mesh.facet_sets["x"], [Facet { cell: 0, opposite: 1 }]);
    assert_eq!(repair_orientation(&mut mesh), 0);
}

#[test]
fn triangles_are_turned_in_the_plane_only() {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut mesh = TriangleMesh { points, cells: vec![[0, 2, 1]], ..Default::default() };
    assert_eq!(repair_orientation(&mut mesh), 1);
    assert_eq!(mesh.cells, [[0, 1, 2]]);
    mesh.cells = vec![[0, 2, 1]];
    mesh.points[1][2] = 1.0;
    assert_eq!(repair_orientation(&mut mesh), 0);
}

/// A few rounding errors of numbers near 1 or 100.
const ROUNDING: f64 = 1e-12;

fn one_tet(points: [[f64; 3]; 4]) -> TetMesh {
    TetMesh { points: points.to_vec(), cells: vec![[0, 1, 2, 3]], ..TetMesh::default() }
}

#[test]
fn a_regular_tetrahedron() {
    let mesh = one_tet([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]);
    let expected = (1.0f64 / 3.0).acos().to_degrees();
    assert!((min_dihedral_angle(&mesh, 0) - expected).abs() < ROUNDING);
    assert!((volume_ratio(&mesh, 0).abs() - 1.0).abs() < ROUNDING);
}

#[test]
fn a_corner_of_a_cube() {
    let mesh = one_tet([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let expected = (1.0f64 / 3.0f64.sqrt()).acos().to_degrees();
    assert!((min_dihedral_angle(&mesh, 0) - expected).abs() < ROUNDING);
    // V = 1/6 and the mean square of the edges is 3/2.
    assert!((volume_ratio(&mesh, 0) - 2f64.sqrt() / 1.5f64.powf(1.5)).abs() < ROUNDING);
}

#[test]
fn a_sliver_is_found() {
    let height = 0.01f64;
    let flat = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, height], [0.0, 1.0, height]];
    let mut mesh = one_tet(flat);
    // Both sides at the edge from x = -1 to 1 rise by `height` over 1.
    let expected = (2.0 * height).atan2(1.0 - height * height).to_degrees();
    assert!(min_dihedral_angle(&mesh, 0) <= expected + ROUNDING);
    mesh.cells.push([0, 1, 2, 3]);
    mesh.points.push([0.0, 0.0, 3.0]);
    mesh.cells[0] = [0, 1, 2, 4];
    let summary = quality(&mesh).unwrap();
    assert!(min_dihedral_angle(&mesh, 1) < SLIVER_ANGLE);
    assert_eq!((summary.worst_cell, summary.slivers), (1, vec![1]));
}

#[test]
fn the_summary_prints() {
    let summary = quality(&box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1])).unwrap();
    let text = summary.to_string();
    assert!(text.contains("12 nodes, 12 tetrahedra, volume 2.000000"), "{text}");
    assert!(text.contains("45.0000") && text.contains("slivers below 5 deg: 0"), "{text}");
    assert_eq!(quality(&TetMesh::default()), None);
}

#[test]
fn collapsed_cells_have_a_number() {
    let mesh = one_tet([[1.0; 3]; 4]);
    assert_eq!((volume_ratio(&mesh, 0), min_dihedral_angle(&mesh, 0)), (0.0, 0.0));
}
