//! Posteriors of bodies with two modes, with errors that are a share, and without an answer everywhere.

use super::*;

/// A body whose one observable is the square of the logarithm of its parameter.
struct Folded;

impl Forward for Folded {
    fn parameters(&self) -> usize {
        1
    }

    fn observables(&self) -> usize {
        1
    }

    fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
        let x = theta[0].ln();
        Ok(Observed { values: vec![x * x], jacobian: vec![vec![2.0 * x / theta[0]]] })
    }
}

#[test]
fn two_modes_are_an_error_that_names_both() {
    let unknown = Unknown::new("k", "kPa", Prior::LogUniform { range: [0.01, 100.0] });
    let datum = Datum { observable: 0, value: 4.0, deviation: 0.1, ..volume(0, 4.0, 0.1) };
    let problem = Problem::new(vec![unknown], vec![datum], Vec::new()).unwrap();
    let mut solves = Solves::new(&Folded);
    let found = calibrate(&problem, &mut solves, &CalibrateOptions::default());
    let error = found.unwrap_err().to_string();
    assert!(error.contains("2 modes") && error.contains("k [kPa] = 7.3"), "{error}");
    assert!(error.contains("k [kPa] = 0.13"), "{error}");
}

/// A body whose one observable is its parameter.
struct Plain;

impl Forward for Plain {
    fn parameters(&self) -> usize {
        1
    }

    fn observables(&self) -> usize {
        1
    }

    fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
        Ok(Observed { values: theta.to_vec(), jacobian: vec![vec![1.0]] })
    }
}

/// Three volumes with errors of 20 %: the logarithm has a normal posterior about their geometric mean. Read as 20 % of what was
/// measured, low volumes would pull it down by .68 of its standard deviation.
#[test]
fn errors_that_are_a_share_are_normal_in_the_logarithm() {
    let volumes = [40.0, 50.0, 65.0];
    let datum = |value: &f64| Datum { observable: 0, is_share: true, ..volume(0, *value, 0.2) };
    let unknown = Unknown::new("V", "mL", Prior::LogUniform { range: [10.0, 250.0] });
    let problem =
        Problem::new(vec![unknown.clone()], volumes.iter().map(datum).collect(), Vec::new());
    let mut solves = Solves::new(&Plain);
    let options = CalibrateOptions { draws: 2400, steps: 4800, ..CalibrateOptions::default() };
    let posterior = calibrate(&problem.unwrap(), &mut solves, &options).unwrap();
    let logs = posterior.draws.parameter(0).concat().iter().map(|v| v.ln()).collect();
    let found = sinew_sample::Summary::of(&[logs]);
    let mean = volumes.iter().map(|v: &f64| v.ln()).sum::<f64>() / 3.0;
    let deviation = 0.2 / 3f64.sqrt();
    println!("off by {:.3} sd, sd {:.3}", (found.mean - mean) / deviation, found.deviation);
    assert!((found.mean - mean).abs() < 0.1 * deviation);
    assert!((found.deviation / deviation - 1.0).abs() < 0.05);
    let refused = Problem::new(vec![unknown], vec![datum(&-1.0)], Vec::new());
    assert!(refused.unwrap_err().to_string().contains("a share of it"));
}

/// The sphere, without an answer for soft bodies, and without derivatives.
struct Partial;

impl Forward for Partial {
    fn parameters(&self) -> usize {
        2
    }

    fn observables(&self) -> usize {
        Sphere.observables()
    }

    fn observe(&self, theta: &[f64], derivatives: bool) -> Result<Observed, ForwardError> {
        if theta[0] < 0.2 {
            return Err(ForwardError { reason: "no body at rest".into() });
        }
        Sphere.observe(theta, derivatives)
    }
}

#[test]
fn where_the_solver_has_no_answer_there_are_no_draws() {
    let problem = Problem::new(unknowns(), data(3, 1.0), Vec::new()).unwrap();
    let mut solves = Solves::new(&Partial);
    match calibrate(&problem, &mut solves, &CalibrateOptions::default()) {
        Ok(posterior) => {
            assert!(posterior.draws.parameter(0).concat().iter().all(|a| *a >= 0.2));
            assert!(posterior.correction.failed > 0);
        }
        Err(error) => assert!(error.to_string().contains("without an answer"), "{error}"),
    }
}
