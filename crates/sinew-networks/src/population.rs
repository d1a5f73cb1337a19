//! One network for all bodies of a population, trained on a stream of bodies by energy or on simulations of each.

mod emulator;
mod settings;
mod stream;
mod template;

pub use emulator::PopulationEmulator;
pub use settings::{Draw, Loss, Population, Start};

use crate::Result;
use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};
use sinew_coordinates::OutputScale;
use sinew_emulate::Body;
use sinew_emulate::parts::scaling;
use sinew_gnn::{
    Backend, Budget, DataSet, Geometry, GeometryBatch, Scales, StreamTrainer, Surrogate,
    TrainingConfig,
};
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Instant;
use template::Template;

/// Progress of a training on a stream.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamProgress {
    /// Steps made.
    pub step: usize,
    /// Part of the budget that is spent.
    pub share: f64,
    /// Wall time since the start, evaluations not counted \[s\].
    pub seconds: f64,
    /// Mean loss since the last evaluation, of steps whose loss was finite.
    pub loss: f64,
    /// Bodies that were left out because they could not be prepared, such as those without an equilibrium.
    pub left_out: usize,
}

/// Numbers of the bodies that scales and graphs are taken from, far from those trained on.
const FIRST_OF_SCALES: u64 = 1 << 40;
/// Number of these bodies.
const OF_SCALES: u64 = 16;
fn first_bodies(draw: &Draw<'_>) -> Result<Vec<Body>> {
    (0..OF_SCALES).map(|index| draw(FIRST_OF_SCALES + index)).collect()
}

impl Population {
    /// An untrained network.
    ///
    /// # Errors
    /// A body that cannot be drawn or prepared.
    pub fn prepare(&self, draw: &Draw<'_>, seed: u64) -> Result<PopulationEmulator> {
        self.untrained(&first_bodies(draw)?, seed)
    }

    /// Trains on the bodies that `draw` makes, and shows the network as it is `training.evaluations` times.
    ///
    /// # Errors
    /// A body that cannot be drawn, prepared or learned.
    pub fn train(
        &self,
        draw: &Draw<'_>,
        seed: u64,
        observe: &mut dyn FnMut(StreamProgress, &PopulationEmulator) -> Result<ControlFlow<()>>,
    ) -> Result<PopulationEmulator> {
        let mut emulator = self.untrained(&first_bodies(draw)?, seed)?;
        let template = emulator.template.clone();
        let config = TrainingConfig { seed, ..self.training.clone() };
        let mut trainer = StreamTrainer::new(emulator.surrogate.clone(), config)?;
        let batch = |index: u64| -> Result<Result<GeometryBatch>> {
            let body = draw(index)?;
            Ok(self.batch(&body, &template, seed, index))
        };
        std::thread::scope(|scope| {
            // Bodies are prepared in order on a separate thread. It ends when the receiver is dropped.
            let (send, batches) = sync_channel(2 * self.bodies.max(1));
            scope.spawn(move || {
                let all = || (0..).try_for_each(|index| send.send(batch(index)).ok());
                // A separate pool, so that preparation does not wait for training.
                match ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
                    Ok(pool) => pool.install(all),
                    Err(_) => all(),
                }
            });
            let (mut seconds, mut evaluated, mut losses, mut left_out) = (0.0, 0, Vec::new(), 0);
            loop {
                let start = Instant::now();
                let share = match self.training.budget {
                    Budget::Steps(steps) => trainer.steps() as f64 / steps as f64,
                    Budget::Seconds(budget) => seconds / budget,
                };
                let due = (share * self.training.evaluations as f64) as usize;
                if due > evaluated || share >= 1.0 {
                    evaluated = due;
                    emulator.surrogate = trainer.surrogate();
                    losses.retain(|loss: &f64| loss.is_finite());
                    let loss = losses.iter().sum::<f64>() / losses.len().max(1) as f64;
                    losses.clear();
                    let step = trainer.steps();
                    let progress = StreamProgress { step, share, seconds, loss, left_out };
                    if observe(progress, &emulator)?.is_break() || share >= 1.0 {
                        return Ok(emulator);
                    }
                    continue;
                }
                let (prepared, refused) = prepared(&batches, self.bodies.max(1))?;
                left_out += refused;
                losses.push(trainer.step(&prepared, share)?);
                seconds += start.elapsed().as_secs_f64();
            }
        })
    }

    fn untrained(&self, bodies: &[Body], seed: u64) -> Result<PopulationEmulator> {
        let template = Template::new(bodies, self.start, seed)?;
        let prepared = bodies.iter().map(|body| self.geometry(body, &template, seed));
        // Some have no equilibrium.
        let (prepared, refused): (Vec<_>, Vec<_>) = prepared.partition(Result::is_ok);
        let geometries: Vec<Geometry> =
            prepared.into_iter().flatten().map(|(geometry, ..)| geometry).collect();
        if let (true, Some(refused)) = (geometries.is_empty(), refused.into_iter().next()) {
            refused?;
        }
        let body = &bodies[0];
        let sizes = self.network.on(&geometries[0], body.parameters.len());
        let output = OutputScale::root_mean_square(3, geometries.iter().map(stream::origin))?;
        let scales = Scales::over(&geometries, scaling(body)?, output)?;
        let data = DataSet {
            geometries: vec![geometries[0].clone()],
            training: Vec::new(),
            validation: Vec::new(),
        };
        let device = Backend::default().device()?;
        let surrogate = Surrogate::new(&sizes, &data, scales, seed, &device)?;
        Ok(PopulationEmulator { recipe: self.clone(), seed, surrogate, template })
    }
}

/// Lessons of a step, and how many bodies before them could not be prepared.
fn prepared(
    batches: &Receiver<Result<Result<GeometryBatch>>>,
    count: usize,
) -> Result<(Vec<GeometryBatch>, usize)> {
    /// Bodies in a row that may fail before all of them count as wrong.
    const MOST_REFUSED: usize = 20;
    let (mut prepared, mut refused, mut in_a_row) = (Vec::with_capacity(count), 0, 0);
    for batch in batches {
        match batch? {
            Ok(batch) => {
                prepared.push(batch);
                in_a_row = 0;
            }
            Err(error) if in_a_row == MOST_REFUSED => return Err(error),
            Err(_) => (refused, in_a_row) = (refused + 1, in_a_row + 1),
        }
        if prepared.len() == count {
            break;
        }
    }
    Ok((prepared, refused))
}
