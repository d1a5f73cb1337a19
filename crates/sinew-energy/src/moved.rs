//! Bodies with a changed reference configuration.

use crate::lower::geometry::orthonormalise;
use crate::{Body, Material, PressureSurface};
use sinew_num::Mat3;
use std::sync::Arc;

/// Material directions where a body is given another shape at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Fibres {
    /// Directions that move with the tissue: a direction m becomes f m / |f m|, those after the first orthonormal to the ones before.
    #[default]
    Carried,
    /// Directions that stay as vectors at the quadrature points.
    Kept,
}

impl Body {
    /// The body with its reference positions displaced by `motion` \[length\], `3 × nodes`. Cells, law, θ, loads per
    /// reference volume and area, supports and pressures stay. `None` where a cell is inverted.
    ///
    /// ```
    /// use sinew_energy::{Fibres, Load, Parameter, Scene, Support, laws::NeoHookean};
    ///
    /// let body = Scene::new(sinew_mesh::box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -1.0]))
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let longer: Vec<f64> = body.positions.iter().flat_map(|x| [0.5 * x[0], 0.0, 0.0]).collect();
    /// let longer = body.moved(&longer, Fibres::Carried).expect("no cell is inverted");
    /// let weight: f64 = longer.nodal_force.iter().sum();
    /// assert!((longer.volumes.iter().sum::<f64>() - 3.0).abs() < 1e-12 && (weight + 3.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn moved(&self, motion: &[f64], fibres: Fibres) -> Option<Self> {
        let maps: Vec<_> = (0..self.volumes.len())
            .map(|point| self.displacement_gradient(point, motion).plus_identity())
            .collect();
        let ratios: Vec<_> = maps.iter().map(Mat3::determinant).collect();
        if !ratios.iter().all(|ratio| *ratio > 0.0 && ratio.is_finite()) {
            return None;
        }
        let mut body = self.clone();
        let moved = &mut body.0;
        let places = moved.positions.as_flattened_mut().iter_mut().zip(motion);
        places.for_each(|(x, u)| *x += u);
        for (volume, ratio) in moved.volumes.iter_mut().zip(&ratios) {
            *volume *= ratio;
        }
        let gradients = moved.shape_gradients.chunks_exact_mut(self.nodes_per_cell);
        for ((map, ratio), gradients) in maps.iter().zip(&ratios).zip(gradients) {
            // ∂N/∂X = f⁻ᵀ ∂N/∂x, and f⁻ᵀ = cof f / det f.
            let cofactors = map.cofactors();
            gradients.iter_mut().for_each(|g| *g = cofactors.apply(g).map(|x| x / ratio));
        }
        Arc::make_mut(&mut moved.mesh).place_points(&moved.positions);
        if fibres == Fibres::Carried {
            moved.material = carried(&self.material, &maps);
        }
        let loads = &moved.reference_loads;
        moved.nodal_force = loads.nodal_force(&moved.cells, &moved.volumes, &moved.positions);
        moved.springs = loads.springs(&moved.positions);
        for surface in moved.pressures.iter_mut().chain(&mut moved.followers) {
            *surface = surface.placed(motion);
        }
        Some(body)
    }
}

/// The material whose directions go with maps f of their points: d becomes f d / |f d|, those after the first orthonormal to the
/// ones before.
fn carried(material: &Arc<dyn Material>, maps: &[Mat3<f64>]) -> Arc<dyn Material> {
    let count = material.law().directions;
    if count == 0 {
        return material.clone();
    }
    let mut directions = Vec::with_capacity(count * maps.len());
    for (point, map) in maps.iter().enumerate() {
        directions.extend(material.directions(point).iter().map(|d| map.apply(d)));
        orthonormalise(&mut directions[count * point..]);
    }
    material.with_directions(directions)
}

impl PressureSurface {
    /// The surface whose nodes are displaced at rest.
    pub fn placed(&self, motion: &[f64]) -> Self {
        let mut moved = self.clone();
        let facets = (&mut moved.positions, &moved.nodes);
        let lids = moved.lids.iter_mut().map(|lid| (&mut lid.positions, &lid.nodes));
        for (positions, nodes) in lids.chain([facets]) {
            for (position, &node) in positions.iter_mut().zip(nodes) {
                (0..3).for_each(|i| position[i] += motion[3 * node + i]);
            }
        }
        moved
    }
}
