//! Built-in scenes.

use super::refuse;
use anyhow::Result;
use clap::Args;
use sinew::{Case, scenes};
use sinew_energy::laws::{LAWS, TENSION};
use std::path::Path;

/// Scene to print.
#[derive(Debug, Args)]
#[command(after_help = "Example: sinew new IdealVentricle > heart.toml")]
pub(crate) struct New {
    /// Name of a built-in scene (`sinew scenes`)
    name: String,
}

impl New {
    pub(crate) fn run(&self) -> Result<()> {
        let Some(scene) = scenes::find(Path::new(&self.name)) else {
            let names: Vec<_> = scenes::SCENES.iter().map(|scene| scene.name).collect();
            let (name, names) = (&self.name, names.join(", "));
            return refuse(format!("there is no scene `{name}`; there are: {names}"));
        };
        print!("{}", scene.text);
        Ok(())
    }
}

pub(crate) fn list() -> Result<()> {
    println!("scenes");
    for scene in scenes::SCENES {
        println!("  {:<22} {}", scene.name, Case::parse(scene.text, scene.name)?.about);
    }
    println!("\nlaws, with their parameters in the order of theta");
    for law in LAWS {
        println!("  {:<28} {:<36} {}", law.name, law.parameters.join(", "), law.about);
    }
    println!("\nlaws with fibres contract with active = true, which adds {TENSION} to theta");
    Ok(())
}
