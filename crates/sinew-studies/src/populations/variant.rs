//! Networks of a study, their inputs and their training.

use super::options::Options;
use anyhow::Result;
use sinew_gnn::{Activation, DataFit, DataSet, Surrogate, Trainer, TrainingBudget, TrainingConfig};

/// Input of a method.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs {
    /// Number of coefficients of its shape.
    pub numbers: usize,
    /// Whether the solution on the coarse mesh is an input, which is then corrected.
    pub coarse: bool,
}

impl Inputs {
    /// Deviation from the default, for a table.
    pub(super) fn name(self) -> &'static str {
        if self.coarse { ", about the coarse solution" } else { "" }
    }
}

/// One network of a study.
#[derive(Clone, Copy, Debug)]
pub(super) struct Variant {
    /// K.
    pub steps: usize,
    /// Width of the embeddings, M.
    pub latent: usize,
    /// Virtual nodes, η.
    pub virtual_nodes: &'static [usize],
    /// Input.
    pub told: Inputs,
    /// Whether the shared graph is that of a template instead of the average body.
    pub template: bool,
    /// Whether parameters are read on their own scale instead of the logarithmic one.
    pub raw: bool,
    /// Nonlinearity of the hidden layers.
    pub activation: Activation,
    /// Pace of its training, where not that of the others.
    pub pace: Option<Pace>,
}

impl Variant {
    /// Parameters on the scale of their sampling, on the graph of the average body.
    pub(super) fn new(
        steps: usize,
        latent: usize,
        virtual_nodes: &'static [usize],
        told: Inputs,
    ) -> Self {
        let (template, raw, activation, pace) = (false, false, Activation::Tanh, None);
        Self { steps, latent, virtual_nodes, told, template, raw, activation, pace }
    }

    /// Description for a table.
    pub(super) fn name(&self) -> String {
        let Self { steps, latent, virtual_nodes, .. } = self;
        let nodes = match virtual_nodes {
            [] => "no virtual nodes".into(),
            some => format!("η = {some:?}"),
        };
        let template = if self.template { ", template" } else { "" };
        let raw = if self.raw { ", parameters as they are" } else { "" };
        format!("K = {steps}, M = {latent}, {nodes}{template}{raw}")
    }
}

/// Length and rate of a training.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Steps, of one body each.
    pub steps: usize,
    /// Largest learning rate.
    pub rate: f64,
    /// Parameter sets in a step, where a body has several.
    pub batch: usize,
    /// Share of the steps in which message passing is trained.
    pub embedding_share: f64,
    /// Whether embeddings stay constant afterwards instead of becoming weights.
    pub frozen_encoder: bool,
}

impl Pace {
    /// Message passing is trained in every step, of one parameter set each.
    pub(super) const fn of(steps: usize, rate: f64) -> Self {
        Self { steps, rate, batch: 1, embedding_share: 1.0, frozen_encoder: false }
    }
}

/// Trains a network on simulations, by the mean nodal distance to them; the best weights on those to validate with are kept.
pub(super) fn train(
    surrogate: Surrogate,
    data: DataSet,
    pace: Pace,
    options: &Options,
) -> Result<Surrogate> {
    let objective = DataFit::new(surrogate.scales().output.length())?;
    let config = TrainingConfig {
        learning_rate: pace.rate,
        batch: pace.batch,
        budget: TrainingBudget::Steps(if options.quick { 4 } else { pace.steps }),
        evaluations: if options.quick { 2 } else { 20 },
        embedding_share: pace.embedding_share,
        frozen_encoder: pace.frozen_encoder,
        seed: options.seed,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data, Box::new(objective), config)?;
    trainer.run(&mut ())?;
    Ok(trainer.into_surrogate())
}
