//! One organ written in different ways is one organ: units, signs of fibres, order of nodes, orientation.

use sinew::{Case, Options, Solver};
use sinew_mesh::{AnyMesh, Field, FieldValues, TetMesh};
use std::path::Path;

/// A coarse ideal ventricle with its fibres as a field.
fn ventricle() -> TetMesh {
    let text = sinew::scenes::find(Path::new("IdealVentricle")).unwrap().text;
    let text = text.replace("cells = [2, 32, 16]", "cells = [1, 16, 8]");
    let body = Case::parse(&text, "ideal.toml").unwrap().body().unwrap();
    match (*body.mesh).clone() {
        AnyMesh::Tetrahedra(mesh) => mesh,
        other => panic!("{} for tetrahedra", other.element().name),
    }
}

/// A stranger's case: mesh file, Holzapfel-Ogden, fibre field, pressure. Twenty lines.
const STRANGER: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]

[mesh]
file = "organ.vtu"
unit = "mm"

[fibres]
field = "fibre"

[parameters]
p = { range = [4.0, 10.0], unit = "mmHg" }
b_f = [1.0, 4.46]
a_f = [1.5, 5.18]
b = [1.0, 4.2]
a = [0.1, 0.26]
"#;

/// Equilibrium of a mesh in a file of its own \[mm\], and its energy.
fn solve(mesh: &TetMesh, unit: &str) -> (Vec<[f64; 3]>, f64) {
    let folder = tempfile::tempdir().unwrap();
    sinew_mesh::write_vtu(folder.path().join("organ.vtu"), mesh).unwrap();
    let case = folder.path().join("stranger.toml");
    std::fs::write(&case, STRANGER.replace("\"mm\"", &format!("\"{unit}\""))).unwrap();
    let case = Case::read(&case).unwrap();
    assert!(STRANGER.trim().lines().count() <= 25);
    let body = case.body().unwrap();
    // Named in any order, theta is in the law's order, with loads' entries last.
    let names: Vec<_> = body.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "a_f", "b_f", "p"]);
    assert!((body.parameters[4].range[1] - 1.333_22).abs() < 1e-5);
    let solution = Solver::new(&body).unwrap().solve(&body.centre(), &Options::default()).unwrap();
    (solution.displacement.as_chunks::<3>().0.to_vec(), solution.energy)
}

fn largest_difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn units_signs_order_and_orientation_change_nothing() {
    let mesh = ventricle();
    let (reference, energy) = solve(&mesh, "mm");
    let size = reference.as_flattened().iter().fold(0.0f64, |most, u| most.max(u.abs()));
    assert!(size > 1.0, "7 mmHg move a ventricle by more than {size} mm");
    let same = |found: &[[f64; 3]], found_energy: f64| {
        let difference = largest_difference(&reference, found);
        assert!(difference < 1e-8 * size, "{difference:e} of {size}");
        assert!((found_energy - energy).abs() < 1e-9 * energy.abs(), "{found_energy} for {energy}");
    };

    let mut metres = mesh.clone();
    metres.points.iter_mut().for_each(|x| *x = x.map(|x| 1e-3 * x));
    let (found, found_energy) = solve(&metres, "m");
    same(&found, found_energy);

    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().unwrap();
    let mut flipped = mesh.clone();
    let turned: Vec<[f64; 3]> = (0..)
        .zip(&fibres)
        .map(|(cell, fibre)| fibre.map(|x| if cell % 3 == 0 { -x } else { x }))
        .collect();
    flipped.cell_fields.insert("fibre".into(), Field::vectors(&turned));
    let (found, found_energy) = solve(&flipped, "mm");
    same(&found, found_energy);

    // Node i becomes node place[i].
    let count = mesh.points.len();
    let place: Vec<usize> = (0..count).map(|node| (node * 7 + 3) % count).collect();
    assert!(!count.is_multiple_of(7), "the step must reach every node");
    let mut renumbered = mesh.clone();
    (0..count).for_each(|node| renumbered.points[place[node]] = mesh.points[node]);
    renumbered.cells.iter_mut().for_each(|cell| *cell = cell.map(|node| place[node]));
    for nodes in renumbered.node_sets.values_mut() {
        nodes.iter_mut().for_each(|node| *node = place[*node]);
        nodes.sort_unstable();
    }
    let (found, found_energy) = solve(&renumbered, "mm");
    let back: Vec<[f64; 3]> = place.iter().map(|&at| found[at]).collect();
    same(&back, found_energy);

    // A turn about the x axis, of organ and fibres; the pressure turns with them.
    let (sin, cos) = 0.7_f64.sin_cos();
    let turn = |[x, y, z]: [f64; 3]| [x, cos * y - sin * z, sin * y + cos * z];
    let mut rotated = mesh.clone();
    rotated.points.iter_mut().for_each(|x| *x = turn(*x));
    let turned: Vec<[f64; 3]> = fibres.iter().copied().map(turn).collect();
    rotated.cell_fields.insert("fibre".into(), Field::vectors(&turned));
    let (found, found_energy) = solve(&rotated, "mm");
    let expected: Vec<[f64; 3]> = reference.iter().copied().map(turn).collect();
    assert!(largest_difference(&expected, &found) < 1e-8 * size);
    assert!((found_energy - energy).abs() < 1e-9 * energy.abs());
}

#[test]
fn a_scene_takes_another_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("organ.vtu");
    let mut mesh = ventricle();
    let held: Vec<f64> = {
        let base = &mesh.node_sets["base"];
        (0..mesh.points.len()).map(|node| f64::from(u8::from(base.contains(&node)))).collect()
    };
    mesh.point_fields.insert("clamped".into(), Field::scalars(held));
    let endo = mesh.facet_sets["endo"].clone();
    mesh.facet_sets.insert("region:1".into(), endo);
    sinew_mesh::write_vtu(&path, &mesh).unwrap();
    let case = Case::read(Path::new("leftventricle")).unwrap().with_mesh(path);
    let body = case.body().unwrap();
    assert_eq!((body.nodes, body.cavities.len()), (mesh.points.len(), 1));
}

#[test]
fn nodal_fibres_of_mixed_signs_are_told_with_their_number() {
    let case = Case::parse(STRANGER, "stranger.toml").unwrap();
    let told = |mesh: &TetMesh| {
        let body = case.body_on(AnyMesh::Tetrahedra(mesh.clone())).unwrap();
        case.warnings(&body)
    };
    let mut mesh = ventricle();
    assert!(told(&mesh).is_empty(), "fibres of cells have nothing to disagree with");
    mesh.cell_fields.clear();
    let along_x = vec![[1.0, 0.0, 0.0]; mesh.points.len()];
    mesh.point_fields.insert("fibre".into(), Field::vectors(&along_x));
    assert!(told(&mesh).is_empty());
    // One node's fibre turned round: every cell around it.
    let around = mesh.cells.iter().filter(|cell| cell.contains(&5)).count();
    let turned: Vec<_> =
        (0..along_x.len()).map(|n| [if n == 5 { -1.0 } else { 1.0 }, 0.0, 0.0]).collect();
    mesh.point_fields.insert("fibre".into(), Field::vectors(&turned));
    let warnings = told(&mesh);
    assert!(around > 0 && warnings.len() == 1);
    assert!(warnings[0].contains(&format!("in {around} of {} cells", mesh.cells.len())));
}

/// Orthotropic law, springs, tractions and a pressure whose rim slides (`fixtures/chamber/PROVENANCE.md`).
#[test]
fn a_chamber_under_every_load_agrees_with_an_independent_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/chamber");
    let body = Case::read(&folder.join("chamber.toml")).unwrap().body().unwrap();
    let theta = [0.18, 2.6, 3.3, 2.7, 1.0, 2.0, 0.3, 2.5, 1.2];
    let found = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
    let expected = sinew_mesh::read_npy(folder.join("displacement.npy")).unwrap();
    let FieldValues::Float(expected) = expected.values else { panic!("displacements are floats") };
    let [found, expected] = [found.displacement, expected].map(|u| u.as_chunks::<3>().0.to_vec());
    // Newton's method ends at rounding errors of the forces in both programs; the largest displacement is 4.7 mm.
    let difference = largest_difference(&found, &expected);
    println!("{difference:.1e} mm apart");
    assert!(difference < 1e-12);
}
