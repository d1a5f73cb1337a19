//! Bodies of structured grids: boxes, the membrane, spheres, tubes and truncated ellipsoids.

use crate::membrane::cook_membrane;
use crate::shells::{cylinder_quarter, sphere_octant};
use nalgebra::Vector3;
use sinew_mesh::{
    Facet, Mesh, TruncatedEllipsoid, boundary_facets, box_hexahedra, box_tetrahedra,
    enclosed_volume, quality, rectangle_triangles,
};
use std::f64::consts::PI;

/// A solid whose cells are positive at and between their nodes, fit together (what is not shared
/// is on a named side) and fill what the boundary encloses. Returns its volume.
fn assert_sound<const N: usize>(mesh: &Mesh<N>) -> f64 {
    assert_eq!(mesh.check(), Ok(()));
    let element = Mesh::<N>::ELEMENT;
    let centre: [f64; 3] =
        std::array::from_fn(|axis| element.nodes.iter().map(|at| at[axis]).sum::<f64>() / N as f64);
    for cell in 0..mesh.cells.len() {
        for node in element.nodes {
            for way in [0.0, 0.4, 0.8, 1.0] {
                let at = std::array::from_fn(|i| way * node[i] + (1.0 - way) * centre[i]);
                assert!(mesh.jacobian(cell, at) > 0.0, "cell {cell} at {at:?}");
            }
        }
    }
    let boundary = boundary_facets(mesh);
    let mut named: Vec<Facet> = mesh.facet_sets.values().flatten().copied().collect();
    named.sort_unstable();
    assert_eq!(named, boundary);
    let volume: f64 = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).sum();
    assert!((enclosed_volume(mesh, &boundary) / volume - 1.0).abs() < 1e-12);
    volume
}

#[test]
fn hexahedra_fill_the_box() {
    let mesh = box_hexahedra([2.0, 3.0, 4.0], [2, 1, 3]);
    assert!((assert_sound(&mesh) - 24.0).abs() < 1e-13);
    assert_eq!(mesh.points, box_tetrahedra([2.0, 3.0, 4.0], [2, 1, 3]).points);
    assert_eq!(mesh.cells[0], [0, 1, 4, 3, 6, 7, 10, 9]);
    assert_eq!(mesh.facet_sets["z_max"], [4, 5].map(|cell| Facet { cell, opposite: 5 }));
}

#[test]
fn the_first_grid_cell_is_split_as_published() {
    let mesh = box_tetrahedra([2.0, 3.0, 4.0], [2, 1, 1]);
    assert_eq!(mesh.points[0], [0.0, 0.0, 0.0]);
    assert_eq!(mesh.points[1], [1.0, 0.0, 0.0]);
    assert_eq!(mesh.points[3], [0.0, 3.0, 0.0]);
    assert_eq!(mesh.points[6], [0.0, 0.0, 4.0]);
    // Walks 0 -> 10 over strides 1, 3, 6; odd axis orders have vertices 1 and 2 swapped.
    let expected =
        [[0, 1, 4, 10], [0, 7, 1, 10], [0, 4, 3, 10], [0, 3, 9, 10], [0, 6, 7, 10], [0, 9, 6, 10]];
    assert_eq!(mesh.cells[..6], expected);
}

#[test]
fn simplices_fill_the_box_and_the_rectangle() {
    assert!((assert_sound(&box_tetrahedra([10.0, 1.0, 2.0], [5, 2, 3])) - 20.0).abs() < 1e-12);
    let plate = rectangle_triangles([3.0, 2.0], [4, 3]);
    let area: f64 = (0..plate.cells.len()).map(|c| plate.cell_volume(c)).sum();
    assert!((area - 6.0).abs() < 1e-13);
}

#[test]
fn sides_are_complete() {
    let mesh = box_tetrahedra([1.0, 1.0, 1.0], [2, 3, 4]);
    assert_eq!(mesh.node_sets["x_min"].len(), 4 * 5);
    assert_eq!(mesh.node_sets["z_max"].len(), 3 * 4);
    assert_eq!(mesh.facet_sets["x_max"].len(), 2 * 3 * 4);
    assert_eq!(mesh.facet_sets["y_min"].len(), 2 * 2 * 4);
    let plate = rectangle_triangles([1.0, 1.0], [2, 3]);
    assert_eq!(plate.facet_sets["x_min"].len(), 3);
    assert_eq!(plate.node_sets.len(), 4);
}

#[test]
fn crossed_triangles_fill_the_membrane() {
    let mut mesh = cook_membrane(4);
    assert_eq!(mesh.check(), Ok(()));
    assert_eq!(mesh.facet_sets["x_max"].len(), 4);
    let sides: usize = mesh.facet_sets.values().map(Vec::len).sum();
    assert_eq!(sides, boundary_facets(&mesh).len());
    assert_eq!(mesh.node_sets["y_max"], [20, 21, 22, 23, 24]);
    // On the square that the membrane is the image of, the four triangles of a box are equal.
    mesh.map_points(|[x, y, z]| {
        let x = x / 48.0;
        [x, (y - 44.0 * x) / (44.0 - 28.0 * x), z]
    });
    let areas: Vec<f64> = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).collect();
    assert_eq!(areas.len(), 64);
    assert!(areas.iter().all(|area| (area - 1.0 / 64.0).abs() < 1e-15));
    for (at, cells) in mesh.cells.chunks(4).enumerate() {
        // Counterclockwise around the centre, which stands behind the nodes of the grid.
        assert!(cells.iter().all(|cell| cell[2] == 25 + at));
        assert!((0..4).all(|k| cells[k][1] == cells[(k + 1) % 4][0]));
    }
}

#[test]
fn the_membrane_has_its_corners() {
    let mesh = cook_membrane(2);
    let corners = [0, 2, 6, 8].map(|node| mesh.points[node]);
    let expected = [[0.0, 0.0], [48.0, 44.0], [0.0, 44.0], [48.0, 60.0]];
    assert_eq!(corners, expected.map(|[x, y]| [x, y, 0.0]));
    assert!(mesh.node_sets["x_max"].iter().all(|&node| mesh.points[node][0] == 48.0));
}

#[test]
#[should_panic(expected = "cell counts at least 1")]
fn no_boxes_are_refused() {
    cook_membrane(0);
}

#[test]
fn the_octant_fills_its_sphere() {
    let exact = PI / 6.0 * 7.0;
    for (layers, across) in [(1, 1), (2, 3), (1, 8)] {
        let wall = sphere_octant([1.0, 2.0], [layers, across]);
        assert_sound(&wall.tetrahedra());
        let quadratic = assert_sound(&wall.quadratic_tetrahedra());
        let linear = assert_sound(&wall.hexahedra());
        let step = 1.0 / across as f64;
        assert!((linear / exact - 1.0).abs() < 0.3 * step.powi(2), "{linear} {exact}");
        assert!((quadratic / exact - 1.0).abs() < 0.01 * step.powi(4), "{quadratic} {exact}");
    }
}

#[test]
fn the_octant_has_its_sides() {
    let mesh = sphere_octant([1.0, 2.0], [2, 3]).quadratic_tetrahedra();
    for (axis, name) in ["x_min", "y_min", "z_min"].into_iter().enumerate() {
        let expected = (0..mesh.points.len()).filter(|&n| mesh.points[n][axis] == 0.0);
        assert_eq!(mesh.node_sets[name], expected.collect::<Vec<_>>(), "{name}");
    }
    let radius = |node: usize| Vector3::from(mesh.points[node]).norm();
    for (name, expected) in [("inner", 1.0), ("outer", 2.0)] {
        let off = |&node: &usize| (radius(node) - expected).abs() > 4.0 * f64::EPSILON;
        assert!(!mesh.node_sets[name].iter().any(off), "{name}");
    }
    assert_eq!(mesh.facet_sets["inner"].len(), 3 * 9 * 2);
    let depth = mesh.point_fields["depth"].to_f64();
    assert!((0..depth.len()).all(|node| (depth[node] + 1.0 - radius(node)).abs() < 1e-14));
}

#[test]
fn the_tube_fills_its_quarter() {
    let wall = cylinder_quarter([1.0, 2.0], 0.5, [2, 4, 1]);
    let exact = 0.375 * PI;
    assert!((assert_sound(&wall.quadratic_tetrahedra()) / exact - 1.0).abs() < 1e-4);
    assert!((assert_sound(&wall.hexahedra()) / exact - 1.0).abs() < 0.03);
    let mesh = wall.tetrahedra();
    assert_sound(&mesh);
    assert!(mesh.node_sets["x_min"].iter().all(|&node| mesh.points[node][0] == 0.0));
    assert!(mesh.node_sets["y_min"].iter().all(|&node| mesh.points[node][1] == 0.0));
    assert_eq!(mesh.node_sets["z_max"].len(), 3 * 5);
}

#[test]
#[should_panic(expected = "radii must be positive and ascending, not 2 and 1")]
fn a_sphere_inside_out_is_refused() {
    sphere_octant([2.0, 1.0], [1, 1]);
}

#[test]
#[should_panic(expected = "cell counts must be at least 1")]
fn a_tube_without_cells_is_refused() {
    cylinder_quarter([1.0, 2.0], 1.0, [1, 0, 1]);
}

/// Volume of an ellipsoid of revolution below z = base.
fn below_base(short: f64, long: f64, base: f64) -> f64 {
    let antiderivative = |z: f64| z - z.powi(3) / (3.0 * long * long);
    PI * short * short * (antiderivative(base) - antiderivative(-long))
}

#[test]
fn the_wall_fills_the_ellipsoid() {
    let exact = below_base(10.0, 20.0, 5.0) - below_base(7.0, 17.0, 5.0);
    for cells in [[1, 8, 2], [2, 16, 8], [3, 32, 16]] {
        let wall = TruncatedEllipsoid::LAND.wall(cells);
        let step = 8.0 / cells[1] as f64;
        for volume in [assert_sound(&wall.tetrahedra()), assert_sound(&wall.hexahedra())] {
            assert!((volume / exact - 1.0).abs() < 0.3 * step.powi(2), "{volume} {exact}");
        }
        let mesh = wall.quadratic_tetrahedra();
        let volume = assert_sound(&mesh);
        assert!((volume / exact - 1.0).abs() < 0.02 * step.powi(4), "{volume} {exact}");
    }
}

#[test]
fn cells_keep_a_good_shape() {
    let wall = TruncatedEllipsoid::LAND.wall([2, 24, 12]);
    let summary = quality(&wall.tetrahedra()).unwrap();
    assert!(summary.dihedral.min > 19.0, "{summary}");
    assert!(summary.ratio.min > 0.36, "{summary}");
}

#[test]
fn nodes_lie_on_the_surfaces() {
    let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 6]).quadratic_tetrahedra();
    for (name, short, long) in [("endo", 7.0, 17.0), ("epi", 10.0, 20.0)] {
        for &node in &mesh.node_sets[name] {
            let [x, y, z] = mesh.points[node];
            let on = (x / short).powi(2) + (y / short).powi(2) + (z / long).powi(2);
            assert!((on - 1.0).abs() < 1e-14, "{name} {node}");
        }
        let apex = &mesh.node_sets[&format!("apex_{name}")];
        assert_eq!(apex.len(), 1);
        assert_eq!(mesh.points[apex[0]], [0.0, 0.0, -long]);
    }
    let base = (0..mesh.points.len()).filter(|&node| mesh.points[node][2] == 5.0);
    assert_eq!(mesh.node_sets["base"], base.collect::<Vec<_>>());
}

#[test]
fn the_cavity_has_its_volume() {
    let mut mesh = TruncatedEllipsoid::LAND.wall([1, 32, 16]).quadratic_tetrahedra();
    mesh.map_points(|[x, y, z]| [x, y, z - 5.0]);
    let cavity = -enclosed_volume(&mesh, &mesh.facet_sets["endo"]);
    let exact = below_base(7.0, 17.0, 5.0);
    assert!((cavity / exact - 1.0).abs() < 1e-4, "{cavity} {exact}");
}

#[test]
#[should_panic(expected = "multiple of 8")]
fn odd_numbers_around_are_refused() {
    TruncatedEllipsoid::LAND.wall([1, 12, 4]);
}

#[test]
#[should_panic(expected = "does not cut the inner ellipsoid")]
fn a_base_above_the_ellipsoid_is_refused() {
    TruncatedEllipsoid { base: 18.0, ..TruncatedEllipsoid::LAND }.wall([1, 8, 4]);
}
