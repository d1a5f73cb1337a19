//! Taylor series against second-order jets and closed forms.

use sinew_gp::Series;
use sinew_num::{Jet, Scalar};

/// Rounding of formulas with values of order one.
const ROUNDING: f64 = 1e-12;

/// Largest Taylor coefficient of two variables up to these degrees.
fn largest_coefficient(of: &Series, [first, second]: [usize; 2]) -> f64 {
    let factorial = |n: usize| -> f64 { (1..=n).map(|k| k as f64).product() };
    let powers = (0..=first).flat_map(|i| (0..=second).map(move |j| [i, j]));
    let coefficient = |[i, j]: [usize; 2]| of.derivative(&[i, j]) / (factorial(i) * factorial(j));
    powers.map(|powers| coefficient(powers).abs()).fold(0.0, f64::max)
}

#[test]
fn agrees_with_second_order_jets() {
    // One formula, whatever the numbers.
    macro_rules! formula {
        ($x:expr, $y:expr) => {{
            let (x, y) = ($x, $y);
            let q = (x.clone() * y.clone() + 2.0).ln() / (y.clone().exp() + 1.0);
            let r = (x.clone() - y.clone()).tanh();
            q + r * 2.0 - (y * 0.3).exp() + x.squared()
        }};
    }
    let jet = formula!(Jet::<2>::variable(0.7, 0), Jet::<2>::variable(-0.4, 1));
    let [x, y] = Series::variables([0.7, -0.4], [2, 2]);
    let series = formula!(x, y);
    assert!((series.value() - jet.value).abs() < ROUNDING);
    assert!((series.derivative(&[1, 0]) - jet.gradient[0]).abs() < ROUNDING);
    assert!((series.derivative(&[1, 1]) - jet.hessian[0][1]).abs() < ROUNDING);
    assert!((series.derivative(&[0, 2]) - jet.hessian[1][1]).abs() < ROUNDING);
}

#[test]
fn high_mixed_derivatives_are_exact() {
    // ∂⁸/∂x⁴∂y⁴ of sin(2x + y) is 2⁴ sin(2x + y).
    let [x, y] = Series::variables([0.4, -0.2], [4, 4]);
    let f = (&x * 2.0 + &y).sin();
    let exact = 16.0 * (2.0 * 0.4 - 0.2_f64).sin();
    assert!((f.derivative(&[4, 4]) - exact).abs() < ROUNDING);
    let g = (&x + &y).powf(1.5);
    // 1.5·0.5·(−0.5)…(−5.5) (x+y)^(−6.5)
    let falling: f64 = (0..8).map(|k| 1.5 - f64::from(k)).product();
    let exact = falling * 0.2_f64.powf(1.5 - 8.0);
    assert!((g.derivative(&[4, 4]) / exact - 1.0).abs() < ROUNDING);
    let square = (&x + &y).sqrt().squared();
    assert!((square.derivative(&[1, 0]) - 1.0).abs() < ROUNDING);
    assert!(square.derivative(&[2, 1]).abs() < 1e-9);
}

#[test]
fn circular_functions_and_quotients_keep_their_identities() {
    let [x, y] = Series::variables([0.9, 0.4], [3, 2]);
    let one = x.sin().squared() + x.cos().squared();
    assert!((one.value() - 1.0).abs() < ROUNDING);
    assert!(one.derivative(&[3, 0]).abs() < ROUNDING);
    let same = &x / &y * &y - &x;
    assert!(largest_coefficient(&same, [3, 2]) < ROUNDING);
    let inverse = 1.0 / (2.0 - &x);
    assert!((inverse.derivative(&[3, 0]) - 6.0 / 1.1_f64.powi(4)).abs() < 1e-11);
}

#[test]
fn constants_of_smaller_shape_are_promoted() {
    let [one] = Series::plain([1.0]);
    let [x] = Series::variables([3.0], [2]);
    assert_eq!((&one + &x).derivative(&[1]), 1.0);
    assert_eq!((&x * &one).value(), 3.0);
}

#[test]
fn the_angle_of_a_point_has_the_derivatives_of_an_angle() {
    for (x0, y0) in [(0.8, 0.3), (-0.5, 0.7), (-0.4, -0.2), (0.0, 1.3)] {
        let [x, y] = Series::variables([x0, y0], [3, 3]);
        let angle = y.atan2(&x);
        let square = x0 * x0 + y0 * y0;
        assert_eq!(angle.value(), f64::atan2(y0, x0));
        assert!((angle.derivative(&[1, 0]) + y0 / square).abs() < ROUNDING);
        assert!((angle.derivative(&[0, 1]) - x0 / square).abs() < ROUNDING);
        // r cos φ = x to all orders.
        let again = (x.squared() + y.squared()).sqrt() * angle.cos() - &x;
        assert!(largest_coefficient(&again, [3, 3]) < 1e-10, "{again:?}");
    }
    let [x, y] = Series::plain([0.0, 0.0]);
    assert_eq!(y.atan2(&x).value(), 0.0);
}
