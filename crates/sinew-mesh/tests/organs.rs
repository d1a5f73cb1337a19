//! The real meshes, which are not part of this repository.

use std::path::PathBuf;

use sinew_mesh::{ReadReport, TetMesh, boundary_facets, enclosed_volume, quality, read_tet_mesh};

/// The mesh, or a visible note that it is absent.
fn organ(name: &str) -> Option<(TetMesh, ReadReport)> {
    let parts = [env!("CARGO_MANIFEST_DIR"), "../../../shared/meshes", name];
    let path: PathBuf = parts.iter().collect();
    if !path.exists() {
        eprintln!("SKIPPED: {name} is absent");
        return None;
    }
    Some(read_tet_mesh(path).unwrap())
}

/// Cells fill exactly what their boundary encloses.
fn assert_closed(mesh: &TetMesh) {
    let summary = quality(mesh).unwrap();
    let enclosed = enclosed_volume(mesh, &boundary_facets(mesh));
    // Rounding of sums of thousands of numbers.
    assert!((enclosed / summary.total_volume - 1.0).abs() < 1e-10);
    assert!(summary.volume.min > 0.0);
    println!("{summary}");
}

#[test]
fn liver() {
    let Some((mesh, report)) = organ("liver.vtk") else { return };
    println!("{report:?}");
    assert_eq!((mesh.points.len(), mesh.cells.len()), (935, 4408));
    assert_eq!(report.matched_facets + report.unmatched_facets + report.unused_nodes, 0);
    assert!(!mesh.nodes_where_nonzero("clamped").unwrap().is_empty());
    assert_closed(&mesh);
}

#[test]
fn left_ventricle() {
    let Some((mesh, report)) = organ("left_ventricle.vtk") else { return };
    println!("{report:?}");
    assert_eq!((mesh.points.len(), mesh.cells.len()), (1570, 6176));
    assert_eq!((report.matched_facets, report.unmatched_facets), (816, 0));
    let endocardium = &mesh.facet_sets["region:1"];
    assert_eq!(endocardium.len(), 816);
    let boundary = boundary_facets(&mesh);
    assert!(endocardium.iter().all(|facet| boundary.binary_search(facet).is_ok()));
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().unwrap();
    let length = |f: &[f64; 3]| f.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(fibres.iter().all(|f| (length(f) - 1.0).abs() < 1e-6));
    println!("cavity {}", enclosed_volume(&mesh, endocardium));
    assert_closed(&mesh);
}
