//! Training.

use super::{CaseArguments, refuse, refuse_if, runs, warn, warn_of_locking};
use anyhow::Result;
use clap::Args;
use sinew::case::{RecipeName, Training, doubtful_emulator};
use sinew_emulate::{Errors, Kept};
use std::path::{Path, PathBuf};

/// Recipe and budget.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/train.txt"))]
pub(crate) struct Train {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    runs: runs::RunsArguments,
    #[command(flatten)]
    training: Training,
    /// Folder of simulations to learn from, such as OUT/sample of sinew merge
    #[arg(long, value_name = "FOLDER")]
    simulations: Option<PathBuf>,
    /// Folder of a run to fine-tune, of the same recipe and parameters on any mesh; with --steps 0 its network is used unchanged
    #[arg(long, value_name = "FOLDER")]
    from: Option<PathBuf>,
    /// Backend of a network's training: flex (this processor), ndarray (deprecated), wgpu or cuda (graphics processors)
    #[cfg(feature = "networks")]
    #[arg(long, default_value_t)]
    backend: sinew::Backend,
    /// Name of the emulator's folder within OUT [default: the recipe's]
    #[arg(long)]
    name: Option<String>,
    /// Resume the run in that folder
    #[arg(long, conflicts_with = "restart")]
    resume: bool,
    /// Replace the run in that folder
    #[arg(long)]
    restart: bool,
}

/// Folder within OUT for simulations that recipes share.
pub(crate) const SIMULATIONS: &str = "simulations";
/// Folders within OUT that commands write into.
const TAKEN: [&str; 7] =
    [SIMULATIONS, "predict", "correct", "solve", "sample", "test", "calibrate"];

impl Train {
    pub(crate) fn run(&self) -> Result<()> {
        if self.runs.are_given() {
            return self.runs.train(&self.case, self.restart);
        }
        #[cfg(feature = "networks")]
        self.backend
            .device()
            .map_err(|reason| super::Usage(format!("--backend {}: {reason}", self.backend)))?;
        let (case, body, folder) = self.case.open()?;
        warn_of_locking(sinew_fem::locking_at_centre(&body));
        let mut training = self.training.clone().or(case.training);
        if self.simulations.is_some() {
            // All stored simulations by default.
            training.samples.get_or_insert(usize::MAX);
        }
        if let Some(few @ 0..=1) = training.samples {
            return refuse(format!("{few} simulations to learn from: give at least 2 (--samples)"));
        }
        let recipe = training.recipe_name().key();
        let alone = matches!(training.recipe_name(), RecipeName::Pi | RecipeName::Taylor);
        refuse_if(self.simulations.is_some() && alone, || {
            format!(
                "`{recipe}` learns from no simulations; leave --simulations out, or choose regression or dd"
            )
        })?;
        let Training { samples, target, minutes, steps, .. } = &self.training;
        let is = |recipes: &[RecipeName]| recipes.contains(&training.recipe_name());
        let unread = [
            ("--samples", samples.is_some() && alone),
            ("--target", target.is_some() && (alone || is(&[RecipeName::Dd]))),
            ("--minutes", minutes.is_some() && is(&[RecipeName::Taylor])),
            ("--steps", steps.is_some() && is(&[RecipeName::Taylor, RecipeName::Regression])),
        ];
        if let Some((option, _)) = unread.into_iter().find(|(_, is_given)| *is_given) {
            return refuse(format!(
                "{option} has no effect on `{recipe}`; leave it out, or choose another --recipe"
            ));
        }
        let name = self.name.as_deref().unwrap_or(recipe);
        let reason = || format!("--name {name}: give the name of a folder within OUT");
        refuse_if(Path::new(name).file_name() != Some(name.as_ref()), reason)?;
        let reason =
            || format!("--name {name}: commands write into that folder; give another name");
        refuse_if(TAKEN.contains(&name), reason)?;
        let (shared, folder) = (folder.join(SIMULATIONS), folder.join(name));
        let options = sinew::TrainingOptions {
            folder: Some(folder.clone()),
            simulations: self.simulations.clone(),
            start: self.from.clone(),
            #[cfg(feature = "networks")]
            backend: self.backend.to_string(),
            shared: Some(shared),
            resume: self.resume,
            restart: self.restart,
            ..training.options()
        };
        let mut terminal = sinew_emulate::Terminal::default();
        let emulator = training.train(&body, &options, &mut terminal)?;
        warn(doubtful_emulator(&emulator)?);
        tell(&emulator, &folder);
        Ok(())
    }
}

/// Early stopping: the weights of a network that were kept, and why.
fn kept_in_words(kept: &Kept, steps: u64) -> String {
    let Kept { step, error, returns } = *kept;
    let why = match error {
        Some(error) => format!(
            "the best: error {error:.1e} over the held-out cases (root mean square, relative)"
        ),
        None => "the last, for none had a finite error on the held-out cases".into(),
    };
    let back = match returns {
        0 => String::new(),
        1 => "; left once, and returned to with half the steps' length".into(),
        n => format!("; left {n} times, and returned to with half the steps' length each time"),
    };
    format!("kept: the network after step {step} of {steps}, {why}{back}")
}

/// Prints the outcome of the training and the folder of the emulator.
fn tell(emulator: &sinew::Emulator<'_>, folder: &Path) {
    let record = &emulator.record;
    match &record.choice {
        Some(choice) => println!("{choice}"),
        None => println!("{}", record.about),
    }
    if let Some(errors) = &record.held_out {
        let (cases, unit) = (record.calibration.cases, &emulator.body().units.length);
        let Errors { err_u, relative, .. } = errors;
        println!(
            "on {cases} held-out cases: err_u median {:.2e} {unit}, largest {:.2e} {unit}; relative to the displacements median {:.2e}, largest {:.2e}",
            err_u.q50, err_u.max, relative.q50, relative.max
        );
    }
    let [simulate, train] = [record.simulate_s, record.prepare_s + record.train_s];
    if let Some(kept) = &record.kept {
        println!("{}", kept_in_words(kept, record.steps));
    }
    println!("{} simulations in {simulate:.1} s, training in {train:.1} s", record.simulations);
    if record.warnings.is_empty() {
        println!("written: {}", folder.display());
    } else {
        println!("written: {}, not to be trusted before these are read:", folder.display());
        record.warnings.iter().for_each(|warning| println!("  {warning}"));
    }
}
