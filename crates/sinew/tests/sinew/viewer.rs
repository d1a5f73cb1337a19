//! The page of an emulator: its script predicts what the program predicts, its error is right, and it refuses what it cannot hold.

use crate::page_numbers::{Regressed, indices, singles};
use crate::shells::sphere_octant;
use nalgebra::Vector3;
use serde_json::{Value, json};
use sinew::recipe::Regression;
use sinew::{
    Body, Case, Design, Emulator, Record, TestSet, Train, TrainingOptions, simulate, viewer,
};
use sinew_emulate::{Output, PodRegression, Predictor, RunsEmulator, recipe::Taylor};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Sampling, Scene, Support};
use sinew_mesh::box_tetrahedra;
use sinew_report::Viewer;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

/// Rounding of a sum of a few dozen products, relative to the largest of them.
const SUMS: f64 = 1e-12;
/// Largest distance of the script from the program, relative to the displacement: what a page promises.
const ROUNDING: f64 = 1e-6;
/// Part of the largest displacement below which it is relative to this part: kernels' weights of either sign cancel to 1e-9 of the largest.
const SMALL: f64 = 1e-2;

const BEAM: &str = r#"
law = { name = "guccione", bulk_modulus = 25.0 }
loads = [{ traction = [0.0, 0.0, 0.15], facets = "z_min" }]
supports = [{ clamped = "x_min" }]
fibres = { direction = [1.0, 0.0, 0.0] }
mesh.box = { extent = [100.0, 10.0, 10.0], cells = [8, 2, 2] }
training = { held_out = 20 }
parameters = { C = [1.75, 3.5], b_f = [1.75, 3.5], b_t = [1.75, 3.5], b_fs = [1.75, 3.5] }
"#;

const BAR: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
training = { held_out = 20 }
"#;

fn body(text: &str) -> Body {
    Case::parse(text, "case.toml").unwrap().body().unwrap()
}

fn regression(body: &Body, simulations: usize) -> Emulator<'_> {
    let recipe = Regression { simulations, most: simulations, target: 0.0 };
    recipe.train(body, &TrainingOptions::default(), &mut ()).unwrap()
}

/// A body with fibres and four parameters, its emulator and its page, made once for all tests: a page solves for hundreds of errors.
static OF_BEAM: LazyLock<(Emulator<'static>, Viewer)> = LazyLock::new(|| {
    let emulator = regression(Box::leak(Box::new(body(BEAM))), 30);
    let page = viewer(&emulator, 1, &mut ()).unwrap();
    (emulator, page)
});

/// Answer of code that follows the page's own script and reads `data` and `thetas`; `None` without node.
fn by_script<T: serde::de::DeserializeOwned>(
    page: &str,
    thetas: &[Vec<f64>],
    code: &str,
) -> Option<T> {
    if Command::new("node").arg("--version").output().is_err() {
        eprintln!("skipped: there is no node on this machine to run the page's script");
        return None;
    }
    let data = page.split("<script type=\"application/json\">").nth(1).unwrap();
    let data = data.split("</script>").next().unwrap();
    let script = page.rsplit("<script>").next().unwrap().split("</script>").next().unwrap();
    let run = format!(
        "{script}\nconst data = {data}; const thetas = {};
        const {{ array, regression, shareOf, volumeOf }} = globalThis.sinewViewer;
        const [{{ parameters, displacement, cavities }}, points] = [data.emulator, array(Float32Array, data.points)];
        const model = regression(displacement);
        const all = thetas.map((theta) => Array.from(model(theta.map((value, i) => shareOf(parameters[i], value)))));
        {code}",
        json!(thetas)
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.cjs");
    std::fs::write(&file, run).unwrap();
    let output = Command::new("node").arg(&file).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    eprintln!("{told}");
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

/// Parameter sets at which pages are compared with their emulators: within the ranges and at their corners.
fn thetas_of(emulator: &Emulator<'_>) -> Vec<Vec<f64>> {
    let parameters = &emulator.body().parameters;
    let corner = |bits: usize| {
        parameters.iter().enumerate().map(|(i, p)| p.range[bits >> i & 1]).collect::<Vec<f64>>()
    };
    let within = Design::Uniform.sample(parameters, 100, 7).unwrap();
    within.into_iter().chain((0..1 << parameters.len()).map(corner)).collect()
}

/// Largest distance of displacements of points from the emulator's over parameter sets, relative to the displacement.
fn distance(
    emulator: &Emulator<'_>,
    thetas: &[Vec<f64>],
    fields: &[Vec<f64>],
    points: &[f64],
) -> f64 {
    let body = emulator.body();
    let single = |x: &[f64; 3]| x.map(|x| (x as f32).to_bits());
    let nodes: Vec<usize> = points
        .as_chunks::<3>()
        .0
        .iter()
        .map(|x| body.positions.iter().position(|own| single(own) == single(x)).unwrap())
        .collect();
    let predicted = emulator.predict(thetas).unwrap();
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let largest = (0..thetas.len())
        .map(|case| {
            norm(&mut nodes.iter().flat_map(|n| predicted.field(case)[3 * n..3 * n + 3].to_vec()))
        })
        .fold(0.0, f64::max);
    let apart = (0..thetas.len()).map(|case| {
        let (own, all) = (&fields[case], predicted.field(case));
        let truth: Vec<f64> = nodes.iter().flat_map(|n| all[3 * n..3 * n + 3].to_vec()).collect();
        assert_eq!(own.len(), truth.len());
        let size = norm(&mut truth.iter().copied()).max(SMALL * largest);
        norm(&mut own.iter().zip(&truth).map(|(a, b)| a - b)) / size
    });
    apart.fold(0.0, f64::max)
}

/// [`distance`] of the page's script; `None` without node.
fn distance_of_script(viewer: &Viewer, emulator: &Emulator<'_>) -> Option<f64> {
    let thetas = thetas_of(emulator);
    let code = "const start = performance.now();
        for (let i = 0; i < 1000; i++) model([(0.37 * i) % 1, (0.61 * i) % 1, 0.5, 0.5, 0.5].slice(0, parameters.length));
        console.error(`${(performance.now() - start) / 1000} ms a prediction`);
        console.log(JSON.stringify([all, Array.from(points)]));";
    let (fields, points): (Vec<Vec<f64>>, Vec<f64>) = by_script(&viewer.to_html(), &thetas, code)?;
    Some(distance(emulator, &thetas, &fields, &points))
}

/// [`distance`] of the regression that the page's numbers are.
fn distance_of_numbers(viewer: &Viewer, emulator: &Emulator<'_>) -> f64 {
    let (thetas, data) = (thetas_of(emulator), serde_json::to_value(viewer).unwrap());
    let parameters = &emulator.body().parameters;
    let shares = |theta: &Vec<f64>| -> Vec<f64> {
        let each = parameters.iter().zip(theta);
        each.map(|(p, x)| match (p.sampling, p.range) {
            (Sampling::Log, [a, b]) => (x / a).ln() / (b / a).ln(),
            (_, [a, b]) => (x - a) / (b - a),
        })
        .collect()
    };
    let model = Regressed::read(&data["emulator"]["displacement"]);
    let fields: Vec<Vec<f64>> = thetas.iter().map(|theta| model.at(&shares(theta))).collect();
    distance(emulator, &thetas, &fields, &singles(&data["points"]))
}

/// Lines lie along fibres of direction x in all triangles but those at right angles to it, with 0.9 roots of the area.
fn check_strokes(viewer: &Viewer) {
    let data = serde_json::to_value(viewer).unwrap();
    let (points, corners) = (singles(&data["points"]), indices(&data["triangles"]));
    let drawn = indices(&data["strokes"]["triangles"]);
    let along = singles(&data["strokes"]["along"]);
    let sides = |triangle: usize| {
        let corner = |k: usize| {
            let node = corners[3 * triangle + k];
            Vector3::from_column_slice(&points[3 * node..][..3])
        };
        [1, 2].map(|k| corner(k) - corner(0))
    };
    let across = |triangle: usize| sides(triangle).iter().all(|side| side[0].abs() < 1e-4);
    let expected: Vec<usize> = (0..corners.len() / 3).filter(|t| !across(*t)).collect();
    assert!(!expected.is_empty() && drawn == expected, "{} {}", drawn.len(), expected.len());
    for (triangle, parts) in drawn.iter().zip(along.as_chunks::<2>().0) {
        let [p, q] = sides(*triangle);
        let half: Vector3<f64> = parts[0] * p + parts[1] * q;
        let area = 0.5 * p.cross(&q).norm();
        // Rounding to 32 bits.
        assert!(half[1].abs().max(half[2].abs()) < 1e-5 * half[0].abs(), "{half:?}");
        assert!((half[0].abs() / (0.45 * area.sqrt()) - 1.0).abs() < 1e-5, "{half:?} {area}");
    }
}

/// Shares at -1 and 0 of a logarithmic parameter, at 0 of a linear one from -1 to 5, and how many of a thousand numbers have none.
const TYPED: &str = "const { shareTyped } = globalThis.sinewViewer;
    const [log, linear] = [{ range: [8, 16], logarithmic: true, size: 1 }, { range: [-0.5, 2.5], logarithmic: false, size: 0.5 }];
    const typed = [0, -0, -1, 5e-324, 1e308, -1e308, ...Array.from({ length: 1000 }, (_, i) => Math.sin(i * i) * 10 ** ((i % 80) - 40))];
    const without = typed.flatMap((x) => [log, linear].map((p) => shareTyped(p, x))).filter((share) => !(share >= 0 && share <= 1));
    console.log(JSON.stringify([shareTyped(log, -1), shareTyped(log, 0), 6 * shareTyped(linear, 0), without.length]));";

/// Number of shown errors out of a hundred that are right, as the page says.
fn right(viewer: &Viewer) -> usize {
    let told = &viewer.facts.iter().find(|(name, _)| name == "shown error").unwrap().1;
    told.split(" in ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
}

/// The page's numbers and its script predict what the emulator does, and its error is right.
fn check_page(viewer: &Viewer, emulator: &Emulator<'_>) {
    assert!(emulator.predictor.regression().is_some(), "{}", emulator.record.about);
    assert!(right(viewer) >= 90, "{:?}", viewer.facts);
    let distance = distance_of_numbers(viewer, emulator);
    assert!(distance < ROUNDING, "{distance:e}");
    if let Some(distance) = distance_of_script(viewer, emulator) {
        assert!(distance < ROUNDING, "{distance:e}");
    }
    // Names of a case are text.
    let named = "console.log(JSON.stringify(globalThis.sinewViewer.chart(['<b>&', 'y'.repeat(80)], [0, 1], [0, 1], [], [0, 0])));";
    let drawn = by_script::<String>(&viewer.to_html(), &[], named);
    assert!(
        drawn.is_none_or(|svg| svg.contains("&#60;b&#62;&#38;") && !svg.contains(&"y".repeat(60)))
    );
    let shares = by_script::<Vec<f64>>(&viewer.to_html(), &[], TYPED);
    assert!(shares.is_none_or(|shares| shares == [0.0, 0.0, 1.0, 0.0]));
}

#[test]
fn the_script_predicts_as_the_program_does() {
    let body = body(BAR);
    let emulator = regression(&body, 12);
    let page = viewer(&emulator, 1, &mut ()).unwrap();
    assert!(page.strokes.is_none());
    check_page(&page, &emulator);
    let (emulator, page) = &*OF_BEAM;
    check_page(page, emulator);
    check_strokes(page);
}

#[test]
fn the_script_encloses_the_volume_that_the_program_does() {
    let lid = "law = \"neo-hookean\"\nloads = [{ pressure = \"p\", facets = \"endo\" }]\nsupports = [{ clamped = \"base\" }]\n\
        mesh.ellipsoid = { short = [20.0, 30.0], long = [50.0, 60.0], base = 10.0, cells = [1, 8, 4] }\n\
        parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0], p = { range = [0.0, 1.0], sampling = \"linear\" } }\ntraining.held_out = 10\n";
    // A flat lid, whose volume is negative where the pressure pulls.
    let flat = BAR
        .replace(
            "loads = [",
            "loads = [{ pressure = \"p\", facets = \"z_max\", rim = \"closed\" }, ",
        )
        .replace(
            "lambda = [8.0, 16.0]",
            "lambda = 12.0, p = { range = [-0.02, 0.01], sampling = \"linear\" }",
        );
    // An octant of a ball, which symmetry planes close.
    let rollers = [("x_min", 0), ("y_min", 1), ("z_min", 2)];
    let load = Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Theta(2) };
    let octant = sphere_octant([13.0, 21.0], [2, 3]).tetrahedra();
    let octant = Scene::new(octant, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .parameter(Parameter::linear("p", "kPa", 0.5..=1.0))
        .load(load);
    let octant = rollers.into_iter().fold(octant, |scene, (nodes, axis)| {
        let row = std::array::from_fn(|i| (i == axis).then_some(0.0));
        scene.support(Support::uniform(nodes, row))
    });
    for body in [body(lid), body(&flat), octant.lower().unwrap()] {
        let emulator = regression(&body, 20);
        let thetas = Design::Uniform.sample(&body.parameters, 5, 3).unwrap();
        let code = "const parts = cavities[0].parts.map((part) => ({ ...part, triangles: array(Uint32Array, part.triangles) }));
            console.log(JSON.stringify(all.map((u) => volumeOf(parts, Array.from(points, (x, i) => x + u[i])))));";
        let page = viewer(&emulator, 1, &mut ()).unwrap();
        let distance = distance_of_numbers(&page, &emulator);
        assert!(distance < ROUNDING, "{distance:e}");
        let page = page.to_html();
        let Some(volumes) = by_script::<Vec<f64>>(&page, &thetas, code) else { return };
        let fields = emulator.predict(&thetas).unwrap().fields();
        for (found, field) in volumes.iter().zip(&fields) {
            let ratio = found / body.cavity_volumes(field)[0];
            assert!((ratio - 1.0).abs() < ROUNDING, "{ratio}");
        }
    }
}

#[test]
fn an_expansion_is_regressed_and_its_added_error_is_told() {
    let body = body(BAR);
    let mut emulator = Taylor.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let held_out = &mut emulator.record.held_out.as_mut().unwrap().relative.mean;
    // An error far below the page's rounding, which nobody sees.
    let own = std::mem::replace(held_out, 1e-10);
    let page = viewer(&emulator, 1, &mut ()).unwrap();
    assert!(page.facts.iter().any(|(name, _)| name.starts_with("added")), "{:?}", page.facts);
    assert!(right(&page) >= 90, "{:?}", page.facts);
    if let Some(distance) = distance_of_script(&page, &emulator) {
        assert!(distance < own, "{distance:e} for {own:e}");
    }
    assert_eq!(viewer(&emulator, 1, &mut ()).unwrap(), page, "the same seed gives the same page");
}

/// An expansion with a ripple that no polynomial follows.
#[derive(Debug)]
struct Rippled<'b>(Box<dyn Predictor + 'b>);

impl Predictor for Rippled<'_> {
    fn kind(&self) -> &'static str {
        "rippled"
    }

    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> sinew_emulate::Result<Vec<f64>> {
        let mut fields = self.0.predict(body, thetas)?;
        for (theta, field) in thetas.iter().zip(fields.chunks_mut(3 * body.nodes)) {
            let ripple = 1.0 + 0.05 * (300.0 * theta[0]).sin();
            field.iter_mut().for_each(|u| *u *= ripple);
        }
        Ok(fields)
    }

    fn save(&self, _: &Path) -> sinew_emulate::Result<()> {
        Ok(())
    }
}

#[test]
fn what_a_page_cannot_hold_is_refused_with_numbers() {
    let body = body(BAR);
    let Emulator { predictor, mut record, .. } =
        Taylor.train(&body, &TrainingOptions::default(), &mut ()).unwrap();
    let rippled = Emulator::new(&body, Box::new(Rippled(predictor)), record.clone());
    // Its own error is that of the ripple, which the held-out cases see.
    let thetas = Design::Uniform.sample(&body.parameters, 20, 3).unwrap();
    let test = TestSet::new(&body, simulate(&body, &thetas, "test", None, &mut ()).unwrap());
    record.held_out = Some(test.errors(&rippled.predict(&test.thetas).unwrap().fields()).unwrap());
    let rippled = Emulator::new(&body, rippled.predictor, record);
    let error = viewer(&rippled, 1, &mut ()).unwrap_err().to_string();
    assert!(error.contains("more than a third of the emulator's own error"), "{error}");
    let unmeasured = Emulator::new(&body, rippled.predictor, Record::new("rippled"));
    let error = viewer(&unmeasured, 1, &mut ()).unwrap_err().to_string();
    assert!(error.contains("not measured on held-out cases"), "{error}");
}

#[test]
fn a_page_is_one_small_file_that_asks_for_nothing() {
    let page = OF_BEAM.1.to_html();
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    for address in ["http:", "https:", "src=", "@import", "fetch(", "XMLHttpRequest"] {
        assert!(!page.contains(address), "{address}");
    }
    let script = page.rsplit("<script>").next().unwrap().split("</script>").next().unwrap();
    assert!(script.lines().count() <= 500, "{} lines", script.lines().count());
    let data = page.split("<script type=\"application/json\">").nth(1).unwrap();
    let data: Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    let names: Vec<_> = data["quantities"].as_array().unwrap().iter().map(|q| &q["name"]).collect();
    assert_eq!(names, ["Displacement", "Fibre stretch", "Fibre stress", "Error"]);
    // Colours take fewer bytes than displacements, which have an error a thousandth as large.
    let bytes = |model: &Value| {
        let rows = model["modes"].as_array().unwrap();
        let size = |row: &Value| row["integers"].as_str().unwrap().len();
        8 * rows.iter().map(size).max().unwrap() / model["mean"].as_str().unwrap().len()
    };
    let displacement = bytes(&data["emulator"]["displacement"]);
    let stretch = bytes(&data["quantities"][1]["model"]);
    assert!(stretch < displacement, "{stretch} {displacement}");
    let mesh = data["emulator"]["mesh"].as_str().unwrap();
    assert!(mesh.starts_with("discretisation error, not in the estimated one: "), "{mesh}");
}

#[test]
fn a_regression_is_the_sum_of_its_parts() {
    let parameters =
        [Parameter::log("k", "kPa", 1.0..=3.0), Parameter::linear("q", "1", 0.0..=2.0)];
    let thetas: Vec<Vec<f64>> = (0..30)
        .map(|i| vec![1.0 + 2.0 * (0.37 * i as f64).fract(), 2.0 * (0.61 * i as f64).fract()])
        .collect();
    let field = |t: &Vec<f64>| vec![5.0 / t[0], (0.3 * t[0] * t[1]).sin(), t[1].exp(), t[0] + t[1]];
    let fields: Vec<_> = thetas.iter().map(field).collect();
    let by_process = PodRegression::fit(&parameters, &thetas, &fields).unwrap();
    let by_polynomial = PodRegression::fit_polynomial(&parameters, &thetas, &fields, 3).unwrap();
    assert!(by_polynomial.parts().lengths.is_empty() && by_polynomial.leave_one_out() < 0.02);
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let (name, unit) = ("displacement".into(), "mm".into());
    let repeated = fields.iter().map(|field| field.iter().copied().cycle().take(24).collect());
    let output = Output { name, unit, values: repeated.collect() };
    let runs =
        RunsEmulator::fit(parameters.to_vec(), &thetas, &[output], Some(mesh.into()), &mut ());
    let by_processes = runs.unwrap().regression().unwrap().clone();
    assert_eq!(by_processes.parts().lengths.len(), 3 * 2, "a set of lengths for each trend");
    for regression in [by_process, by_polynomial, by_processes] {
        let (parts, theta) = (regression.parts(), [2.2f64, 0.7]);
        let share = [theta[0].ln() / 3f64.ln(), theta[1] / 2.0];
        let x = share.map(|s| 12f64.sqrt() * (s - 0.5));
        let sets = parts.lengths.chunks(2);
        let of_sets = sets.flat_map(|lengths| parts.points.iter().map(move |p| (lengths, p)));
        let kernels = of_sets.map(|(lengths, p)| {
            let square = |d: usize| ((x[d] - p[d]) / lengths[d]).powi(2);
            (-0.5 * (square(0) + square(1))).exp()
        });
        let monomials = parts.exponents.iter().map(|e| x[0].powi(e[0]) * x[1].powi(e[1]));
        let functions: Vec<f64> = kernels.chain(monomials).collect();
        let mut sum = parts.mean.to_vec();
        for (k, mode) in parts.modes.iter().enumerate() {
            let c: f64 = functions.iter().zip(&parts.weights).map(|(f, row)| f * row[k]).sum();
            sum.iter_mut().zip(*mode).for_each(|(sum, m)| *sum += c * m);
        }
        let size = functions.iter().map(|f| f.abs()).sum::<f64>();
        let largest = parts.weights.iter().flatten().fold(1.0, |m: f64, w| m.max(w.abs()));
        for (own, predicted) in sum.iter().zip(regression.predict(&theta).unwrap()) {
            assert!((own - predicted).abs() < SUMS * size * largest, "{own} {predicted}");
        }
    }
}
