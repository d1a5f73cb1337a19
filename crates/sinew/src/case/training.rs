//! Training of an emulator in a case file.

use serde::{Deserialize, Serialize};
use sinew_emulate::recipe::Regression;
use sinew_emulate::{Body, Budget, Design, Emulator, Error, Observer, TrainingOptions};
#[cfg(feature = "networks")]
use sinew_gnn::{
    Network, Recipe,
    recipe::{Auto, DataDriven, PhysicsInformed},
};

/// Sizes of a network, which a build without networks does not read.
#[cfg(not(feature = "networks"))]
type Network = toml::Table;

/// Settings of an emulator's training; every key may be left out.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// The recipe.
    pub recipe: RecipeName,
    /// Simulations to learn from; by default the recipe's own number.
    pub samples: Option<usize>,
    /// Error relative to the displacements at which a regression is good enough.
    pub target: Option<f64>,
    /// Wall time of simulations and training \[min\].
    pub minutes: Option<f64>,
    /// Training steps in all.
    pub steps: Option<usize>,
    /// Seed that all others derive from; 1 by default.
    pub seed: Option<u64>,
    /// Simulations that nothing is trained on; 20 by default.
    pub held_out: Option<usize>,
    /// Solved states that taylor or pi stand about; 1 by default.
    pub anchors: Option<usize>,
    /// Design of the samples.
    pub design: Option<Design>,
    /// Sizes of the network.
    pub network: Option<Network>,
}

/// A recipe by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum RecipeName {
    /// The one of lowest error on the held-out cases: regression, and dd where that misses the target.
    #[default]
    Auto,
    /// Taylor expansion of second order about one solution: nothing is trained.
    Taylor,
    /// Few simulations, their main modes, and a Gaussian process.
    Regression,
    /// A network by minimum potential energy, without simulations.
    Pi,
    /// A network on simulated displacements.
    Dd,
}

impl RecipeName {
    /// Short name for files and tables.
    pub fn key(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Taylor => "taylor",
            Self::Regression => "regression",
            Self::Pi => "pi",
            Self::Dd => "dd",
        }
    }

    /// Whether it always trains a network.
    pub fn is_network(self) -> bool {
        matches!(self, Self::Pi | Self::Dd)
    }
}

impl Training {
    /// These settings, and those of `own` where they are not given; a budget replaces another, whichever kind it is.
    pub fn or(self, own: Self) -> Self {
        let (minutes, steps) = match (self.minutes, self.steps) {
            (None, None) => (own.minutes, own.steps),
            budget => budget,
        };
        Self {
            recipe: self.recipe,
            samples: self.samples.or(own.samples),
            target: self.target.or(own.target),
            minutes,
            steps,
            seed: self.seed.or(own.seed),
            held_out: self.held_out.or(own.held_out),
            anchors: self.anchors.or(own.anchors),
            design: self.design.or(own.design),
            network: self.network.or(own.network),
        }
    }

    /// Trains by the recipe.
    ///
    /// # Errors
    /// As [`sinew_emulate::train`].
    #[cfg(feature = "networks")]
    pub fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'b>, Error> {
        self.recipe().train(body, options, observer)
    }

    /// Trains by the recipe; `auto` is regression in a build without networks.
    ///
    /// # Errors
    /// As [`sinew_emulate::train`], and recipes of networks.
    #[cfg(not(feature = "networks"))]
    pub fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'b>, Error> {
        use sinew_emulate::{Train, recipe::Taylor};
        if self.recipe.is_network() {
            let reason = format!(
                "the recipe `{}` trains a network, which this build leaves out; build with the feature `networks`, or \
                 choose taylor or regression",
                self.recipe.key()
            );
            return Err(Error::Network(reason.into()));
        }
        match self.recipe {
            RecipeName::Taylor => Taylor.train(body, options, observer),
            _ => self.regression().train(body, options, observer),
        }
    }

    /// The recipe with its settings.
    #[cfg(feature = "networks")]
    pub fn recipe(&self) -> Recipe {
        let network = self.network.unwrap_or_default();
        match self.recipe {
            RecipeName::Auto => Auto { regression: self.regression(), ..Auto::default() }.into(),
            RecipeName::Taylor => Recipe::Taylor,
            RecipeName::Regression => self.regression().into(),
            RecipeName::Pi => PhysicsInformed { network, ..PhysicsInformed::default() }.into(),
            RecipeName::Dd => {
                let own = DataDriven::default();
                let simulations = self.samples.unwrap_or(own.simulations);
                DataDriven { simulations, network, ..own }.into()
            }
        }
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
