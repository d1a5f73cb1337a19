//! Simulations: which of several equilibria, and runs that were stopped.

use sinew_emulate::{
    Body, Design, Error, MOST_COMPARED, Observer, Progress, Simulations, central_differences,
    simulate, simulate_by,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::{LoadSteps, Options, Solver, sweep};
use sinew_mesh::box_tetrahedra;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A bar that bends under its weight.
pub(crate) fn short_bar() -> Body {
    Scene::new(box_tetrahedra([40.0, 8.0, 8.0], [4, 1, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

/// A straight column stays straight beyond its Euler load, by a rising load too.
#[test]
fn unstable_solutions_are_named() {
    let body = Scene::new(box_tetrahedra([40.0, 2.0, 2.0], [5, 1, 1]).quadratic(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=1000.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=1000.0))
        .load(Load::Traction { facets: "x_max".into(), value: [-0.3, 0.0, 0.0] })
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    let thetas = [vec![50.0, 50.0]];
    let options = Options { load_steps: LoadSteps::Always, ..Options::default() };
    let found = simulate_by(&body, &thetas, "test", None, &options, &mut ()).unwrap();
    assert_eq!((found.fields.len(), &found.unstable[..]), (1, &thetas[..]));
}

#[test]
fn solutions_that_a_rising_load_does_not_lead_to_are_named() {
    // Columns that are pushed along their axis and a little across, beyond the load at which they buckle.
    let column = |push: f64, across: f64| {
        let value = [-push, 0.0, across * push];
        Scene::new(box_tetrahedra([20.0, 1.0, 1.0], [20, 2, 2]), NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 0.5..=8.0))
            .parameter(Parameter::log("lambda", "kPa", 0.5..=8.0))
            .load(Load::Traction { facets: "x_max".into(), value })
            .support(Support::clamped("x_min"))
            .lower()
            .unwrap()
    };
    let thetas: Vec<Vec<f64>> = (0..7).map(|i| vec![1.0, 1.0 + 0.01 * f64::from(i)]).collect();
    let mut open = 0;
    for body in [column(0.0075, 1e-4), column(0.0025, 1e-3)] {
        let found = simulate(&body, &thetas, "test", None, &mut ()).unwrap();
        assert_eq!(found.fields.len(), thetas.len());
        let swept = sweep(&body, &thetas, &Options::default(), || ()).unwrap();
        let jumped: Vec<usize> =
            (0..swept.len()).filter(|&case| swept[case].as_ref().is_ok_and(|s| s.jumped)).collect();
        let (compared, rest) = jumped.split_at(MOST_COMPARED.min(jumped.len()));
        let mut solver = Solver::new(&body).unwrap();
        let is_other = |case: &&usize| {
            let (field, theta) = (&found.fields[**case], &thetas[**case]);
            let solution = solver.solve_from(field, theta, &Options::default()).unwrap();
            solver.under_rising_load(&solution, &Options::default(), &mut |_| ()).unwrap().is_some()
        };
        let of = |cases: &[usize]| -> Vec<Vec<f64>> {
            cases.iter().map(|&case| thetas[case].clone()).collect()
        };
        let others: Vec<usize> = compared.iter().filter(is_other).copied().collect();
        assert_eq!((&found.branched, found.compared), (&of(&others), compared.len()));
        // Those that are not compared stay open.
        assert_eq!(found.jumped, of(&[&others[..], rest].concat()));
        open += rest.len();
    }
    assert!(open > 0, "no search met an indefinite stiffness");
}

/// Breaks after some solves; whether something was stored within a hundred samples at each of them.
struct Breaks {
    after: usize,
    under_way: PathBuf,
    stored: Vec<bool>,
}

impl Breaks {
    fn after(solves: usize, folder: &Path) -> Self {
        Self { after: solves, under_way: folder.join("under-way"), stored: Vec::new() }
    }
}

impl Observer for Breaks {
    fn progress(&mut self, _: &Progress<'_>) -> ControlFlow<()> {
        self.stored.push(self.under_way.exists());
        let breaks = self.stored.len() >= self.after;
        if breaks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn a_block_that_was_stopped_gives_the_numbers_of_one_that_was_not() {
    let (body, folder) = (short_bar(), tempfile::tempdir().unwrap());
    let mut thetas = Design::Sobol.sample(&body.parameters, 130, 1).unwrap();
    // One without an equilibrium, which is not tried again.
    thetas[3][0] = -1.0;
    let whole = simulate(&body, &thetas, "test", None, &mut ()).unwrap();
    assert_eq!(whole.failures.len(), 1);
    let mut solves = 0;
    // Stopped three times, once within the second hundred; each time solves that are under way end.
    for after in [20, 30, 60, usize::MAX] {
        let mut observer = Breaks::after(after, folder.path());
        let found = simulate(&body, &thetas, "test", Some(folder.path()), &mut observer);
        solves += observer.stored.len();
        let under_way = observer.under_way.exists();
        match found {
            Ok(found) => {
                assert!(after == usize::MAX && !under_way);
                assert_eq!((&found.thetas, &found.failures), (&whole.thetas, &whole.failures));
                assert_eq!(found.solve_seconds.len(), whole.fields.len());
                assert_eq!(found.fields, whole.fields);
            }
            Err(error) => {
                assert!(after < usize::MAX && under_way, "{after}: {error}");
                assert!(matches!(error, Error::Interrupted { .. }), "{error}");
            }
        }
    }
    // Chains of neighbours that were finished are kept.
    assert!(solves < 2 * thetas.len(), "{solves}");
}

#[test]
fn a_run_that_was_killed_while_it_stored_goes_on_from_what_its_log_counts() {
    let (body, folder) = (short_bar(), tempfile::tempdir().unwrap());
    let thetas = Design::Sobol.sample(&body.parameters, 8, 1).unwrap();
    let solved = |thetas: &[Vec<f64>], observer: &mut dyn Observer| {
        simulate(&body, thetas, "test", Some(folder.path()), observer)
    };
    let log = folder.path().join("under-way/simulations.json");
    let stopped = |solves: usize| {
        let mut observer = Breaks::after(solves, folder.path());
        let error = solved(&thetas, &mut observer).unwrap_err();
        assert!(matches!(error, Error::Interrupted { .. }), "{error}");
        (std::fs::read(&log).unwrap(), observer.stored)
    };
    let (three, stored) = stopped(3);
    // A solve is not stored at once.
    assert!(!stored.contains(&true), "{stored:?}");
    let (six, _) = stopped(6);
    assert_ne!(three, six);
    // The tables are new, the log is old.
    std::fs::write(&log, three).unwrap();
    let same = |found: Simulations, thetas: &[Vec<f64>]| {
        let whole = simulate(&body, thetas, "test", None, &mut ()).unwrap();
        assert_eq!((found.thetas, found.fields), (whole.thetas, whole.fields));
    };
    same(solved(&thetas, &mut ()).unwrap(), &thetas);
    // Solutions of other samples are no part of a block.
    std::fs::remove_file(folder.path().join("simulations.json")).unwrap();
    stopped(3);
    let others = Design::Uniform.sample(&body.parameters, 6, 2).unwrap();
    same(solved(&others, &mut ()).unwrap(), &others);
}

#[test]
fn simulations_of_a_body_that_is_equal_at_the_centre_of_the_ranges_are_refused() {
    // Two pressures that change places: equal at the centre, or zero there.
    let plate = |[first, second]: [&str; 2], low: f64| {
        let pressure = |number: usize, facets: &str| Load::Pressure {
            facets: facets.into(),
            magnitude: Magnitude::Theta(2 + number),
        };
        Scene::new(box_tetrahedra([20.0, 20.0, 4.0], [3, 3, 1]), NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 20.0..=40.0))
            .parameter(Parameter::log("lambda", "kPa", 20.0..=40.0))
            .parameter(Parameter::linear("p", "kPa", low..=0.5))
            .parameter(Parameter::linear("q", "kPa", low..=0.5))
            .load(pressure(0, first))
            .load(pressure(1, second))
            .support(Support::clamped("x_min"))
            .support(Support::clamped("x_max"))
            .support(Support::clamped("y_min"))
            .support(Support::clamped("y_max"))
            .lower()
            .unwrap()
    };
    let theta = vec![vec![30.0, 30.0, 0.2, 0.1]];
    let [first, second] = [["z_min", "z_max"], ["z_max", "z_min"]];
    for low in [0.1, -0.5] {
        let folder = tempfile::tempdir().unwrap();
        simulate(&plate(first, low), &theta, "test", Some(folder.path()), &mut ()).unwrap();
        let other = plate(second, low);
        let error = simulate(&other, &theta, "test", Some(folder.path()), &mut ()).unwrap_err();
        assert!(matches!(error, Error::OtherSamples { .. }), "{error}");
    }
}

#[test]
fn derivatives_by_differences_keep_six_digits() {
    // A parameter over six decades, and predictions with rounding errors of 1e-9.
    let body = Scene::new(box_tetrahedra([4.0, 1.0, 1.0], [1, 1, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1e-3..=1e3))
        .parameter(Parameter::linear("lambda", "kPa", 1.0..=3.0))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    for theta in [[1e-3, 1.0], [0.3, 2.0], [1e3, 3.0]] {
        let at = |theta: Vec<f64>| {
            let rounding = 1.0 + 1e-9 * (1e7 * (theta[0].ln() + theta[1])).sin();
            Ok::<_, Error>(vec![rounding * theta[0].ln().sin(), rounding / theta[1]])
        };
        let [by_mu, by_lambda] = &central_differences(&body, &theta, at).unwrap()[..] else {
            panic!("two parameters")
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b.abs(), "{a} {b}");
        close(by_mu[0], theta[0].ln().cos() / theta[0]);
        close(by_lambda[1], -1.0 / theta[1].powi(2));
    }
}
