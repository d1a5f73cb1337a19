//! Regions: cells by set and label, surfaces between them, and parts cut out of a mesh.

use sinew_mesh::{
    AnyMesh, Field, Selection, TetMesh, boundary_facets, box_hexahedra, box_tetrahedra, parse_mesh,
    to_vtu,
};

/// A bar of four parts along x with labels 0 to 3, of which the first two are the set `first`.
fn bar() -> TetMesh {
    let mut bar = box_tetrahedra([4.0, 1.0, 1.0], [4, 2, 2]);
    let label = |cell: usize| {
        let x: f64 = bar.cells[cell].iter().map(|&node| bar.points[node][0]).sum();
        (x / 4.0) as i64
    };
    let labels: Vec<i64> = (0..bar.cells.len()).map(label).collect();
    let first = (0..labels.len()).filter(|&cell| labels[cell] < 2).collect();
    bar.cell_fields.insert("region".into(), Field::labels(labels));
    bar.cell_sets.insert("first".into(), first);
    bar
}

/// Heights x of the nodes of a selection.
fn at(mesh: &TetMesh, name: &str) -> Vec<f64> {
    let mut at: Vec<f64> = mesh.node_sets[name].iter().map(|&node| mesh.points[node][0]).collect();
    at.sort_by(f64::total_cmp);
    at.dedup();
    at
}

#[test]
fn the_surface_between_two_regions_survives_any_cut() {
    let pairs =
        [("region:1", "region:2"), ("2", "1"), ("first", "region:2"), ("region:2", "first")];
    for (one, other) in pairs {
        for keep in [&["0", "1", "2", "3"][..], &["first"], &["region:2", "3"], &["1"], &["2"]] {
            let mut bar = bar();
            bar.keep(keep).unwrap();
            let between = Selection::between(one, other);
            let selected = bar.select("cut", &between).unwrap();
            assert_eq!((selected.nodes, selected.facets), (9, 8), "{one} {other} {keep:?}");
            assert_eq!(at(&bar, "cut"), [2.0]);
            let boundary = boundary_facets(&bar);
            let on_boundary = bar.facet_sets["cut"].iter().all(|facet| boundary.contains(facet));
            assert_eq!(on_boundary, keep.len() != 4);
            // Of the first region, where the mesh has both.
            let owner = bar.facet_sets["cut"][0].cell;
            let side = bar.cells_of(one).is_none_or(|cells| cells.contains(&owner));
            assert!(side, "{one} {other} {keep:?}");
        }
    }
}

#[test]
fn what_is_cut_keeps_its_sets_and_fields() {
    let whole = bar();
    let mut part = whole.clone();
    let inner = whole.nodes_of_facets(&whole.facet_sets["x_max"]);
    part.node_sets.insert("inner".into(), inner);
    // Of the second part's cells, as a file may have it.
    part.select("side", &Selection::between("1", "2")).unwrap();
    part.keep(&["region:2", "region:3"]).unwrap();
    assert_eq!((part.check(), part.cells.len()), (Ok(()), whole.cells.len() / 2));
    assert_eq!(part.facet_sets["side"].len(), 8);
    assert_eq!(part.facet_sets["side"], part.facet_sets["cut:region:1"]);
    assert_eq!(part.facet_sets["side"], part.facet_sets["cut:first"]);
    assert_eq!(part.names_of_cells(), ["region:2", "region:3"]);
    assert_eq!((at(&part, "inner"), part.facet_sets["x_max"].len()), (vec![4.0], 8));
    assert!(!part.facet_sets.contains_key("x_min") && !part.node_sets.contains_key("x_min"));
    assert_eq!(part.points.len(), 3 * 9);
    // A second cut, a file in between, and cells that are quadratic by then.
    let (mut again, _) = parse_mesh::<4>("part.vtu", &to_vtu(&part).unwrap()).unwrap();
    again.keep(&["2"]).unwrap();
    let mut quadratic = again.quadratic();
    for (other, x) in [("region:1", 2.0), ("region:3", 3.0)] {
        let between = Selection::between("region:2", other);
        assert_eq!(again.select("between", &between).unwrap().facets, 8);
        assert_eq!(at(&again, "between"), [x]);
        assert_eq!(quadratic.select("between", &between).unwrap().nodes, 25);
    }
    assert_eq!(again.select("free", &Selection::between("outside", "2")).unwrap().facets, 16);
    let error = again.select("all", &Selection::between("2", "2")).unwrap_err().to_string();
    assert!(error.contains("the surface between the regions holds 0 of"), "{error}");
}

#[test]
fn a_surface_between_regions_meets_other_conditions() {
    let mut bar = bar();
    let upper = Selection::HalfSpace([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]);
    let half = Selection::between("1", "2").and(upper.clone());
    let selected = bar.select("half", &half).unwrap();
    assert_eq!((selected.nodes, selected.facets), (6, 4));
    let either = Selection::Any(vec![Selection::between("0", "1"), Selection::between("2", "3")]);
    assert_eq!(bar.select("either", &either).unwrap().facets, 16);
    assert_eq!(at(&bar, "either"), [1.0, 3.0]);
    // Of hexahedra, and with a name of its own for the region.
    let mut cubes = box_hexahedra([2.0, 1.0, 1.0], [2, 2, 1]);
    cubes.cell_sets.insert("outside".into(), vec![0, 2]);
    cubes.cell_sets.insert("wall".into(), vec![1, 3]);
    assert_eq!(cubes.select("s", &Selection::between("wall", "outside")).unwrap().facets, 2);
}

#[test]
fn names_that_mean_nothing_are_refused_with_those_that_there_are() {
    let mut bar = bar();
    let known =
        ["first", "region:0", "region:1", "region:2", "region:3"].map(String::from).to_vec();
    let unknown =
        |name: &str| format!("the mesh has no set of cells `{name}`, only {}", known.join(", "));
    assert_eq!(bar.keep(&["region:9"]).unwrap_err().to_string(), unknown("region:9"));
    let between = bar.select("x", &Selection::between("region:1", "LV"));
    assert_eq!(between.unwrap_err().to_string(), unknown("LV"));
    assert!(bar.keep::<&str>(&[]).unwrap_err().to_string().contains("no cells would stay"));
    assert_eq!(bar.names_of_cells(), known);
    // A bare label needs one field, or one called `region`; numbers of cells are no labels worth listing.
    let cells = bar.cells.len() as i64;
    bar.cell_fields.insert("number".into(), Field::labels((0..cells).collect()));
    assert_eq!(
        (bar.names_of_cells(), bar.cells_of("3").map(|cells| cells.len())),
        (known, Some(24))
    );
    assert_eq!(bar.cells_of("number:7"), Some(vec![7]));
    let labels = bar.cell_fields.remove("region").unwrap();
    assert_eq!(bar.cells_of("7"), Some(vec![7]));
    bar.cell_fields.insert("other".into(), labels);
    assert_eq!(
        (bar.cells_of("3"), bar.cells_of("other:3").map(|cells| cells.len())),
        (None, Some(24))
    );
    bar.keep(&["other:3"]).unwrap();
    assert_eq!(bar.facet_sets["cut:other:2"].len(), 8);
    let mut any = AnyMesh::from(self::bar());
    any.keep(&["first"]).unwrap();
    assert_eq!(any.cell_count(), 48);
}

#[test]
fn what_was_cut_away_without_a_name_is_not_outside() {
    let mut bar = bar();
    bar.cell_fields.clear();
    bar.keep(&["first"]).unwrap();
    let names: Vec<&String> =
        bar.facet_sets.keys().filter(|name| name.starts_with("cut:")).collect();
    assert_eq!((names.len(), bar.facet_sets["cut:"].len()), (1, 8));
    let outside = bar.select("outside", &Selection::between("first", "outside")).unwrap();
    assert_eq!(outside.facets, boundary_facets(&bar).len() - 8);
}
