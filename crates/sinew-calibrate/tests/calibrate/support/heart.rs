//! A small ideal left ventricle with fibres by a rule, under a pressure and a tension.
#![allow(dead_code, reason = "each program uses a part")]

use sinew_calibrate::{Direction, Observable, PatientBuilder, Segments, WallCoordinates};
use sinew_energy::laws::{ActiveTension, HolzapfelOgden};
use sinew_energy::{Body, Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_mesh::{TetMesh, TruncatedEllipsoid};

/// One millimetre of mercury \[kPa\].
pub(crate) const MMHG: f64 = 0.133_322;
/// Names of the law's parameters and a θ in the middle of their ranges; a and a_f in kPa.
pub(crate) const NAMES: [&str; 4] = ["a", "b", "a_f", "b_f"];
pub(crate) const THETA: [f64; 4] = [0.2, 2.0, 2.8, 2.1];
const SURFACES: Surfaces<'static> =
    Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };

/// Two layers of cells, in mm.
pub(crate) fn mesh() -> TetMesh {
    TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 }
        .wall([2, 8, 5])
        .tetrahedra()
}

/// Fibres of the cells.
pub(crate) fn fibres(mesh: &TetMesh) -> Vec<[[f64; 3]; 1]> {
    let frames = by_rule(mesh, &SURFACES, &FibreRule::SIXTY).expect("a ventricle");
    frames.into_iter().map(|[fibre, _, _]| [fibre]).collect()
}

/// θ = (a, b, a_f, b_f, pressure).
pub(crate) fn passive(mesh: TetMesh, bulk_modulus: f64) -> Scene {
    let tissue = HolzapfelOgden.nearly_incompressible(bulk_modulus).along(fibres(&mesh));
    Scene::new(mesh, tissue)
        .parameter(Parameter::log("a", "kPa", 0.1..=0.4))
        .parameter(Parameter::log("b", "1", 1.0..=4.0))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.0))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.5))
        .parameter(Parameter::linear("pressure", "kPa", 0.0..=3.0))
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) })
        .support(Support::clamped("base"))
}

/// θ = (a, b, a_f, b_f, T_a, pressure), on springs all around and with a base that may widen.
pub(crate) fn beating(mesh: TetMesh) -> Body {
    let law = HolzapfelOgden.nearly_incompressible(25.0).with_active(ActiveTension);
    let muscle = law.along(fibres(&mesh));
    let Scene { parameters, mesh, .. } = passive(mesh, 25.0);
    let mut all = parameters[..4].to_vec();
    all.push(Parameter::linear("T_a", "kPa", 0.0..=60.0));
    all.push(parameters[4].clone());
    let mut beating = Scene::new(mesh, muscle);
    beating.parameters = all;
    beating
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(5) })
        .load(Load::Foundation { facets: "epi".into(), normal: 0.02, tangential: 0.005 })
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::radial("base", [0.0; 3], [0.0, 0.0, 1.0]))
        .averaged()
        .lower()
        .expect("a body")
}

pub(crate) fn wall(mesh: &TetMesh) -> WallCoordinates {
    let wall = WallCoordinates::new(mesh, &SURFACES).expect("a ventricle");
    wall.with_septum([-1.0, 0.1, 0.0]).expect("a direction across the axis")
}

pub(crate) fn segments(wall: &WallCoordinates) -> Segments {
    wall.aha17().expect("cells in each segment")
}

/// Strains of all segments, in their order.
pub(crate) trait ObserveStrains {
    fn observe_strains(self, all: &Segments, direction: Direction, from: &str, to: &str) -> Self;
}

impl ObserveStrains for PatientBuilder<'_> {
    fn observe_strains(self, all: &Segments, direction: Direction, from: &str, to: &str) -> Self {
        let strain = |name: &String| Observable::strain(name.as_str(), direction, from, to);
        all.names().iter().map(strain).fold(self, Self::observe)
    }
}
