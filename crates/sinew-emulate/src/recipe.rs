//! Recipes: how a body becomes an emulator. One file each; adding one adds a file, a variant and a line of `train`.

mod auto;
mod data_driven;
mod hybrid;
mod physics_informed;
mod regression;

pub use auto::{Auto, Candidate, Choice};
pub use data_driven::DataDriven;
pub use hybrid::Hybrid;
pub use physics_informed::PhysicsInformed;
pub use regression::Regression;
pub use sinew_gnn::{OptimiserConfig, Schedule, TrainingConfig};

use crate::emulator::Model;
use crate::evaluate::TestSet;
use crate::options::cost;
use crate::session::{Session, is_finished};
use crate::{
    Body, Calibration, Coordinates, Emulator, Error, Network, Observer, Record, Result,
    TrainingOptions,
};
use serde::{Deserialize, Serialize};

/// How an emulator is made. [`Recipe::auto`] decides by numbers; every recipe's own settings have defaults that were
/// measured (docs/design.md, docs/emulators.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "recipe", rename_all = "kebab-case")]
pub enum Recipe {
    /// A network on simulated displacements, thesis (3.11).
    DataDriven(DataDriven),
    /// A network by minimum potential energy, thesis (3.12): no simulation enters.
    PhysicsInformed(PhysicsInformed),
    /// A network on simulated displacements whose errors are weighed by the body's stiffness.
    Hybrid(Hybrid),
    /// One solution, at the centre of the parameters' ranges, followed to second order: nothing is trained.
    Series,
    /// Decomposition of few simulations and a Gaussian process: the best of a fixed geometry with few parameters.
    Regression(Regression),
    /// The one that does best on the held-out cases.
    Auto(Auto),
}

impl Recipe {
    /// Chooses by errors on the held-out cases, and says why ([`Record::choice`]).
    pub fn auto() -> Self {
        Self::Auto(Auto::default())
    }

    /// Short name for files and tables.
    pub fn key(&self) -> &'static str {
        match self {
            Self::DataDriven(_) => "dd",
            Self::PhysicsInformed(_) => "pi",
            Self::Hybrid(_) => "hybrid",
            Self::Series => "series",
            Self::Regression(_) => "regression",
            Self::Auto(_) => "auto",
        }
    }

    /// Refuses what could be trained, but neither stored nor meant.
    pub(crate) fn check(&self) -> Result<()> {
        let (Self::Regression(regression) | Self::Auto(Auto { regression, .. })) = self else {
            return Ok(());
        };
        let (what, value) = ("the target of a regression", regression.target);
        let advice = "give a finite number that is not negative";
        let makes_sense = value >= 0.0 && value.is_finite();
        if makes_sense { Ok(()) } else { Err(Error::Setting { what, value, advice }) }
    }

    /// Outputs, sizes and training of its network, where it is one.
    pub(crate) fn network(&self) -> Option<(&Coordinates, Network, &TrainingConfig)> {
        match self {
            Self::DataDriven(DataDriven { coordinates, network, training, .. })
            | Self::PhysicsInformed(PhysicsInformed { coordinates, network, training, .. })
            | Self::Hybrid(Hybrid { coordinates, network, training, .. }) => {
                Some((coordinates, *network, training))
            }
            Self::Series | Self::Regression(_) | Self::Auto(_) => None,
        }
    }

    /// From a body to an emulator that knows its error.
    ///
    /// Solves what the recipe needs, trains, and checks the error estimate on held-out simulations. With a folder
    /// in the options everything is kept there as it is made, a killed run goes on from it, and the emulator is stored
    /// in its `emulator`. A network has the weights that did best on the held-out simulations ([`Record::kept`]). What makes
    /// the result less trustworthy is in [`Record::warnings`].
    ///
    /// # Errors
    /// Settings that make no sense, a body without free parameters, a folder with a run that is neither to be resumed nor to be
    /// replaced, simulations of which most fail, a training that diverges, files that cannot be written, an observer that breaks.
    pub fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'b>> {
        let mut session = Session::begin(body, self, options, observer)?;
        if let Some(folder) = &options.folder
            && is_finished(folder)
        {
            return Emulator::load(&folder.join("emulator"), body);
        }
        let held_out = session.held_out()?;
        let mut record = Record::new(self.clone());
        // Held-out cases are no part of what the recipe costs.
        session.simulate_s = 0.0;
        let model = self.model(&mut session, &held_out, &mut record)?;
        record.simulations = session.simulations;
        record.simulate_s = session.simulate_s;
        let mut emulator = Emulator::new(body, model, record);
        let (calibration, errors) = Calibration::on(&emulator, &held_out)?;
        calibration.warnings().into_iter().for_each(|warning| session.warn(warning));
        emulator.record.warnings = session.warnings;
        emulator.record.calibration = calibration;
        emulator.record.held_out = Some(errors);
        if let Some(folder) = &options.folder {
            emulator.save(&folder.join("emulator"))?;
        }
        Ok(emulator)
    }

    /// Cost of the recipe's own training steps, in decoded parameter sets: what a budget is shared by between recipes. Zero
    /// for a regression.
    pub fn cost(&self) -> f64 {
        match (self, self.network()) {
            (Self::Auto(recipe), _) => recipe.rivals.iter().map(Self::cost).sum(),
            (_, Some((Coordinates::MotionsAfter(first), _, training))) => {
                cost(first) + cost(training)
            }
            (_, Some((_, _, training))) => cost(training),
            (_, None) => 0.0,
        }
    }

    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Model> {
        match self {
            Self::DataDriven(recipe) => recipe.model(session, held_out, record),
            Self::PhysicsInformed(recipe) => recipe.model(session, held_out, record),
            Self::Hybrid(recipe) => recipe.model(session, held_out, record),
            Self::Series => {
                let followed = Emulator::series(session.body, session.options.seed)?;
                let (model, of_it) = followed.into_parts();
                record.prepare_s = of_it.prepare_s;
                session.simulations = of_it.simulations;
                Ok(model)
            }
            Self::Regression(recipe) => recipe.model(session, held_out, record),
            Self::Auto(recipe) => recipe.model(session, held_out, record),
        }
    }
}

macro_rules! from_recipe {
    ($($name:ident),*) => {$(
        impl From<$name> for Recipe {
            fn from(recipe: $name) -> Self {
                Self::$name(recipe)
            }
        }
    )*};
}
from_recipe!(DataDriven, PhysicsInformed, Hybrid, Regression, Auto);
