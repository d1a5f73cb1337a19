//! An emulator of a left ventricle with fibres under pressure: Holzapfel–Ogden, θ = (a, b, a_f, b_f, p).
//!
//! ```sh
//! cargo run -p sinew-emulate --features terminal --example ventricle -- fixtures/organ/ventricle.vtk 100
//! ```
//!
//! The mesh has a facet set `region:1` (the endocardium), a point field `clamped` and a cell field `fibre`; the number is
//! that of the simulations for a regression. Prints errors on 100 test cases, raw and corrected, and times.

use sinew_emulate::recipe::Regression;
use sinew_emulate::{Body, Design, Recipe, Terminal, TestSet, TrainingOptions, simulate};
use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_mesh::read_tet_mesh;
use std::error::Error;
use std::path::Path;

/// One millimetre of mercury [kPa].
const MMHG: f64 = 0.133_322;

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "usage: ventricle MESH.vtk SIMULATIONS";
    let mut arguments = std::env::args().skip(1);
    let body = ventricle(Path::new(&arguments.next().ok_or(usage)?))?;
    let simulations: usize = arguments.next().ok_or(usage)?.parse()?;
    let recipe: Recipe =
        Regression { simulations, most: simulations, ..Regression::default() }.into();
    let mut terminal = Terminal::default();
    let emulator = recipe.train(&body, &TrainingOptions::default(), &mut terminal)?;
    let thetas = Design::Uniform.sample(&body.parameters, 100, 99)?;
    let test = TestSet::new(&body, simulate(&body, &thetas, "simulate test", None, &mut terminal)?);
    let found = emulator.evaluate(&test, 2)?;

    println!("{:?}", emulator.record.calibration);
    let corrected = found.corrected.iter().map(|corrected| (corrected.steps, &corrected.errors));
    for (steps, errors) in std::iter::once((0, &found.raw)).chain(corrected) {
        let volume = errors.err_volume.map_or(f64::NAN, |volume| volume.q50);
        println!(
            "{steps} corrections: err_u {:.1e} mm (largest {:.1e}), err_F {:.1e} %, err_I1 {:.1e} %, err_Pi {:.1e} %, volume {volume:.1e} %",
            errors.err_u.q50,
            errors.err_u.max,
            errors.err_f.q50,
            errors.err_i1.q50,
            errors.err_pi.q50
        );
    }
    println!("estimates within a factor of two: {:.0} %", 100.0 * found.within_two);
    println!("{:#?}", found.times);
    Ok(())
}

fn ventricle(path: &Path) -> Result<Body, Box<dyn Error>> {
    let (mut mesh, _) = read_tet_mesh(path)?;
    let base = mesh.nodes_where_nonzero("clamped")?;
    mesh.node_sets.insert("base".into(), base);
    let field = mesh.cell_fields.get("fibre").ok_or("the mesh has no cell field `fibre`")?;
    let fibres = field.to_vectors::<3>().ok_or("`fibre` has not three components")?;
    let pressure = Load::Pressure { facets: "region:1".into(), magnitude: Magnitude::Theta(4) };
    let mut scene = Scene::new(mesh, HolzapfelOgden.nearly_incompressible(25.0))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::log("p", "kPa", 4.0 * MMHG..=10.0 * MMHG))
        .load(pressure)
        .support(Support::clamped("base"));
    scene.directions = fibres.into_iter().map(|fibre| [fibre]).collect();
    Ok(scene.lower()?)
}
