//! A kernel of one's own, from its formula: mirror images, for organs with two like halves.
//!
//! `cargo run --example own_kernel -p sinew-gp`
//!
//! A kernel needs a name, its hyperparameters, and one formula over Taylor series, from which every
//! derivative that an operator takes of it follows. `check_kernel` then tries it out.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, Formula, Hyperparameter, Measure, Model, Noise,
    Prior, Problem, Series, Side, check_kernel, constant, squared_exponential,
};
use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

/// ½ k(x, x′) + ½ k(x, 1 − x′) with a squared exponential k: functions with u(x) = u(1 − x).
fn mirrored() -> Formula<1> {
    // For a length along an axis, bounds and starts follow from the domain's extent.
    let length = Hyperparameter { name: "lengthscale", measure: Measure::Length { axis: 0 } };
    Formula::new("mirrored", vec![length], |lengths, [x]: &[Series; 1], [y]: &[Series; 1]| {
        let bell = |distance: Series| ((distance / &lengths[0]).squared() * -0.5).exp();
        (bell(x - y) + bell(x + y - 1.0)) * 0.5
    })
}

/// A deflection with two like halves.
fn deflection(x: f64) -> f64 {
    (PI * x).sin() + 0.3 * (5.0 * PI * x).sin()
}

/// The load that makes it: −u″.
fn load(x: f64) -> f64 {
    PI * PI * ((PI * x).sin() + 7.5 * (5.0 * PI * x).sin())
}

fn main() -> Result<(), Box<dyn Error>> {
    // Symmetric, positive definite, slopes right?
    check_kernel(&mirrored(), &[0.1], [0.0], [1.0], 1)?;

    // −u″ = f on [0, 1], zero at both ends; the load is known on the left half only.
    let string = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = string.derivatives();
    let problem = Problem::new(string.clone(), -(dx * dx))?
        .condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?;
    let at: Vec<[f64; 1]> = (0..10).map(|k| [(f64::from(k) + 0.5) / 20.0]).collect();
    let loads: Vec<f64> = at.iter().map(|[x]| load(*x)).collect();

    // The load is known where it is given only.
    let options = FitOptions { most_points: 0, ..FitOptions::default() };
    let solve = |kernel: &Formula<1>| -> Result<f64, Box<dyn Error>> {
        let start = Instant::now();
        let data = Data::new().equation(&at, &loads, Noise::Exact);
        let prior = Prior::constrained(&problem, kernel)?;
        let fit = Model::new(prior, data, Evidence::Auto)?.fit(&options)?;
        let grid = string.grid(201);
        let mean = fit.conditional()?.mean(&grid)?;
        let error =
            mean.iter().zip(&grid).map(|(u, [x])| (u - deflection(*x)).abs()).fold(0.0, f64::max);
        println!(
            "{}: largest error {error:.1e}, log evidence {:.1}, in {:.2} s",
            kernel.name,
            fit.outcome().log_evidence,
            start.elapsed().as_secs_f64()
        );
        Ok(error)
    };
    let (plain, halves) = (solve(&squared_exponential())?, solve(&mirrored())?);
    assert!(halves < 0.01 * plain, "the half that is known tells of the other");
    Ok(())
}

#[test]
fn the_numbers_of_own_kernel_hold() -> Result<(), Box<dyn Error>> {
    main()
}
