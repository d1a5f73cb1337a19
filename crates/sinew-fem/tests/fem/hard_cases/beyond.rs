//! Loads beyond what a body bears, and bodies that bear them in more than one way.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use crate::support::ventricle;
use crate::ventricles::ventricles;
use sinew_energy::laws::{HolzapfelOgden, NeoHookean};
use sinew_energy::{
    Body, IntoMaterial, Law, Load, Magnitude, Parameter, Prescribed, Scene, Support,
};
use sinew_fem::fibres::{FibreRule, Surfaces, VentricleCoordinates};
use sinew_fem::{
    Advice, CurvePoint, Line, LoadSteps, NotConverged, Options, Solution, SolveError, Solver, Stop,
    sweep,
};
use sinew_mesh::{TetMesh, TruncatedEllipsoid, box_tetrahedra};

/// States that are assembled at most until a load is refused that the body does not bear.
const MOST: usize = 60;
/// Ten millimetres of mercury \[kPa\].
const TEN_MMHG: f64 = 1.33322;

/// The wall of the built-in scene IdealVentricle, coarser.
fn ventricle() -> TetMesh {
    let shape = TruncatedEllipsoid { short: [22.0, 36.0], long: [58.0, 74.0], base: 0.0 };
    shape.wall([2, 16, 8]).tetrahedra()
}

fn scene_of(material: impl IntoMaterial, names: &[(&str, [f64; 2])]) -> Scene {
    let scene = Scene::new(ventricle(), material)
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(names.len()) })
        .support(Support::clamped("base"));
    let named = names.iter().fold(scene, |scene, (name, range)| {
        scene.parameter(Parameter::log(*name, "kPa", range[0]..=range[1]))
    });
    named.parameter(Parameter::log("p", "kPa", 0.5..=1.5))
}

/// Ventricle with the law of IdealVentricle, with fibres by rule, at the middle of its parameters and a pressure.
fn fibrous() -> Body {
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let wall = VentricleCoordinates::new(&ventricle(), &surfaces).unwrap();
    let frames = wall.cell_frames(&FibreRule::SIXTY);
    let names = [("a", [0.1, 0.26]), ("b", [1.0, 4.2]), ("a_f", [1.5, 5.18]), ("b_f", [1.0, 4.46])];
    let fibres = frames.iter().map(|[fibre, ..]| [*fibre]).collect();
    let law = HolzapfelOgden.nearly_incompressible(25.0);
    scene_of(law.along(fibres), &names).lower().unwrap()
}

fn rubber() -> Body {
    scene_of(NeoHookean, &[("mu", [8.0, 10.0]), ("lambda", [8.0, 10.0])]).lower().unwrap()
}

/// Refused in few iterations, with a part of the load that holds and another advice than more iterations.
#[track_caller]
fn refused(body: &Body, theta: &[f64]) -> NotConverged {
    let failure = failure(solve(body, theta));
    let states = failure.history.iterations.len();
    println!("{states} states: {}", failure.advice);
    assert!(states <= MOST, "{states}");
    assert!(failure.load_factor > 0.0, "{}", failure.load_factor);
    let known = matches!(failure.advice, Advice::LimitPoint { .. } | Advice::FarBeyond { .. });
    assert!(known, "{}", failure.advice);
    // What is said to hold does, as the same load alone.
    let mut smaller = theta.to_vec();
    *smaller.last_mut().unwrap() *= failure.load_factor;
    let mut solver = Solver::new(body).unwrap();
    let holds = solver.solve_from(&failure.displacement, &smaller, &Options::default()).unwrap();
    assert!(holds.iterations() <= 2, "{}", holds.history);
    let size = norm(&holds.displacement);
    assert!(difference(&holds.displacement, &failure.displacement) < 1e-6 * size);
    failure
}

#[test]
fn a_pressure_a_million_times_too_large_is_refused_on_a_ventricle() {
    for theta in [[0.1, 1.0, 1.5, 1.0, TEN_MMHG], [0.16, 2.0, 2.8, 2.1, TEN_MMHG]] {
        let body = fibrous();
        solve(&body, &theta).unwrap();
        let mut theta = theta;
        theta[4] *= 1e6;
        refused(&body, &theta);
    }
    refused(&rubber(), &[9.0, 9.0, 1e6 * TEN_MMHG]);
}

/// Half a ball of averaged tetrahedra that slides on its rim: load steps alone took 113 to 163 iterations.
#[test]
fn a_thin_ball_beyond_its_limit_pressure_is_refused_with_the_pressure_that_it_bears() {
    let shape = TruncatedEllipsoid { short: [20.0, 21.0], long: [20.0, 21.0], base: 0.0 };
    let body = Scene::new(shape.wall([1, 24, 12]).tetrahedra(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 5.0..=10.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
        .support(Support::radial("base", [0.0; 3], [0.0, 0.0, 1.0]))
        .parameter(Parameter::log("p", "kPa", 0.5..=1.5))
        .averaged()
        .lower()
        .unwrap();
    // The pressure of an incompressible thin ball is largest at a stretch of 7^(1/6): 2 μ h / R (λ⁻¹ − λ⁻⁷).
    let stretch = 7f64.powf(1.0 / 6.0);
    let thin = 2.0 * 6.9 / 20.5 * (stretch.recip() - stretch.powi(-7));
    for pressure in [0.6, 0.8, 1.5, 3.0, 10.0] {
        let failure = refused(&body, &[6.9, 62.0, pressure]);
        let borne = failure.load_factor * pressure;
        println!("{borne} kPa, thin and incompressible {thin} kPa");
        assert!((borne / thin - 1.0).abs() < 0.15, "{borne}");
        assert!(matches!(failure.advice, Advice::LimitPoint { .. }));
    }
}

#[test]
fn a_ventricle_beyond_its_limit_pressure_is_refused_with_the_pressure_that_it_bears() {
    let body = rubber();
    // The largest pressure on the curve of equilibria.
    let mut solver = Solver::new(&body).unwrap();
    let line = Line::of_loads(&[9.0, 9.0, 4.0 * TEN_MMHG]);
    let mut largest: f64 = 0.0;
    for point in solver.follow(&line, &Options::default()).unwrap() {
        let CurvePoint { place, .. } = point.unwrap();
        if place < largest {
            break;
        }
        largest = place;
    }
    assert!(largest > 0.5 && largest < 1.0, "{largest}");
    for times in [1.25, 2.0, 5.0, 50.0] {
        let pressure = 4.0 * TEN_MMHG * times;
        let failure = refused(&body, &[9.0, 9.0, pressure]);
        let borne = failure.load_factor * times / largest;
        println!("{times}: {borne}");
        assert!(borne > 0.9 && borne < 1.02, "{borne}");
        let Advice::LimitPoint { limit, refused } = failure.advice else {
            panic!("{}", failure.advice)
        };
        assert!((limit * times / largest - 1.0).abs() < 0.1 && refused > limit);
        assert!(failure.to_string().contains("what the body bears"));
    }
    solve(&body, &[9.0, 9.0, 0.9 * 4.0 * TEN_MMHG * largest]).unwrap();
}

/// A column that is pushed along its axis and a little across.
fn column(push: f64, across: f64) -> Body {
    Scene::new(box_tetrahedra([20.0, 1.0, 1.0], [20, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .load(traction("x_max", [-push, 0.0, across * push]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

/// Stiffness all but vanishes where a column buckles, and yet it bears more.
#[test]
fn a_column_that_buckles_bears_more_than_where_it_softens() {
    for push in [0.0025, 0.0125, 0.0175, 0.025] {
        for across in [1e-4, 1e-3] {
            let body = column(push, across);
            let solution = solve(&body, &[1.0, 1.0]).unwrap();
            assert_sound(&body, &solution);
        }
    }
}

/// Largest displacement across.
fn sway(solution: &Solution) -> f64 {
    let across = solution.displacement.chunks(3).map(|u| u[2]);
    across.fold(0.0, |most: f64, u| if u.abs() > most.abs() { u } else { most })
}

#[test]
fn of_several_stable_equilibria_a_rising_load_finds_the_one_that_it_leads_to() {
    let rising = Options { load_steps: LoadSteps::Always, ..Options::default() };
    for (push, across) in [(0.0025, 1e-3), (0.0075, 1e-3), (0.0075, 1e-4), (0.0025, -1e-3)] {
        let body = column(push, across);
        let mut solver = Solver::new(&body).unwrap();
        let at_once = solver.solve(&[1.0, 1.0], &Options::default()).unwrap();
        let risen = solver.solve(&[1.0, 1.0], &rising).unwrap();
        assert_sound(&body, &risen);
        assert!(risen.load_steps > 2);
        let other = solver.under_rising_load(&at_once, &Options::default(), &mut |_| ()).unwrap();
        let differ = difference(&at_once.displacement, &risen.displacement) > 1e-3;
        println!("{push} {across}: {} and {}", sway(&at_once), sway(&risen));
        assert_eq!(other.is_some(), differ);
        // The evidence that costs nothing.
        assert!(at_once.jumped || !differ);
    }
    // Bowed to the other side it bears the same load, and no rising load leads there.
    let there = solve(&column(0.0075, -1e-4), &[1.0, 1.0]);
    let body = column(0.0075, 1e-4);
    let mut solver = Solver::new(&body).unwrap();
    let [here, there] = [
        solver.solve(&[1.0, 1.0], &rising),
        solver.solve_from(&there.unwrap().displacement, &[1.0, 1.0], &Options::default()),
    ]
    .map(Result::unwrap);
    assert_sound(&body, &there);
    assert!(here.is_stable() && there.is_stable());
    assert!(sway(&here) > 10.0 && sway(&there) < -10.0, "{} {}", sway(&here), sway(&there));
    let risen =
        solver.under_rising_load(&there, &Options::default(), &mut |_| ()).unwrap().unwrap();
    assert!(difference(&risen.displacement, &here.displacement) < 1e-6 * norm(&here.displacement));
    assert!(solver.under_rising_load(&here, &Options::default(), &mut |_| ()).unwrap().is_none());
}

/// Load steps lead there in more than 20 states.
#[test]
fn a_smooth_curve_is_compared_by_a_few_of_its_points() {
    let body = ventricle::scene(ventricles().remove(0).1, 25.0).lower().unwrap();
    let (mut solver, options, mut states) = (Solver::new(&body).unwrap(), Options::default(), 0);
    let found = solver.solve(&[0.17, 2.4, 3.0, 2.5, 0.9], &options).unwrap();
    assert!(found.jumped, "the search meets indefinite stiffnesses");
    let other = solver.under_rising_load(&found, &options, &mut |_| states += 1).unwrap();
    assert!(other.is_none() && states <= 10, "{states}");
}

#[test]
fn a_sweep_marks_the_samples_that_left_the_branch_of_their_neighbour() {
    let body = column(0.005, 1e-3);
    let thetas: Vec<_> = [4.0, 3.0, 2.0, 1.0].map(|mu| vec![mu, mu]).to_vec();
    let swept = sweep(&body, &thetas, &Options::default(), || ()).unwrap();
    let jumped = |result: &Result<Solution, SolveError>| result.as_ref().unwrap().jumped;
    // The softest column buckles.
    assert_eq!(swept.iter().map(jumped).collect::<Vec<_>>(), [false, false, false, true]);
    let stiff = sweep(&body, &[vec![4.0, 4.0], vec![3.5, 3.5]], &Options::default(), || ());
    assert!(!stiff.unwrap().iter().any(jumped));
}

/// A bar whose end is turned about its axis.
fn twisted(degrees: f64) -> Body {
    let mesh = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
    let (sin, cos) = f64::to_radians(degrees).sin_cos();
    let turned = |&node: &usize| {
        let [y, z] = [mesh.points[node][1] - 0.5, mesh.points[node][2] - 0.5];
        [0.0, cos * y - sin * z - y, sin * y + cos * z - z].map(Some)
    };
    let rows = mesh.node_sets["x_max"].iter().map(turned).collect();
    Scene::new(mesh.clone(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .support(Support::clamped("x_min"))
        .support(Support { nodes: "x_max".into(), displacement: Prescribed::PerNode(rows) })
        .lower()
        .unwrap()
}

#[test]
fn half_a_turn_along_a_straight_way_is_named_and_works_in_two_parts() {
    let failure = failure(solve(&twisted(180.0), &[1.0, 1.0]));
    let Advice::Turned { degrees } = failure.advice else { panic!("{}", failure.advice) };
    assert!((degrees - 180.0).abs() < 1e-6);
    assert!(failure.to_string().contains("90 degrees"));
    let first = solve(&twisted(90.0), &[1.0, 1.0]).unwrap();
    let body = twisted(180.0);
    let mut solver = Solver::new(&body).unwrap();
    let whole = solver.solve_from(&first.displacement, &[1.0, 1.0], &Options::default()).unwrap();
    assert_sound(&body, &whole);
    // Other failures are none of a turn.
    let far = failure_of_a_block();
    assert!(!matches!(far.advice, Advice::Turned { .. }), "{}", far.advice);
}

fn failure_of_a_block() -> NotConverged {
    failure(solve(&rubber(), &[9.0, 9.0, 10.0 * TEN_MMHG]))
}

#[test]
fn a_displacement_and_theta_that_are_swapped_are_called_that() {
    let body = column(0.001, 0.0);
    let mut solver = Solver::new(&body).unwrap();
    let (rest, theta, options) = (vec![0.0; body.prescribed.len()], [1.0, 1.0], Options::default());
    let held = solver.frozen_stiffness(&rest, &theta).unwrap();
    let errors = [
        solver.solve_from(&theta, &rest, &options).unwrap_err(),
        solver.newton_steps(&theta, &rest, 1).unwrap_err(),
        solver.frozen_stiffness(&theta, &rest).err().unwrap(),
        held.refine(&body, &theta, &rest, Stop::after(3)).unwrap_err(),
    ];
    for error in errors {
        assert!(matches!(error, SolveError::Swapped { parameters: 2, .. }), "{error}");
        assert!(error.to_string().contains("look swapped"), "{error}");
    }
}
