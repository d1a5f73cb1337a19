//! A body for other programs.

#[cfg(feature = "networks")]
use super::refuse;
use super::{CaseArguments, chosen, trained, warn, write};
use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use sinew::case::{RecipeName, Training, doubtful_emulator};
use sinew::{Body, Case, Emulator, PAGE_SEED, TrainingOptions, npz};
use sinew_emulate::Terminal;
use sinew_mesh::to_npy;
use std::path::Path;

/// Body.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/export.txt"))]
pub(crate) struct Export {
    #[command(flatten)]
    case: CaseArguments,
    /// The emulator as one page for a browser
    #[arg(long, group = "of_emulator")]
    page: bool,
    /// The weights of a network as arrays for `numpy.load`
    #[cfg(feature = "networks")]
    #[arg(long, group = "of_emulator")]
    weights: bool,
    /// Name of the emulator's folder within OUT, such as `regression` [default: the only one, or that of the case's recipe]
    #[arg(long, value_name = "NAME", requires = "of_emulator")]
    emulator: Option<String>,
}

impl Export {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.case.open()?;
        if self.page {
            return self.page(&case, &body, &folder);
        }
        #[cfg(feature = "networks")]
        if self.weights {
            return self.weights(&case, &folder);
        }
        let folder = folder.join("export");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        body.mesh.write_vtu(folder.join("body.vtu"))?;
        arrays(&body, &folder.join("body.npz")).context("body.npz cannot be written")?;
        write(&folder.join("body.json"), serde_json::to_string_pretty(&description(&body))?)?;
        println!("written: {}", folder.display());
        for part in left_out(&body) {
            eprintln!(
                "warning: {part} of this body are not in the arrays; another program must add them"
            );
        }
        Ok(())
    }

    #[cfg(feature = "networks")]
    fn weights(&self, case: &Case, folder: &Path) -> Result<()> {
        let (name, path) = chosen(self.emulator.as_deref(), case, folder)?;
        let stored = path.join("network");
        if !stored.exists() {
            return refuse(format!("`{name}` is not a network and has no weights; train pi or dd"));
        }
        let device = sinew::Backend::default().device()?;
        let weights = sinew_gnn::Surrogate::load(&stored, &device)?.weights();
        let file = folder.join(format!("{name}.npz"));
        let arrays = weights.iter().map(|(name, shape, u)| (name.clone(), to_npy(shape, u)));
        npz::write(&file, arrays).with_context(|| file.display().to_string())?;
        println!("written: {}, {} arrays", file.display(), weights.len());
        Ok(())
    }

    fn page(&self, case: &Case, body: &Body, folder: &Path) -> Result<()> {
        let (name, emulator) = match (&self.emulator, trained(folder)) {
            (None, Err(_)) => {
                (RecipeName::Regression.key().into(), regression(case, body, folder)?)
            }
            _ => {
                let (name, path) = chosen(self.emulator.as_deref(), case, folder)?;
                (name, sinew::load(&path, body)?)
            }
        };
        warn(doubtful_emulator(&emulator)?);
        let viewer = sinew::viewer(&emulator, PAGE_SEED, &mut Terminal::default())?;
        warn(&viewer.notes);
        for (name, value) in &viewer.facts {
            println!("{name}: {value}");
        }
        let (file, page) = (folder.join(format!("{name}.html")), viewer.to_html());
        write(&file, &page)?;
        let size = sinew_report::format::digits(page.len() as f64 / 1e6, 2);
        println!("written: {}, {size} MB; open it in a browser", file.display());
        Ok(())
    }
}

/// A regression as `sinew train --recipe regression` makes it.
fn regression<'b>(case: &Case, body: &'b Body, folder: &Path) -> Result<Emulator<'b>> {
    let recipe = RecipeName::Regression;
    let training = Training { recipe: Some(recipe), ..case.training.clone() };
    let run = folder.join(recipe.key());
    eprintln!("nothing is trained yet in {}: a regression is now", folder.display());
    let options = TrainingOptions {
        resume: run.exists(),
        folder: Some(run),
        shared: Some(folder.join(super::train::SIMULATIONS)),
        ..training.options()
    };
    Ok(training.train(body, &options, &mut Terminal::default())?)
}

/// Parts of a body that its arrays do not hold.
fn left_out(body: &Body) -> Vec<&'static str> {
    let parts = [
        ("pressures", !body.pressures.is_empty()),
        ("elastic supports", !body.springs.is_empty()),
        ("averaged volume ratios", !body.patches.is_empty()),
        ("supports along other directions than the axes", !body.frames.is_empty()),
    ];
    parts.into_iter().filter(|(_, has)| *has).map(|(part, _)| part).collect()
}

fn arrays(body: &Body, path: &Path) -> std::io::Result<()> {
    let (points, each) = (body.volumes.len(), body.nodes_per_cell);
    let cells: Vec<f64> = body.cells.iter().map(|&node| node as f64).collect();
    let prescribed: Vec<f64> =
        body.prescribed.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
    let count = body.material.law().directions;
    let directions: Vec<f64> = (0..points)
        .flat_map(|point| body.material.directions(point).as_flattened().to_vec())
        .collect();
    let arrays = [
        ("positions", to_npy(&[body.nodes, 3], body.positions.as_flattened())),
        ("cells", to_npy(&[body.cell_count(), each], &cells)),
        ("shape_gradients", to_npy(&[points, each, 3], body.shape_gradients.as_flattened())),
        ("volumes", to_npy(&[points], &body.volumes)),
        ("nodal_force", to_npy(&[body.nodes, 3], &body.nodal_force)),
        ("prescribed", to_npy(&[body.nodes, 3], &prescribed)),
        ("directions", to_npy(&[directions.len() / (3 * count.max(1)), count, 3], &directions)),
    ];
    npz::write(path, arrays.map(|(name, array)| (name.into(), array)))
}

fn description(body: &Body) -> serde_json::Value {
    let parameter = |p: &sinew::Parameter| json!({ "name": p.name, "unit": p.unit.of_scene(&body.units), "range": p.range, "sampling": p.sampling });
    let probe: Vec<f64> = (0..3 * body.nodes).map(|i| 1e-4 * (i as f64).sin()).collect();
    let theta = body.centre();
    let mut force = vec![0.0; probe.len()];
    let energy = body.value_and_gradient(&probe, &theta, &mut force);
    let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
    json!({
        "name": body.name,
        "units": { "length": body.units.length, "stress": body.units.stress },
        "law": body.material.law().name,
        "known": body.known.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
        "parameters": body.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "nodes": body.nodes, "cells": body.cell_count(), "nodes_per_cell": body.nodes_per_cell,
        "points_per_cell": body.points_per_cell, "unknowns": body.free_degrees_of_freedom().len(),
        "left_out": left_out(body),
        "cavities": body.cavities.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "check": { "displacement": "1e-4 sin(i), i = 3 node + component", "theta": theta, "energy": energy, "force_norm": norm },
    })
}
