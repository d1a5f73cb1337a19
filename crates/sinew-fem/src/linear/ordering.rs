//! Orders of elimination that keep factors sparse.

mod graph;
mod separator;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use graph::{Graph, Random};
use separator::{BETWEEN, Separation};
use sinew_num::SplitMix64;

/// Graphs up to this many vertices are ordered by minimum degree. Measured on beams with three unknowns per vertex:
/// entries of the factor by degree and by dissection are 0.41 and 0.43 million with 784 vertices, 1.21 and
/// 1.19 with 1620, and 16.9 and 14.8 with 10 080.
const MOST_BY_DEGREE: usize = 1_500;
/// Parts up to this many vertices are not cut further; 200 gives 1 % more operations.
const LEAF: usize = 50;
/// Parts of at least this many vertices are ordered by two threads.
const PARALLEL: usize = 4_000;

/// An order of elimination for little fill in the Cholesky factor of a symmetric matrix with the given
/// graph: the neighbours of vertex `v`, without itself, are `neighbours[starts[v]..starts[v + 1]]`, and each
/// is listed on both sides.
///
/// Small graphs are ordered by approximate minimum degree (P. R. Amestoy, T. A. Davis, I. S. Duff, SIAM J. Matrix
/// Anal. Appl. 17, 1996), large ones by nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973) with separators
/// from multilevel bisection. The same graph has the same order, on any number of threads.
pub(crate) fn fill_reducing_order(starts: &[usize], neighbours: &[usize]) -> Vec<usize> {
    let graph = Graph::unweighted(starts, neighbours);
    let order = if graph.len() <= MOST_BY_DEGREE {
        minimum_degree(&graph)
    } else {
        let mut order = vec![0; graph.len()];
        let vertices: Vec<u32> = (0..graph.len() as u32).collect();
        dissect(&graph, &vertices, 0, &mut order);
        order
    };
    order.into_iter().map(|vertex| vertex as usize).collect()
}

/// Writes the elimination order of a part of the graph: both sides of a separator, then itself.
///
/// `names` are the vertices' names in the whole graph.
fn dissect(graph: &Graph, names: &[u32], seed: u64, order: &mut [u32]) {
    let by_degree = |order: &mut [u32]| {
        for (place, vertex) in order.iter_mut().zip(minimum_degree(graph)) {
            *place = names[vertex as usize];
        }
    };
    if graph.len() <= LEAF {
        return by_degree(order);
    }
    let mut random = Random(SplitMix64(seed));
    let separation = Separation::find(graph, &mut random);
    if separation.cost().0 {
        // Nothing separates the graph: it is complete, or nearly so.
        return by_degree(order);
    }
    let mut parts = [Vec::new(), Vec::new(), Vec::new()];
    let mut place = vec![0; graph.len()];
    for (vertex, &part) in separation.part.iter().enumerate() {
        place[vertex] = parts[part as usize].len() as u32;
        parts[part as usize].push(vertex as u32);
    }
    let side = |part: u8| {
        let vertices = &parts[part as usize];
        let own = |(vertex, &p): (usize, &u32)| {
            if separation.part[vertex] == part { p } else { u32::MAX }
        };
        let place: Vec<u32> = place.iter().enumerate().map(own).collect();
        let names: Vec<u32> = vertices.iter().map(|&v| names[v as usize]).collect();
        (graph.induced(vertices, &place), names)
    };
    let (left, rest) = order.split_at_mut(parts[0].len());
    let (right, between) = rest.split_at_mut(parts[1].len());
    for (place, &vertex) in between.iter_mut().zip(&parts[BETWEEN as usize]) {
        *place = names[vertex as usize];
    }
    let seeds = [random.0.bits(), random.0.bits()];
    let order_side = |part: u8, order: &mut [u32]| {
        let (graph, names) = side(part);
        dissect(&graph, &names, seeds[part as usize], order);
    };
    if graph.len() >= PARALLEL {
        rayon::join(|| order_side(0, left), || order_side(1, right));
    } else {
        order_side(0, left);
        order_side(1, right);
    }
}

/// The vertices ordered by approximate minimum degree.
fn minimum_degree(graph: &Graph) -> Vec<u32> {
    let size = graph.len();
    let (mut starts, mut rows) = (Vec::with_capacity(size + 1), Vec::new());
    starts.push(0);
    for vertex in 0..size {
        let first = rows.len();
        rows.extend(graph.neighbours(vertex).iter().map(|&n| n as usize).filter(|&n| n < vertex));
        rows[first..].sort_unstable();
        starts.push(rows.len());
    }
    let entries = rows.len();
    let upper = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
    let mut forward = vec![0; size];
    let mut inverse = vec![0; size];
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(size, entries));
    let control = amd::Control::default();
    let ordered =
        amd::order(&mut forward, &mut inverse, upper.as_ref(), control, MemStack::new(&mut memory));
    match ordered {
        Ok(_) => forward.into_iter().map(|vertex| vertex as u32).collect(),
        // Only memory can run out, and any order is an order.
        Err(_) => (0..size as u32).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Side;
    use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};

    /// A grid in which each vertex is joined to those next to it, diagonally too.
    pub(super) fn grid(size: [usize; 3]) -> Vec<Vec<usize>> {
        let index = |at: [usize; 3]| at[0] + size[0] * (at[1] + size[1] * at[2]);
        let near = |x: usize, bound: usize| x.saturating_sub(1)..(x + 2).min(bound);
        let mut graph = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let mut neighbours = Vec::new();
                    for c in near(z, size[2]) {
                        for b in near(y, size[1]) {
                            neighbours.extend(near(x, size[0]).map(|a| index([a, b, c])));
                        }
                    }
                    neighbours.retain(|&n| n != index([x, y, z]));
                    graph.push(neighbours);
                }
            }
        }
        graph
    }

    /// Starts and neighbours of a graph, compressed.
    pub(super) fn compressed(graph: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
        let mut starts = vec![0];
        for neighbours in graph {
            starts.push(starts[starts.len() - 1] + neighbours.len());
        }
        (starts, graph.concat())
    }

    fn ordered(graph: &[Vec<usize>]) -> Vec<usize> {
        let (starts, neighbours) = compressed(graph);
        let order = fill_reducing_order(&starts, &neighbours);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..graph.len()), "each vertex comes once");
        order
    }

    /// Entries of the factor of a matrix with this graph.
    fn entries(graph: &[Vec<usize>], order: &[usize]) -> usize {
        let mut place = vec![0; graph.len()];
        order.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = at);
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for (column, &vertex) in order.iter().enumerate() {
            let mut above: Vec<_> =
                graph[vertex].iter().map(|&n| place[n]).filter(|&row| row < column).collect();
            above.sort_unstable();
            rows.extend(above);
            rows.push(column);
            starts.push(rows.len());
        }
        let size = graph.len();
        let upper = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        let order = SymmetricOrdering::Identity;
        factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, order, Default::default())
            .unwrap()
            .len_val()
    }

    #[test]
    fn a_large_grid_fills_less_than_by_minimum_degree() {
        let graph = grid([18, 18, 18]);
        let (starts, neighbours) = compressed(&graph);
        let by_degree = minimum_degree(&Graph::unweighted(&starts, &neighbours));
        let by_degree: Vec<_> = by_degree.into_iter().map(|v| v as usize).collect();
        let [ours, amd] = [ordered(&graph), by_degree].map(|order| entries(&graph, &order));
        assert!(10 * ours < 9 * amd, "{ours} entries against {amd}");
    }

    #[test]
    fn an_order_does_not_depend_on_the_number_of_threads() {
        let graph = grid([40, 12, 12]);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| ordered(&graph))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn strange_graphs_have_orders_too() {
        const SIZE: usize = MOST_BY_DEGREE + 10;
        assert!(ordered(&[]).is_empty());
        let loose = vec![Vec::new(); SIZE];
        ordered(&loose);
        let mut star = vec![vec![0]; SIZE];
        star[0] = (1..SIZE).collect();
        let order = ordered(&star);
        assert!(entries(&star, &order) < 4 * SIZE, "the centre comes late");
        let blocks = grid([15, 15, 8]);
        let shifted = blocks.iter().map(|n| n.iter().map(|v| v + blocks.len()).collect());
        let two: Vec<Vec<usize>> = blocks.iter().cloned().chain(shifted).collect();
        ordered(&two);
        let complete: Vec<Vec<usize>> =
            (0..300).map(|v| (0..300).filter(|&n| n != v).collect()).collect();
        let (starts, neighbours) = compressed(&complete);
        let mut order = vec![0; 300];
        let names: Vec<u32> = (0..300).collect();
        dissect(&Graph::unweighted(&starts, &neighbours), &names, 0, &mut order);
        order.sort_unstable();
        assert_eq!(order, names);
    }
}
