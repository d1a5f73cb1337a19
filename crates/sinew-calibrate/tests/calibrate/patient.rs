//! Observables of patients and their derivatives through unloading.

use crate::support::heart::{
    MMHG, NAMES, ObserveStrains, THETA, beating, mesh, passive, segments, wall,
};
use crate::support::slopes::{SHORT_STEP, check, check_rows};
use sinew_calibrate::{Direction, Forward, Observable, Patient, PatientBuilder, Setting};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Fibres, Load, Magnitude, Parameter, Scene, Support};
use sinew_mesh::TruncatedEllipsoid;

#[test]
fn volumes_and_strains_of_a_passive_heart_have_exact_derivatives() {
    let body = passive(mesh(), 25.0).lower().unwrap();
    let (wall, point) = (wall(&mesh()), body.positions[body.nodes / 2]);
    let segments = segments(&wall);
    let all = &segments;
    for convention in [Fibres::Carried, Fibres::Kept] {
        let (fibres, wall, segments) = (Some(convention), Some(&wall), Some(all));
        let base = PatientBuilder { fibres, wall, segments, ..Patient::of(&body) };
        let mut patient = base
            .parameters(NAMES)
            .image([("pressure", 8.0 * MMHG)])
            .phase("low", [("pressure", 3.0 * MMHG)])
            .phase("high", [("pressure", 14.0 * MMHG)])
            .observe(Observable::volume("endo", "rest"))
            .observe(Observable::volume("endo", "low"))
            .observe(Observable::volume("endo", "high"))
            .observe(Observable::displacement(point, [1.0, 0.0, 1.0], "rest", "high"));
        for direction in [
            Direction::Circumferential,
            Direction::Longitudinal,
            Direction::Radial,
            Direction::Fibre,
        ] {
            patient = patient.observe_strains(all, direction, "low", "high");
        }
        patient = patient.observe_strains(all, Direction::Circumferential, "image", "high");
        let patient = patient.build().unwrap();
        let seen = check(&format!("{convention:?}"), &patient, &THETA);
        // Volumes rise with the pressure, and strains in the wall with the volume.
        let image = body.cavity_volumes(&vec![0.0; 3 * body.nodes])[0];
        assert!(seen.values[0] < seen.values[1] && seen.values[1] < image, "{:?}", seen.values);
        assert!(image < seen.values[2]);
        assert!(seen.values[4..4 + 6].iter().all(|strain| *strain > 0.0));
    }
}

#[test]
fn a_beating_heart_on_springs_has_exact_derivatives() {
    let body = beating(mesh());
    let wall = wall(&mesh());
    let segments = segments(&wall);
    let base = PatientBuilder {
        start: Some(vec![0.2, 2.0, 2.8, 2.1, 34.0, 1.0]),
        wall: Some(&wall),
        segments: Some(&segments),
        ..Patient::of(&body)
    };
    let patient = base
        .parameters(["a", "b", "a_f", "b_f", "tension", "common"])
        .image([("pressure", Setting::from(8.0 * MMHG).times("common")), ("T_a", 0.0.into())])
        .phase(
            "end of systole",
            [
                ("pressure", Setting::from(90.0 * MMHG).times("common")),
                ("T_a", Setting::parameter("tension")),
            ],
        )
        .observe(Observable::volume("endo", "end of systole"))
        .observe_strains(&segments, Direction::Circumferential, "image", "end of systole")
        .build()
        .unwrap();
    let theta = [0.21, 1.9, 2.7, 2.2, 36.0, 1.02];
    let seen = check_rows("beating", &patient, &theta, patient.observables(), SHORT_STEP);
    let image = body.cavity_volumes(&vec![0.0; 3 * body.nodes])[0];
    println!("{} of {image}", seen.values[0]);
    assert!(seen.values[0] < 0.95 * image);
}

#[test]
fn loads_have_the_slopes_of_a_product_of_parameters() {
    let mesh = TruncatedEllipsoid::LAND.wall([1, 8, 4]).tetrahedra();
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) };
    let body = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 5.0..=50.0))
        .parameter(Parameter::log("lambda", "kPa", 20.0..=200.0))
        .parameter(Parameter::linear("p", "kPa", 0.0..=3.0))
        .load(pressure)
        .support(Support::clamped("base"))
        .lower()
        .unwrap();
    let product = Setting::from(3e-3).times("common").times("own").times("own");
    let patient = Patient::of(&body)
        .parameters(["mu", "lambda", "common", "own"])
        .image([("p", 0.1)])
        .phase("filled", [("p", product)])
        .observe(Observable::volume("endo", "rest"))
        .observe(Observable::volume("endo", "filled"))
        .build()
        .unwrap();
    let seen = check("product", &patient, &[20.0, 80.0, 2.0, 5.0]);
    assert_eq!(seen.jacobian[0][2..], [0.0; 2]);
    // 0.15 kPa: the derivatives in the factors are 0.075 and 0.06 kPa.
    let [.., common, own] = seen.jacobian[1][..] else { panic!() };
    assert!((common / own - 1.25).abs() < 1e-6, "{common} {own}");
}

#[test]
fn an_image_at_rest_is_loaded_as_it_is() {
    let body = passive(mesh(), 25.0).lower().unwrap();
    let patient = PatientBuilder { fibres: None, ..Patient::of(&body) }
        .parameters(NAMES)
        .image([("pressure", 0.0)])
        .phase("filled", [("pressure", 8.0 * MMHG)])
        .observe(Observable::volume("endo", "rest"))
        .observe(Observable::volume("endo", "filled"))
        .build()
        .unwrap();
    let seen = patient.observe(&THETA, true).unwrap();
    let theta: Vec<f64> = THETA.into_iter().chain([8.0 * MMHG]).collect();
    let solution =
        sinew_fem::Solver::new(&body).unwrap().solve(&theta, &Default::default()).unwrap();
    let expected = body.cavity_volumes(&solution.displacement)[0];
    // Both are accurate to rounding errors of the solver.
    assert!((seen.values[1] / expected - 1.0).abs() < 1e-10, "{} {expected}", seen.values[1]);
    assert_eq!(seen.jacobian[0], [0.0; 4]);
    assert!(seen.jacobian[1].iter().all(|slope| *slope < 0.0));
}

#[test]
fn a_vessel_open_at_both_ends_has_the_volume_that_the_solver_has() {
    // A quarter of a tube between two symmetry planes, held at both ends.
    let mut mesh = sinew_mesh::box_tetrahedra([2.0, 1.0, 12.0], [1, 4, 4]);
    mesh.points.iter_mut().for_each(|x| {
        let angle = 0.5 * std::f64::consts::PI * x[1];
        (x[0], x[1]) = ((5.0 + x[0]) * angle.cos(), (5.0 + x[0]) * angle.sin());
    });
    let pressure = Load::Pressure { facets: "x_min".into(), magnitude: Magnitude::Theta(2) };
    let body = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
        .parameter(Parameter::linear("p", "kPa", 0.0..=2.0))
        .load(pressure)
        .support(Support::clamped("z_min"))
        .support(Support::clamped("z_max"))
        .support(Support::uniform("y_min", [None, Some(0.0), None]))
        .support(Support::uniform("y_max", [Some(0.0), None, None]))
        .lower()
        .unwrap();
    let patient = Patient::of(&body)
        .parameters(["mu", "lambda"])
        .image([("p", 0.5)])
        .phase("high", [("p", 1.5)])
        .observe(Observable::volume("x_min", "image"))
        .observe(Observable::volume("x_min", "high"))
        .build()
        .unwrap();
    let theta = [11.1, 20.0];
    let seen = check("vessel", &patient, &theta);
    let chords = 4.0 * 0.5 * 25.0 * (std::f64::consts::PI / 8.0).sin() * 12.0;
    assert!((seen.values[0] / chords - 1.0).abs() < 1e-10, "{} for {chords}", seen.values[0]);
    let unloaded = sinew_fem::Unload::new(&body).unwrap();
    let unloaded = { unloaded }.solve(&[11.1, 20.0, 0.5], &Default::default()).unwrap();
    let rest = &unloaded.rest;
    for (pressure, expected) in [(0.5, seen.values[0]), (1.5, seen.values[1])] {
        let mut solver = sinew_fem::Solver::new(rest).unwrap();
        let solution = solver.solve(&[11.1, 20.0, pressure], &Default::default()).unwrap();
        let volume = rest.cavity_volumes(&solution.displacement)[0];
        assert!((volume / expected - 1.0).abs() < 1e-9, "{volume} for {expected}");
    }
}

#[test]
fn all_stresses_times_a_factor_leave_displacements_as_they_are() {
    const FACTOR: f64 = 1.7;
    let wall = wall(&mesh());
    let segments = segments(&wall);
    let bodies = [1.0, FACTOR].map(|scale| passive(mesh(), 25.0 * scale).lower().unwrap());
    let seen = [1.0, FACTOR].map(|scale| {
        let patient = Patient::of(&bodies[usize::from(scale > 1.0)]);
        let (wall, own) = (Some(&wall), Some(&segments));
        let patient = PatientBuilder { wall, segments: own, ..patient }
            .parameters(NAMES)
            .image([("pressure", 8.0 * MMHG * scale)])
            .phase("high", [("pressure", 14.0 * MMHG * scale)])
            .observe(Observable::volume("endo", "rest"))
            .observe(Observable::volume("endo", "high"))
            .observe_strains(&segments, Direction::Circumferential, "rest", "high")
            .build()
            .unwrap();
        let [a, b, a_f, b_f] = THETA;
        patient.observe(&[scale * a, b, scale * a_f, b_f], false).unwrap().values
    });
    for (a, b) in seen[0].iter().zip(&seen[1]) {
        assert!((a - b).abs() <= 1e-8 * a.abs().max(1e-3), "{a} {b}");
    }
}

#[test]
fn numbers_depend_on_theta_alone() {
    let body = passive(mesh(), 25.0).lower().unwrap();
    let patient = || {
        Patient::of(&body)
            .parameters(NAMES)
            .image([("pressure", 8.0 * MMHG)])
            .phase("high", [("pressure", 14.0 * MMHG)])
            .observe(Observable::volume("endo", "rest"))
            .observe(Observable::volume("endo", "high"))
            .build()
            .unwrap()
    };
    let thetas = [THETA, [0.25, 1.5, 2.0, 3.0], [0.15, 2.5, 4.0, 1.5]];
    let at = |patient: &Patient<'_>, theta: &[f64; 4]| {
        let seen = patient.observe(theta, true).unwrap();
        (seen.values, seen.jacobian)
    };
    let forwards = patient();
    let first: Vec<_> = thetas.iter().map(|theta| at(&forwards, theta)).collect();
    let backwards = patient();
    let mut second: Vec<_> = thetas.iter().rev().map(|theta| at(&backwards, theta)).collect();
    second.reverse();
    assert_eq!(first, second);
    let shared = patient();
    let threaded: Vec<_> = std::thread::scope(|scope| {
        let runs: Vec<_> = thetas.iter().map(|theta| scope.spawn(|| at(&shared, theta))).collect();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    assert_eq!(first, threaded);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| {
            let patient = patient();
            thetas.iter().map(|theta| at(&patient, theta)).collect::<Vec<_>>()
        });
        assert_eq!(first, again, "{threads} threads");
    }
}

#[test]
fn states_to_a_millionth_are_exact_beside_the_noise_of_data() {
    let body = passive(mesh(), 25.0).lower().unwrap();
    let wall = wall(&mesh());
    let segments = segments(&wall);
    let patient = |accuracy: f64| {
        let (wall, own) = (Some(&wall), Some(&segments));
        PatientBuilder { accuracy, wall, segments: own, ..Patient::of(&body) }
            .parameters(NAMES)
            .image([("pressure", 8.0 * MMHG)])
            .phase("low", [("pressure", 3.0 * MMHG)])
            .phase("high", [("pressure", 14.0 * MMHG)])
            .observe(Observable::volume("endo", "high"))
            .observe_strains(&segments, Direction::Circumferential, "low", "high")
            .observe_strains(&segments, Direction::Longitudinal, "low", "high")
            .build()
            .unwrap()
    };
    let (rough, exact) = (patient(1e-6), patient(0.0));
    for factors in [[1.1, 0.9, 1.0, 1.1], [0.7, 1.3, 0.8, 1.2], [1.5, 0.7, 1.4, 0.8], [1.0; 4]] {
        let theta = std::array::from_fn::<_, 4, _>(|k| THETA[k] * factors[k]);
        let [rough, exact] = [&rough, &exact].map(|of| of.observe(&theta, false).unwrap().values);
        for (index, (rough, exact)) in rough.iter().zip(&exact).enumerate() {
            // Volumes are measured to three per cent, strains to 0.02.
            let deviation = if index == 0 { 0.03 * exact } else { 0.02 };
            let apart = (rough - exact).abs() / deviation;
            assert!(apart < 1e-4, "datum {index} at {theta:?}: {apart}");
        }
    }
}
