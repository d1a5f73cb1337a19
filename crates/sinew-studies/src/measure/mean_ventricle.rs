//! The mean ventricle under a pressure: θ = (a, b, a_f, b_f, pressure); fibres by rule of any ventricle.

use crate::ventricle_shape::VentricleShape;
use anyhow::Result;
use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_mesh::{AnyMesh, TetMesh};

/// Parameters a \[kPa\], b, a_f \[kPa\] and b_f, and the pressure \[kPa\]; `fixtures/rivals/problem.py` has them, too.
pub(super) const THETA: [f64; 5] = [0.17, 2.4, 3.0, 2.5, 0.9];
/// Bulk modulus \[kPa\].
pub(super) const BULK_MODULUS: f64 = 25.0;

/// Fibres of the cells by rule, between sides of these names.
pub(super) fn fibres(
    mesh: &TetMesh,
    [endocardium, epicardium, base]: [&str; 3],
) -> Result<Vec<[f64; 3]>> {
    let surfaces = Surfaces { endocardium, epicardium, base };
    let frames = by_rule(mesh, &surfaces, &FibreRule::SIXTY)?;
    Ok(frames.iter().map(|frame| frame[0]).collect())
}

/// Scene on a mesh of the ventricle; bulk modulus \[kPa\].
pub(super) fn scene(mesh: impl Into<AnyMesh>, fibres: Vec<[f64; 3]>, bulk_modulus: f64) -> Scene {
    let law = HolzapfelOgden.nearly_incompressible(bulk_modulus);
    let fibres = fibres.into_iter().map(|fibre| [fibre]).collect();
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 0.53..=1.33)) // 4 to 10 mmHg
        .load(pressure)
        .support(Support::clamped("base"))
}

/// The ventricle of tetrahedra; bulk modulus \[kPa\].
pub(super) fn ventricle(cells: [usize; 3], bulk_modulus: f64, averaged: bool) -> Result<Body> {
    let mesh = VentricleShape::new(&[])?.tetrahedra(cells)?;
    let fibres = fibres(&mesh, ["endo", "epi", "base"])?;
    let scene = scene(mesh, fibres, bulk_modulus);
    Ok(if averaged { scene.averaged().lower()? } else { scene.lower()? })
}
