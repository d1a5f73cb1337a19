//! The directions in which simulations differ as coordinates of the displacement.

mod common;

use common::*;
use sinew_gnn::*;

/// Directions that mix all degrees of freedom.
fn mixing_directions(size: usize) -> PrincipalDirections {
    let wave = |k: usize| (0..size).map(move |i| ((k * i) as f64 + 0.3).sin()).collect();
    let fields: Vec<Vec<f64>> = (1..6).map(wave).collect();
    PrincipalDirections::of(fields.iter().map(Vec::as_slice), 0.7).unwrap()
}

#[test]
fn supports_sensitivities_and_storage_hold_in_any_directions() {
    let (_, mut data) = plane_data();
    for geometry in &mut data.geometries {
        geometry.coordinates =
            Coordinates::Principal(mixing_directions(geometry.dirichlet.prescribed.len()));
    }
    let config = small_config(&data, 2);
    let folder = tempfile::tempdir().unwrap();
    for device in devices() {
        let surrogate = briefly_trained(&data, &config, &device);
        let geometry = &data.geometries[1];
        let fixed = surrogate.fixed_geometry(geometry).unwrap();
        let base = [vec![0.8, 1.3]];
        let exact = fixed.sensitivity(&base).unwrap();
        let u = &exact.prediction.displacement;
        for (dof, prescribed) in geometry.dirichlet.prescribed.iter().enumerate() {
            if let Some(value) = prescribed {
                assert_eq!(u[dof], *value);
                assert_eq!(exact.derivative[dof], 0.0);
            }
        }
        let moved = |by: f64| fixed.predict(&[vec![0.8 + by, 1.3]]).unwrap().displacement;
        let step = 5e-3; // single precision: rounding and truncation both stay near 1e-4
        let (ahead, behind) = (moved(step), moved(-step));
        let finite: Vec<f64> =
            ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        let difference = relative_difference(&exact.derivative[..u.len()], &finite);
        assert!(difference < 5e-3, "{difference:e}");

        surrogate.save(&folder.path().join("surrogate")).unwrap();
        let read = Surrogate::load(&folder.path().join("surrogate"), &device).unwrap();
        assert_eq!(read.geometries(), surrogate.geometries());
        let (again, before) = (read.predict(geometry, &base), fixed.predict(&base));
        assert_eq!(again.unwrap(), before.unwrap());
    }
}

#[test]
fn directions_of_another_body_are_refused() {
    let (_, mut data) = plane_data();
    data.geometries[0].coordinates = Coordinates::Principal(mixing_directions(4));
    assert!(matches!(data.check(2), Err(Error::Count { .. })));
}
