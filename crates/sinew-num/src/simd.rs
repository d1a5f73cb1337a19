//! Vector instructions chosen at run time.

use std::sync::OnceLock;

/// Sets of vector instructions that loops are compiled for, the widest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// Instructions of every processor of the target.
    Baseline,
    /// AVX2 and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// The widest set that this processor has and the environment variable `SINEW_INSTRUCTIONS` (`avx2`, `baseline`) allows. Asked thousands
/// of times on a few numbers each, so the answer is kept.
#[inline(always)]
pub fn instructions() -> Instructions {
    static ALLOWED: OnceLock<Instructions> = OnceLock::new();
    *ALLOWED.get_or_init(|| allowed(widest()))
}

/// Name of the environment variable that keeps wider sets from being used: `avx2` or `baseline`.
const LIMIT: &str = "SINEW_INSTRUCTIONS";

#[cold]
fn allowed(widest: Instructions) -> Instructions {
    let limit = std::env::var(LIMIT).unwrap_or_default();
    match limit.as_str() {
        "" => widest,
        "baseline" => Instructions::Baseline,
        #[cfg(target_arch = "x86_64")]
        "avx2" => widest.min(Instructions::Avx2),
        other => {
            eprintln!("{LIMIT} = {other} is ignored: give avx2 or baseline");
            widest
        }
    }
}

/// The widest set that the processor has.
fn widest() -> Instructions {
    #[cfg(target_arch = "x86_64")]
    {
        let wide = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        match is_x86_feature_detected!("fma") && is_x86_feature_detected!("avx2") {
            true if wide => Instructions::Avx512,
            true => Instructions::Avx2,
            false => Instructions::Baseline,
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    Instructions::Baseline
}

/// Defines functions whose loops are compiled for each of [`Instructions`], of which the widest that
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
    ($(#[$meta:meta])* $vis:vis fn $name:ident $(<$fused:ident>)? ($($arg:ident: $type:ty),* $(,)?) $body:block $($further:tt)+) => {
        $crate::vectorised! { $(#[$meta])* $vis fn $name $(<$fused>)? ($($arg: $type),*) $body }
        $crate::vectorised! { $($further)+ }
    };
}
