//! Diagnostics of a solve: its iterations as they come, reactions, locking, and the worst cells of a failure.

use crate::support::{GRAVITY, forces_of_supports, gravity, once, parameters, twice, vector_area};
use sinew_energy::laws::{ActiveTension, HolzapfelOgden, NeoHookean};
use sinew_energy::metrics::volume_ratios;
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support, SurfaceResponse};
use sinew_fem::{
    Advice, LARGEST_BULK_TO_SHEAR, LockingWarning, Options, Solution, SolveError, Solver,
    held_sets, locking, reactions,
};
use sinew_mesh::{
    AnyMesh, TetMesh, TruncatedEllipsoid, box_hexahedra, box_tetrahedra, rectangle_triangles,
};

const THETA: [f64; 2] = [75.0, 75.0];
/// Weight of the once clamped beam [kPa mm²].
const WEIGHT: f64 = 98.0;
/// A pressure [kPa] that bends the beam far.
const PRESSURE: f64 = 0.3;
/// Balance of forces that a converged solution leaves, relative to the weight.
const BALANCED: f64 = 1e-8;

fn scene(mesh: impl Into<AnyMesh>, loads: Vec<Load>) -> Scene {
    Scene {
        name: "diagnostics".into(),
        parameters: parameters(&["mu", "lambda"]),
        loads,
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, NeoHookean)
    }
}

fn beam() -> TetMesh {
    box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5])
}

#[test]
fn every_iteration_is_handed_out_with_its_state() {
    let potential = once();
    let mut seen = Vec::new();
    let mut last = Vec::new();
    let mut solver = Solver::new(&potential).unwrap();
    let solution = solver
        .solve_watched(&THETA, &Options::default(), &mut |progress| {
            let energy = potential.value(progress.displacement, &THETA);
            assert!((energy - progress.iteration.energy).abs() <= 1e-9 * energy.abs().max(1.0));
            let free = potential.free_degrees_of_freedom();
            let squares = free.iter().map(|&i| progress.forces[i].powi(2)).sum::<f64>();
            assert!(
                (squares.sqrt() - progress.iteration.residual).abs()
                    <= 1e-12 * progress.iteration.residual
            );
            last = progress.displacement.to_vec();
            seen.push((
                progress.iteration.residual,
                progress.iteration.tolerance,
                progress.iteration.least_volume_ratio,
            ));
            assert_eq!(seen.len(), progress.number + 1);
            assert_eq!(progress.iteration.step > 0.0, progress.number > 0);
        })
        .unwrap();
    let recorded = solution.history.iterations.iter();
    let recorded: Vec<_> =
        recorded.map(|i| (i.residual, i.tolerance, i.least_volume_ratio)).collect();
    assert_eq!((seen, last), (recorded, solution.displacement.clone()));
    let unwatched = solver.solve(&THETA, &Options::default()).unwrap();
    assert_eq!(unwatched.displacement, solution.displacement);
}

#[test]
fn a_balance_is_watched_as_well() {
    let mesh = box_tetrahedra([10.0, 2.0, 2.0], [4, 1, 1]).quadratic();
    let body = scene(mesh, gravity(1.0)).mixed().lower().unwrap();
    let mut residuals = Vec::new();
    let solution = Solver::new(&body)
        .unwrap()
        .solve_watched(&THETA, &Options::default(), &mut |p| residuals.push(p.iteration.residual))
        .unwrap();
    let recorded: Vec<_> = solution.history.iterations.iter().map(|i| i.residual).collect();
    assert_eq!(residuals, recorded);
}

/// A body of the scene at its equilibrium.
fn at_equilibrium(mesh: impl Into<AnyMesh>, loads: Vec<Load>) -> (Body, Solution) {
    let body = scene(mesh, loads).lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
    let ratios = volume_ratios(&body, &solution.displacement);
    let least = ratios.into_iter().fold(f64::INFINITY, f64::min);
    assert!((least - solution.least_volume_ratio).abs() < 1e-12);
    (body, solution)
}

/// Reference and deformed volume.
fn volumes(body: &Body, solution: &Solution) -> [f64; 2] {
    let ratios = volume_ratios(body, &solution.displacement);
    let deformed = body.volumes.iter().zip(ratios).map(|(v, j)| v * j).sum();
    [body.volumes.iter().sum(), deformed]
}

#[test]
fn reactions_balance_the_weight() {
    let (body, solution) = at_equilibrium(beam(), gravity(1.0));
    let [clamp] = forces_of_supports(&body, &solution)[..] else { panic!("one side is held") };
    assert!((clamp[2] - WEIGHT).abs() < BALANCED * WEIGHT, "{clamp:?}");
    assert!(clamp[0].abs() + clamp[1].abs() < BALANCED * WEIGHT, "{clamp:?}");
    let (name, nodes) = held_sets(&body).next().unwrap();
    assert_eq!((name.as_str(), nodes.len()), ("x_min", 30));
    assert!(solution.residual < 1e-10 * solution.force_scale);
    let [reference, deformed] = volumes(&body, &solution);
    assert!((reference - 1e4).abs() < 1e-8 && (deformed / reference - 1.00042).abs() < 5e-6);
    let short = reactions(&body, &solution.displacement[1..], &[], &THETA);
    assert!(matches!(short, Err(SolveError::Initial { .. })));
}

#[test]
fn two_clamps_share_the_weight() {
    let body = twice();
    let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
    let names: Vec<_> = held_sets(&body).map(|(name, _)| name).collect();
    assert_eq!(names, ["x_max", "x_min"]);
    let [right, left] = forces_of_supports(&body, &solution)[..] else { panic!("two sides") };
    let weight = 150.0 * 10.0 * 2.0 * 9.8e-3;
    assert!((left[2] + right[2] - weight).abs() < BALANCED * weight, "{left:?} {right:?}");
    // They pull the sagging beam apart, each outwards.
    assert!(left[0] < 0.0 && (left[0] + right[0]).abs() < BALANCED * weight);
}

#[test]
fn a_linear_body_stores_half_the_work_of_its_loads() {
    let (body, solution) = at_equilibrium(beam(), gravity(1e-5));
    let work = -body.load_value(&solution.displacement, &THETA);
    // The beam stiffens with the square of its rotation, here below 1e-5.
    assert!(((solution.energy + work) / work - 0.5).abs() < 1e-6);
}

#[test]
fn hexahedra_and_incompressible_bodies_are_held_by_their_weight() {
    let (hexahedra, solution) = at_equilibrium(box_hexahedra([10.0; 3], [3; 3]), gravity(1.0));
    let clamp = forces_of_supports(&hexahedra, &solution)[0];
    assert!((clamp[2] - 9.8).abs() < BALANCED * 9.8);
    assert_eq!(locking(&hexahedra, &THETA, &solution.displacement), Ok(None));

    let mesh = box_tetrahedra([20.0, 2.0, 2.0], [6, 1, 1]).quadratic();
    let body = scene(mesh, gravity(1.0)).mixed().lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
    let weight = 80.0 * 9.8e-3;
    let clamp = forces_of_supports(&body, &solution)[0];
    assert!((clamp[2] - weight).abs() < BALANCED * weight);
    let [reference, deformed] = volumes(&body, &solution);
    // The pressures test the volume of every cell together with its neighbours'.
    assert!((deformed / reference - 1.0).abs() < 1e-8, "{deformed}");
    assert_eq!(locking(&body, &THETA, &solution.displacement), Ok(None));
}

#[test]
fn loose_followers_are_loads() {
    let pressure = Load::Pressure { facets: "x_max".into(), magnitude: Magnitude::Fixed(3.0) };
    let body = scene(box_tetrahedra([4.0, 4.0, 4.0], [2; 3]), vec![pressure]);
    let body = body.loose_rims().lower().unwrap();
    assert_eq!(body.followers.len(), 1);
    let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
    let clamp = forces_of_supports(&body, &solution)[0];
    let area = vector_area(&body, "x_max", &solution.displacement);
    // 3 kPa on a face of 16 mm² that hardly widens.
    assert!((clamp[0] - 48.0).abs() < 3.0, "{clamp:?}");
    for (force, area) in clamp.iter().zip(area) {
        assert!((force - 3.0 * area).abs() < BALANCED * 48.0, "{clamp:?} {area:?}");
    }
}

#[test]
fn plane_strain_has_reactions_per_unit_of_thickness() {
    let pull = Load::Traction { facets: "x_max".into(), value: [2.0, 0.0, 0.0] };
    let (body, solution) = at_equilibrium(rectangle_triangles([4.0, 1.0], [16, 4]), vec![pull]);
    let [clamp] = forces_of_supports(&body, &solution)[..] else { panic!("one side is held") };
    assert!((clamp[0] + 2.0).abs() < BALANCED * 2.0 && clamp[2] == 0.0, "{clamp:?}");
    // The contraction at the clamp is hindered alike on both edges.
    assert!(clamp[1].abs() < 1e-2 && (volumes(&body, &solution)[0] - 4.0).abs() < 1e-12);
}

/// [`locking`] at rest.
fn at_rest(body: &Body, theta: &[f64]) -> Option<LockingWarning> {
    locking(body, theta, &vec![0.0; 3 * body.nodes]).unwrap()
}

#[test]
fn locking_is_foreseen_at_rest() {
    let tets = scene(beam(), gravity(1.0));
    let plain = tets.lower().unwrap();
    assert_eq!(at_rest(&plain, &THETA).expect("too few elements").bulk_to_shear, None);

    let stiff = [75.0, 7.5e3];
    let warning = at_rest(&plain, &stiff).unwrap();
    let ratio = warning.bulk_to_shear.unwrap();
    assert!((ratio - (100.0 + 2.0 / 3.0)).abs() < 1e-9 && ratio > LARGEST_BULK_TO_SHEAR);
    let advice = warning.to_string();
    for cure in ["Scene::averaged()", "mesh.quadratic()", "Scene::mixed()", "lose 7"] {
        assert!(advice.contains(cure), "{advice}");
    }

    // Patches cure the volume, not the bending.
    let averaged = at_rest(&tets.clone().averaged().lower().unwrap(), &stiff).unwrap();
    assert!(averaged.bulk_to_shear.is_none() && averaged.expected_share < warning.expected_share);
    let quadratic = scene(beam().quadratic(), vec![]).lower().unwrap();
    assert_eq!(at_rest(&quadratic, &stiff), None);
    let bricks = scene(box_hexahedra([10.0; 3], [4; 3]), gravity(1.0));
    assert!(at_rest(&bricks.lower().unwrap(), &stiff).is_some());
    assert_eq!(at_rest(&bricks.lower().unwrap(), &THETA), None);
    assert_eq!(at_rest(&bricks.averaged().lower().unwrap(), &stiff), None);
    let thin = scene(box_hexahedra([100.0, 10.0, 10.0], [20, 2, 2]), gravity(1.0));
    assert!(at_rest(&thin.lower().unwrap(), &THETA).is_some());
    assert!(locking(&plain, &[75.0], &vec![0.0; 3 * plain.nodes]).is_err());
    assert!(locking(&plain, &THETA, &[0.0]).is_err());
}

#[test]
fn a_solution_tells_that_elements_lock() {
    // ν = 0.4999 in linear tetrahedra: the tip sinks by a fortieth of what it should.
    let theta = [75.0, 75.0 * 2.0 * 0.4999 / (1.0 - 2.0 * 0.4999)];
    let body = scene(beam(), gravity(1.0)).lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
    let found = locking(&body, &theta, &solution.displacement).unwrap();
    assert!(found.expect("linear tetrahedra lock").bulk_to_shear.unwrap() > 1e3);
}

#[test]
fn neither_one_scar_nor_a_tension_decides_the_ratio_of_moduli() {
    let ratio = |body: &Body, theta: &[f64]| {
        at_rest(body, theta).expect("linear tetrahedra lock").bulk_to_shear
    };
    let beam = scene(beam(), gravity(1.0)).lower().unwrap();
    let theta = [1.0, 100.0];
    let mut factors = vec![1.0; beam.volumes.len()];
    factors[0] = 0.0;
    let scarred = beam.clone().with_parameter_field("mu", &factors).unwrap();
    assert_eq!(ratio(&scarred, &theta), ratio(&beam, &theta));

    let law = HolzapfelOgden.nearly_incompressible(25.0).with_active(ActiveTension);
    let directions = vec![[[1.0, 0.0, 0.0]]; beam.volumes.len()];
    let names = ["a", "b", "a_f", "b_f", "T_a"];
    let muscle = law.along(directions);
    let scene = names.iter().fold(Scene::new(self::beam(), muscle), |scene, name| {
        scene.parameter(Parameter::log(*name, "kPa", 0.1..=100.0))
    });
    let load = Load::BodyForce([0.0, 0.0, GRAVITY]);
    let active = scene.load(load).support(Support::clamped("x_min"));
    let active = active.lower().unwrap();
    let at = |tension: f64| ratio(&active, &[0.5, 1.0, 0.5, 1.0, tension]).unwrap();
    // Below the beam's weight, which a larger tension would outweigh.
    assert!((at(0.1) / at(1e-3) - 1.0).abs() < 1e-6, "{} and {}", at(0.1), at(1e-3));
}

#[test]
fn a_failed_solve_returns_what_it_found() {
    let potential = once();
    let short = Options { iterations: 3, ..Options::default() };
    let failed = |error: SolveError| match error {
        SolveError::NotConverged(failure) => failure,
        other => panic!("{other}"),
    };
    let failure = failed(Solver::new(&potential).unwrap().solve(&THETA, &short).unwrap_err());
    assert_eq!((failure.worst_cells.len(), failure.advice), (5, Advice::MoreIterations));
    assert!(failure.worst_cells.is_sorted_by_key(|cell| cell.value));
    let last = failure.history.iterations.last().unwrap();
    let worst = failure.worst_cells[0];
    assert!((worst.value - last.least_volume_ratio).abs() < 1e-12 && worst.cell == last.worst_cell);
    assert!(failure.to_string().contains(&format!("(cell {})", worst.cell)), "{failure}");

    // A patch that the prescribed motion turns over is named although its energy is infinite.
    let mut turned = scene(beam(), vec![]);
    turned.supports.push(Support::uniform("x_max", [Some(-120.0), None, None]));
    let turned = turned.averaged().lower().unwrap();
    let options = Options { iterations: 2, ..Options::default() };
    let failure = failed(Solver::new(&turned).unwrap().solve(&THETA, &options).unwrap_err());
    let last = failure.history.iterations.last().unwrap();
    assert!(last.energy == f64::INFINITY && last.least_volume_ratio < 0.0, "{failure}");
    assert_eq!(failure.worst_cells[0].value, last.least_volume_ratio, "{failure}");

    // A pressure that follows the lower side needs load steps: some of them are done when the iterations run out.
    let pressed = |pressure: f64| {
        let magnitude = Magnitude::Fixed(pressure);
        let load = Load::Pressure { facets: "z_min".into(), magnitude };
        scene(beam(), vec![load]).loose_rims().lower().unwrap()
    };
    let body = pressed(PRESSURE);
    let mut solver = Solver::new(&body).unwrap();
    let whole = solver.solve(&THETA, &Options::default()).unwrap();
    assert!(whole.load_steps > 2);
    let iterations = whole.history.iterations.len() - 1;
    let short = Options { iterations, ..Options::default() };
    let failure = failed(solver.solve(&THETA, &short).unwrap_err());
    assert!(failure.load_factor > 0.0 && failure.load_factor < 1.0, "{failure}");
    assert_eq!((failure.worst_cells.len(), failure.history.iterations.len()), (5, iterations));
    // The state returned is the equilibrium at its load factor.
    let mut forces = vec![0.0; failure.displacement.len()];
    let part = pressed(PRESSURE * failure.load_factor);
    part.value_and_gradient(&failure.displacement, &THETA, &mut forces);
    let (follower, mut response) = (&part.followers[0], SurfaceResponse::default());
    let mut loads = vec![0.0; forces.len()];
    for facet in 0..follower.facets() {
        follower.facet_force(facet, &failure.displacement, &mut response);
        for (slot, force) in response.gradient.iter().enumerate() {
            let dof = 3 * follower.facet_nodes(facet)[slot / 3] + slot % 3;
            loads[dof] += PRESSURE * failure.load_factor * force;
        }
    }
    forces.iter_mut().zip(&loads).for_each(|(sum, load)| *sum += load);
    let free = part.free_degrees_of_freedom();
    let scale = loads.iter().map(|load| load.abs()).sum::<f64>();
    let largest = free.iter().map(|&i| forces[i].abs()).fold(0.0, f64::max);
    assert!(largest < BALANCED * scale, "{largest:e} of {scale:e}");
}

#[test]
fn a_factor_that_is_too_large_is_told_with_its_size() {
    let advice = Advice::FactorTooLarge { unknowns: 300_000, gigabytes: 5.3, most: 4.0 };
    let text = advice.to_string();
    assert!(
        text.contains("300000 unknowns would take 5.3 GB, of which 4.0 are taken unasked"),
        "{text}"
    );
}

#[test]
fn a_held_rim_carries_the_pressure_wherever_the_origin_is() {
    let forces = [[0.0; 3], [30.0, -20.0, 10.0]].map(|shift| {
        let mut mesh = TruncatedEllipsoid::LAND.wall([1, 8, 4]).tetrahedra();
        mesh.points.iter_mut().for_each(|x| *x = [0, 1, 2].map(|i| x[i] + shift[i]));
        let load = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(0.15) };
        let scene = Scene { supports: vec![Support::clamped("base")], ..scene(mesh, vec![load]) };
        let body = scene.lower().unwrap();
        assert!(body.has_potential());
        let solution = Solver::new(&body).unwrap().solve(&THETA, &Options::default()).unwrap();
        let base = held_sets(&body).position(|(name, _)| name == "base").unwrap();
        let force = forces_of_supports(&body, &solution)[base];
        let area = vector_area(&body, "endo", &solution.displacement);
        assert!(
            (force[2] - 0.15 * area[2]).abs() < BALANCED * force[2].abs(),
            "{force:?} {area:?}"
        );
        force[2]
    });
    assert!((forces[0] / forces[1] - 1.0).abs() < 1e-8, "{forces:?}");
}
