//! The thesis' gravity beams: node by node on its meshes, and from linear to quadratic elements.

use crate::program;
use crate::verify::case::{Band, Case, Cost, Effort, Formulation, Label, Rows};
use crate::verify::cases::boxes::{Boxes, box_mesh, boxes};
use crate::verify::reference::published;
use crate::verify::solve::{displaced, equilibrium, lower, scene};
use anyhow::{Context, Result, ensure};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Scene, Support};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// Relative to the largest displacement; FEniCS itself is good to 4e-14.
const DISPLACEMENT: Band = Band::below(1e-9);
/// Relative; FEniCS itself is good to 1.4e-13.
const ENERGY: Band = Band::below(1e-12);
/// Relative; the printed energy has nine digits.
const PRINTED_ENERGY: Band = Band::below(1e-8);
/// Tissue of 1 g/cm³ \[kPa/mm\].
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.8e-3];

/// Nodal displacements and energies of independent solvers (`fixtures/beam/PROVENANCE.md`).
pub(super) const CASE: Case = Case {
    name: "beam-fixture",
    title: "The thesis' gravity beams on the thesis' meshes, node by node",
    provenance: "FEniCS 2019.2 (ten θ per beam) and FElupe 11.3 (two), fixtures/beam; the energy of quadratic elements by \
         FEniCS with quadrature of degree 2.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for beam in [once([12, 4, 5]), twice()] {
        compare(rows, effort, &beam, "FEniCS", "")?;
        compare(rows, effort, &beam, "FElupe", "felupe_")?;
    }
    let theta = [75.0, 75.0];
    let Scene { loads, supports, .. } = once([12, 4, 5]);
    let mesh = box_tetrahedra(ONCE, [12, 4, 5]).quadratic();
    let quadratic = scene(mesh, NeoHookean, &theta, loads, supports);
    let (solution, cost) = equilibrium(&quadratic.lower()?, &theta)?;
    let label = Label::new(Formulation::P2, "once, FEniCS", "energy [kPa mm³]");
    let energies = [solution.energy, published::BEAM_ENERGY_DEGREE_2];
    rows.relative(label, energies, PRINTED_ENERGY, cost)
}

/// Size of OnceClampedBeam \[mm\].
const ONCE: [f64; 3] = [100.0, 10.0, 10.0];

/// OnceClampedBeam on a grid of boxes.
fn once(cells: [usize; 3]) -> Scene {
    beam("once", box_tetrahedra(ONCE, cells), &["x_min"])
}

/// TwiceClampedBeam on the thesis' mesh.
fn twice() -> Scene {
    beam("twice", box_tetrahedra([150.0, 10.0, 2.0], [12, 4, 5]), &["x_min", "x_max"])
}

fn beam(name: &str, mesh: TetMesh, clamped: &[&str]) -> Scene {
    let supports = clamped.iter().map(|side| Support::clamped(*side)).collect();
    let scene = scene(mesh, NeoHookean, &[75.0, 75.0], vec![Load::BodyForce(GRAVITY)], supports);
    Scene { name: name.into(), ..scene }
}

/// The worst displacement and the worst energy over all θ of one program.
fn compare(
    rows: &mut Rows,
    effort: Effort,
    beam: &Scene,
    program: &str,
    prefix: &str,
) -> Result<()> {
    let array = |name: &str| read(&beam.name, &format!("{prefix}{name}"));
    let potential = lower(beam, Formulation::P1)?;
    let cells: Vec<_> = potential.cells.iter().map(|&c| c as f64).collect();
    ensure!(cells == read(&beam.name, "cells.npy")?, "the meshes of {} differ", beam.name);
    let (thetas, truths, energies) =
        (array("theta.npy")?, array("displacement.npy")?, array("energy.npy")?);
    let size = 3 * potential.nodes;
    ensure!(
        thetas.len() == 2 * energies.len() && truths.len() == size * energies.len(),
        "the fixtures of {} do not fit each other",
        beam.name
    );
    let all: Vec<usize> = (0..energies.len()).collect();
    let (mut displacements, mut energies_found) = (Vec::new(), Vec::new());
    for &index in effort.levels(4, &all) {
        let (solution, cost) = equilibrium(&potential, &thetas[2 * index..2 * index + 2])?;
        let truth = &truths[size * index..size * (index + 1)];
        let error = relative_difference(&solution.displacement, truth);
        displacements.push((error, [error, 0.0], cost));
        let pair = [solution.energy, energies[index]];
        energies_found.push(((pair[0] / pair[1] - 1.0).abs(), pair, cost));
    }
    let label = |quantity: &str| {
        let setup = format!("{}, {program}, worst of {}", beam.name, effort.levels(4, &all).len());
        Label::new(Formulation::P1, setup, quantity)
    };
    let (_, pair, cost) = worst(&displacements)?;
    rows.absolute(label("difference of u over largest u"), pair, DISPLACEMENT, cost)?;
    let (_, pair, cost) = worst(&energies_found)?;
    rows.relative(label("energy [kPa mm³]"), pair, ENERGY, cost)
}

/// Error, values and cost of a θ.
type Compared = (f64, [f64; 2], Cost);

/// The largest error, the first of equal ones.
fn worst(all: &[Compared]) -> Result<Compared> {
    let worst = all.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0));
    worst.copied().context("the fixture holds no θ")
}

fn read(beam: &str, name: &str) -> Result<Vec<f64>> {
    program::fixture(&format!("beam/{beam}/{name}"))
}

/// Largest difference over the largest entry of `truth`.
fn relative_difference(found: &[f64], truth: &[f64]) -> f64 {
    let largest = truth.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let off = found.iter().zip(truth).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs()));
    off / largest
}

const THETA: [f64; 2] = [75.0, 75.0];
/// Middle of the free end \[mm\].
const TIP: [f64; 3] = [100.0, 5.0, 5.0];

const LINEAR: &Boxes = &[
    ([12, 4, 5], Band::between(0.33, 0.39)),
    ([24, 8, 10], Band::between(0.10, 0.14)),
    ([36, 12, 15], Band::between(0.045, 0.07)),
];
/// 0.4 % is wanted on the thesis' cells.
const QUADRATIC: &Boxes = &[
    ([6, 2, 2], Band::below(0.04)),
    ([12, 4, 5], Band::below(0.004)),
    ([24, 8, 10], Band::below(0.001)),
];
/// Averaging the volume ratio cures no locking in bending.
const PATCHES: &Boxes = &[
    ([12, 4, 5], Band::between(0.30, 0.37)),
    ([24, 8, 10], Band::between(0.09, 0.13)),
    ([36, 12, 15], Band::between(0.04, 0.065)),
];
const HEXAHEDRA: &Boxes = &[
    ([12, 4, 4], Band::between(0.12, 0.17)),
    ([24, 8, 8], Band::between(0.03, 0.05)),
    ([36, 12, 12], Band::between(0.014, 0.023)),
];
const HEXAHEDRA_AVERAGED: &Boxes = &[
    ([12, 4, 4], Band::between(0.11, 0.16)),
    ([24, 8, 8], Band::between(0.028, 0.045)),
    ([36, 12, 12], Band::between(0.012, 0.02)),
];

/// The deflection of the thesis' first beam at μ = λ = 75 kPa, which its linear tetrahedra miss by a third.
pub(super) const CONTINUUM: Case = Case {
    name: "beam",
    title: "OnceClampedBeam at μ = λ = 75 kPa: tip deflection against the continuum",
    provenance: "FEniCS, quadratic tetrahedra on 12×4×5 and 24×8×10 boxes, Richardson extrapolation: −57.36 ± 0.02 mm. Bands \
         of linear elements state how much they lock in bending.",
    run: run_continuum,
};

fn run_continuum(effort: Effort, rows: &mut Rows) -> Result<()> {
    for (formulation, quick, ladder) in [
        (Formulation::P1, 2, LINEAR),
        (Formulation::FBar, 2, PATCHES),
        (Formulation::P2, 2, QUADRATIC),
        (Formulation::Q1, 1, HEXAHEDRA),
        (Formulation::Q1FBar, 1, HEXAHEDRA_AVERAGED),
    ] {
        for &(cells, band) in effort.levels(quick, ladder) {
            let mesh = box_mesh([100.0, 10.0, 10.0], cells, formulation);
            let (loads, held) = (vec![Load::BodyForce(GRAVITY)], vec![Support::clamped("x_min")]);
            let beam = scene(mesh, NeoHookean, &THETA, loads, held);
            let found = displaced(beam, formulation, &THETA)?;
            let label = Label::new(formulation, boxes(cells), "deflection of the tip [mm]");
            rows.relative(label, [found.at(TIP)[2], published::BEAM_TIP], band, found.cost)?;
        }
    }
    Ok(())
}
