//! Bodies at rest of loaded images: loading them gives the image back, whatever the formulation.

#[path = "../../../fixtures/organ/ventricles.rs"]
mod ventricles;
#[path = "support/ventricle.rs"]
mod ventricle;

use sinew_energy::laws::{ActiveTension, Guccione, HolzapfelOgden, NeoHookean, NeoHookeanShape};
use sinew_energy::{
    Body, Fibres, ForceBalance, Law, Load, Magnitude, Mat3, Parameter, Scene, Support,
};
use sinew_fem::{Options, Unload, UnloadError, UnloadOptions, Unloaded};
use sinew_mesh::{Mesh, TruncatedEllipsoid, box_hexahedra, box_tetrahedra};
use ventricle::{BULK_MODULUS, MMHG, scene, thetas};
use ventricles::ventricles;

/// Nodes return to their image to this \[mm\], in bodies of some 10 to 100 mm.
const CLOSED: f64 = 1e-8;
/// Derivatives against central differences [relative to the largest].
const DIFFERENCE: f64 = 1e-6;

/// Checks what an answer says of itself, and prints it.
fn assert_closes(name: &str, unloaded: &Unloaded) {
    let [least, largest] = &unloaded.volume_ratios;
    let loading = unloaded.loading.expect("loading is the default");
    println!(
        "{name}: {} iterations, {} load steps, det f {least} to {largest}, closes to {:.1e}, {:.3} s of which loading {:.3} s",
        unloaded.iterations, unloaded.load_steps, loading.distance, unloaded.seconds, loading.seconds
    );
    assert!(loading.distance <= CLOSED, "{name}: {:.2e}", loading.distance);
    let moved = unloaded.motion.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
    assert!(moved > 1e-3, "{name}: nothing moved");
}

/// Unloads, and holds the derivatives in θ against central differences.
fn check(name: &str, mut unload: Unload<'_>, theta: &[f64]) -> Unloaded {
    let unloaded = unload.solve(theta, &UnloadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_closes(name, &unloaded);
    let slopes = unload.sensitivity(&unloaded).unwrap();
    for (index, slope) in slopes.iter().enumerate() {
        let step = 1e-4 * theta[index].abs().max(1e-2);
        let mut at = |sign: f64| {
            let mut theta = theta.to_vec();
            theta[index] += sign * step;
            let options = UnloadOptions { load: None, ..UnloadOptions::default() };
            unload.solve_from(&unloaded, &theta, &options).unwrap().motion
        };
        let [a, b, c, d] = [2.0, 1.0, -1.0, -2.0].map(&mut at);
        let largest = slope.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
        for (i, s) in slope.iter().enumerate() {
            let difference = (8.0 * (b[i] - c[i]) - (a[i] - d[i])) / (12.0 * step);
            let error = (s - difference).abs();
            assert!(error <= DIFFERENCE * largest, "{name}, θ{index}: {s} against {difference}");
        }
    }
    unloaded
}

fn parameters<L: Law<D>, const D: usize, const N: usize>(scene: Scene<L, D, N>) -> Scene<L, D, N> {
    L::PARAMETERS.iter().fold(scene, |scene, name| scene.parameter(Parameter::linear(*name, "kPa", 0.0..=1e3)))
}

fn beam<const N: usize>(mesh: Mesh<N>) -> Scene<NeoHookean, 0, N> {
    parameters(Scene::new(mesh, NeoHookean))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
}

const SOFT: [f64; 2] = [15.0, 30.0];

#[test]
fn beams_of_every_element_under_gravity() {
    let (size, cells) = ([60.0, 10.0, 10.0], [8, 2, 2]);
    let tets = box_tetrahedra(size, cells);
    let body = beam(tets.clone()).lower().unwrap();
    check("tetrahedra", Unload::new(&body).unwrap(), &SOFT);
    let body = beam(tets.clone()).lower_averaged().unwrap();
    check("averaged tetrahedra", Unload::new(&body).unwrap(), &SOFT);
    let body = beam(box_hexahedra(size, cells)).lower().unwrap();
    check("hexahedra", Unload::new(&body).unwrap(), &SOFT);
    let body = beam(box_hexahedra(size, cells)).lower_averaged().unwrap();
    check("averaged hexahedra", Unload::new(&body).unwrap(), &SOFT);
    let body = beam(box_tetrahedra(size, [6, 1, 1]).quadratic()).lower().unwrap();
    check("quadratic tetrahedra", Unload::new(&body).unwrap(), &SOFT);
}

#[test]
fn tractions_springs_and_prescribed_motions() {
    let mesh = box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]);
    let scene = parameters(Scene::new(mesh, NeoHookean))
        .load(Load::Traction { facets: "z_max".into(), value: [0.3, 0.5, -0.8] })
        .load(Load::Traction { facets: "x_max".into(), value: [1.0, 0.0, 0.0] })
        .load(Load::Foundation { facets: "z_min".into(), normal: 0.5, tangential: 0.1 })
        .load(Load::Foundation { facets: "y_max".into(), normal: 0.2, tangential: 0.3 })
        .support(Support::uniform("x_min", [Some(0.5), Some(-0.25), None]));
    let body = scene.lower().unwrap();
    check("tractions and springs", Unload::new(&body).unwrap(), &SOFT);
}

#[test]
fn ventricles_of_the_box_at_diastolic_pressures() {
    for (name, mesh) in ventricles() {
        let body = scene(mesh, BULK_MODULUS).lower().unwrap();
        for fibres in [Fibres::Carried, Fibres::Kept] {
            let mut unload = Unload::new(&body).unwrap().fibres(fibres);
            for pressure in [4.0, 8.0, 20.0] {
                for theta in thetas(2, pressure * MMHG) {
                    let name = format!("{name} {fibres:?} {pressure} mmHg {theta:.3?}");
                    match unload.solve(&theta, &UnloadOptions::default()) {
                        Ok(unloaded) => assert_closes(&name, &unloaded),
                        Err(error) => println!("{name}: {error}"),
                    }
                }
            }
        }
    }
}
