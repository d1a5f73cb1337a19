//! A parameter of the law that differs from cell to cell, such as the tension of a muscle with a scar in it.

use crate::error::unknown_parameter;
use crate::stiffened::check;
use crate::{Body, SceneError};

impl Body {
    /// Body whose law reads one of its parameters times one factor per cell; θ keeps its value where the factor is one.
    ///
    /// ```
    /// use sinew_energy::{Law, Parameter, Scene, Support, laws::{ActiveTension, HolzapfelOgden}};
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let law = HolzapfelOgden.nearly_incompressible(25.0).with_active(ActiveTension);
    /// let muscle = law.along(vec![[[1.0, 0.0, 0.0]]; 60]);
    /// let mut scene = Scene::new(box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]), muscle)
    ///     .support(Support::clamped("x_min"));
    /// for name in ["a", "b", "a_f", "b_f", "T_a"] {
    ///     scene = scene.parameter(Parameter::log(name, "1", 1.0..=2.0));
    /// }
    /// let body = scene.lower()?;
    /// // The half beyond x = 5 does not contract.
    /// let factors: Vec<f64> = body.cell_nodes()
    ///     .map(|cell| if cell.iter().all(|&node| body.positions[node][0] <= 5.0) { 1.0 } else { 0.0 })
    ///     .collect();
    /// let half = body.clone().with_parameter_field("T_a", &factors)?;
    /// let stretched: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
    /// let tension = |body: &sinew_energy::Body| {
    ///     let at = |tension: f64| body.value(&stretched, &[1.0, 1.0, 1.0, 1.0, tension]);
    ///     at(2.0) - at(1.0)
    /// };
    /// assert!((tension(&half) / tension(&body) - 0.5).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// A name that is not a parameter of the law, and [`SceneError::Body`] unless there is one finite factor for every cell, none of
    /// them negative.
    pub fn with_parameter_field(mut self, name: &str, factors: &[f64]) -> Result<Self, SceneError> {
        let names = self.material.parameters();
        let Some(index) = names.iter().position(|known| *known == name) else {
            return Err(unknown_parameter(name, names));
        };
        check(factors, self.cell_count(), "cell", |factor| factor >= 0.0)?;
        let factors = self.per_point(factors);
        self.0.material = self.material.with_factors(index, factors);
        Ok(self)
    }
}
