//! Answers in files: units, rows that fail, emulators beside each other, and remains of an earlier run.

use sinew::Case;
use sinew::output::{MOST_BYTES, Results, Row};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A plate under pressure in mmHg that trains in a second.
pub(crate) const PLATE: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "z_min" }]
supports = [{ clamped = "x_min" }, { clamped = "x_max" }, { clamped = "y_min" }, { clamped = "y_max" }]

[mesh]
box = { extent = [30.0, 20.0, 6.0], cells = [4, 3, 2] }

[parameters]
mu = [8.0, 16.0]
lambda = 12.0
p = { range = [1.0, 4.0], unit = "mmHg" }

[training]
recipe = "regression"
samples = 9
held_out = 3
"#;

pub(crate) fn plate() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.toml"), PLATE).unwrap();
    folder
}

fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}

/// Exit code, and what was printed.
pub(crate) fn sinew(folder: &Path, arguments: &str) -> (i32, String) {
    let Output { status, stdout, stderr } = run(folder, arguments);
    let text = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (status.code().unwrap(), text)
}

/// Output of a command that succeeds.
pub(crate) fn done(folder: &Path, arguments: &str) -> String {
    let (code, told) = sinew(folder, arguments);
    assert_eq!(code, 0, "sinew {arguments}: {told}");
    told
}

/// Cells of a table by the heads of their columns; quoted cells hold no commas in these tests but in the last columns.
pub(crate) fn column(folder: &Path, file: &str, head: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join(file)).unwrap();
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = heads.iter().position(|found| *found == head);
    let place = place.unwrap_or_else(|| panic!("{head} is not in {heads:?}"));
    lines.map(|line| line.splitn(heads.len(), ',').nth(place).unwrap().to_string()).collect()
}

#[test]
fn numbers_are_in_the_units_of_the_case() {
    let folder = plate();
    let folder = folder.path();
    // The line of the answer, without times.
    let done = |folder: &Path, arguments: &str| {
        let told = done(folder, arguments);
        told.lines().filter(|line| !line.starts_with("solve ")).collect::<Vec<_>>().join("\n")
    };
    let told = done(folder, "solve plate.toml --theta mu=10,p=2");
    assert!(told.contains("mu = 10 kPa, p = 2 mmHg: displacement"), "{told}");
    assert_eq!(told, done(folder, "solve plate.toml --theta p=2mmhg,mu=10000Pa"));
    assert_ne!(told, done(folder, "solve plate.toml --theta mu=10,p=2kPa"));
    std::fs::write(folder.join("thetas.csv"), "mu,p\n10,2\n").unwrap();
    assert_eq!(told, done(folder, "solve plate.toml --theta thetas.csv"));
    assert_eq!(column(folder, "out/plate/solve/cases.csv", "p [mmHg]"), ["2"]);
    let picture = std::fs::read_to_string(folder.join("out/plate/solve/0000.vtu")).unwrap();
    assert!(picture.contains("Name=\"p [mmHg]\">2.0</DataArray>"), "no field data");
    sinew_mesh::read_mesh::<4>(folder.join("out/plate/solve/0000.vtu")).unwrap();

    let outside = done(folder, "solve plate.toml --theta mu=10,p=5");
    let range = "p = 5 mmHg is outside its range from 1 to 4 mmHg";
    assert!(outside.contains(range), "{outside}");
    let [cell] = &column(folder, "out/plate/solve/cases.csv", "outside their ranges")[..] else {
        panic!("one row")
    };
    assert_eq!(cell, range);
    // Samples go out and come back as they are.
    done(folder, "sample plate.toml --count 3");
    let drawn = column(folder, "out/plate/sample/thetas.csv", "p [mmHg]");
    assert!(drawn.iter().all(|p| (1.0..=4.0).contains(&p.parse::<f64>().unwrap())), "{drawn:?}");
    done(folder, "solve plate.toml --theta out/plate/sample/thetas.csv");
    assert_eq!(column(folder, "out/plate/solve/cases.csv", "p [mmHg]"), drawn);
}

#[test]
fn solutions_beside_which_there_are_others_are_counted() {
    // A column beyond the load at which it buckles.
    let column = r#"
        law = "neo-hookean"
        loads = [{ traction = [-0.9, 0.0, 0.0], facets = "x_max" }, { pressure = "q", facets = "z_min", rim = "closed" }]
        supports = [{ clamped = "x_min" }]
        mesh = { box = { extent = [20.0, 4.0, 4.0], cells = [8, 2, 2] }, element = "hexahedra" }
        parameters = { mu = [2.0, 50.0], lambda = 20.0, q = { range = [-0.05, 0.05], sampling = "linear" } }
    "#;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("column.toml"), column).unwrap();
    let rows = [3, 6, 12].map(|mu| format!("{mu},-0.03\n{mu},-0.003\n{mu},0.003\n{mu},0.03\n"));
    std::fs::write(folder.join("thetas.csv"), format!("mu,q\n{}", rows.concat())).unwrap();
    let solved = done(folder, "solve column.toml --theta thetas.csv");
    assert!(solved.contains(" of the 5 compared solutions are not those"), "{solved}");
    assert!(solved.contains(" others, which were not compared, may not be either"), "{solved}");
    let told = done(folder, "predict column.toml --theta thetas.csv --accuracy 1e-3");
    assert!(told.contains("12 of 12 answers may be on another branch"), "{told}");
    let cases = std::fs::read_to_string(folder.join("out/column/predict/accuracy/cases.csv"));
    assert_eq!(cases.unwrap().matches("jumped: ").count(), 12);
    // Samples of one process, and of a campaign in shards.
    let marked = |name: &str| {
        let cases = std::fs::read_to_string(folder.join(name).join("sample/cases.csv"));
        cases.unwrap().matches("jumped: ").count()
    };
    let sample = "sample column.toml --count 6 --solve --out";
    assert!(done(folder, &format!("{sample} one")).contains(" solutions are not those"));
    for shard in ["1/2", "2/2"] {
        done(folder, &format!("{sample} shards --shard {shard}"));
    }
    let merged = done(folder, "merge column.toml --out shards");
    assert!(merged.contains(" solutions are not those"), "{merged}");
    assert!(marked("one") > 0 && marked("shards") > 0);
}

#[test]
fn answers_that_are_unstable_say_so() {
    // Ten times the load at which the column buckles.
    let column = r#"
law = "neo-hookean-young"
loads = [{ traction = [-0.05, 0.0, 0.0], facets = "x_max" }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [100.0, 5.0, 5.0], cells = [20, 2, 2] }, element = "hexahedra" }
parameters = { E = [5.0, 20.0], nu = 0.3 }
"#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("column.toml"), column).unwrap();
    let told = done(folder.path(), "predict column.toml --theta E=10 --accuracy 1e-3");
    assert!(told.contains("1 of 1 answers are unstable"), "{told}");
}

#[test]
fn a_row_that_fails_is_a_row_with_its_reason() {
    let folder = plate();
    let folder = folder.path();
    let table = "mu,p\n10,2\n10,two\n-10,2\n10,1,3\n12,3\n";
    std::fs::write(folder.join("thetas.csv"), table).unwrap();
    done(folder, "train plate.toml");
    for (command, kept) in [
        ("solve", "out/plate/solve"),
        ("predict", "out/plate/predict/regression"),
        ("predict", "out/plate/predict/regression"),
        ("correct", "out/plate/correct/regression"),
    ] {
        let (code, told) = sinew(folder, &format!("{command} plate.toml --theta thetas.csv"));
        assert_eq!(code, 2, "{command}: {told}");
        assert!(told.contains("3 of 5 rows failed, the others were computed"), "{told}");
        let cases = format!("{kept}/cases.csv");
        let failures = column(folder, &cases, "failure");
        let expected = ["", "line 3: `two` is not", "line 4: mu = -10 kPa", "line 5: 3 values", ""];
        for (found, expected) in failures.iter().zip(expected) {
            assert!(found.contains(expected) && found.is_empty() == expected.is_empty(), "{found}");
        }
        assert_eq!(column(folder, &cases, "mu [kPa]"), ["10", "", "-10", "", "12"]);
        let pictures =
            [0, 1, 2, 3, 4].map(|case| folder.join(format!("{kept}/{case:04}.vtu")).exists());
        assert_eq!(pictures, [true, false, false, false, true], "{command}");
    }
    // One that cannot be solved: no mistake of the table.
    std::fs::write(folder.join("thetas.csv"), "mu,p\n10,2\n10,1e9\n").unwrap();
    let (code, told) = sinew(folder, "solve plate.toml --theta thetas.csv");
    assert_eq!(code, 1, "{told}");
    let failures = column(folder, "out/plate/solve/cases.csv", "failure");
    assert!(failures[0].is_empty() && failures[1].contains("no equilibrium"), "{failures:?}");
}

#[test]
fn answers_of_two_emulators_stay_and_those_of_an_earlier_run_go() {
    let folder = plate();
    let folder = folder.path();
    done(folder, "train plate.toml");
    done(folder, "train plate.toml --recipe taylor");
    done(folder, "sample plate.toml --count 5");
    done(folder, "predict plate.toml --theta out/plate/sample/thetas.csv --emulator taylor");
    let of_taylor = std::fs::read(folder.join("out/plate/predict/taylor/cases.csv")).unwrap();
    let quick = "predict plate.toml --quick --theta out/plate/sample/thetas.csv";
    done(folder, quick);
    assert_eq!(
        std::fs::read(folder.join("out/plate/predict/taylor/cases.csv")).unwrap(),
        of_taylor
    );
    let kept = folder.join("out/plate/predict/regression");
    assert!(kept.join("0004.vtu").exists() && kept.join("cases.pvd").exists());
    std::fs::write(kept.join("notes.txt"), "mine").unwrap();
    done(folder, "predict plate.toml --quick --theta mu=10,p=2");
    assert!(kept.join("0000.vtu").exists() && !kept.join("0001.vtu").exists());
    assert!(kept.join("notes.txt").exists());
    done(folder, &format!("{quick} --pictures 0"));
    assert!(!kept.join("0000.vtu").exists() && !kept.join("cases.pvd").exists());
    // Which one is not guessed.
    std::fs::rename(folder.join("out/plate/regression"), folder.join("out/plate/mine")).unwrap();
    let (code, told) = sinew(folder, "predict plate.toml");
    assert!(code == 2 && told.contains("several emulators"), "{told}");
    assert!(told.contains("--emulator NAME: mine, taylor"), "{told}");
    let (code, told) = sinew(folder, "predict plate.toml --emulator regresion");
    assert!(code == 2 && told.contains("--emulator regresion") && told.contains("mine"), "{told}");
}

#[test]
fn nobody_needs_to_read_what_is_printed() {
    let folder = plate();
    for arguments in [&["scenes"][..], &["solve", "plate.toml"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
        let command = command.current_dir(folder.path()).args(arguments);
        let output = command.stdout(writer).stderr(Stdio::piped()).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && !told.contains("panicked"), "{arguments:?}: {told}");
    }
    assert!(folder.path().join("out/plate/solve/cases.csv").exists());
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    let status = command.current_dir(folder.path()).args(["solve", "none.toml"]).stderr(writer);
    assert_eq!(status.status().unwrap().code(), Some(2));
}

#[test]
fn large_archives_are_written_only_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let body = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap();
    let (field, theta) = (vec![0.0; 3 * body.nodes], body.centre());
    let count = MOST_BYTES / (8 * field.len()) + 1;
    // Rows that failed take as many bytes, and nothing is computed of them.
    let mut rows = vec![Row { theta: theta.clone(), ..Row::default() }; count];
    rows[count / 2].fields = vec![&field[..]];
    let results = Results { body: &body, names: vec!["predicted"], rows, stresses: false };
    let left_out = results.write(folder.path(), 1, false).unwrap();
    assert_eq!(left_out, Some(8 * field.len() * count));
    assert!(!folder.path().join("cases.npz").exists());
    assert_eq!(results.write(folder.path(), 1, true).unwrap(), None);
    assert!(folder.path().join("cases.npz").exists());
    // What is small is written unasked, and takes the place of the large one.
    let rows = vec![Row { theta, fields: vec![&field[..]], ..Row::default() }];
    let small = Results { body: &body, names: vec!["predicted"], rows, stresses: false };
    small.write(folder.path(), 1, false).unwrap();
    let size = std::fs::metadata(folder.path().join("cases.npz")).unwrap().len() as usize;
    assert!(size < MOST_BYTES && column(folder.path(), "cases.csv", "case") == ["0"]);
}

#[test]
fn parts_of_a_table_are_numbered_on() {
    let folder = tempfile::tempdir().unwrap();
    let body = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap();
    let field = vec![0.0; 3 * body.nodes];
    let row = Row { theta: body.centre(), fields: vec![&field[..]], ..Row::default() };
    let part = |count: usize| Results {
        body: &body,
        names: vec!["solved"],
        rows: vec![row.clone(); count],
        stresses: false,
    };
    part(1).write(folder.path(), 1, false).unwrap();
    part(2).append(folder.path(), 1).unwrap();
    assert_eq!(column(folder.path(), "cases.csv", "case"), ["0", "1", "2"]);
    assert_eq!(column(folder.path(), "cases.csv", "solved mean u [mm]"), ["0", "0", "0"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_output_is_an_error() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    let done = command.arg("scenes").stdout(full).stderr(Stdio::piped()).output().unwrap();
    let told = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{told}");
    assert!(told.contains("standard output is incomplete"), "{told}");
}

#[test]
fn an_accuracy_is_met_without_an_emulator() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.toml"), PLATE).unwrap();
    done(folder.path(), "sample plate.toml --count 12 --solve");
    let theta = "--theta out/plate/sample/thetas.csv";
    let told = done(folder.path(), &format!("predict plate.toml {theta} --accuracy 1e-6"));
    assert!(told.contains("12 within 1e-6") && told.contains("taken "), "{told}");
    let table = folder.path().join("out/plate/predict/accuracy/cases.csv");
    let table = std::fs::read_to_string(table).unwrap();
    let head: Vec<_> = table.lines().next().unwrap().split(',').collect();
    let solved = std::fs::read_to_string(folder.path().join("out/plate/sample/cases.csv")).unwrap();
    let solved_head: Vec<_> = solved.lines().next().unwrap().split(',').collect();
    let column = |head: &[&str], name: &str| head.iter().position(|h| h.contains(name)).unwrap();
    let (ours, theirs) = (column(&head, "mean u"), column(&solved_head, "mean u"));
    for (a, b) in table.lines().zip(solved.lines()).skip(1) {
        let number =
            |line: &str, at: usize| line.split(',').nth(at).unwrap().parse::<f64>().unwrap();
        let (a, b) = (number(a, ours), number(b, theirs));
        assert!((a / b - 1.0).abs() < 1e-6, "{a} for {b}");
    }
    let planned = done(folder.path(), "plan plate.toml --count 1,10000");
    let taken: Vec<_> = planned.lines().filter(|line| line.starts_with("taken")).collect();
    assert!(taken[0].contains("solver") && taken[1].contains("expansion"), "{planned}");
    let (code, told) = sinew(folder.path(), "predict plate.toml --accuracy 2");
    assert!(code == 2 && told.contains("1e-10 to 0.5"), "{code}: {told}");
}

#[test]
fn an_unseen_body_is_answered_from_another() {
    let folder = plate();
    let folder = folder.path();
    // Narrower and under its own name.
    let other = PLATE.replace("extent = [30.0, 20.0, 6.0]", "extent = [30.0, 18.0, 6.5]");
    assert_ne!(other, PLATE);
    std::fs::write(folder.join("other.toml"), other).unwrap();
    let told =
        done(folder, "predict other.toml --accuracy 1e-4 --from plate.toml --theta mu=10,p=2");
    assert!(told.contains("1 within 1e-4") && told.contains("taken emulator"), "{told}");
    let planned = done(folder, "plan other.toml --count 1 --from plate.toml");
    assert!(planned.contains("emulator + Newton steps"), "{planned}");
    let coarser = PLATE.replace("cells = [4, 3, 2]", "cells = [4, 3, 1]");
    std::fs::write(folder.join("coarser.toml"), coarser).unwrap();
    let (code, told) = sinew(folder, "predict other.toml --accuracy 1e-4 --from coarser.toml");
    assert!(code == 2 && told.contains("--from coarser.toml"), "{code}: {told}");
    let (code, told) = sinew(folder, "predict other.toml --from plate.toml");
    assert!(code == 2 && told.contains("--accuracy"), "{code}: {told}");
}

#[test]
fn pictures_hold_stress_and_strain_where_they_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.toml"), PLATE).unwrap();
    let picture = || {
        let file = folder.path().join("out/plate/solve/0000.vtu");
        sinew_mesh::read(&file).unwrap().0
    };
    done(folder.path(), "solve plate.toml --theta mu=10,p=1");
    assert!(!picture().cell_fields().contains_key("cauchy_stress"));
    done(folder.path(), "solve plate.toml --theta mu=10,p=1 --fields");
    let mesh = picture();
    let body = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap();
    let u = mesh.point_fields()["displacement"].to_f64().into_owned();
    let cells = sinew_fem::cell_stresses(&body, &u, &[10.0, 1.0]).unwrap();
    let expected: Vec<f64> = cells.iter().flat_map(|cell| cell.cauchy.concat()).collect();
    let cauchy = &mesh.cell_fields()["cauchy_stress"];
    assert_eq!((cauchy.components, cauchy.to_f64().as_ref()), (9, &expected[..]));
    assert_eq!(mesh.point_fields()["principal_stresses"].rows(), body.nodes);
    // ParaView warps by the vectors of the nodes.
    let text = std::fs::read_to_string(folder.path().join("out/plate/solve/0000.vtu")).unwrap();
    assert!(text.contains("<PointData Vectors=\"displacement\">"));
    // Principal values at nodes belong to the tensor there: by its trace and its norm, to rounding errors.
    let [tensors, values] = ["cauchy_stress", "principal_stresses"]
        .map(|name| mesh.point_fields()[name].to_f64().into_owned());
    for (tensor, values) in tensors.chunks(9).zip(values.chunks(3)) {
        let [norm, own] = [tensor, values].map(|x| x.iter().map(|x| x * x).sum::<f64>());
        let trace = tensor[0] + tensor[4] + tensor[8];
        assert!((norm - own).abs() <= 1e-12 * norm, "{tensor:?} {values:?}");
        assert!((trace - values.iter().sum::<f64>()).abs() <= 1e-12 * norm.sqrt());
    }
    let arrays = std::fs::File::open(folder.path().join("out/plate/solve/cases.npz")).unwrap();
    let mut arrays = zip::ZipArchive::new(arrays).unwrap();
    let mut bytes = Vec::new();
    arrays.by_name("cells.npy").unwrap().read_to_end(&mut bytes).unwrap();
    let cells = sinew_mesh::parse_npy("cells.npy", &bytes).unwrap();
    assert_eq!(cells.shape, [body.cell_count(), 4]);
    let expected = body.mesh.cells().iter().map(|&node| node as i64).collect();
    assert_eq!(cells.values, sinew_mesh::FieldValues::Integer(expected));
    assert!(arrays.by_name("displacement.npy").is_ok() && arrays.by_name("solved.npy").is_err());
    // The law is isotropic.
    assert!(!mesh.cell_fields().contains_key("fibre"));
}

/// Samples of a body that bursts at the larger pressures: numbers of rows are those of the samples.
#[test]
fn a_sample_without_equilibrium_keeps_its_row() {
    let folder = plate();
    let folder = folder.path();
    let wide = PLATE.replace("[1.0, 4.0], unit", "[1.0, 1e7], sampling = \"log\", unit");
    std::fs::write(folder.join("plate.toml"), wide).unwrap();
    let sample = "sample plate.toml --count 12 --solve";
    let (code, told) = sinew(folder, sample);
    assert!(code == 1 && told.contains("of 12 samples have no equilibrium"), "{told}");
    for shard in ["1/2", "2/2"] {
        sinew(folder, &format!("{sample} --out parts --shard {shard}"));
    }
    done(folder, "merge plate.toml --out parts");
    let asked = column(folder, "out/plate/sample/thetas.csv", "p [mmHg]");
    for out in ["out/plate/sample", "parts/sample"] {
        let cases = format!("{out}/cases.csv");
        let numbers: Vec<_> = (0..12).map(|case| case.to_string()).collect();
        assert_eq!(column(folder, &cases, "case"), numbers);
        assert_eq!(column(folder, &cases, "p [mmHg]"), asked);
        let [means, failures] =
            ["solved mean u [mm]", "failure"].map(|head| column(folder, &cases, head));
        let (_, fields) =
            sinew::npz::read(&folder.join(out).join("cases.npz"), "displacement").unwrap();
        let mut solved = 0;
        for case in 0..12 {
            let failed = means[case].is_empty();
            assert_eq!(failed, failures[case].contains("no equilibrium"), "{out} {case}");
            assert_eq!(failed, fields[case * fields.len() / 12].is_nan(), "{out} {case}");
            solved += usize::from(!failed);
        }
        assert!((6..12).contains(&solved), "{solved}");
        // Its rows are runs, but for those that failed.
        let runs = sinew::runs::Runs::read_table(
            &folder.join(&cases),
            "mu,p",
            Some("solved mean u,solved least J"),
        );
        let runs = runs.unwrap();
        assert_eq!(runs.thetas.len(), solved);
        let left = format!("{} failed runs are left out, the first in line", 12 - solved);
        assert!(runs.warnings.iter().any(|said| said.contains(&left)), "{:?}", runs.warnings);
    }
}
