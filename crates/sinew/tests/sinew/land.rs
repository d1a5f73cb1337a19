//! The benchmarks of Land et al. (2015), and fibres by rule against the closed form of the third.

use crate::keys::{VENTRICLE, case, refusal};
use sinew::{Case, Options, Solver};
use std::path::Path;

/// Height \[mm\] of a point of a built-in scene, at the middle of its ranges.
fn height(scene: &str, points: &[[f64; 3]]) -> Vec<f64> {
    let text = sinew::scenes::find(Path::new(scene)).unwrap().text;
    let body = case(text).lowered().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let solution = solver.solve(&body.centre(), &Options::default()).unwrap();
    let height = |point: &[f64; 3]| {
        let distance = |x: &[f64; 3]| (0..3).map(|i| (x[i] - point[i]).powi(2)).sum::<f64>();
        let nearest = body.positions.iter().map(distance).fold(f64::INFINITY, f64::min);
        // Of nodes at equal distances the mean is that of the point between them.
        let near = (0..body.nodes).filter(|&n| distance(&body.positions[n]) < nearest + 1e-9);
        let near: Vec<f64> = near.map(|n| solution.displacement[3 * n + 2]).collect();
        point[2] + near.iter().sum::<f64>() / near.len() as f64
    };
    points.iter().map(height).collect()
}

/// Value and reference apart by at most a share.
fn close(value: f64, reference: f64, share: f64) {
    let error = (value / reference - 1.0).abs();
    println!("{value:.4} against {reference}: {:.3} %", 100.0 * error);
    assert!(error < share, "{value} is {error} away from {reference}");
}

#[test]
fn problem_1_of_land() {
    let found = height("Land1", &[[10.0, 0.5, 1.0]])[0];
    // FEniCS on the same mesh; the limit of fine ones (`cargo xtask verify`, `land-bar`: references and bands).
    close(found, 4.14169, 1e-3);
    close(found, 4.16, 0.006);
}

/// The apex inside and outside.
const APEX: [[f64; 3]; 2] = [[0.0, 0.0, -17.0], [0.0, 0.0, -20.0]];

#[test]
fn problem_2_of_land() {
    let found = height("Land2", &APEX);
    // FEniCS on the axisymmetric problem (`land-ventricle`).
    close(found[0], -26.612, 0.005);
    close(found[1], -28.280, 0.005);
}

#[test]
fn problem_3_of_land() {
    // A converged axisymmetric computation (`land-active`).
    let found = height("Land3", &APEX);
    close(found[0], -12.335, 0.015);
    close(found[1], -15.465, 0.015);
}

/// Mean angle between the fibres of two rules on the same cells at their quadrature points \[degrees\].
fn apart(element: &str, by_rule: &str) -> f64 {
    let [start, end] = ["fibres.rule", "\n[parameters]"].map(|mark| VENTRICLE.find(mark).unwrap());
    let closed = format!(
        "{}fibres.ellipsoid = {{ angles = [60.0, -60.0] }}{}",
        &VENTRICLE[..start],
        &VENTRICLE[end..]
    );
    let bodies = [by_rule, &closed].map(|text| {
        let cells = format!("cells = [3, 24, 12] }}\nmesh.element = \"{element}\"");
        Case::parse(&text.replace("cells = [1, 16, 8] }", &cells), "heart.toml")
            .unwrap()
            .lowered()
            .unwrap()
    });
    let points = bodies[0].volumes.len();
    let angle = |point: usize| {
        let [a, b] = [0, 1].map(|k: usize| bodies[k].material.directions(point)[0]);
        (0..3).map(|i| a[i] * b[i]).sum::<f64>().abs().min(1.0).acos().to_degrees()
    };
    (0..points).map(angle).sum::<f64>() / points as f64
}

#[test]
fn fibres_by_rule_are_near_the_closed_form_in_all_solid_cells() {
    // Fibres of tetrahedra are constant in a cell, across which the closed form turns by 40 degrees.
    for (element, degrees) in
        [("tetrahedra", 6.0), ("quadratic-tetrahedra", 11.0), ("hexahedra", 6.0)]
    {
        let found = apart(element, VENTRICLE);
        assert!(found < degrees, "{element}: {found}");
        let turned = VENTRICLE.replace("angles = [60.0, -60.0]", "angles = [-60.0, 60.0]");
        assert!(apart(element, &turned) > 30.0, "{element}");
    }
    let one_layer =
        VENTRICLE.replace("\nfibres.rule", "\nmesh.element = \"hexahedra\"\nfibres.rule");
    refusal(&one_layer, &["fibres.rule", "120°", "more layers"]);
}
