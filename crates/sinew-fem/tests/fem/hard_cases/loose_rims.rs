//! Pressures on surfaces with a free rim, which no potential gives: the balance of forces in hard places.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{Guccione, HolzapfelOgden, NeoHookean};
use sinew_energy::{Body, Load, Magnitude, Scene, Support, ThetaError};
use sinew_fem::{NotConverged, Options, Solution, SolveError, Solver, sweep};
use sinew_mesh::{TetMesh, box_tetrahedra, quality};

const THETA: [f64; 2] = [1.0, 1.0];

/// A cantilever of length 4 pressed from above, where the rim of the pressed side is free.
fn pressed(pressure: f64) -> Scene {
    pressed_on(mesh(), pressure)
}

fn pressed_on(mesh: TetMesh, pressure: f64) -> Scene {
    let magnitude = Magnitude::Fixed(pressure);
    let loads = vec![Load::Pressure { facets: "z_max".into(), magnitude }];
    Scene { loads, ..scene(NeoHookean, mesh) }
}

fn mesh() -> TetMesh {
    box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2])
}

fn solved(body: &Body, theta: &[f64], options: &Options) -> Result<Solution, SolveError> {
    let result = Solver::new(body)?.solve(theta, options);
    if let Ok(solution) = &result {
        println!(
            "{} iterations, {} load steps, residual {:.1e} of {:.1e}, {:.1} ms",
            solution.history.iterations.len(),
            solution.load_steps,
            solution.residual,
            solution.force_scale,
            1e3 * solution.seconds
        );
        assert!(solution.displacement.iter().all(|u| u.is_finite()));
        assert!(solution.least_volume_ratio > 0.0);
        assert!(solution.residual <= 1e-7 * solution.force_scale);
    }
    result
}

#[track_caller]
fn not_converged(result: Result<Solution, SolveError>) -> NotConverged {
    match result {
        Err(SolveError::NotConverged(failure)) => {
            println!("{failure}");
            assert!(failure.displacement.iter().all(|u| u.is_finite()));
            assert!(!failure.to_string().contains("NaN"));
            *failure
        }
        Err(other) => panic!("expected no convergence, got {other}"),
        Ok(_) => panic!("expected no convergence"),
    }
}

#[test]
fn a_vanishing_pressure_on_a_free_rim_is_a_dead_traction() {
    let body = pressed(1e-7).loose_rims().lower().unwrap();
    let follower = solved(&body, &THETA, &Options::default()).unwrap();
    let loads = vec![traction("z_max", [0.0, 0.0, -1e-7])];
    let dead = Scene { loads, ..scene(NeoHookean, mesh()) }.lower().unwrap();
    let dead = solve(&dead, &THETA).unwrap();
    // The direction of the load changes by the slope, about 1e-5.
    assert!(difference(&follower.displacement, &dead.displacement) < 1e-4);
}

#[test]
fn a_large_pressure_on_a_free_rim_balances_forces_and_moments() {
    let pressure = 0.02;
    let scene = pressed(pressure).loose_rims();
    let body = scene.lower().unwrap();
    let solution = solved(&body, &THETA, &Options::default()).unwrap();
    let x = |node: usize| -> [f64; 3] {
        std::array::from_fn(|i| scene.mesh.points()[node][i] + solution.displacement[3 * node + i])
    };
    let (internal, _) = gradient_and_energy(&body, &solution.displacement, &THETA);
    let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let minus = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| a[i] - b[i]) };
    // Force and moment of the pressure on the deformed facets, node by node where nothing holds, and what
    // holds the other nodes.
    let (mut force, mut moment, mut load) = ([0.0; 3], [0.0; 3], 0.0);
    let mut add = |node: usize, f: [f64; 3]| {
        let m = cross(x(node), f);
        (0..3).for_each(|i| [force[i], moment[i]] = [force[i] + f[i], moment[i] + m[i]]);
    };
    let mesh = mesh();
    let held = &mesh.node_sets["x_min"];
    for &facet in &mesh.facet_sets["z_max"] {
        let nodes = mesh.facet_nodes(facet);
        let [a, b, c] = nodes.map(x);
        let third = cross(minus(b, a), minus(c, a)).map(|n| -pressure * n / 6.0);
        load += 3.0 * norm(&third);
        nodes.into_iter().filter(|node| !held.contains(node)).for_each(|node| add(node, third));
    }
    held.iter().for_each(|&node| add(node, std::array::from_fn(|i| internal[3 * node + i])));
    println!("{force:?} and {moment:?} of {load}");
    assert!(load > 0.05 && norm(&force) < 1e-7 * load && norm(&moment) < 1e-6 * load);
    let tip = mesh.node_sets["x_max"][0];
    assert!(solution.displacement[3 * tip + 2] < -0.5, "the load has turned");
}

#[test]
fn a_held_rim_gives_the_same_by_balance_and_by_potential() {
    let mut scene = pressed(0.3);
    scene.supports = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    let balance =
        solved(&scene.clone().loose_rims().lower().unwrap(), &THETA, &Options::default()).unwrap();
    let potential = scene.lower().unwrap();
    let minimum = solve(&potential, &THETA).unwrap();
    assert_sound(&potential, &minimum);
    assert!(difference(&balance.displacement, &minimum.displacement) < 1e-8);
}

#[test]
fn a_pressure_a_million_times_too_large_is_refused_with_the_largest_that_holds() {
    // With a free rim, and with a held one, where a potential is minimised.
    let held = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    for (supports, bearable) in [(vec![Support::clamped("x_min")], 0.02), (held, 0.3)] {
        let body = |pressure: f64| {
            Scene { supports: supports.clone(), ..pressed(pressure) }.loose_rims().lower().unwrap()
        };
        let start = std::time::Instant::now();
        let failure = not_converged(solved(&body(1e6 * bearable), &THETA, &Options::default()));
        println!("{:?}", start.elapsed());
        assert!(failure.load_factor > 1e-6 && failure.load_factor < 1e-2);
        assert!(!failure.to_string().contains("is 0.0000"), "{failure}");
        // Unoptimised builds with checks take longer than the seconds of a user.
        assert!(failure.history.iterations.len() <= 60, "{}", failure.history.iterations.len());
        // What is said to hold does.
        let smaller = body(failure.load_factor * 1e6 * bearable);
        let found = solved(&smaller, &THETA, &Options::default()).unwrap();
        assert!(difference(&found.displacement, &failure.displacement) < 1e-6);
    }
}

/// Both beams of the thesis that a pressure on their loose lower side rolls up, over the whole ranges of their parameters.
#[test]
fn beams_that_roll_up_under_a_loose_pressure_take_few_iterations_all_over_their_ranges() {
    let mesh = || box_tetrahedra([100.0, 10.0, 10.0], [10, 3, 3]);
    let loads =
        || vec![Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.15) }];
    let (ho, guccione) =
        (HolzapfelOgden.nearly_incompressible(25.0), Guccione.nearly_incompressible(25.0));
    let ho = with_directions(ho, mesh(), [[1.0, 0.0, 0.0]]);
    let guccione = with_directions(guccione, mesh(), Guccione::frame([1.0, 0.0, 0.0]));
    let bodies = [
        (Scene { loads: loads(), ..ho }.loose_rims().lower().unwrap(), [0.75, 2.5]),
        (Scene { loads: loads(), ..guccione }.loose_rims().lower().unwrap(), [1.75, 3.5]),
    ];
    for (body, [low, high]) in bodies {
        // Steps of a low-discrepancy sequence (M. Roberts), and the softest corner.
        let steps = [0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101];
        let point = |k: u32| steps.map(|s| low + (high - low) * (0.5 + s * f64::from(k)).fract());
        let mut iterations = Vec::new();
        for theta in (1..=8).map(point).chain([[low; 4]]) {
            let solution = solved(&body, &theta, &Options::default()).unwrap();
            iterations.push(solution.iterations());
        }
        iterations.sort_unstable();
        println!("{iterations:?}");
        assert!(iterations[iterations.len() / 2] <= 40, "{iterations:?}");
    }
}

#[test]
fn a_balance_goes_on_from_a_solution_nearby_and_knows_where_to() {
    let mut scene = pressed(0.0);
    scene.parameters = parameters(&["mu", "lambda", "p"]);
    scene.loads = vec![Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) }];
    let body = scene.loose_rims().lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let (theta, near) = ([1.0, 1.2, 0.012], [1.0 + 1e-4, 1.2, 0.012]);
    let solution = solver.solve(&theta, &Options::default()).unwrap();
    let cold = solver.solve(&near, &Options::default()).unwrap();
    let warm = solver.solve_near(&solution, &near, &Options::default()).unwrap();
    assert!(difference(&warm.displacement, &cold.displacement) < 1e-8);
    assert!(warm.iterations() <= 4 && warm.iterations() < cold.iterations());
    let slopes = solver.sensitivity(&solution).unwrap();
    for (entry, slope) in slopes.iter().enumerate() {
        let step = 1e-4 * theta[entry];
        let at = |by: f64| {
            let mut theta = theta;
            theta[entry] += by;
            Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap()
        };
        let (up, down) = (at(step).displacement, at(-step).displacement);
        let quotient: Vec<_> = up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        // Central differences are off by the square of the step, 1e-8, and by what the solves leave over it.
        assert!(difference(slope, &quotient) < 1e-5, "entry {entry}");
    }
}

#[test]
fn a_balance_without_unknowns_is_what_is_prescribed() {
    let mut scene = pressed(0.3);
    let all = (0..scene.mesh.points().len()).collect();
    scene.mesh.node_sets_mut().insert("all".into(), all);
    scene.supports = vec![Support::clamped("all")];
    let body = scene.loose_rims().lower().unwrap();
    let solution = solved(&body, &THETA, &Options::default()).unwrap();
    assert!(solution.displacement.iter().all(|&u| u == 0.0));
}

#[test]
fn a_balance_without_loads_is_rest() {
    let body = pressed(0.0).loose_rims().lower().unwrap();
    let solution = solved(&body, &THETA, &Options::default()).unwrap();
    assert!(solution.displacement.iter().all(|&u| u == 0.0));
}

#[test]
fn theta_that_makes_no_sense_is_refused_by_the_balance_too() {
    let body = pressed(0.1).loose_rims().lower().unwrap();
    for theta in [&[f64::NAN, 1.0][..], &[1.0, -1.0], &[1.0], &[1.0, f64::INFINITY]] {
        let error = solved(&body, theta, &Options::default()).unwrap_err();
        assert!(matches!(error, SolveError::Theta(_)), "{error}");
    }
    let mut scene = pressed(0.1);
    scene.parameters = parameters(&["mu", "lambda", "p"]);
    scene.loads = vec![Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) }];
    let body = scene.loose_rims().lower().unwrap();
    let error = solved(&body, &THETA, &Options::default()).unwrap_err();
    let expected = ThetaError::Length { given: 2, needed: 3, names: vec!["mu", "lambda"] };
    assert_eq!(error, SolveError::Theta(expected));
    let error = solved(&body, &[1.0, 1.0, f64::NAN], &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::Theta(ThetaError::OutOfBounds { index: 2, .. })));
}

#[test]
fn limits_on_iterations_are_kept_by_the_balance_too() {
    let body = pressed(0.02).loose_rims().lower().unwrap();
    for iterations in [0, 1, 3] {
        let options = Options { iterations, ..Options::default() };
        let failure = not_converged(solved(&body, &THETA, &options));
        assert_eq!(failure.history.iterations.len(), iterations);
    }
}

#[test]
fn a_free_body_is_refused_by_the_balance_too() {
    let mut scene = pressed(0.1);
    scene.mesh.node_sets_mut().insert("corner".into(), vec![0]);
    scene.supports = vec![Support::clamped("corner")];
    let body = scene.loose_rims().lower().unwrap();
    let error = Solver::new(&body).map(|_| ()).unwrap_err();
    // Held at a corner it turns about it.
    assert!(matches!(error, SolveError::FreeToMove { modes, .. } if modes.len() == 3));
}

#[test]
fn fibres_near_overflow_under_a_loose_pressure_are_solved_or_refused() {
    let law = HolzapfelOgden.nearly_incompressible(100.0);
    let loads = vec![Load::Pressure { facets: "x_max".into(), magnitude: Magnitude::Fixed(-30.0) }];
    let scene = Scene { loads, ..with_directions(law, mesh(), [[1.0, 0.0, 0.0]]) };
    let body = scene.loose_rims().lower().unwrap();
    for b_f in [1.0, 1e2, 1e4] {
        match solved(&body, &[1.0, 1.0, 1.0, b_f], &Options::default()) {
            Ok(solution) => assert!(solution.displacement[3 * 8] > 0.0),
            other => drop(not_converged(other)),
        }
    }
}

#[test]
fn slivers_under_a_loose_pressure_are_solved_as_if_they_were_not_there() {
    // A node inside is moved to within a hair of the pressed side: flat cells below its facets.
    let solved_with = |gap: f64| {
        let mut mesh = mesh();
        let node = mesh.points.iter().position(|&p| p == [2.0, 0.5, 0.5]).unwrap();
        mesh.points[node] = [2.0, 0.5, 1.0 - gap];
        let least = quality(&mesh).unwrap().ratio.min;
        assert!(least > 0.0 && least < 10.0 * gap, "{least:e}");
        let body = pressed_on(mesh, 0.02).loose_rims().lower().unwrap();
        solved(&body, &THETA, &Options::default()).unwrap()
    };
    let (thin, thinner) = (solved_with(1e-6), solved_with(1e-8));
    let tip = 3 * mesh().node_sets["x_max"][0] + 2;
    assert!(thin.displacement[tip] < -0.5, "the load has turned");
    // In the limit the node lies on the side; it is off by the gap.
    let apart = difference(&thin.displacement, &thinner.displacement);
    assert!(apart > 0.0 && apart < 1e-5, "{apart:e}");
}

#[test]
fn a_sweep_of_loose_followers_finds_what_cold_solves_find_in_fewer_iterations() {
    let body = pressed(0.05).loose_rims().lower().unwrap();
    let thetas: Vec<Vec<f64>> =
        (0..12).map(|k| vec![1.0 + 0.05 * f64::from(k), 1.5 - 0.04 * f64::from(k)]).collect();
    let options = Options::default();
    let swept = sweep(&body, &thetas, &options, || {}).unwrap();
    let (mut cold, mut warm) = (0, 0);
    for (found, theta) in swept.into_iter().map(Result::unwrap).zip(&thetas) {
        let alone = solved(&body, theta, &options).unwrap();
        cold += alone.iterations();
        warm += found.iterations();
        // Both end 1e-10 of the forces from balance; bending amplifies that.
        assert!(difference(&found.displacement, &alone.displacement) < 1e-7);
    }
    assert!(warm < cold, "{warm} iterations for {cold}");
}

/// One pressure has a potential, the other none: both keep their own entry of θ when others are known.
#[test]
fn known_parameters_leave_every_pressure_its_own() {
    let mut scene = pressed(0.0);
    scene.parameters = parameters(&["mu", "lambda", "p", "q"]);
    let pressure = |facets: &str, index| {
        let magnitude = Magnitude::Theta(index);
        Load::Pressure { facets: facets.into(), magnitude }
    };
    scene.loads = vec![pressure("z_max", 2), pressure("x_min", 3)];
    let whole = scene.loose_rims().lower().unwrap();
    assert_eq!((whole.followers.len(), whole.pressures.len()), (1, 1));
    let expected = solved(&whole, &[1.0, 1.2, 0.012, 0.5], &Options::default()).unwrap();
    for (known, theta) in [
        (&[("mu", 1.0)][..], &[1.2, 0.012, 0.5][..]),
        (&[("p", 0.012)], &[1.0, 1.2, 0.5]),
        (&[("q", 0.5), ("lambda", 1.2)], &[1.0, 0.012]),
    ] {
        let body = whole.clone().with_known(known).unwrap();
        let found = solved(&body, theta, &Options::default()).unwrap();
        assert_eq!(found.displacement, expected.displacement, "{known:?}: bit for bit");
    }
}
