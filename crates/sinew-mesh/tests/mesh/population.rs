//! Shapes of populations are what they are said to be.

use sinew_mesh::{BeamShape, RingShape, ShapeError, ShapeModes, VentricleShape, quality};

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
    let modes = ShapeModes::of(&places).unwrap();
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
fn cells_of_no_mesh_are_refused_and_not_panicked_at() {
    let ventricle = VentricleShape::new(&[]).unwrap();
    for cells in [[0, 16, 8], [1, 0, 8], [1, 36, 18], [1, 16, 2], [1, 16, 0]] {
        let told = ventricle.tetrahedra(cells).unwrap_err().to_string();
        assert!(told.contains("a multiple of 8 below 8 times"), "{told}");
        assert!(ventricle.hexahedra(cells).is_err());
    }
    assert!(BeamShape::new(&[]).unwrap().tetrahedra([4, 0, 2]).is_err());
    let told = RingShape::new(&[]).unwrap().triangles([2, 1]).unwrap_err().to_string();
    assert!(told.contains("2 x 1") && told.contains("three around"), "{told}");
}

#[test]
fn numbers_of_no_body_are_refused() {
    assert!(matches!(BeamShape::new(&[0.0; 13]), Err(ShapeError::Numbers { found: 13, most: 12 })));
    assert!(matches!(VentricleShape::new(&[f64::NAN]), Err(ShapeError::Numbers { .. })));
    let thin = VentricleShape::new(&[0.0, 0.0, -3.0]).unwrap_err();
    assert!(matches!(thin, ShapeError::Measure { what: "thickness of the wall", .. }), "{thin}");
    assert!(thin.to_string().contains("draw other numbers"), "{thin}");
    let large = VentricleShape::new(&[9.0]).unwrap_err();
    assert!(matches!(large, ShapeError::Measure { .. }), "{large}");
    // A beam that is bent back so sharply that its cells turn over.
    let bent =
        BeamShape::new(&[0.0, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 40.0]).unwrap();
    let folded = bent.tetrahedra([4, 3, 3]).unwrap_err();
    assert!(matches!(folded, ShapeError::Folded { .. }), "{folded}");
    assert!(ShapeModes::of(&[vec![[0.0; 3]]]).is_err());
    assert!(ShapeModes::of(&[vec![[0.0; 3]], vec![[0.0; 3]]]).is_err());
}

/// Rings are meshes without defects between two closed curves, or refused with the measure.
#[test]
fn rings_are_between_two_closed_curves() {
    let shapes = (0..200).filter_map(|k| RingShape::new(&normals(k, RingShape::NUMBERS)).ok());
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
    let thin = RingShape::new(&{
        let mut numbers = [0.0; RingShape::NUMBERS];
        numbers[15] = -6.0;
        numbers
    });
    assert!(matches!(thin, Err(ShapeError::Measure { what: "thickness of the wall", .. })));
    assert!(RingShape::new(&[0.0; 31]).is_err());
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
