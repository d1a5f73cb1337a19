use super::interpolation::{Basis, solve_ridge};
use super::process::solve_process;
use super::*;
use sinew_num::monomials;

/// `count` points in `[low, high]^variables`, evenly spread by the additive recurrence of
/// Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018).
fn points(count: usize, variables: usize, low: f64, high: f64) -> Vec<Vec<f64>> {
    let golden = (0..64).fold(2f64, |g, _| (1.0 + g).powf(1.0 / (variables + 1) as f64));
    let share = |i: usize, d: usize| (0.5 + (i + 1) as f64 / golden.powi(d as i32 + 1)).fract();
    let value = |i, d| low * (high / low).powf(share(i, d));
    (0..count).map(|i| (0..variables).map(|d| value(i, d)).collect()).collect()
}

#[test]
fn too_few_samples_lower_the_degree() {
    for (samples, degree) in [(2, 0), (4, 1), (7, 2), (10, 2), (11, 3)] {
        let thetas = points(samples, 2, 1.0, 2.0);
        let targets = DMatrix::from_fn(samples, 1, |i, _| thetas[i][0].ln().powi(3));
        let x = DMatrix::from_fn(samples, 2, |i, d| 3.0 * thetas[i][d].ln() - 1.0);
        let highest = (0..=3).filter(|&d| d == 0 || monomials(2, d).len() < samples).max();
        assert_eq!(highest, Some(degree), "{samples} samples");
        match fit_polynomial(&x, &targets, 3).interpolation {
            Interpolation::Polynomial { degree: used, .. } => assert!(used <= degree),
            other => panic!("{other}"),
        }
    }
}

#[test]
fn leave_one_out_in_closed_form_is_the_one_by_refitting() {
    let thetas = points(9, 2, 1.0, 2.0);
    let x = DMatrix::from_fn(9, 2, |i, d| 3.0 * thetas[i][d].ln() - 1.0);
    let y = DMatrix::from_fn(9, 2, |i, j| (x[(i, 0)] + j as f64 * x[(i, 1)]).sin());
    let basis = Basis::monomials(monomials(2, 2));
    let trend = monomials(2, 1);
    let values = basis.at_all(&x);
    let logarithms = [0.3, 0.5, -9.0];
    let (mut polynomial, mut process) = (0.0, 0.0);
    for i in 0..9 {
        let (rest, targets) = (x.clone().remove_row(i), y.clone().remove_row(i));
        // The penalty is per sample; here it must stay that of nine.
        let (weights, _) = solve_ridge(&basis.at_all(&rest), &targets, 0.01 * 9.0 / 8.0).unwrap();
        polynomial += (values.row(i) * weights - y.row(i)).norm_squared();
        let fit = solve_process(&rest, &targets, 1, &trend, &logarithms).unwrap();
        let guess = fit.at(&x.row(i).into_owned());
        process += (guess - y.row(i)).norm_squared();
    }
    let closed = solve_ridge(&values, &y, 0.01).unwrap().1;
    assert!((closed / polynomial - 1.0).abs() < 1e-10);
    let closed = solve_process(&x, &y, 1, &trend, &logarithms).unwrap().leave_one_out;
    assert!((closed / process - 1.0).abs() < 1e-8);
}
