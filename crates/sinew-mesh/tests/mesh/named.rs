//! Names for nodes and facets, fields, and the rules of a mesh.

use sinew_mesh::{Defect, Facet, Field, TetMesh, box_tetrahedra, extract_surface};

#[test]
fn what_a_condition_chooses_is_what_the_generator_named() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]).quadratic();
    mesh.name_nodes("end", |[x, _, _]| x == 2.0);
    let facets = mesh.name_facets("end", |[x, _, _]| x == 2.0);
    assert_eq!(mesh.node_sets["end"], mesh.node_sets["x_max"]);
    assert_eq!(mesh.facet_sets["end"], mesh.facet_sets["x_max"]);
    assert_eq!(facets, mesh.facet_sets["x_max"].len());
}

#[test]
fn fields_convert_to_rows() {
    let field = Field::vectors(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(field.rows(), 2);
    assert_eq!(field.to_vectors::<3>(), Some(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
    assert_eq!(field.to_vectors::<2>(), None);
    assert_eq!(Field::labels(vec![3, -1]).to_f64(), [3.0, -1.0].as_slice());
}

#[test]
fn facets_of_one_cell_have_its_row_each() {
    let mut mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let rows = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|x| [x, 10.0 * x, 100.0 * x]);
    mesh.cell_fields.insert("u".into(), Field::vectors(&rows));
    let twice = [0, 3].map(|opposite| Facet { cell: 4, opposite });
    let surface = extract_surface(&mesh, &twice);
    let expected = [4.0, 40.0, 400.0, 4.0, 40.0, 400.0];
    assert_eq!(surface.cell_fields["u"].to_f64(), expected.as_slice());
}

#[test]
fn markers_become_sets() {
    let mut mesh = box_tetrahedra([1.0; 3], [1; 3]);
    mesh.point_fields.insert("clamped".into(), Field::labels(vec![0, 1, 0, 0, 0, -2, 0, 0]));
    assert_eq!(mesh.nodes_where_nonzero("clamped"), Ok(vec![1, 5]));
    let error = mesh.nodes_where_nonzero("fixed").unwrap_err();
    assert!(error.to_string().contains("clamped"), "{error}");
}

#[test]
fn each_rule_is_checked() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let new = TetMesh::new;
    let error = new(corners.clone(), vec![[0, 1, 2, 4]]).unwrap_err();
    assert_eq!(error, Defect::NodeOutOfRange { cell: 0, node: 4, nodes: 4 });
    let error = new(corners.clone(), vec![[0, 1, 2, 1]]).unwrap_err();
    assert_eq!(error, Defect::RepeatedNode { cell: 0, node: 1 });
    let mut broken = corners.clone();
    broken[2][1] = f64::NAN;
    assert!(matches!(new(broken, vec![]), Err(Defect::NotFinite { node: 2, .. })));

    let good = new(corners, vec![[0, 1, 2, 3]]).unwrap();
    let broken_by = |change: fn(&mut TetMesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        mesh.check().unwrap_err()
    };
    let field = broken_by(|m| {
        m.point_fields.insert("u".into(), Field::scalars(vec![0.0; 3]));
    });
    assert!(matches!(field, Defect::FieldSize { values: 3, rows: 4, .. }));
    let set = broken_by(|m| {
        m.node_sets.insert("s".into(), vec![4]);
    });
    assert!(matches!(set, Defect::SetMember { index: 4, limit: 4, .. }));
    let facet = broken_by(|m| {
        m.facet_sets.insert("f".into(), vec![Facet { cell: 0, opposite: 4 }]);
    });
    assert!(matches!(facet, Defect::SetMember { index: 4, limit: 4, .. }));
}
