//! Groups of neighbouring nodes, and coarse functions on them.

use super::blocks::{Block, BlockMatrix};
use crate::vector::norm;

/// Rigid motions of a body.
pub(super) const MODES: usize = 6;

/// A coarse function that the others on its group describe up to this part is left out.
const DEPENDENT: f64 = 1e-8;

/// Groups each node with its strong neighbours: the group of each node, and the number of groups
/// (P. Vaněk, J. Mandel, M. Brezina, Computing 56, 1996, Algorithm 5.1).
///
/// Nodes are strongly coupled when the norm of their block is above `strong` times the geometric mean of their diagonal
/// blocks' norms.
pub(super) fn aggregates<const B: usize>(
    matrix: &BlockMatrix<f64, B, B>,
    strong: f64,
) -> (Vec<u32>, usize) {
    const NONE: u32 = u32::MAX;
    let size = matrix.height();
    let size_of = |block: &Block<f64, B, B>| norm(block.as_flattened());
    let diagonal: Vec<f64> = (0..size)
        .map(|row| matrix.row(row).find(|&(c, _)| c == row).map_or(0.0, |(_, b)| size_of(b)))
        .collect();
    let strongly_coupled = |row: usize| {
        let diagonal = &diagonal;
        matrix.row(row).filter_map(move |(column, block)| {
            let coupling = size_of(block);
            let scale = strong * diagonal[row].sqrt() * diagonal[column].sqrt();
            (column != row && coupling > scale).then_some((column, coupling))
        })
    };
    let mut group = vec![NONE; size];
    let mut count = 0;
    // Whole neighbourhoods first.
    for node in 0..size {
        if group[node] == NONE && strongly_coupled(node).all(|(n, _)| group[n] == NONE) {
            group[node] = count;
            strongly_coupled(node).for_each(|(n, _)| group[n] = count);
            count += 1;
        }
    }
    // What is left joins the group that it is coupled to most.
    let whole = group.clone();
    for node in (0..size).filter(|&node| whole[node] == NONE) {
        let beside = strongly_coupled(node).filter(|&(n, _)| whole[n] != NONE);
        if let Some((nearest, _)) = beside.max_by(|a, b| a.1.total_cmp(&b.1)) {
            group[node] = whole[nearest];
        }
    }
    for node in 0..size {
        if group[node] == NONE {
            group[node] = count;
            for (neighbour, _) in strongly_coupled(node) {
                if group[neighbour] == NONE {
                    group[neighbour] = count;
                }
            }
            count += 1;
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
/// triangle that gives back what they were. Dependent columns become zero.
fn orthonormalise<const B: usize>(
    nodes: &[usize],
    blocks: &mut [Block<f64, B, MODES>],
) -> Block<f64, MODES, MODES> {
    let mut triangle = [[0.0; MODES]; MODES];
    for column in 0..MODES {
        let product = |blocks: &[Block<f64, B, MODES>], a: usize, b: usize| -> f64 {
            nodes.iter().flat_map(|&n| &blocks[n]).map(|row| row[a] * row[b]).sum()
        };
        let before = product(blocks, column, column).sqrt();
        for _ in 0..2 {
            for other in 0..column {
                let along = product(blocks, other, column);
                triangle[other][column] += along;
                for &node in nodes {
                    for row in &mut blocks[node] {
                        row[column] -= along * row[other];
                    }
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

#[cfg(test)]
mod tests {
    use super::super::blocks::tests::elastic_grid;
    use super::*;

    #[test]
    fn groups_cover_all_nodes_and_are_about_as_large_as_neighbourhoods() {
        let (matrix, _) = elastic_grid([12, 12, 12]);
        let (group, count) = aggregates(&matrix, 0.0);
        let mut sizes = vec![0; count];
        group.iter().for_each(|&g| sizes[g as usize] += 1);
        assert!(sizes.iter().all(|&size| size > 0));
        let mean = group.len() as f64 / count as f64;
        assert!((12.0..60.0).contains(&mean), "{mean} nodes per group; a neighbourhood has 27");
    }

    #[test]
    fn tentative_functions_are_orthonormal_and_give_the_modes() {
        let (matrix, modes) = elastic_grid([5, 4, 3]);
        let (group, count) = aggregates(&matrix, 0.0);
        let (prolongation, coarse) = tentative(&group, count, &modes);
        for (node, mode) in modes.iter().enumerate() {
            let (function, triangle) = (&prolongation.blocks[node], &coarse[group[node] as usize]);
            for i in 0..3 {
                for j in 0..MODES {
                    let value: f64 = (0..MODES).map(|k| function[i][k] * triangle[k][j]).sum();
                    assert!((value - mode[i][j]).abs() < 1e-13);
                }
            }
        }
        let gram = prolongation.transposed().product(&prolongation);
        for row in 0..count {
            for (i, values) in gram.row(row).next().unwrap().1.iter().enumerate() {
                for (j, &value) in values.iter().enumerate() {
                    // A node alone has three motions: the other functions are zero.
                    let unit = (value - f64::from(u8::from(i == j))).abs() < 1e-13;
                    assert!(unit || value.abs() < 1e-13, "{i} {j}: {value}");
                }
            }
        }
    }

    #[test]
    fn a_single_node_has_only_translations() {
        let modes = [[
            [1.0, 0.0, 0.0, 0.0, 0.5, -2.0],
            [0.0, 1.0, 0.0, -0.5, 0.0, 1.0],
            [0.0, 0.0, 1.0, 2.0, -1.0, 0.0],
        ]];
        let (prolongation, _) = tentative(&[0], 1, &modes);
        for row in prolongation.blocks[0] {
            assert_eq!(row[3..], [0.0; 3]);
        }
    }
}
