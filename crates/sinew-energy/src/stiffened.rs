//! A material that is stiffer or softer from cell to cell, such as the scar of an infarct.

use crate::{Body, SceneError};

impl Body {
    /// Body with the energy of its material times the mean of `factors` over the nodes of each cell: a scar that is ten times
    /// as stiff, or tissue whose stiffness was measured from place to place. Parameters keep their meaning where the factor is one.
    ///
    /// ```
    /// use sinew_energy::{Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let body = Scene::new(box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let scar: Vec<f64> = body.positions.iter().map(|x| if x[0] > 8.0 { 10.0 } else { 1.0 }).collect();
    /// let stiffer = body.clone().stiffened(&scar)?;
    /// let stretched: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
    /// let theta = body.centre();
    /// assert!(stiffer.value(&stretched, &theta) > 2.0 * body.value(&stretched, &theta));
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError::Factors`] unless there is one finite, positive factor for every node.
    pub fn stiffened(self, factors: &[f64]) -> Result<Self, SceneError> {
        let unfit =
            |node: usize| SceneError::Factors { nodes: self.nodes, found: factors.len(), node };
        if factors.len() != self.nodes {
            return Err(unfit(factors.len().min(self.nodes)));
        }
        let wrong = |factor: &f64| !(factor.is_finite() && *factor > 0.0);
        if let Some(node) = factors.iter().position(wrong) {
            return Err(unfit(node));
        }
        let mean = |cell: &[usize]| {
            cell.iter().map(|&node| factors[node]).sum::<f64>() / cell.len() as f64
        };
        let per_point = self
            .cell_nodes()
            .flat_map(|cell| std::iter::repeat_n(mean(cell), self.points_per_cell));
        Ok(Self { material: self.material.stiffened(per_point.collect()), ..self })
    }
}
