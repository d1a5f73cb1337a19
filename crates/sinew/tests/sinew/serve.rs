//! Models over HTTP: derivatives are those of the values, faults are answered as the protocol says, and the server lives.

use serde_json::{Value, json};
use sinew::recipe::Regression;
use sinew::serve::Service;
use sinew::{Body, Case, Emulator, Options, Solver, Train, TrainingOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

const CASE: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
training = { held_out = 4, recipe = "regression", samples = 12 }

[mesh]
ellipsoid = { short = [22.0, 36.0], long = [58.0, 74.0], base = 0.0, cells = [1, 8, 4] }

[parameters]
mu = [8.0, 16.0]
lambda = 20.0
p = { range = [2.0, 6.0], unit = "mmHg" }
"#;

fn body() -> Body {
    Case::parse(CASE, "heart.toml").unwrap().body().unwrap()
}

fn emulator(body: &Body) -> Emulator<'_> {
    let recipe = Regression { simulations: 12, most: 12, target: 0.0 };
    let options = TrainingOptions { held_out: 4, ..TrainingOptions::default() };
    recipe.train(body, &options, &mut ()).unwrap()
}

fn asked(service: &Service<'_>, path: &str, request: &Value) -> (u16, Value) {
    let reply = service.answer("POST", path, &request.to_string());
    (reply.status, serde_json::from_str(&reply.text).unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn evaluated(service: &Service<'_>, model: &str, theta: &[f64]) -> Vec<f64> {
    let (status, found) = asked(service, "/Evaluate", &json!({ "name": model, "input": [theta] }));
    assert_eq!(status, 200, "{found}");
    numbers(&found["output"][0])
}

#[test]
fn derivatives_are_those_of_the_values() {
    let body = body();
    let service = Service::new(&body, Some(emulator(&body)));
    assert_eq!(service.models(), ["emulator", "corrected", "solver"]);
    let (theta, sens) = ([11.0, 4.0], [1e-3, 2.0, -0.5]);
    let solution = Solver::new(&body)
        .unwrap()
        .solve(&[11.0, body.parameters[1].unit.in_scene(4.0)], &Options::default())
        .unwrap();
    let solved = evaluated(&service, "solver", &theta);
    assert_eq!(solved[0], body.cavity_volumes(&solution.displacement)[0]);
    let mut apart = Vec::new();
    for model in service.models() {
        let own = evaluated(&service, model, &theta);
        apart.push((own[0] / solved[0] - 1.0).abs());
        let ask = |path: &str, name: &str, vector: &[f64]| -> Vec<f64> {
            let request =
                json!({ "name": model, "input": [theta], "outWrt": 0, "inWrt": 0, name: vector });
            let (status, found) = asked(&service, path, &request);
            assert_eq!(status, 200, "{model}: {found}");
            numbers(&found["output"])
        };
        let gradient = ask("/Gradient", "sens", &sens);
        for index in 0..2 {
            let step = 1e-3;
            let at = |by: f64| {
                let mut moved = theta;
                moved[index] += by;
                let values = evaluated(&service, model, &moved);
                values.iter().zip(sens).map(|(q, s)| q * s).sum::<f64>()
            };
            // Fourth order: the truncation of these steps is far below the bar.
            let slope =
                (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
            assert!(
                (gradient[index] / slope - 1.0).abs() < 1e-6,
                "{model}: {} {slope}",
                gradient[index]
            );
        }
        let direction = [0.3, -0.7];
        let rates = ask("/ApplyJacobian", "vec", &direction);
        let [one, other] = [
            rates.iter().zip(sens).map(|(q, s)| q * s).sum::<f64>(),
            gradient.iter().zip(direction).map(|(g, d)| g * d).sum::<f64>(),
        ];
        assert!((one / other - 1.0).abs() < 1e-6, "{model}: {one} {other}");
    }
    // A hierarchy: each is nearer to the solver than the one before.
    assert!(apart[1] < 0.1 * apart[0] && apart[2] == 0.0, "{apart:?}");
}

#[test]
fn faults_are_answered_as_the_protocol_says() {
    let body = body();
    let service = Service::new(&body, None);
    assert_eq!(service.models(), ["solver"]);
    let input = json!([[11.0, 4.0]]);
    let good =
        json!({ "name": "solver", "input": input, "outWrt": 0, "inWrt": 0, "sens": [1, 0, 0] });
    let with = |name: &str, value: Value| {
        let mut request = good.clone();
        request[name] = value;
        request.to_string()
    };
    for (path, text, kind) in [
        ("/Evaluate", "{".into(), "InvalidInput"),
        ("/Evaluate", String::new(), "InvalidInput"),
        ("/Evaluate", "[]".into(), "InvalidInput"),
        ("/Evaluate", r#"{"name": "solver", "input": [[NaN, 4.0]]}"#.into(), "InvalidInput"),
        ("/Evaluate", r#"{"name": "solver", "input": [[1e999, 4.0]]}"#.into(), "InvalidInput"),
        ("/Evaluate", with("input", json!([[null, 4.0]])), "InvalidInput"),
        ("/Evaluate", with("input", json!([[11.0, 4.0, 1.0]])), "InvalidInput"),
        ("/Evaluate", with("input", json!([[11.0], [4.0]])), "InvalidInput"),
        ("/Evaluate", with("input", json!([["11", 4.0]])), "InvalidInput"),
        ("/Evaluate", with("input", json!([[-11.0, 4.0]])), "InvalidInput"),
        ("/Evaluate", with("input", json!([[11.0, 1e6]])), "InvalidOutput"),
        ("/Evaluate", with("name", json!("emulator")), "ModelNotFound"),
        ("/Evaluate", r#"{"name": "wrong"}"#.into(), "ModelNotFound"),
        ("/Gradient", with("sens", json!([1.0])), "InvalidInput"),
        ("/Gradient", with("outWrt", json!(1)), "InvalidInput"),
        ("/Gradient", with("inWrt", json!(-1)), "InvalidInput"),
        ("/ApplyJacobian", good.to_string(), "InvalidInput"),
        ("/ApplyHessian", good.to_string(), "UnsupportedFeature"),
    ] {
        let reply = service.answer("POST", path, &text);
        let found: Value = serde_json::from_str(&reply.text).unwrap();
        assert_eq!(found["error"]["type"], kind, "{path} {text}: {found}");
        assert_eq!(reply.status, if kind == "InvalidOutput" { 500 } else { 400 }, "{text}");
        let message = found["error"]["message"].as_str().unwrap();
        assert!(message.len() > 10 && !message.contains("Err("), "{message}");
    }
    assert_eq!(service.answer("GET", "/", "").status, 404);
    assert_eq!(evaluated(&service, "solver", &[11.0, 4.0]).len(), 3);
}

#[test]
fn emulators_refuse_what_they_would_extrapolate() {
    let body = body();
    let service = Service::new(&body, Some(emulator(&body)));
    let ask = |model: &str, path: &str, config: Value| {
        let request = json!({
            "name": model, "input": [[100.0, 4.0]], "outWrt": 0, "inWrt": 0, "sens": [1, 0, 0], "config": config
        });
        asked(&service, path, &request)
    };
    for model in ["emulator", "corrected"] {
        for path in ["/Evaluate", "/Gradient"] {
            let (status, found) = ask(model, path, json!({}));
            assert_eq!((status, &found["error"]["type"]), (400, &json!("InvalidInput")), "{found}");
            let message = found["error"]["message"].as_str().unwrap();
            for words in ["mu = 100 kPa is outside its range from 8 to 16 kPa", "extrapolate"] {
                assert!(message.contains(words), "{message}");
            }
        }
        assert_eq!(ask(model, "/Evaluate", json!({ "extrapolate": true, "other": 1 })).0, 200);
    }
    assert_eq!(ask("solver", "/Evaluate", Value::Null).0, 200);
}

#[test]
fn the_page_is_given_the_displacement_of_its_nodes() {
    let body = body();
    let request = json!({ "name": "solver", "input": [[11.0, 4.0]] });
    let service = Service::new(&body, Some(emulator(&body)));
    assert_eq!(service.answer("GET", "/", "").status, 404);
    assert_eq!(asked(&service, "/Surface", &request).1["error"]["type"], "UnsupportedFeature");
    let service = service.with_page(1);
    let page = service.answer("GET", "/", "");
    assert!(page.status == 200 && page.kind.starts_with("text/html"), "{}", page.text);
    assert!(page.text.contains("fetch(\"Surface\"") && page.text.contains("viewer-page"));
    let (status, found) = asked(&service, "/Surface", &request);
    assert_eq!(status, 200, "{found}");
    let mut solver = Solver::new(&body).unwrap();
    let theta = [11.0, body.parameters[1].unit.in_scene(4.0)];
    let solution = solver.solve(&theta, &Options::default()).unwrap();
    let facets = body.mesh.boundary_facets();
    let mut nodes: Vec<usize> =
        facets.iter().flat_map(|&facet| body.mesh.nodes_of_facet(facet)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let expected = nodes.iter().flat_map(|n| &solution.displacement[3 * n..3 * n + 3]);
    let shown = numbers(&found["displacement"]);
    assert_eq!(shown.len(), 3 * nodes.len());
    // Decimals of JSON, of displacements of some millimetres.
    assert!(shown.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
}

/// A server that ends with the test.
struct Served(Child, String);

impl Drop for Served {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

fn served(folder: &std::path::Path) -> Served {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sinew"))
        .current_dir(folder)
        .args(["serve", "heart.toml", "--port", "0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let line = lines.find(|line| line.as_ref().unwrap().starts_with("serving")).unwrap().unwrap();
    let address = line.split("http://").nth(1).unwrap().to_string();
    assert!(address.starts_with("127.0.0.1:"), "{address}");
    Served(child, address)
}

/// Status and body of the answer to a request of HTTP.
fn sent(address: &str, request: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split("\r\n\r\n").nth(1).unwrap().to_string())
}

fn post(address: &str, path: &str, text: &str) -> (u16, String) {
    let length = text.len();
    sent(
        address,
        &format!(
            "POST {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: {length}\r\n\r\n{text}"
        ),
    )
}

#[test]
fn a_hundred_clients_and_nonsense_leave_the_server_alive() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("heart.toml"), CASE).unwrap();
    let server = served(folder.path());
    let address = server.1.as_str();
    let info = || sent(address, "GET /Info HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    assert_eq!(info(), (200, r#"{"models":["solver"],"protocolVersion":1.0}"#.into()));
    for nonsense in ["{", "\u{0}\u{1}", r#"{"name": "solver", "input": [[NaN]]}"#] {
        assert_eq!(post(address, "/Evaluate", nonsense).0, 400);
    }
    let (status, told) = post(address, "/Evaluate", &"[".repeat((1 << 20) + 1));
    assert!(status == 413 && told.contains("1048576 bytes"), "{status}: {told}");
    // No HTTP at all, and a client that leaves.
    TcpStream::connect(address).unwrap().write_all(b"\x16\x03\x01 nonsense\r\n\r\n").unwrap();
    TcpStream::connect(address)
        .unwrap()
        .write_all(b"POST /Evaluate HTTP/1.1\r\nContent-Length: 9999\r\n\r\n{")
        .unwrap();
    let request = r#"{"name": "solver", "input": [[11.0, 4.0]]}"#;
    let answers: Vec<_> = std::thread::scope(|scope| {
        let clients: Vec<_> =
            (0..100).map(|_| scope.spawn(|| post(address, "/Evaluate", request))).collect();
        clients.into_iter().map(|client| client.join().unwrap()).collect()
    });
    assert!(
        answers.iter().all(|answer| *answer == answers[0] && answer.0 == 200),
        "{:?}",
        answers[0]
    );
    assert_eq!(info().0, 200);
}
