//! Trains an emulator of a bar, corrects one of its predictions and stores it.
//!
//! ```sh
//! cargo run -p sinew-examples --example train_emulator -- auto      # or regression, hybrid, dd, pi
//! ```

use anyhow::{Result, bail};
use sinew_emulate::recipe::{DataDriven, Hybrid, PhysicsInformed, Regression};
use sinew_emulate::{Budget, Recipe, Terminal, TrainingOptions};
use sinew_mesh::Field;
use std::path::Path;

fn main() -> Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "auto".into());
    let recipe = match name.as_str() {
        "auto" => Recipe::auto(),
        "regression" => Regression::default().into(),
        "hybrid" => Hybrid::default().into(),
        "dd" => DataDriven::default().into(),
        "pi" => PhysicsInformed::default().into(),
        _ => bail!("usage: train_emulator [auto | regression | hybrid | dd | pi]"),
    };
    let body = sinew_examples::bar()?;
    let folder = Path::new("out/bar");
    let budget = Budget::Seconds(20.0);
    let options = TrainingOptions { budget, folder: Some(folder.into()), ..Default::default() };
    let emulator = recipe.train(&body, &options, &mut Terminal::default())?;
    if let Some(choice) = &emulator.record.choice {
        println!("{choice}");
    }

    let theta = vec![10.0, 12.0]; // μ, λ [kPa]
    let prediction = emulator.predict(&[theta.clone()])?;
    let estimate = emulator.estimate(&prediction, 0)?;
    let corrected = emulator.correct(&theta, 1)?;
    println!(
        "at mu, lambda = {theta:?} kPa: error of about {:.1e} mm, after a Newton step of {:.1} ms the residual is {:.1e} of the \
         forces",
        estimate.mean_distance,
        1e3 * corrected.steps[0].seconds,
        corrected.steps[0].residual_after / corrected.steps[0].force_scale
    );
    let mut mesh = (*body.mesh).clone();
    let rows = |u: &[f64]| u.as_chunks::<3>().0.to_vec();
    let fields = [("u", prediction.field(0)), ("u_corrected", &corrected.displacement)];
    for (name, field) in fields {
        mesh.point_fields_mut().insert(name.into(), Field::vectors(&rows(field)));
    }
    mesh.write_vtu(folder.join("prediction.vtu"))?;
    println!("emulator: {}", folder.join("emulator").display());
    Ok(())
}
