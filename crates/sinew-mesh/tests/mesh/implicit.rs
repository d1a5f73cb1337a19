//! Bodies cut out of a grid: the idealised heart.

use sinew_mesh::{Biventricle, boundary_facets, enclosed_volume, quality};
use std::f64::consts::PI;

#[test]
fn the_heart_is_symmetric_and_sound() {
    let heart = Biventricle::default();
    for edge in [5.5, 4.0] {
        let mesh = heart.tetrahedra(edge);
        let summary = quality(&mesh).unwrap();
        assert!(summary.dihedral.min > 8.0, "{edge}: {summary}");
        // Every facet of the boundary is on one side, and none is lost. Where neighbouring pieces of cells did not agree on a
        // diagonal, there would be facets inside of the wall.
        let sides = ["base", "endo_left", "endo_right", "epi"];
        let named: usize = sides.iter().map(|side| mesh.facet_sets[*side].len()).sum();
        assert_eq!(named, boundary_facets(&mesh).len());
        let exact = 2.0 / 3.0 * PI * heart.radius.powi(2) * heart.depth;
        for (side, middle) in [("endo_left", -25.0), ("endo_right", 25.0)] {
            let cavity = -enclosed_volume(&mesh, &mesh.facet_sets[side]);
            // Chords cut corners: by the square of an edge over the radius.
            assert!((cavity / exact - 1.0).abs() < 0.03, "{side}: {cavity} for {exact}");
            for &node in &mesh.node_sets[side] {
                let [x, y, z] = mesh.points[node];
                let on = ((x - middle).hypot(y) / heart.radius).hypot(z / heart.depth);
                assert!((on - 1.0).abs() < 1e-12, "{side} {node}");
            }
        }
    }
}

#[test]
fn edges_have_bounds() {
    let heart = Biventricle::default();
    assert_eq!(heart.longest_edge(), 5.5);
    let shortest = heart.shortest_edge();
    // Two million cells of a grid in the box around the heart alone, 110 by 60 by 70, and no more than half as much beside it.
    let least = (110.0 * 60.0 * 70.0 / 2e6_f64).cbrt();
    assert!(least < shortest && shortest < 1.5 * least, "{shortest}");
    let large = Biventricle { radius: 2e3, depth: 6e3, ..heart };
    assert!(large.shortest_edge() > large.longest_edge());
}

#[test]
#[should_panic(expected = "and at least 0.7")]
fn an_edge_that_makes_too_many_cells_is_refused() {
    Biventricle::default().tetrahedra(0.01);
}

#[test]
#[should_panic(expected = "an edge at most 0.55")]
fn an_edge_that_reaches_through_the_wall_is_refused() {
    Biventricle::default().tetrahedra(6.0);
}
