//! Names for nodes and facets, fields, and the rules of a mesh.

use sinew_mesh::{Facet, Field, TetMesh, box_tetrahedra, extract_surface};

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
    let message = |cells| new(corners.clone(), cells).unwrap_err().to_string();
    let missing = message(vec![[0, 1, 2, 4]]);
    assert!(missing.starts_with("cell 0 names node 4, but nodes run from 0 to 3"), "{missing}");
    let repeated = message(vec![[0, 1, 2, 1]]);
    assert!(repeated.starts_with("cell 0 names node 1 twice"), "{repeated}");
    let mut broken = corners.clone();
    broken[2][1] = f64::NAN;
    let not_finite = new(broken, vec![]).unwrap_err().to_string();
    assert_eq!(not_finite, "node 2 lies at (0, NaN, 0); give it finite coordinates");

    let good = new(corners, vec![[0, 1, 2, 3]]).unwrap();
    let broken_by = |change: fn(&mut TetMesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        mesh.check().unwrap_err().to_string()
    };
    let field = broken_by(|m| {
        m.point_fields.insert("u".into(), Field::scalars(vec![0.0; 3]));
    });
    assert!(field.starts_with("field `u` holds 3 numbers, but 4 rows of 1 components"), "{field}");
    let set = broken_by(|m| {
        m.node_sets.insert("s".into(), vec![4]);
    });
    assert!(set.starts_with("set `s` names index 4, but there are only 4"), "{set}");
    let facet = broken_by(|m| {
        m.facet_sets.insert("f".into(), vec![Facet { cell: 0, opposite: 4 }]);
    });
    assert!(facet.starts_with("set `f` names index 4, but there are only 4"), "{facet}");
}
