//! Curves of equilibria where bodies are hard to follow.

use crate::hard_cases::bodies::*;
use sinew_energy::laws::{Guccione, NeoHookean};
use sinew_energy::{Load, Magnitude, Scene};
use sinew_fem::{CurvePoint, Line, Options, SolveError, Solver};
use sinew_mesh::box_tetrahedra;

/// Only equilibria, or an error with numbers, within so many points.
const MOST: usize = 60;

/// A beam that a pressure without a rim rolls up meets the equilibrium that a solve finds.
#[test]
fn a_loose_pressure_is_followed_to_where_a_solve_ends() {
    let load = Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Fixed(0.01) };
    let beam = scene(NeoHookean, box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]));
    let body = Scene { loads: vec![load], ..beam }.loose_rims().lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let (theta, options) = ([1.0, 1.0], Options::default());
    let solved = solver.solve(&theta, &options).unwrap().displacement;
    let curve = solver.follow(&Line::of_loads(&theta), &options).unwrap().take(MOST);
    let last = curve.map(Result::unwrap).last().unwrap();
    assert_eq!(last.place, 1.0);
    let off = solved.iter().zip(&last.solution.displacement).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-7);
}

/// A cube of ten thousand times the resistance to volume changes is pulled to twice its length.
#[test]
fn a_nearly_incompressible_body_is_followed_along_a_motion() {
    let body = Scene { supports: pulled(1.0), ..scene(NeoHookean, cube(3)) }.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let line = Line::of_loads(&[1.0, 1e4]);
    let curve = solver.follow(&line, &Options::default()).unwrap().take(MOST);
    let points: Vec<_> = curve.map(Result::unwrap).collect();
    let CurvePoint { place, solution, .. } = &points[points.len() - 1];
    assert!(*place == 1.0 && (solution.least_volume_ratio - 1.0).abs() < 1e-2);
    assert!(solution.residual <= 1e-9 * solution.force_scale);
}

/// Exponentials of a fibre law overflow long before the load that is asked for: every point before is an equilibrium, and the error
/// tells how far the load went.
#[test]
fn a_law_that_overflows_ends_a_curve_with_the_last_equilibrium() {
    let frame = Guccione::frame([1.0, 0.0, 0.0]);
    let bar = with_directions(Guccione.nearly_incompressible(100.0), cube(2), frame);
    let mut supports = pulled(20.0);
    supports.extend([roller("y_max", 1), roller("z_max", 2)]);
    let body = Scene { supports, ..bar }.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let line = Line::of_loads(&[2.0, 60.0, 20.0, 40.0]);
    let mut reached = 0.0;
    for point in solver.follow(&line, &Options::default()).unwrap().take(MOST) {
        match point {
            Ok(CurvePoint { place, solution, .. }) => {
                assert!(solution.displacement.iter().all(|u| u.is_finite()));
                assert!(solution.residual <= 1e-9 * solution.force_scale);
                reached = place;
            }
            Err(SolveError::CurveEnded { failure, .. }) => {
                assert!((failure.load_factor - reached).abs() < 1e-12 && reached > 0.0);
                assert!(!failure.to_string().contains("NaN"), "{failure}");
                return;
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(reached < 1.0, "nothing bears this");
}
