//! Shared parts of the thick spheres and cylinders.

use crate::verify::case::{Band, Formulation, Label, Rows};
use crate::verify::reference::RADII;
use crate::verify::solve::Found;
use anyhow::Result;
use sinew_energy::Support;

/// Displacements of both surfaces of an incompressible wall beside the exact radii.
pub(super) fn surfaces(
    rows: &mut Rows,
    (setup, band): (String, Band),
    found: &Found,
    (dimension, kind): (usize, &str),
    exact: [f64; 2],
) -> Result<()> {
    for ((side, exact), rest) in ["inner", "outer"].into_iter().zip(exact).zip(RADII) {
        let value = outward(found, side, dimension);
        let quantity = format!("displacement of the {side} surface{kind}");
        let label = Label::new(Formulation::Mixed, setup.clone(), quantity);
        rows.relative(label, [value, exact - rest], band, found.cost)?;
    }
    Ok(())
}

/// Planes of symmetry of an octant.
pub(super) const OCTANT: [(&str, usize); 3] = [("x_min", 0), ("y_min", 1), ("z_min", 2)];

/// A mesh of an octant in words.
pub(super) fn octant([layers, across]: [usize; 2]) -> String {
    format!("{layers} layers, {across}² × 3 cells")
}

/// Sides that slide in their planes.
pub(super) fn rollers(sides: &[(&str, usize)]) -> Vec<Support> {
    let roller = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
    sides.iter().map(|&(side, axis)| Support::uniform(side, roller(axis))).collect()
}

/// Mean displacement of a side away from the centre; for cylinders from the z axis, along which nothing moves.
pub(super) fn outward(found: &Found, side: &str, dimension: usize) -> f64 {
    let nodes = &found.body.mesh.node_sets()[side];
    let moved = |&node: &usize| {
        let (mut before, mut after) = (0.0, 0.0);
        for i in 0..dimension {
            let x = found.body.positions[node][i];
            before += x * x;
            after += (x + found.solution.displacement[3 * node + i]).powi(2);
        }
        f64::sqrt(after) - f64::sqrt(before)
    };
    nodes.iter().map(moved).sum::<f64>() / nodes.len() as f64
}
