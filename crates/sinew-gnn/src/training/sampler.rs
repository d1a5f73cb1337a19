//! Batches in shuffled epochs.

use crate::data::Sample;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Draws batches of one geometry each, every sample once per epoch. The samples of a geometry are
/// divided into batches that differ by at most one in size.
pub(crate) struct Sampler {
    by_geometry: Vec<Vec<usize>>,
    batch: usize,
    pub(super) state: SamplerState,
    epoch: Vec<Vec<usize>>,
}

/// State from which a sampler continues exactly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SamplerState {
    /// Generator as it was before the current epoch was shuffled.
    before_epoch: ChaCha8Rng,
    /// Batches of the current epoch already drawn.
    drawn: usize,
}

impl Sampler {
    pub(super) fn new(samples: &[Sample], geometries: usize, batch: usize, seed: u64) -> Self {
        let state = SamplerState { before_epoch: ChaCha8Rng::seed_from_u64(seed), drawn: 0 };
        Self::resume(samples, geometries, batch, state)
    }

    pub(super) fn resume(
        samples: &[Sample],
        geometries: usize,
        batch: usize,
        state: SamplerState,
    ) -> Self {
        let mut by_geometry = vec![Vec::new(); geometries];
        for (index, sample) in samples.iter().enumerate() {
            by_geometry[sample.geometry].push(index);
        }
        let mut sampler = Self { by_geometry, batch, state, epoch: Vec::new() };
        sampler.epoch = sampler.shuffled(&mut sampler.state.before_epoch.clone());
        sampler
    }

    /// Indices of the next batch, of one geometry.
    pub(super) fn draw(&mut self) -> &[usize] {
        if self.state.drawn == self.epoch.len() {
            let mut random = self.state.before_epoch.clone();
            self.shuffled(&mut random);
            self.epoch = self.shuffled(&mut random.clone());
            self.state = SamplerState { before_epoch: random, drawn: 0 };
        }
        self.state.drawn += 1;
        &self.epoch[self.state.drawn - 1]
    }

    fn shuffled(&self, random: &mut ChaCha8Rng) -> Vec<Vec<usize>> {
        let mut batches = Vec::new();
        for samples in self.by_geometry.iter().filter(|samples| !samples.is_empty()) {
            let mut samples = samples.clone();
            samples.shuffle(random);
            let (count, parts) = (samples.len(), samples.len().div_ceil(self.batch));
            let bound = |part: usize| part * count / parts;
            batches.extend((0..parts).map(|part| samples[bound(part)..bound(part + 1)].to_vec()));
        }
        batches.shuffle(random);
        batches
    }
}
