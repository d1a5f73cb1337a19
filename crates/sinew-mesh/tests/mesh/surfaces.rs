//! Surfaces in files: those of VTK are what they were made from, our own come back as they were, damaged ones are named.

use crate::legacy::{VtkEncoding, to_stl, to_stl_text, to_vtk_surface, to_vtp};
use sinew_mesh::{
    Facet, Field, TriangleMesh, boundary_facets, box_tetrahedra, extract_surface, parse,
    parse_mesh, read_mesh,
};
use std::path::PathBuf;

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../fixtures/mesh", name].iter().collect()
}

/// The points behind each corner of each triangle.
fn corners(mesh: &TriangleMesh) -> Vec<[[f64; 3]; 3]> {
    mesh.cells.iter().map(|cell| cell.map(|node| mesh.points[node])).collect()
}

/// Surface by `vtk_surface` of the generator: the fan of a quadrilateral, a triangle, two triangles of a strip.
const TRIANGLES: [[usize; 3]; 5] = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [4, 5, 2]];

fn point(node: usize) -> [f64; 3] {
    let [x, y] = [(node % 3) as f64, (node / 3) as f64];
    [x, y, x * y / 4.0]
}

#[test]
fn surfaces_of_vtk_with_fields() {
    let files = [
        "42_ascii.vtk",
        "42_binary.vtk",
        "51_ascii.vtk",
        "51_binary.vtk",
        "ascii.vtp",
        "binary.vtp",
        "appended.vtp",
    ];
    for file in files.map(|file| format!("vtk_surface_{file}")) {
        let (mesh, report) = read_mesh::<3>(fixture(&file)).unwrap();
        assert_eq!(mesh.points, (0..6).map(point).collect::<Vec<_>>(), "{file}");
        let mut cells = mesh.cells.clone();
        // Strips turn every other triangle; where a triangle begins does not matter.
        cells.iter_mut().zip(TRIANGLES).for_each(|(cell, expected)| {
            let start = cell.iter().position(|node| *node == expected[0]).unwrap();
            cell.rotate_left(start);
        });
        assert_eq!(cells, TRIANGLES, "{file}");
        assert_eq!(mesh.cell_fields["row"], Field::labels(vec![2, 2, 3, 4, 4]), "{file}");
        for (node, value) in mesh.point_fields["warmth"].to_f64().iter().enumerate() {
            assert!((value - node as f64 / 7.0).abs() < 5e-11, "{file}");
        }
        // The line is an edge of the mesh, the vertex none.
        assert_eq!((report.matched_facets, report.dropped_cells), (1, 1), "{file}");
        assert_eq!(mesh.facet_sets["row:1"], [Facet { cell: 1, opposite: 1 }], "{file}");
    }
}

#[test]
fn surfaces_of_vtk_without_fields() {
    for file in ["vtk_surface_ascii.stl", "vtk_surface_binary.stl"] {
        let (mesh, report) = read_mesh::<3>(fixture(file)).unwrap();
        assert_eq!(
            (mesh.points.len(), mesh.cells.len(), report.dropped_cells),
            (6, 5, 0),
            "{file}"
        );
        let area: f64 = (0..5).map(|cell| mesh.cell_volume(cell)).sum();
        let whole = |triangles: &[[usize; 3]]| -> f64 {
            let mesh = TriangleMesh::new((0..6).map(point).collect(), triangles.to_vec()).unwrap();
            (0..triangles.len()).map(|cell| mesh.cell_volume(cell)).sum()
        };
        // The quadrilateral is not plane, and VTK may cut it the other way.
        let other = [[0, 1, 3], [1, 4, 3], [1, 2, 5], [1, 5, 4], [4, 5, 2]];
        let apart =
            [whole(&TRIANGLES), whole(&other)].map(|expected| (area / expected - 1.0).abs());
        assert!(apart.iter().any(|apart| *apart < 1e-7), "{file}: {area} {apart:?}");
    }
}

fn surface() -> TriangleMesh {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.5], [2, 1, 2]);
    let values = mesh.points.iter().map(|x| x[0] / 3.0).collect();
    mesh.point_fields.insert("a third".into(), Field::scalars(values));
    let mut surface = extract_surface(&mesh, &boundary_facets(&mesh));
    surface.cell_sets.insert("some".into(), vec![1, 4]);
    surface
}

#[test]
fn our_own_files_come_back() {
    let mesh = surface();
    let whole = [
        to_vtk_surface(&mesh, VtkEncoding::Ascii),
        to_vtk_surface(&mesh, VtkEncoding::Binary),
        to_vtp(&mesh),
    ];
    for file in whole {
        assert_eq!(parse_mesh::<3>("surface", &file).unwrap().0, mesh);
    }
    for file in [to_stl_text(&mesh), to_stl(&mesh)] {
        let (again, _) = parse_mesh::<3>("surface.stl", &file).unwrap();
        // These coordinates are exact in single precision too, and corners are one point again.
        assert_eq!((corners(&again), again.points.len()), (corners(&mesh), mesh.points.len()));
    }
    let folder = tempfile::tempdir().unwrap();
    for (ending, file) in [("vtp", to_vtp(&mesh)), ("STL", to_stl(&mesh))] {
        let path = folder.path().join(format!("surface.{ending}"));
        std::fs::write(&path, file).unwrap();
        assert_eq!(read_mesh::<3>(&path).unwrap().0.cells.len(), mesh.cells.len());
    }
}

#[test]
fn solids_of_stl_are_named_and_collapsed_triangles_left_out() {
    let facet = |[a, b, c]: [&str; 3]| {
        format!(
            "facet normal nan 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
        )
    };
    let flat = facet(["0 0 0", "1 0 0", "1 0 0"]);
    let (one, two) = (facet(["0 0 0", "1 0 0", "0 1 0"]), facet(["1 0 0", "1 1 0", "0 1 0"]));
    let text =
        format!("solid outer wall\n{one}{flat}endsolid outer wall\nsolid b\n{two}endsolid b\n");
    let (mesh, report) = parse_mesh::<3>("two.stl", text.as_bytes()).unwrap();
    assert_eq!((mesh.points.len(), mesh.cells.len(), report.dropped_cells), (4, 2, 1));
    assert_eq!((&mesh.cell_sets["outer wall"], &mesh.cell_sets["b"]), (&vec![0], &vec![1]));
}

#[test]
fn a_byte_order_mark_changes_nothing_but_places() {
    let mesh = surface();
    let files = [
        ("surface.stl", to_stl_text(&mesh)),
        ("surface.vtk", to_vtk_surface(&mesh, VtkEncoding::Binary)),
        ("surface.vtp", to_vtp(&mesh)),
        ("plate.msh", std::fs::read(fixture("gmsh_plate.msh")).unwrap()),
    ];
    for (name, file) in files {
        let marked = [b"\xef\xbb\xbf", &*file].concat();
        let read = |bytes: &[u8]| parse(name, bytes).map_err(|error| error.to_string());
        assert_eq!(read(&marked).map(|read| read.0), read(&file).map(|read| read.0), "{name}");
    }
    let error = refused("a.stl", b"\xef\xbb\xbfsolid a\nfacet n\nouter loop\nvertex 0 0 x");
    assert!(error.contains("line 4 (byte 41)") && error.contains("a coordinate"), "{error}");
}

/// The error of a file, which must name file and place.
fn refused(file: &str, bytes: &[u8]) -> String {
    let error = parse(file, bytes).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{file}, ")), "{error}");
    error
}

#[test]
fn damaged_surfaces_are_named_with_their_place() {
    let error =
        refused("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 x\n");
    assert!(error.contains("line 5") && error.contains("`x`"), "{error}");
    let mut binary = to_stl(&surface());
    binary.truncate(binary.len() - 20);
    let error = refused("a.STL", &binary);
    assert!(error.contains("triangles: only") && error.contains("byte 80"), "{error}");
    let text = String::from_utf8(to_vtk_surface(&surface(), VtkEncoding::Ascii)).unwrap();
    let error = refused("a.vtk", text.replace("POLYDATA", "STRUCTURED_GRID").as_bytes());
    assert!(error.contains("line 4") && error.contains("poly data"), "{error}");
    let cells = surface().cells.len();
    let error = refused(
        "a.vtk",
        text.replace(&format!("POLYGONS {} ", cells + 1), "POLYGONS 9 ").as_bytes(),
    );
    assert!(error.contains("an offset of a cell"), "{error}");
    let xml = String::from_utf8(to_vtp(&surface())).unwrap();
    let error = refused("a.vtp", xml.replace("\"offsets\"", "\"ends\"").as_bytes());
    assert!(error.contains("an array named offsets"), "{error}");
}
