//! An experiment: cases, each run on several data sets.

use crate::gp::row::{Label, Method, Run, Truth};
use anyhow::Result;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Extent of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// A check of the code path, not a result.
    pub quick: bool,
}

impl Scale {
    /// The first for a result, the second for a check.
    pub(crate) fn pick<T>(self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }
}

/// One data set to be made and fitted.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// Seed that all random choices derive from.
    pub seed: u64,
    /// Whether to draw.
    pub draw: bool,
}

impl Task {
    /// A seed for one purpose, independent of those for others.
    pub(crate) fn seed_for(&self, purpose: Purpose) -> u64 {
        derived(self.seed, purpose as u64)
    }
}

/// Purpose of a seed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Places,
    /// Errors of observed values.
    Noise,
    Collocation,
    /// Pseudo-observations of the boundary.
    Boundary,
    /// Seed of the optimiser.
    Starts,
    /// Seed of parameters or functions.
    Draws,
}

/// A seed that `seed` and `stream` determine, without visible relation to those of neighbours.
pub fn derived(seed: u64, stream: u64) -> u64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random.random()
}

/// Does one task.
pub(crate) type Runner = Box<dyn Fn(&Task) -> Result<Run> + Send + Sync>;

/// One method on one problem.
pub struct Case {
    /// Subject.
    pub label: Label,
    /// Does one task.
    pub run: Runner,
}

impl Case {
    /// Case of a method on a problem with parameters: the work of one task.
    pub(crate) fn new(
        (problem, truth): (&str, &[Truth]),
        method: Method,
        run: impl Fn(&Task) -> Result<Run> + Send + Sync + 'static,
    ) -> Self {
        let label = Label {
            problem: problem.into(),
            setting: String::new(),
            method,
            abscissa: None,
            truth: truth.to_vec(),
        };
        Self { label, run: Box::new(run) }
    }

    /// Case with a label that distinguishes it from others of the same problem and method.
    pub(crate) fn at(mut self, setting: impl Into<String>) -> Self {
        self.label.setting = setting.into();
        self
    }

    /// Case with the number that varies in a sweep.
    pub(crate) fn sweep(mut self, abscissa: f64) -> Self {
        self.label.abscissa = Some(abscissa);
        self
    }

    /// Name in files, unique within an experiment.
    pub fn key(&self) -> String {
        let label = &self.label;
        let text = format!("{} {} {}", label.problem, label.method.label(), label.setting);
        let plain = text.to_lowercase().replace(|c: char| !c.is_ascii_alphanumeric(), "-");
        let words: Vec<&str> = plain.split('-').filter(|word| !word.is_empty()).collect();
        words.join("-")
    }
}

/// A family of cases that answers one question.
pub struct Experiment {
    /// Title, with the thesis' section.
    pub title: &'static str,
    /// Description and notes.
    pub about: &'static str,
    /// The cases.
    pub cases: Vec<Case>,
}
