//! Organs as files hold them: the small ventricle of the fixtures, and the published meshes where they are.

use crate::ventricles::{fixture, published};
use sinew_mesh::{ReadReport, TetMesh, boundary_facets, enclosed_volume, quality, read_mesh};

/// Cells fill exactly what their boundary encloses.
fn assert_closed(mesh: &TetMesh) {
    let summary = quality(mesh).unwrap();
    let enclosed = enclosed_volume(mesh, &boundary_facets(mesh));
    // Rounding of sums of thousands of numbers.
    assert!((enclosed / summary.total_volume - 1.0).abs() < 1e-10);
    assert!(summary.volume.min > 0.0);
    println!("{summary}");
}

/// Numbers of nodes, cells and triangles of the endocardium.
fn assert_ventricle((mesh, report): (TetMesh, ReadReport), counts: [usize; 3]) {
    println!("{report:?}");
    assert_eq!([mesh.points.len(), mesh.cells.len(), report.matched_facets], counts);
    assert_eq!(report.unmatched_facets + report.unused_nodes, 0);
    let endocardium = &mesh.facet_sets["region:1"];
    assert_eq!(endocardium.len(), counts[2]);
    let boundary = boundary_facets(&mesh);
    assert!(endocardium.iter().all(|facet| boundary.binary_search(facet).is_ok()));
    let clamped = mesh.nodes_where_nonzero("clamped").unwrap();
    assert!(!clamped.is_empty() && clamped.len() < mesh.points.len() / 4);
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().unwrap();
    let length = |f: &[f64; 3]| f.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(fibres.iter().all(|f| (length(f) - 1.0).abs() < 1e-6));
    println!("cavity {}", enclosed_volume(&mesh, endocardium));
    assert_closed(&mesh);
}

#[test]
fn small_left_ventricle() {
    let (mesh, report) = read_mesh::<4>(fixture("ventricle.vtk")).unwrap();
    // The half ellipsoids without the chords' share, which a coarse mesh cuts off.
    let half_ellipsoid =
        |short: f64, long: f64| 2.0 / 3.0 * std::f64::consts::PI * short.powi(2) * long;
    let (inner, outer) = (half_ellipsoid(25.0, 66.0), half_ellipsoid(36.0, 75.0));
    let wall = quality(&mesh).unwrap().total_volume;
    assert!((0.9..1.0).contains(&(wall / (outer - inner))), "{wall} mm³");
    assert_ventricle((mesh, report), [363, 1344, 224]);
}

#[test]
fn published_left_ventricle() {
    if let Some(ventricle) = published("left_ventricle.vtk") {
        assert_ventricle(ventricle, [1570, 6176, 816]);
    }
}

#[test]
fn published_liver() {
    let Some((mesh, report)) = published("liver.vtk") else { return };
    println!("{report:?}");
    assert_eq!((mesh.points.len(), mesh.cells.len()), (935, 4408));
    assert_eq!(report.matched_facets + report.unmatched_facets + report.unused_nodes, 0);
    assert!(!mesh.nodes_where_nonzero("clamped").unwrap().is_empty());
    assert_closed(&mesh);
}
