//! Bodies that are hard to solve, and problems that have no solution.

mod support;

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Support, TotalPotential};
use sinew_fem::{Advice, NotConverged, Options, Solution, SolveError, Solver, Stiffness};
use sinew_mesh::{TetMesh, box_tetrahedra};
use support::{gravity, lower, once, twice};

type Body = TotalPotential<NeoHookean, 0>;

fn solve(potential: &Body, theta: [f64; 2]) -> Result<Solution, SolveError> {
    let solution = Solver::new(potential)?.solve(&theta, &Options::default())?;
    println!(
        "{} iterations, {} load steps, min J {:.3}, {:.1} ms",
        solution.history.iterations.len(),
        solution.load_steps,
        solution.least_volume_ratio,
        1e3 * solution.seconds
    );
    Ok(solution)
}

/// An equilibrium: balanced to rounding, admissible, stable.
fn assert_sound(solution: &Solution) {
    let last = solution.history.iterations.last().unwrap();
    assert!(
        solution.residual <= last.tolerance.max(1e-9 * solution.force_scale),
        "{}",
        solution.history
    );
    assert!(solution.least_volume_ratio > 0.0);
    assert!(solution.is_stable());
}

#[test]
fn nearly_incompressible() {
    let solution = solve(&once(), [75.0, 7.5e5]).unwrap();
    assert_sound(&solution);
}

#[test]
fn soft_material_under_five_times_its_weight() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let beam = lower(NeoHookean, mesh, gravity(5.0), vec![Support::clamped("x_min")]);
    assert_sound(&solve(&beam, [50.0, 50.0]).unwrap());
}

#[test]
fn slender_beam_of_soft_material() {
    assert_sound(&solve(&twice(), [5.0, 5.0]).unwrap());
}

#[test]
fn slivers() {
    let mut mesh = box_tetrahedra([10.0, 10.0, 10.0], [4, 4, 4]);
    // Squeezes a layer of cells to a thousandth of its thickness.
    for point in &mut mesh.points {
        if point[0] == 5.0 {
            point[0] = 7.4975;
        }
    }
    let traction = Load::Traction { facets: "x_max".into(), value: [3.0, 0.0, 2.0] };
    let block = lower(NeoHookean, mesh, vec![traction], vec![Support::clamped("x_min")]);
    assert_sound(&solve(&block, [10.0, 20.0]).unwrap());
}

#[test]
fn single_tetrahedron_with_prescribed_stretch() {
    let mut mesh = TetMesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        cells: vec![[0, 1, 2, 3]],
        ..TetMesh::default()
    };
    mesh.node_sets.insert("base".into(), vec![0, 2, 3]);
    mesh.node_sets.insert("tip".into(), vec![1]);
    let supports =
        vec![Support::clamped("base"), Support::uniform("tip", [Some(0.5), Some(0.0), None])];
    let solution = solve(&lower(NeoHookean, mesh.clone(), vec![], supports), [1.0, 1.0]).unwrap();
    assert_eq!(solution.displacement[3], 0.5);
    assert_sound(&solution);

    // No unknown at all: the solution is what is prescribed.
    let supports =
        vec![Support::clamped("base"), Support::uniform("tip", [Some(0.5), Some(0.0), Some(0.0)])];
    let held = lower(NeoHookean, mesh, vec![], supports);
    let solution = solve(&held, [1.0, 1.0]).unwrap();
    assert_eq!(solution.displacement[3..6], [0.5, 0.0, 0.0]);
    // ψ = ½(ln 1.5)² − ln 1.5 + ½(1.5² − 1), volume 1/6.
    let log = 1.5_f64.ln();
    let density = 0.5 * log * log - log + 0.5 * (1.5 * 1.5 - 1.0);
    assert!((solution.energy - density / 6.0).abs() < 1e-15);
}

#[test]
fn a_cube_twisted_by_sixty_degrees_and_further() {
    for degrees in [60.0_f64, 150.0] {
        let mesh = box_tetrahedra([10.0, 10.0, 10.0], [4, 4, 4]);
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let twist = |[_, y, z]: [f64; 3]| {
            let (y, z) = (y - 5.0, z - 5.0);
            [0.0, cosine * y - sine * z - y, sine * y + cosine * z - z]
        };
        let supports = vec![Support::clamped("x_min"), Support::moved("x_max", &mesh, twist)];
        let cube = lower(NeoHookean, mesh, vec![], supports);
        let solution = solve(&cube, [5.0, 5.0]).unwrap();
        assert_sound(&solution);
        assert!(solution.energy > 0.0);
    }
}

fn failure(result: Result<Solution, SolveError>) -> NotConverged {
    match result {
        Err(SolveError::NotConverged(failure)) => *failure,
        other => panic!("expected no convergence, got {other:?}"),
    }
}

#[test]
fn an_impossible_load_is_refused_with_history_and_advice() {
    let mesh = box_tetrahedra([10.0, 10.0, 10.0], [2, 2, 2]);
    // Compression into nothing: the far side is pushed through the held one.
    let supports = vec![
        Support::clamped("x_min"),
        Support::uniform("x_max", [Some(-15.0), Some(0.0), Some(0.0)]),
    ];
    let block = lower(NeoHookean, mesh, vec![], supports);
    let failure = failure(solve(&block, [1.0, 1.0]));
    println!("{failure}");
    assert!(failure.load_factor > 0.3 && failure.load_factor < 0.7, "{}", failure.load_factor);
    assert!(failure.displacement.iter().all(|u| u.is_finite()));
    assert!(!failure.history.iterations.is_empty());
    assert!(matches!(failure.advice, Advice::Squeezed { volume_ratio, .. } if volume_ratio < 0.05));
    assert!(failure.to_string().contains("cell"));
}

#[test]
fn an_absurd_load_is_solved_or_refused_with_history() {
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let beam = lower(NeoHookean, mesh, gravity(1e6), vec![Support::clamped("x_min")]);
    match solve(&beam, [75.0, 75.0]) {
        Ok(solution) => assert_sound(&solution),
        Err(SolveError::NotConverged(failure)) => {
            println!("{failure}");
            assert!(failure.load_factor < 1.0 && !failure.history.iterations.is_empty());
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn limits_on_iterations_are_kept() {
    let options = Options { iterations: 3, ..Options::default() };
    let beam = once();
    let failure = failure(Solver::new(&beam).unwrap().solve(&[75.0, 75.0], &options));
    assert_eq!(failure.history.iterations.len(), 3);
    assert_eq!(failure.advice, Advice::MoreIterations);
}

#[test]
fn an_unclamped_body_is_named_with_its_free_motions() {
    let mut beam = once();
    beam.prescribed.fill(None);
    let Err(SolveError::FreeToMove { nodes, modes, .. }) = Solver::new(&beam).map(|_| ()) else {
        panic!("expected a free body");
    };
    assert_eq!((nodes, modes.len()), (390, 6));

    // A hinge along y at the edge x = z = 0.
    let mesh = box_tetrahedra([10.0, 10.0, 10.0], [2, 2, 2]);
    let edge =
        (0..mesh.points.len()).filter(|&n| mesh.points[n][0] == 0.0 && mesh.points[n][2] == 0.0);
    let mut hinged = mesh.clone();
    hinged.node_sets.insert("edge".into(), edge.collect());
    let hinged = lower(NeoHookean, hinged, vec![], vec![Support::clamped("edge")]);
    let error = Solver::new(&hinged).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("rotation about y"), "{error}");

    // Rollers on three sides hold a body.
    let roller = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
    let sides = ["x_min", "y_min", "z_min"].into_iter().enumerate();
    let supports = sides.map(|(axis, set)| Support::uniform(set, roller(axis))).collect();
    assert!(Solver::new(&lower(NeoHookean, mesh, vec![], supports)).is_ok());
}

#[test]
fn a_loose_part_and_a_loose_node_are_named() {
    let mut mesh = box_tetrahedra([10.0, 10.0, 10.0], [1, 1, 1]);
    let part = box_tetrahedra([1.0, 1.0, 1.0], [1, 1, 1]);
    let first = mesh.points.len();
    mesh.points.extend(part.points.iter().map(|p| p.map(|x| x + 20.0)));
    mesh.cells.extend(part.cells.iter().map(|cell| cell.map(|node| node + first)));
    let mut body = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min")]);
    let error = Solver::new(&body).map(|_| ()).unwrap_err();
    assert!(
        matches!(&error, SolveError::FreeToMove { node: 8, nodes: 8, modes } if modes.len() == 6)
    );

    body.cells.truncate(6);
    body.volumes.truncate(6);
    body.shape_gradients.truncate(6);
    body.directions.truncate(6);
    assert_eq!(Solver::new(&body).map(|_| ()).unwrap_err(), SolveError::LooseNode { node: 8 });
}

#[test]
fn senseless_input_is_refused() {
    let beam = once();
    let mut solver = Solver::new(&beam).unwrap();
    let options = Options::default();
    for theta in [&[f64::NAN, 75.0][..], &[75.0, -1.0], &[75.0], &[f64::INFINITY, 1.0]] {
        assert!(matches!(solver.solve(theta, &options), Err(SolveError::Theta(_))), "{theta:?}");
    }
    let short = solver.solve_from(&[0.0; 3], &[75.0, 75.0], &options);
    assert_eq!(short.unwrap_err(), SolveError::Initial { given: 3, finite: 3, needed: 1170 });
    let unreal = solver.solve_from(&[f64::NAN; 1170], &[75.0, 75.0], &options);
    assert_eq!(unreal.unwrap_err(), SolveError::Initial { given: 1170, finite: 0, needed: 1170 });

    let mut empty = once();
    empty.cells.clear();
    assert_eq!(Solver::new(&empty).map(|_| ()).unwrap_err(), SolveError::EmptyMesh);
    let mut torn = once();
    torn.nodal_force[0] = f64::NAN;
    assert!(matches!(Solver::new(&torn).map(|_| ()), Err(SolveError::Malformed { .. })));
}

#[test]
fn an_inverted_initial_state_is_left_for_load_steps() {
    let beam = once();
    let mut solver = Solver::new(&beam).unwrap();
    let tangled: Vec<_> = (0..1170).map(|i| ((i * 7919) % 101) as f64).collect();
    let cold = solver.solve(&[75.0, 75.0], &Options::default()).unwrap();
    let solution = solver.solve_from(&tangled, &[75.0, 75.0], &Options::default()).unwrap();
    assert!(solution.load_steps > 1);
    assert!(support::difference(&solution.displacement, &cold.displacement) < 1e-10);
}

#[test]
fn a_compressed_column_reports_its_instability_and_bows_when_nudged() {
    // Shortened by a tenth between clamps that cannot turn: past its buckling load. The mesh is symmetric
    // under inversion and the first buckling mode is not, so nothing excites it.
    let mesh = box_tetrahedra([100.0, 4.0, 4.0], [20, 1, 1]);
    let bump: Vec<_> =
        mesh.points.iter().map(|p| (p[0] * std::f64::consts::PI / 100.0).sin().powi(2)).collect();
    let slide = Support::uniform("x_max", [Some(-10.0), Some(0.0), Some(0.0)]);
    let column = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min"), slide]);
    let straight = solve(&column, [75.0, 75.0]).unwrap();
    assert!(!straight.is_stable());
    let mut solver = Solver::new(&column).unwrap();
    assert_eq!(
        negative_eigenvalues(&solver.stiffness(&straight).unwrap()),
        straight.negative_pivots
    );

    let mut nudged = straight.displacement.clone();
    bump.iter().enumerate().for_each(|(node, b)| nudged[3 * node + 1] += b);
    let bowed = solver.solve_from(&nudged, &[75.0, 75.0], &Options::default()).unwrap();
    println!("{} -> {} kPa mm³, {} iterations", straight.energy, bowed.energy, bowed.iterations());
    assert_sound(&bowed);
    assert!(bowed.energy < straight.energy);
    assert_eq!(negative_eigenvalues(&solver.stiffness(&bowed).unwrap()), 0);
}

/// Counted from a dense eigenvalue decomposition.
fn negative_eigenvalues(stiffness: &Stiffness) -> usize {
    let size = stiffness.degree_of_freedom.len();
    let mut dense = nalgebra::DMatrix::zeros(size, size);
    for column in 0..size {
        for at in stiffness.column_starts[column]..stiffness.column_starts[column + 1] {
            let row = stiffness.rows[at];
            dense[(row, column)] = stiffness.values[at];
            dense[(column, row)] = stiffness.values[at];
        }
    }
    dense.symmetric_eigenvalues().iter().filter(|&&value| value < 0.0).count()
}
