//! Shapes of populations are what they are said to be.

#[path = "../../src/ventricle_shape.rs"]
mod shape;

use crate::modes::ShapeModes;
use shape::VentricleShape;
use sinew_mesh::quality;

/// Numbers of mean zero and variance one (Box and Muller 1958) from a generator of Park and Miller (1988).
fn normals(seed: u64, count: usize) -> Vec<f64> {
    // Neighbouring seeds are far apart from the third number on.
    let mut state = (0..3).fold(seed, |state, _| state * 48271 % 2_147_483_647);
    let mut uniform = || {
        state = state * 48271 % 2_147_483_647;
        state as f64 / 2_147_483_647.0
    };
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    (0..count).map(|_| normal()).collect()
}

#[test]
fn ventricles_vary_as_hearts_do() {
    let mut meshes = Vec::new();
    for seed in 1..160 {
        let shape = VentricleShape::new(&normals(seed, VentricleShape::NUMBERS));
        meshes.extend(shape.and_then(|shape| shape.tetrahedra([1, 24, 10])).ok());
    }
    // Walls that are too thin are the common reason to be refused.
    assert!(meshes.len() > 80, "{}", meshes.len());
    let places: Vec<_> = meshes.iter().map(|mesh| mesh.points.clone()).collect();
    let modes = ShapeModes::of(&places);
    // Root mean square nodal deviation of 1093 hearts along their modes [mm]; nodes inside the base and the draw of eighty shapes or more
    // leave a third.
    let hearts = [3.1, 2.0, 1.5, 1.25, 1.1, 0.8, 0.7, 0.6, 0.5, 0.5];
    for (found, heart) in modes.deviations.iter().zip(hearts) {
        assert!((found / heart - 1.0).abs() < 0.34, "{:.2?}", &modes.deviations[..10]);
    }
    // All of the numbers, and nothing else, vary: their modes are independent, and nearly linear.
    let all = modes.left_over[0];
    assert!(modes.left_over.windows(2).all(|pair| pair[1] <= pair[0]));
    assert!(modes.left_over[10] < 0.5 * all && modes.left_over[32] < 1e-6 * all);
    for mesh in &meshes {
        let summary = quality(mesh).unwrap();
        assert!(summary.dihedral.min > 3.0, "{summary}");
    }
}

#[test]
fn numbers_of_no_body_are_refused() {
    let refused = |numbers: &[f64]| VentricleShape::new(numbers).unwrap_err().to_string();
    let thin = refused(&[0.0, 0.0, -3.0]);
    assert!(thin.starts_with("the thickness of the wall of"), "{thin}");
    assert!(thin.ends_with("is not between 4.5 and 22: draw other numbers"), "{thin}");
    let large = refused(&[9.0]);
    assert!(large.contains("is not between"), "{large}");
}

/// The base of every ventricle is a plane, and its sets are the ellipsoid's, whatever the cells.
#[test]
fn ventricles_keep_their_base_and_sets() {
    let numbers: Vec<f64> = normals(7, VentricleShape::NUMBERS).iter().map(|x| 0.5 * x).collect();
    let shape = VentricleShape::new(&numbers).unwrap();
    for cells in [[1, 16, 6], [2, 24, 12], [3, 32, 16]] {
        let tetrahedra = shape.tetrahedra(cells).unwrap();
        let hexahedra = shape.hexahedra(cells).unwrap();
        assert_eq!(tetrahedra.points.len(), hexahedra.points.len());
        let base = &tetrahedra.node_sets["base"];
        assert!(base.iter().all(|&node| tetrahedra.points[node][2].abs() < 1e-12));
        assert_eq!(*base, hexahedra.node_sets["base"]);
        assert!(hexahedra.check().is_ok() && tetrahedra.check().is_ok());
    }
}

/// One standard deviation of the third number moves inner and outer surface by 1.5 mm against each other.
#[test]
fn the_third_number_is_the_thickness() {
    let shape = |numbers: &[f64]| VentricleShape::new(numbers).unwrap().tetrahedra([2, 24, 12]);
    let [mean, thick] = [&[][..], &[0.0, 0.0, 1.0]].map(|numbers| shape(numbers).unwrap());
    assert_eq!(thick.cells, mean.cells);
    let thickness = |mesh: &sinew_mesh::TetMesh| {
        let [endo, epi] =
            ["apex_endo", "apex_epi"].map(|apex| mesh.points[mesh.node_sets[apex][0]]);
        endo[2] - epi[2]
    };
    assert!((thickness(&thick) - thickness(&mean) - 3.0).abs() < 0.3);
}
