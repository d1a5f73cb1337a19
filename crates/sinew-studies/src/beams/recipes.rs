//! Meaning of the options of the beams: recipes and numbers of simulations.

use crate::beams::options::{BeamOptions, Method};
use crate::program;
use sinew_emulate::{Budget, TrainingOptions};
use sinew_gnn::Recipe;
use sinew_gnn::recipe::{DataDriven, PhysicsInformed, Regression};
use std::path::Path;

pub(crate) struct Samples {
    /// Latin hypercube for training.
    pub training: usize,
    /// Uniform points that every error in the tables is over.
    pub test: usize,
    /// Name of the regression.
    pub regression: usize,
}

impl Samples {
    /// The thesis' 200 and 100; few for a quick check.
    pub(crate) fn of(options: &BeamOptions) -> Self {
        if options.quick {
            Self { training: 32, test: 8, regression: 12 }
        } else {
            Self { training: 200, test: 100, regression: 25 }
        }
    }
}

/// Recipes by the names of their emulators: the chosen ones, and the regression that they are rivals of.
pub(crate) fn recipes(options: &BeamOptions) -> Vec<(&'static str, Recipe)> {
    let Samples { training: simulations, regression, .. } = Samples::of(options);
    let recipe = |&method: &Method| -> (&'static str, Recipe) {
        let recipe = match method {
            Method::Dd => DataDriven { simulations, ..DataDriven::default() }.into(),
            Method::Pi => PhysicsInformed::default().into(),
        };
        (method.key(), recipe)
    };
    let pod = Regression { simulations: regression, most: regression, ..Regression::default() };
    options.method.iter().map(recipe).chain([("pod", pod.into())]).collect()
}

pub(crate) fn training(options: &BeamOptions, recipe: &Recipe, folder: &Path) -> TrainingOptions {
    const QUICK_STEPS: usize = 20;
    let training = program::training(options.quick, options.seed, folder, options.resume);
    let is_network = matches!(recipe, Recipe::DataDriven(_) | Recipe::PhysicsInformed(_));
    let budget = match options.quick && is_network {
        true => Budget::Steps(QUICK_STEPS),
        false => Budget::default(),
    };
    TrainingOptions { budget, backend: options.backend.to_string(), ..training }
}
