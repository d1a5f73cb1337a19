//! The book's first page: a beam that bends under its own weight, from the mesh to an emulator and its error.
//!
//! `cargo run -p sinew --example book_beam`

use sinew::laws::NeoHookean;
use sinew::{
    Design, Load, Options, Parameter, Scene, Solver, Support, TestSet, Train, TrainingOptions,
    recipe::Taylor, simulate,
};
use sinew_mesh::box_tetrahedra;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // The reference configuration: 12 × 4 × 5 boxes of tetrahedra with a node in the middle of each edge [mm].
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]).quadratic();
    let tip = mesh.points.iter().position(|point| *point == [100.0, 5.0, 5.0]);
    let tip = tip.ok_or("the middle of the free end is a node of this mesh")?;

    // What it is made of, what acts on it, where it is held, and which numbers are open.
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
        .support(Support::clamped("x_min"));
    let body = scene.lower()?;

    // One parameter set, μ = λ = 75 kPa, by Newton's method.
    let theta = vec![75.0, 75.0];
    let solution = Solver::new(&body)?.solve(&theta, &Options::default())?;
    println!(
        "{} nodes, {} Newton iterations, {:.2} s: the tip moves by {:.3} mm",
        body.nodes,
        solution.iterations(),
        solution.seconds,
        solution.displacement[3 * tip + 2]
    );

    // All parameter sets: Taylor expansion of second order about one solution, at the centre of the ranges.
    let options = TrainingOptions { held_out: 4, ..TrainingOptions::default() };
    let emulator = Taylor.train(&body, &options, &mut ())?;

    // Its error, on parameter sets drawn apart from everything above.
    let thetas = Design::Uniform.sample(&body.parameters, 4, 99)?;
    let test = TestSet::new(&body, simulate(&body, &thetas, "test", None, &mut ())?);
    let found = emulator.evaluate(&test, 2)?;
    let [raw, once, twice] =
        [&found.raw, &found.corrected[0].errors, &found.corrected[1].errors].map(|e| e.err_u.q50);
    println!(
        "median nodal error {raw:.1e} mm, after one Newton step {once:.1e}, after two {twice:.1e}"
    );
    assert!(raw < 0.1 && once < 1e-3 && twice < 1e-6, "a step squares the error, about");

    // A prediction comes with an estimate of its error, and can be corrected.
    let prediction = emulator.predict(std::slice::from_ref(&theta))?;
    let estimate = emulator.estimate(&prediction, 0)?;
    let corrected = emulator.correct(&theta, 2)?;
    let [predicted, exact] = [prediction.field(0), &corrected.displacement].map(|u| u[3 * tip + 2]);
    println!("predicted {predicted:.3} mm, {}", estimate.in_words("mm"));

    // FEniCS, another program, with quadratic elements on the same cells (fixtures/beam/once/reference.json).
    let reference = -57.13704465491409;
    println!("corrected {exact:.3} mm, FEniCS {reference:.3} mm");
    assert!((exact / reference - 1.0).abs() < 5e-4, "quadrature of 4 points for more");
    Ok(())
}

#[test]
fn the_numbers_of_book_beam_hold() -> Result<(), Box<dyn Error>> {
    main()
}
