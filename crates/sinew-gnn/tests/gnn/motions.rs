//! Outputs at every scale: rigid motions of clusters as coordinates of the displacement.

use crate::clustered::{Beam, WEIGHT, response, scene};
use crate::common::{devices, relative_difference, small_config};
use sinew_emulate::coordinates::*;
use sinew_energy::{Barriers, Support};
use sinew_fem::Solver;
use sinew_gnn::*;
use sinew_mesh::box_tetrahedra;

#[test]
fn energy_training_bends_the_beam_and_inclined_supports_hold_exactly() {
    let mesh = box_tetrahedra([40.0, 10.0, 10.0], [8, 2, 2]);
    let normal = [1.0, 0.0, 2.0];
    let supports = vec![Support::clamped("x_min"), Support::roller_on_plane("x_max", normal)];
    let beam = Beam::new(mesh, [75.0, 75.0], supports);
    let data = beam.data();
    for device in devices() {
        let surrogate = beam.trained(&data, 300, &device);
        let fixed = surrogate.fixed_geometry(&data.geometries[0]).unwrap();
        let theta = vec![75.0, 75.0];
        let exact = fixed.sensitivity(&theta).unwrap();
        let u = &fixed.predict(std::slice::from_ref(&theta)).unwrap()[0];
        for (dof, prescribed) in beam.body.prescribed.iter().enumerate() {
            if prescribed.is_some() {
                assert!(beam.body.frames.component(dof, u).abs() < 1e-6);
                assert!(beam.body.frames.component(dof, &exact[0]).abs() < 1e-6);
            }
        }
        // Nothing but the energy was told: it must come near its minimum.
        let energy = beam.body.value(u, &theta);
        // Energy that a Newton step from there gains.
        let step = &Solver::new(&beam.body).unwrap().newton_steps(u, &theta, 1).unwrap()[0];
        let excess = 0.5 * step.energy_norm.powi(2);
        assert!(energy < 0.0 && excess < 0.05 * energy.abs(), "{excess} above {energy}");

        let moved = |by: f64| fixed.predict(&[vec![75.0 + by, 75.0]]).unwrap().concat();
        let (ahead, behind) = (moved(0.5), moved(-0.5));
        let finite: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| a - b).collect();
        let difference = relative_difference(&exact[0], &finite);
        assert!(difference < 5e-3, "{difference:e}");
    }
}

#[test]
fn storage_gives_back_the_same_bits() {
    let beam = Beam::hanging([4, 2, 2]);
    let data = beam.data();
    let folder = tempfile::tempdir().unwrap();
    for device in devices() {
        let surrogate = beam.trained(&data, 5, &device);
        surrogate.save(&folder.path().join("surrogate")).unwrap();
        let read = Surrogate::load(&folder.path().join("surrogate"), &device).unwrap();
        assert_eq!(read.geometries(), surrogate.geometries());
        let theta = [vec![60.0, 90.0]];
        let geometry = &data.geometries[0];
        assert_eq!(
            read.predict(geometry, &theta).unwrap(),
            surrogate.predict(geometry, &theta).unwrap()
        );
    }
    let text = serde_json::to_string(&beam.motions()).unwrap();
    assert_eq!(serde_json::from_str::<Motions>(&text).unwrap(), beam.motions());
    assert!(serde_json::from_str::<Motions>(&text.replacen("[null]", "[0]", 1)).is_ok());
    let cut = text.replacen("\"node_parents\":[", "\"node_parents\":[999,", 1);
    assert!(serde_json::from_str::<Motions>(&cut).is_err());
}

#[test]
fn a_place_far_away_changes_nothing() {
    let beam = Beam::hanging([4, 2, 2]);
    let mut mesh = box_tetrahedra([40.0, 10.0, 10.0], [4, 2, 2]);
    mesh.map_points(|[x, y, z]| [x + 1024.0, y, z]);
    let far = Beam::new(mesh, [75.0, 75.0], vec![Support::clamped("x_min")]);
    let [here, there] = [&beam, &far].map(|beam| {
        let data = beam.data();
        let surrogate = beam.trained(&data, 5, &devices()[0]);
        surrogate.predict(&data.geometries[0], &[vec![60.0, 90.0]]).unwrap().concat()
    });
    assert!(relative_difference(&here, &there) < 1e-4);
}

#[test]
fn outputs_of_other_networks_and_bodies_are_refused() {
    let beam = Beam::hanging([4, 2, 2]);
    let mut data = beam.data();
    let surrogate = beam.surrogate(&data, &devices()[0]);
    let plain = Geometry { coordinates: Coordinates::Components, ..data.geometries[0].clone() };
    assert!(matches!(
        surrogate.fixed_geometry(&plain),
        Err(Error::Coordinates(CoordinateError::Count { .. }))
    ));
    let config = small_config(&data, 3);
    let scales = surrogate.scales().clone();
    let other = Surrogate::new(&config, &data, scales, 1, &devices()[0]);
    assert!(matches!(other, Err(Error::Coordinates(CoordinateError::Count { .. }))));
    data.geometries[0].coordinates = Coordinates::Motions(Beam::hanging([3, 2, 2]).motions());
    assert!(matches!(data.check(3), Err(Error::Coordinates(CoordinateError::Count { .. }))));
    let rest = vec![0.0; 3 * beam.body.nodes];
    assert!(Motions::about(&rest, &[], &beam.body, &beam.theta).is_err());
    assert!(Motions::about(&rest[3..], &beam.topology.clusters, &beam.body, &beam.theta).is_err());
    assert!(Motions::about(&rest, &beam.topology.clusters, &beam.body, &[75.0]).is_err());
}

#[test]
fn memory_and_time_grow_with_the_body() {
    // 7300 nodes: a dense map of their 22 000 unknowns would take 1.9 GB, or 260 000 bytes a node.
    let beam = Beam::hanging([36, 13, 13]);
    assert!(3 * beam.body.nodes > 21_500);
    let motions = beam.motions();
    let text = serde_json::to_string(&motions).unwrap();
    assert!(text.len() < 2000 * beam.body.nodes, "{} bytes", text.len());
    // So small that nothing turns.
    let bend = beam.body.positions.iter().flat_map(|x| [0.0, 0.0, -1e-6 * x[0] * x[0]]);
    let bend: Vec<f64> = bend.collect();
    let expansion = motions.with_expansion(std::slice::from_ref(&bend), &beam.body).unwrap();
    let found = expansion.expansion_at(&[1.0], &beam.body).unwrap();
    assert!(relative_difference(&bend, &found) < 1e-3);
}

/// Motions on a turned body give turned displacements.
#[test]
fn coordinates_turn_with_the_body() {
    let turn = |x: [f64; 3]| [x[1], x[2], x[0]];
    let beam = Beam::hanging([4, 2, 2]);
    let mut mesh = box_tetrahedra([40.0, 10.0, 10.0], [4, 2, 2]);
    mesh.points.iter_mut().for_each(|x| *x = turn(*x));
    let body = scene(mesh, turn([0.0, 0.0, -WEIGHT]), vec![Support::clamped("x_min")]);
    let turned = Beam { body, topology: beam.topology.clone(), theta: beam.theta };
    let expected: Vec<f64> = beam.response().as_chunks().0.iter().flat_map(|&u| turn(u)).collect();
    assert!(relative_difference(&turned.response(), &expected) < 1e-7);
}

/// Share of the energy that bending gains which a prediction leaves: 1 at rest, about 0 at equilibrium. These beams bend
/// little, so that the linear response has all but the last hundredths of it.
fn energy_left(beam: &Beam, fixed: &FixedGeometry) -> f64 {
    let found = fixed.predict(&[beam.theta.to_vec()]).unwrap();
    1.0 + beam.body.value(&found[0], &beam.theta) / beam.energy()
}

#[test]
fn bodies_of_different_graphs_train_together_and_a_network_goes_on_to_others() {
    // Different numbers of nodes, edges and layers of clusters.
    let beams = [Beam::hanging([4, 1, 1]), Beam::hanging([6, 2, 2])];
    let layers = beams.each_ref().map(|beam| beam.topology.roots_per_layer.len());
    assert!(layers[0] < layers[1], "{layers:?}");
    let [few, many] = beams.each_ref().map(Beam::data);
    let second = few.training.iter().map(|sample| Sample { geometry: 1, ..sample.clone() });
    let data = DataSet {
        geometries: vec![few.geometries[0].clone(), many.geometries[0].clone()],
        training: few.training.iter().cloned().chain(second).collect(),
        validation: vec![],
    };
    let device = &devices()[0];
    let potential = |beam: &Beam| -> std::sync::Arc<dyn Potential> {
        std::sync::Arc::new(beam.body.clone().with_barriers(Barriers::default()))
    };
    let potentials = beams.iter().map(potential).collect();
    let objective = MinimumPotential::new(potentials, beams[0].energy()).unwrap();
    let settings = TrainingConfig {
        budget: TrainingBudget::Steps(400),
        batch: 4,
        learning_rate: 1e-2,
        evaluations: 1,
        ..TrainingConfig::default()
    };
    // The network has the layers of the finer body.
    let surrogate = beams[1].surrogate(&data, device);
    let mut trainer = Trainer::new(surrogate, data, Box::new(objective), settings.clone()).unwrap();
    trainer.run(&mut ()).unwrap();
    let surrogate = trainer.into_surrogate();
    for (beam, geometry) in beams.iter().zip(surrogate.geometries()) {
        let left = energy_left(beam, &surrogate.fixed_geometry(geometry).unwrap());
        assert!((-0.05..0.1).contains(&left), "{left}");
    }
    // On a mesh with more layers than the network has, a few steps of fine-tuning do more than training from scratch.
    let finer = Beam::hanging([8, 3, 3]);
    assert!(finer.topology.roots_per_layer.len() > layers[1]);
    let data = finer.data();
    let left_after = |surrogate: Surrogate| {
        let objective = MinimumPotential::new(vec![potential(&finer)], finer.energy()).unwrap();
        let settings = TrainingConfig { budget: TrainingBudget::Steps(60), ..settings.clone() };
        let mut trainer =
            Trainer::new(surrogate, data.clone(), Box::new(objective), settings).unwrap();
        trainer.run(&mut ()).unwrap();
        let fixed = trainer.surrogate().fixed_geometry(&data.geometries[0]).unwrap();
        energy_left(&finer, &fixed)
    };
    let carried = left_after(surrogate.transferred_to(&data).unwrap());
    let fresh = left_after(finer.surrogate(&data, device));
    println!("a finer mesh after sixty steps: {carried:.3} and {fresh:.3} of the energy is left");
    assert!(carried < 0.5 * fresh, "{carried} {fresh}");
}

#[test]
fn outputs_have_the_first_order_expansion() {
    let rollers =
        vec![Support::clamped("x_min"), Support::roller_on_plane("x_max", [1.0, 0.0, 2.0])];
    let mesh = box_tetrahedra([40.0, 10.0, 10.0], [4, 2, 2]);
    let beam = Beam::new(mesh, [50.0 * 2f64.sqrt(); 2], rollers);
    let mut data = beam.data();
    let Coordinates::Motions(motions) = data.geometries[0].coordinates.clone() else { panic!() };
    // Of two parameters the first moves the body as its weight does, the second as a weight along y would.
    let sideways = scene(
        box_tetrahedra([40.0, 10.0, 10.0], [4, 2, 2]),
        [0.0, WEIGHT, 0.0],
        vec![Support::clamped("x_min"), Support::roller_on_plane("x_max", [1.0, 0.0, 2.0])],
    );
    let changes = [beam.response(), response(&sideways, &beam.theta)];
    let expansion = motions.clone().with_expansion(&changes, &beam.body).unwrap();
    let small = 1e-4;
    for (p, change) in changes.iter().enumerate() {
        let parameters: [f64; 2] = std::array::from_fn(|i| if i == p { small } else { 0.0 });
        let found = expansion.expansion_at(&parameters, &beam.body).unwrap();
        let found: Vec<f64> = found.iter().map(|u| u / small).collect();
        assert!(relative_difference(change, &found) < 1e-3, "{p}");
        // Half of the way, and of no energy's size.
        let damped = expansion.clone().damped([0.5, 0.5], 1).of_energy(1.0).unwrap();
        let half: Vec<f64> = damped.expansion_at(&parameters, &beam.body).unwrap();
        let half: Vec<f64> = half.iter().map(|u| 2.0 * u / small).collect();
        assert!(relative_difference(change, &half) < 1e-3, "{p}");
    }
    assert!(expansion.expansion_at(&[0.0; 3], &beam.body).is_err());
    assert!(motions.clone().with_expansion(&[vec![0.0; 3]], &beam.body).is_err());
    let text = serde_json::to_string(&expansion).unwrap();
    assert_eq!(serde_json::from_str::<Motions>(&text).unwrap(), expansion);
    assert_eq!(expansion.features().len(), 12 * beam.topology.nodes);

    // A network that adds nothing predicts that, with its derivatives.
    data.geometries[0].coordinates = Coordinates::Motions(expansion.clone());
    for device in devices() {
        let surrogate = beam.surrogate(&data, &device);
        let fixed = surrogate.fixed_geometry(&data.geometries[0]).unwrap();
        let theta = vec![55.0, 95.0];
        let expected = surrogate.scales().parameters.standardise(&theta).unwrap();
        let expected = expansion.expansion_at(&expected, &beam.body).unwrap();
        let found = fixed.predict(std::slice::from_ref(&theta)).unwrap();
        assert!(relative_difference(&expected, &found[0]) < 1e-5);
        let centre = beam.theta.to_vec();
        let found = fixed.sensitivity(&centre).unwrap();
        assert_eq!(found.len(), centre.len());
        let slopes = surrogate.scales().parameters.slopes(&centre);
        for ((own, change), slope) in found.iter().zip(&changes).zip(slopes) {
            let expected: Vec<f64> = change.iter().map(|u| slope * u).collect();
            assert!(relative_difference(&expected, own) < 1e-4);
        }
    }
    // Parameters that the outputs do not know are refused.
    let one = motions.with_expansion(&changes[..1], &beam.body).unwrap();
    data.geometries[0].coordinates = Coordinates::Motions(one);
    let scales = beam.surrogate(&beam.data(), &devices()[0]);
    assert!(matches!(
        scales.fixed_geometry(&data.geometries[0]),
        Err(Error::Coordinates(CoordinateError::Count { .. }))
    ));
}

#[test]
fn the_expansion_holds_over_decades_of_stiffness_in_proportion_to_an_amplitude() {
    let beam = Beam::hanging([4, 2, 2]);
    // So small that nothing turns: the displacement falls like the inverse of the first parameter's exponential.
    let origin: Vec<f64> = beam.response().iter().map(|u| 1e-3 * u).collect();
    let about = Motions::about(&origin, &beam.topology.clusters, &beam.body, &beam.theta).unwrap();
    let part = |part: f64| -> Vec<f64> { origin.iter().map(|u| part * u).collect() };
    let changes = [part(-1.0), part(0.0), part(0.5), part(0.0), part(0.0)];
    let plain = about.clone().with_expansion(&changes, &beam.body).unwrap();
    let expansion = about.clone().with_amplitude(&changes, 2, &beam.body).unwrap();
    let at = |motions: &Motions, t: f64| motions.expansion_at(&[t, 0.3], &beam.body).unwrap();
    // No polynomial falls to a fourteenth; the amplitude saturates far beyond.
    for t in [-1.5f64, 0.7, 1.5] {
        let bounded = 3.0 * (-t / 3.0).tanh();
        assert!(relative_difference(&part(bounded.exp()), &at(&expansion, t)) < 1e-3, "{t}");
    }
    assert!(relative_difference(&part((-1.5f64).exp()), &at(&plain, 1.5)) > 1.0);
    assert!(at(&expansion, -400.0).iter().all(|u| u.is_finite()));
    // Whatever the changes, both are the same to second order: what is between them falls by eight where parameters halve.
    let mut random = (1..).map(|k: i32| (17.0 * f64::from(k)).sin() * (5.3 * f64::from(k)).cos());
    let size = origin.iter().fold(0f64, |most, u| most.max(u.abs()));
    // What is held stays.
    let mut change = |u: &f64| match *u {
        0.0 => 0.0,
        u => 0.5 * u + 0.2 * size * random.next().unwrap(),
    };
    let changes: Vec<Vec<f64>> = (0..5).map(|_| origin.iter().map(&mut change).collect()).collect();
    let plain = about.clone().with_expansion(&changes, &beam.body).unwrap();
    let expansion = about.clone().with_amplitude(&changes, 2, &beam.body).unwrap();
    let at = |motions: &Motions, h: f64| motions.expansion_at(&[h, -0.7 * h], &beam.body).unwrap();
    let [far, near] = [0.2, 0.1].map(|h| relative_difference(&at(&plain, h), &at(&expansion, h)));
    assert!((6.5..9.5).contains(&(far / near)) && near > 1e-6, "{far:e} {near:e}");
    // The size of outputs changes nothing.
    let other = expansion.clone().of_energy(3.0).unwrap();
    assert!(relative_difference(&at(&expansion, 0.9), &at(&other, 0.9)) < 1e-12);
    let text = serde_json::to_string(&expansion).unwrap();
    assert_eq!(serde_json::from_str::<Motions>(&text).unwrap(), expansion);
    assert!(about.clone().with_amplitude(&changes[..2], 2, &beam.body).is_err());
    let rest =
        Motions::about(&part(0.0), &beam.topology.clusters, &beam.body, &beam.theta).unwrap();
    assert!(rest.with_amplitude(&changes, 2, &beam.body).is_err());

    // A network that adds nothing predicts that, with its derivatives.
    let mut data = beam.data();
    data.geometries[0].coordinates = Coordinates::Motions(expansion.clone());
    for device in devices() {
        let surrogate = beam.surrogate(&data, &device);
        let fixed = surrogate.fixed_geometry(&data.geometries[0]).unwrap();
        let scaling = &surrogate.scales().parameters;
        let theta = vec![58.0, 95.0];
        let exact = |theta: &[f64]| {
            expansion.expansion_at(&scaling.standardise(theta).unwrap(), &beam.body).unwrap()
        };
        let found = fixed.predict(std::slice::from_ref(&theta)).unwrap();
        assert!(relative_difference(&exact(&theta), &found[0]) < 1e-5);
        let step = 1e-3;
        let sensitivity = fixed.sensitivity(&theta).unwrap();
        assert_eq!(sensitivity.len(), 2);
        for (p, found) in sensitivity.iter().enumerate() {
            let [more, less] = [step, -step].map(|step| {
                exact(&[theta[0] + f64::from(p == 0) * step, theta[1] + f64::from(p == 1) * step])
            });
            let expected: Vec<f64> =
                more.iter().zip(&less).map(|(a, b)| (a - b) / (2.0 * step)).collect();
            assert!(relative_difference(&expected, found) < 1e-4, "{p}");
        }
    }
}
