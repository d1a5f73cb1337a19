//! The small ventricle of `fixtures/organ`, written like the published one: legacy VTK with the triangles of the
//! endocardium among the cells.

use sinew_fem::fibres::{EllipsoidWall, FibreRule};
use sinew_mesh::TruncatedEllipsoid;
use std::fmt::Write;

/// Approximate size of the published ventricle \[mm\].
const SHAPE: TruncatedEllipsoid =
    TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 0.0 };
/// Layers, cells around, cells from the apex to the base.
const CELLS: [usize; 3] = [2, 16, 8];
/// Centres of cells may lie this far outside the curved wall, as a fraction of its thickness.
const SLACK: f64 = 0.5;

/// The whole file. Numbers are rounded to 1e-9, so that another machine's sine writes the same text.
pub(crate) fn file() -> String {
    let mesh = SHAPE.wall(CELLS).tetrahedra();
    let wall = EllipsoidWall::new(SHAPE).expect("ascending axes and a base between the apexes");
    let cavity: Vec<_> = mesh.facet_sets["endo"].iter().map(|&f| mesh.facet_nodes(f)).collect();
    let fibres = mesh.cells.iter().map(|cell| {
        let centre = [0, 1, 2].map(|i| cell.iter().map(|&n| mesh.points[n][i]).sum::<f64>() / 4.0);
        let frame = wall.frame(centre, &FibreRule::SIXTY, SLACK).expect("a cell of the wall");
        frame[0]
    });
    let clamped = |node: usize| mesh.node_sets["base"].binary_search(&node).is_ok();
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len() + cavity.len());

    let mut text = String::from("# vtk DataFile Version 3.0\n");
    text +=
        "generated left ventricle, mm; region 1 = endocardium\nASCII\nDATASET UNSTRUCTURED_GRID\n";
    line(&mut text, format_args!("POINTS {nodes} double"));
    mesh.points.iter().for_each(|&point| vector(&mut text, point));
    line(&mut text, format_args!("CELLS {cells} {}", 5 * mesh.cells.len() + 4 * cavity.len()));
    for [a, b, c, d] in &mesh.cells {
        line(&mut text, format_args!("4 {a} {b} {c} {d}"));
    }
    for triangle in &cavity {
        let [a, b, c] = triangle[..] else { unreachable!("a facet of a tetrahedron") };
        line(&mut text, format_args!("3 {a} {b} {c}"));
    }
    line(&mut text, format_args!("CELL_TYPES {cells}"));
    text += &"10\n".repeat(mesh.cells.len());
    text += &"5\n".repeat(cavity.len());
    line(&mut text, format_args!("CELL_DATA {cells}\nSCALARS region int 1\nLOOKUP_TABLE default"));
    text += &"0\n".repeat(mesh.cells.len());
    text += &"1\n".repeat(cavity.len());
    text += "VECTORS fibre double\n";
    fibres.for_each(|fibre| vector(&mut text, fibre));
    text += &"0 0 0\n".repeat(cavity.len());
    line(
        &mut text,
        format_args!("POINT_DATA {nodes}\nSCALARS clamped int 1\nLOOKUP_TABLE default"),
    );
    (0..nodes).for_each(|node| line(&mut text, format_args!("{}", i32::from(clamped(node)))));
    text
}

fn line(text: &mut String, content: std::fmt::Arguments) {
    writeln!(text, "{content}").expect("text grows");
}

fn vector(text: &mut String, [x, y, z]: [f64; 3]) {
    // Adding zero turns −0 into 0.
    let [x, y, z] = [x, y, z].map(|value| (value * 1e9).round() / 1e9 + 0.0);
    line(text, format_args!("{x} {y} {z}"));
}
