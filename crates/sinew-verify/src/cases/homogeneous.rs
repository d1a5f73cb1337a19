//! What the homogeneous benchmarks share: laws with their independent references, and stresses from reactions.

use crate::reference::Fung;
use sinew_energy::laws::{
    Guccione, HolzapfelOgden, HolzapfelOgden2009, HolzapfelOgdenCompressible,
};
use sinew_energy::{Exact, Law, TotalPotential};

pub(super) type Matrix = [[f64; 3]; 3];

/// Fibres, sheets and normals along the axes.
pub(super) const FRAME: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A law with parameters, and the same law in independent code.
pub(super) struct Exponential<L, const D: usize> {
    pub name: &'static str,
    pub law: L,
    pub theta: Vec<f64>,
    pub reference: Fung,
    pub bulk: f64,
}

impl<L: Law<D>, const D: usize> Exponential<L, D> {
    /// The first directions of the frame.
    pub fn directions(&self) -> [[f64; 3]; D] {
        std::array::from_fn(|i| FRAME[i])
    }
}

/// Bulk modulus of the thesis' ventricle \[kPa\].
const BULK: f64 = 25.0;

/// Transversely isotropic Holzapfel–Ogden, factors of the thesis.
pub(super) fn holzapfel_ogden() -> Exponential<HolzapfelOgden, 1> {
    let theta = [0.18, 2.6, 3.34, 2.73];
    Exponential {
        name: "Holzapfel–Ogden",
        law: HolzapfelOgden { bulk_modulus: BULK },
        theta: theta.to_vec(),
        reference: Fung::HolzapfelOgden(theta),
        bulk: BULK,
    }
}

/// The variant of the thesis' code.
pub(super) fn thesis_code() -> Exponential<HolzapfelOgdenCompressible, 1> {
    let theta = [0.18, 2.6, 3.34, 2.73];
    Exponential {
        name: "variant of the thesis' code",
        law: HolzapfelOgdenCompressible { bulk_modulus: BULK },
        theta: theta.to_vec(),
        reference: Fung::ThesisCode(theta),
        bulk: BULK,
    }
}

/// Orthotropic, table 1 of Holzapfel & Ogden (2009).
pub(super) fn holzapfel_ogden_2009() -> Exponential<HolzapfelOgden2009, 2> {
    let theta = [0.059, 8.023, 18.472, 16.026, 2.481, 11.120, 0.216, 11.436];
    Exponential {
        name: "Holzapfel–Ogden 2009",
        law: HolzapfelOgden2009 { bulk_modulus: BULK },
        theta: theta.to_vec(),
        reference: Fung::HolzapfelOgden2009(theta),
        bulk: BULK,
    }
}

/// Guccione's law as in problem 1 of Land et al. (2015).
pub(super) fn guccione() -> Exponential<Guccione, 3> {
    let theta = [2.0, 8.0, 2.0, 4.0];
    Exponential {
        name: "Guccione",
        law: Guccione { bulk_modulus: 100.0 },
        theta: theta.to_vec(),
        reference: Fung::Guccione(theta),
        bulk: 100.0,
    }
}

/// Mean first Piola–Kirchhoff stress \[stress\] of a body without body force: `∫P dV = Σ reaction ⊗ X`.
pub(super) fn mean_stress<L: Law<D>, const D: usize, const N: usize>(
    potential: &TotalPotential<L, D, Exact, N>,
    displacement: &[f64],
    theta: &[f64],
) -> Matrix {
    let mut forces = vec![0.0; displacement.len()];
    potential.value_and_gradient(displacement, theta, &mut forces);
    let volume: f64 = potential.volumes.iter().sum();
    let moment = |i: usize, j: usize| -> f64 {
        potential.positions.iter().enumerate().map(|(a, x)| forces[3 * a + i] * x[j]).sum()
    };
    std::array::from_fn(|i| std::array::from_fn(|j| moment(i, j) / volume))
}
