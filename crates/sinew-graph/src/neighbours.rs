//! Nearest neighbours within a layer.

use crate::GraphError;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
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
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, without a tree.
    fn by_comparison(roots: &[[f64; 3]], neighbours: usize) -> Vec<[usize; 2]> {
        let mut pairs = Vec::new();
        for (i, a) in roots.iter().enumerate() {
            let distance = |j: usize| (0..3).map(|d| (a[d] - roots[j][d]).powi(2)).sum::<f64>();
            let mut others: Vec<usize> = (0..roots.len()).filter(|&j| j != i).collect();
            others.sort_by(|&j, &k| distance(j).total_cmp(&distance(k)).then(j.cmp(&k)));
            pairs.extend(others.into_iter().take(neighbours).map(|j| [i.max(j), i.min(j)]));
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    #[test]
    fn regular_grids_of_many_equal_coordinates() {
        // 400 points in a plane, 20 per line, and all in one line: more equal coordinates than
        // a bucket of 32 holds.
        let plane: Vec<_> = (0..400).map(|i| [(i % 20) as f64, (i / 20) as f64, 0.0]).collect();
        assert_eq!(nearest_pairs(&plane, 5).unwrap(), by_comparison(&plane, 5));
        let line: Vec<_> = (0..200).map(|i| [0.0, 0.5, i as f64]).collect();
        assert_eq!(nearest_pairs(&line, 4).unwrap(), by_comparison(&line, 4));
    }

    #[test]
    fn coincident_points() {
        let same = [[0.25, 0.5, 0.75]; 100];
        assert_eq!(nearest_pairs(&same, 3).unwrap(), by_comparison(&same, 3));
    }

    #[test]
    fn zero_neighbours_and_more_than_there_are() {
        let points = [[0.0; 3], [1.0; 3], [3.0; 3]];
        assert!(nearest_pairs(&points, 0).unwrap().is_empty());
        assert_eq!(nearest_pairs(&points, 9).unwrap(), [[1, 0], [2, 0], [2, 1]]);
    }
}
