//! Kernels of this crate are symmetric, definite and differentiated correctly, and functions that are not covariances are found.

use sinew_gp::{
    Formula, Hyperparameter, Measure, Series, Smoothness, check_kernel, linear, matern, periodic,
    rational_quadratic, squared_exponential,
};

fn kernels() -> Vec<Formula<2>> {
    let wave = |axis, period| periodic(axis, period).unwrap();
    vec![
        squared_exponential(),
        squared_exponential().along(&[1]),
        rational_quadratic(),
        rational_quadratic().along(&[1]),
        matern(Smoothness::Once),
        matern(Smoothness::Twice),
        matern(Smoothness::Thrice),
        linear(),
        wave(0, 1.3),
        wave(0, 1.3) * squared_exponential().along(&[1]),
        linear() * squared_exponential(),
        squared_exponential().scaled() + rational_quadratic().scaled(),
        linear() + wave(1, 0.9),
        linear() + matern(Smoothness::Once),
        matern(Smoothness::Twice) * wave(0, 1.3),
    ]
}

#[test]
fn all_kernels_conform() {
    for kernel in &kernels() {
        let values: Vec<f64> = kernel
            .hyperparameters()
            .iter()
            .enumerate()
            .map(|(number, h)| match h.measure {
                Measure::Length { .. } => 0.6 + 0.2 * number as f64,
                Measure::Number { .. } | Measure::Width { .. } => 1.1 + 0.1 * number as f64,
            })
            .collect();
        let result = check_kernel(kernel, &values, [-0.5, 0.0], [1.0, 2.0], 3);
        assert_eq!(result, Ok(()), "{}", kernel.name);
    }
}

#[test]
fn lengths_from_a_twentieth_to_fifty_times_the_extent_pass() {
    let extents = [3.0, 0.02];
    for kernel in &kernels() {
        for (seed, length) in [0.05, 0.2, 1.0, 5.0, 20.0, 50.0].into_iter().enumerate() {
            let value = |h: Hyperparameter| match h.measure {
                Measure::Length { axis } => length * extents[axis],
                Measure::Number { .. } | Measure::Width { .. } => 1.2,
            };
            let values: Vec<f64> = kernel.hyperparameters().into_iter().map(value).collect();
            let upper = [-1.0 + extents[0], extents[1]];
            let result = check_kernel(kernel, &values, [-1.0, 0.0], upper, seed as u64);
            assert_eq!(result, Ok(()), "{} of length {length}", kernel.name);
        }
    }
}

/// k(x, x′) = x − 2x′ in the first axis.
fn skew() -> Formula<1> {
    let formula = |_: &[Series], x: &[Series; 1], y: &[Series; 1]| &x[0] - &y[0] * 2.0;
    Formula::new("skew", Vec::new(), formula)
}

/// A constant that says of its hyperparameter what it is told.
fn declared(measure: Measure) -> Formula<1> {
    let known = vec![Hyperparameter { name: "number", measure }];
    let formula = |h: &[Series], _: &[Series; 1], _: &[Series; 1]| h[0].squared();
    Formula::new("declared", known, formula)
}

/// A function of the squared distance and of the first coordinates of both points.
type OfDistance = fn(&Series, &Series, &Series) -> Series;

fn distance(formula: OfDistance) -> Formula<2> {
    Formula::new("formula", Vec::new(), move |_, x, y| {
        let square = (&x[0] - &y[0]).squared() + (&x[1] - &y[1]).squared();
        formula(&square, &x[0], &y[0])
    })
}

#[test]
fn kernels_with_small_negative_eigenvalues_are_refused() {
    let indefinite: [(&str, OfDistance); 4] = [
        // A cosine of the distance that stops at its first minimum; definite on no line.
        ("truncated cosine", |s, _, _| {
            if s.value() < 1.0 { (s.sqrt() * 3.0).cos() } else { s.constant(3.0_f64.cos()) }
        }),
        // Definite on lines, not in the plane.
        ("hat", |s, _, _| match s.value() {
            below if below < 0.09 => -(s.sqrt() / 0.3) + 1.0,
            _ => s.constant(0.0),
        }),
        // A power above two.
        ("exponential of a power", |s, _, _| match s.value() {
            0.0 => s.constant(1.0),
            _ => (-(s.powf(1.15))).exp(),
        }),
        // A millionth of the variance taken away from one function.
        ("squared exponential less a wave", |s, x, y| {
            (s * -0.5).exp() - (x * 20.0).sin() * (y * 20.0).sin() * 1e-6
        }),
    ];
    let refused = |formula: OfDistance| {
        let result = check_kernel(&distance(formula), &[], [0.0; 2], [1.0; 2], 1);
        result.unwrap_err().to_string()
    };
    for (name, formula) in indefinite {
        let text = refused(formula);
        let number = text.split("the eigenvalue ").nth(1).and_then(|rest| rest.split(' ').next());
        let eigenvalue: f64 = number.and_then(|number| number.parse().ok()).expect(&text);
        println!("{name}: {eigenvalue:.1e}");
        assert!(eigenvalue < -1e-7, "far beyond rounding: {name}, {eigenvalue}");
    }
    // Definite, but constant for Taylor series where points coincide.
    let constant = refused(|s, _, _| match s.value() {
        0.0 => s.constant(1.0),
        _ => (s.sqrt() * 3.0 + 1.0) * (s.sqrt() * -3.0).exp(),
    });
    assert!(constant.contains("0 in the table") && constant.contains("where x' = x"), "{constant}");
    let undefined = refused(|s, _, _| s.recip());
    assert!(undefined.contains("k(x, x') = inf"), "{undefined}");
}

#[test]
fn faults_are_found() {
    let fault = check_kernel(&skew(), &[], [0.0], [1.0], 1).unwrap_err();
    assert!(fault.to_string().contains("not symmetric"), "{fault}");
    let count = check_kernel(&skew(), &[1.0], [0.0], [1.0], 1).unwrap_err().to_string();
    assert_eq!(count, "1 hyperparameter values for a kernel that names 0");
    for (measure, value) in [
        (Measure::Number { lower: -1.0, upper: 2.0 }, 0.5),
        (Measure::Number { lower: 2.0, upper: 1.0 }, 0.5),
        (Measure::Length { axis: 1 }, 0.5),
        (Measure::Length { axis: 0 }, -0.5),
        (Measure::Length { axis: 0 }, f64::NAN),
    ] {
        let fault = check_kernel(&declared(measure), &[value], [0.0], [1.0], 1).unwrap_err();
        assert!(fault.to_string().contains("hyperparameter number of the"), "{fault}");
    }
}
