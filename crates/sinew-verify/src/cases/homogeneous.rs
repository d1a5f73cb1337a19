//! What the homogeneous benchmarks share: laws with their independent references, and stresses from reactions.

use crate::reference::Fung;
use sinew_energy::laws::{
    ByYoungPoisson, Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible,
    IsochoricNeoHookean, LinearElastic, NeoHookean,
};
use sinew_energy::{Body, Guard, Law, Response};
use sinew_num::{Mat3, Scalar};
use std::ops::RangeInclusive;

pub(super) type Matrix = [[f64; 3]; 3];

/// Fibres, sheets and normals along the axes.
pub(super) const FRAME: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Any of the laws, so that one solver is compiled for all of them. Parameters are padded to [`PARAMETERS`], and
/// every law is handed a whole frame.
#[derive(Clone, Copy, Debug)]
pub(super) enum EveryLaw {
    NeoHookean(NeoHookean),
    ByYoungPoisson(ByYoungPoisson<NeoHookean>),
    LinearElastic(LinearElastic),
    IsochoricNeoHookean(IsochoricNeoHookean),
    HolzapfelOgden(HolzapfelOgden),
    ThesisCode(HolzapfelOgdenCompressible),
    HolzapfelOgden2009(HolzapfelOgden2009),
    Guccione(Guccione),
}

/// As many as the law with most of them has.
const PARAMETERS: usize = 8;

/// Calls a method of the law with the parameters and directions that it reads.
macro_rules! dispatch {
    ($every:expr, $method:ident($parameters:expr, $gradient:expr, $frame:expr $(, $guard:expr)?)) => {{
        let (theta, [fibre, sheet, _]) = ($parameters, $frame);
        match $every {
            EveryLaw::NeoHookean(law) => law.$method(&theta[..2], $gradient, &[] $(, $guard)?),
            EveryLaw::ByYoungPoisson(law) => law.$method(&theta[..2], $gradient, &[] $(, $guard)?),
            EveryLaw::LinearElastic(law) => law.$method(&theta[..2], $gradient, &[] $(, $guard)?),
            EveryLaw::IsochoricNeoHookean(law) => {
                law.$method(&theta[..1], $gradient, &[] $(, $guard)?)
            }
            EveryLaw::HolzapfelOgden(law) => {
                law.$method(&theta[..4], $gradient, std::array::from_ref(fibre) $(, $guard)?)
            }
            EveryLaw::ThesisCode(law) => {
                law.$method(&theta[..4], $gradient, std::array::from_ref(fibre) $(, $guard)?)
            }
            EveryLaw::HolzapfelOgden2009(law) => {
                law.$method(theta, $gradient, &[fibre.clone(), sheet.clone()] $(, $guard)?)
            }
            EveryLaw::Guccione(law) => law.$method(&theta[..4], $gradient, $frame $(, $guard)?),
        }
    }};
}

impl Law<3> for EveryLaw {
    const NAME: &'static str = "any of the laws";
    const PARAMETERS: &'static [&'static str] = &["1", "2", "3", "4", "5", "6", "7", "8"];

    fn bounds(_index: usize) -> RangeInclusive<f64> {
        0.0..=f64::MAX
    }

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        displacement_gradient: &Mat3<S>,
        directions: &[[S; 3]; 3],
        guard: &G,
    ) -> S {
        dispatch!(self, density(parameters, displacement_gradient, directions, guard))
    }

    fn energy<G: Guard>(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &Matrix,
        guard: &G,
    ) -> f64 {
        dispatch!(self, energy(parameters, displacement_gradient, directions, guard))
    }

    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &Matrix,
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        dispatch!(self, stress(parameters, displacement_gradient, directions, guard))
    }

    fn response(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &Matrix,
    ) -> Response {
        dispatch!(self, response(parameters, displacement_gradient, directions))
    }
}

/// A law with parameters.
pub(super) struct Material {
    pub name: String,
    pub law: EveryLaw,
    pub theta: [f64; PARAMETERS],
}

impl Material {
    pub fn new(name: impl Into<String>, law: EveryLaw, theta: &[f64]) -> Self {
        // Any number that is allowed will do for parameters that are not read.
        let padded = std::array::from_fn(|i| theta.get(i).copied().unwrap_or(1.0));
        Self { name: name.into(), law, theta: padded }
    }
}

/// A law with parameters, and the same law in independent code.
pub(super) struct Exponential {
    pub material: Material,
    pub reference: Fung,
    pub bulk: f64,
}

/// The exponential laws, and the isochoric neo-Hookean one that is their limit.
pub(super) fn exponentials() -> Vec<Exponential> {
    let body = |name: &str, law, theta: &[f64], reference, bulk| Exponential {
        material: Material::new(name, law, theta),
        reference,
        bulk,
    };
    // Bulk modulus of the thesis' ventricle \[kPa\].
    let bulk_modulus = 25.0;
    // Factors of the thesis.
    let thesis = [0.18, 2.6, 3.34, 2.73];
    // Table 1 of Holzapfel & Ogden (2009).
    let dokos = [0.059, 8.023, 18.472, 16.026, 2.481, 11.120, 0.216, 11.436];
    // Problem 1 of Land et al. (2015).
    let land = [2.0, 8.0, 2.0, 4.0];
    vec![
        body(
            "isochoric neo-Hookean",
            EveryLaw::IsochoricNeoHookean(IsochoricNeoHookean { bulk_modulus }),
            &[2.0],
            Fung::NeoHookean([2.0]),
            bulk_modulus,
        ),
        body(
            "Holzapfel–Ogden",
            EveryLaw::HolzapfelOgden(HolzapfelOgden { bulk_modulus }),
            &thesis,
            Fung::HolzapfelOgden(thesis),
            bulk_modulus,
        ),
        body(
            "variant of the thesis' code",
            EveryLaw::ThesisCode(HolzapfelOgdenCompressible { bulk_modulus }),
            &thesis,
            Fung::ThesisCode(thesis),
            bulk_modulus,
        ),
        body(
            "Holzapfel–Ogden 2009",
            EveryLaw::HolzapfelOgden2009(HolzapfelOgden2009 { bulk_modulus }),
            &dokos,
            Fung::HolzapfelOgden2009(dokos),
            bulk_modulus,
        ),
        body(
            "Guccione",
            EveryLaw::Guccione(Guccione { bulk_modulus: 100.0 }),
            &land,
            Fung::Guccione(land),
            100.0,
        ),
    ]
}

/// Mean first Piola–Kirchhoff stress \[stress\] of a body without body force: `∫P dV = Σ reaction ⊗ X`.
pub(super) fn mean_stress(potential: &Body, displacement: &[f64], theta: &[f64]) -> Matrix {
    let mut forces = vec![0.0; displacement.len()];
    potential.value_and_gradient(displacement, theta, &mut forces);
    let volume: f64 = potential.volumes.iter().sum();
    let moment = |i: usize, j: usize| -> f64 {
        potential.positions.iter().enumerate().map(|(a, x)| forces[3 * a + i] * x[j]).sum()
    };
    std::array::from_fn(|i| std::array::from_fn(|j| moment(i, j) / volume))
}
