//! The surfaces of a ventricle and their checks.

use super::FibreError;
use sinew_mesh::{Facet, TetMesh};
use sinew_num::connected_components;

/// Names of the facet sets that bound a ventricle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surfaces<'a> {
    /// The inner surface.
    pub endocardium: &'a str,
    /// The outer surface.
    pub epicardium: &'a str,
    /// The rim at the valves.
    pub base: &'a str,
}

/// Nodes of the surfaces.
pub(super) struct Bounds {
    pub endocardium: Vec<usize>,
    pub epicardium: Vec<usize>,
    pub base: Vec<usize>,
    nodes: usize,
}

impl Bounds {
    /// # Errors
    /// Surfaces that are missing, empty or touching, and parts of the mesh that do not reach one.
    pub(super) fn new(mesh: &TetMesh, names: &Surfaces<'_>) -> Result<Self, FibreError> {
        let nodes_of = |name: &str| facets(mesh, name).map(|facets| mesh.nodes_of_facets(facets));
        let bounds = Self {
            endocardium: nodes_of(names.endocardium)?,
            epicardium: nodes_of(names.epicardium)?,
            base: nodes_of(names.base)?,
            nodes: mesh.points.len(),
        };
        let inner = |node: &&usize| bounds.endocardium.binary_search(node).is_ok();
        let mut shared = bounds.epicardium.iter().filter(inner);
        if let Some(&node) = shared.next() {
            return Err(FibreError::Unfit(format!(
                "endocardium and epicardium share {} nodes, the first is node {node}; facets of the base belong to a set of their own",
                1 + shared.count()
            )));
        }
        // Each connected part of the mesh has a node on each surface.
        let parts = connected_components(mesh.points.len(), &mesh.cells);
        for (nodes, name) in [
            (&bounds.endocardium, names.endocardium),
            (&bounds.epicardium, names.epicardium),
            (&bounds.base, names.base),
        ] {
            let apart =
                |part: &&Vec<usize>| !part.iter().any(|node| nodes.binary_search(node).is_ok());
            if let Some(part) = parts.iter().find(apart) {
                let (node, nodes) = (part[0], part.len());
                return Err(FibreError::Unfit(format!(
                    "the part of the mesh with node {node} ({nodes} nodes) has no node on `{name}`; remove it, see remove_unused_nodes, or mesh the ventricle in one piece"
                )));
            }
        }
        Ok(bounds)
    }

    /// Values at sets of nodes; later sets override earlier ones.
    pub(super) fn prescribe(&self, sets: &[(&[usize], f64)]) -> Vec<Option<f64>> {
        let mut prescribed = vec![None; self.nodes];
        for (set, value) in sets {
            set.iter().for_each(|&node| prescribed[node] = Some(*value));
        }
        prescribed
    }

    /// The nodes of endocardium and epicardium farthest from the base.
    ///
    /// # Errors
    /// A surface of which each node is on the base.
    pub(super) fn apexes(&self, distance: &[f64]) -> Result<[usize; 2], FibreError> {
        let farthest = |nodes: &[usize]| {
            let apex = nodes.iter().copied().max_by(|&a, &b| distance[a].total_cmp(&distance[b]));
            let apex = apex.filter(|&node| distance[node] > 0.0);
            apex.ok_or_else(|| FibreError::Unfit(format!("there is no apex: all {} nodes of the epicardium are on the base; keep the outer facets out of the base", nodes.len())))
        };
        Ok([farthest(&self.endocardium)?, farthest(&self.epicardium)?])
    }
}

fn facets<'m>(mesh: &'m TetMesh, name: &str) -> Result<&'m [Facet], FibreError> {
    match mesh.facet_sets.get(name).map(Vec::as_slice) {
        None => {
            let known = mesh.facet_sets.keys().cloned().collect();
            Err(FibreError::UnknownSurface { name: name.into(), known })
        }
        Some([]) => Err(FibreError::EmptySurface { name: name.into() }),
        Some(facets) => Ok(facets),
    }
}
