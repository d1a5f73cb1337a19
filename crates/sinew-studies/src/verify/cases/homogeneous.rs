//! Shared parts of the homogeneous benchmarks: laws with their independent references, and stresses from reactions.

use crate::verify::case::Formulation;
use crate::verify::reference::Fung;
use crate::verify::solids::distort::Distort as _;
use crate::verify::solve::scene;
use sinew_energy::laws::{
    Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible,
    NeoHookeanShape,
};
use sinew_energy::{Body, Law, Scene, Solid, Support};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra};
use std::sync::Arc;

pub(super) type Matrix = [[f64; 3]; 3];

/// Fibres, sheets and normals along the axes.
pub(super) const FRAME: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Elements of displacements alone.
pub(super) const ELEMENTS: [Formulation; 5] =
    [Formulation::P1, Formulation::FBar, Formulation::P2, Formulation::Q1, Formulation::Q1FBar];

/// A distorted unit cube in the elements of a formulation, by boxes along an edge, seed and amplitude.
pub(super) fn distorted(formulation: Formulation, cells: usize, (seed, by): (u64, f64)) -> AnyMesh {
    let tets = || box_tetrahedra([1.0; 3], [cells; 3]).distorted(seed, by);
    match formulation {
        Formulation::P1 | Formulation::FBar => tets().into(),
        Formulation::P2 | Formulation::Mixed => tets().quadratic().into(),
        _ => box_hexahedra([1.0; 3], [cells; 3]).distorted(seed, by).into(),
    }
}

/// Eight boxes in the elements of a formulation.
pub(super) fn eight_boxes(formulation: Formulation) -> AnyMesh {
    distorted(formulation, 2, (5, 0.2))
}

/// A law with parameters, fibres, sheets and normals along the axes.
pub(super) struct Material {
    pub name: String,
    at: Box<dyn Fn(usize) -> Arc<dyn sinew_energy::Material>>,
    pub theta: Vec<f64>,
}

impl Material {
    pub(super) fn new<L: Law<D>, const D: usize>(
        name: impl Into<String>,
        law: L,
        theta: &[f64],
    ) -> Self {
        let axes: [_; D] = std::array::from_fn(|direction| FRAME[direction]);
        let at = move |cells| law.clone().along(vec![axes; cells]);
        Self { name: name.into(), at: Box::new(at), theta: theta.to_vec() }
    }

    /// A scene of this material without loads.
    pub(super) fn scene(&self, mesh: impl Into<AnyMesh>, supports: Vec<Support>) -> Scene {
        let mesh = mesh.into();
        let material = (self.at)(mesh.cell_count());
        scene(mesh, material, &self.theta, vec![], supports)
    }
}

/// A law with parameters, and the same law in independent code.
pub(super) struct Exponential {
    pub material: Material,
    pub reference: Fung,
    pub bulk: f64,
}

fn exponential<L: Law<D>, const D: usize>(
    name: &str,
    law: L,
    theta: &[f64],
    reference: Fung,
    bulk: f64,
) -> Exponential {
    Exponential { material: Material::new(name, law, theta), reference, bulk }
}

/// The exponential laws, and the isochoric neo-Hookean one that is their limit.
pub(super) fn exponentials() -> Vec<Exponential> {
    // Bulk modulus of the thesis' ventricle \[kPa\].
    let bulk_modulus = 25.0;
    // Factors of the thesis.
    let thesis = [0.18, 2.6, 3.34, 2.73];
    // Table 1 of Holzapfel & Ogden (2009).
    let dokos = [0.059, 8.023, 18.472, 16.026, 2.481, 11.120, 0.216, 11.436];
    // Problem 1 of Land et al. (2015).
    let land = [2.0, 8.0, 2.0, 4.0];
    vec![
        exponential(
            "isochoric neo-Hookean",
            NeoHookeanShape.nearly_incompressible(bulk_modulus),
            &[2.0],
            Fung::NeoHookean([2.0]),
            bulk_modulus,
        ),
        exponential(
            "Holzapfel–Ogden",
            HolzapfelOgden.nearly_incompressible(bulk_modulus),
            &thesis,
            Fung::HolzapfelOgden(thesis),
            bulk_modulus,
        ),
        exponential(
            "variant of the thesis' code",
            Solid::new(HolzapfelOgdenCompressible, Compressible { kappa: bulk_modulus }),
            &thesis,
            Fung::ThesisCode(thesis),
            bulk_modulus,
        ),
        exponential(
            "Holzapfel–Ogden 2009",
            HolzapfelOgden2009.nearly_incompressible(bulk_modulus),
            &dokos,
            Fung::HolzapfelOgden2009(dokos),
            bulk_modulus,
        ),
        exponential(
            "Guccione",
            Guccione.nearly_incompressible(100.0),
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
