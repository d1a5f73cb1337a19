//! Shared state of the stages of one training: body, options, observer, folder, simulations, warnings.

use crate::error::at;
use crate::estimate::evaluate::TestSet;
use crate::parameters::{check_body, in_words, require_inside};
use crate::recipe::progress::Observer;
use crate::sample::simulate::{Shared, Simulations, read_simulations, simulate};
use crate::sample::split_seed;
use crate::store::{SEAL, identity, read_json, write_json};
use crate::{Body, Design, Error, Result, TrainingOptions, Warning};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Independent streams of random numbers, derived from the run's seed.
#[derive(Clone, Copy)]
pub enum Stream {
    /// Parameters to train at.
    Training,
    /// Held-out cases.
    HeldOut,
    /// Simulations of a regression.
    Regression = 3,
}

/// One training under way.
pub struct Session<'a, 'b> {
    /// The body.
    pub body: &'b Body,
    /// Budget, seed, design and folders.
    pub options: &'a TrainingOptions,
    /// Receives progress and warnings.
    pub observer: &'a mut dyn Observer,
    /// Reasons not to trust the result so far.
    pub warnings: Vec<Warning>,
    /// Wall time of simulations so far \[s\].
    pub simulate_s: f64,
    /// Simulations solved so far for training.
    pub simulations: usize,
}

/// Recipe, options and body of a run, kept in its folder.
#[derive(Serialize, Deserialize)]
struct Started {
    /// Short name of the recipe, its settings, and sizes of its network.
    key: String,
    recipe: Value,
    network: Option<Value>,
    options: TrainingOptions,
    body: identity::Identity,
}

const STARTED: &str = "run.json";

impl<'a, 'b> Session<'a, 'b> {
    /// Prepares the folder for a recipe by its short name, settings and sizes of its network: empty, emptied of a run that is to be
    /// replaced, or checked to hold the one to be resumed.
    pub(crate) fn begin(
        body: &'b Body,
        (key, recipe, network): (&str, Value, Option<Value>),
        options: &'a TrainingOptions,
        observer: &'a mut dyn Observer,
    ) -> Result<Self> {
        options.check()?;
        check_body(body)?;
        let (key, body_of_run) = (key.into(), identity::of(body));
        let own = Started { key, recipe, network, options: options.clone(), body: body_of_run };
        if let Some(start) = &options.start {
            check_start(start, &own)?;
        }
        if let Some(folder) = &options.folder {
            // What is learned from must not be emptied with an earlier run.
            let sources = [&options.start, &options.simulations, &options.shared];
            if let Some(source) = sources.into_iter().flatten().find(|path| inside(path, folder)) {
                return Err(Error::Request(format!(
                    "{} lies in {}, which the new run replaces; give the new run another folder",
                    source.display(),
                    folder.display()
                )));
            }
            prepare(folder, &own)?;
        }
        Ok(Self { body, options, observer, warnings: Vec::new(), simulate_s: 0.0, simulations: 0 })
    }

    /// A folder within that of the run.
    pub fn folder(&self, name: &str) -> Option<PathBuf> {
        self.options.folder.as_ref().map(|folder| folder.join(name))
    }

    /// A seed of its own.
    pub fn seed(&self, stream: Stream) -> u64 {
        split_seed(self.options.seed, stream as u64)
    }

    /// Keeps a warning and reports it to the observer.
    pub fn warn(&mut self, warning: Warning) {
        self.observer.warning(&warning);
        self.warnings.push(warning);
    }

    /// Parameters to train at: those of the options, or `count` new ones.
    ///
    /// # Errors
    /// Parameters outside their ranges.
    pub fn thetas(&self, design: Design, count: usize, stream: Stream) -> Result<Vec<Vec<f64>>> {
        match &self.options.thetas {
            Some(given) => {
                require_inside(self.body, given)?;
                Ok(given.clone())
            }
            None => design.sample(&self.body.parameters, count, self.seed(stream)),
        }
    }

    /// Solves for `thetas`; those without a solution are left out with a warning.
    ///
    /// # Errors
    /// Fewer than two solutions, files that cannot be written, an observer that breaks.
    pub fn simulate(&mut self, name: &str, thetas: &[Vec<f64>]) -> Result<Simulations> {
        let (stage, folder) = (format!("simulate {name}"), self.folder("simulations"));
        let folder = folder.map(|folder| folder.join(name));
        // Simulations that another run shares, or those of this run.
        let shared = self.options.shared.as_ref();
        let shared = shared.map(|folder| Shared::new(folder, self.body, thetas));
        let earlier = shared.as_ref().map_or(Ok(None), |shared| shared.find(thetas))?;
        let found = match earlier {
            Some(found) => {
                let outcome = format!("{} solves of an earlier run", found.fields.len());
                self.observer.finished(&stage, &outcome, 0.0);
                found
            }
            None => {
                let found = simulate(self.body, thetas, &stage, folder.as_deref(), self.observer)?;
                if let (Some(shared), Some(folder)) = (shared, &folder) {
                    shared.leave(folder);
                }
                found
            }
        };
        self.note(&stage, &found)?;
        Ok(found)
    }

    /// Requires two solutions, counts their time and warns of those that are missing.
    fn note(&mut self, stage: &str, found: &Simulations) -> Result<()> {
        found.require(self.body, 2)?;
        self.simulate_s += found.seconds;
        if let Some(first) = found.failures.first() {
            let (theta, reason) = (in_words(self.body, &first.theta), first.reason.clone());
            let failed = found.failures.len();
            let (stage, tried) = (stage.into(), failed + found.fields.len());
            self.warn(Warning::FailedSimulations { stage, failed, tried, theta, reason });
        }
        if let Some(theta) = found.branched.first() {
            let (stage, count) = (stage.into(), found.branched.len());
            let theta = in_words(self.body, theta);
            self.warn(Warning::SeveralEquilibria { stage, count, theta });
        }
        if !found.unstable.is_empty() && !self.warnings.contains(&Warning::Unstable) {
            self.warn(Warning::Unstable);
        }
        Ok(())
    }

    /// Solves for training.
    ///
    /// # Errors
    /// As [`Session::simulate`], and a folder of other simulations.
    pub fn training(&mut self, count: usize) -> Result<Simulations> {
        let found = match &self.options.simulations {
            Some(folder) => {
                let mut found = read_simulations(self.body, folder)?;
                require_inside(self.body, &found.thetas)?;
                found.keep(count);
                self.note(&folder.display().to_string(), &found)?;
                found
            }
            None => {
                let thetas = self.thetas(self.options.design, count, Stream::Training)?;
                self.simulate("training", &thetas)?
            }
        };
        self.simulations = found.fields.len();
        Ok(found)
    }

    /// Cases that nothing is trained on.
    pub(crate) fn held_out(&mut self) -> Result<TestSet<'b>> {
        let (count, seed) = (self.options.held_out, self.seed(Stream::HeldOut));
        let thetas = Design::Uniform.sample(&self.body.parameters, count, seed)?;
        Ok(TestSet::new(self.body, self.simulate("held out", &thetas)?))
    }
}

/// Requires a finished run of the same recipe, with networks of the same sizes, for parameters of the same names.
fn check_start(start: &Path, own: &Started) -> Result<()> {
    let stored = read_json::<Started>(&start.join(STARTED));
    let reason = if own.network.is_none() {
        format!("`{}` trains no network of its own; choose pi or dd", own.key)
    } else {
        match stored? {
            None => "it holds no run".into(),
            Some(_) if !is_finished(start) => "its run is not finished".into(),
            Some(stored) if stored.key != own.key => {
                format!("it is of the recipe `{}`, not `{}`", stored.key, own.key)
            }
            Some(stored) if stored.network != own.network => {
                "its network has other sizes; name the same under [training.network]".into()
            }
            Some(stored) if !identity::same_axes(&stored.body.parameters, &own.body.parameters) => {
                let [known, own] = [&stored, own].map(|run| identity::listed(&run.body.parameters));
                format!("its parameters are {known}, those here {own}")
            }
            Some(_) => return Ok(()),
        }
    };
    Err(Error::Request(format!(
        "training cannot start from {}: {reason}; name the folder of a finished run of the same recipe and parameters",
        start.display()
    )))
}

/// Whether a path is a folder or lies in it.
fn inside(path: &Path, folder: &Path) -> bool {
    match (path.canonicalize(), folder.canonicalize()) {
        (Ok(path), Ok(folder)) => path.starts_with(folder),
        _ => false,
    }
}

/// Whether a folder is that of a run, which may be damaged or of an earlier form.
fn is_run(folder: &Path) -> bool {
    let Ok(text) = std::fs::read(folder.join(STARTED)) else { return false };
    match serde_json::from_slice::<serde_json::Value>(&text) {
        Ok(started) => started.get("recipe").is_some() && started.get("body").is_some(),
        Err(_) => ["emulator", "simulations"].iter().any(|part| folder.join(part).is_dir()),
    }
}

/// Whether the run in a folder has left an emulator.
pub(crate) fn is_finished(folder: &Path) -> bool {
    folder.join("emulator").join(SEAL).exists()
}

/// Refuses to replace a run that has left more than what it was started with.
fn require_nothing(folder: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let empty =
        |folder: &Path| std::fs::read_dir(folder).is_ok_and(|mut left| left.next().is_none());
    let mut left = entries.flatten().filter(|e| e.file_name() != STARTED && !empty(&e.path()));
    let (state, resumed) = match (is_finished(folder), left.next()) {
        (_, None) => return Ok(()),
        (true, _) => ("finished", "reads its emulator"),
        (false, _) => ("not finished", "goes on with it"),
    };
    Err(Error::Refused(format!(
        "{} holds a run that is {state}: --resume {resumed}, --restart replaces it; or choose another folder (--name)",
        folder.display()
    )))
}

fn prepare(folder: &Path, own: &Started) -> Result<()> {
    let file = folder.join(STARTED);
    // What a run replaces may be damaged or of an earlier form.
    if own.options.resume
        && let Some(stored) = read_json::<Started>(&file)?
    {
        let recipe = |run: &Started| (run.key.clone(), run.recipe.clone(), run.network.clone());
        // As they are stored, without folders.
        let options = |run: &Started| serde_json::to_value(&run.options).ok();
        let differs = if recipe(&stored) != recipe(own) {
            Some("the recipe")
        } else if options(&stored) != options(own) {
            Some("the options")
        } else {
            identity::difference(&stored.body, &own.body).map(|(what, _, _)| what)
        };
        let Some(differs) = differs else { return Ok(()) };
        return Err(Error::Request(format!(
            "the run in {} was started with another recipe, other options or for another body ({differs}); repeat them, or begin it again (--restart)",
            folder.display()
        )));
    }
    if folder.exists() {
        let mut entries = std::fs::read_dir(folder).map_err(at(folder))?;
        if is_run(folder) {
            if !own.options.restart {
                require_nothing(folder)?;
            }
            std::fs::remove_dir_all(folder).map_err(at(folder))?;
        } else if entries.next().is_some() {
            return Err(Error::Request(format!(
                "{} exists but is not of an earlier training; choose another folder",
                folder.display()
            )));
        }
    }
    write_json(&file, own)
}
