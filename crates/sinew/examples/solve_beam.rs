//! A scene put together in Rust: a beam that bends under its own weight, written for ParaView.
//!
//! `cargo run -p sinew --example solve_beam -- FOLDER`

use sinew::laws::NeoHookean;
use sinew::output::{Fields, mean_and_largest};
use sinew::{Load, Options, Parameter, Scene, Solver, Support};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder =
        std::env::args().nth(1).ok_or("name a folder for the results, such as out/beam")?;
    let beam = sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let scene = Scene::new(beam, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
        .support(Support::clamped("x_min"));
    let body = scene.lower()?;
    let theta = vec![75.0, 75.0];
    let solution = Solver::new(&body)?.solve(&theta, &Options::default())?;

    println!("{}", solution.history);
    let [_, largest] = mean_and_largest(&solution.displacement);
    println!(
        "energy {:.6} kPa mm³, largest displacement {largest:.4} mm, stable: {}, {:.1} ms",
        solution.energy,
        solution.is_stable(),
        1e3 * solution.seconds
    );
    let found = vec![("solved", vec![solution.displacement])];
    Fields { body: &body, thetas: &[theta], found }.write(Path::new(&folder), 1)?;
    println!("written: {folder}");
    Ok(())
}
