//! A curriculum in load: the potential energy under loads that grow to their full size.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use burn::tensor::Tensor;
use sinew_gnn::{Batch, DataSet, MinimumPotential, Objective, Result};
use sinew_study::train::Body;

/// Minimum potential energy at a quarter, a half, three quarters and all of the load, one after the other; the full
/// load from half of the steps on.
pub struct LoadRamp {
    stages: Vec<MinimumPotential>,
    steps: usize,
    made: AtomicUsize,
}

impl LoadRamp {
    /// `energy` makes the loss dimensionless.
    pub fn new(body: &Body, energy: f64, steps: usize) -> Result<Self> {
        let stage = |share: f64| {
            let mut potential = body.potential.clone();
            potential.nodal_force.iter_mut().for_each(|force| *force *= share);
            MinimumPotential::new(vec![Arc::new(potential)], energy)
        };
        let stages = [0.25, 0.5, 0.75, 1.0].map(stage).into_iter().collect::<Result<_>>()?;
        Ok(Self { stages, steps, made: AtomicUsize::new(0) })
    }
}

impl Objective for LoadRamp {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.stages.iter().try_for_each(|stage| stage.check(data))
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        // Evaluations without gradients are of the full load.
        let stage = match displacement.is_autodiff() {
            true => 6 * self.made.fetch_add(1, Ordering::Relaxed) / self.steps.max(1),
            false => self.stages.len(),
        };
        self.stages[stage.min(self.stages.len() - 1)].loss(batch, displacement)
    }

    fn inadmissible(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> usize {
        self.stages[0].inadmissible(batch, displacement)
    }
}
