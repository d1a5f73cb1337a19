//! Loads per volume and area of the reference configuration, lumped to the nodes; springs.

use crate::FacetRule;
use sinew_num::{cross, dot3};
use std::collections::BTreeMap;

/// Loads and elastic supports per volume and area of the body at rest. Its nodal forces and springs are their sums,
/// lumped again when the reference configuration changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceLoads {
    /// Force per reference volume \[stress/length\].
    pub body_force: [f64; 3],
    /// Dead forces on the nodes [stress·length²], which stay when the reference configuration changes: `3 × nodes`, or none.
    pub nodal: Vec<f64>,
    /// Values of the shape functions at each quadrature point of a cell.
    pub shapes: Vec<Vec<f64>>,
    /// Loaded and elastically held surfaces.
    pub surfaces: Vec<ReferenceSurface>,
}

/// A surface with a dead traction or springs per reference area.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSurface {
    /// Shape functions and quadrature of a facet.
    pub rule: FacetRule,
    /// Nodes of the facets, one facet after the other.
    pub nodes: Vec<usize>,
    /// Dead traction \[stress\].
    pub traction: [f64; 3],
    /// Stiffness of the springs along the normal [stress/length].
    pub normal: f64,
    /// Their stiffness across it [stress/length].
    pub tangential: f64,
}

impl ReferenceSurface {
    /// Nodes of each facet.
    pub fn facets(&self) -> impl Iterator<Item = &[usize]> {
        self.nodes.chunks_exact(self.rule.nodes)
    }

    /// Calls `visit` with each node, `N_a dA` and the outward unit normal, point by point.
    fn for_nodes(&self, positions: &[[f64; 3]], mut visit: impl FnMut(usize, f64, [f64; 3])) {
        for facet in self.facets() {
            for point in &self.rule.points {
                let [along, across] = self.rule.tangents(facet, point, positions);
                let normal = cross(&along, &across).map(|x| point.weight * x);
                let area = dot3(&normal, &normal).sqrt();
                if area == 0.0 {
                    continue;
                }
                for (&node, n) in facet.iter().zip(&point.shape) {
                    visit(node, n * area, normal.map(|x| x / area));
                }
            }
        }
    }
}

impl ReferenceLoads {
    /// Dead loads lumped to the nodes [stress·length²], `3 × nodes`, of cells with `points` quadrature points of these volumes.
    pub(crate) fn nodal_force(
        &self,
        cells: &[usize],
        volumes: &[f64],
        positions: &[[f64; 3]],
    ) -> Vec<f64> {
        let mut force = self.nodal.clone();
        force.resize(3 * positions.len(), 0.0);
        let points = self.shapes.len().max(1);
        let present = self.body_force != [0.0; 3];
        for (point, volume) in volumes.iter().enumerate().filter(|_| present) {
            let shape = &self.shapes[point % points];
            let nodes = &cells[point / points * shape.len()..][..shape.len()];
            for (&node, n) in nodes.iter().zip(shape) {
                add(&mut force, node, &self.body_force, n * volume);
            }
        }
        for surface in self.surfaces.iter().filter(|surface| surface.traction != [0.0; 3]) {
            surface.for_nodes(positions, |node, area, _| {
                add(&mut force, node, &surface.traction, area);
            });
        }
        force
    }

    /// Springs lumped to the nodes, ascending.
    pub(crate) fn springs(&self, positions: &[[f64; 3]]) -> Vec<Spring> {
        let mut springs = BTreeMap::new();
        for surface in self.surfaces.iter().filter(|s| s.normal != 0.0 || s.tangential != 0.0) {
            let (normal, tangential) = (surface.normal, surface.tangential);
            surface.for_nodes(positions, |node, area, n| {
                let stiffness = springs.entry(node).or_insert([[0.0; 3]; 3]);
                for i in 0..3 {
                    stiffness[i][i] += area * tangential;
                    for j in 0..3 {
                        stiffness[i][j] += area * (normal - tangential) * n[i] * n[j];
                    }
                }
            });
        }
        springs.into_iter().map(|(node, stiffness)| Spring { node, stiffness }).collect()
    }
}

/// Adds `weight × density` to the force on a node.
fn add(force: &mut [f64], node: usize, density: &[f64; 3], weight: f64) {
    (0..3).for_each(|i| force[3 * node + i] += weight * density[i]);
}

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
