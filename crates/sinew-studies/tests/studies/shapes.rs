//! Bodies of random shape, of which reports hold the errors of methods alone.

use beam::BeamShape;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use ring::RingShape;
use sinew_sample::standard_normals;

#[path = "../../src/shapes/beam.rs"]
mod beam;
#[path = "../../src/shapes/checked.rs"]
mod checked;
#[path = "../../src/shapes/ring.rs"]
mod ring;

/// Rings are meshes without defects between two closed curves, or refused with the measure.
#[test]
fn rings_are_between_two_closed_curves() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut numbers = || standard_normals(RingShape::NUMBERS, &mut random);
    let shapes = (0..200).filter_map(|_| RingShape::new(&numbers()).ok());
    let meshes: Vec<_> = shapes.map(|shape| shape.triangles([24, 3]).unwrap()).collect();
    assert!(meshes.len() > 150, "{} of 200", meshes.len());
    for mesh in &meshes {
        assert!(mesh.check().is_ok());
        assert_eq!(mesh.facet_sets["inner"].len() + mesh.facet_sets["outer"].len(), 48);
    }
    // A round ring's area, but for the polygon that stands for the circle.
    let round = RingShape::new(&[]).unwrap().triangles([200, 2]).unwrap();
    let area: f64 = (0..round.cells.len()).map(|cell| round.cell_volume(cell)).sum();
    let exact = std::f64::consts::PI * (35f64.powi(2) - 25f64.powi(2));
    assert!((area / exact - 1.0).abs() < 1e-3, "{area} {exact}");
    assert_eq!(round.facet_sets["inner"].len(), 200);
    let mut numbers = [0.0; RingShape::NUMBERS];
    numbers[15] = -6.0;
    let thin = RingShape::new(&numbers).unwrap_err().to_string();
    assert!(thin.contains("thickness of the wall"), "{thin}");
    assert!(RingShape::new(&[0.0; 31]).is_err());
    let few = RingShape::new(&[]).unwrap().triangles([2, 1]).unwrap_err().to_string();
    assert!(few.contains("2 x 1") && few.contains("three around"), "{few}");
}

#[test]
fn beams_are_one_mesh_in_other_places_or_refused() {
    let straight = BeamShape::new(&[]).unwrap().tetrahedra([10, 3, 3]).unwrap();
    let other = [1.0, -0.5, 0.7, 0.2, -1.0, 0.3, 1.2, 0.0, 0.4, 1.5, -1.1, 0.8];
    let other = BeamShape::new(&other).unwrap().tetrahedra([10, 3, 3]).unwrap();
    assert_eq!((straight.points.len(), straight.cells.len()), (176, 540));
    assert_eq!(other.cells, straight.cells);
    assert_eq!(other.node_sets["x_min"], straight.node_sets["x_min"]);
    assert!(BeamShape::new(&[]).unwrap().tetrahedra([4, 0, 2]).is_err());
    let refused = BeamShape::new(&[0.0; 13]).unwrap_err().to_string();
    assert!(refused.contains("has 12 finite numbers; 13 were given"), "{refused}");
    // Bent back so sharply that its cells turn over.
    let bent = [0.0, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 40.0];
    let folded = BeamShape::new(&bent).unwrap().tetrahedra([4, 3, 3]).unwrap_err().to_string();
    assert!(folded.contains("the shape is folded"), "{folded}");
}
