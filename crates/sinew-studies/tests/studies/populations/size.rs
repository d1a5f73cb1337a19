//! Sizes of displacement fields over the parameters.

use sinew_emulate::{PodRegression, RegressionError};
use sinew_studies::populations::size::SizeRegression;
use spread::{parameters, points};

#[path = "../../../../sinew-emulate/tests/emulate/spread.rs"]
mod spread;

#[test]
fn fields_relative_to_their_size_have_smaller_relative_errors() {
    // Power laws of four stiffnesses over two decades each; the shape turns a little with the first.
    let (low, high) = (0.1, 10.0);
    let stretched = |theta: &[f64]| -> Vec<f64> {
        let size = theta.iter().zip([-0.7, -0.5, -0.3, -0.2]).map(|(k, n)| k.powf(n));
        let (size, turned) = (size.product::<f64>(), 0.1 * theta[0].ln());
        (0..60).map(|i| size * (1.0 + (turned + i as f64 / 60.0).sin())).collect()
    };
    let [training, unseen] = [85, 200].map(|count| points(count, 4, low, high));
    let fields: Vec<_> = training.iter().map(|theta| stretched(theta)).collect();
    let sizes = SizeRegression::fit(&parameters(4, low, high), &training, &fields).unwrap();
    let relative: Vec<Vec<f64>> = training
        .iter()
        .zip(&fields)
        .map(|(theta, field)| field.iter().map(|u| u / sizes.at(theta).unwrap()).collect())
        .collect();
    let fitted = |fields| PodRegression::fit(&parameters(4, low, high), &training, fields).unwrap();
    let [absolute, relative] = [&fields, &relative].map(|fields| fitted(fields));
    let median_error = |predict: &dyn Fn(&Vec<f64>) -> Vec<f64>| {
        let mut errors: Vec<f64> = unseen
            .iter()
            .map(|theta| {
                let (found, truth) = (predict(theta), stretched(theta));
                let squares: f64 = found.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
                (squares / truth.iter().map(|u| u * u).sum::<f64>()).sqrt()
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    };
    let of_absolute = median_error(&|theta| absolute.predict(theta).unwrap());
    let of_relative = median_error(&|theta| {
        let size = sizes.at(theta).unwrap();
        relative.predict(theta).unwrap().into_iter().map(|u| size * u).collect()
    });
    eprintln!("median relative error: absolute {of_absolute:.1e}, relative {of_relative:.1e}");
    assert!(of_relative < 0.5 * of_absolute, "{of_relative} {of_absolute}");
}

#[test]
fn a_field_of_zeros_has_no_size() {
    let thetas = points(9, 1, 1.0, 2.0);
    let mut fields: Vec<_> = thetas.iter().map(|theta| vec![1.0 / theta[0]; 3]).collect();
    let sizes = SizeRegression::fit(&parameters(1, 1.0, 2.0), &thetas, &fields).unwrap();
    assert!(matches!(sizes.at(&[1.0, 2.0]), Err(RegressionError::Length { .. })));
    fields[4].fill(0.0);
    let refused = SizeRegression::fit(&parameters(1, 1.0, 2.0), &thetas, &fields).unwrap_err();
    assert!(matches!(refused, RegressionError::Field { sample: 4, .. }), "{refused}");
}
