//! Vectors and matrices of three components.

use sinew_num::{Mat3, add3, cross, dot, dot3, norm, sub3, sum};

#[test]
fn a_sum_of_a_million_terms_keeps_its_digits() {
    let terms = vec![0.1; 1_000_000];
    // 20 halvings and 8 terms, of half a rounding each; one after the other they lose a factor of 1e5.
    assert!((sum(&terms) / 1e5 - 1.0).abs() <= 14.0 * f64::EPSILON, "{}", sum(&terms));
    assert!((terms.iter().sum::<f64>() / 1e5 - 1.0).abs() > 1000.0 * f64::EPSILON);
    assert_eq!((sum(&[]), sum(&[1.0, 2.0, -4.0])), (0.0, -1.0));
}

#[test]
fn a_cross_product_is_normal_to_both_and_its_square_is_lagranges() {
    let (a, b) = ([1.0, 2.0, 3.0], [-4.0, 5.0, 7.0]);
    let normal = cross(&a, &b);
    assert_eq!(normal, [-1.0, -19.0, 13.0]);
    assert_eq!((dot3(&normal, &a), dot3(&normal, &b)), (0.0, 0.0));
    assert_eq!(norm(&[3.0, -4.0]), 5.0);
    assert_eq!(dot3(&normal, &normal), dot(&a, &a) * dot(&b, &b) - dot(&a, &b).powi(2));
    assert_eq!((add3(&a, &b), sub3(&a, &b)), ([-3.0, 7.0, 10.0], [5.0, -3.0, -4.0]));
}

const H: Mat3<f64> = Mat3([[0.1, -0.2, 0.05], [0.3, 0.2, -0.1], [0.02, 0.4, -0.15]]);

#[test]
fn expanded_invariants_agree_with_the_plain_ones() {
    let f = H.plus_identity();
    assert!((H.volume_change() - (f.determinant() - 1.0)).abs() < 1e-15);
    assert!((H.first_invariant_minus_three() - (f.squared_norm() - 3.0)).abs() < 1e-15);
    let (a, b) = ([1.0, 2.0, -0.5], [0.3, 0.1, 0.7]);
    let (fa, fb) = (f.apply(&a), f.apply(&b));
    let plain: f64 = (0..3).map(|i| fa[i] * fb[i] - a[i] * b[i]).sum();
    assert!((H.strain_between(&a, &b) - plain).abs() < 1e-15);
}

#[test]
fn cofactors_invert_the_matrix() {
    let m = Mat3::from_fn(|i, j| H[i][j] + if i == j { 2.0 } else { 0.0 });
    for i in 0..3 {
        for j in 0..3 {
            let entry: f64 = (0..3).map(|k| m[i][k] * m.cofactor(j, k)).sum();
            let expected = if i == j { m.determinant() } else { 0.0 };
            assert!((entry - expected).abs() < 1e-14);
        }
    }
}
