//! Where a potential is evaluated.

use sinew_energy::{Exact, Law, TotalPotential};

/// Where a potential is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<'a> {
    /// Nodal displacements \[length\].
    pub displacement: &'a [f64],
    /// Parameters of law and loads.
    pub theta: &'a [f64],
    /// Fraction of all loads.
    pub load_factor: f64,
    /// Pressure at each quadrature point \[stress\], where it is an unknown; else empty.
    pub pressure: &'a [f64],
}

impl State<'_> {
    /// Π \[stress·length³\]; +∞ as soon as a cell is inverted.
    pub fn energy<L: Law<D>, const D: usize, const N: usize>(
        &self,
        potential: &TotalPotential<L, D, Exact, N>,
    ) -> f64 {
        let parameters = TotalPotential::<L, D, Exact, N>::law_parameters(self.theta);
        let mut energy = self.load_factor * potential.load_value(self.displacement, self.theta);
        energy += potential.springs.iter().map(|s| s.value(self.displacement)).sum::<f64>();
        if !potential.patches.is_empty() {
            return energy + potential.patches_value(self.displacement, self.theta);
        }
        for point in 0..potential.volumes.len() {
            let h = potential.displacement_gradient(point, self.displacement);
            let directions = &potential.directions[point];
            energy += potential.volumes[point]
                * potential.law.energy(parameters, &h, directions, &potential.guard);
            if energy == f64::INFINITY {
                break;
            }
        }
        energy
    }
}
