//! Batches that a training draws.

use crate::common::*;
use burn::tensor::Tensor;
use sinew_gnn::*;
use std::sync::{Arc, Mutex};

/// Geometry of a batch, and first parameter of each of its samples.
type Drawn = (usize, Vec<f64>);

/// Keeps all batches.
struct Recorder {
    fit: Box<dyn Objective>,
    batches: Arc<Mutex<Vec<Drawn>>>,
}

impl Objective for Recorder {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.fit.check(data)
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let thetas = samples.iter().map(|sample| sample.theta[0]).collect();
        self.batches.lock().unwrap().push((samples[0].geometry, thetas));
        self.fit.loss(samples, displacement)
    }
}

#[test]
fn an_epoch_holds_every_sample_once_and_no_batch_mixes_geometries() {
    const LARGEST: usize = 4;
    const EPOCH: usize = 4;
    let (body, mut data) = plane_data();
    data.geometries.push(body.geometry(vec![80.0, 10.0], |x| [2.0 * x[0], x[1], x[2]]));
    let of_samples = [0, 1, 0, 0, 1, 0, 0, 0, 1, 2];
    let thetas = thetas(of_samples.len());
    let samples = of_samples.iter().zip(&thetas);
    data.training = samples.map(|(geometry, theta)| body.sample(*geometry, *theta, 1.0)).collect();
    data.validation.clear();

    let batches = Arc::new(Mutex::new(Vec::new()));
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    let objective = Recorder { fit: data_fit(&surrogate), batches: batches.clone() };
    let config = TrainingConfig {
        budget: TrainingBudget::Steps(3 * EPOCH),
        batch: LARGEST,
        seed: 5,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data, Box::new(objective), config).unwrap();
    for _ in 0..3 * EPOCH {
        trainer.step().unwrap();
    }

    let sample = |theta: &f64| thetas.iter().position(|other| other[0] == *theta).unwrap();
    let batches = batches.lock().unwrap();
    let drawn: Vec<Vec<usize>> =
        batches.iter().map(|(_, thetas)| thetas.iter().map(sample).collect()).collect();
    for ((geometry, _), batch) in batches.iter().zip(&drawn) {
        assert!(batch.len() <= LARGEST);
        assert!(batch.iter().all(|&sample| of_samples[sample] == *geometry));
    }
    let epochs: Vec<_> = drawn.chunks(EPOCH).collect();
    assert_eq!(epochs.len(), 3);
    for epoch in &epochs {
        let mut seen = epoch.concat();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..of_samples.len()));
    }
    assert_ne!(epochs[0], epochs[1], "epochs repeat their order");
}
