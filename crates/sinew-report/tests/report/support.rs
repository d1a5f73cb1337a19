//! A report that has everything.

use sinew_report::{
    Block, Cell, Chart, Column, Distribution, Level, Provenance, Report, Row, Section, Series,
    Style, Surfaces, Table, Value,
};

const METHODS: [&str; 4] = ["DD-GNN", "PI-GNN", "FEM <cold>", "FEM warm"];

fn samples(centre: f64) -> Vec<f64> {
    (1..=40).map(|k| centre * f64::from(k) / 20.0).collect()
}

pub(crate) fn table() -> Table {
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
        .other(1000.0);
        let reference = if solver { "FEniCS" } else { "FEM & more" }.into();
        table.push(Row { about: "what it <does>".into(), reference, ..row }).unwrap();
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

pub(crate) fn report() -> Report {
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
        Block::charts("a < b", "a <caption>", [Chart::speed_against_error(&table, 0)]),
        Block::charts("Densities", "", [0, 1].map(|error| densities(&table, error))),
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

pub(crate) fn surfaces() -> Surfaces {
    let points = [[0.0; 3], [9.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    let mut surfaces =
        Surfaces::new(&[[0, 2, 3], [0, 2, 4], [0, 3, 4], [2, 3, 4]], &points).unwrap();
    surfaces.quantity = "Where the errors are".into();
    surfaces.unit = "mm".into();
    surfaces.push("PI-GNN", "median <case>", &points, &[0.0, 9.0, 1e-2, f64::NAN, 3e-2]).unwrap();
    surfaces
}

pub(crate) fn svgs(page: &str) -> impl Iterator<Item = &str> {
    page.split("<svg ").skip(1).map(|rest| rest.split_once("</svg>").expect("a drawing ends").0)
}
