//! Infers how fast a solute diffuses out of a slab of tissue, from 25 noisy concentrations.
//!
//! `cargo run --example diffusivity -p sinew-gp`
//!
//! One millimetre of cartilage, sealed below (x = 0) and washed above (x = 1), loses what it was
//! loaded with: u_t = D u_xx. Wanted are D with an interval, and how much left within the hour.

use rand::{RngExt, SeedableRng};
use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, Functional, Model, Noise, NutsOptions,
    Parameter, Prior, Problem, Side, constant, field, nuts, squared_exponential,
};
use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

/// The truth, to be found again [mm²/h].
const DIFFUSIVITY: f64 = 0.3;
/// Standard deviation of the instrument; concentrations run from 0 to 1.
const ERROR: f64 = 0.02;

fn exact([x, t]: [f64; 2]) -> f64 {
    (FRAC_PI_2 * x).cos() * (-DIFFUSIVITY * FRAC_PI_2 * FRAC_PI_2 * t).exp()
}

fn main() -> Result<(), Box<dyn Error>> {
    // The problem, as on paper.
    let slab = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = slab.derivatives();
    let diffusivity = Parameter::new("diffusivity", [0.01, 10.0])?;
    let loaded = field(|[x, _]| (x * FRAC_PI_2).cos());
    let problem = Problem::new(slab.clone(), dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition("t", Side::Lower, Condition::Dirichlet(loaded))?;

    // What is measured, and where the equation is imposed.
    let mut random = rand::rngs::ChaCha8Rng::seed_from_u64(7);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let places = slab.sample(25, 1)?;
    let measured: Vec<f64> = places.iter().map(|x| exact(*x) + ERROR * normal()).collect();
    let data = Data::new().values(&places, &measured, Noise::Learned).equation(
        &slab.sample(25, 2)?,
        &[0.0; 25],
        Noise::Exact,
    );

    // The most probable diffusivity.
    let start = Instant::now();
    let prior = Prior::constrained(&problem, &squared_exponential())?;
    let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
    let found = fit.parameter("diffusivity")?;
    println!(
        "D = {found:.4} mm²/h, error {:.1} %, in {:.2} s",
        100.0 * (found / DIFFUSIVITY - 1.0).abs(),
        start.elapsed().as_secs_f64()
    );

    // An interval that includes what is not known of lengthscales, amplitudes and noise.
    let start = Instant::now();
    let ensemble = nuts(&fit, &NutsOptions::default())?;
    let [lower, upper] = ensemble.interval("diffusivity", 0.95)?;
    println!("95 %: [{lower:.4}, {upper:.4}], in {:.2} s", start.elapsed().as_secs_f64());

    // What left through the washed face, −∫ D u_x dt, each drawn D with its own slope.
    let start = Instant::now();
    let flux = Functional::face_integral(&slab, ("x", Side::Upper), -(&diffusivity * dx), 8)?;
    let (lost, uncertainty) = ensemble.predict_functional(&flux)?;
    let truth = (1.0 - exact([0.0, 1.0])) / FRAC_PI_2;
    println!(
        "lost in one hour: {lost:.4} ± {uncertainty:.4} mm, error {:.4}, in {:.2} s",
        (lost - truth).abs(),
        start.elapsed().as_secs_f64()
    );

    assert!((found / DIFFUSIVITY - 1.0).abs() < 0.01, "D as the data were made");
    assert!(lower < DIFFUSIVITY && DIFFUSIVITY < upper, "the interval holds the truth");
    assert!((lost - truth).abs() < 3.0 * uncertainty, "and so does that of the loss");
    Ok(())
}

#[test]
fn the_numbers_of_diffusivity_hold() -> Result<(), Box<dyn Error>> {
    main()
}
