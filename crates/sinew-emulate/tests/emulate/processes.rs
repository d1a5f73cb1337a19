//! Closed forms of regressions against their definitions: leave-one-out errors, evidence, standard deviations.

use crate::spread::{parameters, points};
use nalgebra::{DMatrix, DVector, RowDVector};
use sinew_emulate::{
    Interpolation, Output, PodRegression, RegressionParts, RunsEmulator, share_of,
};
use sinew_energy::Parameter;

/// Two components of a function of two parameters from 1 to 2, with some noise.
pub(crate) fn noisy(count: usize) -> (Vec<Parameter>, Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let thetas = points(count, 2, 1.0, 2.0);
    let value = |(sample, theta): (usize, &Vec<f64>)| {
        let [x, y] = [0, 1].map(|d| 3.0 * theta[d].ln() - 1.0);
        let noise = |component: usize| (1e3 * ((sample + 1) * component) as f64).sin();
        vec![x.sin() + 0.1 * noise(1), (x + y).sin() + 0.1 * noise(2)]
    };
    let fields = thetas.iter().enumerate().map(value).collect();
    (parameters(2, 1.0, 2.0), thetas, fields)
}

/// Inputs of a regression at θ.
fn inputs(parameters: &[Parameter], theta: &[f64]) -> RowDVector<f64> {
    let input = |(p, &value): (&Parameter, &f64)| 12f64.sqrt() * (share_of(p, value) - 0.5);
    RowDVector::from_iterator(theta.len(), parameters.iter().zip(theta).map(input))
}

/// Monomials at the rows of a matrix.
fn monomials(x: &DMatrix<f64>, exponents: &[Vec<i32>]) -> DMatrix<f64> {
    let monomial = |i: usize, e: &[i32]| (0..x.ncols()).map(|d| x[(i, d)].powi(e[d])).product();
    DMatrix::from_fn(x.nrows(), exponents.len(), |i, j| monomial(i, &exponents[j]))
}

/// Sum of the squared errors of samples that are left out, by the regression's own account.
fn left_out(regression: &PodRegression, fields: &[Vec<f64>]) -> f64 {
    let size: f64 = fields.iter().flatten().map(|u| u * u).sum();
    regression.leave_one_out().powi(2) * size
}

fn without<T: Clone>(rows: &[T], left_out: usize) -> Vec<T> {
    [&rows[..left_out], &rows[left_out + 1..]].concat()
}

#[test]
fn leave_one_out_of_a_polynomial_is_the_one_by_refitting() {
    let (parameters, thetas, fields) = noisy(9);
    let regression = PodRegression::fit_polynomial(&parameters, &thetas, &fields, 4).unwrap();
    let Interpolation::Polynomial { degree: 1.., ridge } = *regression.interpolation() else {
        panic!("{}", regression.interpolation())
    };
    let RegressionParts { mean, modes, exponents, .. } = regression.parts();
    let rows: Vec<_> = thetas.iter().map(|theta| inputs(&parameters, theta)).collect();
    let values = monomials(&DMatrix::from_rows(&rows), exponents);
    let targets: DMatrix<f64> = DMatrix::from_fn(9, modes.len(), |i, m| {
        let apart = fields[i].iter().zip(mean).zip(modes[m]);
        apart.map(|((u, mean), mode)| (u - mean) * mode).sum()
    });
    let mut refitted = 0.0;
    for i in 0..9 {
        let (rest, known) = (values.clone().remove_row(i), targets.clone().remove_row(i));
        let mut normal = rest.tr_mul(&rest);
        // The penalty is per sample; it stays that of nine.
        (1..normal.nrows()).for_each(|j| normal[(j, j)] += 9.0 * ridge);
        let weights = normal.try_inverse().unwrap() * rest.tr_mul(&known);
        refitted += (values.row(i) * weights - targets.row(i)).norm_squared();
    }
    let closed = left_out(&regression, &fields);
    assert!((closed / refitted - 1.0).abs() < 1e-10, "{closed} {refitted}");
}

#[test]
fn leave_one_out_of_a_process_is_the_one_by_refitting() {
    let (parameters, thetas, fields) = noisy(9);
    let regression = PodRegression::fit(&parameters, &thetas, &fields).unwrap();
    let interpolation = regression.interpolation();
    assert!(matches!(interpolation, Interpolation::GaussianProcess { .. }), "{interpolation}");
    let refitted = (0..9).map(|i| {
        let rest = regression.refitted(&without(&thetas, i), &without(&fields, i)).unwrap();
        let found = rest.predict(&thetas[i]).unwrap();
        found.iter().zip(&fields[i]).map(|(a, b)| (a - b).powi(2)).sum::<f64>()
    });
    let (refitted, closed) = (refitted.sum::<f64>(), left_out(&regression, &fields));
    assert!((closed / refitted - 1.0).abs() < 1e-8, "{closed} {refitted}");
}

#[test]
fn too_few_samples_lower_the_degree() {
    let parameters = parameters(2, 1.0, 2.0);
    for (samples, degree) in [(2, 0), (4, 1), (7, 2), (10, 2), (11, 3)] {
        let thetas = points(samples, 2, 1.0, 2.0);
        let values: Vec<_> = thetas.iter().map(|theta| vec![theta[0].ln().powi(3)]).collect();
        let highest = (0..=3).filter(|&d| d == 0 || (d + 1) * (d + 2) / 2 < samples).max();
        assert_eq!(highest, Some(degree), "{samples} samples");
        let fit = PodRegression::fit_polynomial(&parameters, &thetas, &values, 3).unwrap();
        match fit.interpolation() {
            Interpolation::Polynomial { degree: used, .. } => assert!(*used <= degree),
            other => panic!("{other}"),
        }
    }
}

/// A Gaussian process of one number of sixteen runs.
struct Process {
    parameters: Vec<Parameter>,
    emulator: RunsEmulator,
    /// Inputs, one row per run.
    x: DMatrix<f64>,
    y: DVector<f64>,
    exponents: Vec<Vec<i32>>,
    /// Lengths, then the nugget.
    fitted: [f64; 3],
}

impl Process {
    fn new() -> Self {
        let (parameters, thetas) = (parameters(2, 1.0, 2.0), points(16, 2, 1.0, 2.0));
        let value = |(run, theta): (usize, &Vec<f64>)| {
            let [x, y] = [0, 1].map(|d| 2.0 * (3.0 * theta[d].ln() - 1.0));
            vec![x.sin() * y.cos() + 0.1 * (1e3 * (run + 1) as f64).sin()]
        };
        let values: Vec<_> = thetas.iter().enumerate().map(value).collect();
        let y = DVector::from_iterator(16, values.iter().map(|value| value[0]));
        let output = Output { name: "v".into(), unit: "1".into(), values };
        let emulator =
            RunsEmulator::fit(parameters.clone(), &thetas, &[output], None, &mut ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        emulator.save(folder.path()).unwrap();
        let regression = PodRegression::load(&folder.path().join("0"), &parameters).unwrap();
        let Interpolation::GaussianProcess { trend, lengths, nugget } = regression.interpolation()
        else {
            panic!("{}", regression.interpolation())
        };
        let fitted = [lengths[0], lengths[1], *nugget];
        let is_of_trend = |e: &&Vec<i32>| e.iter().sum::<i32>() as usize <= *trend;
        let parts = regression.parts();
        assert_eq!(parts.lengths.len(), 3 * 2, "a set of lengths for each trend");
        let exponents = parts.exponents.iter().filter(is_of_trend).cloned().collect();
        let rows: Vec<_> = thetas.iter().map(|theta| inputs(&parameters, theta)).collect();
        Self { x: DMatrix::from_rows(&rows), parameters, emulator, y, exponents, fitted }
    }

    /// Covariance of values at rows of inputs, noise included.
    fn covariance(x: &DMatrix<f64>, [l0, l1, nugget]: [f64; 3]) -> DMatrix<f64> {
        DMatrix::from_fn(x.nrows(), x.nrows(), |i, j| {
            let apart = |d: usize, length: f64| ((x[(i, d)] - x[(j, d)]) / length).powi(2);
            let noise = if i == j { nugget } else { 0.0 };
            (-0.5 * (apart(0, l0) + apart(1, l1))).exp() + noise
        })
    }
}

#[test]
fn standard_deviations_are_those_of_the_inverse_covariance() {
    let process = Process::new();
    // [K P; Pᵀ 0]⁻¹ holds the inverse variances on its diagonal (Dubrule 1983).
    let variance = |theta: &[f64]| {
        let new = inputs(&process.parameters, theta);
        let x = DMatrix::from_fn(17, 2, |i, d| if i < 16 { process.x[(i, d)] } else { new[d] });
        let (trend, count) = (monomials(&x, &process.exponents), process.exponents.len());
        let mut bordered = DMatrix::zeros(17 + count, 17 + count);
        bordered.view_mut((0, 0), (17, 17)).copy_from(&Process::covariance(&x, process.fitted));
        bordered.view_mut((0, 17), (17, count)).copy_from(&trend);
        bordered.view_mut((17, 0), (count, 17)).copy_from(&trend.transpose());
        1.0 / bordered.try_inverse().unwrap()[(16, 16)]
    };
    let half_width = |theta: &[f64]| process.emulator.predict(theta).unwrap()[0].half_width;
    let (here, there) = ([1.3, 1.6], [[1.05, 1.95], [0.9, 2.2], [1.5, 1.5]]);
    for there in there {
        let found = (half_width(&there) / half_width(&here)).powi(2);
        let expected = variance(&there) / variance(&here);
        assert!((found / expected - 1.0).abs() < 1e-8, "{there:?}: {found} {expected}");
    }
}

#[test]
fn length_scales_maximise_the_evidence_of_contrasts_which_the_trend_does_not_reach() {
    let Process { x, y, exponents, fitted, .. } = Process::new();
    // Columns with eigenvalue 1 of the projection span the contrasts.
    let trend = monomials(&x, &exponents);
    let normal = trend.tr_mul(&trend).try_inverse().unwrap();
    let projection = DMatrix::identity(16, 16) - &trend * normal * trend.transpose();
    let eigen = projection.symmetric_eigen();
    let kept: Vec<usize> = (0..16).filter(|&i| eigen.eigenvalues[i] > 0.5).collect();
    let contrasts = eigen.eigenvectors.select_columns(&kept);
    assert_eq!(kept.len(), 16 - exponents.len());
    let z = contrasts.tr_mul(&y);
    let negative_log_evidence = |at: [f64; 3]| {
        let covariance = contrasts.tr_mul(&Process::covariance(&x, at)) * &contrasts;
        let square = z.dot(&(covariance.clone().try_inverse().unwrap() * &z));
        0.5 * (kept.len() as f64 * square.ln() + covariance.determinant().ln())
    };
    let own = negative_log_evidence(fitted);
    let lengths = || (-2..6).map(|half| (0.5 * f64::from(half)).exp());
    for (l0, l1) in lengths().flat_map(|l0| lengths().map(move |l1| (l0, l1))) {
        for nugget in (-12..=0).map(|half| f64::from(2 * half).exp()) {
            let other = negative_log_evidence([l0, l1, nugget]);
            // The search ends where a parameter is less than a standard deviation off its optimum.
            assert!(own < other + 0.5, "{own} at {fitted:?}, {other} at {l0} {l1} {nugget}");
        }
    }
}
