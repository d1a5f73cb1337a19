//! Cavities: what a pressure fills.

use crate::Body;

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
        let rim = rim_nodes(&triangles);
        let count = rim.len().max(1) as f64;
        let apex =
            std::array::from_fn(|i| rim.iter().map(|&node| points[node][i]).sum::<f64>() / count);
        Self { name: name.into(), triangles, apex }
    }

    /// Volume at a displacement \[length³\].
    pub fn volume(&self, points: &[[f64; 3]], displacement: &[f64]) -> f64 {
        crate::metrics::deformed_volume(points, displacement, &self.triangles, self.apex).abs()
    }
}

impl Body {
    /// Volumes of the cavities at a displacement \[length³\].
    pub fn cavity_volumes(&self, displacement: &[f64]) -> Vec<f64> {
        self.cavities.iter().map(|cavity| cavity.volume(&self.positions, displacement)).collect()
    }
}

/// Nodes of the edges that belong to one triangle only, ascending.
fn rim_nodes(triangles: &[[usize; 3]]) -> Vec<usize> {
    let mut owners = std::collections::BTreeMap::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *owners.entry((from.min(to), from.max(to))).or_insert(0) += 1;
        }
    }
    let edges = owners.into_iter().filter(|(_, count)| *count == 1);
    let mut nodes: Vec<usize> = edges.flat_map(|((&a, &b), _)| [a, b]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
