//! Loads per volume and area of the reference configuration, lumped to the nodes; springs of facets.

use crate::FacetRule;
use sinew_num::{cross, dot3};

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

    /// Area `dA` and outward unit normal of each point of a facet, with its shape functions.
    fn at_points<'s>(
        &'s self,
        facet: &'s [usize],
        positions: &'s [[f64; 3]],
    ) -> impl Iterator<Item = (&'s [f64], f64, [f64; 3])> {
        self.rule.points.iter().filter_map(move |point| {
            let [along, across] = self.rule.tangents(facet, point, positions);
            let normal = cross(&along, &across).map(|x| point.weight * x);
            let area = dot3(&normal, &normal).sqrt();
            (area > 0.0).then(|| (&point.shape[..], area, normal.map(|x| x / area)))
        })
    }

    /// The springs of a facet: `∫ N_a N_b (k_t I + (k_n − k_t) n nᵀ) dA`.
    fn spring(&self, facet: &[usize], positions: &[[f64; 3]]) -> Spring {
        let size = 3 * facet.len();
        let mut stiffness = vec![0.0; size * size];
        for (shape, area, n) in self.at_points(facet, positions) {
            for (at, entry) in stiffness.iter_mut().enumerate() {
                let [(a, i), (b, j)] = [at / size, at % size].map(|local| (local / 3, local % 3));
                let same = if i == j { self.tangential } else { 0.0 };
                let k = same + (self.normal - self.tangential) * n[i] * n[j];
                *entry += area * shape[a] * shape[b] * k;
            }
        }
        Spring { nodes: facet.to_vec(), stiffness }
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
            for facet in surface.facets() {
                for (shape, area, _) in surface.at_points(facet, positions) {
                    for (&node, n) in facet.iter().zip(shape) {
                        add(&mut force, node, &surface.traction, n * area);
                    }
                }
            }
        }
        force
    }

    /// Springs, facet by facet.
    pub(crate) fn springs(&self, positions: &[[f64; 3]]) -> Vec<Spring> {
        let sprung = self.surfaces.iter().filter(|s| s.normal != 0.0 || s.tangential != 0.0);
        let of = |surface: &ReferenceSurface| -> Vec<Spring> {
            surface.facets().map(|facet| surface.spring(facet, positions)).collect()
        };
        sprung.flat_map(of).collect()
    }
}

/// Adds `weight × density` to the force on a node.
fn add(force: &mut [f64], node: usize, density: &[f64; 3], weight: f64) {
    (0..3).for_each(|i| force[3 * node + i] += weight * density[i]);
}

/// Linear springs between a facet and where it was: forces `−K u` on its nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Nodes of the facet.
    pub nodes: Vec<usize>,
    /// Symmetric stiffness K over their components, row by row [stress·length].
    pub stiffness: Vec<f64>,
}

impl Spring {
    /// Energy `½ u·K u` [stress·length³].
    pub(crate) fn value(&self, displacement: &[f64]) -> f64 {
        self.forces(displacement).map(|(dof, force)| 0.5 * displacement[dof] * force).sum()
    }

    /// Energy [stress·length³]; its derivative is added to `gradient` [stress·length²].
    pub fn value_and_add_gradient(&self, displacement: &[f64], gradient: &mut [f64]) -> f64 {
        self.forces(displacement).for_each(|(dof, force)| gradient[dof] += force);
        self.value(displacement)
    }

    /// Degrees of freedom with their entries of `K u`.
    fn forces<'s>(&'s self, displacement: &'s [f64]) -> impl Iterator<Item = (usize, f64)> + 's {
        let dof = |local: usize| 3 * self.nodes[local / 3] + local % 3;
        let rows = self.stiffness.chunks_exact(3 * self.nodes.len()).enumerate();
        rows.map(move |(row, entries)| {
            let product = entries.iter().enumerate().map(|(k, entry)| entry * displacement[dof(k)]);
            (dof(row), product.sum())
        })
    }
}
