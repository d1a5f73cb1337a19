//! Groups of neighbouring nodes, and coarse functions on them.

use super::blocks::{Block, BlockMatrix};

/// Rigid motions of a body.
pub(super) const MODES: usize = 6;

/// Least new part of a coarse function \[relative to itself\]; below it the others on its group describe it.
const DEPENDENT: f64 = 1e-8;

/// Groups each node with its strong neighbours: the group of each node, and the number of groups
/// (P. Vaněk, J. Mandel, M. Brezina, Computing 56, 1996, Algorithm 5.1).
///
/// Nodes are strongly coupled when the norm of their block is above `strong` times the geometric mean of their diagonal
/// blocks' norms.
pub(super) fn groups<const B: usize>(
    matrix: &BlockMatrix<f64, B, B>,
    strong: f64,
) -> (Vec<u32>, usize) {
    const NONE: u32 = u32::MAX;
    let size = matrix.height();
    let square = |block: &Block<f64, B, B>| block.as_flattened().iter().map(|x| x * x).sum::<f64>();
    let diagonal = |row| matrix.row(row).find(|&(c, _)| c == row).map_or(0.0, |(_, b)| square(b));
    let diagonal: Vec<f64> = (0..size).map(diagonal).collect();
    let neighbours = |row: usize| {
        let diagonal = &diagonal;
        matrix.row(row).filter_map(move |(column, block)| {
            let coupling = square(block);
            let least = strong * strong * (diagonal[row] * diagonal[column]).sqrt();
            (column != row && coupling > least).then_some((column, coupling))
        })
    };
    let (mut group, mut count) = (vec![NONE; size], 0);
    // Whole neighbourhoods first.
    for node in 0..size {
        if group[node] == NONE && neighbours(node).all(|(n, _)| group[n] == NONE) {
            group[node] = count;
            neighbours(node).for_each(|(n, _)| group[n] = count);
            count += 1;
        }
    }
    // Other nodes join the group that they are coupled to most.
    let whole = group.clone();
    for node in (0..size).filter(|&node| whole[node] == NONE) {
        let beside = neighbours(node).filter(|&(n, _)| whole[n] != NONE);
        match beside.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((nearest, _)) => group[node] = whole[nearest],
            None => {
                group[node] = count;
                count += 1;
            }
        }
    }
    (group, count as usize)
}

/// Functions on each group that span the modes there, orthonormal: the prolongation, and the modes in
/// terms of its functions.
pub(super) fn tentative<const B: usize>(
    group: &[u32],
    count: usize,
    modes: &[Block<f64, B, MODES>],
) -> (BlockMatrix<f64, B, MODES>, Vec<Block<f64, MODES, MODES>>) {
    let mut members = vec![Vec::new(); count];
    group.iter().enumerate().for_each(|(node, &g)| members[g as usize].push(node));
    let mut blocks = modes.to_vec();
    let coarse = members.iter().map(|nodes| orthonormalise(nodes, &mut blocks)).collect();
    let starts = (0..=group.len()).collect();
    (BlockMatrix { width: count, starts, columns: group.to_vec(), blocks }, coarse)
}

/// Makes the columns of some nodes' blocks orthonormal (Gram–Schmidt, twice for accuracy); returns the
/// triangle that restores them. Dependent columns become zero.
fn orthonormalise<const B: usize>(
    nodes: &[usize],
    blocks: &mut [Block<f64, B, MODES>],
) -> Block<f64, MODES, MODES> {
    let product = |blocks: &[Block<f64, B, MODES>], a: usize, b: usize| -> f64 {
        nodes.iter().flat_map(|&n| &blocks[n]).map(|row| row[a] * row[b]).sum()
    };
    let mut triangle = [[0.0; MODES]; MODES];
    for column in 0..MODES {
        let before = product(blocks, column, column).sqrt();
        for _ in 0..2 {
            for other in 0..column {
                let along = product(blocks, other, column);
                triangle[other][column] += along;
                for &node in nodes {
                    blocks[node].iter_mut().for_each(|row| row[column] -= along * row[other]);
                }
            }
        }
        let length = product(blocks, column, column).sqrt();
        let scale = if length > DEPENDENT * before { 1.0 / length } else { 0.0 };
        triangle[column][column] = if scale > 0.0 { length } else { 0.0 };
        for &node in nodes {
            blocks[node].iter_mut().for_each(|row| row[column] *= scale);
        }
    }
    triangle
}
