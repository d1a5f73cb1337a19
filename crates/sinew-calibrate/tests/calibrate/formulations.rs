//! Derivatives through unloading for every formulation that can be unloaded, and segments of cells other than linear tetrahedra.

use crate::support::heart::{MMHG, ObserveStrains};
use sinew_calibrate::{Observable, Patient, PatientBuilder, Segments};
use sinew_energy::laws::{NeoHookean, NeoHookeanShape};
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_mesh::{AnyMesh, Field, TruncatedEllipsoid, Wall};

fn shape() -> Wall {
    TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 }.wall([1, 8, 4])
}

fn pressed<L: Law<0>>(mesh: impl Into<AnyMesh>, law: L) -> Scene {
    let mut scene = Scene::new(mesh, law);
    for &name in L::PARAMETERS {
        scene = scene.parameter(Parameter::log(name, "kPa", 5.0..=200.0));
    }
    scene.parameter(Parameter::linear("pressure", "kPa", 0.0..=3.0)).load(Load::Pressure {
        facets: "endo".into(),
        magnitude: Magnitude::Theta(L::PARAMETERS.len()),
    })
}

fn seen<'p>(patient: PatientBuilder<'p>, body: &Body) -> PatientBuilder<'p> {
    let names = body.material.parameters().to_vec();
    patient
        .parameters(names)
        .image([("pressure", 8.0 * MMHG)])
        .phase("high", [("pressure", 13.0 * MMHG)])
        .observe(Observable::volume("endo", "rest"))
        .observe(Observable::volume("endo", "image"))
        .observe(Observable::volume("endo", "high"))
}

fn check(name: &str, body: &Body, theta: &[f64]) {
    let patient = seen(Patient::of(body), body).build().unwrap();
    crate::support::slopes::check(name, &patient, theta);
}

#[test]
fn derivatives_are_exact_in_every_formulation() {
    let clamped = || Support::clamped("base");
    let stiff = || NeoHookeanShape.nearly_incompressible(200.0);
    let hexahedra = pressed(shape().hexahedra(), stiff()).support(clamped());
    check("mean-volume hexahedra", &hexahedra.clone().averaged().lower().unwrap(), &[12.0]);
    check("hexahedra", &hexahedra.lower().unwrap(), &[12.0]);
    let quadratic = pressed(shape().quadratic_tetrahedra(), NeoHookean).support(clamped());
    check("quadratic tetrahedra", &quadratic.lower().unwrap(), &[12.0, 40.0]);
    let patches = pressed(shape().tetrahedra(), stiff()).support(clamped());
    check("patches", &patches.clone().averaged().lower().unwrap(), &[12.0]);
}

/// A base that is held by springs alone: the pressure has no potential, and the lid's rim moves.
#[test]
fn a_loose_rim_moves_its_lid() {
    let loose = pressed(shape().tetrahedra(), NeoHookean)
        .load(Load::Foundation { facets: "epi".into(), normal: 0.1, tangential: 0.05 })
        .load(Load::Foundation { facets: "base".into(), normal: 0.2, tangential: 0.1 });
    let balance = loose.loose_rims().lower().unwrap();
    let patient = seen(Patient::of(&balance), &balance).build().unwrap();
    let found = crate::support::slopes::check("a loose rim", &patient, &[14.0, 40.0]);
    assert!(found.values[0] < found.values[1] && found.values[1] < found.values[2]);
}

/// A base that is held by springs alone, with the pressure on its lid too: it has a potential.
#[test]
fn a_lid_under_pressure_moves_with_its_rim() {
    for mesh in [AnyMesh::from(shape().tetrahedra()), shape().quadratic_tetrahedra().into()] {
        let mut scene = pressed(mesh, NeoHookean)
            .load(Load::Foundation { facets: "epi".into(), normal: 0.1, tangential: 0.05 })
            .load(Load::Foundation { facets: "base".into(), normal: 0.2, tangential: 0.1 });
        scene.loads[0] =
            Load::CavityPressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) };
        let body = scene.lower().unwrap();
        assert!(body.has_potential());
        let patient = seen(Patient::of(&body), &body).build().unwrap();
        let found = crate::support::slopes::check("a lid", &patient, &[14.0, 40.0]);
        assert!(found.values[0] < found.values[1] && found.values[1] < found.values[2]);
    }
}

#[test]
fn hexahedra_have_strains_in_segments_of_a_field() {
    let mut mesh = shape().hexahedra();
    let halves = (0..mesh.cells.len()).map(|cell| (cell % 2) as f64).collect();
    mesh.cell_fields.insert("half".into(), Field::scalars(halves));
    let segments = Segments::by_field(&mesh.clone().into(), "half").unwrap();
    let law = sinew_energy::laws::HolzapfelOgden.nearly_incompressible(25.0);
    let fibres = vec![[[0.6, 0.8, 0.0]]; mesh.cells.len()];
    let mut scene = Scene::new(mesh, law.along(fibres));
    for (name, unit) in [("a", "kPa"), ("b", "1"), ("a_f", "kPa"), ("b_f", "1")] {
        scene = scene.parameter(Parameter::log(name, unit, 0.1..=5.0));
    }
    let body = scene
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(1.0) })
        .support(Support::clamped("base"))
        .lower()
        .unwrap();
    let none: [(&str, f64); 0] = [];
    let patient = PatientBuilder { segments: Some(&segments), ..Patient::of(&body) }
        .parameters(["a", "b", "a_f", "b_f"])
        .phase("as in the image", none)
        .observe_strains(&segments, sinew_calibrate::Direction::Fibre, "rest", "image")
        .observe_strains(&segments, sinew_calibrate::Direction::Fibre, "image", "as in the image")
        .build()
        .unwrap();
    let found = crate::support::slopes::check_rows(
        "hexahedra",
        &patient,
        &[2.0, 2.0, 2.0, 2.0],
        2,
        crate::support::slopes::SHORT_STEP,
    );
    // The phase has the loads of the image, so it is the image.
    assert!(found.values[2..].iter().all(|strain| strain.abs() < 1e-10), "{:?}", found.values);
}
