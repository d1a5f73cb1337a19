//! Directions at nodes: they have neither length nor sense, in cells of any order.

use sinew::{Body, Case};
use sinew_mesh::{
    AnyMesh, Field, TruncatedEllipsoid, box_hexahedra, box_tetrahedra, repair_orientation,
};

const CASE: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ body_force = [0.0, 0.0, -0.01] }]
supports = [{ clamped = "x_min" }]
mesh.file = "none.vtu"
fibres.field = "f"
parameters = { a = [0.1, 0.26], b = [1.0, 4.2], a_f = [1.5, 5.18], b_f = [1.0, 4.46] }
"#;

/// A body whose fibres turn along x; that of a node is multiplied by a factor.
fn body(
    formulation: &str,
    mut mesh: AnyMesh,
    factor: impl Fn(usize) -> f64,
) -> Result<Body, String> {
    let turned = |(node, x): (usize, &[f64; 3])| {
        let (sin, cos) = (0.3 + 0.2 * x[0] + 0.1 * x[1]).sin_cos();
        [cos, sin, 0.1 * x[2]].map(|d| factor(node) * d)
    };
    let fibres: Vec<_> = mesh.points().iter().enumerate().map(turned).collect();
    mesh.point_fields_mut().insert("f".into(), Field::vectors(&fibres));
    let text = format!("formulation = \"{formulation}\"\n{CASE}");
    let case = Case::parse(&text, "case.toml").map_err(|error| error.to_string())?;
    case.body_on(mesh).map_err(|error| error.to_string())
}

#[test]
fn length_and_sense_of_nodal_directions_change_nothing() {
    let energy = |formulation: &str, factor: fn(usize) -> f64| {
        let mesh = box_tetrahedra([4.0, 3.0, 2.0], [4, 3, 2]);
        let body = body(formulation, mesh.into(), factor).unwrap();
        let moved =
            body.positions.iter().flat_map(|x| [0.2 * x[0] * x[1], 0.1 * x[0], -0.1 * x[2]]);
        let (moved, mut forces) = (moved.collect::<Vec<_>>(), vec![0.0; 3 * body.nodes]);
        body.value_and_gradient(&moved, &body.centre(), &mut forces)
    };
    for formulation in ["plain", "quadratic"] {
        let unit = energy(formulation, |_| 1.0);
        let [long, turned] = [
            energy(formulation, |node| 1.0 + (node * 7 % 5) as f64),
            energy(formulation, |node| if node * 7 % 5 < 2 { -1.0 } else { 1.0 }),
        ];
        for other in [long, turned] {
            assert!((other / unit - 1.0).abs() < 1e-12, "{formulation}: {other} and {unit}");
        }
    }
}

#[test]
fn nodal_directions_are_not_taken_for_those_of_cells() {
    // As many nodes as quadrature points, and as many nodes as cells.
    for mesh in [
        AnyMesh::from(box_hexahedra([1.0; 3], [1, 1, 1])),
        box_tetrahedra([1.0, 1.0, 2.0], [1, 1, 2]).into(),
    ] {
        let refused = body("plain", mesh, |_| 1.0).unwrap_err();
        assert!(refused.contains("give fibres of cells"), "{refused}");
    }
    assert!(body("plain", box_hexahedra([1.0; 3], [2, 1, 1]).into(), |_| 1.0).is_ok());
}

#[test]
fn cells_that_are_quadratic_in_the_file_keep_the_directions_of_their_middle_nodes() {
    let energy = |formulation: &str| {
        let mesh = box_tetrahedra([4.0, 3.0, 2.0], [2, 2, 1]).quadratic();
        let body = body(formulation, mesh.into(), |_| 1.0).unwrap();
        let moved = body.positions.iter().flat_map(|x| [0.2 * x[0] * x[1], 0.1 * x[0], 0.0]);
        body.value(&moved.collect::<Vec<_>>(), &body.centre())
    };
    assert_eq!(energy("quadratic"), energy("plain"));
}

#[test]
fn directions_that_nothing_determines_between_nodes_are_refused() {
    let refused = |formulation: &str| {
        let mut mesh = box_tetrahedra([4.0, 3.0, 2.0], [4, 3, 2]);
        let axis = |x: &[f64; 3]| if x[0] < 2.0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let fibres: Vec<_> = mesh.points.iter().map(axis).collect();
        mesh.point_fields.insert("f".into(), Field::vectors(&fibres));
        let text = format!("formulation = \"{formulation}\"\n{CASE}");
        Case::parse(&text, "case.toml").unwrap().body_on(mesh.into()).unwrap_err().to_string()
    };
    let [plain, quadratic] = ["plain", "quadratic"].map(refused);
    assert!(plain.contains("nothing determines direction 0 of cell"), "{plain}");
    assert!(quadratic.contains("between two at right angles"), "{quadratic}");
}

/// A wall of hexahedra with a node on its axis, where no direction is circumferential; mirrored or not, a quarter turn on, its cells in
/// either order.
#[test]
fn fibres_by_rule_follow_neither_numbering_nor_symmetry() {
    let energy = |sense: f64, quarter: bool, reversed: bool| {
        let placed = |[x, y, z]: [f64; 3]| {
            let [x, y] = [sense * x, y];
            if quarter { [-y, x, z] } else { [x, y, z] }
        };
        let mut mesh = TruncatedEllipsoid::LAND.wall([2, 8, 6]).hexahedra();
        let moved = |[x, y, z]: [f64; 3]| {
            [0.02 * x + 1e-3 * y * z, 0.03 * x + 1e-3 * x * y, 0.02 * x + 2e-3 * y * z]
        };
        let moved: Vec<f64> = mesh.points.iter().flat_map(|&x| placed(moved(x))).collect();
        mesh.points.iter_mut().for_each(|x| *x = placed(*x));
        repair_orientation(&mut mesh);
        if reversed {
            mesh.cells.reverse();
            let facets = mesh.facet_sets.values_mut().flatten();
            facets.for_each(|facet| facet.cell = mesh.cells.len() - 1 - facet.cell);
        }
        let rule = format!(
            "fibres.rule = {{ endocardium = \"endo\", epicardium = \"epi\", base = \"base\", angles = [{}, {}] }}",
            60.0 * sense,
            -60.0 * sense
        );
        let text = CASE.replace("fibres.field = \"f\"", &rule).replace("x_min", "base");
        let case = Case::parse(&text, "case.toml").unwrap();
        let body = case.body_on(mesh.into()).unwrap();
        body.value(&moved, &body.centre())
    };
    let own = energy(1.0, false, false);
    for (sense, quarter) in [(1.0, false), (1.0, true), (-1.0, false), (-1.0, true)] {
        for reversed in [false, true] {
            let other = energy(sense, quarter, reversed);
            let off = (other / own - 1.0).abs();
            assert!(off < 1e-9, "{sense} {quarter} {reversed}: {other} {own}, {off:e}");
        }
    }
}

#[test]
fn nodes_without_a_direction_take_those_of_the_others() {
    let energy = |absent: fn(usize) -> bool, formulation: &str| {
        let mut mesh = box_tetrahedra([4.0, 3.0, 2.0], [4, 3, 2]);
        let straight = |node| if absent(node) { [0.0; 3] } else { [0.6, 0.8, 0.0] };
        let fibres: Vec<_> = (0..mesh.points.len()).map(straight).collect();
        mesh.point_fields.insert("f".into(), Field::vectors(&fibres));
        let text = format!("formulation = \"{formulation}\"\n{CASE}");
        let body = Case::parse(&text, "case.toml").unwrap().body_on(mesh.into());
        let body = body.map_err(|error| error.to_string())?;
        let moved = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.05 * x[1], 0.0]);
        Ok::<f64, String>(body.value(&moved.collect::<Vec<_>>(), &body.centre()))
    };
    for formulation in ["plain", "quadratic"] {
        let [own, other] =
            [|_: usize| false, |node: usize| node == 7].map(|at| energy(at, formulation).unwrap());
        assert!((other / own - 1.0).abs() < 1e-12, "{formulation}: {other} {own}");
    }
    let refused = energy(|_| true, "plain").unwrap_err();
    assert!(refused.contains("nothing determines direction 0 of cell 0"), "{refused}");
}
