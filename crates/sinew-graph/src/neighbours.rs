//! Nearest neighbours within a layer.

use crate::GraphError;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use sinew_num::ascending;
use std::num::NonZero;

/// Pairs `[larger, smaller]` of roots of which one is among the `neighbours` nearest of the
/// other (thesis Eqs. 2.18 and 2.19, made symmetric as in Fig. 2.4).
///
/// Among roots at the same distance the lower index is taken, so the result depends neither on the
/// layout of the tree nor on threads. The immutable tree takes any number of points that share a
/// coordinate, as on regular grids, where trees with bounded buckets fail.
pub(crate) fn nearest_pairs(
    roots: &[[f64; 3]],
    neighbours: usize,
) -> Result<Vec<[usize; 2]>, GraphError> {
    let tree: ImmutableKdTree<f64, 3> =
        ImmutableKdTree::new_from_slice(roots).map_err(|error| {
            GraphError(format!("no nearest-neighbour tree of {} roots: {error}", roots.len()))
        })?;
    // The root itself is its own nearest, at distance zero.
    let wanted = NonZero::<usize>::MIN.saturating_add(neighbours);
    let mut pairs = Vec::with_capacity(roots.len() * neighbours);
    for (root, position) in roots.iter().enumerate() {
        let query = || tree.query(position);
        let nearest = query().nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
        let Some(reach) = nearest.last().map(|n| n.distance) else { continue };
        let within = query().within::<SquaredEuclidean<f64>>(reach).unsorted().execute();
        let mut others: Vec<(f64, usize)> = within
            .into_iter()
            .map(|n| (n.distance, n.item as usize))
            .filter(|&(_, other)| other != root)
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let kept = others.into_iter().take(neighbours);
        pairs.extend(kept.map(|(_, other)| [root.max(other), root.min(other)]));
    }
    Ok(ascending(pairs))
}
