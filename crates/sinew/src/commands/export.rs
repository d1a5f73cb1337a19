//! An emulator for other programs.

use super::{CaseArguments, chosen, refuse, tell_doubtful, trained, warn, write};
#[cfg(feature = "networks")]
use anyhow::Context;
use anyhow::Result;
use clap::Args;
use sinew::case::{RecipeName, Training};
use sinew::{Body, Case, Emulator, TrainingOptions};
use sinew_emulate::Terminal;
use std::path::Path;

/// Emulator.
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

/// Seed of the predictions that a page is made from.
pub(super) const SEED: u64 = 0x9a6e;

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
        refuse("name what to write: --page, or --weights of a network".into())
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
        let arrays =
            weights.iter().map(|(name, shape, values)| (&name[..], &shape[..], &values[..]));
        let file = folder.join(format!("{name}.npz"));
        sinew::npz::write(&file, &arrays.collect::<Vec<_>>(), &[])
            .with_context(|| file.display().to_string())?;
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
        tell_doubtful(body, [emulator.predict(&[body.centre()])?.field(0)]);
        let viewer = sinew::viewer(&emulator, SEED, &mut Terminal::default())?;
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
    let own = case.training.clone();
    let training = Training { recipe: RecipeName::Regression, ..own };
    let run = folder.join(training.recipe.key());
    eprintln!("nothing is trained yet in {}: a regression is now", folder.display());
    let options = TrainingOptions {
        resume: run.exists(),
        folder: Some(run),
        shared: Some(folder.join(super::train::SIMULATIONS)),
        ..training.options()
    };
    Ok(training.train(body, &options, &mut Terminal::default())?)
}
