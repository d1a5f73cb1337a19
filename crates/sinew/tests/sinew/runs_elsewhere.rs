//! Emulators of stored runs for other programs: models over HTTP, and a page for a browser.

use crate::page_numbers::{Regressed, singles};
use crate::posteriors_of_runs::two_numbers;
use crate::program::{done, refused};
use crate::runs::runs;
use crate::serve::{asked, numbers, post, started};
use serde_json::{Value, json};
use sinew::emulate::{Output, RunsEmulator, share_of};
use sinew::serve::Service;
use sinew::{Design, viewer_of_runs};

/// Displacements of the bar by 16 runs.
fn displacements() -> RunsEmulator {
    let (body, thetas, values) = runs(16, Design::Sobol);
    let output = Output { name: "displacement".into(), unit: "1".into(), values };
    let mesh = sinew_mesh::AnyMesh::clone(&body.mesh);
    RunsEmulator::fit(body.parameters.clone(), &thetas, &[output], Some(mesh), &mut ()).unwrap()
}

#[test]
fn numbers_of_runs_are_models_with_derivatives() {
    let (emulator, _) = two_numbers(12);
    let service = Service::of_runs(&emulator);
    assert_eq!(service.models(), ["emulator", "deviation"]);
    let [input, output] = service.heads("emulator");
    assert_eq!(
        (input, output),
        (vec!["k [kPa]".into(), "angle [deg]".into()], vec!["volume [ml]".into(), "strain".into()])
    );
    let (theta, sens, direction) = ([3.0, -20.0], [0.3, 40.0], [0.2, 5.0]);
    for model in service.models() {
        let ask = |path: &str, theta: [f64; 2], name: &str, vector: [f64; 2]| -> Vec<f64> {
            let request =
                json!({ "name": model, "input": [theta], "outWrt": 0, "inWrt": 0, name: vector });
            let (status, found) = asked(&service, path, &request);
            assert_eq!(status, 200, "{model}: {found}");
            numbers(if path == "/Evaluate" { &found["output"][0] } else { &found["output"] })
        };
        let found = emulator.predict(&theta).unwrap();
        for (own, found) in ask("/Evaluate", theta, "sens", sens).iter().zip(found) {
            // 1.96 standard deviations are the half-width of an interval.
            let expected =
                if model == "emulator" { found.values[0] } else { found.half_width / 1.96 };
            assert!((own / expected - 1.0).abs() < 1e-6, "{model}: {own} {expected}");
        }
        let gradient = ask("/Gradient", theta, "sens", sens);
        for d in 0..2 {
            // The variance is a small difference of numbers of order one, so that steps are long.
            let step = 2e-3 * theta[d].abs();
            let at = |by: f64| {
                let mut moved = theta;
                moved[d] += by * step;
                ask("/Evaluate", moved, "sens", sens)
                    .iter()
                    .zip(sens)
                    .map(|(q, s)| q * s)
                    .sum::<f64>()
            };
            let slope = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step);
            assert!((gradient[d] / slope - 1.0).abs() < 1e-4, "{model}: {} {slope}", gradient[d]);
        }
        let rates = ask("/ApplyJacobian", theta, "vec", direction);
        let dot = |a: &[f64], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let (one, other) = (dot(&rates, sens), dot(&gradient, direction));
        assert!((one / other - 1.0).abs() < 1e-12, "{model}: {one} {other}");
        let far = |config: Value| {
            asked(
                &service,
                "/Evaluate",
                &json!({ "name": model, "input": [[30.0, 0.0]], "config": config }),
            )
        };
        let (status, told) = far(json!({}));
        let told = told["error"]["message"].as_str().unwrap();
        assert!(status == 400 && told.contains("k = 30 kPa is outside its range"), "{told}");
        assert!(!told.contains("solver") && far(json!({ "extrapolate": true })).0 == 200, "{told}");
    }
    for (path, name, input, kind) in [
        ("/Evaluate", "solver", json!([[3.0, 0.0]]), "ModelNotFound"),
        ("/Evaluate", "emulator", json!([[3.0]]), "InvalidInput"),
        ("/Evaluate", "emulator", json!([[-3.0, 0.0]]), "InvalidOutput"),
        ("/Surface", "emulator", json!([[3.0, 0.0]]), "UnsupportedFeature"),
    ] {
        let config = json!({ "extrapolate": true });
        let request = json!({ "name": name, "input": input, "config": config });
        let (status, found) = asked(&service, path, &request);
        assert_eq!(status, if kind == "InvalidOutput" { 500 } else { 400 }, "{found}");
        assert_eq!(found["error"]["type"], kind, "{found}");
    }
}

#[test]
fn displacements_of_runs_are_a_model_without_derivatives() {
    let emulator = displacements();
    let service = Service::of_runs(&emulator);
    assert_eq!(service.models(), ["emulator"]);
    let request = json!({ "name": "emulator", "input": [[10.0, 12.0]], "outWrt": 0, "inWrt": 0, "sens": [1, 0, 0] });
    let found = emulator.predict(&[10.0, 12.0]).unwrap().remove(0);
    let [mean, largest] = sinew::output::mean_and_largest(&found.values);
    let (_, told) = asked(&service, "/Evaluate", &request);
    assert_eq!(numbers(&told["output"][0]), [mean, largest, found.half_width]);
    assert_eq!(asked(&service, "/ModelInfo", &request).1["support"]["Gradient"], false);
    let (status, told) = asked(&service, "/Gradient", &request);
    assert_eq!((status, &told["error"]["type"]), (400, &json!("UnsupportedFeature")), "{told}");
}

#[test]
fn a_page_of_runs_has_their_displacement_and_their_error() {
    let emulator = displacements();
    let page = viewer_of_runs(&emulator, "bar", 1).unwrap();
    let data = serde_json::to_value(&page).unwrap();
    let [motion, error] =
        ["displacement", "error"].map(|name| Regressed::read(&data["emulator"][name]));
    let mesh = emulator.mesh.as_ref().unwrap();
    let single = |x: &[f64]| [0, 1, 2].map(|i| (x[i] as f32).to_bits());
    let place = |x: &[f64; 3]| mesh.points().iter().position(|own| single(own) == single(x));
    let nodes: Vec<usize> =
        singles(&data["points"]).as_chunks().0.iter().map(|x| place(x).unwrap()).collect();
    let (mut right, norm) = (0, |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt());
    for theta in Design::Uniform.sample(&emulator.parameters, 50, 7).unwrap() {
        let shares: Vec<f64> =
            emulator.parameters.iter().zip(&theta).map(|(p, x)| share_of(p, *x)).collect();
        let found = emulator.predict(&theta).unwrap().remove(0);
        let truth: Vec<f64> =
            nodes.iter().flat_map(|node| found.values[3 * node..3 * node + 3].to_vec()).collect();
        let apart: Vec<f64> = motion.at(&shares).iter().zip(&truth).map(|(a, b)| a - b).collect();
        // What a page promises.
        assert!(norm(&apart) < 1e-6 * norm(&truth), "{:e}", norm(&apart) / norm(&truth));
        let ratio = error.at(&shares)[0].exp() / found.half_width;
        right += usize::from((1.0 / 3.0..=3.0).contains(&ratio));
    }
    assert!(right >= 45, "{right} of 50 errors");
    let told = &page.facts.iter().find(|(name, _)| name == "shown error").unwrap().1;
    assert!(told.starts_with("within a factor of 3 of the emulator's in "), "{told}");
    assert_eq!(viewer_of_runs(&emulator, "bar", 1).unwrap(), page, "the same seed, the same page");
}

#[test]
fn the_program_serves_runs_and_exports_their_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    displacements().save(&folder.join("bars/emulator")).unwrap();
    two_numbers(12).0.save(&folder.join("numbers/emulator")).unwrap();
    let told = done(folder, "export bars --page");
    assert!(told.contains("error of runs left out: ") && told.contains("MB"), "{told}");
    done(&folder.join("bars"), "export . --page --out ../pages/bars");
    let page = std::fs::read_to_string(folder.join("bars/emulator.html")).unwrap();
    assert_eq!(std::fs::read_to_string(folder.join("pages/bars/emulator.html")).unwrap(), page);
    assert!(page.contains("<title>bars</title>") && page.len() < 200_000, "{}", page.len());
    for (command, said) in [
        ("export numbers --page", "this emulator has numbers alone; train it with --from-fields"),
        ("export bars --page --emulator other", "leave --weights, --emulator and --mesh out"),
        #[cfg(feature = "networks")]
        ("export bars --page --weights", "leave --weights, --emulator and --mesh out"),
        ("serve bars --emulator other", "leave --emulator and --mesh out"),
    ] {
        let (code, told) = refused(folder, command);
        assert!(code == 2 && told.contains(said), "{command}: {told}");
    }
    let server = started(folder, "numbers", &[]);
    let request = r#"{"name": "emulator", "input": [[3.0, -20.0]]}"#;
    let (status, told) = post(&server.1, "/Evaluate", request);
    assert!(status == 200 && told.starts_with(r#"{"output":[[7"#), "{told}");
}
