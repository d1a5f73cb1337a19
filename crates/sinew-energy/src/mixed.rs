//! Bodies with a field of pressure.

use crate::{Body, SceneError};

impl Body {
    /// Mixed elements with the further bulk modulus 1/`compliance` \[stress\]; 0 is incompressible.
    ///
    /// # Errors
    /// [`SceneError::Body`] where it is negative or not finite.
    pub fn with_compliance(mut self, compliance: f64) -> Result<Self, SceneError> {
        if !(compliance >= 0.0 && compliance.is_finite()) {
            return Err(SceneError::Body(format!(
                "the compliance of the pressure field is {compliance}; give 1/κ, finite and at least 0"
            )));
        }
        self.0.pressure_field.iter_mut().for_each(|field| field.compliance = compliance);
        Ok(self)
    }

    /// Pressures \[stress\] at all nodes of the mesh from those at the nodes of the field, which is linear in each cell; `None` without a
    /// field, or with pressures of another.
    pub fn nodal_pressure(&self, pressure: &[f64]) -> Option<Vec<f64>> {
        let field =
            self.pressure_field.as_ref().filter(|field| field.unknowns == pressure.len())?;
        let edges = self.element().edges;
        let mut of_nodes = vec![0.0; self.nodes];
        field.nodes.iter().zip(pressure).for_each(|(&node, &p)| of_nodes[node] = p);
        for cell in self.cell_nodes() {
            for edge in edges {
                if let [a, b, middle] = **edge {
                    of_nodes[cell[middle]] = 0.5 * (of_nodes[cell[a]] + of_nodes[cell[b]]);
                }
            }
        }
        Some(of_nodes)
    }
}
