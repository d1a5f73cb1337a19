//! Stresses and strains of cells against closed forms and FElupe.

use crate::support::{once, twice};
use nalgebra::Vector3;
use sinew_energy::laws::{HolzapfelOgden, NeoHookean, NeoHookeanShape};
use sinew_energy::{Body, Law, Parameter, Scene, Support};
use sinew_fem::{CellStress, Options, Solver, cell_stresses};
use sinew_mesh::{AnyMesh, FieldValues, box_hexahedra, box_tetrahedra};
use std::path::Path;

/// Tolerance against closed forms [relative to the largest value].
const CLOSED: f64 = 1e-10;
/// Tolerance against FElupe [relative to the largest value]; both displacements are good to 1e-13.
const FELUPE: f64 = 1e-8;

/// A body of one law that nothing acts on.
fn block<L: Law<D>, const D: usize>(
    mesh: impl Into<AnyMesh>,
    law: L,
    directions: [[f64; 3]; D],
    held: &[(&str, usize)],
) -> Body {
    let mesh = mesh.into();
    let directions = vec![directions; mesh.cell_count()];
    let mut scene = Scene::new(mesh, law.along(directions));
    for name in L::PARAMETERS {
        scene = scene.parameter(Parameter::log(*name, "kPa", 0.01..=100.0));
    }
    for &(set, axis) in held {
        let mut components = [None; 3];
        components[axis] = Some(0.0);
        scene = scene.support(Support::uniform(set, components));
    }
    scene.lower().unwrap()
}

/// Displacement of the homogeneous gradient H.
fn affine(body: &Body, h: [[f64; 3]; 3]) -> Vec<f64> {
    let place = |x: &[f64; 3]| h.map(|row| (0..3).map(|j| row[j] * x[j]).sum::<f64>());
    body.positions.iter().flat_map(place).collect()
}

fn check(what: &str, found: &[f64], exact: &[f64], wanted: f64) {
    let largest = exact.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let error = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    println!("{what}: {error:.1e}");
    assert!(error <= wanted && found.len() == exact.len(), "{what}: {error:e}");
}

fn of_cells<const M: usize>(
    cells: &[CellStress],
    of: impl Fn(&CellStress) -> [f64; M],
) -> Vec<f64> {
    cells.iter().flat_map(of).collect()
}

const BOX: ([f64; 3], [usize; 3]) = ([2.0, 1.0, 1.0], [2, 1, 1]);
const ROLLERS: [(&str, usize); 3] = [("x_min", 0), ("y_min", 1), ("z_min", 2)];

/// Simple shear of every element: σ = μ [[γ², γ, 0], [γ, 0, 0], [0, 0, 0]], E₁₂ = γ/2, E₂₂ = γ²/2.
#[test]
fn simple_shear_in_closed_form() {
    let (mu, lambda, gamma) = (3.0, 7.0, 0.6);
    let bodies = [
        block(box_tetrahedra(BOX.0, BOX.1), NeoHookean, [], &ROLLERS),
        block(box_tetrahedra(BOX.0, BOX.1).quadratic(), NeoHookean, [], &ROLLERS),
        block(box_hexahedra(BOX.0, BOX.1), NeoHookean, [], &ROLLERS),
    ];
    for body in &bodies {
        let mut h = [[0.0; 3]; 3];
        h[0][1] = gamma;
        let found = cell_stresses(body, &affine(body, h), &[mu, lambda]).unwrap();
        let name = body.element().name;
        let root = gamma * (gamma * gamma + 4.0).sqrt();
        let principal = [0.5 * mu * (gamma * gamma + root), 0.0, 0.5 * mu * (gamma * gamma - root)];
        let all = |one: &[f64]| one.repeat(found.len());
        let named = |what: &str| format!("{what} of simple shear, {name}");
        check(
            &named("stresses"),
            &of_cells(&found, |c| c.principal_stresses),
            &all(&principal),
            CLOSED,
        );
        let flat = [mu * gamma * gamma, mu * gamma, 0.0, mu * gamma, 0.0, 0.0, 0.0, 0.0, 0.0];
        let tensor = |t: &[[f64; 3]; 3]| -> [f64; 9] { std::array::from_fn(|i| t[i / 3][i % 3]) };
        check(&named("σ"), &of_cells(&found, |c| tensor(&c.cauchy)), &all(&flat), CLOSED);
        let half = 0.5 * gamma;
        let strain = [0.0, half, 0.0, half, gamma * half, 0.0, 0.0, 0.0, 0.0];
        check(&named("E"), &of_cells(&found, |c| tensor(&c.green_lagrange)), &all(&strain), CLOSED);
        check(&named("J"), &of_cells(&found, |c| [c.volume_ratio]), &all(&[1.0]), CLOSED);
    }
}

/// A bar that is drawn out and free across, solved: the width follows from no stress across, by bisection.
#[test]
fn uniaxial_tension_in_closed_form() {
    let (mu, lambda, stretch) = (3.0, 7.0, 1.4_f64);
    let across = |width: f64| {
        let j = stretch * width * width;
        mu * (width * width - 1.0) + lambda * j.ln()
    };
    let (mut low, mut high) = (0.5, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if across(middle) > 0.0 { high = middle } else { low = middle }
    }
    let j = stretch * low * low;
    let along = (mu * (stretch * stretch - 1.0) + lambda * j.ln()) / j;
    let mesh = box_tetrahedra(BOX.0, BOX.1).quadratic();
    let mut scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
        .support(Support::uniform("x_max", [Some(2.0 * (stretch - 1.0)), None, None]));
    for (set, axis) in ROLLERS {
        let mut components = [None; 3];
        components[axis] = Some(0.0);
        scene = scene.support(Support::uniform(set, components));
    }
    let body = scene.lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[mu, lambda], &Options::default()).unwrap();
    let found = cell_stresses(&body, &solution.displacement, &[mu, lambda]).unwrap();
    let all = |one: &[f64]| one.repeat(found.len());
    let stresses = of_cells(&found, |c| c.principal_stresses);
    check("stresses of uniaxial tension", &stresses, &all(&[along, 0.0, 0.0]), CLOSED);
    let stretches = of_cells(&found, |c| c.principal_stretches);
    check("stretches of uniaxial tension", &stretches, &all(&[stretch, low, low]), CLOSED);
    check("J of uniaxial tension", &of_cells(&found, |c| [c.volume_ratio]), &all(&[j]), CLOSED);
}

/// Tissue drawn out along its fibres at constant volume: σ = dev(a e^{b(I₁−3)} b̂) + 2 a_f (λ²−1) e^{b_f(λ²−1)²} dev(f⊗f).
#[test]
fn a_fibre_in_closed_form() {
    let (theta, stretch) = ([0.2, 2.0, 3.0, 1.5], 1.15_f64);
    let [a, b, a_f, b_f] = theta;
    // Along (3, 4, 0)/5, so that no component is zero by chance.
    let fibre = [0.6, 0.8, 0.0];
    let law = HolzapfelOgden.nearly_incompressible(25.0);
    let body = block(box_tetrahedra(BOX.0, BOX.1), law, [fibre], &ROLLERS);
    let width = 1.0 / stretch.sqrt();
    let h = |i: usize, j: usize| {
        (stretch - width) * fibre[i] * fibre[j] + if i == j { width - 1.0 } else { 0.0 }
    };
    let h = std::array::from_fn(|i| std::array::from_fn(|j| h(i, j)));
    let found = cell_stresses(&body, &affine(&body, h), &theta).unwrap();
    let (square, trace) = (stretch * stretch, stretch * stretch + 2.0 / stretch);
    let ground = a * (b * (trace - 3.0)).exp();
    let along = 2.0 * a_f * (square - 1.0) * (b_f * (square - 1.0).powi(2)).exp() * square;
    let exact = ground * (square - trace / 3.0) + along * 2.0 / 3.0;
    let fibres = of_cells(&found, |c| {
        let fibre = c.fibre.unwrap();
        [fibre.stretch, fibre.stress]
    });
    check("a fibre", &fibres, &[stretch, exact].repeat(found.len()), CLOSED);
    let directions = of_cells(&found, |c| c.fibre.unwrap().direction);
    check("its direction", &directions, &fibre.repeat(found.len()), CLOSED);
}

#[test]
fn volumes_of_averaged_cells_are_their_own() {
    let scene = Scene::new(box_tetrahedra([2.0; 3], [2; 3]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 0.01..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 0.01..=100.0));
    let body = scene.averaged().support(Support::clamped("x_min")).lower().unwrap();
    let bent = |&[x, y, z]: &[f64; 3]| [0.1 * x * y, 0.1 * x * z, -0.1 * x * x];
    let displacement: Vec<f64> = body.positions.iter().flat_map(bent).collect();
    let place =
        |node: usize| Vector3::from_fn(|i, _| body.positions[node][i] + displacement[3 * node + i]);
    let found = cell_stresses(&body, &displacement, &[1.0, 1.0]).unwrap();
    let mut apart: f64 = 0.0;
    for (cell, nodes) in found.iter().zip(body.cell_nodes()) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| place(nodes[k]));
        let volume = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
        assert!((cell.volume / volume - 1.0).abs() < 1e-12);
        apart = apart.max((cell.volume_ratio * (1.0 / 6.0) / volume - 1.0).abs());
    }
    // The law has the ratio of a patch.
    assert!(apart > 0.01, "{apart}");
}

/// An incompressible sphere that is inflated, r³ = R³ + c: stresses from the deformation gradient at points of the wall, and the pressure
/// that they balance, p = ∫ 2(σ_θ − σ_r)/r dr = μ [1/(2λ⁴) + 2/λ] from the inner to the outer surface, λ = r/R.
#[test]
fn an_inflated_sphere_in_closed_form() {
    let (mu, inner, outer, c) = (3.0, 1.0, 2.0, 1.5_f64);
    // Changes of volume cost nothing at J = 1.
    let body = block(
        box_tetrahedra([1.0; 3], [1, 1, 1]),
        NeoHookeanShape.nearly_incompressible(9.0),
        [],
        &ROLLERS,
    );
    let place = |radius: f64| (radius.powi(3) + c).cbrt();
    let difference = |radius: f64| {
        let hoop = place(radius) / radius;
        let radial = 1.0 / (hoop * hoop);
        // The radius is along (1, 2, 2)/3.
        let n = [1.0, 2.0, 2.0].map(|x| x / 3.0);
        let h = |i: usize, j: usize| {
            (radial - hoop) * n[i] * n[j] + if i == j { hoop - 1.0 } else { 0.0 }
        };
        let h = std::array::from_fn(|i| std::array::from_fn(|j| h(i, j)));
        let found = &cell_stresses(&body, &affine(&body, h), &[mu]).unwrap()[0];
        let exact = mu * (hoop * hoop - radial * radial);
        let [first, second, third] = found.principal_stresses;
        check("hoop stresses", &[first - third, second - third], &[exact; 2], CLOSED);
        first - third
    };
    // Simpson's rule over r; its error falls with the fourth power of the step.
    let (from, to, steps) = (place(inner), place(outer), 2000);
    let step = (to - from) / f64::from(steps);
    let sum: f64 = (0..=steps)
        .map(|k| {
            let r = from + step * f64::from(k);
            let weight = if k == 0 || k == steps { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
            weight * 2.0 * difference((r.powi(3) - c).cbrt()) / r
        })
        .sum();
    let end = |radius: f64| {
        let hoop = place(radius) / radius;
        mu * (0.5 / hoop.powi(4) + 2.0 / hoop)
    };
    check("pressure", &[sum * step / 3.0], &[end(outer) - end(inner)], CLOSED);
}

fn stored(scene: &str, name: &str) -> Vec<f64> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/beam").join(scene);
    match sinew_mesh::read_npy(folder.join(name)).expect("part of the repository").values {
        FieldValues::Float(values) => values,
        FieldValues::Integer(values) => values.iter().map(|&v| v as f64).collect(),
    }
}

#[test]
fn principal_stresses_of_the_beams_agree_with_felupe() {
    for (body, scene) in [(once(), "once"), (twice(), "twice")] {
        let thetas = stored(scene, "felupe_theta.npy");
        let truth = stored(scene, "felupe_principal_stresses.npy");
        let size = 3 * body.cell_count();
        assert_eq!(truth.len(), thetas.len() / 2 * size);
        let mut solver = Solver::new(&body).unwrap();
        for (theta, truth) in thetas.chunks(2).zip(truth.chunks(size)) {
            let solution = solver.solve(theta, &Options::default()).unwrap();
            let found = cell_stresses(&body, &solution.displacement, theta).unwrap();
            let stresses = of_cells(&found, |cell| cell.principal_stresses);
            check(&format!("{scene} {theta:?} against FElupe"), &stresses, truth, FELUPE);
        }
    }
}
