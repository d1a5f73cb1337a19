//! Flow through a pentagonal duct: Poisson's equation on a convex polygon, no mesh.
//!
//! `cargo run --example pentagon -p sinew-gp`
//!
//! −Δu = 4 with u = 0 on the walls. The prior vanishes on all five edges by construction, so all
//! points can be spent on the inside; −∂u/∂n on a wall is the shear that the fluid exerts on it.

use sinew_gp::{
    Data, Domain, Evidence, FitOptions, Model, Noise, Operator, Prior, Problem, constant,
    squared_exponential,
};
use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

/// u at the centre and −∂u/∂n amid an edge of the pentagon with corners on the unit circle, by
/// least squares with harmonic polynomials and poles outside the corners (Gopal & Trefethen 2019).
const CENTRE: f64 = 0.728_969_387_013;
const SHEAR: f64 = 2.061_258_750_772;

fn main() -> Result<(), Box<dyn Error>> {
    // Corners in order along the boundary; one lies on top, one edge at the bottom.
    let corner = |k: i32| PI * (0.5 + 0.4 * f64::from(k));
    let corners: Vec<[f64; 2]> = (0..5).map(|k| [corner(k).cos(), corner(k).sin()]).collect();
    let duct = Domain::polygon(["x", "y"], &corners)?;
    let [dx, dy] = duct.derivatives();
    let problem = Problem::new(duct.clone(), -(dx * dx) - dy * dy)?.boundary(constant(0.0))?;

    let amid_an_edge = [0.0, -(0.2 * PI).cos()];
    let mut error = f64::INFINITY;
    for count in [25, 50, 100, 200] {
        let start = Instant::now();
        let at = duct.sample(count, 3)?;
        let data = Data::new().equation(&at, &vec![4.0; count], Noise::Exact);
        let prior = Prior::constrained(&problem, &squared_exponential())?;
        let options = FitOptions {
            restarts: 2,
            iterations: 60,
            seed: 1,
            most_points: 0,
            ..FitOptions::default()
        };
        let fit = Model::new(prior, data, Evidence::Auto)?.fit(&options)?;

        // The solution, and its slope as an operator on it: both are Gaussian.
        let conditional = fit.conditional()?;
        let u = conditional.predict(&[[0.0, 0.0]])?;
        // The outward normal of the bottom edge is −y.
        let shear = conditional.predict_operator(&Operator::from(dy), &[amid_an_edge])?;
        error = (u.mean[0] - CENTRE).abs();
        println!(
            "{count:3} points: u {:.5} ± {:.0e}, error {error:.0e}; shear {:.4} ± {:.0e}, \
             error {:.0e}; {:.2} s",
            u.mean[0],
            u.standard_deviation[0],
            shear.mean[0],
            shear.standard_deviation[0],
            (shear.mean[0] - SHEAR).abs(),
            start.elapsed().as_secs_f64()
        );
    }
    assert!(error < 1e-3, "{error:e}");
    Ok(())
}

#[test]
fn the_numbers_of_pentagon_hold() -> Result<(), Box<dyn Error>> {
    main()
}
