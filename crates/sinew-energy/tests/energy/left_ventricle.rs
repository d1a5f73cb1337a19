//! Ventricles lower, their energies are those of an independent program, and the pressure in their cavity is the
//! follower load.

use crate::ventricles::{fixture, ventricles};
use sinew_energy::laws::{Compressible, HolzapfelOgdenCompressible};
use sinew_energy::{Law, Load, Magnitude, Parameter, Sampling, Scene, Solid, Support};
use sinew_mesh::{AnyMesh, TetMesh};

/// θ = (a, b, a_f, b_f, pressure).
fn scene(mesh: TetMesh, load: fn(String, Magnitude) -> Load) -> Scene {
    // Files hold unit vectors to nine digits; the scene and the independent program make them units.
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().expect("three components");
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa or 1".into(),
        range: [0.1, 5.2],
        sampling: Sampling::Log,
    };
    let fibres = fibres.into_iter().map(|fibre| [fibre]).collect();
    let law = Solid::new(HolzapfelOgdenCompressible, Compressible { kappa: 25.0 });
    Scene {
        name: "left ventricle".into(),
        parameters: ["a", "b", "a_f", "b_f", "p"].map(parameter).into(),
        loads: vec![load("region:1".into(), Magnitude::Theta(4))],
        supports: vec![Support::clamped("base")],
        ..Scene::new(mesh, law.along(fibres))
    }
}

/// A displacement that vanishes where the mesh is clamped.
fn motion(mesh: &AnyMesh, at: impl Fn(&[f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let mut u: Vec<_> = mesh.points().iter().map(at).collect();
    mesh.node_sets()["base"].iter().for_each(|&node| u[node] = [0.0; 3]);
    u.into_flattened()
}

/// The law and the pressure of the thesis' code against `fixtures/organ/evaluate.py`, which shares no code with us.
#[test]
fn energies_are_those_of_an_independent_program() {
    let table = std::fs::read_to_string(fixture("energies.csv")).expect("part of the repository");
    for (name, mesh) in ventricles() {
        let scene = scene(mesh, |facets, magnitude| Load::ThesisPressure { facets, magnitude });
        let potential = scene.lower().expect("the ventricle is a scene");
        let rows: Vec<Vec<f64>> = (table.lines())
            .filter_map(|line| line.strip_prefix(name)?.strip_prefix(','))
            .map(|row| row.split(',').map(|x| x.parse().expect("a number")).collect())
            .collect();
        assert_eq!(rows.len(), 9, "{name}");
        for row in rows {
            let [amplitude, a, b, a_f, b_f, strain, p, pressure] = row[..] else {
                panic!("eight numbers, not {row:?}")
            };
            let u = motion(&scene.mesh, |&[x, y, z]| {
                let size = amplitude * (-z / 60.0);
                [0.06 * x + 0.02 * y, 0.06 * y - 0.02 * x, 3.0 * (x / 10.0).sin()].map(|u| size * u)
            });
            let found = [0.0, p].map(|p| potential.value(&u, &[a, b, a_f, b_f, p]));
            let errors = [found[0] / strain - 1.0, (found[1] - strain - pressure) / pressure];
            println!("{name} {row:?}: {errors:?}");
            // Rounding of sums over thousands of cells; at small strain a density loses digits like ε/strain.
            assert!(errors.iter().all(|error| error.abs() < 1e-10), "{name} {row:?}: {errors:?}");
        }
    }
}

#[test]
fn cavity_pressure_inflates_a_ventricle() {
    for (name, mesh) in ventricles() {
        let scene = scene(mesh, |facets, magnitude| Load::Pressure { facets, magnitude });
        inflates(name, &scene);
    }
}

fn inflates(name: &str, scene: &Scene) {
    // The rim of the endocardium lies on the clamped base, or this would be refused.
    let potential = scene.lower().expect("the ventricle is a scene");
    let theta = [0.18, 2.6, 3.34, 2.73, 1.0];
    potential.check_theta(&theta).expect("parameters of healthy tissue");

    // Widen the cavity below the base: everything moves away from the long axis.
    let u = motion(&scene.mesh, |x| {
        let share = 0.05 * (x[2] / -60.0).clamp(0.0, 1.0);
        [share * x[0], share * x[1], 0.0]
    });
    let load = &potential.pressures[0];
    let rest = vec![0.0; u.len()];
    let volume = |u: &[f64]| potential.cavity_volumes(u)[0];
    assert!(volume(&u) > volume(&rest), "{name}");
    // Its energy falls as the cavity widens.
    let change = volume(&rest) - volume(&u);
    assert!((load.value(&u, &theta) - change).abs() < 1e-9 * change.abs(), "{name}");

    let mut gradient = vec![0.0; u.len()];
    let value = potential.value_and_gradient(&u, &theta, &mut gradient);
    assert!(value.is_finite() && gradient.iter().all(|g| g.is_finite()), "{name}");
    // Along the motion itself, by a central difference with a step that balances its errors.
    let step = 1e-5;
    let scaled = |s: f64| potential.value(&u.iter().map(|u| s * u).collect::<Vec<_>>(), &theta);
    let slope = (scaled(1.0 + step) - scaled(1.0 - step)) / (2.0 * step);
    let work: f64 = gradient.iter().zip(&u).map(|(g, u)| g * u).sum();
    assert!((slope - work).abs() < 1e-6 * work.abs(), "{name}: {slope} against {work}");
}
