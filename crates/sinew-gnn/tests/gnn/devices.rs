//! Networks on every kind of device that this build and this machine have.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{Budget, TrainingOptions};
use sinew_gnn::recipe::PhysicsInformed;
use sinew_gnn::{Backend, Error, Network, OutputCoordinates, Recipe};
use std::io::Write;

#[test]
fn backends_are_read_and_a_missing_one_says_how_to_get_it() {
    for backend in Backend::ALL {
        assert_eq!(backend.to_string().parse(), Ok(backend));
        match backend.device() {
            Err(Error::NoDevice(name)) => assert_eq!(name, backend.to_string()),
            Err(error) => assert!(error.to_string().contains("--features"), "{error}"),
            Ok(_) => {}
        }
    }
    assert!(Backend::Flex.device().is_ok());
    assert!("gpu".parse::<Backend>().unwrap_err().contains("flex, ndarray, wgpu, cuda"));
}

/// Trains with the same seed on the processor and on every other device. Rounding differs, so that the trainings drift apart;
/// over some steps by little.
#[test]
fn a_training_goes_the_same_way_on_every_device() {
    const APART: f64 = 2e-3;
    let body = beam(1.0);
    let defaults = PhysicsInformed::default();
    let recipe = Recipe::from(PhysicsInformed {
        parameter_sets: 16,
        coordinates: OutputCoordinates::Motions,
        network: Network { message_passing_steps: 2, ..small_network() },
        training: steps(&defaults.training, 12),
    });
    let train = |backend: Backend| {
        let options = TrainingOptions {
            budget: Budget::Effort(1.0),
            held_out: 2,
            evaluations: 1,
            backend: backend.to_string(),
            ..TrainingOptions::default()
        };
        recipe.train(&body, &options, &mut ()).unwrap().predict(&[body.centre()]).unwrap()
    };
    let expected = train(Backend::Flex).displacement;
    let size = expected.iter().fold(0f64, |most, u| most.max(u.abs()));
    assert!(size > 0.0, "nothing was learned");
    for backend in Backend::ALL {
        if let Err(reason) = backend.device() {
            // Written past the harness, which hides what tests that pass print.
            let _ = writeln!(std::io::stderr(), "NOT TESTED on {backend}: {reason}");
            continue;
        }
        let found = train(backend).displacement;
        let apart = found.iter().zip(&expected).fold(0f64, |most, (a, b)| most.max((a - b).abs()));
        let _ = writeln!(std::io::stderr(), "tested on {backend}: {:.1e} apart", apart / size);
        assert!(apart <= APART * size, "{backend}: {apart:e} of {size:e}");
    }
}
