//! Reports as a whole: what is refused, what is written, what is read back, and what a page shows.

use sinew_report::{
    Block, Cell, Chart, Column, Distribution, Figure, Level, Map, Panel, Provenance, Report,
    ReportError, Row, Section, Series, Style, Surfaces, Table, Value, Verdict, format,
};

const METHODS: [&str; 4] = ["DD-GNN", "PI-GNN", "FEM <cold>", "FEM warm"];

fn samples(centre: f64) -> Vec<f64> {
    (1..=40).map(|k| centre * f64::from(k) / 20.0).collect()
}

fn table() -> Table {
    let mut table = Table::new(
        [Column::new("err_u", "mm").about("‖u − û‖ at every node"), Column::new("err_F", "%")],
        [Column::new("train", "s").once(), Column::new("full", "s"), Column::new("decoder", "s")],
        [Column::new("steps", "")],
    );
    table.baseline = Some("FEM warm".into());
    for (number, method) in METHODS.into_iter().enumerate() {
        let of = |centre: f64| {
            Distribution::with_density("err", samples(centre * 10f64.powi(number as i32))).unwrap()
        };
        let printed = (number < 2).then_some(1e-2);
        let solver = number > 1;
        let row = Row::new(
            method,
            Cell::from(of(6e-3)).against("the thesis’", printed),
            if solver { 0.0 } else { 150.0 },
        )
        .unwrap()
        .error(of(0.1))
        .time(2e-2)
        .time(if solver { 1e-2 } else { 1e-3 })
        .other(1000.0)
        .described("what it <does>", if solver { "FEniCS" } else { "FEM & more" });
        table.push(row).unwrap();
    }
    table
}

fn densities(table: &Table, error: usize) -> Chart {
    let name = table.errors[error].head();
    let mut chart = Chart::new("Density", [&name, "density per decade"], [true, false]);
    for row in table.ranked() {
        let Value::Distribution(found) = &row.errors[error].value else { continue };
        chart.series.push(Series::new(&row.method, Style::Area, found.density.iter().copied()));
        let level = |value, published| {
            let name = row.method.clone();
            Level { name, value, upright: true, published }
        };
        chart.levels.push(level(found.q50, false));
        let verdict = row.errors[error].verdict.iter();
        chart.levels.extend(verdict.map(|verdict| level(verdict.limit, true)));
    }
    chart
}

fn report() -> Report {
    let provenance = Provenance {
        command: "study --scene once && echo \"<done>\"".into(),
        machine: "<script>alert('x')</script>".into(),
        config: "steps = 1000 # < 2000".into(),
        versions: [("rustc".into(), "1.95 & newer".into())].into(),
        seed: Some(42),
        ..Provenance::default()
    };
    let table = table();
    let figures = [
        Block::charts("Speed", "", [Chart::speed_against_error(&table, 0)]),
        Block::charts("Densities", "", [0, 1].map(|error| densities(&table, error))),
        Block::Figure(Figure {
            title: "Maps".into(),
            caption: "a <caption>".into(),
            panels: vec![Panel::Map(map())],
        }),
        Block::Surfaces(surfaces()),
    ];
    let mut report = Report::new("Once<Clamped>Beam", "a <beam> & gravity", provenance);
    report.notes.push("a <note>".into());
    report.headline = "two of \"two\"".into();
    let summary = Block::List(table.summary());
    let blocks = [summary, Block::Table(table)].into_iter().chain(figures).collect();
    report.sections.push(Section { name: "once".into(), title: "Once & more".into(), blocks });
    report
}

fn map() -> Map {
    Map {
        title: "a < b".into(),
        axes: ["x".into(), "y".into()],
        ranges: [[0.0, 1.0], [0.0, 2.0]],
        rows: vec![vec![Some(0.0), Some(0.0), Some(1.0), None]; 2],
        scale: [0.0, 1.0],
        marks: vec![
            ("u observed".into(), vec![[0.5, 0.5]]),
            ("equation imposed".into(), vec![[0.2, 1.0]]),
        ],
    }
}

fn surfaces() -> Surfaces {
    let points = [[0.0; 3], [9.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    let mut surfaces =
        Surfaces::new(&[[0, 2, 3], [0, 2, 4], [0, 3, 4], [2, 3, 4]], &points).unwrap();
    surfaces.quantity = "Where the errors are".into();
    surfaces.unit = "mm".into();
    surfaces.push("PI-GNN", "median <case>", &points, &[0.0, 9.0, 1e-2, f64::NAN, 3e-2]).unwrap();
    surfaces
}

fn svgs(page: &str) -> impl Iterator<Item = &str> {
    page.split("<svg ").skip(1).map(|rest| rest.split_once("</svg>").expect("a drawing ends").0)
}

#[test]
fn a_row_needs_error_and_time() {
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(
            matches!(Row::new("m", value, 1.0), Err(ReportError::Number(field, _)) if field.contains("first error"))
        );
        assert!(
            matches!(Row::new("m", 1.0, value), Err(ReportError::Number(field, _)) if field.contains("first time"))
        );
        let full = |error: f64, time: f64| {
            Row::new("m", 1.0, 1.0).unwrap().error(error).time(1.0).time(time).other(0.0)
        };
        assert!(table().push(full(1.0, 1.0)).is_ok());
        let message = table().push(full(value, 1.0)).unwrap_err().to_string();
        assert!(message.contains("m: err_F"), "{message}");
        let message = table().push(full(1.0, value)).unwrap_err().to_string();
        assert!(message.contains("m: decoder"), "{message}");
    }
    assert!(matches!(Row::new("m", "none", 1.0), Err(ReportError::Missing(_))));
    assert!(matches!(Row::new("m", 1.0, Value::Nothing), Err(ReportError::Missing(_))));
    assert!(matches!(table().push(Row::new("m", 1.0, 1.0).unwrap()), Err(ReportError::Length(..))));
    assert!(matches!(Distribution::with_density("e", vec![]), Err(ReportError::Missing(_))));
    assert!(matches!(
        Distribution::with_density("e", vec![1.0, f64::NAN]),
        Err(ReportError::Number(..))
    ));
}

#[test]
fn quantiles_agree_with_numpy() {
    // np.quantile([3, 1, 4, 1.5, 9.25, 2.6, 5.3], [0, .025, .25, .5, .75, .975, 1]) and the mean
    let found = Distribution::of(vec![3.0, 1.0, 4.0, 1.5, 9.25, 2.6, 5.3]).unwrap();
    let values = [
        found.q0,
        found.q2_5,
        found.q25,
        found.q50,
        found.q75,
        found.q97_5,
        found.q100,
        found.mean,
    ];
    let numpy = [1.0, 1.075, 2.05, 3.0, 4.65, 8.6575, 9.25, 3.807_142_857_142_857];
    for (value, expected) in values.into_iter().zip(numpy) {
        // Both interpolate in f64 and differ by rounding only.
        assert!((value - expected).abs() < 1e-14, "{value} for {expected}");
    }
    assert_eq!(Distribution::of(vec![f64::INFINITY; 2]).unwrap().q25, f64::INFINITY);
    assert_eq!((Distribution::of(vec![]), Distribution::of(vec![1.0, f64::NAN])), (None, None));
}

#[test]
fn densities_integrate_to_one_and_peak_where_samples_are() {
    // Evenly spaced quantiles of a logistic distribution of log₁₀ x.
    let logistic = |count: u32, centre: f64, scale: f64| -> Vec<f64> {
        let p = |i| (f64::from(i) + 0.5) / f64::from(count);
        (0..count).map(|i| 10f64.powf(centre + scale * (p(i) / (1.0 - p(i))).ln())).collect()
    };
    let cases =
        [vec![1e-3], vec![0.0, 2e-3, 2e-3], logistic(100, -2.0, 0.2), logistic(50_000, -3.0, 0.3)];
    for samples in cases {
        let density = sinew_report::density(&samples);
        let area =
            |pair: &[[f64; 2]]| (pair[1][0] / pair[0][0]).log10() * 0.5 * (pair[0][1] + pair[1][1]);
        let integral: f64 = density.windows(2).map(area).sum();
        // Cut tails of the kernel (6e-5) and the trapezoidal rule on bins.
        assert!((integral - 1.0).abs() < 2e-4, "{integral}");
    }
    let density = sinew_report::density(&logistic(20_000, -2.5, 0.25));
    let peak = density.into_iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    // Half a bin, and the smoothing of the kernel (h²f″/2: 2.4 %).
    assert!(
        (peak[0].log10() + 2.5).abs() < 0.5 / 32.0 + 1e-9 && (peak[1] - 1.0).abs() < 0.03,
        "{peak:?}"
    );
    assert!(sinew_report::density(&[0.0, -1.0, f64::NAN, 1e9, f64::INFINITY]).is_empty());
}

#[test]
fn numbers_and_durations_read_well() {
    let digits = |value| format::digits(value, 2);
    let numbers = [
        6.5e-3,
        0.087,
        0.01,
        0.009_99,
        15.7,
        9.96,
        12_345.0,
        -1.2e-9,
        0.0,
        f64::NAN,
        -f64::INFINITY,
    ];
    let texts =
        ["6.5×10⁻³", "0.087", "0.010", "0.010", "16", "10", "1.2×10⁴", "−1.2×10⁻⁹", "0", "–", "−∞"];
    assert_eq!(numbers.map(digits), texts);
    let trimmed = [4.16, -26.612, 0.999_999_999_99, 1.2e-13, 0.0, 123_456.0, -0.00123, 100.0];
    let texts = ["4.16", "−26.612", "1", "1.2×10⁻¹³", "0", "123456", "−0.00123", "100"];
    assert_eq!(trimmed.map(|value| format::trimmed(value, 8)), texts);
    let durations = [2.1e-10, 2.1e-4, 0.0123, 2.14, 200.0, 3900.0, f64::NAN];
    let texts = ["0.21 ns", "210 µs", "12 ms", "2.1 s", "3 min 20 s", "1 h 05 min", "–"];
    assert_eq!(durations.map(format::seconds), texts);
    // What rounds to a whole of the next unit is written in that.
    let durations = [0.9996e-6, 0.9996e-3, 0.9996, 3599.6];
    assert_eq!(durations.map(format::seconds), ["1.0 µs", "1.0 ms", "1.0 s", "1 h 00 min"]);
    assert_eq!([1.09, 295.2, 4_123.0].map(format::factor), ["1.1×", "300×", "4\u{202f}100×"]);
    assert_eq!(format::count(1_234_567), "1\u{202f}234\u{202f}567");
}

#[test]
fn the_one_verdict_rule_counts_printed_digits() {
    let met = |ours, printed| Verdict::against_printed("thesis", ours, printed).met;
    assert!(met(4.94e-5, 4.9e-5) && met(4.9e-5, 4.9e-5) && met(0.0, 4.9e-5));
    assert!(
        !met(4.96e-5, 4.9e-5) && !met(1.0, 0.4) && !met(f64::NAN, 1.0) && !met(f64::INFINITY, 1.0)
    );
    assert_eq!(report().verdicts(), [2, 1]);
    let page = report().to_html();
    assert!(
        page.contains("1 of 2 not met") && page.contains("× the thesis’ 0.010"),
        "what is missed is said"
    );
}

#[test]
fn json_round_trip_is_exact_and_wrong_files_are_refused() {
    let mut report = report();
    let text = report.to_json().unwrap();
    let read = Report::from_json(&text).unwrap();
    assert_eq!(read.to_json().unwrap(), text);
    assert_eq!(read.sections[0].blocks[..3], report.sections[0].blocks[..3]);
    let negative = text.replacen("{\"value\":150.0}", "{\"value\":-150.0}", 1);
    assert!(
        matches!(Report::from_json(&negative), Err(ReportError::Number(field, _)) if field == "DD-GNN: train")
    );
    let newer = text.replacen("\"schema\":3", "\"schema\":4", 1);
    assert!(matches!(Report::from_json(&newer), Err(ReportError::Schema(4, _))));
    assert!(matches!(Report::from_json("{"), Err(ReportError::Json(_))));
    let hostile = text.replacen("\"triangles\":[[0,1,2]", "\"triangles\":[[0,1,77]", 1);
    assert!(matches!(Report::from_json(&hostile), Err(ReportError::Triangle(0, 77, 4))));

    // What is not finite is null in the file and a gap after reading.
    let broken = Series::new("n", Style::Line, [[1.0, f64::NAN], [2.0, f64::INFINITY], [3.0, 1.0]]);
    let chart = Chart::new("c", ["x", "y"], [false; 2]).with(broken);
    report.sections[0].blocks = vec![Block::charts("t", "", [chart])];
    let read = Report::from_json(&report.to_json().unwrap()).unwrap();
    assert_eq!(read.to_html(), report.to_html());
}

#[test]
fn text_cannot_become_markup_and_the_page_stands_alone() {
    let page = report().to_html();
    for hostile in [
        "<script>alert",
        "<does>",
        "<beam>",
        "<Clamped>",
        "<case>",
        "<note>",
        "<done>",
        "<cold>",
        "a < b",
    ] {
        assert!(!page.contains(hostile), "{hostile}");
    }
    for shown in [
        "Once&lt;Clamped&gt;Beam",
        "FEM &lt;cold&gt;",
        "median \\u003ccase>",
        "FEM &amp; more",
        "steps = 1000",
    ] {
        assert!(page.contains(shown), "{shown}");
    }
    for outside in ["http:", "https:", "src=", "@import", "url(h"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert_eq!(page, report().to_html(), "a page is a function of its report");
}

#[test]
fn names_of_clipping_areas_are_the_chart_s_own() {
    let page = report().to_html();
    let ids: Vec<&str> =
        page.split(" id=\"").skip(1).filter_map(|rest| Some(rest.split_once('"')?.0)).collect();
    let distinct: std::collections::HashSet<_> = ids.iter().collect();
    assert_eq!(distinct.len(), ids.len(), "{ids:?}");
    for used in page.split("url(#").skip(1) {
        assert!(ids.contains(&used.split_once(')').unwrap().0));
    }
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let series = |points: &[[f64; 2]]| Series::new("n", Style::Marked, points.iter().copied());
    let log = |points: &[[f64; 2]]| Chart::new("c", ["x", "y"], [true; 2]).with(series(points));
    let linear = |points: &[[f64; 2]]| Chart::new("c", ["x", "y"], [false; 2]).with(series(points));
    let cases = [
        (
            log(&[[1.0, f64::NAN], [10.0, 0.0], [100.0, 1e-3], [-1.0, 2.0]]),
            "3 of 4 points are not drawn",
        ),
        (
            linear(&[[1.0, f64::INFINITY], [2.0, 3.0], [3.0, f64::NAN], [4.0, 5.0]]),
            "2 of 4 points are not drawn",
        ),
        (linear(&[]), "Nothing to draw"),
        (log(&[[0.0, 0.0]]), "Nothing to draw"),
        (linear(&[[f64::NAN, 1.0]]), "1 of 1 points"),
        // Single, equal, huge and tiny numbers still have axes.
        (linear(&[[1.0, 0.0], [1.0, 0.0]]), "<svg"),
        (linear(&[[1e300, -1e300]]), "<svg"),
        (log(&[[1e-300, 1e-14], [1e-3, 1e2]]), "1 of 2 points are not drawn"),
        (log(&[[1e-14, 1e-14]]), "<svg"),
    ];
    for (chart, expected) in cases {
        let mut report = Report::new("t", "", Provenance::default());
        let level = Level { name: "n".into(), value: f64::NAN, upright: false, published: true };
        let chart = Chart { levels: vec![level], ..chart };
        let block = Block::charts("figure", "", [chart]);
        report.sections.push(Section { name: "s".into(), title: "s".into(), blocks: vec![block] });
        let page = report.to_html();
        assert!(page.contains(expected), "{expected}");
        assert!(
            svgs(&page).all(|svg| !svg.contains("NaN") && !svg.contains("inf")),
            "{expected}: {page}"
        );
    }
    assert!(Report::default().to_html().ends_with("</html>"));
    let empty = Map { rows: vec![vec![None, Some(f64::NAN)]], ranges: [[0.0; 2]; 2], ..map() };
    let mut report = Report::default();
    let blocks =
        vec![Block::Figure(Figure { panels: vec![Panel::Map(empty)], ..Figure::default() })];
    report.sections.push(Section { blocks, ..Section::default() });
    assert!(svgs(&report.to_html()).all(|svg| !svg.contains("NaN") && !svg.contains("inf")));
    let mut nowhere = Surfaces::new(&[], &[]).unwrap();
    nowhere.push("m", "a surface without triangles", &[], &[]).unwrap();
    report.sections[0].blocks = vec![Block::Surfaces(nowhere)];
    assert!(!report.to_html().contains("inf"));
}

#[test]
fn warnings_stand_at_the_head_and_beside_their_method() {
    let mut table = Table::new([Column::new("err_u", "mm")], [Column::new("predict", "s")], []);
    let noted = Cell { note: "95 % 2.0, largest 9.0".into(), ..Cell::from(1.0) };
    table.push(Row::new("good", 1.0, 1.0).unwrap()).unwrap();
    let page = |table: &Table| {
        let mut report = Report::new("t", "", Provenance::default());
        let blocks = vec![Block::Table(table.clone())];
        report.sections.push(Section { name: "s".into(), title: "Errors".into(), blocks });
        assert_eq!(Report::from_json(&report.to_json().unwrap()).unwrap(), report);
        report.to_html()
    };
    assert!(!page(&table).contains("In short"), "a head that says nothing is left out");
    table
        .push(Row::new("bad", noted, 1.0).unwrap().warned(["predictions <invert> cells"]))
        .unwrap();
    let page = page(&table);
    assert_eq!(page.matches("predictions &lt;invert&gt; cells").count(), 2, "head and row");
    let [head, body] = [page.find("Not to be trusted"), page.find(">Errors<")].map(Option::unwrap);
    assert!(head < body && page.contains("95 % 2.0, largest 9.0"), "{page}");
}

#[test]
fn thirty_two_methods_are_told_apart() {
    let mut table = Table::new([Column::new("err_u", "mm")], [Column::new("predict", "s")], []);
    for number in 0..32 {
        table.push(Row::new(format!("method {number}"), 1.0, 1.0).unwrap()).unwrap();
    }
    let mut report = Report::default();
    report.sections.push(Section { blocks: vec![Block::Table(table)], ..Section::default() });
    let page = report.to_html();
    let keys: Vec<&str> = svgs(&page).filter(|svg| svg.starts_with("class=\"key\"")).collect();
    let distinct: std::collections::HashSet<_> = keys.iter().collect();
    assert_eq!((keys.len(), distinct.len()), (32, 32), "colour and dashes together");
}

#[test]
fn one_bad_case_does_not_set_the_scale_of_the_others() {
    let points: Vec<[f64; 3]> =
        (0..200).map(|i| [f64::from(i % 20), f64::from(i / 20), 0.0]).collect();
    let triangles: Vec<_> = (0..179).map(|i| [i, i + 1, i + 20]).collect();
    let drawn = |errors: &[f64], linear| {
        let mut surfaces = Surfaces::new(&triangles, &points).unwrap();
        (surfaces.unit, surfaces.linear) = ("mm".into(), linear);
        for error in errors {
            let values: Vec<f64> = (1..=200).map(|i| error * f64::from(i) / 200.0).collect();
            surfaces.push("m", "case", &points, &values).unwrap();
        }
        let scale = surfaces.scale().unwrap();
        let mut report = Report::default();
        let blocks = vec![Block::Surfaces(surfaces)];
        report.sections.push(Section { blocks, ..Section::default() });
        (scale, report.to_html())
    };
    let (good, page) = drawn(&[1.0; 4], false);
    // The 98 % quantile of each, and of all.
    assert!((good - 0.98).abs() < 0.011 && page.contains("have the last colour"), "{good}");
    let (scale, page) = drawn(&[1.0, 1.0, 1.0, 5000.0], false);
    assert!((scale / good - 10.0).abs() < 1e-6, "{scale} for {good}");
    let ends = |page: &str| -> Vec<f64> {
        let scale = page.split("\"scale\":[").nth(1).unwrap().split(']').next().unwrap();
        scale.split(',').map(|end| end.parse().unwrap()).collect()
    };
    // Three decades of colours below the last one.
    assert!(page.contains("25 % are larger") && ends(&page)[1] == scale, "{page}");
    assert!((ends(&page)[0] / scale - 1e-3).abs() < 1e-12);
    let (_, page) = drawn(&[3.0; 2], true);
    assert!(page.contains("one linear scale") && ends(&page)[0] == 0.0);
    // Equal to zero but for one node.
    let mut surfaces = Surfaces::new(&triangles, &points).unwrap();
    let spike: Vec<f64> = (0..200).map(|i| f64::from(u8::from(i == 7))).collect();
    surfaces.push("m", "spike", &points, &spike).unwrap();
    assert_eq!(surfaces.scale(), Some(1.0));
}

/// Boxes of level labels as wide as the widest usual font makes them.
fn labels(svg: &str) -> Vec<([f64; 2], [f64; 2], &str)> {
    let number = |text: &str, key: &str| -> f64 {
        text.split_once(&format!(" {key}=\""))
            .unwrap()
            .1
            .split_once('"')
            .unwrap()
            .0
            .parse()
            .unwrap()
    };
    let texts = svg.split("<text").skip(1).map(|rest| rest.split_once("</text>").unwrap().0);
    texts
        .filter(|text| !text.contains("rotate") && !text.ends_with('>'))
        .map(|text| {
            let (head, content) = text.split_once('>').unwrap();
            let (x, y) = (number(head, "x"), number(head, "y"));
            let size = number(head, "font-size");
            let width = 0.6 * size * content.chars().count() as f64;
            let left = match () {
                () if head.contains("middle") => x - 0.5 * width,
                () if head.contains("\"end\"") => x - width,
                () => x,
            };
            ([left, left + width], [y - 0.75 * size, y + 0.2 * size], content)
        })
        .collect()
}

#[test]
fn labels_do_not_overlap() {
    let spans = [0.05, 0.3, 0.9, 1.5, 2.0, 3.0, 5.0, 9.0, 14.0, 25.0];
    for (span, linear, wide) in
        spans.iter().flat_map(|s| [(s, false, true), (s, false, false), (s, true, false)])
    {
        let points =
            (0..5).map(|k| [-9.0, -3.0].map(|low| 10f64.powf(low + span * f64::from(k) / 4.0)));
        let mut chart = Chart::new("c", ["time [s]", "err_u [mm]"], [!linear; 2]);
        for name in ["DD-GNN", "PI-GNN", "hybrid GNN", "FDD-GNN", "POD", "FEM cold", "FEM warm"] {
            chart.series.push(Series::new(name, Style::Marked, points.clone()));
        }
        let mut report = Report::default();
        let charts = vec![chart; if wide { 1 } else { 2 }];
        report
            .sections
            .push(Section { blocks: vec![Block::charts("f", "", charts)], ..Section::default() });
        let page = report.to_html();
        for svg in svgs(&page) {
            let labels = labels(svg);
            assert!(labels.len() >= 7 + 4, "{labels:?}");
            for (i, a) in labels.iter().enumerate() {
                for b in &labels[..i] {
                    let along = |a: [f64; 2], b: [f64; 2]| a[0] < b[1] && b[0] < a[1];
                    let apart = !along(a.0, b.0) || !along(a.1, b.1);
                    assert!(apart, "span {span}, linear {linear}: {:?} over {:?}", a, b);
                }
            }
        }
    }
}

#[test]
fn surfaces_keep_the_nodes_that_are_seen() {
    let surfaces = surfaces();
    assert_eq!(surfaces.reference.len(), 4);
    assert_eq!(surfaces.triangles[3], [1, 2, 3]);
    assert_eq!(surfaces.cases[0].values, [Some(0.0), Some(1e-2), None, Some(3e-2)]);
    assert!(matches!(
        Surfaces::new(&[[0, 1, 5]], &[[0.0; 3]; 5]),
        Err(ReportError::Triangle(0, 5, 5))
    ));
    let mut surfaces = surfaces;
    let short = surfaces.push("m", "short", &[[0.0; 3]; 4], &[0.0; 5]);
    assert!(matches!(short, Err(ReportError::Length(_, 4, 5))));
    assert!(surfaces.push("m", "nan", &[[f64::NAN; 3]; 5], &[0.0; 5]).is_err());
}

#[test]
fn files_are_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let report = report();
    let page = report.write(&folder.path().join("new")).unwrap();
    assert_eq!(std::fs::read_to_string(&page).unwrap(), report.to_html());
    let read = Report::read(&page.with_file_name("report.json")).unwrap();
    assert_eq!(read.to_html(), report.to_html());
    let message = Report::read(&folder.path().join("none.json")).unwrap_err().to_string();
    assert!(message.contains("none.json"), "{message}");
}

#[test]
fn every_field_is_documented() {
    fn names(value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, value) in fields {
                    found.push(name.clone());
                    // Names of packages are data.
                    if name != "versions" {
                        names(value, found);
                    }
                }
            }
            serde_json::Value::Array(values) => values.iter().for_each(|value| names(value, found)),
            _ => (),
        }
    }
    let schema = include_str!("../../../docs/report-schema.md");
    let mut found = Vec::new();
    names(&serde_json::from_str(&report().to_json().unwrap()).unwrap(), &mut found);
    for name in found {
        assert!(schema.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn a_legend_of_many_names_is_inside_its_drawing() {
    let series = |number: u32| {
        let name = format!("a method of some length, number {number}");
        Series::new(name, Style::Marked, [[1.0, f64::from(number)], [2.0, 1.0]])
    };
    let chart = (0..30).map(series).fold(Chart::new("c", ["x", "y"], [false; 2]), Chart::with);
    let mut report = report();
    report.sections[0].blocks = vec![Block::charts("t", "", [chart])];
    let page = report.to_html();
    let drawing = page.split_once("<svg viewBox=\"0 0 ").unwrap().1;
    let drawing = drawing.split_once("</svg>").unwrap().0;
    let number = |text: &str| text.split_once('"').unwrap().0.parse::<f64>().unwrap();
    let height = number(drawing.split_once(' ').unwrap().1);
    let lines: Vec<f64> = drawing
        .split("<text ")
        .skip(1)
        .map(|text| number(text.split_once(" y=\"").unwrap().1))
        .collect();
    assert!(lines.len() > 30 && lines.iter().all(|line| *line < height), "{height}: {lines:?}");
}

#[test]
fn a_revision_is_dirty_with_changed_sources_and_clean_with_a_changed_document() {
    let folder = tempfile::tempdir().unwrap();
    let git = |arguments: &str| {
        let given = "-c user.name=a -c user.email=a@b ".to_string() + arguments;
        let given = given.split(' ');
        let done = std::process::Command::new("git").args(given).current_dir(&folder).output();
        assert!(done.unwrap().status.success(), "{arguments}");
    };
    let put = |name: &str| std::fs::write(folder.path().join(name), name).unwrap();
    let revision = || Provenance::of_this_run("p", folder.path().join("sources")).revision;
    for name in ["docs", "sources"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    assert_eq!(revision(), "unknown");
    put("sources/a.rs");
    ["init -q", "add .", "commit -q -m first"].iter().copied().for_each(git);
    let clean = revision();
    assert_eq!(clean.len(), 12, "{clean}");
    put("docs/results.md");
    assert_eq!(revision(), clean);
    put("sources/b.rs");
    assert_eq!(revision(), format!("{clean}-dirty"));
}
