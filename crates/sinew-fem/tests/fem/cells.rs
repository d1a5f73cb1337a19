//! Shapes and volume ratios of cells, by the report of a solution.

use crate::support::parameters;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Scene, Support};
use sinew_fem::{Options, Solution, Solver, report};
use sinew_mesh::{AnyMesh, Mesh, TetMesh, TriangleMesh, box_hexahedra};

/// A few roundings of numbers near 1.
const ROUNDING: f64 = 1e-14;

/// A body at rest whose first side is clamped.
fn at_rest(mesh: impl Into<AnyMesh>) -> (Body, Solution) {
    let scene = Scene::new(mesh, NeoHookean).support(Support::clamped("x_min"));
    let body = Scene { parameters: parameters(&["mu", "lambda"]), ..scene }.lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[1.0, 1.0], &Options::default()).unwrap();
    (body, solution)
}

/// One cell, held at its first corners.
fn alone<const N: usize>(points: &[[f64; 3]; N]) -> Mesh<N> {
    let mut mesh = Mesh {
        points: points.to_vec(),
        cells: vec![std::array::from_fn(|i| i)],
        ..Mesh::default()
    };
    mesh.node_sets.insert("x_min".into(), (0..N - 1).collect());
    mesh
}

fn worst_shape(mesh: impl Into<AnyMesh>) -> f64 {
    let (body, solution) = at_rest(mesh);
    report(&body, &solution).unwrap().worst_reference_shapes[0].value
}

#[test]
fn regular_cells_have_mean_ratio_one_and_flat_ones_none() {
    let corners = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
    let tet: TetMesh = alone(&corners);
    assert!((worst_shape(tet.clone()) - 1.0).abs() < ROUNDING);
    // Two corners change places, so that the cell is turned inside out.
    let (body, mut solution) = at_rest(tet.quadratic());
    for i in 0..3 {
        solution.displacement[i] = corners[1][i] - corners[0][i];
        solution.displacement[3 + i] = corners[0][i] - corners[1][i];
    }
    assert_eq!(report(&body, &solution).unwrap().worst_deformed_shapes[0].value, 0.0);

    let triangle: TriangleMesh = alone(&[[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.75f64.sqrt(), 0.0]]);
    assert!((worst_shape(triangle) - 1.0).abs() < ROUNDING);
    assert!((worst_shape(box_hexahedra([1.0; 3], [1; 3])) - 1.0).abs() < ROUNDING);
    // Twice as long in one direction: 3 · 2^(2/3) / 6.
    let brick = worst_shape(box_hexahedra([2.0, 1.0, 1.0], [1; 3]));
    assert!((brick - 0.5 * 2f64.powf(2.0 / 3.0)).abs() < ROUNDING);
}

/// A row of hexahedra that are stretched to these volume ratios; that of the last one grows from its lower to its upper side.
#[test]
fn the_worst_come_first() {
    let (body, mut solution) = at_rest(box_hexahedra([6.0, 1.0, 1.0], [6, 1, 1]));
    let places = [0.0, 0.5, 0.75, 2.75, 3.0, 4.5, 5.0];
    for (node, [x, y, _]) in body.positions.iter().enumerate() {
        let last = if *x == 6.0 { *y } else { 0.0 };
        solution.displacement[3 * node] = places[*x as usize] + last - x;
    }
    let found = report(&body, &solution).unwrap();
    let cells: Vec<_> = found.least_volume_ratios.iter().map(|c| c.cell).collect();
    // Equal ones in their order; five at most.
    assert_eq!(cells, [1, 3, 0, 5, 4], "{found}");
    assert_eq!(found.largest_volume_ratio.cell, 2);
    // J = ½ + y of the last cell is least at the lower quadrature points.
    let least = 1.0 - 3f64.sqrt() / 6.0;
    for (cell, exact) in found.least_volume_ratios.iter().zip([0.25, 0.25, 0.5, least, 1.5]) {
        assert!((cell.value - exact).abs() < ROUNDING, "{found}");
    }
    assert!((found.largest_volume_ratio.value - 2.0).abs() < ROUNDING, "{found}");
}
