//! Emulators of stored runs, without a case: a table of numbers, and displacements on a mesh.

use crate::program::{BAR, done, refused};
use sinew::emulate::{Output, RunsEmulator};
use sinew::runs::Runs;
use sinew::{Body, Case, Design, Parameter, npz, outside, simulate};
use sinew_mesh::{AnyMesh, Field, to_npy, to_npy_of};
use std::fmt::Write;
use std::path::Path;

/// Runs of a bar by the solver: parameters in their order (μ, λ), and displacements.
pub(crate) fn runs(count: usize, design: Design) -> (Body, Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let body = Case::parse(BAR, "bar.toml").unwrap().body().unwrap();
    let thetas = design.sample(&body.parameters, count, 3).unwrap();
    let found = simulate(&body, &thetas, "test", None, &mut ()).unwrap();
    assert_eq!(found.thetas, thetas);
    (body, thetas, found.fields)
}

/// Largest sinking, and energy.
fn numbers(body: &Body, theta: &[f64], field: &[f64]) -> [f64; 2] {
    let down = field.iter().skip(2).step_by(3).fold(0.0, |most: f64, u| most.max(-u));
    [down, body.value(field, theta)]
}

/// A column of a table of predictions.
fn column(folder: &Path, head: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join("cases.csv")).unwrap();
    let place = text.lines().next().unwrap().split(',').position(|name| name == head);
    let place = place.unwrap_or_else(|| panic!("{head}: {text}"));
    text.lines().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

fn thetas_csv(folder: &Path, thetas: &[Vec<f64>]) {
    let rows: String = thetas.iter().map(|theta| format!("{},{}\n", theta[0], theta[1])).collect();
    std::fs::write(folder.join("thetas.csv"), format!("mu,lambda\n{rows}")).unwrap();
}

#[test]
fn a_table_of_runs_predicts_runs_that_were_held_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (body, thetas, fields) = runs(40, Design::Sobol);
    let mut table = String::from("case,mu [kPa],lambda [kPa],\"sinking, largest [mm]\",energy\n");
    for (case, (theta, field)) in thetas.iter().zip(&fields).enumerate() {
        let [down, energy] = numbers(&body, theta, field);
        writeln!(table, "run {case},{},{},{down},{energy}", theta[0], theta[1]).unwrap();
    }
    std::fs::write(folder.join("runs.csv"), table.replace("sinking, largest", "sinking")).unwrap();
    let told =
        done(folder, "train --from-table runs.csv --parameters mu,lambda --outputs sinking,energy");
    assert!(
        told.contains("sinking: error")
            && told.contains("(leave-one-out)")
            && told.contains("R² 1.0000"),
        "{told}"
    );

    // Within the box of the runs: beyond it there is a warning.
    let emulator = RunsEmulator::load(&folder.join("out/runs/emulator")).unwrap();
    let (_, unseen, truth) = runs(110, Design::LatinHypercube);
    let within =
        |(theta, _): &(Vec<f64>, Vec<f64>)| outside(&emulator.parameters, theta).is_empty();
    let (unseen, truth): (Vec<_>, Vec<_>) =
        unseen.into_iter().zip(truth).filter(within).take(100).unzip();
    thetas_csv(folder, &unseen);
    let told = done(folder, "predict out/runs --theta thetas.csv");
    assert!(told.contains("sinking") && told.contains('±'), "{told}");
    for (place, (name, unit)) in [("sinking", " [mm]"), ("energy", "")].into_iter().enumerate() {
        let left = &emulator.left_out()[place];
        let out = folder.join("out/runs/predict");
        let predicted = column(&out, &format!("{name}{unit}"));
        let half = column(&out, &format!("95 % error of {name}{unit}"));
        let truth = unseen.iter().zip(&truth).map(|(t, field)| numbers(&body, t, field)[place]);
        let errors: Vec<f64> = predicted.iter().zip(truth).map(|(p, t)| p - t).collect();
        let error = root_mean_square(errors.iter().copied());
        assert!(error < 1.5 * left.error, "{name}: {error:e}, {:e} stated", left.error);
        // A rank quantile of 40 errors: at least 0.85 of 100 with a probability of 0.99.
        let within = errors.iter().zip(&half).filter(|(e, h)| e.abs() <= **h).count();
        assert!((85..=100).contains(&within), "{name}: {within} of 100");
        assert!(left.r_squared() > 0.9999, "{name}: {}", left.r_squared());
    }
    // Quoted heads.
    std::fs::write(folder.join("quoted.csv"), table.replace("run ", "").replace("case,", "x,"))
        .unwrap();
    let runs = Runs::read_table(&folder.join("quoted.csv"), "x,mu,lambda", None).unwrap();
    let names: Vec<_> = runs.outputs.iter().map(|output| &output.name[..]).collect();
    assert_eq!(
        (names, runs.parameters[1].unit.name()),
        (vec!["sinking, largest", "energy"], "kPa")
    );

    let far = done(folder, "predict out/runs --theta mu=30,lambda=10");
    assert!(far.contains("mu = 30 kPa is outside its range"), "{far}");
    let (_, none) = refused(folder, "predict out/runs");
    assert!(none.contains("--theta is missing"), "{none}");
    let (code, solver) = refused(folder, "predict out/runs --theta thetas.csv --accuracy 1e-3");
    assert!(code == 2 && solver.contains("no solver"), "{solver}");
    let (code, solver) = refused(folder, "predict out/runs --theta thetas.csv --quick");
    assert!(code == 2 && solver.contains("--quick"), "{solver}");
    std::fs::write(folder.join("bad.csv"), "mu,lambda\n9,ten\n").unwrap();
    let (code, row) = refused(folder, "predict out/runs --theta bad.csv");
    assert!(code == 2 && row.contains("`ten`"), "{row}");
    assert!(!folder.join("out/runs/predict/cases.csv").exists(), "results of an earlier run");
    let again = "train --from-table runs.csv --parameters mu,lambda --outputs energy";
    let (code, there) = refused(folder, again);
    assert!(code == 2 && there.contains("--restart"), "{there}");
    done(folder, &format!("{again} --restart"));
    std::fs::write(folder.join("out/runs/emulator/0/modes.npy"), "other").unwrap();
    let (_, damaged) = refused(folder, "predict out/runs --theta thetas.csv");
    assert!(damaged.contains("modes.npy is not as it was stored"), "{damaged}");
}

/// Writes an archive anew as `numpy.savez_compressed` does.
fn deflate(from: &Path, to: &Path) {
    let options = zip::write::SimpleFileOptions::default();
    let options = options.compression_method(zip::CompressionMethod::Deflated);
    let mut archive = zip::ZipArchive::new(std::fs::File::open(from).unwrap()).unwrap();
    let mut small = zip::ZipWriter::new(std::fs::File::create(to).unwrap());
    for place in 0..archive.len() {
        let mut file = archive.by_index(place).unwrap();
        small.start_file(file.name().unwrap().to_string(), options).unwrap();
        std::io::copy(&mut file, &mut small).unwrap();
    }
    small.finish().unwrap();
    assert!(std::fs::metadata(to).unwrap().len() < std::fs::metadata(from).unwrap().len());
}

#[test]
fn displacements_on_a_mesh_predict_runs_that_were_held_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (body, thetas, fields) = runs(16, Design::Sobol);
    let shape = [16, body.nodes, 3];
    let shape_of_runs = shape;
    let of_theta = ("theta".to_string(), to_npy(&[16, 2], &thetas.concat()));
    let arrays = [of_theta.clone(), ("displacements".into(), to_npy(&shape, &fields.concat()))];
    npz::write(&folder.join("runs.npz"), arrays).unwrap();
    body.mesh.write_vtu(folder.join("bar.vtu")).unwrap();
    let told = done(folder, "train --from-fields runs.npz --mesh bar.vtu --parameters mu,lambda");
    assert!(told.contains("(leave-one-out)") && told.contains("; widest interval ± "), "{told}");
    deflate(&folder.join("runs.npz"), &folder.join("small.npz"));
    let [whole, small] = ["runs.npz", "small.npz"]
        .map(|name| npz::read(&folder.join(name), "displacements").unwrap());
    assert_eq!(whole, small);

    let (_, unseen, truth) = runs(30, Design::LatinHypercube);
    thetas_csv(folder, &unseen);
    let told = done(folder, "predict out/runs --theta thetas.csv --pictures 2 --out other");
    assert!(told.contains("displacement mean") && !told.contains(" mm"), "{told}");
    let out = folder.join("other/predict");
    let (shape, found) = npz::read(&out.join("cases.npz"), "displacement").unwrap();
    assert_eq!(shape, [30, body.nodes, 3]);
    // Root mean square over the nodes, run by run.
    let error = |(found, truth): (&[f64], &Vec<f64>)| {
        root_mean_square(found.iter().zip(truth).map(|(a, b)| a - b)) * 3f64.sqrt()
    };
    let errors: Vec<f64> = found.chunks(3 * body.nodes).zip(&truth).map(error).collect();
    let off = root_mean_square(errors.iter().copied());
    let stated = RunsEmulator::load(&folder.join("out/runs/emulator")).unwrap().left_out()[0].error;
    assert!(off < 1.5 * stated, "{off:e}, {stated:e} stated");
    // The largest ratio of 16: at least 22 of 30 with a probability of 0.99.
    let bounds = column(&out, "95 % error of displacement");
    let within = errors.iter().zip(&bounds).filter(|(error, bound)| error <= bound).count();
    assert!(within >= 22, "{within} of 30");
    let (mesh, _) = sinew_mesh::read_mesh::<4>(out.join("0001.vtu")).unwrap();
    assert_eq!(mesh.point_fields["displacement"].components, 3);
    assert!(out.join("cases.pvd").exists() && !out.join("0002.vtu").exists());

    // A VTU file for each run, as solvers write them.
    std::fs::create_dir(folder.join("vtu")).unwrap();
    let mut table = String::from("file,mu,lambda\n");
    let written = |run: usize, moved: f64, name: &str| {
        let mut mesh = AnyMesh::clone(&body.mesh);
        mesh.map_points(|[x, y, z]| [x + moved, y, z]);
        let field = Field::vectors(fields[run].as_chunks::<3>().0);
        mesh.point_fields_mut().insert(name.into(), field);
        mesh.write_vtu(folder.join(format!("vtu/{run}.vtu"))).unwrap();
    };
    for (run, theta) in thetas.iter().enumerate() {
        written(run, 0.0, "u");
        writeln!(table, "vtu/{run}.vtu,{},{}", theta[0], theta[1]).unwrap();
    }
    std::fs::write(folder.join("files.csv"), table).unwrap();
    let train = "train --from-table files.csv --parameters mu,lambda --files file";
    done(folder, train);
    let [archive, files] = ["runs", "files"]
        .map(|name| RunsEmulator::load(&folder.join(format!("out/{name}/emulator"))).unwrap())
        .map(|emulator| emulator.left_out()[0].error);
    // Files hold numbers as text of all their digits.
    assert!((files / archive - 1.0).abs() < 1e-9, "{files:e}, {archive:e} by an archive");
    written(3, 0.0, "v");
    let (code, named) = refused(folder, &format!("{train} --restart"));
    assert!(code == 2 && named.contains("line 5") && named.contains("`v`"), "{named}");
    written(3, 0.1, "u");
    let (code, moved) = refused(folder, &format!("{train} --restart"));
    assert!(code == 2 && moved.contains("line 5") && moved.contains("all at rest"), "{moved}");
    std::fs::remove_file(folder.join("vtu/3.vtu")).unwrap();
    let (code, lost) = refused(folder, &format!("{train} --restart"));
    assert!(code == 2 && lost.contains("line 5") && lost.contains("3.vtu"), "{lost}");

    let points = body.mesh.points().as_flattened();
    let positions: Vec<f64> =
        fields.iter().flat_map(|field| field.iter().zip(points).map(|(u, x)| u + x)).collect();
    let mut failed = fields.concat();
    failed[9 * body.nodes] = f64::NAN;
    for (values, said) in [
        (positions, "they are positions"),
        (fields[0].repeat(16), "the same in all"),
        (failed, "wrong.npz: run 3 has values of displacement that are not finite"),
    ] {
        let fields = to_npy(&[16, body.nodes, 3], &values);
        let arrays = [of_theta.clone(), ("displacements".into(), fields)];
        npz::write(&folder.join("wrong.npz"), arrays).unwrap();
        let train = "train --from-fields wrong.npz --mesh bar.vtu --parameters mu,lambda";
        let (code, wrong) = refused(folder, train);
        assert!(code == 2 && wrong.contains(said), "{wrong}");
    }

    // Names and nodes of the file beside those that are given; those of `sample --solve` are texts of one length.
    let letters =
        |word: &str| -> Vec<u8> { word.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect() };
    let words = |words: [&str; 2]| words.map(letters).concat();
    let moved: Vec<f64> = points.iter().rev().copied().collect();
    let [plain, in_pascal] = ["mu\0\0\0\0", "mu[Pa]"].map(|name| words([name, "lambda"]));
    for (names, nodes, given, said) in [
        (&plain, points, "mu,lambda", None),
        (&plain, points, "lambda,mu", Some("are mu, lambda; give --parameters in")),
        (&plain, &moved, "mu,lambda", Some("`points` of the file are not the nodes")),
        (&in_pascal, points, "mu [kPa],lambda", Some("are mu[Pa], lambda; give --parameters in")),
        (&in_pascal, points, "mu,lambda [Pa]", None),
    ] {
        let fields = to_npy(&shape_of_runs, &fields.concat());
        let arrays = [
            of_theta.clone(),
            ("displacements".into(), fields),
            ("parameters".into(), to_npy_of("<U6", &[2], names)),
            ("points".into(), to_npy(&[body.nodes, 3], nodes)),
        ];
        npz::write(&folder.join("named.npz"), arrays).unwrap();
        let read = Runs::read_fields(&folder.join("named.npz"), &folder.join("bar.vtu"), given);
        if let Ok(runs) = &read {
            let units = [0, 1].map(|at| runs.parameters[at].unit.name());
            let of_file = if given.contains('[') { "Pa" } else { "1" };
            assert_eq!(units, [of_file; 2], "{given}");
        }
        let told = read.err().map(|error| error.to_string());
        assert_eq!(told.is_some(), said.is_some(), "{told:?}");
        assert!(
            said.is_none_or(|said| told.as_ref().is_some_and(|t| t.contains(said))),
            "{told:?}"
        );
    }

    npz::write(&folder.join("short.npz"), [of_theta]).unwrap();
    let (code, short) =
        refused(folder, "train --from-fields short.npz --mesh bar.vtu --parameters mu,lambda");
    assert!(code == 2 && short.contains("no array `displacements`; it holds: theta"), "{short}");
    let (code, bare) = refused(folder, "train --from-fields runs.npz --parameters mu,lambda");
    assert!(code == 2 && bare.contains("--mesh"), "{bare}");
    let other = "[mesh]\nbox = { extent = [1.0, 1.0, 1.0], cells = [1, 1, 1] }";
    let other = BAR.replace(
        &BAR[BAR.find("[mesh]").unwrap()..BAR.find("[parameters]").unwrap()],
        &format!("{other}\n"),
    );
    let cube = Case::parse(&other, "cube.toml").unwrap().body().unwrap();
    cube.mesh.write_vtu(folder.join("cube.vtu")).unwrap();
    let (code, nodes) =
        refused(folder, "train --from-fields runs.npz --mesh cube.vtu --parameters mu,lambda");
    assert!(code == 2 && nodes.contains("runs × 8 × 3"), "{nodes}");
    // Read in mm, beside displacements in µm.
    std::fs::write(folder.join("c.pts"), "4\n0 0 0\n1e3 0 0\n0 1e3 0\n0 0 1e3\n").unwrap();
    std::fs::write(folder.join("c.elem"), "1\nTt 0 1 2 3 1\n").unwrap();
    let (code, carp) =
        refused(folder, "train --from-fields runs.npz --mesh c.pts --parameters mu,lambda");
    assert!(code == 2 && carp.contains("CARP files are in µm"), "{carp}");
}

#[test]
fn mistakes_in_a_table_are_told_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let row = |i: usize| format!("{},{},{}", 1 + i, 10 - i, i * i);
    let good: Vec<String> = std::iter::once("a,b,v".into()).chain((0..8).map(row)).collect();
    let with = |line: usize, text: &str| {
        let mut lines = good.clone();
        lines[line - 1] = text.into();
        lines.join("\n")
    };
    let constant = good.iter().map(|row| row.clone() + ",7").collect::<Vec<_>>().join("\n");
    let tables = [
        (good.join("\n"), "", "--parameters <NAMES>"),
        (
            good.join("\n"),
            "--parameters a,w",
            "line 1: there is no column `w`; the columns are: a, b, v",
        ),
        (good.join("\n"), "--parameters a,b,v", "give outputs that are not parameters"),
        (good.join("\n"), "--parameters a,b --outputs b", "give outputs that are not parameters"),
        (with(3, "x,1,2"), "--parameters a,b", "runs.csv, line 3: `x` in the column `a`"),
        (with(5, "1,2,NaN"), "--parameters a,b", "line 5: `NaN` in the column `v` is not a finite"),
        (with(4, "1,,2"), "--parameters a,b", "line 4: `` in the column `b`"),
        (
            with(4, "1,2,inf").replace("6,5,25", "6,5,-\n\n7,3,"),
            "--parameters a,b",
            "runs.csv, line 4: `inf` in the column `v` is not a finite number (and 2 more lines have such cells); mend it, or leave failed runs out: delete their lines",
        ),
        (with(4, "1,2"), "--parameters a,b", "line 4: 2 values for 3 columns; mend it"),
        (with(9, "1,10,3"), "--parameters a,b", "line 2 and line 9 have the same parameters"),
        (constant.replace("v,7", "v,w"), "--parameters a,b", "`w` is 7 in all runs"),
        (good[..6].join("\n"), "--parameters a,b", "5 runs of 2 parameters; give at least 6"),
        (good[1..].join("\n"), "--parameters a,b", "no column `a`; the columns are: 1, 10, 0"),
        (String::new(), "--parameters a,b", "the table is empty"),
        (good.join("\n").replace(',', ";"), "--parameters a,b", "separate columns by commas"),
        (
            good.join("e-171\n").replacen("e-171", "", 1) + "e-171",
            "--parameters a,b",
            "the largest magnitude of v is 4.9e-170: choose units",
        ),
        (
            good[..8].iter().map(|row| row.replace(',', "e150,")).collect::<Vec<_>>().join("\n"),
            "--parameters ae150,be150",
            "the largest magnitude of ae150 is 7.0e150: choose units",
        ),
    ];
    for (table, options, expected) in tables {
        std::fs::write(folder.join("runs.csv"), table).unwrap();
        let (code, told) = refused(folder, &format!("train --from-table runs.csv {options}"));
        assert!(code == 2 && told.contains(expected), "{options}: {told}\nnot {expected}");
    }
    // Quotes within quotes are doubled.
    let quoted = good.join("\n").replacen("a,b,v", "a,\"the \"\"b\"\", mm\",v", 1);
    std::fs::write(folder.join("runs.csv"), quoted).unwrap();
    let read = Runs::read_table(&folder.join("runs.csv"), "a,\"the \"\"b\"\", mm\"", None).unwrap();
    assert_eq!(read.parameters[1].name, "the \"b\", mm");
    let (code, both) = refused(folder, "train bar.toml --from-table runs.csv");
    assert!(code == 2 && both.contains("cannot be used with"), "{both}");
    let (code, none) = refused(folder, "train");
    assert!(code == 2 && none.contains("CASE"), "{none}");
}

#[test]
fn a_row_of_many_runs_is_no_cluster_of_twins() {
    // Neighbours are nearer than in a filled box of ten parameters, from the first run to the last.
    let parameters: Vec<_> =
        (0..10).map(|d| Parameter::linear(format!("p{d}"), "1", 0.0..=1.0)).collect();
    let thetas: Vec<_> = (0..200).map(|run| vec![f64::from(run) / 199.0; 10]).collect();
    let values = thetas.iter().map(|theta| vec![theta[0].exp()]).collect();
    let outputs = [Output { name: "y".into(), unit: "1".into(), values }];
    let emulator = RunsEmulator::fit(parameters, &thetas, &outputs, None, &mut ()).unwrap();
    assert!(emulator.warnings[0].contains("follows from the other parameters"));
}

#[test]
fn marks_of_failed_runs_are_told_with_their_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    let told = |mark: &str, at: &[usize], value: fn(f64) -> f64| {
        let row = |i: usize| match at.contains(&i) {
            true => format!("{i},{mark}\n"),
            false => format!("{i},{}\n", value(i as f64)),
        };
        let text = (1..=14).map(row).collect::<String>();
        std::fs::write(&path, format!("x,volume\n{text}")).unwrap();
        Runs::read_table(&path, "x", None).unwrap().warnings
    };
    let volume = |i: f64| 60.0 - i;
    for mark in ["-9999", "9999", "1e30", "-1e10", "999"] {
        for at in [&[6][..], &[3, 9]] {
            let found = told(mark, at, volume);
            let line = format!("in line {}", at[0] + 1);
            assert!(found.len() == 1 && found[0].contains(&line), "{mark}: {found:?}");
            assert_eq!(found[0].contains("1 more"), at.len() > 1, "{found:?}");
        }
    }
    assert_eq!(told("0", &[3, 9, 11], volume).len(), 1, "zeros");
    for mark in ["0", "-1"] {
        assert_eq!(told(mark, &[6], volume).len(), 1, "{mark}");
    }
    let found = told("-9999", &[4], |i| 300.0 * i);
    assert!(found[0].contains("volume is −9999 in line 5, far from all others"), "{found:?}");
    let smooth: [fn(f64) -> f64; 5] =
        [volume, |i| 5.0 / i, f64::exp, |i| (i - 8.0).max(0.0), |i| 1.0 / (15.0 - i)];
    for smooth in smooth {
        assert_eq!(told("", &[], smooth), Vec::<String>::new());
    }
    // Marks are in all predictions, and the file of the emulator keeps it.
    let _ = told("-9999", &[6], volume);
    done(folder.path(), "train --from-table runs.csv --parameters x");
    let said = done(folder.path(), "predict out/runs --theta x=3.5");
    assert!(said.contains("warning: volume is −9999 in line 7"), "{said}");
    // A parameter takes the same value in many runs of a design, fields have marks at nodes.
    let thetas: Vec<_> = (0..12).map(|i| vec![[1.0, 10.0, 100.0][i % 3], i as f64]).collect();
    let field = |i: usize| vec![0.1 * i as f64, if i == 5 { -9999.0 } else { 0.2 }, 0.0];
    let values = (0..12).map(field).collect();
    let output = Output { name: "displacement".into(), unit: "mm".into(), values };
    let heads = [("p", ""), ("q", "")];
    let runs = Runs::new(&heads, thetas, vec![output], |run| format!("run {run}")).unwrap();
    let [one] = &runs.warnings[..] else { panic!("{:?}", runs.warnings) };
    assert!(one.contains("displacement is −9999 in run 5"), "{one}");
}

#[test]
fn failed_runs_and_outputs_worse_than_their_mean_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.csv");
    let read = |flag: &str, bad: &str, good: &str| {
        let row = |i: usize| match i {
            5 => format!("5,0,{bad}\n"),
            _ => format!("{i},{},{good}\n", [3, 9, 1, 8, 0, 2, 9, 1, 7, 2, 8, 3, 9, 1][i - 1]),
        };
        let text = (1..=14).map(row).collect::<String>();
        std::fs::write(&path, format!("x,volume,{flag}\n{text}")).unwrap();
        let runs = Runs::read_table(&path, "x", None).unwrap();
        let told = format!("1 failed runs are left out, the first in line 6: the column `{flag}`");
        assert!(runs.warnings[0].contains(&told), "{:?}", runs.warnings);
        assert!(runs.thetas.len() == 13 && runs.outputs.len() == 1, "{flag}");
        runs
    };
    for (flag, bad, good) in [
        ("failed", "1", "0"),
        ("failed", "True", "False"),
        ("failed", "1.0", "0.0"),
        ("converged", "0.0", "1.0"),
        ("converged", "0", "1"),
        ("success", "no", "yes"),
        ("status", "NOT CONVERGED", "converged"),
    ] {
        read(flag, bad, good);
    }
    let runs = read("Failure", "diverged", "");
    let warnings = runs.fit(&mut ()).unwrap().warnings;
    let told = |warning: &String| warning.contains("predictions of volume are worse than its mean");
    assert!(warnings.iter().any(told), "{warnings:?}");
}
