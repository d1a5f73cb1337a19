//! Principal components of shapes.

use nalgebra::{DMatrix, SymmetricEigen};

/// Principal components of shapes that share their nodes, by the singular values of their deviations from the mean.
pub(crate) struct ShapeModes {
    /// Root mean square deviation of the nodes along each mode \[length\].
    pub(crate) deviations: Vec<f64>,
    /// Mean nodal distance to the approximation by the first P modes, over all nodes and shapes, P = 0, 1, …
    /// \[length\]: δ_P of thesis Fig. A.2.
    pub(crate) left_over: Vec<f64>,
}

/// Modes that deviate less than this part of the first are rounding.
const SMALLEST: f64 = 1e-7;

impl ShapeModes {
    /// Modes of the nodal positions of two shapes or more \[length\].
    pub(crate) fn of(shapes: &[Vec<[f64; 3]>]) -> Self {
        let nodes = shapes[0].len();
        let (count, size) = (shapes.len(), 3 * nodes);
        let of = |shape: usize, i: usize| shapes[shape].as_flattened()[i];
        let mean: Vec<f64> =
            (0..size).map(|i| (0..count).map(|s| of(s, i)).sum::<f64>() / count as f64).collect();
        let spread = DMatrix::from_fn(size, count, |i, s| of(s, i) - mean[i]);
        // Few shapes of many nodes: the singular values from the products of the shapes.
        let SymmetricEigen { eigenvalues, eigenvectors } =
            SymmetricEigen::new(spread.transpose() * &spread);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
        let singular = |k: usize| eigenvalues[k].max(0.0).sqrt();
        let floor = SMALLEST * singular(order[0]);
        order.retain(|&k| singular(k) > floor);
        let mut rest = spread.clone();
        let distance = |rest: &DMatrix<f64>| {
            let nodal = rest.as_slice().chunks_exact(3);
            let distance = nodal.map(|d| d.iter().map(|x| x * x).sum::<f64>().sqrt());
            distance.sum::<f64>() / (count * nodes) as f64
        };
        let mut left_over = vec![distance(&rest)];
        for &k in &order {
            let mode = &spread * eigenvectors.column(k) / singular(k);
            rest -= &mode * (mode.transpose() * &rest);
            left_over.push(distance(&rest));
        }
        let deviation = |&k: &usize| singular(k) / ((count * nodes) as f64).sqrt();
        let deviations = order.iter().map(deviation).collect();
        Self { deviations, left_over }
    }
}

#[test]
fn two_directions_are_two_modes() {
    // Two nodes: the second moves along x by 2 in either direction, and along y by 1.
    let shape = |x: f64, y: f64| vec![[0.0; 3], [5.0 + x, y, 0.0]];
    let shapes = [shape(2.0, 1.0), shape(2.0, -1.0), shape(-2.0, 1.0), shape(-2.0, -1.0)];
    let modes = ShapeModes::of(&shapes);
    assert_eq!(modes.deviations.len(), 2);
    // Root mean square over nodes and shapes: √(2² / 2) and √(1² / 2).
    assert!((modes.deviations[0] - 2f64.sqrt()).abs() < 1e-12);
    assert!((modes.left_over[0] - 0.5 * 5f64.sqrt()).abs() < 1e-12);
    assert!((modes.left_over[1] - 0.5).abs() < 1e-12 && modes.left_over[2] < 1e-12);
}
