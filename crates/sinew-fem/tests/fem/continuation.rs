//! Curves of equilibria along lines in loads and parameters, against closed forms and other ways to the same equilibria.

use crate::shells::sphere_octant;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{CurvePoint, Line, Options, SolveError, Solver};
use sinew_mesh::box_tetrahedra;
use std::f64::consts::PI;

/// At the crown and along the plates: the arch sways to no side.
const SYMMETRY: [Option<f64>; 3] = [Some(0.0), None, None];
const BETWEEN: [Option<f64>; 3] = [None, Some(0.0), None];
/// Size that rounding leaves what is solved to 1e-10 of the forces.
const EXACT: f64 = 1e-7;
/// Shear modulus and Lamé's λ of the arch \[kPa\].
const ARCH: [f64; 2] = [75.0, 75.0];

/// Half of a shallow arch between two plates that bears its weight, clamped at one end, and held somehow at its crown.
fn arch(weight: f64, end: Support) -> Body {
    let mut mesh = box_tetrahedra([50.0, 4.0, 4.0], [8, 1, 1]).quadratic();
    mesh.map_points(|[x, y, z]| [x, y, z + 8.0 * (PI * x / 100.0).sin()]);
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, weight]))
        .support(Support::clamped("x_min"))
        .support(Support::uniform("y_min", BETWEEN))
        .support(Support::uniform("y_max", BETWEEN))
        .support(end);
    scene.lower().unwrap()
}

fn lowest(displacement: &[f64]) -> f64 {
    displacement.chunks(3).map(|u| u[2]).fold(0.0, f64::min)
}

fn followed(body: &Body, line: &Line, most: usize) -> Vec<CurvePoint> {
    let mut solver = Solver::new(body).unwrap();
    let points = solver.follow(line, &Options::default()).unwrap().take(most);
    let points: Vec<_> = points.collect::<Result<_, _>>().unwrap();
    for CurvePoint { place, length, solution, .. } in &points {
        let (negative, iterations) = (solution.negative_pivots, solution.iterations());
        println!("{place:.6} {length:.4}: {negative} negative pivots, {iterations} iterations");
        assert!(solution.residual <= 1e-10 * solution.force_scale, "{}", solution.residual);
    }
    points
}

/// Inner radii over the one at rest of a sphere of radii 1 and 2 of μ = 1 under a pressure (A. E. Green, W. Zerna, 1954).
fn pressure(a: f64) -> f64 {
    let b = ((7.0 + a.powi(3)) / 8.0).cbrt();
    2.0 / b + 0.5 / b.powi(4) - 2.0 / a - 0.5 / a.powi(4)
}

/// An octant of such a sphere, with the node at its pole.
fn sphere() -> (Scene, usize) {
    let mesh = sphere_octant([1.0, 2.0], [2, 3]).quadratic_tetrahedra();
    let pole = mesh.points.iter().position(|x| *x == [1.0, 0.0, 0.0]).unwrap();
    let mut scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .load(Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Fixed(1.0) });
    for (set, axis) in [("x_min", 0), ("y_min", 1), ("z_min", 2)] {
        let held = std::array::from_fn(|i| (i == axis).then_some(0.0));
        scene = scene.support(Support::uniform(set, held));
    }
    (scene, pole)
}

/// A softening material passes the same states as a rising load (`elements/incompressible.rs`), and the limit point is one of the stiffness.
#[test]
fn a_sphere_that_softens_under_its_pressure_turns_back_at_the_stiffness_of_its_limit_point() {
    let (scene, pole) = sphere();
    let body = scene.mixed().lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let line = Line::of_theta([&[2.0, 0.0], &[1.0, 0.0]]);
    let curve = solver.follow(&line, &Options::default()).unwrap().with_longest_step(0.3).unwrap();
    let mut softest = f64::INFINITY;
    for point in curve {
        let CurvePoint { solution, .. } = point.unwrap();
        let radius = 1.0 + solution.displacement[3 * pole];
        let stiffness = solution.theta[0];
        assert_eq!(solution.load_factor, 1.0);
        assert!((1.0 / stiffness - pressure(radius)).abs() < 0.01, "{radius}: {stiffness}");
        softest = stiffness.min(softest);
        if radius > 2.5 {
            assert!(stiffness > softest + 0.05);
            assert!((softest * 0.816423647955 - 1.0).abs() < 0.005, "{softest}");
            return;
        }
    }
    panic!("the curve ended before the sphere was wide");
}

#[test]
fn an_arch_snaps_through_along_states_that_are_not_stable() {
    let points =
        followed(&arch(-1e-2, Support::uniform("x_max", SYMMETRY)), &Line::of_loads(&ARCH), 40);
    let places: Vec<f64> = points.iter().map(|point| point.place).collect();
    let top = places.iter().take(6).copied().fold(0.0, f64::max);
    let falling = places.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(falling >= 1 && top < 0.9, "{places:?}");
    assert!(points.iter().any(|point| point.solution.negative_pivots > 0));
    let last = &points[points.len() - 1];
    assert!(last.place == 1.0 && last.solution.is_stable());
    // Load steps that minimise the energy snap to the same.
    let body = arch(-1e-2, Support::uniform("x_max", SYMMETRY));
    let snapped = Solver::new(&body).unwrap().solve(&ARCH, &Options::default()).unwrap();
    assert!((last.solution.energy / snapped.energy - 1.0).abs() < EXACT);
    assert!(points.iter().map(|p| p.solution.history.iterations.len()).sum::<usize>() < 120);
}

/// The limit point is found wherever the line ends, at a load of its size, a hundred or ten thousand times as much, and is where an
/// arch under a given load snaps.
#[test]
fn steps_suit_the_body_and_not_the_line() {
    let top = |weight: f64| {
        let body = arch(weight, Support::uniform("x_max", SYMMETRY));
        let mut solver = Solver::new(&body).unwrap();
        let line = Line::of_loads(&ARCH);
        let mut last = 0.0;
        let curve = solver.follow(&line, &Options::default()).unwrap();
        for point in curve.with_longest_step(0.2 * 8e-3 / weight.abs()).unwrap() {
            let place = point.unwrap().place;
            if place < last {
                return -weight * last;
            }
            last = place;
        }
        panic!("no limit point");
    };
    let tops = [1e-2, 1.0, 100.0].map(|weight| top(-weight));
    let far = Line { load_factors: [0.0, 1e6], ..Line::of_loads(&ARCH) };
    let body = arch(-1e-2, Support::uniform("x_max", SYMMETRY));
    let mut solver = Solver::new(&body).unwrap();
    let second = solver.follow(&far, &Options::default()).unwrap().nth(1).unwrap().unwrap();
    let load = second.solution.load_factor;
    assert!(load > 0.05 && load < 0.85, "{load}");
    println!("{tops:?}");
    assert!(tops.iter().all(|top| (top / tops[0] - 1.0).abs() < EXACT), "{tops:?}");
    let settled = |part: f64| {
        let body = arch(-part * tops[0], Support::uniform("x_max", SYMMETRY));
        lowest(&Solver::new(&body).unwrap().solve(&ARCH, &Options::default()).unwrap().displacement)
    };
    assert!(settled(0.99) > -5.0 && settled(1.01) < -11.0, "{} {}", settled(0.99), settled(1.01));
}

#[test]
fn prescribed_motions_are_followed_where_solves_at_once_lead_as_well() {
    let far = Support::along("x_max", [-0.8, 0.0, 0.6], 3.0);
    let body = arch(-1e-4, far);
    let points = followed(&body, &Line::of_loads(&ARCH), 40);
    let last = &points[points.len() - 1];
    assert_eq!(last.place, 1.0);
    let once = Solver::new(&body).unwrap().solve(&ARCH, &Options::default()).unwrap();
    let pairs = once.displacement.iter().zip(&last.solution.displacement);
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < EXACT, "{off}");
}

/// Continuation from a stable state under a load to another θ under another load.
#[test]
fn lines_start_at_any_load() {
    let body = arch(-1e-2, Support::uniform("x_max", SYMMETRY));
    let mut solver = Solver::new(&body).unwrap();
    let options = Options::default();
    let ends = [[75.0, 75.0], [90.0, 50.0]];
    let line = Line { load_factors: [0.4, 0.7], thetas: ends.map(Vec::from) };
    let points: Result<Vec<_>, _> = solver.follow(&line, &options).unwrap().collect();
    let points = points.unwrap();
    let [first, last] = [&points[0], &points[points.len() - 1]];
    assert_eq!([first, last].map(|point| point.solution.load_factor), [0.4, 0.7]);
    assert_eq!(last.solution.theta, ends[1]);
    assert!(points.windows(2).all(|pair| pair[0].place < pair[1].place));
}

/// Half of the loads are the whole of half as large ones, for whatever reads a solution on the way.
#[test]
fn solutions_on_the_way_know_their_load() {
    let mesh = sphere_octant([1.0, 2.0], [2, 3]);
    let (scene, _) = sphere();
    let mut scene = Scene::new(mesh.tetrahedra(), NeoHookean)
        .parameter(scene.parameters[0].clone())
        .parameter(scene.parameters[1].clone())
        .parameter(Parameter::linear("p", "kPa", 0.0..=1.0))
        .load(Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Theta(2) });
    for (set, axis) in [("x_min", 0), ("y_min", 1), ("z_min", 2)] {
        let held = std::array::from_fn(|i| (i == axis).then_some(0.0));
        scene = scene.support(Support::uniform(set, held));
    }
    let body = scene.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let line = Line::of_loads(&[1.0, 2.0, 0.3]);
    let half = solver.follow(&line, &Options::default()).unwrap().nth(1).unwrap().unwrap();
    let part = half.solution.load_factor;
    assert!(part > 0.0 && part < 1.0 && half.place == part);
    let whole = solver.solve(&[1.0, 2.0, 0.3 * part], &Options::default()).unwrap();
    let close = |a: f64, b: f64| (a - b).abs() < EXACT * b.abs().max(1e-3);
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(&a, &b)| close(a, b));
    assert!(apart(&half.solution.displacement, &whole.displacement));
    let [of_half, of_whole] = [&half.solution, &whole].map(|s| solver.sensitivity(s).unwrap());
    assert!(apart(&of_half[0], &of_whole[0]));
    let scaled: Vec<f64> = of_whole[2].iter().map(|u| part * u).collect();
    assert!(apart(&of_half[2], &scaled));
    let slope: Vec<f64> = (0..whole.displacement.len()).map(|i| (i as f64).sin()).collect();
    let [by_half, by_whole] =
        [&half.solution, &whole].map(|s| solver.adjoint_sensitivity(s, &slope).unwrap());
    assert!(close(by_half[1], by_whole[1]) && close(by_half[2], part * by_whole[2]));
}

#[test]
fn loose_pressures_in_theta_are_followed() {
    let mesh = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
    let body = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .parameter(Parameter::linear("p", "kPa", 0.0..=1.0))
        .load(Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) })
        .support(Support::clamped("x_min"))
        .loose_rims()
        .lower()
        .unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let options = Options::default();
    // More pressure under the whole load, from less of it.
    let ends = [[1.0, 1.0, 0.004], [1.5, 1.0, 0.012]];
    let line = Line::of_theta([&ends[0], &ends[1]]);
    let last = solver.follow(&line, &options).unwrap().map(Result::unwrap).last().unwrap();
    assert_eq!((last.place, &last.solution.theta[..]), (1.0, &ends[1][..]));
    let once = solver.solve(&ends[1], &options).unwrap();
    let pairs = once.displacement.iter().zip(&last.solution.displacement);
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < EXACT);
    assert!(solver.follow(&Line::of_loads(&[1.0, 1.0]), &options).is_err());
}

#[test]
fn lines_that_are_none_are_refused_and_ends_are_told() {
    let body = arch(-1e-2, Support::uniform("x_max", SYMMETRY));
    let mut solver = Solver::new(&body).unwrap();
    let options = Options::default();
    let refused = |solver: &mut Solver<'_>, line: &Line| match solver.follow(line, &options) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{line:?} is followed"),
    };
    let same = Line::of_theta([&ARCH, &ARCH]);
    assert!(refused(&mut solver, &same).contains("its ends are the same"));
    let far = Line { load_factors: [0.0, f64::NAN], ..Line::of_loads(&ARCH) };
    assert!(refused(&mut solver, &far).contains("not finite"));
    refused(&mut solver, &Line::of_loads(&[75.0]));
    refused(&mut solver, &Line::of_theta([&ARCH, &[-1.0, 75.0]]));

    // Too few iterations: an error with the last equilibrium, and nothing after it.
    let few = Options { iterations: 5, ..options };
    let mut curve = solver.follow(&Line::of_loads(&ARCH), &few).unwrap();
    let failure = loop {
        if let Err(failure) = curve.next().expect("an end with an error") {
            break failure;
        }
    };
    assert!(matches!(failure, SolveError::CurveEnded { .. }) && curve.next().is_none());
    assert!(failure.to_string().contains("followed to place"), "{failure}");
    for longest in [0.0, -1.0, f64::NAN] {
        let curve = solver.follow(&Line::of_loads(&ARCH), &options).unwrap();
        assert!(curve.with_longest_step(longest).is_err());
    }
    assert!(!failure.to_string().contains("NaN"), "{failure}");
}

/// A column at its Euler load, where arc length passes the whole load along the straight states.
#[test]
fn steps_that_passed_the_end_of_their_line_go_back_to_it() {
    let body = Scene::new(box_tetrahedra([100.0, 5.0, 5.0], [8, 1, 1]).quadratic(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 100.0..=300.0))
        .parameter(Parameter::log("lambda", "kPa", 10.0..=100.0))
        .load(Load::Traction { facets: "x_max".into(), value: [-0.3, 0.0, 0.0] })
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let straight = solver.solve(&[270.0, 50.0], &Options::default()).unwrap();
    let few = Options { iterations: 40, ..Options::default() };
    let history = match solver.solve_near(&straight, &[269.9, 50.0], &few) {
        Err(SolveError::NotConverged(failure)) => failure.history,
        found => found.unwrap().history,
    };
    let loads: Vec<f64> = history.iterations.iter().map(|it| it.load_factor).collect();
    let passed = loads.iter().position(|load| *load > 1.0).expect("arc length passes the end");
    assert!(loads.iter().any(|load| *load > 1.1), "{loads:?}");
    let last = loads[passed..].iter().rposition(|load| *load > 1.1).unwrap_or(0);
    assert!(loads[passed + last] < 1.15, "{loads:?}");
}
