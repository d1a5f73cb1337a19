//! Surfaces of bodies, coloured by a value.

use crate::support::surfaces;
use sinew_report::{Block, Report, ReportError, Section, Surfaces};

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
