//! Pressure as an energy: against volumes, differences, Nanson's formula and the thesis' stand-in.

use sinew_energy::laws::NeoHookean;
use sinew_energy::{
    Body, Load, Magnitude, Parameter, PressureSurface, Sampling, Scene, SceneError, Support,
    SurfaceResponse,
};
use sinew_mesh::{boundary_facets, box_tetrahedra};
use sinew_num::Mat3;

fn scene(load: Load, supports: Vec<Support>) -> Scene {
    let mut mesh = box_tetrahedra([3.0, 2.0, 1.0], [4, 3, 2]);
    let all = boundary_facets(&mesh);
    mesh.facet_sets.insert("all".into(), all);
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [1.0, 2.0],
        sampling: Sampling::Linear,
    };
    Scene {
        name: "block".into(),
        parameters: ["mu", "lambda", "p"].map(parameter).into(),
        loads: vec![load],
        supports,
        ..Scene::new(mesh, NeoHookean)
    }
}

fn follower(facets: &str) -> Load {
    Load::Pressure { facets: facets.into(), magnitude: Magnitude::Theta(2) }
}

fn stand_in(facets: &str) -> Load {
    Load::ThesisPressure { facets: facets.into(), magnitude: Magnitude::Theta(2) }
}

fn clamped() -> Vec<Support> {
    vec![Support::clamped("x_min")]
}

fn wobble<const D: usize>(potential: &Body, size: f64) -> Vec<f64>
where
    NeoHookean: sinew_energy::Law<D>,
{
    (0..3 * potential.nodes)
        .map(|i| potential.prescribed[i].unwrap_or(size * (1.3 * i as f64 + 0.4).sin()))
        .collect()
}

fn gradient(load: &PressureSurface, u: &[f64], theta: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; u.len()];
    load.value_and_add_gradient(u, theta, &mut gradient);
    gradient
}

fn triangles(load: &PressureSurface) -> &[[usize; 3]] {
    load.nodes.as_chunks().0
}

fn response(load: &PressureSurface, facet: usize, u: &[f64]) -> SurfaceResponse {
    let mut response = SurfaceResponse::default();
    load.facet_response(facet, u, &mut response);
    response
}

const THETA: [f64; 3] = [1.0, 1.0, 0.7];

#[test]
fn follower_energy_is_pressure_times_change_of_volume() {
    let scene = scene(follower("all"), clamped());
    let potential = scene.lower().unwrap();
    let load = &potential.pressures[0];
    for size in [1e-6, 0.05, 1.0] {
        let u = wobble(&potential, size);
        let volume = |u: &[f64]| {
            let place = |&node: &usize| -> [f64; 3] {
                std::array::from_fn(|i| scene.mesh.points()[node][i] + u[3 * node + i])
            };
            let cones = triangles(load)
                .iter()
                .map(|nodes| Mat3(nodes.map(|node| place(&node))).determinant());
            cones.sum::<f64>() / 6.0
        };
        let change = volume(&u) - volume(&vec![0.0; u.len()]);
        // The difference of two volumes of 6 mm³ has this rounding; the expanded form has less.
        assert!((load.value(&u, &THETA) - 0.7 * change).abs() < 1e-13 * (1.0 + change.abs()));
    }
}

#[test]
fn follower_gradient_is_pressure_along_the_deformed_normals() {
    let scene = scene(follower("all"), clamped());
    let potential = scene.lower().unwrap();
    let load = &potential.pressures[0];
    let u = wobble(&potential, 0.1);
    let place = |node: usize| -> [f64; 3] {
        std::array::from_fn(|i| scene.mesh.points()[node][i] + u[3 * node + i])
    };
    // Each node carries a third of p n da of its facets.
    let mut expected = vec![0.0; u.len()];
    for nodes in triangles(load) {
        let [o, a, b] = nodes.map(place);
        let [a, b]: [[f64; 3]; 2] = [a, b].map(|x| std::array::from_fn(|i| x[i] - o[i]));
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let area = 0.5 * (a[j] * b[k] - a[k] * b[j]);
            nodes.iter().for_each(|node| expected[3 * node + i] += 0.7 * area / 3.0);
        }
    }
    for (found, expected) in gradient(load, &u, &THETA).iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-14);
    }
}

#[test]
fn derivatives_agree_with_differences_and_tangents_are_symmetric() {
    // Both energies are cubic in u: with this step a central difference errs by 1e-10 only.
    let (step, tolerance) = (1e-5, 1e-9);
    for load in [follower("all"), stand_in("all")] {
        let potential = scene(load, clamped()).lower().unwrap();
        let load = &potential.pressures[0];
        let u = wobble(&potential, 0.1);
        let shifted = |entry: usize, by: f64| {
            let mut u = u.clone();
            u[entry] += by;
            u
        };
        let found = gradient(load, &u, &THETA);
        for entry in 0..u.len() {
            let [up, down] = [step, -step].map(|by| load.value(&shifted(entry, by), &THETA));
            assert!((found[entry] - (up - down) / (2.0 * step)).abs() < tolerance);
        }
        let facet = 3;
        let hessian = response(load, facet, &u).hessian;
        let degree = |slot: usize| 3 * load.facet_nodes(facet)[slot / 3] + slot % 3;
        for column in 0..9 {
            let [up, down] = [step, -step]
                .map(|by| response(load, facet, &shifted(degree(column), by)).gradient);
            for row in 0..9 {
                let slope = (up[row] - down[row]) / (2.0 * step);
                assert!((hessian[9 * row + column] - slope).abs() < tolerance);
                assert_eq!(hessian[9 * row + column], hessian[9 * column + row]);
            }
        }
    }
}

#[test]
fn the_stand_in_is_right_at_rest_only() {
    let (true_load, thesis) = (
        scene(follower("all"), clamped()).lower().unwrap(),
        scene(stand_in("all"), clamped()).lower().unwrap(),
    );
    let [true_load, thesis] = [&true_load.pressures[0], &thesis.pressures[0]].map(Clone::clone);
    let nodes = scene(follower("all"), clamped()).mesh.points().to_vec();
    let rest = vec![0.0; 3 * nodes.len()];
    let both = |u: &[f64]| [gradient(&true_load, u, &THETA), gradient(&thesis, u, &THETA)];
    let [a, b] = both(&rest);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-15));

    // A closed surface blown up s times: the follower load grows like s², the stand-in like
    // 3s² − 2s, because its energy is p·3V(s)(s−1)/s.
    let s = 1.2;
    let inflated: Vec<f64> = nodes.iter().flat_map(|x| x.map(|x| (s - 1.0) * x)).collect();
    let [a, b] = both(&inflated);
    let work = |g: &[f64]| g.iter().zip(nodes.as_flattened()).map(|(g, x)| g * x).sum::<f64>();
    assert!((work(&a) - 0.7 * 3.0 * 6.0 * s * s).abs() < 1e-12);
    assert!((work(&b) / work(&a) - (3.0 * s * s - 2.0 * s) / (s * s)).abs() < 1e-12);
}

/// A tube whose ends slide across x, its rim there uneven by a part of its size.
fn uneven(part: f64) -> Scene {
    let roller = |set: &str| Support::uniform(set, [Some(0.0), None, None]);
    let supports = vec![
        Support::clamped("x_min"),
        roller("x_max"),
        Support::clamped("y_min"),
        Support::clamped("y_max"),
    ];
    let mut scene = scene(follower("z_max"), supports);
    let scatter = |node: usize| ((node * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
    let mut points = scene.mesh.points().to_vec();
    for &node in &scene.mesh.node_sets()["x_max"] {
        points[node][0] += part * 3.0 * scatter(node);
    }
    scene.mesh.place_points(&points);
    scene
}

#[test]
fn a_rim_may_be_as_uneven_as_a_file_prints_it_and_misses_no_more_force_than_is_said() {
    for part in [0.0, 1e-7, 6e-6] {
        let body = uneven(part).lower().unwrap();
        let balance = uneven(part).loose_rims().lower().unwrap();
        // The same pressure without a potential gives the true forces of the deformed surface; single precision prints 6e-6.
        let u = wobble(&body, 0.1);
        let surface = &body.pressures[0];
        let potential = gradient(surface, &u, &THETA);
        let mut exact = vec![0.0; u.len()];
        let mut response = SurfaceResponse::default();
        for facet in 0..surface.facets() {
            surface.facet_force(facet, &u, &mut response);
            for (&node, force) in surface.facet_nodes(facet).iter().zip(response.gradient.chunks(3))
            {
                (0..3).for_each(|i| exact[3 * node + i] += THETA[2] * force[i]);
            }
        }
        assert!(balance.followers.is_empty());
        let free = |i: &usize| body.prescribed[*i].is_none();
        let missed = (0..u.len()).filter(free).map(|i| (potential[i] - exact[i]).abs());
        // Of pressure times area.
        let missed = missed.sum::<f64>() / (THETA[2] * 6.0);
        assert!(missed <= if part == 0.0 { 1e-14 } else { 1e-4 }, "{part}: {missed:e}");
        assert!(part == 0.0 || missed > 1e-3 * part, "{part}: {missed:e}");
    }
}

#[test]
fn a_rim_that_is_not_even_is_refused_with_what_it_would_miss() {
    let error = uneven(0.01).lower().unwrap_err();
    let SceneError::LooseRim(text) = &error else { panic!("{error}") };
    let number = |before: &str| -> f64 {
        let rest = text.split_once(before).expect("the text before a number").1;
        rest.split([' ', ',']).next().and_then(|x| x.parse().ok()).expect("a number")
    };
    let [least, most, percent] = ["from x = ", "to x = ", "so that "].map(number);
    assert!(text.starts_with("the rim of `z_max` slides across x but is not even"), "{error}");
    assert!(least < 3.0 && most > 3.0 && most - least < 0.06, "{least} {most}");
    assert!(percent > 0.01 && text.contains("loose rim"), "{error}");
    assert_eq!(uneven(0.01).loose_rims().lower().unwrap().followers.len(), 1);
}

#[test]
fn a_rim_must_be_held_or_slide_in_a_coordinate_plane() {
    // The top's rim is clear of all supports.
    let loose = scene(follower("z_max"), clamped()).lower().unwrap_err();
    assert!(matches!(loose, SceneError::LooseRim(_)), "{loose}");
    // The thesis' formula does not care.
    assert!(scene(stand_in("z_max"), clamped()).lower().is_ok());

    let held = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped);
    assert!(scene(follower("z_max"), held.into()).lower().is_ok());

    // A rim in one symmetry plane that is not through the origin, the others held.
    let roller = |set: &str, axis: usize| {
        Support::uniform(set, std::array::from_fn(|i| (i == axis).then_some(0.0)))
    };
    let supports = vec![
        Support::clamped("x_min"),
        roller("x_max", 0),
        Support::clamped("y_min"),
        Support::clamped("y_max"),
    ];
    let potential = scene(follower("z_max"), supports).lower().unwrap();
    check_sliding(&potential);

    // Parallel planes 3 mm apart have no common origin.
    let supports = vec![
        roller("x_min", 0),
        roller("x_max", 0),
        Support::clamped("y_min"),
        Support::clamped("y_max"),
    ];
    let planes = scene(follower("z_max"), supports).lower().unwrap_err();
    assert!(planes.to_string().contains("slides in the planes x = "), "{planes}");
    // A case file says then how to write that.
    assert!(matches!(planes, SceneError::LooseRim(_)), "{planes:?}");
}

/// The load on every free degree of freedom is the pressure on the deformed facets.
fn check_sliding(potential: &Body) {
    let load = &potential.pressures[0];
    assert!(!load.thesis);
    let u = wobble(potential, 0.1);
    let found = gradient(load, &u, &THETA);
    let mut expected = vec![0.0; u.len()];
    for (nodes, positions) in triangles(load).iter().zip(load.positions.as_chunks::<3>().0) {
        let place = |a: usize, i: usize| positions[a][i] + u[3 * nodes[a] + i];
        let edge = |a: usize, i: usize| place(a, i) - place(0, i);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let area = 0.5 * (edge(1, j) * edge(2, k) - edge(1, k) * edge(2, j));
            nodes.iter().for_each(|node| expected[3 * node + i] += 0.7 * area / 3.0);
        }
    }
    for entry in potential.free_degrees_of_freedom() {
        assert!((found[entry] - expected[entry]).abs() < 1e-14, "{entry}");
    }
}
