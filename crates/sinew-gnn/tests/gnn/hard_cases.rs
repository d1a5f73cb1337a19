//! Trainings that go wrong, and must say so.

use std::sync::Arc;

use crate::common::*;
use sinew_emulate::coordinates::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Barriers, Load, Parameter, Sampling, Scene, Support};
use sinew_gnn::*;

/// Trained stiffnesses [kPa].
const RANGE: [f64; 2] = [50.0, 100.0];

/// A short neo-Hookean cantilever under its weight, without simulations.
struct Cantilever {
    potential: sinew_energy::Body,
    data: DataSet,
}

fn cantilever() -> Cantilever {
    let size = [40.0, 10.0, 10.0];
    let mesh = sinew_mesh::box_tetrahedra(size, [4, 2, 2]);
    let parameter = |name: &str| Parameter {
        name: name.to_string(),
        unit: "kPa".into(),
        range: RANGE,
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "cantilever".to_string(),
        supports: vec![Support::clamped("x_min")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        parameters: vec![parameter("mu"), parameter("lambda")],
        ..Scene::new(mesh, NeoHookean)
    };
    let potential = scene.lower().unwrap();
    let body = beam_of(size, [4, 2, 2], vec![7, 3]);
    let sample = |[a, b]: [f64; 2]| Sample {
        geometry: 0,
        theta: vec![50.0 * 2f64.powf(a), 50.0 * 2f64.powf(b)],
        displacement: vec![],
    };
    let fractions = (0..12).map(|i| [(f64::from(i) + 0.5) / 12.0, (f64::from(i) * 0.618).fract()]);
    let data = DataSet {
        geometries: vec![body.rest()],
        training: fractions.map(sample).collect(),
        validation: vec![],
    };
    Cantilever { potential, data }
}

impl Cantilever {
    /// A trainer by minimum potential energy that begins from a shift of all free nodes by `shift` along the beam [mm].
    fn trainer(&self, barriers: Option<Barriers>, shift: f64, config: TrainingConfig) -> Trainer {
        let plain = self.potential.clone();
        let potential = match barriers {
            Some(barriers) => plain.with_barriers(barriers),
            None => plain,
        };
        let energy = 1e-3 * self.potential.volumes.iter().sum::<f64>();
        let objective = MinimumPotential::new(vec![Arc::new(potential)], energy).unwrap();
        let output = OutputScale { mean: vec![shift, 0.0, 0.0], scale: vec![1.0; 3] };
        let parameters = ParameterScaling::logarithmic(&[RANGE[0]; 2], &[RANGE[1]; 2]).unwrap();
        let scales = Scales::over(&self.data.geometries, parameters, output).unwrap();
        let network = small_config(&self.data, 3);
        let surrogate = Surrogate::new(&network, &self.data, scales, 1, &devices()[0]).unwrap();
        Trainer::new(surrogate, self.data.clone(), Box::new(objective), config).unwrap()
    }

    /// Number of predictions at the parameters of the training that invert no cell.
    fn admitted(&self, surrogate: &Surrogate) -> usize {
        let thetas: Vec<Vec<f64>> = self.data.training.iter().map(|s| s.theta.clone()).collect();
        let prediction = surrogate.predict(&self.data.geometries[0], &thetas).unwrap();
        (0..thetas.len()).filter(|&case| self.potential.admits(&prediction[case])).count()
    }
}

fn config(steps: usize, learning_rate: f64) -> TrainingConfig {
    TrainingConfig {
        budget: TrainingBudget::Steps(steps),
        batch: 4,
        evaluations: 8,
        learning_rate,
        ..TrainingConfig::default()
    }
}

#[derive(Default)]
struct Listener {
    concerns: Vec<Concern>,
}

impl TrainingObserver for Listener {
    fn concern(&mut self, concern: &Concern) {
        self.concerns.push(*concern);
    }
}

#[test]
fn a_training_that_goes_well_raises_no_concern() {
    let mut listener = Listener::default();
    let mut trainer = cantilever().trainer(Some(Barriers::default()), 0.0, config(200, 4e-3));
    let report = trainer.run(&mut listener).unwrap();
    assert_eq!((report.concerns, listener.concerns), (vec![], vec![]), "{:?}", report.history);
}

/// Barriers leave a finite energy to every state, and weight pulls it down for ever: a falling loss proves nothing.
#[test]
fn learning_rates_that_are_too_high_are_reported() {
    let body = cantilever();
    for optimiser in [OptimiserConfig::default(), OptimiserConfig::adam()] {
        for learning_rate in [1.0, 1e3, 1e30] {
            let config =
                TrainingConfig { optimiser: optimiser.clone(), ..config(80, learning_rate) };
            let mut listener = Listener::default();
            let outcome = body.trainer(Some(Barriers::default()), 0.0, config).run(&mut listener);
            match outcome {
                Ok(report) => {
                    assert_ne!(
                        report.concerns,
                        [],
                        "{optimiser:?} {learning_rate}: {:?}",
                        report.history
                    );
                    assert_ne!(listener.concerns, []);
                }
                Err(error) => assert!(
                    matches!(error, Error::Diverged { .. } | Error::InvertedCells { .. }),
                    "{error}"
                ),
            }
        }
    }
}

#[test]
fn data_fits_report_learning_rates_that_are_too_high() {
    let (_, data) = plane_data();
    // From rates of some hundreds smaller steps from the best weights still recover.
    for learning_rate in [1e3, 1e4, 1e6] {
        let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
        let objective = data_fit(&surrogate);
        let config = config(80, learning_rate);
        let outcome =
            Trainer::new(surrogate, data.clone(), objective, config).unwrap().run(&mut ());
        match outcome {
            Ok(report) => assert!(
                matches!(report.concerns[..], [Concern::NothingLearned { .. }]),
                "{learning_rate}: {report:?}"
            ),
            Err(error) => assert!(matches!(error, Error::Diverged { .. }), "{error}"),
        }
    }
}

#[test]
fn a_start_with_inverted_cells_recovers_under_barriers() {
    let body = cantilever();
    // Cells next to the support are ten millimetres long.
    let mut trainer = body.trainer(Some(Barriers::default()), -12.0, config(400, 1e-2));
    assert_eq!(body.admitted(trainer.surrogate()), 0);
    let report = trainer.run(&mut ()).unwrap();
    assert_eq!((body.admitted(trainer.surrogate()), report.concerns), (12, vec![]));
}

#[test]
fn a_start_that_barriers_cannot_save_is_reported() {
    let body = cantilever();
    let mut trainer = body.trainer(Some(Barriers::default()), -200.0, config(40, 4e-3));
    let report = trainer.run(&mut ()).unwrap();
    let all = Concern::Inadmissible { inadmissible: 12, samples: 12 };
    assert!(report.concerns.contains(&all), "{report:?}");
    assert_eq!(body.admitted(trainer.surrogate()), 0);
}

#[test]
fn a_start_with_inverted_cells_is_an_error_without_barriers() {
    let mut trainer = cantilever().trainer(None, -12.0, config(40, 4e-3));
    let error = trainer.run(&mut ()).unwrap_err();
    let expected = Error::InvertedCells { step: 1, inadmissible: 4, samples: 4 };
    assert_eq!(error.to_string(), expected.to_string());
}

#[test]
fn parameters_in_wrong_units_are_refused() {
    let (_, data) = plane_data();
    let surrogate = untrained(&data, &small_config(&data, 2), 1, &devices()[0]);
    for (of_training, index) in [(true, 3), (false, data.training.len() + 2)] {
        let mut data = data.clone();
        let sample = if of_training { &mut data.training[3] } else { &mut data.validation[2] };
        sample.theta[1] *= 10.0;
        let value = sample.theta[1];
        let objective = data_fit(&surrogate);
        let refused = Trainer::new(surrogate.clone(), data, objective, config(1, 1e-3)).err();
        let expected = format!(
            "parameter 1 of sample {index} is {value}, outside its range [0.5, 2]; check the units, or widen the range"
        );
        assert_eq!(refused.map(|error| error.to_string()), Some(expected));
    }
    // A prediction there is made.
    assert!(surrogate.predict(&data.geometries[0], &[vec![1.0, 10.0]]).is_ok());
}
