//! Stored emulators: the body that they belong to.

use crate::to_an_accuracy::Wrong;
use sinew_emulate::{Body, Emulator, Predictor, Record};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Parameter, Scene, Support};
use sinew_mesh::box_tetrahedra;
use std::path::Path;

/// A predictor without files.
fn at_rest(body: &Body) -> Box<dyn Predictor> {
    Box::new(Wrong(vec![0.0; 3 * body.nodes], 1.0))
}

/// Stores an emulator of a body and loads it for another one; the error in words.
fn loaded_for(body: &Body, other: &Body) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    Emulator::new(body, at_rest(body), Record::new("wrong")).save(folder.path()).unwrap();
    let load = |_: &Path, body: &Body| Ok(at_rest(body));
    let loaded = Emulator::load_with(folder.path(), other, &[("wrong", &load)]);
    loaded.map(drop).map_err(|error| error.to_string())
}

fn cube(mu: Parameter) -> Scene {
    Scene::new(box_tetrahedra([1.0; 3], [1; 3]), NeoHookean)
        .parameter(mu)
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .support(Support::clamped("x_min"))
}

#[test]
fn bodies_in_other_units_and_with_parameters_of_another_scale_are_others() {
    let mu = || Parameter::log("mu", "kPa", 1.0..=2.0);
    let body = cube(mu()).lower().unwrap();
    let told = |other: &Body| loaded_for(&body, other).unwrap_err();
    let mut metres = cube(mu());
    metres.units.length = "m".into();
    let metres = told(&metres.lower().unwrap());
    assert!(metres.contains("the units was mm and kPa and is m and kPa"), "{metres}");
    for (other, parameter) in [
        (Parameter::linear("mu", "kPa", 1.0..=2.0), "is mu from 1 to 2 kPa (linear)"),
        (Parameter::log("mu", "Pa", 1.0..=2.0), "Pa (logarithmic)"),
    ] {
        let told = told(&cube(other).lower().unwrap());
        assert!(told.contains("the list of parameters was mu from 1 to 2 kPa (log"), "{told}");
        assert!(told.contains(parameter), "{told}");
    }
    assert_eq!(loaded_for(&body, &body.clone()), Ok(()));
}

#[test]
fn bodies_with_other_known_parameters_are_others() {
    let body = cube(Parameter::log("mu", "kPa", 1.0..=2.0)).lower().unwrap();
    let known = |lambda| body.clone().with_known(&[("lambda", lambda)]).unwrap();
    // Less than the work along a displacement tells.
    let told = loaded_for(&known(1.5), &known(1.5 + 1e-12)).unwrap_err();
    assert!(told.contains("the list of known parameters was"), "{told}");
    assert_eq!(loaded_for(&known(1.5), &known(1.5)), Ok(()));
}
