//! Deformations as large as they come: twist, compression, stretch, rotation, snap-through, buckling.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Support};
use sinew_fem::{Advice, Options, Solution, SolveError, Solver, Stiffness};
use sinew_mesh::{TetMesh, box_tetrahedra};
use std::f64::consts::{PI, TAU};

const SOFT: [f64; 2] = [1.0, 1.0];

/// Solves a mesh under a path of supports, each from the last solution: the body and its solution at every step.
fn follow(
    mesh: &TetMesh,
    steps: usize,
    supports: impl Fn(usize) -> Vec<Support>,
) -> Vec<(Body, Solution)> {
    let mut path: Vec<(Body, Solution)> = Vec::new();
    for step in 1..=steps {
        let body = lower(NeoHookean, mesh.clone(), vec![], supports(step));
        let rest = vec![0.0; body.prescribed.len()];
        let initial = path.last().map_or(rest, |(_, s)| s.displacement.clone());
        let solution =
            Solver::new(&body).unwrap().solve_from(&initial, &SOFT, &Options::default()).unwrap();
        path.push((body, solution));
    }
    path
}

#[test]
fn a_column_twisted_by_360_degrees_keeps_its_turn() {
    let mesh = box_tetrahedra([6.0, 1.0, 1.0], [12, 2, 2]);
    let steps = 16;
    let turned = |step| turn_about_x(TAU * step as f64 / steps as f64, [0.5; 2]);
    let twisted = follow(&mesh, steps, |step| {
        vec![Support::clamped("x_min"), Support::moved("x_max", &mesh, turned(step))]
    });
    // The energy of a full turn, though the prescribed motion is that of rest (to rounding of sin 2π).
    let (column, last) = twisted.last().unwrap();
    assert_sound(column, last);
    assert!(twisted.windows(2).all(|pair| pair[1].1.energy > pair[0].1.energy));
    let end = mesh.node_sets["x_max"].iter().map(|&n| norm(&last.displacement[3 * n..3 * n + 3]));
    assert!(end.fold(0.0, f64::max) < 1e-14);
    // Halfway up the section has turned by half: (y, z) → −(y, z) about the axis.
    for (node, &[x, y, z]) in mesh.points.iter().enumerate().filter(|(_, p)| p[0] == 3.0) {
        let u = &last.displacement[3 * node..3 * node + 3];
        let (before, after) = ([y - 0.5, z - 0.5], [y + u[1] - 0.5, z + u[2] - 0.5]);
        let product = before[0] * after[0] + before[1] * after[1];
        if norm(&before) > 0.0 {
            // The cosine of the turn; the section also shrinks.
            assert!(product < -0.9 * norm(&before) * norm(&after), "{x} {after:?}");
        }
    }
    // A cold solve of the same motion finds rest, the other equilibrium.
    let rest = solve(column, &SOFT).unwrap();
    assert!(rest.energy < 1e-25);
}

#[test]
fn a_cube_twisted_by_150_degrees_at_once_is_solved() {
    for degrees in [60.0_f64, 150.0] {
        let mesh = box_tetrahedra([10.0; 3], [4; 3]);
        let twist = turn_about_x(degrees.to_radians(), [5.0; 2]);
        let supports = vec![Support::clamped("x_min"), Support::moved("x_max", &mesh, twist)];
        let cube = lower(NeoHookean, mesh, vec![], supports);
        let solution = solve(&cube, &[5.0, 5.0]).unwrap();
        assert_sound(&cube, &solution);
        assert!(solution.energy > 0.0);
    }
}

/// A distorted bar between rollers against `μ(t² − 1) + λ ln(s t²) = 0`, which is increasing in t.
#[track_caller]
fn assert_homogeneous(stretch: f64, theta: [f64; 2]) {
    let mesh = distorted_cube(3);
    let nodes = mesh.node_sets["x_min"].clone();
    let bar = lower(NeoHookean, mesh, vec![], pulled(stretch - 1.0));
    let solution = solve(&bar, &theta).unwrap();
    assert_sound(&bar, &solution);
    let [shear, lame] = theta;
    let (mut low, mut high) = (1e-3, 1e3);
    for _ in 0..200 {
        let t = 0.5 * (low + high);
        let value = shear * (t * t - 1.0) + lame * f64::ln(stretch * t * t);
        if value < 0.0 { low = t } else { high = t }
    }
    let across = 1.0 + solution.displacement[3 * bar.nodes - 2];
    assert_close(across, low, 1e-9);
    // Force on the held side, −(μ s + (λ ln J − μ)/s) times area 1.
    let log = f64::ln(stretch * low * low);
    let force = shear * stretch + (lame * log - shear) / stretch;
    assert_close(reaction(&bar, &solution, &nodes)[0], -force, 1e-8);
}

#[test]
fn a_bar_compressed_by_90_percent_bulges_as_the_closed_form_says() {
    assert_homogeneous(0.1, [1.0, 1.0]);
    assert_homogeneous(0.1, [1.0, 0.0]);
}

#[test]
fn a_bar_stretched_by_300_percent_contracts_as_the_closed_form_says() {
    assert_homogeneous(4.0, [1.0, 1.0]);
    assert_homogeneous(4.0, [1.0, 100.0]);
}

#[test]
fn a_bar_pressed_through_its_own_support_is_refused_with_advice() {
    let mesh = box_tetrahedra([10.0; 3], [2; 3]);
    let supports = vec![
        Support::clamped("x_min"),
        Support::uniform("x_max", [Some(-15.0), Some(0.0), Some(0.0)]),
    ];
    let failure = failure(solve(&lower(NeoHookean, mesh, vec![], supports), &SOFT));
    assert!(failure.load_factor > 0.3 && failure.load_factor < 0.7, "{}", failure.load_factor);
    assert!(matches!(failure.advice, Advice::Squeezed { volume_ratio, .. } if volume_ratio < 0.05));
    assert!(failure.to_string().contains("cell"));
    // A trial state is not what the body does.
    let Advice::Squeezed { volume_ratio, .. } = failure.advice else { unreachable!() };
    assert!(volume_ratio > 0.0, "{volume_ratio}");
}

#[test]
fn a_boundary_turned_by_180_degrees_turns_the_inside_without_energy() {
    let mesh = distorted_cube(3);
    let half_turn = turn_about_x(PI, [0.3, 0.7]);
    let exact: Vec<_> = mesh.points.iter().flat_map(|&p| half_turn(p)).collect();
    let supports = vec![Support::moved("boundary", &mesh, half_turn)];
    let cube = lower(NeoHookean, mesh, vec![], supports);
    let solution = solve(&cube, &SOFT).unwrap();
    assert!(difference(&solution.displacement, &exact) < 1e-12);
    assert!(solution.energy.abs() < 1e-14 && solution.is_stable());
}

#[test]
fn a_support_turned_by_180_degrees_is_refused_at_once_and_followed_in_steps() {
    // A straight ramp to a half turn passes the axis, where the support is flat: no path for the body.
    let mesh = box_tetrahedra([3.0, 1.0, 1.0], [6, 2, 2]);
    let turned = |angle| vec![Support::moved("x_min", &mesh, turn_about_x(angle, [0.5; 2]))];
    let body = lower(NeoHookean, mesh.clone(), vec![], turned(PI));
    let refused = failure(solve(&body, &SOFT));
    assert!(refused.load_factor < 0.51, "{}", refused.load_factor);

    // In eight turns the body just turns along.
    let path = follow(&mesh, 8, |step| turned(PI * step as f64 / 8.0));
    let (_, last) = path.last().unwrap();
    let exact: Vec<_> = mesh.points.iter().flat_map(|&p| turn_about_x(PI, [0.5; 2])(p)).collect();
    assert!(difference(&last.displacement, &exact) < 1e-10);
    assert!(last.energy.abs() < 1e-14 && last.is_stable());

    // From the turned state the half turn needs no step at all.
    let mut solver = Solver::new(&body).unwrap();
    let direct = solver.solve_from(&exact, &SOFT, &Options::default()).unwrap();
    assert!(direct.load_steps == 1 && direct.energy.abs() < 1e-14);
}

#[test]
fn a_nearly_incompressible_body_stretched_and_turned_by_179_degrees_has_the_energy_of_the_stretch()
{
    let (stretch, angle) = (1.8_f64, 179_f64.to_radians());
    let across = stretch.sqrt().recip();
    let turn = turn_about_x(angle, [0.3, 0.7]);
    let motion = |[x, y, z]: [f64; 3]| {
        let place = [stretch * x, across * y, across * z];
        let turned = turn(place);
        [place[0] + turned[0] - x, place[1] + turned[1] - y, place[2] + turned[2] - z]
    };
    let mesh = distorted_cube(3);
    let exact: Vec<_> = mesh.points.iter().flat_map(|&p| motion(p)).collect();
    let supports = vec![Support::moved("boundary", &mesh, motion)];
    let cube = lower(NeoHookean, mesh, vec![], supports);
    // λ/μ = 10⁶, ν = 0.4999995: rounding errors of J are multiplied by it in the stress, and divided by it in the solution.
    let solution = solve(&cube, &[1.0, 1e6]).unwrap();
    assert!(difference(&solution.displacement, &exact) < 1e-9);
    // Ψ = ½μ(I₁ − 3) at J = 1, on a volume of 1; λ squares the error of ln J, some 1e-10.
    let closed_form = 0.5 * (stretch * stretch + 2.0 / stretch - 3.0);
    assert_close(solution.energy, closed_form, 1e-9);
    assert!(solution.is_stable());
}

/// A shallow arch with the `feet` it turns about, one line of nodes at each end, and its `crown`, the nodes in the
/// middle.
fn arch() -> TetMesh {
    let mut mesh = box_tetrahedra([20.0, 1.0, 0.25], [40, 1, 2]);
    for point in &mut mesh.points {
        point[2] += 1.5 * (PI * point[0] / 20.0).sin();
    }
    let crown = (0..mesh.points.len()).filter(|&n| mesh.points[n][0] == 10.0).collect();
    let is_foot = |p: [f64; 3]| (p[0] == 0.0 || p[0] == 20.0) && p[2].abs() < 1e-9;
    let feet = (0..mesh.points.len()).filter(|&n| is_foot(mesh.points[n])).collect();
    mesh.node_sets.insert("crown".into(), crown);
    mesh.node_sets.insert("feet".into(), feet);
    mesh
}

#[test]
fn an_arch_pushed_through_snaps_and_its_force_does_the_work_that_it_stores() {
    let mesh = arch();
    let (steps, depth) = (40, 3.6);
    let path = follow(&mesh, steps, |step| {
        let motion = -depth * step as f64 / steps as f64;
        let crown = Support::uniform("crown", [None, Some(0.0), Some(motion)]);
        vec![Support::clamped("feet"), crown]
    });
    let mut forces = vec![0.0];
    let mut energies = vec![0.0];
    for (body, solution) in &path {
        assert_equilibrium(body, solution);
        forces.push(-reaction(body, solution, &mesh.node_sets["crown"])[2]);
        energies.push(solution.energy);
    }
    // The push rises, falls, becomes a pull and rises again: the way of every shallow arch.
    println!("{forces:.4?}");
    assert!(forces[steps] > 0.0 && forces.iter().any(|&f| f < 0.0));
    let top = (1..steps).find(|&i| forces[i] > forces[i - 1] && forces[i] > forces[i + 1]);
    assert!(top.is_some());
    // Until it pulls, Simpson's rule over the force is the stored energy; later the arch jumps sideways.
    let pulls = (0..steps).step_by(2).find(|&i| forces[i] < 0.0).unwrap();
    let width = depth / steps as f64;
    let segments = forces[..=pulls].windows(3).step_by(2);
    let work: f64 = segments.map(|f| (f[0] + 4.0 * f[1] + f[2]) * width / 3.0).sum();
    assert_close(energies[pulls], work, 1e-3);
}

#[test]
fn an_arch_under_a_dead_load_beyond_its_limit_point_is_found_on_the_other_side_or_refused() {
    let mesh = arch();
    let clamps = vec![Support::clamped("feet")];
    let weight = vec![Load::BodyForce([0.0, 0.0, -0.02])];
    let body = lower(NeoHookean, mesh.clone(), weight, clamps);
    let crown = mesh.node_sets["crown"][0];
    match solve(&body, &SOFT) {
        Ok(solution) => {
            assert_sound(&body, &solution);
            assert!(solution.displacement[3 * crown + 2] < -2.0, "it has snapped");
        }
        Err(SolveError::NotConverged(failure)) => println!("{failure}"),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn a_compressed_column_reports_its_instability_and_bows_when_nudged() {
    // Shortened by a tenth between clamps that cannot turn: past its buckling load. The mesh is symmetric
    // under inversion and the first buckling mode is not, so nothing excites it.
    let mesh = box_tetrahedra([100.0, 4.0, 4.0], [20, 1, 1]);
    let bump: Vec<_> = mesh.points.iter().map(|p| (p[0] * PI / 100.0).sin().powi(2)).collect();
    let slide = Support::uniform("x_max", [Some(-10.0), Some(0.0), Some(0.0)]);
    let column = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min"), slide]);
    let straight = solve(&column, &[75.0, 75.0]).unwrap();
    assert_equilibrium(&column, &straight);
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
    assert_sound(&column, &bowed);
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
