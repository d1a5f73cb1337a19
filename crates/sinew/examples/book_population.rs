//! The book's last page: ventricles that nothing has seen, answered by the stiffness of another.
//!
//! `cargo run -p sinew --example book_population`

use sinew::laws::HolzapfelOgden;
use sinew::{
    Body, Emulator, FrozenStiffness, Law, Load, Options, Parameter, Scene, Solver, Support,
};
use sinew_energy::Magnitude;
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_mesh::TruncatedEllipsoid;
use std::error::Error;
use std::time::Instant;

/// One millimetre of mercury [kPa].
const MMHG: f64 = 0.133322;

/// The body of a shape.
fn ventricle(shape: TruncatedEllipsoid) -> Result<Body, Box<dyn Error>> {
    let mesh = shape.wall([2, 24, 12]).tetrahedra();
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let fibres = frames.iter().map(|&[fibre, _sheet, _normal]| [fibre]).collect();
    let law = HolzapfelOgden.nearly_incompressible(25.0); // K [kPa]
    let scene = Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 4.0 * MMHG..=10.0 * MMHG))
        .load(pressure)
        .support(Support::clamped("base"));
    Ok(scene.lower()?)
}

/// `‖u − û‖ / ‖u‖`.
fn distance(found: &[f64], truth: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / truth.iter().map(|u| u * u).sum::<f64>()).sqrt()
}

fn main() -> Result<(), Box<dyn Error>> {
    // Before anybody comes: the mean ventricle, one solution of it and one factorised stiffness.
    let mean = TruncatedEllipsoid { short: [24.0, 35.0], long: [60.0, 71.0], base: 0.0 };
    let mean = ventricle(mean)?;
    let known = FrozenStiffness::new(&mean)?;

    // A patient: larger and thinner than the mean, with a scar of ten times the stiffness on one side.
    let patient = TruncatedEllipsoid { short: [27.0, 36.0], long: [63.0, 72.0], base: 0.0 };
    let patient = ventricle(patient)?;
    let scarred = |x: &[f64; 3]| (x[0] - 30.0).hypot(x[2] + 30.0) < 15.0 && x[1] > 0.0;
    let factor = |x: &[f64; 3]| if scarred(x) { 10.0 } else { 1.0 };
    let factors: Vec<f64> = patient.positions.iter().map(factor).collect();
    let patient = patient.stiffened(&factors)?;
    let theta = vec![0.2, 1.8, 2.5, 2.0, 9.0 * MMHG];

    // The first answer: steps with the mean's stiffness, which knows neither shape nor scar.
    let first = known.descend(&patient, &theta, 30)?;
    println!(
        "{} steps, {:.0} ms, {:.1e} of the unbalanced forces are left",
        first.steps,
        1e3 * first.seconds,
        first.residual_after / first.residual_before
    );

    // The solver, for comparison.
    let start = Instant::now();
    let truth = Solver::new(&patient)?.solve(&theta, &Options::default())?.displacement;
    let off = distance(&first.displacement, &truth);
    println!(
        "{:.2} % off; a solve takes {:.0} ms",
        100.0 * off,
        1e3 * start.elapsed().as_secs_f64()
    );
    assert!(off < 0.01, "{off}");

    // Many answers for this patient: a Taylor expansion about one solve, and four quasi-Newton steps with its stiffness.
    let emulator = Emulator::taylor(&patient, 1)?;
    let raw = emulator.predict(std::slice::from_ref(&theta))?;
    let fine = emulator.refine(std::slice::from_ref(&theta), 4)?;
    let [raw_off, fine_off] = [&raw, &fine].map(|found| distance(found.field(0), &truth));
    println!("expansion {:.2} % off, refined {:.3} %", 100.0 * raw_off, 100.0 * fine_off);
    assert!(fine_off < 0.25 * raw_off && fine_off < 5e-4);

    // The error bar: the distance to the equilibrium that Newton steps contract to.
    let estimate = emulator.estimate(&raw, 0)?;
    let nodes = raw.field(0).as_chunks::<3>().0.iter().zip(truth.as_chunks::<3>().0);
    let lengths = nodes.map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt());
    let error = lengths.sum::<f64>() / patient.nodes as f64;
    let estimated = estimate.distance.ok_or("no equilibrium nearby")?.mean;
    println!("mean error {error:.4} mm, estimated {estimated:.4} mm");
    assert!((0.99..1.01).contains(&(estimated / error)));
    Ok(())
}

#[test]
fn the_numbers_of_book_population_hold() -> Result<(), Box<dyn Error>> {
    main()
}
