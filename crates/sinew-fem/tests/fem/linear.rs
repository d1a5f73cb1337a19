//! Kernels of linear algebra, compiled from their files: failures that the solver seldom meets.

#![allow(dead_code)]

#[path = "../../src/linear/aggregation/blocks.rs"]
mod blocks;
#[path = "../../src/elements/convex.rs"]
mod convex;
#[path = "../../src/linear/krylov.rs"]
mod krylov;
#[path = "../../src/linear/vector.rs"]
mod vector;

pub(crate) use vector::{add, compressed, difference, dot, norm, relative};

mod of_vectors {
    use super::vector::norm;

    #[test]
    fn a_norm_is_had_wherever_it_is_a_number() {
        for scale in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let long = norm(&[0.0, 3.0 * scale, -4.0 * scale, 12.0 * scale]);
            assert!((long / scale - 13.0).abs() < 1e-14, "{scale:e} {long:e}");
        }
        assert_eq!((norm(&[]), norm(&[0.0, -0.0])), (0.0, 0.0));
        assert!(!norm(&[1.0, f64::INFINITY]).is_finite());
        assert!(norm(&[1.0, f64::NAN]).is_nan() && norm(&[f64::NAN, 1.0]).is_nan());
        assert!(norm(&[0.0, f64::NAN, 1e200]).is_nan());
    }
}

mod of_gmres {
    use super::krylov::gmres;

    /// A convection–diffusion matrix, far from symmetric.
    fn apply(x: &[f64], y: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            let left = if i > 0 { x[i - 1] } else { 0.0 };
            let right = if i + 1 < n { x[i + 1] } else { 0.0 };
            y[i] = 2.0 * x[i] - 1.8 * left - 0.2 * right;
        }
    }

    #[test]
    fn an_unsymmetric_system_is_solved_to_the_tolerance() {
        let right: Vec<f64> = (0..60).map(|i| f64::from(i % 7) - 2.5).collect();
        let mut x = vec![0.0; 60];
        let outcome = gmres(apply, |r, z| z.copy_from_slice(r), &right, &mut x, 1e-12, 300);
        let mut product = vec![0.0; 60];
        apply(&x, &mut product);
        let error = product.iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-9 && outcome.relative_residual <= 1e-12, "{error:e} {outcome:?}");
    }

    #[test]
    fn a_singular_system_ends_with_its_residual() {
        let project = |x: &[f64], y: &mut [f64]| {
            y.copy_from_slice(x);
            y[0] = 0.0;
        };
        let mut x = vec![0.0; 3];
        let right = [1.0, 2.0, 3.0];
        let outcome = gmres(project, |r, z| z.copy_from_slice(r), &right, &mut x, 1e-12, 50);
        assert!((outcome.relative_residual - 1.0 / 14f64.sqrt()).abs() < 1e-9, "{outcome:?}");
    }

    #[test]
    fn no_load_gives_no_answer() {
        let mut x = vec![1.0; 4];
        let outcome = gmres(apply, |r, z| z.copy_from_slice(r), &[0.0; 4], &mut x, 1e-12, 50);
        assert_eq!((outcome.iterations, x), (0, vec![0.0; 4]));
    }
}

mod of_conjugate_gradients {
    use super::krylov::{End, conjugate_gradients};

    fn solve(diagonal: &[f64], right: &[f64], most: usize) -> (Vec<f64>, usize, End) {
        let apply = |x: &[f64], y: &mut [f64]| {
            y.iter_mut().zip(x).zip(diagonal).for_each(|((y, x), d)| *y = d * x);
        };
        conjugate_gradients(apply, |x, y| y.copy_from_slice(x), right, 1e-12, most)
    }

    #[test]
    fn as_many_iterations_as_eigenvalues() {
        let (solution, iterations, end) = solve(&[1.0, 2.0, 4.0, 2.0], &[1.0, 1.0, -1.0, 3.0], 9);
        assert_eq!((end, iterations), (End::Converged, 3));
        let expected = [1.0, 0.5, -0.25, 1.5];
        assert!(solution.iter().zip(expected).all(|(x, e)| (x - e).abs() < 1e-14));
        assert_eq!(solve(&[1.0; 4], &[0.0; 4], 9), (vec![0.0; 4], 0, End::Converged));
    }

    #[test]
    fn each_failure_has_its_end() {
        let right = [1.0, 1.0, -1.0, 3.0];
        assert_eq!(solve(&[1.0, 2.0, -0.1, 2.0], &right, 9).2, End::NegativeCurvature);
        assert_eq!(solve(&[0.0; 4], &right, 9).2, End::NegativeCurvature);
        assert_eq!(solve(&[1.0, 2.0, 4.0, 2.0], &right, 2).2, End::Failed);
        assert_eq!(solve(&[1.0, f64::NAN, 4.0, 2.0], &right, 9).2, End::Failed);
    }
}

mod of_blocks {
    use super::blocks::{Block, BlockMatrix, definite_inverse, times};

    #[test]
    fn products_and_transposes_are_those_of_the_dense_matrices() {
        let block = |k: usize| -> Block<f64, 2, 3> {
            let entry = |i, j| ((7 * k + 3 * i + 5 * j) % 11) as f64 - 5.0;
            std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
        };
        let (starts, columns) = (vec![0, 2, 2, 3, 6], vec![0, 3, 1, 0, 2, 3]);
        let a = BlockMatrix { width: 4, starts, columns, blocks: (0..6).map(block).collect() };
        let mut dense = [[0.0; 12]; 8];
        for row in 0..4 {
            for (column, block) in a.row(row) {
                (0..2).for_each(|i| {
                    dense[2 * row + i][3 * column..3 * column + 3].copy_from_slice(&block[i]);
                });
            }
        }
        let mut square = [[0.0; 8]; 8];
        let product = a.product(&a.transposed());
        for row in 0..4 {
            for (column, block) in product.row(row) {
                (0..2).for_each(|i| {
                    square[2 * row + i][2 * column..2 * column + 2].copy_from_slice(&block[i]);
                });
            }
        }
        for i in 0..8 {
            for j in 0..8 {
                // Small integers have no rounding errors.
                assert_eq!(square[i][j], sinew_num::dot(&dense[i], &dense[j]));
            }
        }
        let x: Vec<[f64; 3]> = (0..4).map(|i| [i as f64, 1.0, -2.0]).collect();
        let mut y = vec![[0.0; 2]; 4];
        a.multiply(&x, &mut y);
        for (y, row) in y.as_flattened().iter().zip(&dense) {
            assert_eq!(*y, sinew_num::dot(row, x.as_flattened()));
        }
        a.subtract_product(&x, &mut y);
        assert!(y.as_flattened().iter().all(|&y| y == 0.0));
    }

    #[test]
    fn inverses_are_exact_or_refused() {
        let block = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]];
        let inverse = definite_inverse(&block).unwrap();
        for j in 0..3 {
            let column = times(&block, &std::array::from_fn(|i| inverse[i][j]));
            for (i, value) in column.into_iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let nan = [[f64::NAN, 0.0], [0.0, 1.0]];
        for bad in [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], nan] {
            assert!(definite_inverse(&bad).is_none());
        }
    }
}

mod of_tangents {
    use super::convex::make_convex;
    use nalgebra::SMatrix;

    #[test]
    fn negative_eigenvalues_become_zero_and_others_stay() {
        let entry = |i: usize, j: usize| ((3 * i * j + 5 * (i + j)) % 7) as f64 - 2.0;
        let before = SMatrix::<f64, 9, 9>::from_fn(entry);
        let mut tangent: [[f64; 9]; 9] =
            std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        assert!(make_convex(&mut tangent));
        let after = SMatrix::<f64, 9, 9>::from_fn(|i, j| tangent[i][j]);
        let sorted = |matrix: SMatrix<f64, 9, 9>| {
            let mut values: [f64; 9] = matrix.symmetric_eigenvalues().into();
            values.sort_by(f64::total_cmp);
            values
        };
        for (before, after) in sorted(before).into_iter().zip(sorted(after)) {
            assert!((before.max(0.0) - after).abs() < 1e-12, "{before} became {after}");
        }
        assert!(!make_convex(&mut tangent));
    }
}
