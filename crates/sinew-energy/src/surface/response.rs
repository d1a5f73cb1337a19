//! Derivatives of the potential of a unit pressure.

/// Potential of a unit pressure on one facet; the derivatives are in the displacement components of its nodes,
/// component `i` of node `a` at `3a + i`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceResponse {
    /// Energy per pressure \[length³\].
    pub energy: f64,
    /// Nodal forces against the solid with the sign of a derivative \[length²\].
    pub gradient: Vec<f64>,
    /// Their derivatives \[length\], row by row; symmetric for the potential.
    pub hessian: Vec<f64>,
}

impl SurfaceResponse {
    /// Zeros for the nodes of a facet; without a Hessian, that is empty.
    pub(super) fn clear(&mut self, nodes: usize, with_hessian: bool) {
        self.energy = 0.0;
        self.gradient.clear();
        self.gradient.resize(3 * nodes, 0.0);
        self.hessian.clear();
        self.hessian.resize(if with_hessian { 9 * nodes * nodes } else { 0 }, 0.0);
    }

    pub(crate) fn has_hessian(&self) -> bool {
        !self.hessian.is_empty()
    }

    /// Adds `weight × (a ⊗ b + b ⊗ a)` to the Hessian.
    pub(crate) fn add_products(&mut self, weight: f64, a: &[f64], b: &[f64]) {
        for (row, (p, q)) in self.hessian.chunks_exact_mut(a.len()).zip(a.iter().zip(b)) {
            let columns = a.iter().zip(b);
            row.iter_mut().zip(columns).for_each(|(h, (a, b))| *h += weight * (p * b + q * a));
        }
    }

    /// Adds the matrix of `axis ×` to the block of nodes `a` and `b`.
    pub(crate) fn add_cross(&mut self, a: usize, b: usize, axis: [f64; 3]) {
        let size = self.gradient.len();
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.hessian[(3 * a + i) * size + 3 * b + k] += axis[j];
            self.hessian[(3 * a + i) * size + 3 * b + j] -= axis[k];
        }
    }
}
