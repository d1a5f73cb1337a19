//! Active stress, fields of stiffness, mixed elements and loose follower pressures in case files.

use sinew::{Body, Case, Options, Solver};
use std::path::Path;
use std::process::{Command, Output};

/// A bar of muscle with fibres along it.
const MUSCLE: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
active = true
supports = [{ nodes = "x_min", x = 0.0 }, { nodes = "y_min", y = 0.0 }, { nodes = "z_min", z = 0.0 }]
mesh.box = { extent = [20.0, 4.0, 4.0], cells = [8, 2, 2] }
fibres.direction = [1.0, 0.0, 0.0]
[parameters]
a = [0.1, 0.3]
b = [1.0, 4.0]
a_f = [1.5, 5.0]
b_f = [1.0, 4.0]
T_a = { range = [0.0, 20.0], sampling = "linear" }
"#;

pub(crate) fn case(text: &str) -> Case {
    Case::parse(text, "muscle.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn body(text: &str) -> Body {
    case(text).body().unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn refusal(text: &str, words: &[&str]) {
    let refused = Case::parse(text, "muscle.toml").and_then(|case| case.body());
    let told = refused.expect_err("a mistake").to_string();
    for word in words {
        assert!(told.contains(word), "{word:?} is not in: {told}");
    }
}

fn uniform(body: &Body, [x, y, z]: [f64; 3]) -> Vec<f64> {
    body.positions.iter().flat_map(|at| [x * at[0], y * at[1], z * at[2]]).collect()
}

#[test]
fn a_pressure_that_is_no_number_is_not_taken_for_a_name() {
    for pressure in ["1 000 Pa", "8.5.1 mmHg", "-", ""] {
        let load = format!("loads = [{{ pressure = \"{pressure}\", facets = \"x_max\" }}]\n");
        refusal(&format!("{load}{MUSCLE}"), &["loads.0.pressure", "is not a number with a unit"]);
    }
}

#[test]
fn an_active_bar_contracts_as_its_closed_form_says() {
    let body = body(MUSCLE);
    let names: Vec<_> = body.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["a", "b", "a_f", "b_f", "T_a"]);
    let theta = [0.2, 2.0, 3.0, 2.0, 5.0];
    let mut solver = Solver::new(&body).unwrap();
    // It shortens freely until nothing is stressed, so that there is neither load nor reaction to compare with.
    let solution = solver.solve(&theta, &Options::default()).unwrap();
    let end = body.mesh.node_sets()["x_max"][0];
    let shortening = solution.displacement[3 * end] / 20.0;
    assert!(shortening < -0.1, "{shortening}");
    let stress = sinew_fem::cell_stresses(&body, &solution.displacement, &theta).unwrap();
    let largest = stress.iter().flat_map(|cell| cell.principal_stresses).map(f64::abs);
    // Relative to the tension.
    assert!(largest.fold(0.0, f64::max) < 1e-8 * theta[4]);
    // Pulled back to its length it is stressed by T_a along it and not at all across, without a change of shape.
    let supports = "supports = [{ nodes = \"x_max\", x = 0.0 }, ";
    let held = crate::keys::body(&MUSCLE.replace("supports = [", supports));
    let solution = Solver::new(&held).unwrap().solve(&theta, &Options::default()).unwrap();
    for cell in sinew_fem::cell_stresses(&held, &solution.displacement, &theta).unwrap() {
        let [along, across, _] = cell.principal_stresses;
        assert!((along - 5.0).abs() < 1e-10 && across.abs() < 1e-10, "{along} {across}");
    }
    // ½ T_a (λ² − 1) is what the tension adds.
    let stretched = uniform(&body, [0.1, 0.0, 0.0]);
    let added = body.value(&stretched, &theta) - body.value(&stretched, &[0.2, 2.0, 3.0, 2.0, 0.0]);
    let exact = 20.0 * 4.0 * 4.0 * 0.5 * 5.0 * (1.1f64 * 1.1 - 1.0);
    assert!((added / exact - 1.0).abs() < 1e-12, "{added} {exact}");
}

#[test]
fn a_scar_is_stiffer_and_need_not_contract() {
    let select = "\n[select.scar]\nbox = { min = [-1.0, -1.0, -1.0], max = [10.0, 9.0, 9.0] }\n";
    let with = |keys: &str| body(&(MUSCLE.replace("active = true", keys) + select));
    let (theta, passive) = ([0.2, 2.0, 3.0, 2.0, 5.0], [0.2, 2.0, 3.0, 2.0, 0.0]);
    let stiffness = "stiffness = { nodes = \"scar\", factor = 10.0 }";
    let plain = body(MUSCLE);
    let stretched = uniform(&plain, [0.1, 0.01, 0.0]);
    let energy = |body: &Body, theta: &[f64; 5]| body.value(&stretched, theta);
    let (alone, both) =
        (energy(&plain, &passive), energy(&plain, &theta) - energy(&plain, &passive));
    // Half of the bar is ten times as stiff, and the cells beside it by the share of their nodes within: 8 cells along, of six
    // tetrahedra each with 1, 2 or 3 of 4 corners at x = 10, on average 2 of 4.
    let scar = with(&format!("active = true\n{stiffness}"));
    let expected = alone * (0.5 * 10.0 + 0.125 * 0.5 * (10.0 + 1.0) + 0.375);
    assert!((energy(&scar, &passive) / expected - 1.0).abs() < 1e-12);
    // The tension is the same everywhere.
    let tension = energy(&scar, &theta) - energy(&scar, &passive);
    assert!((tension / both - 1.0).abs() < 1e-12, "{tension} {both}");
    // And by a factor of its own it is not.
    let dead = with(&format!("active = {{ nodes = \"scar\", factor = 0.0 }}\n{stiffness}"));
    let tension = energy(&dead, &theta) - energy(&dead, &passive);
    let expected = both * (0.125 * 0.5 + 0.375);
    assert!((tension / expected - 1.0).abs() < 1e-12, "{tension} {expected}");
    assert_eq!(energy(&dead, &passive), energy(&scar, &passive));
}

#[test]
fn factors_are_read_from_fields_of_cells_and_of_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = sinew_mesh::box_tetrahedra([20.0, 4.0, 4.0], [8, 2, 2]);
    let of_nodes: Vec<f64> = mesh.points.iter().map(|x| 1.0 + x[0]).collect();
    let of_cells: Vec<f64> = mesh
        .cells
        .iter()
        .map(|cell| cell.iter().map(|&node| of_nodes[node]).sum::<f64>() / 4.0)
        .collect();
    mesh.point_fields.insert("nodal".into(), sinew_mesh::Field::scalars(of_nodes));
    let mut wrong = of_cells.clone();
    wrong[7] = 0.0;
    mesh.cell_fields.insert("wrong".into(), sinew_mesh::Field::scalars(wrong));
    let labels: Vec<i64> = (0..mesh.cells.len()).map(|cell| (cell % 3) as i64).collect();
    let scar: Vec<usize> = (0..mesh.cells.len()).filter(|&cell| labels[cell] == 2).collect();
    let tenfold = labels.iter().map(|&label| if label == 2 { 10.0 } else { 1.0 });
    mesh.cell_fields.insert("tenfold".into(), sinew_mesh::Field::scalars(tenfold.collect()));
    mesh.cell_sets.insert("scar".into(), scar);
    mesh.cell_fields.insert("region".into(), sinew_mesh::Field::labels(labels));
    mesh.cell_fields.insert("cellular".into(), sinew_mesh::Field::scalars(of_cells));
    let both = sinew_mesh::Field::vectors(&vec![[1.0, 0.0, 0.0]; mesh.cells.len()]);
    mesh.cell_fields.insert("both".into(), both);
    let both = sinew_mesh::Field::vectors(&vec![[1.0, 0.0, 0.0]; mesh.points.len()]);
    mesh.point_fields.insert("both".into(), both);
    let file = folder.path().join("bar.vtu");
    sinew_mesh::write_vtu(&file, &mesh).unwrap();
    let with = |stiffness: &str| {
        MUSCLE
            .replace("active = true", &format!("stiffness{stiffness}"))
            .replace("T_a = { range = [0.0, 20.0], sampling = \"linear\" }\n", "")
            .replace(
                "mesh.box = { extent = [20.0, 4.0, 4.0], cells = [8, 2, 2] }",
                &format!("mesh.file = '{}'", file.display()),
            )
    };
    let text = |field: &str| with(&format!(".field = \"{field}\""));
    let (nodal, cellular) = (body(&text("nodal")), body(&text("cellular")));
    let theta = nodal.centre();
    let [a, b] = [&nodal, &cellular].map(|b| b.value(&uniform(b, [0.1, 0.0, 0.0]), &theta));
    assert!((a / b - 1.0).abs() < 1e-14);
    refusal(&text("wrong"), &["stiffness.field", "0 at cell 7", "above zero"]);
    refusal(&text("celular"), &["stiffness.field", "did you mean `cellular`?"]);
    // A name of two fields.
    const TWO: &str = "a field `both` of cells and one of nodes; rename";
    let fibres =
        text("nodal").replace("fibres.direction = [1.0, 0.0, 0.0]", "fibres.field = \"both\"");
    let field = [(text("both"), "stiffness.field"), (fibres, "fibres.field")];
    field.iter().for_each(|(text, key)| refusal(text, &[key, TWO]));
    refusal(
        &format!("mesh.keep = []\n{}", text("nodal")),
        &["mesh.keep", "no cells would stay; name some"],
    );
    refusal(&text("node_set:x_min"), &["stiffness.field"]);
    // A set of cells, a label and a field give the same bits.
    let by = |name: &str, factor: f64| {
        with(&format!(" = {{ cells = \"{name}\", factor = {factor:?} }}"))
    };
    let of_set = |name| by(name, 10.0);
    let cases = [by("scar", 1.0), text("tenfold"), of_set("scar"), of_set("region:2")];
    let [plain, scars @ ..] = cases.map(|text| {
        let body = body(&text);
        body.value(&uniform(&body, [0.1, 0.0, 0.0]), &theta)
    });
    // A third of cells of one size is ten times as stiff.
    assert!((scars[0] / plain - 4.0).abs() < 1e-12, "{scars:?} {plain}");
    assert!(scars.iter().all(|scar| *scar == scars[0]), "{scars:?}");
    refusal(&of_set("scra"), &["stiffness.cells", "did you mean `scar`?"]);
    let along = "fibres.direction = [1.0, 0.0, 0.0]\n";
    let folder_named = sinew(&["serve", &folder.path().display().to_string()]);
    assert!(
        lines(&folder_named.stderr).contains("this is a folder"),
        "{}",
        lines(&folder_named.stderr)
    );
    let sheets = text("tenfold").replace(along, &format!("{along}fibres.sheets = \"across\"\n"));
    refusal(&sheets, &["fibres.sheets", "give `field` too"]);
    refusal(&of_set("region:7"), &["stiffness.cells", "region:0"]);
    // A support holds the nodes of a label.
    let held = text("tenfold").replace("nodes = \"x_min\", x = 0.0", "clamped = \"region:2\"");
    let held = body(&held);
    let region = &held.mesh.cells_of("region:2").unwrap();
    assert!(
        region
            .iter()
            .flat_map(|&cell| held.nodes_of_cell(cell))
            .all(|&n| held.prescribed[3 * n].is_some())
    );
    // Fibres of another file with the same mesh, in another unit.
    let mut other = mesh.clone();
    let along = vec![[1.0, 1.0, 0.0]; mesh.cells.len()];
    other.cell_fields.insert("helix".into(), sinew_mesh::Field::vectors(&along));
    other.map_points(|x| x.map(|x| 1e3 * x));
    let fibres = folder.path().join("fibres.vtu");
    let from = |file: &Path, mesh: &sinew_mesh::TetMesh| {
        sinew_mesh::write_vtu(file, mesh).unwrap();
        let keys = format!("fibres = {{ field = \"helix\", file = '{}' }}", file.display());
        text("tenfold").replace("fibres.direction = [1.0, 0.0, 0.0]", &keys)
    };
    let turned = body(&from(&fibres, &other));
    assert!((turned.material.directions(5)[0][1] - 0.5_f64.sqrt()).abs() < 1e-12);
    // A field that the second file lacks is not that of the body's own file.
    let helix = other.cell_fields.remove("helix").unwrap();
    mesh.cell_fields.insert("helix".into(), helix);
    sinew_mesh::write_vtu(&file, &mesh).unwrap();
    refusal(&from(&fibres, &other), &["fibres.file", "no field `helix`"]);
    // Cells in another order keep their own directions.
    let (mut shuffled, count) = (other.clone(), mesh.cells.len());
    let rows: Vec<_> = (0..count).map(|cell| [cell as f64 + 1.0, 2.0, 0.0]).collect();
    shuffled.cells.reverse();
    let reversed: Vec<_> = rows.iter().rev().copied().collect();
    shuffled.cell_fields.insert("helix".into(), sinew_mesh::Field::vectors(&reversed));
    let [first, second] = body(&from(&fibres, &shuffled)).material.directions(0)[0][..2] else {
        panic!()
    };
    assert!((first / second - 0.5).abs() < 1e-12, "{first} {second}");
    shuffled.cells[3] = shuffled.cells[4];
    refusal(&from(&fibres, &shuffled), &["fibres.file", "other nodes"]);
    other.points.swap(3, 4);
    refusal(&from(&fibres, &other), &["fibres.file", "same order"]);
    let nodes = with(" = { nodes = \"scar\", factor = 10.0 }");
    refusal(&nodes, &["stiffness.nodes", "`scar` is a set of cells: write stiffness = { cells"]);
}

#[test]
fn mistakes_are_told_with_key_number_and_remedy() {
    let told = |from: &str, to: &str, words: &[&str]| {
        assert!(MUSCLE.contains(from), "{from}");
        refusal(&MUSCLE.replace(from, to), words);
    };
    told(
        "active = true",
        "active = \"yes\"",
        &["line 3", "active", "the text \"yes\"", "true, false"],
    );
    told("active = true", "", &["parameters.T_a", "nothing reads it", "active = true"]);
    told("active = true", "active = { factor = 2.0 }", &["line 3", "active", "give the `field`"]);
    told(
        "active = true",
        "active = { nodes = \"x_max\", factor = -1.0 }",
        &["active.factor", "-1", "zero or more"],
    );
    told(
        "active = true",
        "active = true\nstiffness = { nodes = \"x_max\", factor = 0.0 }",
        &["line 4", "stiffness.factor", "0 is", "above zero"],
    );
    told(
        "active = true",
        "active = true\nstiffness = { nodes = \"scar\", factor = 2.0 }",
        &["stiffness.nodes", "`scar`", "x_max"],
    );
    told(
        "active = true",
        "active = true\nstiffness = { node = \"x_max\", factor = 2.0 }",
        &["line 4", "did you mean `nodes`?"],
    );
    told("T_a = {", "Ta = {", &["parameters.Ta", "nothing reads it"]);
    told(
        "T_a = { range = [0.0, 20.0], sampling = \"linear\" }\n",
        "",
        &["`T_a` is missing", "kPa"],
    );
    told("\"linear\"", "\"log\"", &["parameters.T_a", "no logarithm", "linear"]);
    told("bulk_modulus = 25.0", "bulk_modulus = 25.0, strain = \"hole\"", &["line 2", "`whole`"]);
    let isotropic = MUSCLE
        .replace("{ name = \"holzapfel-ogden\", bulk_modulus = 25.0 }", "\"neo-hookean\"")
        .replace(
            "a = [0.1, 0.3]\nb = [1.0, 4.0]\na_f = [1.5, 5.0]\nb_f = [1.0, 4.0]",
            "mu = 1\nlambda = 1",
        );
    refusal(&isotropic, &["line 3", "active", "`neo-hookean` reads none", "guccione"]);
    let rim = "active = true\nloads = [{ traction = [0.0, 0.0, 1.0], facets = \"z_max\", rim = \"loose\" }]";
    told("active = true", rim, &["loads.0.rim", "only a `pressure`"]);
}

/// A bar under a pressure from below, whose rim is loose.
const BENT: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "z_min", rim = "loose" }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [20.0, 4.0, 4.0], cells = [8, 2, 2] }
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0], p = [0.05, 0.2] }
"#;

#[test]
fn bodies_without_a_potential_are_balances_and_refused_elsewhere() {
    let body = case(BENT).lowered().unwrap();
    assert_eq!((body.followers.len(), body.parameters.len()), (1, 3));
    refusal(BENT, &["line 3", "loads.0.rim", "no potential", "sinew solve", "hold the rim"]);
    let silent = BENT.replace(", rim = \"loose\"", "");
    refusal(&silent, &["loads", "z_min", "hold the rim", "rim = \"loose\""]);
    let mixed = silent.replace("law =", "formulation = \"mixed\"\nlaw =");
    refusal(&mixed, &["loads.0", "moves freely", "rim = \"loose\""]);
    let mixed = BENT.replace("law =", "formulation = \"mixed\"\nlaw =");
    refusal(&mixed, &["line 2", "formulation", "no potential", "averaged"]);
    let hexahedra =
        mixed.replace("cells = [8, 2, 2] }", "cells = [8, 2, 2] }\nmesh.element = \"hexahedra\"");
    refusal(&hexahedra, &["formulation", "hexahedra"]);
    // A rim that is held needs no balance though it may be loose.
    let held = "{ clamped = \"x_min\" }, { clamped = \"x_max\" }, { clamped = \"y_min\" }, { clamped = \"y_max\" }";
    assert!(case(&BENT.replace("{ clamped = \"x_min\" }", held)).body().is_ok());
    // A lid that moves with the rim gives it a potential.
    refusal(BENT, &["rim = \"closed\""]);
    refusal(&silent, &["rim = \"closed\"", "lid"]);
    let closed = case(&BENT.replace("loose", "closed")).body().unwrap();
    assert_eq!((closed.has_potential(), closed.pressures[0].lids.len()), (true, 1));
    let traction = BENT.replace("pressure = \"p\"", "traction = [0.0, 0.0, 1.0]");
    let traction = traction.replace("loose", "closed").replace(", p = [0.05, 0.2]", "");
    refusal(&traction, &["loads.0.rim", "only a `pressure`"]);
    refusal(&BENT.replace("loose", "open"), &["loads.0.rim", "closed"]);
    // Of two pressures the one that says nothing is told.
    let two = BENT.replace("loads = [", "loads = [{ pressure = 0.1, facets = \"z_max\" }, ");
    refusal(&two, &["loads.0", "`z_max`"]);
}

fn sinew(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sinew")).args(arguments).output().unwrap()
}

fn lines(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_program_solves_balances_and_refuses_to_train_on_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bent.toml");
    let mixed = BENT.replace("law =", "formulation = \"mixed\"\nlaw =");
    let [file, out] = [file, folder.path().join("out")].map(|path| path.display().to_string());
    for text in [BENT, &mixed] {
        std::fs::write(&file, text).unwrap();
        let done =
            sinew(&["solve", &file, "--out", &out, "--fields", "--theta", "mu=10,lambda=12,p=0.1"]);
        assert!(done.status.success(), "{}", lines(&done.stderr));
        let table = std::fs::read_to_string(format!("{out}/solve/cases.csv")).unwrap();
        let row = table.lines().nth(1).unwrap().split(',').collect::<Vec<_>>();
        // Without a potential there is no energy.
        assert!(row[5].parse::<f64>().unwrap() > 0.1 && row[6].is_empty(), "{table}");
        let (mesh, _) = sinew_mesh::read(format!("{out}/solve/0000.vtu")).unwrap();
        assert!(mesh.cell_fields().contains_key("cauchy_stress"));
        assert_eq!(mesh.point_fields().contains_key("pressure"), text == mixed);
        let done = sinew(&["sample", &file, "--out", &out, "--count", "3", "--solve"]);
        assert!(done.status.success(), "{}", lines(&done.stderr));
        for command in ["train", "plan", "export --page", "evaluate"] {
            let command: Vec<_> = command.split(' ').collect();
            let refused = sinew(&[&command[..], &[&file, "--out", &out]].concat());
            let told = lines(&refused.stderr);
            assert_eq!(refused.status.code(), Some(2), "{told}");
            assert!(told.contains("no potential") && told.contains("sinew solve"), "{told}");
        }
        let refused = sinew(&["sample", &file, "--out", &out, "--solve", "--shard", "1/2"]);
        assert!(lines(&refused.stderr).contains("--shard"), "{}", lines(&refused.stderr));
        let refused = sinew(&["predict", &file, "--out", &out, "--accuracy", "1e-3"]);
        assert!(lines(&refused.stderr).contains("no potential"), "{}", lines(&refused.stderr));
    }
}

/// A small ventricle with its pressure in θ.
pub(crate) const VENTRICLE: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
mesh.ellipsoid = { short = [22.0, 36.0], long = [58.0, 74.0], base = 0.0, cells = [1, 16, 8] }
fibres.rule = { endocardium = "endo", epicardium = "epi", base = "base", angles = [60.0, -60.0] }
[parameters]
a = [0.1, 0.26]
b = [1.0, 4.2]
a_f = [1.5, 5.18]
b_f = [1.0, 4.46]
p = { range = [4.0, 10.0], unit = "mmHg" }
"#;

/// Numbers of a CSV table below its head.
fn table(path: &str) -> (String, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(String::from);
    let head = lines.next().unwrap();
    let row = |line: String| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (head, lines.map(row).collect())
}

#[test]
fn a_pressure_is_followed_frame_by_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (file, out) = (path("heart.toml"), path("out"));
    std::fs::write(&file, VENTRICLE).unwrap();
    let follow = |way: &str| {
        sinew(&["solve", &file, "--out", &out, "--along", way, "--frames", "4", "--fields"])
    };
    let done = follow("p=0..8mmHg");
    assert!(done.status.success(), "{}", lines(&done.stderr));
    let (out_said, err_said) = (lines(&done.stdout), lines(&done.stderr));
    assert!(out_said.contains("p from 0 to 8 mmHg"), "{out_said}");
    assert!(err_said.contains("warning: p = 0 mmHg is outside its range from 4"), "{err_said}");
    let (head, rows) = table(&format!("{out}/solve/curve.csv"));
    assert_eq!(head, "p [mmHg],mean u [mm],largest u [mm],volume of endo [mm3]");
    let pressures: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    // Converted to kPa and back.
    let exact = [0.0, 2.0, 4.0, 6.0, 8.0];
    assert!(pressures.iter().zip(exact).all(|(p, q)| (p - q).abs() < 1e-12), "{pressures:?}");
    assert!(rows.windows(2).all(|pair| pair[1][1] > pair[0][1] && pair[1][3] > pair[0][3]));
    assert!(rows[0][1].abs() < 1e-12);
    // The last frame is the equilibrium of its pressure.
    let body = body(VENTRICLE);
    let mut theta = body.centre();
    theta[4] = body.parameters[4].unit.in_scene(8.0);
    let solution = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
    let volume = body.cavity_volumes(&solution.displacement)[0];
    assert!((rows[4][3] / volume - 1.0).abs() < 1e-9, "{} {volume}", rows[4][3]);
    let series = std::fs::read_to_string(format!("{out}/solve/cases.pvd")).unwrap();
    assert!(series.contains("timestep=\"2.0\"") && series.contains("0004.vtu"), "{series}");
    // Names of fields without spaces, tensors of nine numbers; the volumes add up to that of the loaded wall.
    let (mesh, _) = sinew_mesh::read(format!("{out}/solve/0004.vtu")).unwrap();
    let fields = mesh.cell_fields();
    assert!(fields.keys().chain(mesh.point_fields().keys()).all(|name| !name.contains(' ')));
    assert_eq!(fields["cauchy_stress"].components, 9);
    let volumes: f64 = fields["volume"].to_f64().iter().sum();
    let ratio = |point: usize| {
        1.0 + body.displacement_gradient(point, &solution.displacement).volume_change()
    };
    let exact: f64 = (0..body.volumes.len()).map(|p| body.volumes[p] * ratio(p)).sum();
    assert!((volumes / exact - 1.0).abs() < 1e-6, "{volumes} {exact}");
    // θ of the others is enough.
    let others = "a=0.18,b=2.6,a_f=3.3,b_f=2.7";
    let along = ["--along", "p=0..1mmHg", "--frames", "1", "--theta", others];
    let done = sinew(&[&["solve", &file, "--out", &out], &along[..]].concat());
    assert!(done.status.success(), "{}", lines(&done.stderr));
    let less = sinew(&["solve", &file, "--along", "p=0..1", "--theta", "a=0.18,b=2.6,a_f=3.3"]);
    assert!(lines(&less.stderr).contains("b_f (from"), "{}", lines(&less.stderr));
    let refused = |way: &str, words: &[&str]| {
        let done = follow(way);
        let told = lines(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{told}");
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
    };
    refused("q=0..8mmHg", &["--along", "`q` is not a parameter", "p"]);
    refused("p=8", &["--along", "two ends"]);
    refused("p=8..8", &["both ends are 8 mmHg"]);
    refused("p=0..8 mm", &["unit"]);
    refused("a=0.1...2", &["--along a=0.1...2", "two points between the ends"]);
    refused("p=2..1kPa", &["`2` has no unit", "write 2mmHg or 2kPa"]);
    refused("p=1kPa..8", &["`8` has no unit", "write 8mmHg or 8kPa"]);
    refused("b=1..-2", &["--along", "b = -2"]);
}

#[test]
fn a_path_ends_where_the_body_snaps() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (file, out) = (path("bag.toml"), path("out"));
    // A neo-Hookean chamber has a largest pressure, beyond which it grows without bound.
    let text = "law = { name = \"neo-hookean-isochoric\", bulk_modulus = 50.0 }\nloads = [{ pressure = \"p\", facets = \"endo\" }]\n\
                supports = [{ clamped = \"base\" }]\nparameters = { mu = 1.0, p = [0.1, 5.0] }\n\
                mesh.ellipsoid = { short = [22.0, 26.0], long = [22.0, 26.0], base = 0.0, cells = [1, 16, 8] }\n";
    std::fs::write(&file, text).unwrap();
    let done = sinew(&["solve", &file, "--out", &out, "--along", "p=0..0.4", "--frames", "20"]);
    let told = lines(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{told}");
    assert!(told.contains("frames were found") && told.contains("ends between p = "), "{told}");
    let (_, rows) = table(&format!("{out}/solve/curve.csv"));
    // Stiffer and stiffer steps of pressure cannot be: the volume grows faster and faster towards the limit.
    assert!(rows.len() > 2 && rows.len() < 20, "{}", rows.len());
    let steps: Vec<f64> = rows.windows(2).map(|pair| pair[1][2] - pair[0][2]).collect();
    assert!(steps.is_sorted(), "{steps:?}");
}

#[test]
fn an_unloaded_image_has_its_stresses() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (file, rest) = (path("heart.toml"), path("rest.vtu"));
    std::fs::write(&file, VENTRICLE).unwrap();
    let done = sinew(&["unload", &file, "--fields", "-o", &rest]);
    assert!(done.status.success(), "{}", lines(&done.stderr));
    assert!(!lines(&done.stderr).contains("not quite"), "{}", lines(&done.stderr));
    let (mesh, _) = sinew_mesh::read(&rest).unwrap();
    let fields = mesh.cell_fields();
    for name in ["cauchy_stress", "fibre_stretch", "fibre_in_image", "fibre", "volume"] {
        assert!(fields.contains_key(name), "{name}");
    }
    // A turn about the places of the image is another about those at rest.
    let turned = VENTRICLE.replace(
        "{ clamped = \"base\" }",
        "{ nodes = \"base\", axis = [1.0, 0.2, 0.0], point = [0.0, 9.0, 3.0], turn = { degrees = 4.0 } }",
    );
    assert_ne!(turned, VENTRICLE);
    std::fs::write(path("turned.toml"), turned).unwrap();
    let done = sinew(&["unload", &path("turned.toml"), "-o", &path("other.vtu")]);
    assert!(!done.status.success());
    assert!(
        lines(&done.stderr).contains("a turn is about other places"),
        "{}",
        lines(&done.stderr)
    );
    // The image is the mesh of the case.
    let volumes: f64 = fields["volume"].to_f64().iter().sum();
    let image: f64 = body(VENTRICLE).volumes.iter().sum();
    assert!((volumes / image - 1.0).abs() < 1e-12, "{volumes} {image}");
}
