//! Walls of one layer of linear tetrahedra.

use crate::elements::system::System;
use sinew_energy::{Body, PressureSurface};
use std::collections::HashSet;
use std::fmt;

/// Share of the cells at a pressure that may reach through the wall.
const MOST_THROUGH: f64 = 0.1;

/// A wall one linear tetrahedron thick under a pressure: the strain is constant through its thickness, so that an
/// unloaded configuration is often not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThinWall {
    /// Cells with a facet under a pressure whose other corner is on the far side of the wall.
    pub through: usize,
    /// Cells with a facet under a pressure.
    pub cells: usize,
}

impl fmt::Display for ThinWall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { through, cells } = self;
        write!(
            f,
            "of {cells} cells at the pressure {through} reach through the wall, which has one layer of linear tetrahedra there: its unloaded \
             shape is not to be trusted and often not found; mesh it with two layers or more"
        )
    }
}

impl ThinWall {
    /// The thin wall of a body under pressures, if a tenth of the cells there reach through.
    pub(super) fn of(system: &System<'_>) -> Option<Self> {
        let body = system.body;
        if body.nodes_per_cell != 4 {
            return None;
        }
        let surfaces = body.pressures.iter().chain(system.followers.surfaces);
        let facets = || surfaces.clone().flat_map(facets_of);
        let pressed: HashSet<usize> = facets().flatten().copied().collect();
        let far = far_side(body, &pressed);
        let under: HashSet<_> = facets().map(sorted).collect();
        let (mut through, mut cells) = (0, 0);
        for nodes in body.cell_nodes() {
            for corner in 0..4 {
                let others: Vec<_> = (0..4).filter(|&k| k != corner).map(|k| nodes[k]).collect();
                if under.contains(&sorted(&others)) {
                    cells += 1;
                    through += usize::from(far.contains(&nodes[corner]));
                }
            }
        }
        let thin = through as f64 > MOST_THROUGH * cells as f64;
        thin.then_some(Self { through, cells })
    }
}

fn facets_of(surface: &PressureSurface) -> impl Iterator<Item = &[usize]> {
    (0..surface.facets()).map(|facet| surface.facet_nodes(facet))
}

fn sorted(nodes: &[usize]) -> Vec<usize> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes
}

/// Free nodes on the surface of the body that no pressure acts on.
fn far_side(body: &Body, pressed: &HashSet<usize>) -> HashSet<usize> {
    let facets = body.mesh.boundary_facets();
    let nodes = facets.into_iter().flat_map(|facet| body.mesh.nodes_of_facet(facet));
    let free = |node: &usize| body.prescribed[3 * node..3 * node + 3].iter().all(Option::is_none);
    nodes.filter(|node| !pressed.contains(node) && free(node)).collect()
}
