//! An emulator for a browser, and the weights of a network.

#[cfg(feature = "networks")]
use super::refuse;
use super::{CaseArguments, chosen, runs, trained, warn, write};
#[cfg(feature = "networks")]
use anyhow::Context;
use anyhow::Result;
use clap::{ArgGroup, Args};
use sinew::case::{RecipeName, Training, doubtful_emulator};
use sinew::{Body, Case, Emulator, PAGE_SEED, TrainingOptions};
use sinew_emulate::Terminal;
use sinew_report::Viewer;
use std::path::Path;

/// Emulator, and what is written of it.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/export.txt"), group = ArgGroup::new("of_emulator").required(true).multiple(true))]
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
    #[arg(long, value_name = "NAME")]
    emulator: Option<String>,
}

impl Export {
    pub(crate) fn run(&self) -> Result<()> {
        let asked = [
            #[cfg(feature = "networks")]
            self.weights,
            self.emulator.is_some(),
        ];
        if let Some(runs) = runs::trained(&self.case, asked, "--weights, --emulator")? {
            let place = &self.case.file.case;
            // The place may be `.`.
            let whole = place.canonicalize()?;
            let title = whole.file_name().unwrap_or_default().to_string_lossy();
            let viewer = sinew::viewer_of_runs(&runs, &title, PAGE_SEED)?;
            let out = self.case.out.as_ref().unwrap_or(place);
            std::fs::create_dir_all(out)?;
            return write_page(&viewer, &out.join("emulator.html"));
        }
        let (case, body, folder) = self.case.open()?;
        if self.page {
            self.page(&case, &body, &folder)?;
        }
        #[cfg(feature = "networks")]
        if self.weights {
            self.weights(&case, &folder)?;
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
        let count = weights.len();
        let arrays = weights.into_iter().map(|(name, of, u)| (name, sinew_mesh::to_npy(&of, &u)));
        sinew::npz::write(&file, arrays).with_context(|| file.display().to_string())?;
        println!("written: {}, {count} arrays", file.display());
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
        write_page(&viewer, &folder.join(format!("{name}.html")))
    }
}

/// Writes a page, and tells what was measured of it.
fn write_page(viewer: &Viewer, file: &Path) -> Result<()> {
    for (name, value) in &viewer.facts {
        println!("{name}: {value}");
    }
    let page = viewer.to_html();
    write(file, &page)?;
    let size = sinew_report::format::digits(page.len() as f64 / 1e6, 2);
    println!("written: {}, {size} MB; open it in a browser", file.display());
    Ok(())
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
