//! Hard cases of patients: each ends in the answer that it should, or in an error that says what is wrong.

use crate::support::heart::{
    MMHG, NAMES, ObserveStrains, THETA, fibres, mesh, passive, segments, wall,
};
use sinew_calibrate::{
    Direction, Forward, ForwardError, Observable, Patient, PatientBuilder, PatientError, Segments,
    Setting, StateError, WallCoordinates,
};
use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Body, Law, Scene};
use sinew_fem::UnloadError;
use sinew_fem::fibres::Surfaces;
use sinew_mesh::{AnyMesh, Field};

fn body() -> Body {
    passive(mesh(), 25.0).lower().unwrap()
}

/// A patient imaged at a pressure [mmHg], whose volume is seen at rest and in a phase.
fn patient(body: &Body, image: f64, phase: f64) -> Patient<'_> {
    builder(body, image, phase).build().unwrap()
}

fn builder(body: &Body, image: f64, phase: f64) -> PatientBuilder<'_> {
    Patient::of(body)
        .parameters(NAMES)
        .image([("pressure", image * MMHG)])
        .phase("phase", [("pressure", phase * MMHG)])
        .observe(Observable::volume("endo", "rest"))
        .observe(Observable::volume("endo", "phase"))
}

fn volume(body: &Body) -> f64 {
    body.cavity_volumes(&vec![0.0; 3 * body.nodes])[0]
}

#[test]
fn without_pressure_the_image_is_at_rest() {
    let body = body();
    let seen = patient(&body, 0.0, 8.0).observe(&THETA, true).unwrap();
    assert!((seen.values[0] / volume(&body) - 1.0).abs() < 1e-12);
    assert!(seen.values[1] > 1.05 * seen.values[0]);
    // And the body at rest is a phase of its own at no pressure.
    let seen = patient(&body, 8.0, 0.0).observe(&THETA, true).unwrap();
    assert!((seen.values[0] / seen.values[1] - 1.0).abs() < 1e-10, "{:?}", seen.values);
    let slopes = seen.jacobian[0].iter().zip(&seen.jacobian[1]);
    slopes.for_each(|(a, b)| assert!((a - b).abs() < 1e-6 * a.abs(), "{a} {b}"));
}

#[test]
fn suction_is_a_pressure() {
    let body = body();
    let seen = patient(&body, 8.0, -1.0).observe(&THETA, false).unwrap();
    assert!(seen.values[1] < seen.values[0], "{:?}", seen.values);
    let seen = patient(&body, -1.0, 8.0).observe(&THETA, false).unwrap();
    assert!(seen.values[0] > volume(&body), "{:?}", seen.values);
}

/// Whatever comes, it is an answer that holds or an error with a type.
#[test]
fn extremes_end_in_an_answer_or_in_a_type() {
    let body = body();
    let softest = [0.1, 1.0, 1.5, 1.0];
    for (theta, image, phase) in [
        (THETA, 110.0, 8.0),
        (THETA, 8.0, 110.0),
        (softest, 20.0, 8.0),
        (softest, 8.0, 20.0),
        (THETA, 60.0, 8.0),
    ] {
        let patient = patient(&body, image, phase);
        match patient.states(&theta, false) {
            Ok(states) => {
                let seen = patient.see(&states);
                let [rest, phase_volume] = seen.values[..] else { panic!() };
                println!("{image} and {phase} mmHg: {rest:.0} and {phase_volume:.0} mm³");
                assert!(rest > 0.0 && rest < volume(&body));
                assert_eq!(phase_volume > volume(&body), phase > image);
            }
            Err(error) => {
                let typed = matches!(
                    error,
                    StateError::Unload(_) | StateError::Phase { .. } | StateError::Unstable { .. }
                );
                println!("{image} and {phase} mmHg: {error}");
                assert!(typed && !matches!(error, StateError::Unload(UnloadError::Body(_))));
                let told = ForwardError::from(error).reason;
                assert!(told.contains(' ') && !told.contains('{'), "{told}");
            }
        }
    }
}

#[test]
fn theta_that_makes_no_sense_is_refused_with_its_state() {
    let body = body();
    let patient = patient(&body, 8.0, 15.0);
    assert!(matches!(
        patient.states(&[1.0; 3], false),
        Err(StateError::Length { given: 3, needed: 4 })
    ));
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let error = patient.states(&[bad, 2.0, 2.8, 2.1], false).unwrap_err();
        assert!(matches!(&error, StateError::Theta { state, .. } if state == "image"), "{error}");
    }
}

#[test]
fn a_cell_that_is_folded_in_the_image_is_named() {
    let mut mesh = mesh();
    let cell = mesh.cells.len() / 2;
    let [a, b, c, d] = mesh.cells[cell];
    // Through the opposite facet and beyond.
    let middle = |i: usize| (mesh.points[b][i] + mesh.points[c][i] + mesh.points[d][i]) / 3.0;
    mesh.points[a] = std::array::from_fn(|i| 2.0 * middle(i) - mesh.points[a][i]);
    let fibres = vec![[[1.0, 0.0, 0.0]]; mesh.cells.len()];
    let material = HolzapfelOgden.nearly_incompressible(25.0).along(fibres);
    let whole = passive(crate::support::heart::mesh(), 25.0);
    let folded = Scene { mesh: mesh.into(), material, ..whole };
    let error = folded.lower().unwrap_err().to_string();
    assert!(error.contains("has the volume -"), "{error}");
}

/// A fibre has no sense: nodal fibres of mixed sign give what fibres of one sign give.
#[test]
fn signs_of_fibres_change_nothing() {
    let scene = passive(mesh(), 25.0);
    let mut mixed = fibres(&mesh());
    mixed.iter_mut().step_by(3).flatten().flatten().for_each(|x| *x = -*x);
    let material = HolzapfelOgden.nearly_incompressible(25.0).along(mixed);
    let mixed = Scene { material, ..scene.clone() };
    let wall = wall(&mesh());
    let segments = segments(&wall);
    let seen = [scene, mixed].map(|scene| {
        let body = scene.lower().unwrap();
        let patient = builder(&body, 8.0, 15.0);
        let (wall, own) = (Some(&wall), Some(&segments));
        let patient = PatientBuilder { wall, segments: own, ..patient }.observe_strains(
            &segments,
            Direction::Fibre,
            "rest",
            "phase",
        );
        patient.build().unwrap().observe(&THETA, true).unwrap()
    });
    assert_eq!(seen[0].values, seen[1].values);
    assert_eq!(seen[0].jacobian, seen[1].jacobian);
}

/// Asserts the text of an error.
fn says(error: &PatientError, text: &str) {
    assert!(error.to_string().contains(text), "{error}");
}

#[test]
fn names_that_nobody_knows_are_told() {
    let body = body();
    let error = |patient: PatientBuilder<'_>| patient.build().err().expect("an error");
    let base = || builder(&body, 8.0, 15.0);
    let twice = error(base().phase("phase", [("pressure", 1.0)]));
    says(&twice, "`phase` is there twice");
    let taken = error(base().phase("rest", [("pressure", 1.0)]));
    says(&taken, "`rest` is there twice");
    let unknown = error(base().phase("other", [("p", 1.0)]));
    assert!(unknown.to_string().contains("pressure"), "{unknown}");
    let infinite = error(base().phase("other", [("pressure", f64::NAN)]));
    says(&infinite, "`pressure` is NaN in");
    let factor = error(base().phase("other", [("pressure", Setting::from(1.0).times("c"))]));
    says(&factor, "multiplies by `c`, but the parameters of the patient are a, b");
    let unused = error(base().parameters(["a", "b", "a_f", "b_f", "c"]));
    says(&unused, "nothing reads the parameter `c`");
    let unset = error(base().parameters(["a", "b", "a_f"]));
    says(&unset, "`b_f` has no value in");
    let phase = error(base().observe(Observable::volume("endo", "diastole")));
    says(&phase, "there is no phase `diastole`; the states are image, rest, phase");
    let cavity = error(base().observe(Observable::volume("endo_left", "rest")));
    assert!(cavity.to_string().contains("endo"), "{cavity}");
    let none = error(Patient::of(&body).parameters(NAMES).image([("pressure", 1.0)]));
    says(&none, "there is nothing to observe");
    let start = error(PatientBuilder { start: Some(vec![1.0, 2.0]), ..base() });
    says(&start, "the start for `a_f` is");
}

#[test]
fn segments_and_points_that_are_not_there_are_told() {
    let (mesh, body) = (mesh(), body());
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let blind = WallCoordinates::new(&mesh, &surfaces).unwrap();
    says(
        &blind.aha17().unwrap_err(),
        "counts angles from the septum, but its direction is not given",
    );
    let along = blind.clone().with_septum([0.0, 0.01, 3.0]).unwrap_err();
    says(&along, "the direction of the septum is 0.19 degrees off the long axis");
    assert!(blind.clone().with_septum([f64::NAN; 3]).is_err());
    let wall = blind.with_septum([-1.0, 0.0, 0.0]).unwrap();
    assert!(wall.levels(3, 6).is_ok());
    let empty = wall.levels(4, 48).unwrap_err();
    says(&empty, "has no cells of");

    let segments = wall.aha17().unwrap();
    let error = |seen: Observable, segments: Option<&Segments>| {
        let patient = builder(&body, 8.0, 15.0).observe(seen);
        PatientBuilder { segments, ..patient }.build().err().expect("an error")
    };
    let strain = |name: &str, direction| Observable::strain(name, direction, "rest", "phase");
    let missing = error(strain("18", Direction::Fibre), Some(&segments));
    says(&missing, "there is no segment `18`; there are");
    let none = error(strain("1", Direction::Fibre), None);
    says(&none, "strains are averaged over segments");
    let blind = error(strain("1", Direction::Radial), Some(&segments));
    says(&blind, "direction needs coordinates of the wall");
    let other = Segments::new(vec!["all".into()], vec![Some(0); 5]).unwrap();
    let other = error(strain("all", Direction::Fibre), Some(&other));
    says(&other, "are of 5 cells, the body has");

    let far = Observable::displacement([0.0; 3], [1.0, 0.0, 0.0], "image", "phase");
    // Two directions at one point are two data.
    assert_eq!(far.to_string(), "displacement of (0, 0, 0) along (1, 0, 0) from image to phase");
    let far = error(far, None);
    says(&far, "(0, 0, 0) is in no cell of the image; the nearest node is");
    let distance = far.to_string().split_once(" away").and_then(|(before, _)| {
        before.rsplit(' ').next().and_then(|number| number.parse::<f64>().ok())
    });
    assert!(distance.is_some_and(|distance| distance > 10.0), "{far}");
    let nowhere = Observable::displacement(body.positions[0], [0.0; 3], "image", "phase");
    says(&error(nowhere, None), "(0, 0, 0) is no direction");
}

#[test]
fn segments_come_from_fields_of_integers() {
    let mut mesh = mesh();
    let numbers = |last: f64| {
        let number = |cell: usize| if cell == 0 { last } else { (cell % 3) as f64 + 5.0 };
        Field::scalars((0..mesh.cells.len()).map(number).collect())
    };
    let (whole, half) = (numbers(-1.0), numbers(0.5));
    mesh.cell_fields.insert("segment".into(), whole);
    mesh.cell_fields.insert("half".into(), half);
    let mesh = AnyMesh::from(mesh);
    let segments = Segments::by_field(&mesh, "segment").unwrap();
    assert_eq!(segments.names(), ["5", "6", "7"]);
    assert_eq!(segments.of_cell()[..3], [None, Some(1), Some(2)]);
    let half = Segments::by_field(&mesh, "half").unwrap_err();
    assert!(half.to_string().contains("0.5"), "{half}");
    assert!(Segments::by_field(&mesh, "nothing").unwrap_err().to_string().contains("segment"));
}
