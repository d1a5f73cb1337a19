use super::interpolation::{Basis, solve_ridge};
use super::process::{Conditional, solve_process};
use super::*;
use crate::{Design, Output, RunsEmulator};
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

/// Points, and values of two smooth functions there.
fn smooth(count: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let thetas = points(count, 2, 1.0, 2.0);
    let x = DMatrix::from_fn(count, 2, |i, d| 3.0 * thetas[i][d].ln() - 1.0);
    let y = DMatrix::from_fn(count, 2, |i, j| (x[(i, 0)] + j as f64 * x[(i, 1)]).sin());
    (x, y)
}

#[test]
fn the_deviation_at_a_point_left_out_is_that_of_the_inverse_covariance() {
    let (x, _) = smooth(12);
    let (trend, logarithms) = (monomials(2, 1), [0.3, 0.5, -9.0]);
    // [K 1; 1ᵀ 0]⁻¹ holds the inverse variances on its diagonal (Dubrule 1983).
    let values = Basis {
        lengths: vec![0.3f64.exp(), 0.5f64.exp()],
        points: x.clone(),
        exponents: trend.clone(),
    };
    let values = values.at_all(&x);
    let mut bordered = DMatrix::zeros(15, 15);
    bordered.view_mut((0, 0), (12, 15)).copy_from(&values);
    bordered.view_mut((12, 0), (3, 12)).copy_from(&values.columns(12, 3).transpose());
    (0..12).for_each(|i| bordered[(i, i)] += (-9f64).exp());
    let inverse = bordered.try_inverse().unwrap();
    for i in 0..12 {
        let rest = Conditional::new(&x.clone().remove_row(i), &trend, &logarithms).unwrap();
        let deviation = rest.deviation(&x.row(i).into_owned());
        assert!((deviation.powi(2) * inverse[(i, i)] - 1.0).abs() < 1e-8);
    }
}

#[test]
fn the_evidence_is_that_of_contrasts_which_the_trend_does_not_reach() {
    let (x, y) = smooth(10);
    let (y, trend) = (y.columns(1, 1).into_owned(), monomials(2, 1));
    // Columns with eigenvalue 1 of the projection span the contrasts.
    let monomials = Basis::monomials(trend.clone()).at_all(&x);
    let normal = monomials.tr_mul(&monomials).try_inverse().unwrap();
    let projection = DMatrix::identity(10, 10) - &monomials * normal * monomials.transpose();
    let eigen = projection.symmetric_eigen();
    let kept: Vec<usize> = (0..10).filter(|&i| eigen.eigenvalues[i] > 0.5).collect();
    let contrasts = eigen.eigenvectors.select_columns(&kept);
    assert_eq!(contrasts.ncols(), 7);
    let direct = |logarithms: [f64; 3]| {
        let [l0, l1, nugget] = logarithms.map(f64::exp);
        let basis = Basis { lengths: vec![l0, l1], points: x.clone(), exponents: Vec::new() };
        let covariance = basis.at_all(&x) + DMatrix::identity(10, 10) * nugget;
        let covariance = contrasts.tr_mul(&covariance) * &contrasts;
        let z = contrasts.tr_mul(&y);
        let square = z.dot(&(covariance.clone().try_inverse().unwrap() * &z));
        3.5 * square.ln() + 0.5 * covariance.determinant().ln()
    };
    let ours = |at: [f64; 3]| Conditional::new(&x, &trend, &at).unwrap().negative_log_evidence(&y);
    let [a, b] = [[0.3, 0.5, -4.0], [0.9, -0.2, -6.0]];
    assert!((ours(a) - ours(b) - direct(a) + direct(b)).abs() < 1e-8);
}

#[test]
fn intervals_from_samples_left_out_hold_for_unseen_ones_of_a_smooth_function() {
    let value = |t: &Vec<f64>| vec![t[0].ln() * t[1].sqrt() + (t[2] / t[0]).ln().sin() + 20.0];
    let parameters = ["a", "b", "c"].map(|name| Parameter::log(name, "kPa", 1.0..=10.0));
    // Independent points, so that those left out are as the unseen ones.
    let mut thetas = Design::Uniform.sample(&parameters, 480, 1).unwrap();
    let unseen = thetas.split_off(80);
    let values = thetas.iter().map(value).collect();
    let output = Output { name: "v".into(), unit: "1".into(), values };
    let emulator =
        RunsEmulator::fit(parameters.to_vec(), &thetas, &[output], None, &mut ()).unwrap();
    let off = |theta: &Vec<f64>| {
        let found = emulator.predict(theta).unwrap().remove(0);
        ((found.values[0] - value(theta)[0]).abs(), found.half_width)
    };
    let found: Vec<_> = unseen.iter().map(off).collect();
    let held = found.iter().filter(|(error, half_width)| error <= half_width).count();
    // The coverage by a rank of 80 errors is 0.95 with a standard deviation of 0.024 (Beta distribution).
    assert!((350..=400).contains(&held), "{held} of 400");
    let mean = found.iter().map(|(_, half_width)| half_width).sum::<f64>() / 400.0;
    assert!(mean < 4.0 * emulator.left_out()[0].error, "{mean:e}");
    let mean_square = found.iter().map(|(error, _)| error * error).sum::<f64>() / 400.0;
    let ratio = mean_square.sqrt() / emulator.left_out()[0].error;
    assert!(ratio < 1.5, "{ratio} of the error stated");
}
