//! Formulas over numbers of every type: first and second derivatives.

use sinew_num::{Jet, Scalar, Slope};

/// A formula that uses every operation of the trait.
fn formula<S: Scalar>(x: S, y: S) -> S {
    let q = (x.clone() * y.clone() + 2.0).ln() / (y.clone().exp() + 1.0);
    let r = (x.clone() - y.clone()).tanh() * (x.clone() * 0.1).ln_1p() - (y.clone() * 0.3).exp_m1();
    let chosen = x.select_below(0.0, y.clone(), x.clone().squared());
    -q.at_least(-10.0) + r.at_most(10.0) * 2.0 + chosen
}

#[test]
fn derivatives_agree_with_central_differences() {
    // Step of a central difference in f64 that balances rounding and truncation.
    const STEP: f64 = 1e-4;
    const TOLERANCE: f64 = 2e-7;
    for (x, y) in [(0.7, -0.4), (1.9, 0.3), (-0.2, 1.1)] {
        let jet = formula(Jet::<2>::variable(x, 0), Jet::variable(y, 1));
        let slope = formula(Slope::<2>::variable(x, 0), Slope::variable(y, 1));
        // Division goes through the reciprocal, so values agree to rounding only.
        assert!((jet.value - formula(x, y)).abs() < 1e-14);
        assert_eq!(slope.value, jet.value);
        let f = |dx: f64, dy: f64| formula(x + dx * STEP, y + dy * STEP);
        let difference = [
            (f(1.0, 0.0) - f(-1.0, 0.0)) / (2.0 * STEP),
            (f(0.0, 1.0) - f(0.0, -1.0)) / (2.0 * STEP),
        ];
        let second = [
            [
                (f(1.0, 0.0) - 2.0 * f(0.0, 0.0) + f(-1.0, 0.0)) / (STEP * STEP),
                (f(1.0, 1.0) - f(1.0, -1.0) - f(-1.0, 1.0) + f(-1.0, -1.0)) / (4.0 * STEP * STEP),
            ],
            [jet.hessian[0][1], (f(0.0, 1.0) - 2.0 * f(0.0, 0.0) + f(0.0, -1.0)) / (STEP * STEP)],
        ];
        for i in 0..2 {
            assert!((jet.gradient[i] - difference[i]).abs() < TOLERANCE);
            assert!((slope.gradient[i] - jet.gradient[i]).abs() < 1e-14);
            for j in 0..2 {
                assert!((jet.hessian[i][j] - second[i][j]).abs() < 1e-6, "{i}{j}");
                assert_eq!(jet.hessian[i][j], jet.hessian[j][i]);
            }
        }
    }
}

#[test]
fn logarithms_outside_their_domain_are_minus_infinity() {
    for x in [0.0, -1.0, -1e300] {
        assert_eq!(Scalar::ln(x), f64::NEG_INFINITY);
        assert_eq!(Scalar::ln_1p(x - 1.0), f64::NEG_INFINITY);
        assert_eq!(Scalar::ln(Jet::<1>::constant(x)).value, f64::NEG_INFINITY);
    }
}

#[test]
fn branch_not_taken_does_not_leak() {
    let x = Slope::<1>::variable(2.0, 0);
    let infinite = Slope::<1>::variable(0.0, 0).ln();
    let kept = x.select_below(1.0, infinite, x * 3.0);
    assert_eq!((kept.value, kept.gradient[0]), (6.0, 3.0));
}
