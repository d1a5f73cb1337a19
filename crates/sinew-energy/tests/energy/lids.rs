//! Pressures in cavities whose rims move, with their lids: against volumes, differences and rigid motions.

use crate::cavities::{FLAT, polygon, roller, round, scene_of, tilted, tube};
use sinew_energy::{Body, Load, Magnitude, PressureSurface, SceneError, Support, SurfaceResponse};
use sinew_mesh::{AnyMesh, Biventricle, TruncatedEllipsoid, rectangle_triangles};
use std::f64::consts::PI;

const P: f64 = 0.7;
const THETA: [f64; 2] = [1.0, 1.0];

fn lidded(facets: &&str) -> Load {
    Load::CavityPressure { facets: facets.to_string(), magnitude: Magnitude::Fixed(P) }
}

fn body(mesh: impl Into<AnyMesh>, cavities: &[&str], supports: Vec<Support>) -> Body {
    scene_of(mesh, cavities.iter().map(lidded).collect(), supports).lower().unwrap()
}

/// A displacement that no support forbids.
fn wave(body: &Body, size: f64) -> Vec<f64> {
    let free = |(i, p): (usize, &Option<f64>)| p.map_or(size * (1.7 * i as f64 + 0.3).sin(), |u| u);
    body.prescribed.iter().enumerate().map(free).collect()
}

fn wall() -> sinew_mesh::Wall {
    TruncatedEllipsoid::LAND.wall([1, 8, 4])
}

/// A half and a quarter of a tube: their rims end in one and in two symmetry planes.
fn sectors() -> [Body; 2] {
    let sector = |angle: f64, last: usize| {
        let ends: [fn([f64; 2]) -> f64; 2] = [|[x, _]| 0.3 * x, |[x, _]| 4.0 + 0.1 * x];
        let mesh = tube(&polygon(6, 0.0, angle, round), false, ends);
        body(mesh, &["inner"], vec![roller("first", 1), roller("last", last)])
    };
    [sector(PI, 1), sector(0.5 * PI, 0)]
}

fn bodies() -> Vec<(&'static str, Body)> {
    let heart = Biventricle { radius: 20.0, depth: 50.0, wall: 10.0, septum: 10.0 };
    let [half, quarter] = sectors();
    vec![
        ("tube", body(tilted().0, &["inner"], Vec::new())),
        ("tetrahedra", body(wall().tetrahedra(), &["endo"], Vec::new())),
        ("quadratic", body(wall().quadratic_tetrahedra(), &["endo"], Vec::new())),
        ("heart", body(heart.tetrahedra(5.5), &["endo_left", "endo_right"], Vec::new())),
        ("half", half),
        ("quarter", quarter),
    ]
}

#[test]
fn the_potential_is_minus_pressure_times_change_of_volume() {
    for (name, body) in bodies() {
        for size in [1e-5, 0.02] {
            let u = match name {
                // Its facets are bilinear, the volume's are triangles: only affine motions keep both alike.
                "tube" | "half" | "quarter" => {
                    let stretched =
                        |x: &[f64; 3]| [size * x[0], -2.0 * size * x[1], 3.0 * size * x[2]];
                    body.positions.iter().flat_map(stretched).collect()
                }
                _ => wave(&body, size),
            };
            let at = |u: &[f64]| body.cavity_volumes(u).iter().sum::<f64>();
            let (before, after) = (at(&vec![0.0; u.len()]), at(&u));
            let energy = body.load_value(&u, &THETA);
            let error = (energy + P * (after - before)).abs();
            assert!(error < 1e-13 * P * before, "{name} {size}: {error:e} of {energy}");
        }
    }
}

#[test]
fn a_rigid_motion_leaves_the_potential() {
    for (name, body) in bodies().into_iter().take(4) {
        let uneven = wave(&body, 0.1);
        let (c, s, d, e) = (0.8, 0.6, 5.0 / 13.0, 12.0 / 13.0);
        let place = |x: [f64; 3]| {
            let [x, y, z] = [c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]];
            [x + 30.0, d * y - e * z - 8.0, e * y + d * z + 0.3]
        };
        let moved = body.positions.iter().zip(uneven.as_chunks::<3>().0).flat_map(|(x, u)| {
            let place = place(std::array::from_fn(|i| x[i] + u[i]));
            [0, 1, 2].map(|i| place[i] - x[i])
        });
        let moved: Vec<f64> = moved.collect();
        let [before, after] = [&uneven, &moved].map(|u| body.load_value(u, &THETA));
        let volume = P * body.cavity_volumes(&uneven).iter().sum::<f64>();
        assert!((before - after).abs() < 1e-12 * volume, "{name}: {before} {after}");
        // Neither force nor moment on the whole.
        let forces = gradient(&body.pressures[0], &moved);
        let size: f64 = forces.iter().map(|f| f.abs()).sum();
        for i in 0..3 {
            let force: f64 = forces.iter().skip(i).step_by(3).sum();
            assert!(force.abs() < 1e-13 * size, "{name}: {force:e} of {size}");
        }
    }
}

fn gradient(load: &PressureSurface, u: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; u.len()];
    load.value_and_add_gradient(u, &THETA, &mut gradient);
    gradient
}

#[test]
fn derivatives_are_differences_and_the_stiffness_is_symmetric() {
    for (name, body) in bodies() {
        for load in &body.pressures {
            // Every node, held ones too: a plane that moves takes the apex with it.
            let scale = body.positions.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let u: Vec<f64> =
                (0..3 * body.nodes).map(|i| 0.01 * scale * (i as f64).sin()).collect();
            let step = 1e-5 * scale;
            let first = load.facets() - load.lids.len();
            assert!(!load.lids.is_empty(), "{name}");
            for facet in first..load.facets() {
                let respond = |u: &[f64]| {
                    let mut response = SurfaceResponse::default();
                    load.facet_response(facet, u, &mut response);
                    response
                };
                let at = respond(&u);
                let nodes = load.facet_nodes(facet);
                let size = 3 * nodes.len();
                let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                let (force, stiffness) = (largest(&at.gradient), largest(&at.hessian));
                for column in 0..size {
                    let [up, down] = [step, -step].map(|by| {
                        let mut u = u.clone();
                        u[3 * nodes[column / 3] + column % 3] += by;
                        respond(&u)
                    });
                    let slope = (up.energy - down.energy) / (2.0 * step);
                    assert!((at.gradient[column] - slope).abs() < 1e-6 * force, "{name} {column}");
                    for row in 0..size {
                        let slope = (up.gradient[row] - down.gradient[row]) / (2.0 * step);
                        let entry = at.hessian[row * size + column];
                        assert!(
                            (entry - slope).abs() < 1e-6 * stiffness,
                            "{name} {row} {column}: {entry} {slope}"
                        );
                        assert_eq!(entry, at.hessian[column * size + row], "{name}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_held_rim_has_the_forces_of_a_pressure_without_a_lid() {
    let held = || vec![Support::clamped("base")];
    let bare = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(P) };
    let bare = scene_of(wall().tetrahedra(), vec![bare], held()).lower().unwrap();
    let closed = body(wall().tetrahedra(), &["endo"], held());
    let u = wave(&closed, 0.1);
    let [a, b] = [&bare, &closed].map(|body| gradient(&body.pressures[0], &u));
    let [x, y] = [&bare, &closed].map(|body| body.load_value(&u, &THETA));
    assert!((x / y - 1.0).abs() < 1e-12, "{x} {y}");
    for dof in closed.free_degrees_of_freedom() {
        assert!((a[dof] - b[dof]).abs() < 1e-12, "{dof}");
    }
    // Symmetry planes close a surface as well, which a rim in them need not be held for.
    for body in sectors() {
        let followers = scene_of(
            (*body.mesh).clone(),
            vec![Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Fixed(P) }],
            vec![
                roller("first", 1),
                roller("last", if body.cavities[0].parts[0].planes.len() > 1 { 0 } else { 1 }),
            ],
        );
        let followers = followers.loose_rims().lower().unwrap();
        assert_eq!(followers.followers.len(), 1);
        // Inside, both push alike.
        let u = wave(&body, 0.05);
        let lidded = gradient(&body.pressures[0], &u);
        let mut exact = vec![0.0; u.len()];
        let (surface, mut response) = (&followers.followers[0], SurfaceResponse::default());
        for facet in 0..surface.facets() {
            surface.facet_force(facet, &u, &mut response);
            for (slot, force) in response.gradient.iter().enumerate() {
                exact[3 * surface.facet_nodes(facet)[slot / 3] + slot % 3] += P * force;
            }
        }
        let rim: Vec<usize> =
            body.pressures[0].lids.iter().flat_map(|lid| lid.nodes.clone()).collect();
        for dof in body.free_degrees_of_freedom() {
            if !rim.contains(&(dof / 3)) {
                assert!(
                    (lidded[dof] - exact[dof]).abs() < 1e-12,
                    "{dof}: {} {}",
                    lidded[dof],
                    exact[dof]
                );
            }
        }
    }
}

#[test]
fn a_closed_surface_needs_no_lid() {
    let mut mesh = sinew_mesh::box_tetrahedra([3.0, 2.0, 1.0], [2, 2, 1]);
    let all = sinew_mesh::boundary_facets(&mesh);
    mesh.facet_sets.insert("all".into(), all);
    let body = body(mesh, &["all"], Vec::new());
    assert!(body.pressures[0].lids.is_empty() && body.has_potential());
}

#[test]
fn what_has_no_volume_is_refused() {
    let refused = |mesh: AnyMesh, facets: &str, supports, what: &str| {
        let error = scene_of(mesh, vec![lidded(&facets)], supports).lower().unwrap_err();
        assert!(matches!(error, SceneError::Loads(_)), "{error}");
        let text = error.to_string();
        assert!(text.contains(what) && text.contains("held or loose"), "{text}");
    };
    let corners = polygon(6, 0.0, 0.5 * PI, round);
    let planes =
        || vec![roller("first", 1), roller("last", 0), roller("low", 2), roller("high", 2)];
    refused(tube(&corners, false, FLAT).into(), "inner", planes(), "parallel");
    let mut moved = vec![roller("first", 1), roller("last", 0)];
    moved[1] = Support::along("last", [1.0, 0.0, 0.0], 0.5);
    refused(tube(&corners, false, FLAT).into(), "inner", moved, "supports move");
    let mut leaning = tube(&corners, false, FLAT);
    leaning.points.iter_mut().for_each(|x| x[0] += 0.3 * x[2]);
    let mut supports = planes();
    supports[1] = Support::roller_on_plane("last", [1.0, 0.0, -0.3]);
    refused(leaning.into(), "inner", supports, "leave it open");
    refused(rectangle_triangles([1.0; 2], [2, 2]).into(), "x_max", Vec::new(), "triangles");
}

#[test]
fn a_loose_rim_is_told_of_the_lid() {
    let bare = |mesh: AnyMesh| {
        let load = Load::Pressure { facets: "inner".into(), magnitude: Magnitude::Fixed(P) };
        scene_of(mesh, vec![load], Vec::new()).lower().unwrap_err()
    };
    let error = bare(tilted().0.into());
    assert!(error.to_string().contains("close it by a lid"), "{error}");
}
