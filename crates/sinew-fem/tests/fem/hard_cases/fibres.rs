//! Material directions that are missing, wrong or about to change sides.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{Guccione, HolzapfelOgden};
use sinew_energy::{Law, Prescribed, Scene, SceneError, Support};
use sinew_mesh::{TetMesh, box_tetrahedra};

const HO: sinew_energy::NearlyIncompressible<HolzapfelOgden> =
    HolzapfelOgden.nearly_incompressible(50.0);
const SOFT: [f64; 4] = [1.0, 2.0, 5.0, 3.0];

/// Error of lowering a block whose cell 4 has this fibre.
#[track_caller]
fn refused_fibre(fibre: [f64; 3]) -> SceneError {
    let mut fibres = vec![[[0.0, 0.0, 1.0]]; 6];
    fibres[4] = [fibre];
    let error = scene(HO.along(fibres), cube(1)).lower().unwrap_err();
    println!("{error}");
    error
}

#[test]
fn a_fibre_of_length_zero_is_refused_with_its_cell() {
    let expected = SceneError::Fibres(
        "direction 0 of cell 4 has length 0, not 1; normalise it, and give a direction to every cell that has none".into(),
    );
    assert_eq!(refused_fibre([0.0; 3]), expected);
}

#[test]
fn a_fibre_that_is_not_unit_is_refused_with_its_length() {
    let expected = SceneError::Fibres(
        "direction 0 of cell 4 has length 5, not 1; normalise it, and give a direction to every cell that has none".into(),
    );
    assert_eq!(refused_fibre([3.0, 4.0, 0.0]), expected);
}

#[test]
fn a_fibre_that_is_no_number_or_infinite_is_refused() {
    for component in [f64::NAN, f64::INFINITY, 1e200] {
        let error = refused_fibre([component, 0.0, 1.0]);
        let text = error.to_string();
        let rest = text.strip_prefix("direction 0 of cell 4 has length ").expect("that direction");
        let length: f64 = rest.split_once(", not 1").expect("a length").0.parse().unwrap();
        assert!(!length.is_finite(), "{text}");
    }
}

#[test]
fn missing_fibres_are_refused_with_both_counts() {
    for given in [0, 5] {
        let scene = scene(HO.along(vec![[[1.0, 0.0, 0.0]]; given]), cube(1));
        let expected = SceneError::Fibres(format!(
            "the law reads 1 directions, for each of the 6 cells, 6 quadrature points or 8 nodes, but {given} rows are given"
        ));
        assert_eq!(scene.lower().unwrap_err(), expected);
    }
}

#[test]
fn a_frame_that_is_not_perpendicular_is_refused_with_the_product() {
    let mut frames = vec![Guccione::frame([1.0, 0.0, 0.0]); 6];
    frames[2][1] = [0.6, 0.8, 0.0];
    let law = Guccione.nearly_incompressible(50.0);
    let error = scene(law.along(frames), cube(1)).lower().unwrap_err();
    let text = error.to_string();
    let before = "directions 0 and 1 of cell 2 have the inner product ";
    let product = text.strip_prefix(before).and_then(|rest| rest.split_once(", not 0"));
    assert_close(product.expect("a product").0.parse().unwrap(), 0.6, 1e-15);
}

#[test]
fn fibres_that_are_squeezed_leave_the_load_to_the_matrix() {
    // Half of the cells have fibres along the load, half across: compression switches the first off.
    let mesh = box_tetrahedra([1.0, 1.0, 2.0], [2, 2, 4]);
    let fibre = |cell| [if cell % 2 == 0 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] }];
    let fibres = (0..mesh.cells.len()).map(fibre).collect();
    let mut scene = scene(HO.along(fibres), mesh);
    scene.supports = vec![Support::clamped("z_min")];
    for force in [-1.5, 1.5] {
        scene.loads = vec![traction("z_max", [0.0, 0.0, force])];
        let block = scene.lower().unwrap();
        let solution = solve(&block, &SOFT).unwrap();
        assert_sound(&block, &solution);
    }
}

/// The rotation by `angle` about the diagonal (1, 1, 1).
fn about_diagonal(angle: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    let (same, next, last) = (
        (1.0 + 2.0 * cosine) / 3.0,
        (1.0 - cosine) / 3.0 - sine / 3.0_f64.sqrt(),
        (1.0 - cosine) / 3.0 + sine / 3.0_f64.sqrt(),
    );
    move |x| std::array::from_fn(|i| same * x[i] + next * x[(i + 1) % 3] + last * x[(i + 2) % 3])
}

#[test]
fn a_rotated_twin_with_rotated_fibres_has_the_rotated_solution() {
    let fibre = [0.6, 0.0, 0.8];
    let build = |turn: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let mut mesh: TetMesh = box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 2]);
        mesh.points.iter_mut().for_each(|x| *x = turn(*x));
        Scene {
            loads: vec![traction("x_max", turn([0.1, 0.2, -0.3]))],
            ..with_directions(HO, mesh, [turn(fibre)])
        }
        .lower()
        .unwrap()
    };
    let turn = about_diagonal(1.234);
    let (plain, turned) = (build(&|x| x), build(&turn));
    let (one, two) = (solve(&plain, &SOFT).unwrap(), solve(&turned, &SOFT).unwrap());
    assert_sound(&turned, &two);
    let rotated: Vec<_> =
        one.displacement.as_chunks::<3>().0.iter().flat_map(|&u| turn(u)).collect();
    assert!(difference(&two.displacement, &rotated) < 1e-9);
    assert_close(two.energy, one.energy, 1e-10);
}

#[test]
fn fibres_at_exactly_their_rest_length_are_no_obstacle() {
    // The fibre term switches on at stretch 1, where all of a body at rest is: pull across and along.
    let mut scene = with_directions(HO, cube(2), [[1.0, 0.0, 0.0]]);
    let rows = |motion: f64| {
        Prescribed::PerNode(vec![[Some(motion), None, None]; scene.mesh.node_sets()["x_max"].len()])
    };
    let (stretched, squeezed) = (rows(1e-9), rows(-1e-9));
    let mut energy = |displacement| {
        scene.supports = corner_rollers();
        scene.supports.push(Support { nodes: "x_max".into(), displacement });
        let bar = scene.lower().unwrap();
        let solution = solve(&bar, &SOFT).unwrap();
        assert_sound(&bar, &solution);
        solution.energy / 0.5e-18
    };
    // Young's modulus of the matrix, μ = a, in compression; a_f-fibres do not enter a tangent
    // at rest: their energy is 2 a_f ε² above it.
    let (along, against) = (energy(stretched), energy(squeezed));
    let matrix = 9.0 * 50.0 / (3.0 * 50.0 + 1.0);
    assert_close(against, matrix, 1e-6);
    assert!(along > against + 0.9 * 4.0 * SOFT[2] * 0.8, "{along} {against}");
}
