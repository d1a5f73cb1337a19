//! Orders of elimination that keep factors sparse.

mod separator;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use separator::{BETWEEN, separate};

/// Graphs up to this many vertices are ordered by minimum degree. Measured on beams with three unknowns per vertex:
/// entries of the factor by degree and by dissection are 0.41 and 0.43 million with 784 vertices, 1.21 and
/// 1.19 with 1620, and 16.9 and 14.8 with 10 080.
const MOST_BY_DEGREE: usize = 1_500;
/// Parts up to this many vertices are not cut further; 200 gives 1 % more operations.
const LEAF: usize = 50;

/// Puts some vertices of a graph in an order of elimination for little fill in the Cholesky factor of a symmetric matrix with these vertices. The
/// graph lists the neighbours of each vertex without itself, on both sides.
///
/// Few vertices are ordered by approximate minimum degree (P. R. Amestoy, T. A. Davis, I. S. Duff, SIAM J. Matrix
/// Anal. Appl. 17, 1996), many by nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973) with separators
/// across the axes of `positions`. The same graph has the same order, on any number of threads.
pub(crate) fn fill_reducing_order(
    graph: &[Vec<usize>],
    mut vertices: Vec<usize>,
    positions: &[[f64; 3]],
) -> Vec<usize> {
    let small = vertices.len() <= MOST_BY_DEGREE;
    let leaf = if small { MOST_BY_DEGREE } else { LEAF };
    dissect(&induced(graph, &vertices), positions, leaf, &mut vertices);
    vertices
}

/// Orders the names of the vertices of a part of the graph: both sides of a separator, then itself.
fn dissect(graph: &[Vec<usize>], positions: &[[f64; 3]], leaf: usize, names: &mut [usize]) {
    let places: Vec<_> = names.iter().map(|&name| positions[name]).collect();
    let part = if graph.len() > leaf { separate(graph, &places) } else { None };
    let sides = [0, 1, BETWEEN].map(|side| {
        let inside = |vertex: &usize| part.as_ref().is_some_and(|part| part[*vertex] == side);
        (0..graph.len()).filter(inside).collect::<Vec<_>>()
    });
    let order = if part.is_some() { sides.concat() } else { minimum_degree(graph) };
    let ordered: Vec<_> = order.into_iter().map(|vertex| names[vertex]).collect();
    names.copy_from_slice(&ordered);
    if part.is_some() {
        let (left, rest) = names.split_at_mut(sides[0].len());
        let (right, _) = rest.split_at_mut(sides[1].len());
        let order_side = |side: usize, names: &mut [usize]| {
            dissect(&induced(graph, &sides[side]), positions, leaf, names);
        };
        rayon::join(|| order_side(0, left), || order_side(1, right));
    }
}

/// The graph of some vertices, with the edges among them.
fn induced(graph: &[Vec<usize>], vertices: &[usize]) -> Vec<Vec<usize>> {
    let mut place = vec![None; graph.len()];
    vertices.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = Some(at));
    let neighbours = |&vertex: &usize| graph[vertex].iter().filter_map(|&n| place[n]).collect();
    vertices.iter().map(neighbours).collect()
}

/// The vertices ordered by approximate minimum degree.
fn minimum_degree(graph: &[Vec<usize>]) -> Vec<usize> {
    let size = graph.len();
    let (mut starts, mut rows) = (Vec::with_capacity(size + 1), Vec::new());
    starts.push(0);
    for (vertex, neighbours) in graph.iter().enumerate() {
        rows.extend(neighbours.iter().filter(|&&n| n < vertex));
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
        Ok(_) => forward,
        // Only memory can run out, and any order is an order.
        Err(_) => (0..size).collect(),
    }
}
