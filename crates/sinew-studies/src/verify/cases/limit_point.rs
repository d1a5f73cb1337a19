//! The largest pressure that a thick sphere bears.

use super::radial::{OCTANT, RADII, inflation, octant, outward, rollers};
use crate::verify::case::{Band, Case, Cost, Effort, Formulation, Label, Rows};
use crate::verify::reference::{LimitPoint, ThickSphere};
use crate::verify::solve::scene;
use anyhow::{Context, Result};
use sinew_energy::laws::NeoHookean;
use sinew_fem::{Line, Options, Solver};
use sinew_mesh::sphere_octant;
use std::f64::consts::PI;
use std::time::Instant;

const THETA: [f64; 2] = [1.0, 10.0];
/// Deformed inner radii over the one at rest; the pressure rises up to 1.83 and falls beyond.
const STRETCHES: [f64; 9] = [1.1, 1.3, 1.5, 1.7, 1.8, 1.9, 2.1, 2.5, 3.0];
/// The three around the limit point, through which a parabola is laid.
const AROUND: [usize; 3] = [3, 4, 5];
/// Longest step along the curve of equilibria.
const LONGEST: f64 = 0.3;
/// Wanted quantity.
const BAND: Band = Band::below(0.005);
/// The coarse mesh of a quick run.
const COARSE: Band = Band::below(0.02);

/// Both branches of the pressure over the volume, through the limit point, by prescribing the volume.
pub(super) const CASE: Case = Case {
    name: "limit-point",
    title: "Limit point of the thick incompressible sphere by prescribed volume, both branches",
    provenance: "Closed form of Green and Adkins; its maximum from the root of the derivative (p/μ = 0.81642 at a/A = 1.8281).",
    run,
};

fn run(effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
    let (cells, band) = match effort {
        Effort::Quick => ([2, 3], COARSE),
        Effort::Full => ([3, 5], BAND),
    };
    let closed = ThickSphere { shear: THETA[0], inner: RADII[0], outer: RADII[1] };
    let mesh = sphere_octant(RADII, cells).quadratic_tetrahedra();
    let supports = rollers(&OCTANT);
    let sphere = scene(mesh, NeoHookean, &THETA, inflation(1.0), supports).mixed();
    let start = Instant::now();
    let body = sphere.lower()?;
    let mut solver = Solver::new(&body)?;
    let unknowns = solver.unknowns() + solver.pressures();
    let volumes =
        STRETCHES.map(|a| PI / 6.0 * (a * RADII[0]).powi(3) - PI / 6.0 * RADII[0].powi(3));
    let trace = solver.trace_volume(&THETA, &volumes, &Options::default())?;
    let cost = Cost::since(start, unknowns);
    let setup = octant(cells);
    let mut path = Vec::with_capacity(trace.len());
    for (step, a) in trace.iter().zip(STRETCHES) {
        let pressure = step.solution.load_factor;
        let found = 1.0 + outward(&sphere.mesh, "inner", &step.solution.displacement, 3) / RADII[0];
        path.push([found, pressure]);
        let label = Label::new(
            Formulation::Mixed,
            format!("{setup}, volume of a/A = {a}"),
            "pressure over μ",
        );
        rows.relative(label, [pressure, closed.pressure(a * RADII[0])], band, cost)?;
    }
    let around = AROUND.map(|index| path.get(index).copied());
    let [Some(a), Some(b), Some(c)] = around else {
        anyhow::bail!("the path ended after {} of {} volumes", path.len(), STRETCHES.len());
    };
    let [stretch, pressure] =
        parabola_top([a, b, c]).context("the pressure has no maximum on the path")?;
    let exact: LimitPoint = closed.limit_point()?;
    let label = |what: &str| Label::new(Formulation::Mixed, setup.clone(), what);
    rows.relative(label("largest pressure over μ"), [pressure, exact.pressure], band, cost)?;
    rows.relative(label("stretch at the largest pressure"), [stretch, exact.stretch], band, cost)?;
    let (start, top) = (Instant::now(), top_by_length(&mut solver)?);
    let label = Label::new(
        Formulation::Mixed,
        format!("{setup}, by the length of the curve"),
        "largest pressure over μ",
    );
    rows.relative(label, [top, exact.pressure], band, Cost::since(start, unknowns))
}

/// The largest pressure along the curve of equilibria over the load, followed until it falls.
fn top_by_length(solver: &mut Solver<'_>) -> Result<f64> {
    let line = Line::of_loads(&THETA);
    let curve = solver.follow(&line, &Options::default())?.with_longest_step(LONGEST)?;
    let mut last = Vec::new();
    for point in curve {
        let point = point?;
        last.push([point.length, point.solution.load_factor]);
        if let [.., a, b, c] = last[..]
            && c[1] < b[1]
        {
            let [_, pressure] = parabola_top([a, b, c]).context("the pressure has no maximum")?;
            return Ok(pressure);
        }
    }
    anyhow::bail!("the pressure rises all along the curve")
}

/// The highest point of the parabola through three points.
fn parabola_top([a, b, c]: [[f64; 2]; 3]) -> Option<[f64; 2]> {
    let first = (b[1] - a[1]) / (b[0] - a[0]);
    let second = (c[1] - b[1]) / (c[0] - b[0]);
    let curvature = (second - first) / (c[0] - a[0]);
    let at = 0.5 * (a[0] + b[0] - first / curvature);
    let top = a[1] + (at - a[0]) * (first + curvature * (at - b[0]));
    (curvature < 0.0 && at.is_finite()).then_some([at, top])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_have_their_top() {
        let f = |x: f64| 3.0 - 2.0 * (x - 1.8).powi(2);
        let [at, top] = parabola_top([1.7, 1.9, 2.3].map(|x| [x, f(x)])).unwrap();
        assert!((at - 1.8).abs() < 1e-12 && (top - 3.0).abs() < 1e-12);
        assert_eq!(parabola_top([1.0, 2.0, 3.0].map(|x| [x, x * x])), None);
    }
}
