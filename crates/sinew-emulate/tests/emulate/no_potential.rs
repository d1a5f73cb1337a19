//! Bodies without a potential, which emulators refuse.

use sinew_emulate::{
    Emulator, Error, Train, TrainingOptions, recipe::Regression, recipe::Taylor, simulate,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{FrozenStiffness, SolveError};

#[test]
fn a_pressure_with_a_loose_rim_is_refused_by_every_door() {
    let scene = Scene::new(sinew_mesh::box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .support(Support::clamped("x_min"));
    let held = scene.clone().lower().unwrap();
    let pressure = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.01) };
    let body = scene.load(pressure).loose_rims().lower().unwrap();
    let refused = |found: Result<(), Error>| {
        let error = found.expect_err("no potential");
        assert!(matches!(error, Error::Solve(SolveError::NoPotential)), "{error}");
        assert!(error.to_string().contains("loose rim have no potential"), "{error}");
    };
    refused(Emulator::taylor(&body, 1).map(drop));
    assert!(matches!(FrozenStiffness::new(&body), Err(SolveError::NoPotential)));
    let known = FrozenStiffness::new(&held).unwrap();
    refused(Emulator::frozen_stiffness(&body, &known).map(drop));
    // It is solved, but not stored.
    let folder = tempfile::tempdir().unwrap();
    let simulated = |folder| simulate(&body, &[body.centre()], "solve", folder, &mut ());
    refused(simulated(Some(folder.path())).map(drop));
    assert_eq!(simulated(None).unwrap().fields.len(), 1);
    let options = TrainingOptions::default();
    refused(Regression::default().train(&body, &options, &mut ()).map(drop));
    refused(Taylor.train(&body, &options, &mut ()).map(drop));
}
