//! Supports along directions of a node's own: rollers on inclined planes and radial supports.

use crate::distort::Distort as _;
use crate::elements::scene::{distance, node_at, roller, scene, with_boundary, wobble};
use crate::support::{forces_of_supports, vector_area};
use sinew_energy::laws::{LinearElastic, NeoHookean};
use sinew_energy::{Body, Law, Load, Magnitude, SceneError, Support};
use sinew_fem::{Options, Solution, SolveError, Solver, held_sets};
use sinew_mesh::{
    AnyMesh, HexMesh, TruncatedEllipsoid, boundary_facets, box_hexahedra, box_tetrahedra,
    rectangle_triangles,
};
use std::f64::consts::TAU;

/// μ and λ.
const THETA: [f64; 2] = [1.0, 3.0];
/// A rotation with rational entries, off all axes.
const TURN: [[f64; 3]; 3] = [
    [1.0 / 9.0, 8.0 / 9.0, -4.0 / 9.0],
    [4.0 / 9.0, -4.0 / 9.0, -7.0 / 9.0],
    [-8.0 / 9.0, -1.0 / 9.0, -4.0 / 9.0],
];
/// A rotation in the plane.
const PLANE_TURN: [[f64; 3]; 3] = [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
const STRAIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn turned(turn: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn turned_field(turn: &[[f64; 3]; 3], field: &[f64]) -> Vec<f64> {
    field.as_chunks::<3>().0.iter().flat_map(|&v| turned(turn, v)).collect()
}

/// A box in another position, on rollers, stretched along its y axis, under dead loads, a spring and whatever
/// `pressed` says; each load is along its axes.
fn block(
    turn: &[[f64; 3]; 3],
    mesh: impl Into<AnyMesh>,
    pressed: Option<&str>,
) -> sinew_energy::Scene {
    let mut mesh = mesh.into();
    mesh.map_points(|x| turned(turn, x));
    let along = |v: [f64; 3]| turned(turn, v);
    let mut loads = vec![
        Load::BodyForce(along([0.05, 0.02, 0.0])),
        Load::Traction { facets: "x_max".into(), value: along([0.1, 0.2, 0.0]) },
        Load::Foundation { facets: "x_max".into(), normal: 0.4, tangential: 0.1 },
    ];
    let magnitude = Magnitude::Fixed(0.1);
    loads.extend(pressed.map(|facets| Load::Pressure { facets: facets.into(), magnitude }));
    let mut supports = vec![
        Support::roller_on_plane("x_min", along([3.0, 0.0, 0.0])),
        Support::roller_on_plane("y_min", along([0.0, -0.5, 0.0])),
        Support::along("y_max", along([0.0, 2.0, 0.0]), 0.3),
    ];
    if mesh.element().dimension == 3 {
        supports.push(Support::roller_on_plane("z_min", along([0.0, 0.0, 1.0])));
    }
    let sets = ["x_min", "y_min", "y_max", "z_min"].map(|name| mesh.node_sets().get(name));
    let mut held: Vec<_> = sets.into_iter().flatten().flatten().copied().collect();
    held.sort_unstable();
    held.dedup();
    mesh.node_sets_mut().insert("held".into(), held);
    scene(NeoHookean, mesh, loads, supports)
}

fn solved(body: &Body) -> Solution {
    Solver::new(body).unwrap().solve(&THETA, &Options::default()).unwrap()
}

fn compare(turn: &[[f64; 3]; 3], [straight, inclined]: [&Body; 2]) {
    assert!(straight.frames.is_empty() && !inclined.frames.is_empty());
    let [first, second] = [solved(straight), solved(inclined)];
    let expected = turned_field(turn, &first.displacement);
    assert!(distance(&first.displacement, &vec![0.0; expected.len()]) > 0.25);
    let error = distance(&expected, &second.displacement);
    assert!(error < 1e-10, "{} nodes: {error:e}", straight.nodes_per_cell);
    assert!((first.energy / second.energy - 1.0).abs() < 1e-12);
    assert!((first.force_scale / second.force_scale - 1.0).abs() < 1e-10);
    assert_eq!(first.iterations(), second.iterations());

    let [[a, b], [c, d]] = [(straight, &first), (inclined, &second)].map(|(body, solution)| {
        let sensitivity = Solver::new(body).unwrap().sensitivity(solution).unwrap();
        sensitivity.try_into().unwrap()
    });
    for (straight, inclined) in [(a, c), (b, d)] {
        assert!(distance(&turned_field(turn, &straight), &inclined) < 1e-9);
    }
    let [first, forces] =
        [(straight, &first), (inclined, &second)].map(|(body, at)| forces_of_supports(body, at));
    assert_eq!(first.len(), forces.len());
    for (first, second) in first.iter().zip(&forces) {
        assert!(distance(&turned(turn, *first), second) < 1e-9);
    }
    // What no support takes is balanced.
    let mut gradient = vec![0.0; second.displacement.len()];
    inclined.value_and_gradient(&second.displacement, &THETA, &mut gradient);
    let all = |i: usize| gradient.iter().skip(i).step_by(3).sum::<f64>();
    let held = held_sets(inclined).position(|(name, _)| name == "held").unwrap();
    assert!(distance(&forces[held], &[0, 1, 2].map(all)) < 1e-9, "{forces:?}");
}

#[test]
fn a_turned_box_on_inclined_rollers_is_the_turned_solution() {
    let extent = [1.5, 1.0, 1.2];
    let tetrahedra = || box_tetrahedra(extent, [3, 2, 2]).distorted(5, 0.3);
    let scenes = [STRAIGHT, TURN].map(|turn| block(&turn, tetrahedra(), None));
    let bodies = scenes.each_ref().map(|scene| scene.lower().unwrap());
    compare(&TURN, bodies.each_ref());
    let bodies = scenes.each_ref().map(|scene| scene.clone().averaged().lower().unwrap());
    compare(&TURN, bodies.each_ref());
    let hexahedra = box_hexahedra(extent, [2, 2, 2]);
    let bodies =
        [STRAIGHT, TURN].map(|turn| block(&turn, hexahedra.clone(), None).lower().unwrap());
    compare(&TURN, bodies.each_ref());
    let quadratic = box_tetrahedra(extent, [1, 1, 2]).quadratic();
    let bodies =
        [STRAIGHT, TURN].map(|turn| block(&turn, quadratic.clone(), None).lower().unwrap());
    compare(&TURN, bodies.each_ref());
    let triangles = rectangle_triangles([1.5, 1.0], [3, 2]).distorted(5, 0.3);
    let bodies =
        [STRAIGHT, PLANE_TURN].map(|turn| block(&turn, triangles.clone(), None).lower().unwrap());
    compare(&PLANE_TURN, bodies.each_ref());
}

fn balanced(body: &Body) -> Vec<f64> {
    Solver::new(body).unwrap().solve(&THETA, &Options::default()).unwrap().displacement
}

#[test]
fn a_turned_balance_is_the_turned_solution() {
    let quadratic = box_tetrahedra([1.5, 1.0, 1.2], [1, 1, 2]).quadratic();
    let scenes = [STRAIGHT, TURN].map(|turn| block(&turn, quadratic.clone(), Some("z_max")));
    assert!(matches!(scenes[1].lower(), Err(SceneError::LooseRim(_))));
    let [straight, inclined] =
        scenes.each_ref().map(|s| balanced(&s.clone().loose_rims().lower().unwrap()));
    assert!(distance(&turned_field(&TURN, &straight), &inclined) < 1e-8);
    let [straight, inclined] =
        scenes.each_ref().map(|s| balanced(&s.clone().mixed().lower().unwrap()));
    assert!(distance(&turned_field(&TURN, &straight), &inclined) < 1e-8);
}

/// Energy, forces and stiffness by differences along the unknowns.
fn check_derivatives(body: &Body) {
    /// Central differences with this step err by about its square times the third derivative.
    const STEP: f64 = 1e-5;
    let mut solver = Solver::new(body).unwrap();
    let mut solution = solver.solve(&THETA, &Options::default()).unwrap();
    let off = wobble(solution.displacement.len(), 0.02);
    let free = body.free_degrees_of_freedom();
    for &dof in &free {
        body.frames.add(dof, off[dof], &mut solution.displacement);
    }
    let u = &solution.displacement;
    let at = |dof: usize, step: f64| {
        let (mut moved, mut gradient) = (u.clone(), vec![0.0; u.len()]);
        body.frames.add(dof, step, &mut moved);
        (body.value_and_gradient(&moved, &THETA, &mut gradient), gradient)
    };
    let (_, gradient) = at(0, 0.0);
    let stiffness = solver.stiffness(&solution).unwrap();
    let largest = stiffness.values.iter().fold(0.0, |m: f64, k| m.max(k.abs()));
    let unknowns = &stiffness.degree_of_freedom;
    assert_eq!(unknowns.len(), free.len());
    assert!(unknowns.iter().any(|dof| body.frames.get(dof / 3).is_some()));
    for (column, &dof) in unknowns.iter().enumerate() {
        let (up, down) = (at(dof, STEP), at(dof, -STEP));
        let slope = (up.0 - down.0) / (2.0 * STEP);
        let force = body.frames.component(dof, &gradient);
        assert!((slope - force).abs() < 1e-7 * largest, "{slope} {force}");
        let mut found = vec![0.0; unknowns.len()];
        for at in stiffness.column_starts[column]..stiffness.column_starts[column + 1] {
            found[stiffness.rows[at]] = stiffness.values[at];
        }
        for (row, &other) in unknowns.iter().enumerate().skip(column) {
            let [up, down] = [&up.1, &down.1].map(|g| body.frames.component(other, g));
            let difference = (up - down) / (2.0 * STEP);
            assert!((found[row] - difference).abs() < 1e-7 * largest, "{row} {column}");
        }
    }

    let mut direction = vec![0.0; u.len()];
    free.iter().for_each(|&dof| body.frames.add(dof, off[dof], &mut direction));
    let forces = solver.stiffness_times(u, &THETA, &direction).unwrap();
    // The stiffness times a direction, by differences along it.
    let along = |step: f64| {
        let moved: Vec<f64> = u.iter().zip(&direction).map(|(u, d)| u + step * d).collect();
        let mut gradient = vec![0.0; u.len()];
        body.value_and_gradient(&moved, &THETA, &mut gradient);
        gradient
    };
    for ((up, down), force) in along(STEP).iter().zip(along(-STEP)).zip(&forces) {
        assert!(((up - down) / (2.0 * STEP) - force).abs() < 1e-7 * largest);
    }
}

#[test]
fn derivatives_in_the_unknowns_of_inclined_supports() {
    let pressed = Some("boundary");
    let tetrahedra = with_boundary(box_tetrahedra([1.5, 1.0, 1.2], [2, 2, 1]).distorted(5, 0.3));
    let tetrahedra = block(&TURN, tetrahedra, pressed);
    check_derivatives(&tetrahedra.lower().unwrap());
    check_derivatives(&tetrahedra.averaged().lower().unwrap());
    let quadratic = with_boundary(box_tetrahedra([1.5, 1.0, 1.2], [1, 1, 1]).quadratic());
    check_derivatives(&block(&TURN, quadratic, pressed).lower().unwrap());
    let triangles = with_boundary(rectangle_triangles([1.5, 1.0], [2, 2]));
    check_derivatives(&block(&PLANE_TURN, triangles, pressed).lower().unwrap());
}

/// Cells around the whole ring, through its wall and along its axis.
const CELLS: [usize; 3] = [16, 3, 2];
const RADII: [f64; 2] = [1.0, 2.0];

/// A sector of a ring around the z axis of this many cells around, with the sets `inner`, `ends` and, unless it
/// is closed, `first` and `last`.
fn ring(around: usize) -> HexMesh {
    let [whole, layers, along] = CELLS;
    let columns = if around == whole { whole } else { around + 1 };
    let node = |k: usize, i: usize, j: usize| (k * (layers + 1) + i) * columns + j % columns;
    let mut mesh = HexMesh::default();
    for k in 0..=along {
        for i in 0..=layers {
            let radius = RADII[0] + (RADII[1] - RADII[0]) * i as f64 / layers as f64;
            for j in 0..columns {
                let (sin, cos) = (TAU * j as f64 / whole as f64).sin_cos();
                mesh.points.push([radius * cos, radius * sin, 0.4 * k as f64]);
            }
        }
    }
    for k in 0..along {
        for i in 0..layers {
            for j in 0..around {
                let quad = |k| {
                    [node(k, i, j), node(k, i + 1, j), node(k, i + 1, j + 1), node(k, i, j + 1)]
                };
                let ([a, b, c, d], [e, f, g, h]) = (quad(k), quad(k + 1));
                mesh.cells.push([a, b, c, d, e, f, g, h]);
            }
        }
    }
    let nodes = |chosen: &dyn Fn(usize, usize) -> bool| {
        let all = (0..=along).flat_map(|k| (0..=layers).map(move |i| (k, i)));
        let all = all.flat_map(|(k, i)| (0..columns).map(move |j| (k, i, j)));
        all.filter(|&(k, _, j)| chosen(k, j)).map(|(k, i, j)| node(k, i, j)).collect()
    };
    mesh.node_sets.insert("ends".into(), nodes(&|k, _| k == 0 || k == along));
    if around < whole {
        mesh.node_sets.insert("first".into(), nodes(&|_, j| j == 0));
        mesh.node_sets.insert("last".into(), nodes(&|_, j| j == around));
    }
    let is_inner = |node: usize| mesh.points[node][0].hypot(mesh.points[node][1]) < RADII[0] + 0.1;
    let inner = boundary_facets(&mesh).into_iter();
    let inner = inner.filter(|&facet| mesh.nodes_of_facet(facet).all(is_inner)).collect();
    mesh.facet_sets.insert("inner".into(), inner);
    mesh
}

/// The ring under a pressure from inside. No pressure has a potential on rims in two parallel planes.
fn pressed_ring<L: Law<0>>(
    law: L,
    around: usize,
    supports: Vec<Support>,
    pressure: f64,
) -> Vec<f64> {
    let magnitude = Magnitude::Fixed(pressure);
    let load = Load::Pressure { facets: "inner".into(), magnitude };
    let body = scene(law, ring(around), vec![load], supports).loose_rims().lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    solver.solve(&THETA, &Options::default()).unwrap().displacement
}

#[test]
fn a_ring_with_radial_ends_is_its_quarter_and_its_sector() {
    let [whole, layers, along] = CELLS;
    let radial = || vec![Support::radial("ends", [0.0, 0.0, 7.0], [0.0, 0.0, -2.0])];
    let quarter = vec![roller("first", 1), roller("last", 0), roller("ends", 2)];
    let (sin, cos) = (TAU / whole as f64).sin_cos();
    let slope = Support::roller_on_plane("last", [-sin, cos, 0.0]);
    let sector = vec![roller("first", 1), slope, roller("ends", 2)];

    let ring = pressed_ring(NeoHookean, whole, radial(), 0.4);
    assert!(ring[0] > 0.3, "it is pressed far out: {}", ring[0]);
    for (around, supports) in [(whole / 4, quarter), (1, sector)] {
        let part = pressed_ring(NeoHookean, around, supports, 0.4);
        for row in 0..(layers + 1) * (along + 1) {
            for j in 0..=around {
                let [a, b] = [3 * (row * whole + j), 3 * (row * (around + 1) + j)];
                let error = distance(&ring[a..a + 3], &part[b..b + 3]);
                assert!(error < 1e-9, "{around} around, row {row}, {j}: {error:e}");
            }
        }
    }

    // Lamé's solution, in plane strain; three linear cells through the wall have an error of 3.7 %.
    const PRESSURE: f64 = 1e-6;
    let found = pressed_ring(LinearElastic, whole, radial(), PRESSURE)[0];
    let ([a, b], [shear, lambda]) = (RADII, THETA);
    let exact =
        PRESSURE * a * a / (2.0 * (b * b - a * a)) * (a / (lambda + shear) + b * b / (shear * a));
    assert!((found / exact - 1.0).abs() < 0.05, "{found:e} {exact:e}");
}

#[test]
fn a_ventricle_inflates_on_a_base_that_moves_along_its_radii() {
    let mesh = TruncatedEllipsoid::LAND.wall([1, 16, 6]).hexahedra();
    let load = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(0.15) };
    let base = Support::radial("base", [0.0; 3], [0.0, 0.0, 1.0]);
    let scene = scene(NeoHookean, mesh, vec![load], vec![base]).averaged();
    // The rim slides in the plane of the base, so that the pressure has a potential.
    let body = scene.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let solution = solver.solve(&THETA, &Options::default()).unwrap();
    assert!(solution.is_stable());
    let u = &solution.displacement;
    let largest = distance(u, &vec![0.0; u.len()]);
    for &node in &scene.mesh.node_sets()["base"] {
        let [x, y, _] = scene.mesh.points()[node];
        let (radius, [u, v, w]) = (x.hypot(y), [0, 1, 2].map(|i| u[3 * node + i]));
        let [out, around] = [(x * u + y * v) / radius, (x * v - y * u) / radius];
        assert!(out > 0.05 * largest, "node {node} moves out: {out}");
        assert!(around.abs().max(w.abs()) < 1e-14 * largest, "node {node}: {around:e} {w:e}");
    }
    let apex = scene.mesh.node_sets()["apex_endo"][0];
    assert!(u[3 * apex + 2] < -0.2, "the apex moves down: {}", u[3 * apex + 2]);

    let held = held_sets(&body).position(|(name, _)| name == "base").unwrap();
    let base = forces_of_supports(&body, &solution)[held];
    let lift = 0.15 * vector_area(&body, "endo", u)[2];
    assert!(
        (base[2] - lift).abs() < 1e-9 * lift.abs(),
        "the pressure pulls at the base: {base:?} {lift}"
    );
    assert!(base[0].abs() + base[1].abs() < 1e-9 * base[2].abs(), "{base:?}");
    assert!(solution.residual < 1e-9 * solution.force_scale);

    // A support that is off its place by rounding only is not moved again.
    let again = solver.solve_from(u, &THETA, &Options::default()).unwrap();
    assert!(again.iterations() <= 1, "{}", again.history);
}

#[test]
fn a_turned_ventricle_inflates_like_the_upright_one() {
    let ventricle = |turn: &[[f64; 3]; 3]| {
        let mut mesh = TruncatedEllipsoid::LAND.wall([1, 8, 4]).hexahedra();
        mesh.points.iter_mut().for_each(|x| *x = turned(turn, *x));
        let load = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(0.15) };
        let base = Support::radial("base", [0.0; 3], turned(turn, [0.0, 0.0, 2.0]));
        scene(NeoHookean, mesh, vec![load], vec![base])
    };
    let upright = solved(&ventricle(&STRAIGHT).lower().unwrap()).displacement;
    let inclined = ventricle(&TURN);
    // The plane of its base is not a coordinate plane, for which alone the potential is known.
    assert!(matches!(inclined.lower(), Err(SceneError::LooseRim(_))));
    let inclined = balanced(&inclined.loose_rims().lower().unwrap());
    let error = distance(&turned_field(&TURN, &upright), &inclined);
    assert!(error < 1e-7 * distance(&upright, &vec![0.0; upright.len()]), "{error:e}");
}

/// Two cubes that share an edge, so that the second turns about it: what holds one of its nodes across that
/// motion holds nothing.
#[test]
fn a_hinged_part_is_held_by_a_roller_against_its_turn_only() {
    let mut mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let first = mesh.clone();
    let second: Vec<usize> = first
        .points
        .iter()
        .map(|x| {
            let place = [x[0] + 1.0, x[1] + 1.0, x[2]];
            mesh.points.iter().position(|&p| p == place).unwrap_or_else(|| {
                mesh.points.push(place);
                mesh.points.len() - 1
            })
        })
        .collect();
    mesh.cells.extend(first.cells.iter().map(|cell| cell.map(|node| second[node])));
    assert_eq!(mesh.points.len(), 14);
    let corner = node_at(&mesh.points, [2.0, 2.0, 0.0]);
    mesh.node_sets.insert("corner".into(), vec![corner]);
    let outcome = |normal: [f64; 3]| {
        let roller = Support::roller_on_plane("corner", normal);
        let supports = vec![Support::clamped("x_min"), roller];
        let body = scene(NeoHookean, mesh.clone(), vec![], supports).lower().unwrap();
        Solver::new(&body).map(|_| ())
    };
    assert_eq!(outcome([1.0, -1.0, 0.0]), Ok(()));
    let Err(SolveError::FreeToMove { modes, .. }) = outcome([1.0, 1.0, 0.0]) else {
        panic!("it turns about the edge");
    };
    assert_eq!(modes.len(), 1);
    assert_eq!(modes[0].to_string(), "rotation about z");
}

#[test]
fn supports_that_hold_too_little_or_contradict_each_other_are_refused() {
    let mesh = || {
        let mut mesh = box_tetrahedra([1.5, 1.0, 1.2], [2, 2, 2]);
        mesh.points.iter_mut().for_each(|x| *x = turned(&TURN, *x));
        mesh
    };
    let lowered = |supports| scene(NeoHookean, mesh(), vec![], supports).lower();
    let normal = |i: usize| turned(&TURN, STRAIGHT[i]);
    let two = vec![
        Support::roller_on_plane("x_min", normal(0)),
        Support::roller_on_plane("y_min", normal(1)),
    ];
    let body = lowered(two.clone()).unwrap();
    let Err(SolveError::FreeToMove { modes, .. }) = Solver::new(&body).map(|_| ()) else {
        panic!("free along the third normal");
    };
    let [mode] = modes[..] else { panic!("{modes:?}") };
    let along: f64 = (0..3).map(|i| mode.translation[i] * normal(2)[i]).sum();
    assert!((along.abs() - 1.0).abs() < 1e-9, "{mode}");

    // The edge between the planes is held by both; a third support moves it along one of them.
    let moved = Support::along("edge", turned(&TURN, [0.6, 0.8, 0.0]), 0.5);
    let mut edge = mesh();
    let node = node_at(&edge.points, turned(&TURN, [0.0, 0.0, 0.6]));
    edge.node_sets.insert("edge".into(), vec![node]);
    let supports = [two, vec![moved]].concat();
    let error = scene(NeoHookean, edge, vec![], supports).lower().unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("the support of `edge` prescribes 0.5 along ("), "{text}");
    assert!(text.contains("there by those of x_min, y_min; take the node out"), "{text}");
    let first = text.split_once(&format!("for node {node}, but it is held at "));
    let first = first.and_then(|(_, rest)| rest.split_once(" there")).expect("a displacement").0;
    assert!(first.parse::<f64>().unwrap().abs() < 1e-12, "{text}");

    for wrong in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        for support in
            [Support::roller_on_plane("x_min", wrong), Support::radial("x_min", [9.0; 3], wrong)]
        {
            let error = lowered(vec![support]).unwrap_err();
            assert!(
                error.to_string().contains("the support of `x_min` has the direction ("),
                "{error}"
            );
        }
    }
    let corner = turned(&TURN, [0.0, 0.5, 0.6]);
    let on_axis = lowered(vec![Support::radial("x_min", corner, normal(2))]).unwrap_err();
    let text = on_axis.to_string();
    let (node, rest) = text.strip_prefix("node ").unwrap().split_once(" of `x_min`, at [").unwrap();
    let distance = rest.split_once("], is ").unwrap().1.split(' ').next().unwrap();
    let (node, distance): (usize, f64) = (node.parse().unwrap(), distance.parse().unwrap());
    assert!(distance < 1e-12);
    let away: [f64; 3] = std::array::from_fn(|i| mesh().points[node][i] - corner[i]);
    let along: f64 = (0..3).map(|i| away[i] * normal(2)[i]).sum();
    assert!((away.iter().map(|x| x * x).sum::<f64>() - along * along).abs() < 1e-12);
    for (support, what) in [
        (Support::radial("x_min", [0.0, f64::NAN, 0.0], normal(0)), "axis"),
        (Support::along("x_min", normal(0), f64::INFINITY), "displacement"),
    ] {
        let error = lowered(vec![support]).unwrap_err();
        let SceneError::NotFinite { what: found, .. } = &error else { panic!("{error}") };
        assert!(found.contains(what), "{error}");
    }
    let unknown = lowered(vec![Support::radial("base", [0.0; 3], normal(0))]).unwrap_err();
    assert!(unknown.to_string().contains("there is no node set `base`"), "{unknown}");
}

#[test]
fn rollers_on_coordinate_planes_need_no_frames() {
    let mesh = box_tetrahedra([1.0; 3], [2; 3]);
    let names = ["x_min", "y_min", "z_min"];
    let lowered = |supports| scene(NeoHookean, mesh.clone(), vec![], supports).lower().unwrap();
    let plain = lowered((0..3).map(|i| roller(names[i], i)).collect());
    let normal = |i: usize| STRAIGHT[i].map(|x| -3.0 * x);
    let planes = (0..3).map(|i| Support::roller_on_plane(names[i], normal(i)));
    let planes = lowered(planes.collect());
    assert!(planes.frames.is_empty());
    assert_eq!(plain.prescribed, planes.prescribed);
}
