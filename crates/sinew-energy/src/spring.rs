//! Elastic supports.

/// A linear spring between a node and where it was: force `−K u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The node.
    pub node: usize,
    /// Symmetric stiffness K [stress·length].
    pub stiffness: [[f64; 3]; 3],
}

impl Spring {
    /// Energy `½ u·K u` [stress·length³].
    pub(crate) fn value(&self, displacement: &[f64]) -> f64 {
        let u = &displacement[3 * self.node..3 * self.node + 3];
        0.5 * (0..3).map(|i| u[i] * self.force(u, i)).sum::<f64>()
    }

    /// Energy [stress·length³]; its derivative is added to `gradient` [stress·length²].
    pub fn value_and_add_gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> f64 {
        let u = &displacement[3 * self.node..3 * self.node + 3];
        for i in 0..3 {
            gradient[3 * self.node + i] += self.force(u, i);
        }
        self.value(displacement)
    }

    fn force(&self, u: &[f64], i: usize) -> f64 {
        (0..3).map(|j| self.stiffness[i][j] * u[j]).sum()
    }
}
