//! Vector instructions chosen at run time.

use std::sync::atomic::{AtomicU8, Ordering};

/// Sets of vector instructions that loops are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// AVX-512 and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// AVX2 and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// What every processor of the target has.
    Baseline,
}

/// The widest set that this processor has and the environment variable `SINEW_INSTRUCTIONS` (`avx2`, `baseline`) allows. Asked thousands
/// of times on a few numbers each, so the answer is one number, kept.
#[inline(always)]
pub fn instructions() -> Instructions {
    match WIDTH.load(Ordering::Relaxed) {
        #[cfg(target_arch = "x86_64")]
        AVX512 => Instructions::Avx512,
        #[cfg(target_arch = "x86_64")]
        AVX2 => Instructions::Avx2,
        UNKNOWN => detect(),
        _ => Instructions::Baseline,
    }
}

const UNKNOWN: u8 = 0;
const BASELINE: u8 = 1;
#[cfg(target_arch = "x86_64")]
const AVX2: u8 = 2;
#[cfg(target_arch = "x86_64")]
const AVX512: u8 = 3;

static WIDTH: AtomicU8 = AtomicU8::new(UNKNOWN);

/// Name of the environment variable that keeps wider sets from being used: `avx2` or `baseline`.
const LIMIT: &str = "SINEW_INSTRUCTIONS";

#[cold]
fn detect() -> Instructions {
    let limit = std::env::var(LIMIT).unwrap_or_default();
    let widest = match limit.as_str() {
        "" => u8::MAX,
        "baseline" => BASELINE,
        #[cfg(target_arch = "x86_64")]
        "avx2" => AVX2,
        other => {
            eprintln!("{LIMIT} = {other} is ignored: give avx2 or baseline");
            u8::MAX
        }
    };
    WIDTH.store(widest.min(width()), Ordering::Relaxed);
    instructions()
}

/// The widest set that the processor has.
fn width() -> u8 {
    #[cfg(target_arch = "x86_64")]
    {
        let wide = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        match is_x86_feature_detected!("fma") && is_x86_feature_detected!("avx2") {
            true if wide => AVX512,
            true => AVX2,
            false => BASELINE,
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    BASELINE
}

/// Defines a function whose loops are compiled for each of [`Instructions`], of which the widest that
/// the processor has is called. A constant parameter, if it is named, says whether a fused
/// multiply-add costs one instruction.
///
/// ```
/// sinew_num::vectorised! {
///     fn add(sum: &mut [f64], terms: &[f64]) {
///         for (s, t) in sum.iter_mut().zip(terms) {
///             *s += t;
///         }
///     }
/// }
/// let mut sum = [1.0, 2.0];
/// add(&mut sum, &[0.5, 0.25]);
/// assert_eq!(sum, [1.5, 2.25]);
/// ```
#[macro_export]
macro_rules! vectorised {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $type:ty),* $(,)?) $body:block) => {
        $crate::vectorised! { $(#[$meta])* $vis fn $name<_FUSED>($($arg: $type),*) $body }
    };
    ($(#[$meta:meta])* $vis:vis fn $name:ident<$fused:ident>($($arg:ident: $type:ty),* $(,)?) $body:block) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments)]
        $vis fn $name($($arg: $type),*) {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn every<const $fused: bool>($($arg: $type),*) $body

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
            #[allow(clippy::too_many_arguments)]
            fn avx512($($arg: $type),*) {
                every::<true>($($arg),*)
            }

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            #[allow(clippy::too_many_arguments)]
            fn avx2($($arg: $type),*) {
                every::<true>($($arg),*)
            }

            match $crate::instructions() {
                // SAFETY: `instructions` returns this only where the processor reports the features.
                #[cfg(target_arch = "x86_64")]
                $crate::Instructions::Avx512 => unsafe { avx512($($arg),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                $crate::Instructions::Avx2 => unsafe { avx2($($arg),*) },
                $crate::Instructions::Baseline => every::<false>($($arg),*),
            }
        }
    };
}
