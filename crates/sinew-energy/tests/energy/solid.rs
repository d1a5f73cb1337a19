//! Solids of three parts.

use sinew_energy::laws::{HolzapfelOgden, NeoHookean, NeoHookeanShape};
use sinew_energy::{ActiveStress, Body, Exact, Invariants, Law, Parameter, Scene, Support};
use sinew_num::{Mat3, Scalar};

/// Holds no value, and yet is a stress.
#[derive(Clone, Debug)]
struct Swelling;

impl ActiveStress<0> for Swelling {
    const PARAMETERS: &'static [&'static str] = &[];

    fn density_of<S: Scalar>(&self, _: &[S], invariants: &Invariants<S, 0>) -> S {
        invariants.volume_change.clone() * -3.0
    }
}

#[test]
fn an_active_stress_without_values_of_its_own_counts() {
    let passive = NeoHookeanShape.nearly_incompressible(25.0);
    let active = passive.with_active(Swelling);
    let (energy, stress) = active.stress(&[2.0], &Mat3::ZERO, &[], &Exact);
    assert_eq!((energy, stress), (0.0, Mat3::from_fn(|i, j| if i == j { -3.0 } else { 0.0 })));
    assert_eq!(passive.stress(&[2.0], &Mat3::ZERO, &[], &Exact).1, Mat3::ZERO);
}

#[test]
fn a_point_without_directions_is_outside_the_domain() {
    let law = HolzapfelOgden.nearly_incompressible(25.0);
    let (material, theta) = (law.along(vec![[[1.0, 0.0, 0.0]]; 2]), [0.2, 2.0, 3.0, 2.0]);
    let energy = |point| material.energy(point, &theta, &Mat3::ZERO, None);
    assert_eq!((energy(1), energy(2)), (0.0, f64::INFINITY));
    assert_eq!(material.stress(2, &theta, &Mat3::ZERO, None), (f64::INFINITY, Mat3::ZERO));
    assert_eq!(material.response(2, &theta, &Mat3::ZERO).energy, f64::INFINITY);
    assert!(material.directions(2).is_empty());
}

#[test]
fn a_field_of_stiffness_counts_energy_cell_by_cell() {
    let bar = Scene::new(sinew_mesh::box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=4.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=4.0))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    let nodes = bar.nodes;
    let u: Vec<f64> = (0..3 * nodes).map(|i| 0.02 * (i as f64).sin()).collect();
    let (theta, doubled) = ([1.5, 2.5], [3.0, 5.0]);
    // Neo-Hookean energy is linear in its parameters.
    let gradient = |body: &Body, theta: &[f64]| {
        let mut gradient = vec![0.0; 3 * nodes];
        let energy = body.value_and_gradient(&u, theta, &mut gradient);
        gradient.push(energy);
        gradient
    };
    let twice = bar.clone().stiffened(&vec![2.0; nodes]).unwrap();
    let close = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(close(gradient(&twice, &theta), gradient(&bar, &doubled)));
    let tangent = |body: &Body, theta: &[f64]| {
        let at =
            |point| body.material.response(point, theta, &body.displacement_gradient(point, &u));
        (0..bar.cell_count()).flat_map(|point| at(point).tangent.concat()).collect()
    };
    assert!(close(tangent(&twice, &theta), tangent(&bar, &doubled)));
    // A scar at one end: only its cells count more, by the mean over their nodes.
    let factors: Vec<f64> =
        bar.positions.iter().map(|x| if x[0] > 3.5 { 9.0 } else { 1.0 }).collect();
    let scarred = bar.clone().stiffened(&factors).unwrap();
    for point in 0..bar.cell_count() {
        let cell = bar.nodes_of_cell(point);
        let mean = cell.iter().map(|&node| factors[node]).sum::<f64>() / cell.len() as f64;
        let h = bar.displacement_gradient(point, &u);
        let [plain, more] =
            [&bar, &scarred].map(|body| body.material.energy(point, &theta, &h, None));
        assert!((more - mean * plain).abs() <= 1e-15 * more.abs());
    }
    for (wrong, node) in [(vec![1.0; nodes - 1], nodes - 1), (vec![f64::NAN; nodes], 0)] {
        let Err(error) = bar.clone().stiffened(&wrong) else { panic!("no field of stiffness") };
        assert!(error.to_string().contains(&format!("that of node {node} ")), "{error}");
    }
    assert!(bar.stiffened(&[vec![1.0; nodes - 1], vec![0.0]].concat()).is_err());
}
