//! Diagnosis of the weights that a training leaves.

use crate::{Concern, HistoryPoint, Result, Trainer};

/// Standard deviations of a mean loss that count as noise of the drawn samples: the lowest of twenty means of about six
/// batches is easily off by four.
const NOISE: f64 = 5.0;

/// Most geometries that an evaluation looks at: message passing on one costs a third of a step.
const GEOMETRIES: usize = 32;

/// Concern about the losses of a run, beyond their noise. `exact`, the loss of all samples after the last step, has no
/// noise. A loss of zero outputs that is not finite raises none.
fn of_losses(history: &[HistoryPoint], of_zero_output: f64, exact: Option<f64>) -> Option<Concern> {
    let last = history.last()?;
    let (loss, deviation) = exact.map_or((last.loss, last.deviation), |exact| (exact, 0.0));
    if !of_zero_output.is_finite() {
        return None;
    }
    if loss - NOISE * deviation >= of_zero_output {
        return Some(Concern::NothingLearned { loss, of_zero_output });
    }
    let lowest = history.iter().min_by(|a, b| a.loss.total_cmp(&b.loss))?;
    let lost = (loss - lowest.loss) / (of_zero_output - lowest.loss);
    let certain = loss - lowest.loss > NOISE * deviation.hypot(lowest.deviation);
    let rose = lost > 0.5 && certain;
    rose.then_some(Concern::LossRose { lowest: lowest.loss, step: lowest.step, loss })
}

impl Trainer {
    /// Concerns about the weights. Before the training is `over`: those of the latest evaluation, from one batch per geometry, of at
    /// most 32 geometries. After it: the kept ones, from all parameters of the training.
    pub(super) fn concerns(&mut self, over: bool) -> Result<Vec<Concern>> {
        let of_zero_output = match self.loss_of_zero_output {
            Some(loss) => loss,
            None => *self.loss_of_zero_output.insert(self.zero_output_loss()?),
        };
        let (inadmissible, loss) = self.of_states(over)?;
        let history = &self.progress.history;
        // Evaluations after the kept weights do not count.
        let kept = self.best.as_ref().filter(|_| over).map(|(best, _)| best.step);
        let until = history.partition_point(|point| kept.is_none_or(|step| point.step <= step));
        let of_losses = of_losses(&history[..until], of_zero_output, over.then_some(loss));
        Ok(of_losses.into_iter().chain(inadmissible).collect())
    }

    /// Mean loss over the training samples without the network's outputs.
    fn zero_output_loss(&self) -> Result<f64> {
        self.mean_loss(&self.batches(&self.data.training), |samples| {
            let output = &self.surrogate.prepared[samples[0].geometry].output;
            Ok(output.without_network(&self.surrogate.parameters_of(samples)?))
        })
    }

    /// Concern about predictions, and their mean loss.
    fn of_states(&self, over: bool) -> Result<(Option<Concern>, f64)> {
        let mut batches = self.batches(&self.data.training);
        if !over {
            batches.dedup_by_key(|samples| samples[0].geometry);
            let apart = batches.len().div_ceil(GEOMETRIES).max(1);
            batches = batches.into_iter().step_by(apart).collect();
        }
        let (mut predictions, mut inadmissible) = (self.predictions(), 0);
        let loss = self.mean_loss(&batches, |samples| {
            let displacement = predictions(samples)?;
            inadmissible += self.objective.inadmissible(samples, displacement.clone());
            Ok(displacement)
        })?;
        let samples = batches.iter().map(Vec::len).sum();
        let concern = (inadmissible > 0).then_some(Concern::Inadmissible { inadmissible, samples });
        Ok((concern, loss))
    }
}
