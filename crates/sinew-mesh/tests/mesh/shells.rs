//! Thick spheres and cylinders. Included by the tests and studies of other crates, too.
#![allow(dead_code, reason = "each test uses a part")]

use sinew_mesh::{Sheet, Wall};
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
pub(crate) fn sphere_octant(radii: [f64; 2], cells: [usize; 2]) -> Wall {
    check(radii, &cells);
    let [layers, across] = cells;
    let mut sheet = Sheet::default();
    for axis in 0..3 {
        sheet.patch([across; 2], |[i, j]| {
            let mut key = [across as i64; 3];
            (key[(axis + 1) % 3], key[(axis + 2) % 3]) = (i, j);
            (key, key.map(|at| share(at, across)))
        });
    }
    Wall {
        sheet,
        layers,
        lift: |at, depth| at.map(|x| (1.0 + depth) * x),
        depth: cube_depth,
        place: Box::new(move |at| {
            let largest = at.into_iter().fold(0.0, f64::max);
            let direction = at.map(|x| (FRAC_PI_4 * (x / largest)).tan());
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            let radius = between(radii, cube_depth(at));
            direction.map(|x| x / length * radius)
        }),
        sides: vec![
            ("x_min", Box::new(|at| at[0] == 0.0)),
            ("y_min", Box::new(|at| at[1] == 0.0)),
            ("z_min", Box::new(|at| at[2] == 0.0)),
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
/// When the radii are not positive, finite and ascending or a cell count is zero.
pub(crate) fn cylinder_quarter(radii: [f64; 2], height: f64, cells: [usize; 3]) -> Wall {
    check(radii, &cells);
    let [layers, around, along] = cells;
    let mut sheet = Sheet::default();
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
            ("x_min", Box::new(|at| at[0] == 1.0)),
            ("y_min", Box::new(|at| at[0] == 0.0)),
            ("z_min", Box::new(|at| at[1] == 0.0)),
            ("z_max", Box::new(|at| at[1] == 1.0)),
            ("inner", Box::new(|at| at[2] == 0.0)),
            ("outer", Box::new(|at| at[2] == 1.0)),
        ],
        nodes: Vec::new(),
    }
}

/// The value between those inside and outside at a depth; exact at both ends.
fn between([inner, outer]: [f64; 2], depth: f64) -> f64 {
    (1.0 - depth) * inner + depth * outer
}

/// Part of the way along `cells` cells, exactly 1 at the end.
fn share(at: i64, cells: usize) -> f64 {
    if at as usize == cells { 1.0 } else { at as f64 * (1.0 / cells as f64) }
}

fn check([inner, outer]: [f64; 2], cells: &[usize]) {
    assert!(
        inner > 0.0 && outer > inner && outer.is_finite(),
        "the radii must be positive and ascending, not {inner} and {outer}"
    );
    assert!(cells.iter().all(|&n| n > 0), "cell counts must be at least 1, not {cells:?}");
}
