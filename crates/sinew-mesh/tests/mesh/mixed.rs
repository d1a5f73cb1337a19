//! Meshes of cells in memory.

use sinew_mesh::{Field, MixedMesh};

fn tetrahedron() -> MixedMesh {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut mixed = MixedMesh::new(corners);
    mixed.add_cells(10, 4, &[0, 1, 2, 3]).unwrap();
    mixed
}

#[test]
fn what_is_wrong_is_said_without_a_file() {
    let said = |mixed: MixedMesh| mixed.into_mesh().unwrap_err().to_string();
    let mut missing = tetrahedron();
    missing.add_cells(10, 4, &[0, 1, 2, 7]).unwrap();
    assert!(said(missing).contains('7'));
    let mut set = tetrahedron();
    set.name_nodes("tip", [4]);
    assert!(said(set).contains("tip"));
    let mut field = tetrahedron();
    field.cell_fields.insert("region".into(), Field::labels(vec![1, 2]));
    assert!(said(field).contains("region"));
    let mut wedge = tetrahedron();
    wedge.add_cells(13, 6, &[0, 1, 2, 3, 0, 1]).unwrap();
    assert!(said(wedge).contains("wedge"));
    assert!(tetrahedron().add_cells(5, 3, &[0, 1]).unwrap_err().to_string().contains("3 nodes"));
}

#[test]
fn names_and_fields_go_with_their_cells() {
    let mut mixed = tetrahedron();
    let bottom = mixed.add_cells(5, 3, &[2, 1, 0]).unwrap();
    mixed.name_cells("bottom", bottom);
    mixed.name_nodes("tip", [3, 3]);
    mixed.cell_fields.insert("stiff".into(), Field::scalars(vec![2.0, 9.0]));
    mixed.point_fields.insert("height".into(), Field::scalars(vec![0.0, 0.0, 0.0, 1.0]));
    let (mesh, _) = mixed.into_mesh().unwrap();
    assert_eq!((mesh.facet_sets()["bottom"].len(), &mesh.node_sets()["tip"]), (1, &vec![3]));
    assert_eq!(mesh.cell_fields()["stiff"].to_f64(), [2.0].as_slice());
    assert_eq!(mesh.point_fields()["height"].rows(), 4);
}
