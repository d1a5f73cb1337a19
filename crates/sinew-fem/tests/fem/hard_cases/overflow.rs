//! Exponential laws where their energies, forces and squares of forces come near the end of floating point.
//!
//! Every solution is held against the potential's own gradient, summed without overflow; what is not an equilibrium must
//! be an error. Each table counts both, so that it cannot pass by refusing everything.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::gradient_and_energy;
use sinew_energy::laws::{Guccione, HolzapfelOgden};
use sinew_energy::{Body, Load, Magnitude, NearlyIncompressible, Scene, Support, SurfaceResponse};
use sinew_fem::{Line, Options, Solution, SolveError, Solver, sweep};
use sinew_mesh::{TetMesh, box_tetrahedra};
use std::f64::consts::FRAC_1_SQRT_2;

const HO: NearlyIncompressible<HolzapfelOgden> = HolzapfelOgden.nearly_incompressible(25.0);
/// Unbalanced forces of a solution, as a part of loads and reactions.
const BALANCED: f64 = 1e-6;

/// Norm of numbers whose squares may overflow.
fn norm(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = values.clone().fold(0.0, |m: f64, x| m.max(x.abs()));
    let sum: f64 = values.map(|x| (x / largest).powi(2)).sum();
    if largest > 0.0 { largest * sum.sqrt() } else { 0.0 }
}

/// Residual of `forces`, as a part of the reactions and of the `loads`.
fn unbalanced(prescribed: &[Option<f64>], forces: &[f64], loads: &[f64]) -> f64 {
    let of = |held: bool| {
        forces.iter().zip(prescribed).filter(move |(_, p)| p.is_some() == held).map(|(f, _)| *f)
    };
    norm(of(false)) / norm(of(true).chain(loads.iter().copied()))
}

/// Outcomes of a table of solves.
#[derive(Debug, Default)]
struct Tally {
    solved: usize,
    refused: usize,
    false_equilibria: Vec<String>,
}

impl Tally {
    fn add(&mut self, name: impl std::fmt::Debug, sound: Result<Result<(), String>, SolveError>) {
        match sound {
            Ok(Ok(())) => self.solved += 1,
            Ok(Err(problem)) => self.false_equilibria.push(format!("{name:?}: {problem}")),
            Err(SolveError::NotConverged(failure)) => {
                assert!(failure.load_factor < 1.0 && !failure.history.iterations.is_empty());
                assert!(failure.displacement.iter().all(|u| u.is_finite()));
                assert!(!failure.to_string().contains("NaN"), "{failure}");
                self.refused += 1;
            }
            Err(other) => panic!("{name:?}: {other}"),
        }
    }

    /// At least this many solved and refused, and nothing else.
    #[track_caller]
    fn check(&self, solved: usize, refused: usize) {
        println!("{} solved, {} refused", self.solved, self.refused);
        let Self { false_equilibria, .. } = self;
        assert!(false_equilibria.is_empty(), "{}\n{false_equilibria:#?}", false_equilibria.len());
        assert!(self.solved >= solved && self.refused >= refused, "{self:?}");
    }
}

/// Whether a minimiser's solution is one.
fn sound(potential: &Body, solution: &Solution) -> Result<(), String> {
    let Solution { displacement, theta, energy, residual, force_scale, .. } = solution;
    let (forces, value) = gradient_and_energy(potential, displacement, theta);
    let left = unbalanced(&potential.prescribed, &forces, &potential.nodal_force);
    let finite = [*energy, value, *residual, *force_scale, left].iter().all(|x| x.is_finite());
    let told = residual / force_scale;
    if finite
        && left <= BALANCED
        && told <= BALANCED
        && (value - energy).abs() <= 1e-9 * value.abs()
    {
        return Ok(());
    }
    Err(format!("{left:.1e} unbalanced, {told:.1e} told, energy {energy:.1e}, {value:.1e}"))
}

/// Whether a solution of the balance is one.
fn sound_balance(body: &Body, solution: &Solution) -> Result<(), String> {
    let Solution { displacement, theta, residual, force_scale, load_factor, .. } = solution;
    let (mut forces, value) = gradient_and_energy(body, displacement, theta);
    let mut loads = vec![0.0; forces.len()];
    let mut response = SurfaceResponse::default();
    for follower in &body.followers {
        for facet in 0..follower.facets() {
            follower.facet_force(facet, displacement, &mut response);
            for (slot, force) in response.gradient.iter().enumerate() {
                loads[3 * follower.facet_nodes(facet)[slot / 3] + slot % 3] +=
                    load_factor * follower.magnitude.value(theta) * force;
            }
        }
    }
    for (force, load) in forces.iter_mut().zip(&loads) {
        *force += load;
    }
    let left = unbalanced(&body.prescribed, &forces, &loads);
    let told = residual / force_scale;
    if value.is_finite() && left <= BALANCED && told <= BALANCED && force_scale.is_finite() {
        return Ok(());
    }
    Err(format!("{left:.1e} unbalanced, {told:.1e} told, energy {value:.1e}"))
}

/// A cube whose side `x_max` is pulled: the other side slides or is clamped, the pulled one slides or not.
fn supports(kind: usize, stretch: f64) -> Vec<Support> {
    let far = |across| Support::uniform("x_max", [Some(stretch - 1.0), across, across]);
    match kind {
        0 => pulled(stretch - 1.0),
        1 => vec![Support::clamped("x_min"), far(None)],
        _ => vec![Support::clamped("x_min"), far(Some(0.0))],
    }
}

const FIBRES: [[f64; 3]; 3] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0]];

fn stretched(kind: usize, fibre: [f64; 3], stretch: f64) -> Body {
    let supports = supports(kind, stretch);
    Scene { supports, ..with_directions(HO, cube(2), [fibre]) }.lower().unwrap()
}

fn exponents(b: f64) -> [f64; 4] {
    [1.0, b, 1.0, b]
}

/// Powers of ten of the energies \[kPa mm³\] that a table aims at: laws end at 1e150, squares of stiffnesses before.
const ENERGIES: [f64; 16] = [
    5.0, 100.0, 140.0, 146.0, 148.0, 149.0, 150.0, 150.5, 151.0, 151.5, 152.0, 152.5, 153.0, 154.0,
    155.0, 160.0,
];

/// The factors b of the exponents that take a stretched cube to the [`ENERGIES`]: their logarithm is nearly linear in b.
fn exponents_to_overflow(cube: &Body) -> [f64; 16] {
    const MEASURED: f64 = 5.0;
    let solution = Solver::new(cube).unwrap().solve(&exponents(MEASURED), &Options::default());
    let rate = (MEASURED * solution.unwrap().energy).log10() / MEASURED;
    ENERGIES.map(|energy| energy / rate)
}

#[test]
fn a_cube_stretched_to_overflow_is_in_equilibrium_or_refused() {
    let mut tally = Tally::default();
    for (kind, fibre) in [1, 2].into_iter().flat_map(|kind| FIBRES.map(|fibre| (kind, fibre))) {
        for stretch in [2.0, 3.0, 3.8] {
            let cube = stretched(kind, fibre, stretch);
            let mut solver = Solver::new(&cube).unwrap();
            for b in exponents_to_overflow(&cube) {
                let result = solver.solve(&exponents(b), &Options::default());
                tally.add((kind, fibre, stretch, b), result.map(|s| sound(&cube, &s)));
            }
        }
    }
    tally.check(150, 36);
}

#[test]
fn stretches_whose_squared_stiffnesses_overflow_are_in_equilibrium_or_refused() {
    // A floor that is the root of an infinite sum took what was left here for rounding: 0.6, 0.5 and 3e-4 of the forces.
    let mut tally = Tally::default();
    let [along, across, _] = FIBRES;
    for (fibre, stretch, b) in [
        (along, 3.0, 176.44272494507732),
        (along, 2.0, 573.8982470778851),
        (across, 3.3, 322.6555642681088),
    ] {
        let cube = stretched(1, fibre, stretch);
        let result = Solver::new(&cube).unwrap().solve(&exponents(b), &Options::default());
        tally.add((fibre, stretch, b), result.map(|s| sound(&cube, &s)));
    }
    tally.check(1, 0);
}

#[test]
fn a_cube_under_tractions_up_to_overflow_is_in_equilibrium_or_refused() {
    let mut tally = Tally::default();
    for exponent in [0, 10, 50, 100, 140, 148, 150, 152, 154, 156, 160, 200, 250, 290, 300, 306] {
        for (fibre, sign) in FIBRES.into_iter().flat_map(|fibre| [(fibre, 1.0), (fibre, -1.0)]) {
            let force = sign * 10.0_f64.powi(exponent);
            let cube = Scene {
                loads: vec![traction("x_max", [force, 0.0, 0.0])],
                ..with_directions(HO, cube(2), [fibre])
            };
            let cube = cube.lower().unwrap();
            let result = Solver::new(&cube).unwrap().solve(&exponents(100.0), &Options::default());
            tally.add((fibre, force), result.map(|s| sound(&cube, &s)));
        }
    }
    tally.check(10, 10);
}

#[test]
fn what_is_said_to_hold_of_a_stretch_beyond_overflow_does_and_a_hundredth_more_does_not() {
    for (kind, b) in [(1, 3e3), (2, 30.0), (2, 300.0), (2, 3e3)] {
        let solved = |stretch: f64| {
            let cube = stretched(kind, FIBRES[0], stretch);
            let result = Solver::new(&cube).unwrap().solve(&exponents(b), &Options::default());
            (cube, result)
        };
        let far = 10.0;
        let (_, Err(SolveError::NotConverged(failure))) = solved(far) else {
            panic!("{kind}, {b}: an energy beyond the end of the law")
        };
        // The largest part of the motion that holds: a solution, and its energy next to the law's end at 1e150.
        let motion = failure.load_factor * (far - 1.0);
        let (cube, result) = solved(1.0 + motion);
        let solution = result.unwrap();
        println!("{kind}, {b}: {} holds, energy {:.1e}", 1.0 + motion, solution.energy);
        assert_eq!(sound(&cube, &solution), Ok(()));
        assert!(solution.energy > 1e140, "{kind}, {b}: {:e}", solution.energy);
        let (_, beyond) = solved(1.0 + 1.01 * motion);
        assert!(matches!(beyond, Err(SolveError::NotConverged(_))), "{kind}, {b}");
    }
}

#[test]
fn a_sweep_that_leads_to_overflow_gives_equilibria_or_errors() {
    let mut tally = Tally::default();
    let thetas: Vec<_> = (0..25).map(|i| exponents(10.0 * 1.2_f64.powi(i)).to_vec()).collect();
    for (kind, stretch) in [(1, 2.0), (1, 3.3), (2, 1.6)] {
        for fibre in FIBRES {
            let cube = stretched(kind, fibre, stretch);
            let swept = sweep(&cube, &thetas, &Options::default(), || {}).unwrap();
            for (theta, result) in thetas.iter().zip(swept) {
                tally.add((kind, fibre, stretch, theta), result.map(|s| sound(&cube, &s)));
            }
        }
    }
    tally.check(190, 10);
}

/// Derivatives in θ near overflow are those of neighbouring forces, or an error.
#[test]
fn sensitivities_near_overflow_keep_the_forces_balanced_or_are_refused() {
    let mut balanced = 0;
    for (kind, stretch) in [(0, 2.0), (1, 1.6), (1, 2.4), (1, 3.3), (1, 3.8), (2, 1.6)] {
        let cube = stretched(kind, FIBRES[0], stretch);
        let mut solver = Solver::new(&cube).unwrap();
        let Ok(solution) = solver.solve(&exponents(100.0), &Options::default()) else { continue };
        let Ok(slopes) = solver.sensitivity(&solution) else { continue };
        for (index, slope) in slopes.iter().enumerate() {
            assert!(slope.iter().all(|s| s.is_finite()), "{kind} {stretch} {index}");
            let forces = |step: f64| {
                let mut theta = solution.theta.clone();
                theta[index] *= 1.0 + step;
                let move_by = step * solution.theta[index];
                let moved = solution.displacement.iter().zip(slope).map(|(u, s)| u + move_by * s);
                gradient_and_energy(&cube, &moved.collect::<Vec<_>>(), &theta).0
            };
            // The forces stay balanced to first order: the residual falls with the square of the step.
            let left = |step: f64| unbalanced(&cube.prescribed, &forces(step), &[]) / step;
            let step = 1e-6;
            assert!(left(step) < 1e-2, "{kind} {stretch} {index}: {:e}", left(step));
            balanced += 1;
        }
    }
    assert!(balanced >= 12, "{balanced}");
}

fn traction_beam(pressure: f64, bulk_modulus: f64) -> Body {
    let mesh: TetMesh = box_tetrahedra([100.0, 10.0, 10.0], [10, 3, 3]);
    let magnitude = Magnitude::Fixed(pressure);
    let loads = vec![Load::Pressure { facets: "z_min".into(), magnitude }];
    let law = Guccione.nearly_incompressible(bulk_modulus);
    let frame = Guccione::frame([1.0, 0.0, 0.0]);
    Scene { loads, ..with_directions(law, mesh, frame) }.loose_rims().lower().unwrap()
}

#[test]
fn a_guccione_beam_under_a_loose_pressure_is_in_equilibrium_all_over_its_range() {
    let mut tally = Tally::default();
    for pressure in [0.149, 0.15, 0.151] {
        let body = traction_beam(pressure, 25.0);
        let mut solver = Solver::new(&body).unwrap();
        let result = solver.solve(&[2.5, 3.0, 2.0, 2.25], &Options::default());
        tally.add(pressure, result.map(|s| sound_balance(&body, &s)));
    }
    let body = traction_beam(0.15, 25.0);
    let mut solver = Solver::new(&body).unwrap();
    for theta in [[1.75; 4], [3.5; 4], [1.75, 3.5, 1.75, 3.5], [3.5, 1.75, 3.5, 1.75]] {
        let result = solver.solve(&theta, &Options::default());
        tally.add(theta, result.map(|s| sound_balance(&body, &s)));
    }
    tally.check(7, 0);
}

#[test]
fn a_loose_pressure_up_to_overflow_is_in_equilibrium_or_refused() {
    let mut tally = Tally::default();
    let mesh = box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]);
    for exponent in [-2, 0, 1, 2, 10, 50, 100, 150, 154, 160, 200, 300] {
        for sign in [1.0, -1.0] {
            let magnitude = Magnitude::Fixed(sign * 10.0_f64.powi(exponent));
            let loads = vec![Load::Pressure { facets: "x_max".into(), magnitude }];
            let scene = Scene { loads, ..with_directions(HO, mesh.clone(), [FIBRES[0]]) };
            let body = scene.loose_rims().lower().unwrap();
            let mut solver = Solver::new(&body).unwrap();
            for b in [1.0, 100.0] {
                let result = solver.solve(&exponents(b), &Options::default());
                tally.add((sign, exponent, b), result.map(|s| sound_balance(&body, &s)));
            }
        }
    }
    tally.check(14, 10);
}

#[test]
fn a_curve_up_to_overflow_is_in_equilibrium_or_ends_with_an_error() {
    let mut tally = Tally::default();
    // A box with clamped walls whose loaded side bulges.
    let mesh = box_tetrahedra([1.0, 1.0, 1.0], [2, 2, 2]);
    let load = Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Fixed(-1.0) };
    let walls = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped);
    let scene = with_directions(HO, mesh, [FIBRES[0]]);
    let scene = Scene { loads: vec![load], supports: walls.to_vec(), ..scene };
    let body = scene.loose_rims().lower().unwrap();
    for b in [1.0, 10.0, 100.0, 300.0] {
        for exponent in [0, 3, 100, 300] {
            let thetas = [exponents(b), exponents(b)].map(Vec::from);
            let line = Line { load_factors: [0.0, 10.0_f64.powi(exponent)], thetas };
            let mut solver = Solver::new(&body).unwrap();
            for point in solver.follow(&line, &Options::default()).unwrap().skip(1).take(12) {
                if let Err(SolveError::CurveEnded { failure, place, .. }) = &point {
                    let finite = failure.displacement.iter().all(|u| u.is_finite());
                    assert!(
                        finite && place.is_finite() && !failure.to_string().contains("NaN"),
                        "{b} {exponent}: {place} {failure}"
                    );
                    tally.refused += 1;
                    continue;
                }
                let sound = point.map(|point| {
                    let Solution { displacement, theta, load_factor, .. } = &point.solution;
                    let (mut forces, value) = gradient_and_energy(&body, displacement, theta);
                    let mut loads = vec![0.0; forces.len()];
                    for pressure in &body.pressures {
                        pressure.value_and_add_gradient(displacement, theta, &mut loads);
                    }
                    for (force, load) in forces.iter_mut().zip(&mut loads) {
                        *force += (load_factor - 1.0) * *load;
                        *load *= load_factor;
                    }
                    let left = unbalanced(&body.prescribed, &forces, &loads);
                    let sound = value.is_finite() && left <= BALANCED;
                    if sound {
                        Ok(())
                    } else {
                        Err(format!("{left:.1e} unbalanced of {value:.1e}"))
                    }
                });
                tally.add((b, exponent), sound);
            }
        }
    }
    tally.check(8, 2);
}
