//! Fields of an independent program (`fixtures/beam/PROVENANCE.md`) read by our energy alone: no solver between.

use sinew::Case;
use sinew_energy::Barriers;
use sinew_mesh::{FieldValues, TetMesh, read_npy};
use std::path::{Path, PathBuf};

/// Relative: rounding in the sum over 1440 cells; the fields themselves are good to 1.4e-13 in Π.
const ENERGY: f64 = 1e-12;
/// Nodal forces relative to the weight: rounding in single cells, 7e-11 by the fixtures' own account.
const RESIDUAL: f64 = 1e-9;

fn array(scene: &str, name: &str) -> (Vec<usize>, FieldValues) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/beam").join(scene);
    let array = read_npy(folder.join(name)).expect("the fixture is part of the repository");
    (array.shape, array.values)
}

fn floats(scene: &str, name: &str) -> Vec<f64> {
    let (shape, FieldValues::Float(values)) = array(scene, name) else {
        panic!("{scene}/{name} does not hold floating-point numbers")
    };
    assert_eq!(values.len(), shape.iter().product::<usize>());
    values
}

/// The mesh as the other program stored it.
fn stored_mesh(scene: &str) -> TetMesh {
    let (_, FieldValues::Integer(cells)) = array(scene, "cells.npy") else {
        panic!("{scene}/cells.npy does not hold integers")
    };
    let cells = cells.as_chunks().0.iter().map(|c| c.map(|i| i as usize)).collect();
    TetMesh::new(floats(scene, "points.npy").as_chunks().0.to_vec(), cells).unwrap()
}

fn check(name: &str, scene: &str) {
    let potential = Case::read(Path::new(scene)).unwrap().body().unwrap();
    let stored = stored_mesh(name);
    assert_eq!(potential.cells, stored.cells.as_flattened());
    let farthest = (potential.positions.iter().flatten())
        .zip(stored.points.iter().flatten())
        .fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(farthest < 1e-12, "nodes differ by {farthest} mm");

    let guarded = potential.clone().with_barriers(Barriers::default());
    let weight = potential.nodal_force.iter().sum::<f64>().abs();
    let (fields, energies) = (floats(name, "displacement.npy"), floats(name, "energy.npy"));
    let thetas = floats(name, "theta.npy");
    let mut gradient = vec![0.0; 3 * potential.nodes];
    assert_eq!(energies.len(), 10);
    for ((theta, u), energy) in thetas.chunks(2).zip(fields.chunks(gradient.len())).zip(energies) {
        let relative = (potential.value(u, theta) / energy - 1.0).abs();
        assert!(relative < ENERGY, "{name} {theta:?}: {relative:e}");
        // The barriers of training leave admissible states alone, and the fields are in balance.
        assert_eq!(guarded.value_and_gradient(u, theta, &mut gradient), {
            let mut exact = gradient.clone();
            potential.value_and_gradient(u, theta, &mut exact)
        });
        let free = potential.free_degrees_of_freedom();
        let residual = free.iter().fold(0.0f64, |most, &i| most.max(gradient[i].abs())) / weight;
        assert!(residual < RESIDUAL, "{name} {theta:?}: {residual:e}");
    }
}

#[test]
fn once_clamped_beam() {
    check("once", "OnceClampedBeam");
}

#[test]
fn twice_clamped_beam() {
    check("twice", "TwiceClampedBeam");
}
