//! Solids of three parts.

use sinew_energy::laws::{FixedTension, HolzapfelOgden, NeoHookeanShape};
use sinew_energy::{
    ActiveStress, Exact, Invariants, Law, Parameter, Scene, SceneError, Support, at_points,
};
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
fn a_tension_that_is_no_number_is_refused() {
    let lower = |tension: f64| {
        let muscle =
            HolzapfelOgden.nearly_incompressible(25.0).with_active(FixedTension { tension });
        let scene = Scene::new(sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]), muscle)
            .support(Support::clamped("x_min"))
            .directions(vec![[[1.0, 0.0, 0.0]]; 6]);
        let names = ["a", "b", "a_f", "b_f"].into_iter();
        names.fold(scene, |s, name| s.parameter(Parameter::log(name, "1", 0.1..=1.0))).lower()
    };
    assert!(lower(-2.0).is_ok(), "a tension may push");
    for tension in [f64::NAN, f64::INFINITY] {
        let error = lower(tension).unwrap_err();
        assert!(matches!(error, SceneError::Constant { name: "tension", .. }), "{error}");
    }
}

#[test]
fn a_point_without_directions_is_outside_the_domain() {
    let law = HolzapfelOgden.nearly_incompressible(25.0);
    let (material, theta) = (at_points(law, vec![[[1.0, 0.0, 0.0]]; 2]), [0.2, 2.0, 3.0, 2.0]);
    let energy = |point| material.energy(point, &theta, &Mat3::ZERO, None);
    assert_eq!((energy(1), energy(2)), (0.0, f64::INFINITY));
    assert_eq!(material.stress(2, &theta, &Mat3::ZERO, None), (f64::INFINITY, Mat3::ZERO));
    assert_eq!(material.response(2, &theta, &Mat3::ZERO).energy, f64::INFINITY);
    assert!(material.directions(2).is_empty());
}
