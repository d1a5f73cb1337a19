//! The book's second page: a left ventricle that its cavity's pressure fills.
//!
//! `cargo run -p sinew --example book_ventricle`

use sinew::laws::HolzapfelOgden;
use sinew::{Law, Load, Options, Parameter, Scene, Solver, Support};
use sinew_energy::Magnitude;
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_mesh::TruncatedEllipsoid;
use std::error::Error;
use std::f64::consts::PI;

/// One millimetre of mercury [kPa].
const MMHG: f64 = 0.133322;

fn main() -> Result<(), Box<dyn Error>> {
    // The wall between two half ellipsoids [mm]: 2 layers, 32 cells around, 16 from the apex to the base.
    let shape = TruncatedEllipsoid { short: [22.0, 36.0], long: [58.0, 74.0], base: 0.0 };
    let mesh = shape.wall([2, 32, 16]).tetrahedra();

    // Fibres turn from +60° at the endocardium to −60° at the epicardium.
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
    let fibres = frames.iter().map(|&[fibre, _sheet, _normal]| [fibre]).collect();

    // A law that reads one direction, and the pressure of the cavity as the fifth entry of θ.
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let law = HolzapfelOgden.nearly_incompressible(25.0); // K [kPa]
    let scene = Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 4.0 * MMHG..=10.0 * MMHG))
        .load(pressure)
        .support(Support::clamped("base"));
    let body = scene.lower()?;

    // Empty: the facets of the endocardium are chords of half an ellipsoid, and lie inside it.
    let rest = vec![0.0; 3 * body.nodes];
    let empty = body.cavity_volumes(&rest)[0];
    let half_ellipsoid = 2.0 / 3.0 * PI * 22.0 * 22.0 * 58.0;
    println!("at rest {:.2} ml, the ellipsoid {:.2} ml", empty / 1e3, half_ellipsoid / 1e3);
    assert!((0.98..1.0).contains(&(empty / half_ellipsoid)), "{}", empty / half_ellipsoid);

    // Filled at 8 mmHg.
    let mut solver = Solver::new(&body)?;
    let filled_at = |solver: &mut Solver, p: f64| {
        solver.solve(&[0.18, 2.6, 3.34, 2.73, p], &Options::default())
    };
    let p = 8.0 * MMHG;
    let solution = filled_at(&mut solver, p)?;
    let filled = body.cavity_volumes(&solution.displacement)[0];
    println!(
        "at 8 mmHg {:.2} ml, {} Newton iterations, {:.2} s",
        filled / 1e3,
        solution.iterations(),
        solution.seconds
    );
    assert!(solution.is_stable());

    // The energy of the equilibrium falls with the pressure by what the cavity has taken in, dΠ/dp = −(V − V₀).
    let step = 1e-3 * p;
    let [less, more] = [filled_at(&mut solver, p - step)?, filled_at(&mut solver, p + step)?];
    let slope = (more.energy - less.energy) / (2.0 * step);
    let taken_in = filled - empty;
    println!("V − V₀ = {:.4} ml, −dΠ/dp = {:.4} ml", taken_in / 1e3, -slope / 1e3);
    assert!((slope / taken_in + 1.0).abs() < 1e-5, "an equilibrium of the potential");
    Ok(())
}

#[test]
fn the_numbers_of_book_ventricle_hold() -> Result<(), Box<dyn Error>> {
    main()
}
