//! The directions in which simulations differ as coordinates of the displacement.

use crate::common::*;
use sinew_emulate::coordinates::*;
use sinew_gnn::*;

/// Directions that mix all degrees of freedom, about displacements that follow two parameters.
fn mixing_directions(size: usize) -> PrincipalDirections {
    let wave = |k: usize, i: usize| ((k * i) as f64 + 0.3).sin();
    let parameters: Vec<Vec<f64>> =
        (1..21).map(|k| vec![(1.3 * k as f64).sin(), (2.1 * k as f64).cos()]).collect();
    let field = |(k, p): (usize, &Vec<f64>)| -> Vec<f64> {
        let at = |i| wave(1, i) + p[0] * wave(2, i) + p[0] * p[1] * wave(3, i) + 0.1 * wave(k, i);
        (0..size).map(at).collect()
    };
    let fields: Vec<Vec<f64>> = parameters.iter().enumerate().map(field).collect();
    let fields = fields.iter().map(Vec::as_slice);
    let directions = PrincipalDirections::about_trend(fields, &parameters, 0.7).unwrap();
    assert!(!directions.slopes().is_empty());
    directions
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
        let exact = fixed.sensitivity(&base[0]).unwrap();
        let u = &fixed.predict(&base).unwrap()[0];
        for (dof, prescribed) in geometry.dirichlet.prescribed.iter().enumerate() {
            if let Some(value) = prescribed {
                assert_eq!(u[dof], *value);
                assert_eq!(exact[0][dof], 0.0);
            }
        }
        let moved = |by: f64| fixed.predict(&[vec![0.8 + by, 1.3]]).unwrap().concat();
        let step = 5e-3; // single precision: rounding and truncation both stay near 1e-4
        let (ahead, behind) = (moved(step), moved(-step));
        let finite: Vec<f64> =
            ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect();
        let difference = relative_difference(&exact[0], &finite);
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
    assert!(matches!(data.check(2), Err(Error::Coordinates(CoordinateError::Count { .. }))));
}

#[test]
fn the_expansion_is_there_before_any_training() {
    // Displacements of second order in the parameters, and nothing beyond them.
    let parameters: Vec<Vec<f64>> =
        (0..20).map(|k| vec![(1.3 * k as f64).sin(), (2.1 * k as f64).cos()]).collect();
    let (_, mut data) = plane_data();
    data.geometries.truncate(1);
    data.training.retain(|sample| sample.geometry == 0);
    data.validation.clear();
    let size = data.geometries[0].dirichlet.prescribed.len();
    let field = |p: &[f64]| -> Vec<f64> {
        (0..size).map(|i| 1.0 + i as f64 * p[0] - p[1] + 0.3 * p[0] * p[1]).collect()
    };
    let fields: Vec<Vec<f64>> = parameters.iter().map(|p| field(p)).collect();
    let directions =
        PrincipalDirections::about_trend(fields.iter().map(Vec::as_slice), &parameters, 0.7)
            .unwrap();
    data.geometries[0].coordinates = Coordinates::Principal(directions);
    let config = small_config(&data, 2);
    let surrogate = untrained(&data, &config, 7, &devices()[0]);
    let theta = vec![0.8, 1.3];
    let standardised = surrogate.scales().parameters.standardise(&theta).unwrap();
    let found = surrogate.predict(&data.geometries[0], &[theta]).unwrap().concat();
    let expected = field(&standardised);
    for (dof, prescribed) in data.geometries[0].dirichlet.prescribed.iter().enumerate() {
        let expected = prescribed.unwrap_or(expected[dof]);
        // Single precision, at values of the size of the field.
        assert!((found[dof] - expected).abs() < 1e-6 * size as f64, "{} {expected}", found[dof]);
    }
    assert!(PrincipalDirections::about_trend([&[1.0][..], &[2.0]], &parameters, 0.7).is_err());
}
