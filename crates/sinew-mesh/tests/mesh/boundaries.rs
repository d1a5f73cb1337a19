//! Edges, facets and surfaces of meshes, and surfaces that pass through themselves.

use nalgebra::Vector3;
use sinew_mesh::{
    AnyMesh, Facet, Field, HexMesh, TriangleMesh, TruncatedEllipsoid, boundary_facets,
    box_hexahedra, box_tetrahedra, edges, enclosed_volume, extract_surface, rectangle_triangles,
    remove_unused_nodes, self_intersections,
};

#[test]
fn edges_of_one_cube() {
    let edges = edges(&box_tetrahedra([1.0; 3], [1; 3]));
    // 12 edges, 6 face diagonals and the main diagonal.
    assert_eq!(edges.len(), 19);
    assert!(edges.iter().all(|[sender, receiver]| sender > receiver));
    assert!(edges.is_sorted());
}

#[test]
fn nodes_of_a_side() {
    let mesh = box_tetrahedra([1.0; 3], [2, 3, 1]);
    for side in ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"] {
        assert_eq!(mesh.nodes_of_facets(&mesh.facet_sets[side]), mesh.node_sets[side]);
    }
}

#[test]
fn unused_nodes_leave_with_their_data() {
    let good = box_tetrahedra([1.0; 3], [1; 3]);
    let mut mesh = good.clone();
    mesh.points.insert(2, [9.0; 3]);
    mesh.points.push([8.0; 3]);
    let beyond = |node: &mut usize| *node += usize::from(*node >= 2);
    mesh.cells.as_flattened_mut().iter_mut().for_each(beyond);
    mesh.node_sets.values_mut().flatten().for_each(beyond);
    mesh.node_sets.insert("odd".into(), vec![1, 2, 3, 9]);
    mesh.point_fields.insert("old".into(), Field::labels((0..10).collect()));
    assert_eq!(remove_unused_nodes(&mut mesh), 2);
    assert_eq!((&mesh.points, &mesh.cells), (&good.points, &good.cells));
    assert_eq!(mesh.node_sets["x_max"], good.node_sets["x_max"]);
    assert_eq!(mesh.node_sets["odd"], [1, 2]);
    let kept = Field::labels(vec![0, 1, 3, 4, 5, 6, 7, 8]);
    assert_eq!(mesh.point_fields["old"], kept);
    assert_eq!(remove_unused_nodes(&mut mesh), 0);
}

#[test]
fn boundary_facets_point_outwards() {
    let mesh = box_tetrahedra([2.0, 2.0, 2.0], [2, 2, 2]);
    let boundary = boundary_facets(&mesh);
    assert_eq!(boundary.len(), 6 * 4 * 2);
    for facet in boundary {
        let [a, b, c] = mesh.facet_nodes(facet).map(|n| Vector3::from(mesh.points[n]));
        let from_centre = (a + b + c) / 3.0 - Vector3::from([1.0; 3]);
        assert!((b - a).cross(&(c - a)).dot(&from_centre) > 0.0);
    }
}

#[test]
fn triangle_edges_run_counterclockwise() {
    let mesh = rectangle_triangles([1.0, 1.0], [1, 1]);
    let mut twice_area = 0.0;
    for facet in boundary_facets(&mesh) {
        let ends: Vec<_> = mesh.nodes_of_facet(facet).map(|node| mesh.points[node]).collect();
        let [[ax, ay, _], [bx, by, _]] = ends[..] else { panic!("an edge has two ends") };
        twice_area += ax * by - ay * bx;
    }
    assert_eq!(twice_area, 2.0);
}

/// Rounding of sums of some hundred numbers near 1.
const ROUNDING: f64 = 1e-12;

#[test]
fn enclosed_volume_does_not_depend_on_the_origin() {
    let mut mesh = box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]);
    let boundary = boundary_facets(&mesh);
    assert!((enclosed_volume(&mesh, &boundary) - 6.0).abs() < ROUNDING);
    mesh.points.iter_mut().for_each(|point| point[1] += 5.0);
    assert!((enclosed_volume(&mesh, &boundary) - 6.0).abs() < 10.0 * ROUNDING);
}

#[test]
fn a_cavity_is_negative() {
    let mut mesh = box_tetrahedra([3.0; 3], [3; 3]);
    // The six tetrahedra of the grid cell in the middle.
    let middle = 6 * (1 + 3 + 9);
    mesh.cells.drain(middle..middle + 6);
    let inside = |facet: &Facet| {
        let nodes = mesh.facet_nodes(*facet);
        nodes.iter().all(|&node| mesh.points[node].iter().all(|x| (1.0..=2.0).contains(x)))
    };
    let wall: Vec<Facet> = boundary_facets(&mesh).into_iter().filter(inside).collect();
    assert_eq!(wall.len(), 12);
    assert!((enclosed_volume(&mesh, &wall) + 1.0).abs() < ROUNDING);
}

#[test]
fn surfaces_carry_fields_and_sets() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    mesh.point_fields.insert("index".into(), Field::labels((0..12).collect()));
    mesh.cell_fields.insert("cell".into(), Field::labels((0..12).collect()));
    let facets = mesh.facet_sets["x_max"].clone();
    let (side, nodes) = (extract_surface(&mesh, &facets), mesh.nodes_of_facets(&facets));
    assert_eq!(nodes, mesh.node_sets["x_max"]);
    assert_eq!(side.check(), Ok(()));
    assert_eq!(side.node_sets["x_max"], [0, 1, 2, 3]);
    assert_eq!(side.node_sets["y_min"], [0, 2]);
    assert_eq!(side.point_fields["index"].to_f64(), [2.0, 5.0, 8.0, 11.0].as_slice());
    let owners: Vec<f64> = facets.iter().map(|facet| facet.cell as f64).collect();
    assert_eq!(side.cell_fields["cell"].to_f64(), owners.as_slice());
}

fn cube(at: f64) -> TriangleMesh {
    let mesh = box_tetrahedra([1.0; 3], [3; 3]);
    let mut surface = extract_surface(&mesh, &boundary_facets(&mesh));
    // Different along each axis: edges that meet edges touch only.
    surface
        .points
        .iter_mut()
        .for_each(|[x, y, z]| (*x, *y, *z) = (*x + at, *y + 1.1 * at, *z + 1.3 * at));
    surface
}

fn both(mut a: TriangleMesh, b: TriangleMesh) -> TriangleMesh {
    let step = a.points.len();
    a.points.extend(b.points);
    a.cells.extend(b.cells.iter().map(|cell| cell.map(|node| node + step)));
    a
}

#[test]
fn sound_and_nested_surfaces_do_not_cross() {
    let mut small = cube(0.0);
    small.points.iter_mut().for_each(|x| *x = x.map(|x| 0.25 + 0.5 * x));
    assert!(self_intersections(&both(cube(0.0), small)).is_empty());
    // Twice the same surface touches everywhere.
    assert!(self_intersections(&both(cube(0.0), cube(0.0))).is_empty());
}

#[test]
fn overlapping_cubes_cross() {
    let found = self_intersections(&both(cube(0.0), cube(0.41)));
    let count = cube(0.0).cells.len();
    assert!(!found.is_empty(), "nothing was found");
    let wrong: Vec<_> = found.iter().filter(|[a, b]| *a >= count || *b < count).collect();
    assert!(wrong.is_empty(), "{count} {wrong:?}");
}

#[test]
fn a_spike_through_its_own_surface_is_found() {
    let mut surface = cube(0.0);
    let middle = surface.points.iter().position(|&x| x == [1.0 / 3.0, 1.0 / 3.0, 1.0]).unwrap();
    surface.points[middle] = [0.4, 0.45, -0.5];
    assert!(!self_intersections(&surface).is_empty());
}

/// Two blocks without common nodes, the second moved.
fn joined(a: HexMesh, mut b: HexMesh, by: [f64; 3]) -> AnyMesh {
    let (mut points, mut cells) = (a.points, a.cells);
    let step = points.len();
    b.points.iter_mut().for_each(|x| (0..3).for_each(|i| x[i] += by[i]));
    points.extend(b.points);
    cells.extend(b.cells.iter().map(|cell| cell.map(|node| node + step)));
    HexMesh::new(points, cells).unwrap().into()
}

#[test]
fn nodes_hang_where_blocks_touch_or_overlap_without_common_nodes() {
    let block = |cells: usize| box_hexahedra([10.0; 3], [cells; 3]);
    let hanging = |by: [f64; 3]| joined(block(2), block(4), by).hanging_nodes().len();
    // Of 25 nodes of the finer side 9 are at corners of the coarser one.
    assert_eq!(hanging([10.0, 0.0, 0.0]), 16);
    // Three digits in a file.
    assert_eq!(hanging([10.004, 0.0, 0.0]), 16);
    assert_eq!([hanging([10.1, 0.0, 0.0]), hanging([20.0, 0.0, 0.0])], [0, 0]);
    // Sides in common planes: two rings of 16 nodes lie on the coarser block, and one of 8 on the finer one.
    assert_eq!(hanging([7.0, 0.0, 0.0]), 40);
    // Alike: all nodes of the two sides meet.
    assert!(joined(block(2), block(2), [10.0, 0.0, 0.0]).hanging_nodes().is_empty());
}

#[test]
fn nodes_hang_in_the_middle_of_edges_and_in_the_plane() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).quadratic();
    // The middle node of a common edge becomes two, at the same place or apart.
    let (middle, copy) =
        (mesh.points.iter().position(|x| *x == [0.5; 3]).unwrap(), mesh.points.len());
    mesh.points.push([0.52; 3]);
    let local = mesh.cells[3].iter().position(|node| *node == middle).unwrap();
    mesh.cells[3][local] = copy;
    assert_eq!(AnyMesh::from(mesh).hanging_nodes(), [[copy, 0]]);

    // One quadratic block beside one of half the size: 25 nodes of the finer side, all nine of the coarser one among them.
    let (mut mesh, fine) = (
        box_tetrahedra([1.0; 3], [1; 3]).quadratic(),
        box_tetrahedra([1.0; 3], [2; 3]).quadratic(),
    );
    let places: Vec<usize> = fine
        .points
        .iter()
        .map(|x| {
            let place = [x[0] + 1.0, x[1], x[2]];
            mesh.points.iter().position(|own| *own == place).unwrap_or_else(|| {
                mesh.points.push(place);
                mesh.points.len() - 1
            })
        })
        .collect();
    mesh.cells.extend(fine.cells.iter().map(|cell| cell.map(|node| places[node])));
    assert_eq!(AnyMesh::from(mesh).hanging_nodes().len(), 16);

    let rectangle = |cells| rectangle_triangles([1.0; 2], [cells; 2]);
    let (mut plane, beside) = (rectangle(1), rectangle(2));
    let step = plane.points.len();
    plane.points.extend(beside.points.iter().map(|[x, y, z]| [x + 1.0, *y, *z]));
    plane.cells.extend(beside.cells.iter().map(|cell| cell.map(|node| node + step)));
    let half = plane.points.iter().position(|x| *x == [1.0, 0.5, 0.0]).unwrap();
    assert_eq!(
        AnyMesh::from(plane).hanging_nodes().iter().map(|pair| pair[0]).collect::<Vec<_>>(),
        [half]
    );
}

#[test]
fn parts_inside_of_others_are_found() {
    let small = || box_hexahedra([1.0; 3], [2; 3]);
    let inside = |by| joined(box_hexahedra([10.0; 3], [5; 3]), small(), by).enclosed_parts();
    assert_eq!(inside([4.1, 4.2, 4.3]), [125]);
    assert!(inside([11.0, 4.0, 4.0]).is_empty());
    let turned = joined(small(), box_hexahedra([10.0; 3], [5; 3]), [-4.0; 3]);
    assert_eq!(turned.enclosed_parts(), [0]);
    // In the hollow of another it is in no cell.
    let mut hollow = box_hexahedra([10.0; 3], [5; 3]);
    hollow.cells.remove(62);
    assert!(joined(hollow.clone(), small(), [4.5; 3]).enclosed_parts().is_empty());
    assert_eq!(joined(hollow, small(), [2.5; 3]).enclosed_parts(), [124]);
}

#[test]
fn plane_parts_that_overlap_are_found() {
    let (large, small) =
        (rectangle_triangles([8.0; 2], [4; 2]), rectangle_triangles([1.0; 2], [1; 2]));
    let both = |by: [f64; 2]| -> AnyMesh {
        let (mut mesh, step) = (large.clone(), large.points.len());
        mesh.points.extend(small.points.iter().map(|[x, y, _]| [x + by[0], y + by[1], 0.0]));
        mesh.cells.extend(small.cells.iter().map(|cell| cell.map(|node| node + step)));
        mesh.into()
    };
    let crossings = |mesh: &AnyMesh| self_intersections(&mesh.boundary_surface().0).len();
    let inside = both([2.5, 2.7]);
    assert_eq!((inside.enclosed_parts(), crossings(&inside)), (vec![32], 0));
    // Sides cross in their middles.
    let across = both([7.5, 2.5]);
    assert!(crossings(&across) > 0);
    let beside = both([9.0, 2.5]);
    assert_eq!((beside.enclosed_parts(), crossings(&beside)), (vec![], 0));
}

#[test]
fn no_node_of_a_generated_mesh_hangs() {
    // Thinner than the distance at which nodes hang.
    let sheet = box_tetrahedra([10.0, 1.0, 0.001], [5, 2, 1]);
    let ellipsoid = TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 15.0 };
    let wall = ellipsoid.wall([2, 16, 8]);
    let meshes: [AnyMesh; 5] = [
        sheet.quadratic().into(),
        sheet.into(),
        wall.hexahedra().into(),
        wall.quadratic_tetrahedra().into(),
        rectangle_triangles([2.0, 1.0], [3, 2]).into(),
    ];
    for mesh in meshes {
        assert!(mesh.hanging_nodes().is_empty(), "{:?}", mesh.element());
        assert!(mesh.enclosed_parts().is_empty(), "{:?}", mesh.element());
        assert!(self_intersections(&mesh.boundary_surface().0).is_empty(), "{:?}", mesh.element());
    }
}
