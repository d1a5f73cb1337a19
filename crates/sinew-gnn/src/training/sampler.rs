//! Batches in shuffled epochs.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::data::Sample;

/// Draws batches of one geometry each, every sample once per epoch. The samples of a geometry are
/// divided into batches that differ by at most one in size.
#[derive(Debug, Clone)]
pub(crate) struct Sampler {
    by_geometry: Vec<Vec<usize>>,
    batch: usize,
    state: SamplerState,
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

    pub(super) fn state(&self) -> &SamplerState {
        &self.state
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

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(geometries: &[usize]) -> Vec<Sample> {
        let sample = |&geometry| Sample { geometry, theta: vec![], displacement: vec![] };
        geometries.iter().map(sample).collect()
    }

    #[test]
    fn an_epoch_holds_every_sample_once_and_no_batch_mixes_geometries() {
        let samples = samples(&[0, 1, 0, 0, 1, 0, 0, 0, 1, 2]);
        let mut sampler = Sampler::new(&samples, 3, 4, 5);
        for _ in 0..3 {
            let mut seen = Vec::new();
            for _ in 0..4 {
                let batch = sampler.draw().to_vec();
                assert!(batch.len() <= 4);
                assert!(batch.iter().all(|&i| samples[i].geometry == samples[batch[0]].geometry));
                seen.extend(batch);
            }
            seen.sort_unstable();
            assert_eq!(seen, (0..10).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_resumed_sampler_continues_exactly() {
        let samples = samples(&[0; 23]);
        let mut one = Sampler::new(&samples, 1, 5, 9);
        let first: Vec<Vec<usize>> = (0..5).map(|_| one.draw().to_vec()).collect();
        for _ in 0..8 {
            let json = serde_json::to_string(one.state()).unwrap();
            let state = serde_json::from_str(&json).unwrap();
            let mut other = Sampler::resume(&samples, 1, 5, state);
            assert_eq!(one.draw(), other.draw());
        }
        let second: Vec<Vec<usize>> = (0..2).map(|_| one.draw().to_vec()).collect();
        assert_ne!(first[..2], second[..], "epochs repeat their order");
    }
}
