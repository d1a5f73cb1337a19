//! Walls between surfaces: those of an ideal ventricle, whose wall is known, and of a person where they are.

use crate::legacy::{VtkEncoding, to_stl, to_vtk_surface};
use nalgebra::Vector3;
use sinew_mesh::{
    Chamber, Size, TriangleMesh, Trim, TruncatedEllipsoid, WallOptions, boundary_facets,
    enclosed_volume, extract_surface, parse_mesh, quality, read_mesh,
};
use std::f64::consts::PI;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Ellipsoid about as large as a human left ventricle \[mm\].
const IDEAL: TruncatedEllipsoid =
    TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 15.0 };

/// Both surfaces, written to a file and read again.
fn ideal() -> [TriangleMesh; 2] {
    let mesh = IDEAL.wall([1, 64, 40]).tetrahedra();
    ["endo", "epi"].map(|name| {
        let surface = extract_surface(&mesh, &mesh.facet_sets[name]);
        let file = to_vtk_surface(&surface, VtkEncoding::Ascii);
        parse_mesh::<3>(name, &file).unwrap().0
    })
}

fn chamber([endocardium, epicardium]: &[TriangleMesh; 2]) -> Chamber<'_> {
    Chamber { endocardium, epicardium, septum: None }
}

fn nodes(count: usize) -> WallOptions {
    WallOptions { size: Size::Nodes(count), ..WallOptions::default() }
}

/// Whether a point lies on a triangle.
fn is_on([a, b, c]: &[Vector3<f64>; 3], x: Vector3<f64>) -> bool {
    let normal = (b - a).cross(&(c - a));
    // Rounding of the way along a ray, some hundred times that of a length of 75 mm.
    let near = ((x - a).dot(&normal) / normal.norm()).abs() < 4e-11;
    let inside = [(a, b), (b, c), (c, a)]
        .map(|(from, to)| (to - from).cross(&(x - from)).dot(&normal) / normal.norm_squared());
    // Beyond its edges, rays meet a triangle still at a distance of 1e-9 of its size.
    near && inside.iter().all(|share| *share > -2e-9)
}

/// Volume of an ellipsoid of revolution below the base.
fn below(short: f64, long: f64, base: f64) -> f64 {
    let antiderivative = |z: f64| z - z.powi(3) / (3.0 * long * long);
    PI * short * short * (antiderivative(base) - antiderivative(-long))
}

#[test]
fn an_ideal_wall_is_found_again() {
    let surfaces = ideal();
    for count in [1500, 6000] {
        let wall = chamber(&surfaces).wall(&nodes(count)).unwrap();
        let (mesh, report) = (wall.tetrahedra(), wall.report());
        println!("{report}");
        assert!(mesh.points.len().abs_diff(count) < count / 10, "{}", mesh.points.len());
        let cavity = below(25.0, 66.0, 15.0);
        // Chords cut corners: by the square of an edge over the radius.
        assert!((report.cavity_volume / cavity - 1.0).abs() < 0.02, "{}", report.cavity_volume);
        assert!((report.cavity_volume_of_surface / cavity - 1.0).abs() < 0.005);
        let volume = below(36.0, 75.0, 15.0) - cavity;
        let summary = quality(&mesh).unwrap();
        assert!((summary.total_volume / volume - 1.0).abs() < 0.02, "{summary}");
        assert!(summary.dihedral.min > 14.0, "{summary}");
        let boundary = boundary_facets(&mesh);
        let mut named: Vec<_> = ["base", "endocardium", "epicardium"]
            .iter()
            .flat_map(|name| mesh.facet_sets[*name].clone())
            .collect();
        named.sort_unstable();
        assert_eq!(named, boundary);
        assert!((enclosed_volume(&mesh, &boundary) / summary.total_volume - 1.0).abs() < 1e-10);
        assert!(report.endocardium_distance[1] < 1.0 && report.outer_distance[1] < 1.0);
        assert_eq!((report.crossings.0, report.own_crossings, report.columns[1]), (0, 0, 0));
        for &node in &mesh.node_sets["base"] {
            assert!((mesh.points[node][2] - 15.0).abs() < 0.02, "{:?}", mesh.points[node]);
        }
        assert!(wall.hexahedra().unwrap().cells.len() * 6 == mesh.cells.len());
    }
}

/// The sixty-four rays of a section run along edges of triangles.
#[test]
fn columns_of_nodes_rise_straight_from_the_triangles_of_the_endocardium() {
    let surfaces = ideal();
    let wall = chamber(&surfaces).wall(&nodes(1500)).unwrap();
    let mesh = wall.hexahedra().unwrap();
    let ([layers, ..], [columns, _]) = (wall.report().cells, wall.report().columns);
    assert_eq!(mesh.points.len(), columns * (layers + 1));
    let triangles: Vec<_> =
        (0..surfaces[0].cells.len()).map(|cell| surfaces[0].corners(cell)).collect();
    let at = |node: usize| Vector3::from(mesh.points[node]);
    for column in 0..columns {
        let (inner, outer) = (at(column), at(column + columns * layers));
        assert!(triangles.iter().any(|triangle| is_on(triangle, inner)), "{inner:?}");
        for layer in 0..=layers {
            let depth = layer as f64 / layers as f64;
            let off = at(column + columns * layer) - inner.lerp(&outer, depth);
            // Rounding of lengths of up to 75 mm.
            assert!(off.norm() < 1e-12, "column {column}, layer {layer}");
        }
    }
}

#[test]
fn the_base_is_where_it_is_asked() {
    let surfaces = ideal();
    let heights = [
        (Trim::Fraction(0.5), -66.0 + 0.5 * 81.0),
        (Trim::Plane { point: [3.0, 1.0, -5.0], normal: [0.0, 0.0, -2.0] }, -5.0),
    ];
    for (trim, height) in heights {
        let wall = chamber(&surfaces).wall(&WallOptions { trim, ..nodes(1500) }).unwrap();
        let mesh = wall.tetrahedra();
        assert!(
            mesh.node_sets["base"].iter().all(|&node| (mesh.points[node][2] - height).abs() < 1e-6)
        );
        assert!((wall.report().cavity_volume / below(25.0, 66.0, height) - 1.0).abs() < 0.02);
    }
    // A plane aslant.
    let normal = [0.2, 0.1, 0.97];
    let trim = Trim::Plane { point: [0.0; 3], normal };
    let wall = chamber(&surfaces).wall(&WallOptions { trim, ..nodes(1500) }).unwrap();
    let mesh = wall.tetrahedra();
    let height = |node: usize| (0..3).map(|i| mesh.points[node][i] * normal[i]).sum::<f64>();
    assert!(mesh.node_sets["base"].iter().all(|&node| height(node).abs() < 1e-9));
    assert!(quality(&mesh).unwrap().dihedral.min > 10.0);
}

#[test]
fn a_wall_of_a_chosen_edge_and_layers() {
    let surfaces = ideal();
    let options = WallOptions { size: Size::Edge(6.0), layers: Some(3), trim: Trim::Auto };
    let wall = chamber(&surfaces).wall(&options).unwrap();
    assert_eq!(wall.report().cells[0], 3);
    let edges = sinew_mesh::edges(&extract_surface(
        &wall.tetrahedra(),
        &wall.tetrahedra().facet_sets["endocardium"],
    ));
    let mesh = wall.tetrahedra();
    let inner = extract_surface(&mesh, &mesh.facet_sets["endocardium"]);
    let length = |&[a, b]: &[usize; 2]| {
        (0..3).map(|i| (inner.points[a][i] - inner.points[b][i]).powi(2)).sum::<f64>().sqrt()
    };
    let mean = edges.iter().map(length).sum::<f64>() / edges.len() as f64;
    assert!((4.0..8.0).contains(&mean), "{mean}");
}

#[test]
fn units_orientation_and_place_change_nothing() {
    let surfaces = ideal();
    let mesh = chamber(&surfaces).wall(&nodes(1500)).unwrap().tetrahedra();
    let mut moved = surfaces.clone();
    for surface in &mut moved {
        surface
            .points
            .iter_mut()
            .for_each(|[x, y, z]| (*x, *y, *z) = (0.001 * *y + 7.0, 0.001 * *z, 0.001 * *x - 3.0));
        surface.cells.iter_mut().for_each(|cell| cell.swap(0, 1));
    }
    let other = chamber(&moved).wall(&nodes(1500)).unwrap().tetrahedra();
    assert_eq!(other.points.len(), mesh.points.len());
    let [a, b] = [&mesh, &other].map(|mesh| quality(mesh).unwrap());
    assert!((a.total_volume / b.total_volume * 1e-9 - 1.0).abs() < 1e-3, "{a}\n{b}");
    // The grid begins elsewhere around the axis, so angles agree roughly.
    assert!(b.dihedral.min > 14.0, "{b}");
    // Triangles without a common list of points.
    let soup = surfaces.each_ref().map(|surface| {
        let file = to_stl(surface);
        parse_mesh::<3>("soup.stl", &file).unwrap().0
    });
    let wall = chamber(&soup).wall(&nodes(1500)).unwrap();
    assert!((wall.report().quality.total_volume / a.total_volume - 1.0).abs() < 1e-4);
}

#[test]
fn surfaces_without_a_wall_are_refused_with_advice() {
    let surfaces = ideal();
    let told = |chamber: Chamber<'_>, options: WallOptions| {
        let error = chamber.wall(&options).unwrap_err();
        println!("{error}");
        error
    };
    let mut far = surfaces.clone();
    far[1].points.iter_mut().for_each(|x| x[0] += 500.0);
    let error = told(chamber(&far), WallOptions { trim: Trim::Fraction(0.7), ..nodes(1500) });
    assert!(error.to_string().contains("have no outer surface along their normal"), "{error}");
    let apart = told(chamber(&far), nodes(1500)).to_string();
    let counts = apart.split_once(" points of the endocardium lie outside").expect("counts").0;
    assert!(counts.split_once(" of ").is_some_and(|(count, of)| count == of), "{apart}");
    let empty = TriangleMesh::default();
    let error = told(Chamber { endocardium: &empty, ..chamber(&surfaces) }, nodes(1500));
    assert!(error.to_string().starts_with("a surface has no triangles"), "{error}");
    for options in [
        nodes(3),
        WallOptions { size: Size::Edge(f64::NAN), ..nodes(0) },
        WallOptions { size: Size::Edge(1e-9), ..nodes(0) },
        WallOptions { layers: Some(0), ..nodes(1500) },
        WallOptions { layers: Some(90), ..nodes(100) },
    ] {
        let size = told(chamber(&surfaces), options).to_string();
        assert!(size.ends_with(
            "give 60 to 3000000 nodes, or a positive length of edges, and at least one layer"
        ));
    }
    let nowhere = Trim::Plane { point: [0.0; 3], normal: [0.0; 3] };
    for trim in [Trim::Fraction(-1.0), Trim::Fraction(f64::NAN), nowhere] {
        let error = told(chamber(&surfaces), WallOptions { trim, ..nodes(1500) });
        assert!(error.to_string().ends_with("or a point and a normal of finite length"), "{error}");
    }
    // A hole in the side, and a fold into the cavity.
    let mut hole = surfaces.clone();
    let keep = |cell: &[usize; 3], points: &[[f64; 3]]| {
        cell.iter().all(|&n| points[n][2] > -20.0 || points[n][0] < 5.0)
    };
    let points = hole[0].points.clone();
    hole[0].cells.retain(|cell| keep(cell, &points));
    let trim = Trim::Plane { point: [0.0, 0.0, 10.0], normal: [0.0, 0.0, 1.0] };
    let hole = told(chamber(&hole), WallOptions { trim, ..nodes(1500) }).to_string();
    assert!(hole.starts_with("the endocardium has a hole below the base"), "{hole}");
    let mut folded = surfaces.clone();
    folded[0].points.iter_mut().filter(|x| x[0] > 20.0 && (x[2] + 20.0).abs() < 6.0).for_each(
        |x| {
            x[0] -= 12.0;
            x[2] += 14.0;
        },
    );
    let folded = told(chamber(&folded), nodes(1500)).to_string();
    assert!(
        folded.starts_with("seen from its axis the endocardium lies behind itself at"),
        "{folded}"
    );
}

#[test]
fn mistaken_surfaces_are_told_from_each_other() {
    let [endo, epi] = &ideal();
    let told = |endocardium: &TriangleMesh, epicardium: &TriangleMesh| {
        let chamber = Chamber { endocardium, epicardium, septum: None };
        let error = chamber.wall(&nodes(1500)).unwrap_err();
        println!("{error}");
        error
    };
    for (factor, size, unit) in [(0.1, 10.0, "cm"), (0.001, 1000.0, "m"), (10.0, 10.0, "mm")] {
        let mut scaled = endo.clone();
        scaled.points.as_flattened_mut().iter_mut().for_each(|x| *x *= factor);
        let text = told(&scaled, epi).to_string();
        let expected =
            format!("a factor near {size} too far apart: the endocardium seems to be in {unit},");
        assert!(text.contains(&expected), "{text}");
    }
    assert!(told(epi, endo).to_string().contains("lies inside of the endocardium"));
    assert!(told(endo, endo).to_string().contains("are the same surface"));
    let mut shifted = endo.clone();
    shifted.points.iter_mut().for_each(|x| x[0] += 25.0);
    let text = told(&shifted, epi).to_string();
    let (counts, rest) = text.split_once(" points of the endocardium lie outside").expect("counts");
    let [count, of] =
        [0, 1].map(|k| counts.split(" of ").nth(k).unwrap().parse::<usize>().unwrap());
    let shift =
        rest.split_once("the middles of the two are ").and_then(|s| s.1.split_once(" apart"));
    let shift: f64 = shift.expect("a distance").0.parse().unwrap();
    // The middles of the boxes are 4.5 apart along z before.
    assert!(count < of && (shift - 25f64.hypot(4.5)).abs() < 0.1, "{text}");
    let island = [[300.0, 0.0, 0.0], [301.0, 0.0, 0.0], [300.0, 1.0, 0.0]];
    let mut islands = endo.clone();
    let first = islands.points.len();
    islands.points.extend(island);
    islands.point_fields.clear();
    islands.cells.push([first, first + 1, first + 2]);
    let text = told(&islands, epi).to_string();
    assert!(text.starts_with("the endocardium has 2 pieces without a common point"), "{text}");
    assert!(text.contains(" triangles and the next of 1 at (300.000, "), "{text}");
    // A tenth of the triangles, so that no plane cuts a whole wall.
    let mut holes = endo.clone();
    let mut number = 0;
    holes.cells.retain(|_| {
        number += 1;
        number % 10 != 0
    });
    let text = told(&holes, epi).to_string();
    let numbers: Vec<usize> = text.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    assert!(text.starts_with("the endocardium has ") && text.contains(" rims, the longest of "));
    assert!(numbers[0] > 10 && numbers[1] > numbers[2], "{text}");
}

#[test]
fn cavities_of_triangles_turned_either_way_are_the_same() {
    let surfaces = ideal();
    let volume = |surfaces: &[TriangleMesh; 2]| {
        chamber(surfaces).wall(&nodes(1500)).unwrap().report().cavity_volume_of_surface
    };
    let mut mixed = surfaces.clone();
    mixed[0].cells.iter_mut().step_by(2).for_each(|cell| cell.swap(0, 1));
    let [whole, mixed] = [&surfaces, &mixed].map(volume);
    // The plane of the base is the same to rounding, and turned triangles would take most of the volume away.
    assert!((mixed / whole - 1.0).abs() < 1e-6, "{mixed} for {whole}");
}

/// A half axis of an ellipsoid across x, across y, along z and where its axis is along x \[mm\].
type Ellipsoid = [f64; 4];
/// The other ventricle's endocardium, nine from the ideal cavity, and the surface around both.
const OTHER: Ellipsoid = [24.0, 28.0, 48.0, 58.0];
const AROUND: Ellipsoid = [62.0, 40.0, 80.0, 24.0];

/// The surface of an ellipsoid below the base of the ideal ventricle.
fn ellipsoid([x, y, z, shift]: Ellipsoid) -> TriangleMesh {
    let long = [z, z + 1.0];
    let mesh = TruncatedEllipsoid { short: [1.0, 2.0], long, base: 15.0 }.wall([1, 96, 48]);
    let mesh = mesh.tetrahedra();
    let mut surface = extract_surface(&mesh, &mesh.facet_sets["endo"]);
    surface.points.iter_mut().for_each(|at| *at = [x * at[0] + shift, y * at[1], at[2]]);
    surface
}

/// Approximate distance to an ellipsoid, positive outside.
fn beyond([x, y, z, shift]: Ellipsoid, at: [f64; 3]) -> f64 {
    let scaled = [(at[0] - shift) / x, at[1] / y, at[2] / z];
    let slope = [scaled[0] / x, scaled[1] / y, scaled[2] / z];
    let norm = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    (norm(scaled) - 1.0) * norm(scaled) / norm(slope)
}

#[test]
fn the_other_ventricle_bounds_the_wall() {
    let [endocardium, _] = ideal();
    let (epicardium, other) = (ellipsoid(AROUND), ellipsoid(OTHER));
    let alone = Chamber { endocardium: &endocardium, epicardium: &epicardium, septum: None };
    let chamber = Chamber { septum: Some(&other), ..alone };
    let wall = chamber.wall(&nodes(3000)).unwrap();
    let (mesh, report) = (wall.tetrahedra(), wall.report());
    println!("{report}");
    assert!(report.quality.dihedral.min > 9.0, "{report}");
    assert_eq!((report.crossings.0, report.own_crossings, report.missed), (0, 0, 0));
    // Where the other ventricle ends the thickness jumps to the surface around both.
    assert!(report.columns[1] > 0 && report.columns[1] < report.columns[0] / 2, "{report}");
    assert!(wall.hexahedra().unwrap().facet_sets.contains_key("septum"));
    let septum = &mesh.facet_sets["septum"];
    let outer = &mesh.facet_sets["epicardium"];
    assert!(septum.len() > outer.len() / 20 && septum.len() < outer.len() / 2);
    assert!(septum.iter().all(|facet| outer.contains(facet)));
    // Its nodes lie on the other ventricle and face it, but for those that end short of it; the others' outside.
    let on = |ellipsoid, node: &usize| beyond(ellipsoid, mesh.points[*node]).abs() < 0.3;
    let facing = mesh.nodes_of_facets(septum);
    let met = facing.iter().filter(|node| on(OTHER, node)).count();
    assert!(met * 3 > facing.len(), "{met} of {}", facing.len());
    assert!(facing.iter().all(|&node| mesh.points[node][0] > 20.0));
    let outside = mesh.node_sets["epicardium"].iter();
    assert!(outside.clone().all(|&node| beyond(OTHER, mesh.points[node]) > -0.3));
    let free = outside.filter(|&&node| mesh.points[node][0] < 0.0).collect::<Vec<_>>();
    assert!(!free.is_empty() && free.iter().all(|node| on(AROUND, node)));
    let near =
        |&&node: &&usize| (0..3).all(|i| (mesh.points[node][i] - [34.0, 0.0, 0.0][i]).abs() < 5.0);
    let middle = facing.iter().filter(near).collect::<Vec<_>>();
    assert!(!middle.is_empty() && middle.iter().all(|node| on(OTHER, node)));

    // Without it the wall reaches into it.
    let mesh = alone.wall(&nodes(3000)).unwrap().tetrahedra();
    assert!(!mesh.facet_sets.contains_key("septum"));
    assert!(mesh.points.iter().any(|&at| beyond(OTHER, at) < -10.0));
}

#[test]
fn rays_that_miss_and_crossings_are_told() {
    let mut surfaces = ideal();
    let whole = chamber(&surfaces).wall(&nodes(1500)).unwrap();
    assert_eq!((whole.report().missed, whole.report().warnings()), (0, vec![]));
    // A hole in the epicardium.
    let points = surfaces[1].points.clone();
    let hole = |node: &usize| points[*node][0] > 20.0 && (points[*node][2] + 20.0).abs() < 9.0;
    surfaces[1].cells.retain(|cell| !cell.iter().all(hole));
    let wall = chamber(&surfaces).wall(&nodes(1500)).unwrap();
    let report = wall.report();
    println!("{report}");
    assert!(report.missed > 5, "{report}");
    // They take the thickness beside them, which jumps nowhere.
    assert!(report.columns[1] < report.missed / 2, "{report}");
    let line = format!("nothing outside along their normal: {} of", report.missed);
    assert!(report.to_string().contains(&line), "{report}");
    let told = report.warnings();
    assert!(told.len() == 1 && told[0].contains(&format!("{} of", report.missed)), "{told:?}");
    let mut crossed = whole.report().clone();
    (crossed.crossings.0, crossed.own_crossings) = (2, 3);
    let told = crossed.warnings();
    assert!(told.len() == 2 && told[0].contains("given surfaces"), "{told:?}");
    assert!(told[1].contains("mesh's boundary crosses itself at 3"), "{told:?}");
}

#[test]
fn seven_frames_of_a_real_heart() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/biv-me");
    if !folder.exists() {
        // Written past the harness, which hides what tests that pass print.
        let _ = writeln!(
            std::io::stderr(),
            "NOT TESTED: the surfaces of a real heart are absent; an ideal one with a septum stands in"
        );
        return;
    }
    for frame in ["000", "004", "008", "012", "016", "020", "024"] {
        let [endocardium, epicardium, septum] = ["LV_ENDOCARDIAL", "EPICARDIAL", "RV_ENDOCARDIAL"]
            .map(|name| {
                read_mesh::<3>(folder.join(format!("patient1_{name}_{frame}.vtk"))).unwrap().0
            });
        assert_eq!([&endocardium, &epicardium, &septum].map(|s| s.cells.len()), [3072, 4864, 3680]);
        let chamber =
            Chamber { endocardium: &endocardium, epicardium: &epicardium, septum: Some(&septum) };
        for count in [1500, 6000] {
            let start = Instant::now();
            let wall = chamber.wall(&nodes(count)).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let (mesh, report) = (wall.tetrahedra(), wall.report());
            println!("frame {frame}, {seconds:.2} s: {report}");
            assert!(mesh.points.len().abs_diff(count) < count / 10, "{}", mesh.points.len());
            assert!(
                report.quality.dihedral.min > 9.0 && report.quality.ratio.min > 0.15,
                "{frame}: {report}"
            );
            assert!((report.cavity_volume / report.cavity_volume_of_surface - 1.0).abs() < 0.03);
            assert_eq!(report.own_crossings, 0);
            assert!(report.endocardium_distance[1] < 2.0 && report.outer_distance[0] < 0.5);
            assert!(!mesh.facet_sets["septum"].is_empty());
            let boundary = boundary_facets(&mesh);
            assert!(
                (enclosed_volume(&mesh, &boundary) / report.quality.total_volume - 1.0).abs()
                    < 1e-10
            );
        }
    }
}
