//! Cases of the experiments, one data set each.

use clap::ValueEnum;
use sinew_studies::gp::experiment::{Case, Scale, Task, derived};
use sinew_studies::gp::experiments::Name;
use sinew_studies::gp::row::{Method, Run};

#[test]
fn names_of_cases_are_unique() {
    for quick in [false, true] {
        for name in Name::value_variants() {
            let experiment = name.experiment(Scale { quick }).unwrap();
            let mut keys: Vec<String> = experiment.cases.iter().map(|case| case.key()).collect();
            let count = keys.len();
            keys.sort();
            keys.dedup();
            assert_eq!(keys.len(), count, "{}", name.key());
        }
    }
}

/// The cases of a method in a full run.
fn cases(name: Name, method: Method) -> impl DoubleEndedIterator<Item = Case> {
    let cases = name.experiment(Scale { quick: false }).unwrap().cases.into_iter();
    cases.filter(move |case| case.label.method == method)
}

/// The first data set of a case.
fn run(case: &Case) -> Run {
    (case.run)(&Task { seed: derived(1, 0), draw: false }).unwrap()
}

/// Families of exact solutions hold the truth, and their least squares find it from starts that are off by a third.
#[test]
fn least_squares_find_the_parameters_behind_noisy_values() {
    // Twice the largest errors of u and of θ over twenty data sets.
    let all = [
        (Name::Heat2, [1.6e-3, 1.8e-2]),
        (Name::Wave1, [6.1e-3, 2.9e-2]),
        (Name::AdvectionDiffusion, [2.5e-2, 2.0e-2]),
    ];
    for (name, [most_u, most_theta]) in all {
        let cases: Vec<Case> = cases(name, Method::LeastSquares).collect();
        assert!(!cases.is_empty());
        for case in cases {
            let (run, truth) = (run(&case), &case.label.truth);
            let pairs = run.theta.iter().zip(truth);
            let off = pairs.map(|(found, truth)| (found - truth.value).powi(2)).sum::<f64>().sqrt();
            assert!(run.err_u < most_u && off < most_theta, "{}: {run:?}", case.key());
            assert_eq!(run.theta.len(), truth.len());
        }
    }
}

/// Slopes of all losses are exact, and the conditions are met exactly.
#[test]
fn trainings_end_at_the_solution() {
    // Five times the largest errors over twenty data sets.
    let all = [
        (Name::Pinn, Method::StrongForm, 1.1e-5),
        (Name::Pinn, Method::EnergyForm, 3.1e-5),
        (Name::Poisson1, Method::Hcnn, 6.7e-7),
    ];
    for (name, method, most) in all {
        // Of the networks with conditions built in, the one with the most collocation points.
        let case = cases(name, method).next_back().unwrap();
        let run = run(&case);
        assert!(run.err_u < most, "{}: {:e}", case.key(), run.err_u);
    }
}
