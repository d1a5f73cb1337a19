//! The page: markup, warnings, colours, drawings without numbers.

use crate::support::{report, svgs};
use sinew_report::{
    Block, Cell, Chart, Column, Level, Provenance, Report, Row, Section, Series, Style, Surfaces,
    Table,
};

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
        "<caption>",
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
    let mut nowhere = Surfaces::new(&[], &[]).unwrap();
    nowhere.push("m", "a surface without triangles", &[], &[]).unwrap();
    let blocks = vec![Block::Surfaces(nowhere)];
    let sections = vec![Section { blocks, ..Section::default() }];
    let report = Report { sections, ..Report::default() };
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
    let warnings = vec!["predictions <invert> cells".into()];
    table.push(Row { warnings, ..Row::new("bad", noted, 1.0).unwrap() }).unwrap();
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
