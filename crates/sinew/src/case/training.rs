//! Training of an emulator in a case file.

use serde::{Deserialize, Serialize};
use sinew_emulate::recipe::Regression;
use sinew_emulate::{Body, Budget, Design, Emulator, Error, Observer, TrainingOptions};
#[cfg(feature = "networks")]
use sinew_gnn::{
    Network, OptimiserConfig, OutputCoordinates, Recipe, TrainingConfig,
    recipe::{DataDriven, PhysicsInformed},
};

/// Sizes of a network, which a build without networks does not read.
#[cfg(not(feature = "networks"))]
type Network = toml::Table;

/// Largest size of a network and of a batch: beyond, a step takes minutes.
const MOST: usize = 1024;

/// Settings of an emulator's training; every key may be left out. Those with an option of `sinew train` have its help as documentation.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// Kind of emulator
    #[arg(long, value_enum)]
    pub recipe: Option<RecipeName>,
    /// Number of simulations to learn from
    #[arg(long, value_name = "COUNT")]
    pub samples: Option<usize>,
    /// Validation error, relative to the displacements, below which a regression takes no more simulations
    #[arg(long)]
    pub target: Option<f64>,
    /// Solved states that the expansion of taylor or pi passes through. They are added where the error is largest, and
    /// count as simulations
    #[arg(long, value_name = "COUNT")]
    pub anchors: Option<usize>,
    /// Wall time of simulations and training in minutes
    #[arg(long, conflicts_with = "steps")]
    pub minutes: Option<f64>,
    /// Training steps
    #[arg(long)]
    pub steps: Option<usize>,
    /// Seed of all random numbers
    #[arg(long)]
    pub seed: Option<u64>,
    /// Simulations that nothing is trained on; 20 by default.
    #[arg(skip)]
    pub held_out: Option<usize>,
    /// Design of the samples.
    #[arg(skip)]
    pub design: Option<Design>,
    /// Sizes of the network.
    #[arg(skip)]
    pub network: Option<Network>,
    /// Optimiser of the network's weights.
    #[arg(skip)]
    pub optimiser: Option<Optimiser>,
    /// Peak of the learning rate, in every stage of a training.
    #[arg(skip)]
    pub learning_rate: Option<f64>,
    /// Parameter sets in a training step.
    #[arg(skip)]
    pub batch: Option<usize>,
}

/// An optimiser of networks by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Optimiser {
    /// Muon on matrices, Adam on vectors.
    Muon,
    /// Adam with decays of 0.9 and 0.999.
    Adam,
}

/// A recipe by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum RecipeName {
    /// Taylor expansion of second order about one solution: nothing is trained.
    Taylor,
    /// Few simulations, their main modes, and a Gaussian process.
    #[default]
    Regression,
    /// A network by minimum potential energy, without simulations.
    Pi,
    /// A network on simulated displacements.
    Dd,
}

impl RecipeName {
    /// Short name for files and tables.
    pub fn key(self) -> &'static str {
        ["taylor", "regression", "pi", "dd"][self as usize]
    }

    /// Whether it trains a network.
    pub fn is_network(self) -> bool {
        matches!(self, Self::Pi | Self::Dd)
    }
}

impl Training {
    /// Name of the recipe; `regression` by default.
    pub fn recipe_name(&self) -> RecipeName {
        self.recipe.unwrap_or_default()
    }

    /// These settings, and those of `own` where they are not given; a budget replaces another, whichever kind it is.
    pub fn or(self, own: Self) -> Self {
        let (minutes, steps) = match (self.minutes, self.steps) {
            (None, None) => (own.minutes, own.steps),
            budget => budget,
        };
        Self {
            recipe: self.recipe.or(own.recipe),
            samples: self.samples.or(own.samples),
            target: self.target.or(own.target),
            anchors: self.anchors.or(own.anchors),
            minutes,
            steps,
            seed: self.seed.or(own.seed),
            held_out: self.held_out.or(own.held_out),
            design: self.design.or(own.design),
            network: self.network.or(own.network),
            optimiser: self.optimiser.or(own.optimiser),
            learning_rate: self.learning_rate.or(own.learning_rate),
            batch: self.batch.or(own.batch),
        }
    }

    /// The first key of networks that the recipe does not read, or whose value admits no training, and the reason.
    pub fn objection(&self) -> Option<(&'static str, String)> {
        if self.minutes.is_some() && self.steps.is_some() {
            return Some(("steps", "give minutes or steps, not both".into()));
        }
        let keys = [
            ("network", self.network.is_some()),
            ("optimiser", self.optimiser.is_some()),
            ("learning_rate", self.learning_rate.is_some()),
            ("batch", self.batch.is_some()),
        ];
        let recipe = self.recipe_name();
        if let Some((key, _)) = keys.into_iter().find(|(_, given)| *given && !recipe.is_network()) {
            let recipe = recipe.key();
            let advice = "leave this key out, or choose pi or dd";
            return Some((key, format!("the recipe `{recipe}` trains no network; {advice}")));
        }
        let is_rate = |rate: &f64| (f64::MIN_POSITIVE..=1.0).contains(rate);
        if let Some(rate) = self.learning_rate.filter(|rate| !is_rate(rate)) {
            let advice = "give a number above 0, at most 1, such as 4e-3";
            return Some(("learning_rate", format!("{rate} is not a learning rate; {advice}")));
        }
        let mut sizes = Vec::new();
        sizes.extend(self.batch.map(|batch| ("batch", batch, 1)));
        #[cfg(feature = "networks")]
        if let Some(network) = &self.network {
            let levels = network.virtual_nodes.as_deref().unwrap_or_default();
            if levels.windows(2).any(|pair| pair[1] >= pair[0]) || levels.contains(&0) {
                let reason = "each level has fewer than the one before, and the last at least one; give them such as [97, 24]";
                return Some(("network.virtual_nodes", reason.into()));
            }
            sizes.extend([
                ("network.latent", network.latent, 1),
                ("network.width", network.width, 1),
                ("network.cluster_width", network.cluster_width, 1),
                ("network.message_passing_steps", network.message_passing_steps, 0),
            ]);
        }
        let refused = |(_, value, least): &(_, usize, usize)| !(*least..=MOST).contains(value);
        let (key, value, least) = sizes.into_iter().find(refused)?;
        Some((key, format!("{value} is out of bounds; give {least} to {MOST}")))
    }

    /// Trains by the recipe.
    ///
    /// # Errors
    /// As [`sinew_emulate::Train::train`], and recipes of networks in such a build.
    pub fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'b>, Error> {
        #[cfg(feature = "networks")]
        {
            let trains = self.recipe_name().is_network();
            let levels = self.network.iter().flat_map(|network| &network.virtual_nodes).flatten();
            let first = levels.copied().next();
            if let Some(first) = first.filter(|&first| trains && first >= body.nodes) {
                return Err(Error::Request(format!(
                    "training.network.virtual_nodes: the first level has {first}, and the mesh {} nodes; give fewer",
                    body.nodes
                )));
            }
            self.recipe().train(body, options, observer)
        }
        #[cfg(not(feature = "networks"))]
        {
            use sinew_emulate::{Train, recipe::Taylor};
            let name = self.recipe_name();
            if name.is_network() {
                let reason = format!(
                    "the recipe `{}` trains a network, which this build leaves out; build with the feature `networks`, or \
                     choose taylor or regression",
                    name.key()
                );
                return Err(Error::Network(reason.into()));
            }
            match name {
                RecipeName::Taylor => Taylor.train(body, options, observer),
                _ => self.regression().train(body, options, observer),
            }
        }
    }

    /// The recipe with its settings.
    #[cfg(feature = "networks")]
    pub fn recipe(&self) -> Recipe {
        match self.recipe_name() {
            RecipeName::Taylor => Recipe::Taylor,
            RecipeName::Regression => self.regression().into(),
            RecipeName::Pi => {
                let network = self.network.clone().unwrap_or_default();
                let mut own = PhysicsInformed { network, ..PhysicsInformed::default() };
                if let OutputCoordinates::MotionsAfter(first) = &mut own.coordinates {
                    self.tune(first);
                }
                self.tune(&mut own.training);
                own.into()
            }
            RecipeName::Dd => {
                let mut own = DataDriven::default();
                own.simulations = self.samples.unwrap_or(own.simulations);
                own.network = self.network.clone().unwrap_or_default();
                self.tune(&mut own.training);
                own.into()
            }
        }
    }

    /// Puts the keys that are given into a training.
    #[cfg(feature = "networks")]
    fn tune(&self, training: &mut TrainingConfig) {
        match self.optimiser {
            Some(Optimiser::Muon) => training.optimiser = OptimiserConfig::default(),
            Some(Optimiser::Adam) => training.optimiser = OptimiserConfig::adam(),
            None => {}
        }
        training.learning_rate = self.learning_rate.unwrap_or(training.learning_rate);
        training.batch = self.batch.unwrap_or(training.batch);
    }

    fn regression(&self) -> Regression {
        let own = Regression::default();
        let target = self.target.unwrap_or(own.target);
        match self.samples {
            None => Regression { target, ..own },
            Some(most) => Regression { simulations: own.simulations.min(most), most, target },
        }
    }

    /// Budget, seed and held-out cases.
    pub fn options(&self) -> TrainingOptions {
        let own = TrainingOptions::default();
        let budget = match (self.minutes, self.steps) {
            (Some(minutes), _) => Budget::Seconds(60.0 * minutes),
            (None, Some(steps)) => Budget::Steps(steps),
            (None, None) => own.budget,
        };
        TrainingOptions {
            budget,
            seed: self.seed.unwrap_or(own.seed),
            design: self.design.unwrap_or(own.design),
            held_out: self.held_out.unwrap_or(own.held_out),
            anchors: self.anchors.unwrap_or(own.anchors),
            ..own
        }
    }
}
