//! The polynomial in the place of the solver: its degree and its error, as the solver sees them.

use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Correction, Datum, Forward, ForwardError, Observed, Prior,
    Problem, Solves, Unknown, calibrate,
};

const PRIOR: Prior = Prior::LogUniform { range: [1.0, 100.0] };

/// A cubic and a line in the standardised logarithms of two parameters.
struct Cubic;

impl Forward for Cubic {
    fn parameters(&self) -> usize {
        2
    }

    fn observables(&self) -> usize {
        2
    }

    fn observe(&self, theta: &[f64], _: bool) -> Result<Observed, ForwardError> {
        let [mean, deviation] = PRIOR.moments();
        let [a, b] = [0, 1].map(|at| (theta[at].ln() - mean) / deviation);
        let slopes = [[2.0 * a * b - 1.0, a * a], [0.0, 3.0]];
        let by_theta = |slopes: [f64; 2]| vec![slopes[0] / theta[0], slopes[1] / theta[1]];
        let scaled = |slopes: [f64; 2]| by_theta(slopes.map(|slope| slope / deviation));
        Ok(Observed {
            values: vec![a * a * b - a, 3.0 * b + 2.0],
            jacobian: slopes.map(scaled).to_vec(),
        })
    }
}

/// Course of one round, with the mode in the middle of the prior: one solve, and those of the design.
fn round(design: usize, degree: usize) -> Correction {
    let unknowns = ["a", "b"].map(|name| Unknown::new(name, "", PRIOR)).to_vec();
    let data =
        vec![Datum::new("cubic", "length", 0, 0.0, 0.3), Datum::new("line", "length", 1, 2.0, 0.3)];
    let problem = Problem::new(unknowns, data, Vec::new()).unwrap();
    let mut solves = Solves::new(&Cubic);
    let options = CalibrateOptions { starts: 1, rounds: 1, design, degree, ..Default::default() };
    match calibrate(&problem, &mut solves, &options) {
        Ok(posterior) => posterior.correction,
        Err(CalibrateError::Unconfirmed(reached)) => *reached,
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn a_cubic_is_found_through_enough_values_with_derivatives() {
    let enough = round(40, 4);
    assert!(enough.degree >= 3 && enough.largest_error < 1e-6, "{enough:?}");
    // Twelve equations do not determine ten coefficients and say how well.
    let few = round(3, 4);
    assert!(few.degree < 3 && few.largest_error > 1e-4, "{few:?}");
}

#[test]
fn lines_through_a_cubic_and_a_line_are_off_the_cubic() {
    let found = round(40, 1);
    assert_eq!((found.degree, &found.worst_datum[..]), (1, "cubic"));
    assert!(found.largest_error > 1e-3, "{found:?}");
}
