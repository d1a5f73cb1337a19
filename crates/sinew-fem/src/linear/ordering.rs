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
