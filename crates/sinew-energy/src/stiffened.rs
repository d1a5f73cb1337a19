//! A material that is stiffer or softer from cell to cell, such as the scar of an infarct, and parameters of the law that differ
//! likewise, such as the tension of a muscle with a scar in it.

use crate::error::unknown_parameter;
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
    /// [`SceneError::Body`] unless there is one finite, positive factor for every node.
    pub fn stiffened(self, factors: &[f64]) -> Result<Self, SceneError> {
        check(factors, self.nodes, "node", |factor| factor > 0.0)?;
        let of_cells = self.cell_factors(factors)?;
        self.stiffened_cells(&of_cells)
    }

    /// Means over the corners of each cell of one finite factor per node, none of them negative: what [`Body::stiffened_cells`] and
    /// [`Body::with_parameter_field`] take.
    ///
    /// # Errors
    /// [`SceneError::Body`] unless there is one for every node.
    pub fn cell_factors(&self, of_nodes: &[f64]) -> Result<Vec<f64>, SceneError> {
        check(of_nodes, self.nodes, "node", |factor| factor >= 0.0)?;
        // Those of linear and quadratic cells on the same corners.
        let corners = self.element().corners;
        let mean = |cell: &[usize]| {
            cell[..corners].iter().map(|&node| of_nodes[node]).sum::<f64>() / corners as f64
        };
        Ok(self.cell_nodes().map(mean).collect())
    }

    /// [`Body::stiffened`] by one factor per cell.
    ///
    /// # Errors
    /// [`SceneError::Body`] unless there is one finite, positive factor for every cell.
    pub fn stiffened_cells(mut self, factors: &[f64]) -> Result<Self, SceneError> {
        check(factors, self.cell_count(), "cell", |factor| factor > 0.0)?;
        let per_point = self.per_point(factors);
        self.0.material = self.material.stiffened(per_point);
        Ok(self)
    }

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

    /// Values of cells at their quadrature points.
    fn per_point(&self, of_cells: &[f64]) -> Vec<f64> {
        let points = self.points_per_cell;
        of_cells.iter().flat_map(|&factor| std::iter::repeat_n(factor, points)).collect()
    }
}

/// Requires one finite factor for each of `count` places.
fn check(
    factors: &[f64],
    count: usize,
    place: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Result<(), SceneError> {
    let found = factors.len();
    let wrong = |factor: &f64| !(factor.is_finite() && fits(*factor));
    let at = match found == count {
        true => factors.iter().position(wrong),
        false => Some(found.min(count)),
    };
    let Some(at) = at else { return Ok(()) };
    Err(SceneError::Body(format!(
        "a field of factors has one finite number for each {place}, {count} in all, above zero for a stiffness and not below for other parameters; {found} were given, and that of {place} {at} is missing or unfit"
    )))
}
