//! Nearly incompressible, stiffening and contrasting materials.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{ByYoungPoisson, Guccione, HolzapfelOgden, NeoHookean};
use sinew_energy::{Exact, Guard, Law, Load, Magnitude, Scene, ShapeEnergy, Support, ThetaError};
use sinew_fem::fibres::{FibreRule, Surfaces, VentricleCoordinates};
use sinew_fem::{Advice, SolveError};
use sinew_mesh::{TruncatedEllipsoid, box_tetrahedra};
use sinew_num::{Mat3, Scalar};

/// Accuracy of a golden-section search: it sees the square root of rounding.
const SEARCHED: f64 = 1e-7;

/// The argument in `[low, high]` at which a function with one valley is least.
fn valley(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    for _ in 0..120 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if value(a) < value(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

/// Stretch across a bar that is stretched along x, from the least energy of one homogeneous state.
fn lateral<L: Law<D>, const D: usize>(
    law: &L,
    theta: &[f64],
    directions: &[[f64; 3]; D],
    stretch: f64,
) -> (f64, f64) {
    let density = |t: f64| {
        let diagonal = [stretch - 1.0, t - 1.0, t - 1.0];
        let h = Mat3::from_fn(|i, j| if i == j { diagonal[i] } else { 0.0 });
        law.energy(theta, &h, directions, &Exact)
    };
    let t = valley(0.1, 3.0, density);
    (t, density(t))
}

/// A distorted bar between rollers against the one homogeneous state that minimises its energy.
#[track_caller]
fn assert_uniaxial(poisson: f64, stretch: f64) {
    let (law, theta) = (ByYoungPoisson(NeoHookean), [3.0, poisson]);
    let mesh = distorted_cube(3);
    let far = mesh.points.iter().position(|&p| p == [1.0; 3]).unwrap();
    let bar = lower(law, mesh, vec![], pulled(stretch - 1.0));
    let solution = solve(&bar, &theta).unwrap();
    assert_sound(&bar, &solution);
    let (across, density) = lateral(&law, &theta, &[], stretch);
    for component in [1, 2] {
        let stretch = 1.0 + solution.displacement[3 * far + component];
        assert!((stretch - across).abs() < SEARCHED, "{stretch} {across}");
    }
    assert_close(solution.energy, density, 1e-9);
}

#[test]
fn a_bar_of_poisson_ratio_0_4999_contracts_as_one_homogeneous_state_does() {
    assert_uniaxial(0.4999, 1.5);
}

#[test]
fn a_bar_of_poisson_ratio_0_499999_contracts_as_one_homogeneous_state_does() {
    assert_uniaxial(0.499999, 1.5);
}

#[test]
fn a_bar_of_poisson_ratio_0_499999_bulges_as_one_homogeneous_state_does() {
    assert_uniaxial(0.499999, 0.6);
}

#[test]
fn bending_at_poisson_ratio_0_4999_softens_with_every_refinement() {
    // Linear tetrahedra lock: nested meshes approach the solution from the stiff side, so the energy falls.
    let mut energies = Vec::new();
    for refinement in [1, 2] {
        let mesh = box_tetrahedra([8.0, 1.0, 1.0], [8 * refinement, refinement, refinement]);
        let loads = vec![traction("x_max", [0.0, 0.0, -2e-3])];
        let scene = Scene { loads, ..scene(ByYoungPoisson(NeoHookean), mesh) };
        let beam = scene.lower().unwrap();
        let compressible = solve(&beam, &[3.0, 0.3]).unwrap();
        let nearly_incompressible = solve(&beam, &[3.0, 0.4999]).unwrap();
        assert_sound(&beam, &nearly_incompressible);
        // A slender beam of one Young's modulus bends by the same amount whatever its Poisson ratio;
        // these lock.
        assert!(compressible.energy < nearly_incompressible.energy);
        println!("locking {:.2}", compressible.energy / nearly_incompressible.energy);
        energies.push(nearly_incompressible.energy);
    }
    assert!(energies[1] < energies[0], "{energies:?}");
}

#[test]
fn bending_at_poisson_ratio_0_499999_converges_and_keeps_the_volume() {
    let mesh = box_tetrahedra([8.0, 2.0, 2.0], [8, 2, 2]);
    let loads = vec![traction("x_max", [0.0, 0.0, -5e-2])];
    let scene = Scene { loads, ..scene(ByYoungPoisson(NeoHookean), mesh) };
    let beam = scene.lower().unwrap();
    let solution = solve(&beam, &[3.0, 0.499999]).unwrap();
    assert_sound(&beam, &solution);
    let ratio =
        |cell| 1.0 + beam.displacement_gradient(cell, &solution.displacement).volume_change();
    let worst = (0..beam.volumes.len()).map(|c| f64::abs(ratio(c) - 1.0)).fold(0.0, f64::max);
    // The pressure is at most a few E, the bulk modulus 5e5 kPa.
    assert!(worst < 1e-4, "{worst:e}");
}

#[test]
fn poisson_ratio_one_half_is_refused_and_its_neighbour_is_solved_or_refused() {
    let bar = lower(ByYoungPoisson(NeoHookean), cube(2), vec![], pulled(0.1));
    let Err(SolveError::Theta(ThetaError::OutOfBounds { index, name, value, most, .. })) =
        solve(&bar, &[1.0, 0.5])
    else {
        panic!("ν = 0.5 has no bulk modulus");
    };
    assert_eq!((index, name, value), (1, "nu", 0.5));
    assert!(most < 0.5);
    match solve(&bar, &[1.0, most]) {
        Ok(solution) => {
            // Incompressible to rounding.
            let across = 1.0 + solution.displacement[3 * (bar.nodes - 1) + 1];
            assert!((across - 1.1_f64.powf(-0.5)).abs() < 1e-6, "{across}");
        }
        Err(SolveError::NotConverged(_)) => {}
        Err(other) => panic!("{other}"),
    }
}

const HO: sinew_energy::NearlyIncompressible<HolzapfelOgden> =
    HolzapfelOgden.nearly_incompressible(100.0);
const ALONG: [[f64; 3]; 1] = [[1.0, 0.0, 0.0]];

#[test]
fn fibres_ten_thousand_times_as_stiff_as_the_matrix_carry_the_load() {
    let theta = [0.1, 1.0, 1e3, 1.0];
    let mesh = distorted_cube(3);
    let far = mesh.points.iter().position(|&p| p == [1.0; 3]).unwrap();
    let scene = Scene {
        loads: vec![traction("x_max", [20.0, 0.0, 0.0])],
        supports: corner_rollers(),
        ..with_directions(HO, mesh, ALONG)
    };
    let bar = scene.lower().unwrap();
    let solution = solve(&bar, &theta).unwrap();
    assert_sound(&bar, &solution);
    let total = |s: f64| lateral(&HO, &theta, &ALONG, s).1 - 20.0 * (s - 1.0);
    let stretch = valley(1.0, 1.5, total);
    assert!((1.0 + solution.displacement[3 * far] - stretch).abs() < SEARCHED, "{stretch}");
    // Across the fibres the same load stretches ten times as much at least.
    let scene = Scene { material: HO.along(vec![[[0.0, 1.0, 0.0]]; bar.volumes.len()]), ..scene };
    let scene = Scene { loads: vec![traction("x_max", [0.2, 0.0, 0.0])], ..scene };
    let soft = scene.lower().unwrap();
    let solution = solve(&soft, &theta).unwrap();
    assert_sound(&soft, &solution);
    assert!(solution.displacement[3 * far] > 10.0 * (stretch - 1.0));
}

#[test]
fn a_first_newton_step_into_overflow_is_cut_back() {
    // The linear model foresees a stretch of 3, where the exponential overflows; it takes 1.05.
    let theta = [1.0, 1.0, 1.0, 500.0];
    let force = 20.0;
    let scene = Scene {
        loads: vec![traction("x_max", [force, 0.0, 0.0])],
        supports: corner_rollers(),
        ..with_directions(HO, distorted_cube(2), ALONG)
    };
    let bar = scene.lower().unwrap();
    let solution = solve(&bar, &theta).unwrap();
    assert_sound(&bar, &solution);
    let total = |s: f64| lateral(&HO, &theta, &ALONG, s).1 - force * (s - 1.0);
    let stretch = valley(1.0, 1.3, total);
    let moved = solution.displacement[3 * (bar.nodes - 1)];
    assert!((1.0 + moved - stretch).abs() < SEARCHED, "{moved} {stretch}");
}

/// A bar stretched to where the law overflows: infinite energy, no false gradient, a typed failure.
#[track_caller]
fn assert_overflow<L: Law<D>, const D: usize>(law: L, directions: [[f64; 3]; D], theta: &[f64]) {
    let mesh = distorted_cube(2);
    // Three times as long at the same volume, so nothing but the exponential resists.
    let across = 3.0_f64.powf(-0.5) - 1.0;
    let stretch = |[x, y, z]: [f64; 3]| [2.0 * x, across * y, across * z];
    let stretched: Vec<_> = mesh.points.iter().flat_map(|&p| stretch(p)).collect();
    let supports = vec![Support::moved("boundary", &mesh, stretch)];
    let scene = Scene { supports, ..with_directions(law, mesh, directions) };
    let bar = scene.lower().unwrap();
    let (gradient, energy) = gradient_and_energy(&bar, &stretched, theta);
    assert_eq!((energy, bar.value(&stretched, theta)), (f64::INFINITY, f64::INFINITY));
    assert!(gradient.iter().all(|g| !g.is_nan()));
    let failure = failure(solve(&bar, theta));
    assert!(failure.load_factor > 0.0 && failure.load_factor < 1.0);
    assert!(matches!(failure.advice, Advice::Overflow), "{}", failure.advice);
    // What was reached is an equilibrium of finite energy.
    assert!(bar.value(&failure.displacement, theta).is_finite());
}

#[test]
fn holzapfel_ogden_fibres_stretched_to_overflow_are_refused() {
    assert_overflow(HO, ALONG, &[1.0, 1.0, 1.0, 400.0]);
}

#[test]
fn a_holzapfel_ogden_matrix_stretched_to_overflow_is_refused() {
    assert_overflow(HO, [[0.0, 1.0, 0.0]], &[1.0, 400.0, 1.0, 1.0]);
}

#[test]
fn a_guccione_solid_stretched_to_overflow_is_refused() {
    let law = Guccione.nearly_incompressible(100.0);
    assert_overflow(law, Guccione::frame([1.0, 0.0, 0.0]), &[1.0, 400.0, 100.0, 100.0]);
}

#[test]
fn moduli_that_are_no_positive_numbers_are_refused_with_name_and_bounds() {
    let scene = with_directions(HO, cube(1), ALONG);
    let block = scene.lower().unwrap();
    for (index, value) in [(0, -1.0), (1, 0.0), (2, f64::NAN), (3, f64::INFINITY)] {
        let mut theta = [1.0; 4];
        theta[index] = value;
        match solve(&block, &theta) {
            Err(SolveError::Theta(ThetaError::OutOfBounds {
                index: at, name, value: v, ..
            })) => {
                assert_eq!(
                    (at, name),
                    (index, <HolzapfelOgden as ShapeEnergy<1>>::PARAMETERS[index])
                );
                assert_eq!(v.to_bits(), value.to_bits());
            }
            other => panic!("expected a refusal, got {other:?}"),
        }
    }
}

#[test]
fn moduli_at_the_ends_of_floating_point_are_solved_or_refused() {
    let bar = lower(NeoHookean, cube(2), vec![], pulled(0.5));
    let reference = solve(&bar, &[1.0, 1.0]).unwrap();
    for scale in [1e-100, 1e-50, 1e50, 1e100] {
        let solution = solve(&bar, &[scale, scale]).unwrap();
        let off = difference(&solution.displacement, &reference.displacement);
        assert!(off < 1e-9, "{scale:e}: {off:e}");
    }
    // Beyond, squares of forces vanish or overflow.
    for scale in [f64::MIN_POSITIVE, 1e-300, 1e-150, 1e150, f64::MAX] {
        let error = solve(&bar, &[scale, scale]).unwrap_err();
        assert!(matches!(error, SolveError::Theta(ThetaError::OutOfBounds { index: 0, .. })));
    }
}

/// Neo-Hookean, `contrast` times as stiff where its direction is the x axis.
#[derive(Clone, Debug)]
struct Inclusion {
    contrast: f64,
}

impl Law<1> for Inclusion {
    const NAME: &'static str = "neo-Hookean with an inclusion";
    const PARAMETERS: &'static [&'static str] = &["mu", "lambda"];

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        displacement_gradient: &Mat3<S>,
        [direction]: &[[S; 3]; 1],
        guard: &G,
    ) -> S {
        let soft = NeoHookean.density(parameters, displacement_gradient, &[], guard);
        soft * (direction[0].clone() * (self.contrast - 1.0) + 1.0)
    }
}

#[test]
fn an_inclusion_a_million_times_as_stiff_turns_without_deforming() {
    let mesh = box_tetrahedra([6.0, 2.0, 2.0], [6, 2, 2]);
    // The grid cells between x = 2 and x = 4 are stiff.
    let stiff: Vec<_> = (0..mesh.cells.len())
        .map(|cell| {
            let centre = mesh.cells[cell].iter().map(|&n| mesh.points[n][0]).sum::<f64>() / 4.0;
            centre > 2.0 && centre < 4.0
        })
        .collect();
    let directions: Vec<_> =
        stiff.iter().map(|&s| [if s { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] }]).collect();
    let loads: Vec<Load> = vec![traction("x_max", [0.0, 0.0, -2e-2])];
    let mut solved = Vec::new();
    for contrast in [1e5, 1e6] {
        let material = Inclusion { contrast }.along(directions.clone());
        let scene = Scene { loads: loads.clone(), ..scene(material, mesh.clone()) };
        let beam = scene.lower().unwrap();
        let solution = solve(&beam, &[1.0, 1.0]).unwrap();
        assert_sound(&beam, &solution);
        // FᵀF = I in the inclusion, and a turn that is not small.
        let gradient = |cell| beam.displacement_gradient(cell, &solution.displacement);
        for cell in (0..stiff.len()).filter(|&c| stiff[c]) {
            let h = gradient(cell);
            let axis = |i| std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
            let strain = (0..3).map(|i| h.strain_between(&axis(i), &axis(i)).abs());
            assert!(strain.fold(0.0, f64::max) < 10.0 / contrast);
            assert!(h[2][0].abs() > 0.1);
        }
        solved.push(solution.displacement);
    }
    // The rigid limit is approached as 1/contrast.
    assert!(difference(&solved[0], &solved[1]) < 1e-3);
}

#[test]
fn a_law_whose_bulk_modulus_is_no_positive_number_is_refused() {
    for bulk_modulus in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let scene =
            with_directions(HolzapfelOgden.nearly_incompressible(bulk_modulus), cube(1), ALONG);
        let error = scene.lower().unwrap_err();
        println!("{error}");
        assert!(error.to_string().contains("bulk modulus"), "{error}");
    }
    let mesh = cube(1);
    let error = with_directions(
        Guccione.nearly_incompressible(-3.0),
        mesh,
        Guccione::frame([0.0, 0.0, 1.0]),
    )
    .lower()
    .unwrap_err();
    assert!(error.to_string().contains("-3"), "{error}");
}

#[test]
fn an_incompressible_ventricle_that_inflates_far_takes_few_iterations() {
    let shape = TruncatedEllipsoid { short: [24.0, 35.0], long: [60.0, 71.0], base: 0.0 };
    let wall = shape.wall([3, 16, 8]);
    let tetrahedra = wall.tetrahedra();
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let coordinates = VentricleCoordinates::new(&tetrahedra, &surfaces).unwrap();
    let frames = coordinates.node_frames(&FibreRule::SIXTY);
    let fibres = frames.iter().map(|[fibre, ..]| [*fibre]).collect();
    let tissue = HolzapfelOgden.nearly_incompressible(1e4).along(fibres);
    let scene = Scene {
        loads: vec![Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(1.07) }],
        supports: vec![Support::radial("base", [0.0; 3], [0.0, 0.0, 1.0])],
        parameters: parameters(<HolzapfelOgden as ShapeEnergy<1>>::PARAMETERS),
        ..Scene::new(wall.hexahedra(), tissue)
    };
    let body = scene.averaged().lower().unwrap();
    // Where no rung is near load steps lead on; begun only where the last was balanced to rounding, and no longer ones, they take 375.
    let softest = ([0.11, 0.26, 0.12, 0.14], 340);
    for (theta, most) in [([0.12, 1.26, 1.98, 1.72], 60), ([0.24, 0.71, 0.8, 0.3], 60), softest] {
        let solution = solve(&body, &theta).unwrap();
        // Rounding of forces that a bulk modulus of 1e4 kPa makes large.
        assert!(solution.residual < 1e-9 * solution.force_scale, "{:e}", solution.residual);
        let volume = |u: &[f64]| body.cavity_volumes(u)[0];
        let grown = volume(&solution.displacement) / volume(&vec![0.0; 3 * body.nodes]);
        assert!(grown > 2.0, "{grown}");
        // By load steps alone they take 249 and 252.
        let iterations = solution.history.iterations.len();
        println!("{theta:?}: {iterations}");
        assert!(iterations < most, "{iterations}");
    }
}
