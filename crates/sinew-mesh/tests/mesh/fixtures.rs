//! Files written by meshio, VTK, gmsh and NumPy (see `fixtures/mesh/generate.py`) are read
//! back and compared with the values they were made from.

use sinew_mesh::{
    AnyMesh, Field, FieldValues, MeshError, QuadraticTetMesh, ReadReport, TetMesh, boundary_facets,
    box_tetrahedra, read, read_mesh, read_npy,
};
use std::path::PathBuf;

/// The text files of VTK, and the VTU text files of meshio, round to 11 digits.
const ELEVEN_DIGITS: f64 = 5e-11;
/// The text files of VTK round single precision to 6 digits.
const SIX_DIGITS: f64 = 5e-6;
/// All other files hold the numbers themselves.
const EXACT: f64 = 0.0;

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../fixtures/mesh", name].iter().collect()
}

fn ramp(rows: usize, components: usize, divisor: f64) -> Vec<f64> {
    (0..rows * components).map(|i| i as f64 / divisor).collect()
}

fn assert_close(field: &Field, expected: &[f64], tolerance: f64, what: &str) {
    let values = field.to_f64();
    assert_eq!(values.len(), expected.len(), "{what}");
    for (value, expected) in values.iter().zip(expected) {
        let allowed = tolerance * expected.abs();
        assert!((value - expected).abs() <= allowed, "{what}: {value} is not {expected}");
    }
}

/// The box of the generator with its repaired tetrahedra and its facets.
fn assert_is_the_box(mesh: &TetMesh, report: ReadReport, name: &str) {
    let expected = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    assert_eq!(mesh.points, expected.points, "{name}");
    assert_eq!(mesh.cells, expected.cells, "{name}");
    let counts = ReadReport { repaired_cells: 6, matched_facets: 2, ..ReadReport::default() };
    assert_eq!(report, counts, "{name}");
}

fn assert_has_the_fields(mesh: &TetMesh, name: &str, tolerance: f64) {
    let points = &mesh.point_fields;
    assert_close(&points["displacement"], &ramp(12, 3, 7.0), tolerance, name);
    let single: Vec<f64> = (0..12).map(|i| f64::from((f64::from(i) / 3.0) as f32)).collect();
    let text_tolerance = if name.contains("ascii") { SIX_DIGITS } else { EXACT };
    assert_close(&points["temperature"], &single, text_tolerance, name);
    let clamped = Field::labels((0..12).map(|i| i64::from(i % 3 == 0)).collect());
    assert_eq!(points["clamped"], clamped, "{name}");
    assert_eq!(mesh.nodes_where_nonzero("clamped"), Ok(vec![0, 3, 6, 9]));
    assert_close(&mesh.cell_fields["fibre"], &ramp(12, 3, 11.0), tolerance, name);
    assert_eq!(mesh.cell_fields["region"], Field::labels(vec![0; 12]), "{name}");
    let loaded = &box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).facet_sets["x_max"];
    assert_eq!(&mesh.facet_sets["region:1"], loaded, "{name}");
    assert_eq!(mesh.facet_sets.len(), 1, "{name}");
}

#[test]
fn vtk_and_vtu_files_of_meshio() {
    let files = [
        "42_ascii.vtk",
        "42_binary.vtk",
        "51_ascii.vtk",
        "51_binary.vtk",
        "ascii.vtu",
        "plain.vtu",
        "zlib.vtu",
    ];
    for file in files {
        let name = format!("meshio_{file}");
        let (mesh, report) = read_mesh::<4>(fixture(&name)).unwrap();
        assert_is_the_box(&mesh, report, &name);
        let tolerance = if file == "ascii.vtu" { ELEVEN_DIGITS } else { EXACT };
        assert_has_the_fields(&mesh, &name, tolerance);
    }
}

#[test]
fn vtk_and_vtu_files_of_vtk() {
    let files = [
        "42_ascii.vtk",
        "42_binary.vtk",
        "51_ascii.vtk",
        "51_binary.vtk",
        "ascii_plain_32_little.vtu",
        "inline_plain_32_big.vtu",
        "inline_zlib_64_little.vtu",
        "raw_plain_64_big.vtu",
        "raw_zlib_32_little.vtu",
        "base64_plain_32_little.vtu",
        "base64_zlib_64_big.vtu",
    ];
    for file in files {
        let name = format!("vtk_{file}");
        let (mesh, report) = read_mesh::<4>(fixture(&name)).unwrap();
        assert_is_the_box(&mesh, report, &name);
        let tolerance = if name.contains("ascii") { ELEVEN_DIGITS } else { EXACT };
        assert_has_the_fields(&mesh, &name, tolerance);
        let stress = &mesh.cell_fields["stress tensor"];
        assert_eq!(stress.components, 9, "{name}");
        assert_close(stress, &ramp(12, 9, 13.0), tolerance, &name);
    }
}

#[test]
fn msh_files_of_meshio() {
    for file in ["22_ascii.msh", "22_binary.msh", "41_ascii.msh", "41_binary.msh"] {
        let name = format!("meshio_{file}");
        let (mesh, report) = read_mesh::<4>(fixture(&name)).unwrap();
        assert_is_the_box(&mesh, report, &name);
        assert_close(&mesh.point_fields["displacement"], &ramp(12, 3, 7.0), EXACT, &name);
        assert_close(&mesh.cell_fields["fibre"], &ramp(12, 3, 11.0), EXACT, &name);
        assert_eq!(mesh.cell_sets["tissue"], (0..12).collect::<Vec<_>>(), "{name}");
        let loaded = &box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).facet_sets["x_max"];
        // meshio writes no entity for the triangles into 4.1 files, so their group is lost.
        let set = if file.starts_with("22") { "loaded side" } else { "facets" };
        assert_eq!(&mesh.facet_sets[set], loaded, "{name}");
    }
}

#[test]
fn msh_files_of_gmsh() {
    let mut meshes = Vec::new();
    for file in ["22_ascii.msh", "22_binary.msh", "41_ascii.msh", "41_binary.msh"] {
        let name = format!("gmsh_{file}");
        let (mesh, report) = read_mesh::<4>(fixture(&name)).unwrap();
        let volume: f64 = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).sum();
        assert!((volume - 2.0).abs() < 1e-12, "{name}: {volume}");
        assert_eq!(report.unmatched_facets, 0, "{name}");
        assert_eq!(report.dropped_cells, 1, "{name}: the point");
        assert_eq!(mesh.cell_sets["tissue"].len(), mesh.cells.len(), "{name}");
        assert_eq!(mesh.facet_sets["clamped side"], mesh.facet_sets["physical_5"], "{name}");
        let side = mesh.nodes_of_facets(&mesh.facet_sets["clamped side"]);
        let at_zero = (0..mesh.points.len()).filter(|&node| mesh.points[node][0] == 0.0);
        assert_eq!(side, at_zero.collect::<Vec<_>>(), "{name}");
        assert_eq!(mesh.points[mesh.node_sets["origin"][0]], [0.0; 3], "{name}");
        meshes.push(mesh);
    }
    for other in &meshes[1..] {
        assert_eq!(boundary_facets(other).len(), boundary_facets(&meshes[0]).len());
        assert_eq!(other.points.len(), meshes[0].points.len());
    }
}

#[test]
fn a_plane_mesh_of_gmsh() {
    let (mesh, _) = read_mesh::<3>(fixture("gmsh_plate.msh")).unwrap();
    let area: f64 = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).sum();
    assert!((area - 2.0).abs() < 1e-12);
    assert_eq!(mesh.cell_sets["plate"].len(), mesh.cells.len());
    let left = mesh.nodes_of_facets(&mesh.facet_sets["left"]);
    assert!(left.len() >= 2 && left.iter().all(|&node| mesh.points[node][0] == 0.0));
    assert!(matches!(read(fixture("gmsh_plate.msh")).unwrap().0, AnyMesh::Triangles(_)));
}

#[test]
fn refused_files_say_what_to_do() {
    let message = |name: &str| read(fixture(name)).unwrap_err().to_string();
    let lz4 = message("vtk_base64_lz4_64_little.vtu");
    assert!(
        lz4.contains("vtkLZ4DataCompressor") && lz4.contains("save the file with zlib"),
        "{lz4}"
    );
    let quadratic = read_mesh::<4>(fixture("gmsh_quadratic.msh")).unwrap_err().to_string();
    assert!(quadratic.contains("quadratic") && quadratic.contains("linear"), "{quadratic}");
    let python = message("generate.py");
    assert!(
        python.contains("neither legacy VTK") && python.contains("(.inp), STL nor CARP"),
        "{python}"
    );
    assert!(message("no_such_file.vtk").contains("check the path"));
    let Err(MeshError::Content { problem, .. }) = read_mesh::<4>(fixture("gmsh_plate.msh")) else {
        panic!("a triangle mesh is not a tetrahedral mesh");
    };
    assert!(problem.to_string().starts_with("the mesh has no tetrahedra"), "{problem}");
}

#[test]
fn npy_files_of_numpy() {
    for kind in ["f4", "f8", "i4", "i8"] {
        for order in ["little", "big"] {
            let array = read_npy(fixture(&format!("numpy_{kind}_{order}.npy"))).unwrap();
            assert_eq!(array.shape, [3, 4]);
            let expected = match kind {
                "f4" | "f8" => FieldValues::Float((-5..7).map(f64::from).collect()),
                _ => FieldValues::Integer((-5..7).collect()),
            };
            assert_eq!(array.values, expected, "{kind} {order}");
        }
    }
    let fortran = read_npy(fixture("numpy_fortran.npy")).unwrap();
    assert_eq!(fortran.values, FieldValues::Float(ramp(3, 4, 7.0)));
    let vector = read_npy(fixture("numpy_vector.npy")).unwrap();
    assert_eq!((vector.shape, vector.values), (vec![5], FieldValues::Float(ramp(5, 1, 7.0))));
    let cube = read_npy(fixture("numpy_cube.npy")).unwrap();
    assert_eq!(cube.shape, [2, 3, 4]);
    assert_eq!(cube.values, FieldValues::Float(ramp(24, 1, 1.0)));
}

#[test]
fn quadratic_tetrahedra_of_gmsh() {
    let (mesh, report) = read_mesh::<10>(fixture("gmsh_quadratic.msh")).unwrap();
    assert_eq!((report.repaired_cells, report.unmatched_facets), (0, 0));
    assert!(!mesh.facet_sets["clamped side"].is_empty());
    for cell in &mesh.cells {
        for edge in QuadraticTetMesh::ELEMENT.edges {
            let [a, b, middle] = [0, 1, 2].map(|k| mesh.points[cell[edge[k]]]);
            for axis in 0..3 {
                assert!((middle[axis] - 0.5 * (a[axis] + b[axis])).abs() < 1e-12);
            }
        }
    }
    let volume: f64 = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).sum();
    assert!((volume - 2.0).abs() < 1e-12);
}
