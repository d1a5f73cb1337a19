//! Sets by place against the sets that generators name, and what an empty one says.

use sinew_mesh::{
    Mesh, Selection, TetMesh, TruncatedEllipsoid, boundary_facets, box_hexahedra, box_tetrahedra,
    extract_surface, rectangle_triangles,
};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

#[track_caller]
fn assert_is<const N: usize>(mesh: &mut Mesh<N>, selection: &Selection, set: &str) {
    mesh.select("chosen", selection).unwrap();
    assert_eq!(mesh.node_sets["chosen"], mesh.node_sets[set], "{selection:?}");
    assert_eq!(mesh.facet_sets["chosen"], mesh.facet_sets[set], "{selection:?}");
}

#[test]
fn each_condition_finds_the_side_of_a_box() {
    fn check<const N: usize>(mut mesh: Mesh<N>) {
        assert_is(&mut mesh, &Selection::plane([2.0, 9.0, 9.0], [5.0, 0.0, 0.0]), "x_max");
        assert_is(&mut mesh, &Selection::Plane([2.2, 0.0, 0.0], X, 0.3), "x_max");
        assert_is(&mut mesh, &Selection::HalfSpace([1.9, 0.0, 0.0], X), "x_max");
        assert_is(&mut mesh, &Selection::Box([1.9, -1.0, -1.0], [2.0, 1.0, 1.0]), "x_max");
        assert_is(&mut mesh, &Selection::Facing(X, 1.0), "x_max");
        assert_is(&mut mesh, &Selection::set("x_max"), "x_max");
        // Half of a degree of rounding in single precision does not matter.
        mesh.points.iter_mut().flatten().for_each(|x| *x *= 1.000_001);
        assert_is(&mut mesh, &Selection::plane([2.0, 0.0, 0.0], X), "x_max");
    }
    check(box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]));
    check(box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]).quadratic());
    check(box_hexahedra([2.0, 1.0, 1.0], [4, 2, 2]));
    check(rectangle_triangles([2.0, 1.0], [4, 2]));
}

fn wall() -> TetMesh {
    TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra()
}

fn opposite(selection: Selection) -> Selection {
    Selection::Not(Box::new(selection))
}

#[test]
fn surfaces_tell_the_inside_of_a_ventricle_from_its_outside() {
    let mut wall = wall();
    let surface = |set: &str| extract_surface(&wall, &wall.facet_sets[set]);
    let [inner, outer, base] = ["endo", "epi", "base"].map(surface);
    // The set of nodes reaches through the wall to the middle surface, the facets do not.
    wall.select("near", &Selection::near(&inner, 0.01)).unwrap();
    assert_eq!(wall.facet_sets["near"], wall.facet_sets["endo"]);
    assert_eq!(wall.node_sets["near"], wall.node_sets["endo"]);
    let not_base = opposite(Selection::set("base"));
    wall.select("nearer", &Selection::nearer(&inner, [&outer, &base]).and(not_base)).unwrap();
    let mut nodes = wall.node_sets["nearer"].clone();
    nodes.retain(|node| !wall.node_sets["endo"].contains(node));
    // Some of the nodes in the middle of the wall are as near to the endocardium as rounding has it.
    assert!(nodes.iter().all(|node| !wall.node_sets["epi"].contains(node)));
    assert!(wall.facet_sets["nearer"].iter().all(|facet| wall.facet_sets["endo"].contains(facet)));
}

#[test]
fn a_selection_and_its_opposite_are_all_there_is() {
    let mut wall = wall();
    let boundary = boundary_facets(&wall);
    for selection in
        [Selection::Facing(Z, 40.0), Selection::Sphere([5.0, 0.0, 0.0], 9.0), Selection::set("epi")]
    {
        let some = wall.select("some", &selection).unwrap();
        let rest = wall.select("rest", &opposite(selection)).unwrap();
        assert_eq!(some.facets + rest.facets, boundary.len());
        assert!(some.facets > 0 && rest.facets > 0);
        let both = Selection::Any(vec![Selection::set("some"), Selection::set("rest")]);
        assert_eq!(wall.select("all", &both).unwrap().facets, boundary.len());
    }
}

#[test]
fn combinations_and_the_nearest_node() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]);
    let edge = Selection::plane([2.0, 0.0, 0.0], X).and(Selection::plane([0.0, 0.0, 1.0], Z));
    assert_eq!(mesh.select("edge", &edge).unwrap().nodes, 3);
    assert_eq!(mesh.facet_sets["edge"], []);
    assert_eq!(mesh.select("one", &Selection::Nearest([2.1, 1.3, 1.2])).unwrap().nodes, 1);
    assert_eq!(mesh.points[mesh.node_sets["one"][0]], [2.0, 1.0, 1.0]);
    // Two nodes as near.
    assert_eq!(mesh.select("two", &Selection::Nearest([0.25, 0.0, 0.0])).unwrap().nodes, 2);
    let three = edge.and(Selection::HalfSpace([0.0, 0.9, 0.0], [0.0, 1.0, 0.0]));
    assert_eq!(mesh.select("corner", &three).unwrap().nodes, 1);
    // Sides, but for the top: facets by their normal keep nodes inside the body out.
    let round = opposite(Selection::Facing(Z, 45.0))
        .and(opposite(Selection::Facing([0.0, 0.0, -1.0], 45.0)));
    assert_eq!(mesh.select("round", &round).unwrap().facets, 2 * (4 * 2 * 2 + 2 * 2 * 2));
    // A union keeps the nodes of the parts that normals do not decide, inside the body too.
    let top = Selection::Facing(Z, 10.0);
    let inside = Selection::Nearest([1.0, 0.5, 0.5]);
    let union = mesh.select("union", &Selection::Any(vec![top, inside])).unwrap();
    assert_eq!((union.nodes, union.facets), (5 * 3 + 1, 2 * 4 * 2));
}

#[test]
fn an_empty_selection_says_how_near_the_nearest_came() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]);
    let mut refuse = |selection: Selection| mesh.select("s", &selection).unwrap_err().to_string();
    let message = refuse(Selection::plane([2.5, 0.0, 0.0], X));
    assert!(message.contains("`s` holds nothing: the plane holds none of 45 nodes"), "{message}");
    assert!(message.contains("at [2, 0, 0], misses it by 0.5"), "{message}");
    let message = refuse(Selection::Facing([1.0, 0.0, 1.0], 10.0));
    assert!(
        message.contains("none of 80 facets, of which the nearest is 45 degrees away"),
        "{message}"
    );
    let message =
        refuse(Selection::plane([0.0; 3], X).and(Selection::Sphere([2.0, 0.0, 0.0], 0.1)));
    assert!(
        message.contains(
            "the plane holds 9 of 45 nodes, the sphere holds 1 of 45 nodes; none is in all"
        ),
        "{message}"
    );
    assert!(!mesh.node_sets.contains_key("s"));
}

#[test]
fn distances_from_a_surface_are_those_from_a_cube() {
    let cube = box_tetrahedra([2.0; 3], [5; 3]);
    let surface = extract_surface(&cube, &boundary_facets(&cube));
    for step in 0..300 {
        let point = [0.37, 0.73, 1.31].map(|f| 5.0 * (f * f64::from(step)).sin());
        let beyond = point.map(|x: f64| (-x).max(x - 2.0));
        let outside = beyond.map(|x| x.max(0.0).powi(2)).iter().sum::<f64>().sqrt();
        let inside = -beyond.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let expected = if outside > 0.0 { outside } else { inside };
        // So small a mesh that the tolerance of selections, which is relative to it, is rounding.
        let mut points = vec![point; 4];
        (0..3).for_each(|axis| points[axis + 1][axis] += 1e-8);
        let mut mesh = TetMesh::new(points, vec![[0, 1, 2, 3]]).unwrap();
        let mut holds = |within: f64| {
            mesh.select("near", &Selection::near(&surface, within)).is_ok()
                && mesh.node_sets["near"].contains(&0)
        };
        assert!(!holds(expected - 1e-12) && holds(expected + 1e-12), "{point:?}");
    }
}

#[test]
fn senseless_selections_are_refused() {
    let mut mesh = box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]);
    let mut refuse = |selection: Selection| mesh.select("s", &selection).unwrap_err().to_string();
    let plane = refuse(Selection::plane([0.0; 3], [0.0; 3]));
    assert!(plane.starts_with("[0, 0, 0] is not a direction"), "{plane}");
    let facing = refuse(Selection::Facing(X, 190.0));
    assert!(facing.starts_with("190 is not an angle"), "{facing}");
    assert!(refuse(Selection::Sphere([0.0; 3], -1.0)).starts_with("the radius is -1;"));
    let nearest = refuse(Selection::Nearest([f64::NAN; 3]));
    assert!(nearest.starts_with("[NaN, NaN, NaN] is not a point"), "{nearest}");
    let cuboid = refuse(Selection::Box([0.0, 2.0, 0.0], X));
    assert!(cuboid.starts_with("along y the box goes from 2 to 0;"), "{cuboid}");
    assert!(refuse(Selection::set("y_mix")).contains("y_max"));
    assert!(refuse(Selection::Any(vec![])).contains("no selections"));
    assert!(refuse(Selection::near(&Mesh::default(), 1.0)).contains("without triangles"));
}
