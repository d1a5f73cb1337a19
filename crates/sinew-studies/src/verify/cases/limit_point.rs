//! The largest pressure that a thick sphere bears.

use super::radial::{OCTANT, octant, rollers};
use crate::verify::case::{Band, Case, Cost, Effort, Formulation, Label, Rows};
use crate::verify::reference::{RADII, sphere_limit_point, sphere_pressure};
use crate::verify::solids::shells::sphere_octant;
use crate::verify::solve::{pressed, scene};
use anyhow::{Context, Result};
use sinew_energy::laws::NeoHookean;
use sinew_fem::{Line, Options, Solver};
use std::f64::consts::PI;
use std::time::Instant;

const THETA: [f64; 2] = [1.0, 10.0];
/// Inner radius over the one at rest at which the curve ends; the pressure rises up to 1.83 and falls beyond.
const LAST: f64 = 3.0;
/// Longest step along the curve of equilibria.
const LONGEST: f64 = 0.3;
/// Wanted quantity.
const BAND: Band = Band::below(0.005);
/// The coarse mesh of a quick run.
const COARSE: Band = Band::below(0.02);

/// Both branches of the pressure over the volume, through the limit point.
pub(super) const CASE: Case = Case {
    name: "limit-point",
    title: "Limit point of the thick incompressible sphere by arc length, both branches",
    provenance: "Closed form of Green and Adkins; its maximum from the root of the derivative (p/μ = 0.81642 at a/A = 1.8281).",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let (cells, band) = match effort {
        Effort::Quick => ([2, 3], COARSE),
        Effort::Full => ([3, 5], BAND),
    };
    let mesh = sphere_octant(RADII, cells).quadratic_tetrahedra();
    let supports = rollers(&OCTANT);
    let sphere = scene(mesh, NeoHookean, &THETA, pressed("inner", 1.0), supports).mixed();
    let start = Instant::now();
    let body = sphere.lower()?;
    let mut solver = Solver::new(&body)?;
    let unknowns = solver.unknowns() + solver.pressures();
    let curve = solver.follow(&Line::of_loads(&THETA), &Options::default())?;
    let mut path = Vec::new();
    for point in curve.with_longest_step(LONGEST)?.skip(1) {
        let solution = point?.solution;
        // An octant of the cavity, by the volume that its wall has swept.
        let swept = -body.pressures[0].value(&solution.displacement, &THETA);
        let stretch = (1.0 + 6.0 * swept / (PI * RADII[0].powi(3))).cbrt();
        path.push([stretch, solution.load_factor]);
        if stretch > LAST {
            break;
        }
    }
    let cost = Cost::since(start, unknowns);
    let setup = octant(cells);
    let label = |what: &str| Label::new(Formulation::Mixed, setup.clone(), what);
    let top = path.iter().map(|[_, pressure]| *pressure).fold(0.0, f64::max);
    let top = path.iter().position(|[_, pressure]| *pressure == top).unwrap_or_default();
    let around = top.checked_sub(1).and_then(|before| path.get(before..top + 2));
    let Some(&[a, b, c]) = around else {
        anyhow::bail!("the pressure has no maximum on the path of {} equilibria", path.len());
    };
    for [stretch, pressure] in [path[0], a, c, path[path.len() - 1]] {
        let label = label(&format!("pressure over μ at a/A = {stretch:.2}"));
        rows.relative(label, [pressure, sphere_pressure(stretch * RADII[0])], band, cost)?;
    }
    let [stretch, pressure] =
        parabola_top([a, b, c]).context("the pressure has no maximum on the path")?;
    let [exact_stretch, exact] = sphere_limit_point()?;
    rows.relative(label("largest pressure over μ"), [pressure, exact], band, cost)?;
    rows.relative(label("stretch at the largest pressure"), [stretch, exact_stretch], band, cost)
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
