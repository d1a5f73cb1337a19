//! Coordinates of the displacement other than one scale per component.

mod common;

use common::*;
use sinew_gnn::*;

/// Rounding of single precision through a few training steps of a small network.
const ROUNDING: f64 = 1e-4;

/// A symmetric map that mixes all degrees of freedom, and an origin.
fn mixing_basis(size: usize) -> OutputBasis {
    let entry = |i: usize, j: usize| {
        let near = (-0.5 * (i as f64 - j as f64).abs()).exp();
        0.3 * near + if i == j { 1.0 } else { 0.0 }
    };
    let map: Vec<f64> = (0..size * size).map(|at| entry(at / size, at % size)).collect();
    OutputBasis::new((0..size).map(|i| 0.01 * i as f64).collect(), &map).unwrap()
}

#[test]
fn a_diagonal_basis_is_one_scale_per_component() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    for device in devices() {
        let plain = briefly_trained(&data, &config, &device);
        let scale = &plain.scales().output;
        let mut based = data.clone();
        for geometry in &mut based.geometries {
            let size = geometry.dirichlet.prescribed.len();
            let origin = (0..size).map(|dof| scale.mean[dof % 2]).collect();
            let mut map = vec![0.0; size * size];
            (0..size).for_each(|dof| map[dof * size + dof] = scale.scale[dof % 2]);
            geometry.coordinates = Coordinates::Basis(OutputBasis::new(origin, &map).unwrap());
        }
        let other = briefly_trained(&based, &config, &device);
        let thetas = [vec![0.8, 1.3], vec![1.7, 0.6]];
        let a = plain.predict(&data.geometries[0], &thetas).unwrap();
        let b = other.predict(&based.geometries[0], &thetas).unwrap();
        let difference = relative_difference(&a.displacement, &b.displacement);
        assert!(difference < ROUNDING, "{difference:e}");
    }
}

#[test]
fn supports_sensitivities_and_storage_hold_in_any_basis() {
    let (_, mut data) = plane_data();
    for geometry in &mut data.geometries {
        geometry.coordinates =
            Coordinates::Basis(mixing_basis(geometry.dirichlet.prescribed.len()));
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
fn a_basis_of_another_body_is_refused() {
    let (_, mut data) = plane_data();
    data.geometries[0].coordinates = Coordinates::Basis(mixing_basis(4));
    assert!(matches!(data.check(2), Err(Error::Count { .. })));
}
