//! Labels and legends of charts.

use crate::support::{report, svgs};
use sinew_report::{Block, Chart, Report, Section, Series, Style};

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
