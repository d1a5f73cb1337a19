//! Sets of nodes and facets that case files choose by place.

use crate::case_files::{blocks, refusal};
use sinew::Case;
use sinew_mesh::TriangleMesh;

/// The case of the page that chooses its sets by place, with one of its lines replaced.
fn selected(from: &str, to: &str) -> String {
    let block = blocks().into_iter().find(|block| block.contains("[select.bottom]")).unwrap();
    assert!(block.contains(from), "the page no longer holds {from:?}");
    block.replace(from, to)
}

#[test]
fn sets_are_chosen_by_place() {
    let body = Case::parse(&selected("within = 0.01", "within = 0.01"), "case.toml")
        .unwrap()
        .body()
        .unwrap();
    let mesh = &body.mesh;
    assert_eq!(mesh.node_sets()["bottom"], mesh.node_sets()["z_min"]);
    // Of the 16 facets of the top those within the first half are left out.
    let pressed = &mesh.facet_sets()["pressed"];
    assert_eq!(pressed.len(), 8);
    let top = |node: usize| body.positions[node][2] == 10.0 && body.positions[node][0] >= 10.0;
    assert!(pressed.iter().all(|&facet| mesh.nodes_of_facet(facet).into_iter().all(top)));
    // 100 mm² of 200 mm² under 0.5 kPa.
    let force: f64 = body.nodal_force.as_chunks::<3>().0.iter().map(|f| f[2]).sum();
    assert!((force + 50.0).abs() < 1e-9, "{force}");
    // One selection may name another, whatever their order.
    let chained = selected(
        "[select.pressed]",
        "[select.all]\nset = \"bottom\"\nnearest = [0.0, 0.0, 0.0]\n[select.pressed]",
    );
    let chained = chained.replace("clamped = \"bottom\"", "clamped = \"all\"");
    let error = Case::parse(&chained, "case.toml").unwrap().body().unwrap();
    assert_eq!(error.mesh.node_sets()["all"].len(), 1);
}

#[test]
fn selections_that_choose_nothing_are_told_with_the_distance() {
    let told = |from: &str, to: &str, words: &[&str]| {
        let error = refusal(&selected(from, to));
        for word in words {
            assert!(error.contains(word), "{word:?} is not in: {error}");
        }
    };
    let plane = "point = [0.0, 0.0, 0.0]";
    told(
        plane,
        "point = [0.0, 0.0, -2.0]",
        &["select.bottom", "none of 45 nodes", "misses it by 1.99 (lengths in mm)"],
    );
    told("degrees = 30.0", "degrees = 300.0", &["select.pressed", "300", "0 to 180"]);
    told(
        "direction = [0.0, 0.0, 1.0], degrees = 30.0",
        "direction = [1.0, 0.0, 1.0], degrees = 30.0",
        &["none of", "45 degrees away"],
    );
    told(
        "normal = [0.0, 0.0, 1.0]",
        "normal = [0.0, 0.0, 0.0]",
        &["select.bottom", "not a direction"],
    );
    told(
        "min = [-1.0, -1.0, 9.0]",
        "min = [11.0, -1.0, 9.0]",
        &["select.pressed", "along x", "smaller corner first"],
    );
    told("not = {", "set = \"bottomm\"\nnot = {", &["select.pressed", "bottomm"]);
    told(
        "facets = \"pressed\"",
        "facets = \"presed\"",
        &["loads.0.facets", "no selection `presed`", "did you mean `pressed`?"],
    );
    told("not = {", "set = \"pressed\"\nnot = {", &["select.pressed", "names this one"]);
    told(
        "[select.pressed]",
        "[select.other]\nset = \"bottom\"\n[select.pressed]",
        &["select.other", "nothing reads"],
    );
    told(
        "[select.pressed]\nfacing",
        "[select.pressed]\n[select.pressed.other]\nfacing",
        &["no key `other`"],
    );
    let near = "near = { surface = \"missing.stl\", within = 1.0 }";
    told("not = {", &format!("{near}\nnot = {{"), &["select.pressed", "missing.stl"]);
    told("not = {", "near = { surface = \"missing.stl\" }\nnot = {", &["missing.stl"]);
    // A set inside the body has no facets to press on.
    let inside = "[select.pressed]\nplane = { point = [5.0, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }\nset = \"loaded\"\n[select.loaded]\nnearest = [5.0, 5.0, 5.0]\n[select.rest]";
    let text = selected("[select.pressed]", inside).replace(
        "facets = \"pressed\"",
        "facets = \"pressed\" }, { traction = [0.0, 0.0, 0.0], facets = \"rest\"",
    );
    let error = refusal(&text);
    assert!(error.contains("loads.0.facets") && error.contains("1 nodes but no facet"), "{error}");
}

/// A surface as STL text.
fn stl(surface: &TriangleMesh) -> String {
    let vertex = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
    let facet = |cell: &[usize; 3]| {
        let corners = cell.map(|node| vertex(surface.points[node])).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets: String = surface.cells.iter().map(facet).collect();
    format!("solid surface\n{facets}endsolid surface\n")
}

/// A surface as VTP: a VTU file whose cells are named polygons.
fn vtp(surface: &TriangleMesh) -> String {
    let vtu = String::from_utf8(sinew_mesh::to_vtu(surface).unwrap()).unwrap();
    let vtu = vtu.replace("UnstructuredGrid", "PolyData").replace("Cells>", "Polys>");
    vtu.replace("NumberOfCells", "NumberOfPolys")
}

#[test]
fn files_are_read_by_place_surface_and_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let wall = sinew_mesh::TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
    let surface = |set: &str| sinew_mesh::extract_surface(&wall, &wall.facet_sets[set]);
    let [inner, outer] = ["endo", "epi"].map(surface);
    std::fs::write(path("inner.stl"), stl(&inner)).unwrap();
    std::fs::write(path("outer.vtp"), vtp(&outer)).unwrap();
    let mut bare = wall.clone();
    bare.node_sets.clear();
    bare.facet_sets.clear();
    sinew_mesh::write_vtu(path("bare.vtu"), &bare).unwrap();
    let case = |mesh: &str, more: &str| {
        let text = format!(
            "law = \"neo-hookean\"\nsupports = [{{ clamped = \"top\" }}]\nloads = [{{ pressure = 1.0, facets = \"cavity\" }}]\n\
             mesh = {{ file = \"{mesh}\", unit = \"cm\" }}\nparameters = {{ mu = [50.0, 100.0], lambda = [50.0, 100.0] }}\n{more}"
        );
        std::fs::write(path("case.toml"), text).unwrap();
        Case::read(&path("case.toml")).and_then(|case| case.body())
    };
    let top = wall.node_sets["base"].iter().map(|&node| wall.points[node][2]).next().unwrap();
    let select = format!(
        "[select.cavity]\nnear = {{ surface = \"inner.stl\", within = 0.01, rather_than = [\"outer.vtp\"] }}\n\
         [select.top]\nplane = {{ point = [0.0, 0.0, {}], normal = [0.0, 0.0, 1.0] }}\n",
        10.0 * top
    );
    let body = case("bare.vtu", &select).unwrap();
    assert_eq!(body.mesh.facet_sets()["cavity"], wall.facet_sets["endo"]);
    assert_eq!(body.mesh.node_sets()["top"], wall.node_sets["base"]);
    // A surface in µm beside a mesh in cm.
    let mut small = inner.clone();
    small.points.iter_mut().flatten().for_each(|x| *x *= 1e4);
    std::fs::write(path("inner.stl"), stl(&small)).unwrap();
    let error = case("bare.vtu", &select).unwrap_err().to_string();
    assert!(
        error.contains("select.cavity") && error.contains("in the unit of the mesh"),
        "{error}"
    );
    std::fs::write(path("inner.stl"), stl(&inner)).unwrap();
    // Without sets and selections the way out is named.
    let error = case("bare.vtu", "").unwrap_err().to_string();
    assert!(error.contains("[select.\"cavity\"]"), "{error}");
    // A surface is not a body, closed or open.
    let error = case("inner.stl", "").unwrap_err().to_string();
    assert!(
        error.contains("mesh.file")
            && error.contains("not a body")
            && error.contains("sinew mesh ventricle"),
        "{error}"
    );
    assert!(error.contains("16 edges of its rim") && error.contains("fTetWild"), "{error}");
    let closed = sinew_mesh::extract_surface(&wall, &sinew_mesh::boundary_facets(&wall));
    std::fs::write(path("closed.vtp"), vtp(&closed)).unwrap();
    let error = case("closed.vtp", "").unwrap_err().to_string();
    assert!(error.contains("a surface of") && error.contains("TetGen"), "{error}");
}
