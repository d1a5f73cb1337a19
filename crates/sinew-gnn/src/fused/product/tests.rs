//! Products against plain sums, on every instruction set.

use super::{Factor, LANES, Panels, Start, Task, add_transposed_product, gram, kernel, multiply};

/// Sums that Miri can wait for.
const LONGEST_INTERPRETED: usize = 16;

/// Small whole numbers, so that sums are exact in any order.
fn matrix(rows: usize, columns: usize, seed: usize) -> Vec<f32> {
    (0..rows * columns).map(|i| ((i * 7 + i / 5 + seed) % 9) as f32 - 4.0).collect()
}

fn transposed(x: &[f32], columns: usize) -> Vec<f32> {
    let rows = x.len() / columns;
    (0..rows * columns).map(|i| x[i % rows * columns + i / rows]).collect()
}

fn plain(a: &[f32], b: &[f32], depth: usize, columns: usize) -> Vec<f32> {
    let row = |i: usize| &a[i * depth..][..depth];
    let entry = |i: usize, j: usize| (0..depth).map(|p| row(i)[p] * b[p * columns + j]).sum();
    (0..a.len() / depth)
        .flat_map(|i| (0..columns).map(move |j| (i, j)))
        .map(|(i, j)| entry(i, j))
        .collect()
}

#[test]
fn products_of_all_shapes() {
    for (rows, depth, columns) in
        [(1, 1, 1), (7, 3, 40), (13, 128, 128), (6, 40, 64), (11, 5, 79), (25, 17, 97), (4, 2, 33)]
    {
        if cfg!(miri) && depth > LONGEST_INTERPRETED {
            continue;
        }
        let (a, b) = (matrix(rows, depth, 1), matrix(depth, columns, 2));
        let expected = plain(&a, &b, depth, columns);
        let mut found = vec![f32::NAN; rows * columns];
        multiply(&a, &Panels::new(&b, columns), Start::Zero, &mut found);
        assert_eq!(found, expected, "{rows}x{depth}x{columns}");
        let packed = Panels::transposed(&transposed(&b, columns), depth);
        multiply(&a, &packed, Start::Kept, &mut found);
        let twice: Vec<f32> = expected.iter().map(|x| 2.0 * x).collect();
        assert_eq!(found, twice, "{rows}x{depth}x{columns}, transposed");
        add_transposed_product(&transposed(&a, depth), rows, &b, &mut found);
        let thrice: Vec<f32> = expected.iter().map(|x| 3.0 * x).collect();
        assert_eq!(found, thrice, "{rows}x{depth}x{columns}, added");
    }
}

#[test]
fn every_instruction_set_multiplies() {
    let (rows, depth, columns) = (13, 7, 11);
    let (a, b) = (matrix(rows, depth, 1), matrix(depth, columns, 2));
    let mut panel = vec![0.0; depth * LANES];
    for (to, from) in panel.chunks_exact_mut(LANES).zip(b.chunks_exact(columns)) {
        to[..columns].copy_from_slice(from);
    }
    let task = Task {
        count: rows,
        depth,
        factor: Factor { values: &a, row_stride: depth, step: 1 },
        panel: &panel,
        stride: LANES,
        columns,
        start: 0,
        kept: true,
    };
    let twice: Vec<f32> = plain(&a, &b, depth, columns).iter().map(|x| 2.0 * x).collect();
    let run = |block: &dyn Fn(&mut [f32])| {
        let mut found = vec![0.0; rows * columns];
        block(&mut found);
        block(&mut found);
        assert_eq!(found, twice);
    };
    // SAFETY: the task fits its slices, and the processor has the instructions.
    run(&|to| unsafe { kernel::portable::run(&task, LANES, to) });
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: as above.
        run(&|to| unsafe { kernel::avx2::run(&task, LANES, to) });
    }
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") {
        // SAFETY: as above.
        run(&|to| unsafe { kernel::avx512::run(&task, LANES, to) });
    }
}

#[test]
fn gram_matrices_are_symmetric() {
    for (rows, columns) in [(3, 1), (128, 40), (50, 128), (9, 79)] {
        if cfg!(miri) && rows > LONGEST_INTERPRETED {
            continue;
        }
        let x = matrix(rows, columns, 3);
        let mut found = vec![f32::NAN; columns * columns];
        gram(&x, columns, &mut found);
        assert_eq!(found, plain(&transposed(&x, columns), &x, rows, columns));
    }
}

#[test]
fn nothing_times_nothing_is_nothing() {
    multiply(&[], &Panels::new(&[1.0, 2.0], 2), Start::Zero, &mut []);
    add_transposed_product(&[], 3, &[], &mut [0.0; 6]);
}
