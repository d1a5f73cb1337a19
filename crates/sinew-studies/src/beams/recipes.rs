//! Meaning of the options of the beams: recipes, budgets, numbers of simulations.

use crate::beams::options::{BeamOptions, Method};
use crate::program;
use sinew_emulate::{Budget, TrainingOptions};
use sinew_gnn::recipe::{DataDriven, PhysicsInformed, Regression};
use sinew_gnn::{Network, OutputCoordinates, Recipe};
use sinew_gnn::{OptimiserConfig, Schedule, TrainingBudget, TrainingConfig};
use std::path::Path;

/// Numbers of simulations.
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
    let simulations = Samples::of(options).regression;
    let regression = Regression { simulations, most: simulations, ..Regression::default() };
    let chosen = options.method.iter().map(|&method| (method.key(), recipe(options, method)));
    chosen.chain([("pod", regression.into())]).collect()
}

/// The thesis' sizes (§2.2.4).
pub(crate) fn thesis_network() -> Network {
    Network { width: 128, ..Network::default() }
}

/// The thesis' schedule (§3.3.1): 5000 epochs of 200 samples, one by one, Adam at 1e-4.
pub(crate) fn thesis_training() -> TrainingConfig {
    TrainingConfig {
        optimiser: OptimiserConfig::adam(),
        learning_rate: 1e-4,
        schedule: Schedule::Constant,
        budget: TrainingBudget::Steps(5000 * 200),
        batch: 1,
        gradient_norm_limit: None,
        evaluations: 500,
        ..TrainingConfig::default()
    }
}

fn recipe(options: &BeamOptions, method: Method) -> Recipe {
    let simulations = Samples::of(options).training;
    let thesis = options.full.then(|| (OutputCoordinates::Components, thesis_training()));
    let network = if options.full { thesis_network() } else { Network::default() };
    match method {
        Method::Dd | Method::Fdd => {
            let base = DataDriven::default();
            let (coordinates, training) = thesis.unwrap_or((base.coordinates, base.training));
            // Both terms of (B.1) are then of one size at the start.
            let gradient_weight = if method == Method::Fdd { 1.0 } else { 0.0 };
            DataDriven { simulations, gradient_weight, coordinates, network, training }.into()
        }
        Method::Pi => {
            let base = PhysicsInformed::default();
            let (coordinates, training) = thesis.unwrap_or((base.coordinates, base.training));
            let parameter_sets = if options.full { simulations } else { base.parameter_sets };
            PhysicsInformed { parameter_sets, coordinates, network, training }.into()
        }
    }
}

/// Training options of one recipe in a run.
pub(crate) fn training(options: &BeamOptions, recipe: &Recipe, folder: &Path) -> TrainingOptions {
    let training = program::training(options.quick, options.seed, folder, options.resume);
    TrainingOptions {
        budget: budget(options, recipe),
        evaluations: if options.full { 500 } else { training.evaluations },
        backend: options.backend.to_string(),
        ..training
    }
}

/// Time of simulations, evaluation of the tests, regression and report of one scene \[s\].
const FIXED_SECONDS: f64 = 10.0;
/// Share of a budget that emulators get at least.
const LEAST_SHARE: f64 = 0.2;
/// Steps of a quick check.
const QUICK_STEPS: usize = 40;

/// Cost of a recipe's own training steps, in decoded parameter sets; zero for a regression.
fn cost(recipe: &Recipe) -> f64 {
    let (coordinates, training) = match recipe {
        Recipe::DataDriven(own) => (&own.coordinates, &own.training),
        Recipe::PhysicsInformed(own) => (&own.coordinates, &own.training),
        Recipe::Taylor | Recipe::Regression(_) | Recipe::Auto(_) => return 0.0,
    };
    match coordinates {
        OutputCoordinates::MotionsAfter(first) => first.cost() + training.cost(),
        _ => training.cost(),
    }
}

/// This recipe's share of the run's budget, in proportion to the cost of the default run.
fn budget(options: &BeamOptions, recipe: &Recipe) -> Budget {
    let Some(budget) = options.budget.map(|budget| budget.as_secs_f64()) else {
        let quick = options.quick && cost(recipe) > 0.0;
        return if quick { Budget::Steps(QUICK_STEPS) } else { Budget::Effort(options.effort) };
    };
    let scenes = options.scene.beams().len() as f64;
    let total: f64 =
        options.method.iter().map(|&method| cost(&self::recipe(options, method))).sum();
    let left = (budget - FIXED_SECONDS * scenes).max(LEAST_SHARE * budget);
    match cost(recipe) {
        0.0 => Budget::default(),
        cost => Budget::Seconds(left / scenes * cost / total),
    }
}
