//! A material that is stiffer or softer from cell to cell, such as the scar of an infarct.

use crate::{Barriers, Body, Material, Response, SceneError};
use sinew_num::Mat3;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// A material whose energy counts so many times at each quadrature point.
#[derive(Debug)]
struct Stiffened {
    material: Arc<dyn Material>,
    factors: Vec<f64>,
}

impl Body {
    /// The same body with the energy of its material times the mean of `factors` over the nodes of each cell: a scar that is ten times
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
        let factors = per_point.collect();
        let material = Arc::new(Stiffened { material: self.material.clone(), factors });
        Ok(Self { material, ..self })
    }
}

impl Material for Stiffened {
    fn name(&self) -> &'static str {
        self.material.name()
    }

    fn parameters(&self) -> &'static [&'static str] {
        self.material.parameters()
    }

    fn bounds(&self, index: usize) -> RangeInclusive<f64> {
        self.material.bounds(index)
    }

    fn points(&self) -> Option<usize> {
        Some(self.factors.len())
    }

    fn directions(&self, point: usize) -> &[[f64; 3]] {
        self.material.directions(point)
    }

    fn energy(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> f64 {
        self.factors[point] * self.material.energy(point, parameters, h, barriers)
    }

    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>) {
        let factor = self.factors[point];
        let (energy, stress) = self.material.stress(point, parameters, h, barriers);
        (factor * energy, times(factor, &stress))
    }

    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response {
        let factor = self.factors[point];
        let Response { energy, stress, tangent } = self.material.response(point, parameters, h);
        let tangent = tangent.map(|row| row.map(|entry| factor * entry));
        Response { energy: factor * energy, stress: times(factor, &stress), tangent }
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>> {
        let material = self.material.with_softer_volume(factor)?;
        Some(Arc::new(Self { material, factors: self.factors.clone() }))
    }

    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64> {
        times(self.factors[point], &self.material.stress_rate(point, parameters, rates, h))
    }
}

fn times(factor: f64, stress: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| factor * stress.at(i, j))
}
