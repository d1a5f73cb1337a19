//! A vector register of single-precision numbers, by instruction set.

/// Numbers that are computed on together.
pub(crate) trait Register: Copy {
    /// How many.
    const LANES: usize;

    /// Zeros.
    ///
    /// # Safety
    /// The processor has this type's instructions, as for all other methods.
    unsafe fn zero() -> Self;

    /// The same number in every lane.
    ///
    /// # Safety
    /// `from` can be read.
    unsafe fn splat(from: *const f32) -> Self;

    /// # Safety
    /// All lanes from `from` on can be read.
    unsafe fn load(from: *const f32) -> Self;

    /// # Safety
    /// All lanes from `to` on can be written.
    unsafe fn store(self, to: *mut f32);

    /// The first `count` lanes, less than all, from `from` on; zeros in the others.
    ///
    /// # Safety
    /// So many numbers from `from` on can be read.
    #[inline(always)]
    unsafe fn load_some(from: *const f32, count: usize) -> Self {
        let mut lanes = [0.0; 16];
        // SAFETY: by the caller; no register is longer than the array.
        unsafe {
            std::ptr::copy_nonoverlapping(from, lanes.as_mut_ptr(), count);
            Self::load(lanes.as_ptr())
        }
    }

    /// Writes the first `count` lanes, less than all.
    ///
    /// # Safety
    /// So many numbers from `to` on can be written.
    #[inline(always)]
    unsafe fn store_some(self, to: *mut f32, count: usize) {
        let mut lanes = [0.0; 16];
        // SAFETY: as above.
        unsafe {
            self.store(lanes.as_mut_ptr());
            std::ptr::copy_nonoverlapping(lanes.as_ptr(), to, count);
        }
    }

    /// `self · b + c`.
    ///
    /// # Safety
    /// As for [`Register::zero`].
    unsafe fn multiply_add(self, b: Self, c: Self) -> Self;
}

#[cfg(target_arch = "x86_64")]
macro_rules! register {
    ($name:ident, $lanes:literal, $zero:ident, $splat:ident, $load:ident, $store:ident, $fused:ident, { $($more:item)* }) => {
        impl Register for std::arch::x86_64::$name {
            const LANES: usize = $lanes;

            // SAFETY: the caller vouches for the instructions and the addresses.
            #[inline(always)]
            unsafe fn zero() -> Self {
                unsafe { std::arch::x86_64::$zero() }
            }

            #[inline(always)]
            unsafe fn splat(from: *const f32) -> Self {
                unsafe { std::arch::x86_64::$splat(*from) }
            }

            #[inline(always)]
            unsafe fn load(from: *const f32) -> Self {
                unsafe { std::arch::x86_64::$load(from) }
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut f32) {
                unsafe { std::arch::x86_64::$store(to, self) }
            }

            #[inline(always)]
            unsafe fn multiply_add(self, b: Self, c: Self) -> Self {
                unsafe { std::arch::x86_64::$fused(self, b, c) }
            }

            $($more)*
        }
    };
}

#[cfg(target_arch = "x86_64")]
register!(
    __m512,
    16,
    _mm512_setzero_ps,
    _mm512_set1_ps,
    _mm512_loadu_ps,
    _mm512_storeu_ps,
    _mm512_fmadd_ps,
    {
        #[inline(always)]
        unsafe fn load_some(from: *const f32, count: usize) -> Self {
            unsafe { std::arch::x86_64::_mm512_maskz_loadu_ps((1 << count) - 1, from) }
        }

        #[inline(always)]
        unsafe fn store_some(self, to: *mut f32, count: usize) {
            unsafe { std::arch::x86_64::_mm512_mask_storeu_ps(to, (1 << count) - 1, self) }
        }
    }
);
#[cfg(target_arch = "x86_64")]
register!(
    __m256,
    8,
    _mm256_setzero_ps,
    _mm256_set1_ps,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_fmadd_ps,
    {}
);

/// Four numbers, which the compiler puts into a register where the target has one.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub(crate) struct Portable([f32; 4]);

impl Register for Portable {
    const LANES: usize = 4;

    #[inline(always)]
    unsafe fn zero() -> Self {
        Self([0.0; 4])
    }

    #[inline(always)]
    unsafe fn splat(from: *const f32) -> Self {
        // SAFETY: the caller vouches for the address.
        Self([unsafe { *from }; 4])
    }

    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        // SAFETY: the caller vouches for the addresses.
        Self(unsafe { from.cast::<[f32; 4]>().read_unaligned() })
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        // SAFETY: the caller vouches for the addresses.
        unsafe { to.cast::<[f32; 4]>().write_unaligned(self.0) }
    }

    #[inline(always)]
    unsafe fn multiply_add(self, b: Self, c: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * b.0[i] + c.0[i]))
    }
}
