//! Thick spheres and cylinders under internal pressure: incompressible, to the largest pressure, and the locking ladder.

use crate::verify::case::{Band, Case, Cost, Effort, Formulation, Label, Rows};
use crate::verify::cases::boxes::boxes;
use crate::verify::reference::{
    RADII, inflated_sphere, outer_radius, sphere_limit_point, sphere_pressure, tube_pressure,
};
use crate::verify::solids::shells::{cylinder_quarter, sphere_octant};
use crate::verify::solve::{Found, displaced, mixed, pressed, scene};
use anyhow::{Context, Result};
use sinew_energy::Support;
use sinew_energy::laws::NeoHookean;
use sinew_fem::{Line, Options, Solver};
use sinew_mesh::{AnyMesh, Mesh, rectangle_triangles};
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Instant;

/// Displacements of both surfaces of an incompressible wall beside the exact radii.
fn surfaces(
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
const OCTANT: [(&str, usize); 3] = [("x_min", 0), ("y_min", 1), ("z_min", 2)];

fn octant([layers, across]: [usize; 2]) -> String {
    format!("{layers} layers, {across}² × 3 cells")
}

/// Sides that slide in their planes.
pub(super) fn rollers(sides: &[(&str, usize)]) -> Vec<Support> {
    let roller = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
    sides.iter().map(|&(side, axis)| Support::uniform(side, roller(axis))).collect()
}

/// Mean displacement of a side away from the centre; for cylinders from the z axis, along which nothing moves.
fn outward(found: &Found, side: &str, dimension: usize) -> f64 {
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

/// μ, and a λ that no incompressible solution feels.
const THETA: [f64; 2] = [1.0, 10.0];
/// Deformed inner radius.
const INFLATED: f64 = 1.3;

/// Layers and cells along an edge of the cube, with the bands.
const SPHERES: &[([usize; 2], Band)] = &[
    ([1, 2], Band::below(0.09)),
    ([2, 3], Band::below(0.01)),
    ([3, 4], Band::below(0.003)),
    ([4, 6], Band::below(0.001)),
];

/// An octant of an incompressible sphere, blown up by a third of its inner radius.
pub(super) const SPHERE: Case = Case {
    name: "sphere",
    title: "Thick incompressible sphere (1 : 2) under internal follower pressure",
    provenance: "Closed form p = μ[2/λ_b + 1/(2λ_b⁴) − 2/λ_a − 1/(2λ_a⁴)] of Green and Adkins.",
    run: run_sphere,
};

fn run_sphere(effort: Effort, rows: &mut Rows) -> Result<()> {
    let pressure = sphere_pressure(INFLATED);
    for &(cells, band) in effort.levels(2, SPHERES) {
        let mesh = sphere_octant(RADII, cells).quadratic_tetrahedra();
        let supports = rollers(&OCTANT);
        let sphere = scene(mesh, NeoHookean, &THETA, pressed("inner", pressure), supports);
        let found = mixed(sphere, 0.0, &THETA)?;
        let setup = octant(cells);
        let exact = [INFLATED, outer_radius(3, INFLATED)];
        surfaces(rows, (setup, band), &found, (3, ""), exact)?;
    }
    Ok(())
}

const PLANE: &[([usize; 2], Band)] =
    &[([2, 4], Band::below(0.01)), ([4, 8], Band::below(0.002)), ([8, 16], Band::below(0.001))];
const SOLID: &[([usize; 2], Band)] = &[([2, 4], Band::below(0.003)), ([4, 8], Band::below(5e-4))];

/// A quarter of a long tube, as triangles in plane strain and as tetrahedra between two sliding planes.
pub(super) const CYLINDER: Case = Case {
    name: "cylinder",
    title: "Thick incompressible cylinder (1 : 2) in plane strain under internal follower pressure",
    provenance: "Closed form p = μ[ln(B/A) − ln(b/a) + ½(a² − A²)(a⁻² − b⁻²)].",
    run: run_cylinder,
};

fn run_cylinder(effort: Effort, rows: &mut Rows) -> Result<()> {
    let planes = [("x_min", 0), ("y_min", 1)];
    for &(cells, band) in effort.levels(2, PLANE) {
        let setup = format!("{}×{} quads in plane strain", cells[0], cells[1]);
        compare(rows, ring(cells), rollers(&planes), (setup, band))?;
    }
    let slides = [("x_min", 0), ("y_min", 1), ("z_min", 2), ("z_max", 2)];
    for &([layers, around], band) in effort.levels(1, SOLID) {
        let wall = cylinder_quarter(RADII, 0.5, [layers, around, 1]);
        let setup = boxes([layers, around, 1]);
        compare(rows, wall.quadratic_tetrahedra(), rollers(&slides), (setup, band))?;
    }
    Ok(())
}

/// A quarter of a ring; its sides have the names of [`cylinder_quarter`].
fn ring([layers, around]: [usize; 2]) -> Mesh<6> {
    let mut mesh = rectangle_triangles([1.0; 2], [layers, around]).quadratic();
    mesh.map_points(|[depth, turn, _]| {
        let radius = (1.0 - depth) * RADII[0] + depth * RADII[1];
        // Both are sines, so that the planes of symmetry are met exactly.
        [radius * (FRAC_PI_2 * (1.0 - turn)).sin(), radius * (FRAC_PI_2 * turn).sin(), 0.0]
    });
    let sides = [("x_min", "inner"), ("x_max", "outer"), ("y_min", "y_min"), ("y_max", "x_min")];
    let renamed =
        |old: &str| sides.iter().find(|side| side.0 == old).map_or(old, |side| side.1).to_string();
    mesh.node_sets = mesh.node_sets.into_iter().map(|(name, set)| (renamed(&name), set)).collect();
    mesh.facet_sets =
        mesh.facet_sets.into_iter().map(|(name, set)| (renamed(&name), set)).collect();
    mesh
}

fn compare(
    rows: &mut Rows,
    mesh: impl Into<AnyMesh>,
    supports: Vec<Support>,
    meshed: (String, Band),
) -> Result<()> {
    let loads = pressed("inner", tube_pressure(INFLATED));
    let tube = scene(mesh, NeoHookean, &THETA, loads, supports);
    let found = mixed(tube, 0.0, &THETA)?;
    let kind =
        if found.body.mesh.element().dimension == 2 { ", triangles" } else { ", tetrahedra" };
    surfaces(rows, meshed, &found, (2, kind), [INFLATED, outer_radius(2, INFLATED)])
}

/// Inner radius over the one at rest at which the curve ends; the pressure rises up to 1.83 and falls beyond.
const LAST: f64 = 3.0;
/// Longest step along the curve of equilibria.
const LONGEST: f64 = 0.3;
/// Wanted quantity.
const BAND: Band = Band::below(0.005);
/// The coarse mesh of a quick run.
const COARSE: Band = Band::below(0.02);

/// Both branches of the pressure over the volume, through the limit point.
pub(super) const LIMIT_POINT: Case = Case {
    name: "limit-point",
    title: "Limit point of the thick incompressible sphere by arc length, both branches",
    provenance: "Closed form of Green and Adkins; its maximum from the root of the derivative (p/μ = 0.81642 at a/A = 1.8281).",
    run: run_limit_point,
};

fn run_limit_point(effort: Effort, rows: &mut Rows) -> Result<()> {
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

const PRESSURE: f64 = 0.4;
/// λ over μ = 1.
const LAMES: [f64; 3] = [1.0, 49.0, 4999.0];
/// Layers and cells along an edge of the cube.
const MESHES: [[usize; 2]; 3] = [[2, 3], [3, 5], [4, 8]];

/// Known errors of one element for each λ and mesh, and the bands they must stay in.
type Known = ([[f64; 3]; 3], fn(f64) -> Band);

/// A quarter to both sides: what locks must be seen to lock.
fn around(error: f64) -> Band {
    Band::between(0.75 * error, 1.25 * error)
}

/// Up to a quarter above.
fn below(error: f64) -> Band {
    Band::below(1.25 * error)
}

const LINEAR: Known = ([[0.19, 0.10, 0.058], [0.51, 0.40, 0.35], [0.91, 0.80, 0.73]], around);
const HEXAHEDRA: Known = ([[0.11, 0.051, 0.029], [0.70, 0.50, 0.36], [1.0, 0.99, 0.99]], around);
const QUADRATIC: Known =
    ([[0.0047, 0.0011, 3.5e-4], [0.016, 0.0059, 0.0029], [0.028, 0.011, 0.007]], below);
const PATCHES: Known = ([[0.12, 0.055, 0.029], [0.13, 0.059, 0.031], [0.14, 0.059, 0.032]], below);
const HEXAHEDRA_AVERAGED: Known =
    ([[0.052, 0.023, 0.013], [0.054, 0.024, 0.013], [0.054, 0.024, 0.013]], below);

/// The locking ladder: how elements lose their deflection as λ/μ grows.
pub(super) const LOCKING: Case = Case {
    name: "sphere-locking",
    title: "Thick sphere at λ/μ = 1, 49 and 4999 under internal follower pressure: the locking ladder",
    provenance: "Radial equilibrium of thesis eq. (3.1) as a boundary value problem, own shooting by Runge and Kutta to \
         1e-12. Bands of linear elements state how much they lock.",
    run: run_locking,
};

fn run_locking(effort: Effort, rows: &mut Rows) -> Result<()> {
    for (formulation, (errors, band)) in [
        (Formulation::P1, LINEAR),
        (Formulation::FBar, PATCHES),
        (Formulation::P2, QUADRATIC),
        (Formulation::Q1, HEXAHEDRA),
        (Formulation::Q1FBar, HEXAHEDRA_AVERAGED),
    ] {
        for (lame, errors) in LAMES.into_iter().zip(errors) {
            let theta = [1.0, lame];
            let [exact, _] = inflated_sphere(lame, PRESSURE)?;
            for (&cells, error) in effort.levels(2, &MESHES).iter().zip(errors) {
                let wall = sphere_octant(RADII, cells);
                let mesh: AnyMesh = match formulation {
                    Formulation::P1 | Formulation::FBar => wall.tetrahedra().into(),
                    Formulation::P2 | Formulation::Mixed => wall.quadratic_tetrahedra().into(),
                    Formulation::Q1 | Formulation::Q1FBar => wall.hexahedra().into(),
                };
                let loads = pressed("inner", PRESSURE);
                let sphere = scene(mesh, NeoHookean, &theta, loads, rollers(&OCTANT));
                let found = displaced(sphere, formulation, &theta)?;
                let value = outward(&found, "inner", 3);
                let quantity = format!("displacement of the inner surface, λ/μ = {lame}");
                let label = Label::new(formulation, octant(cells), quantity);
                rows.relative(label, [value, exact], band(error), found.cost)?;
            }
        }
    }
    Ok(())
}
