//! Trains one recipe on a scene and prints its errors on the way: what `docs/design.md` compares.
//!
//! ```text
//! cargo run -p sinew --example recipe -- SCENE RECIPE [HELD_OUT [SEED]]
//! cargo run -p sinew --example recipe -- OnceClampedBeam '{"recipe": "hybrid"}' 100
//! ```
//!
//! SCENE is a built-in one or a case file, RECIPE JSON of [`sinew::Recipe`] whose missing keys have the recipe's
//! defaults. Errors are medians over HELD_OUT uniform cases.

use anyhow::{Context, Result};
use sinew::{Case, Recipe, TrainingOptions};
use std::path::Path;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "usage: recipe SCENE RECIPE [HELD_OUT [SEED]]";
    let [scene, recipe, more @ ..] = &arguments[..] else { anyhow::bail!(usage) };
    let number = |index: usize, otherwise: u64| -> Result<u64> {
        more.get(index).map_or(Ok(otherwise), |text| text.parse().context(usage))
    };
    let recipe: Recipe = serde_json::from_str(recipe).context("RECIPE")?;
    let body = match sinew::scenes::find(Path::new(scene)) {
        Some(scene) => Case::parse(scene.text, scene.name)?.body()?,
        None => Case::read(Path::new(scene))?.body()?,
    };
    let (held_out, seed) = (number(0, 30)? as usize, number(1, 1)?);
    let options = TrainingOptions { held_out, seed, ..TrainingOptions::default() };
    let emulator = recipe.train(&body, &options, &mut ())?;
    for point in &emulator.record.history {
        let [u, f, i1, pi] = point.medians.unwrap_or([f64::NAN; 4]);
        println!(
            "{:6} steps {:7.1} s: err_u {u:.1e}, err_F {f:.1e} %, err_I1 {i1:.1e} %, err_Pi {pi:.1e} %",
            point.step, point.train_s
        );
    }
    if let Some(errors) = &emulator.record.held_out {
        println!("err_u: largest {:.2e}", errors.err_u.max);
    }
    emulator.record.warnings.iter().for_each(|warning| println!("{warning}"));
    Ok(())
}
