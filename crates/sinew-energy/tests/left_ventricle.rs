//! A real ventricle lowers, and its cavity pressure is the follower load.

use sinew_energy::laws::HolzapfelOgdenCompressible;
use sinew_energy::{Load, Magnitude, Parameter, Sampling, Scene, Support, Units, metrics};
use sinew_mesh::{TetMesh, read_tet_mesh};
use std::path::Path;

fn ventricle() -> Option<TetMesh> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes");
    let path = shared.join("left_ventricle.vtk");
    if !path.exists() {
        eprintln!("skipped: there is no {}", path.display());
        return None;
    }
    let (mut mesh, _) = read_tet_mesh(path).expect("a readable mesh");
    let clamped = mesh.point_fields["clamped"].to_f64().into_owned();
    let held = (0..clamped.len()).filter(|&node| clamped[node] == 1.0).collect();
    mesh.node_sets.insert("base".into(), held);
    Some(mesh)
}

#[test]
fn cavity_pressure_inflates_a_real_ventricle() {
    let Some(mesh) = ventricle() else { return };
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().expect("three components");
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa or 1".into(),
        range: [0.1, 5.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "left ventricle".into(),
        units: Units::mm_kpa(),
        law: HolzapfelOgdenCompressible::THESIS_KPA,
        directions: fibres.into_iter().map(|fibre| [fibre]).collect(),
        parameters: ["a", "b", "a_f", "b_f", "p"].map(parameter).into(),
        loads: vec![Load::Pressure { facets: "region:1".into(), magnitude: Magnitude::Theta(4) }],
        supports: vec![Support::clamped("base")],
        mesh,
    };
    // The rim of the endocardium lies on the clamped base, or this would be refused.
    let potential = scene.lower().expect("the ventricle is a scene");
    let theta = [0.18, 2.6, 3.34, 2.73, 1.0];
    potential.check_theta(&theta).expect("parameters of healthy tissue");

    // Widen the cavity below the base: everything moves away from the long axis.
    let widen = |x: &[f64; 3]| {
        let share = 0.05 * (x[2] / -60.0).clamp(0.0, 1.0);
        [share * x[0], share * x[1], 0.0]
    };
    let mut u: Vec<f64> = scene.mesh.points.iter().flat_map(widen).collect();
    for (value, prescribed) in u.iter_mut().zip(&potential.prescribed) {
        *value = prescribed.unwrap_or(*value);
    }
    let load = &potential.pressures[0];
    let rest = vec![0.0; u.len()];
    let volume =
        |u: &[f64]| metrics::deformed_volume(&scene.mesh.points, u, &load.facets, [0.0; 3]);
    // Seen from outside the solid the cavity has a negative volume, which falls as it widens.
    assert!(volume(&rest) < 0.0 && volume(&u) < volume(&rest));
    let change = volume(&u) - volume(&rest);
    assert!((load.value(&u, &theta) - change).abs() < 1e-9 * change.abs());

    let mut gradient = vec![0.0; u.len()];
    let value = potential.value_and_gradient(&u, &theta, &mut gradient);
    assert!(value.is_finite() && gradient.iter().all(|g| g.is_finite()));
    // Along the motion itself, by a central difference with a step that balances its errors.
    let step = 1e-5;
    let scaled = |s: f64| potential.value(&u.iter().map(|u| s * u).collect::<Vec<_>>(), &theta);
    let slope = (scaled(1.0 + step) - scaled(1.0 - step)) / (2.0 * step);
    let work: f64 = gradient.iter().zip(&u).map(|(g, u)| g * u).sum();
    assert!((slope - work).abs() < 1e-6 * work.abs());
}
