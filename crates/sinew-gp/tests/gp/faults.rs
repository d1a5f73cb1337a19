//! Answers that were wrong without a word.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, Fit, FitOptions, Functional, GpError, Model,
    Noise, Operator, Parameter, Periodicity, Prior, Problem, SemiLinear, Series, Side, Warning,
    constant, field, squared_exponential,
};
use std::f64::consts::PI;

fn normals(count: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
        radius * (2.0 * PI * random.random::<f64>()).cos()
    };
    (0..count).map(|_| normal()).collect()
}

fn model<const D: usize>(problem: &Problem<D>, data: Data<D>) -> Result<Model<D>, GpError> {
    Model::new(Prior::constrained(problem, &squared_exponential())?, data, Evidence::Auto)
}

fn fitted<const D: usize>(problem: &Problem<D>, data: Data<D>) -> Result<Fit<D>, GpError> {
    model(problem, data)?.fit(&FitOptions::default())
}

fn zero<const D: usize>() -> Condition<D> {
    Condition::Dirichlet(constant(0.0))
}

fn line() -> Result<(Domain<1>, Derivative<1>), GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    Ok((domain, dx))
}

/// Points from one end of the line to the other.
fn even(count: usize) -> Vec<[f64; 1]> {
    (0..count).map(|k| [k as f64 / (count - 1) as f64]).collect()
}

#[test]
fn an_equation_at_points_of_a_part_is_not_that_of_the_whole() -> Result<(), GpError> {
    // u_t = 0.1 u_xx up to t = 1/2, and a source later: u = sin(πx) g.
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let k = 0.1 * PI * PI;
    let g = |t: f64| {
        let s = (t - 0.5).max(0.0);
        let later = s * s / k - 2.0 * s / (k * k) - 2.0 / k.powi(3) * (-k * s).exp_m1();
        (-k * t).exp() + 20.0 * later
    };
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| (x * PI).sin()));
    let heat = Problem::new(domain.clone(), dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, start)?;
    let places = domain.sample(40, 5)?;
    let each = places.iter().zip(normals(40, 15));
    let y: Vec<f64> = each.map(|([x, t], e)| (PI * x).sin() * g(*t) + 0.01 * e).collect();
    let at: Vec<[f64; 2]> = domain.sample(30, 2)?.iter().map(|[x, t]| [*x, 0.5 * t]).collect();
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 30], Noise::Exact);
    let [lower, upper] = fitted(&heat, data)?.interval("D", 0.95)?;
    println!("D = 0.1 in {lower:.4} to {upper:.4}");
    assert!(lower < 0.1 && 0.1 < upper && upper - lower < 0.01, "{lower} {upper}");

    // Points of a line tell of no other.
    let along: Vec<[f64; 2]> = at.iter().map(|[x, _]| [*x, 0.3]).collect();
    let data = Data::new().values(&places, &y, Noise::Learned);
    let fit = fitted(&heat, data.equation(&along, &[0.0; 30], Noise::Exact))?;
    assert_eq!(fit.restarts.len(), FitOptions::default().restarts, "no point is added");

    // −D u″ = 1 on the left and more on the right.
    let (line, dx) = line()?;
    let d = Parameter::new("D", [0.05, 50.0])?;
    let rod = Problem::new(line, -1.0 * (&d * dx * dx))?.condition("x", Side::Lower, zero())?;
    let exact = |x: f64| 0.5 * x - x * x / 4.0 - 10.0 * (x - 0.5).max(0.0).powi(3) / 12.0;
    let places: Vec<[f64; 1]> = (0..25).map(|k| [0.02 + f64::from(k) * 0.04]).collect();
    let each = places.iter().zip(normals(25, 4));
    let y: Vec<f64> = each.map(|([x], e)| exact(*x) + 0.002 * e).collect();
    let at: Vec<[f64; 1]> = (0..12).map(|k| [0.02 + f64::from(k) * 0.46 / 11.0]).collect();
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[1.0; 12], Noise::Exact);
    let [lower, upper] = fitted(&rod, data)?.interval("D", 0.95)?;
    println!("D = 2 in {lower:.4} to {upper:.4}");
    assert!(lower < 2.0 && 2.0 < upper, "{lower} {upper}");
    Ok(())
}

#[test]
fn exact_values_of_several_groups_that_contradict_each_other_are_named() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let one = Derivative::identity();
    let free = Problem::new(line.clone(), dx * dx)?;
    let ring = free.clone().periodic("x", Periodicity::Value)?;
    let flat = Condition::Neumann(constant(0.0));
    let flat = free.clone().condition("x", Side::Lower, flat)?;
    let mean = Functional::integral(&line, one, 8)?;
    let two = || Data::new().values(&[[0.2], [0.5]], &[0.4, 1.0], Noise::Exact);
    let known = Noise::Known(0.01);
    // The last of each contradicts the others by `off`.
    let cases = |off: f64| -> Result<Vec<(&Problem<1>, Data<1>)>, GpError> {
        Ok(vec![
            (&free, two().values(&[[0.5], [0.9]], &[1.0 + off, 1.8], Noise::Exact)),
            (&free, two().imposed(2.0 * one, &[[0.5]], &[2.0 + off], Noise::Exact)),
            (
                &ring,
                Data::new().values(&[[0.0], [0.3], [1.0]], &[1.0, 0.5, 1.0 + off], Noise::Exact),
            ),
            (&free, {
                let data = Data::new().integral(&mean, 1.0, Noise::Exact)?;
                data.integral(&mean, 1.0 + off, Noise::Exact)?
            }),
            (&flat, two().imposed(dx, &[[0.0]], &[off], known)),
        ])
    };
    for (number, (problem, data)) in cases(0.0)?.into_iter().chain(cases(1.0)?).enumerate() {
        let warnings = fitted(problem, data)?.warnings()?;
        let named = warnings.iter().any(|w| matches!(w, Warning::Outlier { .. }));
        assert_eq!(named, number >= 5, "case {number}: {warnings:?}");
    }
    let twice = two().equation(&[[0.7]], &[0.0], Noise::Exact);
    let twice = model(&free, twice.equation(&[[0.7]], &[5.0], Noise::Exact)).unwrap_err();
    assert!(
        twice.to_string().contains("values 0 and 1 of the equation at (0.7) and (0.7)"),
        "{twice}"
    );
    // Exact values are not named for the jitter of a smooth kernel.
    let places = even(60);
    let [first, second] = [places[..].iter().step_by(2), places[1..].iter().step_by(2)]
        .map(|own| own.copied().collect::<Vec<_>>());
    let u = |x: &[f64; 1]| (3.0 * x[0]).sin() + (9.3 * x[0]).cos();
    let [u, twice] =
        [first.iter().map(u).collect::<Vec<_>>(), second.iter().map(|x| 2.0 * u(x)).collect()];
    let data = Data::new().values(&first, &u, Noise::Exact);
    let data = data.imposed(2.0 * one, &second, &twice, Noise::Exact);
    assert_eq!(fitted(&free, data)?.warnings()?, []);
    // Nor is a group without values.
    let data = two().values(&[], &[], Noise::Known(0.1)).equation_everywhere(constant(0.0));
    assert_eq!(fitted(&free, data)?.warnings()?, []);
    Ok(())
}

#[test]
fn a_level_of_noise_does_not_depend_on_the_zero_of_u() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let d = Parameter::new("D", [0.05, 50.0])?;
    let flat = Condition::Neumann(constant(0.0));
    let problem = Problem::new(line.clone(), &d * dx * dx)?.condition("x", Side::Lower, flat)?;
    let places = even(20);
    for (zero, sigma) in [(300.0, 0.003), (101_325.0, 1.0)] {
        let noise = |zero: f64| -> Result<f64, GpError> {
            let each = places.iter().zip(normals(20, 70));
            let y = each.map(|([x], e)| zero + sigma * (e - 20.0 * x * x)).collect::<Vec<_>>();
            let data = Data::new().values(&places, &y, Noise::Learned);
            let data = data.equation_everywhere(constant(-80.0 * sigma));
            fitted(&problem, data)?.parameter("noise 1")
        };
        let (offset, plain) = (noise(zero)?, noise(0.0)?);
        println!("{zero}: {:.3} of the noise, {:.3} about zero", offset / sigma, plain / sigma);
        assert!((offset / plain - 1.0).abs() < 0.05, "{offset} {plain}");
    }
    // Two values at one place that differ by three times the jitter that stands in for their noise, 1e-6: where z = 1 and 3/√2
    // are independent with variances that are multiples of a², d ln p / d ln a = z² − 2 summed up, and noise has no part in it.
    let free = Problem::new(line, Operator::identity())?;
    let prior = Prior::unconstrained(&free, &squared_exponential())?;
    let data = Data::new().values(&[[0.5]; 2], &[1.0, 1.0 + 3e-6], Noise::Learned);
    let model = Model::new(prior, data, Evidence::Joint)?;
    let gradient = model.evaluate(&[0.0, 0.0, 1e-9_f64.ln()])?.gradient;
    // Rounding of the pivot, 1e-16 of 2e-12.
    assert!((gradient[0] - 3.5).abs() < 1e-2 && gradient[2] == 0.0, "{gradient:?}");
    Ok(())
}

#[test]
fn averages_of_places_outside_of_the_domain_are_refused() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let problem = Problem::new(line.clone(), dx * dx)?;
    let places: Vec<[f64; 1]> = line.sample(2000, 1)?.iter().map(|[x]| [x * 1.02]).collect();
    let data = Data::new().values(&places, &[1.0; 2000], Noise::Learned).averaged(40);
    let refused = model(&problem, data).unwrap_err().to_string();
    assert!(refused.contains("lies outside the domain"), "{refused}");
    Ok(())
}

#[test]
#[should_panic(expected = "one cell at least")]
fn averages_over_no_cell_are_refused() {
    Data::<1>::new().averaged(0);
}

#[test]
fn a_few_values_bear_an_outlier() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let problem = Problem::new(line, dx * dx)?;
    let places = even(12);
    for (freedom, seed) in [(4.0, 51), (4.0, 52), (1.0, 53)] {
        let each = places.iter().zip(normals(12, seed));
        let mut y: Vec<f64> = each.map(|([x], e)| 2.0 * x + 0.02 * e).collect();
        y[4] += 9.0;
        let data = Data::new().values(&places, &y, Noise::StudentT(freedom));
        let fit = fitted(&problem, data.equation_everywhere(constant(0.0)))?;
        let (scale, u) = (fit.parameter("noise 1")?, fit.predict(&[[0.75]])?);
        println!("scale {scale:.4}, u {:.4} ± {:.4}", u.mean[0], u.standard_deviation[0]);
        assert!(scale < 0.05 && (u.mean[0] - 1.5).abs() < 0.03, "{scale} {u:?}");
        assert!(u.standard_deviation[0] < 0.03, "{u:?}");
    }
    Ok(())
}

#[test]
fn what_no_points_steps_or_units_help_says_so() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let says = |data: Data<1>, text: &str| {
        let problem = Problem::new(line.clone(), -(dx * dx));
        let refused = problem.and_then(|problem| model(&problem, data)).unwrap_err().to_string();
        assert!(refused.contains(text), "{refused}");
    };
    says(Data::new().values(&[[0.5]], &[1.0], Noise::Known(1e160)), "a finite square");
    let some = Data::new().values(&[[0.5]], &[1.0], Noise::Exact);
    says(some.values(&[], &[], Noise::StudentT(4.0)), "observation group 2 has no points");

    // −u″ = 1 between two insulated ends, and u″ + 3.6 eᵘ = 0 between two that are held, have no solution.
    let sealed = Problem::new(line.clone(), -(dx * dx))?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Neumann(constant(0.0)))?;
    let warnings = fitted(&sealed, Data::new().equation_everywhere(constant(1.0)))?.warnings()?;
    let stalled = |w: &Warning| matches!(w, Warning::Stalled { points } if *points < 200);
    assert!(warnings.iter().any(stalled), "{warnings:?}");
    let held = Problem::new(line, dx * dx)?.condition("x", Side::Lower, zero())?.condition(
        "x",
        Side::Upper,
        zero(),
    )?;
    let bratu = SemiLinear::new(held, [Derivative::identity()], |[u]| u.exp() * 3.6);
    let at: Vec<[f64; 1]> = (0..15).map(|k| [(f64::from(k) + 0.5) / 15.0]).collect();
    let own = Data::new().equation(&at, &[0.0; 15], Noise::Exact);
    for data in [own, Data::new().equation_everywhere(constant(0.0))] {
        let (kernel, options) = (squared_exponential(), FitOptions::default());
        let warnings = bratu.solve(&kernel, &data, &options, 20)?.fit.warnings()?;
        let lost = |w: &Warning| matches!(w, Warning::NotConverged { steps: 20, .. });
        assert!(warnings.iter().any(lost), "{warnings:?}");
    }
    Ok(())
}

#[test]
fn points_that_make_a_fit_worse_are_left_out_again() -> Result<(), GpError> {
    let square = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = square.derivatives();
    let mut problem = Problem::new(square, -(dx * dx) - dy * dy)?;
    for (axis, side) in ["x", "y"].iter().flat_map(|axis| Side::BOTH.map(|side| (axis, side))) {
        problem = problem.condition(axis, side, zero())?;
    }
    let model = model(&problem, Data::new().equation_everywhere(constant(1.0)))?;
    let fit = model.fit(&FitOptions { most_points: 100, ..FitOptions::default() })?;
    let u = fit.predict(&[[0.5, 0.5]])?;
    // Series of Saint-Venant's problem.
    let (off, sigma) = ((u.mean[0] - 0.073_671_35).abs(), u.standard_deviation[0]);
    println!("off by {off:.1e} ± {sigma:.1e}");
    assert!(off < 0.002 && off < 2.0 * sigma && sigma < 0.005, "{off} {sigma}");
    Ok(())
}

#[test]
fn a_load_too_narrow_for_most_places_is_seen() -> Result<(), GpError> {
    let (line, dx) = line()?;
    let problem = Problem::new(line, dx)?.condition("x", Side::Lower, zero())?;
    // An area of one within 0.004 of x = 0.2.
    let load = field(|[x]: [Series; 1]| {
        (((x - 0.2) / 0.002).squared() * -1.0).exp() / (0.002 * PI.sqrt()) + 1.0
    });
    let fit = fitted(&problem, Data::new().equation_everywhere(load))?;
    let (warnings, u) = (fit.warnings()?, fit.predict(&[[1.0]]));
    assert!(warnings.iter().any(|w| matches!(w, Warning::Unresolved { .. })), "{warnings:?}");
    assert!(u.is_err() || u.is_ok_and(|u| (u.mean[0] - 2.0).abs() < 3.0 * u.standard_deviation[0]));
    Ok(())
}
