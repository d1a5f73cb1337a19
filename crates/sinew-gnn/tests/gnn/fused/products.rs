//! Products of matrices inside the Newton–Schulz iteration against plain sums. Miri interprets these tests, on several
//! sets of instructions (docs/architecture.md, *Where things go*).

use sinew_gnn::fused::orthogonalise;

/// Longest sums that Miri can wait for.
const LONGEST_INTERPRETED: usize = 20;

/// Numbers in (−0.5, 0.5) without a pattern that another row or column repeats.
fn matrix(rows: usize, columns: usize) -> Vec<f32> {
    let number = |i: usize| ((i * i + 1) as f64 * 0.618_033_988_75).fract() - 0.5;
    (0..rows * columns).map(|i| number(i) as f32).collect()
}

fn transposed(x: &[f64], columns: usize) -> Vec<f64> {
    let rows = x.len() / columns;
    (0..rows * columns).map(|i| x[i % rows * columns + i / rows]).collect()
}

fn product(a: &[f64], b: &[f64], depth: usize, columns: usize) -> Vec<f64> {
    let row = |i: usize| &a[i * depth..][..depth];
    let entry = |i: usize, j: usize| (0..depth).map(|p| row(i)[p] * b[p * columns + j]).sum();
    (0..a.len() / depth)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .map(|(i, j)| entry(i, j))
        .collect()
}

/// Five steps `X ← X (a I + b A + c A²)` with `A = Xᵀ X`, from X of Frobenius norm one.
pub(crate) fn by_plain_sums(mut x: Vec<f64>, columns: usize) -> Vec<f64> {
    let norm = x.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-7);
    x.iter_mut().for_each(|x| *x /= norm);
    for _ in 0..5 {
        let gram = product(&transposed(&x, columns), &x, x.len() / columns, columns);
        let square = product(&gram, &gram, columns, columns);
        let entry = |(i, (g, s)): (usize, (&f64, &f64))| {
            let diagonal = i / columns == i % columns;
            -4.775 * g + 2.0315 * s + if diagonal { 3.4445 } else { 0.0 }
        };
        let polynomial: Vec<f64> = gram.iter().zip(&square).enumerate().map(entry).collect();
        x = product(&x, &polynomial, columns, columns);
    }
    x
}

#[test]
fn matrices_of_all_shapes() {
    for (rows, columns) in [
        (3, 1),
        (1, 3),
        (13, 11),
        (18, 17),
        (5, 33),
        (20, 16),
        (97, 79),
        (128, 40),
        (50, 128),
        (9, 79),
        (70, 64),
    ] {
        if cfg!(miri) && rows.min(columns) > LONGEST_INTERPRETED {
            continue;
        }
        let x = matrix(rows, columns);
        let expected = by_plain_sums(x.iter().map(|x| f64::from(*x)).collect(), columns);
        let mut found = x;
        orthogonalise(&mut found, columns);
        for (found, expected) in found.iter().zip(expected) {
            // Rounding of single precision, amplified by the steps.
            let error = (f64::from(*found) - expected).abs();
            assert!(error < 2e-5, "{rows}x{columns}: {found} for {expected}");
        }
    }
}

/// Scratch memory is handed on from product to product with what it holds.
#[test]
fn scratch_memory_leaves_no_trace() {
    let x = matrix(18, 17);
    let of = |mut x: Vec<f32>| {
        orthogonalise(&mut x, 17);
        x
    };
    let expected = of(x.clone());
    assert!(of(vec![f32::NAN; x.len()]).iter().all(|x| x.is_nan()));
    assert_eq!(of(x), expected);
}

#[test]
fn nothing_times_nothing_is_nothing() {
    let mut nothing = vec![];
    orthogonalise(&mut nothing, 3);
    assert!(nothing.is_empty());
}
