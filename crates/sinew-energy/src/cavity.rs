//! Cavities: what a pressure fills.

use crate::Body;
use crate::metrics::deformed_volume;
use sinew_mesh::{TriangleMesh, boundary_facets};

/// The space behind a surface that a pressure acts on, such as the chamber of a ventricle, closed by the cone
/// over its rim to an apex in the middle of the rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Cavity {
    /// The facet set.
    pub name: String,
    /// Triangles that cover the surface, counterclockwise seen from outside the solid.
    pub triangles: Vec<[usize; 3]>,
    /// Where the lid meets \[length\].
    pub apex: [f64; 3],
}

impl Cavity {
    /// From the nodes of facets, corners first.
    pub(crate) fn new(
        name: &str,
        facets: &[Vec<usize>],
        corners: usize,
        points: &[[f64; 3]],
    ) -> Self {
        let fan = |nodes: &Vec<usize>| -> Vec<[usize; 3]> {
            (1..corners - 1).map(|k| [nodes[0], nodes[k], nodes[k + 1]]).collect()
        };
        let triangles: Vec<_> = facets.iter().flat_map(fan).collect();
        let surface = TriangleMesh { cells: triangles.clone(), ..TriangleMesh::default() };
        let rim = surface.nodes_of_facets(&boundary_facets(&surface));
        let count = rim.len().max(1) as f64;
        let apex =
            std::array::from_fn(|i| rim.iter().map(|&node| points[node][i]).sum::<f64>() / count);
        Self { name: name.into(), triangles, apex }
    }
}

impl Body {
    /// Volumes of the cavities at a displacement \[length³\].
    pub fn cavity_volumes(&self, displacement: &[f64]) -> Vec<f64> {
        let volume = |Cavity { triangles, apex, .. }: &Cavity| {
            deformed_volume(&self.positions, displacement, triangles, *apex).abs()
        };
        self.cavities.iter().map(volume).collect()
    }
}
