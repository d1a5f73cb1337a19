//! Loads and elastic supports in plain arrays.

use super::geometry::{cross, dot3, sub};
use super::{Held, Setup, finite};
use crate::cavity::Cavity;
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use crate::rim::rim_origin;
use crate::{FacetPoint, Load, PressureForm, PressureSurface, SceneError, Spring};
use std::collections::BTreeMap;

impl<const N: usize> Setup<'_, N>
where
    Nodes<N>: FiniteElement<N>,
{
    pub(super) fn nodal_force(
        &self,
        rule: &[QuadraturePoint],
        volumes: &[f64],
    ) -> Result<Vec<f64>, SceneError> {
        let mut force = vec![0.0; 3 * self.mesh.points.len()];
        for load in self.loads {
            match load {
                Load::BodyForce(density) => {
                    density.iter().try_for_each(|&b| finite(b, || "a body force".into()))?;
                    let shapes: Vec<_> = rule.iter().map(|p| Nodes::<N>::shape(p.at)).collect();
                    for (point, volume) in volumes.iter().enumerate() {
                        let nodes = &self.mesh.cells[point / rule.len()];
                        for (&node, n) in nodes.iter().zip(&shapes[point % rule.len()]) {
                            add(&mut force, node, density, n * volume);
                        }
                    }
                }
                Load::Traction { facets, value } => {
                    let what = || format!("the traction on `{facets}`");
                    value.iter().try_for_each(|&t| finite(t, what))?;
                    self.for_facet_nodes(facets, |node, area, _| {
                        add(&mut force, node, value, area);
                    })?;
                }
                Load::Foundation { .. } | Load::Pressure { .. } | Load::ThesisPressure { .. } => {}
            }
        }
        for (i, &sum) in force.iter().enumerate() {
            finite(sum, || format!("the sum of the loads on node {}", i / 3))?;
        }
        Ok(force)
    }

    pub(super) fn springs(&self) -> Result<Vec<Spring>, SceneError> {
        let mut springs = BTreeMap::new();
        for load in self.loads {
            let Load::Foundation { facets, normal, tangential } = load else { continue };
            for (&value, which) in [(normal, "normal"), (tangential, "tangential")] {
                let what = || format!("the {which} stiffness of the foundation on `{facets}`");
                finite(value, what)?;
                if value < 0.0 {
                    return Err(SceneError::NegativeStiffness { what: what(), value });
                }
            }
            self.for_facet_nodes(facets, |node, area, n| {
                let stiffness = springs.entry(node).or_insert([[0.0; 3]; 3]);
                for i in 0..3 {
                    stiffness[i][i] += area * tangential;
                    for j in 0..3 {
                        stiffness[i][j] += area * (normal - tangential) * n[i] * n[j];
                    }
                }
            })?;
        }
        Ok(springs.into_iter().map(|(node, stiffness)| Spring { node, stiffness }).collect())
    }

    /// Calls `visit` with each node of a facet set, `N_a dA` and the outward unit normal, point by point.
    fn for_facet_nodes(
        &self,
        name: &str,
        mut visit: impl FnMut(usize, f64, [f64; 3]),
    ) -> Result<(), SceneError> {
        let rule = Nodes::<N>::facet_rule();
        for nodes in self.facet_nodes(name)? {
            for point in &rule.points {
                let normal = self.normal_area(&nodes, point, rule.dimension);
                let area = dot3(&normal, &normal).sqrt();
                if area == 0.0 {
                    continue;
                }
                for (&node, n) in nodes.iter().zip(&point.shape) {
                    visit(node, n * area, normal.map(|x| x / area));
                }
            }
        }
        Ok(())
    }

    /// Outward area vector that a quadrature point of a facet stands for.
    fn normal_area(&self, nodes: &[usize], point: &FacetPoint, dimension: usize) -> [f64; 3] {
        let origin = self.mesh.points[nodes[0]];
        let tangent = |slopes: &[f64]| {
            nodes.iter().zip(slopes).fold([0.0; 3], |sum, (&node, s)| {
                let x = sub(&self.mesh.points[node], &origin);
                std::array::from_fn(|i| sum[i] + s * x[i])
            })
        };
        let along = tangent(&point.slope[0]);
        let across = if dimension == 2 { [0.0, 0.0, 1.0] } else { tangent(&point.slope[1]) };
        cross(&along, &across).map(|x| point.weight * x)
    }

    fn facet_nodes(&self, name: &str) -> Result<Vec<Vec<usize>>, SceneError> {
        let facets = self.facets(name)?.iter();
        Ok(facets.map(|&facet| self.mesh.nodes_of_facet(facet).collect()).collect())
    }

    /// The cavities that pressures act in, in three dimensions.
    pub(super) fn cavities(&self) -> Result<Vec<Cavity>, SceneError> {
        let element = sinew_mesh::Mesh::<N>::ELEMENT;
        let mut cavities: Vec<Cavity> = Vec::new();
        for (_, facets, _) in self.loads.iter().filter_map(Load::pressure) {
            if element.dimension == 3 && cavities.iter().all(|cavity| cavity.name != facets) {
                let nodes = self.facet_nodes(facets)?;
                let corners = element.facet_corners;
                cavities.push(Cavity::new(facets, &nodes, corners, &self.mesh.points));
            }
        }
        Ok(cavities)
    }

    /// The pressures that have a potential, and those that have none.
    pub(super) fn pressures(
        &self,
        held: &Held,
        loose_rims: bool,
    ) -> Result<(Vec<PressureSurface>, Vec<PressureSurface>), SceneError> {
        let (mut pressures, mut followers) = (Vec::new(), Vec::new());
        for (form, name, magnitude) in self.loads.iter().filter_map(Load::pressure) {
            let (points, facets) = (&self.mesh.points, self.facet_nodes(name)?);
            let rule = Nodes::<N>::facet_rule();
            let potential_origin = match form {
                PressureForm::Follower => rim_origin(name, &rule, &facets, points, held),
                PressureForm::Thesis if N == 4 => Ok([0.0; 3]),
                PressureForm::Thesis => Err(SceneError::ThesisPressure { nodes: N }),
            };
            let (origin, has_potential) = match potential_origin {
                Ok(origin) => (origin, true),
                Err(_) if loose_rims && form == PressureForm::Follower => {
                    (points[facets[0][0]], false)
                }
                Err(error) => return Err(error),
            };
            let nodes: Vec<_> = facets.into_iter().flatten().collect();
            let positions = nodes.iter().map(|&node| sub(&points[node], &origin)).collect();
            let triangles = (N == 4 && has_potential).then_some(form);
            let surface = PressureSurface { magnitude, triangles, rule, nodes, positions };
            if has_potential { &mut pressures } else { &mut followers }.push(surface);
        }
        Ok((pressures, followers))
    }
}

/// Adds `weight × density` to the force on a node.
fn add(force: &mut [f64], node: usize, density: &[f64; 3], weight: f64) {
    (0..3).for_each(|i| force[3 * node + i] += weight * density[i]);
}
