//! Round trips: written meshes read back bit for bit.

use crate::legacy::{VtkEncoding, to_vtk};
use proptest::collection::{btree_map, btree_set, vec};
use proptest::prelude::*;
use sinew_mesh::{
    AnyMesh, Facet, Field, FieldValues, HexMesh, Mesh, QuadraticTetMesh, QuadraticTriangleMesh,
    TetMesh, TriangleMesh, box_hexahedra, box_tetrahedra, parse_mesh, parse_npy, read, read_mesh,
    read_npy, rectangle_triangles, to_npy, to_vtu, write_pvd, write_vtu,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Any number that text can carry: only the payload of "not a number" is lost there.
fn numbers() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_map(|x| if x.is_nan() { f64::NAN } else { x })
}

fn field(rows: usize) -> impl Strategy<Value = Field> {
    (1usize..5, any::<bool>()).prop_flat_map(move |(components, integers)| {
        let count = rows * components;
        let values = if integers {
            vec(any::<i64>(), count).prop_map(FieldValues::Integer).boxed()
        } else {
            vec(numbers(), count).prop_map(FieldValues::Float).boxed()
        };
        values.prop_map(move |values| Field { components, values })
    })
}

/// Names with blanks, quotes, markup and other alphabets.
fn name() -> impl Strategy<Value = String> {
    "[a-zA-Z0-9 _:%\"'<>&;äλ𝛼/\\\\-]{1,12}"
}

/// Mesh with sets, fields and nodes moved by up to `shift` along x.
fn decorated<const N: usize>(mesh: Mesh<N>, shift: f64) -> impl Strategy<Value = Mesh<N>> {
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    let facet = (0..cells, 0..Mesh::<N>::ELEMENT.facets.len())
        .prop_map(|(cell, opposite)| Facet { cell, opposite });
    let jitter = vec(-shift..shift, nodes);
    let sets = |limit: usize| btree_map(name(), btree_set(0..limit, 0..limit), 0..3);
    let facet_sets = btree_map(name(), btree_set(facet, 0..cells), 0..3);
    let fields = |rows| btree_map(name(), field(rows), 0..3);
    (jitter, sets(nodes), sets(cells), facet_sets, fields(nodes), fields(cells)).prop_map(
        move |(jitter, node_sets, cell_sets, facet_sets, point_fields, cell_fields)| {
            let mut mesh = mesh.clone();
            mesh.points.iter_mut().zip(jitter).for_each(|(point, shift)| point[0] += shift);
            let lists = |sets: BTreeMap<String, BTreeSet<usize>>| {
                sets.into_iter().map(|(name, set)| (name, set.into_iter().collect())).collect()
            };
            mesh.node_sets = lists(node_sets);
            mesh.cell_sets = lists(cell_sets);
            let in_order =
                |(name, set): (String, BTreeSet<Facet>)| (name, set.into_iter().collect());
            mesh.facet_sets = facet_sets.into_iter().map(in_order).collect();
            mesh.point_fields = point_fields;
            mesh.cell_fields = cell_fields;
            mesh
        },
    )
}

/// Bit for bit, so that the sign of zero and "not a number" count.
fn assert_same<const N: usize>(read: &Mesh<N>, written: &Mesh<N>) {
    let bits = |field: &Field| match &field.values {
        FieldValues::Float(values) => {
            (field.components, values.iter().map(|v| v.to_bits()).collect())
        }
        FieldValues::Integer(values) => {
            (field.components, values.iter().map(|&v| v as u64).collect::<Vec<_>>())
        }
    };
    let all_bits = |fields: &BTreeMap<String, Field>| -> Vec<_> {
        fields
            .iter()
            .map(|(name, field)| {
                (name.clone(), bits(field), matches!(field.values, FieldValues::Float(_)))
            })
            .collect()
    };
    assert_eq!(all_bits(&read.point_fields), all_bits(&written.point_fields));
    assert_eq!(all_bits(&read.cell_fields), all_bits(&written.cell_fields));
    assert_eq!(read.points, written.points);
    assert_eq!(read.cells, written.cells);
    assert_eq!(read.node_sets, written.node_sets);
    assert_eq!(read.cell_sets, written.cell_sets);
    assert_eq!(read.facet_sets, written.facet_sets);
}

fn tetrahedra() -> impl Strategy<Value = TetMesh> {
    decorated(box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]), 0.1)
}

fn triangles() -> impl Strategy<Value = TriangleMesh> {
    decorated(rectangle_triangles([2.0, 1.0], [2, 1]), 0.1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..Default::default() })]

    #[test]
    fn tetrahedra_through_vtk_and_vtu(mesh in tetrahedra()) {
        for encoding in [VtkEncoding::Ascii, VtkEncoding::Binary] {
            let bytes = to_vtk(&mesh, encoding);
            let (read, report) = parse_mesh::<4>("mesh.vtk", &bytes).unwrap();
            assert_same(&read, &mesh);
            prop_assert_eq!(report, Default::default());
        }
        let (read, _) = parse_mesh::<4>("mesh.vtu", &to_vtu(&mesh).unwrap()).unwrap();
        assert_same(&read, &mesh);
    }

    #[test]
    fn triangles_through_vtk_and_vtu(mesh in triangles()) {
        for encoding in [VtkEncoding::Ascii, VtkEncoding::Binary] {
            let bytes = to_vtk(&mesh, encoding);
            assert_same(&parse_mesh::<3>("mesh.vtk", &bytes).unwrap().0, &mesh);
        }
        let bytes = to_vtu(&mesh).unwrap();
        assert_same(&parse_mesh::<3>("mesh.vtu", &bytes).unwrap().0, &mesh);
    }

    #[test]
    fn arrays_through_npy(rows in 0usize..5, columns in 1usize..5, seed in vec(numbers(), 16)) {
        let values = &seed[..rows * columns];
        let array = parse_npy("u.npy", &to_npy(&[rows, columns], values)).unwrap();
        let FieldValues::Float(read) = array.values else { panic!("not floats") };
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!((array.shape, bits(&read)), (vec![rows, columns], bits(values)));
    }
}

#[test]
fn broken_meshes_and_names_are_not_written() {
    let good = box_tetrahedra([1.0; 3], [1; 3]);
    for name in ["", "node_set:a", "two\nlines"] {
        let mut mesh = good.clone();
        mesh.point_fields.insert(name.into(), Field::labels(vec![0; 8]));
        assert!(to_vtu(&mesh).is_err(), "{name:?}");
    }
    let mut mesh = good.clone();
    mesh.node_sets.insert("far".into(), vec![8]);
    assert!(to_vtu(&mesh).is_err());
}

#[test]
fn files_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("text.vtk"), to_vtk(&mesh, VtkEncoding::Ascii)).unwrap();
    std::fs::write(at("binary.vtk"), to_vtk(&mesh, VtkEncoding::Binary)).unwrap();
    write_vtu(at("mesh.vtu"), &mesh).unwrap();
    for name in ["text.vtk", "binary.vtk", "mesh.vtu"] {
        let (read, _) = read(at(name)).unwrap();
        assert_eq!(read, AnyMesh::Tetrahedra(mesh.clone()), "{name}");
        assert_eq!(read_mesh::<4>(at(name)).unwrap().0, mesh, "{name}");
    }
    let plate = rectangle_triangles([1.0, 1.0], [1, 1]);
    write_vtu(at("plate.vtu"), &plate).unwrap();
    assert_eq!(read_mesh::<3>(at("plate.vtu")).unwrap().0, plate);
    std::fs::write(at("u.npy"), to_npy(&[1, 2], &[0.5, -1.0])).unwrap();
    assert_eq!(read_npy(at("u.npy")).unwrap().values, FieldValues::Float(vec![0.5, -1.0]));
    write_pvd(at("series.pvd"), &[(0.0, Path::new("mesh.vtu")), (0.25, Path::new("a&b.vtu"))])
        .unwrap();
    let series = std::fs::read_to_string(at("series.pvd")).unwrap();
    assert!(series.contains("<DataSet timestep=\"0.25\" part=\"0\" file=\"a&amp;b.vtu\"/>"));
    let error = write_vtu(at("no/folder.vtu"), &mesh).unwrap_err().to_string();
    assert!(error.contains("folder.vtu") && error.contains("check the path"), "{error}");
}

fn quadratic_tetrahedra() -> impl Strategy<Value = QuadraticTetMesh> {
    decorated(box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).quadratic(), 0.01)
}

fn quadratic_triangles() -> impl Strategy<Value = QuadraticTriangleMesh> {
    decorated(rectangle_triangles([2.0, 1.0], [2, 1]).quadratic(), 0.01)
}

fn hexahedra() -> impl Strategy<Value = HexMesh> {
    decorated(box_hexahedra([2.0, 1.0, 1.0], [2, 1, 1]), 0.1)
}

fn assert_survives<const N: usize>(mesh: &Mesh<N>) {
    for bytes in
        [to_vtk(mesh, VtkEncoding::Ascii), to_vtk(mesh, VtkEncoding::Binary), to_vtu(mesh).unwrap()]
    {
        let (read, report) = parse_mesh("mesh", &bytes).unwrap();
        assert_same(&read, mesh);
        assert_eq!(report, Default::default());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..Default::default() })]

    #[test]
    fn quadratic_tetrahedra_through_vtk_and_vtu(mesh in quadratic_tetrahedra()) {
        assert_survives(&mesh);
    }

    #[test]
    fn quadratic_triangles_through_vtk_and_vtu(mesh in quadratic_triangles()) {
        assert_survives(&mesh);
    }

    #[test]
    fn hexahedra_through_vtk_and_vtu(mesh in hexahedra()) {
        assert_survives(&mesh);
    }
}
