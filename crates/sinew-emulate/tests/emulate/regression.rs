//! Regression on few simulations: families of fields that it must reproduce, and samples that it must refuse.

use crate::spread::{parameters, points};
use sinew_emulate::{Design, Interpolation, PodRegression, RegressionParts, Result};

/// A clamped beam's deflection in form: stiffness in the denominator, and some coupling.
fn smooth(theta: &[f64]) -> Vec<f64> {
    let stiffness: f64 = theta.iter().sum();
    let ratio = theta[0] / stiffness;
    (0..60)
        .map(|i| {
            let s = i as f64 / 59.0;
            1e3 * s * s / stiffness + 5.0 * (3.0 * s * ratio).sin() + ratio * ratio * s
        })
        .collect()
}

fn relative_error(pod: &PodRegression, thetas: &[Vec<f64>]) -> f64 {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let error = |theta: &Vec<f64>| {
        let (truth, guess) = (smooth(theta), pod.predict(theta).unwrap());
        let difference: Vec<f64> = truth.iter().zip(&guess).map(|(a, b)| a - b).collect();
        norm(&difference) / norm(&truth)
    };
    thetas.iter().map(error).fold(0.0, f64::max)
}

fn fit(thetas: &[Vec<f64>], low: f64, high: f64) -> PodRegression {
    let fields: Vec<_> = thetas.iter().map(|theta| smooth(theta)).collect();
    PodRegression::fit(&parameters(thetas[0].len(), low, high), thetas, &fields).unwrap()
}

#[test]
fn a_smooth_family_is_reproduced_and_interpolated() {
    let thetas = points(25, 2, 50.0, 100.0);
    let pod = fit(&thetas, 50.0, 100.0);
    let training = relative_error(&pod, &thetas);
    let between = relative_error(&pod, &points(60, 2, 55.0, 90.0));
    assert!(training < 1e-5, "{training:e} with {}", pod.interpolation());
    assert!(between < 1e-4, "{between:e} with {}", pod.interpolation());
    assert!(pod.leave_one_out() < 1e-4 && pod.modes() >= 3, "{}", pod.leave_one_out());
}

#[test]
fn any_number_of_parameters() {
    let one = points(12, 1, 1.0, 3.0);
    assert!(relative_error(&fit(&one, 1.0, 3.0), &points(20, 1, 1.1, 2.8)) < 1e-4);
    let five = points(120, 5, 1.0, 1.5);
    let (pod, test) = (fit(&five, 1.0, 1.5), points(20, 5, 1.1, 1.4));
    assert!(relative_error(&pod, &test) < 1e-3, "{:e}", relative_error(&pod, &test));
}

#[test]
fn a_cubic_family_is_recognised() {
    let thetas = points(25, 2, 1.0, 4.0);
    let field = |theta: &Vec<f64>| {
        let (a, b) = (theta[0].ln(), theta[1].ln());
        vec![a * a * b - 2.0, 3.0 * b * b * b + a, a * b]
    };
    let fields: Vec<_> = thetas.iter().map(field).collect();
    let pod = PodRegression::fit(&parameters(2, 1.0, 4.0), &thetas, &fields).unwrap();
    assert!(matches!(pod.interpolation(), Interpolation::Polynomial { degree: 3, .. }));
    let theta = vec![1.7, 3.1];
    let guess = pod.predict(&theta).unwrap();
    for (truth, guess) in field(&theta).iter().zip(guess) {
        // A dropped share of 1e-12 of the energy is 1e-6 of the field, at most.
        assert!((truth - guess).abs() < 2e-6, "{truth} {guess}");
    }
}

#[test]
fn fields_of_exact_rank_one_and_two_are_kept_whole() {
    let parameters = parameters(2, 1.0, 3.0);
    for (rank, seed) in (1..=2).flat_map(|rank| (0..40).map(move |seed| (rank, seed))) {
        let thetas = Design::Uniform.sample(&parameters, 25, seed).unwrap();
        let value = |theta: &Vec<f64>, node: usize| {
            let x = node as f64;
            // Rows of zeros, as of displacements in a plane.
            let bent = if node % 3 == 2 { x * x / theta[0] } else { 0.0 };
            bent + if rank == 2 { x * theta[1] } else { 0.0 }
        };
        let field = |theta: &Vec<f64>| (0..135).map(|node| value(theta, node)).collect();
        let fields: Vec<Vec<f64>> = thetas.iter().map(field).collect();
        let pod = PodRegression::fit_polynomial(&parameters, &thetas, &fields, 4).unwrap();
        assert_eq!(pod.modes(), rank);
        let RegressionParts { mean, modes, .. } = pod.parts();
        let size = fields.iter().flatten().fold(0.0, |most: f64, u| most.max(u.abs()));
        for field in &fields {
            let apart: Vec<f64> = field.iter().zip(mean).map(|(u, mean)| u - mean).collect();
            let along = |mode: &[f64]| mode.iter().zip(&apart).map(|(m, u)| m * u).sum::<f64>();
            let told: Vec<f64> = modes.iter().map(|mode| along(mode)).collect();
            for (node, u) in apart.iter().enumerate() {
                let found: f64 = modes.iter().zip(&told).map(|(mode, c)| c * mode[node]).sum();
                assert!((u - found).abs() < 1e-10 * size, "rank {rank}, seed {seed}: {u} {found}");
            }
        }
    }
}

#[test]
fn two_samples_are_enough_for_a_finite_field() {
    let two = fit(&points(2, 2, 50.0, 100.0), 50.0, 100.0);
    assert!(two.predict(&[60.0, 70.0]).unwrap().iter().all(|u| u.is_finite()));
}

#[test]
fn equal_fields_have_no_modes() {
    let thetas = points(5, 2, 1.0, 2.0);
    let fields = vec![vec![0.1, -0.2, 0.3]; 5];
    let pod = PodRegression::fit(&parameters(2, 1.0, 2.0), &thetas, &fields).unwrap();
    assert_eq!(pod.modes(), 0);
    for (a, b) in pod.predict(&[1.5, 1.5]).unwrap().iter().zip(&fields[0]) {
        assert!((a - b).abs() < 1e-15);
    }
}

#[test]
fn a_constant_parameter_does_no_harm() {
    let mut thetas = points(20, 2, 50.0, 100.0);
    thetas.iter_mut().for_each(|theta| theta[1] = 0.3);
    assert!(relative_error(&fit(&thetas, 50.0, 100.0), &thetas) < 1e-5);
}

#[test]
fn unusable_samples() {
    let thetas = points(4, 2, 1.0, 2.0);
    let fields = vec![vec![1.0, 2.0], vec![2.0, 0.0], vec![0.0, 1.0], vec![1.0, 1.0]];
    let fit = |thetas: &[Vec<f64>], fields: &[Vec<f64>]| {
        PodRegression::fit(&parameters(2, 1.0, 2.0), thetas, fields)
    };
    fn says<T: std::fmt::Debug>(found: Result<T>, text: &str) {
        let error = found.unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    }
    let mut broken = fields.clone();
    broken[2][1] = f64::NAN;
    says(fit(&thetas, &broken), "value 1 of field 2 is NaN");
    broken[2] = vec![0.0; 3];
    says(fit(&thetas, &broken), "sample 2: 2 field values expected, 3 found");
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut thetas = thetas.clone();
        thetas[1][0] = value;
        says(fit(&thetas, &fields), &format!("of sample 1 is {value}: it must be finite"));
    }
    says(fit(&thetas[..3], &fields), "3 parameter vectors but 4 fields");
    says(fit(&thetas[..1], &fields[..1]), "1 simulations were given");
    let huge: Vec<_> = fields.iter().map(|f| f.iter().map(|u| 1e200 * u).collect()).collect();
    says(fit(&thetas, &huge), "no singular values of 4 fields of 2 values");
    let pod = fit(&thetas, &fields).unwrap();
    says(pod.predict(&[1.0]), "2 parameters expected, 1 found");
    says(pod.predict(&[1.0, -1.0]), "of sample 0 is -1");
}
