//! Coordinates and segments of a left ventricle's wall.

use sinew_calibrate::{Direction, WallCoordinates};
use sinew_fem::fibres::Surfaces;
use sinew_mesh::{TetMesh, TruncatedEllipsoid};

const SURFACES: Surfaces<'static> =
    Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };

fn centre(mesh: &TetMesh, cell: usize) -> [f64; 3] {
    std::array::from_fn(|i| {
        mesh.cells[cell].iter().map(|&node| mesh.points[node][i]).sum::<f64>() / 4.0
    })
}

#[test]
fn coordinates_of_an_ellipsoid_are_those_of_its_formula() {
    let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
    let wall = WallCoordinates::new(&mesh, &SURFACES).unwrap().with_septum([-2.0, 0.0, 0.3]);
    let wall = wall.unwrap();
    for cell in 0..mesh.cells.len() {
        let [x, y, z] = centre(&mesh, cell);
        // The base is at z = 5, the apex of the endocardium at −17.
        assert!((wall.heights[cell] - (z + 17.0) / 22.0).abs() < 1e-9);
        // From −x on; an eye at the apex looks up, so that y is on the left of −x as it turns counterclockwise.
        let angle = y.atan2(-x).to_degrees().rem_euclid(360.0);
        let off = (wall.angles[cell] - angle).rem_euclid(360.0);
        assert!(off.min(360.0 - off) < 1e-6, "{} is not {angle}", wall.angles[cell]);
        assert!((0.0..=1.0).contains(&wall.depths[cell]));
        let radial = wall.direction(cell, Direction::Radial);
        let around = wall.direction(cell, Direction::Circumferential);
        if wall.heights[cell] > 0.3 {
            assert!(radial[0] * x + radial[1] * y > 0.0, "{radial:?} at {x}, {y}");
            assert!((around[0] * x + around[1] * y).abs() < 0.35 * x.hypot(y), "{around:?}");
        }
    }
}

/// M. D. Cerqueira et al. (2002): seen from the apex with the septum on the left, the anterior wall is up and the lateral one on the right.
#[test]
fn segments_lie_as_in_the_polar_map() {
    let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
    let wall = WallCoordinates::new(&mesh, &SURFACES).unwrap();
    let segments = wall.with_septum([-1.0, 0.0, 0.0]).unwrap().aha17().unwrap();
    let mean = |name: &str, axis: usize| {
        let cells = segments.cells_of(name).unwrap();
        cells.iter().map(|&cell| centre(&mesh, cell)[axis]).sum::<f64>() / cells.len() as f64
    };
    // Seen from below with −x on the left, −y is up.
    for (anterior, inferior) in [("1", "4"), ("7", "10"), ("13", "15")] {
        assert!(mean(anterior, 1) < -2.0 && mean(inferior, 1) > 2.0, "{anterior}");
    }
    for septal in ["2", "3", "8", "9", "14"] {
        assert!(mean(septal, 0) < -1.5, "{septal}");
    }
    assert!(mean("2", 1) < 0.0 && mean("3", 1) > 0.0);
    assert!(mean("5", 1) > 0.0 && mean("6", 1) < 0.0 && mean("5", 0) > 1.0);
    assert!(mean("1", 2) > mean("7", 2) && mean("7", 2) > mean("13", 2));
    assert!(mean("17", 2) < -17.0);
}
