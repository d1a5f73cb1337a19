//! Sinew on one mesh, which is written for the others.

use super::{Arguments, Kind};
use crate::measure::by_size::peak_gb;
use crate::measure::mean_ventricle::{THETA, fibres, scene};
use crate::measure::rivals::table::{Own, Solved};
use crate::program::cpu_seconds_of;
use crate::ventricle_shape::VentricleShape;
use anyhow::{Context, Result};
use sinew_energy::Body;
use sinew_fem::{Method, Options, Solver};
use sinew_mesh::{AnyMesh, Mesh, to_npy};
use sinew_num::{dot3, norm};
use std::path::Path;

/// Prints the row as JSON, and writes mesh, fibres and displacement into the folder.
pub(super) fn run(arguments: &Arguments, folder: &Path) -> Result<()> {
    let cells = arguments.cells[0];
    let shape = VentricleShape::new(&[])?;
    let linear = shape.tetrahedra(cells)?;
    let fibres = fibres(&linear, ["endo", "epi", "base"])?;
    match arguments.elements[0] {
        Kind::Linear => solved(&linear, fibres, arguments, folder),
        Kind::Quadratic => solved(&linear.quadratic(), fibres, arguments, folder),
        Kind::Hexahedra => {
            // Each is cut into the next six tetrahedra.
            let fibres = fibres.chunks_exact(6).map(mean).collect();
            solved(&shape.hexahedra(cells)?, fibres, arguments, folder)
        }
    }
}

/// Mean of directions, which have no sense.
fn mean(directions: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for d in directions {
        let sign = dot3(d, &directions[0]).signum();
        (0..3).for_each(|i| sum[i] += sign * d[i]);
    }
    sum.map(|x| x / norm(&sum))
}

fn solved<const N: usize>(
    mesh: &Mesh<N>,
    fibres: Vec<[f64; 3]>,
    arguments: &Arguments,
    folder: &Path,
) -> Result<()>
where
    Mesh<N>: Into<AnyMesh>,
{
    let method = if arguments.factor { Method::Factor } else { Method::Automatic };
    let scene = scene(mesh.clone(), fibres.clone(), arguments.bulk_modulus);
    let (mut setup_s, mut solve_s, mut found) = (f64::INFINITY, f64::INFINITY, None);
    for _ in 0..2 {
        let prepare = || {
            let body: Body = scene.clone().lower()?;
            Ok(Solver::new(&body).map(drop)?)
        };
        setup_s = cpu_seconds_of(false, prepare)?.min(setup_s);
        let body = scene.clone().lower()?;
        let mut solver = Solver::new(&body)?;
        let solve = || {
            found = Some(solver.solve(&THETA, &Options { method, ..Options::default() })?);
            Ok(())
        };
        solve_s = cpu_seconds_of(false, solve)?.min(solve_s);
    }
    let found = found.context("no solve ran")?;
    let apex = mesh.node_sets["apex_endo"][0];
    let iterates = found.linear_iterations > 0;
    let row = Own {
        nodes: mesh.points.len(),
        cells: mesh.cells.len(),
        solved: Solved {
            version: env!("CARGO_PKG_VERSION").into(),
            solver: if iterates { "conjugate gradients" } else { "sparse Cholesky" }.into(),
            import_s: 0.0,
            compile_s: 0.0,
            setup_s,
            solve_s,
            assembly_s: None,
            load_steps: found.load_steps,
            iterations: found.iterations(),
            linear_iterations: found.linear_iterations,
            energy: found.energy,
            energy_apart: 0.0,
            apex: std::array::from_fn(|i| found.displacement[3 * apex + i]),
            apart: 0.0,
            peak_gb: peak_gb(),
        },
    };
    write(folder, mesh, &fibres, &found.displacement)?;
    println!("{}", serde_json::to_string(&row)?);
    Ok(())
}

/// Writes `points`, `cells`, `fibres`, `endo`, `epi` and `base` (nodes of facets) and `displacement`, all as floats.
fn write<const N: usize>(
    folder: &Path,
    mesh: &Mesh<N>,
    fibres: &[[f64; 3]],
    displacement: &[f64],
) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let save = |name: &str, columns: usize, values: &[f64]| {
        let bytes = to_npy(&[values.len() / columns, columns], values);
        std::fs::write(folder.join(name).with_extension("npy"), bytes)
    };
    let floats = |nodes: Vec<usize>| nodes.iter().map(|&node| node as f64).collect::<Vec<_>>();
    save("points", 3, mesh.points.as_flattened())?;
    save("cells", N, &floats(mesh.cells.concat()))?;
    save("fibres", 3, fibres.as_flattened())?;
    save("displacement", 3, displacement)?;
    for name in ["endo", "epi", "base"] {
        let facets = mesh.facet_sets[name].iter();
        let nodes = facets.flat_map(|&facet| mesh.nodes_of_facet(facet)).collect();
        save(name, Mesh::<N>::ELEMENT.facets[0].len(), &floats(nodes))?;
    }
    Ok(())
}
