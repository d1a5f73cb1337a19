//! The two gravity beams against FEniCS and FElupe on the identical mesh (`fixtures/beam/PROVENANCE.md`).

use crate::support::{difference, once, twice};
use sinew_energy::Body;
use sinew_fem::{Options, Solver};
use std::path::Path;

/// Relative in the largest displacement: what is wanted; FEniCS itself is good to 4e-14.
const DISPLACEMENT: f64 = 1e-9;
/// Relative: rounding in the sum over the cells; FEniCS itself is good to 1.4e-13.
const ENERGY: f64 = 1e-12;

fn array(scene: &str, name: &str) -> Vec<f64> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/beam").join(scene);
    let array =
        sinew_mesh::read_npy(folder.join(name)).expect("the fixture is part of the repository");
    match array.values {
        sinew_mesh::FieldValues::Float(values) => values,
        sinew_mesh::FieldValues::Integer(values) => values.iter().map(|&v| v as f64).collect(),
    }
}

fn compare(potential: &Body, scene: &str, prefix: &str, expected: usize) {
    let cells: Vec<_> = potential.cells.iter().map(|&c| c as f64).collect();
    assert_eq!(cells, array(scene, "cells.npy"), "the meshes differ");
    let [thetas, displacements, energies] = ["theta.npy", "displacement.npy", "energy.npy"]
        .map(|name| array(scene, &format!("{prefix}{name}")));
    assert_eq!(energies.len(), expected);
    let mut solver = Solver::new(potential).expect("the beam is held");
    for (row, theta) in thetas.chunks(2).enumerate() {
        let solution =
            solver.solve(theta, &Options::default()).expect("the beam has an equilibrium");
        let size = 3 * potential.nodes;
        let truth = &displacements[row * size..(row + 1) * size];
        let error = difference(&solution.displacement, truth);
        let energy_error = (solution.energy / energies[row] - 1.0).abs();
        println!(
            "{scene} {prefix}{theta:?}: u {error:.1e}, energy {energy_error:.1e}, {} iterations, {:.1} ms",
            solution.iterations(),
            1e3 * solution.seconds
        );
        assert!(error < DISPLACEMENT, "{scene} {theta:?}: {error:e}");
        assert!(energy_error < ENERGY, "{scene} {theta:?}: {energy_error:e}");
        assert!(solution.is_stable());
    }
}

#[test]
fn once_clamped_beam_agrees_with_fenics() {
    compare(&once(), "once", "", 10);
}

#[test]
fn twice_clamped_beam_agrees_with_fenics() {
    compare(&twice(), "twice", "", 10);
}

#[test]
fn both_beams_agree_with_felupe() {
    compare(&once(), "once", "felupe_", 2);
    compare(&twice(), "twice", "felupe_", 2);
}
