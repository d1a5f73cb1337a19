//! Emulators against the solver that shares their energy. The bounds are three times what was measured.

mod support;

use sinew_emulate::coordinates::OutputScale;
use sinew_energy::{Barriers, metrics::displacement_error};
use sinew_fem::{Solution, Solver};
use sinew_gnn::{
    DataFit, FixedGeometry, MinimumPotential, Surrogate, TrainingBudget, TrainingConfig,
};
use std::sync::Arc;
use support::{Beam, centre, grid, norm};

/// Settings that train in a second.
fn settings(steps: usize) -> TrainingConfig {
    TrainingConfig {
        budget: TrainingBudget::Steps(steps),
        seed: 1,
        evaluations: 1,
        ..Default::default()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean nodal distance of `fields` from the solutions, relative to the mean nodal displacement.
fn relative_error<'a>(solutions: &[Solution], fields: impl IntoIterator<Item = &'a [f64]>) -> f64 {
    let (mut errors, mut motions) = (Vec::new(), Vec::new());
    for (solution, field) in solutions.iter().zip(fields) {
        errors.extend(displacement_error(&solution.displacement, field));
        motions.extend(displacement_error(&solution.displacement, &vec![0.0; field.len()]));
    }
    mean(&errors) / mean(&motions)
}

/// Energy of the predictions above the minimum, relative to its depth.
fn energy_excess(beam: &Beam, surrogate: &Surrogate, solutions: &[Solution]) -> Vec<f64> {
    let excess = |solution: &Solution| {
        let theta = std::slice::from_ref(&solution.theta);
        let field = surrogate.predict(&beam.geometry, theta).unwrap().concat();
        for (u, fixed) in field.iter().zip(&beam.potential.prescribed) {
            assert!(fixed.is_none_or(|value| value == *u), "the support moved by {u} mm");
        }
        (beam.potential.value(&field, &solution.theta) - solution.energy) / solution.energy.abs()
    };
    solutions.iter().map(excess).collect()
}

#[test]
fn training_on_energy_alone_approaches_the_minimum_from_above() {
    let beam = Beam::new();
    let response = beam.linear_response(&centre());
    let potential = Arc::new(beam.potential.clone().with_barriers(Barriers::default()));
    let energy =
        MinimumPotential::energy_of_linear_response(&*potential, &response, &centre()).unwrap();
    let objective = MinimumPotential::new(vec![potential], energy).unwrap();
    let output = OutputScale::root_mean_square(3, [&response[..]]).unwrap();
    let mut trainer = beam.trainer(&grid(6), &[], output, Box::new(objective), settings(1500));

    // Solutions for other parameters, corners of the range included: the yardstick, not data.
    let solutions = beam.solve(&grid(4));
    let untrained = energy_excess(&beam, &trainer.current_surrogate(), &solutions);
    assert!(untrained.iter().all(|&excess| excess > 0.5), "{untrained:?}");
    trainer.run(&mut ()).unwrap();
    let trained = energy_excess(&beam, trainer.surrogate(), &solutions);
    println!("energy above the minimum, relative: {trained:.4?}");
    // No admissible displacement has less energy than the stable equilibrium.
    assert!(trained.iter().all(|&excess| excess > 0.0), "{trained:?}");
    assert!(trained.iter().all(|&excess| excess < 4e-3) && mean(&trained) < 1.2e-3, "{trained:?}");

    let prediction = trainer.surrogate().predict(&beam.geometry, &grid(4)).unwrap();
    let error = relative_error(&solutions, prediction.iter().map(Vec::as_slice));
    println!("displacement error, relative: {error:.1e}");
    assert!(error < 0.035, "{error}");
}

#[test]
fn training_on_simulations_reaches_the_solver_and_its_derivatives() {
    let beam = Beam::new();
    let thetas = grid(5);
    let fields: Vec<_> = beam.solve(&thetas).into_iter().map(|s| s.displacement).collect();
    // Per degree of freedom.
    let fields_of = fields.iter().map(Vec::as_slice);
    let output = OutputScale::standardising(fields[0].len(), fields_of).unwrap();
    let mean_field = output.mean.clone();
    let objective = DataFit::new(output.length()).unwrap();
    let mut trainer = beam.trainer(&thetas, &fields, output, Box::new(objective), settings(400));
    trainer.run(&mut ()).unwrap();
    let surrogate = trainer.into_surrogate();

    let unseen = grid(4);
    let solutions = beam.solve(&unseen);
    let prediction = surrogate.predict(&beam.geometry, &unseen).unwrap();
    let error = relative_error(&solutions, prediction.iter().map(Vec::as_slice));
    let of_mean = relative_error(&solutions, std::iter::repeat_n(&mean_field[..], unseen.len()));
    println!("displacement error, relative: {error:.1e}; of the mean field: {of_mean:.1e}");
    assert!(error < 0.016 && error < 0.1 * of_mean, "{error} {of_mean}");

    let fixed = surrogate.fixed_geometry(&beam.geometry).unwrap();
    check_derivatives(&beam, &fixed, &solutions);
}

/// `∂û/∂θ` against differences of predictions, and over all cases against the solver's `∂u/∂θ`.
fn check_derivatives(beam: &Beam, fixed: &FixedGeometry, solutions: &[Solution]) {
    /// [kPa]: differences in single precision are then good to a few parts in a thousand.
    const STEP: f64 = 0.05;
    let mut solver = Solver::new(&beam.potential).unwrap();
    for parameter in 0..2 {
        let (mut distance, mut size) = (Vec::new(), Vec::new());
        for solution in solutions {
            let theta = &solution.theta;
            let emulated = &fixed.sensitivity(theta).unwrap()[parameter];
            let shifted = |step: f64| {
                let mut theta = solution.theta.clone();
                theta[parameter] += step;
                fixed.predict(&[theta]).unwrap().concat()
            };
            let (ahead, behind) = (shifted(STEP), shifted(-STEP));
            let difference = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * STEP));
            let misfit = norm(difference.zip(emulated).map(|(d, e)| d - e));
            let relative = misfit / norm(emulated.iter().copied());
            assert!(relative < 0.015, "{theta:?}: {relative:e}");

            let exact = &solver.sensitivity(solution).unwrap()[parameter];
            distance.extend(exact.iter().zip(emulated).map(|(d, e)| d - e));
            size.extend(exact);
        }
        let relative = norm(distance) / norm(size);
        println!("derivative in theta[{parameter}] against the solver's, relative: {relative:.1e}");
        assert!(relative < 0.5, "theta[{parameter}]: {relative}");
    }
}
