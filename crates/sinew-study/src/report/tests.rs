//! The report as a whole.

use std::collections::BTreeMap;

use super::*;

const TIMES: Times = Times {
    prepare_s: 2.0,
    train_s: 150.0,
    steps: 1000,
    predict_full_s: 2e-2,
    predict_decoder_s: 1e-3,
    predict_batch_per_theta_s: 3e-4,
};

fn samples(scale: f64) -> ErrorSamples {
    let spread = |centre: f64| (1..=40).map(|k| centre * scale * f64::from(k) / 20.0).collect();
    PerMetric {
        err_u_mm: spread(6e-3),
        err_f_pct: spread(0.1),
        err_i1_pct: spread(0.05),
        err_pi_pct: spread(0.5),
    }
}

fn row(method: Method, scale: f64, times: Times) -> Result<MethodRow, ReportError> {
    MethodRow::from_samples(method, "what it <does>", "FEM & more", samples(scale), times)
}

fn history(method: Method) -> TrainingHistory {
    let point = |step: u64| {
        let errors = samples(10.0 / step as f64).try_map(|_, mut s| quantiles(&mut s).ok_or(()));
        let medians = errors.unwrap().try_map(|_, q| Ok::<_, ()>(q.q50)).unwrap();
        CurvePoint::new(step, step as f64 * 0.1, medians, -3.0)
    };
    let energy = |step: u64| EnergyPoint {
        step,
        train_s: step as f64 * 0.1,
        excess_pct: Some(5.0 / step as f64),
    };
    let steps = [1, 10, 100, 1000];
    TrainingHistory::new(method, &steps.map(point), &steps.map(energy))
}

fn surfaces() -> SurfaceCases {
    let points = [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    let mut surfaces = SurfaceCases::new(&faces, &points).unwrap();
    let deformed = points.map(|[x, y, z]| [1.1 * x, y, z - 1.0]);
    let error = [0.0, 1e-2, 2e-2, 3e-2];
    surfaces.push(Method::Dd, "median <case>", &deformed, &error).unwrap();
    surfaces
}

fn report() -> Report {
    let methods = Method::ALL.into_iter().enumerate();
    Report {
        schema: SCHEMA,
        command: "study --scene once && echo \"<done>\"".into(),
        finished: "2026-01-01 00:00:00 UTC".into(),
        wall_s: 300.0,
        threads: 2,
        seed: 42,
        revision: "abc123".into(),
        machine: "<script>alert('x')</script>".into(),
        versions: BTreeMap::from([("rustc".into(), "1.95 & newer".into())]),
        config: "steps = 1000 # < 2000".into(),
        notes: vec!["a <note>".into()],
        scenes: vec![SceneReport {
            name: "once\" onclick=\"x".into(),
            title: "Once<Clamped>Beam".into(),
            description: "a <beam> & gravity".into(),
            units: "mm, kPa".into(),
            mesh: MeshCounts { nodes: 390, elements: 1440, unknowns: 1080 },
            theta: vec![ThetaRange {
                name: "μ<".into(),
                unit: "kPa".into(),
                low: 50.0,
                high: 100.0,
            }],
            train_samples: 200,
            test_samples: 100,
            displacement: DisplacementScale { mean_mm: 15.7, max_mm: 50.1 },
            thesis: Some(ThesisReference {
                dd: samples(1.0).try_map(|_, s| Ok::<_, ()>(Some(s[19]))).unwrap(),
                pi: PerMetric { err_u_mm: Some(1e-3), ..PerMetric::default() },
                displacement: None,
            }),
            methods: methods
                .map(|(i, method)| row(method, (i + 1) as f64, TIMES).unwrap())
                .collect(),
            training: vec![history(Method::Dd), history(Method::Pi)],
            surfaces: Some(surfaces()),
        }],
    }
}

#[test]
fn a_row_needs_every_time() {
    let broken = [
        ("prepare_s", Times { prepare_s: -1.0, ..TIMES }),
        ("train_s", Times { train_s: f64::NAN, ..TIMES }),
        ("predict_full_s", Times { predict_full_s: f64::INFINITY, ..TIMES }),
        ("predict_decoder_s", Times { predict_decoder_s: -1e-9, ..TIMES }),
        ("predict_batch_per_theta_s", Times { predict_batch_per_theta_s: f64::NAN, ..TIMES }),
    ];
    for (field, times) in broken {
        let message = row(Method::Pi, 1.0, times).unwrap_err().to_string();
        assert!(message.contains(&format!("pi.times.{field}")), "{message}");
    }
}

#[test]
fn a_row_needs_every_error() {
    let good = row(Method::Dd, 1.0, TIMES).unwrap();
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        let mut errors = *good.errors();
        errors.err_i1_pct.q97_5 = value;
        let histograms = good.histograms().clone();
        let refused = MethodRow::new(Method::Dd, "d", "r", errors, histograms, TIMES);
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("dd.errors.err_I1_pct.q97_5"), "{message}");

        let mut wrong = samples(1.0);
        wrong.err_f_pct[3] = value;
        let refused = MethodRow::from_samples(Method::Dd, "d", "r", wrong, TIMES);
        assert!(matches!(refused, Err(ReportError::Sample { field: "err_F_pct", index: 3, .. })));
    }
    let empty = PerMetric { err_pi_pct: Vec::new(), ..samples(1.0) };
    assert!(matches!(
        MethodRow::from_samples(Method::Dd, "d", "r", empty, TIMES),
        Err(ReportError::NoSamples { field: "err_Pi_pct" })
    ));
    assert!(matches!(
        MethodRow::from_samples(Method::Dd, "d", " ", samples(1.0), TIMES),
        Err(ReportError::EmptyText { .. })
    ));
}

#[test]
fn json_round_trip_is_exact() {
    let report = report();
    let text = to_json(&report).unwrap();
    // Not assert_eq: it would print two reports.
    assert!(json::parse(&text).unwrap() == report);
    for name in ["err_u_mm", "err_F_pct", "err_I1_pct", "err_Pi_pct", "q2_5", "q97_5", "q100"] {
        assert!(text.contains(&format!("\"{name}\": ")), "{name}");
    }
}

/// Collects the names of all fields; those of `versions` are data.
fn field_names(value: &serde_json::Value, names: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(fields) => {
            for (name, value) in fields {
                names.push(name.clone());
                if name != "versions" {
                    field_names(value, names);
                }
            }
        }
        serde_json::Value::Array(values) => {
            for value in values {
                field_names(value, names);
            }
        }
        _ => {}
    }
}

#[test]
fn every_field_is_documented() {
    let schema = include_str!("../../../../docs/report-schema.md");
    let mut names = Vec::new();
    let json = serde_json::from_str(&to_json(&report()).unwrap()).unwrap();
    field_names(&json, &mut names);
    let mut header = Vec::new();
    write_samples(&[], &mut header).unwrap();
    let header = String::from_utf8(header).unwrap();
    names.extend(header.trim().split(',').map(str::to_owned));
    names.extend(Method::ALL.map(|method| method.key().to_owned()));
    for name in names {
        assert!(schema.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn json_with_a_bad_row_or_another_schema_is_refused() {
    let text = to_json(&report()).unwrap();
    let negative = text.replace("\"train_s\": 150.0", "\"train_s\": -150.0");
    let message = json::parse(&negative).unwrap_err().to_string();
    assert!(message.contains("times.train_s"), "{message}");
    let newer = text.replace("\"schema\": 1", "\"schema\": 2");
    assert!(matches!(json::parse(&newer), Err(ReportError::Schema { found: 2, .. })));
    assert!(matches!(json::parse("{"), Err(ReportError::Json(_))));
}

#[test]
fn html_names_every_method_and_escapes_text() {
    let html = render_html(&report());
    for method in Method::ALL {
        assert!(html.contains(&format!(">{}<", method.label())), "{method:?}");
    }
    for hostile in [
        "<script",
        "<does>",
        "<beam>",
        "<Clamped>",
        "<case>",
        "<note>",
        "<done>",
        "μ<",
        "\" onclick",
        "& more",
        "& newer",
        "< 2000",
    ] {
        assert!(!html.contains(hostile), "{hostile}");
    }
    assert!(html.contains("Once&lt;Clamped&gt;Beam"));
    // Nothing is drawn at a position that is no number.
    let svg = html.split_once("<body>").unwrap().1;
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn the_summary_says_what_is_missed() {
    let html = render_html(&report());
    // DD is the thesis' own number; PI and the hybrid, which has to be as good as the better of the two, are
    // 12 times above 1e-3.
    assert!(html.contains("4 of 6 medians that the thesis prints are reached"));
    assert!(html.contains("12× the thesis’ 1.0×10⁻³"));
}

#[test]
fn a_report_without_optional_parts_still_renders() {
    let mut report = report();
    let scene = &mut report.scenes[0];
    scene.thesis = None;
    scene.surfaces = None;
    scene.training.clear();
    scene.methods.truncate(1);
    assert!(render_html(&report).contains("DD-GNN"));
    report.scenes[0].methods.clear();
    assert!(render_html(&report).ends_with("</html>\n"));
    report.scenes.clear();
    assert!(render_html(&report).ends_with("</html>\n"));
}

#[test]
fn all_files_are_written_and_read_back() {
    let folder = std::env::temp_dir().join(format!("sinew-report-{}", std::process::id()));
    let report = report();
    write_all(&folder, &report, &[]).unwrap();
    let read = read_json(&folder.join("report.json")).unwrap();
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(folder.join("samples.csv").is_file());
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(read == report);
    assert!(html == render_html(&report));
}
