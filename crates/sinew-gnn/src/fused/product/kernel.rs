//! The blocks of a product in vector registers: one kernel, compiled for each set of instructions.

use super::Task;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;
use std::ptr::copy_nonoverlapping;

/// Defines a module for a set of instructions, whose `run` multiplies a [`Task`]. `load` takes a whole register, `load_some`
/// and `store_some` its first lanes. The table says for each width of a panel, in registers, how many rows make a block,
/// whose sums stay in registers.
macro_rules! kernel {
    (
        $(#[$features:meta])? $name:ident: $register:ty, $lanes:literal lanes,
        splat = $splat:expr, multiply_add = $multiply_add:expr, load = $load:expr,
        load_some = $load_some:expr, store_some = $store_some:expr,
        rows = { $($width:literal => $rows:literal),+ }
    ) => {
        pub(super) mod $name {
            use super::*;

            /// The product with a panel of `width` columns.
            ///
            /// # Safety
            /// The task fits its slices, as `Task::run` asserts, and the processor has the instructions.
            $(#[$features])?
            pub(in crate::fused::product) unsafe fn run(task: &Task<'_>, width: usize, output: &mut [f32]) {
                match width / $lanes {
                    $($width => blocks::<$rows, $width>(task, output),)+
                    other => unreachable!("no panel is {other} registers wide"),
                }
            }

            /// All rows, `M` at a time and the last ones fewer; `V` registers are the panel's width.
            $(#[$features])?
            #[inline]
            fn blocks<const M: usize, const V: usize>(task: &Task<'_>, output: &mut [f32]) {
                let mut row = 0;
                while row + M <= task.count {
                    block::<M, V>(task, row, output);
                    row += M;
                }
                while row + 2 <= task.count {
                    block::<2, V>(task, row, output);
                    row += 2;
                }
                if row < task.count {
                    block::<1, V>(task, row, output);
                }
            }

            /// `M` rows from `row` on, `V` registers wide.
            $(#[$features])?
            #[inline]
            fn block<const M: usize, const V: usize>(
                task: &Task<'_>,
                row: usize,
                output: &mut [f32],
            ) {
                let Task { factor, row_stride, step, .. } = *task;
                let mut sums = [[$splat(0.0); V]; M];
                let mut rows = [factor.as_ptr(); M];
                (0..M).for_each(|i| rows[i] = rows[i].wrapping_add((row + i) * row_stride));
                for p in 0..task.depth {
                    // SAFETY: by the caller of `run`, rows and panel reach as far as `depth`.
                    unsafe {
                        let panel = task.panel.as_ptr().add(p * task.stride);
                        let mut registers = [$splat(0.0); V];
                        for v in 0..V {
                            registers[v] = $load(panel.add(v * $lanes));
                        }
                        for i in 0..M {
                            let factor = $splat(*rows[i].add(p * step));
                            for v in 0..V {
                                sums[i][v] = $multiply_add(factor, registers[v], sums[i][v]);
                            }
                        }
                    }
                }
                let valid = (V * $lanes).min(task.columns - task.start);
                let output = &mut output[row * task.columns + task.start..];
                assert!((M - 1) * task.columns + valid <= output.len());
                let mut places = [output.as_mut_ptr(); M];
                (0..M).for_each(|i| places[i] = places[i].wrapping_add(i * task.columns));
                let counts: [usize; V] =
                    std::array::from_fn(|v| valid.saturating_sub(v * $lanes).min($lanes));
                // SAFETY: so many numbers of a row of the output are left for each register.
                unsafe {
                    for i in 0..if task.kept { M } else { 0 } {
                        for v in 0..V {
                            let there = $load_some(places[i].wrapping_add(v * $lanes), counts[v]);
                            sums[i][v] = $multiply_add(there, $splat(1.0), sums[i][v]);
                        }
                    }
                    for i in 0..M {
                        for v in 0..V {
                            $store_some(places[i].wrapping_add(v * $lanes), counts[v], sums[i][v]);
                        }
                    }
                }
            }
        }
    };
}

// Blocks fill 24 of the 32 registers.
#[cfg(target_arch = "x86_64")]
kernel!(
    #[target_feature(enable = "avx512f")]
    avx512: __m512, 16 lanes,
    splat = _mm512_set1_ps, multiply_add = _mm512_fmadd_ps, load = _mm512_loadu_ps,
    load_some = |from, count: usize| _mm512_maskz_loadu_ps(((1_u32 << count) - 1) as u16, from),
    store_some = |to, count: usize, x| _mm512_mask_storeu_ps(to, ((1_u32 << count) - 1) as u16, x),
    rows = { 4 => 6, 3 => 8, 2 => 12, 1 => 8 }
);

// Blocks fill 12 of the 16 registers.
#[cfg(target_arch = "x86_64")]
kernel!(
    #[target_feature(enable = "avx2,fma")]
    avx2: __m256, 8 lanes,
    splat = _mm256_set1_ps, multiply_add = _mm256_fmadd_ps, load = _mm256_loadu_ps,
    load_some = |from, count| _mm256_maskload_ps(from, lanes_before(count)),
    store_some = |to, count, x| match count {
        8 => _mm256_storeu_ps(to, x),
        _ => _mm256_maskstore_ps(to, lanes_before(count), x),
    },
    rows = { 2 => 6, 1 => 12 }
);

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn lanes_before(count: usize) -> __m256i {
    _mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7))
}

// Four numbers, which the compiler puts into a register where the target has one.
kernel!(
    portable: [f32; 4], 4 lanes,
    splat = |x: f32| [x; 4],
    multiply_add = |a: [f32; 4], b: [f32; 4], c: [f32; 4]| -> [f32; 4] {
        std::array::from_fn(|i| a[i] * b[i] + c[i])
    },
    load = |from: *const f32| from.cast::<[f32; 4]>().read_unaligned(),
    load_some = |from: *const f32, count| {
        let mut lanes = [0.0; 4];
        copy_nonoverlapping(from, lanes.as_mut_ptr(), count);
        lanes
    },
    store_some = |to, count, x: [f32; 4]| copy_nonoverlapping(x.as_ptr(), to, count),
    rows = { 4 => 2, 2 => 4 }
);
