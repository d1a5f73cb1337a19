//! Thick spheres and cylinders.

use super::grid_coordinate;
use super::wall::{Sheet, Wall, side};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// The octant x, y, z ≥ 0 of a sphere with a hole, of radii `[inner, outer]`. Its surface is the image
/// of three sides of a cube, with equal angles between the nodes, so that no cell degenerates at a pole.
///
/// `cells` are the layers through the wall and the cells along each edge of the cube; the edge of the
/// octant in a plane of symmetry has twice as many. The sides are `x_min`, `y_min`, `z_min` (the planes
/// of symmetry), `inner` and `outer`.
///
/// # Panics
/// When the radii are not positive, finite and ascending or a cell count is zero.
///
/// ```
/// let wall = sinew_mesh::sphere_octant([1.0, 2.0], [2, 4]);
/// let (tets, hexes) = (wall.quadratic_tetrahedra(), wall.hexahedra());
/// assert_eq!((tets.cells.len(), hexes.cells.len()), (2 * 3 * 16 * 6, 2 * 3 * 16));
/// for &node in &tets.node_sets["inner"] {
///     let [x, y, z] = tets.points[node];
///     assert!(((x * x + y * y + z * z).sqrt() - 1.0).abs() < 1e-15);
/// }
/// ```
pub fn sphere_octant(radii: [f64; 2], cells: [usize; 2]) -> Wall {
    check("radii", radii, &cells);
    let [layers, across] = cells;
    let mut sheet = Sheet::default();
    for axis in 0..3 {
        sheet.patch([across; 2], |[i, j]| {
            let mut key = [across as i64; 3];
            (key[(axis + 1) % 3], key[(axis + 2) % 3]) = (i, j);
            (key, key.map(|at| grid_coordinate(at as usize, across, 1.0)))
        });
    }
    Wall {
        sheet,
        layers,
        lift: |at, depth| at.map(|x| (1.0 + depth) * x),
        depth: cube_depth,
        place: Box::new(move |at| {
            let largest = at.into_iter().fold(0.0, f64::max);
            let direction = Vector3::from(at.map(|x| (FRAC_PI_4 * (x / largest)).tan()));
            (direction.normalize() * between(radii, cube_depth(at))).into()
        }),
        sides: vec![
            ("x_min", side(0, 0.0)),
            ("y_min", side(1, 0.0)),
            ("z_min", side(2, 0.0)),
            ("inner", Box::new(|at| cube_depth(at) == 0.0)),
            ("outer", Box::new(|at| cube_depth(at) == 1.0)),
        ],
        nodes: Vec::new(),
    }
}

/// Depth in the cube's wall between the sides at distance 1 and 2.
fn cube_depth(at: [f64; 3]) -> f64 {
    at.into_iter().fold(0.0, f64::max) - 1.0
}

/// The quarter x, y ≥ 0 of a tube around the z axis, of radii `[inner, outer]` and the given height
/// from z = 0.
///
/// `cells` are the layers through the wall, the cells around the quarter and those along the axis. The
/// sides are `x_min`, `y_min` (the planes of symmetry), `z_min`, `z_max`, `inner` and `outer`.
///
/// # Panics
/// When the radii are not positive, finite and ascending, the height is not positive and finite or a
/// cell count is zero.
///
/// ```
/// let tube = sinew_mesh::cylinder_quarter([1.0, 2.0], 0.5, [4, 8, 1]).quadratic_tetrahedra();
/// assert_eq!(tube.cells.len(), 4 * 8 * 6);
/// let volume: f64 = (0..tube.cells.len()).map(|cell| tube.cell_volume(cell)).sum();
/// assert!((volume / (0.375 * std::f64::consts::PI) - 1.0).abs() < 1e-5);
/// ```
pub fn cylinder_quarter(radii: [f64; 2], height: f64, cells: [usize; 3]) -> Wall {
    check("radii", radii, &cells);
    assert!(height.is_finite() && height > 0.0, "the height must be positive, not {height}");
    let [layers, around, along] = cells;
    let mut sheet = Sheet::default();
    let share = |at: i64, cells: usize| grid_coordinate(at as usize, cells, 1.0);
    sheet.patch([around, along], |[i, j]| ([i, j, 0], [share(i, around), share(j, along), 0.0]));
    Wall {
        sheet,
        layers,
        lift: |[turn, up, _], depth| [turn, up, depth],
        depth: |[_, _, depth]| depth,
        place: Box::new(move |[turn, up, depth]| {
            let radius = between(radii, depth);
            // Both are sines, so that the planes of symmetry are met exactly.
            let [x, y] = [1.0 - turn, turn].map(|part| radius * (FRAC_PI_2 * part).sin());
            [x, y, height * up]
        }),
        sides: vec![
            ("x_min", side(0, 1.0)),
            ("y_min", side(0, 0.0)),
            ("z_min", side(1, 0.0)),
            ("z_max", side(1, 1.0)),
            ("inner", side(2, 0.0)),
            ("outer", side(2, 1.0)),
        ],
        nodes: Vec::new(),
    }
}

/// The value between those inside and outside at a depth; exact at both ends.
pub(super) fn between([inner, outer]: [f64; 2], depth: f64) -> f64 {
    (1.0 - depth) * inner + depth * outer
}

pub(super) fn check(what: &str, [inner, outer]: [f64; 2], cells: &[usize]) {
    assert!(
        inner > 0.0 && outer > inner && outer.is_finite(),
        "the {what} must be positive and ascending, not {inner} and {outer}"
    );
    assert!(cells.iter().all(|&n| n > 0), "cell counts must be at least 1, not {cells:?}");
}
