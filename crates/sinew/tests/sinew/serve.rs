//! Models over HTTP: derivatives are those of the values, faults are answered as the protocol says, and the server lives.

use serde_json::{Value, json};
use sinew::recipe::Regression;
use sinew::serve::Service;
use sinew::{Body, Case, Emulator, Options, PatientFile, Solver, Train, TrainingOptions};
use sinew_calibrate::Forward;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

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

pub(crate) fn asked(service: &Service<'_>, path: &str, request: &Value) -> (u16, Value) {
    let reply = service.answer("POST", path, &request.to_string());
    (reply.status, serde_json::from_str(&reply.text).unwrap())
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
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

#[test]
fn a_patient_s_data_are_those_of_a_calibration() {
    let [x, y, z] = body().positions[3];
    let data = format!(
        "[phases]\nimage = {{ p = \"2 mmHg\" }}\nlate = {{ p = \"5 mmHg\" }}\n
        [[data]]\nvolume = \"endo\"\nphase = \"late\"\nvalue = 70.0\nunit = \"mL\"\nsd = \"3 %\"\n
        [[data]]\ndisplacement = [0.0, 0.0, 1.0]\npoint = [{x}, {y}, {z}]\nphase = \"late\"\nvalue = -0.1\nunit = \"mm\"\nsd = 0.1\n"
    );
    let prepared =
        PatientFile::parse(&(CASE.to_owned() + &data), "p.toml").unwrap().prepare().unwrap();
    let service = Service::new(&prepared.body, None).with_patient(&prepared).unwrap();
    assert_eq!(service.models(), ["solver", "patient"]);
    let [input, output] = service.heads("patient");
    assert_eq!(
        (input, output[1].as_str()),
        (vec!["mu [kPa]".into()], "volume of endo at late [mL]")
    );
    let seen = prepared.patient().unwrap().observe(&[11.0], false).unwrap().values;
    let values = evaluated(&service, "patient", &[11.0]);
    // Data stand in the order of their names.
    assert_eq!(values, [seen[1], seen[0] / 1e3]);
    let ask = |path: &str, name: &str, vector: Value| {
        let request =
            json!({ "name": "patient", "input": [[11.0]], "outWrt": 0, "inWrt": 0, name: vector });
        let (status, found) = asked(&service, path, &request);
        assert_eq!(status, 200, "{found}");
        numbers(&found["output"])
    };
    let [above, below] =
        [1.0, -1.0].map(|sign| evaluated(&service, "patient", &[11.0 + 0.01 * sign]));
    let rates = ask("/ApplyJacobian", "vec", json!([1.0]));
    let gradient = ask("/Gradient", "sens", json!([2.0, 30.0]))[0];
    for (rate, (above, below)) in rates.iter().zip(above.iter().zip(&below)) {
        // Truncation of second order.
        assert!((rate / ((above - below) / 0.02) - 1.0).abs() < 1e-4, "{rate} {above} {below}");
    }
    assert!((gradient / (2.0 * rates[0] + 30.0 * rates[1]) - 1.0).abs() < 1e-12);
    for (path, input, kind) in [
        ("/Evaluate", -1.0, "InvalidInput"),
        ("/Evaluate", 1e308, "InvalidInput"),
        ("/Surface", 11.0, "UnsupportedFeature"),
        ("/Evaluate", 1e-3, "InvalidOutput"),
    ] {
        let (_, found) = asked(&service, path, &json!({ "name": "patient", "input": [[input]] }));
        assert_eq!(found["error"]["type"], kind, "{found}");
    }
}

/// A server that ends with the test.
pub(crate) struct Served(Child, pub(crate) String);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        self.0.wait().unwrap();
    }
}

fn served(folder: &std::path::Path, options: &[&str]) -> Served {
    std::fs::write(folder.join("heart.toml"), CASE).unwrap();
    started(folder, "heart.toml", options)
}

pub(crate) fn started(folder: &std::path::Path, case: &str, options: &[&str]) -> Served {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sinew"))
        .current_dir(folder)
        .args(["serve", case, "--port", "0"])
        .args(options)
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
    received(opened(address, request))
}

fn opened(address: &str, request: &str) -> TcpStream {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

fn received(mut stream: TcpStream) -> (u16, String) {
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split("\r\n\r\n").nth(1).unwrap().to_string())
}

pub(crate) fn post(address: &str, path: &str, text: &str) -> (u16, String) {
    sent(address, &posted(path, text))
}

fn posted(path: &str, text: &str) -> String {
    let length = text.len();
    format!(
        "POST {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: {length}\r\n\r\n{text}"
    )
}

#[test]
fn a_hundred_clients_and_nonsense_leave_the_server_alive() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(folder.path(), &[]);
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

#[test]
fn requests_that_do_not_arrive_hold_nobody_up() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(folder.path(), &["--threads", "1", "--timeout", "3"]);
    let address = server.1.as_str();
    let half = |request: &str| {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        stream
    };
    let body = "POST /Evaluate HTTP/1.1\r\nHost: x\r\nContent-Length: 5000\r\n\r\n{";
    let held = [body, body, "GET /Info HTTP/1.1\r\nHo"].map(half);
    let start = Instant::now();
    let (status, told) =
        post(address, "/Evaluate", r#"{"name": "solver", "input": [[11.0, 4.0]]}"#);
    assert!(status == 200 && start.elapsed() < Duration::from_secs(3), "{status}: {told}");
    for mut stream in held {
        let mut told = String::new();
        stream.read_to_string(&mut told).unwrap();
        assert!(told.starts_with("HTTP/1.1 408 ") && told.contains("within 3 s"), "{told}");
    }
}

#[test]
fn a_signal_ends_the_server_with_every_request_answered() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = served(folder.path(), &["--threads", "1"]);
    let request = posted(
        "/ApplyJacobian",
        r#"{"name": "solver", "input": [[11.0, 4.0]], "outWrt": 0, "inWrt": 0, "vec": [1, 0]}"#,
    );
    // All have asked before the signal comes, which is when one of them is answered.
    let clients: Vec<_> = (0..80).map(|_| opened(&server.1, &request)).collect();
    let pid = server.0.id().to_string();
    let answers: Vec<_> = std::thread::scope(|scope| {
        let (answered, first) = mpsc::channel();
        let receive = |client| {
            let answered = answered.clone();
            scope.spawn(move || {
                let answer = received(client);
                // Only the first one is waited for.
                let _ = answered.send(());
                answer
            })
        };
        let clients: Vec<_> = clients.into_iter().map(receive).collect();
        first.recv().unwrap();
        assert!(Command::new("kill").arg(pid).status().unwrap().success());
        clients.into_iter().map(|client| client.join().unwrap()).collect()
    });
    assert_eq!(server.0.wait().unwrap().code(), Some(0));
    let (given, refused): (Vec<_>, Vec<_>) = answers.iter().partition(|answer| answer.0 == 200);
    assert!(!given.is_empty() && !refused.is_empty(), "{} given", given.len());
    for (status, told) in refused {
        assert!(*status == 503 && told.contains("the server is ending"), "{status}: {told}");
    }
}

#[test]
fn requests_are_read_as_clients_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let server = served(folder.path(), &[]);
    let body = r#"{"name": "solver", "input": [[11.0, 4.0]]}"#;
    let (length, half) = (body.len(), body.len() / 2);
    let (one, other) = body.split_at(half);
    let rest = length - half;
    // Three on one connection: a length, chunks after a question whether to go on, and a HEAD.
    let requests = format!(
        "POST /Evaluate HTTP/1.1\r\nHost: x\r\ncontent-length: {length}\r\n\r\n{body}\
         POST /Evaluate?x=1 HTTP/1.1\r\nTransfer-Encoding: chunked\r\nExpect: 100-continue\r\n\r\n\
         {half:x}\r\n{one}\r\n{rest:X};more\r\n{other}\r\n0\r\nTrailer: 1\r\n\r\n\
         HEAD /Info HTTP/1.1\r\nConnection: close\r\n\r\n"
    );
    let mut stream = TcpStream::connect(&server.1).unwrap();
    stream.write_all(requests.as_bytes()).unwrap();
    let mut told = String::new();
    stream.read_to_string(&mut told).unwrap();
    let values: Vec<_> =
        told.split(r#"{"output":[["#).skip(1).map(|v| v.split(']').next()).collect();
    assert!(values.len() == 2 && values[0] == values[1], "{told}");
    assert!(told.matches("HTTP/1.1 200").count() == 3 && told.contains("100 Continue"), "{told}");
    assert!(told.ends_with("Content-Length: 43\r\nConnection: close\r\n\r\n"), "{told}");
}

#[test]
fn addresses_that_cannot_be_had_are_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("heart.toml"), CASE).unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    for (options, words) in [
        (["--bind", "192.0.2.1", "--port", "0"], "choose another --bind"),
        (["--bind", "localhost", "--port", &port], "choose another --port"),
        (["--bind", "no such name", "--port", "0"], "no machine has this name"),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
        let command = command.current_dir(folder.path()).args(["serve", "heart.toml"]);
        let output = command.args(options).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && told.contains(words), "{told}");
    }
}
