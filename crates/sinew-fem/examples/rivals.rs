//! A ventricle under pressure, solved, and written for the other programs of `fixtures/rivals`: mesh, fibres and displacement as NumPy arrays in a folder.
//!
//! `RAYON_NUM_THREADS=1 cargo run -p sinew-fem --example rivals -- 4,48,40 automatic [FOLDER]`; `factor` and `aggregation` are the other methods.

use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_fem::{Method, Options, Solver};
use sinew_mesh::{TetMesh, VentricleShape, to_npy};
use std::error::Error;
use std::path::Path;

/// Parameters a \[kPa\], b, a_f \[kPa\] and b_f, and the pressure \[kPa\].
const THETA: [f64; 5] = [0.17, 2.4, 3.0, 2.5, 0.9];
const BULK_MODULUS: f64 = 25.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [cells, method, folder @ ..] = &arguments[..] else {
        return Err("cells through the wall, around and along, and a method".into());
    };
    let cells: Vec<usize> = cells.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let cells = cells.try_into().map_err(|_| "cells are three numbers, such as 4,48,40")?;
    let method = match method.as_str() {
        "automatic" => Method::Automatic,
        "aggregation" => Method::Aggregation,
        "factor" => Method::Factor,
        other => return Err(format!("no method {other}").into()),
    };
    let mesh = VentricleShape::new(&[])?.tetrahedra(cells)?;
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
    let fibres: Vec<[[f64; 3]; 1]> = frames.iter().map(|&[fibre, _, _]| [fibre]).collect();
    let body = body(mesh.clone(), fibres.clone())?;

    let [start, _] = process();
    let mut solver = Solver::new(&body)?;
    let [prepared, _] = process();
    let found = solver.solve(&THETA, &Options { method, ..Options::default() })?;
    let [solved, peak] = process();
    println!(
        "Sinew, {}: {} nodes, {} unknowns; prepared in {:.2} CPU s, solved in {:.2} CPU s; {} load steps, {} iterations, {} of conjugate gradients; \
         energy {:.14e}; {peak:.2} GB",
        if found.linear_iterations > 0 { "aggregation" } else { "factors" },
        body.nodes,
        solver.unknowns(),
        prepared - start,
        solved - prepared,
        found.load_steps,
        found.iterations(),
        found.linear_iterations,
        found.energy,
    );
    if let [folder] = folder {
        write(Path::new(folder), &mesh, fibres.as_flattened(), &found.displacement)?;
    }
    Ok(())
}

fn body(mesh: TetMesh, fibres: Vec<[[f64; 3]; 1]>) -> Result<Body, Box<dyn Error>> {
    let law = HolzapfelOgden.nearly_incompressible(BULK_MODULUS);
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let scene = Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 0.53..=1.33))
        .load(pressure)
        .support(Support::clamped("base"));
    Ok(scene.lower()?)
}

/// Writes `points`, `cells`, `fibres`, `endo`, `epi` and `base` (triangles) and `displacement`, all as floats.
fn write(
    folder: &Path,
    mesh: &TetMesh,
    fibres: &[[f64; 3]],
    displacement: &[f64],
) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let save = |name: &str, columns: usize, values: &[f64]| {
        let bytes = to_npy(&[values.len() / columns, columns], values);
        std::fs::write(folder.join(name).with_extension("npy"), bytes)
    };
    let floats = |nodes: Vec<usize>| nodes.iter().map(|&node| node as f64).collect::<Vec<_>>();
    save("points", 3, mesh.points.as_flattened())?;
    save("cells", 4, &floats(mesh.cells.concat()))?;
    save("fibres", 3, fibres.as_flattened())?;
    save("displacement", 3, displacement)?;
    for name in ["endo", "epi", "base"] {
        let facets = mesh.facet_sets[name].iter();
        let nodes = facets.flat_map(|&facet| mesh.nodes_of_facet(facet)).collect();
        save(name, 3, &floats(nodes))?;
    }
    Ok(())
}

/// CPU seconds of this process so far, and its largest resident memory \[GB\]; NaN where the system does not tell.
fn process() -> [f64; 2] {
    let read = |file: &str| std::fs::read_to_string(file).unwrap_or_default();
    let (stat, status) = (read("/proc/self/stat"), read("/proc/self/status"));
    // User and system time in hundredths of a second, after the name, which may hold spaces.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = fields.filter_map(|field| field.parse().ok()).collect();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak = peak.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    let seconds = if ticks.len() == 2 { (ticks[0] + ticks[1]) / 100.0 } else { f64::NAN };
    [seconds, peak.map_or(f64::NAN, |kb| kb / 1e6)]
}
